//! Packets to JSON.

use super::{MAX_EXACT, QUIET_NAN_F32, QUIET_NAN_F64};
use crate::catalogue::{FieldDesc, MessageDesc};
use crate::header::{Header, PacketView};
use crate::messages::Message;
use crate::packet::{EncodeError, Packet, ShortPayload};
use crate::reflect::{self, Value, Visitor, WalkError};
use crate::text::{escaped_parts, plain};
use crate::wire::ByteOrder;
use std::io::Write as _;

/// Why a packet has no JSON.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum WriteError {
    /// The catalogue has no message with its id.
    #[error("unknown message id {0}")]
    UnknownId(u16),
    /// Its fields do not fit its payload.
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

impl WriteError {
    /// A stable word for machines.
    pub fn class(&self) -> &'static str {
        match self {
            Self::UnknownId(_) => "unknown_id",
            Self::Payload { error, .. } => error.class(),
        }
    }
}

/// Appends the packet as one JSON object; on failure `out` is as before.
///
/// # Errors
/// When the catalogue lacks its id or its fields do not fit its payload.
pub fn write_packet(out: &mut Vec<u8>, view: &PacketView<'_>, short: ShortPayload) -> Result<(), WriteError> {
    let desc = view.desc().ok_or(WriteError::UnknownId(view.id()))?;
    let start = out.len();
    write!(out, r#"{{"abbrev":"{}","id":{},"header":"#, desc.abbrev, desc.id).ok();
    write_header(out, &view.header());
    if view.order() == ByteOrder::Big {
        out.extend_from_slice(br#","endian":"big""#);
    }
    out.extend_from_slice(br#","fields":{"#);
    let mut fields = Fields { out, open: vec![Open { list: false, first: true }] };
    let lenient = short == ShortPayload::AnyBoundary;
    let walked = match reflect::walk_payload(desc, view.payload(), view.order(), lenient, &mut fields) {
        Ok(walked) => walked,
        Err(error) => {
            out.truncate(start);
            return Err(WriteError::Payload { message: desc.abbrev, id: desc.id, error });
        }
    };
    out.push(b'}');
    for (at, field) in desc.fields[walked.fields..].iter().enumerate() {
        out.extend_from_slice(if at == 0 { br#","absent":["# } else { b"," });
        write!(out, "\"{}\"", field.abbrev).ok();
    }
    if walked.fields < desc.fields.len() {
        out.push(b']');
    }
    let trailing = &view.payload()[walked.bytes..];
    if !trailing.is_empty() {
        out.extend_from_slice(br#","trailing":"#);
        quoted_hex(out, trailing);
    }
    out.push(b'}');
    Ok(())
}

/// A message without a header: `{"abbrev":…,"fields":…}`.
///
/// # Errors
/// When the message does not fit a packet.
///
/// # Panics
/// Never: the walk reads what the structs write.
pub fn message_to_string(message: &Message) -> Result<String, EncodeError> {
    let packet = Packet::new(Header::default(), message.clone());
    let bytes = packet.encode()?;
    let view = PacketView::checked_before(&bytes, packet.order);
    let desc = message.desc();
    let mut out = format!(r#"{{"abbrev":"{}","fields":{{"#, desc.abbrev).into_bytes();
    let mut fields = Fields { out: &mut out, open: vec![Open { list: false, first: true }] };
    reflect::walk_payload(desc, view.payload(), view.order(), false, &mut fields)
        .expect("invariant: the walk reads what the structs write");
    out.extend_from_slice(b"}}");
    Ok(String::from_utf8_lossy(&out).into_owned())
}

/// Appends a header as a JSON object.
pub fn write_header(out: &mut Vec<u8>, header: &Header) {
    out.extend_from_slice(br#"{"timestamp":"#);
    double(out, header.timestamp);
    write!(
        out,
        r#","src":{},"src_ent":{},"dst":{},"dst_ent":{}}}"#,
        header.src.0, header.src_ent, header.dst.0, header.dst_ent
    )
    .ok();
}

/// Appends text as a JSON string, [escaped](crate::text::escape) where it is not text.
pub fn write_text(out: &mut Vec<u8>, text: &[u8]) {
    // Writing to a vector cannot fail, and every string has a JSON form.
    if let Some(text) = plain(text) {
        serde_json::to_writer(out, text).unwrap_or_default();
        return;
    }
    out.push(b'"');
    escaped_parts(text, |part| {
        let start = out.len();
        serde_json::to_writer(&mut *out, part).unwrap_or_default();
        // Without the quotes around it.
        out.pop();
        out.remove(start);
    });
    out.push(b'"');
}

/// Appends lower-case hexadecimal as a JSON string.
pub(super) fn quoted_hex(out: &mut Vec<u8>, bytes: &[u8]) {
    out.reserve(2 * bytes.len() + 2);
    out.push(b'"');
    let start = out.len();
    out.resize(start + 2 * bytes.len(), 0);
    // There is room for two digits of each byte.
    hex::encode_to_slice(bytes, &mut out[start..]).unwrap_or_default();
    out.push(b'"');
}

pub(super) fn double(out: &mut Vec<u8>, value: f64) {
    if value.is_finite() {
        serde_json::to_writer(out, &value).unwrap_or_default();
    } else if value.is_infinite() {
        out.extend_from_slice(if value > 0.0 { b"\"Infinity\"" } else { b"\"-Infinity\"" });
    } else if value.to_bits() == QUIET_NAN_F64 {
        out.extend_from_slice(b"\"NaN\"");
    } else {
        write!(out, "\"NaN:{:016x}\"", value.to_bits()).ok();
    }
}

pub(super) fn single(out: &mut Vec<u8>, value: f32) {
    if value.is_nan() && value.to_bits() != QUIET_NAN_F32 {
        write!(out, "\"NaN:{:08x}\"", value.to_bits()).ok();
    } else if value.is_nan() {
        out.extend_from_slice(b"\"NaN\"");
    } else {
        double(out, value.into());
    }
}

pub(super) fn integer(out: &mut Vec<u8>, value: i64) {
    if value.unsigned_abs() > MAX_EXACT {
        write!(out, "\"{value}\"").ok();
    } else {
        write!(out, "{value}").ok();
    }
}

/// The inside of `"fields":{…}`.
struct Fields<'o> {
    out: &'o mut Vec<u8>,
    open: Vec<Open>,
}

#[derive(Clone, Copy)]
struct Open {
    list: bool,
    first: bool,
}

impl Fields<'_> {
    /// The comma before, and the name of, the next item in the innermost object or list.
    fn next(&mut self, field: &FieldDesc) {
        if let Some(open) = self.open.last_mut() {
            if !open.first {
                self.out.push(b',');
            }
            open.first = false;
            if !open.list {
                write!(self.out, "\"{}\":", field.abbrev).ok();
            }
        }
    }
}

impl<'a> Visitor<'a> for Fields<'_> {
    fn value(&mut self, field: &'static FieldDesc, value: Value<'a>) {
        self.next(field);
        match value {
            Value::Integer(value) => integer(self.out, value),
            Value::Single(value) => single(self.out, value),
            Value::Double(value) => double(self.out, value),
            Value::Text(text) => write_text(self.out, text),
            Value::Raw(bytes) => quoted_hex(self.out, bytes),
        }
    }

    fn null(&mut self, field: &'static FieldDesc) {
        self.next(field);
        self.out.extend_from_slice(b"null");
    }

    fn enter_message(&mut self, field: &'static FieldDesc, message: &'static MessageDesc) {
        self.next(field);
        write!(self.out, r#"{{"abbrev":"{}","fields":{{"#, message.abbrev).ok();
        self.open.push(Open { list: false, first: true });
    }

    fn leave_message(&mut self) {
        self.out.extend_from_slice(b"}}");
        self.open.pop();
    }

    fn enter_list(&mut self, field: &'static FieldDesc, _: usize) {
        self.next(field);
        self.out.push(b'[');
        self.open.push(Open { list: true, first: true });
    }

    fn leave_list(&mut self) {
        self.out.push(b']');
        self.open.pop();
    }
}
