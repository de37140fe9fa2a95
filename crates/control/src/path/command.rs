//! The inputs of a path tracker: fixes and paths, and why it may refuse them.

use crate::motion::Motion;
use thiserror::Error;
use units::{LatLon, Turn};

/// Largest loiter radius (m).
const LARGEST_RADIUS_M: f64 = 5_000.0;

/// Where and how the vessel is.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Fix {
    /// Position.
    pub place: LatLon,
    /// Heading and velocity.
    pub motion: Motion,
    /// Larger variance of the two horizontal position components (m²), where known.
    pub variance_m2: Option<f64>,
}

/// A circle around the end of a path.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Loiter {
    /// Radius (m), above 0 up to 5 km.
    pub radius_m: f64,
    /// Sense of turning.
    pub turn: Turn,
}

/// Where a path starts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PathStart {
    /// At the end of the path before if that was reached and has not been over for more than 1 s, else here.
    Chained,
    /// At the vessel (flag DIRECT).
    Here,
    /// At a place (flag START).
    At(LatLon),
}

/// Where a path ends, or the centre of its loiter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum PathEnd {
    /// At a place.
    At(LatLon),
    /// At the vessel; only with a loiter (flag LOITER_CURR).
    Here,
}

/// A path to follow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathCommand {
    /// Number that identifies its status.
    pub path_ref: u32,
    /// Where it starts.
    pub start: PathStart,
    /// Where it ends.
    pub end: PathEnd,
    /// Circle around the end.
    pub loiter: Option<Loiter>,
}

/// Why a path was not taken or no status can be given. The path in use, if any, stays.
#[derive(Debug, Clone, Copy, PartialEq, Error)]
pub enum PathError {
    /// No path is followed.
    #[error("no path is followed")]
    Idle,
    /// The fix holds a value that is not a number.
    #[error("the vessel's motion is not a number")]
    NotFinite,
    /// The leg is longer than allowed.
    #[error("the leg is {length_m:.0} m long, {limit_m:.0} m are allowed")]
    TooLong {
        /// Its length (m).
        length_m: f64,
        /// The limit (m).
        limit_m: f64,
    },
    /// The loiter radius is not a number above 0 and up to 5 km.
    #[error("a loiter radius of {0} m is not possible")]
    Radius(f64),
    /// A path that ends where the vessel is needs a loiter.
    #[error("a path that ends where the vessel is needs a loiter radius")]
    NoRadius,
}

impl PathCommand {
    /// Where the path ends, or the centre of its loiter, for a vessel at `place`.
    pub(super) fn target(&self, place: LatLon) -> Result<LatLon, PathError> {
        if let Some(Loiter { radius_m, .. }) = self.loiter
            && !(radius_m > 0.0 && radius_m <= LARGEST_RADIUS_M)
        {
            return Err(PathError::Radius(radius_m));
        }
        match (self.end, self.loiter) {
            (PathEnd::At(end), _) => Ok(end),
            (PathEnd::Here, Some(_)) => Ok(place),
            (PathEnd::Here, None) => Err(PathError::NoRadius),
        }
    }
}
