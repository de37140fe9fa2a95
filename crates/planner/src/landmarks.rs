//! Lengths of the shortest ways from a few far places of a piece of water to all its corners.
//!
//! By them a search knows better than by the straight line how far the goal is: no way from a place to the goal is shorter than
//! the difference of the ways to both from a third place. Around headlands and through islands that leaves out most of the
//! water that lies nearer to the goal and leads nowhere. (A. V. Goldberg and C. Harrelson, "Computing the shortest path: A*
//! search meets graph theory", SODA 2005; here the places are corners of triangles, and what lies between corners is bounded
//! by theirs.)

use crate::mesh::Mesh;
use crate::plane::Point;

/// Lengths are kept to less than this (m): of 1,000 km, an `f32` tells 0.06 m apart.
const ROUNDED_M: f64 = 0.1;

/// Of one piece of water.
#[derive(Debug, Clone)]
pub(crate) struct Landmarks {
    piece: u32,
    /// For each place, by corner, the length of the shortest way (m); infinite in other pieces of water.
    lengths_m: Vec<Vec<f32>>,
}

impl Landmarks {
    /// By lengths from each place to all corners (m).
    pub(crate) fn new(piece: u32, lengths_m: Vec<Vec<f32>>) -> Self {
        Self { piece, lengths_m }
    }

    /// About how much memory it takes (bytes).
    pub(crate) fn bytes(&self) -> usize {
        self.lengths_m.iter().map(|lengths_m| lengths_m.len() * size_of::<f32>()).sum()
    }

    /// What these say of a goal in a triangle; nothing in another piece of water.
    pub(crate) fn towards(&self, mesh: &Mesh, goal: Point, triangle: u32) -> Towards<'_> {
        let corners = mesh.corners[triangle as usize];
        let goal_m = |lengths_m: &Vec<f32>| {
            corners.iter().fold([0.0_f64, f64::INFINITY], |[least_m, most_m], corner| {
                let length_m = f64::from(lengths_m[*corner as usize]);
                let off_m = mesh.points[*corner as usize].distance_m(goal);
                [least_m.max(length_m - off_m), most_m.min(length_m + off_m)]
            })
        };
        let here = mesh.piece[triangle as usize] == self.piece;
        let lengths_m = if here { &self.lengths_m[..] } else { &[] };
        let kept = lengths_m.iter().map(|lengths_m| (&lengths_m[..], goal_m(lengths_m)));
        Towards { kept: kept.filter(|(_, goal_m)| goal_m.iter().all(|one| one.is_finite())).collect() }
    }
}

/// How far from a goal corners and sides are at least.
#[derive(Debug, Default)]
pub(crate) struct Towards<'a> {
    /// For each place the lengths by corner, and the least and the most that the goal is from it (m).
    kept: Vec<(&'a [f32], [f64; 2])>,
}

impl Towards<'_> {
    /// Whether it says nothing.
    pub(crate) fn is_empty(&self) -> bool {
        self.kept.is_empty()
    }

    /// No way from a corner to the goal is shorter (m).
    pub(crate) fn corner_to_goal_m(&self, corner: u32) -> f64 {
        let of_place = |(lengths_m, [least_m, most_m]): &(&[f32], [f64; 2])| {
            let length_m = f64::from(lengths_m[corner as usize]);
            if length_m.is_finite() { (length_m - most_m).max(least_m - length_m) } else { 0.0 }
        };
        self.kept.iter().map(of_place).fold(0.0, |held_m, more_m| f64::max(held_m, more_m - 2.0 * ROUNDED_M))
    }
}
