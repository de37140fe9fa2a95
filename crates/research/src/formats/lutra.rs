//! All that is known of a detection, in columns of our own: a row each, the oldest report first.
//!
//! A column that no message carried is an empty cell, never 0. Both messages that can carry a detection are one row.

use super::cells::Cells;
use super::{Format, Rows};
use crate::study::Heard;
use tables::Dialect;

pub(super) const FORMAT: Format = Format {
    name: "lutra",
    about: "every column that Lutra knows, for programs and spreadsheets",
    // Written by `header`, as the dialect of a spreadsheet decides what stands between names.
    header: "",
    absent: "",
    rows: Rows::Detections(row),
    has_lag: true,
};

/// The columns: name in the header, and what it tells.
pub const LUTRA_COLUMNS: [(&str, &str); 32] = [
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
    ("tag_name", "what the register calls the tag"),
    ("animal", "the animal that carried it then, by the register"),
    ("scientific_name", "its species, by the register"),
    ("sensor_reading", "the tag's measurement by the slope and intercept that the register has for it"),
    ("sensor_unit", "unit of that"),
    (
        "min_lag [s]",
        "time to the nearest other detection of the tag by the same receiver; empty where none is within a day",
    ),
    (
        "doubt",
        "why it is perhaps a false detection, by the rule of 30 ping intervals; empty where another one confirms it, or the register has no ping interval",
    ),
];

/// Appends the names of the columns.
pub(super) fn header(out: &mut Vec<u8>, dialect: Dialect) {
    for (at, (name, _)) in LUTRA_COLUMNS.iter().enumerate() {
        if at > 0 {
            out.push(dialect.separator());
        }
        out.extend_from_slice(name.as_bytes());
    }
    out.push(b'\n');
}

/// The cells of [`LUTRA_COLUMNS`], in their order.
fn row(cells: &mut Cells<'_>, heard: &Heard<'_>) -> bool {
    let one = heard.detection;
    let (origin, clock, effort, pose) = (one.origin, one.clock, one.effort, one.pose);
    let noise = effort.noise;
    cells.iso_ms(clock.utc().map(units::UtcTime::micros));
    cells.text(&one.tag());
    cells.whole(Some(one.receiver.into()));
    cells.text(heard.vessel);
    cells.degrees(pose.map(|pose| pose.place.lat_deg()));
    cells.degrees(pose.map(|pose| pose.place.lon_deg()));
    cells.real(pose.and_then(|pose| pose.age_s));
    cells.real(pose.and_then(|pose| pose.sigma_m));
    cells.whole(Some(one.snr_db.into()));
    cells.whole(one.data.map(i64::from));
    cells.whole(Some(one.frequency_khz.into()));
    cells.text(clock.state.word());
    cells.decimals(&format!("{}.{:03}", clock.seconds, clock.millis));
    cells.iso_us(Some(origin.reported));
    cells.iso_us(origin.received);
    cells.text(&one.protocol.to_string());
    cells.whole(Some(one.tag_id.into()));
    cells.whole(effort.lines_lost.map(i64::from));
    cells.whole(noise.map(|noise| noise.average.into()));
    cells.whole(noise.map(|noise| noise.peak.into()));
    cells.real(noise.map(|noise| noise.age_s));
    cells.real(effort.propeller_rpm);
    cells.whole(Some(one.line.into()));
    cells.maybe(one.raw.as_deref());
    cells.text(&one.id());
    cells.maybe(heard.tag.map(|tag| &*tag.name));
    cells.maybe(heard.animal.map(|animal| &*animal.name));
    cells.maybe(heard.animal.map(|animal| &*animal.scientific_name));
    let sensor = heard.sensor();
    cells.number(sensor.map(|sensor| sensor.value));
    cells.maybe(sensor.map(|sensor| sensor.unit));
    cells.number(heard.lag.seconds());
    cells.text(&heard.doubt().unwrap_or_default());
    true
}
