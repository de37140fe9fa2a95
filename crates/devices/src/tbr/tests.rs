//! Lines written, and lines read: of every recording, and damaged ones.

use super::*;

#[test]
fn lines_are_those_of_a_real_receiver() {
    // Recorded lines, their ends apart.
    let tag = |clock_s, millis, protocol, tag_id, data, snr_db, counter| {
        let serial = 1_000_042;
        TagReading {
            serial,
            clock_s,
            millis,
            protocol: TagProtocol::name(protocol).to_owned(),
            tag_id,
            data,
            snr_db,
            frequency_khz: 69,
            counter,
            raw: None,
            lines_lost: None,
        }
        .encode()
    };
    let sensor = WaterReading {
        serial: 1_000_042,
        clock_s: 600,
        temperature_c: 24.7,
        noise_average: 15,
        noise_peak: 29,
        frequency_khz: 69,
        counter: 6,
        lines_lost: None,
    };
    for (line, expected) in [
        (sensor.encode(), "$1000042,0000000600,TBR Sensor,297,15,29,69,6\r"),
        (
            tag(2185, 897, TagProtocol::R64K, 1023, None, 24, 9),
            "$1000042,0000002185,897,R64K,1023,,24,69,9\r",
        ),
        (
            tag(1_623_050_485, 615, TagProtocol::S64K, 1285, Some(12), 24, 11),
            "$1000042,1623050485,615,S64K,1285,12,24,69,11\r",
        ),
    ] {
        assert_eq!(String::from_utf8(line).unwrap(), expected);
    }
}

/// The result of reading a stream that arrives in chunks.
fn heard(stream: &[u8], chunk: usize) -> (Vec<Heard>, Vec<(u64, DamagedLine)>) {
    let mut framer = Framer::default();
    let (mut found, mut damaged) = (Vec::new(), Vec::new());
    let mut take = |offset, read: Result<Heard, DamagedLine>| match read {
        Ok(heard) => found.push(heard),
        Err(error) => damaged.push((offset, error)),
    };
    for bytes in stream.chunks(chunk) {
        framer.feed(bytes, &mut take);
        assert!(framer.kept() <= LONGEST);
    }
    framer.end(&mut take);
    (found, damaged)
}

fn tags(found: &[Heard]) -> Vec<&TagReading> {
    let tag = |heard: &'_ Heard| matches!(heard.line, Line::Tag(_));
    let tags = found.iter().filter(|heard| tag(heard));
    tags.filter_map(|heard| if let Line::Tag(tag) = &heard.line { Some(tag) } else { None }).collect()
}

/// Every recording: tag lines, sensor lines, receiver, coding, tag, frequency.
const RECORDINGS: [(&str, usize, usize, u32, &str, u32, u8); 9] = [
    ("onboard/thelma_2016_serial45.txt", 419, 1, 45, "S256", 40, 67),
    ("onboard/thelma_2017_circle_with_sensor.csv", 204, 1, 25, "S256", 40, 67),
    ("onboard/thelma_20211013_long.csv", 352, 0, 1_000_052, "S256", 200, 69),
    ("onboard/thelma_20220303_moving_tag.csv", 52, 0, 1_000_052, "S256", 200, 69),
    ("onboard/thelma_stryn2021_r64k_part.csv", 16, 0, 1_000_052, "R64K", 1705, 69),
    ("acoustics/raw/otter_20161102_s256_40.txt", 543, 1, 45, "S256", 40, 67),
    ("acoustics/raw/otter_20170217_s256_40.txt", 204, 0, 25, "S256", 40, 67),
    ("acoustics/raw/otter_20170217_s256_40_with_sensor_line.txt", 204, 1, 25, "S256", 40, 67),
    ("acoustics/raw/otter_20220303b_s256_200.txt", 52, 0, 1_000_052, "S256", 200, 69),
];

#[test]
fn every_recording_is_read_completely() {
    for (name, tag_lines, sensor_lines, serial, protocol, tag_id, frequency_khz) in RECORDINGS {
        let Some(path) = testkit::shared(&format!("data/{name}")) else { return };
        let stream = std::fs::read(path).unwrap();
        let (found, damaged) = heard(&stream, 17);
        assert_eq!(damaged, [], "{name}");
        let tags = tags(&found);
        assert_eq!((tags.len(), found.len()), (tag_lines, tag_lines + sensor_lines), "{name}");
        // The text itself says what each line must give.
        let text = String::from_utf8(stream).unwrap();
        let written = text.lines().filter(|line| !line.contains("Sensor"));
        for (tag, line) in tags.iter().zip(written) {
            let fields: Vec<&str> = line.split(',').collect();
            let number = |index: usize| fields[index].trim_start_matches('$').parse::<u32>().unwrap();
            assert_eq!((tag.serial, tag.protocol.as_str()), (serial, protocol));
            assert_eq!((tag.tag_id, tag.frequency_khz), (tag_id, frequency_khz));
            assert_eq!((tag.clock_s, u32::from(tag.millis)), (number(1), number(2)));
            let data = (protocol != "R64K").then(|| number(5));
            assert_eq!((tag.data.map(u32::from), u32::from(tag.snr_db)), (data, number(6)));
            assert_eq!((u32::from(tag.counter), tag.raw.as_deref()), (number(8), Some(line)));
        }
    }
}

#[test]
fn native_lines_have_empty_data_and_a_clock_that_is_not_set() {
    let Some(path) = testkit::shared("data/onboard/thelma_tblive_native_lines.txt") else { return };
    let (found, damaged) = heard(&std::fs::read(path).unwrap(), 1);
    assert_eq!((found.len(), damaged), (7, vec![]));
    let Line::Water(water) = &found[0].line else { panic!("no sensor line") };
    assert_eq!((water.clock_s, water.noise_average, water.noise_peak), (600, 15, 29));
    assert!((water.temperature_c - 24.7).abs() < 1e-9);
    let tags = tags(&found);
    let data: Vec<Option<u16>> = tags.iter().map(|tag| tag.data).collect();
    assert_eq!(data, [None, None, Some(12), Some(0)]);
    let set: Vec<bool> = tags.iter().map(|tag| tag.clock_s >= SET_AFTER_S).collect();
    assert_eq!(set, [false, false, true, false]);
    assert_eq!(found.iter().filter_map(|heard| heard.counter).collect::<Vec<_>>(), [6, 7, 8, 9, 10, 11, 12]);
}

#[test]
fn what_is_written_is_read() {
    for protocol in TagProtocol::ALL {
        let data = protocol.data_max();
        let tag = TagReading {
            serial: 25,
            clock_s: 1_487_343_577,
            millis: 7,
            protocol: protocol.name().to_owned(),
            tag_id: 15,
            data,
            snr_db: 33,
            frequency_khz: 69,
            counter: u16::MAX,
            raw: None,
            lines_lost: None,
        };
        let (found, damaged) = heard(&tag.encode(), 3);
        let expected = TagReading { raw: Some(tag.line()), ..tag };
        assert_eq!((found.len(), damaged), (1, vec![]));
        assert_eq!(found[0].line, Line::Tag(expected));
    }
}

#[test]
fn protocols_that_are_not_known_are_kept_as_text() {
    let (found, _) =
        heard(b"$001129,1551087572,897,OPz,15,32,33,69\r$001129,1551087600,TBR Sensor,280,3,8,69\r", 5);
    let tags = tags(&found);
    assert_eq!((tags[0].protocol.as_str(), tags[0].data), ("OPz", Some(32)));
    assert_eq!((found[0].counter, found.len()), (None, 2));
}

#[test]
fn answers_are_told_from_noise() {
    let line = "$000025,1487343577,721,S256,40,13,17,67,15790";
    let stream = format!("\u{7f}xx{line}\rack01\r\nLIVECM\rFV=v1.0.6\r~ack02{line}\r");
    let (found, damaged) = heard(stream.as_bytes(), 4);
    assert_eq!(damaged, []);
    let lines: Vec<&Line> = found.iter().map(|heard| &heard.line).collect();
    assert!(matches!(
        lines[..],
        [
            Line::Tag(_),
            Line::Ack(Ack::Rounded),
            Line::Reply(_),
            Line::Reply(_),
            Line::Ack(Ack::Set),
            Line::Tag(_)
        ]
    ));
    assert_eq!(*lines[3], Line::Reply("FV=v1.0.6".to_owned()));
}

#[test]
fn damaged_lines_say_which_field_and_where() {
    for (line, expected) in [
        ("$000025,1487343577,1000,S256,40,13,17,67,15790", "the milliseconds is not valid: '1000'"),
        ("$000025,1487343577,721,S256,40,13,300,67,15790", "the SNR is not valid: '300'"),
        ("$000025,1487343577,721,,40,13,17,67,15790", "the protocol is not valid: ''"),
        ("$000025,-5,721,S256,40,13,17,67,15790", "the time is not valid: '-5'"),
        ("$000025,1487343577,721,S256,40,13,17", "7 fields make no line of this receiver"),
        ("$000025,1487343577,721,S256,40,13,17,67,1,95,10", "the position is not valid: '95,10'"),
        ("$000025,1487343577,721,S256,40,13,17,67,1,5,1,2,3", "13 fields make no line of this receiver"),
        ("$000025,1487343577,TBR Sensor,x,13,17,67,1", "the temperature is not valid: 'x'"),
    ] {
        let stream = format!("ack01\r{line}\rack02\r");
        let (found, damaged) = heard(stream.as_bytes(), 100);
        assert_eq!(found.len(), 2, "{line}");
        let damaged: Vec<(u64, String)> = damaged.iter().map(|(at, why)| (*at, why.to_string())).collect();
        assert_eq!(damaged, [(6, expected.to_owned())]);
    }
}

#[test]
fn glued_and_endless_lines_cost_themselves_alone() {
    let line = "$000025,1487343577,721,S256,40,13,17,67,15790";
    let stream = format!("$000025,14873{line}\r{line}{}{line}\r", "9".repeat(5_000));
    let (found, damaged) = heard(stream.as_bytes(), 64);
    assert_eq!(found.len(), 2);
    let second = 13 + line.len() as u64 + 1;
    assert_eq!(damaged, [(0, DamagedLine::Unended), (second, DamagedLine::TooLong)]);
}
