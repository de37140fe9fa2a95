//! The fuzz targets' bodies over their committed seeds and over everything they ever found, whole and damaged.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

use proptest::prelude::*;

#[path = "../../../fuzz/bodies/can.rs"]
mod bodies;

/// The seeds of a target.
fn seeds(target: &str) -> Vec<Vec<u8>> {
    let folder = testkit::repository().join("fuzz/seeds").join(target);
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{} has no seeds", folder.display());
    files.into_iter().map(|file| std::fs::read(file).unwrap()).collect()
}

fn hold(target: &str, body: fn(&[u8])) {
    for seed in seeds(target) {
        body(&seed);
        proptest!(ProptestConfig::with_cases(64), |(at in 0..seed.len(), value: u8, cut in 0..seed.len())| {
            let mut bytes = seed.clone();
            bytes[at] = value;
            body(&bytes);
            body(&bytes[cut..]);
            body(&bytes[..cut]);
        });
    }
}

#[test]
fn candump_seeds_hold() {
    hold("can_candump", bodies::candump);
}

#[test]
fn slcan_seeds_hold() {
    hold("can_slcan", bodies::slcan);
}

#[test]
fn tq_bus_seeds_hold() {
    hold("can_tq_bus", bodies::tq_bus);
}
