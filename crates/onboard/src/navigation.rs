//! From a GNSS compass to the state of the vessel.
//!
//! Positions pass gates first: they must be there, be numbers on Earth, good enough (dilution), newer than the
//! last, and within reach of where the vessel can be. What fails says why. A position out of reach is a jump:
//! it is refused, the vessel is reckoned onwards, and only when three in a row agree with each other is the
//! new place believed. Between positions, and over gaps up to a limit, position follows from velocity and
//! heading from the rate of turn, with an uncertainty that grows; beyond the limit there is no estimate, and
//! without an estimate nobody steers.
//!
//! Heading (where the bow points, from the compass) and course (where the vessel goes, from the receiver's
//! velocity) are never mixed: north and east velocities are kept, surge and sway follow from them and the
//! heading, v = sog·sin(cog - ψ) (facts/onboard.md 3.1, where the original has the sign wrong).
//!
//! Units: radians, metres, seconds. x north, y east of a reference that stays until it is too far away.

use crate::input::{GnssFix, GnssReading};
use control::Motion;
use std::time::Duration;
use units::{LatLon, LocalFrame, LocalPoint, MonoTime, UtcTime, wrap_pi};

/// Positions that must agree before a jump is believed.
const JUMP_AGREE: u32 = 3;
/// No boat of ours turns faster (rad/s) or runs faster (m/s); what is more is nonsense.
const FASTEST_TURN_RAD_S: f64 = 3.0;
const FASTEST_MPS: f64 = 30.0;

/// Parameters of [`Navigation`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct NavigationSettings {
    /// Estimates a second (Hz), 2.5 to 25.
    pub rate_hz: f64,
    /// Positions with a larger dilution are refused.
    pub max_hdop: f64,
    /// Without a good position for so long there is no estimate (s).
    pub reckoning_s: f64,
    /// Without a heading for so long there is no estimate (s).
    pub heading_timeout_s: f64,
    /// Farther than this from the reference a new one is taken (m).
    pub origin_distance_m: f64,
    /// Speed above which the way between two positions is a jump (m/s).
    pub jump_speed_mps: f64,
    /// Slack of that test (m).
    pub jump_slack_m: f64,
    /// Share of a position's deviation from the reckoned one that is taken over, above 0 to 1.
    pub position_gain: f64,
    /// Standard deviation of a position at dilution 1 (m).
    pub sigma_m: f64,
    /// Growth of the standard deviation without positions (m/s).
    pub drift_mps: f64,
}

impl Default for NavigationSettings {
    fn default() -> Self {
        Self {
            rate_hz: 5.0,
            max_hdop: 5.0,
            reckoning_s: 5.0,
            heading_timeout_s: 3.0,
            origin_distance_m: 1000.0,
            jump_speed_mps: 10.0,
            jump_slack_m: 5.0,
            position_gain: 0.6,
            sigma_m: 1.0,
            drift_mps: 0.4,
        }
    }
}

/// Why a position was not used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rejection {
    /// There is none, or it is no place on Earth.
    Invalid,
    /// The dilution is too large.
    Dilution,
    /// The epoch is not newer than the one before.
    Stale,
    /// Out of reach of the one before.
    Jump,
}

/// How navigation is doing.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum NavigationHealth {
    /// No position so far.
    Waiting,
    /// Positions come.
    Good,
    /// They do not, and the vessel is reckoned onwards.
    Reckoning,
    /// They have not for too long.
    NoPosition,
    /// The compass gives no heading.
    NoHeading,
}

/// Where the vessel is and how it moves.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// Place.
    pub place: LatLon,
    /// Reference of the local offset.
    pub origin: LatLon,
    /// Offset from the reference.
    pub offset: LocalPoint,
    /// Height above the ellipsoid (m).
    pub height_m: f64,
    /// Heading and velocity.
    pub motion: Motion,
    /// Standard deviation of the position on each axis (m).
    pub sigma_m: f64,
    /// Time since the last position that was used.
    pub age: Duration,
}

impl Estimate {
    /// The same for the mission.
    pub(crate) fn fix(&self) -> mission::Fix {
        mission::Fix {
            place: self.place,
            heading_rad: self.motion.heading_rad,
            speed_mps: self.motion.speed_over_ground_mps(),
            sigma_m: self.sigma_m,
            water_below_m: None,
        }
    }
}

#[derive(Debug, Clone, Copy)]
struct Position {
    /// When it was true.
    at: MonoTime,
    point: LocalPoint,
    sigma_m: f64,
    height_m: f64,
}

#[derive(Debug, Clone, Copy)]
struct Suspect {
    at: MonoTime,
    point: LocalPoint,
    count: u32,
}

/// The navigator.
#[derive(Debug, Clone)]
pub struct Navigation {
    settings: NavigationSettings,
    frame: Option<LocalFrame>,
    position: Option<Position>,
    suspect: Option<Suspect>,
    /// North and east (m/s).
    velocity: Option<(MonoTime, f64, f64)>,
    heading: Option<(MonoTime, f64)>,
    yaw_rate: Option<(MonoTime, f64)>,
    last_epoch: Option<UtcTime>,
    jumps: u64,
}

impl Navigation {
    /// A navigator that knows nothing yet.
    pub fn new(settings: NavigationSettings) -> Self {
        Self {
            settings,
            frame: None,
            position: None,
            suspect: None,
            velocity: None,
            heading: None,
            yaw_rate: None,
            last_epoch: None,
            jumps: 0,
        }
    }

    /// The parameters in use.
    pub fn settings(&self) -> &NavigationSettings {
        &self.settings
    }

    /// Other parameters, from here on.
    pub fn reconfigure(&mut self, settings: NavigationSettings) {
        self.settings = settings;
    }

    /// Jumps that were believed in the end.
    pub fn jumps(&self) -> u64 {
        self.jumps
    }

    /// Takes an epoch of the compass. What is good of it is used, whatever else is wrong; of an epoch that was
    /// told before nothing is, or a receiver that hangs would keep an old heading alive.
    ///
    /// # Errors
    /// Why its position was not used.
    pub fn read(&mut self, now: MonoTime, reading: &GnssReading) -> Result<(), Rejection> {
        if let Some(epoch) = reading.utc {
            // A receiver that repeats itself has nothing new; one whose clock was set back a second or more has.
            let stale = self.last_epoch.is_some_and(|last| (0..1_000_000).contains(&(last - epoch)));
            self.last_epoch = Some(epoch);
            if stale {
                return Err(Rejection::Stale);
            }
        }
        let number = |value: Option<f64>, most: f64| value.filter(|value| value.abs() <= most);
        if let Some(heading_rad) = number(reading.heading_rad, 100.0) {
            self.heading = Some((now, wrap_pi(heading_rad)));
        }
        if let Some(rate) = number(reading.yaw_rate_rad_s, FASTEST_TURN_RAD_S) {
            self.yaw_rate = Some((now, rate));
        }
        if let Some((course_rad, speed_mps)) = reading.velocity
            && course_rad.abs() <= 100.0
            && (0.0..=FASTEST_MPS).contains(&speed_mps)
        {
            let (east, north) = course_rad.sin_cos();
            self.velocity = Some((now, speed_mps * north, speed_mps * east));
        }
        let fix = reading.fix.ok_or(Rejection::Invalid)?;
        let place = LatLon::from_rad(fix.lat_rad, fix.lon_rad).map_err(|_| Rejection::Invalid)?;
        if !(fix.hdop >= 0.0 && fix.hdop <= self.settings.max_hdop) {
            return Err(Rejection::Dilution);
        }
        self.locate(now, place, &fix)
    }

    fn locate(&mut self, now: MonoTime, place: LatLon, fix: &GnssFix) -> Result<(), Rejection> {
        let settings = self.settings;
        let sigma_m = settings.sigma_m * fix.hdop.max(0.5);
        let height_m = if fix.height_m.is_finite() { fix.height_m } else { 0.0 };
        let frame = *self.frame.get_or_insert_with(|| LocalFrame::new(place));
        let mut point = frame.to_local(place);
        if let Some(before) = self.position {
            let reckoned = self.reckoned(now, before);
            let elapsed_s = now.since(before.at).as_secs_f64();
            let reach_m = settings.jump_slack_m + settings.jump_speed_mps * elapsed_s;
            if before.point.distance_m(point) > reach_m && !self.believes_jump(now, point) {
                return Err(Rejection::Jump);
            }
            if self.suspect.take().is_none() && elapsed_s <= settings.reckoning_s {
                let gain = settings.position_gain;
                point = LocalPoint {
                    north_m: reckoned.north_m + gain * (point.north_m - reckoned.north_m),
                    east_m: reckoned.east_m + gain * (point.east_m - reckoned.east_m),
                };
            }
        }
        self.position = Some(Position { at: now, point, sigma_m, height_m });
        if frame.origin() != place && point.distance_m(LocalPoint::default()) > settings.origin_distance_m {
            let place = frame.to_place(point);
            self.frame = Some(LocalFrame::new(place));
            self.position = Some(Position { at: now, point: LocalPoint::default(), sigma_m, height_m });
        }
        Ok(())
    }

    /// Whether positions out of reach of the old agree with each other often enough.
    fn believes_jump(&mut self, now: MonoTime, point: LocalPoint) -> bool {
        let NavigationSettings { jump_slack_m, jump_speed_mps, .. } = self.settings;
        let count = match self.suspect {
            Some(suspect)
                if suspect.point.distance_m(point)
                    <= jump_slack_m + jump_speed_mps * now.since(suspect.at).as_secs_f64() =>
            {
                suspect.count + 1
            }
            _ => 1,
        };
        self.suspect = Some(Suspect { at: now, point, count });
        let believed = count >= JUMP_AGREE;
        self.jumps += u64::from(believed);
        believed
    }

    fn reckoned(&self, now: MonoTime, position: Position) -> LocalPoint {
        let Some((_, north_mps, east_mps)) = self.velocity else { return position.point };
        // No longer than reckoning is allowed at all, so that a stale velocity carries nothing far away.
        let elapsed_s = now.since(position.at).as_secs_f64().min(self.settings.reckoning_s);
        LocalPoint {
            north_m: position.point.north_m + north_mps * elapsed_s,
            east_m: position.point.east_m + east_mps * elapsed_s,
        }
    }

    /// How it is going.
    pub fn health(&self, now: MonoTime) -> NavigationHealth {
        let Some(position) = self.position else { return NavigationHealth::Waiting };
        let age_s = now.since(position.at).as_secs_f64();
        if age_s > self.settings.reckoning_s {
            return NavigationHealth::NoPosition;
        }
        let heading_age_s = self.heading.map(|(at, _)| now.since(at).as_secs_f64());
        if heading_age_s.is_none_or(|age_s| age_s > self.settings.heading_timeout_s) {
            return NavigationHealth::NoHeading;
        }
        // A compass gives at least one position a second.
        if age_s > 1.5 { NavigationHealth::Reckoning } else { NavigationHealth::Good }
    }

    /// The state at `now`; `None` while there is no basis for one.
    pub fn estimate(&self, now: MonoTime) -> Option<Estimate> {
        match self.health(now) {
            NavigationHealth::Good | NavigationHealth::Reckoning => {}
            NavigationHealth::Waiting | NavigationHealth::NoPosition | NavigationHealth::NoHeading => {
                return None;
            }
        }
        let (frame, position, (heading_at, heading_rad)) = (self.frame?, self.position?, self.heading?);
        let fresh = |at: MonoTime| now.since(at).as_secs_f64() <= self.settings.reckoning_s;
        let yaw_rate = self.yaw_rate.filter(|(at, _)| fresh(*at)).map(|(_, rate)| rate);
        let turned_rad = yaw_rate.unwrap_or(0.0) * now.since(heading_at).as_secs_f64();
        let (north_mps, east_mps) =
            self.velocity.filter(|(at, ..)| fresh(*at)).map_or((0.0, 0.0), |(_, n, e)| (n, e));
        let offset = self.reckoned(now, position);
        let age = now.since(position.at);
        Some(Estimate {
            place: frame.to_place(offset),
            origin: frame.origin(),
            offset,
            height_m: position.height_m,
            motion: Motion {
                heading_rad: wrap_pi(heading_rad + turned_rad),
                yaw_rate_rad_s: yaw_rate,
                north_mps,
                east_mps,
            },
            sigma_m: position.sigma_m + self.settings.drift_mps * age.as_secs_f64(),
            age,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(seconds: f64) -> MonoTime {
        MonoTime::from_micros((seconds * 1e6) as u64)
    }

    fn reading(seconds: f64, north_m: f64) -> GnssReading {
        let frame = LocalFrame::new(LatLon::from_deg(63.33, 10.0833).unwrap());
        let place = frame.to_place(LocalPoint { north_m, east_m: 0.0 });
        GnssReading {
            utc: UtcTime::from_seconds(1_700_000_000.0 + seconds),
            fix: Some(GnssFix {
                lat_rad: place.lat_rad(),
                lon_rad: place.lon_rad(),
                height_m: 40.0,
                differential: false,
                hdop: 0.9,
            }),
            satellites: 9,
            velocity: Some((0.0, 2.0)),
            heading_rad: Some(-0.3),
            yaw_rate_rad_s: Some(0.1),
        }
    }

    fn sailing() -> Navigation {
        let mut navigation = Navigation::new(NavigationSettings::default());
        for second in 0..10 {
            let seconds = f64::from(second);
            navigation.read(at(seconds), &reading(seconds, 2.0 * seconds)).unwrap();
        }
        navigation
    }

    #[test]
    fn keeps_heading_and_course_apart_with_the_right_sign_of_sway() {
        let estimate = sailing().estimate(at(9.0)).unwrap();
        // Bow 0.3 rad to port of a course to the north: set to starboard, v > 0.
        assert!((estimate.motion.sway_mps() - 2.0 * 0.3_f64.sin()).abs() < 1e-9);
        assert!((estimate.motion.surge_mps() - 2.0 * 0.3_f64.cos()).abs() < 1e-9);
        assert!((estimate.offset.north_m - 18.0).abs() < 0.01, "{estimate:?}");
    }

    #[test]
    fn reckons_over_a_gap_with_growing_uncertainty_and_then_gives_up() {
        let navigation = sailing();
        let (near, far) = (navigation.estimate(at(9.0)).unwrap(), navigation.estimate(at(11.5)).unwrap());
        assert!((far.offset.north_m - 23.0).abs() < 0.02);
        assert!((wrap_pi(far.motion.heading_rad + 0.3 - 0.25)).abs() < 1e-9);
        assert!(far.sigma_m > near.sigma_m + 0.9);
        assert_eq!(navigation.health(at(11.5)), NavigationHealth::Reckoning);
        assert_eq!(navigation.health(at(12.5)), NavigationHealth::NoHeading);
        assert!(navigation.estimate(at(12.5)).is_none());
        assert_eq!(navigation.health(at(14.1)), NavigationHealth::NoPosition);
    }

    #[test]
    fn refuses_what_is_no_number_or_too_poor() {
        let mut navigation = sailing();
        let before = navigation.estimate(at(10.0)).unwrap();
        let mut nan = reading(10.0, 20.0);
        nan.heading_rad = Some(f64::NAN);
        nan.yaw_rate_rad_s = Some(f64::INFINITY);
        nan.velocity = Some((f64::NAN, 2.0));
        nan.fix = nan.fix.map(|fix| GnssFix { lat_rad: f64::NAN, ..fix });
        assert_eq!(navigation.read(at(10.0), &nan), Err(Rejection::Invalid));
        assert_eq!(navigation.estimate(at(10.0)), Some(before));
        let mut poor = reading(11.0, 22.0);
        poor.fix = poor.fix.map(|fix| GnssFix { hdop: 9.0, ..fix });
        assert_eq!(navigation.read(at(11.0), &poor), Err(Rejection::Dilution));
        poor.fix = poor.fix.map(|fix| GnssFix { hdop: f64::NAN, ..fix });
        assert_eq!(navigation.read(at(12.0), &poor), Err(Rejection::Stale));
        assert_eq!(navigation.read(at(12.0), &GnssReading::default()), Err(Rejection::Invalid));
    }

    #[test]
    fn one_outlier_is_refused_and_three_that_agree_are_believed() {
        let mut navigation = sailing();
        assert_eq!(navigation.read(at(10.0), &reading(10.0, 520.0)), Err(Rejection::Jump));
        navigation.read(at(11.0), &reading(11.0, 22.0)).unwrap();
        assert_eq!(navigation.jumps(), 0);
        for (seconds, north_m) in [(12.0, 524.0), (13.0, 526.0)] {
            assert_eq!(navigation.read(at(seconds), &reading(seconds, north_m)), Err(Rejection::Jump));
            assert!(navigation.estimate(at(seconds)).unwrap().offset.north_m < 30.0);
        }
        navigation.read(at(14.0), &reading(14.0, 528.0)).unwrap();
        assert!((navigation.estimate(at(14.0)).unwrap().offset.north_m - 528.0).abs() < 0.1);
        assert_eq!(navigation.jumps(), 1);
    }

    #[test]
    fn takes_another_reference_far_away_without_moving_the_vessel() {
        let mut navigation = Navigation::new(NavigationSettings::default());
        for second in 0..600 {
            let seconds = f64::from(second);
            navigation.read(at(seconds), &reading(seconds, 2.0 * seconds)).unwrap();
        }
        let estimate = navigation.estimate(at(599.0)).unwrap();
        assert!(estimate.offset.north_m < 250.0);
        let frame = LocalFrame::new(LatLon::from_deg(63.33, 10.0833).unwrap());
        assert!((frame.to_local(estimate.place).north_m - 1198.0).abs() < 1.0);
    }

    #[test]
    fn a_repeated_epoch_is_stale() {
        let mut navigation = sailing();
        assert_eq!(navigation.read(at(9.5), &reading(9.0, 18.0)), Err(Rejection::Stale));
        // Nor does a receiver that hangs keep its heading alive.
        for tenth in 0..50 {
            let now = at(10.0 + 0.1 * f64::from(tenth));
            assert_eq!(navigation.read(now, &reading(9.0, 18.0)), Err(Rejection::Stale));
        }
        assert_eq!(navigation.health(at(13.5)), NavigationHealth::NoHeading);
    }
}
