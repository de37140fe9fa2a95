//! Lists of messages inside messages.

use crate::messages::{Message, Payload};

/// The value of a `message-list` field.
///
/// The wire lets any element be null and any element be of another type than the field asks for; both are
/// kept. [`MessageList::of`] picks the elements of the type wanted.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct MessageList(Vec<Option<Message>>);

impl MessageList {
    /// Number of elements, nulls included.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// Whether there are no elements.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// All elements as they came.
    pub fn as_slice(&self) -> &[Option<Message>] {
        &self.0
    }

    /// The elements of type `T`, in order; nulls and others are passed over.
    pub fn of<T: Payload>(&self) -> impl Iterator<Item = &T> {
        self.0.iter().flatten().filter_map(T::of)
    }

    /// Appends an element.
    pub fn push(&mut self, message: impl Into<Message>) {
        self.0.push(Some(message.into()));
    }
}

impl From<Vec<Option<Message>>> for MessageList {
    fn from(list: Vec<Option<Message>>) -> Self {
        Self(list)
    }
}

impl<T: Into<Message>> FromIterator<T> for MessageList {
    fn from_iter<I: IntoIterator<Item = T>>(messages: I) -> Self {
        Self(messages.into_iter().map(|message| Some(message.into())).collect())
    }
}
