//! The sentences of the Hemisphere V104s GNSS compass, byte for byte.
//!
//! Fields: NMEA 0183 (IEC 61162-1) and the table of facts/onboard.md section 2.1; widths and decimals as in
//! data/onboard/v104s_made.nmea. Values that the receiver does not have are empty fields. Sentences end in
//! CR LF; the checksum is the exclusive or of the bytes between `$` and `*`.

use crate::gnss::{GnssFix, GnssReading};
use std::fmt::Write as _;
use units::wrap_two_pi;

const KNOTS_PER_MPS: f64 = 3600.0 / 1852.0;
const KMPH_PER_MPS: f64 = 3.6;

/// The sentences the simulated compass sends.
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
}

impl Sentence {
    /// The order in which the boats have them sent within one epoch.
    pub const EPOCH: [Self; 6] = [Self::Hdt, Self::Rot, Self::Hdm, Self::Gga, Self::Vtg, Self::Zda];

    /// The whole sentence for a reading, from `$` to CR LF; `declination_rad` (east positive) leads from true
    /// to magnetic directions.
    pub fn encode(self, reading: &GnssReading, declination_rad: f64) -> Vec<u8> {
        let mut text = String::with_capacity(96);
        // Writing to a string cannot fail.
        let _ = match self {
            Self::Hdt => heading(&mut text, "HDT", 'T', reading.heading_rad),
            Self::Rot => rate_of_turn(&mut text, reading.rate_of_turn_radps),
            Self::Hdm => heading(&mut text, "HDM", 'M', reading.heading_rad.map(|h| h - declination_rad)),
            Self::Gga => position(&mut text, reading),
            Self::Vtg => course(&mut text, reading, declination_rad),
            Self::Zda => date(&mut text, reading),
        };
        let checksum = text.bytes().skip(1).fold(0, |sum, byte| sum ^ byte);
        let _ = write!(text, "*{checksum:02X}\r\n");
        text.into_bytes()
    }
}

/// Degrees in [0, 360), two decimals; 359.996 is 0.00, not 360.00. A fault may make it no number.
fn degrees(angle_rad: f64) -> f64 {
    let rounded = (wrap_two_pi(angle_rad).to_degrees() * 100.0).round() / 100.0;
    if rounded >= 360.0 { 0.0 } else { rounded }
}

fn heading(text: &mut String, name: &str, letter: char, heading_rad: Option<f64>) -> std::fmt::Result {
    match heading_rad {
        Some(heading_rad) => write!(text, "$GP{name},{:.2},{letter}", degrees(heading_rad)),
        None => write!(text, "$GP{name},,{letter}"),
    }
}

fn rate_of_turn(text: &mut String, rate_radps: Option<f64>) -> std::fmt::Result {
    match rate_radps {
        Some(rate_radps) => write!(text, "$GPROT,{:.2},A", rate_radps.to_degrees() * 60.0),
        None => write!(text, "$GPROT,,V"),
    }
}

/// Whole degrees and minutes with seven decimals, as ddmm.mmmmmmm or dddmm.mmmmmmm.
fn angle(text: &mut String, angle_deg: f64, width: usize, letters: [char; 2]) -> std::fmt::Result {
    // Ten-millionths of a minute: 180° are 1.08e11, exact in both types.
    let total = (angle_deg.abs() * 60.0 * 1e7).round() as u64;
    let (degrees, rest) = (total / 600_000_000, total % 600_000_000);
    let letter = letters[usize::from(angle_deg < 0.0)];
    write!(text, "{degrees:0width$}{:02}.{:07},{letter}", rest / 10_000_000, rest % 10_000_000)
}

fn clock(text: &mut String, reading: &GnssReading) -> std::fmt::Result {
    let civil = reading.utc.civil();
    let hundredths = civil.microsecond / 10_000;
    write!(text, "{:02}{:02}{:02}.{hundredths:02}", civil.hour, civil.minute, civil.second)
}

fn position(text: &mut String, reading: &GnssReading) -> std::fmt::Result {
    text.push_str("$GPGGA,");
    clock(text, reading)?;
    let Some(GnssFix { place, height_m, separation_m, quality, satellites, hdop }) = reading.fix else {
        return write!(text, ",,,,,0,{:02},,,M,,M,,", reading.satellites_seen);
    };
    text.push(',');
    angle(text, place.lat_deg(), 2, ['N', 'S'])?;
    text.push(',');
    angle(text, place.lon_deg(), 3, ['E', 'W'])?;
    write!(text, ",{},{satellites:02},{hdop:.1},{height_m:.2},M,{separation_m:.2},M,,", quality.digit())
}

fn course(text: &mut String, reading: &GnssReading, declination_rad: f64) -> std::fmt::Result {
    let Some(velocity) = reading.velocity else {
        return write!(text, "$GPVTG,,T,,M,,N,,K,N");
    };
    let mode = reading.fix.map_or('N', |fix| fix.quality.mode());
    write!(
        text,
        "$GPVTG,{:.2},T,{:.2},M,{:.2},N,{:.2},K,{mode}",
        degrees(velocity.course_rad),
        degrees(velocity.course_rad - declination_rad),
        velocity.speed_mps * KNOTS_PER_MPS,
        velocity.speed_mps * KMPH_PER_MPS,
    )
}

fn date(text: &mut String, reading: &GnssReading) -> std::fmt::Result {
    text.push_str("$GPZDA,");
    clock(text, reading)?;
    let civil = reading.utc.civil();
    write!(text, ",{:02},{:02},{:04},00,00", civil.day, civil.month, civil.year)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::gnss::{GroundVelocity, Quality};
    use units::{Civil, LatLon, UtcTime};

    fn text(sentence: Sentence, reading: &GnssReading) -> String {
        String::from_utf8(sentence.encode(reading, 3.5_f64.to_radians())).unwrap()
    }

    fn reading() -> GnssReading {
        let civil = Civil { year: 2026, month: 11, day: 21, hour: 10, minute: 0, second: 0, microsecond: 0 };
        GnssReading {
            utc: UtcTime::from_civil(civil).unwrap(),
            fix: Some(GnssFix {
                place: LatLon::from_deg(63.0 + 26.43 / 60.0, 10.0 + 21.036 / 60.0).unwrap(),
                height_m: 1.1,
                separation_m: 39.16,
                quality: Quality::Autonomous,
                satellites: 7,
                hdop: 0.6,
            }),
            satellites_seen: 7,
            velocity: Some(GroundVelocity { course_rad: 79.35_f64.to_radians(), speed_mps: 1.55 / 3.6 }),
            heading_rad: Some(81.01_f64.to_radians()),
            rate_of_turn_radps: Some((-238.1_f64 / 60.0).to_radians()),
        }
    }

    #[test]
    fn sentences_are_those_of_the_made_log() {
        // First epoch of data/onboard/v104s_made.nmea but for the mode of VTG, which here follows GGA.
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
            satellites_seen: 2,
            velocity: None,
            heading_rad: None,
            rate_of_turn_radps: None,
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
            (10.999_999_999_999, "01100.0000000,E"),
            (-0.5, "00030.0000000,W"),
            (-179.999_999_9, "17959.9999940,W"),
            (0.0, "00000.0000000,E"),
        ] {
            let mut text = String::new();
            angle(&mut text, angle_deg, 3, ['E', 'W']).unwrap();
            assert_eq!(text, expected);
        }
    }

    #[test]
    fn a_heading_just_short_of_north_is_zero() {
        let almost = GnssReading { heading_rad: Some(-1e-6), ..reading() };
        assert!(text(Sentence::Hdt, &almost).starts_with("$GPHDT,0.00,T*"));
    }
}
