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
    Ok(store.adopt(&mut packing)?.expect("nothing came for it"))
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
            store.adopt(&mut packing).unwrap().unwrap();
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
        assert_eq!(store.adopt(&mut packing).unwrap(), None);
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
    store.adopt(&mut Packing::begin(scratch.path(), &plan[0]).unwrap()).unwrap_err();
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
    // A file that is cut is named, and recording goes on.
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
    let before = everything(folder);
    let mut reader = crate::Reader::open(folder).unwrap();
    let samples = |reader: &mut crate::Reader| -> u64 {
        reader.series(None).unwrap().iter().map(|one| one.extent.count).sum()
    };
    let held = samples(&mut reader);
    // A plain day of an older backup, or half unpacked by hand: shorter.
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
    assert!(error.to_string().contains("the compressed one is in use"), "{error}");
    drop(packing);
    // The longer one is in use, and neither is changed.
    for _ in 0..2 {
        assert_eq!(everything(folder), before);
        let store = Store::open(folder).unwrap();
        assert_eq!((store.durable(STREAM), store.repairs().replayed), (Some(60), 0));
        assert!(
            store.repairs().notes.iter().any(|note| note.contains("Move Data.lsf")),
            "{:?}",
            store.repairs().notes
        );
        assert!(!folder.join("archive/shortened.jsonl").exists());
        store.close().unwrap();
    }
    assert_eq!(samples(&mut crate::Reader::open(folder).unwrap()), held);
    let names: Vec<PathBuf> =
        crate::backup_files(folder).unwrap().into_iter().map(|file| file.path).collect();
    assert!(names.iter().any(|path| path.ends_with("20261121/Data.lsf.zst")), "{names:?}");
    assert!(!names.iter().any(|path| path.ends_with("20261121/Data.lsf")), "{names:?}");
    assert_eq!(fs::read(day(folder).join("Data.lsf.zst")).unwrap(), packed);
    assert_eq!(fs::read(day(folder).join(DATA)).unwrap(), plain[..plain.len() / 2]);
    // As long, with other contents: a power cut while it was unpacked.
    fs::write(day(folder).join(DATA), vec![0; plain.len()]).unwrap();
    assert_eq!(everything(folder), before);
    let mut store = Store::open(folder).unwrap();
    let packed_again = pack_with(&mut store, folder, Box::new(|_| ()), Box::new(RealDisk), 1 << 12);
    assert!(matches!(packed_again, Err(StoreError::Differs { .. })), "{packed_again:?}");
    assert_eq!(fs::read(day(folder).join("Data.lsf.zst")).unwrap(), packed);
}

type Everything = Vec<(DayKey, Arrival, Vec<u8>)>;

/// A folder with a compressed day, its plain packets and records, and all of its archive as it is read.
fn packed_day(folder: &Path) -> ([Vec<u8>; 2], Everything) {
    fill(folder, 60, 30);
    let plain = [DATA, ARRIVALS].map(|name| fs::read(day(folder).join(name)).unwrap());
    let mut store = Store::open(folder).unwrap();
    pack(&mut store, folder);
    store.close().unwrap();
    (plain, everything(folder))
}

#[test]
fn a_packet_that_comes_between_a_kill_and_the_next_run_does_not_hold_it_up() {
    let scratch = scratch();
    let folder = scratch.path();
    let (plain, before) = packed_day(folder);
    // As a kill before the plain files go leaves it.
    for (name, plain) in [DATA, ARRIVALS].iter().zip(&plain) {
        fs::write(day(folder).join(name), plain).unwrap();
    }
    let mut store = Store::open(folder).unwrap();
    assert_eq!(store.repairs().notes, Vec::<String>::new());
    give(&mut store, 0, 61, 30);
    store.commit().unwrap();
    pack(&mut store, folder);
    assert!(!day(folder).join(DATA).exists() && !day(folder).join(ARRIVALS).exists());
    assert!(folder.join("archive/0x2810/20261121-2/Data.lsf").exists());
    assert_eq!(everything(folder).len(), before.len() + 1);
    // A plain day that holds more, put there by hand: compressed anew.
    let other = self::scratch();
    fill(other.path(), 80, 30);
    let longer = [DATA, ARRIVALS].map(|name| fs::read(day(other.path()).join(name)).unwrap());
    assert!(longer[0].starts_with(&plain[0]));
    drop(store);
    for (name, longer) in [DATA, ARRIVALS].iter().zip(&longer) {
        fs::write(day(folder).join(name), longer).unwrap();
    }
    let mut store = Store::open(folder).unwrap();
    pack(&mut store, folder);
    let mut packed = Packed::open(&day(folder).join("Data.lsf.zst")).unwrap();
    let mut bytes = Vec::new();
    packed.read_to_end(&mut bytes).unwrap();
    assert!(bytes == longer[0] && !day(folder).join(DATA).exists());
}

#[test]
fn a_damaged_compressed_file_beside_its_plain_one_is_made_anew() {
    let scratch = scratch();
    let folder = scratch.path();
    let (plain, before) = packed_day(folder);
    let files = ["Data.lsf.zst", "Arrivals.zst"].map(|name| day(folder).join(name));
    let whole = files.clone().map(|path| fs::read(path).unwrap());
    for (at, is_aside) in [(100, false), (20, true)] {
        // A frame, and the head.
        for (path, whole) in files.iter().zip(&whole) {
            let mut damaged = whole.clone();
            damaged[at] ^= 1;
            fs::write(path, damaged).unwrap();
        }
        for (name, plain) in [DATA, ARRIVALS].iter().zip(&plain) {
            fs::write(day(folder).join(name), plain).unwrap();
        }
        let mut store = Store::open(folder).unwrap();
        pack(&mut store, folder);
        assert_eq!(everything(folder), before);
        assert!(!day(folder).join(DATA).exists() && !day(folder).join(ARRIVALS).exists());
        let aside = fs::read_dir(folder.join("archive/damaged")).map_or(0, Iterator::count);
        assert_eq!(aside, if is_aside { 2 } else { 0 });
        drop(store);
        let checks = doctor(folder, NOW, true, &mut |_| true).unwrap();
        assert_eq!(checks.iter().any(|check| check.found.contains("archive/damaged")), is_aside);
    }
}

#[test]
fn a_damaged_head_or_seek_table_or_a_cut_end_costs_only_what_is_gone() {
    let scratch = scratch();
    let folder = scratch.path();
    fill(folder, 400, 60);
    let before = everything(folder);
    let mut store = Store::open(folder).unwrap();
    pack(&mut store, folder);
    store.close().unwrap();
    let path = day(folder).join("Data.lsf.zst");
    let whole = fs::read(&path).unwrap();
    for at in
        [0, 5, 9, 14, 17, 22, 40, 61, whole.len() - 1, whole.len() - 7, whole.len() - 14, whole.len() - 30]
    {
        let mut damaged = whole.clone();
        damaged[at] ^= 1;
        fs::write(&path, damaged).unwrap();
        assert_eq!(everything(folder), before, "byte {at}");
        let store = Store::open(folder).unwrap();
        assert_eq!((store.durable(STREAM), store.repairs().replayed), (Some(400), 0));
        assert!(store.repairs().notes[0].contains("Data.lsf.zst: its"), "{:?}", store.repairs().notes);
        assert!(!folder.join("archive/shortened.jsonl").exists());
    }
    // The records of arrival: by their head.
    let arrivals = day(folder).join("Arrivals.zst");
    fs::write(&path, &whole).unwrap();
    let mut damaged = fs::read(&arrivals).unwrap();
    let end = damaged.len() - 1;
    damaged[end] ^= 1;
    fs::write(&arrivals, damaged).unwrap();
    assert_eq!(everything(folder), before);
    for (cut, least) in [(1, 400), (whole.len() / 2, 100)] {
        fs::write(&path, &whole[..whole.len() - cut]).unwrap();
        let mut reader = DayReader::open(&folder.join("archive"), before[0].0, 0, 0).unwrap();
        let mut kept = 0;
        while let Some(archived) = reader.next_packet().unwrap() {
            assert_eq!(archived.view.bytes(), before[kept].2);
            kept += 1;
        }
        assert!(kept >= least, "{kept} packets of 400 with {cut} bytes cut");
    }
}

#[test]
fn a_compressed_day_that_cannot_be_read_stops_neither_the_start_nor_other_days() {
    let scratch = scratch();
    let folder = scratch.path();
    let (_, before) = packed_day(folder);
    for name in ["Data.lsf.zst", "Arrivals.zst"] {
        // Opens, and each read of it fails with an error of the system, also for root.
        fs::rename(day(folder).join(name), folder.join(name)).unwrap();
        fs::create_dir(day(folder).join(name)).unwrap();
    }
    let mut store = Store::open(folder).unwrap();
    assert_eq!((store.durable(STREAM), store.repairs().replayed), (Some(60), 0));
    assert!(
        store.repairs().notes.iter().any(|note| note.contains("Data.lsf.zst")),
        "{:?}",
        store.repairs().notes
    );
    give(&mut store, 0, 61, 30);
    assert_eq!(store.commit().unwrap().history_behind, None);
    store.close().unwrap();
    assert!(!folder.join("archive/shortened.jsonl").exists());
    let checks = doctor(folder, NOW, true, &mut |_| true).unwrap();
    assert!(
        checks.iter().any(|check| check.health == Health::Problem && check.found.contains("Data.lsf.zst"))
    );
    assert_eq!(crate::covered(folder).unwrap()[0].days, 2);
    // The time that packet 60 states lies behind those of the day.
    let range = crate::TimeRange { from_us: START_US + 59_500_000, to_us: START_US + 60_500_000 };
    let selection = crate::Selection { range, ..Default::default() };
    crate::log_version(folder, &selection).unwrap();
    let mut log = Vec::new();
    crate::export_lsf(folder, &selection, &mut log).unwrap();
    assert_eq!(log, before[60].2);
    // Made again without the day, from the archive alone; then the disk is well again.
    fs::remove_dir_all(folder.join("history")).unwrap();
    Store::open(folder).unwrap();
    for name in ["Data.lsf.zst", "Arrivals.zst"] {
        fs::remove_dir(day(folder).join(name)).unwrap();
        fs::rename(folder.join(name), day(folder).join(name)).unwrap();
    }
    let store = Store::open(folder).unwrap();
    assert_eq!(
        (store.durable(STREAM), store.repairs().replayed, everything(folder).len()),
        (Some(59), 60, 62)
    );
}

#[test]
fn a_name_that_cannot_be_given_leaves_the_plain_day_in_use() {
    let scratch = scratch();
    let folder = scratch.path();
    fill(folder, 60, 30);
    let before = everything(folder);
    let mut store = Store::open(folder).unwrap();
    let plan = plan_packing(folder, 3, NOW).unwrap();
    let mut packing = Packing::begin(folder, &plan[0]).unwrap();
    while packing.work(1 << 20).unwrap() {}
    let in_the_way = day(folder).join("Data.lsf.zst");
    fs::create_dir(&in_the_way).unwrap();
    store.adopt(&mut packing).unwrap_err();
    drop(packing);
    assert!(!folder.join("archive/packing").exists());
    assert_eq!(everything(folder), before);
    give(&mut store, 0, 61, 30);
    store.commit().unwrap();
    assert!(folder.join("archive/0x2810/20261121-2/Data.lsf").exists());
    fs::remove_dir(in_the_way).unwrap();
    pack(&mut store, folder);
    assert_eq!(everything(folder).len(), before.len() + 1);
}

#[test]
fn half_made_files_go_with_the_work_and_those_of_other_work_stay() {
    let scratch = scratch();
    let folder = scratch.path();
    fill(folder, 60, 30);
    let mut store = Store::open(folder).unwrap();
    let plan = plan_packing(folder, 3, NOW).unwrap();
    let mut packing = Packing::begin(folder, &plan[0]).unwrap();
    packing.work(1).unwrap();
    let other = folder.join("archive/packing/other");
    fs::write(&other, "x").unwrap();
    drop(packing);
    let left: Vec<_> =
        fs::read_dir(folder.join("archive/packing")).unwrap().map(|one| one.unwrap().path()).collect();
    assert_eq!(left, [other]);
    pack(&mut store, folder);
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
    // One that was lost, or is older than the days, is written anew.
    fs::remove_file(folder.join("archive/format.json")).unwrap();
    Store::open(folder).unwrap();
    assert!(format().contains("\"format\":2"), "{}", format());
    fs::write(folder.join("archive/format.json"), r#"{"format":1,"program":"0.1.0"}"#).unwrap();
    Store::open(folder).unwrap();
    assert!(format().contains("\"format\":2"), "{}", format());
}
