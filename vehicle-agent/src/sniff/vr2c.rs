//! Innovasea's receivers VR2C and Rx-LIVE: one line of output for each of theirs.

use super::{Decoder, Found};
use devices::vr2c::{DamagedLine, Detection, Framer, Line, Status};
use serde_json::json;
use units::UtcTime;

/// Reads the receivers' lines.
#[derive(Debug, Default)]
pub(crate) struct Vr2c {
    framer: Framer,
}

impl Decoder for Vr2c {
    fn feed(&mut self, bytes: &[u8], found: &mut Vec<Found>) {
        self.framer.feed(bytes, |offset, read| found.push(shown(offset, read)));
    }

    fn end(&mut self, found: &mut Vec<Found>) {
        self.framer.end(|offset, read| found.push(shown(offset, read)));
    }
}

fn shown(offset: u64, read: Result<Line, DamagedLine>) -> Found {
    match read {
        Ok(Line::Tag(detection)) => heard(&detection),
        Ok(Line::Status(status)) => own(&status),
        Err(error) => Found::damaged(&error, offset),
    }
}

/// A detection with the keys of the hydrophone's; the SNR is absent where the receiver does not report levels.
fn heard(detection: &Detection) -> Found {
    let tag = &detection.tag;
    let mut json = json!({
        "kind": "detection",
        "serial": tag.serial,
        "utc_s": tag.clock_s,
        "ms": tag.millis,
        "protocol": tag.protocol,
        "id": tag.tag_id,
        "data": tag.data,
        "freq_khz": tag.frequency_khz,
    });
    let data = tag.data.map_or_else(|| "no data".to_owned(), |data| format!("data {data}"));
    let mut words = vec![
        UtcTime::from_micros((i64::from(tag.clock_s) * 1000 + i64::from(tag.millis)) * 1000).to_string(),
        format!("receiver {}: tag {} {}", tag.serial, tag.protocol, tag.tag_id),
        data,
    ];
    if detection.levels.is_some() {
        json["snr"] = tag.snr_db.into();
        words.push(format!("SNR {} dB", tag.snr_db));
    }
    let text = words.join(", ");
    Found { json, text }
}

fn own(status: &Status) -> Found {
    let Status { serial, sequence, utc, text } = status;
    let json = json!({"kind": "status", "serial": serial, "utc": utc.to_string(), "text": text});
    Found { json, text: format!("{utc}, receiver {serial}: status {sequence}: {text}") }
}
