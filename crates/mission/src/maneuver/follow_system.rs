//! Follow system: keeps at a place beside another system, by the positions it announces.
//!
//! The other's course is the direction between announcements far enough apart; before it is known, the
//! direction from the vessel to the other stands in. Announcements come every ten seconds or so: following is
//! coarse, so the vessel drifts while it is close to its place or to the other, and drives otherwise. While its place
//! lies outside the area, or no safe way leads there, it keeps near where it was.

use super::behaviour::{Behaviour, Context, FailReason, Left, wait_left_s};
use super::goto::{distance_m, path_to};
use crate::checks::Checks;
use crate::command::{Path, PathStart};
use crate::event::{Event, Fix, Sighting};
use std::time::Duration;
use units::Speed;
use units::{LatLon, LocalFrame, LocalPoint, MonoTime, Now};

/// Keep beside another system.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FollowSystem {
    /// Its address.
    pub system: u16,
    /// How fast.
    pub speed: Speed,
    /// Place ahead of the other (m).
    pub ahead_m: f64,
    /// Place to port of the other (m).
    pub port_m: f64,
    /// How long; `None` until stopped.
    pub duration: Option<Duration>,
}

/// Parameters of the behaviour.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FollowSystemConfig {
    /// Announcements closer than this give no course (m).
    pub min_displace_m: f64,
    /// The vessel stops when closer to the other (m).
    pub safety_m: f64,
    /// It drives only when farther from its place (m).
    pub slack_m: f64,
    /// No announcement for so long fails the maneuver.
    pub silence: Duration,
}

impl Default for FollowSystemConfig {
    fn default() -> Self {
        Self { min_displace_m: 2.0, safety_m: 15.0, slack_m: 10.0, silence: Duration::from_mins(1) }
    }
}

impl FollowSystem {
    pub(crate) fn check(&self, checks: &mut Checks<'_>) {
        checks.speed(self.speed);
        checks.offset(LocalPoint { north_m: self.ahead_m, east_m: self.port_m });
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Machine {
    follow: FollowSystem,
    since: Option<MonoTime>,
    heard: Option<MonoTime>,
    silence: Duration,
    other: Option<LatLon>,
    /// The announcement that the course is reckoned from.
    anchor: Option<LatLon>,
    course_rad: Option<f64>,
    /// Where the vessel drives, if it does.
    driving_to: Option<LatLon>,
    /// Where it waits while it may not go to its place.
    waits_at: Option<LatLon>,
}

impl Machine {
    pub(super) fn new(follow: FollowSystem) -> Self {
        Self {
            follow,
            since: None,
            heard: None,
            silence: Duration::ZERO,
            other: None,
            anchor: None,
            course_rad: None,
            driving_to: None,
            waits_at: None,
        }
    }

    fn sighting(&mut self, cx: &mut Context<'_>, place: LatLon) {
        self.heard = Some(cx.now.mono);
        self.other = Some(place);
        let anchor = *self.anchor.get_or_insert(place);
        if distance_m(anchor, place) >= cx.config.system.min_displace_m {
            let frame = LocalFrame::new(anchor);
            self.course_rad = Some(frame.to_local(anchor).bearing_rad(frame.to_local(place)));
            self.anchor = Some(place);
        }
        if let Some(fix) = cx.fix {
            self.steer(cx, &fix, true);
        }
    }

    /// The place to keep, beside the other.
    fn slot(&self, other: LatLon, fix: &Fix) -> LatLon {
        let frame = LocalFrame::new(other);
        let towards_rad = frame.to_local(fix.place).bearing_rad(frame.to_local(other));
        let course_rad = self.course_rad.unwrap_or(towards_rad);
        let (sin, cos) = course_rad.sin_cos();
        let (ahead_m, port_m) = (self.follow.ahead_m, self.follow.port_m);
        frame.to_place(LocalPoint {
            north_m: ahead_m * cos + port_m * sin,
            east_m: ahead_m * sin - port_m * cos,
        })
    }

    fn steer(&mut self, cx: &mut Context<'_>, fix: &Fix, news: bool) {
        let Some(other) = self.other else { return };
        let config = &cx.config.system;
        let slot = self.slot(other, fix);
        if news {
            self.look_at_way(cx, slot, fix);
        }
        let slot = self.waits_at.unwrap_or(slot);
        let too_close = distance_m(fix.place, other) < config.safety_m;
        let far = distance_m(fix.place, slot) > config.slack_m;
        if too_close {
            self.rest(cx);
        } else if far && (news || self.driving_to.is_none()) {
            self.driving_to = Some(slot);
            cx.follow(Path { start: PathStart::Here, ..path_to(slot, self.follow.speed) });
        }
    }

    /// Whether the vessel may go to its place, by the latest report of the other.
    fn look_at_way(&mut self, cx: &mut Context<'_>, slot: LatLon, fix: &Fix) {
        match cx.waters.way(fix.place, slot) {
            Ok(()) => self.waits_at = None,
            Err(why) => {
                if self.waits_at.is_none() {
                    cx.warn(format!(
                        "it waits where it is and does not follow {:#06x}: {why}",
                        self.follow.system
                    ));
                    self.waits_at = Some(fix.place);
                    self.rest(cx);
                }
            }
        }
    }

    fn rest(&mut self, cx: &mut Context<'_>) {
        if self.driving_to.take().is_some() {
            cx.drift();
        }
    }
}

impl Behaviour for Machine {
    fn start(&mut self, cx: &mut Context<'_>) {
        self.since = Some(cx.now.mono);
        self.heard = Some(cx.now.mono);
        self.silence = cx.config.system.silence;
        cx.drift();
    }

    fn event(&mut self, cx: &mut Context<'_>, event: &Event) {
        match event {
            Event::Fix(fix) => self.steer(cx, fix, false),
            Event::Sighting(Sighting { system, place, .. }) if *system == self.follow.system => {
                self.sighting(cx, *place);
            }
            Event::Path(progress) if progress.near => self.rest(cx),
            Event::PathFailed { reason, .. } => cx.fail(FailReason::Path(reason.clone())),
            Event::Sighting(_)
            | Event::Path(_)
            | Event::Reference(_)
            | Event::Medium(_)
            | Event::TeleoperationDone { .. }
            | Event::Way(_)
            | Event::CommanderChanged => {}
        }
    }

    fn timeout(&mut self, cx: &mut Context<'_>) {
        if wait_left_s(self.follow.duration, self.since, cx.now) == Some(0.0) {
            cx.done();
        } else {
            cx.fail(FailReason::SystemSilent(self.follow.system));
        }
    }

    fn deadline(&self) -> Option<MonoTime> {
        let silent = self.heard? + self.silence;
        let over = self.follow.duration.and_then(|duration| Some(self.since? + duration));
        Some(over.map_or(silent, |over| over.min(silent)))
    }

    fn left(&self, now: Now) -> Option<Left> {
        let wait_s = wait_left_s(self.follow.duration, self.since, now)?;
        Some(Left { way_m: 0.0, wait_s })
    }
}
