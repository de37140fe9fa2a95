//! The columns of a message's table, and a packet as one of its lines.

use super::cell::{Row, Style};
use super::names::Names;
use super::shown::iso;
use imc::catalogue::{FieldDesc, FieldKind, MessageDesc};
use imc::reflect::{self, Value, Visitor};
use imc::{PacketView, ShortPayload, json};
use serde_json::json;

/// The line of headings.
pub(super) fn header(desc: &MessageDesc, style: Style) -> String {
    let mut row = Row::default();
    for name in ["time", "epoch [s]", "src", "src_ent", "entity"] {
        row.plain(name);
    }
    for field in desc.fields {
        match unit(field, style) {
            Some(unit) => row.plain(format_args!("{} [{unit}]", field.abbrev)),
            None => row.plain(field.abbrev),
        }
    }
    row.finish().to_owned()
}

/// The unit of a column; the catalogue's own words for kinds of values are none.
fn unit(field: &FieldDesc, style: Style) -> Option<String> {
    let unit = field.unit.filter(|unit| !["Enumerated", "Bitfield", "TupleList", "List"].contains(unit))?;
    Some(if style.degrees && is_angle(unit) { unit.replacen("rad", "°", 1) } else { unit.to_owned() })
}

/// Whether a unit is radians, or radians per something.
fn is_angle(unit: &str) -> bool {
    unit.strip_prefix("rad").is_some_and(|rest| rest.is_empty() || rest.starts_with('/'))
}

/// Writes the line of a packet. Whether it could be read.
pub(super) fn write_row(
    row: &mut Row,
    desc: &MessageDesc,
    view: &PacketView<'_>,
    names: &Names,
    style: Style,
) -> bool {
    let header = view.header();
    row.clear();
    row.plain(iso(header.timestamp));
    row.double(header.timestamp);
    row.text(&names.system(header.src), style);
    row.plain(header.src_ent);
    row.text(names.label(header.src, header.src_ent), style);
    let nested = if has_nested(desc) { fields_json(view) } else { json!({}) };
    let mut cells = Cells { row, style, nested: &nested, depth: 0 };
    let Some(Ok(walked)) = reflect::walk(view, &mut cells) else { return false };
    for _absent in &desc.fields[walked.fields..] {
        row.empty();
    }
    true
}

fn has_nested(desc: &MessageDesc) -> bool {
    desc.fields.iter().any(|field| matches!(field.kind, FieldKind::Message | FieldKind::List))
}

/// A packet's fields as JSON.
fn fields_json(view: &PacketView<'_>) -> serde_json::Value {
    let mut line = Vec::new();
    // A packet that cannot be read fails in the walk too.
    json::write_packet(&mut line, view, ShortPayload::default()).ok();
    serde_json::from_slice(&line)
        .map_or_else(|_| json!({}), |mut packet: serde_json::Value| packet["fields"].take())
}

/// Fields of the outer message as cells.
struct Cells<'r> {
    row: &'r mut Row,
    style: Style,
    /// The fields as JSON, when some are messages.
    nested: &'r serde_json::Value,
    /// Messages and lists around the present place.
    depth: usize,
}

impl Cells<'_> {
    fn enter(&mut self, field: &FieldDesc) {
        if self.depth == 0 {
            self.row.text(&self.nested[field.abbrev].to_string(), self.style);
        }
        self.depth += 1;
    }

    fn integer(&mut self, field: &FieldDesc, value: i64) {
        match field.label(value).filter(|label| self.style.labels && !label.is_empty()) {
            Some(label) => self.row.plain(label),
            None => self.row.plain(value),
        }
    }
}

impl<'a> Visitor<'a> for Cells<'_> {
    fn value(&mut self, field: &'static FieldDesc, value: Value<'a>) {
        if self.depth > 0 {
            return;
        }
        let turned = self.style.degrees && field.unit.is_some_and(is_angle);
        match value {
            Value::Integer(value) => self.integer(field, value),
            // In the precision of a double, so that turning adds no error of its own.
            Value::Single(value) if turned => self.row.single(f64::from(value).to_degrees() as f32),
            Value::Single(value) => self.row.single(value),
            Value::Double(value) if turned => self.row.double(value.to_degrees()),
            Value::Double(value) => self.row.double(value),
            Value::Text(text) => self.row.wire_text(text, self.style),
            Value::Raw(bytes) => self.row.plain(hex::encode(bytes)),
        }
    }

    fn null(&mut self, _: &'static FieldDesc) {
        if self.depth == 0 {
            self.row.empty();
        }
    }

    fn enter_message(&mut self, field: &'static FieldDesc, _: &'static MessageDesc) {
        self.enter(field);
    }

    fn leave_message(&mut self) {
        self.depth -= 1;
    }

    fn enter_list(&mut self, field: &'static FieldDesc, _: usize) {
        self.enter(field);
    }

    fn leave_list(&mut self) {
        self.depth -= 1;
    }
}
