//! The Inter-Module Communication protocol (LSTS IMC 5.4.31 and the Otters' additions), whole.
//!
//! - [`catalogue`]: what the definition says of all 351 messages; [`messages`]: a struct for each.
//! - [`PacketView`] looks at a packet in place, [`Packet`] holds a decoded one.
//! - [`Deframer`] and [`Frames`] find the packets in any stream of bytes and say what was damaged.
//! - [`reflect`] walks over the fields of any packet; [`json`] shows them as JSON and reads them back.
//! - [`lsf`]: logs as DUNE writes and Neptus MRA opens them.
//! - [`position`], [`logbook`], [`plan_digest`], [`services`], [`entities`], [`tuples`]: what fields mean beyond their
//!   type; [`names`]: the names of systems and entities over time; [`text`]: how bytes that are not text are shown.
//!
//! Everything here is a function of its arguments: no sockets, clock, threads or randomness. Bytes from
//! outside never cause a panic and never make it reserve memory by a count they state; unknown ids, unlisted
//! numbers, trailing bytes and either byte order survive a round trip. Messages inside messages ([`Nested`],
//! [`MessageList`]) are checked at once and decoded when they are asked for, so that a decoded packet takes
//! the memory it took on the wire and one struct.
//!
//! It knows `units` and nothing else of Lutra; what a vessel does with a message is left to other crates.

mod address;
pub mod catalogue;
mod crc;
mod deframe;
pub mod entities;
mod header;
pub mod json;
mod list;
pub mod logbook;
pub mod lsf;
#[rustfmt::skip]
#[expect(
    clippy::too_many_lines,
    clippy::default_trait_access,
    clippy::unreadable_literal,
    reason = "generated, with numbers as the catalogue has them"
)]
pub mod messages;
pub mod names;
mod nested;
mod packed;
mod packet;
pub mod plan_digest;
pub mod position;
pub mod reflect;
mod runs;
pub mod services;
pub mod text;
pub mod tuples;
mod wire;

pub use address::{Address, AddressError, AddressKind};
pub use crc::crc16;
pub use deframe::{Damage, Deframer, Frame, Frames};
pub use header::{
    ANY_ENTITY, FOOTER_BYTES, FrameError, HEADER_BYTES, Header, MAX_PACKET_BYTES, MAX_PAYLOAD_BYTES,
    PacketView, SYNC,
};
pub use list::MessageList;
pub use messages::{Message, Payload};
pub use nested::Nested;
pub use packet::{
    Body, DecodeError, EncodeError, Packet, ShortPayload, decode, encode_into, encode_payload, readdress_into,
};
pub use runs::{Run, Runs};
pub use text::Text;
pub use wire::{ByteOrder, MAX_DEPTH};
