//! What is nearest: water too shallow, and points of interest.
//!
//! Best-first search by the distance to boxes (G. R. Hjaltason and H. Samet, "Distance browsing in spatial
//! databases", ACM TODS 24, 1999).

use super::coords::{Frame, Spot, TURN, distance_m, unwrap_near};
use super::index::DepthIndex;
use super::object::{Stored, Water, millimetres};
use super::plane::Strip;
use super::tree::{NO_DATA, Node, Run, Tree};
use std::collections::BinaryHeap;
use units::LatLon;

/// Something near a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Nearby {
    /// Distance (m).
    pub distance_m: f64,
    /// Its nearest point.
    pub at: LatLon,
    /// The object, for [`DepthIndex::object`]; `None` where there is no data.
    pub object: Option<u32>,
    /// What it means for a vessel.
    pub water: Water,
}

/// A waiting box or run.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Waiting {
    distance_m: f64,
    level: usize,
    index: usize,
    found: Option<(Spot, u32)>,
}

impl Eq for Waiting {}

impl Ord for Waiting {
    /// The nearest is the greatest; found things come before boxes at the same distance.
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let by_distance = other.distance_m.total_cmp(&self.distance_m);
        by_distance
            .then(self.found.is_some().cmp(&other.found.is_some()))
            .then((other.level, other.index).cmp(&(self.level, self.index)))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl DepthIndex {
    /// The nearest place where it is charted shallower than `depth_m`, or is no water of known depth; `None`
    /// if there is none within `within_m`. 0 where the place itself is.
    ///
    /// Distances are exact to 1 mm at 1 km; which of two things is the nearer is judged in one flat frame, so
    /// at 10 km the answer may be 0.3 % farther than the nearest (at 63°N).
    pub fn distance_to_shallower(&self, place: LatLon, depth_m: f64, within_m: f64) -> Option<Nearby> {
        let from = Spot::of(place);
        let state = self.state_at(from);
        // NaN must find everything.
        let limit_mm = if depth_m.is_nan() { i32::MAX } else { millimetres(depth_m) };
        if state.stored.least_mm() < limit_mm {
            let water = state.stored.water();
            return Some(Nearby { distance_m: 0.0, at: place, object: state.object, water });
        }
        let mut nearest = None;
        self.nearest_in(
            &self.danger,
            from,
            within_m,
            |node| node.least_mm < limit_mm,
            |found| {
                nearest = Some(found);
                false
            },
        );
        nearest
    }

    /// Points of interest by distance: at most `count` within `within_m` for which `wanted` holds.
    pub fn points_of_interest(
        &self,
        place: LatLon,
        count: usize,
        within_m: f64,
        wanted: impl Fn(&super::ChartObject) -> bool,
    ) -> Vec<Nearby> {
        let mut found: Vec<Nearby> = Vec::new();
        if count == 0 {
            return found;
        }
        self.nearest_in(
            &self.interest,
            Spot::of(place),
            within_m,
            |_| true,
            |one| {
                let object = one.object.and_then(|id| self.object(id));
                let twice = found.iter().any(|before| before.object == one.object);
                if !twice && object.is_some_and(&wanted) {
                    found.push(one);
                }
                found.len() < count
            },
        );
        found
    }

    /// Gives what is in a tree by growing distance until told to stop.
    fn nearest_in(
        &self,
        tree: &Tree,
        from: Spot,
        within_m: f64,
        wanted: impl Fn(&Node) -> bool,
        mut give: impl FnMut(Nearby) -> bool,
    ) {
        let frame = Frame::at(from.y);
        let mut heap = BinaryHeap::new();
        let Some((level, index)) = tree.top() else { return };
        if wanted(tree.node(level, index)) {
            let distance_m = box_distance_m(&frame, from, tree.node(level, index));
            heap.push(Waiting { distance_m, level, index, found: None });
        }
        while let Some(next) = heap.pop() {
            if let Some((at, object)) = next.found {
                let exact_m = distance_m(from, at);
                if exact_m > within_m {
                    return;
                }
                let id = (object != NO_DATA).then_some(object);
                let stored = id.map_or(Stored::NoData, |id| self.objects[id as usize].stored);
                let water = stored.water();
                if !give(Nearby { distance_m: exact_m, at: at.place(), object: id, water }) {
                    return;
                }
            } else if next.level == 0 {
                let run = tree.runs[next.index];
                let (distance_m, at) = self.run_distance(&run, from);
                heap.push(Waiting { distance_m, found: Some((at, run.object)), ..next });
            } else if next.distance_m <= within_m * 1.1 {
                for index in tree.children(next.level, next.index) {
                    let level = next.level - 1;
                    let node = tree.node(level, index);
                    if wanted(node) {
                        let distance_m = box_distance_m(&frame, from, node);
                        heap.push(Waiting { distance_m, level, index, found: None });
                    }
                }
            }
        }
    }

    /// The nearest point of a run and its distance.
    fn run_distance(&self, run: &Run, from: Spot) -> (f64, Spot) {
        let vertices = &self.areas.vertices[run.first as usize..(run.first + run.count) as usize];
        let first = Spot::of_vertex(vertices[0]);
        let turn = unwrap_near(first.x, from.x) - first.x;
        let strip = Strip::new(from, from, 0.0).turned(-turn);
        let mut a = strip.across(vertices[0]);
        let mut best = strip.nearest_anywhere(a, a);
        for vertex in &vertices[1..] {
            let b = strip.across(*vertex);
            let nearest = strip.nearest_anywhere(a, b);
            if nearest.distance_m < best.distance_m {
                best = nearest;
            }
            a = b;
        }
        let at = strip.spot(best.on);
        (best.distance_m, Spot { x: at.x + turn, ..at })
    }
}

/// Distance to a box, on the nearer way round the Earth.
fn box_distance_m(frame: &Frame, from: Spot, node: &Node) -> f64 {
    let (min, max) = (Spot::of_vertex(node.bounds.min), Spot::of_vertex(node.bounds.max));
    let y = from.y.clamp(min.y, max.y);
    let of_turn = |turn: f64| {
        let x = from.x.clamp(min.x + turn, max.x + turn);
        frame.distance_m(from, Spot { x, y })
    };
    of_turn(0.0).min(of_turn(TURN)).min(of_turn(-TURN))
}
