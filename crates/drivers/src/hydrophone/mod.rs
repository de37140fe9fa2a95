//! The Thelma Biotel hydrophone: its settings, its clock, its lines as readings, and whether it works.
//!
//! When the port opens, settings go by command mode, each answer compared; a wrong or missing one fails the start, which is
//! tried again, three times in all. Then the receiver listens, its clock is kept ([`Sync`]), and every line is a reading; one
//! that refused a setting stays in error meanwhile. How it listens and its clock is kept is a reading of its own, given before
//! the line that it matters to. Running numbers
//! reveal lost lines and restarts. With a sensor interval set, silence fails the receiver; bytes without a valid line tell
//! of a wrong baud rate. Detections are given from the first line on, even if something else fails.

mod clock;
mod continuity;
mod delays;
mod settings;

pub use clock::Sync;
pub use devices::ClockState;
pub use settings::{NoSetting, Setting};

use crate::outbox::Outbox;
use crate::{Driver, Input, Output, State};
use clock::{Keeper, Said, Stamp};
use continuity::{Continuity, Step};
use core::time::Duration;
use devices::tbr::{Ack, DamagedLine, Framer, Heard, Line};
use devices::tbr_clock::ClockCommand;
use devices::{Reading, ReceiverReading, TagReading, WaterReading};
use units::{MonoTime, Now};

/// The receiver takes a character a millisecond, no more.
const PACE: Duration = Duration::from_millis(1);
/// After a start that failed it is tried again.
const START_AGAIN: Duration = Duration::from_secs(5);
/// Starts that fail before the receiver is used with its present settings.
const STARTS: u32 = 3;
/// A pause ends a command: the answer to one and the next are at least so far apart.
const BETWEEN: Duration = Duration::from_millis(50);
/// So many bytes without a valid line are babble.
const BABBLE_BYTES: u64 = 512;

/// The settings of a receiver.
#[derive(Debug, Clone, PartialEq)]
pub struct ReceiverSettings {
    /// Sent in command mode when the port opens; empty leaves the receiver's settings unchanged.
    pub settings: Vec<Setting>,
    /// For an answer in command mode.
    pub reply_timeout: Duration,
    /// For the acknowledgement of a command of its clock.
    pub ack_timeout: Duration,
    /// How its clock is kept.
    pub sync: Sync,
    /// From one sensor line to the next, as the receiver is set (LI): without a line for one and a half times as long it
    /// fails. `None` where it sends no sensor lines, and silence says nothing.
    pub sensor_interval: Option<Duration>,
}

impl Default for ReceiverSettings {
    /// Only the clock's commands are sent, each sixth in full; answers within 4 s; silence is not a fault.
    fn default() -> Self {
        Self {
            settings: Vec::new(),
            reply_timeout: Duration::from_secs(4),
            ack_timeout: Duration::from_secs(5),
            sync: Sync::Marks { full_every: 6 },
            sensor_interval: None,
        }
    }
}

/// Counts since the port opened.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Counts {
    /// Detections.
    pub detections: u64,
    /// Sensor lines.
    pub sensor_lines: u64,
    /// Damaged lines.
    pub damaged: u64,
    /// Lines lost by the running numbers.
    pub lost: u64,
}

/// The stage of the start.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    Closed,
    /// Command mode was asked for.
    Entering(MonoTime),
    /// The setting of this index was sent.
    Setting(usize, MonoTime),
    /// The end of command mode was asked for.
    Leaving(MonoTime),
    Listening,
    /// A setting was not accepted.
    Refused(MonoTime),
}

impl Phase {
    const fn deadline(self) -> Option<MonoTime> {
        match self {
            Self::Closed | Self::Listening => None,
            Self::Entering(at) | Self::Setting(_, at) | Self::Leaving(at) | Self::Refused(at) => Some(at),
        }
    }
}

/// The driver of a hydrophone.
#[derive(Debug, Clone)]
pub struct Receiver {
    settings: ReceiverSettings,
    framer: Framer,
    phase: Phase,
    /// Starts that have failed since the port opened.
    failed: u32,
    /// Why the receiver is listened to although it did not take its settings.
    refusal: Option<Refusal>,
    keeper: Keeper,
    continuity: Continuity,
    /// The frequency in its lines (kHz).
    frequency_khz: Option<u8>,
    /// The last report of how it listens.
    told: ReceiverReading,
    /// When silence is too long.
    silent_at: Option<MonoTime>,
    /// Bytes since the last valid line.
    babble: u64,
    counts: Counts,
    outbox: Outbox,
}

/// A start that failed too often.
#[derive(Debug, Clone, PartialEq, Eq)]
struct Refusal {
    why: String,
    /// It did not answer at all: it may have had no power.
    silent: bool,
}

impl Receiver {
    /// A receiver behind a port that is not open.
    pub fn new(settings: ReceiverSettings) -> Self {
        let mut outbox = Outbox::default();
        outbox.state(State::Starting);
        let keeper = Keeper::new(settings.sync, settings.ack_timeout);
        Self {
            settings,
            framer: Framer::default(),
            phase: Phase::Closed,
            failed: 0,
            refusal: None,
            keeper,
            continuity: Continuity::default(),
            frequency_khz: None,
            told: ReceiverReading::default(),
            silent_at: None,
            babble: 0,
            counts: Counts::default(),
            outbox,
        }
    }

    /// How good its clock is.
    pub const fn clock(&self) -> ClockState {
        self.keeper.state()
    }

    /// The least of the last differences between the arrival of a line by this computer's clock and its stamp (s): how far the
    /// receiver's clock is behind, with the shortest delay of a line in it. `None` until stamps have come.
    pub fn clock_offset_s(&self) -> Option<f64> {
        self.keeper.offset_s()
    }

    /// Counts since the port opened.
    pub const fn counts(&self) -> Counts {
        self.counts
    }

    fn send(&mut self, at: MonoTime, text: &str) -> MonoTime {
        let bytes = text.as_bytes().to_vec();
        let sent = at + PACE * u32::try_from(bytes.len()).unwrap_or(u32::MAX);
        self.outbox.push(Output::Send { bytes, at, pace: PACE });
        sent
    }

    fn opened(&mut self, now: Now) {
        self.framer.clear();
        self.babble = 0;
        self.counts = Counts::default();
        self.failed = 0;
        self.refusal = None;
        self.outbox.state(State::Starting);
        self.start(now);
    }

    fn start(&mut self, now: Now) {
        self.keeper.stop();
        if self.settings.settings.is_empty() {
            self.listen(now);
            return;
        }
        let sent = self.send(now.mono, &ClockCommand::EnterCommands.text());
        self.phase = Phase::Entering(sent + self.settings.reply_timeout);
    }

    /// Sends a setting, or the end of command mode behind the last.
    fn set(&mut self, now: Now, index: usize) {
        let at = now.mono + BETWEEN;
        let wait = self.settings.reply_timeout;
        self.phase = if let Some(text) = self.settings.settings.get(index).map(Setting::text) {
            Phase::Setting(index, self.send(at, &text) + wait)
        } else {
            self.refusal = None;
            Phase::Leaving(self.send(at, &ClockCommand::LeaveCommands.text()) + wait)
        };
    }

    fn listen(&mut self, now: Now) {
        self.phase = Phase::Listening;
        self.keeper.start(now);
        self.await_line(now);
    }

    /// The start failed: says why and leaves command mode. It is tried again later, but not for ever: a receiver with a wrong
    /// setting hears more than one that is in command mode again and again.
    fn refuse(&mut self, now: Now, why: String, silent: bool) {
        self.failed += 1;
        self.outbox.state(State::Failing(why.clone()));
        let sent = self.send(now.mono + BETWEEN, &ClockCommand::LeaveCommands.text());
        self.phase = if self.failed < STARTS {
            Phase::Refused(sent + START_AGAIN)
        } else {
            self.outbox.note(true, format!("the hydrophone is listened to as it is: {why}"));
            self.refusal = Some(Refusal { why, silent: silent && self.failed == STARTS });
            Phase::Leaving(sent + self.settings.reply_timeout)
        };
    }

    fn await_line(&mut self, now: Now) {
        self.silent_at = self.settings.sensor_interval.map(|interval| now.mono + interval + interval / 2);
    }

    fn bytes(&mut self, now: Now, bytes: &[u8]) {
        self.babble += bytes.len() as u64;
        let mut reads = Vec::new();
        self.framer.feed(bytes, |_, read| reads.push(read));
        for read in reads {
            match read {
                Ok(Heard { line: Line::Reply(text), .. }) => self.reply(now, &text),
                Ok(Heard { line: Line::Ack(ack), .. }) => self.ack(now, ack),
                Ok(Heard { line: Line::Tag(tag), counter }) => self.tag(now, tag, counter),
                Ok(Heard { line: Line::Water(water), counter }) => self.water(now, water, counter),
                Err(error) => self.damage(&error),
            }
        }
        if self.babble >= BABBLE_BYTES && !self.outbox.is_failing() {
            let why = "bytes come but no valid line of the hydrophone: check the baud rate (115200) and the device at the port";
            self.outbox.state(State::Failing(why.to_owned()));
        }
    }

    fn tag(&mut self, now: Now, mut tag: TagReading, counter: Option<u16>) {
        self.counts.detections += 1;
        tag.lines_lost = self.line(now, counter);
        self.frequency_khz = Some(tag.frequency_khz);
        // What a tag sends lasts as long each time; a measurement is a part of it.
        let data = tag.data.map_or_else(String::new, |data| format!("={data}"));
        let sort = format!("{}-{}{data}", tag.protocol, tag.tag_id);
        self.stamp(now, Stamp { clock_s: tag.clock_s, millis: tag.millis, sort: Some(&sort) });
        self.tell(now);
        self.outbox.push(Output::Reading { at: now, reading: Reading::Tag(tag) });
    }

    fn water(&mut self, now: Now, mut water: WaterReading, counter: Option<u16>) {
        self.counts.sensor_lines += 1;
        water.lines_lost = self.line(now, counter);
        self.frequency_khz = Some(water.frequency_khz);
        // Its stamp is of whole seconds.
        self.stamp(now, Stamp { clock_s: water.clock_s, millis: 0, sort: None });
        self.tell(now);
        self.outbox.push(Output::Reading { at: now, reading: Reading::Water(water) });
    }

    /// A line with a running number, of a detection or of the water. Answers how many were lost before it, where that is known.
    fn line(&mut self, now: Now, counter: Option<u16>) -> Option<u16> {
        self.await_line(now);
        self.alive(now);
        match counter.map(|counter| self.continuity.take(now.mono, counter)) {
            None | Some(Step::First) => None,
            Some(Step::Next | Step::Again) => Some(0),
            Some(Step::Lost(lines)) => {
                self.counts.lost += u64::from(lines);
                let s = if lines == 1 { "" } else { "s" };
                self.outbox
                    .note(true, format!("{lines} line{s} of the hydrophone lost, by their running numbers"));
                Some(lines)
            }
            Some(Step::Restarted) => {
                let remedy = self.keeper.remedy();
                let why = format!(
                    "the hydrophone restarted: it counts its lines from elsewhere, and its clock may be anything; {remedy}"
                );
                self.keeper.lose(now, why.clone());
                self.outbox.note(true, why);
                None
            }
        }
    }

    /// A valid line came. An acknowledgement does not end the silence of a receiver that owes sensor lines.
    fn alive(&mut self, now: Now) {
        self.babble = 0;
        if self.phase != Phase::Listening || self.is_silent() {
            return;
        }
        let Some(refusal) = &mut self.refusal else { return self.outbox.state(State::Working) };
        self.outbox.state(State::Failing(refusal.why.clone()));
        if std::mem::take(&mut refusal.silent) {
            // It had no power when it was asked; it is asked once more.
            self.start(now);
        }
    }

    /// Whether it owes sensor lines and sends none.
    fn is_silent(&self) -> bool {
        self.settings.sensor_interval.is_some() && self.silent_at.is_none()
    }

    /// Gives how it listens and how its clock is, when that is another.
    fn tell(&mut self, now: Now) {
        let (clock, why) = self.keeper.of_lines();
        let reading = ReceiverReading {
            listening: self.phase == Phase::Listening && !self.is_silent() && self.babble < BABBLE_BYTES,
            frequency_khz: self.number_of("FC").or(self.frequency_khz),
            protocols: self.number_of("LM"),
            clock,
            clock_offset_s: self.keeper.offset_s(),
            clock_fault: why.to_owned(),
        };
        if reading != self.told {
            self.told = reading.clone();
            self.outbox.push(Output::Reading { at: now, reading: Reading::Receiver(reading) });
        }
    }

    /// The receiver's settings, if it accepted them.
    fn number_of(&self, name: &str) -> Option<u8> {
        let of = |setting: &Setting| setting.text().strip_prefix(name)?.strip_prefix('=')?.parse().ok();
        self.settings.settings.iter().rev().find_map(of).filter(|_| self.refusal.is_none())
    }

    fn stamp(&mut self, now: Now, stamp: Stamp<'_>) {
        let mut said = Vec::new();
        self.keeper.stamp(now, stamp, &mut said);
        self.say(said);
    }

    fn ack(&mut self, now: Now, ack: Ack) {
        self.alive(now);
        let mut said = Vec::new();
        self.keeper.ack(now, ack, &mut said);
        self.say(said);
    }

    fn say(&mut self, said: Vec<Said>) {
        for one in said {
            match one {
                Said::Send(command, at) => {
                    self.send(at, &command.text());
                }
                Said::Note(text) => self.outbox.note(false, text),
                Said::Warning(text) => self.outbox.note(true, text),
            }
        }
    }

    /// An answer, in command mode only a sign of life.
    fn reply(&mut self, now: Now, text: &str) {
        match self.phase {
            Phase::Entering(_) if text == ClockCommand::EnterCommands.text() => {
                self.babble = 0;
                self.set(now, 0);
            }
            Phase::Setting(index, _) => self.answered(now, index, text),
            Phase::Leaving(_) if text == ClockCommand::LeaveCommands.text() => {
                self.listen(now);
                self.alive(now);
            }
            // Answers to what an earlier start sent, and noise.
            Phase::Closed | Phase::Entering(_) | Phase::Leaving(_) | Phase::Listening | Phase::Refused(_) => {
            }
        }
    }

    fn answered(&mut self, now: Now, index: usize, text: &str) {
        let Some(setting) = self.settings.settings.get(index) else { return };
        if setting.accepts(text) {
            self.babble = 0;
            if setting.text() == ClockCommand::Version.text() {
                self.outbox.note(false, format!("the hydrophone's firmware: {text}"));
            }
            self.set(now, index + 1);
        } else if text != ClockCommand::EnterCommands.text() {
            let text: String = text.chars().take(40).collect();
            let (sent, expected) = (setting.text(), setting.expected());
            self.refuse(
                now,
                format!("the hydrophone answered '{text}' to {sent} where {expected} was due: check the setting and its firmware"),
                false,
            );
        }
    }

    fn damage(&mut self, error: &DamagedLine) {
        self.counts.damaged += 1;
        // The first, the tenth, the hundredth: a bad cable does not fill the log.
        if self.counts.damaged.checked_ilog10().is_some_and(|power| 10_u64.pow(power) == self.counts.damaged)
        {
            let damaged = self.counts.damaged;
            let text =
                format!("{damaged} damaged lines of the hydrophone since its port opened, the last: {error}");
            self.outbox.note(true, text);
        }
    }

    fn time(&mut self, now: Now) {
        if self.phase.deadline().is_some_and(|deadline| deadline <= now.mono) {
            self.overdue(now);
        }
        if self.silent_at.is_some_and(|at| at <= now.mono) {
            self.silent_at = None;
            let why = "no line of the hydrophone for longer than its sensor interval: check its power and cable, and LI";
            self.outbox.state(State::Failing(why.to_owned()));
        }
        let mut said = Vec::new();
        self.keeper.time(now, &mut said);
        self.say(said);
    }

    /// An answer did not come.
    fn overdue(&mut self, now: Now) {
        match self.phase {
            Phase::Closed | Phase::Listening => {}
            // It may be in command mode already, where this command has no answer.
            Phase::Entering(_) => self.set(now, 0),
            Phase::Setting(index, _) => {
                let sent = self.settings.settings.get(index).map(Setting::text).unwrap_or_default();
                let seconds = self.settings.reply_timeout.as_secs_f64();
                self.refuse(
                    now,
                    format!("the hydrophone did not answer {sent} within {seconds} s: check its power, its cable and the baud rate"),
                    true,
                );
            }
            Phase::Leaving(_) => {
                self.outbox.note(true, "the hydrophone did not confirm the end of command mode (EX!)");
                self.listen(now);
            }
            Phase::Refused(_) => self.start(now),
        }
    }
}

impl Driver for Receiver {
    fn handle(&mut self, now: Now, input: Input<'_>) {
        let mut said = Vec::new();
        self.keeper.watch(now, &mut said);
        self.say(said);
        match input {
            Input::Opened => self.opened(now),
            Input::Bytes(bytes) => self.bytes(now, bytes),
            Input::Lost => {
                self.phase = Phase::Closed;
                self.keeper.stop();
                self.silent_at = None;
                self.outbox.port_lost();
            }
            Input::Time => self.time(now),
        }
        self.tell(now);
    }

    fn poll_output(&mut self) -> Option<Output> {
        self.outbox.pop()
    }

    fn poll_timeout(&self) -> Option<MonoTime> {
        let keeper = self.keeper.timeout();
        keeper.into_iter().chain(self.silent_at).chain(self.phase.deadline()).min()
    }
}

#[cfg(test)]
mod tests;
