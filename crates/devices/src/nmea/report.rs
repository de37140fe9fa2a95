//! One sentence read: its checksum, its address, and the fields that Lutra has a use for.

use super::damage::DamagedSentence;
use super::fields::{Fields, TimeOfDay, decimal, whole};
use units::{Civil, UtcTime};

const MPS_PER_KNOT: f64 = 1852.0 / 3600.0;
const MPS_PER_KMPH: f64 = 1.0 / 3.6;
/// No vessel and no receiver on one is faster (m/s).
const FASTEST_MPS: f64 = 1_000.0;
/// The years of a valid date: GPS began in 1980.
const YEARS: std::ops::RangeInclusive<u32> = 1980..=2999;

/// The contents of a sentence. Empty fields are `None`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Report {
    /// Position, its quality, satellites.
    Gga(Position),
    /// Course over ground (rad) and speed over ground (m/s).
    Vtg {
        /// Course, true.
        course_rad: Option<f64>,
        /// Speed.
        speed_mps: Option<f64>,
    },
    /// Date and time.
    Zda(DateTime),
    /// True heading (rad).
    Hdt(Option<f64>),
    /// Magnetic heading (rad).
    Hdm(Option<f64>),
    /// Rate of turn, to starboard positive (rad/s).
    Rot(Option<f64>),
    /// Recommended minimum: position, movement, date and time.
    Rmc(Minimum),
    /// Dilution of precision.
    Gsa(Precision),
    /// Estimated errors of the position.
    Gst(Errors),
    /// Heading, pitch and roll: Hemisphere's `PSAT,HPR`.
    Hpr(Attitude),
    /// Heading, roll, pitch and heave: `PASHR`.
    Pashr(Attitude),
    /// Any other sentence whose checksum is right, or a Hemisphere's answer to a command.
    Other,
}

/// The kinds of [`Report`].
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
#[expect(missing_docs, reason = "the names are the sentences'")]
pub enum Kind {
    Gga,
    Vtg,
    Zda,
    Hdt,
    Hdm,
    Rot,
    Rmc,
    Gsa,
    Gst,
    Hpr,
    Pashr,
    Other,
}

impl Report {
    /// Of which kind it is.
    pub const fn kind(&self) -> Kind {
        match self {
            Self::Gga(_) => Kind::Gga,
            Self::Vtg { .. } => Kind::Vtg,
            Self::Zda(_) => Kind::Zda,
            Self::Hdt(_) => Kind::Hdt,
            Self::Hdm(_) => Kind::Hdm,
            Self::Rot(_) => Kind::Rot,
            Self::Rmc(_) => Kind::Rmc,
            Self::Gsa(_) => Kind::Gsa,
            Self::Gst(_) => Kind::Gst,
            Self::Hpr(_) => Kind::Hpr,
            Self::Pashr(_) => Kind::Pashr,
            Self::Other => Kind::Other,
        }
    }

    /// The time of day it is of, where it says one.
    pub const fn time(&self) -> Option<TimeOfDay> {
        match self {
            Self::Gga(position) => position.time,
            Self::Zda(date) => date.time,
            Self::Rmc(minimum) => minimum.date.time,
            Self::Gst(errors) => errors.time,
            Self::Hpr(attitude) | Self::Pashr(attitude) => attitude.time,
            Self::Vtg { .. } | Self::Hdt(_) | Self::Hdm(_) | Self::Rot(_) | Self::Gsa(_) | Self::Other => {
                None
            }
        }
    }
}

/// A position and how good it is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Position {
    /// Time of day of the position.
    pub time: Option<TimeOfDay>,
    /// Latitude and longitude (rad); absent with quality 0, whatever the sentence repeats.
    pub lat_lon_rad: Option<(f64, f64)>,
    /// GGA's number of the quality: 0 no position, 1 autonomous, 2 differential, 3 precise, 4 RTK fixed, 5 RTK float,
    /// 6 estimated, 7 entered by hand, 8 simulated, 9 Novatel's for autonomous.
    pub quality: Option<u8>,
    /// Satellites in use.
    pub satellites: Option<u8>,
    /// Horizontal dilution of precision.
    pub hdop: Option<f64>,
    /// Height above the geoid (m).
    pub height_geoid_m: Option<f64>,
    /// Height of the geoid above the ellipsoid (m).
    pub separation_m: Option<f64>,
}

/// Date and time, as far as they are reported.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct DateTime {
    /// Time of day.
    pub time: Option<TimeOfDay>,
    /// The day, as its midnight UTC.
    pub midnight: Option<UtcTime>,
}

/// The recommended minimum of a receiver.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Minimum {
    /// Date and time.
    pub date: DateTime,
    /// Latitude and longitude (rad); absent where the receiver warns of them.
    pub lat_lon_rad: Option<(f64, f64)>,
    /// Quality by the mode letter, in GGA's numbers.
    pub quality: Option<u8>,
    /// Course over ground, true (rad).
    pub course_rad: Option<f64>,
    /// Speed over ground (m/s).
    pub speed_mps: Option<f64>,
}

/// Dilution of precision.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Precision {
    /// Of the position in three dimensions.
    pub pdop: Option<f64>,
    /// In the horizontal.
    pub hdop: Option<f64>,
    /// In the vertical.
    pub vdop: Option<f64>,
}

/// Estimated errors of a position, one standard deviation.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Errors {
    /// Time of day.
    pub time: Option<TimeOfDay>,
    /// Of the latitude (m).
    pub lat_m: Option<f64>,
    /// Of the longitude (m).
    pub lon_m: Option<f64>,
    /// Of the height (m).
    pub height_m: Option<f64>,
}

/// Attitude of the vessel.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Attitude {
    /// Time of day.
    pub time: Option<TimeOfDay>,
    /// True heading (rad); absent where the sentence says that its heading is magnetic.
    pub heading_rad: Option<f64>,
    /// Pitch, bow up positive (rad).
    pub pitch_rad: Option<f64>,
    /// Roll, to starboard positive (rad).
    pub roll_rad: Option<f64>,
    /// Heave (m).
    pub heave_m: Option<f64>,
}

/// Reads one sentence, from `$` to before its line end.
///
/// Any talker is taken. The answers of Hemisphere's receivers to commands begin with `$>` and have no checksum. Sentences are those of NMEA 0183 version 4.11; `PSAT,HPR` is after Hemisphere's Technical
/// Reference, `PASHR` as Trimble and Hemisphere write it.
///
/// # Errors
/// When its checksum is absent or wrong, or a field of a known sentence is not valid.
pub fn read(line: &[u8]) -> Result<Report, DamagedSentence> {
    if is_answer(line) {
        return Ok(Report::Other);
    }
    let body = checked(line)?;
    let address = body.split(',').next().unwrap_or_default();
    match address {
        "PASHR" => return pashr(body),
        "PSAT" if body.starts_with("PSAT,HPR,") => return hpr(body),
        _ if address.starts_with('P') || address.len() != 5 => return Ok(Report::Other),
        _ => {}
    }
    match address.get(2..).unwrap_or_default() {
        "GGA" => gga(body),
        "VTG" => vtg(body),
        "ZDA" => zda(body),
        "HDT" => Ok(Report::Hdt(Fields::new(body, 3)?.direction_rad(1)?)),
        "HDM" => Ok(Report::Hdm(Fields::new(body, 3)?.direction_rad(1)?)),
        "ROT" => rot(body),
        "RMC" => rmc(body),
        "GSA" => gsa(body),
        "GST" => gst(body),
        _ => Ok(Report::Other),
    }
}

/// Whether a line is a Hemisphere's answer to a command.
fn is_answer(line: &[u8]) -> bool {
    line.starts_with(b"$>") && line.iter().all(|byte| (b' '..=b'~').contains(byte))
}

/// The text between `$` and the last `*`, if its checksum is right.
fn checked(line: &[u8]) -> Result<&str, DamagedSentence> {
    let line = line.trim_ascii();
    if !line.iter().all(|byte| (b' '..=b'~').contains(byte)) {
        return Err(DamagedSentence::NotText);
    }
    let text = std::str::from_utf8(line).map_err(|_| DamagedSentence::NotText)?;
    // AIS receivers begin theirs with an exclamation mark.
    let body = text.strip_prefix(['$', '!']).ok_or(DamagedSentence::NoStart)?;
    let (body, stands) = body.rsplit_once('*').ok_or(DamagedSentence::NoChecksum)?;
    let computed = body.bytes().fold(0, |sum, byte| sum ^ byte);
    let two_digits = stands.len() == 2 && stands.bytes().all(|byte| byte.is_ascii_hexdigit());
    if two_digits && u8::from_str_radix(stands, 16) == Ok(computed) {
        Ok(body)
    } else {
        Err(DamagedSentence::Checksum { stands: stands.chars().take(8).collect(), computed })
    }
}

fn lat_lon(fields: &Fields<'_>, first: usize) -> Result<Option<(f64, f64)>, DamagedSentence> {
    let lat_rad = fields.angle_rad(first, ["N", "S"], 90.0)?;
    let lon_rad = fields.angle_rad(first + 2, ["E", "W"], 180.0)?;
    match (lat_rad, lon_rad) {
        (Some(lat_rad), Some(lon_rad)) => Ok(Some((lat_rad, lon_rad))),
        (None, None) => Ok(None),
        (None, Some(_)) => Err(fields.wrong(first)),
        (Some(_), None) => Err(fields.wrong(first + 2)),
    }
}

fn gga(body: &str) -> Result<Report, DamagedSentence> {
    let fields = Fields::new(body, 15)?;
    // One digit, or two from 10 on, which no receiver writes.
    let quality = fields.whole(6, 9)?.map(|quality| quality as u8);
    let lat_lon_rad = lat_lon(&fields, 2)?.filter(|_| quality.is_some_and(|quality| quality > 0));
    Ok(Report::Gga(Position {
        time: fields.time(1)?,
        lat_lon_rad,
        quality,
        satellites: fields.whole(7, 255)?.map(|count| count as u8),
        hdop: fields.number(8, 0.0, 1e4)?,
        height_geoid_m: fields.number(9, -1e5, 1e5)?,
        separation_m: fields.number(11, -1e3, 1e3)?,
    }))
}

fn vtg(body: &str) -> Result<Report, DamagedSentence> {
    let fields = Fields::new(body, 9)?;
    let course_rad = fields.direction_rad(1)?;
    let knots = fields.number(5, 0.0, FASTEST_MPS / MPS_PER_KNOT)?;
    let kmph = fields.number(7, 0.0, FASTEST_MPS / MPS_PER_KMPH)?;
    // Mode N: the values are not valid.
    if fields.letter(9, "ADEFMNPRS")? == Some('N') {
        return Ok(Report::Vtg { course_rad: None, speed_mps: None });
    }
    let speed_mps = kmph.map(|speed| speed * MPS_PER_KMPH).or(knots.map(|speed| speed * MPS_PER_KNOT));
    Ok(Report::Vtg { course_rad, speed_mps })
}

fn zda(body: &str) -> Result<Report, DamagedSentence> {
    let fields = Fields::new(body, 5)?;
    let date = (fields.whole(2, 31)?, fields.whole(3, 12)?, fields.whole(4, *YEARS.end())?);
    let midnight = match date {
        (Some(day), Some(month), Some(year)) => {
            Some(midnight(year, month, day).ok_or_else(|| fields.wrong(2))?)
        }
        (None, None, None) => None,
        (None, ..) => return Err(fields.wrong(2)),
        (_, None, _) => return Err(fields.wrong(3)),
        (.., None) => return Err(fields.wrong(4)),
    };
    Ok(Report::Zda(DateTime { time: fields.time(1)?, midnight }))
}

/// The beginning of a day; `None` where there is no such day, or before GPS began.
fn midnight(year: u32, month: u32, day: u32) -> Option<UtcTime> {
    let civil = Civil {
        year: Some(year).filter(|year| YEARS.contains(year))?.into(),
        month: u8::try_from(month).ok()?,
        day: u8::try_from(day).ok()?,
        hour: 0,
        minute: 0,
        second: 0,
        microsecond: 0,
    };
    UtcTime::from_civil(civil)
}

fn rot(body: &str) -> Result<Report, DamagedSentence> {
    let fields = Fields::new(body, 3)?;
    let degrees_per_minute = fields.number(1, -1e5, 1e5)?;
    let valid = fields.letter(2, "AV")? == Some('A');
    Ok(Report::Rot(degrees_per_minute.filter(|_| valid).map(|rate| (rate / 60.0).to_radians())))
}

fn rmc(body: &str) -> Result<Report, DamagedSentence> {
    let fields = Fields::new(body, 10)?;
    let valid = fields.letter(2, "AV")? == Some('A');
    let quality = match fields.letter(12, "ADEFMNPRS")? {
        _ if !valid => Some(0),
        None | Some('A') => Some(1),
        Some('D') => Some(2),
        Some('P') => Some(3),
        Some('R') => Some(4),
        Some('F') => Some(5),
        Some('E') => Some(6),
        Some('M') => Some(7),
        Some('S') => Some(8),
        Some(_) => Some(0),
    };
    let measured = quality != Some(0);
    let midnight = match fields.text(9) {
        "" => None,
        text => Some(short_date(text).ok_or_else(|| fields.wrong(9))?),
    };
    let speed_knots = fields.number(7, 0.0, FASTEST_MPS / MPS_PER_KNOT)?;
    Ok(Report::Rmc(Minimum {
        date: DateTime { time: fields.time(1)?, midnight },
        lat_lon_rad: lat_lon(&fields, 3)?.filter(|_| measured),
        quality,
        course_rad: fields.direction_rad(8)?.filter(|_| measured),
        speed_mps: speed_knots.filter(|_| measured).map(|speed| speed * MPS_PER_KNOT),
    }))
}

/// `ddmmyy`; years from 80 on are of the last century.
fn short_date(text: &str) -> Option<UtcTime> {
    if text.len() != 6 {
        return None;
    }
    let part = |from: usize| text.get(from..from + 2).and_then(whole);
    let (day, month, year) = (part(0)?, part(2)?, part(4)?);
    midnight(if year >= 80 { 1900 + year } else { 2000 + year }, month, day)
}

fn gsa(body: &str) -> Result<Report, DamagedSentence> {
    let fields = Fields::new(body, 18)?;
    let dilution = |index| fields.number(index, 0.0, 1e4);
    Ok(Report::Gsa(Precision { pdop: dilution(15)?, hdop: dilution(16)?, vdop: dilution(17)? }))
}

fn gst(body: &str) -> Result<Report, DamagedSentence> {
    let fields = Fields::new(body, 9)?;
    let error_m = |index| fields.number(index, 0.0, 1e8);
    Ok(Report::Gst(Errors {
        time: fields.time(1)?,
        lat_m: error_m(6)?,
        lon_m: error_m(7)?,
        height_m: error_m(8)?,
    }))
}

fn hpr(body: &str) -> Result<Report, DamagedSentence> {
    let fields = Fields::new(body, 7)?;
    // N: of GNSS. G: carried on by the gyro. Both are true headings.
    fields.letter(6, "NG")?;
    Ok(Report::Hpr(Attitude {
        time: fields.time(2)?,
        heading_rad: fields.direction_rad(3)?,
        pitch_rad: fields.tilt_rad(4)?,
        roll_rad: fields.tilt_rad(5)?,
        heave_m: None,
    }))
}

fn pashr(body: &str) -> Result<Report, DamagedSentence> {
    // Other sentences share the address: attitude has a time where they have a name.
    if body.split(',').nth(1).is_some_and(|first| !first.is_empty() && decimal(first).is_none()) {
        return Ok(Report::Other);
    }
    let fields = Fields::new(body, 11)?;
    let is_true = fields.letter(3, "TM")? != Some('M');
    Ok(Report::Pashr(Attitude {
        time: fields.time(1)?,
        heading_rad: fields.direction_rad(2)?.filter(|_| is_true),
        roll_rad: fields.tilt_rad(4)?,
        pitch_rad: fields.tilt_rad(5)?,
        heave_m: fields.number(6, -1e3, 1e3)?,
    }))
}
