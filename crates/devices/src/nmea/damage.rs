//! Damage of a sentence.

/// Why a sentence is not read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DamagedSentence {
    /// It does not begin with `$`.
    #[error("no NMEA sentence: it does not begin with $")]
    NoStart,
    /// A byte is not a printable character.
    #[error("bytes that are not text: the baud rate may be wrong")]
    NotText,
    /// Another sentence begins, or the stream ends, before its line end.
    #[error("the sentence is cut short")]
    Unended,
    /// It is longer than [`LONGEST`](super::LONGEST).
    #[error("longer than 256 bytes without a line end")]
    TooLong,
    /// It has no checksum, without which a serial line cannot be trusted.
    #[error("no checksum")]
    NoChecksum,
    /// Its checksum is another.
    #[error("checksum {stands}, computed {computed:02X}")]
    Checksum {
        /// The checksum after `*`.
        stands: String,
        /// The checksum of the bytes.
        computed: u8,
    },
    /// It has too few fields.
    #[error("{address} has {stand} fields, {least} are needed")]
    TooFew {
        /// The sentence's address.
        address: String,
        /// Fields that it has.
        stand: usize,
        /// Fields that it must have.
        least: usize,
    },
    /// A field is not valid.
    #[error("field {index} of {address} is not valid: '{text}'")]
    Field {
        /// The sentence's address.
        address: String,
        /// The field's number, the address being 0.
        index: usize,
        /// The text found.
        text: String,
    },
}
