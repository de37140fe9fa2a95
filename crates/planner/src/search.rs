//! The shortest way through triangles.
//!
//! Polyanya (M. Cui, D. Harabor and A. Grastien, "Compromise-free pathfinding on a navigation mesh", IJCAI 2017): a
//! search over intervals of sides that are seen from a root, the last point at which the way bends. It finds the
//! shortest way, whatever its angles. Triangles in bays are left out unless the way begins or ends there.

use crate::landmarks::{Landmarks, Towards};
use crate::mesh::{Mesh, NONE};
use crate::plane::Point;
use crate::{Cancel, PlanError};
use std::cmp::Reverse;
use std::collections::BinaryHeap;

/// Lengths (m) that differ by less count as equal.
const SAME_M: f64 = 1e-6;
/// Share of the product of two lengths below which three points count as in line.
const IN_LINE: f64 = 1e-12;
/// Steps between two looks at whether the answer is still wanted.
const STEPS_BETWEEN_LOOKS: usize = 4_096;

/// A point at which a way begins or bends.
#[derive(Debug, Clone, Copy)]
struct Root {
    at: Point,
    /// Its number in the mesh, if it is a corner.
    corner: u32,
    /// The root before it.
    before: u32,
    /// Length of the way so far (m).
    length_m: f64,
}

/// An interval of a side through which a way goes on: `left` and `right` as seen in its direction.
#[derive(Debug, Clone, Copy)]
struct Interval {
    root: u32,
    left: Point,
    right: Point,
    /// Whether these are the ends of the side.
    at_left: bool,
    at_right: bool,
    /// The triangle beyond, and its side.
    triangle: u32,
    side: usize,
}

#[derive(Debug, Clone, Copy)]
enum Step {
    Through(Interval),
    /// To the goal, by a point of the last side if it is not seen from the root.
    Arrive {
        root: u32,
        by: Option<Point>,
    },
}

/// What a search did.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Effort {
    /// Intervals that were looked at.
    pub intervals: usize,
    /// Intervals that were put by for later.
    pub waiting: usize,
}

impl Effort {
    pub(crate) fn and(self, other: Self) -> Self {
        Self { intervals: self.intervals + other.intervals, waiting: self.waiting + other.waiting }
    }
}

/// Where a way is to end.
#[derive(Debug)]
struct Goal<'a> {
    at: Point,
    triangle: u32,
    towards: Towards<'a>,
}

struct Search<'a> {
    mesh: &'a Mesh,
    /// `None` for ways to everywhere.
    goal: Option<Goal<'a>>,
    /// A side that no way may pass, by its corners.
    closed: Option<[u32; 2]>,
    /// Triangles in bays that may be passed, in order.
    bays: Vec<u32>,
    roots: Vec<Root>,
    /// By corner the best root there, or [`NONE`].
    best: Vec<u32>,
    /// By corner the length of the shortest way to it that was seen (m).
    seen_m: Vec<f64>,
    /// By corner what landmarks say of the way to the goal (m), NaN where they were not asked; empty without landmarks.
    rest_m: Vec<f64>,
    steps: Vec<Step>,
    /// Places in `steps` that wait for a step.
    free: Vec<u32>,
    /// By length, whose bits order like itself.
    heap: BinaryHeap<Reverse<(u64, u32)>>,
    effort: Effort,
}

/// A way, both ends included, and what finding it took.
pub(crate) type Found = Option<(Vec<Point>, Effort)>;
/// A point and the triangle that holds it.
pub(crate) type Place = (Point, u32);

/// The shortest way between two points in these triangles that does not pass a side, given by its corners, if one is closed;
/// `None` where there is no such way, as between different pieces of water.
pub(crate) fn shortest(
    (mesh, landmarks): (&Mesh, Option<&Landmarks>),
    [(from, from_triangle), (to, to_triangle)]: [Place; 2],
    closed: Option<[u32; 2]>,
    cancel: &Cancel<'_>,
) -> Result<Found, PlanError> {
    if mesh.piece[from_triangle as usize] != mesh.piece[to_triangle as usize] {
        return Ok(None);
    }
    if from_triangle == to_triangle {
        return Ok(Some((vec![from, to], Effort::default())));
    }
    let towards = landmarks.map(|landmarks| landmarks.towards(mesh, to, to_triangle)).unwrap_or_default();
    let mut search = Search::new(mesh, (from, from_triangle));
    if !towards.is_empty() {
        search.rest_m = vec![f64::NAN; mesh.points.len()];
    }
    search.goal = Some(Goal { at: to, triangle: to_triangle, towards });
    search.bays.extend(mesh.way_out(to_triangle));
    search.bays.sort_unstable();
    search.closed = closed;
    search.begin(from_triangle);
    let arrived = search.run(cancel)?;
    Ok(arrived.map(|arrived| search.way(arrived)))
}

/// Lengths of the shortest ways from the middle of a triangle to all corners (m); infinite in other pieces of water.
pub(crate) fn lengths_from(mesh: &Mesh, triangle: u32, cancel: &Cancel<'_>) -> Result<Vec<f64>, PlanError> {
    let [a, b, c] = mesh.triangle(triangle);
    let middle = Point { x: (a.x + b.x + c.x) / 3.0, y: (a.y + b.y + c.y) / 3.0 };
    let mut search = Search::new(mesh, (middle, triangle));
    search.begin(triangle);
    search.run(cancel)?;
    Ok(search.seen_m)
}

/// A root and the point of the last side by which the goal is reached from it, if it is not seen from there.
type Arrived = (u32, Option<Point>);

impl<'a> Search<'a> {
    fn new(mesh: &'a Mesh, (from, triangle): Place) -> Self {
        Self {
            mesh,
            goal: None,
            closed: None,
            bays: mesh.way_out(triangle).collect(),
            roots: vec![Root { at: from, corner: NONE, before: NONE, length_m: 0.0 }],
            best: vec![NONE; mesh.points.len()],
            seen_m: vec![f64::INFINITY; mesh.points.len()],
            rest_m: Vec::new(),
            steps: Vec::new(),
            free: Vec::new(),
            heap: BinaryHeap::new(),
            effort: Effort::default(),
        }
    }

    fn begin(&mut self, triangle: u32) {
        let corners = self.mesh.triangle(triangle);
        for side in 0..3 {
            let (left, right) = (corners[(side + 1) % 3], corners[side]);
            if let Some(next) = self.across(triangle, side, 0, (left, true), (right, true)) {
                self.put(next);
            }
        }
    }

    /// Until the goal is reached, or all water is.
    fn run(&mut self, cancel: &Cancel<'_>) -> Result<Option<Arrived>, PlanError> {
        while let Some(Reverse((_, step))) = self.heap.pop() {
            match self.steps[step as usize] {
                Step::Arrive { root, by } => return Ok(Some((root, by))),
                Step::Through(interval) => {
                    // Its place is for the next one: a search over all water holds only the border of what it has seen.
                    self.free.push(step);
                    self.follow(interval);
                }
            }
            if self.effort.intervals.is_multiple_of(STEPS_BETWEEN_LOOKS) {
                cancel.check()?;
            }
        }
        Ok(None)
    }

    /// Goes on as long as there is one way on only.
    fn follow(&mut self, mut interval: Interval) {
        loop {
            self.effort.intervals += 1;
            if !self.is_best(interval.root) {
                return;
            }
            if let Some(Goal { at, triangle, .. }) = self.goal
                && triangle == interval.triangle
            {
                return self.arrive(interval, at);
            }
            let next = self.expand(interval);
            let mut onward = next.into_iter().flatten();
            match (onward.next(), onward.next()) {
                (None, _) => return,
                (Some(only), None) => interval = only,
                (Some(one), Some(other)) => {
                    self.put(one);
                    self.put(other);
                    onward.for_each(|more| self.put(more));
                    return;
                }
            }
        }
    }

    fn is_best(&self, root: u32) -> bool {
        let Root { corner, length_m, .. } = self.roots[root as usize];
        let best = self.best.get(corner as usize).and_then(|best| self.roots.get(*best as usize));
        best.is_none_or(|best| length_m <= best.length_m + SAME_M)
    }

    /// What of the two other sides of the triangle is reached through an interval, straight and around its ends.
    fn expand(&mut self, interval: Interval) -> [Option<Interval>; 4] {
        let Interval { root, left, right, at_left, at_right, triangle, side } = interval;
        let numbers = self.mesh.corners[triangle as usize];
        let (left_corner, right_corner) = (numbers[side], numbers[(side + 1) % 3]);
        let corners = self.mesh.triangle(triangle);
        let (l, r, apex) = (corners[side], corners[(side + 1) % 3], corners[(side + 2) % 3]);
        let (right_side, left_side) = ((side + 1) % 3, (side + 2) % 3);
        let Root { at: eye, corner: eye_corner, .. } = self.roots[root as usize];
        let mut next = [None; 4];
        let full_left = ((l, true), (apex, true));
        let full_right = ((apex, true), (r, true));
        if eye_corner != NONE && (eye_corner == left_corner || eye_corner == right_corner) {
            next[0] = self.across(triangle, left_side, root, full_left.0, full_left.1);
            next[1] = self.across(triangle, right_side, root, full_right.0, full_right.1);
            return next;
        }
        let off_left = turn(eye, left, apex);
        let off_right = turn(eye, right, apex);
        // Where the rays from the root past the ends of the interval leave the triangle.
        if off_left > 0.0 {
            // The apex lies left of what is seen.
            let ray_left = meet(eye, left, apex, r);
            let ray_right = if at_right { (r, true) } else { (meet(eye, right, apex, r), false) };
            next[0] = self.across(triangle, right_side, root, (ray_left, false), ray_right);
            if let Some(bent) = self.bend(root, left, left_corner, at_left) {
                next[1] = self.across(triangle, left_side, bent, full_left.0, full_left.1);
                next[2] = self.across(triangle, right_side, bent, (apex, true), (ray_left, false));
            }
        } else if off_right < 0.0 {
            let ray_right = meet(eye, right, l, apex);
            let ray_left = if at_left { (l, true) } else { (meet(eye, left, l, apex), false) };
            next[0] = self.across(triangle, left_side, root, ray_left, (ray_right, false));
            if let Some(bent) = self.bend(root, right, right_corner, at_right) {
                next[1] = self.across(triangle, right_side, bent, full_right.0, full_right.1);
                next[2] = self.across(triangle, left_side, bent, (ray_right, false), (apex, true));
            }
        } else {
            let ray_left = if at_left { (l, true) } else { (meet(eye, left, l, apex), false) };
            let ray_right = if at_right { (r, true) } else { (meet(eye, right, apex, r), false) };
            next[0] = self.across(triangle, left_side, root, ray_left, (apex, true));
            next[1] = self.across(triangle, right_side, root, (apex, true), ray_right);
            // The apex in line with an end: what lies beyond is reached around that end only.
            if off_left == 0.0 {
                let bent = self.bend(root, left, left_corner, at_left);
                next[2] =
                    bent.and_then(|bent| self.across(triangle, left_side, bent, full_left.0, full_left.1));
            }
            if off_right == 0.0 {
                let bent = self.bend(root, right, right_corner, at_right);
                next[3] =
                    bent.and_then(|bent| self.across(triangle, right_side, bent, full_right.0, full_right.1));
            }
        }
        next
    }

    /// A root at an end of an interval, if the way may bend there and no shorter way to it is known.
    fn bend(&mut self, root: u32, at: Point, corner: u32, is_corner: bool) -> Option<u32> {
        if !is_corner || !self.mesh.bends[corner as usize] {
            return None;
        }
        let before = self.roots[root as usize];
        let length_m = before.length_m + before.at.distance_m(at);
        let best = self.best[corner as usize];
        if let Some(Root { length_m: best_m, .. }) = self.roots.get(best as usize) {
            if length_m > best_m + SAME_M {
                return None;
            }
            if length_m >= *best_m {
                return Some(best);
            }
        }
        self.roots.push(Root { at, corner, before: root, length_m });
        let number = self.roots.len() as u32 - 1;
        self.best[corner as usize] = number;
        Some(number)
    }

    /// The interval on a side of a triangle, as a way to the triangle beyond; `None` where it is closed, or so short
    /// that nothing is seen through it.
    fn across(
        &mut self,
        triangle: u32,
        side: usize,
        root: u32,
        (left, at_left): (Point, bool),
        (right, at_right): (Point, bool),
    ) -> Option<Interval> {
        let beyond = self.mesh.beyond[triangle as usize][side];
        let corners = self.mesh.corners[triangle as usize];
        let ends = (corners[(side + 1) % 3], corners[side]);
        if beyond == NONE {
            self.note((ends.0, at_left), left, root);
            self.note((ends.1, at_right), right, root);
            return None;
        }
        if left.distance_m(right) < SAME_M {
            return None;
        }
        let is_aside = self.goal.is_some() && self.mesh.is_in_bay(beyond);
        if is_aside && self.bays.binary_search(&beyond).is_err() {
            return None;
        }
        if self.closed.is_some_and(|[one, other]| ends == (one, other) || ends == (other, one)) {
            return None;
        }
        if self.is_shorter_along((ends.0, at_left), left, right, root)
            || self.is_shorter_along((ends.1, at_right), right, left, root)
        {
            return None;
        }
        let side = self.mesh.corners[beyond as usize].iter().position(|one| *one == ends.0)?;
        Some(Interval { root, left, right, at_left, at_right, triangle: beyond, side })
    }

    /// Whether every point of an interval is reached by a shorter way than from this root: to an end of the side, then
    /// along the side. Going along, that way grows at least as fast as the one from the root, so that the far end of
    /// the interval decides. A way straight to the end itself is noted.
    fn is_shorter_along(&mut self, end: (u32, bool), near: Point, far: Point, root: u32) -> bool {
        if self.note(end, near, root) {
            return false;
        }
        let Root { at: eye, length_m, .. } = self.roots[root as usize];
        let along_m = self.seen_m[end.0 as usize] + self.mesh.points[end.0 as usize].distance_m(far);
        along_m < length_m + eye.distance_m(far) - SAME_M
    }

    /// Notes the way straight from a root to an end of a side, if that is seen; whether it is the shortest so far.
    fn note(&mut self, (end, is_seen): (u32, bool), at: Point, root: u32) -> bool {
        let Root { at: eye, length_m, .. } = self.roots[root as usize];
        let straight_m = length_m + eye.distance_m(at);
        let is_shortest = is_seen && straight_m < self.seen_m[end as usize];
        if is_shortest {
            self.seen_m[end as usize] = straight_m;
        }
        is_shortest
    }

    fn put(&mut self, interval: Interval) {
        let Root { at: eye, corner: root, length_m, .. } = self.roots[interval.root as usize];
        let Interval { left, right, triangle, side, .. } = interval;
        let Some(goal) = self.goal.as_ref().map(|goal| goal.at) else {
            return self
                .push(length_m + eye.distance_m(eye.nearest_on(left, right)), Step::Through(interval));
        };
        let mut rest_m = least_m(eye, left, right, goal);
        if !self.rest_m.is_empty() {
            let corners = self.mesh.corners[triangle as usize];
            for corner in [corners[side], corners[(side + 1) % 3]] {
                // Going along the side, the way from the root grows no faster than the way from its end: the far end of the
                // interval decides.
                let end = self.mesh.points[corner as usize];
                let far = if end.distance_m(left) > end.distance_m(right) { left } else { right };
                rest_m = rest_m.max(eye.distance_m(far) - end.distance_m(far) + self.least_rest_m(corner));
            }
            if root != NONE {
                rest_m = rest_m.max(self.least_rest_m(root));
            }
        }
        self.push(length_m + rest_m, Step::Through(interval));
    }

    /// No way from a corner to the goal is shorter (m), as far as landmarks say.
    fn least_rest_m(&mut self, corner: u32) -> f64 {
        let held_m = self.rest_m[corner as usize];
        if !held_m.is_nan() {
            return held_m;
        }
        let rest_m = self.goal.as_ref().map_or(0.0, |goal| goal.towards.corner_to_goal_m(corner));
        self.rest_m[corner as usize] = rest_m;
        rest_m
    }

    fn arrive(&mut self, interval: Interval, goal: Point) {
        let root = self.roots[interval.root as usize];
        let Interval { left, right, .. } = interval;
        let by = if turn(root.at, left, goal) > 0.0 {
            Some(left)
        } else if turn(root.at, right, goal) < 0.0 {
            Some(right)
        } else {
            None
        };
        let by = by.filter(|by| by.distance_m(root.at) > SAME_M);
        let rest_m = by.map_or(root.at.distance_m(goal), |by| root.at.distance_m(by) + by.distance_m(goal));
        self.push(root.length_m + rest_m, Step::Arrive { root: interval.root, by });
    }

    fn push(&mut self, length_m: f64, step: Step) {
        self.effort.waiting += 1;
        let number = if let Some(free) = self.free.pop() {
            self.steps[free as usize] = step;
            free
        } else {
            self.steps.push(step);
            self.steps.len() as u32 - 1
        };
        self.heap.push(Reverse((length_m.to_bits(), number)));
    }

    fn way(&self, (root, by): Arrived) -> (Vec<Point>, Effort) {
        let mut way: Vec<Point> = self.goal.iter().map(|goal| goal.at).chain(by).collect();
        let mut at = root;
        while at != NONE {
            way.push(self.roots[at as usize].at);
            at = self.roots[at as usize].before;
        }
        way.reverse();
        way.dedup_by(|one, other| one.distance_m(*other) < SAME_M);
        (way, self.effort)
    }
}

/// On which side of the way from `eye` past `a` a point lies: positive on the left, 0 in line.
fn turn(eye: Point, a: Point, b: Point) -> f64 {
    let cross = eye.cross(a, b);
    if cross.abs() <= IN_LINE * eye.distance_m(a) * eye.distance_m(b) { 0.0 } else { cross }
}

/// Where the line from `eye` past `by` meets the segment from `a` to `b`.
fn meet(eye: Point, by: Point, a: Point, b: Point) -> Point {
    let (of_a, of_b) = (eye.cross(by, a), eye.cross(by, b));
    let span = of_a - of_b;
    if span == 0.0 { a } else { a.towards(b, (of_a / span).clamp(0.0, 1.0)) }
}

/// No way from a root through an interval to a goal beyond it is shorter (m).
fn least_m(eye: Point, left: Point, right: Point, goal: Point) -> f64 {
    let (side, of_eye) = (left.cross(right, goal), left.cross(right, eye));
    let goal = if side * of_eye > 0.0 { mirrored(goal, left, right) } else { goal };
    if eye.cross(left, goal) > 0.0 {
        eye.distance_m(left) + left.distance_m(goal)
    } else if eye.cross(right, goal) < 0.0 {
        eye.distance_m(right) + right.distance_m(goal)
    } else {
        eye.distance_m(goal)
    }
}

fn mirrored(at: Point, a: Point, b: Point) -> Point {
    let (dx, dy) = (b.x - a.x, b.y - a.y);
    let off = 2.0 * a.cross(b, at) / (dx * dx + dy * dy);
    Point { x: at.x + dy * off, y: at.y - dx * off }
}
