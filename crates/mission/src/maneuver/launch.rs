//! Launch: waits until the vessel is in the water, then goes to a place.

use super::behaviour::{Behaviour, Context, Left};
use super::goto::{self, Goto};
use crate::checks::Checks;
use crate::event::{Event, Medium};
use crate::place::RawPlace;
use units::Speed;
use units::{LatLon, Now};

/// Wait for the water, then go to a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Launch<P = LatLon> {
    /// Where to.
    pub target: P,
    /// How fast.
    pub speed: Speed,
}

impl Launch<RawPlace> {
    pub(crate) fn check(&self, checks: &mut Checks<'_>) -> Option<Launch> {
        checks.speed(self.speed);
        Some(Launch { target: checks.place(self.target)?, speed: self.speed })
    }
}

#[derive(Debug, Clone)]
pub(crate) struct Machine {
    goto: goto::Machine,
    afloat: bool,
}

impl Machine {
    pub(super) fn new(Launch { target, speed }: Launch) -> Self {
        Self { goto: goto::Machine::new(Goto { target, speed }), afloat: false }
    }

    fn try_medium(&mut self, cx: &mut Context<'_>, medium: Medium) {
        if !self.afloat && matches!(medium, Medium::Water | Medium::Underwater) {
            self.afloat = true;
            self.goto.start(cx);
        }
    }
}

impl Behaviour for Machine {
    fn start(&mut self, cx: &mut Context<'_>) {
        self.try_medium(cx, cx.medium);
        if !self.afloat {
            cx.drift();
        }
    }

    fn event(&mut self, cx: &mut Context<'_>, event: &Event) {
        if self.afloat {
            self.goto.event(cx, event);
        } else if let Event::Medium(medium) = event {
            self.try_medium(cx, *medium);
        }
    }

    fn left(&self, now: Now) -> Option<Left> {
        self.goto.left(now)
    }
}
