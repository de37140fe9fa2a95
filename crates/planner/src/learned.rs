//! What a room learns from its searches: landmarks of the water in which one was long.

use crate::landmarks::Landmarks;
use crate::mesh::Mesh;
use crate::search;
use crate::{Cancel, PlanError};
use std::sync::OnceLock;

/// Places from which lengths are kept. Each takes a search over the whole piece, and four bytes for each corner of the mesh.
const PLACES: usize = 8;

/// What a room has learned of one piece of water: the first in which a search was long.
#[derive(Debug, Clone, Default)]
pub(crate) struct Learned {
    /// The piece for which landmarks are wanted.
    wanted: OnceLock<u32>,
    landmarks: OnceLock<Landmarks>,
}

impl Learned {
    /// A search in this piece was long.
    pub(crate) fn ask_for(&self, piece: u32) {
        self.wanted.get_or_init(|| piece);
    }

    /// Whether a search was long and [`Self::learn`] has not been asked since.
    pub(crate) fn is_wanted(&self) -> bool {
        self.wanted.get().is_some() && self.landmarks.get().is_none()
    }

    /// Makes what is wanted, nothing where its time is used up; as much work as a dozen long searches.
    pub(crate) fn learn(&self, mesh: &Mesh, cancel: &Cancel<'_>) -> Result<(), PlanError> {
        if let Some(piece) = self.wanted.get().filter(|_| self.is_wanted()) {
            let landmarks = match landmarks(mesh, *piece, cancel) {
                // Water that is too large for its time is not tried again.
                Err(PlanError::OutOfTime) => Landmarks::new(*piece, Vec::new()),
                made => made?,
            };
            // If another thread was faster, these are the same.
            self.landmarks.get_or_init(|| landmarks);
        }
        Ok(())
    }

    /// What was learned; nothing before it is asked for.
    pub(crate) fn landmarks(&self) -> Option<&Landmarks> {
        self.landmarks.get()
    }

    /// About how much memory it takes (bytes).
    pub(crate) fn bytes(&self) -> usize {
        self.landmarks.get().map_or(0, Landmarks::bytes)
    }
}

/// Chooses places as far from each other as the water has them.
fn landmarks(mesh: &Mesh, piece: u32, cancel: &Cancel<'_>) -> Result<Landmarks, PlanError> {
    let mut kept: Vec<Vec<f32>> = Vec::new();
    let Some(first) = mesh.piece.iter().position(|one| *one == piece) else {
        return Ok(Landmarks::new(piece, kept));
    };
    let mut from = first as u32;
    let mut nearest_m = search::lengths_from(mesh, from, cancel)?;
    while kept.len() < PLACES {
        let far = |triangle: u32| {
            let corners = mesh.corners[triangle as usize];
            corners.map(|corner| nearest_m[corner as usize]).into_iter().fold(f64::INFINITY, f64::min)
        };
        let in_piece = (0_u32..).zip(&mesh.piece).filter(|(_, one)| **one == piece);
        let farthest = in_piece.map(|(triangle, _)| (far(triangle), triangle));
        let farthest =
            farthest.filter(|(far_m, _)| far_m.is_finite()).max_by(|one, other| one.0.total_cmp(&other.0));
        match farthest {
            Some((far_m, triangle)) if far_m > 0.0 && triangle != from => from = triangle,
            _ => break,
        }
        let lengths_m = search::lengths_from(mesh, from, cancel)?;
        // The very first lengths are of any place at all, and only lead to a far one.
        if kept.is_empty() {
            nearest_m.clone_from(&lengths_m);
        }
        nearest_m
            .iter_mut()
            .zip(&lengths_m)
            .for_each(|(nearest_m, length_m)| *nearest_m = nearest_m.min(*length_m));
        kept.push(lengths_m.into_iter().map(|length_m| length_m as f32).collect());
    }
    Ok(Landmarks::new(piece, kept))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::needs::Needs;
    use crate::plane::Point;
    use crate::room::SeaRoom;
    use std::sync::Arc;
    use testkit::Numbers;
    use testkit::sea::{Ground, Sea};
    use units::LatLon;

    /// Water of 8 by 8 km with walls of islands that touch, and islands between them, by a seed.
    fn room(seed: u64) -> SeaRoom {
        let mut numbers = Numbers(seed);
        let mut sea = Sea::new(LatLon::from_deg(63.4, 9.5).unwrap(), 4_000.0, 20.0);
        for wall in 0..3 {
            let north_m = -2_000.0 + 2_000.0 * f64::from(wall);
            let gap_m = numbers.within(-3_000.0, 3_000.0);
            for step in 0..24 {
                let east_m = -4_000.0 + 340.0 * f64::from(step);
                if (east_m - gap_m).abs() > 400.0 {
                    sea = sea.with(Ground::Land, units::LocalPoint { north_m, east_m }, 230.0, 7);
                }
            }
        }
        for _ in 0..40 {
            sea = sea.with(Ground::Land, numbers.point(3_800.0), numbers.within(20.0, 150.0), 5);
        }
        let needs = Needs::depth_and_clearance(5.0, 10.0);
        SeaRoom::of_chart(&sea.index(), &needs, &Arc::default(), &Cancel::never()).unwrap()
    }

    fn length_m(way: &[Point]) -> f64 {
        way.windows(2).map(|leg| leg[0].distance_m(leg[1])).sum()
    }

    #[test]
    fn ways_are_as_short_with_landmarks_as_without_and_found_sooner() {
        let never = Cancel::never();
        let (mut plain_sum, mut quick_sum, mut longest) = (0, 0, 0.0_f64);
        for seed in 1..=6 {
            let plain = room(seed);
            let quick = plain.clone();
            quick.learned.ask_for(plain.mesh.piece[0]);
            quick.learned.learn(&quick.mesh, &never).unwrap();
            assert!(!quick.learned.is_wanted());
            let mut numbers = Numbers(seed + 100);
            for _ in 0..60 {
                let mut place = || {
                    let triangle = (numbers.share() * plain.mesh.corners.len() as f64) as u32;
                    let [a, b, c] = plain.mesh.triangle(triangle);
                    let across = numbers.within(0.05, 0.9);
                    (a.towards(b, across).towards(c, numbers.within(0.05, 0.9)), triangle)
                };
                let (from, to) = (place(), place());
                let without = plain.shortest([from, to], None, &never).unwrap();
                let with = quick.shortest([from, to], None, &never).unwrap();
                let (Some((without, effort)), Some((with, less))) = (&without, &with) else {
                    assert_eq!(without.is_some(), with.is_some(), "from {from:?} to {to:?}");
                    continue;
                };
                let (without_m, with_m) = (length_m(without), length_m(with));
                assert!(
                    (without_m - with_m).abs() < 1e-6,
                    "{without_m} m and {with_m} m from {from:?} to {to:?}"
                );
                plain_sum += effort.intervals;
                quick_sum += less.intervals;
                longest = longest.max(without_m / from.0.distance_m(to.0));
            }
        }
        assert!(longest > 1.5, "the walls are in the way of some: {longest}");
        assert!(2 * quick_sum < plain_sum, "{quick_sum} intervals in place of {plain_sum}");
    }

    #[test]
    fn every_corner_has_its_length_and_none_that_is_said_is_longer() {
        let never = Cancel::never();
        let room = room(9);
        let mesh = &room.mesh;
        let piece = mesh.piece[0];
        let landmarks = landmarks(mesh, piece, &never).unwrap();
        let mut numbers = Numbers(4);
        for _ in 0..6 {
            let triangle = (numbers.share() * mesh.corners.len() as f64) as u32;
            let [a, b, c] = mesh.triangle(triangle);
            let goal = Point { x: (a.x + b.x + c.x) / 3.0, y: (a.y + b.y + c.y) / 3.0 };
            let lengths_m = search::lengths_from(mesh, triangle, &never).unwrap();
            let towards = landmarks.towards(mesh, goal, triangle);
            assert_eq!(towards.is_empty(), mesh.piece[triangle as usize] != piece);
            for from in (0..mesh.corners.len() as u32).step_by(23) {
                let corner = mesh.corners[from as usize][0];
                let at = mesh.within(from, mesh.points[corner as usize]);
                let way = room.shortest([(at, from), (goal, triangle)], None, &never).unwrap();
                let Some((way, _)) = way else {
                    assert!(lengths_m[corner as usize].is_infinite());
                    continue;
                };
                // The place is moved into the triangle by some centimetres.
                let (length_m, held_m) = (length_m(&way), lengths_m[corner as usize]);
                assert!((held_m - length_m).abs() < 0.05, "{held_m} m, by a search of its own {length_m} m");
                assert!(
                    towards.corner_to_goal_m(corner) <= held_m,
                    "{} m of {held_m} m",
                    towards.corner_to_goal_m(corner)
                );
            }
        }
    }

    #[test]
    fn learning_stops_when_it_is_called_off_and_is_still_wanted() {
        let room = room(2);
        room.learned.ask_for(room.mesh.piece[0]);
        let off = || false;
        let found = room.learned.learn(&room.mesh, &Cancel::unless(&off));
        assert_eq!((found, room.learned.is_wanted()), (Err(PlanError::Cancelled), true));
    }
}
