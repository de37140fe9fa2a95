//! Messages that each matter: tags that were heard, and what the log book says.

use super::{Cell, Reader, Row, Source};
use crate::error::Result;
use crate::range::TimeRange;
use imc::Address;
use units::UtcTime;

const DETECTION_FIELDS: [&str; 11] = [
    "serial_no",
    "unix_timestamp",
    "millis",
    "trans_protocol",
    "trans_id",
    "trans_data",
    "SNR",
    "trans_freq",
    "recv_mem_addr",
    "lat",
    "lon",
];
const LOG_FIELDS: [&str; 4] = ["type", "htime", "context", "text"];

/// A tag that a receiver heard.
#[derive(Debug, Clone, PartialEq)]
pub struct Detection {
    /// The vessel that carried the receiver.
    pub system: Address,
    /// The entity that reported it.
    pub entity: u8,
    /// When the vessel reported it.
    pub reported: UtcTime,
    /// When the receiver heard it, by the receiver's clock, to the millisecond.
    pub heard: UtcTime,
    /// When it first came ashore.
    pub received: UtcTime,
    /// Serial number of the receiver.
    pub serial_no: i64,
    /// Number of the protocol, by IMC's enumeration.
    pub protocol: i64,
    /// Name of the protocol, such as `R64K`.
    pub protocol_name: Option<String>,
    /// The tag's number.
    pub tag_id: i64,
    /// The tag's measurement as it was sent.
    pub data: i64,
    /// Signal to noise ratio (dB).
    pub snr_db: i64,
    /// Frequency (kHz).
    pub frequency_khz: i64,
    /// Place in the receiver's memory.
    pub memory_address: i64,
    /// Where the vessel was (degrees); `None` for messages of 2019, which have no position.
    pub place_deg: Option<(f64, f64)>,
}

/// An entry of a vessel's log book.
#[derive(Debug, Clone, PartialEq)]
pub struct LogEntry {
    /// The vessel.
    pub system: Address,
    /// The entity that wrote it.
    pub entity: u8,
    /// When it was sent.
    pub sent: UtcTime,
    /// When it was written.
    pub written: Option<UtcTime>,
    /// How serious it is, by IMC's enumeration: 0 information, 1 warning, 2 error, 3 critical, 4 debug.
    pub kind: i64,
    /// The name of that.
    pub kind_name: Option<String>,
    /// The part of the vessel's program.
    pub context: String,
    /// What it says.
    pub text: String,
}

impl Reader {
    /// The tags heard in a range, by when they were reported, at most `limit`; of one system or of all.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn detections(
        &mut self,
        system: Option<Address>,
        range: TimeRange,
        limit: usize,
    ) -> Result<Vec<Detection>> {
        let protocols = imc::catalogue::by_abbrev("TBRFishTag").and_then(|desc| desc.field("trans_protocol"));
        let detection = |(source, row): (Source, Row)| {
            let integer = |at: usize| match row.cells[at] {
                Cell::Integer(value) => value,
                _ => 0,
            };
            let degrees = |at: usize| row.cells[at].as_f64().map(f64::to_degrees);
            Detection {
                system: source.system,
                entity: source.entity,
                reported: row.time,
                heard: UtcTime::from_micros(integer(1) * 1_000_000 + integer(2) * 1_000),
                received: row.received,
                serial_no: integer(0),
                protocol: integer(3),
                protocol_name: protocols.and_then(|field| field.label(integer(3))),
                tag_id: integer(4),
                data: integer(5),
                snr_db: integer(6),
                frequency_khz: integer(7),
                memory_address: integer(8),
                place_deg: degrees(9).zip(degrees(10)),
            }
        };
        let rows = self.events("TBRFishTag", &DETECTION_FIELDS, system, range, limit)?;
        Ok(rows.into_iter().map(detection).collect())
    }

    /// The log books' entries in a range, by when they were sent, at most `limit`; of one system or of all.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn log_book(
        &mut self,
        system: Option<Address>,
        range: TimeRange,
        limit: usize,
    ) -> Result<Vec<LogEntry>> {
        let kinds = imc::catalogue::by_abbrev("LogBookEntry").and_then(|desc| desc.field("type"));
        let entry = |(source, row): (Source, Row)| {
            let kind = row.cells[0].as_f64().unwrap_or_default() as i64;
            let text = |at: usize| match &row.cells[at] {
                Cell::Text(text) => text.clone(),
                Cell::Raw(bytes) => String::from_utf8_lossy(bytes).into_owned(),
                Cell::Nothing | Cell::Integer(_) | Cell::Real(_) => String::new(),
            };
            LogEntry {
                system: source.system,
                entity: source.entity,
                sent: row.time,
                written: row.cells[1].as_f64().and_then(UtcTime::from_seconds),
                kind,
                kind_name: kinds.and_then(|field| field.label(kind)),
                context: text(2),
                text: text(3),
            }
        };
        let rows = self.events("LogBookEntry", &LOG_FIELDS, system, range, limit)?;
        Ok(rows.into_iter().map(entry).collect())
    }

    /// The first messages of a kind from all entities, in order of time.
    fn events(
        &mut self,
        message: &str,
        fields: &[&str],
        system: Option<Address>,
        range: TimeRange,
        limit: usize,
    ) -> Result<Vec<(Source, Row)>> {
        let id = self.table(message)?.desc.id;
        let wanted = |src: u16| system.is_none_or(|system| system.0 == src);
        let groups: Vec<_> =
            self.extents()?.into_keys().filter(|key| key.id == id && wanted(key.src)).collect();
        let mut found = Vec::new();
        for group in groups {
            let source =
                Source { system: Address(group.src), entity: group.src_ent, message: message.to_owned() };
            found.extend(
                self.rows(&source, fields, range, limit)?.into_iter().map(|row| (source.clone(), row)),
            );
        }
        found.sort_by(|a, b| (a.1.time, &a.0).cmp(&(b.1.time, &b.0)));
        found.truncate(limit);
        Ok(found)
    }
}
