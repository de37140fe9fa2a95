use super::*;
use crate::{About, LUTRA, Lag, Writer, format};
use ::bytes::Bytes;
use api::{RegisterReceiver, RegisterRecord};
use detections::{ClockState, Effort, Maker, Noise, Origin, Pose, Protocol, ReceiverClock};
use imc::Address;
use proptest::prelude::*;
use tables::Dialect;
use units::{LatLon, UtcTime};

/// 2026-11-21 08:00 UTC.
const START_US: i64 = 1_795_248_000_000_000;
const STATION: u16 = 0x1C01;

fn study() -> Study {
    Study::new([
        RegisterRecord::Receiver(RegisterReceiver {
            name: "at the pier".to_owned(),
            serial: Some(109_924),
            ..Default::default()
        }),
        RegisterRecord::Deployment(api::RegisterDeployment {
            receiver: "At the pier".to_owned(),
            vessel: Some(STATION),
            from_us: Some(START_US - 86_400_000_000),
            lat_deg: Some(63.44),
            lon_deg: Some(10.4),
            ..Default::default()
        }),
    ])
}

fn read(text: &[u8], system: Option<u16>) -> (ReadDetections, Vec<Detection>) {
    let (study, mut all) = (study(), Vec::new());
    let address = |name: &str| match name {
        "otter-1" => Ok(0x0814),
        _ => Err(Said::as_is(format!("no vessel is called {name}"))),
    };
    let carriers = Carriers { system, address: &address, study: &study };
    let mut take = |one| {
        all.push(one);
        Ok(())
    };
    let read = if text.starts_with(PARQUET) {
        read_parquet(Bytes::copy_from_slice(text), &carriers, &mut take)
    } else {
        read_detections(text, &carriers, &mut take)
    };
    (read.unwrap(), all)
}

/// The only problem of a file, as line, column and text.
fn wrong(text: &str) -> (u32, String, String) {
    let (read, _) = read(text.as_bytes(), None);
    assert_eq!(read.wrong.len(), 1, "{:?}", read.wrong);
    let WrongCell { line, column, text } = &read.wrong[0];
    (*line, column.clone(), text.to_string())
}

fn any() -> impl Strategy<Value = Detection> {
    let states = prop_oneof![Just(ClockState::Set), Just(ClockState::Disciplined), Just(ClockState::Lost)];
    let place = (-89.0..89.0_f64, -179.0..179.0_f64);
    let pose = proptest::option::of((place, proptest::option::of(0..100_000_u32)));
    let raw = proptest::option::of("[ -~æø\\\\'=\"\n;,]{1,40}");
    let noise = proptest::option::of((0..=u8::MAX, 0..=u8::MAX, 0..100_000_u32));
    (
        (0..86_400_000_000_i64, 0..1_000_u16, states, 0..=u32::MAX),
        (pose, raw, noise, proptest::option::of(0..=u16::MAX), proptest::option::of(1..=u8::MAX)),
        prop_oneof![
            Just(Protocol::named("S256")),
            Just(Protocol::named("A69-9001")),
            Just(Protocol::numbered(0))
        ],
    )
        .prop_map(|((at_us, millis, state, tag_id), (pose, raw, noise, data, snr_db), protocol)| {
            Detection {
                origin: Origin {
                    system: Address(0x0814),
                    entity: 9,
                    reported: UtcTime::from_micros(START_US + at_us),
                    received: None,
                },
                receiver: 1_024,
                maker: (tag_id % 2 == 0).then_some(Maker::Innovasea),
                clock: ReceiverClock { seconds: 1_795_248_000, millis, state },
                protocol,
                tag_id,
                data,
                snr_db,
                frequency_khz: (tag_id % 3 > 0).then_some(69),
                line: data.unwrap_or(7),
                pose: pose.map(|((lat, lon), age)| Pose {
                    place: LatLon::from_deg(lat, lon).unwrap(),
                    age_s: age.map(|age| f64::from(age) / 1e3),
                    sigma_m: age.map(|age| f64::from(age) / 1e2),
                }),
                effort: Effort {
                    lines_lost: data,
                    noise: noise.map(|(average, peak, age)| Noise {
                        average,
                        peak,
                        age_s: f64::from(age) / 1e3,
                    }),
                    propeller_rpm: noise.map(|(average, ..)| f64::from(average)),
                },
                raw,
            }
        })
}

fn written(format: crate::Format, dialect: Dialect, all: &[Detection]) -> Vec<u8> {
    let (study, mut out) = (Study::default(), Vec::new());
    let mut writer = Writer::new(format, dialect);
    writer.header(&mut out).unwrap();
    for one in all {
        writer.row(&mut out, &study.heard(one, "otter-1", Lag::Unknown)).unwrap();
    }
    writer.end(&mut out, &study, &About::default()).unwrap();
    out
}

proptest! {
    #[test]
    fn our_own_tables_come_back_to_the_last_value(all in prop::collection::vec(any(), 1..20)) {
        for (format, dialect) in [
            (LUTRA, Dialect::Plain),
            (LUTRA, Dialect::SpreadsheetComma),
            (format("parquet").unwrap(), Dialect::Plain),
        ] {
            let table = written(format, dialect, &all);
            prop_assert!(is_detections(&table).unwrap());
            let (told, back) = read(&table, None);
            prop_assert_eq!(&told.wrong, &[]);
            prop_assert_eq!(written(format, dialect, &back), table);
        }
    }
}

#[test]
fn files_of_other_programs_are_detections_of_their_receivers() {
    let at = |us: i64| UtcTime::from_micros(START_US + us);
    let cases = [
        (
            "Date and Time (UTC),Receiver,Transmitter,Transmitter Name,Transmitter Serial,Sensor Value,Sensor Unit,Station Name,Latitude,Longitude\n2026-11-21 08:00:01.250,VR2W-109924,A69-1303-63366,,,12,ADC,Pier,63.5,10.5\n",
            "A69-1303-63366",
            1_250_000,
            Some(12),
            None,
            63.5,
        ),
        (
            "Date and Time (UTC),Receiver,Transmitter,Transmitter Name,Transmitter Serial,Sensor Value,Sensor Unit,Station Name,Latitude,Longitude\n2026-11-21 08:00:01,VR2W-109924,A69-1303-63366,,,,,,+0,+0\n",
            "A69-1303-63366",
            1_000_000,
            None,
            None,
            63.44,
        ),
        (
            "Date and Time UTC,TBR Serial Number,Unix Timestamp UTC,Millisecond,CodeType,Id,Data,Signal to Noise Ratio\n2026-11-21 08:00:01,109924,1795248001,250,R64K,77,-,31\n",
            "R64K-77",
            1_250_000,
            None,
            Some(31),
            63.44,
        ),
        (
            "Date and Time (UTC),Unix Timestamp (UTC),ID,Data,Protocol,SNR,Receiver\n2026-11-21 08:00:01.250,1795248001.250,77,9,S64K-69kHz,31,109924\n",
            "S64K-77",
            1_250_000,
            Some(9),
            Some(31),
            63.44,
        ),
        (
            "VEMCO DATA LOG,2.0.0,x\nBATTERY,1,2\nDET_DESC,Device Time (UTC),Time,Time Offset (h),Time Correction (s),Model,Serial Number,Channel,Detection Type,Full ID,ID,Raw Data,Transmitter Serial,Signal Strength (dB),Noise (dB),Gain (dB),Quality Score,Station Name,Latitude,Longitude,GPS HDOP\nDET,2026-11-21 08:00:01.000,2026-11-21 09:00:01.250,1.00,0.250,VR2AR,109924,1,PPM,A180-1702-4,4,5,,60.5,40,0,,Pier,,,\n",
            "A180-1702-4",
            1_250_000,
            Some(5),
            Some(21),
            63.44,
        ),
        (
            "detection_id,date_time,tag_serial_number,acoustic_tag_id,animal_project_code,animal_id,scientific_name,acoustic_project_code,receiver_id,station_name,deploy_latitude,deploy_longitude,sensor_value,sensor_unit,sensor2_value,sensor2_unit,signal_to_noise_ratio,source_file,qc_flag,deployment_id\n1,2026-11-21T08:00:01Z,,R01M-802761,,,,,TBR800-109924,,51.1,4.5,7.25,m,,,NA,,,\n",
            "R01M-802761",
            1_000_000,
            None,
            None,
            51.1,
        ),
        (
            "catalogNumber,station,receiver,tagName,codeSpace,sensorRaw,dateCollectedUTC,decimalLongitude,decimalLatitude\nx,p,release,A69-9001-1,A69-9001,,2026-11-21 08:00:00,1,2\nx,p,109924,A69-9001-24395,A69-9001,,2026-11-21T09:00:01.000001+01:00,10.5,63.5\n",
            "A69-9001-24395",
            1_000_001,
            None,
            None,
            63.5,
        ),
        (
            "catalognumber,station,receiver,tagname,codespace,sensorraw,datecollected,timezone,longitude,latitude\nx,p,109924,A69-9001-24395,A69-9001,,2026-11-21 08:00:01,UTC,10.5,63.5\n",
            "A69-9001-24395",
            1_000_000,
            None,
            None,
            63.5,
        ),
    ];
    for (text, tag, us, data, snr_db, lat_deg) in cases {
        assert!(is_detections(text.as_bytes()).unwrap(), "{text}");
        // With a byte order mark and a spreadsheet's line ends too.
        let dressed = format!("\u{FEFF}{}", text.replace('\n', "\r\n"));
        for text in [text, &dressed] {
            let (told, all) = read(text.as_bytes(), None);
            assert_eq!((told.wrong.as_slice(), all.len()), (&[][..], 1), "{text}");
            let one = &all[0];
            assert_eq!((one.tag().as_str(), one.origin.reported), (tag, at(us)), "{text}");
            assert_eq!(
                (one.clock.micros(), one.clock.state),
                (START_US + us / 1_000 * 1_000, ClockState::Set)
            );
            assert_eq!((one.origin.system, one.receiver), (Address(STATION), 109_924));
            assert_eq!((one.data, one.snr_db), (data, snr_db), "{text}");
            let place = one.pose.unwrap().place;
            assert!((place.lat_deg() - lat_deg).abs() < 1e-9, "{text}");
            assert_eq!(one.raw.as_deref(), text.trim_end().lines().last(), "{text}");
            assert_eq!(read(text.as_bytes(), Some(7)).1[0].origin.system, Address(7));
        }
    }
}

#[test]
fn what_a_file_does_not_say_of_the_signal_is_absent() {
    const NEW: &str = "Date and Time (UTC),Unix Timestamp (UTC),ID,Data,Protocol,SNR,Receiver\n2026-11-21 08:00:01.250,1795248001.250,77,9,";
    const FATHOM: &str = "VEMCO DATA LOG,2.0.0,x\nDET_DESC,Device Time (UTC),Model,Serial Number,Full ID,Signal Strength (dB),Noise (dB)\nDET,2026-11-21 08:00:01,VR2AR,109924,A180-1702-4,";
    let cases = [
        (format!("{NEW}S64K-71kHz,31,109924\n"), Some(31), Some(71)),
        (format!("{NEW}S64K-71kHz,-,109924\n"), None, Some(71)),
        (format!("{NEW}S64K,,109924\n"), None, None),
        (format!("{FATHOM}60.5,40\n"), Some(21), Some(180)),
        (format!("{FATHOM},\n"), None, Some(180)),
        (format!("{FATHOM}40,60.5\n"), None, Some(180)),
        ("date_time,acoustic_tag_id,receiver_id,signal_to_noise_ratio\n2026-11-21T08:00:01Z,R01M-8,TBR800-109924,NA\n".to_owned(), None, None),
    ];
    for (text, snr_db, khz) in cases {
        let (told, all) = read(text.as_bytes(), None);
        assert_eq!(told.wrong, [], "{text}");
        assert_eq!((all[0].snr_db, all[0].frequency_khz), (snr_db, khz), "{text}");
        let table = String::from_utf8(written(LUTRA, Dialect::Plain, &all)).unwrap();
        let cell = |value: Option<u8>| value.map_or_else(String::new, |value| value.to_string());
        let data = all[0].data.map_or_else(String::new, |data| data.to_string());
        assert!(table.contains(&format!(",{},{data},{},set,", cell(snr_db), cell(khz))), "{table}");
        // Earlier versions wrote 0 there.
        let earlier = table.replacen(&format!(",,{data},"), &format!(",0,{data},"), 1);
        assert_eq!(read(earlier.as_bytes(), Some(STATION)).1[0].snr_db, snr_db, "{earlier}");
    }
}

#[test]
fn receivers_of_two_makers_with_one_serial_number_are_two() {
    let receiver = |name: &str, manufacturer: &str| {
        RegisterRecord::Receiver(RegisterReceiver {
            name: name.to_owned(),
            serial: Some(700),
            manufacturer: manufacturer.to_owned(),
            ..Default::default()
        })
    };
    let deployed = |receiver: &str, vessel| {
        RegisterRecord::Deployment(api::RegisterDeployment {
            receiver: receiver.to_owned(),
            vessel: Some(vessel),
            ..Default::default()
        })
    };
    let study = Study::new([
        receiver("north", "VEMCO"),
        receiver("south", "Thelma Biotel"),
        deployed("north", 0x1C01),
        deployed("south", 0x1C02),
    ]);
    let carriers = Carriers { system: None, address: &|_| Ok(7), study: &study };
    let heard = |text: &str| {
        let mut all = Vec::new();
        let mut take = |one| {
            all.push(one);
            Ok(())
        };
        let told = read_detections(text.as_bytes(), &carriers, &mut take).unwrap();
        (told.wrong, all)
    };
    let rows = [
        "Date and Time (UTC),Receiver,Transmitter\n2026-11-21 08:00:01,VR2W-700,R64K-5\n",
        "Date and Time (UTC),Unix Timestamp (UTC),ID,Data,Protocol,SNR,Receiver\n2026-11-21 08:00:01,1795248001,5,-,R64K,-,700\n",
    ];
    let all: Vec<Detection> = rows.iter().flat_map(|text| heard(text).1).collect();
    assert_eq!(all.iter().map(|one| one.origin.system.0).collect::<Vec<_>>(), [0x1C01, 0x1C02]);
    let named = |one: &Detection| study.heard(one, "s", Lag::Unknown).receiver.map(|one| one.name.clone());
    assert_eq!(
        all.iter().map(named).collect::<Vec<_>>(),
        ["north", "south"].map(|name| Some(name.to_owned()))
    );
    // On one station, at one moment, too.
    let mut twin = all[0].clone();
    twin.maker = all[1].maker;
    assert!(!twin.is_same(&all[0]) && twin.id() != all[0].id());
    assert!(all[0].id().starts_with("innovasea:700-"), "{}", all[0].id());
    // What our own vessels report has the id of before, and is the receiver that was there.
    let own = Detection { maker: None, ..all[1].clone() };
    assert!(own.id().starts_with("700-") && named(&own).as_deref() == Some("south"));
    // Without its maker it may be either.
    let (wrong, _) = heard("datecollectedutc,receiver,tagname\n2026-11-21 08:00:01,700,A69-9001-24395\n");
    assert!(wrong[0].text.to_string().contains("does not say where the receiver 700 was"), "{wrong:?}");
}

#[test]
fn damage_in_a_parquet_file_is_named_by_row_or_by_column_and_rows() {
    let (_, all) =
        read(b"Date and Time (UTC),Receiver,Transmitter\n2026-11-21 08:00:01,VR2W-109924,A69-9001-5\n", None);
    let whole = written(format("parquet").unwrap(), Dialect::Plain, &all);
    let study = Study::default();
    let carriers = Carriers { system: Some(STATION), address: &|_| Ok(7), study: &study };
    let (mut refused, mut named) = (0, 0);
    // Any byte of the pages, which come first in the file; its last eight are the length of the footer before them, and a mark.
    let length = u32::from_le_bytes(*whole[whole.len() - 8..].first_chunk().unwrap()) as usize;
    for at in (4..whole.len() - 8 - length).step_by(7) {
        let mut damaged = whole.clone();
        damaged[at] ^= 0x55;
        let Err(error) = read_parquet(Bytes::from(damaged), &carriers, &mut |_| Ok(())) else { continue };
        let text = error.to_string();
        refused += 1;
        named += usize::from(text.starts_with("row 1: ") || text.contains(", rows 1 to 1: "));
    }
    assert!(refused > 5 && named == refused, "{named} of {refused}");
}

#[test]
fn texts_and_pages_that_no_detection_has_are_refused_before_they_fill_the_memory() {
    let (_, all) =
        read(b"Date and Time (UTC),Receiver,Transmitter\n2026-11-21 08:00:01,VR2W-109924,A69-9001-5\n", None);
    let parquet = |bytes: usize| {
        let one = Detection { raw: Some("x".repeat(bytes)), ..all[0].clone() };
        written(format("parquet").unwrap(), Dialect::Plain, &[one])
    };
    let whole = |bytes: usize| read(&parquet(bytes), Some(STATION)).0;
    assert_eq!(whole(8 << 10).wrong, []);
    let told = whole((8 << 10) + 1);
    let WrongCell { line, column, text } = &told.wrong[0];
    assert_eq!((told.has_rows, *line, &**column), (true, 1, "raw_line"));
    assert!(text.to_string().contains("is 8193 bytes long, a cell has at most 8192"), "{text}");
    // 20 MiB of one letter, packed to a small file.
    let table = parquet(20 << 20);
    assert!(table.len() < 2 << 20, "{} bytes", table.len());
    let study = Study::default();
    let carriers = Carriers { system: Some(STATION), address: &|_| Ok(7), study: &study };
    let refused = read_parquet(Bytes::from(table), &carriers, &mut |_| Ok(())).unwrap_err();
    assert!(refused.to_string().contains("column raw_line, rows 1 to 1: "), "{refused}");
    assert!(refused.to_string().contains("a page of 20 MiB, at most 16"), "{refused}");
    assert_eq!(refused.kind(), std::io::ErrorKind::InvalidData);
}

#[test]
fn a_bad_row_is_told_by_its_line_its_column_and_what_to_do() {
    const VUE: &str = "Date and Time (UTC),Receiver,Transmitter,Sensor Value,Sensor Unit\n2026-11-21 08:00:01,VR2W-109924,A69-1303-1,,\n";
    let cases = [
        (
            "2026-11-21 08:00,VR2W-109924,A69-1303-1,,\n",
            "date and time (utc)",
            "has no seconds: a spreadsheet cut them",
        ),
        ("21.11.2026 08:00:01,VR2W-109924,A69-1303-1,,\n", "date and time (utc)", "is not a time such as"),
        ("11/21/2026 08:00:01,VR2W-109924,A69-1303-1,,\n", "date and time (utc)", "is not a time such as"),
        ("2026-11-21 08:00:01,VR2W,A69-1303-1,,\n", "receiver", "is not a receiver such as VR2W-109924"),
        ("2026-11-21 08:00:01,VR2W-109924,63366,,\n", "transmitter", "is not a tag such as A69-1303-63366"),
        ("2026-11-21 08:00:01,VR2W-109924,,,\n", "transmitter", "empty"),
        ("2026-11-21 08:00:01,VR2W-109924,A69-1303-1,\"7,5\",m\n", "sensor value", "write a decimal point"),
        (
            "2026-11-21 08:00:01,VR2W-109924,A69-1303-1,99999,ADC\n",
            "sensor value",
            "not a whole number of this column",
        ),
        ("2000-01-01 08:00:01,VR2W-109924,A69-1303-1,,\n", "date and time (utc)", "clock was not set"),
        (
            "2026-11-21 08:00:01,VR2W-5,A69-1303-1,,\n",
            "receiver",
            "does not say where the receiver VR2W-5 was",
        ),
        ("2026-11-01 08:00:01,VR2W-109924,A69-1303-1,,\n", "receiver", "add its deployment"),
        ("2026-11-21 08:00:01,VR2W-109924,A69-1303-1,,,,\n", "", "has 7 cells, the header 5"),
        ("2026-11-21 08:00:01,\"VR2W-109924,A69-1303-1,,\n", "", "never closed"),
        ("2026-11-21,VR2W-109924,A69-1303-1,,\n", "date and time (utc)", "has no seconds"),
        ("2026-11-21T08:00+01,VR2W-109924,A69-1303-1,,\n", "date and time (utc)", "has no seconds"),
        ("2026-11-21 08:00:01,VR2W-109924,A69-1303-6", "", "the file is cut off here"),
        ("2026-11-21 08:00:01,VR2W\"-1,A69\n2026-11-21 08:00:01,VR2W\"-1,A69\n", "", "joins lines"),
    ];
    for (row, column, text) in cases {
        let (line, of, told) = wrong(&format!("{VUE}{row}"));
        assert_eq!((line, &*of), (3, column), "{row}: {told}");
        assert!(told.contains(text), "{row}: {told}");
    }
    let (read_all, all) =
        read(format!("{VUE}x,y\nx,y,z,,\n{}", VUE.lines().last().unwrap()).as_bytes(), None);
    assert_eq!((all.len(), read_all.wrong.iter().map(|one| one.line).collect::<Vec<_>>()), (2, vec![3, 4]));
}

#[test]
fn a_file_that_is_not_a_table_of_detections_is_told_so() {
    let thelma = "Date and Time UTC,TBR Serial Number,Unix Timestamp UTC,Millisecond,CodeType,Id,Data,Signal to Noise Ratio\n2026-11-21 09:00:01,109924,1795248001,250,R64K,77,-,31\n";
    assert!(wrong(thelma).2.contains("is 3599 s off the Unix time"), "{}", wrong(thelma).2);
    assert_eq!(wrong("").0, 1);
    assert!(wrong("a,b\n1,2\n").2.contains("not the columns of a table of detections"));
    assert!(wrong("VEMCO DATA LOG,2\nDET,1\n").2.contains("comes before the line DET_DESC"));
    let (told, _) = read(
        b"Date and Time (UTC),Receiver,Transmitter\n2026-11-21 08:00:01,VR2W-109924,A69-1303-1,\xF8\n",
        None,
    );
    assert!(told.wrong[0].text.to_string().contains("is not UTF-8") && told.wrong[0].line == 2);
    assert!(is_detections(b"a,b\n").is_err());
    for other in [&b"\xFET\x01\x02"[..], b"plain words\n", b"", b"\x1F\x8B,,"] {
        assert_eq!(is_detections(other), Ok(false));
    }
    let study = Study::default();
    let carriers = Carriers { system: None, address: &|_| Ok(7), study: &study };
    assert!(read_parquet(Bytes::from_static(b"PAR1 cut"), &carriers, &mut |_| Ok(())).is_err());
}

#[test]
fn numbers_of_rows_in_a_column_without_a_name_are_no_values() {
    // As R's write.csv and pandas write it.
    let heads = [
        "Date and Time UTC,TBR Serial Number,Unix Timestamp UTC,Millisecond,CodeType,Id,Data,Signal to Noise Ratio\n2026-11-21 08:00:01,109924,1795248001,250,R64K,77,-,31\n",
        "Date and Time (UTC),Unix Timestamp (UTC),ID,Data,Protocol,SNR,Receiver\n2026-11-21 08:00:01.250,1795248001.250,77,9,S64K-69kHz,31,109924\n",
        "Date and Time (UTC),Receiver,Transmitter\n2026-11-21 08:00:01,VR2W-109924,A69-1303-63366\n",
        "datecollectedutc,receiver,tagname\n2026-11-21 08:00:01,109924,A69-9001-24395\n",
    ];
    for text in heads {
        let numbered = text.replacen('\n', "\n7,", 1);
        let (told, numbered) = read(format!("\"\",{numbered}").as_bytes(), None);
        assert_eq!(told.wrong, [], "{text}");
        let bare = |all: Vec<Detection>| {
            all.into_iter().map(|one| Detection { raw: None, ..one }).collect::<Vec<_>>()
        };
        assert_eq!(bare(numbered), bare(read(text.as_bytes(), None).1));
    }
}

#[test]
fn a_place_is_that_of_the_station_that_is_named_and_whole() {
    const HEAD: &str = "datecollected,receiver,tagname,timezone,latitude,longitude\n2026-11-21 08:00:01,109924,A69-9001-24395,";
    let (_, all) = read(format!("{HEAD}GMT,,\n").as_bytes(), Some(0x7777));
    assert_eq!(all[0].pose, None, "the register's place is another station's");
    for (cells, column) in
        [("UTC,63.4,\n", "longitude"), ("UTC,,10.4\n", "latitude"), ("CET,,\n", "timezone")]
    {
        assert_eq!(wrong(&format!("{HEAD}{cells}")).1, column, "{cells}");
    }
}

#[test]
fn our_own_row_that_a_spreadsheet_rounded_is_refused() {
    let clock = ReceiverClock { seconds: 1_795_248_000, millis: 7, state: ClockState::Set };
    let (_, all) =
        read(b"Date and Time (UTC),Receiver,Transmitter\n2026-11-21 08:00:01,VR2W-109924,A69-9001-5\n", None);
    let one = Detection { clock, ..all[0].clone() };
    let table = String::from_utf8(written(LUTRA, Dialect::Plain, &[one])).unwrap();
    let rounded = table.replacen(",1795248000.007,", ",1795248000,", 1);
    assert_ne!(rounded, table);
    assert!(wrong(&rounded).2.contains("names another detection"), "{}", wrong(&rounded).2);
}

#[test]
fn a_code_space_is_not_named_twice() {
    let (_, all) =
        read(b"Date and Time (UTC),Receiver,Transmitter\n2026-11-21 08:00:01,VR2W-109924,A69-9001-5\n", None);
    assert_eq!(study().heard(&all[0], "pier", Lag::Unknown).codespace(), "A69-9001");
}
