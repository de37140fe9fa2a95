//! What is asked and what is answered: a route in legs, or the reason that no route exists.

use crate::Cancel;
use crate::alternatives;
use crate::needs::{Needs, NeedsError};
use crate::objective::{LegCost, Objective};
use crate::obstacles;
use crate::plane::Point;
use crate::refusal::{End, Refusal};
use crate::room::{FAR_M, SeaRoom};
use crate::sailing::Wish;
use crate::search::Effort;
use crate::tidy::tidy;
use crate::turns::{self, Turn};
use crate::zones::Zones;
use charts::depth_index::{DepthAnswer, DepthIndex, Leg, Restricted, Restriction, Water};
use units::LatLon;

/// A leg that the chart does not confirm as one geodesic is halved so often at most: a long one bows in the plane.
const MOST_HALVINGS: u32 = 7;
/// Beyond the allowed distance, water is looked for so far, to say where it is (m).
const LOOK_M: f64 = 50_000.0;

/// So many other routes are weighed at least, beside the shortest one.
const WEIGHED: usize = 3;
/// Where smaller demands are looked for, so many places for each end are tried.
const MOST_STANDS: usize = 2;
/// Greatest turning radius that routes are planned for (m).
const MOST_TURN_RADIUS_M: f64 = 2_000.0;
/// Greatest length that can be asked for as the longest (m): half way round the globe.
const MOST_LENGTH_M: f64 = 2e7;

/// From where to where.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Request {
    /// Start.
    pub from: LatLon,
    /// Goal.
    pub to: LatLon,
    /// A start or goal in closed water is moved to the nearest open water if that is not farther off (m).
    pub move_up_to_m: f64,
    /// Corners are joined where legs would be shorter (m).
    pub least_leg_m: f64,
    /// Turning radius of the vessel (m): corners are joined and moved so that its turns keep clear as the legs do, and
    /// where the water does not allow that, [`RouteLeg::turn`] says so. `None` where it is not known.
    pub turn_radius_m: Option<f64>,
    /// So many other routes are looked for that pass what the shortest passes on the other side.
    pub alternatives: usize,
    /// A longer route is of no use (m): none is looked for in water farther off than it could lead. `None` for any length.
    pub longest_m: Option<f64>,
}

impl Request {
    /// With ends that may be moved by 1 km, and legs of 15 m and more, for a vessel that turns on the spot; of any length,
    /// and without alternatives.
    pub fn new(from: LatLon, to: LatLon) -> Self {
        Self {
            from,
            to,
            move_up_to_m: 1_000.0,
            least_leg_m: 15.0,
            turn_radius_m: None,
            alternatives: 0,
            longest_m: None,
        }
    }

    /// Whether all its lengths are numbers in range.
    ///
    /// # Errors
    /// The first that is not.
    pub fn validate(&self) -> Result<(), NeedsError> {
        let radius_m = self.turn_radius_m.unwrap_or(0.0);
        NeedsError::of("turning radius (m)", radius_m, 0.0, MOST_TURN_RADIUS_M)?;
        NeedsError::of("longest route (m)", self.longest_m.unwrap_or(0.0), 0.0, MOST_LENGTH_M)
    }

    /// The answer, if it is not longer than is of use; the shortest route in place of one that is.
    pub(crate) fn not_too_long(&self, mut route: Route) -> Result<Route, Refusal> {
        if self.not_longer(route.length_m).is_err()
            && let Some(mut shortest) = route.shortest.take()
        {
            shortest.alternatives = route.alternatives;
            route = *shortest;
        }
        route.alternatives.retain(|other| self.not_longer(other.length_m).is_ok());
        self.not_longer(route.length_m).map(|()| route)
    }

    /// Whether a way of this length (m) is of use.
    pub(crate) fn not_longer(&self, length_m: f64) -> Result<(), Refusal> {
        match self.longest_m.filter(|most_m| length_m > *most_m) {
            Some(most_m) => Err(Refusal::TooLong { length_m, most_m }),
            None => Ok(()),
        }
    }
}

/// An end that lay in closed water.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Moved {
    /// Where it was asked for.
    pub from: LatLon,
    /// Where the way begins or ends instead.
    pub to: LatLon,
    /// How far that is (m).
    pub distance_m: f64,
    /// What there is where it was asked for.
    pub water: Water,
    /// How the place is closed to the vessel by a rule, if it is.
    pub refused: Option<Restriction>,
}

/// A leg of a way, and what the chart has around it.
#[derive(Debug, Clone, PartialEq)]
pub struct RouteLeg {
    /// Start.
    pub from: LatLon,
    /// End.
    pub to: LatLon,
    /// Length (m).
    pub length_m: f64,
    /// The worst within the clearance: least depth, what is left of it, and where.
    pub worst: DepthAnswer,
    /// Distance to the nearest danger, land or shallow water (m); `None` beyond 5 km.
    pub clearance_m: Option<f64>,
    /// The turn at its end, if a turning radius was asked for; `None` at the goal, and where the way goes straight on.
    pub turn: Option<Turn>,
}

/// Legs of a route that have less room than is wanted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Narrow {
    /// The narrowest leg, by its number from 0.
    pub leg: usize,
    /// Its distance to the nearest danger, land or shallow water (m).
    pub least_m: f64,
    /// How many legs they are.
    pub legs: usize,
    /// How long they are together (m).
    pub length_m: f64,
}

/// A route whose every leg the chart confirms.
#[derive(Debug, Clone, PartialEq)]
pub struct Route {
    /// The legs, in order; one without length where start and goal are the same place.
    pub legs: Vec<RouteLeg>,
    /// Where it begins; the legs' ends follow.
    pub start: LatLon,
    /// Length (m).
    pub length_m: f64,
    /// The start, if it was moved.
    pub moved_start: Option<Moved>,
    /// The goal, if it was moved.
    pub moved_goal: Option<Moved>,
    /// Places to pass that were moved, by their numbers from 1.
    pub moved_via: Vec<(usize, Moved)>,
    /// What finding it took.
    pub effort: Effort,
    /// Only part of the water was looked at in full, as there is too much of it: other water may hold a shorter way.
    pub of_part: bool,
    /// Other routes between the same places, as far as they were asked for: the shortest of them first. A route by way of
    /// several places has none.
    pub alternatives: Vec<Route>,
    /// The shortest route, where an [`Objective`](crate::Objective) chose another one.
    pub shortest: Option<Box<Route>>,
    /// The speed through the water that takes the least energy (m/s), where that was asked for; `None` for the asked speed.
    pub through_water_mps: Option<f64>,
}

impl Route {
    /// This way and another that begins where it ends, as one.
    #[must_use]
    pub fn then(mut self, mut next: Self) -> Self {
        let shortest = [self.shortest.take(), next.shortest.take()];
        self.shortest = match shortest {
            [None, None] => None,
            [before, after] => {
                let [before, after] = [(before, &self), (after, &next)]
                    .map(|(shortest, route)| shortest.map_or_else(|| route.clone(), |shortest| *shortest));
                Some(Box::new(before.then(after)))
            }
        };
        self.length_m += next.length_m;
        self.legs.extend(next.legs);
        self.moved_goal = next.moved_goal;
        self.moved_via.extend(next.moved_via);
        self.effort = self.effort.and(next.effort);
        self.of_part |= next.of_part;
        self.alternatives.clear();
        self
    }

    /// As a stretch that ends at a place to pass: its goal is that place.
    pub(crate) fn ending_at_via(mut self, number: usize) -> Self {
        if let Some(shortest) = self.shortest.take() {
            self.shortest = Some(Box::new(shortest.ending_at_via(number)));
        }
        self.moved_via.extend(self.moved_goal.map(|moved| (number, moved)));
        self
    }

    /// Says at each leg what turn follows it, if a turning radius was asked for.
    pub(crate) fn judge_turns(
        &mut self,
        request: &Request,
        index: &DepthIndex,
        needs: &Needs,
        zones: &Zones,
    ) {
        if let Some(radius_m) = request.turn_radius_m {
            let turns = turns::judge(&self.lines(), radius_m, index, needs, zones);
            self.legs.iter_mut().zip(turns).for_each(|(leg, turn)| leg.turn = turn);
        }
        for other in self.alternatives.iter_mut().chain(self.shortest.as_deref_mut()) {
            other.judge_turns(request, index, needs, zones);
        }
    }

    /// The speed through the water that it is sailed at (m/s).
    pub fn speed_mps(&self, objective: &Objective) -> f64 {
        self.through_water_mps.unwrap_or(objective.through_water_mps)
    }

    /// Its legs as lines, and how long each is (m).
    pub(crate) fn lines(&self) -> Vec<(Leg, f64)> {
        self.legs.iter().map(|leg| (Leg { from: leg.from, to: leg.to }, leg.length_m)).collect()
    }

    /// What its legs take, one after the other from the time of departure.
    pub fn reckon(&self, objective: &Objective) -> Vec<LegCost> {
        objective.reckon(&self.lines(), self.speed_mps(objective))
    }

    /// Length of the shortest route (m): of this one, unless an objective chose another.
    pub(crate) fn shortest_m(&self) -> f64 {
        self.shortest.as_ref().map_or(self.length_m, |shortest| shortest.length_m)
    }

    /// Where it ends.
    pub fn goal(&self) -> LatLon {
        self.legs.last().map_or(self.start, |leg| leg.to)
    }

    /// All corners, ends included.
    pub fn places(&self) -> impl Iterator<Item = LatLon> {
        std::iter::once(self.start).chain(self.legs.iter().map(|leg| leg.to))
    }

    /// Least charted depth within the clearance of the way (m).
    pub fn least_depth_m(&self) -> Option<f64> {
        self.legs.iter().filter_map(|leg| leg.worst.water.least_m()).min_by(f64::total_cmp)
    }

    /// Where danger, land or shallow water is nearer than this (m), such as what a vessel may be off its track before its path
    /// monitor acts; `None` where there is so much room everywhere.
    pub fn narrow(&self, room_m: f64) -> Option<Narrow> {
        let clear = |leg: &RouteLeg| leg.clearance_m.filter(|clear_m| *clear_m < room_m);
        let narrow = (0..).zip(&self.legs).filter_map(|(number, leg)| Some((number, leg, clear(leg)?)));
        let (leg, _, least_m) = narrow.clone().min_by(|one, other| one.2.total_cmp(&other.2))?;
        Some(Narrow {
            leg,
            least_m,
            legs: narrow.clone().count(),
            length_m: narrow.map(|(_, leg, _)| leg.length_m).sum(),
        })
    }

    /// Distance to the nearest danger, land or shallow water (m); `None` beyond 5 km.
    pub fn least_clearance_m(&self) -> Option<f64> {
        self.legs.iter().filter_map(|leg| leg.clearance_m).min_by(f64::total_cmp)
    }
}

/// An end in open water.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Stand {
    at: Point,
    triangle: u32,
    moved: Option<Moved>,
}

/// A question to one room.
pub(crate) struct Question<'a> {
    pub(crate) room: &'a SeaRoom,
    pub(crate) index: &'a DepthIndex,
    pub(crate) request: &'a Request,
    /// What the route is good for; `None` for the shortest.
    pub(crate) wish: Option<&'a Wish>,
    pub(crate) cancel: &'a Cancel<'a>,
}

impl Question<'_> {
    pub(crate) fn answer(&self) -> Result<Route, Refusal> {
        let (start, goal) = self.stands()?;
        let mesh = &self.room.mesh;
        let ends = [start, goal].map(|end| (mesh.within(end.triangle, end.at), end.triangle));
        let found = self.room.shortest(ends, None, self.cancel)?;
        let Some((way, effort)) = found else { return Err(self.no_way(start)) };
        let asked = self.request.alternatives;
        let weighed = if self.wish.is_some() { asked.max(WEIGHED) } else { asked };
        let others = alternatives::others(self.room, ends, &way, weighed, self.cancel)?;
        let ways = || std::iter::once(&way).chain(others.iter().map(|other| &other.way)).cloned();
        let ways: Vec<Vec<Point>> = if self.wish.is_some() { ways().collect() } else { Vec::new() };
        let mut route = self.confirmed(way, effort, (start, goal))?;
        for other in others {
            match self.confirmed(other.way, other.effort, (start, goal)) {
                Ok(other) => route.alternatives.push(other),
                // The route that was asked for stands without it.
                Err(Refusal::NotConfirmed { .. }) => {}
                Err(refusal) => return Err(refusal),
            }
        }
        if let Some(wish) = self.wish {
            route = self.weighed(wish, &ways, route, (start, goal))?;
            route.alternatives.truncate(asked);
        }
        Ok(route)
    }

    /// A way in legs that a vessel can sail, each confirmed by the chart.
    pub(crate) fn confirmed(
        &self,
        mut way: Vec<Point>,
        effort: Effort,
        (start, goal): (Stand, Stand),
    ) -> Result<Route, Refusal> {
        (way[0], *way.last_mut().expect("invariant: a way has ends")) = (start.at, goal.at);
        let radius_m = self.request.turn_radius_m.unwrap_or(0.0);
        let is_clear = |from: Point, to: Point| self.is_clear(from, to);
        let mut way = tidy(&way, self.request.least_leg_m, radius_m, is_clear);
        if radius_m > 0.0 {
            turns::move_out(&mut way, radius_m, is_clear);
        }
        let mut legs = Vec::with_capacity(way.len());
        for leg in way.windows(2) {
            self.cancel.check()?;
            self.confirm(leg[0], leg[1], MOST_HALVINGS, &mut legs)?;
        }
        let start_place = legs.first().map_or(self.room.plane().place(start.at), |leg: &RouteLeg| leg.from);
        let length_m = legs.iter().map(|leg| leg.length_m).sum();
        let (moved_start, moved_goal) = (start.moved, goal.moved);
        Ok(Route {
            legs,
            start: start_place,
            length_m,
            moved_start,
            moved_goal,
            moved_via: Vec::new(),
            effort,
            of_part: false,
            alternatives: Vec::new(),
            shortest: None,
            through_water_mps: None,
        })
    }

    /// Where both ends may stand, as pairs; `None` where one is closed.
    pub(crate) fn ends(&self) -> Option<Vec<[Point; 2]>> {
        let starts = self.stand(End::Start, self.request.from).ok()?;
        let goals = self.stand(End::Goal, self.request.to).ok()?;
        let few = |stands: Vec<Stand>| stands.into_iter().take(MOST_STANDS);
        let goals: Vec<Stand> = few(goals).collect();
        Some(few(starts).flat_map(|start| goals.iter().map(move |goal| [start.at, goal.at])).collect())
    }

    /// Whether one end lies in water that ends within the region, wherever it may stand: more of the chart gives no way.
    pub(crate) fn is_enclosed(&self) -> bool {
        let ends = [(End::Start, self.request.from), (End::Goal, self.request.to)];
        let leads_out = |stand: &Stand| self.room.leads_out(self.room.mesh.piece[stand.triangle as usize]);
        ends.into_iter()
            .any(|(end, place)| self.stand(end, place).is_ok_and(|stands| !stands.iter().any(leads_out)))
    }

    /// Why no way begins or ends at an end, if so.
    pub(crate) fn closed(&self, (end, place): (End, LatLon)) -> Option<Refusal> {
        self.stand(end, place).err()
    }

    /// Both ends in open water, in the same piece of it if there is a choice.
    fn stands(&self) -> Result<(Stand, Stand), Refusal> {
        let starts = self.stand(End::Start, self.request.from)?;
        let goals = self.stand(End::Goal, self.request.to)?;
        let piece = |stand: &Stand| self.room.mesh.piece[stand.triangle as usize];
        let pairs = starts.iter().flat_map(|start| goals.iter().map(move |goal| (*start, *goal)));
        let moved_m = |stand: &Stand| stand.moved.map_or(0.0, |moved| moved.distance_m);
        let together = pairs.filter(|(start, goal)| piece(start) == piece(goal));
        let best = together.min_by(|one, other| {
            (moved_m(&one.0) + moved_m(&one.1)).total_cmp(&(moved_m(&other.0) + moved_m(&other.1)))
        });
        best.map_or_else(|| Err(self.no_way(starts[0])), Ok)
    }

    /// Where an end may stand: at its place, or at the nearest points of pieces of open water; at least one.
    fn stand(&self, end: End, place: LatLon) -> Result<Vec<Stand>, Refusal> {
        let Question { room, index, request, .. } = self;
        let at = room.plane().point(place);
        if let Some(triangle) = room.mesh.locate(at) {
            return Ok(vec![Stand { at, triangle, moved: None }]);
        }
        let here = index.shallowest_within(place, 0.0, &room.needs().demand);
        let refused = here.area.filter(Restricted::is_refused).map(|area| area.restriction);
        let water = here.water;
        let near = room.mesh.nearest(at, request.move_up_to_m);
        let stands: Vec<Stand> = near
            .into_iter()
            .map(|near| {
                let to = room.mesh.within(near.triangle, near.at);
                let moved = Moved {
                    from: place,
                    to: room.plane().place(to),
                    distance_m: near.distance_m,
                    water,
                    refused,
                };
                Stand { at: to, triangle: near.triangle, moved: Some(moved) }
            })
            .collect();
        if stands.is_empty() {
            let nearest_m = room.mesh.nearest(at, LOOK_M).first().map(|near| near.distance_m);
            let (zoned, allowed_m) = (!room.zones().allow(place), request.move_up_to_m);
            return Err(Refusal::Closed { end, water, refused, zoned, nearest_m, allowed_m });
        }
        Ok(stands)
    }

    fn no_way(&self, start: Stand) -> Refusal {
        let room = self.room;
        let goal = room.plane().point(self.request.to);
        let piece = room.mesh.piece[start.triangle as usize];
        let near = room.mesh.nearest_of(piece, goal);
        let (at, gap_m) =
            near.map_or((start.at, start.at.distance_m(goal)), |near| (near.at, near.distance_m));
        Refusal::NoWay { nearest: room.plane().place(at), gap_m, looked_km: None }
    }

    /// Whether a leg from open water keeps the clearance; asked often, so of the room. The chart confirms what is chosen.
    fn is_clear(&self, from: Point, to: Point) -> bool {
        self.room.keeps_clear(from, to)
    }

    fn worst(&self, from: Point, to: Point) -> (LatLon, LatLon, DepthAnswer) {
        let plane = self.room.plane();
        let (from, to) = (plane.place(from), plane.place(to));
        let Needs { demand, clearance_m } = self.room.needs();
        (from, to, self.index.shallowest_along(Leg { from, to }, *clearance_m, demand))
    }

    /// Adds a leg that the chart confirms, in two parts where its geodesic bows too far.
    fn confirm(
        &self,
        from: Point,
        to: Point,
        halvings: u32,
        legs: &mut Vec<RouteLeg>,
    ) -> Result<(), Refusal> {
        let (start, end, worst) = self.worst(from, to);
        if !worst.navigable {
            if halvings == 0 || from.distance_m(to) < obstacles::LONGEST_SIDE_M {
                let at = format!("{:.6}, {:.6}", worst.at.lat_deg(), worst.at.lon_deg());
                return Err(Refusal::NotConfirmed { at });
            }
            let middle = from.towards(to, 0.5);
            self.confirm(from, middle, halvings - 1, legs)?;
            return self.confirm(middle, to, halvings - 1, legs);
        }
        if !self.room.keeps_to_zones(from, to) {
            let at = format!("{:.6}, {:.6}", start.lat_deg(), start.lon_deg());
            return Err(Refusal::NotConfirmed { at });
        }
        let clearance_m = self.room.clearance(from, to, FAR_M).map(|(clearance_m, _)| clearance_m);
        legs.push(RouteLeg {
            from: start,
            to: end,
            length_m: Leg { from: start, to: end }.length_m(),
            worst,
            clearance_m,
            turn: None,
        });
        Ok(())
    }
}
