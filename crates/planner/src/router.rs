//! Answers requests on a chart, and keeps the sea room that it made for them.

use crate::Cancel;
use crate::needs::Needs;
use crate::plane::Plane;
use crate::room::{PlanError, SeaRoom};
use crate::route::{Question, Refusal, Request, Route};
use charts::depth_index::{Demand, DepthIndex, Leg};
use std::sync::{Arc, Mutex, PoisonError};
use units::LatLon;

/// A chart set with no more vertices, and no wider, is prepared as a whole.
const WHOLE_VERTICES: usize = 600_000;
const WHOLE_DEG: f64 = 8.0;
/// Rooms that are kept; the one not asked for longest goes first.
const MOST_ROOMS: usize = 8;
/// Trials for smaller demands that give a route.
const TRIALS: u32 = 5;
/// Where a way keeps off by some clearance, one is surely found that is asked to keep off by so much less (m) and this
/// share of it: lines are thinned, and circles are polygons around them.
const UNSURE_M: f64 = 2.5;
const SURE: f64 = 0.99;
/// Half sides of regions (m), the smallest that fits first.
const HALVES_M: [f64; 6] = [20_000.0, 40_000.0, 80_000.0, 160_000.0, 320_000.0, 640_000.0];

/// Farthest that start and goal may lie apart (m): the largest region holds both, with room around them.
const FARTHEST_M: f64 = 800_000.0;

/// Plans on one chart.
///
/// May be asked from several threads; two that need the same room at once may both prepare it.
#[derive(Debug)]
pub struct Router {
    index: Arc<DepthIndex>,
    whole: bool,
    rooms: Mutex<Vec<Kept>>,
}

#[derive(Debug, Clone)]
struct Kept {
    key: Key,
    room: Arc<SeaRoom>,
}

/// Needs, and of which region: `None` of the whole chart.
#[derive(Debug, Clone, PartialEq)]
struct Key {
    needs: Needs,
    region: Option<Square>,
}

/// A square region around a middle on a coarse grid, so that requests near each other share it.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Square {
    middle: LatLon,
    half_m: f64,
}

impl Router {
    /// Over a chart.
    pub fn new(index: Arc<DepthIndex>) -> Self {
        let narrow = index.extent().is_none_or(|extent| {
            extent.east_deg - extent.west_deg <= 3.0 * WHOLE_DEG
                && extent.north_deg - extent.south_deg <= WHOLE_DEG
        });
        let whole = narrow && index.vertex_count() <= WHOLE_VERTICES;
        Self { index, whole, rooms: Mutex::default() }
    }

    /// Over a chart that is prepared region by region, whatever its size.
    pub fn by_regions(index: Arc<DepthIndex>) -> Self {
        Self { whole: false, ..Self::new(index) }
    }

    /// The chart.
    pub fn index(&self) -> &Arc<DepthIndex> {
        &self.index
    }

    /// The shortest way. The first request with new needs prepares the water, which can take a second.
    ///
    /// # Errors
    /// The reason that no route exists.
    pub fn route(&self, request: &Request, needs: &Needs, cancel: &Cancel<'_>) -> Result<Route, Refusal> {
        needs.validate()?;
        if self.whole {
            return self.ask(None, request, needs, cancel).map(|(route, _)| route);
        }
        let straight_m = Leg { from: request.from, to: request.to }.length_m();
        if straight_m > FARTHEST_M {
            return Err(Refusal::TooFar { straight_km: straight_m / 1e3, most_km: FARTHEST_M / 1e3 });
        }
        let mut answer = Err(PlanError::Geometry("no region holds both ends".to_owned()).into());
        for square in squares(request, straight_m) {
            answer = match self.ask(Some(square), request, needs, cancel) {
                // No way that leaves the region can be shorter.
                Ok((route, least_out_m)) if route.length_m <= least_out_m => return Ok(route),
                Ok((route, _)) => Ok(route),
                // There may be a way around, by water outside.
                Err(refusal @ Refusal::NoWay { .. }) => answer.or(Err(refusal)),
                Err(other) => return Err(other),
            };
        }
        answer
    }

    /// The shortest way by way of all these places, in order; the request says what holds for each stretch.
    ///
    /// # Errors
    /// The number of the first stretch, from 0, that has no way, and why.
    pub fn route_by(
        &self,
        places: &[LatLon],
        request: &Request,
        needs: &Needs,
        cancel: &Cancel<'_>,
    ) -> Result<Route, (usize, Refusal)> {
        let (from, onward) = match places {
            [from, onward @ ..] if !onward.is_empty() => (*from, onward.to_vec()),
            _ => (request.from, vec![request.to]),
        };
        let mut whole: Option<Route> = None;
        for (stretch, to) in onward.into_iter().enumerate() {
            let from = whole.as_ref().map_or(from, Route::goal);
            let next = self.route(&Request { from, to, ..*request }, needs, cancel);
            let next = next.map_err(|refusal| (stretch, refusal))?;
            whole = Some(match whole {
                Some(before) => before.then(next),
                None => next,
            });
        }
        whole.ok_or((0, PlanError::Geometry("no place was given".to_owned()).into()))
    }

    /// Which smaller demands would give a route: the greatest least depth with this clearance, and the greatest clearance
    /// with this depth (m), each found by a few trials.
    ///
    /// # Errors
    /// When the request was cancelled.
    pub fn passable(
        &self,
        request: &Request,
        needs: &Needs,
        cancel: &Cancel<'_>,
    ) -> Result<Passable, PlanError> {
        let depth_m = greatest(needs.demand.needed_m(), |depth_m| {
            let demand = Demand { draught_m: depth_m, squat_m: 0.0, reserve_m: 0.0, ..needs.demand };
            let route = self.try_room(request, &Needs { demand, ..*needs }, cancel)?;
            Ok(route.map(|route| route.least_depth_m().unwrap_or(depth_m)))
        })?;
        let clearance_m = greatest(needs.clearance_m, |clearance_m| {
            let route = self.try_room(request, &Needs { clearance_m, ..*needs }, cancel)?;
            Ok(route.map(|route| {
                let kept_m = route.least_clearance_m().unwrap_or(clearance_m) - needs.demand.position_m;
                clearance_m.max(SURE * (kept_m - UNSURE_M))
            }))
        })?;
        Ok(Passable { depth_m, clearance_m })
    }

    /// The way in water that is prepared for this alone.
    fn try_room(
        &self,
        request: &Request,
        needs: &Needs,
        cancel: &Cancel<'_>,
    ) -> Result<Option<Route>, PlanError> {
        let straight_m = Leg { from: request.from, to: request.to }.length_m();
        let square = if self.whole { None } else { squares(request, straight_m).next() };
        let room = Self::prepare(&self.index, &Key { needs: *needs, region: square }, cancel)?;
        match (Question { room: &room, index: &self.index, request, cancel }).answer() {
            Ok(route) => Ok(Some(route)),
            Err(Refusal::Plan(error)) => Err(error),
            Err(_) => Ok(None),
        }
    }

    fn ask(
        &self,
        region: Option<Square>,
        request: &Request,
        needs: &Needs,
        cancel: &Cancel<'_>,
    ) -> Result<(Route, f64), Refusal> {
        let room = self.room(Key { needs: *needs, region }, cancel)?;
        let route = Question { room: &room, index: &self.index, request, cancel }.answer()?;
        let ends = [request.from, request.to].map(|place| room.plane().point(place));
        Ok((route, room.least_way_out_m(ends[0], ends[1])))
    }

    /// The water for these needs, prepared now if it is not kept.
    fn room(&self, key: Key, cancel: &Cancel<'_>) -> Result<Arc<SeaRoom>, PlanError> {
        let lock = || self.rooms.lock().unwrap_or_else(PoisonError::into_inner);
        {
            let mut rooms = lock();
            if let Some(at) = rooms.iter().position(|kept| kept.key == key) {
                let kept = rooms.remove(at);
                rooms.push(kept.clone());
                return Ok(kept.room);
            }
        }
        let room = Arc::new(Self::prepare(&self.index, &key, cancel)?);
        let mut rooms = lock();
        if rooms.len() >= MOST_ROOMS {
            rooms.remove(0);
        }
        rooms.push(Kept { key, room: Arc::clone(&room) });
        Ok(room)
    }

    fn prepare(index: &DepthIndex, key: &Key, cancel: &Cancel<'_>) -> Result<SeaRoom, PlanError> {
        match key.region {
            None => SeaRoom::of_chart(index, &key.needs, cancel),
            Some(Square { middle, half_m }) => {
                SeaRoom::around(index, &key.needs, middle, (half_m, half_m), cancel)
            }
        }
    }
}

/// Smaller demands that give a route.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Passable {
    /// The greatest least depth (m); `None` if 0 m is still too much.
    pub depth_m: Option<f64>,
    /// The greatest clearance (m); `None` if no route exists even without clearance.
    pub clearance_m: Option<f64>,
}

/// The greatest value below `wanted` that a trial is known to reach: what it gives is what its way really has.
fn greatest(
    wanted: f64,
    mut reached: impl FnMut(f64) -> Result<Option<f64>, PlanError>,
) -> Result<Option<f64>, PlanError> {
    if wanted <= 0.0 {
        return Ok(None);
    }
    let Some(mut best) = reached(0.0)? else { return Ok(None) };
    let mut too_much = wanted;
    for _ in 0..TRIALS {
        let middle = f64::midpoint(best, too_much);
        if too_much - best < 0.02 * wanted {
            break;
        }
        match reached(middle)? {
            Some(more) => best = more.max(middle),
            None => too_much = middle,
        }
    }
    Ok(Some(best.min(wanted)))
}

/// The regions that hold both ends with room around them, the smallest first.
fn squares(request: &Request, straight_m: f64) -> impl Iterator<Item = Square> + use<'_> {
    let plane = Plane::new(request.from);
    let middle = plane.place(plane.point(request.from).towards(plane.point(request.to), 0.5));
    let fits = move |half_m: &f64| *half_m >= 0.75 * straight_m + 5_000.0;
    let least = HALVES_M.iter().position(fits).unwrap_or(HALVES_M.len() - 1);
    HALVES_M[least..].iter().map(move |half_m| {
        let step_deg = half_m / 8.0 / 111_000.0;
        let lon_step_deg = step_deg / middle.lat_rad().cos().max(0.05);
        let lat_deg = ((middle.lat_deg() / step_deg).round() * step_deg).clamp(-90.0, 90.0);
        let lon_deg = ((middle.lon_deg() / lon_step_deg).round() * lon_step_deg).clamp(-180.0, 180.0);
        Square { middle: LatLon::from_deg(lat_deg, lon_deg).unwrap_or(middle), half_m: *half_m }
    })
}
