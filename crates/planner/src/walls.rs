//! What parts two places: the chart's lines, each with the depth at which it closes, and how near each other they lie.
//!
//! Lines that are widened by the clearance and meet are one wall; two points are parted if a ring of walls has one of them
//! inside ([`Joining`]). Taken in the order of the depth at which they close, the first line that completes such a ring tells
//! the greatest depth that lets a vessel pass; taken in the order of the gaps between them, it tells the narrowest gap of the
//! widest way. Nothing is divided into triangles for this, so it answers in milliseconds what would else take many
//! preparations of the water.

use crate::Cancel;
use crate::joining::Joining;
use crate::obstacles::{project_line, thin};
use crate::plane::sides;
use crate::plane::{Plane, Point};
use crate::region::Region;
use crate::side::{Gap, Kind, Reach, Side, Trouble};
use charts::depth_index::{Closes, ClosingLine};
use std::collections::BTreeSet;

/// From one reach to a smaller one, where the widest way is looked for.
const HALF: f64 = 0.5;

/// Lines, in the order of the depths at which they close.
#[derive(Debug, Clone)]
pub(crate) struct Walls {
    region: Region,
    sides: Vec<Side>,
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
    pub(crate) fn widest_gap(
        &self,
        ends: [Point; 2],
        (least, most): (Reach, Reach),
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
                return Ok(Some(Gap { reach_m: 0.0, width_m: 0.0, at: ends[0] }));
            }
            (open, closed) = (at(HALF * open.chart_m), open);
        }
        // Lines in one square are surely joined where the two reaches differ by less than this.
        while closed.chart_m > std::f64::consts::SQRT_2 * open.chart_m {
            let middle = at((open.chart_m * closed.chart_m).sqrt());
            *(if parted(middle)? { &mut closed } else { &mut open }) = middle;
        }
        let joining = Joining::new(self.region, &self.sides, [open, closed], ends)?;
        Ok(joining.run(cancel)?.gap)
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
