//! Any message's fields without code for that message: a walk over the payload by the catalogue.
//!
//! Storage, tables, exports and JSON work from this. The walk allocates nothing, so a visitor that does not
//! either can look at any packet in constant memory.

use crate::catalogue::{self, FieldDesc, FieldKind, MessageDesc};
use crate::header::{HEADER_BYTES, PacketView};
use crate::wire::{ByteOrder, MAX_DEPTH, NULL_ID};
use std::fmt::Write as _;

/// The value of a field that is not a message.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Value<'a> {
    /// Any integer type.
    Integer(i64),
    /// A single; kept apart from doubles so that it prints as short as it is.
    Single(f32),
    /// A double.
    Double(f64),
    /// Text, nearly always UTF-8.
    Text(&'a [u8]),
    /// Bytes.
    Raw(&'a [u8]),
}

impl Value<'_> {
    /// The value as a number, when it is one.
    pub fn as_f64(&self) -> Option<f64> {
        match *self {
            Self::Integer(value) => Some(value as f64),
            Self::Single(value) => Some(value.into()),
            Self::Double(value) => Some(value),
            Self::Text(_) | Self::Raw(_) => None,
        }
    }
}

/// Why a payload cannot be walked to its end.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
#[error("{path} at byte {offset} of the packet: {cause}")]
pub struct WalkError {
    /// The field, such as `maneuvers[2].data.lat`.
    pub path: String,
    /// The field's first byte, counted from the start of the packet.
    pub offset: usize,
    /// What is wrong there.
    pub cause: WalkCause,
}

/// What is wrong with a field.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum WalkCause {
    /// It reaches past the end of the payload.
    #[error("the field reaches past the end of the payload")]
    Overrun,
    /// It holds a message whose id is not in the catalogue, so that the rest cannot be read.
    #[error("the nested message has the unknown id {0}")]
    UnknownNested(u16),
    /// It holds messages nested too deep.
    #[error("messages are nested more than {MAX_DEPTH} deep")]
    TooDeep,
}

impl WalkError {
    /// A stable word for machines.
    pub fn class(&self) -> &'static str {
        match self.cause {
            WalkCause::Overrun => "field_overrun",
            WalkCause::UnknownNested(_) => "nested_unknown_id",
            WalkCause::TooDeep => "nested_too_deep",
        }
    }

    #[cold]
    fn new(field: &FieldDesc, offset: usize, cause: WalkCause) -> Self {
        Self { path: field.abbrev.to_owned(), offset: HEADER_BYTES + offset, cause }
    }

    /// The same error seen from the message or list around it.
    #[cold]
    fn within(mut self, field: &FieldDesc, index: Option<usize>) -> Self {
        let mut path = field.abbrev.to_owned();
        if let Some(index) = index {
            write!(path, "[{index}]").ok();
        }
        if !self.path.is_empty() {
            path.push('.');
            path.push_str(&self.path);
        }
        self.path = path;
        self
    }
}

/// The visitor of a walk, in wire order. Everything between `enter_message` and `leave_message` belongs to the
/// nested message; elements of a list come between `enter_list` and `leave_list`.
pub trait Visitor<'a> {
    /// A field that is not a message.
    fn value(&mut self, field: &'static FieldDesc, value: Value<'a>);
    /// A nested position without a message.
    fn null(&mut self, field: &'static FieldDesc);
    /// A nested message begins.
    fn enter_message(&mut self, field: &'static FieldDesc, message: &'static MessageDesc);
    /// The nested message ends.
    fn leave_message(&mut self);
    /// A list begins.
    fn enter_list(&mut self, field: &'static FieldDesc, count: usize);
    /// The list ends.
    fn leave_list(&mut self);
}

/// The result of a walk over the outer message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Walked {
    /// Bytes of all fields; the rest of the payload is trailing.
    pub bytes: usize,
    /// Fields that were there.
    pub fields: usize,
}

/// Walks over the fields of a packet. `None` when the catalogue lacks its message.
///
/// # Errors
/// When the fields do not fit the payload. What was visited before stays visited.
pub fn walk<'a>(view: &PacketView<'a>, visitor: &mut impl Visitor<'a>) -> Option<Result<Walked, WalkError>> {
    let desc = view.desc()?;
    Some(walk_payload(desc, view.payload(), view.order(), false, visitor))
}

/// Walks over the fields of a payload; `lenient` lets it end before any field of the outer message.
///
/// # Errors
/// When the fields do not fit the payload.
pub fn walk_payload<'a>(
    desc: &'static MessageDesc,
    payload: &'a [u8],
    order: ByteOrder,
    lenient: bool,
    visitor: &mut impl Visitor<'a>,
) -> Result<Walked, WalkError> {
    let mut walker = Walker { bytes: payload, at: 0, order };
    for (fields, field) in desc.fields.iter().enumerate() {
        if walker.at == payload.len() && (lenient || field.appended) {
            return Ok(Walked { bytes: walker.at, fields });
        }
        walker.field(field, 0, visitor)?;
    }
    Ok(Walked { bytes: walker.at, fields: desc.fields.len() })
}

/// Checks that the fields of a packet fit its payload. `None` when the catalogue lacks its message.
///
/// # Errors
/// When they do not.
pub fn check(view: &PacketView<'_>) -> Option<Result<Walked, WalkError>> {
    walk(view, &mut Ignore)
}

/// Checks that the fields fit the payload.
pub(crate) fn check_payload(
    desc: &'static MessageDesc,
    payload: &[u8],
    order: ByteOrder,
) -> Result<Walked, WalkError> {
    walk_payload(desc, payload, order, false, &mut Ignore)
}

/// How many fields of the outer message the payload holds.
pub(crate) fn fields_present(
    desc: &'static MessageDesc,
    payload: &[u8],
    order: ByteOrder,
) -> Result<usize, WalkError> {
    walk_payload(desc, payload, order, true, &mut Ignore).map(|walked| walked.fields)
}

/// Bytes of the first `count` fields of a well-formed payload.
pub(crate) fn field_offset(
    desc: &'static MessageDesc,
    payload: &[u8],
    order: ByteOrder,
    count: usize,
) -> usize {
    let mut walker = Walker { bytes: payload, at: 0, order };
    for field in desc.fields.iter().take(count) {
        if walker.field(field, 0, &mut Ignore).is_err() {
            break;
        }
    }
    walker.at
}

struct Ignore;

impl Visitor<'_> for Ignore {
    fn value(&mut self, _: &'static FieldDesc, _: Value<'_>) {}
    fn null(&mut self, _: &'static FieldDesc) {}
    fn enter_message(&mut self, _: &'static FieldDesc, _: &'static MessageDesc) {}
    fn leave_message(&mut self) {}
    fn enter_list(&mut self, _: &'static FieldDesc, _: usize) {}
    fn leave_list(&mut self) {}
}

struct Walker<'a> {
    bytes: &'a [u8],
    at: usize,
    order: ByteOrder,
}

macro_rules! number {
    ($walker:expr, $type:ident) => {{
        let bytes = $walker.bytes[$walker.at..].first_chunk()?;
        $walker.at += bytes.len();
        match $walker.order {
            ByteOrder::Little => $type::from_le_bytes(*bytes),
            ByteOrder::Big => $type::from_be_bytes(*bytes),
        }
    }};
}

impl<'a> Walker<'a> {
    fn field(
        &mut self,
        field: &'static FieldDesc,
        depth: u8,
        visitor: &mut impl Visitor<'a>,
    ) -> Result<(), WalkError> {
        match field.kind {
            FieldKind::Message => self.message(field, None, depth, visitor),
            FieldKind::List => self.list(field, depth, visitor),
            _ => {
                let start = self.at;
                let value =
                    self.value(field.kind).ok_or_else(|| WalkError::new(field, start, WalkCause::Overrun))?;
                visitor.value(field, value);
                Ok(())
            }
        }
    }

    /// A value that is not a message; `None` when bytes are missing.
    fn value(&mut self, kind: FieldKind) -> Option<Value<'a>> {
        Some(match kind {
            FieldKind::I8 => Value::Integer(number!(self, i8).into()),
            FieldKind::U8 => Value::Integer(number!(self, u8).into()),
            FieldKind::I16 => Value::Integer(number!(self, i16).into()),
            FieldKind::U16 => Value::Integer(number!(self, u16).into()),
            FieldKind::I32 => Value::Integer(number!(self, i32).into()),
            FieldKind::U32 => Value::Integer(number!(self, u32).into()),
            FieldKind::I64 => Value::Integer(number!(self, i64)),
            FieldKind::F32 => Value::Single(number!(self, f32)),
            FieldKind::F64 => Value::Double(number!(self, f64)),
            FieldKind::Raw => Value::Raw(self.counted()?),
            FieldKind::Text => Value::Text(self.counted()?),
            FieldKind::Message | FieldKind::List => return None,
        })
    }

    fn counted(&mut self) -> Option<&'a [u8]> {
        let count = usize::from(number!(self, u16));
        let bytes = self.bytes.get(self.at..self.at + count)?;
        self.at += count;
        Some(bytes)
    }

    fn length(&mut self) -> Option<u16> {
        Some(number!(self, u16))
    }

    /// A nested message; `index` is its place when it is an element of a list.
    fn message(
        &mut self,
        field: &'static FieldDesc,
        index: Option<usize>,
        depth: u8,
        visitor: &mut impl Visitor<'a>,
    ) -> Result<(), WalkError> {
        let start = self.at;
        let fail = |cause| {
            let error = WalkError { path: String::new(), offset: HEADER_BYTES + start, cause };
            error.within(field, index)
        };
        let id = self.length().ok_or_else(|| fail(WalkCause::Overrun))?;
        if id == NULL_ID {
            visitor.null(field);
            return Ok(());
        }
        if depth == MAX_DEPTH {
            return Err(fail(WalkCause::TooDeep));
        }
        let desc = catalogue::by_id(id).ok_or_else(|| fail(WalkCause::UnknownNested(id)))?;
        visitor.enter_message(field, desc);
        for inner in desc.fields {
            self.field(inner, depth + 1, visitor).map_err(|error| error.within(field, index))?;
        }
        visitor.leave_message();
        Ok(())
    }

    fn list(
        &mut self,
        field: &'static FieldDesc,
        depth: u8,
        visitor: &mut impl Visitor<'a>,
    ) -> Result<(), WalkError> {
        let start = self.at;
        let count = self.length().map(usize::from).filter(|count| count * 2 <= self.bytes.len() - self.at);
        let count = count.ok_or_else(|| WalkError::new(field, start, WalkCause::Overrun))?;
        visitor.enter_list(field, count);
        for index in 0..count {
            self.message(field, Some(index), depth, visitor)?;
        }
        visitor.leave_list();
        Ok(())
    }
}

/// One value with its place in the message.
#[derive(Debug, Clone, PartialEq)]
pub struct Field<'a> {
    /// Place, such as `lat` or `maneuvers[2].data.lat`.
    pub path: String,
    /// Its catalogue entry: unit, labels, range.
    pub desc: &'static FieldDesc,
    /// The value.
    pub value: Value<'a>,
}

impl Field<'_> {
    /// The name of the value, when its numbers have names.
    pub fn label(&self) -> Option<String> {
        match self.value {
            Value::Integer(value) => self.desc.label(value),
            Value::Single(_) | Value::Double(_) | Value::Text(_) | Value::Raw(_) => None,
        }
    }
}

/// All values of a packet, nested ones by path. `None` when the catalogue lacks its message.
///
/// # Errors
/// When the fields do not fit the payload.
pub fn fields<'a>(view: &PacketView<'a>) -> Option<Result<Vec<Field<'a>>, WalkError>> {
    let mut flatten = Flatten { fields: Vec::new(), path: String::new(), open: Vec::new() };
    Some(walk(view, &mut flatten)?.map(|_| flatten.fields))
}

struct Flatten<'a> {
    fields: Vec<Field<'a>>,
    path: String,
    /// Around the present place: how long the path was before, and for a list the next index.
    open: Vec<(usize, Option<usize>)>,
}

impl Flatten<'_> {
    /// Appends the path of a nested message: the list's next index, or the field.
    fn push(&mut self, field: &FieldDesc) {
        if let Some((_, Some(index))) = self.open.last_mut() {
            write!(self.path, "[{index}]").ok();
            *index += 1;
        } else {
            self.push_field(field);
        }
    }

    fn push_field(&mut self, field: &FieldDesc) {
        if !self.path.is_empty() {
            self.path.push('.');
        }
        self.path.push_str(field.abbrev);
    }

    fn leave(&mut self) {
        if let Some((length, _)) = self.open.pop() {
            self.path.truncate(length);
        }
    }
}

impl<'a> Visitor<'a> for Flatten<'a> {
    fn value(&mut self, desc: &'static FieldDesc, value: Value<'a>) {
        let length = self.path.len();
        self.push_field(desc);
        self.fields.push(Field { path: self.path.clone(), desc, value });
        self.path.truncate(length);
    }

    fn null(&mut self, _: &'static FieldDesc) {
        if let Some((_, Some(index))) = self.open.last_mut() {
            *index += 1;
        }
    }

    fn enter_message(&mut self, field: &'static FieldDesc, _: &'static MessageDesc) {
        let length = self.path.len();
        self.push(field);
        self.open.push((length, None));
    }

    fn leave_message(&mut self) {
        self.leave();
    }

    fn enter_list(&mut self, field: &'static FieldDesc, _: usize) {
        let length = self.path.len();
        self.push_field(field);
        self.open.push((length, Some(0)));
    }

    fn leave_list(&mut self) {
        self.leave();
    }
}
