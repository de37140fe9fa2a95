//! Messages inside messages, kept as bytes.
//!
//! A message that has two bytes on the wire may have a hundred as a struct. So what comes nested stays bytes: it
//! is checked when the packet is decoded, kept little-endian whatever it was, and becomes structs one at a time
//! when it is read. A decoded packet then holds its own bytes and one struct.

use crate::catalogue::{self, FieldKind, Run};
use crate::messages::{Message, Payload};
use crate::wire::{ByteOrder, Fault, MAX_DEPTH, NULL_ID, Reader, Unwritable, Writer};

/// Ids and fields of messages back to back, little-endian. All of it was written by [`Writer`] or passed by
/// [`check`], so it can be read.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Packed {
    bytes: Vec<u8>,
    /// How deep messages are nested in here: 0 for nulls, 1 for messages that hold none.
    height: u8,
    /// Why a message could not be packed; reported when this is encoded.
    fault: Option<Box<Unwritable>>,
}

impl Packed {
    /// From `bytes` that [`check`] passed with this height.
    pub(crate) fn from_checked(bytes: &[u8], order: ByteOrder, height: u8) -> Self {
        let mut bytes = bytes.to_vec();
        if order == ByteOrder::Big {
            turn(&mut bytes, order);
        }
        Self { bytes, height, fault: None }
    }

    pub(crate) fn is_empty(&self) -> bool {
        self.bytes.is_empty()
    }

    pub(crate) fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    pub(crate) fn height(&self) -> u8 {
        self.height
    }

    pub(crate) fn fault(&self) -> Option<Unwritable> {
        self.fault.as_deref().copied()
    }

    /// Appends a message or null, and says whether it went in: what no packet can hold is left out and its fault
    /// kept.
    pub(crate) fn push(&mut self, message: Option<&Message>) -> bool {
        let start = self.bytes.len();
        let mut writer = Writer::new(&mut self.bytes, ByteOrder::Little);
        writer.element(message);
        let (height, fault) = (writer.height(), writer.fault());
        if let Some(fault) = fault {
            self.bytes.truncate(start);
            self.fault.get_or_insert(Box::new(fault));
            return false;
        }
        self.height = self.height.max(height);
        true
    }

    /// Gives back what [`Self::push`] reserved for more.
    pub(crate) fn shrink(&mut self) {
        self.bytes.shrink_to_fit();
    }

    /// The messages and nulls, decoded one at a time.
    pub(crate) fn iter(&self) -> impl Iterator<Item = Option<Message>> + use<'_> {
        let mut rest = self.bytes.as_slice();
        std::iter::from_fn(move || {
            let (id, fields) = split_id(rest)?;
            let mut reader = Reader::nested(fields);
            // The catalogue has no message with the id of null.
            let message = Message::read(id, &mut reader).map(checked);
            rest = &fields[reader.at()..];
            Some(message)
        })
    }

    /// The messages of type `T`, decoded one at a time; nulls and others are passed over.
    pub(crate) fn of<T: Payload>(&self) -> impl Iterator<Item = T> + use<'_, T> {
        let mut rest = self.bytes.as_slice();
        std::iter::from_fn(move || {
            loop {
                let (id, fields) = split_id(rest)?;
                if id == T::ID {
                    let mut reader = Reader::nested(fields);
                    let message = checked(T::read(&mut reader));
                    rest = &fields[reader.at()..];
                    return Some(message);
                }
                let (end, _) = checked(check(rest, 0, ByteOrder::Little, 0, 1));
                rest = &rest[end..];
            }
        })
    }
}

fn split_id(bytes: &[u8]) -> Option<(u16, &[u8])> {
    let (id, fields) = bytes.split_first_chunk()?;
    Some((u16::from_le_bytes(*id), fields))
}

fn checked<T>(read: Result<T, Fault>) -> T {
    read.expect("invariant: what is packed was checked or written by us")
}

/// Passes over `count` messages or nulls of a payload from byte `at` on, which are in a message that is `depth`
/// deep. Gives where they end and how deep they go themselves.
pub(crate) fn check(
    bytes: &[u8],
    at: usize,
    order: ByteOrder,
    depth: u8,
    count: usize,
) -> Result<(usize, u8), Fault> {
    let mut check = Check { bytes, at, order, deepest: depth };
    for _ in 0..count {
        check.message(depth)?;
    }
    Ok((check.at, check.deepest - depth))
}

struct Check<'a> {
    bytes: &'a [u8],
    at: usize,
    order: ByteOrder,
    deepest: u8,
}

impl Check<'_> {
    #[inline]
    fn number(&mut self) -> Result<u16, Fault> {
        let number = self.bytes[self.at..].first_chunk().ok_or(Fault::Overrun)?;
        self.at += 2;
        Ok(self.order.u16(*number))
    }

    #[inline]
    fn pass(&mut self, count: usize) -> Result<(), Fault> {
        if count > self.bytes.len() - self.at {
            return Err(Fault::Overrun);
        }
        self.at += count;
        Ok(())
    }

    /// A message or null in a message that is `depth` deep.
    fn message(&mut self, depth: u8) -> Result<(), Fault> {
        let id = self.number()?;
        if id == NULL_ID {
            return Ok(());
        }
        if depth == MAX_DEPTH {
            return Err(Fault::TooDeep);
        }
        let desc = catalogue::by_id(id).ok_or(Fault::UnknownNested(id))?;
        let depth = depth + 1;
        self.deepest = self.deepest.max(depth);
        for run in desc.runs {
            match *run {
                Run::Fixed(bytes) => self.pass(bytes)?,
                Run::Counted => {
                    let count = self.number()?;
                    self.pass(usize::from(count))?;
                }
                Run::Message => self.message(depth)?,
                Run::List => {
                    for _ in 0..self.number()? {
                        self.message(depth)?;
                    }
                }
            }
        }
        Ok(())
    }
}

/// Turns the numbers of messages that were checked around, from this byte order into the other.
pub(crate) fn turn(bytes: &mut [u8], from: ByteOrder) {
    let mut turn = Turn { bytes, at: 0, from };
    while turn.at < turn.bytes.len() {
        turn.message();
    }
}

struct Turn<'a> {
    bytes: &'a mut [u8],
    at: usize,
    from: ByteOrder,
}

impl Turn<'_> {
    /// Turns the next bytes around and gives them as they were.
    fn next<const N: usize>(&mut self) -> [u8; N] {
        let mut before = [0; N];
        let place = &mut self.bytes[self.at..self.at + N];
        before.copy_from_slice(place);
        place.reverse();
        self.at += N;
        before
    }

    fn number(&mut self) -> u16 {
        let bytes = self.next();
        self.from.u16(bytes)
    }

    fn message(&mut self) {
        let id = self.number();
        // The catalogue has no message with the id of null.
        let Some(desc) = catalogue::by_id(id) else { return };
        for field in desc.fields {
            match field.kind {
                FieldKind::I8 | FieldKind::U8 => self.at += 1,
                FieldKind::I16 | FieldKind::U16 => drop(self.next::<2>()),
                FieldKind::I32 | FieldKind::U32 | FieldKind::F32 => drop(self.next::<4>()),
                FieldKind::I64 | FieldKind::F64 => drop(self.next::<8>()),
                FieldKind::Raw | FieldKind::Text => self.at += usize::from(self.number()),
                FieldKind::Message => self.message(),
                FieldKind::List => {
                    for _ in 0..self.number() {
                        self.message();
                    }
                }
            }
        }
    }
}
