//! The sentences of the Hemisphere V104s GNSS compass, byte for byte.
//!
//! Fields: NMEA 0183 (IEC 61162-1), as the DUNE task `Sensors.GPS` reads them from the Otters' V104s. Values
//! that the receiver does not have are empty fields. Sentences end in CR LF; the checksum is the exclusive or of
//! the bytes between `$` and `*`.

use crate::reading::{GnssFix, GnssReading, Quality};
use units::{Civil, UtcTime, wrap_two_pi};

const KNOTS_PER_MPS: f64 = 3600.0 / 1852.0;
const KMPH_PER_MPS: f64 = 3.6;

/// Values that the receiver takes from its models of the Earth at its position.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct EarthModel {
    /// Magnetic declination, east positive: leads from magnetic to true directions (rad).
    pub declination_rad: f64,
    /// Height of the geoid above the ellipsoid (m).
    pub separation_m: f64,
}

/// The talker of heading and rate-of-turn sentences, as the compass is configured; all others have the GNSS receiver's.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Talker {
    /// `GP`, a GPS receiver.
    #[default]
    Gp,
    /// `HE`, a gyro that seeks north.
    He,
}

impl Talker {
    const fn text(self) -> &'static str {
        match self {
            Self::Gp => "$GP",
            Self::He => "$HE",
        }
    }
}

/// The sentences the compass sends.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sentence {
    /// True heading.
    Hdt,
    /// Rate of turn.
    Rot,
    /// Magnetic heading.
    Hdm,
    /// Position, quality, satellites.
    Gga,
    /// Course and speed over ground.
    Vtg,
    /// Date and time.
    Zda,
    /// Heading, pitch and roll, in Hemisphere's own sentence `PSAT,HPR`.
    Hpr,
}

impl Sentence {
    /// All, in the order within one epoch.
    pub const ALL: [Self; 7] = [Self::Hdt, Self::Rot, Self::Hdm, Self::Gga, Self::Vtg, Self::Zda, Self::Hpr];

    /// The order in which the boats have them sent within one epoch.
    pub const EPOCH: [Self; 6] = [Self::Hdt, Self::Rot, Self::Hdm, Self::Gga, Self::Vtg, Self::Zda];

    /// The sentence that a command to the compass names, as `GPGGA`; the name holds with either talker.
    pub fn named(name: &str) -> Option<Self> {
        Some(match name {
            "GPHDT" => Self::Hdt,
            "GPROT" => Self::Rot,
            "GPHDM" => Self::Hdm,
            "GPGGA" => Self::Gga,
            "GPVTG" => Self::Vtg,
            "GPZDA" => Self::Zda,
            "GPHPR" => Self::Hpr,
            _ => return None,
        })
    }

    /// The whole sentence for a reading, from `$` to CR LF, with the talker of the satellites' receiver.
    pub fn encode(self, reading: &GnssReading, earth: &EarthModel) -> Vec<u8> {
        self.encode_from(Talker::Gp, reading, earth)
    }

    /// The same with another talker of heading and turn.
    pub fn encode_from(self, talker: Talker, reading: &GnssReading, earth: &EarthModel) -> Vec<u8> {
        let EarthModel { declination_rad, separation_m } = *earth;
        let mut text = String::with_capacity(96);
        if matches!(self, Self::Hdt | Self::Rot | Self::Hdm) {
            text.push_str(talker.text());
        }
        match self {
            Self::Hdt => heading(&mut text, "HDT,", ",T", reading.heading_rad),
            Self::Rot => rate_of_turn(&mut text, reading.yaw_rate_rad_s),
            Self::Hdm => {
                heading(&mut text, "HDM,", ",M", reading.heading_rad.map(|h| h - declination_rad));
            }
            Self::Hpr => attitude(&mut text, reading),
            Self::Gga => position(&mut text, reading, separation_m),
            Self::Vtg => course(&mut text, reading, declination_rad),
            Self::Zda => date(&mut text, reading),
        }
        let checksum = text.bytes().skip(1).fold(0, |sum, byte| sum ^ byte);
        text.push('*');
        for nibble in [checksum >> 4, checksum & 15] {
            text.push(char::from(b"0123456789ABCDEF"[usize::from(nibble)]));
        }
        text.push_str("\r\n");
        text.into_bytes()
    }
}

/// Appends a value with a fixed number of decimals; what is not a number as `NaN`. The same text as `{:.2}`
/// gives, but for exact halves, and several times faster, which the simulation's speed hangs on.
fn fixed(text: &mut String, value: f64, decimals: usize) {
    const SCALES: [u32; 3] = [1, 10, 100];
    if !value.is_finite() {
        text.push_str("NaN");
        return;
    }
    let scale = SCALES[decimals];
    // Values on this wire are far below 10^15, where every hundredth is still exact in 64 bits.
    let scaled = (value * f64::from(scale)).round();
    if scaled < 0.0 {
        text.push('-');
    }
    let scaled = scaled.abs() as u64;
    digits(text, scaled / u64::from(scale), 1);
    if decimals > 0 {
        text.push('.');
        digits(text, scaled % u64::from(scale), decimals);
    }
}

/// Appends a number with at least `width` digits.
fn digits(text: &mut String, mut number: u64, width: usize) {
    let mut buffer = [b'0'; 20];
    let mut first = buffer.len();
    while number > 0 {
        first -= 1;
        // A remainder below ten.
        buffer[first] = b'0' + (number % 10) as u8;
        number /= 10;
    }
    first = first.min(buffer.len() - width);
    text.extend(buffer[first..].iter().map(|&byte| char::from(byte)));
}

/// Degrees in [0, 360), two decimals; 359.996 is 0.00, not 360.00. A fault may make it no number.
fn degrees(angle_rad: f64) -> f64 {
    let rounded = (wrap_two_pi(angle_rad).to_degrees() * 100.0).round() / 100.0;
    if rounded >= 360.0 { 0.0 } else { rounded }
}

fn heading(text: &mut String, start: &str, end: &str, heading_rad: Option<f64>) {
    text.push_str(start);
    if let Some(heading_rad) = heading_rad {
        fixed(text, degrees(heading_rad), 2);
    }
    text.push_str(end);
}

fn rate_of_turn(text: &mut String, rate_radps: Option<f64>) {
    text.push_str("ROT,");
    let Some(rate_radps) = rate_radps else {
        text.push_str(",V");
        return;
    };
    fixed(text, rate_radps.to_degrees() * 60.0, 2);
    text.push_str(",A");
}

fn attitude(text: &mut String, reading: &GnssReading) {
    text.push_str("$PSAT,HPR,");
    clock(text, reading.utc.map(UtcTime::civil).as_ref());
    heading(text, ",", "", reading.heading_rad);
    for tilt_rad in [reading.pitch_rad, reading.roll_rad] {
        text.push(',');
        if let Some(tilt_rad) = tilt_rad {
            fixed(text, tilt_rad.to_degrees(), 2);
        }
    }
    text.push_str(",N");
}

/// Whole degrees and minutes with seven decimals, as ddmm.mmmmmmm or dddmm.mmmmmmm.
fn angle(text: &mut String, angle_deg: f64, width: usize, letters: [&str; 2]) {
    // Ten-millionths of a minute: 180° are 1.08e11, exact in both types.
    let total = (angle_deg.abs() * 60.0 * 1e7).round() as u64;
    let (degrees, rest) = (total / 600_000_000, total % 600_000_000);
    digits(text, degrees, width);
    digits(text, rest / 10_000_000, 2);
    text.push('.');
    digits(text, rest % 10_000_000, 7);
    text.push_str(letters[usize::from(angle_deg < 0.0)]);
}

/// The time of day; empty where the receiver has none.
fn clock(text: &mut String, civil: Option<&Civil>) {
    let Some(civil) = civil else { return };
    for part in [civil.hour, civil.minute, civil.second] {
        digits(text, u64::from(part), 2);
    }
    text.push('.');
    digits(text, u64::from(civil.microsecond / 10_000), 2);
}

fn position(text: &mut String, reading: &GnssReading, separation_m: f64) {
    text.push_str("$GPGGA,");
    clock(text, reading.utc.map(UtcTime::civil).as_ref());
    let Some(GnssFix { lat_rad, lon_rad, height_m, quality, hdop }) = reading.fix else {
        text.push_str(",,,,,0,");
        digits(text, u64::from(reading.satellites), 2);
        text.push_str(",,,M,,M,,");
        return;
    };
    text.push(',');
    angle(text, lat_rad.to_degrees(), 2, [",N,", ",S,"]);
    angle(text, lon_rad.to_degrees(), 3, [",E,", ",W,"]);
    digits(text, quality_digit(quality), 1);
    text.push(',');
    digits(text, u64::from(reading.satellites), 2);
    text.push(',');
    fixed(text, hdop, 1);
    text.push(',');
    fixed(text, height_m - separation_m, 2);
    text.push_str(",M,");
    fixed(text, separation_m, 2);
    text.push_str(",M,,");
}

/// Quality of a position as GGA has it.
const fn quality_digit(quality: Quality) -> u64 {
    match quality {
        Quality::Autonomous => 1,
        Quality::Differential => 2,
        Quality::RtkFixed => 4,
        Quality::RtkFloat => 5,
        Quality::Estimated => 6,
    }
}

fn course(text: &mut String, reading: &GnssReading, declination_rad: f64) {
    let Some(velocity) = reading.velocity else {
        text.push_str("$GPVTG,,T,,M,,N,,K,N");
        return;
    };
    text.push_str("$GPVTG,");
    fixed(text, degrees(velocity.course_rad), 2);
    text.push_str(",T,");
    fixed(text, degrees(velocity.course_rad - declination_rad), 2);
    text.push_str(",M,");
    fixed(text, velocity.speed_mps * KNOTS_PER_MPS, 2);
    text.push_str(",N,");
    fixed(text, velocity.speed_mps * KMPH_PER_MPS, 2);
    text.push_str(",K,");
    text.push(match reading.fix.map(|fix| fix.quality) {
        None => 'N',
        Some(Quality::Autonomous) => 'A',
        Some(Quality::Differential) => 'D',
        Some(Quality::RtkFixed) => 'R',
        Some(Quality::RtkFloat) => 'F',
        Some(Quality::Estimated) => 'E',
    });
}

fn date(text: &mut String, reading: &GnssReading) {
    text.push_str("$GPZDA,");
    let Some(civil) = reading.utc.map(UtcTime::civil) else {
        text.push_str(",,,,,");
        return;
    };
    clock(text, Some(&civil));
    text.push(',');
    digits(text, u64::from(civil.day), 2);
    text.push(',');
    digits(text, u64::from(civil.month), 2);
    text.push(',');
    // The sentence has four digits for the year; a simulation lies within them.
    digits(text, civil.year.unsigned_abs() % 10_000, 4);
    text.push_str(",00,00");
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reading::GroundVelocity;

    const EARTH: EarthModel = EarthModel { declination_rad: 3.5_f64.to_radians(), separation_m: 39.16 };

    fn text(sentence: Sentence, reading: &GnssReading) -> String {
        String::from_utf8(sentence.encode(reading, &EARTH)).unwrap()
    }

    fn reading() -> GnssReading {
        let civil = Civil { year: 2026, month: 11, day: 21, hour: 10, minute: 0, second: 0, microsecond: 0 };
        GnssReading {
            utc: UtcTime::from_civil(civil),
            fix: Some(GnssFix {
                lat_rad: (63.0_f64 + 26.43 / 60.0).to_radians(),
                lon_rad: (10.0_f64 + 21.036 / 60.0).to_radians(),
                height_m: 40.26,
                quality: Quality::Autonomous,
                hdop: 0.6,
            }),
            satellites: 7,
            velocity: Some(GroundVelocity { course_rad: 79.35_f64.to_radians(), speed_mps: 1.55 / 3.6 }),
            heading_rad: Some(81.01_f64.to_radians()),
            yaw_rate_rad_s: Some((-238.1_f64 / 60.0).to_radians()),
            ..GnssReading::default()
        }
    }

    #[test]
    fn sentences_are_those_of_the_made_log() {
        // The mode of VTG follows the quality of GGA.
        let expected = [
            "$GPHDT,81.01,T*3D\r\n",
            "$GPROT,-238.10,A*24\r\n",
            "$GPHDM,77.51,M*31\r\n",
            "$GPGGA,100000.00,6326.4300000,N,01021.0360000,E,1,07,0.6,1.10,M,39.16,M,,*60\r\n",
            "$GPVTG,79.35,T,75.85,M,0.84,N,1.55,K,A*29\r\n",
            "$GPZDA,100000.00,21,11,2026,00,00*62\r\n",
        ];
        for (sentence, expected) in Sentence::EPOCH.into_iter().zip(expected) {
            assert_eq!(text(sentence, &reading()), expected);
        }
    }

    #[test]
    fn fields_without_value_are_empty() {
        let blind = GnssReading {
            fix: None,
            satellites: 2,
            velocity: None,
            heading_rad: None,
            yaw_rate_rad_s: None,
            ..reading()
        };
        let bodies: Vec<String> = Sentence::EPOCH
            .into_iter()
            .map(|s| text(s, &blind).split('*').next().unwrap().to_owned())
            .collect();
        assert_eq!(
            bodies,
            [
                "$GPHDT,,T",
                "$GPROT,,V",
                "$GPHDM,,M",
                "$GPGGA,100000.00,,,,,0,02,,,M,,M,,",
                "$GPVTG,,T,,M,,N,,K,N",
                "$GPZDA,100000.00,21,11,2026,00,00",
            ]
        );
    }

    #[test]
    fn angles_carry_into_degrees_and_letters() {
        for (angle_deg, expected) in [
            (10.999_999_999_999, "01100.0000000,E,"),
            (-0.5, "00030.0000000,W,"),
            (-179.999_999_9, "17959.9999940,W,"),
            (0.0, "00000.0000000,E,"),
        ] {
            let mut text = String::new();
            angle(&mut text, angle_deg, 3, [",E,", ",W,"]);
            assert_eq!(text, expected);
        }
    }

    #[test]
    fn a_heading_just_short_of_north_is_zero() {
        let almost = GnssReading { heading_rad: Some(-1e-6), ..reading() };
        assert!(text(Sentence::Hdt, &almost).starts_with("$GPHDT,0.00,T*"));
    }

    #[test]
    fn fixed_decimals_are_those_of_the_library() {
        for value in [0.0, 1.0, 9.99, 9.999, -0.004, -0.006, 99.994, 359.99, -238.1, 12_345.678, 0.05] {
            let mut text = String::new();
            fixed(&mut text, value, 2);
            let expected = format!("{value:.2}");
            // A value that rounds to nothing has no sign here.
            assert_eq!(text, if expected == "-0.00" { "0.00" } else { &expected });
        }
        let mut text = String::new();
        fixed(&mut text, 7.25, 0);
        fixed(&mut text, 0.96, 1);
        fixed(&mut text, f64::NAN, 1);
        assert_eq!(text, "71.0NaN");
    }
}
