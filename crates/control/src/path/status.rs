//! The status of a path tracker: the vessel's place on its path, changes, faults.

use super::command::Loiter;
use std::f64::consts::FRAC_PI_2;
use thiserror::Error;
use units::{LatLon, wrap_pi};

/// A fault of the path under way. It stays until the next path or
/// [`PathTracker::stop`](super::PathTracker::stop).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum PathFault {
    /// The end was reached and no new path came in time.
    #[error("the end was reached and no new path came")]
    NoNewPath,
    /// The vessel does not get on along the track.
    #[error("no progress along the track")]
    NoProgress,
    /// The vessel is too far from the track.
    #[error("too far from the track")]
    OffTrack,
}

/// The changes by this update; to be reported at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PathEvent {
    /// The end came near.
    Near,
    /// The circle began.
    Loitering,
}

/// Where the vessel is on a straight leg.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct LegPosition {
    /// Distance from the start along the track (m).
    pub along_m: f64,
    /// Distance from the track, positive to starboard (m).
    pub cross_m: f64,
    /// Length of the leg (m).
    pub length_m: f64,
    /// Direction of the track at the vessel (rad).
    pub bearing_rad: f64,
    /// Direction from the vessel to the end (rad).
    pub end_bearing_rad: f64,
}

/// Where the vessel is on a circle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CirclePosition {
    /// Distance from the centre (m).
    pub range_m: f64,
    /// Direction from the vessel to the centre (rad).
    pub centre_bearing_rad: f64,
    /// Radius (m) and sense.
    pub loiter: Loiter,
}

impl CirclePosition {
    /// Direction of the tangent at the vessel, in the sense of the circle (rad).
    pub fn tangent_rad(&self) -> f64 {
        wrap_pi(self.centre_bearing_rad - self.loiter.turn.sign() * FRAC_PI_2)
    }

    /// Distance outside the circle (m); negative inside.
    pub fn outside_m(&self) -> f64 {
        self.range_m - self.loiter.radius_m
    }
}

/// Where the vessel is relative to what it follows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Geometry {
    /// A straight leg.
    Leg(LegPosition),
    /// A circle.
    Circle(CirclePosition),
}

impl Geometry {
    /// Distance from the track, positive to starboard (m).
    pub fn cross_m(&self) -> f64 {
        match self {
            Self::Leg(leg) => leg.cross_m,
            Self::Circle(circle) => -circle.loiter.turn.sign() * circle.outside_m(),
        }
    }

    /// Direction of the track, or of the circle's tangent, at the vessel (rad).
    pub fn bearing_rad(&self) -> f64 {
        match self {
            Self::Leg(leg) => leg.bearing_rad,
            Self::Circle(circle) => circle.tangent_rad(),
        }
    }
}

/// The state of a path after an update.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathStatus {
    /// Number of the path.
    pub path_ref: u32,
    /// Where it starts.
    pub start: LatLon,
    /// Where it ends, or the centre of its loiter.
    pub end: LatLon,
    /// Circle around the end.
    pub loiter: Option<Loiter>,
    /// Where the vessel is on it.
    pub geometry: Geometry,
    /// Distance left along the track (m); 0 on a circle.
    pub left_m: f64,
    /// Distance to the end or centre (m).
    pub range_m: f64,
    /// Course minus track direction (rad).
    pub course_error_rad: f64,
    /// Speed that progress is reckoned with (m/s).
    pub speed_mps: f64,
    /// Time to arrival (s), 0 to 65535.
    pub eta_s: u16,
    /// Whether the end is near; stays so for the rest of this path.
    pub near: bool,
    /// Whether the vessel is on the circle.
    pub loitering: bool,
    /// What changed.
    pub event: Option<PathEvent>,
    /// What is wrong.
    pub fault: Option<PathFault>,
}
