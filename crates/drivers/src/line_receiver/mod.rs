//! Receivers of fish tags that only talk: Innovasea's VR2C and Rx-LIVE, and any whose lines a pattern declares.
//!
//! They write a line for each detection and their clock cannot be set. Configured commands, if any, are sent unchanged when
//! the port opens, one character per millisecond. Silence is not a fault, as no fish is near most of the time, unless the
//! receiver is known to report now and then; bytes without a valid line indicate a wrong baud rate or pattern.

use crate::outbox::Outbox;
use crate::{Driver, Input, Output, State};
use core::time::Duration;
use devices::lines::{Lines, Piece};
use devices::pattern::{self, Pattern};
use devices::vr2c;
use devices::{Reading, TagReading};
use units::{MonoTime, Now};

/// From one character to the next.
const PACE: Duration = Duration::from_millis(1);
/// So many bytes without a valid line are babble.
const BABBLE_BYTES: u64 = 2048;

/// How a receiver's lines read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Language {
    /// VR2C and Rx-LIVE.
    Innovasea,
    /// As declared.
    Pattern(Pattern),
}

/// The settings of a receiver.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LineReceiverSettings {
    /// How its lines read.
    pub language: Language,
    /// Sent when the port opens, in order.
    pub init: Vec<Vec<u8>>,
    /// Without any line for so long it fails; `None` where it may be silent.
    pub longest_silence: Option<Duration>,
}

/// The driver of such a receiver.
#[derive(Debug, Clone)]
pub struct LineReceiver {
    settings: LineReceiverSettings,
    lines: Lines,
    silent_at: Option<MonoTime>,
    /// Bytes since the last valid line.
    babble: u64,
    damaged: u64,
    outbox: Outbox,
}

/// The kind of a line.
enum Heard {
    Tag(TagReading),
    Status(String),
}

impl LineReceiver {
    /// A receiver behind a port that is not open.
    pub fn new(settings: LineReceiverSettings) -> Self {
        let mut outbox = Outbox::default();
        outbox.state(State::Starting);
        let lines = Lines::new(None, vr2c::LONGEST.max(pattern::LONGEST));
        Self { settings, lines, silent_at: None, babble: 0, damaged: 0, outbox }
    }

    fn opened(&mut self, now: Now) {
        self.lines.clear();
        (self.babble, self.damaged) = (0, 0);
        let mut at = now.mono;
        for bytes in &self.settings.init {
            self.outbox.push(Output::Send { bytes: bytes.clone(), at, pace: PACE });
            at = at + PACE * u32::try_from(bytes.len()).unwrap_or(u32::MAX);
        }
        self.silent_at = self.settings.longest_silence.map(|longest| at + longest);
        // A receiver that may be silent has no other sign of life.
        if self.silent_at.is_none() {
            self.outbox.state(State::Working);
        }
    }

    fn bytes(&mut self, now: Now, bytes: &[u8]) {
        self.babble += bytes.len() as u64;
        let mut heard = Vec::new();
        let language = &self.settings.language;
        self.lines.feed(bytes, |_, piece| match piece {
            Piece::Line(text) | Piece::Cut(text) if text.trim_ascii().is_empty() => {}
            Piece::Line(text) | Piece::Cut(text) => heard.push(language.read(text)),
            Piece::TooLong => heard.push(Err("a line is longer than 512 bytes".to_owned())),
        });
        for one in heard {
            match one {
                Ok(Heard::Tag(tag)) => {
                    self.alive(now);
                    self.outbox.push(Output::Reading { at: now, reading: Reading::Tag(tag) });
                }
                Ok(Heard::Status(text)) => {
                    self.alive(now);
                    self.outbox.note(false, format!("the receiver reports: {text}"));
                }
                Err(why) => self.damage(&why),
            }
        }
        if self.babble >= BABBLE_BYTES {
            let why = "bytes of the receiver make no lines: check its baud rate, and which receiver or pattern is configured";
            self.outbox.state(State::Failing(why.to_owned()));
        }
    }

    fn alive(&mut self, now: Now) {
        self.babble = 0;
        self.silent_at = self.settings.longest_silence.map(|longest| now.mono + longest);
        self.outbox.state(State::Working);
    }

    fn damage(&mut self, why: &str) {
        self.damaged += 1;
        // The first, the tenth, the hundredth: a bad cable does not fill the log.
        if self.damaged.checked_ilog10().is_some_and(|power| 10_u64.pow(power) == self.damaged) {
            let text = format!(
                "{} damaged lines of the receiver since its port opened, the last: {why}",
                self.damaged
            );
            self.outbox.note(true, text);
        }
    }
}

impl Language {
    fn read(&self, line: &[u8]) -> Result<Heard, String> {
        match self {
            Self::Innovasea => match vr2c::parse(line) {
                Ok(vr2c::Line::Tag(found)) => Ok(Heard::Tag(found.tag)),
                Ok(vr2c::Line::Status(status)) => Ok(Heard::Status(status.text)),
                Err(error) => Err(error.to_string()),
            },
            Self::Pattern(pattern) => pattern.read(line).map(Heard::Tag).map_err(|error| error.to_string()),
        }
    }
}

impl Driver for LineReceiver {
    fn handle(&mut self, now: Now, input: Input<'_>) {
        match input {
            Input::Opened => self.opened(now),
            Input::Bytes(bytes) => self.bytes(now, bytes),
            Input::Lost => {
                self.silent_at = None;
                self.outbox.port_lost();
            }
            Input::Time => {
                if self.silent_at.is_some_and(|at| at <= now.mono) {
                    self.silent_at = None;
                    let why =
                        "no line of the receiver for longer than it may be silent: check its power and cable";
                    self.outbox.state(State::Failing(why.to_owned()));
                }
            }
        }
    }

    fn poll_output(&mut self) -> Option<Output> {
        self.outbox.pop()
    }

    fn poll_timeout(&self) -> Option<MonoTime> {
        self.silent_at
    }
}

#[cfg(test)]
mod tests;
