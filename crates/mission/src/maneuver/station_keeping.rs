//! Station keeping: drifts inside a radius, motors off, and drives back to the centre when outside. Between
//! drives the vessel is quiet: this is how it listens.

use super::RawPlace;
use super::behaviour::{Behaviour, Context, FailReason, Left, wait_left_s};
use super::goto::{distance_m, path_to};
use crate::command::{Path, PathStart};
use crate::event::{Event, Fix, Now, PathProgress};
use crate::plan::Checks;
use crate::speed::Speed;
use std::time::Duration;
use units::{LatLon, MonoTime};

/// A path that is near its end, the vessel still outside, is sent again after this.
const RESEND_AFTER: Duration = Duration::from_secs(1);

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
    /// Driving back since the path was sent.
    OffStation { sent: MonoTime },
}

#[derive(Debug, Clone)]
pub(crate) struct Machine {
    station: StationKeeping,
    state: State,
    arrived: Option<MonoTime>,
    range_m: Option<f64>,
}

impl Machine {
    pub(super) fn new(station: StationKeeping) -> Self {
        Self { station, state: State::Initial, arrived: None, range_m: None }
    }

    fn radius_m(&self, cx: &Context<'_>) -> f64 {
        self.station.radius_m.max(cx.config.station_min_radius_m)
    }

    fn drive(&mut self, cx: &mut Context<'_>) {
        self.state = State::OffStation { sent: cx.now.mono };
        cx.follow(Path { start: PathStart::Here, ..path_to(self.station.centre, self.station.speed) });
    }

    fn rest(&mut self, cx: &mut Context<'_>) {
        self.state = State::OnStation;
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
        let range_m = distance_m(fix.place, self.station.centre);
        self.range_m = Some(range_m);
        let outside = range_m > self.radius_m(cx);
        match self.state {
            State::Initial | State::OnStation if outside => self.drive(cx),
            State::Initial => self.rest(cx),
            State::OnStation | State::OffStation { .. } => {}
        }
    }

    fn progress(&mut self, cx: &mut Context<'_>, progress: &PathProgress) {
        if let State::OffStation { sent } = self.state
            && progress.near
        {
            if progress.left_m.hypot(progress.cross_m) < self.radius_m(cx) {
                self.rest(cx);
            } else if cx.now.mono.since(sent) >= RESEND_AFTER {
                self.drive(cx);
            }
        }
    }
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
            Event::Reference(_) | Event::Sighting(_) | Event::Medium(_) | Event::TeleoperationDone { .. } => {
            }
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
