//! Nested messages and lists as texts of their own: what a table holds of them.

use super::write::{double, integer, quoted_hex, single, write_text};
use crate::catalogue::{FieldDesc, MessageDesc};
use crate::reflect::Value;
use std::io::Write as _;

/// One nested value being written, of a walk that meets several. Empty while the walk is at the outer message's own fields.
#[derive(Debug, Default)]
pub struct NestedText {
    text: Vec<u8>,
    open: Vec<Open>,
}

#[derive(Debug, Clone, Copy)]
struct Open {
    list: bool,
    empty: bool,
}

impl NestedText {
    /// Whether the walk is inside a nested message or list.
    pub fn is_open(&self) -> bool {
        !self.open.is_empty()
    }

    /// What was written, once it is closed.
    pub fn text(&self) -> &str {
        // Everything written is JSON made from UTF-8.
        str::from_utf8(&self.text).unwrap_or_default()
    }

    /// Forgets a value that was broken off.
    pub fn reset(&mut self) {
        self.text.clear();
        self.open.clear();
    }

    fn next(&mut self, field: &FieldDesc) {
        match self.open.last_mut() {
            None => self.text.clear(),
            Some(open) => {
                if !open.empty {
                    self.text.push(b',');
                }
                open.empty = false;
                if !open.list {
                    write!(self.text, "\"{}\":", field.abbrev).ok();
                }
            }
        }
    }

    /// A field that is not a message.
    pub fn value(&mut self, field: &FieldDesc, value: Value<'_>) {
        self.next(field);
        match value {
            Value::Integer(value) => integer(&mut self.text, value),
            Value::Single(value) => single(&mut self.text, value),
            Value::Double(value) => double(&mut self.text, value),
            Value::Text(text) => write_text(&mut self.text, text),
            Value::Raw(bytes) => quoted_hex(&mut self.text, bytes),
        }
    }

    /// A nested position without a message.
    pub fn null(&mut self, field: &FieldDesc) {
        self.next(field);
        self.text.extend_from_slice(b"null");
    }

    /// A nested message begins.
    pub fn enter_message(&mut self, field: &FieldDesc, message: &MessageDesc) {
        self.next(field);
        write!(self.text, r#"{{"abbrev":"{}","fields":{{"#, message.abbrev).ok();
        self.open.push(Open { list: false, empty: true });
    }

    /// The nested message ends.
    pub fn leave_message(&mut self) {
        self.text.extend_from_slice(b"}}");
        self.open.pop();
    }

    /// A list begins.
    pub fn enter_list(&mut self, field: &FieldDesc) {
        self.next(field);
        self.text.push(b'[');
        self.open.push(Open { list: true, empty: true });
    }

    /// The list ends.
    pub fn leave_list(&mut self) {
        self.text.push(b']');
        self.open.pop();
    }
}
