use super::*;
use units::UtcTime;

fn at(seconds: u64) -> Now {
    let micros = seconds * 1_000_000;
    Now {
        mono: MonoTime::from_micros(micros),
        utc: UtcTime::from_micros(1_600_000_000_000_000 + micros as i64),
    }
}

fn receiver(language: Language, longest_silence: Option<Duration>) -> LineReceiver {
    let mut receiver = LineReceiver::new(LineReceiverSettings {
        language,
        init: vec![b"RTMNOW\r".to_vec()],
        longest_silence,
    });
    receiver.handle(at(0), Input::Opened);
    receiver
}

fn outputs(receiver: &mut LineReceiver) -> Vec<Output> {
    std::iter::from_fn(|| receiver.poll_output()).collect()
}

fn tags(outputs: &[Output]) -> Vec<TagReading> {
    let tag = |one: &Output| match one {
        Output::Reading { reading: Reading::Tag(tag), .. } => Some(tag.clone()),
        _ => None,
    };
    outputs.iter().filter_map(tag).collect()
}

fn last_state(outputs: &[Output]) -> Option<&State> {
    outputs.iter().rev().find_map(|one| if let Output::State(state) = one { Some(state) } else { None })
}

/// A line with its checksum.
fn innovasea(body: &str) -> String {
    format!("{body},#{:02X}\r\n", body.bytes().fold(0, u8::wrapping_add))
}

#[test]
fn an_innovasea_receiver_gives_detections_whatever_the_pieces() {
    let text = innovasea("450281,009,2019-07-25 12:33:05,STS,DC=1,PC=8,LV=12.3")
        + &innovasea("450281,010,2019-07-25 12:33:09,A69-1601,1057")
        + &innovasea("450281,011,2019-07-25 12:33:11.125,A69-9006,12,37,S=41,N=30,C=0");
    for size in [1, 7, 1000] {
        let mut receiver = receiver(Language::Innovasea, None);
        let mut all = outputs(&mut receiver);
        assert!(matches!(
            &all[..],
            [Output::State(State::Starting), Output::Send { .. }, Output::State(State::Working)]
        ));
        for chunk in text.as_bytes().chunks(size) {
            receiver.handle(at(1), Input::Bytes(chunk));
        }
        all = outputs(&mut receiver);
        let tags = tags(&all);
        assert_eq!(tags.len(), 2, "{all:?}");
        assert_eq!((tags[0].serial, tags[0].tag_id, tags[0].counter), (450_281, 1057, 10));
        assert_eq!(tags[0].protocol, "A69-1601");
        assert_eq!((tags[1].millis, tags[1].data, tags[1].snr_db), (125, Some(37), 11));
        assert_eq!(tags[1].raw.as_deref(), Some(text.lines().nth(2).unwrap()));
    }
}

#[test]
fn a_declared_receiver_gives_detections() {
    let pattern = Pattern::parse("DET {unix_s}.{ms};{protocol}/{id};{snr_db}").unwrap();
    let mut receiver = receiver(Language::Pattern(pattern), None);
    receiver.handle(at(1), Input::Bytes(b"DET 1600000001.250;R64K/17;23\nDET nonsense\n"));
    let all = outputs(&mut receiver);
    let tags = tags(&all);
    assert_eq!(tags.len(), 1);
    assert_eq!(
        (tags[0].clock_s, tags[0].millis, tags[0].tag_id, tags[0].snr_db),
        (1_600_000_001, 250, 17, 23)
    );
    let warned = |one: &Output| matches!(one, Output::Note(note) if note.warning && note.text.starts_with("1 damaged"));
    assert!(all.iter().any(warned), "{all:?}");
}

#[test]
fn babble_and_silence_fail_it_and_a_line_mends_it() {
    let mut receiver = receiver(Language::Innovasea, Some(Duration::from_secs(100)));
    assert_eq!(last_state(&outputs(&mut receiver)), Some(&State::Starting));
    let due = receiver.poll_timeout().unwrap();
    receiver.handle(Now { mono: due, ..at(101) }, Input::Time);
    assert!(
        matches!(last_state(&outputs(&mut receiver)), Some(State::Failing(why)) if why.contains("silent"))
    );
    let line = innovasea("450281,010,2019-07-25 12:33:09,A69-1601,1057");
    receiver.handle(at(102), Input::Bytes(line.as_bytes()));
    assert_eq!(last_state(&outputs(&mut receiver)), Some(&State::Working));
    for _ in 0..1000 {
        receiver.handle(at(103), Input::Bytes(&[0x81, 0x0D, 0xFF, b'x']));
    }
    let all = outputs(&mut receiver);
    assert!(matches!(last_state(&all), Some(State::Failing(why)) if why.contains("baud rate")));
    let notes = all.iter().filter(|one| matches!(one, Output::Note(_))).count();
    assert!(notes <= 4, "{notes} notes of a thousand damaged lines");
    receiver.handle(at(104), Input::Lost);
    assert_eq!(receiver.poll_timeout(), None);
}
