//! The columns of a message's table: its fields and computed ones.

use detections::SET_AFTER_S;
use imc::catalogue::{FieldDesc, FieldKind, Meaning, MessageDesc};
use imc::messages::{EstimatedState, Payload as _, TBRFishTag};

/// The columns that every row begins with: name, contents, unit.
pub const FIXED: [(&str, &str, Option<&str>); 8] = [
    (
        "time",
        "when it was said, by the sender's clock; ISO 8601, UTC; empty where the sender's stamp is not a time",
        None,
    ),
    ("unix_s", "the same as seconds since 1970-01-01 UTC", Some("s")),
    ("system", "name of the system", None),
    ("system_id", "its IMC address", None),
    ("entity", "label that the entity had then", None),
    ("entity_id", "its number", None),
    ("dst", "IMC address of the system that it was said to", None),
    ("dst_ent", "number of the entity that it was said to", None),
];

/// A field's column in a table. No two columns of a table have one name: where rows of several messages share a `mixed` table,
/// or the name is one that every table begins with, the message's stands before it.
pub fn column_name(message: &str, field: &Field, mixed: bool) -> String {
    if mixed || FIXED.iter().any(|(name, ..)| *name == field.name) {
        format!("{message}.{}", field.name)
    } else {
        field.name.to_owned()
    }
}

/// The same with its unit, as in `psi [rad]`.
pub fn heading(message: &str, field: &Field, mixed: bool) -> String {
    let name = column_name(message, field, mixed);
    field.unit.as_ref().map_or_else(|| name.clone(), |unit| format!("{name} [{unit}]"))
}

/// The type of a column.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// An integer.
    Integer,
    /// A single: nine digits identify it.
    Single,
    /// A double.
    Double,
    /// Text.
    Text,
    /// Bytes.
    Raw,
    /// A message or list of messages as JSON.
    Nested,
}

/// A column of a message's table.
#[derive(Debug, Clone, PartialEq)]
pub struct Column {
    /// Its name.
    pub name: &'static str,
    /// Its type.
    pub kind: ColumnKind,
    /// The unit, where there is one.
    pub unit: Option<&'static str>,
    /// Its catalogue entry; `None` for a computed column.
    pub desc: Option<&'static FieldDesc>,
}

impl Column {
    /// Whether its values can be drawn and rolled up.
    pub fn is_number(&self) -> bool {
        matches!(self.kind, ColumnKind::Integer | ColumnKind::Single | ColumnKind::Double)
    }

    /// Whether it is a latitude or longitude.
    pub fn is_place(&self) -> bool {
        let name = self.name;
        ["lat", "lon"].contains(&name)
            || TRUE_POSITION.contains(&name)
            || name.ends_with("_lat")
            || name.ends_with("_lon")
    }

    /// Once around, in the unit of an angle. Latitudes and longitudes are no such angles: their mean is a place between them.
    pub fn circle(&self) -> Option<f64> {
        if !self.is_number() || self.is_place() {
            return None;
        }
        match self.unit {
            Some("rad") => Some(std::f64::consts::TAU),
            Some("°") => Some(360.0),
            _ => None,
        }
    }
}

/// Columns of `EstimatedState` that are computed.
pub const TRUE_POSITION: [&str; 2] = ["true_lat_deg", "true_lon_deg"];

/// The columns of a message that are kept and drawn: first its fields, then where the vessel of an `EstimatedState` is.
pub fn columns(desc: &'static MessageDesc) -> Vec<Column> {
    let mut columns: Vec<Column> = desc.fields.iter().map(own_column).collect();
    if desc.id == EstimatedState::ID {
        let computed = |name| Column { name, kind: ColumnKind::Double, unit: Some("°"), desc: None };
        columns.extend(TRUE_POSITION.map(computed));
    }
    columns
}

fn own_column(field: &'static FieldDesc) -> Column {
    let kind = match field.kind {
        FieldKind::I8
        | FieldKind::U8
        | FieldKind::I16
        | FieldKind::U16
        | FieldKind::I32
        | FieldKind::U32
        | FieldKind::I64 => ColumnKind::Integer,
        FieldKind::F32 => ColumnKind::Single,
        FieldKind::F64 => ColumnKind::Double,
        FieldKind::Text => ColumnKind::Text,
        FieldKind::Raw => ColumnKind::Raw,
        FieldKind::Message | FieldKind::List => ColumnKind::Nested,
    };
    // These are kinds of number, not units.
    let unit = field.unit.filter(|unit| !matches!(*unit, "Enumerated" | "Bitfield" | "TupleList" | "List"));
    Column { name: field.abbrev, kind, unit, desc: Some(field) }
}

/// Where the vessel of an `EstimatedState` is: latitude and longitude (deg) of its reference point (lat, lon in radians, height
/// in metres) displaced by x, y and z (m), which are its first six fields; `None` where they are not a place.
pub fn computed_place([lat, lon, height, x, y, z]: [f64; 6]) -> Option<(f64, f64)> {
    let state = EstimatedState {
        lat,
        lon,
        height: height as f32,
        x: x as f32,
        y: y as f32,
        z: z as f32,
        ..EstimatedState::default()
    };
    let place = imc::position::place(&state).ok()?;
    Some((place.lat_deg(), place.lon_deg()))
}

/// A column that is computed from a message.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Computed {
    /// When the receiver heard a tag, by its own clock, as text; absent where that was never set.
    Heard,
    /// The same in seconds since 1970.
    HeardUnix,
    /// Where the vessel of an `EstimatedState` is (deg).
    TrueLat,
    /// Likewise.
    TrueLon,
}

impl Computed {
    /// When a receiver heard a tag by its own clock, seconds and milliseconds, if that clock was ever set.
    pub fn heard(unix_s: u32, millis: u16) -> Option<(u32, u16)> {
        (unix_s >= SET_AFTER_S).then_some((unix_s, millis))
    }
}

/// How values are shown in a table.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Style {
    /// Angles in degrees instead of radians: `rad` becomes `deg` and `rad/s` becomes `deg/s`.
    pub degrees: bool,
    /// Numbers that have names by these: `R64K` for 4. Numbers without a name stay.
    pub labels: bool,
}

/// One column of a table, and how it is written.
#[derive(Debug, Clone)]
pub struct Field {
    /// Its name.
    pub name: &'static str,
    /// Its type.
    pub kind: ColumnKind,
    /// The unit it is written in.
    pub unit: Option<String>,
    /// To multiply numbers by.
    pub factor: Option<f64>,
    /// To name numbers by.
    pub names: Option<&'static FieldDesc>,
    /// The contents of the column.
    pub meaning: &'static str,
    /// Its place among the message's fields; `None` for what is computed.
    pub at: Option<usize>,
    /// The computed value.
    pub computed: Option<Computed>,
}

/// The fields of a message in the order of their columns: what is computed first, as it is what most people look for. Of
/// EstimatedState that is where the vessel is, for its `lat` and `lon` are those of a reference point.
pub fn fields(desc: &'static MessageDesc, style: Style) -> Vec<Field> {
    let mut fields = match desc.id {
        TBRFishTag::ID => heard().to_vec(),
        EstimatedState::ID => true_position().to_vec(),
        _ => Vec::new(),
    };
    let own = desc.fields.iter().enumerate();
    fields.extend(own.map(|(at, field)| own_field(desc, at, &own_column(field), style)));
    fields
}

fn own_field(desc: &MessageDesc, at: usize, column: &Column, style: Style) -> Field {
    let turned = style.degrees && column.unit.is_some_and(is_angle);
    let unit = column.unit.map(|unit| match unit {
        "°" => "deg".to_owned(),
        unit if turned => unit.replacen("rad", "deg", 1),
        unit => unit.to_owned(),
    });
    let named = column.desc.filter(|desc| style.labels && !matches!(desc.meaning, Meaning::Plain));
    let meaning = match (desc.id, column.name) {
        (EstimatedState::ID, "lat") => "latitude of the reference point of x, y and z, not of the vessel",
        (EstimatedState::ID, "lon") => "longitude of the reference point of x, y and z, not of the vessel",
        _ => column.desc.map_or("", |desc| desc.name),
    };
    Field {
        name: column.name,
        kind: column.kind,
        unit,
        factor: turned.then_some(180.0 / std::f64::consts::PI),
        names: named,
        meaning,
        at: Some(at),
        computed: None,
    }
}

/// Whether a unit is radians, or radians per something.
fn is_angle(unit: &str) -> bool {
    unit.strip_prefix("rad").is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

fn computed_field(
    name: &'static str,
    kind: ColumnKind,
    unit: Option<&str>,
    meaning: &'static str,
    computed: Computed,
) -> Field {
    let unit = unit.map(str::to_owned);
    Field { name, kind, unit, factor: None, names: None, meaning, at: None, computed: Some(computed) }
}

fn heard() -> [Field; 2] {
    let when =
        "when the receiver heard the tag, by its own clock; ISO 8601, UTC; empty where that was never set";
    let seconds = "the same as seconds since 1970-01-01 UTC";
    [
        computed_field("heard", ColumnKind::Text, None, when, Computed::Heard),
        computed_field("heard_unix_s", ColumnKind::Double, Some("s"), seconds, Computed::HeardUnix),
    ]
}

fn true_position() -> [Field; 2] {
    let lat = "latitude of the vessel: the reference point displaced by x, y and z";
    let lon = "longitude of the vessel: the reference point displaced by x, y and z";
    let [lat_name, lon_name] = TRUE_POSITION;
    [
        computed_field(lat_name, ColumnKind::Double, Some("deg"), lat, Computed::TrueLat),
        computed_field(lon_name, ColumnKind::Double, Some("deg"), lon, Computed::TrueLon),
    ]
}
