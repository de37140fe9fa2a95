//! Compressed days: every byte and every arrival as before, whatever breaks off the work.

use crate::archive::bytes::DayFile;
use crate::archive::{ARRIVALS, Arrival, DATA, DayKey, DayReader, Disk, Packed, RealDisk, days, packed_name};
use crate::faults::{FullDisk, State, copy, scratch};
use crate::{
    Accepted, Health, LinkSeq, PackStep, Packable, PackedDay, Packing, Store, StoreError, Tail, Transport,
    doctor, plan_packing,
};
use imc::messages::TextMessage;
use imc::{Address, Header};
use proptest::prelude::*;
use std::fs;
use std::io::Read as _;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex};
use units::UtcTime;

/// 2026-11-21T08:00:00Z.
const START_US: i64 = 1_795_248_000_000_000;
const DAY_US: i64 = 86_400_000_000;
const NOW: UtcTime = UtcTime::from_micros(START_US + 30 * DAY_US);
const STREAM: u64 = 0xFEED_0000_0000_0007;

fn packet(number: u64, letters: usize) -> Vec<u8> {
    let header = Header {
        timestamp: START_US as f64 / 1e6 + number as f64,
        src: Address(0x2810),
        ..Header::default()
    };
    let text: String =
        (0..letters).map(|at| char::from(b'a' + ((number as usize * 7 + at * at) % 26) as u8)).collect();
    let mut bytes = Vec::new();
    imc::encode_into(&mut bytes, &header, &TextMessage { origin: "x".into(), text: text.into() }).unwrap();
    bytes
}

fn give(store: &mut Store, day: i64, number: u64, letters: usize) {
    let (packet, received) =
        (packet(number, letters), UtcTime::from_micros(START_US + day * DAY_US + number as i64 * 1_000));
    let link = Some(LinkSeq { stream: STREAM, seq: number });
    store.accept(&Accepted { packet: &packet, received, transport: Transport::Link, link }).unwrap();
}

/// A store with a day of so many packets, and one packet on the day after.
fn fill(folder: &Path, packets: u64, letters: usize) {
    let mut store = Store::open(folder).unwrap();
    (0..packets).for_each(|number| give(&mut store, 0, number, letters));
    give(&mut store, 1, packets, letters);
    store.close().unwrap();
}

fn day(folder: &Path) -> PathBuf {
    folder.join("archive/0x2810/20261121")
}

/// Each packet of the archive with how it came, as any reader gets it.
fn everything(folder: &Path) -> Vec<(DayKey, Arrival, Vec<u8>)> {
    let root = folder.join("archive");
    let mut found = Vec::new();
    for key in days(&root).unwrap() {
        let mut reader = DayReader::open(&root, key, 0, 0).unwrap();
        while let Some(archived) = reader.next_packet().unwrap() {
            found.push((key, archived.arrival, archived.view.bytes().to_vec()));
        }
        assert_eq!(reader.damaged_bytes(), 0);
    }
    found
}

type Steps = Box<dyn FnMut(PackStep) + Send>;

fn pack_with(
    store: &mut Store,
    folder: &Path,
    steps: Steps,
    disk: Box<dyn Disk>,
    frame_bytes: u32,
) -> crate::Result<PackedDay> {
    let plan = plan_packing(folder, 3, NOW)?;
    let mut packing = Packing::begin_on(folder, &plan[0], steps, disk, frame_bytes)?;
    while packing.work(1)? {}
    Ok(store.adopt(packing)?.expect("nothing came for it"))
}

fn pack(store: &mut Store, folder: &Path) -> PackedDay {
    pack_with(store, folder, Box::new(|_| ()), Box::new(RealDisk), 1 << 12).unwrap()
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn all_bytes_and_any_stretch_of_them_are_as_before(
        letters in prop::collection::vec(0_usize..3_000, 1..40),
        frame_records in 1_u32..200,
        places in prop::collection::vec((0.0..1.1_f64, 1_usize..5_000), 1..20),
    ) {
        let scratch = scratch();
        let folder = scratch.path();
        let mut store = Store::open(folder).unwrap();
        for (number, letters) in (0..).zip(&letters) {
            give(&mut store, 0, number, *letters);
        }
        give(&mut store, 1, 1_000, 5);
        store.commit().unwrap();
        let before = everything(folder);
        let plain = [DATA, ARRIVALS].map(|name| fs::read(day(folder).join(name)).unwrap());
        pack_with(&mut store, folder, Box::new(|_| ()), Box::new(RealDisk), frame_records * 32).unwrap();
        prop_assert_eq!(everything(folder), before);
        for (name, plain) in [DATA, ARRIVALS].into_iter().zip(&plain) {
            prop_assert!(!day(folder).join(name).exists());
            let mut packed = Packed::open(&day(folder).join(packed_name(name))).unwrap();
            let mut bytes = Vec::new();
            packed.read_to_end(&mut bytes).unwrap();
            prop_assert_eq!(&bytes, plain);
            for (share, count) in &places {
                let at = (*share * plain.len() as f64) as usize;
                let mut stretch = Vec::new();
                let file = DayFile::open(&day(folder), name, at as u64).unwrap();
                file.take(*count as u64).read_to_end(&mut stretch).unwrap();
                let at = at.min(plain.len());
                prop_assert_eq!(&stretch, &plain[at..plain.len().min(at + count)]);
            }
        }
        // Another program unpacks it, too.
        let mut other = Vec::new();
        let file = fs::File::open(day(folder).join("Data.lsf.zst")).unwrap();
        zstd::stream::read::Decoder::new(file).unwrap().read_to_end(&mut other).unwrap();
        prop_assert_eq!(&other, &plain[0]);
    }
}

#[test]
fn a_kill_at_any_step_loses_nothing_and_the_next_run_ends_the_work() {
    let scratch = scratch();
    let (folder, copies) = (scratch.path().join("data"), scratch.path().join("copies"));
    fill(&folder, 300, 40);
    let before = everything(&folder);
    let plain_bytes = fs::metadata(day(&folder).join(DATA)).unwrap().len();
    let mut store = Store::open(&folder).unwrap();
    let seen = Arc::new(Mutex::new(Vec::new()));
    let steps = {
        let (folder, copies, seen) = (folder.clone(), copies.clone(), Arc::clone(&seen));
        // The files as a kill leaves them: nothing of what comes later, and nothing cleaned up.
        Box::new(move |step: PackStep| {
            let mut seen = seen.lock().unwrap();
            copy(&folder, &copies.join(seen.len().to_string()));
            seen.push(step);
        })
    };
    pack_with(&mut store, &folder, steps, Box::new(RealDisk), 1 << 12).unwrap();
    let seen = seen.lock().unwrap().clone();
    for step in PackStep::ALL {
        assert!(seen.contains(&step), "{step:?} is not a step any more");
    }
    for (at, step) in seen.iter().enumerate() {
        let folder = copies.join(at.to_string());
        assert_eq!(everything(&folder), before, "read at {step:?} as it is");
        let mut store = Store::open(&folder).unwrap();
        assert_eq!(store.repairs().notes, Vec::<String>::new(), "{step:?}");
        assert_eq!((store.durable(STREAM), everything(&folder)), (Some(300), before.clone()), "{step:?}");
        while let Some(day) = plan_packing(&folder, 3, NOW).unwrap().first() {
            let mut packing = Packing::begin(&folder, day).unwrap();
            while packing.work(1 << 12).unwrap() {}
            store.adopt(packing).unwrap().unwrap();
        }
        store.close().unwrap();
        assert_eq!(everything(&folder), before, "{step:?}");
        assert!(!day(&folder).join(DATA).exists() && !day(&folder).join(ARRIVALS).exists(), "{step:?}");
        let packed_bytes = fs::metadata(day(&folder).join("Data.lsf.zst")).unwrap().len();
        assert!(packed_bytes < plain_bytes / 2, "{packed_bytes} of {plain_bytes}");
    }
}

#[test]
fn a_disk_that_is_full_at_any_byte_leaves_the_plain_day() {
    let scratch = scratch();
    let folder = scratch.path();
    fill(folder, 40, 30);
    let before = everything(folder);
    let mut store = Store::open(folder).unwrap();
    let mut room = 0;
    loop {
        let state = Arc::new(Mutex::new(State { room, syncs: true }));
        match pack_with(&mut store, folder, Box::new(|_| ()), Box::new(FullDisk(state)), 1 << 10) {
            Ok(_) => break,
            Err(error) => assert!(error.is_disk_full(), "{error}"),
        }
        assert_eq!(everything(folder), before);
        assert!(!folder.join("archive/packing").exists(), "the room is given back");
        assert!(!day(folder).join("Data.lsf.zst").exists());
        room += 7;
    }
    assert!(room > 300, "{room} bytes are too few for it");
    assert_eq!(everything(folder), before);
    // One that cannot sync.
    let scratch = self::scratch();
    fill(scratch.path(), 40, 30);
    let mut store = Store::open(scratch.path()).unwrap();
    let state = Arc::new(Mutex::new(State { room: usize::MAX, syncs: false }));
    pack_with(&mut store, scratch.path(), Box::new(|_| ()), Box::new(FullDisk(state)), 1 << 10).unwrap_err();
    assert_eq!(everything(scratch.path()), before);
}

#[test]
fn what_still_comes_for_a_compressed_day_goes_to_a_further_part() {
    let scratch = scratch();
    let folder = scratch.path();
    fill(folder, 50, 30);
    let mut store = Store::open(folder).unwrap();
    let mut tail = Tail::open(folder, "test", "there").unwrap();
    let mut carried = |store: &Store| {
        let mut count = 0;
        while let Some(place) = tail
            .read(&store.marks(), |_| {
                count += 1;
                true
            })
            .unwrap()
        {
            tail.carried(place, &store.marks()).unwrap();
        }
        count
    };
    assert_eq!(carried(&store), 51);
    pack(&mut store, folder);
    assert_eq!(carried(&store), 0, "compressing is nothing new");
    let packed = fs::read(day(folder).join("Data.lsf.zst")).unwrap();
    for number in 51..60 {
        give(&mut store, 0, number, 30);
        assert_eq!(store.commit().unwrap().history_behind, None);
    }
    assert_eq!(carried(&store), 9);
    let check = |folder: &Path, store: &Store| {
        assert_eq!(
            fs::read(day(folder).join("Data.lsf.zst")).unwrap(),
            packed,
            "a compressed file is never changed"
        );
        assert!(
            !day(folder).join(DATA).exists() && folder.join("archive/0x2810/20261121-2/Data.lsf").exists()
        );
        assert_eq!(everything(folder).len(), 60);
        assert_eq!(store.durable(STREAM), Some(59));
    };
    check(folder, &store);
    store.close().unwrap();
    // From the archive alone.
    fs::remove_dir_all(folder.join("history")).unwrap();
    let mut store = Store::open(folder).unwrap();
    check(folder, &store);
    assert_eq!(store.repairs().replayed, 60);
    // Later that part is compressed as well, and the next one begins.
    pack(&mut store, folder);
    give(&mut store, 0, 60, 30);
    store.commit().unwrap();
    assert_eq!(everything(folder).last().unwrap().0.name(), "0x2810/20261122");
    assert!(folder.join("archive/0x2810/20261121-3/Data.lsf").exists());
    assert_eq!((carried(&store), everything(folder).len()), (1, 61));
    // Removed as one day.
    let before = UtcTime::from_micros(START_US + DAY_US);
    let gone =
        store.retain(&crate::Retention { archive_before: Some(before), ..Default::default() }).unwrap();
    assert_eq!((gone.len(), everything(folder).len()), (3, 1));
    assert!(!day(folder).exists());
    give(&mut store, 0, 61, 30);
    store.commit().unwrap();
    assert!(day(folder).join(DATA).exists(), "a removed day begins anew");
}

#[test]
fn a_day_to_which_something_came_meanwhile_is_left_as_it_is() {
    let scratch = scratch();
    let folder = scratch.path();
    fill(folder, 50, 30);
    let mut store = Store::open(folder).unwrap();
    for is_durable in [false, true] {
        let plan = plan_packing(folder, 3, NOW).unwrap();
        let mut packing = Packing::begin(folder, &plan[0]).unwrap();
        while packing.work(1 << 20).unwrap() {}
        give(&mut store, 0, 51 + u64::from(is_durable), 30);
        if is_durable {
            store.commit().unwrap();
        }
        assert_eq!(store.adopt(packing).unwrap(), None);
        assert!(day(folder).join(DATA).exists() && !day(folder).join("Data.lsf.zst").exists());
    }
    assert_eq!(everything(folder).len(), 53);
    pack(&mut store, folder);
    assert_eq!(everything(folder).len(), 53);
    // Work that is not done is refused.
    let scratch = self::scratch();
    fill(scratch.path(), 5, 5);
    let mut store = Store::open(scratch.path()).unwrap();
    let plan = plan_packing(scratch.path(), 3, NOW).unwrap();
    store.adopt(Packing::begin(scratch.path(), &plan[0]).unwrap()).unwrap_err();
}

#[test]
fn only_days_that_ended_long_enough_ago_are_chosen_and_never_the_newest() {
    let scratch = scratch();
    let folder = scratch.path();
    let mut store = Store::open(folder).unwrap();
    for day in [0, 1, 2, 5] {
        give(&mut store, day, day as u64, 5);
    }
    store.close().unwrap();
    let plan = |after_days, now| -> Vec<u32> {
        plan_packing(folder, after_days, now).unwrap().iter().map(|one| one.key.day).collect()
    };
    let midnight = UtcTime::from_micros(START_US - START_US % DAY_US + 4 * DAY_US);
    assert_eq!(plan(3, midnight), [20_261_121]);
    assert_eq!(plan(3, UtcTime::from_micros(midnight.micros() - 1)), [0_u32; 0]);
    assert_eq!(plan(0, NOW), [20_261_121, 20_261_122, 20_261_123]);
    assert_eq!(plan(3, UtcTime::from_micros(0)), [0_u32; 0], "a clock that was not set");
}

#[test]
fn a_damaged_frame_costs_its_packets_alone_and_is_named() {
    let scratch = scratch();
    let folder = scratch.path();
    fill(folder, 400, 60);
    let before = everything(folder);
    let mut store = Store::open(folder).unwrap();
    pack(&mut store, folder);
    store.close().unwrap();
    let path = day(folder).join("Data.lsf.zst");
    let whole = fs::read(&path).unwrap();
    let mut damaged = whole.clone();
    damaged[whole.len() / 2] ^= 0x10;
    fs::write(&path, &damaged).unwrap();
    let mut reader = DayReader::open(&folder.join("archive"), before[0].0, 0, 0).unwrap();
    let mut kept = 0;
    while let Some(archived) = reader.next_packet().unwrap() {
        assert!(
            before
                .iter()
                .any(|(_, arrival, bytes)| *arrival == archived.arrival && bytes == archived.view.bytes())
        );
        kept += 1;
    }
    assert!((300..400).contains(&kept) && reader.damaged_bytes() > 0, "{kept} of 400 packets");
    let told = |thorough| -> Vec<String> {
        let checks = doctor(folder, NOW, thorough, &mut |_| true).unwrap();
        checks.into_iter().filter(|check| check.health == Health::Problem).map(|check| check.found).collect()
    };
    assert!(told(true).iter().any(|found| found.contains("0x2810/20261121") && found.contains("damaged")));
    // Head, seek table, and a file that is cut: the day cannot be read, everything else can, and recording goes on.
    for cut in [10, whole.len() / 2, whole.len() - 1] {
        fs::write(&path, &whole[..cut]).unwrap();
        assert!(told(false).iter().any(|found| found.contains("Data.lsf.zst")), "{cut}");
        let mut store = Store::open(folder).unwrap();
        assert!(
            store.repairs().notes.iter().any(|note| note.contains("Data.lsf.zst")),
            "{:?}",
            store.repairs().notes
        );
        give(&mut store, 0, 1_000 + cut as u64, 5);
        store.commit().unwrap();
        assert!(folder.join("archive/0x2810/20261121-2/Data.lsf").exists());
        drop(store);
    }
    assert_eq!(fs::read(&path).unwrap().len(), whole.len() - 1, "nothing is written to a damaged file");
}

#[test]
fn two_forms_that_differ_are_both_kept() {
    let scratch = scratch();
    let folder = scratch.path();
    fill(folder, 60, 30);
    let plain = fs::read(day(folder).join(DATA)).unwrap();
    let mut store = Store::open(folder).unwrap();
    pack(&mut store, folder);
    store.close().unwrap();
    // A plain day of an older backup, put back by hand: shorter.
    fs::write(day(folder).join(DATA), &plain[..plain.len() / 2]).unwrap();
    fs::write(day(folder).join(ARRIVALS), b"").unwrap();
    let plan: Vec<Packable> = plan_packing(folder, 3, NOW).unwrap();
    let packed = fs::read(day(folder).join("Data.lsf.zst")).unwrap();
    let mut packing = Packing::begin(folder, &plan[0]).unwrap();
    let error = loop {
        match packing.work(1 << 20) {
            Ok(true) => {}
            Ok(false) => panic!("a file that differs was taken"),
            Err(error) => break error,
        }
    };
    assert!(matches!(error, StoreError::Differs { .. }), "{error}");
    assert_eq!(fs::read(day(folder).join("Data.lsf.zst")).unwrap(), packed);
    assert!(day(folder).join(DATA).exists());
}

#[test]
fn plain_packets_beside_compressed_records_keep_how_they_came() {
    let scratch = scratch();
    let folder = scratch.path();
    fill(folder, 60, 30);
    let (before, plain) = (everything(folder), fs::read(day(folder).join(DATA)).unwrap());
    let mut store = Store::open(folder).unwrap();
    pack(&mut store, folder);
    store.close().unwrap();
    // As in a backup that was made while the day was compressed.
    fs::write(day(folder).join(DATA), &plain).unwrap();
    fs::remove_file(day(folder).join("Data.lsf.zst")).unwrap();
    fs::remove_dir_all(folder.join("history")).unwrap();
    let mut store = Store::open(folder).unwrap();
    assert_eq!((store.durable(STREAM), everything(folder)), (Some(60), before.clone()));
    pack(&mut store, folder);
    assert_eq!(everything(folder), before);
}

#[test]
fn an_archive_is_of_the_later_format_only_once_a_day_is_compressed() {
    let scratch = scratch();
    let folder = scratch.path();
    fill(folder, 5, 5);
    let format = || fs::read_to_string(folder.join("archive/format.json")).unwrap();
    assert!(format().contains("\"format\":1"), "{}", format());
    let mut store = Store::open(folder).unwrap();
    pack(&mut store, folder);
    assert!(format().contains("\"format\":2"), "{}", format());
    drop(store);
    crate::refuse_newer(folder).unwrap();
    Store::open(folder).unwrap();
}
