//! From a GNSS compass to the state of the vessel.
//!
//! Positions pass gates first: they must be there, be numbers on Earth, good enough (dilution), newer than the
//! last, and within reach of where the vessel can be. What fails says why. A position out of reach is a jump:
//! it is refused, the vessel is reckoned onwards, and only when three in a row agree with each other is the
//! new place accepted. Between positions, and over gaps up to a limit, position follows from velocity and
//! heading from the rate of turn. What is not measured is doubted: the uncertainty grows with time, and with the way
//! that is only reckoned. Beyond a time, or an uncertainty, there is no estimate, and without one no controller steers.
//!
//! Heading (where the bow points, from the compass) and course (where the vessel goes, from the receiver's
//! velocity) are never mixed: north and east velocities are kept, surge and sway follow from them and the
//! heading, v = sog·sin(cog - ψ).
//!
//! Units: radians, metres, seconds. x north, y east of a reference that stays until it is too far away.

use control::Motion;
use devices::{GnssFix, GnssReading, GroundVelocity};
use std::time::Duration;
use units::{LatLon, LocalFrame, LocalPoint, MonoTime, UtcTime, wrap_pi};

/// Positions that must agree before a jump is accepted.
const JUMP_AGREE: u32 = 3;
/// A compass gives at least one position and heading a second: what is older is reckoned.
const MEASURED: Duration = Duration::from_millis(1500);
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
    /// The dilution that is assumed where the receiver gives none.
    pub assumed_hdop: f64,
    /// Without a good position, or a heading, for so long there is no estimate (s).
    pub reckoning_s: f64,
    /// With a greater standard deviation of the position there is no estimate (m).
    pub most_sigma_m: f64,
    /// Greatest speed of a path while the position is only reckoned (m/s).
    pub reckoning_mps: f64,
    /// Positions must have been good for this long before a plan that waited for them continues (s).
    pub recovery_s: f64,
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
    /// Growth of the standard deviation without positions, by wind and current (m/s).
    pub drift_mps: f64,
    /// Growth of the standard deviation as a share of the way that is reckoned, 0 to 1: nothing measures the speed.
    pub speed_error: f64,
}

impl Default for NavigationSettings {
    fn default() -> Self {
        Self {
            rate_hz: 5.0,
            max_hdop: 5.0,
            assumed_hdop: 2.0,
            reckoning_s: 5.0,
            most_sigma_m: 15.0,
            reckoning_mps: 0.8,
            recovery_s: 3.0,
            origin_distance_m: 1000.0,
            jump_speed_mps: 10.0,
            jump_slack_m: 5.0,
            position_gain: 0.6,
            sigma_m: 1.0,
            drift_mps: 0.4,
            speed_error: 0.5,
        }
    }
}

/// Why a position was not used.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Rejection {
    /// No position, or not a place on Earth.
    Invalid,
    /// The dilution is too large.
    Dilution,
    /// The epoch is not newer than the previous one.
    Stale,
    /// Out of reach of the previous one.
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
    /// Time since the arrival of the last position that was used.
    pub age: Duration,
    /// How long that had been under way: the estimate is of this long before the moment it is made for. Steering does not
    /// mind; what is placed by it does.
    pub lag: Duration,
    /// Time since the last heading.
    pub heading_age: Duration,
}

/// When a reading came.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Arrival {
    /// The moment.
    pub at: MonoTime,
    /// How long after the measurement that was.
    pub lag: Duration,
}

impl Estimate {
    /// Whether the position is only reckoned.
    pub fn is_reckoned(&self) -> bool {
        self.age > MEASURED
    }

    /// Whether the heading is only assumed unchanged: no turn would be noticed.
    pub fn is_heading_old(&self) -> bool {
        self.heading_age > MEASURED
    }

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
    /// When it came.
    measured: MonoTime,
    /// How long it had been under way then.
    lag: Duration,
    /// Where it has been reckoned to since, and when.
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

    /// Jumps that were accepted in the end.
    pub fn jumps(&self) -> u64 {
        self.jumps
    }

    /// Takes an epoch of the compass that was not under way for any time; see [`read_late`](Self::read_late).
    ///
    /// # Errors
    /// Why its position was not used.
    pub fn read(&mut self, now: MonoTime, reading: &GnssReading) -> Result<(), Rejection> {
        self.read_late(Arrival { at: now, lag: Duration::ZERO }, reading)
    }

    /// Takes an epoch of the compass. Its valid values are used, even if others are not; a repeated epoch is not
    /// used at all, or a receiver that hangs would keep an old heading alive.
    ///
    /// # Errors
    /// Why its position was not used.
    pub fn read_late(&mut self, arrival: Arrival, reading: &GnssReading) -> Result<(), Rejection> {
        let now = arrival.at;
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
            self.turn(now, wrap_pi(heading_rad));
        }
        if let Some(rate) = number(reading.yaw_rate_rad_s, FASTEST_TURN_RAD_S) {
            self.yaw_rate = Some((now, rate));
        }
        if let Some(velocity) = reading.velocity
            && (0.0..=FASTEST_MPS).contains(&velocity.speed_mps)
        {
            let GroundVelocity { course_rad, speed_mps } = velocity;
            let (east, north) = course_rad.sin_cos();
            if velocity.stands() {
                self.velocity = Some((now, 0.0, 0.0));
            } else if course_rad.abs() <= 100.0 {
                self.velocity = Some((now, speed_mps * north, speed_mps * east));
            }
        }
        let mut fix = reading.fix.ok_or(Rejection::Invalid)?;
        let place = LatLon::from_rad(fix.lat_rad, fix.lon_rad).map_err(|_| Rejection::Invalid)?;
        if fix.hdop.is_nan() {
            fix.hdop = self.settings.assumed_hdop;
        }
        if !(fix.hdop >= 0.0 && fix.hdop <= self.settings.max_hdop) {
            return Err(Rejection::Dilution);
        }
        self.locate(arrival, place, &fix)
    }

    /// Takes a heading. The velocity that nothing measures any more turns with the bow.
    fn turn(&mut self, now: MonoTime, heading_rad: f64) {
        let before = self.heading.replace((now, heading_rad));
        let (Some((_, before_rad)), Some((measured, north_mps, east_mps))) = (before, self.velocity) else {
            return;
        };
        if now.since(measured) <= MEASURED {
            return;
        }
        if let Some(position) = self.position {
            let (point, at) = (self.reckoned(now, position), self.reckoned_until(now, position));
            self.position = Some(Position { at, point, ..position });
        }
        let (sin, cos) = wrap_pi(heading_rad - before_rad).sin_cos();
        self.velocity = Some((measured, north_mps * cos - east_mps * sin, north_mps * sin + east_mps * cos));
    }

    fn locate(&mut self, arrival: Arrival, place: LatLon, fix: &GnssFix) -> Result<(), Rejection> {
        let (now, lag) = (arrival.at, arrival.lag);
        let settings = self.settings;
        let sigma_m = settings.sigma_m * fix.hdop.max(0.5);
        let height_m = if fix.height_m.is_finite() { fix.height_m } else { 0.0 };
        let frame = *self.frame.get_or_insert_with(|| LocalFrame::new(place));
        let mut point = frame.to_local(place);
        if let Some(before) = self.position {
            let reckoned = self.reckoned(now, before);
            let elapsed_s = now.since(before.measured).as_secs_f64();
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
        let position = Position { measured: now, lag, at: now, point, sigma_m, height_m };
        self.position = Some(position);
        if frame.origin() != place && point.distance_m(LocalPoint::default()) > settings.origin_distance_m {
            let place = frame.to_place(point);
            self.frame = Some(LocalFrame::new(place));
            self.position = Some(Position { point: LocalPoint::default(), ..position });
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
        let elapsed_s = self.reckoned_until(now, position).since(position.at).as_secs_f64();
        LocalPoint {
            north_m: position.point.north_m + north_mps * elapsed_s,
            east_m: position.point.east_m + east_mps * elapsed_s,
        }
    }

    /// No longer than reckoning is allowed at all, so that a stale velocity carries nothing far away.
    fn reckoned_until(&self, now: MonoTime, position: Position) -> MonoTime {
        now.min(position.measured + Duration::from_secs_f64(self.settings.reckoning_s)).max(position.at)
    }

    /// Standard deviation of a position on each axis (m).
    fn sigma_m(&self, now: MonoTime, position: Position) -> f64 {
        let speed_mps = self.velocity.map_or(0.0, |(_, north_mps, east_mps)| north_mps.hypot(east_mps));
        let growth_mps = self.settings.drift_mps + self.settings.speed_error * speed_mps;
        position.sigma_m + growth_mps * now.since(position.measured).as_secs_f64()
    }

    /// How it is going.
    pub fn health(&self, now: MonoTime) -> NavigationHealth {
        let Some(position) = self.position else { return NavigationHealth::Waiting };
        let longest = Duration::from_secs_f64(self.settings.reckoning_s);
        let age = now.since(position.measured);
        let is_known = age <= MEASURED || self.sigma_m(now, position) <= self.settings.most_sigma_m;
        if age > longest || !is_known {
            return NavigationHealth::NoPosition;
        }
        if self.heading.is_none_or(|(at, _)| now.since(at) > longest) {
            return NavigationHealth::NoHeading;
        }
        if age > MEASURED { NavigationHealth::Reckoning } else { NavigationHealth::Good }
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
        let heading_age = now.since(heading_at);
        let yaw_rate = self.yaw_rate.filter(|(at, _)| now.since(*at) <= MEASURED).map(|(_, rate)| rate);
        // A turn that is not measured is not assumed to continue.
        let turned_s = heading_age.min(MEASURED).as_secs_f64();
        let turned_rad = self.yaw_rate.map_or(0.0, |(_, rate)| rate) * turned_s;
        let (north_mps, east_mps) =
            self.velocity.filter(|(at, ..)| fresh(*at)).map_or((0.0, 0.0), |(_, n, e)| (n, e));
        let offset = self.reckoned(now, position);
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
            sigma_m: self.sigma_m(now, position),
            age: now.since(position.measured),
            lag: position.lag,
            heading_age,
        })
    }
}

#[cfg(test)]
mod tests;
