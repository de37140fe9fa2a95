//! From barriers to the water that keeps clear of them.
//!
//! Each line is thinned within a tolerance, widened to what lies within clearance and tolerance of it, and cut out of
//! the region: what is left are pieces of open water and of closed ground, which the chart tells apart. Circles become
//! polygons around them, never inside, so that the result keeps at least as far off as was asked.

use crate::outermost::Outermost;
use crate::plane::{Plane, Point};
use crate::region::Region;
use crate::{Cancel, PlanError};
use charts::coverage::{Vertex, degrees};
use i_overlay::core::fill_rule::FillRule;
use i_overlay::core::overlay::{Overlay, ShapeType};
use i_overlay::core::overlay_rule::OverlayRule;
use i_overlay::i_float::int::point::IntPoint;
use std::collections::BTreeMap;

/// Cuts are made on a grid of centimetres, which covers ±5,000 km in 30 bits.
const PER_METRE: f64 = 100.0;
/// Corners of the polygon around a circle, and around one of less than a metre.
const CORNERS: usize = 24;
const FEW_CORNERS: usize = 8;
const SMALL_M: f64 = 1.0;
/// What the depth index takes a corridor wider than asked for rounding and the bow of geodesics, twice over, and the
/// rounding to the grid here (m).
pub(crate) const SLACK_M: f64 = 0.3;
/// Sides of the chart are straight in longitude and latitude; in pieces so long they bow by 4 cm at 63° (m).
pub(crate) const LONGEST_SIDE_M: f64 = 1_000.0;
/// Lines are thinned by this share of the clearance, but within these bounds (m).
const THINNED: f64 = 0.02;
const LEAST_THINNED_M: f64 = 0.05;
const MOST_THINNED_M: f64 = 1.0;

/// For clearances from this on, sides that cannot lie at the edge of open water are left out (m).
const WIDE_M: f64 = 100.0;

/// So many corners of contours are cut out at a time: an overlay of all of a large region takes several times the memory, and where
/// contours lie over each other many times, several times as long.
const MOST_AT_ONCE: usize = 100_000;
/// Sides of a line between two looks at whether the answer is still wanted, and at how many corners wait.
const SIDES_BETWEEN_LOOKS: usize = 1_000;

/// A corner on the grid.
pub(crate) type GridPoint = [i32; 2];

/// Pieces of a region between barriers: each an outer ring and its holes, not closed by a repeated corner.
pub(crate) type Pieces = Vec<Vec<Vec<GridPoint>>>;

pub(crate) fn metres(at: GridPoint) -> Point {
    Point { x: f64::from(at[0]) / PER_METRE, y: f64::from(at[1]) / PER_METRE }
}

fn on_grid(at: Point) -> IntPoint<i32> {
    // Saturates beyond the region, which is within ±5,000 km.
    IntPoint::new((at.x * PER_METRE).round() as i32, (at.y * PER_METRE).round() as i32)
}

/// The lines of a chart in the plane, their long sides in pieces.
pub(crate) fn project(lines: &[Vec<Vertex>], plane: &Plane) -> Vec<Vec<Point>> {
    lines.iter().map(|line| project_line(line, plane)).collect()
}

pub(crate) fn project_line(line: &[Vertex], plane: &Plane) -> Vec<Point> {
    let at = |lon_deg: f64, lat_deg: f64| {
        units::LatLon::from_deg(lat_deg, lon_deg).map(|place| plane.point(place)).unwrap_or_default()
    };
    let mut points: Vec<Point> = Vec::with_capacity(line.len());
    let mut before = None;
    for vertex in line {
        let here = degrees(*vertex);
        let point = at(here.lon_deg, here.lat_deg);
        if let (Some(last), Some(from)) = (points.last().copied(), before) {
            let from: charts::s57::GeoPoint = from;
            let pieces = (last.distance_m(point) / LONGEST_SIDE_M).ceil().clamp(1.0, 100_000.0) as u32;
            for piece in 1..pieces {
                let share = f64::from(piece) / f64::from(pieces);
                points.push(at(
                    from.lon_deg + (here.lon_deg - from.lon_deg) * share,
                    from.lat_deg + (here.lat_deg - from.lat_deg) * share,
                ));
            }
        }
        points.push(point);
        before = Some(here);
    }
    points
}

/// How far at most from a line water is cut out for a clearance (m).
pub(crate) fn cut_out_m(clearance_m: f64) -> f64 {
    let brush = Brush::new(least_cut_out_m(clearance_m));
    brush.corners[0].distance_m(Point::default())
}

/// How far from a line water is cut out for a clearance at least (m).
pub(crate) fn least_cut_out_m(clearance_m: f64) -> f64 {
    clearance_m + thinned_m(clearance_m) + SLACK_M
}

/// By how much lines are thinned for a clearance (m).
fn thinned_m(clearance_m: f64) -> f64 {
    (clearance_m * THINNED).clamp(LEAST_THINNED_M, MOST_THINNED_M)
}

/// Lines, and how far from them water is to be kept (m).
#[derive(Debug, Clone, Copy)]
pub(crate) struct Cut<'a> {
    pub(crate) lines: &'a [Vec<Point>],
    pub(crate) clearance_m: f64,
    /// Clearances are on the sea, and grow with the scale of this plane at each line; `None` where they are of the plane itself.
    pub(crate) plane: Option<&'a Plane>,
    /// The chart itself calls closed what lies nearer to these lines than this (m), so that what they cut out may have holes
    /// in it; `None` of lines that are not the chart's.
    pub(crate) closed_m: Option<f64>,
}

impl Cut<'_> {
    /// The greatest scale at points, and so on straight lines between them, which are so far from the middle at most.
    fn scale(&self, points: &[Point]) -> f64 {
        let Some(plane) = self.plane else { return 1.0 };
        points.iter().map(|at| plane.scale(*at)).fold(1.0, f64::max)
    }

    /// Which sides are needed, where the clearance is wide; `None` where all of them may be.
    fn outermost(&self, near: Region, cancel: &Cancel<'_>) -> Result<Option<Outermost>, PlanError> {
        let Some(closed_m) = self.closed_m.filter(|closed_m| *closed_m >= WIDE_M) else { return Ok(None) };
        let thinned_m = thinned_m(self.clearance_m);
        let thinned: Vec<Vec<Point>> = self.lines.iter().map(|line| thin(line, thinned_m)).collect();
        cancel.check()?;
        let most_m = cut_out_m(self.clearance_m) * self.scale(&near.ring());
        // A thinned line lies up to the tolerance beside the chart's; the polygon around a circle reaches beyond the circle.
        Outermost::new(near, &thinned, (closed_m - thinned_m - SLACK_M, most_m), cancel)
    }
}

/// Cuts what lies too near lines out of a region.
pub(crate) fn cut_out(region: Region, cuts: &[Cut<'_>], cancel: &Cancel<'_>) -> Result<Pieces, PlanError> {
    let Region { min, max } = region;
    let corners = [min, Point { x: max.x, y: min.y }, max, Point { x: min.x, y: max.y }].map(on_grid);
    let mut open: Shapes = vec![vec![corners.to_vec()]];
    let mut overlay: Overlay<i32> = Overlay::new(0);
    let mut waiting = 0;
    let mut contour = Vec::new();
    for cut in cuts {
        let thinned_m = thinned_m(cut.clearance_m);
        let brush = Brush::new(cut.clearance_m + thinned_m + SLACK_M);
        let near = region.wider(2.0 * brush.radius_m + 10.0);
        let outermost = cut.outermost(near, cancel)?;
        let wanted = |a: Point, b: Point| outermost.as_ref().is_none_or(|outermost| outermost.needs(a, b));
        let scale = |a: Point, b: Point| cut.scale(&[a, b]);
        for line in cut.lines {
            let thinned = thin(line, thinned_m);
            for part in parts(&thinned) {
                cancel.check()?;
                brush.draw(part, (&near, &wanted, &scale), &mut contour, |contour| {
                    overlay.add_contour(contour, ShapeType::Clip);
                    waiting += contour.len();
                });
                if waiting > MOST_AT_ONCE {
                    open = without(open, std::mem::replace(&mut overlay, Overlay::new(0)));
                    waiting = 0;
                }
            }
        }
    }
    cancel.check()?;
    Ok(pieces(without(open, overlay)))
}

/// Parts of a line with so many sides at most, each from the end of the one before; of a point, itself.
fn parts(line: &[Point]) -> impl Iterator<Item = &[Point]> {
    let last = line.len().saturating_sub(1);
    let part = move |from: usize| &line[from..(from + SIDES_BETWEEN_LOOKS + 1).min(line.len())];
    (0..last.max(1)).step_by(SIDES_BETWEEN_LOOKS).map(part)
}

/// Pieces of tiles with sides of so many metres, each with the corners of its neighbours on common borders among its own: then
/// sides on both hands of a border are the same, and triangles of one piece lie beside those of the other.
///
/// So the water of many tiles becomes one without being cut again as a whole, which could not be called off.
pub(crate) fn matched(mut pieces: Pieces, tile_m: f64, cancel: &Cancel<'_>) -> Result<Pieces, PlanError> {
    // Tiles have sides of whole metres, up to some tens of kilometres.
    let tile = (tile_m * PER_METRE).round() as i32;
    // By border the places of corners along it: of borders from south to north, and from west to east.
    let mut along: [BTreeMap<i32, Vec<i32>>; 2] = Default::default();
    for [x, y] in pieces.iter().flatten().flatten() {
        if x % tile == 0 {
            along[0].entry(*x).or_default().push(*y);
        }
        if y % tile == 0 {
            along[1].entry(*y).or_default().push(*x);
        }
    }
    cancel.check()?;
    for places in along.iter_mut().flat_map(BTreeMap::values_mut) {
        places.sort_unstable();
        places.dedup();
    }
    for rings in &mut pieces {
        cancel.check()?;
        for ring in rings {
            *ring = with_corners(ring, &along);
        }
    }
    Ok(pieces)
}

/// A ring with the corners that lie on those of its sides that run along a border.
fn with_corners(ring: &[GridPoint], [columns, rows]: &[BTreeMap<i32, Vec<i32>>; 2]) -> Vec<GridPoint> {
    let mut all = Vec::with_capacity(ring.len());
    let next = ring.iter().cycle().skip(1);
    for (from, to) in ring.iter().zip(next) {
        all.push(*from);
        let (border, axis) = match (from[0] == to[0], from[1] == to[1]) {
            (true, false) => (columns.get(&from[0]), 1),
            (false, true) => (rows.get(&from[1]), 0),
            _ => (None, 0),
        };
        let Some(places) = border else { continue };
        let (least, most) = (from[axis].min(to[axis]), from[axis].max(to[axis]));
        let within = places.partition_point(|at| *at <= least)..places.partition_point(|at| *at < most);
        let begun = all.len();
        all.extend(places[within].iter().map(|at| {
            let mut corner = *from;
            corner[axis] = *at;
            corner
        }));
        if from[axis] > to[axis] {
            all[begun..].reverse();
        }
    }
    all
}

fn pieces(shapes: Shapes) -> Pieces {
    let ring = |ring: Vec<IntPoint<i32>>| ring.into_iter().map(|at| [at.x, at.y]).collect();
    shapes.into_iter().map(|piece| piece.into_iter().map(ring).collect()).collect()
}

/// Pieces, each an outer ring and its holes.
type Shapes = Vec<Vec<Vec<IntPoint<i32>>>>;

/// What is left of pieces when the contours of an overlay are cut out.
fn without(open: Shapes, mut overlay: Overlay<i32>) -> Shapes {
    open.iter().flatten().for_each(|ring| overlay.add_contour(ring, ShapeType::Subject));
    // The copies in the overlay are enough.
    drop(open);
    overlay.overlay(OverlayRule::Difference, FillRule::NonZero)
}

/// Something of a side from one point to another.
type OfSide<'a, T> = &'a dyn Fn(Point, Point) -> T;

/// A polygon around a circle that is drawn along lines.
struct Brush {
    radius_m: f64,
    corners: Vec<Point>,
}

impl Brush {
    fn new(radius_m: f64) -> Self {
        let count = if radius_m < SMALL_M { FEW_CORNERS } else { CORNERS };
        let step_rad = std::f64::consts::TAU / count as f64;
        let outer_m = radius_m / (step_rad / 2.0).cos();
        let corner = |n: usize| {
            let (sin, cos) = (step_rad * n as f64).sin_cos();
            Point { x: outer_m * cos, y: outer_m * sin }
        };
        Self { radius_m, corners: (0..count).map(corner).collect() }
    }

    /// Gives the hull of the brush, grown by a scale, over each side of a line, as far as the side lies in a region and is wanted.
    fn draw(
        &self,
        line: &[Point],
        (near, wanted, scale): (&Region, OfSide<'_, bool>, OfSide<'_, f64>),
        contour: &mut Vec<IntPoint<i32>>,
        mut give: impl FnMut(&[IntPoint<i32>]),
    ) {
        let count = self.corners.len();
        let at = |centre: Point, scale: f64, n: usize| {
            let corner = self.corners[n % count];
            on_grid(Point { x: centre.x + scale * corner.x, y: centre.y + scale * corner.y })
        };
        if let [point] = line
            && near.clip(*point, *point).is_some()
            && wanted(*point, *point)
        {
            contour.clear();
            contour.extend((0..count).map(|n| at(*point, scale(*point, *point), n)));
            give(contour);
        }
        for side in line.windows(2) {
            let Some((a, b)) = near.clip(side[0], side[1]).filter(|(a, b)| wanted(*a, *b)) else { continue };
            let ahead_rad = (b.y - a.y).atan2(b.x - a.x);
            // The corner farthest to the right of the way, and the opposite one, belong to both ends.
            let right = (ahead_rad / std::f64::consts::TAU - 0.25) * count as f64;
            let right = right.round().rem_euclid(count as f64) as usize;
            contour.clear();
            let half = count / 2;
            let grown = scale(a, b);
            contour.extend((0..=half).map(|n| at(b, grown, right + n)));
            contour.extend((half..=count).map(|n| at(a, grown, right + n)));
            give(contour);
        }
    }
}

/// Leaves out what lies within a tolerance of the rest (U. Ramer 1972; D. Douglas and T. Peucker 1973).
pub(crate) fn thin(line: &[Point], tolerance_m: f64) -> Vec<Point> {
    if line.len() < 3 {
        return line.to_vec();
    }
    let mut kept = vec![false; line.len()];
    let last = line.len() - 1;
    (kept[0], kept[last]) = (true, true);
    let mut spans = vec![(0, last)];
    while let Some((from, to)) = spans.pop() {
        let far =
            (from + 1..to).map(|at| (line[at].square_m2(line[at].nearest_on(line[from], line[to])), at));
        let Some((off_m2, at)) = far.max_by(|one, other| one.0.total_cmp(&other.0)) else { continue };
        if off_m2 > tolerance_m * tolerance_m {
            kept[at] = true;
            spans.extend([(from, at), (at, to)]);
        }
    }
    line.iter().zip(kept).filter(|(_, kept)| *kept).map(|(point, _)| *point).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::Mesh;
    use std::cell::Cell;

    /// Two tiles of 100 m: the western one has a strip of land at its eastern border, the eastern one an island that touches
    /// the border from 40 to 60 m.
    fn tiles() -> Pieces {
        let west = vec![[0, 0], [10_000, 0], [10_000, 7_000], [8_000, 7_000], [8_000, 10_000], [0, 10_000]];
        let east = vec![
            [10_000, 0],
            [20_000, 0],
            [20_000, 10_000],
            [10_000, 10_000],
            [10_000, 6_000],
            [12_000, 5_000],
            [10_000, 4_000],
        ];
        // Water of the east beside the land of the west, by itself.
        vec![vec![west], vec![east], vec![vec![[20_000, 0], [30_000, 0], [30_000, 10_000], [20_000, 10_000]]]]
    }

    #[test]
    fn a_long_line_is_cut_out_in_parts_between_which_it_can_be_called_off() {
        let zigzag: Vec<Point> =
            (0_u32..6_500).map(|n| Point { x: 2.0 * f64::from(n), y: 20.0 * f64::from(n % 2) }).collect();
        let lengths: Vec<usize> = parts(&zigzag).map(<[Point]>::len).collect();
        assert_eq!(lengths, [1_001, 1_001, 1_001, 1_001, 1_001, 1_001, 500]);
        assert!(parts(&zigzag).zip(parts(&zigzag).skip(1)).all(|(one, next)| one.last() == next.first()));
        assert_eq!(parts(&zigzag[..1]).map(<[Point]>::len).collect::<Vec<_>>(), [1]);
        let region = Region { min: Point { x: -100.0, y: -100.0 }, max: Point { x: 13_100.0, y: 120.0 } };
        let looks = Cell::new(0);
        let wanted = || {
            looks.set(looks.get() + 1);
            looks.get() < 4
        };
        let lines = [zigzag];
        let cut = Cut { lines: &lines, clearance_m: 5.0, plane: None, closed_m: None };
        assert_eq!(cut_out(region, &[cut], &Cancel::unless(&wanted)), Err(PlanError::Cancelled));
    }

    #[test]
    fn pieces_get_the_corners_of_their_neighbours_on_common_borders() {
        let matched = matched(tiles(), 100.0, &Cancel::never()).unwrap();
        let west = &matched[0][0];
        assert_eq!(west[1..5], [[10_000, 0], [10_000, 4_000], [10_000, 6_000], [10_000, 7_000]]);
        let east = &matched[1][0];
        assert_eq!(east[3..6], [[10_000, 10_000], [10_000, 7_000], [10_000, 6_000]]);
        assert_eq!(matched[2], tiles()[2], "nothing lies on its border but its corners");
    }

    #[test]
    fn matched_pieces_are_one_water_and_others_are_not() {
        let whole = |pieces: Pieces| Mesh::new(pieces, |_| true, &Cancel::never()).unwrap();
        let apart: std::collections::BTreeSet<u32> = whole(tiles()).piece.into_iter().collect();
        assert!(apart.len() > 1, "sides that are not the same join nothing");
        let mesh = whole(matched(tiles(), 100.0, &Cancel::never()).unwrap());
        assert!(mesh.piece.iter().all(|piece| *piece == mesh.piece[0]), "{:?}", mesh.piece);
        // A way from west to east bends at one corner of the island, on the border.
        let [from, to] = [Point { x: 95.0, y: 50.0 }, Point { x: 125.0, y: 50.0 }];
        let ends = [from, to].map(|at| (at, mesh.locate(at).unwrap()));
        let (way, _) = crate::search::shortest((&mesh, None), ends, None, &Cancel::never()).unwrap().unwrap();
        assert_eq!(way.len(), 3, "{way:?}");
        let corner = Point { x: 100.0, y: if way[1].y > 50.0 { 60.0 } else { 40.0 } };
        assert!(way[1].distance_m(corner) < 1e-6, "{way:?}");
    }

    #[test]
    fn matching_ends_at_the_first_look_that_says_that_it_is_not_wanted() {
        let mut ended = 0;
        for most in 0.. {
            let looks = Cell::new(0);
            let wanted = || {
                looks.set(looks.get() + 1);
                looks.get() <= most
            };
            match matched(tiles(), 100.0, &Cancel::unless(&wanted)) {
                Err(PlanError::Cancelled) => assert_eq!(looks.get(), most + 1),
                other => {
                    assert_eq!(other.unwrap().len(), 3);
                    break;
                }
            }
            ended += 1;
        }
        // Once the corners are sorted, and before each piece.
        assert_eq!(ended, 4);
    }
}
