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
    fill_of(BOAT, data, from, count, every_s);
}

fn fill_of(vessel: u16, data: &Path, from: u32, count: u32, every_s: u32) {
    let at_s: Vec<i64> = (from..from + count).map(|at| i64::from(START_S + at * every_s)).collect();
    fill_at(vessel, data, from, &at_s);
}

/// A detection at each of these times, by the vessel's clock.
fn fill_at(vessel: u16, data: &Path, from: u32, at_s: &[i64]) {
    let mut store = Store::open(data).unwrap();
    for (at, seconds) in (from..).zip(at_s) {
        let tag = TBRFishTag {
            serial_no: 1_024,
            unix_timestamp: u32::try_from(*seconds).unwrap_or(START_S),
            trans_protocol: 6_u8.into(),
            trans_id: 100 + at.wrapping_mul(2_654_435_761) % 300,
            lat: Some(1.1 + f64::from(at % 1_000) * 1e-7),
            lon: Some(0.2),
            ..TBRFishTag::default()
        };
        let received = UtcTime::from_micros(seconds * 1_000_000);
        let header = Header {
            timestamp: received.seconds(),
            src: Address(vessel),
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
        whole_axis: false,
    }
}

#[test]
fn what_comes_later_is_counted_too_but_not_before_a_rest() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path(), 0, 50, 60);
    let (at_once, rested) =
        (Explorer::holding(folder.path(), MOST, 0), Explorer::holding(folder.path(), MOST, u32::MAX));
    let count = |explorer: &Explorer| {
        let mut reader = Reader::open(folder.path()).unwrap();
        let prepared = explorer.prepare(&mut reader, all(), LONG).unwrap();
        explorer.summary(&prepared, &Study::default()).detections
    };
    assert_eq!((count(&at_once), count(&rested)), (50, 50));
    fill(folder.path(), 50, 10, 60);
    assert_eq!((count(&at_once), count(&rested)), (60, 50));
}

/// Half of 25 days (s).
const HALF_S: u32 = 25 * 86_400 / 2;

fn begin_us(at: u32) -> i64 {
    i64::from(START_S + at * HALF_S) * 1_000_000
}

/// Room for so many detections that are read one by one: each with its name.
fn holding(data: &Path, detections: usize, rest: u32) -> Explorer {
    Explorer::holding(data, detections * 5, rest)
}

fn ask(explorer: &Explorer, question: &Question) -> DetectionsSummary {
    let mut reader = Reader::open(&explorer.data).unwrap();
    let prepared = explorer.prepare(&mut reader, question.clone(), LONG).unwrap();
    explorer.summary(&prepared, &Study::default())
}

#[test]
fn more_than_there_is_room_for_is_left_out_the_oldest_first_and_said_so() {
    let folder = tempfile::tempdir().unwrap();
    // Two months: 25 days apart, so that the second begins in December.
    fill(folder.path(), 0, 4, HALF_S);
    let explorer = holding(folder.path(), 3, REST);
    let found = ask(&explorer, &all());
    assert_eq!((found.detections, found.read_from_us), (3, None));
    assert_eq!(
        found.left_out_before_us,
        Some(1_795_564_800_000_000),
        "the end of 2026-11-24: of four days is the first"
    );
    // A shorter range has room again, whatever was queried before.
    let old = ask(&explorer, &Question { to_us: begin_us(0) + 1, ..all() });
    assert_eq!((old.detections, old.left_out_before_us), (1, None));
}

/// Clocks set to 1970, 1980, 1999 or 2110: the history also keeps data without a plausible time, and none is lost.
#[test]
fn reports_of_no_believable_time_are_counted() {
    let folder = tempfile::tempdir().unwrap();
    let at_s = [5, 315_532_800, 946_684_799, i64::from(START_S), 4_102_444_800, 4_418_064_000];
    fill_at(BOAT, folder.path(), 0, &at_s);
    let explorer = holding(folder.path(), 20, REST);
    let found = ask(&explorer, &all());
    assert_eq!((found.detections, found.left_out_before_us, found.read_from_us), (6, None, None));
    for seconds in at_s {
        let (from_us, to_us) = (seconds * 1_000_000, seconds * 1_000_000 + 1);
        assert_eq!(ask(&explorer, &Question { from_us, to_us, ..all() }).detections, 1, "{seconds}");
    }
}

/// Detections before the range may confirm its first day: if there is no room for them, none of that day is called
/// unconfirmed, and the answer says so although it has the whole range.
#[test]
fn near_a_cut_the_answer_says_since_when_it_is_known_what_nothing_confirms() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path(), 0, 20, 3_600);
    let explorer = holding(folder.path(), 10, REST);
    let us = |at: u32| i64::from(START_S + at * 3_600) * 1_000_000;
    let found = ask(&explorer, &Question { from_us: us(15), ..all() });
    assert_eq!((found.detections, found.left_out_before_us, found.read_from_us), (5, None, None));
    let confirmed_us = found.confirmed_from_us.unwrap();
    assert!((us(15)..=us(10) + 86_400_000_000).contains(&confirmed_us), "{confirmed_us}");
    assert_eq!(ask(&Explorer::new(folder.path()), &all()).confirmed_from_us, None);
}

/// Months and days without data of these vessels are not read.
#[test]
fn days_without_a_report_are_not_wanted() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path(), 0, 10, 60);
    fill_of(BOAT + 1, folder.path(), 0, 20, 5 * 86_400);
    let (explorer, mut reader) = (Explorer::new(folder.path()), Reader::open(folder.path()).unwrap());
    let mut stretches = |vessels: &[u16]| {
        let question = Question { vessels: vessels.iter().copied().collect(), ..all() };
        explorer.prepare(&mut reader, question, LONG).unwrap().wanted.stretches.len()
    };
    assert_eq!([stretches(&[BOAT]), stretches(&[BOAT + 2])], [1, 0]);
    assert_eq!(stretches(&[BOAT + 1]), stretches(&[BOAT, BOAT + 1]));
}

#[test]
fn the_same_question_gets_the_same_answer_where_there_is_no_room_for_all() {
    let folder = tempfile::tempdir().unwrap();
    // Weeks from November to January.
    fill(folder.path(), 0, 40, 2 * 86_400);
    for rest in [0, REST] {
        let explorer = holding(folder.path(), 25, rest);
        let first = ask(&explorer, &all());
        assert_eq!(first.detections, 25, "there is room for so many");
        for _ in 0..3 {
            assert_eq!(ask(&explorer, &all()), first);
        }
        // A query for older data evicts these, and vice versa.
        let older = Question { to_us: begin_us(1), ..all() };
        assert_eq!(ask(&explorer, &older).detections, 7);
        assert_eq!(ask(&explorer, &all()), first);
    }
}

#[test]
fn what_comes_to_a_cut_month_is_the_newest_of_it() {
    let folder = tempfile::tempdir().unwrap();
    fill(folder.path(), 0, 40, 2 * 86_400);
    let explorer = holding(folder.path(), 25, 0);
    ask(&explorer, &all());
    fill(folder.path(), 40, 5, 2 * 86_400);
    let found = ask(&explorer, &all());
    assert_eq!(found.detections, 25);
    let newest_us = i64::from(START_S + 44 * 2 * 86_400) * 1_000_000;
    assert_eq!(found.tags.iter().map(|tag| tag.last_us).max(), Some(newest_us));
}

#[test]
fn what_others_heard_cuts_nobody() {
    let folder = tempfile::tempdir().unwrap();
    fill_of(BOAT + 1, folder.path(), 0, 3, 60);
    fill(folder.path(), 3, 40, 60);
    let explorer = holding(folder.path(), 10, REST);
    let few = Question { vessels: [BOAT + 1].into(), ..all() };
    assert_eq!(ask(&explorer, &all()).detections, 10);
    let found = ask(&explorer, &few);
    assert_eq!((found.detections, found.left_out_before_us), (3, None));
    // For both, the newest of each: both are cut at the same time.
    let both = ask(&explorer, &Question { vessels: [BOAT, BOAT + 1].into(), ..all() });
    assert_eq!(both.detections, 10);
    let before_us = both.left_out_before_us.unwrap();
    assert!(both.tags.iter().all(|tag| tag.first_us >= before_us), "{before_us}");
}

/// A month with more detections than there is room for: a query for its first days is answered, however many came later.
#[test]
fn the_first_days_of_a_full_month_are_reached() {
    let folder = tempfile::tempdir().unwrap();
    // 20 on the 21st and 22nd, then 60 from the 26th to the 28th, and some in December.
    fill(folder.path(), 0, 20, 4_000);
    fill(folder.path(), 120, 60, 4_000);
    fill(folder.path(), 240, 5, 4_000);
    let explorer = holding(folder.path(), 30, REST);
    let whole = ask(&explorer, &all());
    assert!(
        whole.detections < 85 && whole.left_out_before_us.is_some(),
        "there is no room for all: {whole:?}"
    );
    let early = Question { to_us: i64::from(START_S + 20 * 4_000) * 1_000_000, ..all() };
    let found = ask(&explorer, &early);
    assert_eq!((found.detections, found.left_out_before_us, found.read_from_us), (20, None, None));
    // Detections of a stretch beyond the room are still left out, and the answer says so.
    let full = Question {
        from_us: i64::from(START_S + 115 * 4_000) * 1_000_000,
        to_us: i64::from(START_S + 200 * 4_000) * 1_000_000,
        ..all()
    };
    let found = ask(&explorer, &full);
    assert_eq!(
        (found.detections, found.left_out_before_us.is_some()),
        (30, true),
        "those of December come more than a day later"
    );
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
        let prepared = explorer.prepare(&mut reader, all(), PATIENCE).unwrap();
        let found = explorer.summary(&prepared, &Study::default());
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
