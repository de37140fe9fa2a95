//! Parameters of the path tracker and the sets in use. Names in quotes are the DUNE parameters.

use super::monitor::{AlongTrackConfig, CrossTrackConfig, JumpConfig};
use crate::range::{InvalidConfig, RangeCheck};

/// All parameters of [`PathTracker`](super::PathTracker).
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathConfig {
    /// When the end counts as reached.
    pub near: NearRule,
    /// Time by which arrival is declared early (s), 0 to 60, "General/Time Of Arrival Factor".
    pub time_of_arrival_factor_s: f64,
    /// Speeds below count as this in the time to arrival (m/s), 0.05 to 5, "ETA Minimum Speed".
    pub eta_min_speed_mps: f64,
    /// Progress and course error by the course over ground rather than the heading, "Course Control".
    pub course_control: bool,
    /// Below this speed over ground the heading stands in for the noisy course (m/s), 0 to 5.
    pub course_min_speed_mps: f64,
    /// Longest leg (m), 10 to 1e6, "Maximum Track Length".
    pub max_length_m: f64,
    /// How long the tracker waits at the end for the next path (s), 3 to 10, "New Reference Timeout".
    pub new_path_timeout_s: f64,
    /// Approaching a loiter, this close to the circle is on it (m), 0.1 to 100, but never more than half the
    /// radius; `None` = only at the end of the approach, "Corridor -- Loiter".
    pub loiter_capture_m: Option<f64>,
    /// Along-track monitor; `None` = off.
    pub along_track: Option<AlongTrackConfig>,
    /// Cross-track monitor; `None` = off.
    pub cross_track: Option<CrossTrackConfig>,
    /// Jump detector.
    pub jump: JumpConfig,
}

/// When the end of a leg counts as reached.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum NearRule {
    /// When the time to arrival, shortened by the time of arrival factor, is over: at 2 m/s and 5 s this is
    /// 10 m before the end.
    TimeToArrival,
    /// Within this distance of the end (m), 0.5 to 1000, "Radius To Endpoint".
    Radius(f64),
}

impl Default for PathConfig {
    /// The thesis' values with the loiter corridor of NTNU's ILOS.
    fn default() -> Self {
        Self { loiter_capture_m: Some(5.0), ..Self::thesis() }
    }
}

impl PathConfig {
    /// The thesis' values (N. Lauvås, NTNU 2020).
    pub fn thesis() -> Self {
        Self {
            near: NearRule::TimeToArrival,
            time_of_arrival_factor_s: 5.0,
            eta_min_speed_mps: 1.0,
            course_control: true,
            course_min_speed_mps: 0.3,
            max_length_m: 25_000.0,
            new_path_timeout_s: 5.0,
            loiter_capture_m: None,
            along_track: Some(AlongTrackConfig {
                period_s: 20.0,
                min_speed_mps: 0.05,
                min_yaw_rate_rad_s: 2_f64.to_radians(),
            }),
            cross_track: Some(CrossTrackConfig {
                limit_m: 25.0,
                uncertainty_factor: None,
                time_limit_s: 20.0,
            }),
            jump: JumpConfig { threshold_m: 10.0, recovery_mps: 0.5 },
        }
    }

    /// NTNU's public values (dune-otter-public): both monitors off.
    pub fn ntnu() -> Self {
        Self {
            time_of_arrival_factor_s: 6.0,
            loiter_capture_m: Some(5.0),
            along_track: None,
            cross_track: None,
            ..Self::thesis()
        }
    }

    /// Whether every value is within its range.
    ///
    /// # Errors
    /// Names every value that is not.
    pub fn validate(&self) -> Result<(), InvalidConfig> {
        let mut check = RangeCheck::default();
        if let NearRule::Radius(radius_m) = self.near {
            check.number("near_radius", "m", radius_m, 0.5..=1000.0);
        }
        check.number("time_of_arrival_factor", "s", self.time_of_arrival_factor_s, 0.0..=60.0);
        check.number("eta_min_speed", "m/s", self.eta_min_speed_mps, 0.05..=5.0);
        check.number("course_min_speed", "m/s", self.course_min_speed_mps, 0.0..=5.0);
        check.number("max_length", "m", self.max_length_m, 10.0..=1e6);
        check.number("new_path_timeout", "s", self.new_path_timeout_s, 3.0..=10.0);
        check.optional("loiter_capture", "m", self.loiter_capture_m, 0.1..=100.0);
        if let Some(along_track) = &self.along_track {
            check.within("along_track", |check| along_track.check(check));
        }
        if let Some(cross_track) = &self.cross_track {
            check.within("cross_track", |check| cross_track.check(check));
        }
        check.within("jump", |check| self.jump.check(check));
        check.finish()
    }
}
