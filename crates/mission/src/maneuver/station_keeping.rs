//! Station keeping: drifts inside a radius with its motors off, and drives back in time. Between drives the
//! vessel is quiet: this is how it listens.
//!
//! It turns back before the radius, by its position error and by its drift during the turn.
//! It drives to the side that wind and current come from, so that the next drift leads through the middle
//! and lasts longest. How the vessel drifts it learns from its own positions while the motors are off; before
//! that is known it drives to the centre.

use super::behaviour::{Behaviour, Context, FailReason, Left, wait_left_s};
use super::drift::Drift;
use super::goto::path_to;
use crate::checks::Checks;
use crate::command::{Path, PathStart};
use crate::event::{Event, Fix, PathProgress};
use crate::place::RawPlace;
use std::time::Duration;
use units::Speed;
use units::{LatLon, LocalFrame, LocalPoint, MonoTime, Now};

/// A path that is near its end, the vessel still under way, is sent again after this.
const RESEND_AFTER: Duration = Duration::from_secs(1);
/// Standard deviations of the position that are kept from the radius: 95 % of a normal distribution.
const SIGMAS: f64 = 2.0;
/// From the decision to drive until the vessel makes way inward (s): it turns on the spot by up to 180°, an
/// Otter at 15 to 20 °/s, and needs a second to gather way.
const TURN_S: f64 = 12.0;
/// The motors stop when the way left is what the vessel runs on without them (s, times its speed): its time
/// constant in surge is 1.1 s.
const COAST_S: f64 = 1.1;
/// How far towards the weather the vessel drives, as a share of what it may drift on the other side.
const UPWIND: f64 = 0.8;
/// Margins never take more of the radius than this share.
const MOST_MARGIN: f64 = 0.5;

/// Drift near a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StationKeeping<P = LatLon> {
    /// Around where.
    pub centre: P,
    /// How far the vessel may drift (m).
    pub radius_m: f64,
    /// How fast to drive.
    pub speed: Speed,
    /// How long after the first arrival; `None` until stopped.
    pub duration: Option<Duration>,
}

impl StationKeeping<RawPlace> {
    pub(crate) fn check(&self, checks: &mut Checks<'_>) -> Option<StationKeeping> {
        checks.speed(self.speed);
        checks.radius(self.radius_m);
        let Self { radius_m, speed, duration, .. } = *self;
        Some(StationKeeping { centre: checks.place(self.centre)?, radius_m, speed, duration })
    }
}

#[derive(Debug, Clone, Copy, PartialEq)]
enum State {
    /// No fix has come since the start.
    Initial,
    /// Drifting inside.
    OnStation,
    /// Driving to `aim` since the path was sent.
    OffStation { sent: MonoTime, from: LocalPoint, aim: LocalPoint },
}

#[derive(Debug, Clone)]
pub(crate) struct Machine {
    station: StationKeeping,
    /// Around the centre.
    frame: LocalFrame,
    state: State,
    drift: Drift,
    arrived: Option<MonoTime>,
    range_m: Option<f64>,
}

impl Machine {
    pub(super) fn new(station: StationKeeping) -> Self {
        Self {
            station,
            frame: LocalFrame::new(station.centre),
            state: State::Initial,
            drift: Drift::default(),
            arrived: None,
            range_m: None,
        }
    }

    fn radius_m(&self, cx: &Context<'_>) -> f64 {
        self.station.radius_m.max(cx.config.station_min_radius_m)
    }

    /// How far from the centre the vessel may believe to be so that it is truly inside the radius.
    fn keep_m(&self, cx: &Context<'_>, fix: &Fix) -> f64 {
        let radius_m = self.radius_m(cx);
        radius_m - (SIGMAS * fix.sigma_m.max(0.0)).min(MOST_MARGIN * radius_m)
    }

    /// Whether it is time to drive back.
    fn leaves(&self, cx: &Context<'_>, fix: &Fix, here: LocalPoint) -> bool {
        let range_m = from_centre_m(here);
        let (north_mps, east_mps) = self.drift.velocity().unwrap_or_default();
        let turned = LocalPoint {
            north_m: here.north_m + TURN_S * north_mps,
            east_m: here.east_m + TURN_S * east_mps,
        };
        // In a strong stream too, the vessel may drift some way before it turns.
        let way_m = (from_centre_m(turned) - range_m).min(MOST_MARGIN * self.radius_m(cx));
        range_m > self.radius_m(cx) || way_m >= 0.0 && range_m + way_m > self.keep_m(cx, fix)
    }

    /// Where to drive: to the side that the vessel drifts away from.
    fn aim(&self, cx: &Context<'_>, fix: &Fix) -> LocalPoint {
        let Some((north_mps, east_mps)) = self.drift.velocity() else { return LocalPoint::default() };
        let share_s = UPWIND * self.keep_m(cx, fix) / north_mps.hypot(east_mps);
        LocalPoint { north_m: -share_s * north_mps, east_m: -share_s * east_mps }
    }

    fn drive(&mut self, cx: &mut Context<'_>, from: LocalPoint, aim: LocalPoint) {
        self.state = State::OffStation { sent: cx.now.mono, from, aim };
        let end = self.frame.to_place(aim);
        cx.follow(Path { start: PathStart::Here, ..path_to(end, self.station.speed) });
    }

    fn rest(&mut self, cx: &mut Context<'_>) {
        self.state = State::OnStation;
        self.drift.begin(cx.now.mono);
        self.arrived.get_or_insert(cx.now.mono);
        cx.drift();
        self.finish_when_over(cx);
    }

    fn finish_when_over(&self, cx: &mut Context<'_>) {
        if wait_left_s(self.station.duration, self.arrived, cx.now) == Some(0.0) {
            cx.done();
        }
    }

    fn fix(&mut self, cx: &mut Context<'_>, fix: &Fix) {
        let here = self.frame.to_local(fix.place);
        self.range_m = Some(from_centre_m(here));
        match self.state {
            State::Initial | State::OnStation => {
                if self.state == State::OnStation {
                    self.drift.at(cx.now.mono, here);
                }
                if self.leaves(cx, fix, here) {
                    let aim = self.aim(cx, fix);
                    self.drive(cx, here, aim);
                } else if self.state == State::Initial {
                    self.rest(cx);
                }
            }
            State::OffStation { from, aim, .. } => {
                let left_m = here.distance_m(aim);
                if left_m <= COAST_S * fix.speed_mps || is_past(from, aim, here) {
                    self.rest(cx);
                }
            }
        }
    }

    /// Path control takes a path for done some way before its end; the vessel continues to where it rests.
    fn progress(&mut self, cx: &mut Context<'_>, progress: &PathProgress) {
        if let State::OffStation { sent, from, aim } = self.state
            && progress.near
            && cx.now.mono.since(sent) >= RESEND_AFTER
        {
            self.drive(cx, from, aim);
        }
    }
}

fn from_centre_m(point: LocalPoint) -> f64 {
    point.distance_m(LocalPoint::default())
}

/// Whether the way from `from` to `aim` is over at `here`.
fn is_past(from: LocalPoint, aim: LocalPoint, here: LocalPoint) -> bool {
    let (north_m, east_m) = (aim.north_m - from.north_m, aim.east_m - from.east_m);
    (aim.north_m - here.north_m) * north_m + (aim.east_m - here.east_m) * east_m <= 0.0
}

impl Behaviour for Machine {
    fn start(&mut self, cx: &mut Context<'_>) {
        match cx.fix {
            Some(fix) => self.fix(cx, &fix),
            None => cx.drift(),
        }
    }

    fn event(&mut self, cx: &mut Context<'_>, event: &Event) {
        match event {
            Event::Fix(fix) => self.fix(cx, fix),
            Event::Path(progress) => self.progress(cx, progress),
            Event::PathFailed { reason, .. } => cx.fail(FailReason::Path(reason.clone())),
            Event::Reference(_)
            | Event::Sighting(_)
            | Event::Medium(_)
            | Event::TeleoperationDone { .. }
            | Event::Way(_)
            | Event::CommanderChanged => {}
        }
    }

    fn timeout(&mut self, cx: &mut Context<'_>) {
        self.finish_when_over(cx);
    }

    /// The duration may pass while driving back; it then ends at the return.
    fn deadline(&self) -> Option<MonoTime> {
        (self.state == State::OnStation).then_some(self.arrived? + self.station.duration?)
    }

    fn left(&self, now: Now) -> Option<Left> {
        let wait_s = wait_left_s(self.station.duration, self.arrived, now)?;
        let way_m = if self.arrived.is_some() { 0.0 } else { self.range_m? };
        Some(Left { way_m, wait_s })
    }
}
