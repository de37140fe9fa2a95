//! Nested messages and lists as JSON, in the form of `imc::json`.

use imc::catalogue::{FieldDesc, MessageDesc};
use imc::json;
use imc::reflect::Value;
use std::io::Write as _;

/// One nested value being written. Empty while the walk is at the outer message's own fields.
#[derive(Debug, Default)]
pub(crate) struct Nested {
    text: Vec<u8>,
    open: Vec<Open>,
}

#[derive(Debug, Clone, Copy)]
struct Open {
    list: bool,
    empty: bool,
}

impl Nested {
    /// Whether the walk is inside a nested message or list.
    pub(crate) fn is_open(&self) -> bool {
        !self.open.is_empty()
    }

    /// What was written, once it is closed.
    pub(crate) fn text(&self) -> &str {
        // Everything written is JSON made from UTF-8.
        str::from_utf8(&self.text).unwrap_or_default()
    }

    /// Forgets a value that was broken off.
    pub(crate) fn reset(&mut self) {
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

    pub(crate) fn value(&mut self, field: &FieldDesc, value: Value<'_>) {
        self.next(field);
        match value {
            Value::Integer(value) => write!(self.text, "{value}").unwrap_or_default(),
            Value::Single(value) => self.number(value.into()),
            Value::Double(value) => self.number(value),
            Value::Text(text) => json::write_text(&mut self.text, text),
            Value::Raw(bytes) => write!(self.text, "\"{}\"", hex::encode(bytes)).unwrap_or_default(),
        }
    }

    fn number(&mut self, value: f64) {
        if value.is_finite() {
            serde_json::to_writer(&mut self.text, &value).unwrap_or_default();
        } else {
            let name: &[u8] = if value.is_nan() {
                b"\"NaN\""
            } else if value > 0.0 {
                b"\"Infinity\""
            } else {
                b"\"-Infinity\""
            };
            self.text.extend_from_slice(name);
        }
    }

    pub(crate) fn null(&mut self, field: &FieldDesc) {
        self.next(field);
        self.text.extend_from_slice(b"null");
    }

    pub(crate) fn enter_message(&mut self, field: &FieldDesc, message: &MessageDesc) {
        self.next(field);
        write!(self.text, r#"{{"abbrev":"{}","fields":{{"#, message.abbrev).ok();
        self.open.push(Open { list: false, empty: true });
    }

    pub(crate) fn leave_message(&mut self) {
        self.text.extend_from_slice(b"}}");
        self.open.pop();
    }

    pub(crate) fn enter_list(&mut self, field: &FieldDesc) {
        self.next(field);
        self.text.push(b'[');
        self.open.push(Open { list: true, empty: true });
    }

    pub(crate) fn leave_list(&mut self) {
        self.text.push(b']');
        self.open.pop();
    }
}
