//! The fuzz target's body over its committed seeds and over everything it ever found.
//!
//! The seeds are this file's own: with LUTRA_WRITE_SEEDS set they are written again.

#[path = "../../../../fuzz/bodies/store.rs"]
mod bodies;

use bodies::{PACKETS, START_S, packet};
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

#[test]
fn arrivals_seeds_hold() {
    let folder = testkit::repository().join("fuzz/seeds/store_arrivals");
    if std::env::var_os("LUTRA_WRITE_SEEDS").is_some() {
        fs::create_dir_all(&folder).unwrap();
        for (name, bytes) in SEEDS.iter() {
            fs::write(folder.join(name), bytes).unwrap();
        }
    }
    let mut files: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() >= SEEDS.len(), "{} lacks seeds", folder.display());
    for file in files {
        println!("{}", file.display());
        bodies::arrivals(&fs::read(file).unwrap());
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
}
