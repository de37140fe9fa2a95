//! A brain and its hull, with a common time.
//!
//! Time comes from outside: [`Vehicle::come_to`] with the computer's, or [`Vehicle::advance`] with a virtual clock that
//! jumps from event to event: the next reading of a sensor, the next deadline of the brain. Two vehicles with the same
//! settings under a virtual clock give the same outputs at the same times.

use super::hull::Hull;
use onboard::{Brain, Input, Keep, Output, Routes};
use planner::Cancel;
use std::time::Duration;
use units::{MonoTime, Now, UtcTime};

/// An input or output of the brain.
#[derive(Debug, PartialEq)]
pub(crate) enum BrainEvent<'a> {
    /// An input.
    Input(&'a Input),
    /// An output.
    Output(Output),
}

/// A hull and its brain.
#[derive(Debug)]
pub(crate) struct Vehicle<H> {
    /// Sensors and thrusters.
    pub(crate) hull: H,
    /// The brain.
    pub(crate) brain: Brain,
    /// The time that both have reached.
    pub(crate) now: Now,
    /// Whether storing plans and parameters is simulated; otherwise the caller passes the outcome.
    pub(crate) virtual_disk: bool,
    /// Answers route requests at once; otherwise the caller does.
    pub(crate) routes: Option<Routes>,
}

impl<H: Hull> Vehicle<H> {
    /// A hull and its brain, with a virtual disk and immediate routes.
    pub(crate) fn new(hull: H, brain: Brain, now: Now) -> Self {
        Self { hull, brain, now, virtual_disk: true, routes: Some(Routes::default()) }
    }

    /// Passes an input to the brain, at the present time.
    pub(crate) fn tell(&mut self, input: Input, sink: &mut impl FnMut(Now, BrainEvent<'_>)) {
        let now = self.now;
        sink(now, BrainEvent::Input(&input));
        self.brain.handle(now, input);
        let mut answers = Vec::new();
        while let Some(output) = self.brain.poll_output() {
            match &output {
                Output::Motors(motors) => self.hull.command(*motors),
                Output::Power { channel, on } => self.hull.switch(channel, *on),
                Output::Keep(Keep::Plans(effect)) if self.virtual_disk => {
                    answers.push(Input::Stored(effect.ticket(), Ok(())));
                }
                Output::Keep(Keep::Parameters(label, _)) if self.virtual_disk => {
                    answers.push(Input::ParametersKept(label.clone(), Ok(())));
                }
                Output::Route(Some(request)) => {
                    let chart = self.brain.chart();
                    let routes = self.routes.as_mut();
                    let answer = routes.and_then(|routes| routes.answer(chart, request, &Cancel::never()));
                    answers.extend(answer.map(Input::Route));
                }
                _ => {}
            }
            sink(now, BrainEvent::Output(output));
        }
        // A virtual disk never fails and takes no time, nor does planning a route.
        for input in answers {
            self.tell(input, sink);
        }
    }

    /// The next time at which there is something to do without other events.
    pub(crate) fn poll_timeout(&self) -> Option<MonoTime> {
        [self.hull.poll_timeout(), self.brain.poll_timeout()].into_iter().flatten().min()
    }

    /// Advances to a time: the brain gets the readings up to then, or a tick if its deadline is due.
    pub(crate) fn come_to(&mut self, now: Now, sink: &mut impl FnMut(Now, BrainEvent<'_>)) {
        self.now = now;
        while let Some(input) = self.hull.poll(now.mono) {
            self.tell(input, sink);
        }
        if self.brain.poll_timeout().is_some_and(|due| due <= now.mono) {
            self.tell(Input::Timer, sink);
        }
        self.hull.attend(&self.brain);
    }

    /// Advances the virtual clock to the next event, but not beyond `until`.
    pub(crate) fn advance(&mut self, until: MonoTime, sink: &mut impl FnMut(Now, BrainEvent<'_>)) {
        let before = self.now;
        // At least a microsecond, so that a missed deadline cannot stop the clock.
        let due = self.poll_timeout().unwrap_or(until).min(until);
        let mono = due.max(before.mono + Duration::from_micros(1));
        // A step of the clock fits 63 bits of microseconds.
        let utc = before.utc.micros() + mono.since(before.mono).as_micros() as i64;
        self.come_to(Now { mono, utc: UtcTime::from_micros(utc) }, sink);
    }
}
