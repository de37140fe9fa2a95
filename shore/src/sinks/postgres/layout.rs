//! The tables in PostgreSQL, made from IMC's catalogue when the program runs, and the statements that make and fill them.
//!
//! One wide table for each message, as the history has, with the columns of [`KEY`] before the message's fields. Names are in small
//! letters, so that `SELECT * FROM lutra.EulerAngles` finds them without quotes; a field whose name is one of the first columns'
//! has `_field` behind it. `_raw` holds what cannot be read as its id says, `detection_reports` what packets say of
//! detections, which the view `detections` puts together.

use imc::catalogue::{FieldDesc, FieldKind, Meaning, MessageDesc};
use imc::messages::{EstimatedState, Payload as _};
use std::fmt::Write as _;

/// The columns that every table begins with.
pub(super) const KEY: [(&str, Type, &str); 7] = [
    ("src", Type::Integer, "IMC address of the system that said it"),
    ("time", Type::Time, "when it was said, by the sender's clock; -infinity where its stamp is not a time"),
    ("src_ent", Type::SmallInt, "number of the entity that said it"),
    ("hash", Type::BigInt, "fingerprint of the payload: tells apart what is said in one microsecond"),
    ("received", Type::Time, "when it first came ashore, by the shore's clock"),
    ("dst", Type::Integer, "IMC address of the system that it was said to"),
    ("dst_ent", Type::SmallInt, "number of the entity that it was said to"),
];

/// Radians to degrees, as the history has it.
const DEGREES: &str = "57.29577951308232";

/// What a column holds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Type {
    SmallInt,
    Integer,
    BigInt,
    Real,
    Double,
    Text,
    Bytes,
    Json,
    Time,
}

impl Type {
    /// As PostgreSQL calls it.
    pub(super) const fn name(self) -> &'static str {
        match self {
            Self::SmallInt => "smallint",
            Self::Integer => "integer",
            Self::BigInt => "bigint",
            Self::Real => "real",
            Self::Double => "double precision",
            Self::Text => "text",
            Self::Bytes => "bytea",
            Self::Json => "json",
            Self::Time => "timestamp with time zone",
        }
    }

    /// The type that holds every value of a field.
    pub(super) const fn of(kind: FieldKind) -> Self {
        match kind {
            FieldKind::I8 | FieldKind::U8 | FieldKind::I16 => Self::SmallInt,
            FieldKind::U16 | FieldKind::I32 => Self::Integer,
            FieldKind::U32 | FieldKind::I64 => Self::BigInt,
            FieldKind::F32 => Self::Real,
            FieldKind::F64 => Self::Double,
            FieldKind::Text => Self::Text,
            FieldKind::Raw => Self::Bytes,
            FieldKind::Message | FieldKind::List => Self::Json,
        }
    }
}

/// One of the tables.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum TableId {
    /// What cannot be read as its id says.
    Raw,
    /// A message of the catalogue, by its id.
    Message(u16),
    /// What packets say of detections.
    Detections,
}

/// A column that is written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Column {
    pub(super) name: String,
    pub(super) kind: Type,
    comment: String,
}

impl Column {
    fn new(name: &str, kind: Type, comment: &str) -> Self {
        Self { name: name.to_owned(), kind, comment: comment.to_owned() }
    }
}

/// A table and how it is filled.
#[derive(Debug)]
pub(super) struct Table {
    pub(super) name: String,
    /// Those that are written, the key's before the others.
    pub(super) columns: Vec<Column>,
    /// Latitudes and longitudes once more in degrees: name, and what it is computed from.
    degrees: Vec<(String, String)>,
    key: &'static str,
    comment: String,
}

impl Table {
    pub(super) fn new(id: TableId) -> Self {
        match id {
            TableId::Raw => raw(),
            TableId::Message(id) => imc::catalogue::by_id(id).map_or_else(raw, message),
            TableId::Detections => detections(),
        }
    }

    /// With its schema, quoted.
    pub(super) fn full_name(&self, schema: &str) -> String {
        format!("\"{schema}\".\"{}\"", self.name)
    }

    /// Makes the table.
    pub(super) fn create(&self, schema: &str) -> String {
        let mut sql = format!("CREATE TABLE IF NOT EXISTS {} (", self.full_name(schema));
        for (at, column) in self.columns.iter().enumerate() {
            let need = if at < KEY.len() { " NOT NULL" } else { "" };
            write!(sql, "\"{}\" {}{need}, ", column.name, column.kind.name()).ok();
        }
        for (name, from) in &self.degrees {
            write!(sql, "{}, ", generated(name, from)).ok();
        }
        write!(sql, "PRIMARY KEY ({}))", self.key).ok();
        sql
    }

    /// Adds the columns that a table of an earlier catalogue lacks: each with its statements.
    pub(super) fn add_missing(&self, schema: &str, lacks: impl Fn(&str) -> bool) -> Vec<(&str, String)> {
        let table = self.full_name(schema);
        let mut statements = Vec::new();
        for column in self.columns.iter().filter(|column| lacks(&column.name)) {
            let (name, kind) = (&column.name, column.kind.name());
            let comment = self.comment_on(schema, column);
            statements.push((
                name.as_str(),
                format!("ALTER TABLE {table} ADD COLUMN IF NOT EXISTS \"{name}\" {kind}; {comment}"),
            ));
        }
        for (name, from) in self.degrees.iter().filter(|(name, _)| lacks(name)) {
            let column = generated(name, from);
            statements
                .push((name.as_str(), format!("ALTER TABLE {table} ADD COLUMN IF NOT EXISTS {column}")));
        }
        statements
    }

    /// Says in the database what its columns mean.
    pub(super) fn comments(&self, schema: &str) -> String {
        let table = self.full_name(schema);
        let mut sql = format!("COMMENT ON TABLE {table} IS {}", quoted(&self.comment));
        for column in &self.columns {
            write!(sql, "; {}", self.comment_on(schema, column)).ok();
        }
        for (name, from) in &self.degrees {
            write!(
                sql,
                "; COMMENT ON COLUMN {table}.\"{name}\" IS {}",
                quoted(&format!("{from} in degrees"))
            )
            .ok();
        }
        sql
    }

    fn comment_on(&self, schema: &str, column: &Column) -> String {
        format!(
            "COMMENT ON COLUMN {}.\"{}\" IS {}",
            self.full_name(schema),
            column.name,
            quoted(&column.comment)
        )
    }

    /// An index that finds a time of the whole fleet, small because rows come nearly in order of time.
    pub(super) fn index_time(&self, schema: &str) -> String {
        format!("CREATE INDEX ON {} USING brin (time)", self.full_name(schema))
    }

    /// Makes the session's own table that rows are copied to first.
    pub(super) fn create_incoming(&self) -> String {
        let mut sql = format!("CREATE TEMPORARY TABLE \"{}\" (", self.name);
        for (at, column) in self.columns.iter().enumerate() {
            let comma = if at > 0 { ", " } else { "" };
            write!(sql, "{comma}\"{}\" {}", column.name, column.kind.name()).ok();
        }
        sql.push_str(") ON COMMIT DELETE ROWS");
        sql
    }

    pub(super) fn empty_incoming(&self) -> String {
        format!("DELETE FROM pg_temp.\"{}\"", self.name)
    }

    /// Copies rows that are not there yet straight into the table; one that is there refuses them all.
    pub(super) fn copy_new(&self, schema: &str) -> String {
        format!("COPY {} ({}) FROM STDIN (FORMAT binary)", self.full_name(schema), self.column_names())
    }

    pub(super) fn copy(&self) -> String {
        format!("COPY pg_temp.\"{}\" FROM STDIN (FORMAT binary)", self.name)
    }

    /// Takes over what was copied. A row that is there stays, and stands for the earliest arrival of its message.
    pub(super) fn merge(&self, schema: &str) -> String {
        let (table, columns) = (self.full_name(schema), self.column_names());
        format!(
            "INSERT INTO {table} AS there ({columns}) SELECT {columns} FROM pg_temp.\"{}\" ON CONFLICT ({}) DO UPDATE SET \
             received = EXCLUDED.received, dst = EXCLUDED.dst, dst_ent = EXCLUDED.dst_ent \
             WHERE there.received > EXCLUDED.received",
            self.name, self.key
        )
    }

    /// Those that rows give, not those that are computed.
    fn column_names(&self) -> String {
        let names: Vec<String> = self.columns.iter().map(|column| format!("\"{}\"", column.name)).collect();
        names.join(", ")
    }
}

/// A computed column; NaN and infinities give themselves, and NULL is what no `double precision` holds, lest the row is refused.
fn generated(name: &str, from: &str) -> String {
    format!(
        "\"{name}\" double precision GENERATED ALWAYS AS (CASE WHEN abs(\"{from}\") < '1e300'::float8 \
         OR \"{from}\" = 'NaN'::float8 OR abs(\"{from}\") = 'Infinity'::float8 THEN \"{from}\" * {DEGREES} END) STORED"
    )
}

fn message(desc: &'static MessageDesc) -> Table {
    let mut columns: Vec<_> = key_columns();
    let mut degrees = Vec::new();
    for field in desc.fields {
        let name = column_name(field.abbrev);
        columns.push(Column::new(&name, Type::of(field.kind), &meaning(field)));
        let is_place = ["lat", "lon"].contains(&field.abbrev)
            || field.abbrev.ends_with("_lat")
            || field.abbrev.ends_with("_lon");
        if is_place && field.unit == Some("rad") {
            degrees.push((format!("{name}_deg"), name));
        }
    }
    if desc.id == EstimatedState::ID {
        for name in tables::TRUE_POSITION {
            let comment = "where the vessel is: the reference point displaced by x, y and z; unit °";
            columns.push(Column::new(name, Type::Double, comment));
        }
    }
    let comment = desc.summary.map_or_else(
        || format!("IMC {} {}", desc.id, desc.name),
        |summary| format!("IMC {} {}: {summary}", desc.id, desc.name),
    );
    Table { name: desc.abbrev.to_lowercase(), columns, degrees, key: "src, time, src_ent, hash", comment }
}

fn raw() -> Table {
    let mut columns = key_columns();
    columns.push(Column::new("id", Type::Integer, "number of the message"));
    columns.push(Column::new("payload", Type::Bytes, "its payload as it came"));
    columns.push(Column::new("problem", Type::Text, "why it is in no other table"));
    Table {
        name: "_raw".to_owned(),
        columns,
        degrees: Vec::new(),
        key: "src, time, src_ent, hash, id",
        comment: "Messages that the catalogue does not know, or that are damaged".to_owned(),
    }
}

/// What [`super::row`] writes of a detection, behind the key.
pub(super) const DETECTION: [(&str, Type, &str); 21] = [
    ("receiver", Type::BigInt, "serial number of the receiver"),
    ("clock_time", Type::Time, "the receiver's clock, counted from 1970 whatever it counts from"),
    ("clock_state", Type::SmallInt, "0 not set, 1 lost, 2 set, 3 disciplined"),
    ("protocol", Type::Text, "coding of the transmission, like R64K"),
    ("tag", Type::BigInt, "number of the tag"),
    ("data", Type::Integer, "what the tag measured, as it was sent"),
    ("snr_db", Type::SmallInt, "signal to noise ratio; unit dB; absent where the receiver does not say it"),
    ("frequency_khz", Type::SmallInt, "carrier; unit kHz; absent where it is not known"),
    ("line", Type::Integer, "running number of the receiver's line"),
    ("lat_deg", Type::Double, "where the vessel was; unit °"),
    ("lon_deg", Type::Double, "where the vessel was; unit °"),
    ("pose_age_s", Type::Double, "time to the nearest measured position; unit s"),
    ("pose_sigma_m", Type::Double, "standard deviation of the place on each axis; unit m"),
    ("lines_lost", Type::Integer, "lines that the receiver wrote before and that never came"),
    ("noise_average", Type::SmallInt, "mean noise, the receiver's counts"),
    ("noise_peak", Type::SmallInt, "peak noise, the receiver's counts"),
    ("noise_age_s", Type::Double, "how long before that was; unit s"),
    ("propeller_rpm", Type::Double, "speed of the faster propeller; unit rpm"),
    ("raw", Type::Text, "the receiver's line"),
    ("message", Type::Text, "the message that says so"),
    ("maker", Type::Text, "maker of the receiver, where a file said it: makers give the same serial numbers"),
];

fn detections() -> Table {
    let mut columns = key_columns();
    columns.extend(DETECTION.map(|(name, kind, comment)| Column::new(name, kind, comment)));
    Table {
        name: "detection_reports".to_owned(),
        columns,
        degrees: Vec::new(),
        key: "src, time, src_ent, hash",
        comment: "What each message says of a detection; the view detections has each detection once"
            .to_owned(),
    }
}

fn key_columns() -> Vec<Column> {
    KEY.map(|(name, kind, comment)| Column::new(name, kind, comment)).into()
}

/// A field's column.
fn column_name(abbrev: &str) -> String {
    let name = abbrev.to_lowercase();
    if KEY.iter().any(|(key, ..)| *key == name) { format!("{name}_field") } else { name }
}

/// A field in words: what it is, its unit, the names of its numbers.
fn meaning(field: &FieldDesc) -> String {
    let mut text = field.name.to_owned();
    let (what, values) = match field.meaning {
        Meaning::Plain => ("", None),
        Meaning::Enumeration(desc) => ("values", Some(desc)),
        Meaning::Bitfield(desc) => ("bits", Some(desc)),
    };
    if let Some(unit) = field.unit.filter(|_| values.is_none() && Type::of(field.kind) != Type::Json) {
        write!(text, "; unit {unit}").ok();
    }
    if let Some(desc) = values {
        write!(text, "; {what}").ok();
        for label in desc.values {
            write!(text, " {}={}", label.value, label.abbrev).ok();
        }
    }
    text
}

/// A text in SQL.
pub(super) fn quoted(text: &str) -> String {
    format!("'{}'", text.replace('\'', "''"))
}

/// A time of PostgreSQL's count (µs since 2000-01-01) in SQL.
pub(super) fn time(us: i64) -> String {
    if us == i64::MIN {
        return "'-infinity'".to_owned();
    }
    // A double holds whole seconds of all times, and no microseconds of distant ones.
    format!(
        "timestamptz '2000-01-01 00:00:00Z' + {} * interval '1 s' + {} * interval '1 us'",
        us.div_euclid(1_000_000),
        us.rem_euclid(1_000_000)
    )
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::catalogue::MESSAGES;
    use std::collections::BTreeSet;

    /// The table that a name is of; `None` where none is of that name.
    fn named(name: &str) -> Option<TableId> {
        match name {
            "_raw" => Some(TableId::Raw),
            "detection_reports" => Some(TableId::Detections),
            _ => MESSAGES
                .iter()
                .find(|desc| desc.abbrev.eq_ignore_ascii_case(name))
                .map(|desc| TableId::Message(desc.id)),
        }
    }

    #[test]
    fn no_two_tables_and_no_two_columns_have_one_name_and_none_is_postgresqls_own() {
        let ids = MESSAGES.iter().map(|desc| TableId::Message(desc.id));
        let mut tables = BTreeSet::from(["vessels".to_owned(), "detections".to_owned(), "_lutra".to_owned()]);
        for id in ids.chain([TableId::Raw, TableId::Detections]) {
            let table = Table::new(id);
            assert_eq!(named(&table.name), Some(id));
            assert!(table.name.len() < 64 && tables.insert(table.name.clone()), "{}", table.name);
            let mut columns =
                BTreeSet::from(["tableoid", "xmin", "cmin", "xmax", "cmax", "ctid"].map(str::to_owned));
            let names = table.columns.iter().map(|column| &column.name);
            for name in names.chain(table.degrees.iter().map(|(name, _)| name)) {
                assert!(name.len() < 64 && columns.insert(name.clone()), "{}.{name}", table.name);
            }
        }
    }

    #[test]
    fn a_field_that_is_called_like_a_key_is_told_apart_and_comments_say_unit_and_values() {
        let table = Table::new(named("EulerAngles").unwrap());
        let sql = table.create("lutra");
        assert!(
            sql.starts_with("CREATE TABLE IF NOT EXISTS \"lutra\".\"eulerangles\" (\"src\" integer NOT NULL")
        );
        assert!(
            sql.contains("\"time_field\" double precision") && sql.contains("\"psi\" double precision"),
            "{sql}"
        );
        let comments = Table::new(named("EntityState").unwrap()).comments("lutra");
        assert!(comments.contains("values 0=BOOT 1=NORMAL"), "{comments}");
        assert!(table.comments("lutra").contains("; unit rad'"));
        let tag = Table::new(named("TBRFishTag").unwrap()).create("lutra");
        let degrees =
            "\"lat_deg\" double precision GENERATED ALWAYS AS (CASE WHEN abs(\"lat\") < '1e300'::float8 ";
        assert!(
            tag.contains(degrees) && tag.contains(" THEN \"lat\" * 57.29577951308232 END) STORED"),
            "{tag}"
        );
    }
}
