//! Answers requests on a chart, and keeps the sea room that it made for them.

use crate::needs::Needs;
use crate::plane::Plane;
use crate::room::{PlanError, SeaRoom};
use crate::route::{Question, Refusal, Request, Route};
use crate::Cancel;
use charts::depth_index::DepthIndex;
use std::sync::{Arc, Mutex, PoisonError};
use units::LatLon;

/// A chart set with no more vertices, and no wider, is prepared as a whole.
const WHOLE_VERTICES: usize = 600_000;
const WHOLE_DEG: f64 = 8.0;
/// Rooms that are kept; the one not asked for longest goes first.
const MOST_ROOMS: usize = 8;
/// Half sides of regions (m), the smallest that fits first.
const HALVES_M: [f64; 6] = [20_000.0, 40_000.0, 80_000.0, 160_000.0, 320_000.0, 640_000.0];

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
            extent.east_deg - extent.west_deg <= 3.0 * WHOLE_DEG && extent.north_deg - extent.south_deg <= WHOLE_DEG
        });
        let whole = narrow && index.vertex_count() <= WHOLE_VERTICES;
        Self { index, whole, rooms: Mutex::default() }
    }

    /// The chart.
    pub fn index(&self) -> &Arc<DepthIndex> {
        &self.index
    }

    /// The shortest way. The first request with new needs prepares the water, which can take a second.
    ///
    /// # Errors
    /// Why there is none.
    pub fn route(&self, request: &Request, needs: &Needs, cancel: &Cancel<'_>) -> Result<Route, Refusal> {
        needs.validate()?;
        if self.whole {
            return self.ask(None, request, needs, cancel).map(|(route, _)| route);
        }
        let mut refused = None;
        for square in squares(request) {
            match self.ask(Some(square), request, needs, cancel) {
                // No way out of the region and back can be shorter.
                Ok((route, least_out_m)) if route.length_m <= least_out_m => return Ok(route),
                Ok(_) => {}
                Err(refusal @ (Refusal::NoWay { .. } | Refusal::Closed { .. })) => refused = Some(refusal),
                Err(other) => return Err(other),
            }
        }
        match refused {
            Some(refusal) => Err(refusal),
            None => Err(PlanError::Geometry("the way is longer than any region".to_owned()).into()),
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
        let room = match key.region {
            None => SeaRoom::of_chart(&self.index, &key.needs, cancel)?,
            Some(Square { middle, half_m }) => {
                SeaRoom::around(&self.index, &key.needs, middle, (half_m, half_m), cancel)?
            }
        };
        let room = Arc::new(room);
        let mut rooms = lock();
        if rooms.len() >= MOST_ROOMS {
            rooms.remove(0);
        }
        rooms.push(Kept { key, room: Arc::clone(&room) });
        Ok(room)
    }
}

/// The regions that hold both ends with room around them, the smallest first.
fn squares(request: &Request) -> impl Iterator<Item = Square> + use<'_> {
    let straight_m = crate::route::geodesic_m(request.from, request.to);
    let plane = Plane::new(request.from);
    let middle = plane.place(plane.point(request.from).towards(plane.point(request.to), 0.5));
    let fits = move |half_m: &f64| *half_m >= 0.75 * straight_m + 5_000.0;
    let least = HALVES_M.iter().position(|half_m| fits(half_m)).unwrap_or(HALVES_M.len() - 1);
    HALVES_M[least..].iter().map(move |half_m| {
        let step_deg = half_m / 8.0 / 111_000.0;
        let lon_step_deg = step_deg / middle.lat_rad().cos().max(0.05);
        let lat_deg = ((middle.lat_deg() / step_deg).round() * step_deg).clamp(-90.0, 90.0);
        let lon_deg = ((middle.lon_deg() / lon_step_deg).round() * lon_step_deg).clamp(-180.0, 180.0);
        Square { middle: LatLon::from_deg(lat_deg, lon_deg).unwrap_or(middle), half_m: *half_m }
    })
}
