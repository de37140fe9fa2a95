//! Where the vessel was in the last seconds, for what is reported after it happened.
//!
//! By the steady clock: a step of the computer's time moves nothing. They are anchored on the epochs of the compass, not on the
//! arrival of its sentences. Places are those of the antenna; that of the hydrophone follows by its [`LeverArm`] and the heading
//! of the moment.

use crate::navigation::Estimate;
use detections::Pose;
use std::collections::VecDeque;
use units::{LatLon, LocalFrame, LocalPoint, MonoTime, wrap_pi};

/// How long a pose is kept (µs).
const KEPT_US: i64 = 30_000_000;
/// A time this much outside the poses kept has none (µs).
const SLACK_US: i64 = 2_000_000;

/// From the antenna whose place navigation knows to the hydrophone, in the vessel's frame (m): x forward, y to starboard,
/// z down, as in body axes of SNAME 1950. The vessel is taken to lie level: a hydrophone 1 m below its antenna is 9 cm off in
/// 5° of roll.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LeverArm {
    /// Forward.
    pub forward_m: f64,
    /// To starboard.
    pub starboard_m: f64,
    /// Down; it moves no place on the chart, and is reported with how the receiver listens.
    pub down_m: f64,
}

impl LeverArm {
    /// The horizontal length (m).
    fn length_m(&self) -> f64 {
        self.forward_m.hypot(self.starboard_m)
    }

    /// North and east of the antenna with this heading (rad).
    fn turned(&self, heading_rad: f64) -> LocalPoint {
        let (sin, cos) = heading_rad.sin_cos();
        LocalPoint {
            north_m: self.forward_m * cos - self.starboard_m * sin,
            east_m: self.forward_m * sin + self.starboard_m * cos,
        }
    }
}

/// The poses of the last seconds, in order of time.
#[derive(Debug, Clone, Default)]
pub(crate) struct Poses {
    kept: VecDeque<Kept>,
}

#[derive(Debug, Clone, Copy)]
struct Kept {
    at_us: i64,
    place: LatLon,
    /// Where the bow points (rad); absent where it is only assumed unchanged.
    heading_rad: Option<f64>,
    sigma_m: f64,
    /// When the position was measured from which this one is reckoned.
    measured_us: i64,
}

/// Microseconds of the steady clock, which counts from the program's start.
fn micros(at: MonoTime) -> i64 {
    i64::try_from(at.micros()).unwrap_or(i64::MAX)
}

impl Poses {
    /// Where the vessel is.
    pub(crate) fn at(&mut self, now: MonoTime, estimate: &Estimate) {
        // Its position is reckoned on from the moment at which it came.
        let at_us = micros(now.before(estimate.lag));
        let age_us = i64::try_from(estimate.age.as_micros()).unwrap_or(i64::MAX);
        self.keep(Kept {
            at_us,
            place: estimate.place,
            heading_rad: Some(estimate.motion.heading_rad).filter(|_| !estimate.is_heading_old()),
            sigma_m: estimate.sigma_m,
            measured_us: at_us.saturating_sub(age_us),
        });
    }

    fn keep(&mut self, pose: Kept) {
        // Epochs are not always as long under way.
        while self.kept.back().is_some_and(|last| pose.at_us <= last.at_us) {
            self.kept.pop_back();
        }
        self.kept.push_back(pose);
        while self.kept.front().is_some_and(|first| pose.at_us - first.at_us > KEPT_US) {
            self.kept.pop_front();
        }
    }

    /// Where the hydrophone was at a time (µs of the steady clock), interpolated between the poses about it; its age is the time
    /// to the nearest measured position, and its deviation the larger of both. Where the heading is not known the place is the
    /// antenna's, and its deviation greater by the arm.
    pub(crate) fn then(&self, at_us: i64, arm: &LeverArm) -> Option<Pose> {
        let after = self.kept.partition_point(|pose| pose.at_us <= at_us);
        let (before, next) = (after.checked_sub(1).and_then(|i| self.kept.get(i)), self.kept.get(after));
        match (before, next) {
            (Some(one), Some(other)) => {
                let share = (at_us - one.at_us) as f64 / (other.at_us - one.at_us).max(1) as f64;
                let (p0, p1) = (one.place, other.place);
                let place = LatLon::from_rad(
                    p0.lat_rad() + share * (p1.lat_rad() - p0.lat_rad()),
                    wrap_pi(p0.lon_rad() + share * wrap_pi(p1.lon_rad() - p0.lon_rad())),
                );
                let heading_rad = one.heading_rad.zip(other.heading_rad);
                let heading_rad = heading_rad.map(|(h0, h1)| wrap_pi(h0 + share * wrap_pi(h1 - h0)));
                let age_s = age_s(at_us, one).min(age_s(at_us, other));
                let sigma_m = one.sigma_m.max(other.sigma_m);
                Some(at_hydrophone(place.ok()?, heading_rad, age_s, sigma_m, arm))
            }
            (Some(only), None) | (None, Some(only)) => {
                let near = (at_us - only.at_us).abs() <= SLACK_US;
                let age_s = age_s(at_us, only);
                near.then(|| at_hydrophone(only.place, only.heading_rad, age_s, only.sigma_m, arm))
            }
            (None, None) => None,
        }
    }
}

/// The pose of the hydrophone beside that of the antenna.
fn at_hydrophone(
    antenna: LatLon,
    heading_rad: Option<f64>,
    age_s: f64,
    sigma_m: f64,
    arm: &LeverArm,
) -> Pose {
    let length_m = arm.length_m();
    let (place, more_m) = match heading_rad {
        _ if length_m == 0.0 => (antenna, 0.0),
        Some(heading_rad) => (LocalFrame::new(antenna).to_place(arm.turned(heading_rad)), 0.0),
        None => (antenna, length_m),
    };
    Pose { place, age_s: Some(age_s), sigma_m: Some(sigma_m + more_m) }
}

/// Time between a moment and the measurement behind a pose (s).
fn age_s(at_us: i64, pose: &Kept) -> f64 {
    (at_us - pose.measured_us).unsigned_abs() as f64 / 1e6
}

#[cfg(test)]
mod tests {
    use super::*;

    const NO_ARM: LeverArm = LeverArm { forward_m: 0.0, starboard_m: 0.0, down_m: 1.0 };

    fn kept(s: i64, lat_deg: f64, age_s: i64, sigma_m: f64) -> Kept {
        let place = LatLon::from_deg(lat_deg, 10.0).unwrap();
        let at_us = s * 1_000_000;
        Kept { at_us, place, heading_rad: Some(0.0), sigma_m, measured_us: at_us - age_s * 1_000_000 }
    }

    #[test]
    fn interpolates_between_poses_and_knows_none_far_away() {
        let mut poses = Poses::default();
        poses.keep(kept(100, 63.0, 0, 1.0));
        poses.keep(kept(102, 63.2, 0, 1.0));
        let lat_deg = |s: i64| poses.then(s * 1_000_000, &NO_ARM).map(|pose| pose.place.lat_deg());
        assert!((lat_deg(101).unwrap() - 63.1).abs() < 1e-9);
        assert!((lat_deg(103).unwrap() - 63.2).abs() < 1e-9);
        assert_eq!((lat_deg(110), lat_deg(90)), (None, None));
    }

    #[test]
    fn a_pose_tells_how_far_the_nearest_measurement_is_and_how_sure_it_is() {
        let mut poses = Poses::default();
        // Measured at 100 s, reckoned on until 108 s, measured again then.
        poses.keep(kept(104, 63.0, 4, 3.0));
        poses.keep(kept(106, 63.0, 6, 4.0));
        poses.keep(kept(108, 63.0, 0, 1.0));
        let pose = |s: i64| poses.then(s * 1_000_000, &NO_ARM);
        let told = |s| pose(s).map(|pose| (pose.age_s.unwrap(), pose.sigma_m.unwrap()));
        assert_eq!(told(105), Some((5.0, 4.0)));
        assert_eq!(told(107), Some((1.0, 4.0)), "the one to come is nearer");
        assert_eq!(told(108), Some((0.0, 1.0)));
        assert_eq!(told(110), Some((2.0, 1.0)));
        assert_eq!(told(103), Some((3.0, 3.0)));
    }

    #[test]
    fn the_arm_turns_with_the_heading_of_the_moment_and_widens_the_deviation_without_one() {
        let arm = LeverArm { forward_m: -0.8, starboard_m: 0.3, down_m: 1.0 };
        let headed = |s, heading_rad| Kept { heading_rad, ..kept(s, 63.0, 0, 1.0) };
        let mut poses = Poses::default();
        // From 170° over south to -170°.
        poses.keep(headed(100, Some(170.0_f64.to_radians())));
        poses.keep(headed(102, Some(-170.0_f64.to_radians())));
        poses.keep(headed(104, None));
        let antenna = LocalFrame::new(LatLon::from_deg(63.0, 10.0).unwrap());
        let beside = |s: i64| {
            let pose = poses.then(s * 1_000_000, &arm).unwrap();
            let LocalPoint { north_m, east_m } = antenna.to_local(pose.place);
            (north_m, east_m, pose.sigma_m.unwrap())
        };
        let (north_m, east_m, sigma_m) = beside(101);
        // Bow to the south: aft is north, starboard is west.
        assert!((north_m - 0.8).abs() < 1e-3 && (east_m + 0.3).abs() < 1e-3, "{north_m} {east_m}");
        assert!((sigma_m - 1.0).abs() < 1e-9);
        let (north_m, east_m, sigma_m) = beside(103);
        assert!(north_m.hypot(east_m) < 1e-6, "the antenna's own place");
        assert!((sigma_m - 1.0 - 0.8_f64.hypot(0.3)).abs() < 1e-9);
    }
}
