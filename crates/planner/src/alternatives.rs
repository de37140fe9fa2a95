//! Other ways than the shortest one: on the other side of what it passes.
//!
//! A way passes between shores: an island on one hand, the mainland on the other. Two ways are told apart by that, not by
//! a few metres more or less in the same water. A side of a triangle that joins two shores, once closed, closes the whole
//! passage between them. So each passage of the shortest way is closed in its turn, and the shortest way without it is
//! looked for. Of what is found, the shortest are kept that leave those before them by a distance that shows on the map.

use crate::boxes::Bounds;
use crate::mesh::{Mesh, NONE};
use crate::parts::Parts;
use crate::plane::Point;
use crate::room::SeaRoom;
use crate::search::{Effort, Place};
use crate::{Cancel, PlanError};
use std::collections::BTreeMap;
use std::ops::RangeInclusive;

/// Most passages that are closed in their turn: those beside the largest islands, as the way round them differs most.
const MOST_CLOSED: usize = 24;
/// A way that is longer than the shortest one by this factor is of no use.
const LONGEST: f64 = 2.0;
/// Ways differ if they part by this share of the distance of their ends, within these bounds (m).
const APART_SHARE: f64 = 0.1;
const APART_M: RangeInclusive<f64> = 50.0..=1_000.0;
/// Pieces of a way that are held against the triangles one by one (m): the box around a long leg holds half the chart.
const PIECE_M: f64 = 250.0;
/// Points nearer than this to each other are the same (m).
const SAME_M: f64 = 1e-3;
/// Ways are compared at so many points.
const COMPARED: u32 = 256;

/// The two shores that a side joins, the lower number first.
type Shores = (u32, u32);
/// The corners of a side.
type Side = [u32; 2];

/// One of several ways.
pub(crate) struct Other {
    pub(crate) way: Vec<Point>,
    pub(crate) effort: Effort,
}

/// Up to so many other ways between two ends, of which `shortest` is the shortest; the shortest of them first.
pub(crate) fn others(
    room: &SeaRoom,
    ends: [Place; 2],
    shortest: &[Point],
    most: usize,
    cancel: &Cancel<'_>,
) -> Result<Vec<Other>, PlanError> {
    if most == 0 {
        return Ok(Vec::new());
    }
    let mesh = &room.mesh;
    let shores = shores(mesh);
    let longest_m = LONGEST * length_m(shortest);
    let mut found = Vec::new();
    for side in passages(mesh, &shores, shortest) {
        let way = room.shortest(ends, Some(side), cancel)?;
        let of_use = way.filter(|(way, _)| length_m(way) <= longest_m);
        found.extend(of_use.map(|(way, effort)| Other { way, effort }));
    }
    found.sort_by(|one, other| length_m(&one.way).total_cmp(&length_m(&other.way)));
    let apart_m = (APART_SHARE * ends[0].0.distance_m(ends[1].0)).clamp(*APART_M.start(), *APART_M.end());
    let mut kept: Vec<Other> = Vec::new();
    for other in found {
        let differs = |way: &[Point]| parts_by(&other.way, way, apart_m);
        if kept.len() < most && differs(shortest) && kept.iter().all(|kept| differs(&kept.way)) {
            kept.push(other);
        }
    }
    Ok(kept)
}

/// Of each corner the shore that it lies on: corners that borders join are of one.
fn shores(mesh: &Mesh) -> Vec<u32> {
    let mut parts = Parts::new(mesh.points.len());
    for (corners, beyond) in mesh.corners.iter().zip(&mesh.beyond) {
        for side in (0..3).filter(|side| beyond[*side] == NONE) {
            parts.join(corners[side], corners[(side + 1) % 3], false);
        }
    }
    (0..mesh.points.len() as u32).map(|corner| parts.of(corner)).collect()
}

/// A side of each passage that a way takes, by its corners; those beside the largest islands first.
fn passages(mesh: &Mesh, shores: &[u32], way: &[Point]) -> Vec<Side> {
    let mut taken = Taken { mesh, shores, sides: BTreeMap::new() };
    for piece in way.windows(2).flat_map(pieces) {
        taken.add(&Bounds::of(&piece), |side| crosses(piece, side));
    }
    for bend in way.windows(3) {
        taken.add(&Bounds::of(&[bend[1]]), |side| is_outside(bend, side));
    }
    let sizes_m = sizes_m(mesh, shores, taken.sides.keys());
    let size_m = |(one, other): &Shores| sizes_m[one].min(sizes_m[other]);
    let mut taken: Vec<(Shores, Side)> = taken.sides.into_iter().collect();
    taken.sort_by(|(one, _), (other, _)| size_m(other).total_cmp(&size_m(one)));
    taken.into_iter().take(MOST_CLOSED).map(|(_, side)| side).collect()
}

/// A side of each passage that was found so far.
struct Taken<'a> {
    mesh: &'a Mesh,
    shores: &'a [u32],
    sides: BTreeMap<Shores, Side>,
}

impl Taken<'_> {
    /// Adds passages of triangles in a box, by their sides that are taken.
    fn add(&mut self, near: &Bounds, is_taken: impl Fn([Point; 2]) -> bool) {
        let Self { mesh, shores, sides } = self;
        mesh.visit_at(near, |triangle| {
            let corners = mesh.corners[triangle as usize];
            for side in (0..3).filter(|side| mesh.beyond[triangle as usize][*side] != NONE) {
                let ends = [corners[side], corners[(side + 1) % 3]];
                let [one, other] = ends.map(|end| shores[end as usize]);
                let joined = (one.min(other), one.max(other));
                let is_new = one != other && !sides.contains_key(&joined);
                if is_new && is_taken(ends.map(|end| mesh.points[end as usize])) {
                    sides.insert(joined, ends);
                }
            }
        });
    }
}

/// A leg in pieces.
fn pieces(leg: &[Point]) -> impl Iterator<Item = [Point; 2]> {
    let (from, to) = (leg[0], leg[1]);
    let count = (from.distance_m(to) / PIECE_M).ceil().clamp(1.0, 1e5) as u32;
    let at = move |piece: u32| from.towards(to, f64::from(piece) / f64::from(count));
    (0..count).map(move |piece| [at(piece), at(piece + 1)])
}

/// How large shores are: the diagonals of the boxes around them (m).
fn sizes_m<'a>(mesh: &Mesh, shores: &[u32], of: impl Iterator<Item = &'a Shores>) -> BTreeMap<u32, f64> {
    let each = of.flat_map(|(one, other)| [*one, *other]);
    let mut boxes: BTreeMap<u32, Bounds> = each.map(|shore| (shore, Bounds::of(&[]))).collect();
    for (shore, point) in shores.iter().zip(&mesh.points) {
        if let Some(held) = boxes.get_mut(shore) {
            *held = held.with(Bounds::of(&[*point]));
        }
    }
    boxes.into_iter().map(|(shore, held)| (shore, held.min.distance_m(held.max))).collect()
}

/// Whether two segments cross.
fn crosses([from, to]: [Point; 2], [a, b]: [Point; 2]) -> bool {
    from.cross(to, a) * from.cross(to, b) < 0.0 && a.cross(b, from) * a.cross(b, to) < 0.0
}

/// Whether a side begins or ends at a bend of a way, and lies on the outer side of it: what the way bends round lies on the inner.
fn is_outside(bend: &[Point], [a, b]: [Point; 2]) -> bool {
    let [before, at, after] = [bend[0], bend[1], bend[2]];
    let end = if a.distance_m(at) < SAME_M {
        b
    } else if b.distance_m(at) < SAME_M {
        a
    } else {
        return false;
    };
    let turn = before.cross(at, after);
    before.cross(at, end) * turn <= 0.0 || at.cross(after, end) * turn <= 0.0
}

fn length_m(way: &[Point]) -> f64 {
    way.windows(2).map(|leg| leg[0].distance_m(leg[1])).sum()
}

/// Whether some point of a way lies so far from another way.
fn parts_by(way: &[Point], other: &[Point], apart_m: f64) -> bool {
    let step_m = length_m(way) / f64::from(COMPARED);
    let off_m = |at: Point| {
        let legs = other.windows(2).map(|leg| at.distance_m(at.nearest_on(leg[0], leg[1])));
        legs.fold(f64::INFINITY, f64::min)
    };
    way.windows(2).any(|leg| {
        let points =
            (leg[0].distance_m(leg[1]) / step_m.max(SAME_M)).ceil().clamp(1.0, f64::from(COMPARED)) as u32;
        (1..=points)
            .any(|point| off_m(leg[0].towards(leg[1], f64::from(point) / f64::from(points))) >= apart_m)
    })
}
