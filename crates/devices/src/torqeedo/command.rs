//! Commands of the vessel's computer to the card: throttles and power channels, encoded and decoded.

use super::{CARD, COMPUTER, FULL_THROTTLE, MessageId, identifier};
use crate::can::{CanFrame, MOST_DATA};
use crate::pair::Pair;
use thiserror::Error;

/// A command of the computer to the card.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CardCommand {
    /// Throttle of motor 0 (as port) and motor 1 (as starboard) in per mille, -1000 to 1000.
    MotorSet(Pair<i16>),
    /// A power channel on or off.
    OutputSet {
        /// Rail of the channel.
        rail: u8,
        /// Number of the channel on its rail.
        channel: u8,
        /// On or off.
        on: bool,
    },
}

/// Why the card makes nothing of a frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum CardError {
    /// The identifier is not that of a message from the computer to the card.
    #[error("the frame {0:08X} is not addressed by the computer to the card")]
    Address(u32),
    /// The message is not one that the card obeys.
    #[error("the card does not obey {0}")]
    Message(MessageId),
    /// Too few or too many bytes.
    #[error("{message} has {len} bytes")]
    Length {
        /// The message.
        message: MessageId,
        /// Bytes found.
        len: u8,
    },
    /// A throttle beyond full speed.
    #[error("the throttle {0} is not within -1000 to 1000")]
    Throttle(i16),
}

impl CardCommand {
    /// Reads a frame as the card does.
    ///
    /// # Errors
    /// When the frame is not for the card, or is not one that it obeys.
    pub fn parse(frame: &CanFrame) -> Result<Self, CardError> {
        let addressed = frame.id() & 0xF_FFFF;
        if addressed != identifier(MessageId(0), COMPUTER, CARD) {
            return Err(CardError::Address(frame.id()));
        }
        // 29 bits less 20 are 9.
        let message = MessageId((frame.id() >> 20) as u16);
        match (message, frame.data()) {
            (MessageId::MOTOR_SET, &[p0, p1, s0, s1]) => {
                let set = Pair::new(i16::from_le_bytes([p0, p1]), i16::from_le_bytes([s0, s1]));
                for throttle in [set.port, set.starboard] {
                    if !(-FULL_THROTTLE..=FULL_THROTTLE).contains(&throttle) {
                        return Err(CardError::Throttle(throttle));
                    }
                }
                Ok(Self::MotorSet(set))
            }
            (MessageId::OUTPUT_SET, &[rail, channel, on]) => {
                Ok(Self::OutputSet { rail, channel, on: on != 0 })
            }
            (MessageId::MOTOR_SET | MessageId::OUTPUT_SET, _) => {
                Err(CardError::Length { message, len: frame.stated_len() })
            }
            _ => Err(CardError::Message(message)),
        }
    }

    /// The frame by which the computer asks for this.
    pub fn frame(self) -> CanFrame {
        match self {
            Self::MotorSet(set) => {
                let ([p0, p1], [s0, s1]) = (set.port.to_le_bytes(), set.starboard.to_le_bytes());
                from_computer(MessageId::MOTOR_SET, [p0, p1, s0, s1])
            }
            Self::OutputSet { rail, channel, on } => {
                from_computer(MessageId::OUTPUT_SET, [rail, channel, u8::from(on)])
            }
        }
    }
}

fn from_computer<const N: usize>(message: MessageId, data: [u8; N]) -> CanFrame {
    const { assert!(N <= MOST_DATA) };
    let frame = CanFrame::new(identifier(message, COMPUTER, CARD), &data);
    frame.expect("invariant: nine bits before twenty are 29, and no command has more than eight bytes")
}

/// A throttle (-1 to 1) in per mille of full speed, truncated toward zero; beyond full speed it is full speed. `None`
/// for what is not a number.
pub fn per_mille(throttle: f64) -> Option<i16> {
    let full = f64::from(FULL_THROTTLE);
    // Within full speed either way, which 16 bits hold.
    (!throttle.is_nan()).then(|| (throttle * full).clamp(-full, full) as i16)
}
