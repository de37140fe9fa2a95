//! The columns of the history that a table is made of, and the values that are computed of them.

use super::options::CsvOptions;
use super::plan::Message;
use crate::history::columns::SENT;
use crate::history::rows::Row;
use rusqlite::types::ValueRef;
use tables::{Computed, Field, IsoTime};

/// Columns before the fields: how many fields were sent, receiver, and when it came.
const BEFORE_FIELDS: [&str; 4] = [SENT, "dst", "dst_ent", "received_us"];
/// The place of the last of them, if it is asked for.
pub(super) const RECEIVED_AT: usize = BEFORE_FIELDS.len() - 1;

/// The columns of a series' rows: what every line begins with, then the fields, and of each field its place.
pub(super) fn columns(message: &Message, options: CsvOptions) -> (Vec<&'static str>, Vec<usize>) {
    let mut columns = BEFORE_FIELDS.to_vec();
    if !options.received {
        columns.truncate(RECEIVED_AT);
    }
    let mut places = Vec::with_capacity(message.fields.len());
    for field in &message.fields {
        places.push(columns.len());
        match field.computed {
            Some(Computed::Heard | Computed::HeardUnix) => columns.extend(["unix_timestamp", "millis"]),
            Some(Computed::TrueLat | Computed::TrueLon) | None => columns.push(field.name),
        }
    }
    (columns, places)
}

/// The value of a field in a row.
pub(super) enum Found<'r> {
    /// As it is.
    Stored(ValueRef<'r>),
    /// As it was computed.
    Text(Vec<u8>),
}

impl<'r> Found<'r> {
    /// `at` is the field's place.
    pub(super) fn read(row: Row<'r>, field: &Field, at: usize) -> rusqlite::Result<Self> {
        let is_text = match field.computed {
            Some(Computed::Heard) => true,
            Some(Computed::HeardUnix) => false,
            Some(Computed::TrueLat | Computed::TrueLon) | None => return Ok(Self::Stored(row.value(at)?)),
        };
        // Empty where the receiver's clock was never set.
        let (unix_s, millis): (Option<u32>, Option<u16>) = (row.get(at)?, row.get(at + 1)?);
        let Some(unix_s) = unix_s.filter(|unix_s| *unix_s >= detections::SET_AFTER_S) else {
            return Ok(Self::Stored(ValueRef::Null));
        };
        if is_text {
            let mut text = Vec::new();
            // A message may hold a second of milliseconds and more.
            let us = i64::from(unix_s) * 1_000_000 + i64::from(millis.unwrap_or(0)) * 1_000;
            IsoTime::new().write_ms(&mut text, us);
            return Ok(Self::Text(text));
        }
        let seconds = millis.map(|millis| f64::from(unix_s) + f64::from(millis) / 1_000.0);
        Ok(Self::Stored(seconds.map_or(ValueRef::Null, ValueRef::Real)))
    }

    pub(super) fn value(&self) -> ValueRef<'_> {
        match self {
            Self::Stored(value) => *value,
            Self::Text(text) => ValueRef::Text(text),
        }
    }
}
