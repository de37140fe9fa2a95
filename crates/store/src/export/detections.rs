//! Detections as CSV: one row each, the oldest report first, in constant memory.
//!
//! A column that no message carried is an empty cell, never 0. Both messages that can carry a detection are one row.

use super::csv::{Exported, unwritable};
use crate::error::Result;
use crate::reader::{DetectionsWanted, Memory, Order, Page, Reader};
use ::detections::Detection;
use imc::Address;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use tables::{Dialect, Format, IsoTime};
use units::UtcTime;

/// Detections that are read at once, and the bytes of their texts.
const PAGE: Page = Page { skip: 0, rows: 2_000, bytes: 1 << 20 };

/// The columns: name in the header, and what it tells.
pub const DETECTION_COLUMNS: [(&str, &str); 25] = [
    (
        "heard_utc",
        "when the receiver heard the tag, by the receiver's clock; ISO 8601, UTC, milliseconds; empty where that clock was never set or was lost",
    ),
    ("tag", "protocol and number of the tag"),
    ("receiver", "serial number of the receiver"),
    ("vessel", "name of the vessel that carried the receiver"),
    ("latitude [deg]", "WGS 84 latitude of the vessel at that time, north positive, eight decimals (1 mm)"),
    ("longitude [deg]", "WGS 84 longitude of the vessel at that time, east positive, eight decimals"),
    ("position_age [s]", "time between the detection and the nearest measured position"),
    ("position_deviation [m]", "standard deviation of the position on each axis"),
    ("snr [dB]", "signal to noise ratio"),
    ("sensor_value [count]", "the tag's measurement as it was sent; empty for a tag that sends none"),
    ("frequency [kHz]", "carrier frequency"),
    (
        "clock",
        "the receiver's clock: set (at some time), disciplined (set by the vessel and kept), lost (not known to be right any more) or not set (since power-up)",
    ),
    ("clock_count [s]", "what the receiver's clock counted: since 1970 UTC where it is set"),
    (
        "reported_utc",
        "when the detection came to the vessel, by the vessel's clock; ISO 8601, UTC, microseconds",
    ),
    ("received_utc", "when it first came ashore, by the server's clock; ISO 8601, UTC, microseconds"),
    ("protocol", "protocol of the tag, as the receiver names it"),
    ("tag_id", "number of the tag"),
    ("lines_lost_before", "lines of the receiver that were lost right before this one"),
    ("noise_average [count]", "mean noise that the receiver reported last"),
    ("noise_peak [count]", "peak noise, likewise"),
    ("noise_age [s]", "how long before the detection that was"),
    ("propeller_speed [rpm]", "speed of the vessel's faster propeller, without direction"),
    ("memory_address", "running number of the line in the receiver's memory"),
    ("raw_line", "the receiver's line as it came, without its end"),
    ("detection_id", "names the detection among those of its vessel"),
];

/// Writes a header and a row for each detection that is wanted. Vessels are called by `names`, else as they announced.
///
/// # Errors
/// When the history cannot be read or `out` not be written. A table that was begun then ends with a line that begins
/// with `#ERROR`, as far as it can be written, and is not whole.
pub fn export_detections(
    data: &Path,
    wanted: &DetectionsWanted,
    names: &BTreeMap<u16, String>,
    dialect: Dialect,
    out: &mut dyn Write,
) -> Result<Exported> {
    let mut exported = Exported::default();
    let written = write(data, wanted, names, dialect, out, &mut exported);
    if let Err(error) = written {
        let line = format!("#ERROR the export is cut here: {error}\n").replace('\r', " ");
        out.write_all(line.as_bytes()).ok();
        return Err(error);
    }
    Ok(exported)
}

fn write(
    data: &Path,
    wanted: &DetectionsWanted,
    names: &BTreeMap<u16, String>,
    dialect: Dialect,
    out: &mut dyn Write,
    exported: &mut Exported,
) -> Result<()> {
    let mut reader = Reader::open_with(data, Memory::EXPORT)?;
    let known = reader.names()?;
    let called = |system: Address| names.get(&system.0).cloned().unwrap_or_else(|| known.system(system));
    let mut buffer = dialect.mark().to_vec();
    let mut line = Line::new(dialect);
    for (at, (name, _)) in DETECTION_COLUMNS.iter().enumerate() {
        if at > 0 {
            line.format.next(&mut buffer);
        }
        buffer.extend_from_slice(name.as_bytes());
    }
    buffer.push(b'\n');
    let mut wanted = wanted.clone();
    let mut page = PAGE;
    loop {
        out.write_all(&buffer).map_err(unwritable)?;
        exported.bytes += buffer.len() as u64;
        buffer.clear();
        let found = reader.detections_of(&wanted, Order::Oldest, page)?;
        exported.rows += found.items.len() as u64;
        for one in &found.items {
            line.write(&mut buffer, one, &called(one.origin.system));
        }
        let Some(next) = found.next else { break };
        wanted.range.from_us = next.time_us;
        page.skip = next.skip;
    }
    out.write_all(&buffer).and_then(|()| out.flush()).map_err(unwritable)?;
    exported.bytes += buffer.len() as u64;
    Ok(())
}

struct Line {
    format: Format,
    heard: IsoTime,
    reported: IsoTime,
    received: IsoTime,
}

impl Line {
    fn new(dialect: Dialect) -> Self {
        let [heard, reported, received] = [IsoTime::new(); 3];
        Self { format: Format { dialect, ..Format::default() }, heard, reported, received }
    }

    /// Writes the cells of [`DETECTION_COLUMNS`], in their order.
    fn write(&mut self, out: &mut Vec<u8>, one: &Detection, vessel: &str) {
        let Detection { origin, clock, effort, pose, .. } = one;
        let noise = effort.noise;
        if let Some(heard) = clock.utc() {
            self.heard.write_ms(out, heard.micros());
        }
        let mut cells = Cells { out, format: self.format };
        cells.text(Some(&one.tag()));
        cells.integer(Some(one.receiver.into()));
        cells.text(Some(vessel));
        cells.degrees(pose.map(|pose| pose.place.lat_deg()));
        cells.degrees(pose.map(|pose| pose.place.lon_deg()));
        cells.double(pose.and_then(|pose| pose.age_s));
        cells.double(pose.and_then(|pose| pose.sigma_m));
        cells.integer(Some(one.snr_db.into()));
        cells.integer(one.data.map(i64::from));
        cells.integer(Some(one.frequency_khz.into()));
        cells.text(Some(clock.state.word()));
        cells.real(Some(format!("{}.{:03}", clock.seconds, clock.millis)));
        cells.time(&mut self.reported, Some(origin.reported));
        cells.time(&mut self.received, origin.received);
        cells.text(Some(&one.protocol.to_string()));
        cells.integer(Some(one.tag_id.into()));
        cells.integer(effort.lines_lost.map(i64::from));
        cells.integer(noise.map(|noise| noise.average.into()));
        cells.integer(noise.map(|noise| noise.peak.into()));
        cells.double(noise.map(|noise| noise.age_s));
        cells.double(effort.propeller_rpm);
        cells.integer(Some(one.line.into()));
        cells.text(one.raw.as_deref());
        cells.text(Some(&one.id()));
        out.push(b'\n');
    }
}

/// Cells after others; one without a value is empty.
struct Cells<'o> {
    out: &'o mut Vec<u8>,
    format: Format,
}

impl Cells<'_> {
    fn text(&mut self, value: Option<&str>) {
        self.format.next(self.out);
        tables::text(self.out, value.unwrap_or_default().as_bytes(), self.format);
    }

    fn integer(&mut self, value: Option<i64>) {
        self.format.next(self.out);
        if let Some(value) = value {
            tables::integer(self.out, value);
        }
    }

    fn double(&mut self, value: Option<f64>) {
        self.format.next(self.out);
        if let Some(value) = value {
            tables::double(self.out, value, self.format.dialect);
        }
    }

    fn degrees(&mut self, value: Option<f64>) {
        self.real(value.map(|value| format!("{value:.8}")));
    }

    /// A number whose decimals are written already.
    fn real(&mut self, value: Option<String>) {
        self.format.next(self.out);
        if let Some(value) = value {
            tables::real(self.out, &value, self.format.dialect);
        }
    }

    fn time(&mut self, iso: &mut IsoTime, value: Option<UtcTime>) {
        self.format.next(self.out);
        if let Some(value) = value {
            iso.write(self.out, value.micros());
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use ::detections::{Effort, Noise, Origin, Pose, Protocol, ReceiverClock};
    use units::LatLon;

    fn bare() -> Detection {
        let reported = UtcTime::from_micros(1_795_248_001_000_001);
        Detection {
            origin: Origin { system: Address(0x0814), entity: 2, reported, received: None },
            receiver: 1_024,
            clock: ReceiverClock::read(600, 250),
            protocol: Protocol::named("R64K"),
            tag_id: 7,
            data: None,
            snr_db: 25,
            frequency_khz: 69,
            line: 3,
            pose: None,
            effort: Effort::default(),
            raw: None,
        }
    }

    fn written(one: &Detection) -> String {
        let mut out = Vec::new();
        let mut line = Line::new(Dialect::Plain);
        line.write(&mut out, one, "otter, \"one\"");
        String::from_utf8(out).unwrap()
    }

    #[test]
    fn what_no_message_carried_is_an_empty_cell() {
        assert_eq!(
            written(&bare()),
            ",R64K-7,1024,\"otter, \"\"one\"\"\",,,,,25,,69,not set,600.250,2026-11-21T08:00:01.000001Z,,R64K,7,,,,,,3,,\
             1024-600.250-R64K-7-2-1795248001000001\n"
        );
    }

    #[test]
    fn a_row_tells_everything_that_was_carried() {
        let place = LatLon::from_deg(63.44, -10.4).unwrap();
        let noise = Noise { average: 0, peak: 40, age_s: 12.5 };
        let received = Some(UtcTime::from_micros(1_795_248_002_000_000));
        let whole = Detection {
            origin: Origin { received, ..bare().origin },
            clock: ReceiverClock::read(1_795_248_000, 7),
            protocol: Protocol::named("S256"),
            data: Some(0),
            pose: Some(Pose { place, age_s: Some(0.4), sigma_m: Some(0.75) }),
            effort: Effort { lines_lost: Some(0), noise: Some(noise), propeller_rpm: Some(0.0) },
            raw: Some("=1024,1".to_owned()),
            ..bare()
        };
        assert_eq!(
            written(&whole),
            "2026-11-21T08:00:00.007Z,S256-7,1024,\"otter, \"\"one\"\"\",63.44000000,-10.40000000,0.4,0.75,25,0,69,set,\
             1795248000.007,2026-11-21T08:00:01.000001Z,2026-11-21T08:00:02.000000Z,S256,7,0,0,40,12.5,0.0,3,\
             \"'=1024,1\",1024-1795248000.007-S256-7-2-1795248001000001\n"
        );
    }

    #[test]
    fn a_row_has_a_cell_for_each_column() {
        let cells = written(&Detection { raw: Some("x".into()), ..bare() })
            .replace("otter, ", "")
            .matches(',')
            .count()
            + 1;
        assert_eq!(cells, DETECTION_COLUMNS.len());
    }
}
