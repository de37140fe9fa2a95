//! Decoders against recordings, and their output.

use super::*;
use serde_json::{Value, json};
use std::os::unix::fs::PermissionsExt as _;
use units::UtcTime;

/// The JSON lines of a stream, cut in chunks.
fn lines(device: Device, stream: &[u8]) -> Vec<Value> {
    let mut decoder = device.decoder(None, None).unwrap();
    let mut found = Vec::new();
    for bytes in stream.chunks(11) {
        decoder.feed(bytes, &mut found);
    }
    decoder.end(&mut found);
    assert!(found.iter().all(|one| !one.text.is_empty()));
    found.into_iter().map(|one| one.json).collect()
}

#[test]
fn epochs_of_the_made_recording_are_those_expected() {
    let Some(path) = testkit::shared("data/onboard/v104s_made.nmea") else { return };
    let found = lines(Device::Gnss, &std::fs::read(&path).unwrap());
    let expected = std::fs::read_to_string(path.with_file_name("v104s_made_expected.csv")).unwrap();
    assert_eq!(found.len(), 20);
    for (epoch, row) in found.iter().zip(expected.lines().skip(1)) {
        let row: Vec<f64> = row.split(',').map(|cell| cell.parse().unwrap()).collect();
        let near = |key: &str, expected: f64| {
            let value = epoch[key].as_f64().unwrap();
            assert!((value - expected).abs() < 1e-6, "{key}: {value} for {expected}");
        };
        near("lat_deg", row[1].to_degrees());
        near("lon_deg", row[2].to_degrees());
        near("quality", row[3]);
        near("sats", row[4]);
        near("hdop", row[5]);
        near("cog_rad", units::wrap_two_pi(row[7]));
        near("sog_mps", row[8]);
        near("heading_rad", units::wrap_two_pi(row[9]));
        near("rot_rad_s", row[11]);
        let utc: UtcTime = epoch["utc"].as_str().unwrap().parse().unwrap();
        assert_eq!(utc.micros().rem_euclid(86_400_000_000), (row[0] * 1e6).round() as i64);
        assert_eq!(epoch["t"], epoch["utc"]);
        assert_eq!(epoch.as_object().unwrap().len(), 11);
    }
}

#[test]
fn what_an_epoch_does_not_report_is_absent() {
    let found = lines(Device::Gnss, b"$GPHDT,,T*1B\r\n$GPGGA,,,,,,0,02,,,M,,M,,*64\r\n$GPHDT,81.01,T*3D\r\n");
    assert_eq!(found[0], json!({"quality": 0, "sats": 2}));
    let second = found[1].as_object().unwrap();
    assert_eq!(second.keys().collect::<Vec<_>>(), ["heading_rad"]);
}

#[test]
fn damage_stands_in_place_with_its_offset() {
    let found = lines(Device::Gnss, b"$GPHDT,81.01,T*3D\r\n$GPHDT,82.01,T*3D\r\n$GPHDT,81.01,T*3D\r\n");
    assert_eq!(found[0], json!({"error": "checksum 3D, computed 3E", "offset": 19}));
    assert_eq!(found.len(), 3);
    let found = lines(Device::Tbr, b"ack01\r$000025,1\rack02\r");
    assert_eq!(found[0], json!({"kind": "reply", "text": "ack01"}));
    assert_eq!(found[1], json!({"error": "2 fields make no line of this receiver", "offset": 6}));
    assert_eq!(found[2], json!({"kind": "reply", "text": "ack02"}));
}

#[test]
fn a_port_stamps_epochs_with_their_arrival() {
    let clock = Clock::of(|| std::time::Duration::ZERO, || UtcTime::from_micros(1_000_000));
    let mut decoder = Device::Gnss.decoder(Some(clock), None).unwrap();
    let mut found = Vec::new();
    decoder.feed(b"$GPHDT,81.01,T*3D\r\n", &mut found);
    decoder.end(&mut found);
    assert_eq!(found[0].json["t"], "1970-01-01T00:00:01.000000Z");
    assert!(found[0].json.get("utc").is_none());
}

#[test]
fn hydrophone_lines_have_their_keys() {
    let found = lines(
        Device::Tbr,
        b"$1000042,0000000600,TBR Sensor,297,15,29,69,6\r$1000042,0000002185,897,R64K,1023,,24,69,9\r",
    );
    assert_eq!(
        found[0],
        json!({"kind": "sensor", "serial": 1_000_042, "utc_s": 600, "temperature_c": 24.7, "noise_avg": 15,
            "noise_peak": 29, "freq_khz": 69})
    );
    assert_eq!(
        found[1],
        json!({"kind": "detection", "serial": 1_000_042, "utc_s": 2185, "ms": 897, "protocol": "R64K", "id": 1023,
            "data": null, "snr": 24, "freq_khz": 69})
    );
}

#[test]
fn every_recording_of_hydrophones_comes_out_whole() {
    for folder in ["data/onboard", "data/acoustics/raw"] {
        let Some(folder) = testkit::shared(folder) else { return };
        for entry in std::fs::read_dir(folder).unwrap() {
            let path = entry.unwrap().path();
            let name = path.file_name().unwrap().to_string_lossy().into_owned();
            if !(name.starts_with("thelma") || name.starts_with("otter_20")) {
                continue;
            }
            let stream = std::fs::read(&path).unwrap();
            let found = lines(Device::Tbr, &stream);
            let written = String::from_utf8(stream).unwrap();
            let sensors = written.lines().filter(|line| line.contains("TBR Sensor")).count();
            let of = |kind: &str| found.iter().filter(|one| one["kind"] == kind).count();
            assert_eq!(of("sensor"), sensors, "{name}");
            assert_eq!(of("detection"), written.lines().count() - sensors, "{name}");
            assert_eq!(found.len(), written.lines().count(), "{name}");
        }
    }
}

#[test]
fn a_reader_that_goes_away_ends_it_quietly() {
    let (reader, writer) = std::io::pipe().unwrap();
    drop(reader);
    let mut decoder = Device::Tbr.decoder(None, None).unwrap();
    let outcome = copy(&mut &b"ack01\r"[..], decoder.as_mut(), &mut { writer }, true);
    assert!(matches!(outcome, Err(Stopped::Unread)));
}

#[test]
fn a_source_that_cannot_be_opened_says_what_to_do() {
    let folder = tempfile::tempdir().unwrap();
    let error = |path: &std::path::Path| format!("{:#}", Source::open(path, None, 19_200).unwrap_err());
    assert!(error(&folder.path().join("absent")).contains("check the name"));
    assert!(error(std::path::Path::new("/dev/serial/by-id/absent")).contains("there is no"));
    assert!(error(folder.path()).contains("is a folder"));
    let secret = folder.path().join("secret");
    std::fs::write(&secret, "x").unwrap();
    std::fs::set_permissions(&secret, std::fs::Permissions::from_mode(0o000)).unwrap();
    if std::fs::File::open(&secret).is_err() {
        assert!(error(&secret).contains("you may read it"));
    } else {
        println!("the check of a file without permission is skipped: this user may read everything");
    }
}

#[test]
fn innovaseas_lines_have_the_same_keys() {
    let found = lines(
        Device::Rxlive,
        b"450123,018,2026-09-21 12:43:52,A69-1105,77,131,#00\r\n\
          457777,204,2026-09-21 12:44:02.317,A69-1602,48211,S=61,N=34,C=0,#C8\r\n\
          457777,204,2026-09-21 12:44:02.317,A69-1602,48212,S=61,N=34,C=0,#C8\r\n",
    );
    assert_eq!(
        found[0],
        json!({"kind": "detection", "serial": 450_123, "utc_s": 1_789_994_632, "ms": 0, "protocol": "A69-1105",
            "id": 77, "data": 131, "freq_khz": 69})
    );
    assert_eq!(
        (&found[1]["snr"], &found[1]["data"], &found[1]["ms"]),
        (&json!(27), &Value::Null, &json!(317))
    );
    assert_eq!(found[2], json!({"error": "checksum C8, computed C9", "offset": 121}));
}

#[test]
fn a_declared_receiver_is_read_by_its_pattern() {
    let pattern = Pattern::parse("{id};{unix_s};{data?}").unwrap();
    let mut decoder = Device::Pattern.decoder(None, Some(&pattern)).unwrap();
    let mut found = Vec::new();
    decoder.feed(b"7;1551087572;\n8;x;\n9;1551087573;5", &mut found);
    decoder.end(&mut found);
    let ids: Vec<Option<u64>> = found.iter().map(|one| one.json["id"].as_u64()).collect();
    assert_eq!(ids, [Some(7), None, Some(9)]);
    assert_eq!((&found[0].json["data"], &found[2].json["data"]), (&Value::Null, &json!(5)));
    assert!(["serial", "protocol", "snr", "freq_khz"].iter().all(|key| found[0].json.get(key).is_none()));
    assert_eq!((&found[1].json["offset"], &found[2].json["raw"]), (&json!(14), &json!("9;1551087573;5")));
}

#[test]
fn ports_have_the_speeds_that_the_shipped_configuration_gives_them() {
    for (device, section) in [(Device::Gnss, "Sensors.GPS"), (Device::Tbr, "Sensors.ThelmaHydrophone")] {
        let configured = config::schema::otter_value(section, "Serial Port - Baud Rate").unwrap();
        assert_eq!(device.baud().to_string(), configured, "{device:?}");
    }
}
