//! Sentences read, and epochs gathered of them.

use super::*;
use crate::{GnssReading, Quality};
use std::f64::consts::PI;

/// A whole sentence of a body, with its checksum.
fn sentence(body: &str) -> String {
    format!("${body}*{:02X}\r\n", body.bytes().fold(0, |sum, byte| sum ^ byte))
}

fn one(body: &str) -> Result<Report, DamagedSentence> {
    read(sentence(body).as_bytes())
}

/// The result of reading a stream: epochs, and damaged sentences with their offset.
fn gathered(stream: &[u8], chunk: usize) -> (Vec<Epoch>, Vec<(u64, DamagedSentence)>) {
    let (mut framer, mut epochs) = (Framer::default(), Epochs::default());
    let (mut found, mut damaged) = (Vec::new(), Vec::new());
    let mut take = |offset, read: Result<Report, DamagedSentence>| match read {
        Ok(report) => found.extend(epochs.take(&report)),
        Err(error) => damaged.push((offset, error)),
    };
    for bytes in stream.chunks(chunk) {
        framer.feed(bytes, &mut take);
    }
    framer.end(&mut take);
    found.extend(epochs.close());
    (found, damaged)
}

#[test]
fn public_lines_are_read() {
    // The first two and the fourth were published with these checksums; that of the third is known to be wrong.
    let Ok(Report::Gga(position)) =
        read(b"$GPGGA,123519,4807.038,N,01131.000,E,1,08,0.9,545.4,M,46.9,M,,*47")
    else {
        panic!("no GGA");
    };
    let (lat_rad, lon_rad) = position.lat_lon_rad.unwrap();
    assert!((lat_rad.to_degrees() - 48.1173).abs() < 1e-9);
    assert!((lon_rad.to_degrees() - 11.516_666_666_7).abs() < 1e-9);
    assert_eq!(
        (position.satellites, position.hdop, position.height_geoid_m),
        (Some(8), Some(0.9), Some(545.4))
    );
    let Ok(Report::Hpr(attitude)) = read(b"$PSAT,HPR,102143.00,356.881,-0.387,-0.4,N*1E") else {
        panic!("no HPR");
    };
    assert!((attitude.heading_rad.unwrap().to_degrees() - 356.881).abs() < 1e-9);
    let wrong = DamagedSentence::Checksum { stands: "3D".to_owned(), computed: 0x13 };
    assert_eq!(read(b"$PSAT,HPR,000002.00,184.19,,-1.73,N*3D"), Err(wrong));
    let Ok(Report::Zda(date)) = read(b"$GPZDA,235959.00,14,9,2010,+0,+0*58") else { panic!("no ZDA") };
    assert_eq!(date.midnight.unwrap().to_string(), "2010-09-14T00:00:00.000000Z");
}

#[test]
fn empty_fields_are_not_reported() {
    assert_eq!(one("GPHDT,,T"), Ok(Report::Hdt(None)));
    assert_eq!(one("GPROT,,V"), Ok(Report::Rot(None)));
    assert_eq!(one("GPVTG,,T,,M,,N,,K,N"), Ok(Report::Vtg { course_rad: None, speed_mps: None }));
    assert_eq!(one("GPZDA,,,,,,"), Ok(Report::Zda(DateTime::default())));
    let blind = Position { quality: Some(0), satellites: Some(2), ..Position::default() };
    assert_eq!(one("GPGGA,,,,,,0,02,,,M,,M,,"), Ok(Report::Gga(blind)));
    assert_eq!(
        one("GPRMC,,V,,,,,,,,,,N"),
        Ok(Report::Rmc(Minimum { quality: Some(0), ..Minimum::default() }))
    );
}

#[test]
fn quality_zero_is_no_position_whatever_is_repeated() {
    for (quality, expected) in [
        (0, None),
        (1, Some(Quality::Autonomous)),
        (2, Some(Quality::Differential)),
        (4, Some(Quality::RtkFixed)),
        (5, Some(Quality::RtkFloat)),
        (6, Some(Quality::Estimated)),
        (7, None),
        (8, None),
        (9, Some(Quality::Autonomous)),
    ] {
        let line =
            sentence(&format!("GNGGA,100000.00,6326.43,N,01021.036,E,{quality},07,0.6,1.10,M,39.16,M,,"));
        let (epochs, damaged) = gathered(line.as_bytes(), 7);
        assert_eq!(damaged, []);
        assert_eq!(epochs[0].reading().fix.map(|fix| fix.quality), expected, "quality {quality}");
        assert_eq!(epochs[0].quality, Some(quality));
    }
}

#[test]
fn fields_out_of_range_are_damage() {
    for body in [
        "GPGGA,100000.00,6360.43,N,01021.036,E,1,07,0.6,1.10,M,39.16,M,,",
        "GPGGA,100000.00,9126.43,N,01021.036,E,1,07,0.6,1.10,M,39.16,M,,",
        "GPGGA,100000.00,6326.43,N,18021.036,E,1,07,0.6,1.10,M,39.16,M,,",
        "GPGGA,100000.00,6326.43,,01021.036,E,1,07,0.6,1.10,M,39.16,M,,",
        "GPGGA,100000.00,6326.43,N,,,1,07,0.6,1.10,M,39.16,M,,",
        "GPGGA,250000.00,6326.43,N,01021.036,E,1,07,0.6,1.10,M,39.16,M,,",
        "GPGGA,100000.00,6326.43,N,01021.036,E,x,07,0.6,1.10,M,39.16,M,,",
        "GPGGA,100000.00,6326.43,N,01021.036,E,1",
        "GPZDA,100000.00,31,02,2026,00,00",
        "GPZDA,100000.00,21,13,2026,00,00",
        "GPZDA,100000.00,21,,2026,00,00",
        "GPZDA,100000.00,00,00,0000,00,00",
        "GPHDT,361.0,T",
        "GPHDT,NaN,T",
        "GPVTG,10,T,,M,1e1,N,-3,K,A",
        "GPRMC,100000,A,6326.43,N,01021.036,E,1.0,10.0,320126,,,A",
    ] {
        let error = one(body).unwrap_err();
        assert!(
            matches!(error, DamagedSentence::Field { .. } | DamagedSentence::TooFew { .. }),
            "{body}: {error}"
        );
    }
}

#[test]
fn other_sentences_are_known_by_their_checksum_only() {
    for body in ["GPGSV,3,1,11", "PSAT,GBS,1", "PUBX,00", "GPTXT,hello", "X"] {
        assert_eq!(one(body), Ok(Report::Other), "{body}");
    }
    for answer in ["$>", "$>JATT,NMEAHE,OK", "$> Save Complete"] {
        assert_eq!(read(answer.as_bytes()), Ok(Report::Other), "{answer}");
    }
    assert_eq!(read(b"$>\x80"), Err(DamagedSentence::NotText));
    assert_eq!(read(b"$GPHDT,81.01,T"), Err(DamagedSentence::NoChecksum));
    assert_eq!(read(b"GPHDT,81.01,T*3D"), Err(DamagedSentence::NoStart));
    assert_eq!(read(b"$GPHDT,\xff,T*3D"), Err(DamagedSentence::NotText));
}

#[test]
fn sentences_of_other_receivers_are_read() {
    let (epochs, damaged) = gathered(
        [
            sentence("GNRMC,093000.50,A,6326.43,N,01021.036,W,2.0,090.0,231126,,,F"),
            sentence("GNGSA,A,3,01,02,,,,,,,,,,,1.5,0.8,1.2"),
            sentence("GNGSA,A,3,71,72,,,,,,,,,,,1.5,0.8,1.2"),
            sentence("GNGST,093000.50,1.0,,,,0.5,0.4,0.9"),
            sentence("PASHR,093000.50,359.50,T,-1.25,0.50,0.10,0.1,0.1,0.2,2,1"),
        ]
        .concat()
        .as_bytes(),
        3,
    );
    assert_eq!(damaged, []);
    let [epoch] = epochs[..] else { panic!("{} epochs", epochs.len()) };
    assert_eq!(epoch.utc.unwrap().to_string(), "2026-11-23T09:30:00.500000Z");
    assert_eq!(epoch.reading().fix.unwrap().quality, Quality::RtkFloat);
    assert!(epoch.lat_lon_rad.unwrap().1 < 0.0);
    assert_eq!(epoch.hdop, Some(0.8));
    assert_eq!(epoch.errors.unwrap().lon_m, Some(0.4));
    assert!((epoch.speed_mps.unwrap() - 2.0 * 1852.0 / 3600.0).abs() < 1e-12);
    assert!((epoch.course_rad.unwrap() - PI / 2.0).abs() < 1e-12);
    assert!((epoch.heading_rad.unwrap().to_degrees() - 359.5).abs() < 1e-9);
    assert!((epoch.attitude.unwrap().roll_rad.unwrap().to_degrees() + 1.25).abs() < 1e-9);
}

#[test]
fn the_made_recording_gives_the_expected_values() {
    let Some(path) = testkit::shared("data/onboard/v104s_made.nmea") else { return };
    let stream = std::fs::read(&path).unwrap();
    let expected = std::fs::read_to_string(path.with_file_name("v104s_made_expected.csv")).unwrap();
    let (epochs, damaged) = gathered(&stream, 13);
    assert_eq!(damaged, []);
    let rows: Vec<Vec<f64>> = expected
        .lines()
        .skip(1)
        .map(|row| row.split(',').map(|cell| cell.parse().unwrap()).collect())
        .collect();
    assert_eq!((epochs.len(), rows.len()), (20, 20));
    for (epoch, row) in epochs.iter().zip(&rows) {
        let (lat_rad, lon_rad) = epoch.lat_lon_rad.unwrap();
        let values = [
            epoch.time.unwrap().micros as f64 / 1e6,
            lat_rad,
            lon_rad,
            f64::from(epoch.quality.unwrap()),
            f64::from(epoch.satellites.unwrap()),
            epoch.hdop.unwrap(),
            epoch.height_m.unwrap(),
            units::wrap_pi(epoch.course_rad.unwrap()),
            epoch.speed_mps.unwrap(),
            units::wrap_pi(epoch.heading_rad.unwrap()),
            units::wrap_pi(epoch.magnetic_heading_rad.unwrap()),
            epoch.yaw_rate_rad_s.unwrap(),
        ];
        for (column, (value, expected)) in values.iter().zip(row).enumerate() {
            assert!((value - expected).abs() < 1e-6, "column {column}: {value} for {expected}");
        }
        assert_eq!(epoch.utc, epoch.carried_utc);
        assert!(epoch.utc.unwrap().to_string().starts_with("2026-11-21T10:00:"));
    }
}

/// Twenty seconds of the simulator's sentences, in an order of one's own for each second.
fn made(order: impl Fn(usize) -> Vec<Sentence>) -> Vec<(usize, Sentence, Vec<u8>)> {
    let start = units::UtcTime::from_micros(1_795_000_000_000_000);
    let mut made = Vec::new();
    for second in 0..20 {
        let reading = GnssReading {
            utc: Some(units::UtcTime::from_micros(start.micros() + second as i64 * 1_000_000)),
            heading_rad: Some((second as f64).to_radians()),
            yaw_rate_rad_s: Some(0.0),
            ..GnssReading::default()
        };
        for kind in order(second) {
            made.push((second, kind, kind.encode(&reading, &EarthModel::default())));
        }
    }
    made
}

fn headings(sentences: &[(usize, Sentence, Vec<u8>)]) -> Vec<Option<f64>> {
    let stream: Vec<u8> = sentences.iter().flat_map(|(_, _, bytes)| bytes.clone()).collect();
    let (epochs, damaged) = gathered(&stream, 50);
    assert_eq!(damaged, []);
    epochs.iter().map(|epoch| epoch.heading_rad.map(|heading| heading.to_degrees().round())).collect()
}

#[test]
fn any_order_of_sentences_makes_the_same_epochs() {
    let shuffled = made(|second| {
        let mut order = Sentence::EPOCH.to_vec();
        order.rotate_left(second % 5);
        order.swap(1, second % 6);
        order
    });
    let expected: Vec<Option<f64>> = (0..20).map(|second| Some(f64::from(second))).collect();
    assert_eq!(headings(&shuffled), expected);
}

#[test]
fn a_lost_sentence_mixes_no_epochs() {
    for lost in Sentence::EPOCH {
        let mut sentences = made(|_| Sentence::EPOCH.to_vec());
        sentences.retain(|&(second, kind, _)| !(second == 10 && kind == lost));
        let expected: Vec<Option<f64>> = (0..20)
            .map(|second| Some(f64::from(second)).filter(|_| second != 10 || lost != Sentence::Hdt))
            .collect();
        assert_eq!(headings(&sentences), expected, "{lost:?}");
    }
}

#[test]
fn the_date_is_carried_over_midnight() {
    let stream = [
        sentence("GPZDA,235958.00,28,02,2027,00,00"),
        sentence("GPGGA,235959.00,6326.43,N,01021.036,E,1,07,0.6,1.10,M,39.16,M,,"),
        sentence("GPGGA,000000.00,6326.43,N,01021.036,E,1,07,0.6,1.10,M,39.16,M,,"),
    ]
    .concat();
    let (epochs, _) = gathered(stream.as_bytes(), 1);
    assert_eq!(epochs[1].utc, None);
    assert_eq!(epochs[1].carried_utc.unwrap().to_string(), "2027-02-28T23:59:59.000000Z");
    assert_eq!(epochs[2].carried_utc.unwrap().to_string(), "2027-03-01T00:00:00.000000Z");
}

#[test]
fn damage_is_told_in_place_and_what_follows_is_read() {
    let good = sentence("GPHDT,81.01,T");
    let endless = format!("$GP{}", "x".repeat(10_000));
    let stream = format!("noise{good}$GPHDT,8{good}$GPHDT,82.01,T*3D\r\n{endless}{good}$GPHDT,81.01,T*3D");
    for chunk in [1, 2, 9, 100_000] {
        let (epochs, damaged) = gathered(stream.as_bytes(), chunk);
        assert_eq!(epochs.len(), 4);
        let second = 5 + good.len() as u64;
        let third = second + 8 + good.len() as u64;
        let fourth = third + good.len() as u64;
        let expected = [
            (second, DamagedSentence::Unended),
            (third, DamagedSentence::Checksum { stands: "3D".to_owned(), computed: 0x3E }),
            (fourth, DamagedSentence::TooLong),
        ];
        assert_eq!(damaged, expected, "{chunk}");
    }
}

/// The reading of one epoch of these bodies.
fn reading_of(bodies: &[&str]) -> crate::GnssReading {
    let with_sum = |body: &&str| {
        let sum = body.bytes().fold(0, |sum, byte| sum ^ byte);
        format!("${body}*{sum:02X}\r\n")
    };
    let stream: String = bodies.iter().map(with_sum).collect();
    let (mut framer, mut epochs) = (Framer::default(), Epochs::default());
    framer.feed(stream.as_bytes(), |_, read| {
        epochs.take(&read.unwrap());
    });
    epochs.close().unwrap().reading()
}

#[test]
fn a_receiver_that_stands_leaves_its_course_empty_and_has_a_velocity_all_the_same() {
    let velocity = |body: &str| reading_of(&[body]).velocity;
    let standing = velocity("GPVTG,,T,,M,0.00,N,0.00,K,A").unwrap();
    assert!(standing.stands() && standing.speed_mps == 0.0);
    assert!(velocity("GPVTG,,T,,M,0.10,N,0.18,K,A").unwrap().stands());
    // At a higher speed without a course, the velocity is unknown.
    assert_eq!(velocity("GPVTG,,T,,M,0.50,N,0.93,K,A"), None);
    assert_eq!(velocity("GPVTG,,T,,M,,N,,K,N"), None);
    let slow = velocity("GPVTG,90.0,T,,M,0.00,N,0.00,K,A").unwrap();
    assert!(!slow.stands() && (slow.course_rad - std::f64::consts::FRAC_PI_2).abs() < 1e-12);
}

#[test]
fn roll_pitch_and_the_magnetic_heading_are_in_the_reading() {
    let hpr = reading_of(&["PSAT,HPR,102143.00,356.881,-0.387,-0.4,N", "GPHDM,353.4,M"]);
    let deg = |value: Option<f64>| value.unwrap().to_degrees();
    assert!(
        (deg(hpr.heading_rad) - 356.881).abs() < 1e-9 && (deg(hpr.magnetic_heading_rad) - 353.4).abs() < 1e-9
    );
    assert!((deg(hpr.pitch_rad) + 0.387).abs() < 1e-9 && (deg(hpr.roll_rad) + 0.4).abs() < 1e-9);
    let pashr = reading_of(&["PASHR,102143.00,12.5,T,1.5,-2.25,0.1,0.2,0.2,0.3,1"]);
    assert!((deg(pashr.roll_rad) - 1.5).abs() < 1e-9 && (deg(pashr.pitch_rad) + 2.25).abs() < 1e-9);
    assert_eq!(reading_of(&["GPHDM,,M"]).magnetic_heading_rad, None);
}
