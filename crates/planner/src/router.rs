//! Answers requests on a chart, and keeps the sea room that it made for them.

use crate::Cancel;
use crate::needs::{Needs, NeedsError};
use crate::objective::{Aim, Objective};
use crate::passable::{Passable, Search};
use crate::plane::Plane;
use crate::room::{PlanError, SeaRoom};
use crate::route::{Question, Refusal, Request, Route};
use crate::sailing::Wish;
use crate::zones::Zones;
use charts::depth_index::{DepthIndex, Leg};
use std::sync::{Arc, Mutex, PoisonError};
use units::LatLon;

/// A chart set with no more vertices, and no wider, is prepared as a whole.
const WHOLE_VERTICES: usize = 600_000;
const WHOLE_DEG: f64 = 8.0;
/// Rooms that are kept where nothing else is said; the one not asked for longest goes first.
const MOST_ROOMS: usize = 8;
/// More memory than this they do not take together, but for the one that was asked for last (bytes).
const MOST_BYTES: usize = 96 << 20;
/// Regions over charts of more vertices are not prepared, but for the smallest: so many take some 10 s and 200 MiB.
const MOST_VERTICES: usize = 12_000_000;
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
    most_rooms: usize,
    most_vertices: usize,
    zones: Arc<Zones>,
    /// What routes are good for; `None` for the shortest.
    objective: Option<Arc<Objective>>,
    /// The speed through the water of all stretches, once it is chosen (m/s).
    pace_mps: Option<f64>,
    rooms: Arc<Mutex<Vec<Kept>>>,
}

#[derive(Debug, Clone)]
struct Kept {
    key: Key,
    room: Arc<SeaRoom>,
}

/// Needs and zones, and of which region: `None` of the whole chart.
#[derive(Debug, Clone, PartialEq)]
struct Key {
    needs: Needs,
    zones: Arc<Zones>,
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
        let (most_rooms, most_vertices) = (MOST_ROOMS, MOST_VERTICES);
        Self {
            index,
            whole,
            most_rooms,
            most_vertices,
            zones: Arc::default(),
            objective: None,
            pace_mps: None,
            rooms: Arc::default(),
        }
    }

    /// Over a chart that is prepared region by region, whatever its size.
    pub fn by_regions(index: Arc<DepthIndex>) -> Self {
        Self { whole: false, ..Self::new(index) }
    }

    /// With so many rooms kept at most, and never less than one, where memory is short.
    #[must_use]
    pub fn keeping(self, most_rooms: usize) -> Self {
        Self { most_rooms: most_rooms.max(1), ..self }
    }

    /// With regions, but for the smallest, over charts of so many vertices at most.
    #[must_use]
    pub fn preparing(self, most_vertices: usize) -> Self {
        Self { most_vertices, ..self }
    }

    /// For ways that keep to zones; it shares the water that is kept with this one.
    #[must_use]
    pub fn in_zones(&self, zones: Zones) -> Self {
        Self { zones: Arc::new(zones), ..self.shared() }
    }

    /// For the best routes by an objective; it shares the water that is kept with this one.
    ///
    /// They are looked for in the region that is prepared for the shortest route, and never cost more than that one; where
    /// they are another one, [`Route::shortest`] has the shortest to compare with. How near they come to the best way is
    /// said at `weighing`.
    ///
    /// # Errors
    /// The first value of the objective that is out of range.
    pub fn by_objective(&self, objective: Objective) -> Result<Self, NeedsError> {
        objective.validate()?;
        let objective = (!objective.is_shortest()).then(|| Arc::new(objective));
        Ok(Self { objective, ..self.shared() })
    }

    fn shared(&self) -> Self {
        let (zones, objective) = (Arc::clone(&self.zones), self.objective.clone());
        Self { index: Arc::clone(&self.index), zones, objective, rooms: Arc::clone(&self.rooms), ..*self }
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
        let mut route = request.not_too_long(self.stretch(request, (needs, None), cancel)?)?;
        route.judge_turns(request, &self.index, needs, &self.zones);
        Ok(route)
    }

    /// A route whose turns are not judged yet, after the stretches before it.
    fn stretch(
        &self,
        request: &Request,
        (needs, before): (&Needs, Option<&Route>),
        cancel: &Cancel<'_>,
    ) -> Result<Route, Refusal> {
        needs.validate()?;
        request.validate()?;
        let straight_m = Leg { from: request.from, to: request.to }.length_m();
        // Nothing is prepared for a way that is too long in any case: the farther the ends, the more memory that takes.
        request.not_longer(straight_m)?;
        if self.whole {
            return self.ask(None, request, (needs, before), cancel).map(|(route, _)| route);
        }
        if straight_m > FARTHEST_M {
            return Err(Refusal::TooFar { straight_km: straight_m / 1e3, most_km: FARTHEST_M / 1e3 });
        }
        let mut answer = Err(PlanError::Geometry("no region holds both ends".to_owned()).into());
        for (turn, square) in squares(request, straight_m).enumerate() {
            if self.is_too_much(&square, needs) {
                // What a smaller region said holds, if there was one.
                return if turn > 0 { answer } else { Err(self.too_far(straight_m, &square, needs)) };
            }
            answer = match self.ask(Some(square), request, (needs, before), cancel) {
                // No way that leaves the region can be shorter.
                Ok((route, least_out_m)) if route.shortest_m() <= least_out_m => return Ok(route),
                Ok((route, _)) => Ok(route),
                // There may be a way around, by water outside, unless an end lies in water that does not lead there.
                Err(refusal @ Refusal::NoWay { .. }) => {
                    if self.is_enclosed(square, request, needs, cancel)? {
                        return answer.or(Err(refusal));
                    }
                    answer.or(Err(refusal))
                }
                Err(other) => return Err(other),
            };
            // A way stays within half its length of the middle between its ends, and the region's middle lies near that.
            if request.longest_m.is_some_and(|longest_m| square.half_m >= 0.6 * longest_m) {
                break;
            }
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
        if let Some(pace_mps) = self.pace_over(places, request, needs, cancel)? {
            let at_pace = Self { pace_mps: Some(pace_mps), ..self.shared() };
            return at_pace.route_by(places, request, needs, cancel);
        }
        let mut whole: Option<Route> = None;
        for (stretch, to) in onward.into_iter().enumerate() {
            let from = whole.as_ref().map_or(from, Route::goal);
            // Of one stretch alone: those of several would have to be chosen for each of them.
            let alternatives = if places.len() > 2 { 0 } else { request.alternatives };
            let request = Request { from, to, alternatives, ..*request };
            let next = self.stretch(&request, (needs, whole.as_ref()), cancel);
            let next = next.map_err(|refusal| (stretch, refusal))?;
            whole = Some(match whole {
                Some(before) => before.then(next),
                None => next,
            });
        }
        let mut whole = whole.ok_or((0, PlanError::Geometry("no place was given".to_owned()).into()))?;
        whole = request.not_too_long(whole).map_err(|refusal| (places.len().saturating_sub(2), refusal))?;
        // With the turns at places on the way.
        whole.judge_turns(request, &self.index, needs, &self.zones);
        Ok(whole)
    }

    /// The speed of a route of the least energy by way of several places: one for all stretches, the best along the shortest
    /// ones, so that no stretch is too slow against its current if that can be helped. `None` where it is not to be chosen.
    fn pace_over(
        &self,
        places: &[LatLon],
        request: &Request,
        needs: &Needs,
        cancel: &Cancel<'_>,
    ) -> Result<Option<f64>, (usize, Refusal)> {
        let chooses = places.len() > 2 && self.pace_mps.is_none();
        let Some(objective) = self.objective.as_deref().filter(|one| chooses && one.aim == Aim::Energy)
        else {
            return Ok(None);
        };
        let plain = Self { objective: None, ..self.shared() };
        let shortest = plain.route_by(places, &Request { turn_radius_m: None, ..*request }, needs, cancel)?;
        Ok(Some(objective.best_pace_mps(&shortest.lines())))
    }

    /// Which smaller demands would give a route: the greatest least depth with this clearance, and the greatest clearance
    /// with this depth (m). A route exists for each of them.
    ///
    /// # Errors
    /// When the request was cancelled.
    pub fn passable(
        &self,
        request: &Request,
        needs: &Needs,
        cancel: &Cancel<'_>,
    ) -> Result<Passable, PlanError> {
        let room = self.room(self.key(needs, self.smallest_square(request)), cancel)?;
        Search::new(&room, &self.index, request, cancel)
            .map_or_else(|| Ok(Passable::default()), Search::answer)
    }

    /// Whether a region larger than the smallest ones is of charts that are too much for it.
    fn is_too_much(&self, square: &Square, needs: &Needs) -> bool {
        let preferred = self.objective.iter().flat_map(|objective| objective.preferred(needs)).flatten();
        let mut all = std::iter::once(*needs).chain(preferred);
        let vertices = |needs| SeaRoom::vertices(&self.index, &needs, square.middle, square.half_m);
        square.half_m > HALVES_M[0] && all.any(|needs| vertices(needs) > self.most_vertices)
    }

    /// How far apart ends may lie around the middle of a region that is too much.
    fn too_far(&self, straight_m: f64, square: &Square, needs: &Needs) -> Refusal {
        let enough = |half_m: &f64| {
            *half_m == HALVES_M[0] || !self.is_too_much(&Square { half_m: *half_m, ..*square }, needs)
        };
        let half_m = HALVES_M.into_iter().rev().find(enough).unwrap_or(HALVES_M[0]);
        Refusal::TooFar { straight_km: straight_m / 1e3, most_km: apart_m(half_m) / 1e3 }
    }

    fn is_enclosed(
        &self,
        square: Square,
        request: &Request,
        needs: &Needs,
        cancel: &Cancel<'_>,
    ) -> Result<bool, PlanError> {
        let room = self.room(self.key(needs, Some(square)), cancel)?;
        Ok(Question { room: &room, index: &self.index, request, wish: None, cancel }.is_enclosed())
    }

    /// How many rooms are kept, and about how much memory they take (bytes).
    pub fn kept(&self) -> (usize, usize) {
        let rooms = self.rooms.lock().unwrap_or_else(PoisonError::into_inner);
        (rooms.len(), rooms.iter().map(|kept| kept.room.bytes()).sum())
    }

    fn key(&self, needs: &Needs, region: Option<Square>) -> Key {
        Key { needs: *needs, zones: Arc::clone(&self.zones), region }
    }

    fn smallest_square(&self, request: &Request) -> Option<Square> {
        let straight_m = Leg { from: request.from, to: request.to }.length_m();
        if self.whole { None } else { squares(request, straight_m).next() }
    }

    fn ask(
        &self,
        region: Option<Square>,
        request: &Request,
        (needs, before): (&Needs, Option<&Route>),
        cancel: &Cancel<'_>,
    ) -> Result<(Route, f64), Refusal> {
        let room = self.room(self.key(needs, region), cancel)?;
        if self.objective.as_ref().is_some_and(|one| one.preferred(needs).iter().any(Option::is_some)) {
            // Preferred water is prepared only where there is a route.
            let request = &Request { alternatives: 0, ..*request };
            Question { room: &room, index: &self.index, request, wish: None, cancel }.answer()?;
        }
        let wish = self.wish(region, (needs, before), cancel)?;
        let route =
            Question { room: &room, index: &self.index, request, wish: wish.as_ref(), cancel }.answer()?;
        let ends = [request.from, request.to].map(|place| room.plane().point(place));
        Ok((route, room.least_way_out_m(ends[0], ends[1])))
    }

    /// The objective of a stretch, with the water that it prefers.
    fn wish(
        &self,
        region: Option<Square>,
        (needs, before): (&Needs, Option<&Route>),
        cancel: &Cancel<'_>,
    ) -> Result<Option<Wish>, PlanError> {
        let Some(objective) = &self.objective else { return Ok(None) };
        let preferred = objective.preferred(needs).into_iter().flatten();
        let preferred = preferred.map(|needs| self.room(self.key(&needs, region), cancel));
        let preferred = preferred.collect::<Result<_, _>>()?;
        let before = before.filter(|_| objective.currents.varies_in_time());
        let since = |before: &Route| objective.estimate_s(&before.lines(), before.speed_mps(objective));
        let since_s = before.map_or(0.0, since);
        Ok(Some(Wish { objective: Arc::clone(objective), preferred, since_s, pace_mps: self.pace_mps }))
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
        // Only now: a preparation that is called off takes nobody's place.
        let held = |rooms: &[Kept]| rooms.iter().map(|kept| kept.room.bytes()).sum::<usize>();
        while rooms.len() >= self.most_rooms || !rooms.is_empty() && held(&rooms) + room.bytes() > MOST_BYTES
        {
            // What a question works with stays: it may have up to three.
            let unused = rooms.iter().position(|kept| Arc::strong_count(&kept.room) == 1);
            let Some(unused) = unused else { break };
            rooms.remove(unused);
        }
        rooms.push(Kept { key, room: Arc::clone(&room) });
        Ok(room)
    }

    fn prepare(index: &DepthIndex, key: &Key, cancel: &Cancel<'_>) -> Result<SeaRoom, PlanError> {
        match key.region {
            None => SeaRoom::of_chart(index, &key.needs, &key.zones, cancel),
            Some(Square { middle, half_m }) => {
                SeaRoom::around(index, (&key.needs, &key.zones), middle, (half_m, half_m), cancel)
            }
        }
    }
}

/// How far apart ends may lie in a region, so that there is room around them (m).
fn apart_m(half_m: f64) -> f64 {
    (half_m - 5_000.0) / 0.75
}

/// The regions that hold both ends with room around them, the smallest first.
fn squares(request: &Request, straight_m: f64) -> impl Iterator<Item = Square> + use<'_> {
    let plane = Plane::new(request.from);
    let middle = plane.place(plane.point(request.from).towards(plane.point(request.to), 0.5));
    let fits = move |half_m: &f64| apart_m(*half_m) >= straight_m;
    let least = HALVES_M.iter().position(fits).unwrap_or(HALVES_M.len() - 1);
    HALVES_M[least..].iter().map(move |half_m| {
        let step_deg = half_m / 8.0 / 111_000.0;
        let lat_deg = ((middle.lat_deg() / step_deg).round() * step_deg).clamp(-90.0, 90.0);
        // Of the grid's latitude: by that of the middle each request would have a grid of its own.
        let lon_step_deg = step_deg / lat_deg.to_radians().cos().max(0.05);
        let lon_deg = ((middle.lon_deg() / lon_step_deg).round() * lon_step_deg).clamp(-180.0, 180.0);
        Square { middle: LatLon::from_deg(lat_deg, lon_deg).unwrap_or(middle), half_m: *half_m }
    })
}
