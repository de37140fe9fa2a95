//! Outputs that wait to be polled, with a bound on each kind and a rule for what happens at the bound.

use super::throttle::Throttle;
use crate::{Note, State};
use devices::Reading;
use devices::torqeedo::{CanFrame, CardCommand};
use std::collections::VecDeque;
use units::{MonoTime, Now};

/// Readings of about seven seconds; the oldest are dropped.
const MOST_READINGS: usize = 256;
/// The oldest are dropped.
const MOST_NOTES: usize = 32;
/// Commands to power channels: three for each of the most that are named. The oldest are dropped; the card's report shows
/// that its channel did not follow, and it is asked again.
const MOST_POWER: usize = 96;

/// An output of the card's driver: a frame to send, or a result.
#[derive(Debug, Clone, PartialEq)]
pub enum MotorsOutput {
    /// A command to the motors: it goes ahead of all frames that wait, and in place of an earlier one.
    Throttle {
        /// The frame.
        frame: CanFrame,
        /// When the command has lived its time, and must not be sent any more; `None` for a stop.
        until: Option<MonoTime>,
    },
    /// Another frame for the bus.
    Frame(CanFrame),
    /// A device has read something.
    Reading {
        /// When the frame came.
        at: Now,
        /// The reading.
        reading: Reading,
    },
    /// The state of card and motors is another.
    State(State),
    /// An entry for the log.
    Note(Note),
}

/// The waiting outputs. Throttles go first and only the last one counts.
#[derive(Debug, Clone, Default)]
pub(super) struct Outbox {
    throttle: Option<Throttle>,
    power: VecDeque<CanFrame>,
    state: Option<State>,
    last_state: Option<State>,
    notes: VecDeque<Note>,
    readings: VecDeque<(Now, Reading)>,
}

impl Outbox {
    pub(super) fn throttle(&mut self, throttle: Throttle) {
        self.throttle = Some(throttle);
    }

    pub(super) fn power(&mut self, command: CardCommand) {
        push(&mut self.power, command.frame(), MOST_POWER);
    }

    pub(super) fn reading(&mut self, at: Now, reading: Reading) {
        push(&mut self.readings, (at, reading), MOST_READINGS);
    }

    pub(super) fn note(&mut self, note: Note) {
        push(&mut self.notes, note, MOST_NOTES);
    }

    /// The state, where it is another than the last.
    pub(super) fn state(&mut self, state: State) {
        if self.last_state.as_ref() != Some(&state) {
            self.last_state = Some(state.clone());
            self.state = Some(state);
        }
    }

    /// The bus is gone, and what was meant for it is stale when it comes back.
    pub(super) fn forget_frames(&mut self) {
        self.throttle = None;
        self.power.clear();
    }

    pub(super) fn poll(&mut self) -> Option<MotorsOutput> {
        let throttle =
            self.throttle.take().map(|Throttle { frame, until }| MotorsOutput::Throttle { frame, until });
        throttle
            .or_else(|| self.power.pop_front().map(MotorsOutput::Frame))
            .or_else(|| self.state.take().map(MotorsOutput::State))
            .or_else(|| self.notes.pop_front().map(MotorsOutput::Note))
            .or_else(|| self.readings.pop_front().map(|(at, reading)| MotorsOutput::Reading { at, reading }))
    }
}

fn push<T>(queue: &mut VecDeque<T>, item: T, most: usize) {
    if queue.len() >= most {
        queue.pop_front();
    }
    queue.push_back(item);
}
