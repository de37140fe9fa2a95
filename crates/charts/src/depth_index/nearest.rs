//! Nearest-neighbour queries: water too shallow, and points of interest.
//!
//! Best-first search by the distance to boxes (G. R. Hjaltason and H. Samet, "Distance browsing in spatial
//! databases", ACM TODS 24, 1999).

use super::coords::{Frame, Spot, TURN, distance_m as distance_between_m, unwrap_near};
use super::index::DepthIndex;
use super::object::{Water, millimetres};
use super::piece::{Kind, Piece};
use super::plane::Strip;
use super::tree::{Node, Run};
use crate::grid::Bounds;
use std::collections::BinaryHeap;
use units::LatLon;

/// An object near a place.
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

/// A waiting chart, box or run.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Waiting {
    distance_m: f64,
    /// Place in the list of charts.
    chart: usize,
    what: What,
}

/// In the order in which they come at the same distance.
#[derive(Debug, Clone, Copy, PartialEq)]
enum What {
    Found { at: Spot, object: u32 },
    Box { level: usize, index: usize },
    Chart,
}

impl What {
    fn order(&self) -> (u8, usize, usize) {
        match self {
            Self::Found { object, .. } => (0, 0, *object as usize),
            Self::Box { level, index } => (1, *level, *index),
            Self::Chart => (2, 0, 0),
        }
    }
}

impl Eq for Waiting {}

impl Ord for Waiting {
    /// The nearest is the greatest; found objects come before boxes at the same distance.
    fn cmp(&self, other: &Self) -> std::cmp::Ordering {
        let by_distance = other.distance_m.total_cmp(&self.distance_m);
        let key = |one: &Self| (one.what.order(), one.chart);
        by_distance.then_with(|| key(other).cmp(&key(self)))
    }
}

impl PartialOrd for Waiting {
    fn partial_cmp(&self, other: &Self) -> Option<std::cmp::Ordering> {
        Some(self.cmp(other))
    }
}

impl DepthIndex {
    /// The nearest place that is charted shallower than `depth_m`, or is not water of known depth; `None`
    /// if no such place lies within `within_m`. The distance is 0 where `place` itself is such a place.
    ///
    /// Distances are exact to 1 mm at 1 km; which of two objects is the nearer is judged in one flat frame, so
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
            Kind::Danger,
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
            Kind::Interest,
            Spot::of(place),
            within_m,
            |_| true,
            |one| {
                let object = one.object.and_then(|id| self.object(id));
                let twice = found.iter().any(|before| before.object == one.object);
                if !twice && object.as_ref().is_some_and(&wanted) {
                    found.push(one);
                }
                found.len() < count
            },
        );
        found
    }

    /// Gives what is in the trees of a kind by growing distance until `give` asks to stop.
    fn nearest_in(
        &self,
        kind: Kind,
        from: Spot,
        within_m: f64,
        wanted: impl Fn(&Node) -> bool,
        mut give: impl FnMut(Nearby) -> bool,
    ) {
        let frame = Frame::at(from.y);
        // Of boxes the distance in this frame is a little off.
        let farthest_m = within_m * 1.1;
        let mut heap = BinaryHeap::new();
        for chart in self.charts_in(|node| box_distance_m(&frame, from, &node.bounds) <= farthest_m) {
            let distance_m = box_distance_m(&frame, from, &self.directory.entries[chart].bounds);
            heap.push(Waiting { distance_m, chart, what: What::Chart });
        }
        while let Some(Waiting { distance_m, chart, what }) = heap.pop() {
            let piece = self.piece(chart);
            let tree = piece.tree(kind);
            let mut wait = |level: usize, index: usize| {
                let node = tree.node(level, index);
                if wanted(node) {
                    let distance_m = box_distance_m(&frame, from, &node.bounds);
                    heap.push(Waiting { distance_m, chart, what: What::Box { level, index } });
                }
            };
            match what {
                What::Chart => {
                    if let Some((level, index)) = tree.top() {
                        wait(level, index);
                    }
                }
                What::Box { level: 0, index } => {
                    let run = tree.runs[index];
                    let (distance_m, at) = run_distance(&piece, &run, from);
                    let what = What::Found { at, object: run.object };
                    heap.push(Waiting { distance_m, chart, what });
                }
                What::Box { level, index } if distance_m <= farthest_m => {
                    tree.children(level, index).for_each(|index| wait(level - 1, index));
                }
                What::Box { .. } => {}
                What::Found { at, object } => {
                    let exact_m = distance_between_m(from, at);
                    if exact_m > within_m {
                        return;
                    }
                    let number = piece.object(object).map(|_| self.number(chart, object));
                    let water = piece.stored(object).water();
                    if !give(Nearby { distance_m: exact_m, at: at.place(), object: number, water }) {
                        return;
                    }
                }
            }
        }
    }
}

/// The nearest point of a run and its distance.
fn run_distance(piece: &Piece, run: &Run, from: Spot) -> (f64, Spot) {
    let vertices = piece.vertices(run);
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

/// Distance to a box, on the nearer way round the Earth.
fn box_distance_m(frame: &Frame, from: Spot, bounds: &Bounds) -> f64 {
    let (min, max) = (Spot::of_vertex(bounds.min), Spot::of_vertex(bounds.max));
    let y = from.y.clamp(min.y, max.y);
    let of_turn = |turn: f64| {
        let x = from.x.clamp(min.x + turn, max.x + turn);
        frame.distance_m(from, Spot { x, y })
    };
    of_turn(0.0).min(of_turn(TURN)).min(of_turn(-TURN))
}
