//! One line of the receiver read.
//!
//! A line has no checksum: the number of fields and the range of each are all that reveals a damaged one. Lines of 8 and 7
//! fields (TB Live without a running number) and of 9 and 8 (with one) are read, each with or without the two fields that
//! recording software appends, latitude and longitude in degrees; these are checked and left out, the vessel knows its
//! own position. An identity that cannot carry data has none, also where recording software filled the empty field with 0.

use super::TagProtocol;
use crate::reading::{TagReading, WaterReading};
use units::LatLon;

/// The third field of a sensor line.
const SENSOR: &str = "TBR Sensor";
/// Protocol names are at most five letters in the manual; unknown ones are kept up to this.
const LONGEST_PROTOCOL: usize = 16;

/// The kinds of the receiver's lines.
#[derive(Debug, Clone, PartialEq)]
pub enum Line {
    /// A detection of a tag.
    Tag(TagReading),
    /// The regular report of the water.
    Water(WaterReading),
    /// The clock obeyed a command.
    Ack(Ack),
    /// An answer in command mode, as it came.
    Reply(String),
}

/// Which command the receiver's clock obeyed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Ack {
    /// `ack01`: it was rounded to the nearest ten seconds.
    Rounded,
    /// `ack02`: it was set to a ten seconds of Unix time.
    Set,
    /// `ack03`: it was set to a second, which the pulse per second marks.
    SetByPulse,
}

impl Ack {
    /// As the receiver writes it.
    pub const fn text(self) -> &'static str {
        match self {
            Self::Rounded => "ack01",
            Self::Set => "ack02",
            Self::SetByPulse => "ack03",
        }
    }

    /// Finds one in a text.
    pub(super) fn find(text: &str) -> Option<Self> {
        [Self::Rounded, Self::Set, Self::SetByPulse].into_iter().find(|ack| text.contains(ack.text()))
    }
}

/// Why a line is not read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DamagedLine {
    /// A byte is not a printable character.
    #[error("bytes that are not text: the baud rate may be wrong")]
    NotText,
    /// Another line begins before this one's end.
    #[error("the line is cut short")]
    Unended,
    /// It is longer than [`LONGEST`](super::LONGEST).
    #[error("longer than 256 bytes without a line end")]
    TooLong,
    /// It has another number of fields than any line of the receiver.
    #[error("{stand} fields make no line of this receiver")]
    Fields {
        /// How many it has.
        stand: usize,
    },
    /// A field is not valid.
    #[error("{name} is not valid: '{text}'")]
    Field {
        /// What the field is.
        name: &'static str,
        /// The text found.
        text: String,
    },
}

/// A line that was read, and what its reading alone does not say.
#[derive(Debug, Clone, PartialEq)]
pub struct Heard {
    /// What it is.
    pub line: Line,
    /// The running number, which counts tag and sensor lines together and wraps at 16 bits; `None` where the receiver sends
    /// none, and the reading's counter is 0.
    pub counter: Option<u16>,
}

/// Reads one line, without its end.
///
/// # Errors
/// When it is not text, has another number of fields than any line, or a field is not valid.
pub fn parse(line: &[u8]) -> Result<Heard, DamagedLine> {
    let line = line.trim_ascii();
    if !line.iter().all(|byte| (b' '..=b'~').contains(byte)) {
        return Err(DamagedLine::NotText);
    }
    let text = std::str::from_utf8(line).map_err(|_| DamagedLine::NotText)?;
    let Some(body) = text.strip_prefix('$') else {
        let line = Ack::find(text).map_or_else(|| Line::Reply(text.to_owned()), Line::Ack);
        return Ok(Heard { line, counter: None });
    };
    let stand = body.split(',').count();
    if stand > MOST_FIELDS {
        return Err(DamagedLine::Fields { stand });
    }
    let fields: Vec<&str> = body.split(',').map(str::trim).collect();
    if fields.get(2) == Some(&SENSOR) { water(&fields) } else { tag(&fields, text) }
}

/// A tag line with running number, latitude and longitude.
const MOST_FIELDS: usize = 11;

fn tag(fields: &[&str], raw: &str) -> Result<Heard, DamagedLine> {
    let counter = tail(fields, 8)?;
    let protocol = fields[3];
    let known_letters =
        protocol.bytes().all(|byte| byte.is_ascii_alphanumeric() || matches!(byte, b'-' | b'_'));
    if protocol.is_empty() || protocol.len() > LONGEST_PROTOCOL || !known_letters {
        return Err(wrong("the protocol", protocol));
    }
    let carries = TagProtocol::from_name(protocol).is_none_or(|known| known.data_max().is_some());
    let data = match fields[5] {
        "" => None,
        text => Some(number("the data", text)?).filter(|&data| carries || data > 0),
    };
    let reading = TagReading {
        serial: number("the serial number", fields[0])?,
        clock_s: number("the time", fields[1])?,
        millis: Some(number("the milliseconds", fields[2])?)
            .filter(|&millis| millis < 1000)
            .ok_or_else(|| wrong("the milliseconds", fields[2]))?,
        protocol: protocol.to_owned(),
        tag_id: number("the tag's id", fields[4])?,
        data,
        snr_db: number("the SNR", fields[6])?,
        frequency_khz: number("the frequency", fields[7])?,
        counter: counter.unwrap_or(0),
        raw: Some(raw.to_owned()),
        lines_lost: None,
    };
    Ok(Heard { line: Line::Tag(reading), counter })
}

fn water(fields: &[&str]) -> Result<Heard, DamagedLine> {
    let counter = tail(fields, 7)?;
    let count: u16 = number("the temperature", fields[3])?;
    let reading = WaterReading {
        serial: number("the serial number", fields[0])?,
        clock_s: number("the time", fields[1])?,
        temperature_c: (f64::from(count) - 50.0) / 10.0,
        noise_average: number("the mean noise", fields[4])?,
        noise_peak: number("the peak noise", fields[5])?,
        frequency_khz: number("the frequency", fields[6])?,
        counter: counter.unwrap_or(0),
        lines_lost: None,
    };
    Ok(Heard { line: Line::Water(reading), counter })
}

/// What may follow the first `own` fields: a running number, a position, both or nothing. Answers with the running number.
fn tail(fields: &[&str], own: usize) -> Result<Option<u16>, DamagedLine> {
    let rest = fields.get(own..).ok_or(DamagedLine::Fields { stand: fields.len() })?;
    let (counter, place) = match rest {
        [] => (None, None),
        [counter] => (Some(*counter), None),
        [lat, lon] => (None, Some((*lat, *lon))),
        [counter, lat, lon] => (Some(*counter), Some((*lat, *lon))),
        _ => return Err(DamagedLine::Fields { stand: fields.len() }),
    };
    if let Some((lat, lon)) = place {
        let degrees = |text: &str| text.parse::<f64>().ok();
        let place = degrees(lat).zip(degrees(lon));
        if place.and_then(|(lat, lon)| LatLon::from_deg(lat, lon).ok()).is_none() {
            return Err(wrong("the position", &format!("{lat},{lon}")));
        }
    }
    counter.map(|text| number("the running number", text)).transpose()
}

/// A number of digits only, in base ten whatever zeros lead it.
fn number<T: TryFrom<u64>>(name: &'static str, text: &str) -> Result<T, DamagedLine> {
    let digits = !text.is_empty() && text.len() <= 18 && text.bytes().all(|byte| byte.is_ascii_digit());
    let value = digits.then(|| text.parse::<u64>().ok()).flatten();
    value.and_then(|value| T::try_from(value).ok()).ok_or_else(|| wrong(name, text))
}

fn wrong(name: &'static str, text: &str) -> DamagedLine {
    DamagedLine::Field { name, text: text.chars().take(40).collect() }
}
