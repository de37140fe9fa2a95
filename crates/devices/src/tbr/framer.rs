//! Lines in the receiver's stream.

use super::parse::{Ack, DamagedLine, Heard, Line, parse};
use crate::framer::{self, Grammar};

/// The longest line kept (bytes); the receiver's are below 90.
pub const LONGEST: usize = 256;

/// Finds the receiver's lines in a stream; noise before a `$` is skipped, unless an acknowledgement stands in it.
pub type Framer = framer::Framer<ReceiverLines>;

/// How the receiver writes its lines.
#[derive(Debug, Clone)]
pub struct ReceiverLines;

impl Grammar for ReceiverLines {
    type Line = Heard;
    type Damage = DamagedLine;

    const START: Option<u8> = Some(b'$');
    const LONGEST: usize = LONGEST;
    const UNENDED: DamagedLine = DamagedLine::Unended;
    const TOO_LONG: DamagedLine = DamagedLine::TooLong;

    fn read(text: &[u8]) -> Result<Heard, DamagedLine> {
        parse(text)
    }

    fn is_unended(damage: &DamagedLine) -> bool {
        matches!(damage, DamagedLine::Fields { .. })
    }

    fn in_noise(text: &[u8]) -> Option<Heard> {
        let ack = Ack::find(&String::from_utf8_lossy(text))?;
        Some(Heard { line: Line::Ack(ack), counter: None })
    }
}
