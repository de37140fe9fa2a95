//! One message into the parameters of one INSERT.

use super::schema::{ESTIMATED_STATE, KEY_COLUMNS, Table};
use imc::catalogue::{FieldDesc, MessageDesc};
use imc::json::NestedText;
use imc::reflect::{self, Value, Visitor, WalkError};
use rusqlite::types::Null;
use rusqlite::{Statement, ToSql};

/// The columns of a row beside the message itself.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sample<'a> {
    pub(crate) view: imc::PacketView<'a>,
    pub(crate) received_us: i64,
    pub(crate) time_us: i64,
    pub(crate) hash: i64,
}

/// Why a message has no row.
#[derive(Debug)]
pub(crate) enum RowError {
    /// Its fields do not fit its payload.
    Payload(WalkError),
    /// By its size it is another message, which another dialect of IMC says by the same id.
    OtherMessage,
    /// The database refused.
    Sqlite(rusqlite::Error),
}

/// Binds a message to its table's INSERT; how many of its fields there were.
pub(crate) fn bind(
    statement: &mut Statement<'_>,
    table: &Table,
    sample: &Sample<'_>,
    nested: &mut NestedText,
) -> Result<usize, RowError> {
    let view = &sample.view;
    if view.desc().is_none() {
        return Err(RowError::OtherMessage);
    }
    nested.reset();
    let mut binder = Binder { statement, at: 1, nested, position: None, failed: None };
    binder.bind(view.src().0);
    binder.bind(view.src_ent());
    binder.bind(sample.time_us);
    binder.bind(sample.hash);
    binder.bind(sample.received_us);
    binder.bind(view.dst().0);
    binder.bind(view.dst_ent());
    if table.desc.id == ESTIMATED_STATE {
        binder.position = Some(Position { next: 0, values: [0.0; POSITION_FIELDS] });
    }
    // An older sender may leave out the last fields.
    let walked = reflect::walk_payload(table.desc, view.payload(), view.order(), true, &mut binder)
        .map_err(RowError::Payload)?;
    while binder.at <= KEY_COLUMNS.len() + table.desc.fields.len() {
        binder.bind(Null);
    }
    if let Some(position) = binder.position.take() {
        let place = position.place();
        binder.bind(place.map(|(lat_deg, _)| lat_deg));
        binder.bind(place.map(|(_, lon_deg)| lon_deg));
    }
    binder.failed.map_or(Ok(walked.fields), |error| Err(RowError::Sqlite(error)))
}

/// `EstimatedState` begins with lat, lon, height, x, y and z.
const POSITION_FIELDS: usize = 6;

struct Position {
    next: usize,
    values: [f64; POSITION_FIELDS],
}

impl Position {
    fn place(&self) -> Option<(f64, f64)> {
        if self.next < POSITION_FIELDS { None } else { tables::computed_place(self.values) }
    }
}

struct Binder<'b, 's> {
    statement: &'b mut Statement<'s>,
    at: usize,
    nested: &'b mut NestedText,
    position: Option<Position>,
    failed: Option<rusqlite::Error>,
}

impl Binder<'_, '_> {
    #[inline]
    fn bind(&mut self, value: impl ToSql) {
        if let Err(error) = self.statement.raw_bind_parameter(self.at, value) {
            self.failed = Some(error);
        }
        self.at += 1;
    }

    fn bind_nested(&mut self) {
        if !self.nested.is_open() {
            if let Err(error) = self.statement.raw_bind_parameter(self.at, self.nested.text()) {
                self.failed = Some(error);
            }
            self.at += 1;
        }
    }
}

impl<'a> Visitor<'a> for Binder<'_, '_> {
    #[inline]
    fn value(&mut self, field: &'static FieldDesc, value: Value<'a>) {
        if self.nested.is_open() {
            self.nested.value(field, value);
            return;
        }
        if let Some(position) = &mut self.position
            && position.next < POSITION_FIELDS
        {
            position.values[position.next] = value.as_f64().unwrap_or(f64::NAN);
            position.next += 1;
        }
        match value {
            Value::Integer(value) => self.bind(value),
            // A NaN becomes NULL.
            Value::Single(value) => self.bind(f64::from(value)),
            Value::Double(value) => self.bind(value),
            Value::Text(text) => match str::from_utf8(text) {
                Ok(text) => self.bind(text),
                Err(_) => self.bind(text),
            },
            Value::Raw(bytes) => self.bind(bytes),
        }
    }

    fn null(&mut self, field: &'static FieldDesc) {
        if self.nested.is_open() {
            self.nested.null(field);
        } else {
            self.bind(Null);
        }
    }

    fn enter_message(&mut self, field: &'static FieldDesc, message: &'static MessageDesc) {
        self.nested.enter_message(field, message);
    }

    fn leave_message(&mut self) {
        self.nested.leave_message();
        self.bind_nested();
    }

    fn enter_list(&mut self, field: &'static FieldDesc, _: usize) {
        self.nested.enter_list(field);
    }

    fn leave_list(&mut self) {
        self.nested.leave_list();
        self.bind_nested();
    }
}
