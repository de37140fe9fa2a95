//! The catalogue as XML, as stored beside each log so that other programs can read it.

use crate::catalogue::{
    BITFIELDS, ENUMERATIONS, EnumDesc, FieldDesc, FieldKind, GROUPS, MESSAGES, Meaning, MessageDesc, UNITS,
    VERSION,
};
use std::collections::BTreeSet;
use std::fmt::Write as _;

const HEADER: &str = r#"  <header>
    <description>Fields before the payload of every packet.</description>
    <field name="Synchronization Number" abbrev="sync" type="uint16_t" value="0xFE54" fixed="true"/>
    <field name="Message Identification Number" abbrev="mgid" type="uint16_t"/>
    <field name="Message size" abbrev="size" type="uint16_t" unit="byte"/>
    <field name="Time stamp" abbrev="timestamp" type="fp64_t" unit="s"/>
    <field name="Source Address" abbrev="src" type="uint16_t"/>
    <field name="Source Entity" abbrev="src_ent" type="uint8_t"/>
    <field name="Destination Address" abbrev="dst" type="uint16_t"/>
    <field name="Destination Entity" abbrev="dst_ent" type="uint8_t"/>
  </header>
  <footer>
    <field name="Check Sum (CRC-16-IBM)" abbrev="crc16" type="uint16_t"/>
  </footer>
"#;

const KINDS: [FieldKind; 13] = [
    FieldKind::I8,
    FieldKind::U8,
    FieldKind::I16,
    FieldKind::U16,
    FieldKind::I32,
    FieldKind::U32,
    FieldKind::I64,
    FieldKind::F32,
    FieldKind::F64,
    FieldKind::Raw,
    FieldKind::Text,
    FieldKind::Message,
    FieldKind::List,
];

/// The definitions of all messages that this crate writes, in the form of LSTS' `IMC.xml`.
pub fn definitions_xml() -> String {
    let mut xml = String::with_capacity(300_000);
    xml.push_str("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    line(
        &mut xml,
        0,
        "messages",
        &[("name", "IMC"), ("long-name", "Inter Module Communication"), ("version", VERSION)],
        false,
    );
    types(&mut xml);
    xml.push_str("  <units>\n");
    for (abbrev, name) in UNITS {
        line(&mut xml, 2, "unit", &[("abbrev", abbrev), ("name", name)], true);
    }
    xml.push_str("  </units>\n");
    for (tag, all, bits) in [("enumerations", &ENUMERATIONS[..], false), ("bitfields", &BITFIELDS[..], true)]
    {
        writeln!(xml, "  <{tag}>").ok();
        for desc in all {
            let abbrev = desc.abbrev.unwrap_or_default();
            let attributes = [("name", desc.name), ("abbrev", abbrev), ("prefix", desc.prefix)];
            line(&mut xml, 2, "def", &attributes, false);
            values(&mut xml, desc, bits);
            xml.push_str("    </def>\n");
        }
        writeln!(xml, "  </{tag}>").ok();
    }
    groups(&mut xml);
    xml.push_str(HEADER);
    xml.push_str("  <categories>\n");
    for category in MESSAGES.iter().map(|message| message.category).collect::<BTreeSet<_>>() {
        line(&mut xml, 2, "category", &[("name", category)], true);
    }
    xml.push_str("  </categories>\n");
    for desc in MESSAGES {
        message(&mut xml, desc);
    }
    xml.push_str("</messages>\n");
    xml
}

/// Some readers distinguish integers and reals by these words.
fn type_description(kind: FieldKind) -> &'static str {
    match kind {
        FieldKind::I8 | FieldKind::I16 | FieldKind::I32 | FieldKind::I64 => "signed integer",
        FieldKind::U8 | FieldKind::U16 | FieldKind::U32 => "unsigned integer",
        FieldKind::F32 | FieldKind::F64 => "IEEE 754 float",
        FieldKind::Raw => "uint16_t count of bytes, then the bytes",
        FieldKind::Text => "uint16_t count of bytes, then the text",
        FieldKind::Message => "uint16_t message id or 65535 for none, then the fields of the message",
        FieldKind::List => "uint16_t count of messages, then the messages",
    }
}

fn types(xml: &mut String) {
    xml.push_str("  <types>\n    <description>Types of fields.</description>\n");
    for kind in KINDS {
        let size = kind.width().map(|width| width.to_string());
        let mut attributes = vec![("name", kind.name())];
        attributes.extend(size.as_deref().map(|size| ("size", size)));
        line(xml, 2, "type", &attributes, false);
        writeln!(xml, "      <description>{}</description>\n    </type>", type_description(kind)).ok();
    }
    xml.push_str("  </types>\n  <serialization>\n");
    for kind in KINDS.iter().filter(|kind| kind.width().is_none()) {
        line(xml, 2, "type", &[("name", kind.name())], true);
    }
    xml.push_str("  </serialization>\n");
}

fn groups(xml: &mut String) {
    xml.push_str("  <message-groups>\n");
    for (name, members) in GROUPS {
        line(xml, 2, "message-group", &[("name", name), ("abbrev", name)], false);
        for member in members {
            line(xml, 3, "message-type", &[("abbrev", member)], true);
        }
        xml.push_str("    </message-group>\n");
    }
    xml.push_str("  </message-groups>\n  <flags>\n");
    line(xml, 2, "flag", &[("abbrev", "periodic"), ("name", "Periodic")], true);
    line(xml, 2, "flag", &[("abbrev", "deprecated"), ("name", "Deprecated")], true);
    xml.push_str("  </flags>\n");
}

fn message(xml: &mut String, desc: &MessageDesc) {
    let (id, source, flags) = (desc.id.to_string(), desc.sources.join(","), desc.flags.join(","));
    let mut attributes = vec![("id", id.as_str()), ("name", desc.name), ("abbrev", desc.abbrev)];
    attributes.extend(
        [("source", source.as_str()), ("flags", flags.as_str())].iter().filter(|(_, v)| !v.is_empty()),
    );
    attributes.push(("category", desc.category));
    line(xml, 1, "message", &attributes, false);
    if let Some(summary) = desc.summary {
        xml.push_str("    <description>");
        escape(xml, summary);
        xml.push_str("</description>\n");
    }
    for field in desc.fields {
        field_element(xml, field);
    }
    xml.push_str("  </message>\n");
}

fn field_element(xml: &mut String, desc: &FieldDesc) {
    let number = |value: Option<f64>| value.map(|value| value.to_string());
    let (min, max, default) = (number(desc.min), number(desc.max), number(desc.default));
    let (named, bits) = match desc.meaning {
        Meaning::Plain => (None, false),
        Meaning::Enumeration(values) => (Some(values), false),
        Meaning::Bitfield(values) => (Some(values), true),
    };
    let inline = named.filter(|values| values.abbrev.is_none());
    let shared = named.and_then(|values| values.abbrev);
    let attributes = [
        ("name", Some(desc.name)),
        ("abbrev", Some(desc.abbrev)),
        ("type", Some(desc.kind.name())),
        (if bits { "bitfield-def" } else { "enum-def" }, shared),
        ("unit", desc.unit),
        ("prefix", inline.map(|values| values.prefix).filter(|prefix| !prefix.is_empty())),
        ("message-type", desc.message_type),
        ("min", min.as_deref()),
        ("max", max.as_deref()),
        ("value", default.as_deref()),
    ];
    let given: Vec<(&str, &str)> =
        attributes.into_iter().filter_map(|(name, value)| Some((name, value?))).collect();
    line(xml, 2, "field", &given, inline.is_none());
    if let Some(desc) = inline {
        values(xml, desc, bits);
        xml.push_str("    </field>\n");
    }
}

fn values(xml: &mut String, desc: &EnumDesc, bits: bool) {
    for label in desc.values {
        let id = if bits { format!("{:#04x}", label.value) } else { label.value.to_string() };
        line(xml, 3, "value", &[("id", &id), ("name", label.name), ("abbrev", label.abbrev)], true);
    }
}

/// One tag on one line.
fn line(xml: &mut String, depth: usize, tag: &str, attributes: &[(&str, &str)], closed: bool) {
    write!(xml, "{:1$}<{tag}", "", depth * 2).ok();
    for (name, value) in attributes {
        write!(xml, " {name}=\"").ok();
        escape(xml, value);
        xml.push('"');
    }
    xml.push_str(if closed { "/>\n" } else { ">\n" });
}

fn escape(xml: &mut String, text: &str) {
    for letter in text.chars() {
        match letter {
            '&' => xml.push_str("&amp;"),
            '<' => xml.push_str("&lt;"),
            '"' => xml.push_str("&quot;"),
            letter => xml.push(letter),
        }
    }
}
