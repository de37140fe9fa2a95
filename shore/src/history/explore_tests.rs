use super::*;
use imc::messages::TBRFishTag;
use imc::{Address, Header, Packet};
use store::{Accepted, Store, Transport};
use units::UtcTime;

/// 2026-11-21 08:00 UTC.
const START_S: u32 = 1_795_248_000;
const BOAT: u16 = 0x0814;
/// Longer than any test reads.
const LONG: Duration = Duration::from_mins(1);

/// Fills a store with so many detections, one every so many seconds.
fn fill(data: &Path, from: u32, count: u32, every_s: u32) {
    let mut store = Store::open(data).unwrap();
    for at in from..from + count {
        let seconds = START_S + at * every_s;
        let tag = TBRFishTag {
            serial_no: 1_024,
            unix_timestamp: seconds,
            trans_protocol: 6_u8.into(),
            trans_id: 100 + at.wrapping_mul(2_654_435_761) % 300,
            lat: Some(1.1 + f64::from(at % 1_000) * 1e-7),
            lon: Some(0.2),
            ..TBRFishTag::default()
        };
        let received = UtcTime::from_micros(i64::from(seconds) * 1_000_000);
        let header = Header {
            timestamp: received.seconds(),
            src: Address(BOAT),
            src_ent: 2,
            dst: Address(0xFFFF),
            dst_ent: 255,
        };
        let packet = Packet::new(header, tag).encode().unwrap();
        let accepted = Accepted { packet: &packet, received, transport: Transport::Tcp, link: None };
        store.accept(&accepted).unwrap();
        if at % 20_000 == 19_999 {
            store.commit().unwrap();
        }
    }
    store.close().unwrap();
}

fn all() -> Question {
    Question {
        vessels: [BOAT].into(),
        from_us: 0,
        to_us: i64::MAX,
        tags: Vec::new(),
        narrowed: Narrowed::default(),
    }
}

#[test]
fn what_comes_later_is_counted_too() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path(), 0, 50, 60);
    let explorer = Explorer::new(folder.path());
    let count = || {
        let mut reader = Reader::open(folder.path()).unwrap();
        explorer.summary_within(&mut reader, &all(), &Study::default(), LONG).unwrap().detections
    };
    assert_eq!(count(), 50);
    fill(folder.path(), 50, 10, 60);
    assert_eq!(count(), 60);
}

#[test]
fn more_than_there_is_room_for_is_left_out_the_oldest_first_and_said_so() {
    let folder = tempfile::tempdir().unwrap();
    // Two months: 25 days apart, so that the second begins in December.
    fill(folder.path(), 0, 4, 25 * 86_400 / 2);
    let begin = |at: u32| i64::from(START_S + at * 25 * 86_400 / 2) * 1_000_000;
    let explorer = Explorer::holding(folder.path(), 3);
    let mut reader = Reader::open(folder.path()).unwrap();
    let mut ask = |question: &Question| {
        explorer.summary_within(&mut reader, question, &Study::default(), LONG).unwrap()
    };
    let found = ask(&all());
    assert!(found.detections < 4 && found.detections > 0, "{}", found.detections);
    let before_us = found.left_out_before_us.unwrap();
    assert!(before_us > begin(0) && before_us <= begin(3) + 1, "{before_us}");
    assert_eq!(found.read_from_us, None);
    // A shorter time has room again, whatever was asked before.
    let old = ask(&Question { to_us: begin(0) + 1, ..all() });
    assert_eq!((old.detections, old.left_out_before_us), (1, None));
}

/// `cargo nextest run --release --workspace --run-ignored all --no-capture -E 'test(a_million_detections)'`.
#[test]
#[ignore = "a measurement: it writes a million detections, and prints its figures"]
fn a_million_detections_are_seen_at_once() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path(), 0, 1_000_000, 1);
    let explorer = Explorer::new(folder.path());
    let begun = Instant::now();
    for times in 0.. {
        let asked = Instant::now();
        let mut reader = Reader::open(folder.path()).unwrap();
        let found = explorer.summary(&mut reader, &all(), &Study::default()).unwrap();
        let (took, since) = (asked.elapsed(), begun.elapsed());
        println!(
            "answer {times}: {} detections in {took:?}, {since:?} since the first question",
            found.detections
        );
        if found.detections == 1_000_000 && found.read_from_us.is_none() && times > 3 {
            return;
        }
    }
}
