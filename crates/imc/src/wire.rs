//! Field values to bytes and back, in either byte order.
//!
//! Generated message code reads and writes runs of fixed-size fields as one [`Fixed`] block, so that a run
//! costs one length check, and everything else field by field.

use crate::list::MessageList;
use crate::messages::Message;
use crate::nested::Nested;
use crate::packed::{self, Packed};
use crate::text::Text;

/// How deep messages may hold messages. The deepest use seen, a plan inside a database request inside a
/// command, is 5; the bound keeps hostile input from the stack.
pub const MAX_DEPTH: u8 = 16;

/// The id that stands for "no message" in a nested position.
pub(crate) const NULL_ID: u16 = 65535;

/// The order of the bytes of a number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]
pub enum ByteOrder {
    /// Least significant first: what DUNE, Neptus and Lutra send.
    #[default]
    Little,
    /// Most significant first: accepted from anyone.
    Big,
}

impl ByteOrder {
    #[inline]
    pub(crate) fn u16(self, bytes: [u8; 2]) -> u16 {
        match self {
            Self::Little => u16::from_le_bytes(bytes),
            Self::Big => u16::from_be_bytes(bytes),
        }
    }
}

/// Why a payload could not be read on. Where, by field, is found by [`crate::reflect`] when it matters.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Fault {
    /// A field reaches past the end of the payload.
    Overrun,
    /// A nested message has an id that is not in the catalogue; its length is unknown.
    UnknownNested(u16),
    /// Messages are nested deeper than [`MAX_DEPTH`].
    TooDeep,
}

/// A run of fixed-size fields.
#[derive(Debug)]
pub(crate) struct Fixed<const N: usize> {
    bytes: [u8; N],
    order: ByteOrder,
}

macro_rules! fixed_numbers {
    ($($type:ident: $width:literal),*) => {
        impl<const N: usize> Fixed<N> {
            $(
                #[inline]
                pub(crate) fn $type(&self, at: usize) -> $type {
                    let mut bytes = [0; $width];
                    bytes.copy_from_slice(&self.bytes[at..at + $width]);
                    match self.order {
                        ByteOrder::Little => $type::from_le_bytes(bytes),
                        ByteOrder::Big => $type::from_be_bytes(bytes),
                    }
                }
            )*
        }

        impl<const N: usize> PutFixed<N> {
            $(
                #[inline]
                pub(crate) fn $type(&mut self, at: usize, value: $type) {
                    let bytes = match self.order {
                        ByteOrder::Little => value.to_le_bytes(),
                        ByteOrder::Big => value.to_be_bytes(),
                    };
                    self.bytes[at..at + $width].copy_from_slice(&bytes);
                }
            )*
        }
    };
}

/// A run of fixed-size fields on its way out.
#[derive(Debug)]
pub(crate) struct PutFixed<const N: usize> {
    bytes: [u8; N],
    order: ByteOrder,
}

// No message has an int64_t; the generated code says so by not compiling when one comes.
fixed_numbers!(i8: 1, u8: 1, i16: 2, u16: 2, i32: 4, u32: 4, f32: 4, f64: 8);

/// Reads the fields of one payload.
#[derive(Debug)]
pub struct Reader<'a> {
    bytes: &'a [u8],
    at: usize,
    order: ByteOrder,
    /// Whether this is a message inside another: it has no end of its own.
    nested: bool,
    /// Whether an outer message may end before its last field.
    lenient: bool,
    /// Whether it did.
    short: bool,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(payload: &'a [u8], order: ByteOrder, lenient: bool) -> Self {
        Self { bytes: payload, at: 0, order, nested: false, lenient, short: false }
    }

    /// Of a message that was packed, with whatever follows it.
    pub(crate) fn nested(fields: &'a [u8]) -> Self {
        Self { nested: true, ..Self::new(fields, ByteOrder::Little, false) }
    }

    /// Bytes read so far.
    pub(crate) fn at(&self) -> usize {
        self.at
    }

    /// Whether the payload ended before the message's last field, leniently read.
    pub(crate) fn is_short(&self) -> bool {
        self.short
    }

    #[inline]
    pub(crate) fn fixed<const N: usize>(&mut self) -> Result<Fixed<N>, Fault> {
        if let Some(bytes) = self.bytes[self.at..].first_chunk::<N>() {
            self.at += N;
            return Ok(Fixed { bytes: *bytes, order: self.order });
        }
        self.short_fixed()
    }

    /// The rest of a short payload, filled up with zeros; an error where the payload must be whole.
    #[cold]
    fn short_fixed<const N: usize>(&mut self) -> Result<Fixed<N>, Fault> {
        if !self.lenient {
            return Err(Fault::Overrun);
        }
        self.short = true;
        let rest = &self.bytes[self.at..];
        let mut bytes = [0; N];
        bytes[..rest.len()].copy_from_slice(rest);
        self.at = self.bytes.len();
        Ok(Fixed { bytes, order: self.order })
    }

    #[inline]
    fn length(&mut self) -> Result<usize, Fault> {
        Ok(usize::from(self.fixed::<2>()?.u16(0)))
    }

    /// Whether nothing is left of an outer message: its appended fields are then absent.
    pub(crate) fn ended(&self) -> bool {
        !self.nested && self.at == self.bytes.len()
    }

    /// A length-prefixed run of bytes.
    #[inline]
    pub(crate) fn raw(&mut self) -> Result<Vec<u8>, Fault> {
        let count = self.length()?;
        let bytes = self.bytes.get(self.at..self.at + count).ok_or(Fault::Overrun)?;
        self.at += count;
        Ok(bytes.to_vec())
    }

    #[inline]
    pub(crate) fn text(&mut self) -> Result<Text, Fault> {
        self.raw().map(Text::from_bytes)
    }

    /// A nested message, which may be null.
    pub(crate) fn message(&mut self) -> Result<Nested, Fault> {
        let start = self.at;
        let id = self.fixed::<2>()?.u16(0);
        if id == NULL_ID || self.short {
            return Ok(Nested::none());
        }
        self.at = start;
        self.packed(1).map(Nested::packed)
    }

    /// A list of nested messages, any of which may be null.
    pub(crate) fn list(&mut self) -> Result<MessageList, Fault> {
        let count = self.length()?;
        Ok(MessageList::packed(self.packed(count)?, count))
    }

    /// So many nested messages, checked and as they are on the wire.
    fn packed(&mut self, count: usize) -> Result<Packed, Fault> {
        let (end, height) = packed::check(self.bytes, self.at, self.order, u8::from(self.nested), count)?;
        let bytes = &self.bytes[self.at..end];
        self.at = end;
        Ok(Packed::from_checked(bytes, self.order, height))
    }
}

/// Appends the fields of one payload to a buffer.
#[derive(Debug)]
pub struct Writer<'a> {
    out: &'a mut Vec<u8>,
    order: ByteOrder,
    depth: u8,
    deepest: u8,
    fault: Option<Unwritable>,
}

/// A value that a packet has no room for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Unwritable {
    /// Text or raw data of so many bytes.
    Bytes(usize),
    /// A list of so many messages.
    List(usize),
    /// Messages nested deeper than [`MAX_DEPTH`].
    Depth,
}

impl<'a> Writer<'a> {
    pub(crate) fn new(out: &'a mut Vec<u8>, order: ByteOrder) -> Self {
        Self { out, order, depth: 0, deepest: 0, fault: None }
    }

    /// The value that did not fit, if any.
    pub(crate) fn fault(&self) -> Option<Unwritable> {
        self.fault
    }

    /// How deep messages were nested.
    pub(crate) fn height(&self) -> u8 {
        self.deepest
    }

    /// Whether a message inside another is being written: it has no end of its own to leave fields out at.
    pub(crate) fn nested(&self) -> bool {
        self.depth > 0
    }

    #[inline]
    pub(crate) fn fixed<const N: usize>(&self) -> PutFixed<N> {
        PutFixed { bytes: [0; N], order: self.order }
    }

    #[inline]
    pub(crate) fn put<const N: usize>(&mut self, fixed: &PutFixed<N>) {
        self.out.extend_from_slice(&fixed.bytes);
    }

    fn length(&mut self, length: u16) {
        let mut fixed = self.fixed::<2>();
        fixed.u16(0, length);
        self.put(&fixed);
    }

    pub(crate) fn raw(&mut self, bytes: &[u8]) {
        match u16::try_from(bytes.len()) {
            Ok(count) => {
                self.length(count);
                self.out.extend_from_slice(bytes);
            }
            Err(_) => self.fault = self.fault.or(Some(Unwritable::Bytes(bytes.len()))),
        }
    }

    pub(crate) fn text(&mut self, text: &Text) {
        self.raw(text.as_bytes());
    }

    /// A message inside another, or null, with its id.
    pub(crate) fn element(&mut self, message: Option<&Message>) {
        let Some(message) = message else {
            self.length(NULL_ID);
            return;
        };
        self.length(message.id());
        self.depth += 1;
        self.deepest = self.deepest.max(self.depth);
        message.write(self);
        self.depth -= 1;
    }

    pub(crate) fn message(&mut self, nested: &Nested) {
        let message = nested.message();
        if message.is_empty() {
            self.length(NULL_ID);
        }
        self.packed(message);
    }

    pub(crate) fn list(&mut self, list: &MessageList) {
        match u16::try_from(list.len()) {
            Ok(count) => {
                self.length(count);
                self.packed(list.elements());
            }
            Err(_) => self.fault = self.fault.or(Some(Unwritable::List(list.len()))),
        }
    }

    fn packed(&mut self, packed: &Packed) {
        let deepest = self.depth + packed.height();
        let too_deep = (deepest > MAX_DEPTH).then_some(Unwritable::Depth);
        self.fault = self.fault.or(packed.fault()).or(too_deep);
        self.deepest = self.deepest.max(deepest);
        let start = self.out.len();
        self.out.extend_from_slice(packed.bytes());
        if self.order == ByteOrder::Big {
            packed::turn(&mut self.out[start..], ByteOrder::Little);
        }
    }
}
