//! Areas with speed limits and of ordered traffic in a plane: where along a leg which limit holds, and what a metre counts.
//!
//! A limit begins at a line. Pieces of a leg that straddled it would count as wholly inside or wholly outside, and of two ways
//! that pass a slow area the worse one could seem better, so legs are cut where they cross a border.

use crate::boxes::Bounds;
use crate::plane::{self, Plane, Point};
use crate::traffic::{self, TrafficArea};
use crate::zones::Zone;

/// How far outside an area a way bends round its corner (m).
const OUTSIDE_M: f64 = 0.5;
/// Shorter parts of a leg have the limit of what is beside them: within the error of places and planes, a leg that only touches an
/// area is not in it, however strong the current is there against the limit (m).
const SLIVER_M: f64 = 1.0;

/// The areas of an objective, in one plane.
#[derive(Debug, Clone, Default)]
pub(crate) struct Limits(Vec<Area>);

#[derive(Debug, Clone)]
struct Area {
    /// Closed: the last point is the first.
    border: Vec<Point>,
    corners: Vec<Point>,
    bounds: Bounds,
    most_mps: f64,
    traffic: Option<Traffic>,
}

/// Ships that sail in order.
#[derive(Debug, Clone, Copy)]
struct Traffic {
    factor: f64,
    ahead: Option<Point>,
}

/// A part of a leg in which one limit holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Piece {
    pub(crate) begin: Point,
    pub(crate) end: Point,
    /// Greatest speed through the water (m/s); infinite without a limit.
    pub(crate) most_mps: f64,
    /// How many times as much it costs as it would without traffic.
    pub(crate) factor: f64,
}

impl Limits {
    /// Of zones, each with the greatest speed in it (m/s).
    pub(crate) fn new<'z>(zones: impl IntoIterator<Item = (&'z Zone, f64)>, plane: &Plane) -> Self {
        let area = |(zone, most_mps): (&Zone, f64)| Area::new(zone, plane, most_mps, None);
        Self(zones.into_iter().map(area).collect())
    }

    /// With areas of ordered traffic, in which everything costs so many times as much.
    pub(crate) fn with_traffic(mut self, areas: &[TrafficArea], factor: f64, plane: &Plane) -> Self {
        let area = |area: &TrafficArea| {
            let traffic = Traffic { factor, ahead: area.ahead(plane) };
            Area::new(&area.zone, plane, f64::INFINITY, Some(traffic))
        };
        self.0.extend(areas.iter().map(area));
        self
    }

    /// Points just outside the corners of all areas: ways that go round one bend there. At corners that lead inwards they are of
    /// no use, and do no harm.
    pub(crate) fn corners(&self) -> impl Iterator<Item = Point> {
        self.0.iter().flat_map(|area| {
            let middle = area.bounds.min.towards(area.bounds.max, 0.5);
            area.corners.iter().map(move |corner| {
                let from_middle_m = middle.distance_m(*corner).max(OUTSIDE_M);
                middle.towards(*corner, 1.0 + OUTSIDE_M / from_middle_m)
            })
        })
    }

    /// A leg in pieces of at most so many metres, cut where a limit begins or ends; one at least.
    pub(crate) fn pieces(
        &self,
        (from, to): (Point, Point),
        piece_m: f64,
    ) -> impl Iterator<Item = Piece> + use<> {
        self.stretches(from, to).into_iter().flat_map(move |Piece { begin, end, most_mps, factor }| {
            let count = (begin.distance_m(end) / piece_m).ceil().max(1.0);
            let at = move |piece: u32| begin.towards(end, f64::from(piece) / count);
            (0..count as u32).map(move |piece| Piece {
                begin: at(piece),
                end: at(piece + 1),
                most_mps,
                factor,
            })
        })
    }

    /// The longest parts of a leg in each of which one limit holds.
    fn stretches(&self, from: Point, to: Point) -> Vec<Piece> {
        let around = Bounds::of(&[from, to]);
        let near: Vec<&Area> = self.0.iter().filter(|area| area.bounds.meets(&around)).collect();
        if near.is_empty() {
            return vec![Piece { begin: from, end: to, most_mps: f64::INFINITY, factor: 1.0 }];
        }
        let mut cuts: Vec<f64> = near.iter().flat_map(|area| area.cuts(from, to)).collect();
        cuts.push(1.0);
        cuts.sort_by(f64::total_cmp);
        let mut begin = 0.0;
        let mut stretches: Vec<Piece> = Vec::with_capacity(cuts.len());
        let sliver = SLIVER_M / from.distance_m(to).max(f64::MIN_POSITIVE);
        for end in cuts {
            let is_rest = end >= 1.0 && stretches.is_empty();
            if end - begin > sliver || is_rest {
                let middle = from.towards(to, 0.5 * (begin + end));
                let (mut most_mps, mut factor) = (f64::INFINITY, 1.0_f64);
                for area in near.iter().filter(|area| area.holds(middle)) {
                    most_mps = most_mps.min(area.most_mps);
                    factor = factor.max(area.factor((from, to)));
                }
                let end_at = from.towards(to, end);
                let is_same = |last: &Piece| {
                    last.most_mps.total_cmp(&most_mps).is_eq() && last.factor.total_cmp(&factor).is_eq()
                };
                match stretches.last_mut() {
                    Some(last) if is_same(last) => last.end = end_at,
                    _ => {
                        let begin = from.towards(to, begin);
                        stretches.push(Piece { begin, end: end_at, most_mps, factor });
                    }
                }
                begin = end;
            }
        }
        if let Some(last) = stretches.last_mut() {
            last.end = to;
        }
        stretches
    }
}

impl Area {
    fn new(zone: &Zone, plane: &Plane, most_mps: f64, traffic: Option<Traffic>) -> Self {
        let border = zone.border(plane);
        let corners = zone.corners().iter().map(|corner| plane.point(*corner)).collect();
        Self { bounds: Bounds::of(&border), border, corners, most_mps, traffic }
    }

    /// How many times as much a leg costs in it as it would without its traffic.
    fn factor(&self, leg: (Point, Point)) -> f64 {
        self.traffic.map_or(1.0, |Traffic { factor, ahead }| traffic::factor(factor, ahead, leg))
    }

    /// Shares of a leg at which it crosses the border.
    fn cuts(&self, from: Point, to: Point) -> impl Iterator<Item = f64> {
        plane::sides(&self.border).filter_map(move |side| crossing([from, to], side))
    }

    fn holds(&self, at: Point) -> bool {
        if !self.bounds.contains(at) {
            return false;
        }
        // A ray to the east crosses the border an odd number of times from inside.
        let crosses = |[one, other]: [Point; 2]| {
            (one.y > at.y) != (other.y > at.y)
                && one.x + (other.x - one.x) * (at.y - one.y) / (other.y - one.y) > at.x
        };
        plane::sides(&self.border).filter(|side| crosses(*side)).count() % 2 == 1
    }
}

/// The share of the first line at which it crosses the second; `None` also where they lie along each other.
fn crossing([a, b]: [Point; 2], [c, d]: [Point; 2]) -> Option<f64> {
    let (of_a, of_b) = (c.cross(d, a), c.cross(d, b));
    (of_a * of_b < 0.0 && a.cross(b, c) * a.cross(b, d) <= 0.0).then(|| of_a / (of_a - of_b))
}

#[cfg(test)]
mod tests {
    use super::*;
    use units::LatLon;

    fn point(x: f64, y: f64) -> Point {
        Point { x, y }
    }

    /// Two squares of 100 m that overlap by 50 m, the second one slower.
    fn limits() -> Limits {
        let plane = Plane::new(LatLon::from_deg(63.4, 10.4).unwrap());
        let square = |west_m: f64| {
            let corners = [(0.0, 0.0), (100.0, 0.0), (100.0, 100.0), (0.0, 100.0)];
            Zone::new(corners.map(|(x, y)| plane.place(point(west_m + x, y))).to_vec()).unwrap()
        };
        let areas = [(square(0.0), 1.0), (square(50.0), 0.5)];
        Limits::new(areas.iter().map(|(zone, most_mps)| (zone, *most_mps)), &plane)
    }

    #[test]
    fn a_leg_is_cut_where_limits_begin_and_end() {
        let found = limits().stretches(point(-50.0, 40.0), point(250.0, 40.0));
        let ends = found.iter().map(|one| (one.end.x.round(), one.most_mps)).collect::<Vec<_>>();
        assert_eq!(ends, [(0.0, f64::INFINITY), (50.0, 1.0), (150.0, 0.5), (250.0, f64::INFINITY)]);
    }

    #[test]
    fn pieces_are_not_longer_than_asked_and_follow_each_other() {
        let ends = (point(-50.0, 40.0), point(250.0, 70.0));
        let found: Vec<Piece> = limits().pieces(ends, 30.0).collect();
        assert!(found.iter().all(|one| one.begin.distance_m(one.end) <= 30.0 + 1e-9));
        assert!(found.windows(2).all(|pair| pair[0].end.distance_m(pair[1].begin) < 1e-9));
        assert_eq!(found[0].begin, ends.0);
        assert!(found[found.len() - 1].end.distance_m(ends.1) < 1e-9);
    }

    #[test]
    fn a_leg_that_touches_a_corner_is_not_in_the_area() {
        // Half a metre within the first square, at its south-western corner.
        let found = limits().stretches(point(-50.0, 50.35), point(50.35, -50.0));
        assert_eq!(found.iter().map(|one| one.most_mps).collect::<Vec<_>>(), [f64::INFINITY]);
        let found = limits().stretches(point(-50.0, 52.0), point(52.0, -50.0));
        assert_eq!(
            found.iter().map(|one| one.most_mps).collect::<Vec<_>>(),
            [f64::INFINITY, 1.0, f64::INFINITY]
        );
    }

    #[test]
    fn a_leg_along_a_border_or_without_length_has_one_limit() {
        for ends in [(point(-50.0, -1.0), point(250.0, -1.0)), (point(20.0, 20.0), point(20.0, 20.0))] {
            assert_eq!(limits().pieces(ends, 1e9).count(), 1, "{ends:?}");
        }
    }
}
