//! How an export is laid out: which series, which columns, in which units.

use super::raw::unexplained;
use super::select::{RAW, Selection};
use crate::error::Result;
use crate::history::{ColumnKind, GroupKey, Names};
use crate::range::{NO_TIME_US, TimeRange};
use crate::reader::Reader;
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::num::NonZeroI64;
use tables::{Dialect, FIXED, Field, Format, Style};

/// How a table is laid out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Shape {
    /// A row for each message and a column for each field.
    #[default]
    Wide,
    /// A row for each value, with the names of message and field and the unit.
    Long,
}

/// In which unit angles are written. The history keeps radians.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Angles {
    /// As IMC has them.
    #[default]
    Radians,
    /// `rad` becomes `deg` and `rad/s` becomes `deg/s`.
    Degrees,
}

/// How values are written.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[expect(clippy::struct_excessive_bools, reason = "each is a choice of its own")]
pub struct CsvOptions {
    /// How the table is laid out.
    pub shape: Shape,
    /// In which unit angles are written.
    pub angles: Angles,
    /// Whether a wide table's header gives units, as in `psi [rad]`; else they are in [`describe_csv`] only.
    pub units: bool,
    /// Whether numbers that have names are written as those: `R64K` for 4. Numbers without a name stay.
    pub labels: bool,
    /// Whether text that a spreadsheet would take for a formula gets an apostrophe before it. To get the text
    /// back, take one apostrophe from text that begins with one.
    pub guard: bool,
    /// Whether each row also tells when its message first came ashore.
    pub received: bool,
    /// For which readers cells and numbers are written.
    pub dialect: Dialect,
    /// Of each series the first row in each span of this length (µs), counted from 1970; `None` for every row.
    pub every_us: Option<NonZeroI64>,
}

impl Default for CsvOptions {
    fn default() -> Self {
        Self {
            shape: Shape::Wide,
            angles: Angles::Radians,
            units: true,
            labels: false,
            guard: true,
            received: false,
            dialect: Dialect::Plain,
            every_us: None,
        }
    }
}

impl CsvOptions {
    /// How cells are written.
    pub(crate) fn format(&self) -> Format {
        Format { dialect: self.dialect, guard: self.guard }
    }

    fn style(&self) -> Style {
        Style { degrees: self.angles == Angles::Degrees, labels: self.labels }
    }
}

/// One message's fields, with the first column that they fill in a wide table.
#[derive(Debug)]
pub(crate) struct Message {
    pub(crate) id: u16,
    pub(crate) name: &'static str,
    pub(crate) fields: Vec<Field>,
    pub(crate) first_column: usize,
}

/// One series, and when it is asked for.
#[derive(Debug)]
pub(crate) struct Group {
    pub(crate) key: GroupKey,
    /// Its message's place in [`Plan::messages`].
    pub(crate) message: usize,
    pub(crate) spans: Vec<TimeRange>,
}

/// Everything to be exported.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) messages: Vec<Message>,
    pub(crate) groups: Vec<Group>,
    pub(crate) names: Names,
    pub(crate) columns: usize,
}

impl Plan {
    /// Of a selection that is [known](Selection::known).
    pub(crate) fn new(reader: &mut Reader, selection: &Selection, options: CsvOptions) -> Result<Self> {
        let names = reader.names()?;
        let extents = reader.extents()?;
        let keys: Vec<GroupKey> =
            extents.keys().copied().filter(|group| selection.has_series(&names, *group)).collect();
        let mut asked: BTreeSet<u16> = keys.iter().map(|group| group.id).collect();
        // What was asked for by name has its columns even when there is nothing to put there.
        asked.extend(
            selection.messages.iter().filter_map(|name| imc::catalogue::by_abbrev(name)).map(|desc| desc.id),
        );
        let mut messages = Vec::new();
        let mut columns = 0;
        for desc in asked.into_iter().filter_map(imc::catalogue::by_id) {
            let mut fields = tables::fields(desc, options.style());
            let has_none = fields.is_empty();
            fields.retain(|field| selection.has_field(desc, field.name));
            if fields.is_empty() && !has_none {
                continue;
            }
            let first_column = columns;
            columns += fields.len();
            messages.push(Message { id: desc.id, name: desc.abbrev, fields, first_column });
        }
        let group = |key: GroupKey| {
            let message = messages.iter().position(|message: &Message| message.id == key.id)?;
            Some(Group { key, message, spans: selection.spans(&names, key.src, key.src_ent) })
        };
        let groups = keys.into_iter().filter_map(group).collect();
        Ok(Self { messages, groups, names, columns })
    }

    /// Whether rows of several messages stand in one table, so that each tells its message.
    pub(crate) fn is_mixed(&self) -> bool {
        self.messages.len() > 1
    }

    /// A field's column in a wide table. No two columns have one name.
    pub(crate) fn column(&self, message: &Message, field: &Field) -> String {
        tables::column_name(message.name, field, self.is_mixed())
    }
}

/// The columns that every table begins with.
pub(super) fn described_start(options: CsvOptions) -> Vec<Value> {
    let received = [
        ("received", "when it first came ashore, by the shore's clock; ISO 8601, UTC", None),
        ("received_unix_s", "the same as seconds since 1970-01-01 UTC", Some("s")),
    ];
    let received = received.iter().filter(|_| options.received);
    FIXED.iter().chain(received).map(described_column).collect()
}

fn described_column((name, meaning, unit): &(&str, &str, Option<&str>)) -> Value {
    json!({"name": name, "description": meaning, "unit": unit})
}

/// What stands in each column of a table, as JSON to be kept beside it: name, unit, type and meaning, and what
/// was asked for.
///
/// # Errors
/// As the export itself.
pub fn describe_csv(reader: &mut Reader, selection: &Selection, options: &CsvOptions) -> Result<Value> {
    let selection = &selection.known(reader)?;
    if selection.is_raw() {
        return Ok(super::raw::describe(selection, *options));
    }
    let plan = Plan::new(reader, selection, *options)?;
    let mut columns = described_start(*options);
    let message = ("message", "abbreviation of the message", None);
    if options.shape == Shape::Long {
        let long = [
            message,
            ("field", "name of the field", None),
            ("value", "its value, in the unit beside it", None),
            ("unit", "the value's unit; empty for none", None),
        ];
        columns.extend(long.iter().map(described_column));
        return with_left_out(described(&columns, selection, *options), reader, selection);
    }
    if plan.is_mixed() {
        columns.push(described_column(&message));
    }
    for message in &plan.messages {
        for field in &message.fields {
            let name = plan.column(message, field);
            let kind = match field.kind {
                ColumnKind::Integer if field.names.is_some() => "text",
                ColumnKind::Integer => "integer",
                ColumnKind::Single | ColumnKind::Double => "number",
                ColumnKind::Text => "text",
                ColumnKind::Raw => "hexadecimal",
                ColumnKind::Nested => "json",
            };
            columns.push(json!({
                "name": name, "message": message.name, "field": field.name, "unit": field.unit, "type": kind,
                "description": field.meaning,
            }));
        }
    }
    with_left_out(described(&columns, selection, *options), reader, selection)
}

/// Adds how many messages have no row, because nobody knows their fields.
fn with_left_out(mut about: Value, reader: &mut Reader, selection: &Selection) -> Result<Value> {
    about["left_out"] = json!({ RAW: unexplained(reader, selection)? });
    Ok(about)
}

/// A description of a table with these columns.
pub(super) fn described(columns: &[Value], selection: &Selection, options: CsvOptions) -> Value {
    let text = |us: i64| {
        let open = us <= NO_TIME_US + 1 || us == i64::MAX;
        (!open).then(|| units::UtcTime::from_micros(us).to_string())
    };
    json!({
        "columns": columns,
        "shape": if options.shape == Shape::Wide { "wide" } else { "long" },
        "time_zone": "UTC",
        "datum": "WGS 84 (EPSG:4326)",
        "missing_value": "",
        "no_number": "NaN, inf, -inf",
        "text_escape": "a cell of text with \\xNN in it is escaped: \\\\ is a backslash, \\xNN a byte",
        "separator": char::from(options.dialect.separator()).to_string(),
        "decimal": char::from(options.dialect.decimal()).to_string(),
        "text_guard": if options.guard { "one apostrophe before text that begins with one of = + - @ (also wide) tab CR LF '" } else { "none" },
        "from": text(selection.range.from_us),
        "to": text(selection.range.to_us),
    })
}
