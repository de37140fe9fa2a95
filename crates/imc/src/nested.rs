//! One message inside another.

use crate::messages::{Message, Payload};
use crate::packed::Packed;
use std::fmt;

/// The value of a `message` field: one message of any type, or none.
///
/// Like the elements of a [`crate::MessageList`] the message is kept as its bytes on the wire and decoded when it
/// is asked for, and two are equal when these bytes are.
#[derive(Clone, PartialEq, Default)]
pub struct Nested(Packed);

impl Nested {
    /// No message.
    pub fn none() -> Self {
        Self::default()
    }

    pub(crate) fn packed(message: Packed) -> Self {
        Self(message)
    }

    pub(crate) fn message(&self) -> &Packed {
        &self.0
    }

    /// Whether there is no message.
    pub fn is_none(&self) -> bool {
        self.0.is_empty()
    }

    /// The message, decoded.
    pub fn get(&self) -> Option<Message> {
        self.0.iter().next().flatten()
    }

    /// The message, decoded, when it is a `T`.
    pub fn of<T: Payload>(&self) -> Option<T> {
        self.0.of().next()
    }
}

impl fmt::Debug for Nested {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0.fault() {
            Some(fault) => f.debug_tuple("Nested").field(&fault).finish(),
            None => self.get().fmt(f),
        }
    }
}

impl<T: Into<Message>> From<T> for Nested {
    /// A message that no packet can hold, because a value in it is too long or it nests too deep, becomes none;
    /// encoding what it would be in is then refused as encoding the message itself would be.
    fn from(message: T) -> Self {
        let mut packed = Packed::default();
        packed.push(Some(&message.into()));
        packed.shrink();
        Self(packed)
    }
}

impl From<Option<Message>> for Nested {
    fn from(message: Option<Message>) -> Self {
        message.map_or_else(Self::none, Self::from)
    }
}
