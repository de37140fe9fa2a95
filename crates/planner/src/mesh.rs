//! Open water as triangles.

use crate::boxes::{Bounds, Boxes};
use crate::obstacles::{GridPoint, Pieces, metres};
use crate::parts::Parts;
use crate::plane::Point;
use crate::{Cancel, PlanError};
use spade::{ConstrainedDelaunayTriangulation, Point2, Triangulation as _};
use std::collections::{BTreeMap, BTreeSet};

/// No triangle.
pub(crate) const NONE: u32 = u32::MAX;

/// Pieces of water are looked for at twice the distance of the nearest one and so much farther (m).
const OTHER_PIECES_M: f64 = 300.0;

/// How far from a point pieces of water are looked for whose nearest one lies so far off (m).
pub(crate) fn others_within_m(nearest_m: f64) -> f64 {
    2.0 * nearest_m + OTHER_PIECES_M
}

/// What lies so near the border of a triangle counts as on it, and is moved in by so much (m).
const ON_BORDER_M: f64 = 1e-3;
const MOVED_IN_M: f64 = 0.02;

/// Triangles of open water; side n of a triangle runs from its corner n to the next, anticlockwise.
#[derive(Debug, Clone, Default)]
pub(crate) struct Mesh {
    pub(crate) points: Vec<Point>,
    /// Whether ways may bend at a point.
    pub(crate) bends: Vec<bool>,
    pub(crate) corners: Vec<[u32; 3]>,
    /// The triangle beyond each side, or [`NONE`].
    pub(crate) beyond: Vec<[u32; 3]>,
    /// Which piece of open water a triangle is of.
    pub(crate) piece: Vec<u32>,
    /// Of a triangle in a bay, the next one on the way out; of the others [`NONE`].
    outward: Vec<u32>,
    /// Whether it lies in a bay: all ways through it end.
    in_bay: Vec<bool>,
    tree: Boxes,
}

/// Each point once, in order.
fn in_order(points: impl Iterator<Item = GridPoint>) -> Vec<GridPoint> {
    let mut points: Vec<GridPoint> = points.collect();
    points.sort_unstable();
    points.dedup();
    points
}

/// A piece's triangles and a point well inside.
struct Piece {
    triangles: Vec<[GridPoint; 3]>,
    inside: Point,
}

impl Mesh {
    /// Divides those pieces into triangles that are open; `is_open` is asked for one point of each.
    pub(crate) fn new(
        pieces: Pieces,
        mut is_open: impl FnMut(Point) -> bool,
        cancel: &Cancel<'_>,
    ) -> Result<Self, PlanError> {
        let mut mesh = Self::default();
        let mut triangles: Vec<[GridPoint; 3]> = Vec::new();
        for rings in pieces {
            cancel.check()?;
            let Some(piece) = Piece::new(rings)? else { continue };
            if is_open(piece.inside) {
                let number = mesh.piece.last().map_or(0, |last| last + 1);
                mesh.piece.resize(mesh.piece.len() + piece.triangles.len(), number);
                triangles.extend(piece.triangles);
            }
        }
        let grid = in_order(triangles.iter().flatten().copied());
        mesh.points = grid.iter().map(|at| metres(*at)).collect();
        let number = |at: GridPoint| grid.binary_search(&at).map_or(NONE, |number| number as u32);
        mesh.corners = triangles.into_iter().map(|corners| corners.map(number)).collect();
        cancel.check()?;
        mesh.join();
        mesh.unite_pieces();
        mesh.find_bays();
        let bounds: Vec<Bounds> =
            (0..mesh.corners.len() as u32).map(|triangle| Bounds::of(&mesh.triangle(triangle))).collect();
        mesh.tree = Boxes::new(&bounds);
        Ok(mesh)
    }

    /// About how much memory it takes (bytes).
    pub(crate) fn bytes(&self) -> usize {
        let each = size_of::<[u32; 3]>() * 2 + size_of::<u32>() * 2 + size_of::<bool>();
        self.corners.len() * each
            + self.points.len() * (size_of::<Point>() + size_of::<bool>())
            + self.tree.bytes()
    }

    /// Pieces of water, by number, of which a corner lies where `is_border` says.
    pub(crate) fn pieces_at(&self, is_border: impl Fn(Point) -> bool) -> BTreeSet<u32> {
        let there: Vec<bool> = self.points.iter().map(|point| is_border(*point)).collect();
        let touches = |corners: &[u32; 3]| corners.iter().any(|corner| there[*corner as usize]);
        let all = self.corners.iter().zip(&self.piece);
        all.filter(|(corners, _)| touches(corners)).map(|(_, piece)| *piece).collect()
    }

    pub(crate) fn triangle(&self, triangle: u32) -> [Point; 3] {
        self.corners[triangle as usize].map(|corner| self.points[corner as usize])
    }

    /// The triangle that holds a point.
    pub(crate) fn locate(&self, at: Point) -> Option<u32> {
        self.tree.find(at, |triangle| {
            let [a, b, c] = self.triangle(triangle);
            a.cross(b, at) >= 0.0 && b.cross(c, at) >= 0.0 && c.cross(a, at) >= 0.0
        })
    }

    /// Gives the triangles whose boxes meet a box.
    pub(crate) fn visit_at(&self, near: &Bounds, mut visit: impl FnMut(u32)) {
        self.tree.nearest(near, 0.0, |triangle| {
            visit(triangle);
            0.0
        });
    }

    /// The same point, or one some centimetres from it that lies within the triangle and not on its border.
    pub(crate) fn within(&self, triangle: u32, at: Point) -> Point {
        let [a, b, c] = self.triangle(triangle);
        let middle = Point { x: (a.x + b.x + c.x) / 3.0, y: (a.y + b.y + c.y) / 3.0 };
        let off_m = [(a, b), (b, c), (c, a)].map(|(from, to)| at.distance_m(at.nearest_on(from, to)));
        if off_m.iter().all(|off_m| *off_m > ON_BORDER_M) {
            return at;
        }
        at.towards(middle, (MOVED_IN_M / at.distance_m(middle).max(MOVED_IN_M)).min(0.5))
    }

    /// For each piece of water within a distance of a point, and not much farther than the nearest one, its nearest
    /// point; the nearest piece first.
    pub(crate) fn nearest(&self, at: Point, within_m: f64) -> Vec<Near> {
        let mut found: Vec<Near> = Vec::new();
        let piece = |one: &Near| self.piece[one.triangle as usize];
        self.tree.nearest(&Bounds { min: at, max: at }, within_m, |triangle| {
            let near = self.near(triangle, at);
            match found.iter_mut().find(|one| piece(one) == piece(&near)) {
                Some(held) if near.distance_m < held.distance_m => *held = near,
                None if near.distance_m <= within_m => found.push(near),
                Some(_) | None => {}
            }
            let nearest_m = found.iter().map(|near| near.distance_m).fold(f64::INFINITY, f64::min);
            within_m.min(others_within_m(nearest_m))
        });
        found.sort_by(|one, other| one.distance_m.total_cmp(&other.distance_m));
        // A triangle may lie much farther off than its box.
        if let Some(Near { distance_m, .. }) = found.first().copied() {
            found.retain(|near| near.distance_m <= others_within_m(distance_m));
        }
        found
    }

    /// The nearest point of one piece of water.
    pub(crate) fn nearest_of(&self, piece: u32, at: Point) -> Option<Near> {
        let mut nearest: Option<Near> = None;
        self.tree.nearest(&Bounds { min: at, max: at }, f64::INFINITY, |triangle| {
            let near = self.near(triangle, at);
            let is_nearer = nearest.is_none_or(|held| near.distance_m < held.distance_m);
            if self.piece[triangle as usize] == piece && is_nearer {
                nearest = Some(near);
            }
            nearest.map_or(f64::INFINITY, |held| held.distance_m)
        });
        nearest
    }

    fn near(&self, triangle: u32, at: Point) -> Near {
        let [a, b, c] = self.triangle(triangle);
        let sides = [(a, b), (b, c), (c, a)].map(|(from, to)| at.nearest_on(from, to));
        let [first, rest @ ..] = sides.map(|on| Near { triangle, at: on, distance_m: at.distance_m(on) });
        rest.into_iter().fold(first, |best, one| if one.distance_m < best.distance_m { one } else { best })
    }

    /// A triangle and, where it lies in a bay, those on the way out of it.
    pub(crate) fn way_out(&self, triangle: u32) -> impl Iterator<Item = u32> {
        let next = move |at: &u32| Some(self.outward[*at as usize]).filter(|out| *out != NONE);
        std::iter::successors(Some(triangle), next)
    }

    /// Whether no way through a triangle leads on.
    pub(crate) fn is_in_bay(&self, triangle: u32) -> bool {
        self.in_bay[triangle as usize]
    }

    /// Finds what lies beyond each side.
    fn join(&mut self) {
        let of = |(number, corners): (u32, &[u32; 3])| {
            let corners = *corners;
            (0..3).map(move |side| (corners[side], corners[(side + 1) % 3], number))
        };
        let mut sides: Vec<(u32, u32, u32)> = (0_u32..).zip(&self.corners).flat_map(of).collect();
        sides.sort_unstable();
        let beyond = |from: u32, to: u32| {
            let at = sides.binary_search_by_key(&(from, to), |side| (side.0, side.1));
            at.map_or(NONE, |at| sides[at].2)
        };
        let all = self.corners.iter();
        self.beyond =
            all.map(|corners| [0, 1, 2].map(|side| beyond(corners[(side + 1) % 3], corners[side]))).collect();
        self.part_corners();
        self.find_bends();
    }

    /// Pieces whose triangles lie beside each other are one water: those of tiles beside each other.
    fn unite_pieces(&mut self) {
        let count = self.piece.last().map_or(0, |last| *last as usize + 1);
        let mut parts = Parts::new(count);
        for (piece, beyond) in self.piece.iter().zip(&self.beyond) {
            for next in beyond.iter().filter(|next| **next != NONE) {
                parts.join(*piece, self.piece[*next as usize], false);
            }
        }
        let mut numbers: BTreeMap<u32, u32> = BTreeMap::new();
        for piece in &mut self.piece {
            let next = numbers.len() as u32;
            *piece = *numbers.entry(parts.of(*piece)).or_insert(next);
        }
    }

    /// Where two borders touch, the water on each side gets a corner of its own: what is known of the way to one says nothing
    /// of the way to the other.
    fn part_corners(&mut self) {
        let number = |triangle: usize, side: usize| (3 * triangle + side) as u32;
        let mut parts = Parts::new(3 * self.corners.len());
        for (triangle, (corners, beyond)) in self.corners.iter().zip(&self.beyond).enumerate() {
            for (side, next) in beyond.iter().enumerate().filter(|(_, next)| **next != NONE) {
                for end in [side, (side + 1) % 3] {
                    let other = self.corners[*next as usize].iter().position(|one| *one == corners[end]);
                    if let Some(other) = other {
                        parts.join(number(triangle, end), number(*next as usize, other), false);
                    }
                }
            }
        }
        let mut first = vec![NONE; self.points.len()];
        let mut further: BTreeMap<u32, u32> = BTreeMap::new();
        for (triangle, corners) in self.corners.iter_mut().enumerate() {
            for (end, corner) in corners.iter_mut().enumerate() {
                let (at, part) = (*corner as usize, parts.of(number(triangle, end)));
                if first[at] == NONE {
                    first[at] = part;
                } else if first[at] != part {
                    let points = &mut self.points;
                    *corner = *further.entry(part).or_insert_with(|| {
                        points.push(points[at]);
                        points.len() as u32 - 1
                    });
                }
            }
        }
    }

    /// A shortest way bends only around closed ground: where the border, with open water to its left, turns right.
    fn find_bends(&mut self) {
        // By corner the one before it on the border.
        let mut before = vec![NONE; self.points.len()];
        let borders = || {
            self.corners.iter().zip(&self.beyond).flat_map(|(corners, beyond)| {
                let closed = (0..3).filter(|side| beyond[*side] == NONE);
                closed.map(|side| (corners[side], corners[(side + 1) % 3]))
            })
        };
        let mut bends = vec![false; self.points.len()];
        for (from, to) in borders() {
            before[to as usize] = from;
        }
        let at = |corner: u32| self.points[corner as usize];
        for (from, to) in borders() {
            let before = before[from as usize];
            if before != NONE {
                bends[from as usize] |= at(before).cross(at(from), at(to)) < 0.0;
            }
        }
        self.bends = bends;
    }

    /// Takes off triangles with one way on until all have two: a way passes through those only if it begins or ends
    /// there.
    fn find_bays(&mut self) {
        let count = self.corners.len();
        (self.in_bay, self.outward) = (vec![false; count], vec![NONE; count]);
        let mut ways: Vec<usize> =
            self.beyond.iter().map(|beyond| beyond.iter().filter(|one| **one != NONE).count()).collect();
        let mut ends: Vec<u32> = (0..count as u32).filter(|at| ways[*at as usize] <= 1).collect();
        while let Some(at) = ends.pop() {
            self.in_bay[at as usize] = true;
            for next in self.beyond[at as usize].into_iter().filter(|next| *next != NONE) {
                if !self.in_bay[next as usize] {
                    self.outward[at as usize] = next;
                    ways[next as usize] -= 1;
                    if ways[next as usize] == 1 {
                        ends.push(next);
                    }
                }
            }
        }
    }
}

/// The nearest point of a piece of water.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Near {
    pub(crate) triangle: u32,
    pub(crate) at: Point,
    pub(crate) distance_m: f64,
}

impl Piece {
    /// `None` of a piece without an area.
    fn new(rings: Vec<Vec<GridPoint>>) -> Result<Option<Self>, PlanError> {
        let grid = in_order(rings.iter().flatten().copied());
        let points = grid.iter().map(|at| Point2::new(f64::from(at[0]), f64::from(at[1]))).collect();
        let mut sides = Vec::new();
        for ring in &rings {
            let corners: Vec<usize> = ring.iter().filter_map(|at| grid.binary_search(at).ok()).collect();
            let next = corners.iter().cycle().skip(1);
            sides.extend(corners.iter().zip(next).map(|(a, b)| [*a, *b]).filter(|[a, b]| a != b));
        }
        // Dividing a large piece takes much memory for a moment.
        drop((rings, grid));
        let mut conflicts = 0;
        let all = ConstrainedDelaunayTriangulation::<Point2<f64>>::try_bulk_load_cdt(points, sides, |_| {
            conflicts += 1;
        });
        let all = all.map_err(|error| PlanError::Geometry(error.to_string()))?;
        if conflicts > 0 {
            return Err(PlanError::Geometry(format!("{conflicts} borders cross each other")));
        }
        Ok(Self::of_inner(&all))
    }

    /// The triangles on the inner side of the borders: those that an odd number of borders parts from the outside.
    fn of_inner(all: &ConstrainedDelaunayTriangulation<Point2<f64>>) -> Option<Self> {
        let mut inside: Vec<Option<bool>> = vec![None; all.num_all_faces()];
        inside[all.outer_face().index()] = Some(false);
        let mut open = vec![all.outer_face().fix()];
        let mut triangles = Vec::new();
        let (mut largest, mut middle) = (0.0, None);
        while let Some(face) = open.pop() {
            let here = inside[face.index()].unwrap_or_default();
            let face = all.face(face);
            let edges: Vec<_> = match face.as_inner() {
                Some(triangle) => triangle.adjacent_edges().to_vec(),
                None => all
                    .convex_hull()
                    .map(|edge| if edge.is_outer_edge() { edge } else { edge.rev() })
                    .collect(),
            };
            if let Some(triangle) = face.as_inner().filter(|_| here) {
                // Corners are whole numbers of the grid.
                let corners = triangle.positions().map(|at| [at.x as i32, at.y as i32]);
                let area = triangle.area();
                if area > largest {
                    let at = triangle.center();
                    largest = area;
                    middle = Some(Point { x: at.x / 100.0, y: at.y / 100.0 });
                }
                triangles.push(corners);
            }
            for edge in edges {
                let other = edge.rev().face();
                if inside[other.index()].is_none() {
                    inside[other.index()] = Some(here ^ edge.is_constraint_edge());
                    open.push(other.fix());
                }
            }
        }
        middle.map(|inside| Self { triangles, inside })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::search;

    /// Two islands that touch at one point part the water to their north from that to their south.
    #[test]
    fn where_two_islands_touch_each_side_has_a_corner_of_its_own() {
        let water = vec![[0, 0], [10_000, 0], [10_000, 6_000], [0, 6_000]];
        let touch = [5_000, 3_000];
        let west = vec![[1_000, 3_000], [3_000, 3_600], touch, [3_000, 2_400]];
        let east = vec![[9_000, 3_000], [7_000, 2_400], touch, [7_000, 3_600]];
        let never = Cancel::never();
        let mesh = Mesh::new(vec![vec![water, west, east]], |_| true, &never).unwrap();
        let touching = mesh.points.iter().filter(|at| **at == metres(touch)).count();
        assert_eq!(touching, 2);
        let place = |at: GridPoint| (metres(at), mesh.locate(metres(at)).unwrap());
        let ends = [place([5_000, 2_950]), place([4_990, 3_050])];
        let (way, _) = search::shortest((&mesh, None), ends, None, &never).unwrap().unwrap();
        let length_m: f64 = way.windows(2).map(|leg| leg[0].distance_m(leg[1])).sum();
        // Around the western tip, by way of the corners of that island.
        let around =
            [[5_000, 2_950], [3_000, 2_400], [1_000, 3_000], [3_000, 3_600], [4_990, 3_050]].map(metres);
        let around_m: f64 = around.windows(2).map(|leg| leg[0].distance_m(leg[1])).sum();
        assert!((length_m - around_m).abs() < 1e-6, "{length_m} m, around the island {around_m} m");
        // Near the touching point, and far from there by sea.
        let lengths_m = search::lengths_from(&mesh, ends[0].1, &never).unwrap();
        let there = mesh.points.iter().zip(&lengths_m).filter(|(at, _)| **at == metres(touch));
        let mut there: Vec<f64> = there.map(|(_, length_m)| *length_m).collect();
        there.sort_by(f64::total_cmp);
        assert!(there[1] > there[0] + 0.5 * around_m, "{there:?} m");
    }
}
