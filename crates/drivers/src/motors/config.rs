//! The card's settings, which differ between vessels: the motors' sides, the rate of commands, the channels' names.

use devices::torqeedo::{MOTORS, RAILS};
use devices::{Pair, Side};
use std::time::Duration;
use thiserror::Error;

/// A throttle is sent at least this often: the card stops a motor after a second, and one frame may be lost.
const LONGEST_WRITE_PERIOD: Duration = Duration::from_millis(500);
/// Commands live no longer than the card would keep them.
const LONGEST_COMMAND: Duration = Duration::from_secs(1);
/// A rail's channels are bits of a 32-bit number.
const CHANNELS_OF_RAIL: u8 = 32;
/// The most named channels; the card has fewer.
const MOST_CHANNELS: usize = 32;

/// One side's motor.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct MotorAssignment {
    /// Its number on the bus, 0 or 1.
    pub motor: u8,
    /// Whether it turns astern when commanded ahead, as a motor mounted or wired the other way round does.
    pub reversed: bool,
}

impl MotorAssignment {
    /// 1, or -1 for a reversed motor.
    pub(super) fn sign(self) -> f64 {
        if self.reversed { -1.0 } else { 1.0 }
    }
}

/// The card's settings, which differ between vessels.
#[derive(Debug, Clone, PartialEq)]
pub struct MotorsConfig {
    /// Time between two commands to the motors; see [`write_period`].
    pub write_period: Duration,
    /// How long a command lives that is not renewed.
    pub command_timeout: Duration,
    /// After this silence of the card, or of a motor's feedback, it is failing.
    pub silence: Duration,
    /// Which motor is on which side. Control takes motor 0 as port, while the names of the power channels of the boats say
    /// the contrary: it has to be tried on the vessel.
    pub sides: Pair<MotorAssignment>,
    /// The power channels that have a name; others are let be.
    pub channels: Vec<ChannelConfig>,
}

impl Default for MotorsConfig {
    /// As the DUNE task has it: four commands a second, motor 0 to port; no power channels.
    fn default() -> Self {
        let straight = |motor| MotorAssignment { motor, reversed: false };
        Self {
            write_period: Duration::from_millis(250),
            command_timeout: Duration::from_millis(500),
            silence: Duration::from_secs(2),
            sides: Pair::new(straight(0), straight(1)),
            channels: Vec::new(),
        }
    }
}

/// Why a configuration is refused.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum ConfigError {
    /// Commands too seldom.
    #[error(
        "the motors would be commanded every {0:?}, and the card stops them after 1 s; lower `Motor write divider` until it is at most 0.5 s"
    )]
    WritePeriod(Duration),
    /// Commands that live too long, or not at all.
    #[error("`Command Timeout` is {0:?}; choose more than zero and at most 1 s")]
    CommandTimeout(Duration),
    /// One motor for both sides, or one that does not exist.
    #[error("port is motor {port} and starboard motor {starboard}; one must be 0 and the other 1")]
    Sides {
        /// Motor to port.
        port: u8,
        /// Motor to starboard.
        starboard: u8,
    },
    /// A channel that the card cannot have.
    #[error("power channel `{0}` is on rail {1}, channel {2}; rails are 0 to 4, channels 0 to 31")]
    Channel(String, u8, u8),
    /// Two names for one channel, or two channels of one name.
    #[error("power channels `{0}` and `{1}` are the same; give each name and each channel once")]
    Twice(String, String),
    /// More channels than a card has.
    #[error("{0} power channels are named; the card has no more than 32")]
    TooMany(usize),
}

/// The time between commands to the motors when every `divider`th step of `frequency_hz` has one. `None` where that is not
/// a time, or longer than a day.
pub fn write_period(frequency_hz: f64, divider: u32) -> Option<Duration> {
    let period_s = f64::from(divider) / frequency_hz;
    (period_s > 0.0 && period_s < 86_400.0).then(|| Duration::from_secs_f64(period_s))
}

impl MotorsConfig {
    pub(super) fn check(&self) -> Result<(), ConfigError> {
        if self.write_period.is_zero() || self.write_period > LONGEST_WRITE_PERIOD {
            return Err(ConfigError::WritePeriod(self.write_period));
        }
        if self.command_timeout.is_zero() || self.command_timeout > LONGEST_COMMAND {
            return Err(ConfigError::CommandTimeout(self.command_timeout));
        }
        let (port, starboard) = (self.sides.port.motor, self.sides.starboard.motor);
        if port == starboard || port >= MOTORS || starboard >= MOTORS {
            return Err(ConfigError::Sides { port, starboard });
        }
        if self.channels.len() > MOST_CHANNELS {
            return Err(ConfigError::TooMany(self.channels.len()));
        }
        for (place, one) in self.channels.iter().enumerate() {
            if one.rail >= RAILS || one.channel >= CHANNELS_OF_RAIL {
                return Err(ConfigError::Channel(one.name.clone(), one.rail, one.channel));
            }
            let same = |other: &&ChannelConfig| {
                other.name == one.name || (other.rail, other.channel) == (one.rail, one.channel)
            };
            if let Some(other) = self.channels[..place].iter().find(same) {
                return Err(ConfigError::Twice(other.name.clone(), one.name.clone()));
            }
        }
        Ok(())
    }

    /// The side of a motor by its number.
    pub(super) fn side_of(&self, motor: u8) -> Option<(Side, MotorAssignment)> {
        let mut sides = Side::BOTH.into_iter().map(|side| (side, *self.sides.of(side)));
        sides.find(|(_, assignment)| assignment.motor == motor)
    }
}

/// A power channel with a name.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct ChannelConfig {
    /// The name, as consoles use it.
    pub name: String,
    /// Its rail.
    pub rail: u8,
    /// Its number on the rail.
    pub channel: u8,
    /// Whether it is on at the start.
    pub on: bool,
}
