//! Idle: all loops off for a while, or for good.

use super::behaviour::{Behaviour, Context, Left, wait_left_s};
use crate::event::Event;
use std::time::Duration;
use units::{MonoTime, Now};

/// Drift.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Idle {
    /// How long; `None` until stopped.
    pub duration: Option<Duration>,
}

#[derive(Debug, Clone)]
pub(crate) struct Machine {
    idle: Idle,
    since: Option<MonoTime>,
}

impl Machine {
    pub(super) fn new(idle: Idle) -> Self {
        Self { idle, since: None }
    }
}

impl Behaviour for Machine {
    fn start(&mut self, cx: &mut Context<'_>) {
        self.since = Some(cx.now.mono);
        cx.drift();
    }

    fn event(&mut self, _: &mut Context<'_>, _: &Event) {}

    fn timeout(&mut self, cx: &mut Context<'_>) {
        cx.done();
    }

    fn deadline(&self) -> Option<MonoTime> {
        Some(self.since? + self.idle.duration?)
    }

    fn left(&self, now: Now) -> Option<Left> {
        wait_left_s(self.idle.duration, self.since, now).map(|wait_s| Left { way_m: 0.0, wait_s })
    }
}
