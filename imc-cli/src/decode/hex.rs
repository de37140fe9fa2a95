//! Hex text: one packet a line, and one line out for each line in.

use crate::input::{CHUNK, Input};
use crate::outcome::Outcome;
use crate::output::Output;
use crate::record::{self, Place};
use anyhow::Context as _;
use imc::{FrameError, MAX_PACKET_BYTES, PacketView, ShortPayload};
use std::io::{self, Read as _, Write as _};

/// Bytes examined to distinguish hex text from packets.
const LOOK: usize = 512;
/// Bytes of a line that are kept; of a longer line the rest is only counted.
const KEPT: usize = 2 * MAX_PACKET_BYTES;

/// Whether the input is hex text: it begins with a sync number in digits, or has only digits.
///
/// Packets cannot be taken for text, because neither byte of the sync number is a digit or a space.
pub(super) fn looks_like_text(input: &mut Input) -> anyhow::Result<bool> {
    let is_text = |byte: &u8| byte.is_ascii_hexdigit() || byte.is_ascii_whitespace();
    let decided = |head: &[u8]| {
        let text = head.trim_ascii_start();
        head.len() >= LOOK || text.len() >= 4 && text.contains(&b'\n') || !head.iter().all(is_text)
    };
    let text = input.peek(decided)?.trim_ascii_start();
    let starts_with_sync = text
        .get(..4)
        .is_some_and(|digits| digits.eq_ignore_ascii_case(b"54fe") || digits.eq_ignore_ascii_case(b"fe54"));
    let first_line = text.split(|&byte| byte == b'\n').next().unwrap_or_default();
    Ok(starts_with_sync || !text.is_empty() && first_line.iter().all(is_text))
}

/// Prints one line for each line.
pub(super) fn decode(input: &mut Input, out: &mut Output, short: ShortPayload) -> anyhow::Result<Outcome> {
    let mut text = Text { line: Line::default(), number: 1, short, damaged: false };
    let mut chunk = vec![0; CHUNK];
    let mut at = 0;
    loop {
        match input.read(&mut chunk) {
            Ok(0) => break,
            Ok(count) => {
                at += count as u64;
                text.push(&chunk[..count], out)?;
                out.flush()?;
            }
            Err(error) if error.kind() == io::ErrorKind::Interrupted => {}
            Err(error) if input.is_damage(&error) => {
                text.end(out)?;
                let mut line = Vec::new();
                record::bad_gzip(&mut line, at, Some(text.number), &error.to_string());
                out.write_all(&line)?;
                return Ok(Outcome::Damaged);
            }
            Err(error) => {
                let (name, line) = (input.name(), text.number);
                return Err(error).with_context(|| format!("cannot read {name} at line {line}, byte {at}"));
            }
        }
    }
    text.end(out)?;
    Ok(Outcome::damaged_if(text.damaged))
}

struct Text {
    line: Line,
    number: u64,
    short: ShortPayload,
    damaged: bool,
}

impl Text {
    fn push(&mut self, text: &[u8], out: &mut Output) -> io::Result<()> {
        for &byte in text {
            if byte == b'\n' {
                self.print(out)?;
            } else {
                self.line.push(byte);
            }
        }
        Ok(())
    }

    /// Prints the last line when no line end follows it.
    fn end(&mut self, out: &mut Output) -> io::Result<()> {
        if self.line.chars > 0 { self.print(out) } else { Ok(()) }
    }

    fn print(&mut self, out: &mut Output) -> io::Result<()> {
        let mut shown = Vec::new();
        self.damaged |= !self.line.show(&mut shown, self.number, self.short);
        self.line.clear();
        self.number += 1;
        out.write_all(&shown)
    }
}

/// The part of a line read so far.
#[derive(Debug, Default)]
struct Line {
    /// Characters of any kind.
    chars: u64,
    /// Characters that are no spaces.
    marks: u64,
    digits: u64,
    bytes: Vec<u8>,
    /// The first half of a byte.
    high: Option<u8>,
    /// The first character that is no digit: its column from 1, itself, and the digits before it.
    wrong: Option<(u64, u8, u64)>,
}

impl Line {
    fn push(&mut self, byte: u8) {
        self.chars += 1;
        self.marks += u64::from(!byte.is_ascii_whitespace());
        let Some(nibble) = char::from(byte).to_digit(16) else {
            if !byte.is_ascii_whitespace() {
                self.wrong.get_or_insert((self.chars, byte, self.digits));
            }
            return;
        };
        self.digits += 1;
        let nibble = nibble as u8;
        match self.high.take() {
            None => self.high = Some(nibble),
            Some(high) if self.bytes.len() < KEPT => self.bytes.push(high << 4 | nibble),
            Some(_) => {}
        }
    }

    fn clear(&mut self) {
        self.bytes.clear();
        *self = Self { bytes: std::mem::take(&mut self.bytes), ..Self::default() };
    }

    /// Appends the decoded line. Returns whether it is a packet that could be decoded.
    fn show(&self, out: &mut Vec<u8>, number: u64, short: ShortPayload) -> bool {
        let place = Place { line: Some(number), ..Place::default() };
        if let Some((offset, message)) = self.bad_hex() {
            let bytes = self.marks.div_ceil(2) - offset;
            record::damage(out, "bad_hex", bytes, Place { offset, ..place }, &message);
            return false;
        }
        let bytes = self.digits / 2;
        let error = match PacketView::new(&self.bytes) {
            Ok(view) if view.bytes().len() as u64 == bytes => {
                return record::packet(out, &view, place, short);
            }
            Ok(view) => {
                let rest = &self.bytes[view.bytes().len()..];
                let kept = (self.bytes.len() as u64 == bytes).then_some(rest);
                record::excess(out, &view, kept, bytes - view.bytes().len() as u64, place);
                return false;
            }
            Err(error) => error,
        };
        let message = match error {
            FrameError::Truncated { .. } if bytes == 0 => "the line is empty".to_owned(),
            error => error.to_string(),
        };
        record::damage(out, error.class(), bytes, place, &message);
        false
    }

    /// The byte where the line stops being hex text, and why.
    fn bad_hex(&self) -> Option<(u64, String)> {
        if let Some((column, byte, digits)) = self.wrong {
            let shown = byte.escape_ascii();
            return Some((digits / 2, format!("`{shown}` in column {column} is not a hexadecimal digit")));
        }
        self.high?;
        Some((self.digits / 2, format!("{} digits: half a byte is missing at the end", self.digits)))
    }
}
