//! Which smaller demands would give a route where what was asked for gives none, and what is in the way.
//!
//! What parts the ends is found among the chart's lines themselves ([`Walls`]): up to which depth they leave a way, and how
//! narrow its narrowest gap is. A figure is given only if the chart confirms a way for it, leg by leg: one along a lead between
//! those lines ([`lead`]) with as much clearance as prepared water ever keeps, so that a route is found there, or the route in water
//! that was prepared for it. As little is prepared as holds a way by those lines.

use crate::Cancel;
use crate::lead::{Lead, lead};
use crate::needs::Needs;
use crate::obstacles::{SLACK_M, cut_out_m, least_cut_out_m};
use crate::plane::Point;
use crate::refusal::Refusal;
use crate::region::Region;
use crate::room::{PlanError, SeaRoom};
use crate::route::{Question, Request, Route};
use crate::side::{Gap, Kind, Reach, Trouble};
use crate::tile::{Grid, Tile, Tiles};
use crate::walls::{Lines, Walls};
use crate::zones::Zones;
use charts::depth_index::{Demand, DepthIndex, EntryRules, Leg};
use std::cell::Cell;
use std::collections::BTreeSet;
use std::sync::Arc;
use units::LatLon;

/// So many depths are tried, from the greatest that may do.
const DEPTH_TRIALS: usize = 4;
/// Shares of the measured clearance that are tried.
const CLEARANCE_TRIALS: [f64; 5] = [1.0, 0.95, 0.8, 0.5, 0.0];
/// Lines are thinned by this share of the reach, by no less than this (m), and by so many times more where too many lie near
/// each other.
const THINNED: f64 = 0.005;
const LEAST_THINNED_M: f64 = 0.3;
const COARSER: f64 = 5.0;
/// Lines thinned by more than this share of the reach say little.
const COARSEST: f64 = 0.25;
/// Along a way that may be one, water is prepared so many times the reach to both sides, in tiles of so many times the reach and
/// no smaller than this (m).
const BESIDE: f64 = 2.0;
const TILE: f64 = 6.0;
const LEAST_TILE_M: f64 = 400.0;
/// Water is prepared along a lead only if that is at most this share of the region.
const LITTLE: f64 = 0.3;
/// A way from where an end is moved to is taken for one from where it was asked for up to so far (m).
const MOVED_M: f64 = 300.0;
/// Water is prepared so far around the ends at least (m).
const AROUND_M: f64 = 300.0;

/// Smaller demands that give a route.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Passable {
    /// The greatest least depth (m), in tenths; `None` if none was found.
    pub depth_m: Option<f64>,
    /// Where the way of that depth is shallowest.
    pub shallowest: Option<LatLon>,
    /// The greatest clearance (m), in whole metres or, below 10 m, tenths; `None` if none was found.
    pub clearance_m: Option<f64>,
    /// Where the way of that clearance is narrowest.
    pub gap: Option<PassableGap>,
    /// There is one through areas whose entry is prohibited or restricted: the rule of entry alone refuses it.
    pub by_rule_alone: bool,
    /// There is one outside the allowed zone or through forbidden ones: they alone are in the way.
    pub by_zones_alone: bool,
    /// Smaller demands were not looked for: the charts around the ends are too much for that.
    pub not_looked: bool,
}

/// A gap between what a way has to keep clear of.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PassableGap {
    /// Its middle.
    pub at: LatLon,
    /// How wide it is (m).
    pub width_m: f64,
}

/// A way that was confirmed for smaller demands.
struct Found {
    /// Where it is shallowest.
    shallowest: Option<LatLon>,
}

/// A search for smaller demands.
pub(crate) struct Search<'a> {
    room: &'a SeaRoom,
    index: &'a DepthIndex,
    request: &'a Request,
    cancel: &'a Cancel<'a>,
    /// Start and goal; several where each may be moved to several pieces of water.
    ends: Vec<[Point; 2]>,
    /// One of them does not stand where it was asked for.
    moved: bool,
    lines: Lines,
    wider_m: f64,
    /// By how much the walls may lie beside the chart's lines (m).
    thinned_m: f64,
    walls: Walls,
    /// Walls of fewer sides, which lie up to `coarse_m` beside the others.
    coarse: Walls,
    coarse_m: f64,
}

impl<'a> Search<'a> {
    /// In the water that was prepared for what was asked; `None` if an end is closed.
    pub(crate) fn new(
        room: &'a SeaRoom,
        index: &'a DepthIndex,
        request: &'a Request,
        cancel: &'a Cancel<'a>,
    ) -> Option<Self> {
        let ends = Question { room, index, request, wish: None, cancel }.ends()?;
        let asked = [request.from, request.to].map(|place| room.plane().point(place));
        let moved = ends.len() > 1 || ends[0] != asked;
        let (chart, wider_m) = room.closing_lines(index);
        let thinned_m = (THINNED * room.cut_m()).max(LEAST_THINNED_M);
        let lines = room.lines(&chart, thinned_m);
        let walls = Walls::new(room.region, &lines, (0.0, thinned_m));
        let coarse_m = COARSER * thinned_m;
        let coarse = Walls::new(room.region, &lines, (coarse_m, coarse_m));
        // Lines lie up to that beside the others, and short sides up to as much again.
        let coarse_m = 2.0 * coarse_m;
        Some(Self {
            room,
            index,
            request,
            cancel,
            ends,
            moved,
            lines,
            wider_m,
            thinned_m,
            walls,
            coarse,
            coarse_m,
        })
    }

    pub(crate) fn answer(mut self) -> Result<Passable, PlanError> {
        let mut passable = Passable::default();
        if let Some((depth_m, Found { shallowest })) = self.depth()? {
            (passable.depth_m, passable.shallowest) = (Some(depth_m), shallowest);
        }
        if let Some((clearance_m, gap)) = self.clearance()? {
            (passable.clearance_m, passable.gap) = (Some(clearance_m), gap);
        }
        let Needs { demand, .. } = *self.room.needs();
        if demand.entry.refuse_any() && self.walls.has(Kind::Rule) {
            let needs =
                Needs { demand: Demand { entry: EntryRules::IGNORE, ..demand }, ..*self.room.needs() };
            let walls = self.walls.without(Kind::Rule);
            passable.by_rule_alone = self.confirmed((&needs, self.room.zones()), &walls, None)?.is_some();
        }
        if self.walls.has(Kind::Zone) {
            let walls = self.walls.without(Kind::Zone);
            passable.by_zones_alone =
                self.confirmed((self.room.needs(), &Arc::default()), &walls, None)?.is_some();
        }
        Ok(passable)
    }

    /// The greatest least depth below the one demanded that gives a route, in tenths.
    fn depth(&mut self) -> Result<Option<(f64, Found)>, PlanError> {
        let (needs, reach) = (*self.room.needs(), self.reach(self.room.needs(), self.room.zones()));
        let parted = self.of_all_ends(|walls, _, ends, cancel| walls.parted_below_m(ends, reach, cancel))?;
        let wanted_m = needs.demand.needed_m();
        // Where nothing parts them by the lines, one step less than asked is the first that may do.
        let most_m = parted.into_iter().map(|depth_m| depth_m.unwrap_or(wanted_m)).fold(f64::MIN, f64::max);
        let mut depths_m: Vec<f64> =
            self.walls.depths_m().filter(|depth_m| *depth_m <= most_m).map(tenths).collect();
        depths_m.dedup();
        depths_m.retain(|depth_m| (0.0..wanted_m).contains(depth_m));
        for depth_m in depths_m.into_iter().rev().take(DEPTH_TRIALS) {
            let demand = Demand { draught_m: depth_m, squat_m: 0.0, reserve_m: 0.0, ..needs.demand };
            let needs = Needs { demand, ..needs };
            if let Some(found) = self.confirmed((&needs, self.room.zones()), &self.walls, None)? {
                return Ok(Some((depth_m, found)));
            }
        }
        Ok(None)
    }

    /// The greatest clearance below the one demanded that gives a route, and the gap that allows no more.
    fn clearance(&mut self) -> Result<Option<(f64, Option<PassableGap>)>, PlanError> {
        let (needs, most) = (*self.room.needs(), self.reach(self.room.needs(), self.room.zones()));
        let least = self.reach(&Needs { clearance_m: 0.0, ..needs }, self.room.zones());
        let widest_m = Cell::new(least.chart_m);
        let gaps = self.of_all_ends(|walls, coarse, ends, cancel| {
            // Other places for the ends count only where they leave a wider way.
            let at = Reach { chart_m: widest_m.get(), ..most };
            if at != least && walls.parted_below_m(ends, at, cancel)?.is_some() {
                return Ok(Some(Gap::shut(ends[0])));
            }
            let gap = walls.widest_gap(coarse, ends, (least, most), cancel)?;
            widest_m.set(gap.map_or(most.chart_m, |gap| gap.reach_m).max(widest_m.get()));
            Ok(gap)
        })?;
        let reach_m = |gap: &Option<Gap>| gap.map_or(most.chart_m, |gap| gap.reach_m);
        let widest = gaps.into_iter().max_by(|one, other| reach_m(one).total_cmp(&reach_m(other)));
        let Some(widest) = widest.filter(|gap| reach_m(gap) > least.chart_m) else { return Ok(None) };
        let most_m = self.clearance_of(reach_m(&widest) - self.thinned_m, &needs);
        let gap =
            widest.map(|gap| PassableGap { at: self.room.plane().place(gap.middle()), width_m: gap.width_m });
        let mut tried_m = needs.clearance_m;
        for share in CLEARANCE_TRIALS {
            let clearance_m = presentable(share * most_m);
            if clearance_m >= tried_m {
                continue;
            }
            tried_m = clearance_m;
            let needs = Needs { clearance_m, ..needs };
            if self.confirmed((&needs, self.room.zones()), &self.walls, widest)?.is_some() {
                return Ok(Some((clearance_m, gap)));
            }
        }
        Ok(None)
    }

    /// What the walls say for each pair of ends; of lines that are thinned more where too many lie near each other, and of
    /// none at all where that says nothing.
    fn of_all_ends<T>(
        &mut self,
        ask: impl Fn(&Walls, (&Walls, f64), [Point; 2], &Cancel<'_>) -> Result<T, Trouble>,
    ) -> Result<Vec<T>, PlanError> {
        loop {
            let coarse = (&self.coarse, self.coarse_m);
            let all: Result<Vec<T>, Trouble> =
                self.ends.iter().map(|ends| ask(&self.walls, coarse, *ends, self.cancel)).collect();
            match all {
                Ok(all) => return Ok(all),
                Err(Trouble::Plan(error)) => return Err(error),
                Err(Trouble::TooMany) => self.thinned_m *= COARSER,
            }
            if self.thinned_m > COARSEST * cut_out_m(self.room.cut_m()) {
                return Ok(Vec::new());
            }
            self.walls = Walls::new(self.room.region, &self.lines, (self.thinned_m, self.thinned_m));
            self.coarse_m = self.coarse_m.max(COARSER * self.thinned_m);
        }
    }

    /// How far from lines nothing is open for these needs: no more than is cut out, so that what parts the ends does.
    fn reach(&self, needs: &Needs, zones: &Zones) -> Reach {
        Reach {
            chart_m: least_cut_out_m(needs.reach_m() + self.wider_m),
            zone_m: least_cut_out_m(zones.margin_m()),
        }
    }

    /// The greatest clearance (m), up to the one asked for, for which no more is cut out than this; it grows evenly, by at
    /// least the clearance.
    fn clearance_of(&self, cut_m: f64, needs: &Needs) -> f64 {
        let (mut least_m, mut most_m) = (0.0, needs.clearance_m);
        for _ in 0..40 {
            let middle_m = f64::midpoint(least_m, most_m);
            let needs = Needs { clearance_m: middle_m, ..*needs };
            if cut_out_m(needs.reach_m() + self.wider_m) <= cut_m {
                least_m = middle_m;
            } else {
                most_m = middle_m;
            }
        }
        least_m
    }

    /// A route for these needs, confirmed by the chart, in the smallest region of some that has one by those walls.
    fn confirmed(
        &self,
        (needs, zones): (&Needs, &Arc<Zones>),
        walls: &Walls,
        gap: Option<Gap>,
    ) -> Result<Option<Found>, PlanError> {
        let cancel = self.cancel;
        let (reach, depth_m) = (self.reach(needs, zones), needs.demand.needed_m());
        for region in self.regions(reach) {
            let whole = region == self.room.region;
            let here = (!whole).then(|| walls.within(region, depth_m));
            let here = here.as_ref().unwrap_or(walls);
            let mut open = None;
            for ends in &self.ends {
                // In the whole the walls were asked already.
                let parted = if whole && std::ptr::eq(walls, &raw const self.walls) {
                    Ok(None)
                } else {
                    here.parted_below_m(*ends, reach, cancel)
                };
                match parted {
                    Ok(None) | Err(Trouble::TooMany) => open = open.or(Some(*ends)),
                    Ok(Some(_)) => {}
                    Err(Trouble::Plan(error)) => return Err(error),
                }
            }
            let Some(ends) = open else { continue };
            if let Some(lead) = lead(here, region, (ends, reach, depth_m), cancel)? {
                if let Some(found) = self.by_legs(&lead, (ends, gap), (needs, &**zones))? {
                    return Ok(Some(found));
                }
                let tiles = self.around(&lead, reach);
                // Each is cut out of what lies around it too.
                let side_m = tiles.grid.tile_m + 4.0 * reach.most_m();
                if side_m * side_m * tiles.tiles.len() as f64 <= LITTLE * region.area() {
                    let room = SeaRoom::of_tiles(self.index, (needs, zones), (&tiles, 0.0), cancel)?;
                    if let Some(found) = self.route_in(&room)? {
                        return Ok(Some(found));
                    }
                }
            }
            let Region { min, max } = region;
            let middle = self.room.plane().place(min.towards(max, 0.5));
            let halves_m = ((max.x - min.x) / 2.0, (max.y - min.y) / 2.0);
            let room = SeaRoom::around(self.index, (needs, zones), middle, halves_m, cancel)?;
            if let Some(found) = self.route_in(&room)? {
                return Ok(Some(found));
            }
        }
        Ok(None)
    }

    /// A way from one end to the other by open squares and through the middle of a gap, whose every leg the chart confirms for
    /// as much clearance as is cut out of prepared water at most: there a route is found then.
    ///
    /// Other water may move an end to another place. So the way must lead on to the place that was asked for, and that leg must be
    /// clear. It gives no answer where an end was moved far, or where zones close some of the water.
    fn by_legs(
        &self,
        lead: &Lead,
        (ends, gap): ([Point; 2], Option<Gap>),
        (needs, zones): (&Needs, &Zones),
    ) -> Result<Option<Found>, PlanError> {
        let plane = self.room.plane();
        let asked = self.asked();
        let moved_m = [0, 1].map(|end| ends[end].distance_m(asked[end]));
        if moved_m.into_iter().any(|moved_m| moved_m > MOVED_M) || !zones.borders(plane).is_empty() {
            return Ok(None);
        }
        let wide_m = needs.reach_m() + self.wider_m;
        let half_m = needs.clearance_m
            + self.wider_m
            + plane.scale(ends[0]).max(plane.scale(ends[1])) * (cut_out_m(wide_m) - wide_m)
            + SLACK_M;
        let way = points(lead, ends, gap);
        let mut points: Vec<Point> = [asked[0]].into_iter().chain(way).chain([asked[1]]).collect();
        points.dedup();
        let leg =
            |from: usize, to: usize| Leg { from: plane.place(points[from]), to: plane.place(points[to]) };
        let is_clear = |from: usize, to: usize| {
            self.index.shallowest_along(leg(from, to), half_m, &needs.demand).navigable
        };
        let (mut at, mut shallowest): (usize, Option<(f64, LatLon)>) = (0, None);
        while at + 1 < points.len() {
            self.cancel.check()?;
            let Some(next) = farthest(at, points.len() - 1, |to| is_clear(at, to)) else { return Ok(None) };
            let worst = self.index.shallowest_along(leg(at, next), needs.clearance_m, &needs.demand);
            if let Some(least_m) = worst.water.least_m()
                && shallowest.is_none_or(|(held_m, _)| least_m < held_m)
            {
                shallowest = Some((least_m, worst.at));
            }
            at = next;
        }
        Ok(Some(Found { shallowest: shallowest.map(|(_, at)| at) }))
    }

    /// Where start and goal were asked for.
    fn asked(&self) -> [Point; 2] {
        [self.request.from, self.request.to].map(|place| self.room.plane().point(place))
    }

    /// The route in water that was prepared for smaller demands, if there is one.
    fn route_in(&self, room: &SeaRoom) -> Result<Option<Found>, PlanError> {
        let Self { index, request, cancel, .. } = *self;
        match (Question { room, index, request, wish: None, cancel }).answer() {
            Ok(route) => Ok(Some(Found { shallowest: shallowest(&route) })),
            Err(Refusal::Plan(error)) => Err(error),
            Err(_) => Ok(None),
        }
    }

    /// The water along a way, and around the ends as far as these may be moved.
    fn around(&self, lead: &Lead, reach: Reach) -> Tiles {
        let beside_m = BESIDE * reach.most_m();
        let grid = Grid {
            middle: self.room.plane().middle(),
            tile_m: (TILE * reach.most_m()).max(LEAST_TILE_M).round(),
        };
        let near = |at: Point, by_m: f64| grid.tiles_in(Region { min: at, max: at }.wider(by_m));
        let mut tiles: BTreeSet<Tile> = lead.squares.iter().flat_map(|(at, _)| near(*at, beside_m)).collect();
        if self.moved {
            let asked = self.asked();
            let move_m = self.request.move_up_to_m + beside_m;
            tiles.extend(asked.into_iter().flat_map(|at| near(at, move_m)));
        }
        Tiles { grid, tiles: Arc::new(tiles) }
    }

    /// Regions around the ends, the smallest first; the last is that of the water that was prepared.
    fn regions(&self, reach: Reach) -> Vec<Region> {
        let whole = self.room.region;
        let all: Vec<Point> = self.ends.iter().flatten().copied().collect();
        let apart_m = self.ends[0][0].distance_m(self.ends[0][1]);
        // Ends that are moved may be moved elsewhere.
        let move_m = if self.moved { self.request.move_up_to_m } else { 0.0 };
        let least_m = move_m + 2.0 * reach.chart_m + AROUND_M;
        let around = |more_m: f64| Region::of(&all).wider(more_m).common(whole);
        let mut regions =
            vec![around(least_m), around(least_m + 0.3 * apart_m), around(2.0 * least_m + apart_m)];
        regions.dedup();
        // One that is nearly all of it saves nothing.
        regions.retain(|region| region.area() < 0.7 * whole.area());
        regions.push(whole);
        regions
    }
}

/// The open squares of a lead between its ends, and the way through a gap, at a right angle to it, in place of those near it.
fn points(lead: &Lead, ends: [Point; 2], gap: Option<Gap>) -> Vec<Point> {
    let mut points = vec![ends[0]];
    let near = gap.filter(|gap| gap.reach_m > 0.0).map(|gap| (gap.middle(), gap));
    let is_near = |at: Point| near.is_some_and(|(middle, gap)| at.distance_m(middle) <= gap.reach_m);
    let mut through = false;
    for (at, is_open) in &lead.squares {
        if let Some((middle, Gap { reach_m, between: [one, other], .. })) = near
            && is_near(*at)
        {
            if !through {
                let wide_m = one.distance_m(other).max(f64::MIN_POSITIVE);
                let (x, y) = ((one.y - other.y) / wide_m, (other.x - one.x) / wide_m);
                let beside = |by_m: f64| Point { x: middle.x + by_m * x, y: middle.y + by_m * y };
                let mut both = [beside(-0.5 * reach_m), beside(0.5 * reach_m)];
                // First that which the way comes to first.
                let before = points[points.len() - 1];
                if before.distance_m(both[1]) < before.distance_m(both[0]) {
                    both.swap(0, 1);
                }
                points.extend(both);
                through = true;
            }
        } else if *is_open {
            points.push(*at);
        }
    }
    points.push(ends[1]);
    points
}

/// The greatest number up to the last for which something holds, as far as that is found by doubling and halving; `None` if it
/// does not even hold for the next one.
fn farthest(at: usize, last: usize, holds: impl Fn(usize) -> bool) -> Option<usize> {
    if !holds(at + 1) {
        return None;
    }
    let (mut good, mut step) = (at + 1, 2);
    while good < last && holds((at + step).min(last)) {
        good = (at + step).min(last);
        step *= 2;
    }
    let mut bad = (at + step).min(last);
    while bad > good + 1 {
        let middle = usize::midpoint(good, bad);
        *(if holds(middle) { &mut good } else { &mut bad }) = middle;
    }
    Some(good)
}

/// Where a route is shallowest.
fn shallowest(route: &Route) -> Option<LatLon> {
    let depths_m = route.legs.iter().filter_map(|leg| Some((leg.worst.water.least_m()?, leg.worst.at)));
    depths_m.min_by(|one, other| one.0.total_cmp(&other.0)).map(|(_, at)| at)
}

/// Rounded down to tenths.
fn tenths(value: f64) -> f64 {
    (value * 10.0 + 1e-6).floor() / 10.0
}

/// Rounded down to what is said of it: whole metres, or tenths below 10 m.
fn presentable(value_m: f64) -> f64 {
    if value_m < 10.0 { tenths(value_m) } else { value_m.floor() }
}

#[cfg(test)]
mod tests {
    use super::*;
    use testkit::sea::{Ground, Sea};
    use units::{LocalFrame, LocalPoint};

    /// Two islands 110 m apart with the start to the south of them, and an islet beside it, so that it is moved for 60 m.
    fn found(islet_off_m: f64) -> Option<bool> {
        let middle = LatLon::from_deg(63.44, 10.35).unwrap();
        let at = |north_m, east_m| LocalPoint { north_m, east_m };
        let sea = Sea::new(middle, 2_000.0, 30.0)
            .with(Ground::Land, at(0.0, 1_055.0), 1_000.0, 4)
            .with(Ground::Land, at(0.0, -1_055.0), 1_000.0, 4)
            .with(Ground::Land, at(-1_000.0, 5.0 + islet_off_m), 5.0, 8);
        let index = sea.index();
        let place = |point| LocalFrame::new(middle).to_place(point);
        let request = Request {
            move_up_to_m: 400.0,
            ..Request::new(place(at(-1_000.0, 0.0)), place(at(1_000.0, 0.0)))
        };
        let needs = Needs::depth_and_clearance(5.0, 60.0);
        let cancel = Cancel::never();
        let halves_m = (2_500.0, 2_500.0);
        let room = SeaRoom::around(&index, (&needs, &Arc::default()), middle, halves_m, &cancel).unwrap();
        let search = Search::new(&room, &index, &request, &cancel)?;
        assert!(search.moved, "the islet is nearer than 60 m");
        let needs = Needs { clearance_m: 25.0, ..needs };
        let reach = search.reach(&needs, room.zones());
        let (ends, depth_m) = (search.ends[0], needs.demand.needed_m());
        let lead = lead(&search.walls, room.region, (ends, reach, depth_m), &cancel).unwrap()?;
        let by_legs = search.by_legs(&lead, (ends, None), (&needs, room.zones())).unwrap();
        Some(by_legs.is_some())
    }

    #[test]
    fn a_moved_end_is_confirmed_by_legs_where_the_asked_place_is_clear_for_less() {
        assert_eq!(found(45.0), Some(true), "with 25 m it is not moved any more");
        assert_eq!(found(15.0), Some(false), "with 25 m it is moved too, perhaps elsewhere");
    }
}
