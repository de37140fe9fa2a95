//! One packet, or one piece of damage, as one line of JSON.
//!
//! A packet is as [`imc::json`] shows it. Damage is
//! `{"error":CLASS,"offset":N,"bytes":N,"message":TEXT}`: a stable word, the run of bad bytes (counted from the start of
//! the stream, of the packet on a hex line, or of the datagram) and a text for people. `line` and `from` are the line of
//! the hex text and the sender of the datagram. A packet whose frame is whole but whose fields cannot be read also has its
//! `id`, `header` and all its bytes in `packet`, so that `imc encode` can write it back; `field` and `field_offset` say
//! where reading it failed.

use imc::{Frame, PacketView, ShortPayload, json};
use std::io::Write as _;

/// Where in the input something was found.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Place<'a> {
    /// The first byte.
    pub(crate) offset: u64,
    /// The line of a hex text, from 1.
    pub(crate) line: Option<u64>,
    /// The sender of a datagram or message.
    pub(crate) from: Option<&'a str>,
}

/// Appends the line of a frame. Returns whether it is a packet that could be decoded.
pub(crate) fn frame(out: &mut Vec<u8>, frame: &Frame<'_>, place: Place<'_>, short: ShortPayload) -> bool {
    match frame {
        Frame::Packet { offset, view } => packet(out, view, Place { offset: *offset, ..place }, short),
        Frame::Damage(damage) => {
            let place = Place { offset: damage.offset, ..place };
            self::damage(out, damage.error.class(), damage.bytes, place, &damage.error.to_string());
            false
        }
    }
}

/// Appends the line of a packet. Returns whether it could be decoded.
pub(crate) fn packet(
    out: &mut Vec<u8>,
    view: &PacketView<'_>,
    place: Place<'_>,
    short: ShortPayload,
) -> bool {
    match json::write_packet(out, view, short) {
        Ok(()) => {
            out.push(b'\n');
            true
        }
        Err(error) => {
            undecodable(out, view, place, &error);
            false
        }
    }
}

/// Appends the line of bytes that are not a packet.
pub(crate) fn damage(out: &mut Vec<u8>, class: &str, bytes: u64, place: Place<'_>, message: &str) {
    open(out, class, bytes, place, message);
    out.extend_from_slice(b"}\n");
}

/// Appends the line of a whole packet with `excess` behind it; all its bytes are shown where they are known.
pub(crate) fn excess(
    out: &mut Vec<u8>,
    view: &PacketView<'_>,
    excess: Option<&[u8]>,
    bytes: u64,
    place: Place<'_>,
) {
    let message = format!("{bytes} bytes follow a whole packet of {} on its line", view.bytes().len());
    let place = Place { offset: view.bytes().len() as u64, ..place };
    open(out, "excess_bytes", bytes, place, &message);
    if let Some(excess) = excess {
        whole(out, view);
        write!(out, r#","excess":"{}""#, hex::encode(excess)).ok();
    }
    out.extend_from_slice(b"}\n");
}

/// Appends the line that says where decompression failed.
pub(crate) fn bad_gzip(out: &mut Vec<u8>, offset: u64, line: Option<u64>, problem: &str) {
    let message =
        format!("the gzip'd input is cut or damaged, nothing after this can be unpacked: {problem}");
    damage(out, "bad_gzip", 0, Place { offset, line, from: None }, &message);
}

fn undecodable(out: &mut Vec<u8>, view: &PacketView<'_>, place: Place<'_>, error: &json::WriteError) {
    open(out, error.class(), view.bytes().len() as u64, place, &error.to_string());
    if let json::WriteError::Payload { message, error, .. } = error {
        write!(out, r#","abbrev":"{message}","field":"#).ok();
        json::write_text(out, error.path.as_bytes());
        write!(out, r#","field_offset":{}"#, error.offset).ok();
    }
    whole(out, view);
    out.extend_from_slice(b"}\n");
}

fn open(out: &mut Vec<u8>, class: &str, bytes: u64, place: Place<'_>, message: &str) {
    write!(out, r#"{{"error":"{class}","offset":{},"bytes":{bytes}"#, place.offset).ok();
    if let Some(line) = place.line {
        write!(out, r#","line":{line}"#).ok();
    }
    if let Some(from) = place.from {
        out.extend_from_slice(br#","from":"#);
        json::write_text(out, from.as_bytes());
    }
    out.extend_from_slice(br#","message":"#);
    json::write_text(out, message.as_bytes());
}

/// Id and header of a packet, and all its bytes.
fn whole(out: &mut Vec<u8>, view: &PacketView<'_>) {
    write!(out, r#","id":{},"header":"#, view.id()).ok();
    json::write_header(out, &view.header());
    write!(out, r#","packet":"{}""#, hex::encode(view.bytes())).ok();
}
