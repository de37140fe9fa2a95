//! Monitors of a path: does the vessel make progress, is it near the track, did its position jump?
//!
//! After DUNE's path controller. All are pure: times and distances come in, a verdict goes out.

use crate::range::RangeCheck;
use std::time::Duration;
use units::MonoTime;

/// Longest time a jump may silence the monitors.
const LONGEST_SILENCE: Duration = Duration::from_secs(100);

/// Parameters of the along-track monitor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct AlongTrackConfig {
    /// Time between two looks (s), 1 to 600.
    pub period_s: f64,
    /// Least progress along the track while heading along it (m/s), 0 to 5.
    pub min_speed_mps: f64,
    /// Least decrease of the course error while turning towards the track (rad/s), 0 to 1.
    pub min_yaw_rate_rad_s: f64,
}

/// Parameters of the cross-track monitor.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct CrossTrackConfig {
    /// Largest distance from the track (m), 0.5 to 1000.
    pub limit_m: f64,
    /// Times √max(σx, σy) of the position, added to the limit, 0 to 100; `None` = not.
    pub uncertainty_factor: Option<f64>,
    /// How long the vessel may stay beyond (s), 0.1 to 600.
    pub time_limit_s: f64,
}

/// Parameters of the jump detector.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct JumpConfig {
    /// Distance between consecutive positions, beyond what the speed explains, that is a jump (m), 0.5 to 1000.
    pub threshold_m: f64,
    /// The monitors rest for distance / factor (m/s), 0.01 to 10; at most 100 s.
    pub recovery_mps: f64,
}

impl AlongTrackConfig {
    pub(super) fn check(&self, check: &mut RangeCheck) {
        check.number("period", "s", self.period_s, 1.0..=600.0);
        check.number("min_speed", "m/s", self.min_speed_mps, 0.0..=5.0);
        check.number("min_yaw_rate", "rad/s", self.min_yaw_rate_rad_s, 0.0..=1.0);
    }
}

impl CrossTrackConfig {
    pub(super) fn check(&self, check: &mut RangeCheck) {
        check.number("limit", "m", self.limit_m, 0.5..=1000.0);
        check.optional("uncertainty_factor", "1", self.uncertainty_factor, 0.0..=100.0);
        check.number("time_limit", "s", self.time_limit_s, 0.1..=600.0);
    }
}

impl JumpConfig {
    pub(super) fn check(&self, check: &mut RangeCheck) {
        check.number("threshold", "m", self.threshold_m, 0.5..=1000.0);
        check.number("recovery", "m/s", self.recovery_mps, 0.01..=10.0);
    }
}

/// Fails when two looks in a row see too little progress.
#[derive(Debug, Clone, Default)]
pub(super) struct AlongTrackMonitor {
    last: Option<Observation>,
    failed_once: bool,
}

#[derive(Debug, Clone, Copy)]
struct Observation {
    at: MonoTime,
    along_m: f64,
    course_error_rad: f64,
}

impl AlongTrackMonitor {
    /// True when progress has been too small for two periods.
    pub(super) fn update(
        &mut self,
        config: &AlongTrackConfig,
        now: MonoTime,
        along_m: f64,
        course_error_rad: f64,
    ) -> bool {
        let look = Observation { at: now, along_m, course_error_rad: course_error_rad.abs() };
        let Some(last) = self.last else {
            self.last = Some(look);
            return false;
        };
        let elapsed_s = now.since(last.at).as_secs_f64();
        if elapsed_s < config.period_s {
            return false;
        }
        self.last = Some(look);
        let enough = if look.course_error_rad < std::f64::consts::FRAC_PI_2 {
            along_m - last.along_m >= elapsed_s * config.min_speed_mps
        } else {
            last.course_error_rad - look.course_error_rad >= elapsed_s * config.min_yaw_rate_rad_s
        };
        let failed = !enough && self.failed_once;
        self.failed_once = !enough;
        failed
    }
}

/// Fails when the vessel stays beyond the limit for too long.
#[derive(Debug, Clone, Default)]
pub(super) struct CrossTrackMonitor {
    beyond_since: Option<MonoTime>,
}

impl CrossTrackMonitor {
    /// True when the vessel has been off the track for too long. `variance_m2` is the larger of σx and σy as
    /// IMC's NavigationUncertainty gives them (variances, m²).
    pub(super) fn update(
        &mut self,
        config: &CrossTrackConfig,
        now: MonoTime,
        cross_m: f64,
        variance_m2: Option<f64>,
    ) -> bool {
        let slack_m = match (config.uncertainty_factor, variance_m2) {
            (Some(factor), Some(variance_m2)) => factor * variance_m2.max(0.0).sqrt(),
            _ => 0.0,
        };
        if cross_m.abs() <= config.limit_m + slack_m {
            self.beyond_since = None;
            return false;
        }
        let since = *self.beyond_since.get_or_insert(now);
        now.since(since).as_secs_f64() >= config.time_limit_s
    }
}

/// How long the monitors rest after a jump of `distance_m`; `None` where it was not a jump. `explained_m` is the
/// distance that speed and time explain.
pub(super) fn silence_after(config: &JumpConfig, distance_m: f64, explained_m: f64) -> Option<Duration> {
    (distance_m > config.threshold_m + explained_m).then(|| {
        let silence_s = (distance_m / config.recovery_mps).min(LONGEST_SILENCE.as_secs_f64());
        Duration::from_secs_f64(silence_s)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALONG: AlongTrackConfig =
        AlongTrackConfig { period_s: 20.0, min_speed_mps: 0.05, min_yaw_rate_rad_s: 0.035 };

    fn at(seconds: u64) -> MonoTime {
        MonoTime::from_micros(seconds * 1_000_000)
    }

    #[test]
    fn two_looks_without_progress_fail() {
        // along, course error in degrees, at 20 s steps -> failed
        for (case, rows) in [
            ("stuck", vec![(0.0, 0.0, false), (0.5, 0.0, false), (0.9, 0.0, true)]),
            (
                "one slow look",
                vec![(0.0, 0.0, false), (0.5, 0.0, false), (20.0, 0.0, false), (20.1, 0.0, false)],
            ),
            (
                "turning",
                vec![(0.0, 170.0, false), (-9.0, 120.0, false), (-9.0, 70.0, false), (9.0, 60.0, false)],
            ),
            ("not turning", vec![(0.0, 170.0, false), (-9.0, 169.0, false), (-9.0, 168.0, true)]),
        ] {
            let mut monitor = AlongTrackMonitor::default();
            for (n, (along_m, error_deg, failed)) in rows.into_iter().enumerate() {
                let error_rad = f64::to_radians(error_deg);
                let now = at(20 * n as u64);
                assert_eq!(monitor.update(&ALONG, now, along_m, error_rad), failed, "{case}, look {n}");
                assert!(!monitor.update(&ALONG, now, along_m, error_rad), "{case}: no look between periods");
            }
        }
    }

    #[test]
    fn off_track_fails_after_its_time_only() {
        let config = CrossTrackConfig { limit_m: 25.0, uncertainty_factor: None, time_limit_s: 20.0 };
        let mut monitor = CrossTrackMonitor::default();
        for (t, cross_m, failed) in
            [(0, -26.0, false), (19, -30.0, false), (20, 24.0, false), (21, 26.0, false), (41, 26.0, true)]
        {
            assert_eq!(monitor.update(&config, at(t), cross_m, Some(9.0)), failed, "{t} s");
        }
        let generous = CrossTrackConfig { uncertainty_factor: Some(2.0), ..config };
        assert!(!CrossTrackMonitor::default().update(&generous, at(0), 30.0, Some(9.0)));
    }

    #[test]
    fn a_jump_silences_by_its_length() {
        let config = JumpConfig { threshold_m: 10.0, recovery_mps: 0.5 };
        assert_eq!(silence_after(&config, 10.0, 0.0), None);
        assert_eq!(silence_after(&config, 12.0, 3.0), None);
        assert_eq!(silence_after(&config, 20.0, 0.0), Some(Duration::from_secs(40)));
        assert_eq!(silence_after(&config, 5000.0, 0.0), Some(Duration::from_secs(100)));
    }
}
