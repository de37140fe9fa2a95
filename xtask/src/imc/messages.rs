//! Structs, enumerations and bit fields: one file per category, and the `Message` enum over all of them.

use super::catalogue::{Catalogue, Field, Kind, Label, Message, Shared};
use super::{File, banner, names};
use std::fmt::Write as _;

const FOLDER: &str = "crates/imc/src/messages";

pub(super) fn files(catalogue: &Catalogue) -> Vec<File> {
    let mut files = vec![module(catalogue), shared(catalogue)];
    for category in &catalogue.categories {
        let messages: Vec<&Message> =
            catalogue.messages.iter().filter(|message| message.category == *category).collect();
        if !messages.is_empty() {
            files.push(category_file(category, &messages));
        }
    }
    files
}

/// `messages/mod.rs`: the modules and the enum over all messages.
fn module(catalogue: &Catalogue) -> File {
    let mut text = banner("The messages of the catalogue.");
    let mut used: Vec<&String> = catalogue.messages.iter().map(|message| &message.category).collect();
    used.sort();
    used.dedup();
    text.push_str("#[macro_use]\nmod payload;\n");
    for category in &used {
        writeln!(text, "mod {};", names::snake(category)).ok();
    }
    text.push_str("mod shared;\n\n");
    for category in &used {
        writeln!(text, "pub use {}::*;", names::snake(category)).ok();
    }
    text.push_str("pub use payload::Payload;\npub use shared::*;\n\n");
    text.push_str("use crate::catalogue::MessageDesc;\nuse crate::wire::{Fault, Reader, Writer};\n\n");
    text.push_str(
        "/// Any message of the catalogue.\n#[derive(Debug, Clone, PartialEq)]\n#[non_exhaustive]\n",
    );
    text.push_str("pub enum Message {\n");
    for message in &catalogue.messages {
        writeln!(text, "    /// {}", headline(message)).ok();
        writeln!(text, "    {0}(Box<{0}>),", message.abbrev).ok();
    }
    text.push_str("}\n\nimpl Message {\n");
    text.push_str("    /// What the catalogue says of this message.\n");
    text.push_str("    pub fn desc(&self) -> &'static MessageDesc {\n        match self {\n");
    for message in &catalogue.messages {
        writeln!(text, "            Self::{0}(_) => {0}::DESC,", message.abbrev).ok();
    }
    text.push_str("        }\n    }\n\n");
    text.push_str("    /// Reads the fields of message `id`; `None` when the catalogue has no such id.\n");
    text.push_str("    pub(crate) fn read(id: u16, r: &mut Reader<'_>) -> Option<Result<Self, Fault>> {\n");
    text.push_str("        Some(match id {\n");
    for message in &catalogue.messages {
        writeln!(text, "            {} => {}::read(r).map(Self::from),", message.id, message.abbrev).ok();
    }
    text.push_str("            _ => return None,\n        })\n    }\n\n");
    text.push_str("    pub(crate) fn write(&self, w: &mut Writer<'_>) {\n        match self {\n");
    for message in &catalogue.messages {
        writeln!(text, "            Self::{}(message) => message.write(w),", message.abbrev).ok();
    }
    text.push_str("        }\n    }\n}\n");
    File { path: format!("{FOLDER}/mod.rs"), text }
}

/// `messages/shared.rs`: enumerations and bit fields that several messages use.
fn shared(catalogue: &Catalogue) -> File {
    let mut text = banner("Enumerations and bit fields that several messages use.");
    let uses = |name: &str| {
        let mut fields = catalogue.messages.iter().flat_map(|message| &message.fields);
        fields
            .find(|field| [&field.enum_def, &field.bitfield_def].into_iter().flatten().any(|def| def == name))
    };
    let mut write = |shared: &Shared, emit: fn(&mut String, &str, &str, Kind, &[Label])| {
        if let Some(field) = uses(&shared.abbrev) {
            emit(&mut text, &shared.abbrev, &shared.name, field.kind, &shared.values);
        }
    };
    for enumeration in &catalogue.enumerations {
        write(enumeration, enumeration_type);
    }
    for bitfield in &catalogue.bitfields {
        write(bitfield, bitfield_type);
    }
    File { path: format!("{FOLDER}/shared.rs"), text: text.trim_end().to_owned() + "\n" }
}

fn category_file(category: &str, messages: &[&Message]) -> File {
    let mut text = banner(&format!("Messages of the category {category}."));
    let mut body = String::new();
    for message in messages {
        message_type(&mut body, message);
    }
    let uses = |name: &str| body.contains(name);
    if uses(": MessageList,") {
        text.push_str("use crate::list::MessageList;\n");
    }
    text.push_str("use crate::catalogue::{MessageDesc, tables};\n");
    text.push_str("use crate::messages::{Message, Payload};\n");
    if uses(": Nested,") {
        text.push_str("use crate::nested::Nested;\n");
    }
    if uses(": Text,") {
        text.push_str("use crate::text::Text;\n");
    }
    text.push_str("use crate::wire::{Fault, Reader, Writer};\n");
    for shared in ["Boolean", "CLoopsMask", "OpLimitsMask", "RSSIUnits", "SpeedUnits", "SystemType", "ZUnits"]
    {
        if uses(&format!(": {shared},")) {
            writeln!(text, "use crate::messages::shared::{shared};").ok();
        }
    }
    text.push('\n');
    text.push_str(body.trim_end());
    text.push('\n');
    File { path: format!("{FOLDER}/{}.rs", names::snake(category)), text }
}

/// Purpose of a message, or at least its name.
fn headline(message: &Message) -> String {
    message.summary.clone().unwrap_or_else(|| format!("{}.", message.name.trim_end_matches('.')))
}

/// The Rust type of a field.
fn rust_type(message: &Message, field: &Field) -> String {
    match field.kind {
        Kind::Raw => "Vec<u8>".to_owned(),
        Kind::Text => "Text".to_owned(),
        Kind::Message => "Nested".to_owned(),
        Kind::List => "MessageList".to_owned(),
        number => {
            if field.is_enumerated() || field.is_bitfield() {
                named_type(message, field)
            } else if field.appended {
                format!("Option<{}>", number.number())
            } else {
                number.number().to_owned()
            }
        }
    }
}

/// The type of an enumerated or bit field: the shared one or one of the field's own.
fn named_type(message: &Message, field: &Field) -> String {
    field
        .enum_def
        .clone()
        .or_else(|| field.bitfield_def.clone())
        .unwrap_or_else(|| format!("{}{}", message.abbrev, names::pascal(&field.abbrev)))
}

/// One message: its struct, its own enumerations and bit fields, and its encoding and decoding.
fn message_type(text: &mut String, message: &Message) {
    let abbrev = &message.abbrev;
    writeln!(text, "/// {}\n///\n/// {} ({}).", headline(message), message.name, message.id).ok();
    let defaults = message.fields.iter().any(|field| field.default.is_some_and(|value| value != 0.0));
    let derive = if defaults { "" } else { ", Default" };
    writeln!(text, "#[derive(Debug, Clone, PartialEq{derive})]").ok();
    if message.fields.is_empty() {
        writeln!(text, "pub struct {abbrev};\n").ok();
    } else {
        writeln!(text, "pub struct {abbrev} {{").ok();
        for field in &message.fields {
            writeln!(text, "    /// {}", field_doc(field)).ok();
            writeln!(text, "    pub {}: {},", names::field(&field.abbrev), rust_type(message, field)).ok();
        }
        text.push_str("}\n\n");
    }
    if defaults {
        default_impl(text, message);
    }
    payload_impl(text, message);
    for field in &message.fields {
        if field.enum_def.is_some() || field.bitfield_def.is_some() {
            continue;
        }
        let name = named_type(message, field);
        let title = format!("Values of `{}.{}`.", message.abbrev, field.abbrev);
        if field.is_enumerated() {
            enumeration_type(text, &name, &title, field.kind, field.values.as_deref().unwrap_or_default());
        } else if field.is_bitfield() {
            bitfield_type(text, &name, &title, field.kind, field.bits.as_deref().unwrap_or_default());
        }
    }
}

/// Name, unit and advised range of a field.
fn field_doc(field: &Field) -> String {
    let mut doc = field.name.clone();
    match field.unit.as_deref() {
        None | Some("Enumerated" | "Bitfield") => {}
        Some("TupleList") => doc.push_str(", `Name=value;...`"),
        Some("List") => doc.push_str(", a list"),
        Some(unit) => write!(doc, " ({unit})").unwrap_or_default(),
    }
    match (field.min, field.max) {
        (Some(min), Some(max)) => write!(doc, ", {min} to {max}").unwrap_or_default(),
        (Some(min), None) => write!(doc, ", at least {min}").unwrap_or_default(),
        (None, Some(max)) => write!(doc, ", at most {max}").unwrap_or_default(),
        (None, None) => {}
    }
    if let Some(wanted) = &field.message_type {
        write!(doc, ", of `{wanted}`").ok();
    }
    if field.appended {
        doc.push_str("; absent from older senders");
    }
    doc.push('.');
    doc
}

fn default_impl(text: &mut String, message: &Message) {
    writeln!(text, "impl Default for {} {{\n    fn default() -> Self {{\n        Self {{", message.abbrev)
        .ok();
    for field in &message.fields {
        let value = match field.default.filter(|value| *value != 0.0) {
            Some(value) if matches!(field.kind, Kind::F32 | Kind::F64) => format!("{value:?}"),
            Some(value) => format!("{value}"),
            None => "Default::default()".to_owned(),
        };
        writeln!(text, "            {}: {value},", names::field(&field.abbrev)).ok();
    }
    text.push_str("        }\n    }\n}\n\n");
}

/// A run of fields that is read or written at once.
enum Step<'a> {
    Fixed { fields: Vec<(&'a Field, usize)>, bytes: usize },
    Single(&'a Field),
}

fn steps(message: &Message) -> Vec<Step<'_>> {
    let mut steps: Vec<Step<'_>> = Vec::new();
    for field in &message.fields {
        let width = field.kind.width().filter(|_| !field.appended);
        match (width, steps.last_mut()) {
            (Some(width), Some(Step::Fixed { fields, bytes })) => {
                fields.push((field, *bytes));
                *bytes += width;
            }
            (Some(width), _) => steps.push(Step::Fixed { fields: vec![(field, 0)], bytes: width }),
            (None, _) => steps.push(Step::Single(field)),
        }
    }
    steps
}

fn payload_impl(text: &mut String, message: &Message) {
    let abbrev = &message.abbrev;
    let table = names::screaming(abbrev);
    writeln!(text, "impl Payload for {abbrev} {{").ok();
    writeln!(text, "    const ID: u16 = {};", message.id).ok();
    writeln!(text, "    const DESC: &'static MessageDesc = &tables::{table};\n").ok();
    read_fn(text, message);
    write_fn(text, message);
    writeln!(text, "    fn of(message: &Message) -> Option<&Self> {{").ok();
    writeln!(text, "        if let Message::{abbrev}(message) = message {{ Some(message) }} else {{ None }}")
        .ok();
    text.push_str("    }\n}\n\n");
    writeln!(text, "impl From<{abbrev}> for Message {{\n    fn from(message: {abbrev}) -> Self {{").ok();
    writeln!(text, "        Self::{abbrev}(Box::new(message))\n    }}\n}}\n").ok();
}

fn read_fn(text: &mut String, message: &Message) {
    if message.fields.is_empty() {
        text.push_str(
            "    fn read(_: &mut Reader<'_>) -> Result<Self, Fault> {\n        Ok(Self)\n    }\n\n",
        );
        return;
    }
    text.push_str("    #[inline]\n    fn read(r: &mut Reader<'_>) -> Result<Self, Fault> {\n");
    let steps = steps(message);
    if let [Step::Fixed { fields, bytes }] = steps.as_slice() {
        writeln!(text, "        let b = r.fixed::<{bytes}>()?;\n        Ok(Self {{").ok();
        for (field, at) in fields {
            let value = from_number(message, field, &format!("b.{}({at})", field.kind.number()));
            writeln!(text, "            {}: {value},", names::field(&field.abbrev)).ok();
        }
        text.push_str("        })\n    }\n\n");
        return;
    }
    for (at, step) in steps.iter().enumerate() {
        match step {
            Step::Fixed { bytes, .. } => writeln!(text, "        let b{at} = r.fixed::<{bytes}>()?;"),
            Step::Single(field) => {
                let name = names::field(&field.abbrev);
                let read = match field.kind {
                    Kind::Raw => "r.raw()?".to_owned(),
                    Kind::Text => "r.text()?".to_owned(),
                    Kind::Message => "r.message()?".to_owned(),
                    Kind::List => "r.list()?".to_owned(),
                    number => format!(
                        "if r.ended() {{ None }} else {{ Some(r.fixed::<{}>()?.{}(0)) }}",
                        number.width().unwrap_or_default(),
                        number.number()
                    ),
                };
                writeln!(text, "        let {name} = {read};")
            }
        }
        .ok();
    }
    text.push_str("        Ok(Self {\n");
    for (at, step) in steps.iter().enumerate() {
        match step {
            Step::Fixed { fields, .. } => {
                for (field, offset) in fields {
                    let value =
                        from_number(message, field, &format!("b{at}.{}({offset})", field.kind.number()));
                    writeln!(text, "            {}: {value},", names::field(&field.abbrev)).ok();
                }
            }
            Step::Single(field) => {
                writeln!(text, "            {},", names::field(&field.abbrev)).ok();
            }
        }
    }
    text.push_str("        })\n    }\n\n");
}

fn write_fn(text: &mut String, message: &Message) {
    if message.fields.is_empty() {
        text.push_str("    fn write(&self, _: &mut Writer<'_>) {}\n\n");
        return;
    }
    text.push_str("    #[inline]\n    fn write(&self, w: &mut Writer<'_>) {\n");
    for step in steps(message) {
        match step {
            Step::Fixed { fields, bytes } => {
                writeln!(text, "        let mut b = w.fixed::<{bytes}>();").ok();
                for (field, at) in fields {
                    let value = to_number(field);
                    writeln!(text, "        b.{}({at}, {value});", field.kind.number()).ok();
                }
                text.push_str("        w.put(&b);\n");
            }
            Step::Single(field) => {
                let name = names::field(&field.abbrev);
                match field.kind {
                    Kind::Raw => writeln!(text, "        w.raw(&self.{name});").ok(),
                    Kind::Text => writeln!(text, "        w.text(&self.{name});").ok(),
                    Kind::Message => writeln!(text, "        w.message(&self.{name});").ok(),
                    Kind::List => writeln!(text, "        w.list(&self.{name});").ok(),
                    number => {
                        let later = appended_from(message, field);
                        writeln!(text, "        if w.nested() || {later} {{").ok();
                        let width = number.width().unwrap_or_default();
                        writeln!(text, "            let mut b = w.fixed::<{width}>();").ok();
                        let kind = number.number();
                        writeln!(text, "            b.{kind}(0, self.{name}.unwrap_or({kind}::NAN));").ok();
                        text.push_str("            w.put(&b);\n        }\n");
                        Some(())
                    }
                };
            }
        }
    }
    text.push_str("    }\n\n");
}

/// The condition that an appended field or one after it is there, so that it has to be written.
fn appended_from(message: &Message, field: &Field) -> String {
    message
        .fields
        .iter()
        .skip_while(|other| other.abbrev != field.abbrev)
        .map(|other| format!("self.{}.is_some()", names::field(&other.abbrev)))
        .collect::<Vec<_>>()
        .join(" || ")
}

fn from_number(message: &Message, field: &Field, number: &str) -> String {
    if field.is_enumerated() {
        format!("{}::from({number})", named_type(message, field))
    } else if field.is_bitfield() {
        format!("{}::from_bits_retain({number})", named_type(message, field))
    } else {
        number.to_owned()
    }
}

fn to_number(field: &Field) -> String {
    let name = names::field(&field.abbrev);
    if field.is_enumerated() {
        format!("self.{name}.value()")
    } else if field.is_bitfield() {
        format!("self.{name}.bits()")
    } else {
        format!("self.{name}")
    }
}

fn enumeration_type(text: &mut String, name: &str, title: &str, kind: Kind, values: &[Label]) {
    writeln!(text, "wire_enum! {{\n    /// {title}\n    pub enum {name}: {} {{", kind.number()).ok();
    for Label(value, abbrev, label) in values {
        writeln!(text, "        /// {label}.\n        {} = {value},", names::pascal(abbrev)).ok();
    }
    text.push_str("    }\n}\n\n");
}

fn bitfield_type(text: &mut String, name: &str, title: &str, kind: Kind, bits: &[Label]) {
    writeln!(text, "bitflags::bitflags! {{\n    /// {title}").ok();
    text.push_str("    #[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, Default)]\n");
    writeln!(text, "    pub struct {name}: {} {{", kind.number()).ok();
    for Label(value, abbrev, label) in bits {
        let constant = names::constant(abbrev);
        writeln!(text, "        /// {label}.\n        const {constant} = {value:#x};").ok();
    }
    text.push_str("    }\n}\n\n");
}
