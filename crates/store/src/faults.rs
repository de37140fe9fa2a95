//! Faults of disks and power: every byte at which a write can stop, every byte at which a file can end.

use crate::archive::Disk;
use crate::{Accepted, LinkSeq, Outcome, Reader, Store, TimeRange, Transport};
use imc::messages::Temperature;
use imc::{Address, Header};
use std::fs::{self, File};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use units::UtcTime;

const START_US: i64 = 1_795_248_000_000_000;
const STREAM: u64 = 99;

/// A folder in memory where there is one: these tests sync a thousand times.
pub(crate) fn scratch() -> tempfile::TempDir {
    let memory = Path::new("/dev/shm");
    if memory.is_dir() { tempfile::tempdir_in(memory).unwrap() } else { tempfile::tempdir().unwrap() }
}

/// A disk with room for some bytes, and perhaps one that cannot sync.
#[derive(Debug, Clone, Copy)]
pub(crate) struct State {
    pub(crate) room: usize,
    pub(crate) syncs: bool,
}

#[derive(Debug)]
pub(crate) struct FullDisk(pub(crate) Arc<Mutex<State>>);

impl Disk for FullDisk {
    fn append(&mut self, mut file: &File, bytes: &[u8]) -> io::Result<()> {
        let mut state = self.0.lock().unwrap();
        let fits = state.room.min(bytes.len());
        file.write_all(&bytes[..fits])?;
        state.room -= fits;
        if fits < bytes.len() { Err(io::ErrorKind::StorageFull.into()) } else { Ok(()) }
    }

    fn sync(&mut self, file: &File) -> io::Result<()> {
        let state = *self.0.lock().unwrap();
        if state.syncs { file.sync_data() } else { Err(io::Error::other("the disk does not answer")) }
    }
}

/// Packets of two systems in turn, of one record lane.
fn packet(seq: u64) -> Vec<u8> {
    let header = Header {
        timestamp: (START_US as f64) / 1e6 + seq as f64,
        src: Address(0x2810 + (seq % 2) as u16),
        src_ent: 3,
        ..Header::default()
    };
    let mut bytes = Vec::new();
    imc::encode_into(&mut bytes, &header, &Temperature { value: seq as f32 }).unwrap();
    bytes
}

fn give(store: &mut Store, seq: u64) -> Outcome {
    let packet = packet(seq);
    let received = UtcTime::from_micros(START_US + seq as i64);
    let link = Some(LinkSeq { stream: STREAM, seq });
    store.accept(&Accepted { packet: &packet, received, transport: Transport::Link, link }).unwrap()
}

fn data(folder: &Path, system: u16) -> PathBuf {
    folder.join(format!("archive/{system:#06x}/20261121/Data.lsf"))
}

fn arrivals(folder: &Path, system: u16) -> PathBuf {
    data(folder, system).with_file_name("Arrivals.idx")
}

/// The numbers of a system's packets, which must be whole.
fn archived(folder: &Path, system: u16) -> Vec<u64> {
    let bytes = fs::read(data(folder, system)).unwrap_or_default();
    let mut found = Vec::new();
    for frame in imc::Frames::new(&bytes) {
        match frame {
            imc::Frame::Packet { view, .. } => found.push((view.timestamp() - START_US as f64 / 1e6) as u64),
            imc::Frame::Damage(damage) => panic!("{damage:?}"),
        }
    }
    found
}

/// The numbers in the history.
fn history(folder: &Path) -> Vec<u64> {
    let mut reader = Reader::open(folder).unwrap();
    let mut found = Vec::new();
    for series in reader.series(None).unwrap() {
        let source = crate::Source {
            system: Address(series.group.src),
            entity: series.group.src_ent,
            message: "Temperature".to_owned(),
        };
        let samples = reader.samples(&source, &["value"], TimeRange::ALL, 100_000).unwrap();
        found.extend(samples.values[0].iter().map(|value| *value as u64));
    }
    found.sort_unstable();
    found
}

fn open_on(folder: &Path, state: &Arc<Mutex<State>>) -> Store {
    Store::open_on(folder, Box::new(FullDisk(Arc::clone(state))), &mut |_| true).unwrap()
}

#[test]
fn a_disk_that_is_full_at_any_byte_loses_nothing_and_acknowledges_nothing() {
    const BATCH: u64 = 5;
    let folder = scratch();
    let state = Arc::new(Mutex::new(State { room: usize::MAX, syncs: true }));
    let mut store = open_on(folder.path(), &state);
    // A commit writes packets and records.
    let needed = BATCH as usize * (packet(0).len() + 32);
    let numbers = |last: u64, odd: u64| (1..=last).filter(|seq| seq % 2 == odd).collect::<Vec<_>>();
    for room in 0..needed as u64 {
        let (before, after) = (room * BATCH, (room + 1) * BATCH);
        let durable = (room > 0).then_some(before);
        state.lock().unwrap().room = room as usize;
        (before + 1..=after).for_each(|seq| assert_eq!(give(&mut store, seq), Outcome::Recorded));
        let error = store.commit().unwrap_err();
        assert!(error.is_disk_full(), "{error}");
        assert_eq!(store.durable(STREAM), durable);
        for odd in [0, 1] {
            let found = archived(folder.path(), 0x2810 + odd as u16);
            assert_eq!(found, numbers(before, odd), "half of a commit at {room} bytes of room");
        }
        assert!(store.commit().is_err(), "it is still full");
        state.lock().unwrap().room = usize::MAX;
        assert_eq!(store.commit().unwrap().durable, [LinkSeq { stream: STREAM, seq: after }]);
        for odd in [0, 1] {
            assert_eq!(archived(folder.path(), 0x2810 + odd as u16), numbers(after, odd));
        }
    }
    let last = needed as u64 * BATCH;
    assert_eq!(history(folder.path()), (1..=last).collect::<Vec<_>>());
    drop(store);
    let store = Store::open(folder.path()).unwrap();
    assert_eq!((store.durable(STREAM), &store.repairs().notes), (Some(last), &Vec::new()));
}

#[test]
fn a_disk_that_cannot_sync_acknowledges_nothing() {
    let folder = scratch();
    let state = Arc::new(Mutex::new(State { room: usize::MAX, syncs: false }));
    let mut store = open_on(folder.path(), &state);
    give(&mut store, 1);
    assert!(!store.commit().unwrap_err().is_disk_full());
    assert_eq!(store.durable(STREAM), None);
    assert_eq!(history(folder.path()), Vec::<u64>::new());
    state.lock().unwrap().syncs = true;
    assert_eq!(store.commit().unwrap().durable, [LinkSeq { stream: STREAM, seq: 1 }]);
    assert_eq!(history(folder.path()), [1]);
}

/// A store with nine packets, closed, and copies of it whose files are changed before they are opened.
fn after_damage(change: impl Fn(&Path), check: impl Fn(&Path, Store)) {
    let folder = scratch();
    copy(original().path(), folder.path());
    change(folder.path());
    check(folder.path(), Store::open(folder.path()).unwrap());
}

fn original() -> tempfile::TempDir {
    let folder = scratch();
    let mut store = Store::open(folder.path()).unwrap();
    for seq in 1..=9 {
        give(&mut store, seq);
        if seq % 3 == 0 {
            store.commit().unwrap();
        }
    }
    store.close().unwrap();
    folder
}

pub(crate) fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap() {
        let entry = entry.unwrap();
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

fn cut(path: &Path, bytes: u64) {
    let file = File::options().write(true).open(path).unwrap();
    let length = file.metadata().unwrap().len();
    file.set_len(length - bytes).unwrap();
}

/// The vessel sends again what was not acknowledged.
fn send_again_from(store: &mut Store, durable: Option<u64>) {
    for seq in durable.map_or(1, |seq| seq + 1)..=9 {
        give(store, seq);
    }
    store.commit().unwrap();
    assert_eq!(store.durable(STREAM), Some(9));
}

#[test]
fn data_that_ends_at_any_byte_is_mended_and_completed() {
    let packet_bytes = packet(1).len() as u64;
    for bytes in 1..=2 * packet_bytes {
        after_damage(
            |folder| cut(&data(folder, 0x2811), bytes),
            |folder, mut store| {
                let whole: &[u64] = if bytes <= packet_bytes { &[1, 3, 5, 7] } else { &[1, 3, 5] };
                assert_eq!(archived(folder, 0x2811), whole);
                assert!(!store.repairs().notes.is_empty());
                // Number 8 lies in the other file, behind the hole.
                let durable = if bytes <= packet_bytes { Some(8) } else { Some(6) };
                assert_eq!(store.durable(STREAM), durable, "{bytes} bytes cut");
                send_again_from(&mut store, durable);
                assert_eq!(archived(folder, 0x2811), [1, 3, 5, 7, 9]);
                assert_eq!(archived(folder, 0x2810), [2, 4, 6, 8], "8 was there already");
                assert_eq!(history(folder), (1..=9).collect::<Vec<_>>());
            },
        );
    }
}

#[test]
fn records_that_end_at_any_byte_cost_no_packet() {
    for bytes in 1..=65 {
        after_damage(
            |folder| cut(&arrivals(folder, 0x2811), bytes),
            |folder, mut store| {
                assert_eq!(archived(folder, 0x2811), [1, 3, 5, 7, 9]);
                assert_eq!(store.durable(STREAM), Some(9), "all data is there");
                send_again_from(&mut store, Some(6));
                assert_eq!(archived(folder, 0x2811), [1, 3, 5, 7, 9]);
                assert_eq!(history(folder), (1..=9).collect::<Vec<_>>());
            },
        );
    }
}

#[test]
fn bytes_behind_the_end_are_told_apart() {
    let whole = packet(11);
    for extra in 1..whole.len() {
        after_damage(
            |folder| append(&data(folder, 0x2811), &whole[..extra]),
            |folder, store| {
                assert_eq!(archived(folder, 0x2811), [1, 3, 5, 7, 9], "half a packet was kept");
                assert_eq!(store.durable(STREAM), Some(9));
                assert_eq!(store.repairs().notes.len(), 1);
            },
        );
    }
    after_damage(
        |folder| append(&data(folder, 0x2811), &whole),
        |folder, store| {
            assert_eq!(archived(folder, 0x2811), [1, 3, 5, 7, 9, 11], "a whole packet was thrown away");
            assert_eq!(store.repairs().replayed, 1);
            assert_eq!(history(folder), [1, 2, 3, 4, 5, 6, 7, 8, 9, 11]);
        },
    );
    // Power loss leaves zeros where a file had grown.
    after_damage(
        |folder| {
            append(&data(folder, 0x2811), &[0; 4096]);
            append(&arrivals(folder, 0x2811), &[0; 4096]);
        },
        |folder, store| {
            assert_eq!(archived(folder, 0x2811), [1, 3, 5, 7, 9]);
            assert_eq!(fs::metadata(arrivals(folder, 0x2811)).unwrap().len(), 5 * 32);
            assert_eq!(store.durable(STREAM), Some(9));
        },
    );
}

#[test]
fn without_its_sidecars_and_its_history_the_archive_is_still_read() {
    after_damage(
        |folder| {
            fs::remove_file(arrivals(folder, 0x2810)).unwrap();
            fs::remove_file(arrivals(folder, 0x2811)).unwrap();
            fs::remove_dir_all(folder.join("history")).unwrap();
        },
        |folder, store| {
            assert_eq!(history(folder), (1..=9).collect::<Vec<_>>());
            assert_eq!(store.durable(STREAM), None);
            assert_eq!(store.repairs().replayed, 9);
        },
    );
}

#[test]
fn without_its_history_the_numbers_come_from_the_archive() {
    after_damage(
        |folder| fs::remove_dir_all(folder.join("history")).unwrap(),
        |folder, mut store| {
            assert_eq!(store.durable(STREAM), Some(9));
            assert_eq!(give(&mut store, 9), Outcome::Duplicate);
            assert_eq!(history(folder), (1..=9).collect::<Vec<_>>());
        },
    );
}

#[test]
fn numbers_may_be_left_out_but_not_go_back() {
    let folder = scratch();
    let mut store = Store::open(folder.path()).unwrap();
    assert_eq!([5, 6, 10, 11].map(|seq| give(&mut store, seq)), [Outcome::Recorded; 4]);
    assert_eq!([5, 8, 10, 11].map(|seq| give(&mut store, seq)), [Outcome::Duplicate; 4]);
    store.commit().unwrap();
    drop(store);
    fs::remove_dir_all(folder.path().join("history")).unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    assert_eq!(store.durable(STREAM), Some(11), "the jump from 6 to 10 was declared");
    assert_eq!(give(&mut store, 11), Outcome::Duplicate);
}

#[test]
fn a_history_of_a_later_version_is_left_alone() {
    let folder = scratch();
    let mut store = Store::open(folder.path()).unwrap();
    give(&mut store, 1);
    store.commit().unwrap();
    store.close().unwrap();
    let month = folder.path().join("history/2026-11.sqlite");
    rusqlite::Connection::open(&month).unwrap().pragma_update(None, "user_version", 99).unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    give(&mut store, 2);
    let told = store.commit().unwrap().history_behind.unwrap();
    assert!(told.contains("later version") && told.contains("reindex"), "{told}");
    assert_eq!(store.durable(STREAM), Some(2), "the archive takes it all the same");
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig { cases: 48, ..Default::default() })]

    /// Whatever a disk made of a day's files, it opens, keeps the packets that are whole and continues.
    #[test]
    fn scrambled_files_open(
        at in 0_usize..300,
        bytes in proptest::collection::vec(proptest::prelude::any::<u8>(), 1..80),
        sidecar in proptest::prelude::any::<bool>(),
    ) {
        after_damage(
            |folder| {
                let path = if sidecar { arrivals(folder, 0x2811) } else { data(folder, 0x2811) };
                let mut content = fs::read(&path).unwrap();
                let end = (at + bytes.len()).max(content.len());
                content.resize(end, 0);
                content[at..at + bytes.len()].copy_from_slice(&bytes);
                fs::write(&path, content).unwrap();
            },
            |folder, mut store| {
                let whole = |folder: &Path| {
                    let bytes = fs::read(data(folder, 0x2811)).unwrap();
                    imc::Frames::new(&bytes).filter(|frame| matches!(frame, imc::Frame::Packet { .. })).count()
                };
                let before = whole(folder);
                if sidecar {
                    assert_eq!(before, 5);
                }
                give(&mut store, 11);
                store.commit().unwrap();
                assert_eq!(whole(folder), before + 1);
                assert!(history(folder).contains(&11));
            },
        );
    }
}

#[test]
fn one_writer_at_a_time() {
    let folder = scratch();
    let store = Store::open(folder.path()).unwrap();
    let refused = Store::open(folder.path()).unwrap_err().to_string();
    assert!(refused.contains("in use by another process"), "{refused}");
    assert!(refused.contains(&std::process::id().to_string()), "{refused}");
    drop(store);
    Store::open(folder.path()).unwrap();
}

#[test]
fn what_is_no_packet_is_refused_and_what_is_too_much_waits() {
    let folder = scratch();
    let mut store = Store::open(folder.path()).unwrap();
    let received = UtcTime::from_micros(START_US);
    let mut accept =
        |packet: &[u8]| store.accept(&Accepted { packet, received, transport: Transport::Udp, link: None });
    let good = packet(1);
    assert!(accept(&good[..good.len() - 1]).unwrap_err().to_string().contains("truncated"));
    assert!(accept(b"GET / HTTP/1.1\r\n\r\n1234567890").unwrap_err().to_string().contains("bad sync"));
    assert!(
        accept(&[good.clone(), good.clone()].concat()).unwrap_err().to_string().contains("follow the packet")
    );
    let mut damaged = good.clone();
    damaged[21] ^= 1;
    assert!(accept(&damaged).unwrap_err().to_string().contains("CRC"));
    let large = imc::messages::TextMessage { origin: "x".into(), text: "y".repeat(60_000).into() };
    let mut refused = 0;
    for seq in 0..1_200 {
        let header = Header { timestamp: f64::from(seq), src: Address(0x2810), ..Header::default() };
        let mut bytes = Vec::new();
        imc::encode_into(&mut bytes, &header, &large).unwrap();
        refused += u32::from(matches!(accept(&bytes), Err(crate::StoreError::Full { .. })));
    }
    assert!((50..100).contains(&refused), "{refused} of 1200 packets of 60 kB were refused");
    assert!(store.commit().unwrap().packets > 1_000);
    assert_eq!(store.waiting_bytes(), 0);
}

fn append(path: &Path, bytes: &[u8]) {
    File::options().append(true).open(path).unwrap().write_all(bytes).unwrap();
}
