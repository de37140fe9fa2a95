//! Answers requests on a chart, and keeps the sea room that it made for them.

use crate::Cancel;
use crate::known::Known;
use crate::long::{Limits, Long, WishIn};
use crate::needs::{Needs, NeedsError};
use crate::objective::{Aim, Objective};
use crate::passable::{Passable, Search};
use crate::refusal::Refusal;
use crate::room::{PlanError, SeaRoom};
use crate::rooms::{Prepared, Rooms, Square, Water};
use crate::route::{Question, Request, Route};
use crate::sailing::Wish;
use crate::zones::Zones;
use charts::depth_index::{DepthIndex, Leg};
use std::sync::Arc;
use units::LatLon;

/// A chart set with no more vertices, and no wider, is prepared as a whole.
const WHOLE_VERTICES: usize = 600_000;
const WHOLE_DEG: f64 = 8.0;
/// Regions over charts of more vertices are not prepared, but for the smallest: so many take some 10 s and 200 MiB.
const MOST_VERTICES: usize = 12_000_000;
/// Corridors of long ways hold no more straight parts of what they keep clear of: so many take some 60 MiB.
const MOST_BARRIERS: usize = 600_000;
/// For one way no more tiles are looked at: twice as many as the corridor of a way of 800 km through open water has.
const MOST_TILES: usize = 2_000;
/// Side of the tiles of a long way (m).
const TILE_M: f64 = 20_000.0;
/// Ends this many tiles apart lie in a corridor of few tiles.
const TILES_APART: f64 = 4.0;
/// Half sides of regions (m), the smallest that fits first.
const HALVES_M: [f64; 6] = [20_000.0, 40_000.0, 80_000.0, 160_000.0, 320_000.0, 640_000.0];

/// Farthest that start and goal may lie apart (m): the largest region holds both, with room around them.
const FARTHEST_M: f64 = 800_000.0;

/// How charts are divided.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Division {
    Whole,
    Regions,
    /// All ways are looked for as long ones are.
    Tiles,
}

/// Plans on one chart.
///
/// May be asked from several threads; two that need the same room at once may both prepare it.
#[derive(Debug)]
pub struct Router {
    division: Division,
    most_vertices: usize,
    most_barriers: usize,
    most_tiles: usize,
    tile_m: f64,
    /// What routes are good for; `None` for the shortest.
    objective: Option<Arc<Objective>>,
    /// The speed through the water of all stretches, once it is chosen (m/s).
    pace_mps: Option<f64>,
    rooms: Rooms,
    known: Known,
}

impl Router {
    /// Over a chart.
    pub fn new(index: Arc<DepthIndex>) -> Self {
        let narrow = index.extent().is_none_or(|extent| {
            extent.east_deg - extent.west_deg <= 3.0 * WHOLE_DEG
                && extent.north_deg - extent.south_deg <= WHOLE_DEG
        });
        let whole = narrow && index.vertex_count() <= WHOLE_VERTICES;
        Self {
            division: if whole { Division::Whole } else { Division::Regions },
            most_vertices: MOST_VERTICES,
            most_barriers: MOST_BARRIERS,
            most_tiles: MOST_TILES,
            tile_m: TILE_M,
            objective: None,
            pace_mps: None,
            rooms: Rooms::new(index),
            known: Known::default(),
        }
    }

    /// Over a chart that is prepared region by region, whatever its size.
    pub fn by_regions(index: Arc<DepthIndex>) -> Self {
        Self { division: Division::Regions, ..Self::new(index) }
    }

    /// Over a chart where each way is looked for as a long one is, by tiles with sides of so many metres.
    pub fn by_tiles(index: Arc<DepthIndex>, tile_m: f64) -> Self {
        Self { division: Division::Tiles, tile_m: tile_m.max(100.0).round(), ..Self::new(index) }
    }

    /// With so many rooms kept at most, and never less than one, where memory is short.
    #[must_use]
    pub fn keeping(self, most_rooms: usize) -> Self {
        Self { rooms: self.rooms.keeping(most_rooms), ..self }
    }

    /// With regions, but for the smallest, over charts of so many vertices at most.
    #[must_use]
    pub fn preparing(self, most_vertices: usize) -> Self {
        Self { most_vertices, ..self }
    }

    /// With corridors of long ways that hold no more straight parts of what ways keep clear of.
    #[must_use]
    pub fn in_corridors(self, most_barriers: usize) -> Self {
        Self { most_barriers, ..self }
    }

    /// With so many tiles looked at for a long way at most; where they do not hold it, the search gives up
    /// ([`Refusal::GaveUp`]). With 0 long ways are refused at once.
    #[must_use]
    pub fn looking_at(self, most_tiles: usize) -> Self {
        Self { most_tiles, ..self }
    }

    /// Without long ways, which are refused at once; it shares the water that is kept with this one.
    #[must_use]
    pub fn without_long(&self) -> Self {
        Self { most_tiles: 0, ..self.shared() }
    }

    /// For ways that keep to zones; it shares the water that is kept with this one.
    #[must_use]
    pub fn in_zones(&self, zones: Zones) -> Self {
        Self { rooms: self.rooms.in_zones(zones), ..self.shared() }
    }

    /// For the best routes by an objective; it shares the water that is kept with this one.
    ///
    /// They are looked for in the region, or the corridor, that is prepared for the shortest route, and never cost more than
    /// that one; where they are another one, [`Route::shortest`] has the shortest to compare with. How near they come to the
    /// best way is said at `weighing`.
    ///
    /// # Errors
    /// The first value of the objective that is out of range.
    pub fn by_objective(&self, objective: Objective) -> Result<Self, NeedsError> {
        objective.validate()?;
        let objective = (!objective.is_shortest()).then(|| Arc::new(objective));
        Ok(Self { objective, ..self.shared() })
    }

    fn shared(&self) -> Self {
        let objective = self.objective.clone();
        Self { objective, rooms: self.rooms.clone(), known: self.known.clone(), ..*self }
    }

    /// The chart.
    pub fn index(&self) -> &Arc<DepthIndex> {
        &self.rooms.index
    }

    /// Whether a route by way of these places has a stretch for which no region is prepared, but a corridor: the first time
    /// that takes tens of seconds.
    pub fn is_long(&self, places: &[LatLon], needs: &Needs) -> bool {
        places.windows(2).any(|ends| {
            let straight_m = Leg { from: ends[0], to: ends[1] }.length_m();
            self.division == Division::Regions
                && self.most_tiles > 0
                && straight_m <= FARTHEST_M
                && squares([ends[0], ends[1]], straight_m)
                    .next()
                    .is_some_and(|square| self.is_too_much(&square, needs))
        })
    }

    /// The shortest way. The first request with new needs prepares the water, which can take a second, and tens of
    /// seconds for a long way ([`Self::is_long`]).
    ///
    /// # Errors
    /// The reason that no route exists.
    pub fn route(&self, request: &Request, needs: &Needs, cancel: &Cancel<'_>) -> Result<Route, Refusal> {
        let mut route = request.not_too_long(self.stretch(request, (needs, None), cancel)?)?;
        route.judge_turns(request, &self.rooms.index, needs, &self.rooms.zones);
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
        let long = |apart_m: f64| self.long(request, (needs, before), apart_m, cancel);
        match self.division {
            Division::Whole => {
                return self.ask(&Water::Whole, request, (needs, before), cancel).map(|(route, _)| route);
            }
            Division::Tiles => return long(TILES_APART * self.tile_m),
            Division::Regions => {}
        }
        let too_far = |most_m: f64| {
            Err(Refusal::TooFar { straight_km: straight_m / 1e3, most_km: most_m / 1e3, by: Vec::new() })
        };
        if straight_m > FARTHEST_M {
            return too_far(FARTHEST_M);
        }
        let mut answer = Err(PlanError::Geometry("no region holds both ends".to_owned()).into());
        let mut looked_m = 0.0;
        for (turn, square) in squares([request.from, request.to], straight_m).enumerate() {
            if self.is_too_much(&square, needs) {
                let apart_m = self.apart_m(&square, needs);
                return match (turn, self.most_tiles) {
                    (0, 0) => too_far(apart_m),
                    (0, _) => long(apart_m),
                    (_, most_tiles) => match of_part(answer, looked_m) {
                        // Regions hold no way, but tiles around them may.
                        Err(Refusal::Unknown { .. }) if most_tiles > 0 => long(apart_m),
                        answer => answer,
                    },
                };
            }
            looked_m = square.half_m - 0.5 * straight_m;
            answer = match self.ask(&Water::Square(square), request, (needs, before), cancel) {
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
                return answer;
            }
        }
        of_part(answer, looked_m)
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
        let stretches = onward.len();
        let mut whole: Option<Route> = None;
        for (stretch, to) in onward.into_iter().enumerate() {
            let from = whole.as_ref().map_or(from, Route::goal);
            // Of one stretch alone: those of several would have to be chosen for each of them.
            let alternatives = if places.len() > 2 { 0 } else { request.alternatives };
            let request = Request { from, to, alternatives, ..*request };
            let next = self.stretch(&request, (needs, whole.as_ref()), cancel);
            let mut next = next.map_err(|refusal| (stretch, refusal.of_stretch(stretch, stretches)))?;
            if stretch + 1 < stretches {
                next = next.ending_at_via(stretch + 1);
            }
            whole = Some(match whole {
                Some(before) => before.then(next),
                None => next,
            });
        }
        let mut whole = whole.ok_or((0, PlanError::Geometry("no place was given".to_owned()).into()))?;
        whole = request.not_too_long(whole).map_err(|refusal| (places.len().saturating_sub(2), refusal))?;
        // With the turns at places on the way.
        whole.judge_turns(request, &self.rooms.index, needs, &self.rooms.zones);
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
        let water = self.smallest_water(request);
        if matches!(&water, Water::Square(square) if self.is_too_much(square, needs)) {
            // What parts the ends is looked for among all lines around them, and these are too many.
            return Ok(Passable { not_looked: true, ..Passable::default() });
        }
        let room = self.rooms.room(needs, water, cancel)?;
        Search::new(&room, &self.rooms.index, request, cancel)
            .map_or_else(|| Ok(Passable::default()), Search::answer)
    }

    /// Makes searches quicker in water in which one was long, all around headlands and through islands. It takes as long as a
    /// dozen of these searches, so ask for it when no route is waited for. Whether there was something to learn.
    ///
    /// # Errors
    /// When it was called off; it can be asked for again.
    pub fn learn(&self, cancel: &Cancel<'_>) -> Result<bool, PlanError> {
        let Some(room) = self.rooms.to_learn() else { return Ok(false) };
        room.learned.learn(&room.mesh, cancel)?;
        drop(room);
        self.rooms.keep_within_bounds();
        Ok(true)
    }

    /// The water that is kept, what was asked for last first, to be prepared on the next chart by [`Self::prepare`]; without the
    /// corridors of long ways.
    pub fn prepared(&self) -> Vec<Prepared> {
        self.rooms.prepared()
    }

    /// Prepares water that was asked for on another chart before it is asked for here: as long as there is room for it beside
    /// what is kept, and where this chart is divided as that one was. Whether it was prepared.
    ///
    /// # Errors
    /// When it was called off; it can be asked for again.
    pub fn prepare(&self, wanted: &Prepared, cancel: &Cancel<'_>) -> Result<bool, PlanError> {
        let fits = match self.division {
            Division::Whole => wanted.is_whole(),
            Division::Regions => {
                wanted.square().is_some_and(|square| !self.is_too_much(square, wanted.needs()))
            }
            Division::Tiles => false,
        };
        Ok(fits && self.rooms.prepare_early(wanted, cancel)?)
    }

    /// Whether a region larger than the smallest ones is of charts that are too much for it.
    fn is_too_much(&self, square: &Square, needs: &Needs) -> bool {
        let preferred = self.objective.iter().flat_map(|objective| objective.preferred(needs)).flatten();
        let mut all = std::iter::once(*needs).chain(preferred);
        let vertices = |needs| SeaRoom::vertices(&self.rooms.index, &needs, square.middle, square.half_m);
        square.half_m > HALVES_M[0] && all.any(|needs| vertices(needs) > self.most_vertices)
    }

    /// How far apart ends may lie around the middle of a region that is too much (m).
    fn apart_m(&self, square: &Square, needs: &Needs) -> f64 {
        let enough = |half_m: &f64| {
            *half_m == HALVES_M[0] || !self.is_too_much(&Square { half_m: *half_m, ..*square }, needs)
        };
        apart_m(HALVES_M.into_iter().rev().find(enough).unwrap_or(HALVES_M[0]))
    }

    fn long(
        &self,
        request: &Request,
        (needs, before): (&Needs, Option<&Route>),
        apart_m: f64,
        cancel: &Cancel<'_>,
    ) -> Result<Route, Refusal> {
        let Self { tile_m, most_barriers, most_tiles, .. } = *self;
        let limits = Limits { tile_m, most_barriers, most_tiles, apart_m };
        let wish = |water: &Water| self.wish(water, (needs, before), cancel);
        let preferred = self.objective.iter().flat_map(|objective| objective.preferred(needs)).flatten();
        let wish = (&wish as WishIn<'_>, 1 + preferred.count());
        Long::new((&self.rooms, &self.known), limits, request, needs, wish, cancel).route()
    }

    fn is_enclosed(
        &self,
        square: Square,
        request: &Request,
        needs: &Needs,
        cancel: &Cancel<'_>,
    ) -> Result<bool, PlanError> {
        let room = self.rooms.room(needs, Water::Square(square), cancel)?;
        Ok(Question { room: &room, index: &self.rooms.index, request, wish: None, cancel }.is_enclosed())
    }

    /// How many rooms are kept, and about how much memory they take with the portals of tiles (bytes).
    pub fn kept(&self) -> (usize, usize) {
        let (rooms, bytes) = self.rooms.held();
        (rooms, bytes + self.known.bytes())
    }

    fn smallest_water(&self, request: &Request) -> Water {
        let straight_m = Leg { from: request.from, to: request.to }.length_m();
        let square = squares([request.from, request.to], straight_m).next();
        square.filter(|_| self.division != Division::Whole).map_or(Water::Whole, Water::Square)
    }

    fn ask(
        &self,
        water: &Water,
        request: &Request,
        (needs, before): (&Needs, Option<&Route>),
        cancel: &Cancel<'_>,
    ) -> Result<(Route, f64), Refusal> {
        let room = self.rooms.room(needs, water.clone(), cancel)?;
        let index = &self.rooms.index;
        if self.objective.as_ref().is_some_and(|one| one.preferred(needs).iter().any(Option::is_some)) {
            // Preferred water is prepared only where there is a route.
            let request = &Request { alternatives: 0, ..*request };
            Question { room: &room, index, request, wish: None, cancel }.answer()?;
        }
        let wish = self.wish(water, (needs, before), cancel)?;
        let route = Question { room: &room, index, request, wish: wish.as_ref(), cancel }.answer()?;
        let ends = [request.from, request.to].map(|place| room.plane().point(place));
        Ok((route, room.least_way_out_m(ends[0], ends[1])))
    }

    /// The objective of a stretch, with the water that it prefers.
    fn wish(
        &self,
        water: &Water,
        (needs, before): (&Needs, Option<&Route>),
        cancel: &Cancel<'_>,
    ) -> Result<Option<Wish>, PlanError> {
        let Some(objective) = &self.objective else { return Ok(None) };
        let preferred = objective.preferred(needs).into_iter().flatten();
        let preferred = preferred.map(|needs| self.rooms.room(&needs, water.clone(), cancel));
        let preferred = preferred.collect::<Result<_, _>>()?;
        let before = before.filter(|_| objective.currents.varies_in_time());
        let since = |before: &Route| objective.estimate_s(&before.lines(), before.speed_mps(objective));
        let since_s = before.map_or(0.0, since);
        Ok(Some(Wish { objective: Arc::clone(objective), preferred, since_s, pace_mps: self.pace_mps }))
    }
}

/// The answer of a region where water outside of it was not looked at, though that may hold another way.
fn of_part(answer: Result<Route, Refusal>, looked_m: f64) -> Result<Route, Refusal> {
    match answer {
        Ok(route) => Ok(Route { of_part: true, ..route }),
        Err(Refusal::NoWay { nearest, gap_m, .. }) => {
            Err(Refusal::Unknown { looked_km: looked_m / 1e3, nearest, gap_m })
        }
        Err(other) => Err(other),
    }
}

/// How far apart ends may lie in a region, so that there is room around them (m).
fn apart_m(half_m: f64) -> f64 {
    (half_m - 5_000.0) / 0.75
}

/// The regions that hold both ends with room around them, the smallest first.
fn squares(ends: [LatLon; 2], straight_m: f64) -> impl Iterator<Item = Square> {
    let fits = |half_m: &f64| apart_m(*half_m) >= straight_m;
    let least = HALVES_M.iter().position(fits).unwrap_or(HALVES_M.len() - 1);
    HALVES_M[least..].iter().map(move |half_m| Square::between(ends, *half_m))
}
