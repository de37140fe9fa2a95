use super::*;
use link::Entry;
use proptest::prelude::*;
use tempfile::TempDir;

/// In memory if possible: these tests sync thousands of times.
fn temporary() -> TempDir {
    TempDir::new_in("/dev/shm").or_else(|_| TempDir::new()).unwrap()
}

fn time(number: u64) -> UtcTime {
    UtcTime::from_micros(1_790_000_000_000_000 + number as i64 * 1000)
}

fn packet(number: u64) -> Vec<u8> {
    let length = 20 + number % 37;
    (0..length).map(|at| (number * 31 + at) as u8).collect()
}

fn open(folder: &Path) -> Spool {
    Spool::open(folder, Bounds { bytes: 1 << 20, file_bytes: 4096 }, time(0)).unwrap().0
}

/// Appends packets with the numbers that they get.
fn append(spool: &mut Spool, count: u64, important: impl Fn(u64) -> bool) {
    for _ in 0..count {
        let number = spool.next;
        spool.append(time(number), &packet(number), important(number));
        spool.write().unwrap();
    }
}

/// Everything from a number on, each number accounted for once: packets as they were written, and gaps.
fn read_all(spool: &mut Spool, from: u64) -> (Vec<u64>, Vec<Gap>) {
    let (mut next, mut packets, mut gaps) = (from, Vec::new(), Vec::new());
    while next < spool.state().next {
        let entries = spool.read(next, 500);
        assert!(!entries.is_empty(), "nothing at {next}");
        for entry in entries {
            match entry {
                Entry::Record(record) => {
                    assert_eq!((record.seq, record.recorded), (next, time(next)));
                    assert_eq!(&record.packet[..], packet(next));
                    packets.push(next);
                    next += 1;
                }
                Entry::Gap(gap) => {
                    assert!(gap.from <= next && gap.to > next, "{gap:?} at {next}");
                    gaps.push(gap);
                    next = gap.to;
                }
            }
        }
    }
    (packets, gaps)
}

fn all_but(gaps: &[Gap], to: u64) -> Vec<u64> {
    (0..to).filter(|number| !gaps.iter().any(|gap| (gap.from..gap.to).contains(number))).collect()
}

#[test]
fn what_is_written_is_read_and_what_is_acknowledged_is_forgotten() {
    let folder = temporary();
    let mut spool = open(folder.path());
    append(&mut spool, 1000, |_| false);
    let (packets, gaps) = read_all(&mut spool, 0);
    assert_eq!((packets.len(), gaps.len()), (1000, 0));
    assert_eq!(read_all(&mut spool, 777).0[0], 777);
    let before = spool.bytes();
    spool.acknowledged(500);
    assert!(spool.state().first > 400 && spool.state().first <= 500 && spool.bytes() < before * 6 / 10);
    let (_, gaps) = read_all(&mut spool, 3);
    assert_eq!(gaps[0].reason, GapReason::AcknowledgedBefore);
    spool.acknowledged(1000);
    assert_eq!(read_all(&mut spool, 1000), (vec![], vec![]));
    spool.close().unwrap();
    let mut spool = open(folder.path());
    append(&mut spool, 1, |_| false);
    assert_eq!((spool.state().next, spool.starts()), (1001, 2));
}

#[test]
fn files_that_a_full_disk_left_empty_hide_no_packets() {
    // Such a disk takes a file's name but not its header; once there is room again, the file before it is written on.
    for (emptied, bytes) in
        [(vec![7], 0), (vec![7, 30], 0), (vec![7, 12, 30], HEADER_BYTES / 2), (vec![40], 0)]
    {
        let folder = temporary();
        let mut spool = open(folder.path());
        append(&mut spool, 40, |_| false);
        let first = spool.active.first;
        assert_eq!(first, 0, "they are all in one file");
        drop(spool);
        for number in &emptied {
            fs::write(path(folder.path(), *number), vec![0; bytes]).unwrap();
        }
        let mut spool = open(folder.path());
        let killed = spool.state().next;
        append(&mut spool, 3, |_| false);
        let (packets, gaps) = read_all(&mut spool, 0);
        assert_eq!(packets, (0..40).chain(killed..killed + 3).collect::<Vec<_>>(), "{emptied:?}");
        assert!(
            gaps.iter().all(|gap| gap.reason == GapReason::Killed && gap.from >= 40),
            "{emptied:?}: {gaps:?}"
        );
        let left = fs::read_dir(folder.path()).unwrap().filter(|one| {
            let one = one.as_ref().unwrap();
            one.path().extension().is_some_and(|end| end == "spool")
                && one.metadata().unwrap().len() < HEADER_BYTES as u64
        });
        assert_eq!(left.count(), 0, "{emptied:?}: no remainder stays");
    }
}

#[test]
fn a_first_file_that_lost_its_entries_is_a_gap_and_not_called_acknowledged() {
    let folder = temporary();
    let mut spool = open(folder.path());
    append(&mut spool, 400, |_| false);
    let (first, second) = spool.oldest().unwrap();
    drop(spool);
    fs::write(path(folder.path(), first), []).unwrap();
    let (packets, gaps) = read_all(&mut open(folder.path()), 0);
    assert_eq!((gaps[0].reason, gaps[0].from, gaps[0].to), (GapReason::Damaged, 0, second));
    assert_eq!((packets.first(), packets.last()), (Some(&second), Some(&399)));
}

#[test]
fn killed_at_any_byte_nothing_whole_is_lost_and_it_goes_on() {
    let folder = temporary();
    let mut spool = open(folder.path());
    append(&mut spool, 60, |_| false);
    spool.missed(5, time(1), time(2));
    append(&mut spool, 20, |_| false);
    let active = path(folder.path(), spool.active.first);
    let first = spool.active.first;
    drop(spool);
    let whole = fs::read(&active).unwrap();
    let before = read_all(&mut open(folder.path()), 0);
    for length in 0..=whole.len() {
        let copy = temporary();
        fs::copy(folder.path().join("identity"), copy.path().join("identity")).unwrap();
        fs::write(path(copy.path(), first), &whole[..length]).unwrap();
        let mut spool = open(copy.path());
        let next = spool.state().next;
        append(&mut spool, 3, |_| false);
        let (packets, gaps) = read_all(&mut spool, first);
        assert_eq!(packets.last(), Some(&(next + 2)));
        // As many whole entries as the bytes hold, no other gap than the one that was written, and the kill's.
        let mut at = HEADER_BYTES;
        let mut expected = first;
        let all = bytes::Bytes::from(whole.clone());
        while let Some((item, bytes)) = segment::take(&all.slice(at.min(length)..length)) {
            (at, expected) = (at + bytes, item.end());
        }
        assert_eq!(next, expected + 1, "cut at {length}");
        let (kills, written): (Vec<_>, Vec<_>) =
            gaps.into_iter().partition(|gap| gap.reason == GapReason::Killed);
        assert!(written.iter().all(|gap| before.1.contains(gap)));
        assert_eq!((kills.len(), kills[0].from, kills[0].to), (1, expected, expected + 1));
    }
}

#[test]
fn a_spool_of_a_later_version_is_left_as_it_is() {
    let folder = temporary();
    let mut spool = open(folder.path());
    append(&mut spool, 200, |_| false);
    drop(spool);
    let files = || {
        let entries = std::fs::read_dir(folder.path()).unwrap().map(|entry| entry.unwrap().path());
        let mut all: Vec<_> = entries.map(|path| (path.clone(), std::fs::read(path).unwrap())).collect();
        all.sort();
        all
    };
    let (last, bytes) =
        files().into_iter().rfind(|(path, _)| path.extension().is_some_and(|end| end == "spool")).unwrap();
    std::fs::write(&last, [b"LUSPOOL2", &bytes[8..]].concat()).unwrap();
    let before = files();
    let told = Spool::open(folder.path(), Bounds::of(1 << 20), time(0)).unwrap_err().to_string();
    assert!(told.contains("later lutra-agent") && told.contains("Install that version again"), "{told}");
    assert!(files() == before, "something was written");
    std::fs::write(&last, bytes).unwrap();
    open(folder.path());
}

#[test]
fn it_is_not_opened_twice() {
    let folder = temporary();
    let spool = open(folder.path());
    let error = Spool::open(folder.path(), Bounds::of(1 << 20), time(0)).unwrap_err();
    assert!(error.is::<crate::disk::InUse>(), "{error:#}");
    drop(spool);
    open(folder.path());
}

#[test]
fn when_full_telemetry_goes_first_and_every_loss_is_declared() {
    let folder = temporary();
    let bounds = Bounds { bytes: 40_000, file_bytes: 4096 };
    let mut spool = Spool::open(folder.path(), bounds, time(0)).unwrap().0;
    let important = |number: u64| number.is_multiple_of(20);
    append(&mut spool, 4000, important);
    assert!(spool.bytes() <= bounds.bytes, "{}", spool.bytes());
    let (packets, gaps) = read_all(&mut spool, 0);
    assert_eq!(packets, all_but(&gaps, 4000));
    assert!(gaps.iter().all(|gap| gap.reason == GapReason::SpoolFull));
    assert_eq!(spool.thinned(), 4000 - packets.len() as u64);
    // The oldest important packets are kept while the telemetry of that time is removed.
    assert_eq!(&packets[..3], [0, 20, 40]);
    // Far more: the important ones go too, the oldest first, and the files do not pile up.
    append(&mut spool, 30_000, important);
    let (packets, gaps) = read_all(&mut spool, 0);
    assert_eq!(packets, all_but(&gaps, 34_000));
    assert!(packets[0] > 0 && important(packets[0]) && spool.bytes() <= bounds.bytes);
    assert!(spool.files.len() < 30, "{}", spool.files.len());
    // It is reopened in the same state.
    spool.close().unwrap();
    let mut spool = Spool::open(folder.path(), bounds, time(0)).unwrap().0;
    assert_eq!(read_all(&mut spool, 0), (packets, gaps));
}

#[test]
fn a_thinning_that_was_cut_off_is_finished_by_the_next_start() {
    let folder = temporary();
    let mut spool = open(folder.path());
    append(&mut spool, 400, |number| number % 50 == 0);
    let second = *spool.files.keys().nth(1).unwrap();
    let copy = fs::read(path(folder.path(), second)).unwrap();
    spool.bounds.bytes = spool.bytes() - 6000;
    spool.thin().unwrap();
    let expected = read_all(&mut spool, 0);
    assert!(!spool.files.contains_key(&second), "joined to the first");
    spool.close().unwrap();
    fs::write(path(folder.path(), second), copy).unwrap();
    fs::write(folder.path().join("1.tmp"), "half").unwrap();
    let mut spool = open(folder.path());
    assert_eq!(read_all(&mut spool, 0), expected);
    assert!(!path(folder.path(), second).exists() && !folder.path().join("1.tmp").exists());
}

#[test]
fn after_a_loss_of_power_no_number_is_given_out_twice() {
    let folder = temporary();
    let start = |boot: &str| Spool::open_after(folder.path(), Bounds::of(1 << 20), time(9), boot).unwrap();
    let (mut spool, _) = start("monday");
    append(&mut spool, 100, |_| false);
    drop(spool);
    // Killed: the numbers continue, and one represents the packets not spooled.
    let (mut spool, remarks) = start("monday");
    assert_eq!((spool.state().next, remarks.len()), (101, 1));
    append(&mut spool, 99, |_| false);
    drop(spool);
    let (mut spool, remarks) = start("tuesday");
    assert_eq!((spool.state().next, remarks.len()), (200 + LEFT_OUT, 1));
    append(&mut spool, 10, |_| false);
    let (packets, gaps) = read_all(&mut spool, 0);
    assert_eq!(packets.len(), 209);
    let declared: Vec<_> = gaps.iter().map(|gap| (gap.from, gap.to, gap.reason)).collect();
    assert_eq!(declared, [(100, 101, GapReason::Killed), (200, 200 + LEFT_OUT, GapReason::PowerLost)]);
    spool.close().unwrap();
    let (spool, remarks) = start("wednesday");
    assert_eq!((spool.state().next, remarks.len()), (210 + LEFT_OUT, 0), "closed in order");
}

#[test]
fn what_a_killed_program_had_not_spooled_is_declared_up_to_the_next_start() {
    let folder = temporary();
    let start = |at| {
        let (mut spool, _) = Spool::open(folder.path(), Bounds::of(1 << 20), time(at)).unwrap();
        let first = spool.state().first;
        let gaps = read_all(&mut spool, first).1;
        assert!(gaps.iter().all(|gap| gap.reason == GapReason::Killed));
        (spool, gaps.last().map(|gap| (gap.since, gap.until)))
    };
    let (mut spool, first) = start(0);
    assert_eq!(first, None, "nobody was killed before the first start");
    append(&mut spool, 100, |_| false);
    drop(spool);
    // From the last packet on.
    let (spool, gap) = start(5_000);
    assert_eq!(gap, Some((time(99), time(5_000))));
    // Killed at once: from the start before.
    drop(spool);
    let (mut spool, gap) = start(9_000);
    assert_eq!(gap, Some((time(5_000), time(9_000))));
    // All is ashore and the file of it is gone.
    append(&mut spool, 1, |_| false);
    spool.roll().unwrap();
    spool.acknowledged(spool.state().next);
    drop(spool);
    // A clock that was set back gives a gap without duration, not one that ends before it begins.
    let (spool, gap) = start(7_000);
    assert_eq!(gap, Some((time(7_000), time(7_000))));
    spool.close().unwrap();
    let (_, gap) = start(20_000);
    assert_eq!(gap, Some((time(7_000), time(7_000))), "closed in order");
}

#[test]
fn damage_in_the_middle_is_declared_and_the_rest_is_read() {
    let folder = temporary();
    let mut spool = open(folder.path());
    append(&mut spool, 400, |_| false);
    let firsts: Vec<u64> = spool.files.keys().copied().collect();
    let damaged = path(folder.path(), firsts[1]);
    let mut bytes = fs::read(&damaged).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(&damaged, bytes).unwrap();
    fs::remove_file(path(folder.path(), firsts[2])).unwrap();
    let (packets, gaps) = read_all(&mut spool, 0);
    assert_eq!(packets, all_but(&gaps, 400));
    assert!(gaps.len() == 2 && gaps.iter().all(|gap| gap.reason == GapReason::Damaged));
    assert_eq!(gaps[0].to, firsts[2]);
    assert!(gaps[0].from > firsts[1] + 10);
}

#[test]
fn what_the_disk_refuses_is_declared_when_it_takes_it() {
    let folder = temporary();
    let mut spool = open(folder.path());
    append(&mut spool, 10, |_| false);
    spool.active.file = Arc::new(OpenOptions::new().write(true).open("/dev/full").unwrap());
    for _ in 0..3 {
        spool.append(time(1), b"lost", false);
    }
    assert_eq!(spool.write().unwrap_err().kind(), io::ErrorKind::StorageFull);
    assert_eq!(spool.state().next, 10);
    append(&mut spool, 5, |_| false);
    let (packets, gaps) = read_all(&mut spool, 0);
    assert_eq!(packets, all_but(&gaps, 18));
    assert_eq!((gaps.len(), gaps[0].from, gaps[0].to, gaps[0].reason), (1, 10, 13, GapReason::NotRecorded));
}

#[test]
fn without_its_identity_another_stream_begins() {
    let folder = temporary();
    let mut spool = open(folder.path());
    append(&mut spool, 10, |_| false);
    let stream = spool.state().stream;
    drop(spool);
    fs::remove_file(folder.path().join("identity")).unwrap();
    let mut spool = open(folder.path());
    assert_ne!(spool.state().stream, stream);
    assert_eq!(read_all(&mut spool, 0).0.len(), 10);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]
    /// After any operations in any order, each number is a packet as written or a gap with its reason.
    #[test]
    fn every_number_is_accounted_for(steps in proptest::collection::vec((0..7_u8, 1..120_u64), 1..20)) {
        let folder = temporary();
        let bounds = Bounds { bytes: 20_000, file_bytes: 2048 };
        let start = |boot: &str| Spool::open_after(folder.path(), bounds, time(0), boot).unwrap().0;
        let mut spool = start("0");
        let (mut acknowledged, mut boots) = (0, 0);
        for (step, amount) in steps {
            match step {
                0..=2 => append(&mut spool, amount, |number| number % 9 == 0),
                3 => spool.missed(amount, time(0), time(1)),
                4 => {
                    acknowledged = spool.state().next.min(acknowledged + amount);
                    spool.acknowledged(acknowledged);
                }
                _ => {
                    boots += u64::from(step == 6);
                    drop(spool);
                    spool = start(&boots.to_string());
                }
            }
            spool.write().unwrap();
            let next = spool.state().next;
            let (packets, gaps) = read_all(&mut spool, acknowledged);
            let there: Vec<u64> =
                (acknowledged..next).filter(|n| !gaps.iter().any(|gap| (gap.from..gap.to).contains(n))).collect();
            prop_assert_eq!(packets, there);
            prop_assert!(gaps.iter().all(|gap| gap.reason != GapReason::Damaged));
        }
    }
}
