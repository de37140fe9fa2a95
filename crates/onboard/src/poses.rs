//! Where the vessel was in the last seconds, for what is reported after it happened.

use crate::navigation::Estimate;
use detections::Pose;
use std::collections::VecDeque;
use units::{LatLon, UtcTime};

/// How long a pose is kept (µs).
const KEPT_US: i64 = 30_000_000;
/// A time this much outside the poses kept has none (µs).
const SLACK_US: i64 = 2_000_000;

/// The poses of the last seconds, in order of time.
#[derive(Debug, Clone, Default)]
pub(crate) struct Poses {
    kept: VecDeque<Kept>,
}

#[derive(Debug, Clone, Copy)]
struct Kept {
    utc: UtcTime,
    place: LatLon,
    sigma_m: f64,
    /// When the position was measured from which this one is reckoned.
    measured: UtcTime,
}

impl Poses {
    /// Where the vessel is.
    pub(crate) fn at(&mut self, utc: UtcTime, estimate: &Estimate) {
        let age_us = i64::try_from(estimate.age.as_micros()).unwrap_or(i64::MAX);
        let measured = UtcTime::from_micros(utc.micros().saturating_sub(age_us));
        self.keep(Kept { utc, place: estimate.place, sigma_m: estimate.sigma_m, measured });
    }

    fn keep(&mut self, pose: Kept) {
        if self.kept.back().is_some_and(|last| pose.utc <= last.utc) {
            // The clock was set back: what is kept has the old time.
            self.kept.clear();
        }
        self.kept.push_back(pose);
        while self.kept.front().is_some_and(|first| pose.utc - first.utc > KEPT_US) {
            self.kept.pop_front();
        }
    }

    /// Where the vessel was at a time, interpolated between the poses about it; its age is the time to the nearest measured
    /// position, and its deviation the larger of both.
    pub(crate) fn then(&self, utc: UtcTime) -> Option<Pose> {
        let after = self.kept.partition_point(|pose| pose.utc <= utc);
        let (before, next) = (after.checked_sub(1).and_then(|i| self.kept.get(i)), self.kept.get(after));
        match (before, next) {
            (Some(one), Some(other)) => {
                let share = (utc - one.utc) as f64 / (other.utc - one.utc).max(1) as f64;
                let (p0, p1) = (one.place, other.place);
                let place = LatLon::from_rad(
                    p0.lat_rad() + share * (p1.lat_rad() - p0.lat_rad()),
                    units::wrap_pi(p0.lon_rad() + share * units::wrap_pi(p1.lon_rad() - p0.lon_rad())),
                );
                let age_s = age_s(utc, one).min(age_s(utc, other));
                let sigma_m = one.sigma_m.max(other.sigma_m);
                Some(Pose { place: place.ok()?, age_s: Some(age_s), sigma_m: Some(sigma_m) })
            }
            (Some(only), None) | (None, Some(only)) => ((utc - only.utc).abs() <= SLACK_US).then(|| Pose {
                place: only.place,
                age_s: Some(age_s(utc, only)),
                sigma_m: Some(only.sigma_m),
            }),
            (None, None) => None,
        }
    }
}

/// Time between a moment and the measurement behind a pose (s).
fn age_s(utc: UtcTime, pose: &Kept) -> f64 {
    (utc - pose.measured).unsigned_abs() as f64 / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    fn second(s: i64) -> UtcTime {
        UtcTime::from_micros(s * 1_000_000)
    }

    fn kept(s: i64, lat_deg: f64, age_s: i64, sigma_m: f64) -> Kept {
        let place = LatLon::from_deg(lat_deg, 10.0).unwrap();
        Kept { utc: second(s), place, sigma_m, measured: second(s - age_s) }
    }

    #[test]
    fn interpolates_between_poses_and_knows_none_far_away() {
        let mut poses = Poses::default();
        poses.keep(kept(100, 63.0, 0, 1.0));
        poses.keep(kept(102, 63.2, 0, 1.0));
        let lat_deg = |poses: &Poses, s| poses.then(second(s)).map(|pose| pose.place.lat_deg());
        assert!((lat_deg(&poses, 101).unwrap() - 63.1).abs() < 1e-9);
        assert!((lat_deg(&poses, 103).unwrap() - 63.2).abs() < 1e-9);
        assert_eq!((lat_deg(&poses, 110), lat_deg(&poses, 90)), (None, None));
        poses.keep(kept(50, 62.0, 0, 1.0));
        assert_eq!(lat_deg(&poses, 101), None);
    }

    #[test]
    fn a_pose_tells_how_far_the_nearest_measurement_is_and_how_sure_it_is() {
        let mut poses = Poses::default();
        // Measured at 100 s, reckoned on until 108 s, measured again then.
        poses.keep(kept(104, 63.0, 4, 3.0));
        poses.keep(kept(106, 63.0, 6, 4.0));
        poses.keep(kept(108, 63.0, 0, 1.0));
        let told = |s| poses.then(second(s)).map(|pose| (pose.age_s.unwrap(), pose.sigma_m.unwrap()));
        assert_eq!(told(105), Some((5.0, 4.0)));
        assert_eq!(told(107), Some((1.0, 4.0)), "the one to come is nearer");
        assert_eq!(told(108), Some((0.0, 1.0)));
        assert_eq!(told(110), Some((2.0, 1.0)));
        assert_eq!(told(103), Some((3.0, 3.0)));
    }
}
