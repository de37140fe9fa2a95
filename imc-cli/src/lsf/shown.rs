//! Packets on one line for people.

use super::names::sender;
use crate::style::plain;
use imc::PacketView;
use imc::names::Names;
use imc::reflect::{self, Field, Value};
use std::fmt::Write as _;
use units::UtcTime;

/// Bytes of raw data shown.
const RAW_SHOWN: usize = 16;

/// A header's time in ISO 8601, or as it is when it is not a time.
pub(crate) fn iso(seconds: f64) -> String {
    UtcTime::from_seconds(seconds).map_or_else(|| seconds.to_string(), |time| time.to_string())
}

/// Time, sender, message and fields: `2026-...Z ntnu-otter-01/GPS GpsFix validity=... lat=1.107 rad`.
pub(crate) fn line(view: &PacketView<'_>, names: &Names) -> String {
    let header = view.header();
    let sender = format!("{}/{}", names.system(header.src), sender(names, view));
    let message = view.desc().map_or("unknown message", |message| message.abbrev);
    let mut out = format!("{} {} {message}", iso(header.timestamp), plain(&sender));
    match reflect::fields(view) {
        None => write!(out, " {} ({} bytes)", view.id(), view.payload().len()).unwrap_or_default(),
        Some(Err(error)) => write!(out, " damaged: {error}").unwrap_or_default(),
        Some(Ok(fields)) => fields.iter().for_each(|field| append(&mut out, field)),
    }
    out
}

fn append(out: &mut String, field: &Field<'_>) {
    write!(out, " {}=", field.path).ok();
    // No bit set has no name.
    match (field.label().filter(|label| !label.is_empty()), field.value) {
        (Some(label), _) => out.push_str(&label),
        (None, Value::Integer(value)) => write!(out, "{value}").unwrap_or_default(),
        (None, Value::Single(value)) => write!(out, "{value}").unwrap_or_default(),
        (None, Value::Double(value)) => write!(out, "{value}").unwrap_or_default(),
        (None, Value::Text(text)) => {
            write!(out, "\"{}\"", plain(&imc::text::escape(text))).unwrap_or_default();
        }
        (None, Value::Raw(bytes)) => {
            let more = if bytes.len() > RAW_SHOWN { "..." } else { "" };
            write!(out, "{}{more}", hex::encode(&bytes[..bytes.len().min(RAW_SHOWN)])).unwrap_or_default();
        }
    }
}
