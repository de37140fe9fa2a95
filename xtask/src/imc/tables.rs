//! Descriptions of every message and field, for code that handles them at run time.

use super::catalogue::{Catalogue, Field, Kind, Label, Message};
use super::{File, banner, names};
use std::collections::BTreeMap;
use std::fmt::Write as _;

pub(super) fn file(catalogue: &Catalogue, addresses: &BTreeMap<String, u16>) -> File {
    let mut text = banner("Descriptions of all messages, enumerations and addresses.");
    text.push_str("use super::{EnumDesc, FieldDesc, FieldKind, Label, Meaning, MessageDesc, Run};\n\n");
    writeln!(text, "/// Version of the catalogue.\npub const VERSION: &str = {:?};\n", catalogue.version)
        .ok();
    pairs(&mut text, "Units: abbreviation and name.", "UNITS", &catalogue.units);
    shared(&mut text, catalogue);
    groups(&mut text, catalogue);
    for message in &catalogue.messages {
        message_table(&mut text, message);
    }
    writeln!(text, "/// All messages by ascending id.").ok();
    writeln!(text, "pub static MESSAGES: [&MessageDesc; {}] = [", catalogue.messages.len()).ok();
    let mut by_id: Vec<&Message> = catalogue.messages.iter().collect();
    by_id.sort_by_key(|message| message.id);
    for message in &by_id {
        writeln!(text, "    &{},", names::screaming(&message.abbrev)).ok();
    }
    text.push_str("];\n\n");
    text.push_str(
        "/// The message with this id; as a match, because nested messages are looked up one by one.\n",
    );
    text.push_str("pub(crate) fn by_id(id: u16) -> Option<&'static MessageDesc> {\n    Some(match id {\n");
    for message in &by_id {
        writeln!(text, "        {} => &{},", message.id, names::screaming(&message.abbrev)).ok();
    }
    text.push_str("        _ => return None,\n    })\n}\n\n");
    let mut by_abbrev = by_id;
    by_abbrev.sort_by_key(|message| &message.abbrev);
    writeln!(text, "/// All messages by abbreviation, in the order of their bytes.").ok();
    writeln!(text, "pub(crate) static BY_ABBREV: [&MessageDesc; {}] = [", by_abbrev.len()).ok();
    for message in &by_abbrev {
        writeln!(text, "    &{},", names::screaming(&message.abbrev)).ok();
    }
    text.push_str("];\n\n");
    let mut listed: Vec<(&String, &u16)> = addresses.iter().collect();
    listed.sort_by_key(|(name, address)| (**address, (*name).clone()));
    writeln!(text, "/// Registered systems: name and address, by ascending address.").ok();
    writeln!(text, "pub static ADDRESSES: [(&str, u16); {}] = [", listed.len()).ok();
    for (name, address) in listed {
        writeln!(text, "    ({name:?}, {address:#06x}),").ok();
    }
    text.push_str("];\n");
    File { path: "crates/imc/src/catalogue/tables.rs".to_owned(), text }
}

fn pairs(text: &mut String, doc: &str, name: &str, pairs: &[(String, String)]) {
    writeln!(text, "/// {doc}\npub static {name}: [(&str, &str); {}] = [", pairs.len()).ok();
    for (key, value) in pairs {
        writeln!(text, "    ({key:?}, {value:?}),").ok();
    }
    text.push_str("];\n\n");
}

fn shared(text: &mut String, catalogue: &Catalogue) {
    for (kind, all) in [("ENUMERATIONS", &catalogue.enumerations), ("BITFIELDS", &catalogue.bitfields)] {
        for shared in all {
            let name = names::screaming(&shared.abbrev);
            let body = enum_desc(Some(&shared.abbrev), &shared.name, &shared.prefix, &shared.values);
            writeln!(text, "static {kind}_{name}: EnumDesc = {body};\n").ok();
        }
        let title = if kind == "BITFIELDS" { "Bit fields" } else { "Enumerations" };
        writeln!(text, "/// {title} that several messages use.").ok();
        let list: Vec<String> =
            all.iter().map(|shared| format!("&{kind}_{}", names::screaming(&shared.abbrev))).collect();
        writeln!(text, "pub static {kind}: [&EnumDesc; {}] = [{}];\n", all.len(), list.join(", ")).ok();
    }
}

fn groups(text: &mut String, catalogue: &Catalogue) {
    writeln!(text, "/// Groups of messages that a field can ask for, with their members.").ok();
    writeln!(text, "pub static GROUPS: [(&str, &[&str]); {}] = [", catalogue.groups.len()).ok();
    for (name, members) in &catalogue.groups {
        writeln!(text, "    ({name:?}, &{members:?}),").ok();
    }
    text.push_str("];\n\n");
}

fn enum_desc(abbrev: Option<&str>, name: &str, prefix: &str, values: &[Label]) -> String {
    let mut body = format!("EnumDesc {{ abbrev: {abbrev:?}, name: {name:?}, prefix: {prefix:?}, values: &[");
    for (at, Label(value, abbrev, name)) in values.iter().enumerate() {
        let comma = if at == 0 { "" } else { ", " };
        write!(body, "{comma}Label {{ value: {value}, abbrev: {abbrev:?}, name: {name:?} }}").ok();
    }
    body.push_str("] }");
    body
}

fn message_table(text: &mut String, message: &Message) {
    let name = names::screaming(&message.abbrev);
    writeln!(text, "pub(crate) static {name}: MessageDesc = MessageDesc {{").ok();
    writeln!(text, "    id: {}, abbrev: {:?}, name: {:?},", message.id, message.abbrev, message.name).ok();
    writeln!(text, "    category: {:?}, summary: {:?},", message.category, message.summary).ok();
    writeln!(text, "    sources: &{:?}, flags: &{:?},", message.source, message.flags).ok();
    let widths: Option<usize> = message.fields.iter().map(|field| field.kind.width()).sum();
    writeln!(text, "    fixed_bytes: {widths:?}, runs: &[{}],", runs(message).join(", ")).ok();
    text.push_str("    fields: &[\n");
    for field in &message.fields {
        field_table(text, field);
    }
    text.push_str("    ],\n};\n\n");
}

/// Layout of the message's fields for skipping: adjacent fields of fixed size are one run.
fn runs(message: &Message) -> Vec<String> {
    let mut runs = Vec::new();
    let mut fixed = 0;
    for field in &message.fields {
        let run = match field.kind {
            Kind::Raw | Kind::Text => "Run::Counted",
            Kind::Message => "Run::Message",
            Kind::List => "Run::List",
            number => {
                fixed += number.width().unwrap_or_default();
                continue;
            }
        };
        if fixed > 0 {
            runs.push(format!("Run::Fixed({fixed})"));
            fixed = 0;
        }
        runs.push(run.to_owned());
    }
    if fixed > 0 {
        runs.push(format!("Run::Fixed({fixed})"));
    }
    runs
}

fn field_table(text: &mut String, field: &Field) {
    write!(text, "        FieldDesc {{ abbrev: {:?}, name: {:?}, ", field.abbrev, field.name).ok();
    write!(text, "kind: FieldKind::{}, unit: {:?}, ", field.kind.variant(), field.unit).ok();
    write!(text, "min: {:?}, max: {:?}, default: {:?}, ", field.min, field.max, field.default).ok();
    let prefix = field.prefix.as_deref().unwrap_or_default();
    let inline = |values: &[Label]| format!("&{}", enum_desc(None, &field.name, prefix, values));
    let meaning = match (&field.enum_def, &field.bitfield_def, &field.values, &field.bits) {
        (Some(def), ..) => format!("Meaning::Enumeration(&ENUMERATIONS_{})", names::screaming(def)),
        (_, Some(def), ..) => format!("Meaning::Bitfield(&BITFIELDS_{})", names::screaming(def)),
        (_, _, Some(values), _) => format!("Meaning::Enumeration({})", inline(values)),
        (_, _, _, Some(bits)) => format!("Meaning::Bitfield({})", inline(bits)),
        _ => "Meaning::Plain".to_owned(),
    };
    let (wanted, appended) = (&field.message_type, field.appended);
    writeln!(text, "meaning: {meaning}, message_type: {wanted:?}, appended: {appended} }},").ok();
}
