//! What is known of a detection, column by column and value by value, before a format writes it.

use crate::study::Heard;
use std::borrow::Cow;
use tables::IsoTime;
use units::UtcTime;

/// A column of our own formats.
#[derive(Debug, Clone, Copy)]
pub struct DetectionColumn {
    /// Its name, with the unit in brackets.
    pub name: &'static str,
    /// What it tells.
    pub about: &'static str,
    /// What its values are.
    pub kind: ColumnKind,
}

impl DetectionColumn {
    /// Its name without the unit.
    pub fn bare_name(&self) -> &'static str {
        self.name.split_once(" [").map_or(self.name, |(name, _)| name)
    }

    /// The unit that its name has.
    pub fn unit(&self) -> Option<&'static str> {
        self.name.split_once(" [").and_then(|(_, unit)| unit.strip_suffix(']'))
    }
}

/// What the values of a column are.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ColumnKind {
    /// Text.
    Text,
    /// A whole number.
    Whole,
    /// A number.
    Real,
    /// A moment, UTC.
    Time,
}

const fn text(name: &'static str, about: &'static str) -> DetectionColumn {
    DetectionColumn { name, about, kind: ColumnKind::Text }
}

const fn whole(name: &'static str, about: &'static str) -> DetectionColumn {
    DetectionColumn { name, about, kind: ColumnKind::Whole }
}

const fn real(name: &'static str, about: &'static str) -> DetectionColumn {
    DetectionColumn { name, about, kind: ColumnKind::Real }
}

const fn time(name: &'static str, about: &'static str) -> DetectionColumn {
    DetectionColumn { name, about, kind: ColumnKind::Time }
}

/// All that is known of a detection.
pub const LUTRA_COLUMNS: [DetectionColumn; 32] = [
    time(
        "heard_utc",
        "when the receiver heard the tag, by the receiver's clock; ISO 8601, UTC, milliseconds; empty where that clock was never set or was lost",
    ),
    text("tag", "protocol and number of the tag"),
    whole("receiver", "serial number of the receiver"),
    text("vessel", "name of the vessel that carried the receiver"),
    real(
        "latitude [deg]",
        "WGS 84 latitude of the vessel at that time, north positive, eight decimals (1 mm)",
    ),
    real("longitude [deg]", "WGS 84 longitude of the vessel at that time, east positive, eight decimals"),
    real("position_age [s]", "time between the detection and the nearest measured position"),
    real("position_deviation [m]", "standard deviation of the position on each axis"),
    whole("snr [dB]", "signal to noise ratio"),
    whole("sensor_value [count]", "the tag's measurement as it was sent; empty for a tag without a sensor"),
    whole("frequency [kHz]", "carrier frequency"),
    text(
        "clock",
        "the receiver's clock: set (at some time), disciplined (set by the vessel and kept), lost (not known to be right any more) or not set (since power-up)",
    ),
    real("clock_count [s]", "what the receiver's clock counted: since 1970 UTC where it is set"),
    time(
        "reported_utc",
        "when the detection came to the vessel, by the vessel's clock; ISO 8601, UTC, microseconds",
    ),
    time("received_utc", "when it first came ashore, by the server's clock; ISO 8601, UTC, microseconds"),
    text("protocol", "protocol of the tag, as the receiver names it"),
    whole("tag_id", "number of the tag"),
    whole("lines_lost_before", "lines of the receiver that were lost right before this one"),
    whole("noise_average [count]", "mean noise that the receiver reported last"),
    whole("noise_peak [count]", "peak noise, likewise"),
    real("noise_age [s]", "how long before the detection that was"),
    real("propeller_speed [rpm]", "speed of the vessel's faster propeller, without direction"),
    whole("memory_address", "running number of the line in the receiver's memory"),
    text("raw_line", "the receiver's line as it came, without its end"),
    text("detection_id", "names the detection among those of its vessel"),
    text("tag_name", "what the register calls the tag"),
    text("animal", "the animal that carried it then, by the register"),
    text("scientific_name", "its species, by the register"),
    real("sensor_reading", "the tag's measurement by the slope and intercept that the register has for it"),
    text("sensor_unit", "unit of that"),
    real(
        "min_lag [s]",
        "time to the nearest other detection of the tag by the same receiver; empty where there is no other within a day",
    ),
    text(
        "doubt",
        "why it is perhaps a false detection, by the rule of 30 ping intervals; empty where another one confirms it, or the register has no ping interval",
    ),
];

/// A value of a column; not known where it is `None` or an empty text.
#[derive(Debug, Clone, Copy)]
pub enum Value<'v> {
    /// A text.
    Text(&'v str),
    /// A whole number.
    Whole(Option<i64>),
    /// With as many digits as tell it from all others.
    Real(Option<f64>),
    /// With eight decimals.
    Degrees(Option<f64>),
    /// With the digits that it needs, twelve at most.
    Number(Option<f64>),
    /// Seconds and their thousandths.
    Thousandths(u32, u16),
    /// A moment to the millisecond.
    Millis(Option<UtcTime>),
    /// A moment to the microsecond.
    Micros(Option<UtcTime>),
}

impl Value<'_> {
    /// The number that the text of the CSV is, as all files have the same values: `None` for what is no number, or not known.
    pub fn number(&self) -> Option<f64> {
        match self {
            Self::Real(value) => *value,
            Self::Text(_) | Self::Millis(_) | Self::Micros(_) => None,
            _ => self.plain().and_then(|(text, _)| text.parse().ok()),
        }
    }

    /// The moment, µs since 1970 UTC; `None` for what is none, or not known.
    pub fn micros(&self) -> Option<i64> {
        match self {
            Self::Millis(time) | Self::Micros(time) => time.map(UtcTime::micros),
            _ => None,
        }
    }

    /// The value as JSON and XML have it: `None` where it is not known; whether it is a number.
    pub fn plain(&self) -> Option<(Cow<'_, str>, bool)> {
        let number = |text: String| Some((Cow::from(text), true));
        let time = |time: &Option<UtcTime>, write: fn(&mut IsoTime, &mut Vec<u8>, i64)| {
            let mut out = Vec::new();
            write(&mut IsoTime::new(), &mut out, time.as_ref()?.micros());
            Some((Cow::from(String::from_utf8_lossy(&out).into_owned()), false))
        };
        match self {
            Self::Text(text) => (!text.is_empty()).then(|| (Cow::from(*text), false)),
            Self::Whole(value) => number(value.as_ref()?.to_string()),
            Self::Real(value) => number(value.filter(|value| value.is_finite())?.to_string()),
            Self::Degrees(value) => number(format!("{:.8}", value.as_ref()?)),
            Self::Number(value) => number(digits(value.filter(|value| value.is_finite())?)),
            Self::Thousandths(seconds, millis) => number(format!("{seconds}.{millis:03}")),
            Self::Millis(at) => time(at, IsoTime::write_ms),
            Self::Micros(at) => time(at, IsoTime::write),
        }
    }
}

/// A number with the digits that it needs: `12`, `0.2`. Rounded to twelve digits, as a product of decimals has crumbs.
pub(super) fn digits(value: f64) -> String {
    let digits = 11 - if value == 0.0 { 0 } else { value.abs().log10().floor() as i32 };
    let text = format!("{value:.*}", usize::try_from(digits.clamp(0, 12)).unwrap_or(0));
    let text = if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.') } else { &text };
    if text == "-0" { "0" } else { text }.to_owned()
}

/// Hands over the values of [`LUTRA_COLUMNS`], in their order.
pub fn values(heard: &Heard<'_>, put: &mut dyn FnMut(Value<'_>)) {
    of_detection(heard, put);
    of_register(heard, put);
}

fn of_detection(heard: &Heard<'_>, put: &mut dyn FnMut(Value<'_>)) {
    let one = heard.detection;
    let (origin, clock, effort, pose) = (one.origin, one.clock, one.effort, one.pose);
    let noise = effort.noise;
    put(Value::Millis(clock.utc()));
    put(Value::Text(&one.tag()));
    put(Value::Whole(Some(one.receiver.into())));
    put(Value::Text(heard.vessel));
    put(Value::Degrees(pose.map(|pose| pose.place.lat_deg())));
    put(Value::Degrees(pose.map(|pose| pose.place.lon_deg())));
    put(Value::Real(pose.and_then(|pose| pose.age_s)));
    put(Value::Real(pose.and_then(|pose| pose.sigma_m)));
    put(Value::Whole(one.snr_db.map(i64::from)));
    put(Value::Whole(one.data.map(i64::from)));
    put(Value::Whole(one.frequency_khz.map(i64::from)));
    put(Value::Text(clock.state.word()));
    put(Value::Thousandths(clock.seconds, clock.millis));
    put(Value::Micros(Some(origin.reported)));
    put(Value::Micros(origin.received));
    put(Value::Text(&one.protocol.to_string()));
    put(Value::Whole(Some(one.tag_id.into())));
    put(Value::Whole(effort.lines_lost.map(i64::from)));
    put(Value::Whole(noise.map(|noise| noise.average.into())));
    put(Value::Whole(noise.map(|noise| noise.peak.into())));
    put(Value::Real(noise.map(|noise| noise.age_s)));
    put(Value::Real(effort.propeller_rpm));
    put(Value::Whole(Some(one.line.into())));
    put(Value::Text(one.raw.as_deref().unwrap_or_default()));
    put(Value::Text(&one.id()));
}

fn of_register(heard: &Heard<'_>, put: &mut dyn FnMut(Value<'_>)) {
    let sensor = heard.sensor();
    put(Value::Text(heard.tag.map_or("", |tag| &tag.name)));
    put(Value::Text(heard.animal.map_or("", |animal| &animal.name)));
    put(Value::Text(heard.animal.map_or("", |animal| &animal.scientific_name)));
    put(Value::Number(sensor.map(|sensor| sensor.value)));
    put(Value::Text(sensor.map_or("", |sensor| sensor.unit)));
    put(Value::Number(heard.lag.seconds()));
    put(Value::Text(&heard.doubt().unwrap_or_default()));
}
