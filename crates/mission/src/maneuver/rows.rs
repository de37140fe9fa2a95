//! Rows: sweeps a rectangle in parallel lines. Its machine is [`waypoints`](super::waypoints).
//!
//! Points are laid out in a frame with x along the bearing and y to the right, relative steps being: approach
//! (-offset, 0), start (+offset, 0), up (length + offset, 0), curve, down (-(length + offset), 0), curve, and
//! again from up. A curve steps sideways by step·alternation/100 (at the upper end) or
//! step·(2 - alternation/100) (at the lower end) and back along by the offset, in one diagonal or, square, in
//! two steps. The sideways step is turned clockwise by the cross angle. The pattern ends before a sideways
//! step that would bring the sum of the steps beyond the width.

use crate::checks::Checks;
use crate::place::RawPlace;
use units::Speed;
use units::{LatLon, LocalPoint};

/// Least length, width and step (m).
pub(super) const LEAST_M: f64 = 1e-3;

/// Sweep an area in parallel lines.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rows<P = LatLon> {
    /// Where the first row starts.
    pub origin: P,
    /// How fast.
    pub speed: Speed,
    /// Direction of the first row (rad).
    pub bearing_rad: f64,
    /// How far the sideways step is turned clockwise (rad).
    pub cross_angle_rad: f64,
    /// Extent across the rows (m).
    pub width_m: f64,
    /// Length of a row (m).
    pub length_m: f64,
    /// Distance between rows (m).
    pub step_m: f64,
    /// How far rows are overrun before turning (m).
    pub curve_offset_m: f64,
    /// How the step is shared between upper and lower curves, 0 to 1; 1 is the same everywhere.
    pub alternation: f64,
    /// Turns are squares instead of diagonals.
    pub square_curve: bool,
    /// The first curve goes to the right.
    pub curve_right: bool,
}

impl Rows<RawPlace> {
    pub(crate) fn check(&self, checks: &mut Checks<'_>) -> Option<Rows> {
        checks.speed(self.speed);
        checks.finite("bearing", self.bearing_rad);
        checks.finite("cross angle", self.cross_angle_rad);
        checks.at_least("width", self.width_m, LEAST_M);
        checks.at_least("length", self.length_m, LEAST_M);
        checks.at_least("step", self.step_m, LEAST_M);
        checks.at_least("curve offset", self.curve_offset_m, 0.0);
        checks.within("alternation", self.alternation, 0.0, 1.0);
        // Two curves make two steps whatever the alternation; three points, a square curve's, per row.
        let points = 3.0 * (self.width_m / self.step_m + 2.0);
        if points.is_finite() {
            checks.points(points as usize);
        }
        Some(self.at(checks.place(self.origin)?))
    }
}

impl<P> Rows<P> {
    /// The same rows from elsewhere.
    pub(super) fn at<Q>(&self, origin: Q) -> Rows<Q> {
        Rows {
            origin,
            speed: self.speed,
            bearing_rad: self.bearing_rad,
            cross_angle_rad: self.cross_angle_rad,
            width_m: self.width_m,
            length_m: self.length_m,
            step_m: self.step_m,
            curve_offset_m: self.curve_offset_m,
            alternation: self.alternation,
            square_curve: self.square_curve,
            curve_right: self.curve_right,
        }
    }
}

impl Rows {
    /// The points, as metres north and east of the origin.
    pub fn points(&self) -> RowsPoints {
        RowsPoints {
            rows: *self,
            stage: Stage::Approach,
            along_m: 0.0,
            across_m: 0.0,
            steps_m: 0.0,
            step_scale: 1.0,
        }
    }
}

/// The points of rows, one after the other.
#[derive(Debug, Clone)]
pub struct RowsPoints {
    rows: Rows,
    stage: Stage,
    along_m: f64,
    across_m: f64,
    /// Sum of the sideways steps, cross angle left out (m).
    steps_m: f64,
    /// Sideways steps are taken times this.
    step_scale: f64,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    Approach,
    Start,
    Up,
    CurveUp,
    /// Second half of a square curve.
    EndCurveUp,
    Down,
    CurveDown,
    EndCurveDown,
    End,
}

impl RowsPoints {
    /// Makes the sideways steps to come `scale` times as wide.
    pub(super) fn scale_step(&mut self, scale: f64) {
        self.step_scale = scale;
    }

    fn go(&mut self, along_m: f64) {
        self.along_m += along_m;
    }

    /// The first point of a curve that goes back `back_m`; false when the pattern ends before it.
    fn curve(&mut self, share: f64, back_m: f64) -> bool {
        let side = if self.rows.curve_right { 1.0 } else { -1.0 };
        let step_m = side * self.rows.step_m * share * self.step_scale;
        if (self.steps_m + step_m).abs() > self.rows.width_m * (1.0 + 1e-9) {
            return false;
        }
        self.steps_m += step_m;
        let (sin, cos) = self.rows.cross_angle_rad.sin_cos();
        self.along_m -= step_m * sin;
        self.across_m += step_m * cos;
        if !self.rows.square_curve {
            self.go(back_m);
        }
        true
    }
}

impl Iterator for RowsPoints {
    type Item = LocalPoint;

    fn next(&mut self) -> Option<LocalPoint> {
        let (offset_m, row_m) = (self.rows.curve_offset_m, self.rows.length_m + self.rows.curve_offset_m);
        let square = self.rows.square_curve;
        let stage = self.stage;
        self.stage = match stage {
            Stage::Approach => {
                self.go(-offset_m);
                Stage::Start
            }
            Stage::Start | Stage::EndCurveDown => {
                self.go(offset_m);
                Stage::Up
            }
            Stage::Up => {
                self.go(row_m);
                Stage::CurveUp
            }
            Stage::CurveUp if !self.curve(self.rows.alternation, -offset_m) => Stage::End,
            Stage::CurveUp if square => Stage::EndCurveUp,
            Stage::CurveUp => Stage::Down,
            Stage::EndCurveUp => {
                self.go(-offset_m);
                Stage::Down
            }
            Stage::Down => {
                self.go(-row_m);
                Stage::CurveDown
            }
            Stage::CurveDown if !self.curve(2.0 - self.rows.alternation, offset_m) => Stage::End,
            Stage::CurveDown if square => Stage::EndCurveDown,
            Stage::CurveDown => Stage::Up,
            Stage::End => Stage::End,
        };
        if self.stage == Stage::End {
            return None;
        }
        let (sin, cos) = self.rows.bearing_rad.sin_cos();
        Some(LocalPoint {
            north_m: self.along_m * cos - self.across_m * sin,
            east_m: self.along_m * sin + self.across_m * cos,
        })
    }
}
