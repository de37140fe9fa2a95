//! The Thelma Biotel hydrophone: one line of output for each of its lines.

use super::{Decoder, Found};
use devices::tbr::{DamagedLine, Framer, Heard, Line, SET_AFTER_S};
use devices::{TagReading, WaterReading};
use serde_json::json;
use units::UtcTime;

/// Reads the receiver's lines.
#[derive(Debug, Default)]
pub(crate) struct Tbr {
    framer: Framer,
}

impl Decoder for Tbr {
    fn feed(&mut self, bytes: &[u8], found: &mut Vec<Found>) {
        self.framer.feed(bytes, |offset, read| found.push(shown(offset, read)));
    }

    fn end(&mut self, found: &mut Vec<Found>) {
        self.framer.end(|offset, read| found.push(shown(offset, read)));
    }
}

fn shown(offset: u64, read: Result<Heard, DamagedLine>) -> Found {
    match read.map(|heard| heard.line) {
        Ok(Line::Tag(tag)) => detection(&tag),
        Ok(Line::Water(water)) => sensor(&water),
        Ok(Line::Ack(ack)) => reply(ack.text()),
        Ok(Line::Reply(text)) => reply(&text),
        Err(error) => Found::damaged(&error, offset),
    }
}

fn detection(tag: &TagReading) -> Found {
    let TagReading { serial, clock_s, millis, protocol, tag_id, data, snr_db, frequency_khz, .. } = tag;
    let json = json!({
        "kind": "detection",
        "serial": serial,
        "utc_s": clock_s,
        "ms": millis,
        "protocol": protocol,
        "id": tag_id,
        "data": data,
        "snr": snr_db,
        "freq_khz": frequency_khz,
    });
    let carried = data.map_or_else(|| "no data".to_owned(), |data| format!("data {data}"));
    let text = format!(
        "{}, receiver {serial}: tag {protocol} {tag_id}, {carried}, SNR {snr_db} dB, {frequency_khz} kHz",
        time(*clock_s, *millis)
    );
    Found { json, text }
}

fn sensor(water: &WaterReading) -> Found {
    let WaterReading { serial, clock_s, temperature_c, noise_average, noise_peak, frequency_khz, .. } = water;
    let json = json!({
        "kind": "sensor",
        "serial": serial,
        "utc_s": clock_s,
        "temperature_c": temperature_c,
        "noise_avg": noise_average,
        "noise_peak": noise_peak,
        "freq_khz": frequency_khz,
    });
    let text = format!(
        "{}, receiver {serial}: water {temperature_c:.1} °C, noise {noise_average}, peak {noise_peak}, {frequency_khz} kHz",
        time(*clock_s, 0)
    );
    Found { json, text }
}

fn reply(text: &str) -> Found {
    Found { json: json!({"kind": "reply", "text": text}), text: format!("answer: {text}") }
}

/// The receiver's clock for people.
fn time(clock_s: u32, millis: u16) -> String {
    if clock_s < SET_AFTER_S {
        return format!("{clock_s}.{millis:03} s since power-up (clock not set)");
    }
    UtcTime::from_micros((i64::from(clock_s) * 1000 + i64::from(millis)) * 1000).to_string()
}
