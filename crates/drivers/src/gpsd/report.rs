//! gpsd's reports as values: TPV, SKY and ATT (gpsd_json(5)). What a report leaves out is `None`.

use devices::{GnssReading, nmea};
use serde_json::Value;
use units::{UtcTime, wrap_two_pi};

/// A report.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Report {
    /// TPV: time, position, velocity.
    Position(Box<Position>),
    /// SKY: satellites.
    Sky(Sky),
    /// ATT: heading, rate of turn.
    Attitude(Attitude),
    /// DEVICES: how many receivers gpsd has.
    Devices(usize),
    /// ERROR: a command was not understood.
    Error(String),
}

/// Time, position and velocity; `epoch` holds them as a sentence's values are held.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Position {
    epoch: nmea::Epoch,
}

/// Satellites and dilution.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Sky {
    hdop: Option<f64>,
    used: Option<u8>,
}

/// Heading and rate of turn.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Attitude {
    heading_rad: Option<f64>,
    yaw_rate_rad_s: Option<f64>,
}

impl Attitude {
    /// With what is known already where this report has nothing.
    pub(super) fn over(self, known: Self) -> Self {
        Self {
            heading_rad: self.heading_rad.or(known.heading_rad),
            yaw_rate_rad_s: self.yaw_rate_rad_s.or(known.yaw_rate_rad_s),
        }
    }
}

impl Position {
    /// The reading of it, with what fresh reports of other kinds say.
    pub(super) fn reading(&self, sky: Option<Sky>, attitude: Option<Attitude>) -> GnssReading {
        let sky = sky.unwrap_or_default();
        let attitude = attitude.unwrap_or_default();
        let epoch = nmea::Epoch {
            hdop: self.epoch.hdop.or(sky.hdop),
            satellites: sky.used,
            heading_rad: attitude.heading_rad,
            yaw_rate_rad_s: attitude.yaw_rate_rad_s,
            ..self.epoch
        };
        epoch.reading()
    }
}

/// Reads a line; `None` for reports that the driver does not use, and for other lines.
pub(super) fn read(line: &[u8]) -> Option<Report> {
    let value: Value = serde_json::from_slice(line).ok()?;
    match value["class"].as_str()? {
        "TPV" => Some(Report::Position(Box::new(position(&value)))),
        "SKY" => Some(Report::Sky(sky(&value))),
        "ATT" => Some(Report::Attitude(attitude(&value))),
        "DEVICES" => Some(Report::Devices(value["devices"].as_array()?.len())),
        "ERROR" => Some(Report::Error(value["message"].as_str()?.chars().take(120).collect())),
        _ => None,
    }
}

fn position(value: &Value) -> Position {
    let number = |key: &str| value[key].as_f64();
    let has_fix = value["mode"].as_u64().is_some_and(|mode| mode >= 2);
    let quality = if has_fix { quality(value["status"].as_u64()) } else { 0 };
    let valid = |lat: &f64, lon: &f64| lat.abs() <= 90.0 && lon.abs() <= 180.0;
    let lat_lon = number("lat").zip(number("lon")).filter(|(lat, lon)| has_fix && valid(lat, lon));
    let utc = value["time"].as_str().and_then(|text| text.parse::<UtcTime>().ok());
    let epoch = nmea::Epoch {
        utc,
        carried_utc: utc,
        lat_lon_rad: lat_lon.map(|(lat, lon)| (lat.to_radians(), lon.to_radians())),
        quality: Some(quality),
        height_m: number("altHAE"),
        course_rad: number("track").map(|track| wrap_two_pi(track.to_radians())),
        speed_mps: number("speed"),
        positional: true,
        ..nmea::Epoch::default()
    };
    Position { epoch }
}

/// GGA's number of gpsd's status; a fix without one is autonomous.
const fn quality(status: Option<u64>) -> u8 {
    match status {
        Some(2) => 2,
        Some(3) => 4,
        Some(4) => 5,
        // Dead reckoning, alone or with satellites.
        Some(5 | 6) => 6,
        // A surveyed place, for time alone.
        Some(7) => 7,
        Some(8) => 8,
        _ => 1,
    }
}

fn sky(value: &Value) -> Sky {
    let counted = || {
        let satellites = value["satellites"].as_array()?;
        Some(satellites.iter().filter(|one| one["used"] == true).count() as u64)
    };
    let used = value["uSat"].as_u64().or_else(counted);
    Sky { hdop: value["hdop"].as_f64(), used: used.and_then(|used| u8::try_from(used).ok()) }
}

fn attitude(value: &Value) -> Attitude {
    Attitude {
        heading_rad: value["heading"].as_f64().map(|heading| wrap_two_pi(heading.to_radians())),
        // Degrees a minute, as ROT has them.
        yaw_rate_rad_s: value["rot"].as_f64().map(|rate| (rate / 60.0).to_radians()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use devices::Quality;

    #[test]
    fn a_report_of_rtk_is_a_reading() {
        let line =
            br#"{"class":"TPV","mode":3,"status":3,"time":"2026-11-21T10:00:01.000Z","lat":63.5,"lon":10.25,
            "altHAE":38.77,"track":270.0,"speed":1.5}"#;
        let Some(Report::Position(position)) = read(line) else { panic!("no TPV") };
        let Some(Report::Sky(sky)) =
            read(br#"{"class":"SKY","hdop":0.8,"satellites":[{"used":true},{"used":false}]}"#)
        else {
            panic!("no SKY")
        };
        let Some(Report::Attitude(heading)) = read(br#"{"class":"ATT","heading":90.0}"#) else {
            panic!("no ATT")
        };
        let Some(Report::Attitude(rate)) = read(br#"{"class":"ATT","rot":60.0}"#) else { panic!("no ATT") };
        let reading = position.reading(Some(sky), Some(rate.over(heading)));
        let fix = reading.fix.unwrap();
        assert_eq!((fix.quality, fix.hdop, reading.satellites), (Quality::RtkFixed, 0.8, 1));
        assert!((fix.lat_rad.to_degrees() - 63.5).abs() < 1e-9);
        assert!((reading.heading_rad.unwrap().to_degrees() - 90.0).abs() < 1e-9);
        assert!((reading.yaw_rate_rad_s.unwrap().to_degrees() - 1.0).abs() < 1e-9);
        assert_eq!(reading.utc.unwrap().to_string(), "2026-11-21T10:00:01.000000Z");
    }

    #[test]
    fn without_a_fix_there_is_no_position() {
        let line = br#"{"class":"TPV","mode":1,"lat":63.5,"lon":10.25}"#;
        let Some(Report::Position(position)) = read(line) else { panic!("no TPV") };
        assert_eq!(position.reading(None, None).fix, None);
        for line in [
            &b"{"[..],
            b"{}",
            b"[1]",
            br#"{"class":1}"#,
            br#"{"class":"VERSION"}"#,
            br#"{"class":"DEVICES"}"#,
        ] {
            assert_eq!(read(line), None);
        }
    }
}
