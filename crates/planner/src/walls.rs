//! What parts two places: the chart's lines, each with the depth at which it closes, and how near each other they lie.
//!
//! Lines that are widened by the clearance and meet are one wall; two points are parted if a ring of walls has one of them
//! inside ([`Joining`]). Taken in the order of the depth at which they close, the first line that completes such a ring tells
//! the greatest depth that lets a vessel pass; taken in the order of the gaps between them, it tells the narrowest gap of the
//! widest way. Nothing is divided into triangles for this, so it answers in milliseconds what would else take many
//! preparations of the water.

use crate::Cancel;
use crate::joining::{Joining, Outcome};
use crate::obstacles::{project_line, thin};
use crate::plane::sides;
use crate::plane::{Plane, Point};
use crate::region::Region;
use crate::side::{Gap, Kind, Reach, Side, Trouble};
use charts::depth_index::{Closes, ClosingLine};
use std::collections::BTreeSet;

/// Lines in one square are surely joined where two reaches differ by no more than this factor.
const JOINED: f64 = std::f64::consts::SQRT_2;
/// Walls that lie so much beside others say nothing of reaches of no more than so many times that.
const LEAST_COARSE: f64 = 4.0;
/// From one reach to a smaller one, where the widest way is looked for.
const HALF: f64 = 0.5;

/// All lines of a chart and of zones in a plane, thinned.
#[derive(Debug, Clone)]
pub(crate) struct Lines(Vec<Line>);

#[derive(Debug, Clone)]
struct Line {
    points: Vec<Point>,
    deeper_than_m: f64,
    kind: Kind,
}

impl Lines {
    /// Of a chart and of zones, thinned by so much (m).
    pub(crate) fn new(plane: &Plane, chart: &[ClosingLine], zones: &[Vec<Point>], thinned_m: f64) -> Self {
        let of_chart = chart.iter().map(|ClosingLine { vertices, closes }| {
            let (deeper_than_m, kind) = match closes {
                Closes::Always => (f64::NEG_INFINITY, Kind::Chart),
                Closes::ByRule => (f64::NEG_INFINITY, Kind::Rule),
                Closes::DeeperThan(depth_m) => (*depth_m, Kind::Chart),
            };
            Line { points: thin(&project_line(vertices, plane), thinned_m), deeper_than_m, kind }
        });
        let of_zones = zones.iter().map(|zone| Line {
            points: zone.clone(),
            deeper_than_m: f64::NEG_INFINITY,
            kind: Kind::Zone,
        });
        Self(of_chart.chain(of_zones).collect())
    }
}

/// Lines, in the order of the depths at which they close.
#[derive(Debug, Clone)]
pub(crate) struct Walls {
    region: Region,
    sides: Vec<Side>,
}

impl Walls {
    /// Lines in a region, thinned by so much more (m), and of sides that are shorter than this (m) one in each square of that
    /// size.
    pub(crate) fn new(region: Region, lines: &Lines, (more_m, short_m): (f64, f64)) -> Self {
        let mut walls = Self { region, sides: Vec::new() };
        for Line { points, deeper_than_m, kind } in &lines.0 {
            let thinned = (more_m > 0.0 && *kind != Kind::Zone).then(|| thin(points, more_m));
            let points = thinned.as_ref().unwrap_or(points);
            let side = |ends| Side { ends, deeper_than_m: *deeper_than_m, kind: *kind };
            walls.sides.extend(sides(points).map(side));
        }
        walls.sides.sort_by(|one, other| one.deeper_than_m.total_cmp(&other.deeper_than_m));
        walls.thin_short(short_m);
        walls
    }

    /// Of sides that are shorter than the tolerance, and points, leaves one in each square of its size, the first to close.
    fn thin_short(&mut self, thinned_m: f64) {
        // Saturates far beyond any region.
        let square = |at: Point| ((at.x / thinned_m) as i32, (at.y / thinned_m) as i32);
        let mut taken = BTreeSet::new();
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

    /// The sides that are in the way of a vessel that needs so much depth (m).
    pub(crate) fn closing(&self, depth_m: f64) -> impl Iterator<Item = &Side> {
        self.sides.iter().filter(move |side| side.deeper_than_m < depth_m)
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
        let joining = Joining::new(self.region, &self.sides, [reach, reach], ends)?;
        Ok(joining.run(cancel)?.parted_at_m)
    }

    /// The narrowest gap of the widest way between two points, if it is narrower than this reach; `None` where nothing
    /// parts them, and a reach of no more than the least one where even that is too much.
    ///
    /// Between which reaches that gap closes is found by walls that are thinned more, and so lie up to `off_m` beside these.
    pub(crate) fn widest_gap(
        &self,
        (coarse, off_m): (&Self, f64),
        ends: [Point; 2],
        (least, most): (Reach, Reach),
        cancel: &Cancel<'_>,
    ) -> Result<Option<Gap>, Trouble> {
        let at = |chart_m: f64| Reach { chart_m: chart_m.max(least.chart_m), ..most };
        let parted = |reach: Reach| coarse.parted_below_m(ends, reach, cancel).map(|parted| parted.is_some());
        let (mut open, mut closed) = (at(HALF * most.chart_m), most);
        while parted(open)? {
            if open.chart_m <= LEAST_COARSE * off_m || open == least {
                // What is narrower is told by these walls alone; where no clearance gives a way, that is soon said.
                let shut = Gap::shut(ends[0]);
                return match self.parted_below_m(ends, least, cancel)? {
                    Some(_) => Ok(Some(shut)),
                    None => self.narrowest(ends, least, most, cancel),
                };
            }
            (open, closed) = (at(HALF * open.chart_m), open);
        }
        let enough = |open: Reach, closed: Reach| closed.chart_m + off_m <= JOINED * (open.chart_m - off_m);
        while !enough(open, closed) && closed.chart_m - open.chart_m > off_m {
            let middle = at((open.chart_m * closed.chart_m).sqrt());
            *(if parted(middle)? { &mut closed } else { &mut open }) = middle;
        }
        let (open, closed) = (at(open.chart_m - off_m), Reach { chart_m: closed.chart_m + off_m, ..closed });
        let joining = Joining::new(self.region, &self.sides, [open, closed], ends)?;
        match joining.run(cancel)? {
            Outcome { gap: None, parted_at_m: None } if closed.chart_m >= most.chart_m => Ok(None),
            Outcome { gap: Some(gap), .. } => Ok(Some(gap).filter(|gap| gap.reach_m < most.chart_m)),
            Outcome { .. } => self.narrowest(ends, least, most, cancel),
        }
    }

    /// The same by these walls alone, where others would mislead.
    fn narrowest(
        &self,
        ends: [Point; 2],
        least: Reach,
        most: Reach,
        cancel: &Cancel<'_>,
    ) -> Result<Option<Gap>, Trouble> {
        let at = |chart_m: f64| Reach { chart_m: chart_m.max(least.chart_m), ..most };
        let parted = |reach: Reach| self.parted_below_m(ends, reach, cancel).map(|parted| parted.is_some());
        if !parted(most)? {
            return Ok(None);
        }
        let (mut open, mut closed) = (at(HALF * most.chart_m), most);
        while parted(open)? {
            if open == least {
                return Ok(Some(Gap::shut(ends[0])));
            }
            (open, closed) = (at(HALF * open.chart_m), open);
        }
        while closed.chart_m > JOINED * open.chart_m {
            let middle = at((open.chart_m * closed.chart_m).sqrt());
            *(if parted(middle)? { &mut closed } else { &mut open }) = middle;
        }
        let joining = Joining::new(self.region, &self.sides, [open, closed], ends)?;
        Ok(joining.run(cancel)?.gap)
    }
}

#[cfg(test)]
impl Walls {
    pub(crate) fn of_sides(region: Region, sides: Vec<Side>) -> Self {
        Self { region, sides }
    }

    pub(crate) fn region(&self) -> Region {
        self.region
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
        let gap = shallow
            .widest_gap((&shallow, 0.0), ENDS, (reach(0.5), reach(80.0)), &Cancel::never())
            .unwrap()
            .unwrap();
        assert!((gap.reach_m - 30.0).abs() < 1e-3 && (gap.width_m - 60.0).abs() < 1e-9, "{gap:?}");
        assert!(gap.middle().distance_m(Point::default()) < 1e-6, "{gap:?}");
        assert_eq!(
            shallow.widest_gap((&shallow, 0.0), ENDS, (reach(0.5), reach(29.0)), &Cancel::never()).unwrap(),
            None
        );
        let away = [ENDS[0], at(-900.0, -900.0)];
        assert_eq!(all.parted_below_m(away, reach(31.0), &Cancel::never()).unwrap(), None);
    }

    #[test]
    fn coarser_walls_only_say_where_to_look() {
        let all = walls();
        let shallow = all.within(all.region, 3.4);
        // The gap of 60 m is 52, 68 m or shut in walls that lie 4 m or more beside these.
        let with_gap = |half_m: f64| {
            let mut other = shallow.clone();
            other.sides[0].ends[1].y = -half_m;
            other.sides[1].ends[0].y = half_m;
            other
        };
        for (half_m, off_m) in [(26.0, 4.0), (34.0, 4.0), (0.0, 4.0), (0.0, 30.0), (100.0, 4.0)] {
            let gap = shallow.widest_gap(
                (&with_gap(half_m), off_m),
                ENDS,
                (reach(0.5), reach(80.0)),
                &Cancel::never(),
            );
            let gap = gap.unwrap().unwrap();
            assert!((gap.reach_m - 30.0).abs() < 1e-3, "{half_m} {off_m} {gap:?}");
        }
        let shut = with_gap(0.0);
        let gap = shut.widest_gap((&shallow, 30.0), ENDS, (reach(0.5), reach(80.0)), &Cancel::never());
        assert!(gap.unwrap().unwrap().reach_m <= 0.5, "shut, whatever coarser walls say");
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
