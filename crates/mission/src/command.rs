//! Commands of a maneuver to the vessel's control.

use units::Speed;
use units::{LatLon, Turn};

/// A command to the control, valid until the next. Commands exclude each other.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Command {
    /// All control loops off, motors stopped: the vessel drifts and listens.
    Drift,
    /// Follow a path, from its beginning.
    Follow(Path),
    /// Continue along the path under way with another speed.
    ChangeSpeed(Speed),
    /// Let an operator steer.
    Teleoperate(Operator),
}

/// A path to follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Path {
    /// Number that identifies its progress; it only grows.
    pub path_ref: u32,
    /// Where it starts.
    pub start: PathStart,
    /// Where it ends, or the centre of its circle.
    pub end: LatLon,
    /// How fast.
    pub speed: Speed,
    /// A circle around the end, for as long as no other command comes.
    pub circle: Option<Circle>,
}

/// Where a path starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PathStart {
    /// At the end of the path before if that was just reached, else at the vessel.
    Chained,
    /// At the vessel (IMC flag DIRECT).
    Here,
    /// At a place (IMC flag START).
    At(LatLon),
}

/// A circle to loiter on.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Circle {
    /// Radius (m), above 0.
    pub radius_m: f64,
    /// Sense.
    pub turn: Turn,
}

/// Who may steer.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Operator {
    /// Any sender.
    Anyone,
    /// The system of this address only.
    System(u16),
}

impl Operator {
    /// Whether the system of this address may steer.
    pub fn admits(self, system: u16) -> bool {
        match self {
            Self::Anyone => true,
            Self::System(only) => only == system,
        }
    }
}

/// Which kind of control is on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Drive {
    /// None; the motors rest.
    #[default]
    Off,
    /// A path is followed.
    Path,
    /// An operator steers.
    Teleoperation(Operator),
}

impl Command {
    /// The kind of control this command leaves on, `before` being what was on.
    pub fn drive(&self, before: Drive) -> Drive {
        match self {
            Self::Drift => Drive::Off,
            Self::Follow(_) => Drive::Path,
            Self::ChangeSpeed(_) => before,
            Self::Teleoperate(operator) => Drive::Teleoperation(*operator),
        }
    }
}
