//! Whole packets: header and message together, to bytes and back.

use crate::catalogue::{self, MessageDesc};
use crate::crc;
use crate::header::{FOOTER_BYTES, FrameError, HEADER_BYTES, Header, MAX_PAYLOAD_BYTES, PacketView, SYNC};
use crate::messages::{Message, Payload};
use crate::reflect::{self, WalkError};
use crate::wire::{ByteOrder, Reader, Unwritable, Writer};

/// One packet, decoded.
#[derive(Debug, Clone, PartialEq)]
pub struct Packet {
    /// Sender, receiver and time.
    pub header: Header,
    /// The message.
    pub body: Body,
    /// The sender's byte order; [`ByteOrder::Little`] for packets of our own.
    pub order: ByteOrder,
    /// Payload bytes after the last field: how a newer sender with more fields looks.
    pub trailing: Vec<u8>,
    /// For an older sender, how many of the message's fields it sent; the others hold their defaults.
    pub fields_sent: Option<usize>,
}

/// The contents of a packet.
#[derive(Debug, Clone, PartialEq)]
pub enum Body {
    /// A message of the catalogue.
    Known(Message),
    /// A message that the catalogue lacks (see [`PacketView::desc`]).
    Unknown {
        /// Its id.
        id: u16,
        /// Its payload as it came.
        payload: Vec<u8>,
    },
}

/// How to treat a payload that ends before the message's last field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum ShortPayload {
    /// Accept the older layouts that the catalogue knows, such as the 21-byte TBRFishTag; anything else
    /// that is short is damage.
    #[default]
    KnownLayouts,
    /// Accept any payload that ends between two fields of the outer message.
    AnyBoundary,
}

/// What is wrong with a packet.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DecodeError {
    /// It is not a whole, undamaged packet.
    #[error(transparent)]
    Frame(#[from] FrameError),
    /// Its payload cannot be what its message id says.
    #[error("{message} ({id}): {error}")]
    Payload {
        /// The message's abbreviation.
        message: &'static str,
        /// The message's id.
        id: u16,
        /// What and where.
        error: WalkError,
    },
}

impl DecodeError {
    /// A stable word for machines.
    pub fn class(&self) -> &'static str {
        match self {
            Self::Frame(error) => error.class(),
            Self::Payload { error, .. } => error.class(),
        }
    }
}

/// Why a packet cannot be written.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum EncodeError {
    /// A text or raw value is too long for its 16-bit length.
    #[error("{message}: a value of {bytes} bytes; a field holds at most 65535")]
    Value {
        /// The message's abbreviation.
        message: &'static str,
        /// Bytes of the value.
        bytes: usize,
    },
    /// A list has too many elements for its 16-bit count.
    #[error("{message}: a list of {count} messages; a list holds at most 65535")]
    List {
        /// The message's abbreviation.
        message: &'static str,
        /// Elements of the list.
        count: usize,
    },
    /// Messages are nested too deep.
    #[error("{message}: messages are nested more than {} deep", crate::wire::MAX_DEPTH)]
    Depth {
        /// The message's abbreviation.
        message: &'static str,
    },
    /// The payload is too long for its 16-bit length.
    #[error("{message}: the payload has {bytes} bytes; a packet holds at most 65535")]
    Payload {
        /// The message's abbreviation.
        message: &'static str,
        /// Bytes of the payload.
        bytes: usize,
    },
}

impl From<Message> for Body {
    fn from(message: Message) -> Self {
        Self::Known(message)
    }
}

impl Packet {
    /// A packet of our own.
    pub fn new(header: Header, message: impl Into<Message>) -> Self {
        Self {
            header,
            body: Body::Known(message.into()),
            order: ByteOrder::Little,
            trailing: Vec::new(),
            fields_sent: None,
        }
    }

    /// The message, when the catalogue knows it.
    pub fn message(&self) -> Option<&Message> {
        match &self.body {
            Body::Known(message) => Some(message),
            Body::Unknown { .. } => None,
        }
    }

    /// The message as the type wanted, when it is one.
    pub fn get<T: Payload>(&self) -> Option<&T> {
        self.message().and_then(T::of)
    }

    /// The message id on the wire.
    pub fn id(&self) -> u16 {
        match &self.body {
            Body::Known(message) => message.id(),
            Body::Unknown { id, .. } => *id,
        }
    }

    /// Reads the packet that `bytes` start with.
    ///
    /// # Errors
    /// When there is no whole, undamaged packet or its fields do not fit its payload.
    pub fn decode(bytes: &[u8]) -> Result<Self, DecodeError> {
        Self::from_view(&PacketView::new(bytes)?, ShortPayload::default())
    }

    /// Reads the message of a packet whose frame was checked.
    ///
    /// # Errors
    /// When its fields do not fit its payload.
    pub fn from_view(view: &PacketView<'_>, short: ShortPayload) -> Result<Self, DecodeError> {
        let lenient = short == ShortPayload::AnyBoundary;
        let (header, order, payload) = (view.header(), view.order(), view.payload());
        let mut reader = Reader::new(payload, order, lenient);
        let mut fields_sent = None;
        let (body, at) = match view.desc().and_then(|_| Message::read(view.id(), &mut reader)) {
            None => (Body::Unknown { id: view.id(), payload: payload.to_vec() }, payload.len()),
            Some(Ok(message)) => {
                if reader.is_short() {
                    fields_sent = Some(boundary(message.desc(), payload, order)?);
                }
                (Body::Known(message), reader.at())
            }
            Some(Err(_)) => return Err(located(view.id(), payload, order)),
        };
        Ok(Self { header, body, order, trailing: payload[at..].to_vec(), fields_sent })
    }

    /// Appends the packet's bytes to `out`; on failure `out` is as before.
    ///
    /// # Errors
    /// When a value, list or the whole is too long for its 16-bit length.
    pub fn encode_into(&self, out: &mut Vec<u8>) -> Result<(), EncodeError> {
        let start = out.len();
        let (id, name) = match &self.body {
            Body::Known(message) => (message.id(), message.abbrev()),
            Body::Unknown { id, .. } => (*id, "unknown message"),
        };
        frame(out, start, id, name, &self.header, self.order, |out| {
            match &self.body {
                Body::Unknown { payload, .. } => out.extend_from_slice(payload),
                Body::Known(message) => {
                    let mut writer = Writer::new(out, self.order);
                    message.write(&mut writer);
                    if let Some(fault) = writer.fault() {
                        return Err(fault);
                    }
                    if let Some(sent) = self.fields_sent {
                        let payload = &out[start + HEADER_BYTES..];
                        let end = reflect::field_offset(message.desc(), payload, self.order, sent);
                        out.truncate(start + HEADER_BYTES + end);
                    }
                }
            }
            out.extend_from_slice(&self.trailing);
            Ok(())
        })
    }

    /// The packet's bytes.
    ///
    /// # Errors
    /// As [`Self::encode_into`].
    pub fn encode(&self) -> Result<Vec<u8>, EncodeError> {
        let payload = match &self.body {
            Body::Known(message) => message.desc().min_bytes(),
            Body::Unknown { payload, .. } => payload.len(),
        };
        // All of it, unless text, bytes or messages follow.
        let bytes = HEADER_BYTES + payload + self.trailing.len() + FOOTER_BYTES;
        let mut out = Vec::with_capacity(bytes);
        self.encode_into(&mut out).map(|()| out)
    }
}

/// Appends a little-endian packet of one message to `out`; on failure `out` is as before.
///
/// # Errors
/// When a value, list or the whole is too long for its 16-bit length.
pub fn encode_into<T: Payload>(out: &mut Vec<u8>, header: &Header, message: &T) -> Result<(), EncodeError> {
    let start = out.len();
    frame(out, start, T::ID, T::DESC.abbrev, header, ByteOrder::Little, |out| {
        let mut writer = Writer::new(out, ByteOrder::Little);
        message.write(&mut writer);
        writer.fault().map_or(Ok(()), Err)
    })
}

/// Reads the message of a packet whose frame was checked, when it is a `T` (see [`PacketView::desc`]).
///
/// Bytes after the last field are passed over; [`Packet`] keeps them.
///
/// # Errors
/// When its fields do not fit its payload.
#[inline]
pub fn decode<T: Payload>(view: &PacketView<'_>) -> Result<Option<T>, DecodeError> {
    if view.id() != T::ID || view.desc().is_none() {
        return Ok(None);
    }
    match T::read(&mut Reader::new(view.payload(), view.order(), false)) {
        Ok(message) => Ok(Some(message)),
        Err(_) => Err(located(view.id(), view.payload(), view.order())),
    }
}

/// Appends the same packet under another header, as a relay does that readdresses packets. Neither its payload
/// nor its byte order changes.
///
/// # Panics
/// Never: a payload that came in a packet fits one.
pub fn readdress_into(out: &mut Vec<u8>, view: &PacketView<'_>, header: &Header) {
    let start = out.len();
    frame(out, start, view.id(), "packet", header, view.order(), |out| {
        out.extend_from_slice(view.payload());
        Ok(())
    })
    .expect("invariant: a payload that came in a packet fits one");
}

/// The payload of a message alone, without header and checksum, as plan digests need it.
///
/// # Errors
/// When a value, list or the whole is too long for its 16-bit length.
pub fn encode_payload<T: Payload>(message: &T, order: ByteOrder) -> Result<Vec<u8>, EncodeError> {
    let mut out = Vec::new();
    let mut writer = Writer::new(&mut out, order);
    message.write(&mut writer);
    match writer.fault() {
        Some(fault) => Err(unwritable(T::DESC.abbrev, fault)),
        None if out.len() > MAX_PAYLOAD_BYTES => {
            Err(EncodeError::Payload { message: T::DESC.abbrev, bytes: out.len() })
        }
        None => Ok(out),
    }
}

/// Appends header, payload and checksum.
fn frame(
    out: &mut Vec<u8>,
    start: usize,
    id: u16,
    name: &'static str,
    header: &Header,
    order: ByteOrder,
    payload: impl FnOnce(&mut Vec<u8>) -> Result<(), Unwritable>,
) -> Result<(), EncodeError> {
    out.extend_from_slice(&header_bytes(id, header, order));
    if let Err(fault) = payload(out) {
        out.truncate(start);
        return Err(unwritable(name, fault));
    }
    let bytes = out.len() - start - HEADER_BYTES;
    let Ok(size) = u16::try_from(bytes) else {
        out.truncate(start);
        return Err(EncodeError::Payload { message: name, bytes });
    };
    out[start + 4..start + 6].copy_from_slice(&ordered(size, order));
    let crc = crc::crc16(&out[start..]);
    out.extend_from_slice(&ordered(crc, order));
    debug_assert_eq!(out.len() - start, HEADER_BYTES + bytes + FOOTER_BYTES);
    Ok(())
}

/// A header whose payload size is still 0.
fn header_bytes(id: u16, header: &Header, order: ByteOrder) -> [u8; HEADER_BYTES] {
    let mut bytes = [0; HEADER_BYTES];
    bytes[0..2].copy_from_slice(&ordered(SYNC, order));
    bytes[2..4].copy_from_slice(&ordered(id, order));
    bytes[6..14].copy_from_slice(&match order {
        ByteOrder::Little => header.timestamp.to_le_bytes(),
        ByteOrder::Big => header.timestamp.to_be_bytes(),
    });
    bytes[14..16].copy_from_slice(&ordered(header.src.0, order));
    bytes[16] = header.src_ent;
    bytes[17..19].copy_from_slice(&ordered(header.dst.0, order));
    bytes[19] = header.dst_ent;
    bytes
}

fn ordered(number: u16, order: ByteOrder) -> [u8; 2] {
    match order {
        ByteOrder::Little => number.to_le_bytes(),
        ByteOrder::Big => number.to_be_bytes(),
    }
}

fn unwritable(message: &'static str, fault: Unwritable) -> EncodeError {
    match fault {
        Unwritable::Bytes(bytes) => EncodeError::Value { message, bytes },
        Unwritable::List(count) => EncodeError::List { message, count },
        Unwritable::Depth => EncodeError::Depth { message },
    }
}

/// How many fields a short payload holds; an error when it ends inside a field.
fn boundary(desc: &'static MessageDesc, payload: &[u8], order: ByteOrder) -> Result<usize, DecodeError> {
    reflect::fields_present(desc, payload, order).map_err(|error| DecodeError::Payload {
        message: desc.abbrev,
        id: desc.id,
        error,
    })
}

/// The error of a payload that could not be read, found again with the name of its field.
#[cold]
fn located(id: u16, payload: &[u8], order: ByteOrder) -> DecodeError {
    let desc = catalogue::by_id(id).expect("invariant: only messages of the catalogue are read");
    let error = reflect::check_payload(desc, payload, order)
        .expect_err("invariant: the generated readers and the walker refuse the same payloads");
    DecodeError::Payload { message: desc.abbrev, id, error }
}
