//! Field values to bytes and back, in either byte order.
//!
//! Generated message code reads and writes runs of fixed-size fields as one [`Fixed`] block, so that a run
//! costs one length check, and everything else field by field.

use crate::list::MessageList;
use crate::messages::Message;
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
    depth: u8,
    /// Whether an outer message may end before its last field.
    lenient: bool,
    /// Whether it did.
    short: bool,
}

impl<'a> Reader<'a> {
    pub(crate) fn new(payload: &'a [u8], order: ByteOrder, lenient: bool) -> Self {
        Self { bytes: payload, at: 0, order, depth: 0, lenient, short: false }
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
        if !self.lenient || self.depth > 0 {
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
        self.depth == 0 && self.at == self.bytes.len()
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
    pub(crate) fn message(&mut self) -> Result<Option<Message>, Fault> {
        let id = self.fixed::<2>()?.u16(0);
        if id == NULL_ID || self.short {
            return Ok(None);
        }
        if self.depth == MAX_DEPTH {
            return Err(Fault::TooDeep);
        }
        self.depth += 1;
        let message = Message::read(id, self).ok_or(Fault::UnknownNested(id))?;
        self.depth -= 1;
        message.map(Some)
    }

    /// A list of nested messages, any of which may be null.
    pub(crate) fn list(&mut self) -> Result<MessageList, Fault> {
        let count = self.length()?;
        // Each element has at least its id, so a lying count cannot make us reserve much.
        if count * 2 > self.bytes.len() - self.at {
            return Err(Fault::Overrun);
        }
        let mut list = Vec::with_capacity(count);
        for _ in 0..count {
            list.push(self.message()?);
        }
        Ok(MessageList::from(list))
    }
}

/// Appends the fields of one payload to a buffer.
#[derive(Debug)]
pub struct Writer<'a> {
    out: &'a mut Vec<u8>,
    order: ByteOrder,
    depth: u8,
    fault: Option<Unwritable>,
}

/// What a packet has no room for.
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
        Self { out, order, depth: 0, fault: None }
    }

    /// What did not fit, if anything.
    pub(crate) fn fault(&self) -> Option<Unwritable> {
        self.fault
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

    pub(crate) fn message(&mut self, message: Option<&Message>) {
        let Some(message) = message else {
            self.length(NULL_ID);
            return;
        };
        if self.depth == MAX_DEPTH {
            self.fault = self.fault.or(Some(Unwritable::Depth));
            return;
        }
        self.length(message.id());
        self.depth += 1;
        message.write(self);
        self.depth -= 1;
    }

    pub(crate) fn list(&mut self, list: &MessageList) {
        match u16::try_from(list.len()) {
            Ok(count) => {
                self.length(count);
                for message in list.as_slice() {
                    self.message(message.as_ref());
                }
            }
            Err(_) => self.fault = self.fault.or(Some(Unwritable::List(list.len()))),
        }
    }
}
