//! Packets as JSON and back, without loss.
//!
//! One packet is one object:
//!
//! ```json
//! {"abbrev":"Temperature","id":263,
//!  "header":{"timestamp":1590400000.5,"src":10256,"src_ent":5,"dst":65535,"dst_ent":255},
//!  "fields":{"value":7.5}}
//! ```
//!
//! - Integers and reals are numbers; a single is given as the double of the same value. NaN and infinities
//!   are the texts `NaN`, `Infinity` and `-Infinity`; a NaN of unusual bits is `NaN:` and its bits in
//!   hexadecimal. An integer beyond ±2⁵³ is a text of its digits, because many readers would round it.
//! - Text is text; a byte that is not UTF-8, and NUL, is `\xNN` in it ([`crate::text::escape`] says how that is turned back,
//!   which is how tables have it too). Raw data is a text of hexadecimal digits.
//! - A nested message is `null` or `{"abbrev":…,"fields":…}`; a list is an array of these.
//! - `"endian":"big"` marks a big-endian packet, `"trailing":"…"` holds payload bytes after the last field,
//!   `"absent":[…]` names the last fields when an older sender left them out.
//!
//! Reading also takes what people write: labels such as `"NORMAL"` or `"PATH|SPEED"` for numbers, names or
//! `0x…` for addresses, and missing fields for defaults.

mod nested;
mod read;
mod write;

pub use nested::NestedText;
pub use read::{ReadDefaults, ReadError, message_from_value, read_packet};
pub use write::{WriteError, message_to_string, write_header, write_packet, write_text};

/// The bits of the NaN that arithmetic makes.
const QUIET_NAN_F32: u32 = 0x7FC0_0000;
const QUIET_NAN_F64: u64 = 0x7FF8_0000_0000_0000;
/// The greatest integer up to which a double holds every integer.
const MAX_EXACT: u64 = 1 << 53;
