//! The lines of Innovasea's cabled receiver VR2C and of Rx-LIVE.
//!
//! `serial,sequence,UTC,codespace,id[,sensor],#HH`, Rx-LIVE with thousandths of a second and `S=` signal, `N=` noise (dB)
//! and `C=` channel in whatever order; status lines have `STS` for a codespace. HH is the low byte of the sum of all
//! characters before `,#` (VR2C manual of 2018, 3.2.5.3). Lines end in CR LF. A VR2C stamps whole seconds: its detections
//! are of no use for differences of arrival times.

use crate::framer::{self, Grammar};
use crate::reading::TagReading;
use units::UtcTime;

/// The longest line kept (bytes); status lines have some 150.
pub const LONGEST: usize = 512;

/// The kinds of lines.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Line {
    /// A detection.
    Tag(Detection),
    /// The receiver's regular report of itself.
    Status(Status),
}

/// A detection as these receivers report it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Detection {
    /// As every receiver's: the codespace is the protocol's name, the sequence the counter, the clock Unix time. The SNR is
    /// signal less noise, 0 where `levels` is absent.
    pub tag: TagReading,
    /// Signal and noise (dB), which Rx-LIVE reports.
    pub levels: Option<(u16, u16)>,
    /// Channel, which Rx-LIVE reports.
    pub channel: Option<u8>,
}

/// The receiver's report of itself.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Status {
    /// Serial number of the receiver.
    pub serial: u32,
    /// Number of the line.
    pub sequence: u16,
    /// The receiver's time.
    pub utc: UtcTime,
    /// Counts, voltages, temperature and tilt as written behind `STS`.
    pub text: String,
}

/// Why a line is not read.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum DamagedLine {
    /// A byte is not a printable character.
    #[error("bytes that are not text: the baud rate may be wrong")]
    NotText,
    /// The stream ends before its line end.
    #[error("the line is cut short")]
    Unended,
    /// It is longer than [`LONGEST`].
    #[error("longer than 512 bytes without a line end")]
    TooLong,
    /// It does not end in `,#` and two hexadecimal digits.
    #[error("no checksum")]
    NoChecksum,
    /// Its checksum is another.
    #[error("checksum {stands:02X}, computed {computed:02X}")]
    Checksum {
        /// The text found.
        stands: u8,
        /// The checksum of the bytes.
        computed: u8,
    },
    /// A field is absent or not valid.
    #[error("{name} is not valid: '{text}'")]
    Field {
        /// What the field is.
        name: &'static str,
        /// The text found.
        text: String,
    },
}

/// Reads one line, without its end.
///
/// # Errors
/// When its checksum is absent or wrong, or a field is not valid.
pub fn parse(line: &[u8]) -> Result<Line, DamagedLine> {
    let line = line.trim_ascii();
    if !line.iter().all(|byte| (b' '..=b'~').contains(byte)) {
        return Err(DamagedLine::NotText);
    }
    let raw = std::str::from_utf8(line).map_err(|_| DamagedLine::NotText)?;
    let mut fields = checked(raw)?.split(',').map(str::trim);
    let serial = number("the serial number", fields.next())?;
    let sequence = number("the sequence", fields.next())?;
    let stamp = fields.next().unwrap_or_default();
    let utc: UtcTime = stamp.parse().map_err(|_| wrong("the time", stamp))?;
    let codespace = fields.next().unwrap_or_default();
    if codespace == "STS" {
        let text = fields.collect::<Vec<_>>().join(",");
        return Ok(Line::Status(Status { serial, sequence, utc, text }));
    }
    let clock_s = u32::try_from(utc.micros().div_euclid(1_000_000)).map_err(|_| wrong("the time", stamp))?;
    let mut found = Detection {
        tag: TagReading {
            serial,
            clock_s,
            // A remainder below a thousand.
            millis: (utc.micros().rem_euclid(1_000_000) / 1000) as u16,
            protocol: codespace.to_owned(),
            tag_id: number("the tag's id", fields.next())?,
            data: None,
            snr_db: 0,
            frequency_khz: frequency_khz(codespace).ok_or_else(|| wrong("the codespace", codespace))?,
            counter: sequence,
            raw: Some(raw.to_owned()),
            lines_lost: None,
        },
        levels: None,
        channel: None,
    };
    rest(&mut found, fields)?;
    Ok(Line::Tag(found))
}

/// What may follow a tag's id: a sensor's value, signal, noise and channel, in any order.
fn rest<'a>(found: &mut Detection, fields: impl Iterator<Item = &'a str>) -> Result<(), DamagedLine> {
    let (mut signal, mut noise) = (None, None);
    for field in fields {
        match field.split_once('=') {
            Some(("S", level)) => signal = Some(number("the signal", Some(level))?),
            Some(("N", level)) => noise = Some(number("the noise", Some(level))?),
            Some(("C", channel)) => found.channel = Some(number("the channel", Some(channel))?),
            // A value of firmware to come: the raw line keeps it.
            Some(_) => {}
            None if found.tag.data.is_none() => {
                found.tag.data = Some(number("the sensor's value", Some(field))?);
            }
            None => return Err(wrong("a field behind the sensor's value", field)),
        }
    }
    found.levels = signal.zip(noise);
    let snr = found.levels.map_or(0, |(signal, noise): (u16, u16)| signal.saturating_sub(noise));
    found.tag.snr_db = u8::try_from(snr).unwrap_or(u8::MAX);
    Ok(())
}

/// The carrier that a codespace names, as 69 in `A69-1303` (kHz).
fn frequency_khz(codespace: &str) -> Option<u8> {
    let (band, space) = codespace.split_once('-')?;
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let carrier = band.get(1..).filter(|text| digits(text) && band.as_bytes()[0].is_ascii_uppercase())?;
    digits(space).then(|| carrier.parse().ok()).flatten()
}

/// The text before `,#`, if its checksum is right.
fn checked(line: &str) -> Result<&str, DamagedLine> {
    let (body, stands) = line.rsplit_once(",#").ok_or(DamagedLine::NoChecksum)?;
    let two_digits = stands.len() == 2 && stands.bytes().all(|byte| byte.is_ascii_hexdigit());
    let stands = u8::from_str_radix(stands, 16).ok().filter(|_| two_digits).ok_or(DamagedLine::NoChecksum)?;
    let computed = body.bytes().fold(0, u8::wrapping_add);
    if stands == computed { Ok(body) } else { Err(DamagedLine::Checksum { stands, computed }) }
}

fn number<T: std::str::FromStr>(name: &'static str, text: Option<&str>) -> Result<T, DamagedLine> {
    let text = text.unwrap_or_default();
    let digits = text.bytes().all(|byte| byte.is_ascii_digit());
    digits.then(|| text.parse().ok()).flatten().ok_or_else(|| wrong(name, text))
}

fn wrong(name: &'static str, text: &str) -> DamagedLine {
    DamagedLine::Field { name, text: text.chars().take(40).collect() }
}

/// Finds the receiver's lines in a stream.
pub type Framer = framer::Framer<ReceiverLines>;

/// How the receiver writes its lines.
#[derive(Debug, Clone)]
pub struct ReceiverLines;

impl Grammar for ReceiverLines {
    type Line = Line;
    type Damage = DamagedLine;

    const START: Option<u8> = None;
    const LONGEST: usize = LONGEST;
    const UNENDED: DamagedLine = DamagedLine::Unended;
    const TOO_LONG: DamagedLine = DamagedLine::TooLong;

    fn read(text: &[u8]) -> Result<Line, DamagedLine> {
        parse(text)
    }

    fn is_unended(damage: &DamagedLine) -> bool {
        *damage == DamagedLine::NoChecksum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn tag(line: &str) -> Detection {
        match parse(line.as_bytes()) {
            Ok(Line::Tag(found)) => found,
            other => panic!("{line}: {other:?}"),
        }
    }

    fn summed(body: &str) -> String {
        format!("{body},#{:02X}", body.bytes().fold(0, u8::wrapping_add))
    }

    #[test]
    fn made_lines_are_read() {
        let id_only = tag("450123,017,2026-09-21 12:43:17,A69-1303,12345,#D0");
        assert_eq!((id_only.tag.serial, id_only.tag.counter, id_only.tag.tag_id), (450_123, 17, 12_345));
        assert_eq!((id_only.tag.protocol.as_str(), id_only.tag.frequency_khz), ("A69-1303", 69));
        assert_eq!((id_only.tag.data, id_only.levels, id_only.tag.snr_db), (None, None, 0));
        let utc: UtcTime = "2026-09-21T12:43:17Z".parse().unwrap();
        assert_eq!(i64::from(id_only.tag.clock_s), utc.micros() / 1_000_000);
        let sensor = tag("450123,018,2026-09-21 12:43:52,A69-1105,77,131,#00");
        assert_eq!((sensor.tag.data, sensor.tag.millis), (Some(131), 0));
        let live = tag("457777,204,2026-09-21 12:44:02.317,A69-1602,48211,S=61,N=34,C=0,#C8");
        assert_eq!((live.tag.millis, live.levels, live.channel), (317, Some((61, 34)), Some(0)));
        assert_eq!(live.tag.snr_db, 27);
    }

    #[test]
    fn optional_fields_come_in_any_order() {
        let line = summed("457777,204,2026-09-21 12:44:02.317,A69-1602,48211,C=1,N=34,99,X=5,S=61");
        let found = tag(&line);
        assert_eq!((found.tag.data, found.tag.snr_db, found.channel), (Some(99), 27, Some(1)));
        assert_eq!(found.tag.raw.as_deref(), Some(line.as_str()));
    }

    #[test]
    fn status_lines_are_told_from_detections() {
        let line = summed("450123,019,2026-09-21 12:45:00,STS,DC=2,PC=17,LV=12.1,T=7.5");
        let Ok(Line::Status(status)) = parse(line.as_bytes()) else { panic!("no status") };
        assert_eq!((status.sequence, status.text.as_str()), (19, "DC=2,PC=17,LV=12.1,T=7.5"));
    }

    #[test]
    fn damage_is_refused() {
        assert_eq!(
            parse(b"450123,017,2026-09-21 12:43:17,A69-1303,12346,#D0"),
            Err(DamagedLine::Checksum { stands: 0xD0, computed: 0xD1 })
        );
        assert_eq!(parse(b"450123,017,2026-09-21 12:43:17"), Err(DamagedLine::NoChecksum));
        assert_eq!(parse(b"\xff,#00"), Err(DamagedLine::NotText));
        for body in [
            "450123,017,2026-13-21 12:43:17,A69-1303,12345",
            "450123,017,2026-09-21 12:43:17,A69,12345",
            "450123,017,2026-09-21 12:43:17,A69-1303,",
            "450123,017,2026-09-21 12:43:17,A69-1303,1,2,3",
            "450123,99999,2026-09-21 12:43:17,A69-1303,12345",
            "450123,017,1950-09-21 12:43:17,A69-1303,12345",
        ] {
            let error = parse(summed(body).as_bytes()).unwrap_err();
            assert!(matches!(error, DamagedLine::Field { .. }), "{body}: {error}");
        }
    }
}
