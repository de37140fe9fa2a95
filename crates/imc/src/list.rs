//! Lists of messages inside messages.

use crate::messages::{Message, Payload};
use crate::packed::Packed;
use std::fmt;

/// The value of a `message-list` field.
///
/// The wire lets any element be null and any element be of another type than the field asks for; both are
/// kept. [`MessageList::of`] picks the elements of the type wanted.
///
/// The elements are kept as their bytes on the wire, little-endian, and decoded one at a time when they are
/// iterated over, so that a list of tiny messages takes the memory it took there. Two lists are equal when these
/// bytes are: a NaN equals the same NaN, and 0 differs from -0. What an older layout of a message lacks, such as
/// the position of a TBRFishTag, cannot be left out inside another message and comes back as NaN.
#[derive(Clone, PartialEq, Default)]
pub struct MessageList {
    elements: Packed,
    count: usize,
}

impl MessageList {
    /// Of as many elements as were packed.
    pub(crate) fn packed(elements: Packed, count: usize) -> Self {
        Self { elements, count }
    }

    pub(crate) fn elements(&self) -> &Packed {
        &self.elements
    }

    /// Number of elements, nulls included.
    pub fn len(&self) -> usize {
        self.count
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// All elements as they came, decoded one at a time.
    pub fn iter(&self) -> impl Iterator<Item = Option<Message>> + use<'_> {
        self.elements.iter()
    }

    /// The elements of type `T`, in order and decoded one at a time; nulls and others are passed over.
    pub fn of<T: Payload>(&self) -> impl Iterator<Item = T> + use<'_, T> {
        self.elements.of()
    }

    /// Appends an element.
    ///
    /// A message that no packet can hold, because a value in it is too long or it nests too deep, is left out;
    /// encoding what the list is in is then refused as encoding that message would be.
    pub fn push(&mut self, message: impl Into<Message>) {
        self.push_or_null(Some(&message.into()));
    }

    fn push_or_null(&mut self, message: Option<&Message>) {
        self.count += usize::from(self.elements.push(message));
    }
}

impl fmt::Debug for MessageList {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let elements = fmt::from_fn(|f| f.debug_list().entries(self.iter()).finish());
        let mut list = f.debug_tuple("MessageList");
        list.field(&elements);
        if let Some(fault) = self.elements.fault() {
            list.field(&fault);
        }
        list.finish()
    }
}

impl From<Vec<Option<Message>>> for MessageList {
    fn from(messages: Vec<Option<Message>>) -> Self {
        let mut list = Self::default();
        for message in &messages {
            list.push_or_null(message.as_ref());
        }
        list.elements.shrink();
        list
    }
}

impl<T: Into<Message>> FromIterator<T> for MessageList {
    fn from_iter<I: IntoIterator<Item = T>>(messages: I) -> Self {
        let mut list = Self::default();
        for message in messages {
            list.push(message);
        }
        list.elements.shrink();
        list
    }
}
