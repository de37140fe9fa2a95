//! A receiver whose lines a pattern declares: one line for each detection.

use super::{Decoder, Found};
use devices::TagReading;
use devices::lines::{Lines, Piece};
use devices::pattern::{LONGEST, Pattern};
use serde_json::json;
use units::UtcTime;

/// Reads declared lines.
#[derive(Debug)]
pub(crate) struct Declared {
    lines: Lines,
    pattern: Pattern,
}

impl Declared {
    pub(crate) const fn new(pattern: Pattern) -> Self {
        Self { lines: Lines::new(None, LONGEST), pattern }
    }
}

impl Decoder for Declared {
    fn feed(&mut self, bytes: &[u8], found: &mut Vec<Found>) {
        let pattern = &self.pattern;
        self.lines.feed(bytes, |offset, piece| found.extend(shown(pattern, offset, piece)));
    }

    fn end(&mut self, found: &mut Vec<Found>) {
        let pattern = &self.pattern;
        self.lines.end(|offset, piece| found.extend(shown(pattern, offset, piece)));
    }
}

fn shown(pattern: &Pattern, offset: u64, piece: Piece<'_>) -> Option<Found> {
    match piece {
        Piece::Line(text) | Piece::Cut(text) if text.trim_ascii().is_empty() => None,
        Piece::Line(text) | Piece::Cut(text) => Some(match pattern.read(text) {
            Ok(tag) => heard(pattern, &tag),
            Err(error) => Found::damaged(&error, offset),
        }),
        Piece::TooLong => {
            Some(Found::damaged(&format!("longer than {LONGEST} bytes without a line end"), offset))
        }
    }
}

/// A detection with the keys of the hydrophone's, without those that the pattern does not declare, and the line as it came.
fn heard(pattern: &Pattern, tag: &TagReading) -> Found {
    let mut json = json!({
        "kind": "detection",
        "serial": tag.serial,
        "utc_s": tag.clock_s,
        "ms": tag.millis,
        "protocol": tag.protocol,
        "id": tag.tag_id,
        "data": tag.data,
        "snr": tag.snr_db,
        "freq_khz": tag.frequency_khz,
        "raw": tag.raw,
    });
    if let Some(object) = json.as_object_mut() {
        object.retain(|key, _| match key.as_str() {
            "serial" | "protocol" => pattern.declares(key),
            "snr" => pattern.declares("snr_db"),
            "freq_khz" => pattern.declares("khz") || pattern.declares("hz"),
            _ => true,
        });
    }
    let time = UtcTime::from_micros((i64::from(tag.clock_s) * 1000 + i64::from(tag.millis)) * 1000);
    let data = tag.data.map_or_else(|| "no data".to_owned(), |data| format!("data {data}"));
    let text = format!("{time}, receiver {}: tag {} {}, {data}", tag.serial, tag.protocol, tag.tag_id);
    Found { json, text }
}
