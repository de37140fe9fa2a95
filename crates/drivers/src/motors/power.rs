//! Power channels: their labels, what was asked of each, and whether the card follows.

use super::config::ChannelConfig;
use super::outbox::Outbox;
use crate::Note;
use devices::torqeedo::CardCommand;
use devices::{PowerChannelReading, Reading};
use std::time::Duration;
use thiserror::Error;
use units::{MonoTime, Now};

/// The card is given this long to follow before it is asked again.
const FOLLOW: Duration = Duration::from_secs(1);
/// Asked so often, a channel that does not follow is refused.
const MOST_ASKED: u8 = 3;
/// The state of a channel is reported at least this often, where the card reports it.
const REPEAT: Duration = Duration::from_secs(10);

/// The documents of the card, which differ in the place of the 5 V output and in the names of the 12 V outputs.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ChannelTable {
    /// The later one, of DUNE: five rails; `H_5V` is channel 0 of rail 4.
    #[default]
    FiveRails,
    /// The earlier one, of its successor code: four rails; `H_5V` is channel 5 of rail 3.
    FourRails,
}

/// The labels of both documents, in the order of their channels.
pub const LABELS: [&str; 11] = [
    "H_MOT0", "H_MOT1", "H_AUX0", "H_AUX1", "H_12V0", "H_12V1", "H_12V2", "H_12V3", "H_VR0", "H_VR1", "H_5V",
];

impl ChannelTable {
    /// Rail and channel of a label; `None` of one that this document does not have.
    pub fn place(self, label: &str) -> Option<(u8, u8)> {
        Some(match (label, self) {
            ("H_MOT0", _) => (0, 0),
            ("H_MOT1", _) => (1, 0),
            ("H_AUX0", _) => (2, 0),
            ("H_AUX1", _) => (2, 1),
            ("H_12V0", Self::FourRails) | ("H_12V1", Self::FiveRails) => (3, 0),
            ("H_12V1", Self::FourRails) | ("H_12V2", Self::FiveRails) => (3, 1),
            ("H_12V2", Self::FourRails) | ("H_12V3", Self::FiveRails) => (3, 2),
            ("H_VR0", _) => (3, 3),
            ("H_VR1", _) => (3, 4),
            ("H_5V", Self::FiveRails) => (4, 0),
            ("H_5V", Self::FourRails) => (3, 5),
            _ => return None,
        })
    }
}

/// No power channel has this name.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
#[error("no power channel is called `{name}`; the configuration names {known}")]
pub struct UnknownChannel {
    name: String,
    known: String,
}

/// One channel and its state.
#[derive(Debug, Clone)]
struct Channel {
    config: ChannelConfig,
    /// The last order.
    asked: bool,
    /// It must be sent.
    due: bool,
    /// How often it was asked since it last followed, and when.
    times: u8,
    at: MonoTime,
    /// It has been noted that the card does not follow.
    refused: bool,
    /// The last order passed on, and when.
    passed_on: Option<(MonoTime, bool)>,
}

/// All channels with names.
#[derive(Debug, Clone)]
pub(super) struct PowerChannels {
    channels: Vec<Channel>,
}

impl PowerChannels {
    pub(super) fn new(configs: &[ChannelConfig]) -> Self {
        let channel = |config: &ChannelConfig| Channel {
            asked: config.on,
            due: false,
            times: 0,
            at: MonoTime::default(),
            refused: false,
            passed_on: None,
            config: config.clone(),
        };
        Self { channels: configs.iter().map(channel).collect() }
    }

    /// Every channel is asked again.
    pub(super) fn ask_all(&mut self) {
        self.channels.iter_mut().for_each(Channel::ask);
    }

    /// Asks for another state of a channel.
    pub(super) fn switch(&mut self, name: &str, on: bool) -> Result<(), UnknownChannel> {
        let Some(channel) = self.channels.iter_mut().find(|channel| channel.config.name == name) else {
            let known: Vec<&str> = self.channels.iter().map(|channel| &channel.config.name[..]).collect();
            let known = if known.is_empty() { "none".to_owned() } else { known.join(", ") };
            return Err(UnknownChannel { name: name.to_owned(), known });
        };
        channel.asked = on;
        channel.ask();
        Ok(())
    }

    /// Sends what is due.
    pub(super) fn due(&mut self, now: MonoTime, out: &mut Outbox) {
        for channel in self.channels.iter_mut().filter(|channel| channel.due) {
            let ChannelConfig { rail, channel: number, .. } = channel.config;
            channel.due = false;
            channel.times += 1;
            channel.at = now;
            out.power(CardCommand::OutputSet { rail, channel: number, on: channel.asked });
        }
    }

    /// The card reports which channels of a rail are on, bit by bit.
    pub(super) fn report(&mut self, now: Now, rail: u8, bits: u32, out: &mut Outbox) {
        for channel in self.channels.iter_mut().filter(|channel| channel.config.rail == rail) {
            let on = bits.checked_shr(channel.config.channel.into()).unwrap_or(0) & 1 == 1;
            channel.compare(now.mono, on, out);
            let due =
                channel.passed_on.is_none_or(|(at, before)| before != on || now.mono.since(at) >= REPEAT);
            if due {
                channel.passed_on = Some((now.mono, on));
                let name = channel.config.name.clone();
                out.reading(now, Reading::PowerChannel(PowerChannelReading { rail, name, on }));
            }
        }
    }
}

impl Channel {
    fn ask(&mut self) {
        (self.due, self.times, self.refused) = (true, 0, false);
    }

    /// Compares what is with what was asked.
    fn compare(&mut self, now: MonoTime, on: bool, out: &mut Outbox) {
        if self.due || self.times == 0 {
            return;
        }
        let name = &self.config.name;
        let word = |on: bool| if on { "on" } else { "off" };
        if on == self.asked {
            // A channel that falls off later is asked again from the first.
            self.times = 1;
            if std::mem::take(&mut self.refused) {
                out.note(Note { warning: false, text: format!("power channel `{name}` is {}", word(on)) });
            }
        } else if self.refused || now.since(self.at) < FOLLOW {
            // It is noted already, or the card has had no time to follow.
        } else if self.times < MOST_ASKED {
            self.due = true;
        } else {
            self.refused = true;
            let ChannelConfig { rail, channel, .. } = self.config;
            let text = format!(
                "power channel `{name}` (rail {rail}, channel {channel}) stays {}: refused after {MOST_ASKED} times; \
                 look at the rail's fuse and at the label's place in the configuration",
                word(on)
            );
            out.note(Note { warning: true, text });
        }
    }
}
