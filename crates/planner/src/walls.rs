//! What parts two places: the chart's lines, each with the depth at which it closes, and how near each other they lie.
//!
//! Lines that are widened by the clearance and meet are one wall; two points are parted if a ring of walls has one of them
//! inside ([`Parts`]). Taken in the order of the depth at which they close, the first line that completes such a ring tells
//! the greatest depth that lets a vessel pass; taken in the order of the gaps between them, it tells the narrowest gap of the
//! widest way. Nothing is divided into triangles for this, so it answers in milliseconds what would else take many
//! preparations of the water.

use crate::boxes::Bounds;
use crate::nearby::Nearby;
use crate::obstacles::{Region, project_line, thin};
use crate::parts::Parts;
use crate::plane::{Plane, Point};
use crate::room::sides;
use crate::{Cancel, PlanError};
use charts::depth_index::{Closes, ClosingLine};
use std::collections::HashSet;

/// Sides are cut into pieces of so many times the greatest reach, and no shorter than so many metres.
const LONGEST: f64 = 20.0;
const SHORT_M: f64 = 500.0;
/// Sides between two looks at whether the answer is still wanted.
const SIDES_BETWEEN_LOOKS: usize = 1_024;
/// More pairs are too many to look at, or to lie near each other.
const MOST_LOOKED_AT: usize = 20_000_000;
const MOST_PAIRS: usize = 3_000_000;

/// What a line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Land, shallow water, a danger, the end of the chart.
    Chart,
    /// The border of an area that may not be entered.
    Rule,
    /// The border of a zone that people drew.
    Zone,
    /// The end of the region that is looked at.
    Edge,
}

/// How far from lines ways keep (m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reach {
    /// From what the chart has.
    pub(crate) chart_m: f64,
    /// From borders of zones.
    pub(crate) zone_m: f64,
}

impl Reach {
    fn of(&self, kind: Kind) -> f64 {
        match kind {
            Kind::Chart | Kind::Rule => self.chart_m,
            Kind::Zone => self.zone_m,
            Kind::Edge => 0.0,
        }
    }

    fn most_m(&self) -> f64 {
        self.chart_m.max(self.zone_m)
    }
}

/// A straight part of a line.
#[derive(Debug, Clone, Copy)]
struct Side {
    ends: [Point; 2],
    /// It is in the way where more depth is needed (m).
    deeper_than_m: f64,
    kind: Kind,
}

/// Lines, in the order of the depths at which they close.
#[derive(Debug, Clone)]
pub(crate) struct Walls {
    region: Region,
    sides: Vec<Side>,
}

/// Too many lines lie near each other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Trouble {
    TooMany,
    Plan(PlanError),
}

impl From<PlanError> for Trouble {
    fn from(error: PlanError) -> Self {
        Self::Plan(error)
    }
}

/// The narrowest gap of the widest way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gap {
    /// How far ways can keep from the chart's lines at most (m).
    pub(crate) reach_m: f64,
    pub(crate) width_m: f64,
    pub(crate) at: Point,
}

impl Walls {
    /// Lines of a chart and of zones in a region, thinned by so much (m).
    pub(crate) fn new(
        region: Region,
        plane: &Plane,
        lines: &[ClosingLine],
        zones: &[Vec<Point>],
        thinned_m: f64,
    ) -> Self {
        let mut walls = Self { region, sides: Vec::new() };
        for ClosingLine { vertices, closes } in lines {
            let (deeper_than_m, kind) = match closes {
                Closes::Always => (f64::NEG_INFINITY, Kind::Chart),
                Closes::ByRule => (f64::NEG_INFINITY, Kind::Rule),
                Closes::DeeperThan(depth_m) => (*depth_m, Kind::Chart),
            };
            for ends in sides(&thin(&project_line(vertices, plane), thinned_m)) {
                walls.sides.push(Side { ends, deeper_than_m, kind });
            }
        }
        let always = |kind: Kind| move |ends| Side { ends, deeper_than_m: f64::NEG_INFINITY, kind };
        walls.sides.extend(zones.iter().flat_map(|zone| sides(zone)).map(always(Kind::Zone)));
        walls.sides.sort_by(|one, other| one.deeper_than_m.total_cmp(&other.deeper_than_m));
        walls.thin_short(thinned_m);
        walls
    }

    /// Of sides that are shorter than the tolerance, and points, leaves one in each square of its size, the first to close.
    fn thin_short(&mut self, thinned_m: f64) {
        // Saturates far beyond any region.
        let square = |at: Point| ((at.x / thinned_m) as i32, (at.y / thinned_m) as i32);
        let mut taken = HashSet::new();
        self.sides.retain(|side| {
            let [a, b] = side.ends;
            a.distance_m(b) > thinned_m || taken.insert((square(a.towards(b, 0.5)), side.kind as u8))
        });
    }

    /// Those that are in the way of a vessel that needs so much depth (m), within a part of the region.
    pub(crate) fn within(&self, region: Region, depth_m: f64) -> Self {
        let sides = self.sides.iter().filter(|side| side.deeper_than_m < depth_m).copied().collect();
        Self { region, sides }
    }

    /// Without what rules or people close.
    pub(crate) fn without(&self, kind: Kind) -> Self {
        Self {
            region: self.region,
            sides: self.sides.iter().filter(|side| side.kind != kind).copied().collect(),
        }
    }

    pub(crate) fn has(&self, kind: Kind) -> bool {
        self.sides.iter().any(|side| side.kind == kind)
    }

    /// The depths (m) at which lines close, in order.
    pub(crate) fn depths_m(&self) -> impl DoubleEndedIterator<Item = f64> {
        self.sides.iter().map(|side| side.deeper_than_m).filter(|depth_m| depth_m.is_finite())
    }

    /// The least depth (m) that need not be exceeded for two points to be parted: minus infinity where they are at any
    /// depth, `None` where nothing parts them.
    pub(crate) fn parted_below_m(
        &self,
        ends: [Point; 2],
        reach: Reach,
        cancel: &Cancel<'_>,
    ) -> Result<Option<f64>, Trouble> {
        let sides = self.pieces(reach);
        let mut parts = Parts::new(sides.len());
        let parted = pairs(&sides, self.region, reach, cancel, |one, other, near| {
            let touch = near.width_m <= reach.of(sides[one].kind) + reach.of(sides[other].kind);
            touch && parts.join(one as u32, other as u32, near.crosses(ends, [&sides[one], &sides[other]]))
        })?;
        Ok(parted.map(|at| sides[at].deeper_than_m))
    }

    /// The narrowest gap of the widest way between two points, if it is narrower than this reach; `None` where nothing
    /// parts them, and a reach below the least one where even that is too much.
    pub(crate) fn widest_gap(
        &self,
        ends: [Point; 2],
        (least, most): (Reach, Reach),
        cancel: &Cancel<'_>,
    ) -> Result<Option<Gap>, Trouble> {
        let sides = self.pieces(most);
        let mut gaps: Vec<(f32, u32, u32)> = Vec::new();
        pairs(&sides, self.region, most, cancel, |one, other, near| {
            let kinds = [sides[one].kind, sides[other].kind];
            let reach_m = closes_at_m(kinds, near.width_m, most);
            if reach_m <= most.chart_m {
                // Within 20 km to the millimetre.
                gaps.push((reach_m.max(least.chart_m) as f32, one as u32, other as u32));
            }
            false
        })?;
        gaps.sort_unstable_by(|one, other| one.0.total_cmp(&other.0));
        let mut parts = Parts::new(sides.len());
        for (reach_m, one, other) in gaps {
            let pair = [&sides[one as usize], &sides[other as usize]];
            let near = Near::of(pair[0], pair[1]);
            if parts.join(one, other, near.crosses(ends, pair)) {
                let [from, to] = near.points;
                let reach_m = f64::from(reach_m);
                return Ok(Some(Gap { reach_m, width_m: near.width_m, at: from.towards(to, 0.5) }));
            }
        }
        Ok(None)
    }

    /// Sides that come into the region, long ones in pieces, and its edges.
    fn pieces(&self, reach: Reach) -> Vec<Side> {
        let Region { min, max } = self.region;
        let corners = [min, Point { x: max.x, y: min.y }, max, Point { x: min.x, y: max.y }, min];
        let longest_m = (LONGEST * reach.most_m()).max(SHORT_M);
        let near = self.region.wider(reach.most_m());
        let edge = |ends| Side { ends, deeper_than_m: f64::NEG_INFINITY, kind: Kind::Edge };
        let all = sides(&corners).map(edge).chain(self.sides.iter().copied());
        let mut pieces = Vec::with_capacity(self.sides.len() + 256);
        for side in all {
            let Some((a, b)) = near.clip(side.ends[0], side.ends[1]) else { continue };
            // A region is some thousand kilometres wide at most.
            let count = (a.distance_m(b) / longest_m).ceil().clamp(1.0, 1e5) as u32;
            let at = |piece: u32| a.towards(b, f64::from(piece) / f64::from(count));
            pieces.extend((0..count).map(|piece| Side { ends: [at(piece), at(piece + 1)], ..side }));
        }
        pieces
    }
}

/// From which reach on two lines with so much between them leave no way (m).
fn closes_at_m(kinds: [Kind; 2], width_m: f64, reach: Reach) -> f64 {
    let grows = |kind: Kind| matches!(kind, Kind::Chart | Kind::Rule);
    match kinds.map(grows) {
        [true, true] => width_m / 2.0,
        [true, false] => width_m - reach.of(kinds[1]),
        [false, true] => width_m - reach.of(kinds[0]),
        [false, false] if width_m <= reach.of(kinds[0]) + reach.of(kinds[1]) => 0.0,
        [false, false] => f64::INFINITY,
    }
}

/// Gives pairs of sides that may lie within twice the reach of each other, the later one of each growing; ends with the
/// number of the later one when told to.
fn pairs(
    sides: &[Side],
    region: Region,
    reach: Reach,
    cancel: &Cancel<'_>,
    mut give: impl FnMut(usize, usize, Near) -> bool,
) -> Result<Option<usize>, Trouble> {
    let within_m = 2.0 * reach.most_m();
    let mut nearby = Nearby::new(region.wider(reach.most_m()), within_m, sides.len());
    let (mut looked_at, mut found) = (0, 0);
    for (at, side) in sides.iter().enumerate() {
        if at % SIDES_BETWEEN_LOOKS == 0 {
            cancel.check()?;
        }
        let mut ends = false;
        let bounds = Bounds::of(&side.ends);
        nearby.visit(side.ends, within_m, |other| {
            looked_at += 1;
            if Bounds::of(&sides[other].ends).distance_m(&bounds) > within_m {
                return;
            }
            let near = Near::of(&sides[other], side);
            if near.width_m <= within_m {
                found += 1;
                ends |= give(other, at, near);
            }
        });
        if ends {
            return Ok(Some(at));
        }
        if looked_at > MOST_LOOKED_AT || found > MOST_PAIRS {
            return Err(Trouble::TooMany);
        }
        nearby.add(side.ends);
    }
    Ok(None)
}

/// How near two sides lie.
#[derive(Debug, Clone, Copy)]
struct Near {
    width_m: f64,
    /// The nearest points of both.
    points: [Point; 2],
}

impl Near {
    fn of(one: &Side, other: &Side) -> Self {
        let ([a, b], [c, d]) = (one.ends, other.ends);
        let (of_a, of_b) = (c.cross(d, a), c.cross(d, b));
        if of_a * of_b < 0.0 && a.cross(b, c) * a.cross(b, d) < 0.0 {
            let meet = a.towards(b, of_a / (of_a - of_b));
            return Self { width_m: 0.0, points: [meet, meet] };
        }
        let ways = [
            [a, a.nearest_on(c, d)],
            [b, b.nearest_on(c, d)],
            [c.nearest_on(a, b), c],
            [d.nearest_on(a, b), d],
        ];
        let [first, rest @ ..] = ways.map(|points| Self { width_m: points[0].distance_m(points[1]), points });
        rest.into_iter().fold(first, |best, one| if one.width_m < best.width_m { one } else { best })
    }

    /// Whether the way from the middle of one side to that of the other, by their nearest points, crosses the line between
    /// two points an odd number of times.
    fn crosses(&self, [from, to]: [Point; 2], [one, other]: [&Side; 2]) -> bool {
        let middle = |side: &Side| side.ends[0].towards(side.ends[1], 0.5);
        let way = [middle(one), self.points[0], self.points[1], middle(other)];
        let left = way.map(|at| from.cross(to, at) > 0.0);
        let crosses = |n: usize| {
            let (a, b) = (way[n], way[n + 1]);
            left[n] != left[n + 1] && (a.cross(b, from) > 0.0) != (a.cross(b, to) > 0.0)
        };
        (0..3).filter(|n| crosses(*n)).count() % 2 == 1
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(x: f64, y: f64) -> Point {
        Point { x, y }
    }

    /// A region of 2 km with a wall from south to north but for a gap of 60 m, and a bar across the gap 100 m behind.
    fn walls() -> Walls {
        let side = |ends, deeper_than_m, kind| Side { ends, deeper_than_m, kind };
        let land = f64::NEG_INFINITY;
        Walls {
            region: Region { min: at(-1_000.0, -1_000.0), max: at(1_000.0, 1_000.0) },
            sides: vec![
                side([at(0.0, -1_000.0), at(0.0, -30.0)], land, Kind::Chart),
                side([at(0.0, 30.0), at(0.0, 1_000.0)], land, Kind::Chart),
                side([at(100.0, -1_000.0), at(100.0, 1_000.0)], 3.4, Kind::Chart),
            ],
        }
    }

    const ENDS: [Point; 2] = [Point { x: -500.0, y: 300.0 }, Point { x: 500.0, y: -200.0 }];

    fn reach(chart_m: f64) -> Reach {
        Reach { chart_m, zone_m: 0.0 }
    }

    #[test]
    fn the_bar_tells_the_depth_and_the_gap_the_clearance() {
        let all = walls();
        let parted =
            |walls: &Walls, chart_m| walls.parted_below_m(ENDS, reach(chart_m), &Cancel::never()).unwrap();
        assert_eq!(parted(&all, 20.0), Some(3.4));
        assert_eq!(parted(&all, 31.0), Some(f64::NEG_INFINITY), "the gap is too narrow whatever the depth");
        let shallow = all.within(all.region, 3.4);
        assert_eq!(parted(&shallow, 29.0), None);
        let gap = shallow.widest_gap(ENDS, (reach(0.5), reach(80.0)), &Cancel::never()).unwrap().unwrap();
        assert!((gap.reach_m - 30.0).abs() < 1e-3 && (gap.width_m - 60.0).abs() < 1e-9, "{gap:?}");
        assert!(gap.at.distance_m(Point::default()) < 1e-6, "{gap:?}");
        assert_eq!(shallow.widest_gap(ENDS, (reach(0.5), reach(29.0)), &Cancel::never()).unwrap(), None);
        let away = [ENDS[0], at(-900.0, -900.0)];
        assert_eq!(all.parted_below_m(away, reach(31.0), &Cancel::never()).unwrap(), None);
    }

    #[test]
    fn a_ring_around_an_end_parts_and_what_is_beside_does_not() {
        let corner = |n: usize| {
            let (sin, cos) = (n as f64 / 12.0 * std::f64::consts::TAU).sin_cos();
            at(-500.0 + 100.0 * cos, 300.0 + 100.0 * sin)
        };
        let side =
            |n: usize| Side { ends: [corner(n), corner(n + 1)], deeper_than_m: n as f64, kind: Kind::Zone };
        let ring = Walls { sides: (0..12).map(side).collect(), ..walls() };
        assert_eq!(ring.parted_below_m(ENDS, reach(5.0), &Cancel::never()).unwrap(), Some(11.0));
        let open = ring.within(ring.region, 11.0);
        assert_eq!(open.parted_below_m(ENDS, reach(5.0), &Cancel::never()).unwrap(), None);
        let beside = [at(500.0, 500.0), at(600.0, 600.0)];
        assert_eq!(ring.parted_below_m(beside, reach(5.0), &Cancel::never()).unwrap(), None);
        assert!(!ring.without(Kind::Zone).has(Kind::Zone));
    }
}
