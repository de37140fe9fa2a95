//! Keeping track of a path: where the vessel is on it, when it arrives, whether something is wrong.
//!
//! After the common part of DUNE's path controllers. A path is a straight leg, optionally with a circle
//! (loiter) around its end. The tracker takes commands and fixes with their times and answers geometry and
//! progress; [`Guidance`](crate::Guidance) turns these into a course. Differences from the original: legs are
//! exact beyond the flat frame ([`Leg`]), the time to arrival never falls below 0, and the time since the last
//! path is measured by the times passed in.
//!
//! Units: metres, seconds, radians clockwise from north; cross-track positive to starboard.

mod command;
mod config;
mod leg;
mod monitor;
mod status;

pub use command::{Fix, Loiter, PathCommand, PathEnd, PathError, PathStart};
pub use config::{NearRule, PathConfig};
pub use leg::{Leg, TrackPosition, range_and_bearing};
pub use monitor::{AlongTrackConfig, CrossTrackConfig, JumpConfig};
pub use status::{CirclePosition, Geometry, LegPosition, PathEvent, PathFault, PathStatus};

use crate::motion::Motion;
use crate::range::InvalidConfig;
use leg::displaced;
use monitor::{AlongTrackMonitor, CrossTrackMonitor, silence_after};
use std::f64::consts::{FRAC_PI_2, PI};
use std::time::Duration;
use units::{LatLon, MonoTime, wrap_pi};

/// A path that ended no longer ago than this may still be continued.
const CONTINUE_WITHIN: Duration = Duration::from_secs(1);
/// Braking silences the monitors no longer than this.
const LONGEST_BRAKING: Duration = Duration::from_secs(30);
/// Largest time to arrival that is reported (s).
const LONGEST_ETA_S: f64 = 65_535.0;

/// The tracker.
#[derive(Debug, Clone)]
pub struct PathTracker {
    config: PathConfig,
    active: Option<Active>,
    ended: Option<Ended>,
    last_fix: Option<(MonoTime, LatLon)>,
    silent_until: Option<MonoTime>,
    braking_since: Option<MonoTime>,
}

#[derive(Debug, Clone)]
struct Active {
    path_ref: u32,
    leg: Leg,
    /// End of the path or centre of its loiter.
    target: LatLon,
    loiter: Option<Loiter>,
    phase: Phase,
    along: AlongTrackMonitor,
    cross: CrossTrackMonitor,
    fault: Option<PathFault>,
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum Phase {
    Approaching,
    Near(MonoTime),
    Loitering,
}

#[derive(Debug, Clone, Copy)]
struct Ended {
    at: MonoTime,
    target: LatLon,
    reached: bool,
}

/// Course and speed that progress is reckoned with.
struct Progress {
    course_rad: f64,
    speed_mps: f64,
}

impl PathTracker {
    /// A tracker without a path.
    ///
    /// # Errors
    /// When values of `config` are out of range.
    pub fn new(config: PathConfig) -> Result<Self, InvalidConfig> {
        config.validate()?;
        Ok(Self {
            config,
            active: None,
            ended: None,
            last_fix: None,
            silent_until: None,
            braking_since: None,
        })
    }

    /// New parameters, also for the path under way.
    ///
    /// # Errors
    /// When values of `config` are out of range; the old ones then stay in use.
    pub fn reconfigure(&mut self, config: PathConfig) -> Result<(), InvalidConfig> {
        config.validate()?;
        self.config = config;
        Ok(())
    }

    /// Whether a path is followed.
    pub fn is_active(&self) -> bool {
        self.active.is_some()
    }

    /// Takes a path at `now` and answers its first status.
    ///
    /// # Errors
    /// When the path is not possible; the one in use then stays.
    pub fn start(
        &mut self,
        now: MonoTime,
        command: &PathCommand,
        fix: &Fix,
    ) -> Result<PathStatus, PathError> {
        if !fix.motion.is_finite() {
            return Err(PathError::NotFinite);
        }
        let target = command.target(fix.place)?;
        let start = match command.start {
            PathStart::At(place) => place,
            PathStart::Here => fix.place,
            PathStart::Chained => self.chained_start(now).unwrap_or(fix.place),
        };
        let end = command.loiter.map_or(target, |loiter| approach_end(start, target, loiter, fix));
        let leg = Leg::new(start, end, fix.motion.heading_rad);
        let limit_m = self.config.max_length_m;
        let length_m = leg.length_m().max(range_and_bearing(start, target).0);
        if length_m > limit_m {
            return Err(PathError::TooLong { length_m, limit_m });
        }
        let stays = command.loiter.is_some_and(|loiter| self.stays_on_circle(target, loiter, fix));
        self.active = Some(Active {
            path_ref: command.path_ref,
            leg,
            target,
            loiter: command.loiter,
            phase: if stays { Phase::Loitering } else { Phase::Approaching },
            along: AlongTrackMonitor::default(),
            cross: CrossTrackMonitor::default(),
            fault: None,
        });
        self.update(now, fix, false)
    }

    /// Watches the path under way as if it had just begun: what the monitors saw so far, and what they found to be
    /// wrong, is forgotten.
    pub fn watch_anew(&mut self) {
        if let Some(active) = &mut self.active {
            (active.along, active.cross) = (AlongTrackMonitor::default(), CrossTrackMonitor::default());
            active.fault = None;
        }
    }

    /// Lets go of the path.
    pub fn stop(&mut self, now: MonoTime) {
        if let Some(active) = self.active.take() {
            let reached = active.phase != Phase::Approaching;
            self.ended = Some(Ended { at: now, target: active.target, reached });
        }
        self.braking_since = None;
    }

    /// The status at a new fix. `braking`: the vessel is being stopped on purpose.
    ///
    /// # Errors
    /// When no path is followed or the fix is not a number.
    pub fn update(&mut self, now: MonoTime, fix: &Fix, braking: bool) -> Result<PathStatus, PathError> {
        if !fix.motion.is_finite() {
            return Err(PathError::NotFinite);
        }
        let silent = self.monitors_rest(now, fix, braking);
        let config = self.config;
        let active = self.active.as_mut().ok_or(PathError::Idle)?;
        let progress = progress(&config, &fix.motion);
        let (range_m, centre_bearing_rad) = range_and_bearing(fix.place, active.target);
        let track = active.leg.locate(fix.place);
        let mut eta_s = 0.0;
        let mut event = None;
        if active.phase != Phase::Loitering {
            eta_s = active.eta_s(&config, &track, &progress, range_m);
            event = active.arrive(&config, now, eta_s, fix.place);
        }
        let loitering = active.phase == Phase::Loitering;
        let geometry = match active.loiter {
            Some(loiter) if loitering => {
                Geometry::Circle(CirclePosition { range_m, centre_bearing_rad, loiter })
            }
            _ => Geometry::Leg(LegPosition {
                along_m: track.along_m,
                cross_m: track.cross_m,
                length_m: active.leg.length_m(),
                bearing_rad: track.bearing_rad,
                end_bearing_rad: range_and_bearing(fix.place, active.leg.end()).1,
            }),
        };
        let course_error_rad = wrap_pi(progress.course_rad - geometry.bearing_rad());
        active.watch(&config, now, silent, &geometry, course_error_rad, fix.variance_m2);
        Ok(PathStatus {
            path_ref: active.path_ref,
            start: active.leg.start(),
            end: active.target,
            loiter: active.loiter,
            geometry,
            left_m: if loitering { 0.0 } else { active.leg.length_m() - track.along_m },
            range_m,
            course_error_rad,
            speed_mps: progress.speed_mps,
            eta_s: if loitering { 0 } else { eta_s.clamp(0.0, LONGEST_ETA_S) as u16 },
            near: matches!(active.phase, Phase::Near(_)),
            loitering,
            event,
            fault: active.fault,
        })
    }

    /// The end of the previous path, where the next may continue from it.
    fn chained_start(&self, now: MonoTime) -> Option<LatLon> {
        match (&self.active, self.ended) {
            (Some(active), _) => (active.phase != Phase::Approaching).then_some(active.target),
            (None, Some(ended)) => {
                (ended.reached && now.since(ended.at) <= CONTINUE_WITHIN).then_some(ended.target)
            }
            (None, None) => None,
        }
    }

    /// Whether a vessel on a circle may go over to another without an approach.
    fn stays_on_circle(&self, centre: LatLon, loiter: Loiter, fix: &Fix) -> bool {
        let range_m = range_and_bearing(fix.place, centre).0;
        self.active.as_ref().is_some_and(|active| {
            active.phase == Phase::Loitering && range_and_bearing(active.target, centre).0 < 30.0
        }) && (0.75..=1.25).contains(&(range_m / loiter.radius_m))
    }

    fn monitors_rest(&mut self, now: MonoTime, fix: &Fix, braking: bool) -> bool {
        if let Some((then, place)) = self.last_fix {
            let distance_m = range_and_bearing(place, fix.place).0;
            let explained_m = fix.motion.speed_over_ground_mps() * now.since(then).as_secs_f64();
            if let Some(silence) = silence_after(&self.config.jump, distance_m, explained_m) {
                self.silent_until = Some(now + silence);
            }
        }
        self.last_fix = Some((now, fix.place));
        let brakes = if braking {
            let since = *self.braking_since.get_or_insert(now);
            now.since(since) <= LONGEST_BRAKING
        } else {
            self.braking_since = None;
            false
        };
        brakes || self.silent_until.is_some_and(|until| now < until)
    }
}

impl Active {
    /// Time to arrival, the factor taken off (s); below 0 where arrival is over.
    fn eta_s(&self, config: &PathConfig, track: &TrackPosition, progress: &Progress, range_m: f64) -> f64 {
        if self.captured(config, range_m) {
            return 0.0;
        }
        let speed_mps = progress.speed_mps.max(config.eta_min_speed_mps);
        let factor_s = config.time_of_arrival_factor_s;
        let (left_m, aside_m) = ((self.leg.length_m() - track.along_m).abs(), track.cross_m.abs());
        let abeam = left_m <= aside_m && aside_m < 1.75 * factor_s * speed_mps;
        let distance_m = if abeam { left_m } else { left_m.hypot(aside_m) };
        distance_m / speed_mps - factor_s
    }

    /// Whether the circle is close enough to begin it.
    fn captured(&self, config: &PathConfig, range_m: f64) -> bool {
        match (self.loiter, config.loiter_capture_m) {
            (Some(loiter), Some(capture_m)) => {
                (range_m - loiter.radius_m).abs() <= capture_m.min(loiter.radius_m / 2.0)
            }
            _ => false,
        }
    }

    fn arrive(&mut self, config: &PathConfig, now: MonoTime, eta_s: f64, place: LatLon) -> Option<PathEvent> {
        if self.phase != Phase::Approaching {
            return None;
        }
        let captured = self.captured(config, range_and_bearing(place, self.target).0);
        let near = match config.near {
            NearRule::TimeToArrival => eta_s <= 0.0,
            NearRule::Radius(radius_m) => captured || range_and_bearing(place, self.leg.end()).0 <= radius_m,
        };
        if !near {
            return None;
        }
        if self.loiter.is_some() {
            self.phase = Phase::Loitering;
            self.cross = CrossTrackMonitor::default();
            Some(PathEvent::Loitering)
        } else {
            self.phase = Phase::Near(now);
            Some(PathEvent::Near)
        }
    }

    fn watch(
        &mut self,
        config: &PathConfig,
        now: MonoTime,
        silent: bool,
        geometry: &Geometry,
        course_error_rad: f64,
        variance_m2: Option<f64>,
    ) {
        if let Phase::Near(since) = self.phase
            && now.since(since).as_secs_f64() >= config.new_path_timeout_s
        {
            self.fault.get_or_insert(PathFault::NoNewPath);
        }
        if silent {
            self.along = AlongTrackMonitor::default();
            self.cross = CrossTrackMonitor::default();
            return;
        }
        if let (Some(limits), Geometry::Leg(leg)) = (&config.along_track, geometry)
            && self.along.update(limits, now, leg.along_m, course_error_rad)
        {
            self.fault.get_or_insert(PathFault::NoProgress);
        }
        if let Some(limits) = &config.cross_track
            && self.cross.update(limits, now, geometry.cross_m(), variance_m2)
        {
            self.fault.get_or_insert(PathFault::OffTrack);
        }
    }
}

fn progress(config: &PathConfig, motion: &Motion) -> Progress {
    let speed_mps = motion.speed_over_ground_mps();
    if !config.course_control {
        return Progress { course_rad: motion.heading_rad, speed_mps: motion.surge_mps() };
    }
    let course_rad =
        if speed_mps < config.course_min_speed_mps { motion.heading_rad } else { motion.course_rad() };
    Progress { course_rad, speed_mps }
}

/// Where the approach to a circle ends: beside the centre, so that the circle is met about tangentially.
fn approach_end(start: LatLon, centre: LatLon, loiter: Loiter, fix: &Fix) -> LatLon {
    let heading_rad = fix.motion.heading_rad;
    let (range_m, vessel_bearing_rad) = range_and_bearing(fix.place, centre);
    if range_m < 1.0 {
        return displaced(centre, heading_rad, loiter.radius_m);
    }
    let (start_range_m, start_bearing_rad) = range_and_bearing(start, centre);
    // A path that starts at its own centre (a new radius) has no direction but the vessel's.
    let bearing_rad = if start_range_m < 1.0 { vessel_bearing_rad } else { start_bearing_rad };
    let inward = wrap_pi(heading_rad - bearing_rad).abs() < FRAC_PI_2;
    let exchanged = if range_m < 0.75 * loiter.radius_m && inward { PI } else { 0.0 };
    displaced(centre, bearing_rad - loiter.turn.sign() * FRAC_PI_2 + exchanged, loiter.radius_m)
}

#[cfg(test)]
mod tests;
