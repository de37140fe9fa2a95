//! The watch over the card's silence and over frames that cannot be read.

use super::config::MotorAssignment;
use super::outbox::Outbox;
use super::trouble::motor_name;
use crate::{Note, State};
use devices::{Pair, Side};
use std::fmt::Display;
use std::time::Duration;
use units::MonoTime;

/// Frames that cannot be read are noted at most this often.
const NOTE_INTERVAL: Duration = Duration::from_mins(1);

/// The parts that were heard, and when.
#[derive(Debug, Clone)]
pub(super) struct Watch {
    silence: Duration,
    /// When the bus opened; the silence of what was never heard counts from here.
    opened: MonoTime,
    card: Option<MonoTime>,
    motors: Pair<Option<MonoTime>>,
    /// The next moment at which a silence may have become too long.
    next: Option<MonoTime>,
    /// Frames that could not be read since the last note, and when that was.
    unread: u64,
    noted: Option<MonoTime>,
}

impl Watch {
    pub(super) fn new(silence: Duration) -> Self {
        Self {
            silence,
            opened: MonoTime::default(),
            card: None,
            motors: Pair::default(),
            next: None,
            unread: 0,
            noted: None,
        }
    }

    pub(super) fn opened(&mut self, now: MonoTime) {
        (self.opened, self.card, self.motors) = (now, None, Pair::default());
    }

    /// A message came that was meant for the computer, perhaps of the card itself.
    pub(super) fn heard(&mut self, now: MonoTime, card: bool) {
        if card {
            if self.silent(now, self.card) {
                // The motors report in turn: each has its time again, from the card's return.
                self.opened(now);
            }
            self.card = Some(now);
        }
    }

    /// A motor reported.
    pub(super) fn feedback(&mut self, now: MonoTime, side: Side) {
        *self.motors.of_mut(side) = Some(now);
    }

    /// A frame could not be read, or was implausible.
    pub(super) fn unread(&mut self, now: MonoTime, error: &dyn Display, out: &mut Outbox) {
        self.unread += 1;
        if self.noted.is_some_and(|at| now.since(at) < NOTE_INTERVAL) {
            return;
        }
        let text = match std::mem::take(&mut self.unread) {
            0 | 1 => format!("a frame of the motor card is not used: {error}"),
            count => format!("{count} frames of the motor card are not used; the last one: {error}"),
        };
        self.noted = Some(now);
        out.note(Note { warning: true, text });
    }

    /// Works the state out.
    pub(super) fn tick(&mut self, now: MonoTime, open: bool, sides: Pair<MotorAssignment>, out: &mut Outbox) {
        self.next = None;
        if !open {
            return;
        }
        let card_silent = self.silent(now, self.card);
        // Both are asked, so that both deadlines are known.
        let motors_silent = self.motors.map(|at| self.silent(now, at));
        let deadlines = [self.card, self.motors.port, self.motors.starboard];
        let deadlines = deadlines.map(|at| at.unwrap_or(self.opened) + self.silence);
        self.next = deadlines.into_iter().filter(|deadline| *deadline > now).min();
        let silence_s = self.silence.as_secs_f64();
        if card_silent {
            let text = format!(
                "nothing from the motor card for {silence_s} s: check its power, the CAN cable and the speed of the bus"
            );
            return out.state(State::Failing(text));
        }
        let silent = Side::BOTH.into_iter().find(|side| *motors_silent.of(*side));
        if let Some(side) = silent {
            let motor = sides.of(side).motor;
            let name = motor_name(side);
            let text = format!(
                "{name} (motor {motor}) has given no feedback for {silence_s} s: check its power channel \
                 and its cable"
            );
            return out.state(State::Failing(text));
        }
        let heard = self.card.is_some() && self.motors.port.is_some() && self.motors.starboard.is_some();
        out.state(if heard { State::Working } else { State::Starting });
    }

    pub(super) fn poll_timeout(&self) -> Option<MonoTime> {
        self.next
    }

    fn silent(&self, now: MonoTime, heard: Option<MonoTime>) -> bool {
        now.since(heard.unwrap_or(self.opened)) >= self.silence
    }
}
