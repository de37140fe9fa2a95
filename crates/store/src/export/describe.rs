//! Description of a table's columns, as JSON to be kept beside it.

use super::options::{CsvOptions, Shape};
use super::plan::{Message, Plan};
use super::raw::{COLUMNS, unexplained};
use super::select::{RAW, Selection};
use crate::error::Result;
use crate::history::ColumnKind;
use crate::range::NO_TIME_US;
use crate::reader::Reader;
use serde_json::{Value, json};
use tables::{FIXED, Field};

/// Of all latitudes and longitudes.
const DATUM: &str = "WGS 84 (EPSG:4326)";

/// The columns that every table begins with.
fn described_start(options: CsvOptions) -> Vec<Value> {
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

/// Describes each column of a table, as JSON to be kept beside it: name, unit, type and meaning, and what
/// was asked for.
///
/// # Errors
/// As the export itself.
pub fn describe_csv(reader: &mut Reader, selection: &Selection, options: &CsvOptions) -> Result<Value> {
    let selection = &selection.known(reader)?;
    if selection.is_raw() {
        return Ok(raw(selection, *options));
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
    for (message, field) in plan.fields() {
        let mut about = described_field(&plan, message, field);
        about["type"] = match field.kind {
            ColumnKind::Integer if field.names.is_some() => "text",
            ColumnKind::Integer => "integer",
            ColumnKind::Single | ColumnKind::Double => "number",
            ColumnKind::Text => "text",
            ColumnKind::Raw => "hexadecimal",
            ColumnKind::Nested => "json",
        }
        .into();
        columns.push(about);
    }
    with_left_out(described(&columns, selection, *options), reader, selection)
}

/// A field's column, without its type.
fn described_field(plan: &Plan, message: &Message, field: &Field) -> Value {
    json!({
        "name": plan.column(message, field), "message": message.name, "field": field.name, "unit": field.unit,
        "description": field.meaning,
    })
}

/// The fields of a table whose format tells types by itself, with the time that was asked for.
pub(super) fn describe_fields(plan: &Plan, selection: &Selection) -> Value {
    let columns: Vec<Value> =
        plan.fields().map(|(message, field)| described_field(plan, message, field)).collect();
    let [from, to] = asked_span(selection);
    json!({ "columns": columns, "time_zone": "UTC", "datum": DATUM, "from": from, "to": to })
}

/// Adds how many messages have no row, because their fields are unknown.
fn with_left_out(mut about: Value, reader: &mut Reader, selection: &Selection) -> Result<Value> {
    about["left_out"] = json!({ RAW: unexplained(reader, selection)? });
    Ok(about)
}

/// Beginning and end of the time that was asked for; `None` where it is open.
fn asked_span(selection: &Selection) -> [Option<String>; 2] {
    [selection.range.from_us, selection.range.to_us].map(|us| {
        let open = us <= NO_TIME_US + 1 || us == i64::MAX;
        (!open).then(|| units::UtcTime::from_micros(us).to_string())
    })
}

/// A description of a table with these columns.
fn described(columns: &[Value], selection: &Selection, options: CsvOptions) -> Value {
    let [from, to] = asked_span(selection);
    json!({
        "columns": columns,
        "shape": if options.shape == Shape::Wide { "wide" } else { "long" },
        "time_zone": "UTC",
        "datum": DATUM,
        "missing_value": "",
        "no_number": "NaN, inf, -inf",
        "text_escape": "a cell of text with \\xNN in it is escaped: \\\\ is a backslash, \\xNN a byte",
        "separator": char::from(options.dialect.separator()).to_string(),
        "decimal": char::from(options.dialect.decimal()).to_string(),
        "text_guard": if options.guard { "one apostrophe before text that begins with one of = + - @ (also wide) tab CR LF '" } else { "none" },
        "from": from,
        "to": to,
    })
}

/// The same of a table of what the catalogue does not explain.
fn raw(selection: &Selection, options: CsvOptions) -> Value {
    let mut columns = described_start(options);
    columns.extend(
        COLUMNS.iter().map(|(name, meaning)| json!({"name": name, "description": meaning, "unit": null})),
    );
    described(&columns, selection, options)
}
