//! JSON to packets.

use super::QUIET_NAN_F32;
use crate::address::Address;
use crate::catalogue::{self, FieldDesc, FieldKind, Meaning, MessageDesc};
use crate::header::{Header, MAX_PAYLOAD_BYTES, PacketView};
use crate::messages::Message;
use crate::packet::{Body, EncodeError, Packet, ShortPayload};
use crate::text::unescape;
use crate::wire::{ByteOrder, MAX_DEPTH, NULL_ID, Reader};
use serde_json::{Map, Value};

/// Defaults where the JSON has no value.
#[derive(Debug, Clone, Copy, Default)]
pub struct ReadDefaults {
    /// Parts of the header that are missing.
    pub header: Header,
    /// The byte order, whatever the JSON says; `None` to follow its `endian`, little when missing.
    pub order: Option<ByteOrder>,
}

/// Why JSON is not a packet.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum ReadError {
    /// A part of it is wrong.
    #[error("{path}: {problem}")]
    Part {
        /// The part, such as `fields.maneuvers[2].data.fields.lat`.
        path: String,
        /// What is wrong with it, and what would be right.
        problem: String,
    },
    /// The packet would be too long.
    #[error(transparent)]
    Encode(#[from] EncodeError),
}

fn wrong(path: &str, problem: impl Into<String>) -> ReadError {
    ReadError::Part { path: path.to_owned(), problem: problem.into() }
}

/// The packet that a JSON object describes.
///
/// Of a key that is given twice the last value counts, as JSON readers have it.
///
/// # Errors
/// When a part is missing, unknown, of the wrong type or out of range.
pub fn read_packet(value: &Value, defaults: &ReadDefaults) -> Result<Packet, ReadError> {
    let object = value.as_object().ok_or_else(|| wrong("packet", "expected a JSON object"))?;
    known_keys(object, &["abbrev", "id", "header", "fields", "endian", "trailing", "absent"], "packet")?;
    let desc = message_desc(object)?;
    let order = match (defaults.order, object.get("endian").map(Value::as_str)) {
        (Some(order), _) => order,
        (None, None | Some(Some("little"))) => ByteOrder::Little,
        (None, Some(Some("big"))) => ByteOrder::Big,
        (None, Some(_)) => return Err(wrong("endian", "expected \"little\" or \"big\"")),
    };
    let header = read_header(object.get("header"), &defaults.header)?;
    let absent = absent_fields(desc, object.get("absent"))?;
    let mut payload = Payload::new(order);
    let empty = Map::new();
    let fields = match object.get("fields") {
        None => &empty,
        Some(Value::Object(fields)) => fields,
        Some(_) => return Err(wrong("fields", "expected a JSON object")),
    };
    payload.fields(desc, fields, "fields", 0, absent)?;
    let trailing = match object.get("trailing") {
        None => Vec::new(),
        Some(text) => bytes(text, "trailing")?,
    };
    let body = Body::Unknown { id: desc.id, payload: payload.whole(desc, trailing.len())? };
    let raw = Packet { header, body, order, trailing, fields_sent: None }.encode()?;
    Packet::from_view(&PacketView::checked_before(&raw, order), ShortPayload::AnyBoundary)
        .map_err(|error| wrong("fields", error.to_string()))
}

/// The message that `{"abbrev":…,"fields":…}` describes.
///
/// # Errors
/// When a part is missing, unknown, of the wrong type or out of range.
pub fn message_from_value(value: &Value) -> Result<Message, ReadError> {
    let object = value.as_object().ok_or_else(|| wrong("message", "expected a JSON object"))?;
    known_keys(object, &["abbrev", "id", "fields"], "message")?;
    let desc = message_desc(object)?;
    let mut payload = Payload::new(ByteOrder::Little);
    let empty = Map::new();
    let fields = match object.get("fields") {
        None => &empty,
        Some(Value::Object(fields)) => fields,
        Some(_) => return Err(wrong("fields", "expected a JSON object")),
    };
    payload.fields(desc, fields, "fields", 0, desc.fields.len())?;
    let payload = payload.whole(desc, 0)?;
    match Message::read(desc.id, &mut Reader::new(&payload, ByteOrder::Little, false)) {
        Some(Ok(message)) => Ok(message),
        // Only nesting can go wrong here: everything else was checked while the payload was made.
        _ => Err(wrong("message", format!("messages are nested more than {MAX_DEPTH} deep"))),
    }
}

fn message_desc(object: &Map<String, Value>) -> Result<&'static MessageDesc, ReadError> {
    let by_id = |value: &Value| {
        let id = value.as_u64().and_then(|id| u16::try_from(id).ok());
        id.and_then(catalogue::by_id).ok_or_else(|| wrong("id", format!("no message has the id {value}")))
    };
    match (object.get("abbrev"), object.get("id")) {
        (Some(Value::String(abbrev)), id) => {
            let desc = catalogue::by_abbrev(abbrev)
                .ok_or_else(|| wrong("abbrev", format!("no message is called `{abbrev}`")))?;
            match id.map(by_id).transpose()? {
                Some(other) if other.id != desc.id => {
                    Err(wrong("id", format!("{abbrev} has the id {}, not {}", desc.id, other.id)))
                }
                _ => Ok(desc),
            }
        }
        (Some(_), _) => Err(wrong("abbrev", "expected a text")),
        (None, Some(id)) => by_id(id),
        (None, None) => Err(wrong("abbrev", "missing: which message is it?")),
    }
}

/// How many fields to write: all but those named as absent, which must be the last ones.
fn absent_fields(desc: &'static MessageDesc, absent: Option<&Value>) -> Result<usize, ReadError> {
    let Some(absent) = absent else { return Ok(desc.fields.len()) };
    let names = absent.as_array().ok_or_else(|| wrong("absent", "expected a list of field names"))?;
    let present = desc.fields.len().saturating_sub(names.len());
    let last = desc.fields[present..].iter().map(|field| Some(field.abbrev));
    if last.eq(names.iter().map(Value::as_str)) {
        Ok(present)
    } else {
        Err(wrong("absent", format!("only the last fields of {} can be absent, in their order", desc.abbrev)))
    }
}

fn read_header(value: Option<&Value>, defaults: &Header) -> Result<Header, ReadError> {
    let mut header = *defaults;
    let object = match value {
        None => return Ok(header),
        Some(Value::Object(object)) => object,
        Some(_) => return Err(wrong("header", "expected a JSON object")),
    };
    known_keys(object, &["timestamp", "src", "src_ent", "dst", "dst_ent"], "header")?;
    if let Some(value) = object.get("timestamp") {
        header.timestamp = double(value).ok_or_else(|| wrong("header.timestamp", "expected seconds"))?;
    }
    for (name, slot) in [("src", &mut header.src), ("dst", &mut header.dst)] {
        if let Some(value) = object.get(name) {
            let path = format!("header.{name}");
            *slot = address(value).ok_or_else(|| {
                wrong(&path, format!("{value} is neither a registered system nor a number from 0 to 65535"))
            })?;
        }
    }
    for (name, slot) in [("src_ent", &mut header.src_ent), ("dst_ent", &mut header.dst_ent)] {
        if let Some(value) = object.get(name) {
            let number = value.as_u64().and_then(|number| u8::try_from(number).ok());
            *slot =
                number.ok_or_else(|| wrong(&format!("header.{name}"), "expected a number from 0 to 255"))?;
        }
    }
    Ok(header)
}

fn address(value: &Value) -> Option<Address> {
    match value {
        Value::String(text) => text.parse().ok(),
        _ => u16::try_from(value.as_u64()?).ok().map(Address),
    }
}

fn known_keys(object: &Map<String, Value>, known: &[&str], path: &str) -> Result<(), ReadError> {
    match object.keys().find(|key| !known.contains(&key.as_str())) {
        None => Ok(()),
        Some(key) => Err(wrong(path, format!("unknown key `{key}`; known are {}", known.join(", ")))),
    }
}

/// A real, or one of the texts for what JSON has no number for.
fn double(value: &Value) -> Option<f64> {
    match value {
        Value::Number(number) => number.as_f64(),
        Value::String(text) => match text.as_str() {
            "NaN" => Some(f64::NAN),
            "Infinity" => Some(f64::INFINITY),
            "-Infinity" => Some(f64::NEG_INFINITY),
            _ => nan_bits(text, 16).map(f64::from_bits).filter(|value| value.is_nan()),
        },
        _ => None,
    }
}

fn single(value: &Value) -> Option<f32> {
    if let Value::String(text) = value
        && let Some(bits) = nan_bits(text, 8)
    {
        return Some(f32::from_bits(u32::try_from(bits).ok()?)).filter(|value| value.is_nan());
    }
    let double = double(value)?;
    if double.is_nan() {
        return Some(f32::from_bits(QUIET_NAN_F32));
    }
    let single = double as f32;
    (single.is_infinite() == double.is_infinite()).then_some(single)
}

fn nan_bits(text: &str, digits: usize) -> Option<u64> {
    let bits = text.strip_prefix("NaN:").filter(|bits| bits.len() == digits)?;
    u64::from_str_radix(bits, 16).ok()
}

fn bytes(value: &Value, path: &str) -> Result<Vec<u8>, ReadError> {
    value
        .as_str()
        .and_then(|text| hex::decode(text).ok())
        .ok_or_else(|| wrong(path, "expected bytes as pairs of hexadecimal digits"))
}

/// A payload being written. What goes beyond the longest payload is counted and not kept, because a few bytes of
/// JSON can ask for a hundred of defaults.
struct Payload {
    out: Vec<u8>,
    bytes: usize,
    order: ByteOrder,
}

impl Payload {
    fn new(order: ByteOrder) -> Self {
        Self { out: Vec::new(), bytes: 0, order }
    }

    /// All of it, when there is room for it and what trails.
    fn whole(self, desc: &MessageDesc, trailing: usize) -> Result<Vec<u8>, EncodeError> {
        let bytes = self.bytes + trailing;
        if bytes > MAX_PAYLOAD_BYTES {
            return Err(EncodeError::Payload { message: desc.abbrev, bytes });
        }
        Ok(self.out)
    }

    fn put(&mut self, bytes: &[u8]) {
        self.bytes += bytes.len();
        if self.bytes <= MAX_PAYLOAD_BYTES {
            self.out.extend_from_slice(bytes);
        }
    }

    /// The first `count` fields of a message.
    fn fields(
        &mut self,
        desc: &'static MessageDesc,
        fields: &Map<String, Value>,
        path: &str,
        depth: u8,
        count: usize,
    ) -> Result<(), ReadError> {
        for key in fields.keys() {
            match desc.fields.iter().position(|field| field.abbrev == key) {
                Some(at) if at < count => {}
                Some(_) => return Err(wrong(&format!("{path}.{key}"), "given, but named as absent too")),
                None => {
                    let known: Vec<&str> = desc.fields.iter().map(|field| field.abbrev).collect();
                    let problem =
                        format!("{} has no field `{key}`; it has {}", desc.abbrev, known.join(", "));
                    return Err(wrong(path, problem));
                }
            }
        }
        for (at, field) in desc.fields[..count].iter().enumerate() {
            let value = fields.get(field.abbrev);
            // A sender of the older layout ends the message before the fields that were appended since.
            let later = &desc.fields[at..];
            if depth == 0 && field.appended && later.iter().all(|field| !fields.contains_key(field.abbrev)) {
                break;
            }
            self.field(field, value, path, depth)?;
        }
        Ok(())
    }

    fn field(
        &mut self,
        field: &'static FieldDesc,
        value: Option<&Value>,
        path: &str,
        depth: u8,
    ) -> Result<(), ReadError> {
        let place = || format!("{path}.{}", field.abbrev);
        match (field.kind, value) {
            (FieldKind::Raw | FieldKind::Text | FieldKind::List, None) => self.number(0, 2),
            (FieldKind::Message, None | Some(Value::Null)) => self.number(NULL_ID.into(), 2),
            (_, None) => {
                let default = if field.appended { f64::NAN } else { field.default.unwrap_or(0.0) };
                self.real_or_integer(field.kind, default);
            }
            (FieldKind::Raw, Some(value)) => {
                let bytes = bytes(value, &place())?;
                self.counted(&bytes, &place)?;
            }
            (FieldKind::Text, Some(value)) => {
                let text = match value {
                    Value::String(text) => unescape(text).into_owned(),
                    // As earlier versions wrote bytes that are not UTF-8.
                    Value::Object(object) if object.len() == 1 && object.contains_key("bytes") => {
                        bytes(&object["bytes"], &place())?
                    }
                    _ => return Err(wrong(&place(), "expected a text")),
                };
                self.counted(&text, &place)?;
            }
            (FieldKind::Message, Some(value)) => self.message(value, &place(), depth)?,
            (FieldKind::List, Some(value)) => self.list(value, &place(), depth)?,
            (FieldKind::F32, Some(value)) => {
                let single = single(value).ok_or_else(|| {
                    wrong(&place(), format!("{value} is not a number that fits fp32_t (or NaN, Infinity)"))
                })?;
                self.number(single.to_bits().into(), 4);
            }
            (FieldKind::F64, Some(value)) => {
                let double = double(value)
                    .ok_or_else(|| wrong(&place(), format!("{value} is not a number (or NaN, Infinity)")))?;
                self.number(double.to_bits(), 8);
            }
            (kind, Some(value)) => {
                let integer = integer(field, value).ok_or_else(|| wrong(&place(), expected(field, value)))?;
                self.number(integer as u64, kind.width().unwrap_or(8));
            }
        }
        Ok(())
    }

    /// The low `width` bytes of a number in the payload's byte order.
    fn number(&mut self, bits: u64, width: usize) {
        match self.order {
            ByteOrder::Little => self.put(&bits.to_le_bytes()[..width]),
            ByteOrder::Big => self.put(&bits.to_be_bytes()[8 - width..]),
        }
    }

    /// A default, which the catalogue gives as a real for any number.
    fn real_or_integer(&mut self, kind: FieldKind, value: f64) {
        match kind {
            FieldKind::F32 => self.number((value as f32).to_bits().into(), 4),
            FieldKind::F64 => self.number(value.to_bits(), 8),
            _ => self.number(value as i64 as u64, kind.width().unwrap_or(8)),
        }
    }

    fn counted(&mut self, bytes: &[u8], place: &impl Fn() -> String) -> Result<(), ReadError> {
        if bytes.len() > usize::from(u16::MAX) {
            return Err(wrong(&place(), format!("{} bytes; a field holds at most 65535", bytes.len())));
        }
        self.number(bytes.len() as u64, 2);
        self.put(bytes);
        Ok(())
    }

    fn message(&mut self, value: &Value, path: &str, depth: u8) -> Result<(), ReadError> {
        if depth == MAX_DEPTH {
            return Err(wrong(path, format!("messages are nested more than {MAX_DEPTH} deep")));
        }
        let Some(object) = value.as_object() else {
            return Err(wrong(path, "expected null or {\"abbrev\":…,\"fields\":…}"));
        };
        known_keys(object, &["abbrev", "id", "fields"], path)?;
        let desc = message_desc(object).map_err(|error| match error {
            ReadError::Part { path: part, problem } => wrong(&format!("{path}.{part}"), problem),
            ReadError::Encode(_) => error,
        })?;
        self.number(desc.id.into(), 2);
        let path = format!("{path}.fields");
        match object.get("fields") {
            None => self.fields(desc, &Map::new(), &path, depth + 1, desc.fields.len()),
            Some(Value::Object(fields)) => self.fields(desc, fields, &path, depth + 1, desc.fields.len()),
            Some(_) => Err(wrong(&path, "expected a JSON object")),
        }
    }

    fn list(&mut self, value: &Value, path: &str, depth: u8) -> Result<(), ReadError> {
        let elements = value.as_array().ok_or_else(|| wrong(path, "expected a list of messages"))?;
        if elements.len() > usize::from(u16::MAX) {
            return Err(wrong(path, format!("{} messages; a list holds at most 65535", elements.len())));
        }
        self.number(elements.len() as u64, 2);
        for (index, element) in elements.iter().enumerate() {
            match element {
                Value::Null => self.number(NULL_ID.into(), 2),
                element => self.message(element, &format!("{path}[{index}]"), depth)?,
            }
        }
        Ok(())
    }
}

/// An integer by number, digits in text, or label.
fn integer(field: &FieldDesc, value: &Value) -> Option<i64> {
    let number = match value {
        Value::Number(number) => number.as_i64().or_else(|| {
            let real = number.as_f64()?;
            // Within ±2^53 the cast is exact.
            (real.fract() == 0.0 && real.abs() <= super::MAX_EXACT as f64).then_some(real as i64)
        })?,
        Value::String(text) => text.parse().ok().or_else(|| field.value_of_label(text))?,
        _ => return None,
    };
    let (least, greatest) = field.kind.integer_range()?;
    (least..=greatest).contains(&number).then_some(number)
}

fn expected(field: &FieldDesc, value: &Value) -> String {
    let (least, greatest) = field.kind.integer_range().unwrap_or_default();
    let text = format!("{value} is not an integer from {least} to {greatest}");
    let labels =
        |values: &[catalogue::Label]| values.iter().map(|label| label.abbrev).collect::<Vec<_>>().join(", ");
    match field.meaning {
        Meaning::Plain => text,
        Meaning::Enumeration(desc) => format!("{text} and none of {}", labels(desc.values)),
        Meaning::Bitfield(desc) => format!("{text} and no `|` of {}", labels(desc.values)),
    }
}
