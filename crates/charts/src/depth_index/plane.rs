//! Distances between a leg and what it may touch, in metres along and across the leg.

use super::coords::{Frame, Spot};
use super::tree::Node;
use crate::grid::{Bounds, Vertex};

/// A straight piece of a leg with the frame it is looked at in: u runs along it from 0 to its length, v across.
#[derive(Debug, Clone, Copy)]
pub(super) struct Strip {
    from: Spot,
    /// Metres of u and v per unit of x and y.
    ux: f64,
    uy: f64,
    vx: f64,
    vy: f64,
    pub(super) length_m: f64,
    /// Half width, slack included.
    pub(super) reach_m: f64,
    window: [f64; 4],
}

/// A point in a strip's frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct Across {
    pub(super) u: f64,
    pub(super) v: f64,
}

/// Where a leg and a segment come nearest.
#[derive(Debug, Clone, Copy)]
pub(super) struct Nearest {
    pub(super) distance_m: f64,
    /// Where on the segment, in the strip's frame.
    pub(super) on: Across,
}

impl Strip {
    pub(super) fn new(from: Spot, to: Spot, half_width_m: f64) -> Self {
        let frame = Frame::at(f64::midpoint(from.y, to.y));
        let (dx, dy) = ((to.x - from.x) * frame.kx_m, (to.y - from.y) * frame.ky_m);
        let length_m = dx.hypot(dy);
        let (cos, sin) = if length_m > 0.0 { (dx / length_m, dy / length_m) } else { (1.0, 0.0) };
        let reach_m = half_width_m + frame.slack_m(length_m, half_width_m);
        let (mx, my) = (reach_m / frame.kx_m, reach_m / frame.ky_m);
        Self {
            from,
            ux: frame.kx_m * cos,
            uy: frame.ky_m * sin,
            vx: -frame.kx_m * sin,
            vy: frame.ky_m * cos,
            length_m,
            reach_m,
            window: [
                from.x.min(to.x) - mx,
                from.y.min(to.y) - my,
                from.x.max(to.x) + mx,
                from.y.max(to.y) + my,
            ],
        }
    }

    /// The same strip a turn further, for what lies on the other side of ±180°.
    pub(super) fn turned(mut self, by: f64) -> Self {
        self.from.x += by;
        self.window[0] += by;
        self.window[2] += by;
        self
    }

    /// Westernmost and easternmost x that it reaches.
    pub(super) fn span_x(&self) -> (f64, f64) {
        (self.window[0], self.window[2])
    }

    pub(super) fn across(&self, vertex: Vertex) -> Across {
        let (dx, dy) = (f64::from(vertex[0]) - self.from.x, f64::from(vertex[1]) - self.from.y);
        Across { u: dx * self.ux + dy * self.uy, v: dx * self.vx + dy * self.vy }
    }

    /// The position of a point of the frame.
    pub(super) fn spot(&self, at: Across) -> Spot {
        let det = self.ux * self.vy - self.uy * self.vx;
        Spot {
            x: self.from.x + (at.u * self.vy - at.v * self.uy) / det,
            y: self.from.y + (at.v * self.ux - at.u * self.vx) / det,
        }
    }

    /// Whether a box may hold something within reach.
    pub(super) fn may_touch(&self, node: &Node) -> bool {
        let Bounds { min, max } = &node.bounds;
        let [x0, y0, x1, y1] = [f64::from(min[0]), f64::from(min[1]), f64::from(max[0]), f64::from(max[1])];
        if x0 > self.window[2] || x1 < self.window[0] || y0 > self.window[3] || y1 < self.window[1] {
            return false;
        }
        let (cx, cy) = (f64::midpoint(x0, x1) - self.from.x, f64::midpoint(y0, y1) - self.from.y);
        let (hx, hy) = ((x1 - x0) / 2.0, (y1 - y0) / 2.0);
        let v = cx * self.vx + cy * self.vy;
        v.abs() - (hx * self.vx.abs() + hy * self.vy.abs()) <= self.reach_m
    }

    /// Where a segment comes nearest to the leg, if within reach.
    pub(super) fn nearest(&self, a: Across, b: Across) -> Option<Nearest> {
        let reach_m = self.reach_m;
        let apart = (a.v > reach_m && b.v > reach_m)
            || (a.v < -reach_m && b.v < -reach_m)
            || (a.u < -reach_m && b.u < -reach_m)
            || (a.u > self.length_m + reach_m && b.u > self.length_m + reach_m);
        if apart {
            return None;
        }
        let nearest = self.nearest_anywhere(a, b);
        (nearest.distance_m <= reach_m).then_some(nearest)
    }

    /// Where a segment comes nearest to the leg.
    pub(super) fn nearest_anywhere(&self, a: Across, b: Across) -> Nearest {
        if (a.v > 0.0) != (b.v > 0.0) {
            let u = a.u + (b.u - a.u) * (a.v / (a.v - b.v));
            if (0.0..=self.length_m).contains(&u) {
                return Nearest { distance_m: 0.0, on: Across { u, v: 0.0 } };
            }
        }
        let to_leg = |point: Across| {
            let du = point.u - point.u.clamp(0.0, self.length_m);
            Nearest { distance_m: du.hypot(point.v), on: point }
        };
        let to_end = |u: f64| {
            let (du, dv) = (b.u - a.u, b.v - a.v);
            let square = du * du + dv * dv;
            let t = if square > 0.0 { (((u - a.u) * du - a.v * dv) / square).clamp(0.0, 1.0) } else { 0.0 };
            let on = Across { u: a.u + t * du, v: a.v + t * dv };
            Nearest { distance_m: (on.u - u).hypot(on.v), on }
        };
        let candidates = [to_leg(b), to_end(0.0), to_end(self.length_m)];
        candidates
            .into_iter()
            .fold(to_leg(a), |best, one| if one.distance_m < best.distance_m { one } else { best })
    }

    /// How far along the leg a disc of the strip's reach first touches a segment, and the segment's point that
    /// is nearest then.
    ///
    /// The places of the disc's centre that touch are the segment grown by the reach: convex, so the leg meets
    /// them in one interval, which begins on one of the two end circles or the two sides.
    pub(super) fn first_touch(&self, a: Across, b: Across) -> Option<(f64, Across)> {
        let nearest = self.nearest(a, b)?;
        let reach_m = self.reach_m;
        let mut first = f64::INFINITY;
        let mut consider = |u: f64| first = first.min(u);
        for end in [a, b] {
            if end.v.abs() <= reach_m {
                consider(end.u - (reach_m * reach_m - end.v * end.v).sqrt());
            }
        }
        let (du, dv) = (b.u - a.u, b.v - a.v);
        let length_m = du.hypot(dv);
        if length_m > 0.0 && dv != 0.0 {
            for side in [-1.0, 1.0] {
                let (nu, nv) = (-dv / length_m * reach_m * side, du / length_m * reach_m * side);
                let t = -(a.v + nv) / dv;
                if (0.0..=1.0).contains(&t) {
                    consider(a.u + nu + t * du);
                }
            }
        }
        // Rounding can lose a grazing touch; the nearest point is a touch in any case.
        let along_m = first.min(nearest.on.u.max(0.0)).clamp(0.0, self.length_m);
        Some((along_m, nearest_to(along_m, a, b)))
    }
}

/// The point of a segment nearest to the leg's point at `along_m`.
fn nearest_to(along_m: f64, a: Across, b: Across) -> Across {
    let (du, dv) = (b.u - a.u, b.v - a.v);
    let square = du * du + dv * dv;
    let t = if square > 0.0 { (((along_m - a.u) * du - a.v * dv) / square).clamp(0.0, 1.0) } else { 0.0 };
    Across { u: a.u + t * du, v: a.v + t * dv }
}
