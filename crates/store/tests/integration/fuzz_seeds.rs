//! The fuzz targets' bodies over their committed seeds and over everything it ever found.
//!
//! The seeds are this file's own: with LUTRA_WRITE_SEEDS set they are written again.

#[path = "../../../../fuzz/bodies/store.rs"]
mod bodies;

use bodies::{CHUNK, PACKED, PACKETS, START_S, packet};
use proptest::prelude::*;
use std::fs;
use std::sync::LazyLock;
use store::{Accepted, LinkSeq, Store, Transport};
use units::UtcTime;

/// The sidecar that a store writes beside the packets, which have these numbers.
fn sidecar(numbers: [Option<u64>; PACKETS as usize]) -> Vec<u8> {
    let folder = tempfile::tempdir_in("/dev/shm").or_else(|_| tempfile::tempdir()).unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for (at, seq) in (0..).zip(numbers) {
        let received = UtcTime::from_seconds(START_S + at as f64 * 0.7).unwrap();
        let link = seq.map(|seq| LinkSeq { stream: 7, seq });
        store.accept(&Accepted { packet: &packet(at), received, transport: Transport::Link, link }).unwrap();
        store.commit().unwrap();
    }
    store.close().unwrap();
    fs::read(folder.path().join("archive/0x2810/20261121/Arrivals.idx")).unwrap()
}

/// Made once: each takes a store.
static SEEDS: LazyLock<Vec<(&str, Vec<u8>)>> = LazyLock::new(seeds);

fn seeds() -> Vec<(&'static str, Vec<u8>)> {
    let whole = sidecar([0, 1, 2, 3, 4, 5].map(Some));
    let jumps = sidecar([Some(3), Some(4), Some(9), None, Some(10), Some(u64::MAX - 1)]);
    let with = |mend: u8, parts: &[&[u8]]| [&[mend][..], &parts.concat()].concat();
    let mut far = whole.clone();
    // The last arrived before there were clocks, the previous one at no place at all.
    far[5 * 32 + 7..5 * 32 + 14].fill(0x80);
    far[4 * 32..4 * 32 + 6].fill(0xFF);
    vec![
        ("whole", with(0, &[&whole])),
        ("jumps", with(0, &[&jumps])),
        ("cut", with(0, &[&whole[..100]])),
        ("zeros", with(0, &[&whole[..64], &[0; 256]])),
        ("twice", with(0, &[&whole, &whole])),
        ("backwards", with(0, &[&whole[96..], &whole[..96]])),
        ("far", with(1, &[&far])),
        ("nothing", vec![0]),
    ]
}

/// Files of a compressed day, whole and damaged.
fn packed_seeds() -> Vec<(&'static str, Vec<u8>)> {
    let [data, arrivals] = &*PACKED;
    let with = |how: u8, bytes: &[u8]| [&[how][..], bytes].concat();
    let part = |how: u8, at: u16, bytes: &[u8]| [&[how][..], &at.to_le_bytes(), bytes].concat();
    vec![
        ("data", with(0, data)),
        ("records", with(1, arrivals)),
        ("cut", with(0, &data[..data.len() - 3])),
        ("nothing", vec![0]),
        // Sizes in the head that the table does not have.
        ("long", part(6, 20, &u64::MAX.to_le_bytes())),
        ("small-frames", part(6, 16, &1_u32.to_le_bytes())),
        ("other-coding", part(6, 14, &[1])),
        // A number of frames for which there is no room.
        ("many-frames", part(2, data.len() as u16 - 9, &u32::MAX.to_le_bytes())),
        ("damaged-frame", part(2, 80, &[0xFF; 8])),
        ("damaged-records", part(3, 80, &[0xFF; 8])),
    ]
}

/// Chunks of a compressed month, whole and damaged.
fn chunk_seeds() -> Vec<(&'static str, Vec<u8>)> {
    let [_, body] = &*CHUNK;
    let with = |how: u8, bytes: &[u8]| [&[how][..], bytes].concat();
    let part = |how: u8, at: u16, bytes: &[u8]| [&[how][..], &at.to_le_bytes(), bytes].concat();
    vec![
        ("whole", with(0, body)),
        ("cut", with(0, &body[..body.len() - 3])),
        ("cut-and-mended", with(2, &body[..body.len() - 30])),
        ("nothing", vec![0]),
        // Counts of rows and columns, and a column's length, that it does not have.
        ("rows", part(3, 1, &[0xFF, 0xFF, 0xFF, 0x7F])),
        ("columns", part(3, 2, &[0xFF, 0x7F])),
        ("length", part(3, 3, &[0xFF, 0xFF, 0xFF, 0x07])),
        ("damaged", part(1, 60, &[0xFF; 8])),
        ("damaged-and-mended", part(3, 60, &[0xFF; 8])),
        // A column that says it is 16 MiB long.
        ("long", part(3, 3 + 10, &[1, 0x80, 0x80, 0x80, 0x08])),
    ]
}

#[test]
fn chunk_seeds_hold() {
    hold("store_chunk", &chunk_seeds(), bodies::chunk);
}

#[test]
fn arrivals_seeds_hold() {
    hold("store_arrivals", &SEEDS, bodies::arrivals);
}

#[test]
fn packed_seeds_hold() {
    hold("store_packed", &packed_seeds(), bodies::packed);
}

fn hold(target: &str, seeds: &[(&str, Vec<u8>)], body: fn(&[u8])) {
    let folder = testkit::repository().join("fuzz/seeds").join(target);
    if std::env::var_os("LUTRA_WRITE_SEEDS").is_some() {
        fs::create_dir_all(&folder).unwrap();
        for (name, bytes) in seeds {
            fs::write(folder.join(name), bytes).unwrap();
        }
    }
    let mut files: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= seeds.len(), "{} lacks seeds", folder.display());
    for file in files {
        println!("{}", file.display());
        body(&fs::read(file).unwrap());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(32))]
    /// Damages the seeds, for those who do not run the fuzzer.
    #[test]
    fn damaged_seeds_hold(
        seed in 0..SEEDS.len(), at in any::<prop::sample::Index>(), value: u8, mend in 0..2_u8,
    ) {
        let mut bytes = SEEDS[seed].1.clone();
        let at = at.index(bytes.len());
        bytes[at] = value;
        bytes[0] = mend;
        bodies::arrivals(&bytes);
        bodies::arrivals(&bytes[..at]);
    }

    /// The same of chunks.
    #[test]
    fn damaged_chunks_hold(at: u16, bytes in prop::collection::vec(any::<u8>(), 1..12), mend: bool) {
        let how = 1 | u8::from(mend) << 1;
        bodies::chunk(&[&[how][..], &at.to_le_bytes(), &bytes].concat());
    }

    /// The same of compressed days.
    #[test]
    fn damaged_packed_days_hold(which in 0..2_u8, at: u16, bytes in prop::collection::vec(any::<u8>(), 1..12), mend: bool) {
        let how = which | 2 | u8::from(mend) << 2;
        bodies::packed(&[&[how][..], &at.to_le_bytes(), &bytes].concat());
    }
}
