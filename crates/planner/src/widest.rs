//! The widest way through triangles: how much farther from everything a way could keep at most.
//!
//! A way through a triangle goes around the corner between the side by which it comes and the one by which it leaves.
//! How wide it is there, is the distance of that corner to the nearest border across (D. Demyen and M. Buro,
//! "Efficient triangulation-based pathfinding", AAAI 2006, algorithm 1). Of all ways the one with the widest narrowest
//! place is found as the shortest is by E. W. Dijkstra's search, with the least width in place of the length.

use crate::mesh::{Mesh, NONE};
use crate::plane::Point;
use crate::{Cancel, PlanError};
use std::collections::BinaryHeap;

/// Steps between two looks at whether the answer is still wanted.
const STEPS_BETWEEN_LOOKS: usize = 4_096;

/// The width (m) of the narrowest place of the widest way from one of some triangles to one of others; infinite where
/// they have one in common, `None` where no way leads from these to those.
pub(crate) fn widest_m(
    mesh: &Mesh,
    from: &[u32],
    to: &[u32],
    cancel: &Cancel<'_>,
) -> Result<Option<f64>, PlanError> {
    let mut is_goal = vec![false; mesh.corners.len()];
    for triangle in to {
        is_goal[*triangle as usize] = true;
    }
    if from.iter().any(|triangle| is_goal[*triangle as usize]) {
        return Ok(Some(f64::INFINITY));
    }
    // By the bits of the width, which order like itself: the triangle that is entered, and its side.
    let mut heap: BinaryHeap<(u64, u32, usize)> = BinaryHeap::new();
    let mut done = vec![[false; 3]; mesh.corners.len()];
    for triangle in from {
        for side in 0..3 {
            let (a, b) = ends(mesh, *triangle, side);
            heap.extend(enter(mesh, *triangle, side).map(|(next, by)| (a.distance_m(b).to_bits(), next, by)));
        }
    }
    let mut steps = 0;
    while let Some((bits, triangle, by)) = heap.pop() {
        steps += 1;
        if steps % STEPS_BETWEEN_LOOKS == 0 {
            cancel.check()?;
        }
        if std::mem::replace(&mut done[triangle as usize][by], true) {
            continue;
        }
        let so_far_m = f64::from_bits(bits);
        if is_goal[triangle as usize] {
            return Ok(Some(so_far_m));
        }
        for out in [(by + 1) % 3, (by + 2) % 3] {
            let Some((next, into)) = enter(mesh, triangle, out) else { continue };
            if !done[next as usize][into] {
                let narrowest_m = so_far_m.min(width_m(mesh, triangle, by, out));
                heap.push((narrowest_m.to_bits(), next, into));
            }
        }
    }
    Ok(None)
}

/// The triangle beyond a side, and which of its sides that is.
fn enter(mesh: &Mesh, triangle: u32, side: usize) -> Option<(u32, usize)> {
    let next = Some(mesh.beyond[triangle as usize][side]).filter(|next| *next != NONE)?;
    let first = mesh.corners[triangle as usize][(side + 1) % 3];
    Some((next, mesh.corners[next as usize].iter().position(|corner| *corner == first)?))
}

fn ends(mesh: &Mesh, triangle: u32, side: usize) -> (Point, Point) {
    let corners = mesh.triangle(triangle);
    (corners[side], corners[(side + 1) % 3])
}

/// How wide a way is that comes by one side of a triangle and leaves by another (m).
fn width_m(mesh: &Mesh, triangle: u32, by: usize, out: usize) -> f64 {
    let around = if out == (by + 1) % 3 { out } else { by };
    let corner = mesh.triangle(triangle)[around];
    let length_m = |side: usize| {
        let (a, b) = ends(mesh, triangle, side);
        a.distance_m(b)
    };
    let mut width_m = length_m(by).min(length_m(out));
    let mut open = vec![(triangle, (around + 1) % 3)];
    while let Some((triangle, side)) = open.pop() {
        let (a, b) = ends(mesh, triangle, side);
        // Beyond an obtuse corner nothing is nearer than that corner.
        if dot(a, corner, b) <= 0.0 || dot(b, corner, a) <= 0.0 {
            continue;
        }
        let off_m = corner.distance_m(corner.nearest_on(a, b));
        if off_m >= width_m {
            continue;
        }
        match enter(mesh, triangle, side) {
            None => width_m = off_m,
            Some((next, into)) => open.extend([(next, (into + 1) % 3), (next, (into + 2) % 3)]),
        }
    }
    width_m
}

/// The scalar product of the ways from a point to two others: negative where the angle between them is obtuse.
fn dot(at: Point, a: Point, b: Point) -> f64 {
    (a.x - at.x) * (b.x - at.x) + (a.y - at.y) * (b.y - at.y)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two basins of 100 m, joined by a canal 12 m wide and by one of 7 m.
    #[test]
    fn the_wider_of_two_canals_decides() {
        let outer = [[0, 0], [30_000, 0], [30_000, 10_000], [0, 10_000]];
        let block = |low: i32, high: i32| vec![[10_000, low], [20_000, low], [20_000, high], [10_000, high]];
        // Open: 0 to 7 m and 40 to 52 m north.
        let rings = vec![outer.to_vec(), block(700, 4_000), block(5_200, 10_000 - 1)];
        let mesh = Mesh::new(vec![rings], |_| true, &Cancel::never()).unwrap();
        let at = |x: f64, y: f64| mesh.locate(Point { x, y }).unwrap();
        let (west, east) = (at(50.0, 50.0), at(250.0, 50.0));
        let width_m = widest_m(&mesh, &[west], &[east], &Cancel::never()).unwrap().unwrap();
        assert!((width_m - 12.0).abs() < 1e-9, "{width_m}");
        assert_eq!(widest_m(&mesh, &[west], &[west], &Cancel::never()), Ok(Some(f64::INFINITY)));
    }
}
