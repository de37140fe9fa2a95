//! `imc info`: a message's definition in the catalogue.

use crate::outcome::Outcome;
use crate::output::Output;
use crate::style::Paint;
use crate::table::Table;
use imc::catalogue::{self, EnumDesc, FieldDesc, GROUPS, Meaning, MessageDesc};
use serde_json::{Value, json};
use std::fmt::Write as _;
use std::io::Write as _;

const EXAMPLES: &str = "\
Examples:
  imc info EstimatedState         fields, types, units, ranges, defaults
  imc info vehiclestate           any case will do
  imc info 350                    by id (0x15e works as well)
  imc info Maneuver               the messages of a group
  imc info GpsFix --json          for programs

Ranges are advice: senders are free to exceed them, and decode and encode pass on what they do.";

/// Explains a message: its fields, types, units, ranges, defaults and the names of its numbers.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Info {
    /// A message by abbreviation or id, or a group of messages such as Maneuver
    #[arg(value_name = "MESSAGE|ID")]
    message: String,
    /// One JSON object for programs
    #[arg(long)]
    json: bool,
}

impl Info {
    pub(crate) fn run(&self, out: &mut Output) -> anyhow::Result<Outcome> {
        let group = GROUPS.iter().find(|(name, _)| name.eq_ignore_ascii_case(&self.message));
        let text = match group {
            Some((name, members)) if self.json => json!({"group": name, "messages": members}).to_string(),
            Some((name, members)) => group_text(name, members),
            None => {
                let message = tables::message(&self.message)?;
                if self.json { to_json(message).to_string() } else { text(message, Paint::stdout()) }
            }
        };
        writeln!(out, "{}", text.trim_end())?;
        Ok(Outcome::Sound)
    }
}

fn group_text(name: &str, members: &[&str]) -> String {
    let mut table = Table::new(&[">id", "message", "meaning"]);
    for message in members.iter().filter_map(|member| catalogue::by_abbrev(member)) {
        table.row([message.id.to_string(), message.abbrev.to_owned(), meaning(message)]);
    }
    let paint = Paint::stdout();
    format!("{}, a group of messages\n\n{}", paint.title(name), table.render(2, paint))
}

/// What a message is for, in one line.
pub(crate) fn meaning(message: &MessageDesc) -> String {
    message.summary.unwrap_or(message.name).to_owned()
}

fn text(message: &MessageDesc, paint: Paint) -> String {
    let mut out = format!("{} {}", paint.title(message.abbrev), message.id);
    writeln!(out, "  {}", paint.aside(&format!("{}, {}", message.name, message.category))).ok();
    if let Some(summary) = message.summary {
        writeln!(out, "{summary}").ok();
    }
    let size = match message.fixed_bytes {
        Some(bytes) => format!("{bytes} bytes"),
        None => format!("{} bytes and more", message.min_bytes()),
    };
    let flags =
        if message.flags.is_empty() { String::new() } else { format!(", {}", message.flags.join(", ")) };
    let sources = if message.sources.is_empty() {
        String::new()
    } else {
        format!(", from {}", message.sources.join(", "))
    };
    writeln!(out, "Payload of {size}{flags}{sources}").ok();
    if message.fields.is_empty() {
        out.push_str("\nNo fields.\n");
        return out;
    }
    let mut table = Table::new(&["field", "type", "unit", "range", "default", "meaning"]);
    for field in message.fields {
        let default = field.default.map(|default| default.to_string()).unwrap_or_default();
        table.row([
            field.abbrev.to_owned(),
            field.kind.name().to_owned(),
            field.unit.unwrap_or_default().to_owned(),
            range(field),
            default,
            field_meaning(field),
        ]);
    }
    write!(out, "\n{}", table.render(2, paint)).ok();
    for field in message.fields {
        labels(&mut out, field, paint);
    }
    out
}

fn range(field: &FieldDesc) -> String {
    match (field.min, field.max) {
        (None, None) => String::new(),
        (Some(min), None) => format!("from {}", shortened(min)),
        (None, Some(max)) => format!("to {}", shortened(max)),
        (Some(min), Some(max)) => format!("{} to {}", shortened(min), shortened(max)),
    }
}

/// A bound as short as tables need it, multiples of π by name.
fn shortened(value: f64) -> String {
    let pi = std::f64::consts::PI;
    for (multiple, name) in [(0.5, "π/2"), (1.0, "π"), (2.0, "2π")] {
        if (value.abs() - multiple * pi).abs() < 1e-5 {
            return format!("{}{name}", if value < 0.0 { "-" } else { "" });
        }
    }
    value.to_string()
}

fn field_meaning(field: &FieldDesc) -> String {
    let mut text = field.name.to_owned();
    if let Some(inner) = field.message_type {
        write!(text, " ({inner})").ok();
    }
    if field.appended {
        text.push_str(" (older senders leave it out)");
    }
    text
}

/// The names of a field's numbers.
fn labels(out: &mut String, field: &FieldDesc, paint: Paint) {
    let (desc, bits) = match field.meaning {
        Meaning::Plain => return,
        Meaning::Enumeration(desc) => (desc, false),
        Meaning::Bitfield(desc) => (desc, true),
    };
    let kind = if bits { "bits, joined by |" } else { "one of" };
    write!(out, "\n{} {}\n", paint.title(field.abbrev), paint.aside(kind)).ok();
    let mut table = Table::new(&[">value", "label", "meaning"]);
    for label in desc.values {
        let value = if bits { format!("{:#x}", label.value) } else { label.value.to_string() };
        table.row([value, label.abbrev.to_owned(), label.name.to_owned()]);
    }
    out.push_str(&table.render(2, paint));
}

fn to_json(message: &MessageDesc) -> Value {
    json!({
        "abbrev": message.abbrev,
        "id": message.id,
        "name": message.name,
        "category": message.category,
        "summary": message.summary,
        "sources": message.sources,
        "flags": message.flags,
        "fixed_bytes": message.fixed_bytes,
        "min_bytes": message.min_bytes(),
        "fields": message.fields.iter().map(field_json).collect::<Vec<_>>(),
    })
}

fn field_json(field: &FieldDesc) -> Value {
    let (enumeration, bitfield) = match field.meaning {
        Meaning::Plain => (None, None),
        Meaning::Enumeration(desc) => (Some(values_json(desc)), None),
        Meaning::Bitfield(desc) => (None, Some(values_json(desc))),
    };
    json!({
        "abbrev": field.abbrev,
        "name": field.name,
        "type": field.kind.name(),
        "unit": field.unit,
        "min": field.min,
        "max": field.max,
        "default": field.default,
        "enumeration": enumeration,
        "bitfield": bitfield,
        "message_type": field.message_type,
        "appended": field.appended,
    })
}

fn values_json(desc: &EnumDesc) -> Value {
    let value =
        |label: &catalogue::Label| json!({"value": label.value, "abbrev": label.abbrev, "name": label.name});
    desc.values.iter().map(value).collect()
}
