//! The way of the least cost, near the known ways or far from them.
//!
//! First A* (P. E. Hart, N. J. Nilsson and B. Raphael 1968) over a [`Lattice`] of points that see each other: its estimate,
//! the straight distance times the least cost of a metre anywhere, never says too much. A point is also reached straight
//! from the point before its neighbour (Theta*, A. Nash, K. Daniel, S. Koenig and A. Felner 2007), so that legs have any
//! direction. Then the way that was found is pulled straight where that costs no more, and its corners are moved as long as
//! that saves something.
//!
//! How near it comes to the best way: no bound is proved. Neighbours alone, to the knight's move, would make a way at most
//! 2.8 % longer than a straight one in like water; straight legs of up to [`FAR`] spacings, pulling and moving take most of
//! that back. In the tests it comes within 0.5 % of the best way that is known: of brute force in a jet, of the exact way round
//! a bank or a slow area. Speed limits begin and end where their areas do; other conditions are looked up in squares of half
//! the grid's spacing: what is smaller may be missed by the search, though never by the comparison with the shortest way. Water that is narrower than the spacing is found only by
//! the corners and the known ways in it. For energy and preferences in currents that change with time, of two ways to a
//! point the cheaper one is kept and not the earlier one. A way that is longer than [`LONGEST`] times the shortest one is not
//! looked for.

use crate::lattice::Lattice;
use crate::objective::{Spot, Toll};
use crate::plane::Point;
use crate::sailing::Sailing;
use crate::{Cancel, PlanError};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// A way is at most so many times as long as the shortest one.
pub(crate) const LONGEST: f64 = 3.0;
/// Legs of the search, but for those of known ways, are at most so many spacings long.
const FAR: f64 = 12.0;
/// Steps between two looks at whether the answer is still wanted.
const STEPS_BETWEEN_LOOKS: usize = 256;
/// Times that corners are moved.
const ROUNDS: usize = 24;
/// Corners are not moved by less (m), nor by a smaller share of the spacing.
const LEAST_MOVE_M: f64 = 1.0;
const LEAST_MOVE: f64 = 1.0 / 64.0;
/// A move must save this share of what the two legs cost.
const SAVES: f64 = 1e-6;
/// Directions in which corners are moved.
const DIRECTIONS: u32 = 8;

/// The cheapest way that was found between the ends of known ways, of which the first is the shortest; `None` where none
/// can be sailed. It may cost more than a known way where water is narrow: the caller compares.
pub(crate) fn cheapest(
    sailing: &Sailing<'_>,
    ways: &[Vec<Point>],
    cancel: &Cancel<'_>,
) -> Result<Option<Vec<Point>>, PlanError> {
    let shortest_m: f64 = ways[0].windows(2).map(|leg| leg[0].distance_m(leg[1])).sum();
    let least_per_m = sailing.wish.objective.least_per_m(sailing.pace_mps).max(f64::MIN_POSITIVE);
    let mut cost = f64::INFINITY;
    for way in ways {
        cost = cost.min(sailing.cost(way, cancel)?);
    }
    let most_m = (cost / least_per_m).min(LONGEST * shortest_m);
    cancel.check()?;
    let lattice = Lattice::new(sailing, ways, most_m, cancel)?;
    let mut search = Search::new(sailing, &lattice, least_per_m);
    let Some(way) = search.run(cancel)? else { return Ok(None) };
    polish(sailing, way, lattice.spacing_m, cancel).map(Some)
}

/// A* over a lattice.
struct Search<'a> {
    sailing: &'a Sailing<'a>,
    lattice: &'a Lattice,
    least_per_m: f64,
    best: Vec<Toll>,
    before: Vec<u32>,
    done: Vec<bool>,
    /// How far a point may go in any direction and keep clear (m), once it was looked up.
    free_m: Vec<Option<f64>>,
    conditions: Conditions,
    /// By cost, whose bits order like itself.
    heap: BinaryHeap<Reverse<(u64, u32)>>,
}

impl<'a> Search<'a> {
    fn new(sailing: &'a Sailing<'a>, lattice: &'a Lattice, least_per_m: f64) -> Self {
        let count = lattice.points.len();
        let unknown = Toll { cost: f64::INFINITY, duration_s: f64::INFINITY, ..Toll::default() };
        let conditions = Conditions::new(lattice);
        Self {
            sailing,
            lattice,
            least_per_m,
            best: vec![unknown; count],
            before: vec![u32::MAX; count],
            done: vec![false; count],
            free_m: vec![None; count],
            conditions,
            heap: BinaryHeap::new(),
        }
    }

    fn run(&mut self, cancel: &Cancel<'_>) -> Result<Option<Vec<Point>>, PlanError> {
        self.best[0] = Toll::default();
        self.put(0);
        let mut steps = 0_usize;
        while let Some(Reverse((_, point))) = self.heap.pop() {
            if std::mem::replace(&mut self.done[point as usize], true) {
                continue;
            }
            if point == 1 {
                return Ok(Some(self.way()));
            }
            steps += 1;
            if steps.is_multiple_of(STEPS_BETWEEN_LOOKS) {
                cancel.check()?;
            }
            for next in self.lattice.near(point) {
                self.relax(point, next);
            }
        }
        Ok(None)
    }

    /// Reaches a point by another, or straight from the point before that one where this costs less.
    fn relax(&mut self, point: u32, next: u32) {
        if self.done[next as usize] {
            return;
        }
        let before = self.before[point as usize];
        if before != u32::MAX && self.length_m(before, next) <= FAR * self.lattice.spacing_m {
            self.reach(before, next, false);
        }
        self.reach(point, next, self.lattice.is_known(point, next));
    }

    fn length_m(&self, one: u32, other: u32) -> f64 {
        self.lattice.points[one as usize].distance_m(self.lattice.points[other as usize])
    }

    fn reach(&mut self, point: u32, next: u32, is_known: bool) {
        let (from, to) = (self.lattice.points[point as usize], self.lattice.points[next as usize]);
        let here = self.best[point as usize];
        let held = self.best[next as usize].cost;
        // What costs too much at the least needs no closer look.
        if here.cost + self.least_per_m * from.distance_m(to) >= held {
            return;
        }
        let piece_m = self.conditions.size_m;
        let Self { sailing, conditions, .. } = self;
        let toll = sailing.leg_by((from, to), here.duration_s, piece_m, |at| conditions.at(sailing, at));
        let Some(toll) = toll.map(|toll| here.and(toll)).filter(|toll| toll.cost < held) else { return };
        if is_known || self.sees(point, next) {
            self.best[next as usize] = toll;
            self.before[next as usize] = point;
            self.put(next);
        }
    }

    /// Whether the leg between two points keeps clear: at once where it lies in the open water around them.
    fn sees(&mut self, one: u32, other: u32) -> bool {
        let [from, to] = [one, other].map(|point| self.lattice.points[point as usize]);
        let room = self.sailing.room;
        if self.free_m(one) + self.free_m(other) > from.distance_m(to) {
            return true;
        }
        room.keeps_clear(from, to)
    }

    fn free_m(&mut self, point: u32) -> f64 {
        let (room, most_m) = (self.sailing.room, 4.0 * self.lattice.spacing_m);
        let at = self.lattice.points[point as usize];
        *self.free_m[point as usize].get_or_insert_with(|| room.free_m(at, most_m))
    }

    fn put(&mut self, point: u32) {
        let rest_m = self.lattice.points[point as usize].distance_m(self.lattice.points[1]);
        let cost = self.best[point as usize].cost + self.least_per_m * rest_m;
        self.heap.push(Reverse((cost.to_bits(), point)));
    }

    fn way(&self) -> Vec<Point> {
        let before = |point: &u32| Some(self.before[*point as usize]).filter(|before| *before != u32::MAX);
        let mut way: Vec<Point> = std::iter::successors(Some(1), before)
            .map(|point: u32| self.lattice.points[point as usize])
            .collect();
        way.reverse();
        way
    }
}

/// Conditions in squares of half the spacing, each looked up once, at its middle.
struct Conditions {
    origin: Point,
    size_m: f64,
    columns: usize,
    /// By square the number of its spot, or `u32::MAX`.
    numbers: Vec<u32>,
    spots: Vec<Spot>,
}

impl Conditions {
    fn new(lattice: &Lattice) -> Self {
        let size_m = lattice.spacing_m / 2.0;
        let (min, max) = (lattice.bounds.min, lattice.bounds.max);
        let [columns, rows] = [max.x - min.x, max.y - min.y].map(|side_m| (side_m / size_m) as usize + 1);
        Self { origin: min, size_m, columns, numbers: vec![u32::MAX; columns * rows], spots: Vec::new() }
    }

    fn at(&mut self, sailing: &Sailing<'_>, at: Point) -> Spot {
        // Known ways may leave what is in reach.
        if at.x < self.origin.x || at.y < self.origin.y {
            return sailing.spot(at);
        }
        let column = ((at.x - self.origin.x) / self.size_m) as usize;
        let row = ((at.y - self.origin.y) / self.size_m) as usize;
        if column >= self.columns || row >= self.numbers.len() / self.columns {
            return sailing.spot(at);
        }
        let number = &mut self.numbers[row * self.columns + column];
        if *number == u32::MAX {
            *number = self.spots.len() as u32;
            let middle = |cell: usize| (cell as f64 + 0.5) * self.size_m;
            let middle = Point { x: self.origin.x + middle(column), y: self.origin.y + middle(row) };
            self.spots.push(sailing.spot(middle));
        }
        self.spots[*number as usize]
    }
}

/// Leaves out corners and moves them as long as that saves something.
fn polish(
    sailing: &Sailing<'_>,
    mut way: Vec<Point>,
    spacing_m: f64,
    cancel: &Cancel<'_>,
) -> Result<Vec<Point>, PlanError> {
    let piece_m = (spacing_m / 4.0).clamp(5.0, 50.0);
    let mut polishing = Polishing { sailing, piece_m };
    let mut step_m = spacing_m / 2.0;
    for _ in 0..ROUNDS {
        cancel.check()?;
        polishing.leave_out(&mut way, cancel)?;
        let moved = polishing.move_corners(&mut way, step_m, cancel)?;
        if !moved {
            step_m /= 2.0;
            if step_m < LEAST_MOVE_M.max(LEAST_MOVE * spacing_m) {
                break;
            }
        }
    }
    Ok(way)
}

struct Polishing<'a> {
    sailing: &'a Sailing<'a>,
    piece_m: f64,
}

impl Polishing<'_> {
    fn leg(&self, from: Point, to: Point, begin_s: f64) -> Option<Toll> {
        self.sailing.leg((from, to), begin_s, self.piece_m)
    }

    /// Two legs, one after the other.
    fn by(&self, from: Point, by: Point, to: Point, begin_s: f64) -> Option<Toll> {
        let first = self.leg(from, by, begin_s)?;
        Some(first.and(self.leg(by, to, begin_s + first.duration_s)?))
    }

    /// Leaves out each corner without which the way costs no more, from the start on.
    fn leave_out(&self, way: &mut Vec<Point>, cancel: &Cancel<'_>) -> Result<(), PlanError> {
        let mut kept = vec![way[0]];
        let mut begin_s = 0.0;
        for at in 1..way.len() - 1 {
            let (from, corner, to) = (kept[kept.len() - 1], way[at], way[at + 1]);
            if at.is_multiple_of(STEPS_BETWEEN_LOOKS) {
                cancel.check()?;
            }
            let straight = self.leg(from, to, begin_s);
            let bent = self.by(from, corner, to, begin_s);
            let saves = |straight: Toll| bent.is_none_or(|bent| straight.cost <= bent.cost * (1.0 + 1e-9));
            if straight.is_some_and(saves) && self.sailing.room.keeps_clear(from, to) {
                continue;
            }
            begin_s += self.leg(from, corner, begin_s).map_or(0.0, |leg| leg.duration_s);
            kept.push(corner);
        }
        kept.push(way[way.len() - 1]);
        *way = kept;
        Ok(())
    }

    /// Moves each corner to the best of some places so far around it; whether one was moved.
    fn move_corners(
        &mut self,
        way: &mut [Point],
        step_m: f64,
        cancel: &Cancel<'_>,
    ) -> Result<bool, PlanError> {
        let (mut moved, mut begin_s) = (false, 0.0);
        for at in 1..way.len() - 1 {
            cancel.check()?;
            let (from, to) = (way[at - 1], way[at + 1]);
            let mut held = self.by(from, way[at], to, begin_s).map_or(f64::INFINITY, |toll| toll.cost);
            let middle = way[at];
            for direction in 0..DIRECTIONS {
                let rad = std::f64::consts::TAU * f64::from(direction) / f64::from(DIRECTIONS);
                let corner = Point { x: middle.x + step_m * rad.cos(), y: middle.y + step_m * rad.sin() };
                let cost = self.by(from, corner, to, begin_s).map_or(f64::INFINITY, |toll| toll.cost);
                let room = self.sailing.room;
                if cost < held * (1.0 - SAVES)
                    && room.mesh.locate(corner).is_some()
                    && room.keeps_clear(from, corner)
                    && room.keeps_clear(corner, to)
                {
                    (held, way[at], moved) = (cost, corner, true);
                }
            }
            begin_s += self.leg(from, way[at], begin_s).map_or(0.0, |leg| leg.duration_s);
        }
        Ok(moved)
    }
}
