//! Sentences in a stream of bytes.

use super::damage::DamagedSentence;
use super::report::{Report, read};
use crate::framer::{self, Grammar};

/// The longest sentence kept (bytes). NMEA allows 82; makers' own sentences are longer.
pub const LONGEST: usize = 256;

/// Finds sentences in a stream; noise before a `$` is skipped.
pub type Framer = framer::Framer<Sentences>;

/// How sentences are written.
#[derive(Debug, Clone)]
pub struct Sentences;

impl Grammar for Sentences {
    type Line = Report;
    type Damage = DamagedSentence;

    const START: Option<u8> = Some(b'$');
    const LONGEST: usize = LONGEST;
    const UNENDED: DamagedSentence = DamagedSentence::Unended;
    const TOO_LONG: DamagedSentence = DamagedSentence::TooLong;

    fn read(text: &[u8]) -> Result<Report, DamagedSentence> {
        read(text)
    }

    fn is_unended(damage: &DamagedSentence) -> bool {
        *damage == DamagedSentence::NoChecksum
    }
}
