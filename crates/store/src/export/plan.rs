//! What an export holds: which series, which columns, in which units.

use crate::error::{Result, StoreError};
use crate::history::{Column, ColumnKind, ESTIMATED_STATE, GroupKey, Names, Table};
use crate::range::TimeRange;
use crate::reader::Reader;
use imc::Address;
use imc::catalogue::{FieldDesc, MESSAGES};
use serde_json::{Value, json};
use std::collections::BTreeSet;
use std::num::NonZeroI64;

/// What is asked for. An empty list means all.
#[derive(Debug, Clone)]
pub struct Selection {
    /// Messages by name; `_raw` alone for those that the catalogue does not explain.
    pub messages: Vec<String>,
    /// Systems.
    pub systems: Vec<Address>,
    /// Entities by label or number.
    pub entities: Vec<String>,
    /// Fields by name, for all messages that have them (`psi`) or for one (`EulerAngles.psi`).
    pub fields: Vec<String>,
    /// By the senders' clocks.
    pub range: TimeRange,
}

impl Default for Selection {
    /// Everything.
    fn default() -> Self {
        Self {
            messages: Vec::new(),
            systems: Vec::new(),
            entities: Vec::new(),
            fields: Vec::new(),
            range: TimeRange::ALL,
        }
    }
}

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
            every_us: None,
        }
    }
}

/// One field on its way into a column.
#[derive(Debug, Clone)]
pub(crate) struct Field {
    pub(crate) name: &'static str,
    pub(crate) kind: ColumnKind,
    pub(crate) unit: Option<&'static str>,
    /// To multiply numbers by.
    pub(crate) factor: Option<f64>,
    /// To name numbers by.
    pub(crate) names: Option<&'static FieldDesc>,
    /// What stands in the column.
    meaning: &'static str,
    /// Whether it is a field of the message itself.
    is_own: bool,
    /// What the database computes it by when it is read; `None` for a column of its own.
    pub(crate) sql: Option<String>,
}

/// One message's fields, with the first column that they fill in a wide table.
#[derive(Debug)]
pub(crate) struct Message {
    pub(crate) id: u16,
    pub(crate) name: &'static str,
    pub(crate) fields: Vec<Field>,
    pub(crate) first_column: usize,
}

/// The columns that every row begins with.
const FIXED: [(&str, &str, Option<&str>); 6] = [
    ("time", "when it was said, by the sender's clock; ISO 8601, UTC", None),
    ("unix_s", "the same as seconds since 1970-01-01 UTC", Some("s")),
    ("system", "name of the system", None),
    ("system_id", "its IMC address", None),
    ("entity", "label of the entity", None),
    ("entity_id", "its number", None),
];

/// Everything to be exported.
#[derive(Debug)]
pub(crate) struct Plan {
    pub(crate) messages: Vec<Message>,
    /// The series, each with its message's place in `messages`.
    pub(crate) groups: Vec<(GroupKey, usize)>,
    pub(crate) names: Names,
    pub(crate) columns: usize,
}

impl Plan {
    pub(crate) fn new(reader: &mut Reader, selection: &Selection, options: CsvOptions) -> Result<Self> {
        for message in &selection.messages {
            reader.table(message)?;
        }
        let names = reader.names()?;
        let extents = reader.extents()?;
        let groups = choose(&names, selection, extents.keys().copied())?;
        let mut asked: BTreeSet<u16> = groups.iter().map(|group| group.id).collect();
        // What was asked for by name has its columns even when there is nothing to put there.
        asked.extend(
            selection.messages.iter().filter_map(|name| imc::catalogue::by_abbrev(name)).map(|desc| desc.id),
        );
        let mut messages = Vec::new();
        let mut columns = 0;
        for id in asked {
            let Some(table) = reader.schema.table(id) else { continue };
            let fields: Vec<Field> = fields_of(table, options)
                .into_iter()
                .filter(|field| wants(selection, table, field.name))
                .collect();
            if fields.is_empty() && !table.columns.is_empty() {
                continue;
            }
            let first_column = columns;
            columns += fields.len();
            messages.push(Message { id, name: table.desc.abbrev, fields, first_column });
        }
        check_fields(selection, &messages)?;
        let place =
            |group: GroupKey| Some((group, messages.iter().position(|message| message.id == group.id)?));
        let groups = groups.into_iter().filter_map(place).collect();
        Ok(Self { messages, groups, names, columns })
    }

    /// Whether rows of several messages stand in one table, so that each tells its message.
    pub(crate) fn is_mixed(&self) -> bool {
        self.messages.len() > 1
    }

    /// A field's column in a wide table. No two columns have one name.
    pub(crate) fn column(&self, message: &Message, field: &Field) -> String {
        if self.is_mixed() || FIXED.iter().any(|(name, ..)| *name == field.name) {
            format!("{}.{}", message.name, field.name)
        } else {
            field.name.to_owned()
        }
    }
}

/// The series that are asked for.
pub(crate) fn choose(
    names: &Names,
    selection: &Selection,
    groups: impl Iterator<Item = GroupKey>,
) -> Result<Vec<GroupKey>> {
    if let Some(unknown) = selection.messages.iter().find(|name| imc::catalogue::by_abbrev(name).is_none()) {
        return Err(StoreError::Query(format!("IMC has no message `{unknown}`")));
    }
    let message = |group: &GroupKey| {
        selection
            .messages
            .iter()
            .any(|name| imc::catalogue::by_abbrev(name).is_some_and(|desc| desc.id == group.id))
    };
    Ok(groups
        .filter(|group| says(names, selection, group.src, group.src_ent))
        .filter(|group| selection.messages.is_empty() || message(group))
        .collect())
}

/// Whether an entity of a system is asked for.
pub(crate) fn says(names: &Names, selection: &Selection, src: u16, src_ent: u8) -> bool {
    let entity = |wanted: &String| {
        wanted.parse() == Ok(src_ent)
            || names
                .entities
                .get(&(src, src_ent))
                .is_some_and(|runs| runs.runs.values().any(|run| run.name == *wanted))
    };
    (selection.systems.is_empty() || selection.systems.contains(&Address(src)))
        && (selection.entities.is_empty() || selection.entities.iter().any(entity))
}

/// The fields of a message in the order of their columns: what is computed first, as it is what most people look for. Of
/// EstimatedState that is where the vessel is, for its `lat` and `lon` are those of a reference point.
fn fields_of(table: &Table, options: CsvOptions) -> Vec<Field> {
    let mut fields = match table.desc.id {
        TBR_FISH_TAG => heard().to_vec(),
        _ => Vec::new(),
    };
    fields.extend(table.columns.iter().map(|column| field(table, column, options)));
    fields.sort_by_key(|field| field.is_own);
    fields
}

/// When the receiver heard a tag, by its own clock; nothing where that was never set.
fn heard() -> [Field; 2] {
    let since = detections::SET_AFTER_S;
    let if_set = |sql: &str| Some(format!("CASE WHEN unix_timestamp >= {since} THEN {sql} END"));
    [
        Field {
            name: "heard",
            kind: ColumnKind::Text,
            unit: None,
            factor: None,
            names: None,
            meaning: "when the receiver heard the tag, by its own clock; ISO 8601, UTC; empty where that was never set",
            is_own: false,
            sql: if_set(
                "strftime('%Y-%m-%dT%H:%M:%S', unix_timestamp, 'unixepoch') || printf('.%03dZ', millis)",
            ),
        },
        Field {
            name: "heard_unix_s",
            kind: ColumnKind::Double,
            unit: Some("s"),
            factor: None,
            names: None,
            meaning: "the same as seconds since 1970-01-01 UTC",
            is_own: false,
            sql: if_set("unix_timestamp + millis / 1000.0"),
        },
    ]
}

fn wants(selection: &Selection, table: &Table, column: &str) -> bool {
    selection.fields.is_empty()
        || selection.fields.iter().any(|wanted| match wanted.split_once('.') {
            Some((message, field)) => message == table.desc.abbrev && field == column,
            None => wanted == column,
        })
}

fn check_fields(selection: &Selection, messages: &[Message]) -> Result<()> {
    let found = |wanted: &String| {
        let (message, field) = wanted.split_once('.').map_or((None, wanted.as_str()), |(m, f)| (Some(m), f));
        messages
            .iter()
            .filter(|one| message.is_none_or(|message| one.name == message))
            .any(|one| one.fields.iter().any(|have| have.name == field))
    };
    // Without any message there is nothing to compare with but the catalogue.
    let in_catalogue = |wanted: &String| {
        let field = wanted.rsplit_once('.').map_or(wanted.as_str(), |(_, field)| field);
        messages.is_empty() && MESSAGES.iter().any(|desc| desc.field(field).is_some())
    };
    match selection.fields.iter().find(|wanted| !found(wanted) && !in_catalogue(wanted)) {
        None => Ok(()),
        Some(unknown) => {
            Err(StoreError::Query(format!("none of the messages asked for has a field `{unknown}`")))
        }
    }
}

fn field(table: &Table, column: &Column, options: CsvOptions) -> Field {
    let degrees = options.angles == Angles::Degrees;
    let (unit, factor) = match column.unit {
        Some("rad") if degrees => (Some("deg"), Some(180.0 / std::f64::consts::PI)),
        Some("rad/s") if degrees => (Some("deg/s"), Some(180.0 / std::f64::consts::PI)),
        Some("°") => (Some("deg"), None),
        unit => (unit, None),
    };
    let named =
        column.desc.filter(|desc| options.labels && !matches!(desc.meaning, imc::catalogue::Meaning::Plain));
    let meaning = match (table.desc.id, column.name) {
        (ESTIMATED_STATE, "lat") => "latitude of the reference point of x, y and z, not of the vessel",
        (ESTIMATED_STATE, "lon") => "longitude of the reference point of x, y and z, not of the vessel",
        (ESTIMATED_STATE, "true_lat_deg") => {
            "latitude of the vessel: the reference point displaced by x, y and z"
        }
        (ESTIMATED_STATE, "true_lon_deg") => {
            "longitude of the vessel: the reference point displaced by x, y and z"
        }
        _ => column.desc.map_or("computed from the message", |desc| desc.name),
    };
    let own = column.desc.is_some();
    Field {
        name: column.name,
        kind: column.kind,
        unit,
        factor,
        names: named,
        meaning,
        is_own: own,
        sql: None,
    }
}

/// The message of a tag that was heard.
const TBR_FISH_TAG: u16 = 2007;

/// The name by which all that the catalogue does not explain is asked for, beside messages' names.
pub(crate) const RAW: &str = "_raw";

/// Whether what the catalogue does not explain is asked for, which has a table of its own.
///
/// # Errors
/// When something else is asked for with it.
pub(crate) fn is_raw(selection: &Selection) -> Result<bool> {
    if !selection.messages.iter().any(|name| name == RAW) {
        return Ok(false);
    }
    if selection.messages.len() > 1 || !selection.fields.is_empty() {
        let problem = format!("`{RAW}` has columns of its own: ask for it alone and without fields");
        return Err(StoreError::Query(problem));
    }
    Ok(true)
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
    if is_raw(selection)? {
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
        return Ok(described(&columns, selection, *options));
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
    Ok(described(&columns, selection, *options))
}

/// A description of a table with these columns.
pub(super) fn described(columns: &[Value], selection: &Selection, options: CsvOptions) -> Value {
    let text = |us: i64| {
        let open = us == i64::MIN || us == i64::MAX;
        (!open).then(|| units::UtcTime::from_micros(us).to_string())
    };
    json!({
        "columns": columns,
        "shape": if options.shape == Shape::Wide { "wide" } else { "long" },
        "time_zone": "UTC",
        "datum": "WGS 84 (EPSG:4326)",
        "missing_value": "",
        "text_guard": if options.guard { "one apostrophe before text that begins with one of = + - @ (also wide) tab CR LF '" } else { "none" },
        "from": text(selection.range.from_us),
        "to": text(selection.range.to_us),
    })
}
