//! Geometry in a tile's units: clipped to a box and simplified.

use crate::world::Point;

/// The box of a tile with its buffer.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Frame {
    pub(crate) min: i32,
    pub(crate) max: i32,
}

impl Frame {
    pub(crate) fn holds(self, at: Point) -> bool {
        (self.min..=self.max).contains(&at.x) && (self.min..=self.max).contains(&at.y)
    }

    /// A ring within the box: by each side in turn (I. E. Sutherland and G. W. Hodgman, "Reentrant polygon
    /// clipping", CACM 17, 1974). Parts that fall asunder stay joined along the border, which fills nothing.
    pub(crate) fn ring(self, ring: Vec<Point>) -> Vec<Point> {
        if ring.iter().all(|at| self.holds(*at)) {
            return ring;
        }
        let (min, max) = (self.min, self.max);
        let x = |at: Point| at.x;
        let y = |at: Point| at.y;
        let ring = half(&ring, |at| x(at) - min, |a, b| at_x(a, b, min));
        let ring = half(&ring, |at| max - x(at), |a, b| at_x(a, b, max));
        let ring = half(&ring, |at| y(at) - min, |a, b| at_y(a, b, min));
        half(&ring, |at| max - y(at), |a, b| at_y(a, b, max))
    }

    /// The parts of a line within the box (Y.-D. Liang and B. A. Barsky, "A new concept and method for line
    /// clipping", ACM TOG 3, 1984).
    pub(crate) fn line(self, line: &[Point]) -> Vec<Vec<Point>> {
        let mut parts: Vec<Vec<Point>> = Vec::new();
        let mut open = false;
        for pair in line.windows(2) {
            let Some((a, b)) = self.segment(pair[0], pair[1]) else {
                open = false;
                continue;
            };
            match parts.last_mut().filter(|_| open) {
                Some(part) => part.push(b),
                None => parts.push(vec![a, b]),
            }
            open = b == pair[1];
        }
        parts
    }

    fn segment(self, a: Point, b: Point) -> Option<(Point, Point)> {
        let (ax, ay) = (f64::from(a.x), f64::from(a.y));
        let (dx, dy) = (f64::from(b.x) - ax, f64::from(b.y) - ay);
        let (min, max) = (f64::from(self.min), f64::from(self.max));
        let (mut from, mut to) = (0.0_f64, 1.0_f64);
        for (step, room) in [(-dx, ax - min), (dx, max - ax), (-dy, ay - min), (dy, max - ay)] {
            if step == 0.0 {
                if room < 0.0 {
                    return None;
                }
            } else if step < 0.0 {
                from = from.max(room / step);
            } else {
                to = to.min(room / step);
            }
        }
        if from > to {
            return None;
        }
        let at = |share: f64| Point::new((ax + share * dx).round() as i32, (ay + share * dy).round() as i32);
        // The ends stay unchanged, so that lines continue.
        let end = |share: f64, whole: f64, point: Point| {
            if (share - whole).abs() < f64::EPSILON { point } else { at(share) }
        };
        Some((end(from, 0.0, a), end(to, 1.0, b)))
    }
}

fn half(ring: &[Point], inside: impl Fn(Point) -> i32, cut: impl Fn(Point, Point) -> Point) -> Vec<Point> {
    let mut out = Vec::with_capacity(ring.len() + 4);
    let Some(mut before) = ring.last().copied() else { return out };
    for at in ring {
        if (inside(before) < 0) != (inside(*at) < 0) {
            out.push(cut(before, *at));
        }
        if inside(*at) >= 0 {
            out.push(*at);
        }
        before = *at;
    }
    out
}

fn at_x(a: Point, b: Point, x: i32) -> Point {
    let share = (f64::from(x) - f64::from(a.x)) / (f64::from(b.x) - f64::from(a.x));
    let y = f64::from(a.y) + share * (f64::from(b.y) - f64::from(a.y));
    Point::new(x, y.round() as i32)
}

fn at_y(a: Point, b: Point, y: i32) -> Point {
    let share = (f64::from(y) - f64::from(a.y)) / (f64::from(b.y) - f64::from(a.y));
    let x = f64::from(a.x) + share * (f64::from(b.x) - f64::from(a.x));
    Point::new(x.round() as i32, y)
}

/// Vertices that are simplified together: bounds the work of [`simplified`], which is quadratic at worst.
const TOGETHER: usize = 4096;

/// A line with fewer vertices, none of the left-out ones farther than `within` from it (D. H. Douglas and
/// T. K. Peucker, "Algorithms for the reduction of the number of points", Cartographica 10, 1973).
pub(crate) fn simplified(line: &[Point], within: f64) -> Vec<Point> {
    if line.len() < 3 {
        return line.to_vec();
    }
    let mut keep = vec![false; line.len()];
    let mut first = 0;
    let mut stack = Vec::new();
    while first + 1 < line.len() {
        let last = (first + TOGETHER).min(line.len() - 1);
        (keep[first], keep[last]) = (true, true);
        stack.push((first, last));
        while let Some((from, to)) = stack.pop() {
            let mut worst = (within, None);
            for at in from + 1..to {
                let off = off(line[at], line[from], line[to]);
                if off > worst.0 {
                    worst = (off, Some(at));
                }
            }
            if let Some(at) = worst.1 {
                keep[at] = true;
                stack.push((from, at));
                stack.push((at, to));
            }
        }
        first = last;
    }
    line.iter().zip(keep).filter(|(_, keep)| *keep).map(|(at, _)| *at).collect()
}

/// A ring with fewer vertices: its first vertex and the one farthest from it stay.
pub(crate) fn simplified_ring(ring: &[Point], within: f64) -> Vec<Point> {
    let Some(first) = ring.first().copied() else { return Vec::new() };
    let away = |at: &Point| {
        let (dx, dy) = (i64::from(at.x) - i64::from(first.x), i64::from(at.y) - i64::from(first.y));
        dx * dx + dy * dy
    };
    let far = (0..ring.len()).max_by_key(|at| away(&ring[*at])).unwrap_or(0);
    let mut there = simplified(&ring[..=far], within);
    let back: Vec<Point> = ring[far..].iter().chain([&first]).copied().collect();
    let back = simplified(&back, within);
    there.extend(&back[1..back.len() - 1]);
    there
}

/// How far a point is from a segment.
fn off(at: Point, a: Point, b: Point) -> f64 {
    let (px, py) = (f64::from(at.x) - f64::from(a.x), f64::from(at.y) - f64::from(a.y));
    let (dx, dy) = (f64::from(b.x) - f64::from(a.x), f64::from(b.y) - f64::from(a.y));
    let length = dx * dx + dy * dy;
    let share = if length > 0.0 { ((px * dx + py * dy) / length).clamp(0.0, 1.0) } else { 0.0 };
    (px - share * dx).hypot(py - share * dy)
}
