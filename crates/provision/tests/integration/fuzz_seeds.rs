//! The fuzz targets' bodies over their committed seeds and over everything that they ever found.

use proptest::prelude::*;

#[path = "../../../../fuzz/bodies/provision.rs"]
mod bodies;

fn seeds(target: &str) -> Vec<Vec<u8>> {
    let folder = testkit::repository().join("fuzz/seeds").join(target);
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{} has no seeds", folder.display());
    files.into_iter().map(|file| std::fs::read(file).unwrap()).collect()
}

#[test]
fn seeds_hold_whole_and_cut() {
    for seed in seeds("provision_bundle") {
        for cut in 0..=seed.len() {
            bodies::bundle(&seed[..cut]);
        }
    }
    for seed in seeds("provision_fleet") {
        for cut in (0..=seed.len()).step_by(7) {
            bodies::fleet(&seed[..cut]);
        }
        bodies::fleet(&seed);
    }
}

/// Damages the seeds, for those who do not run the fuzzer.
#[test]
fn damaged_seeds_hold() {
    let (bundle, fleet) = (seeds("provision_bundle").pop().unwrap(), seeds("provision_fleet").pop().unwrap());
    proptest!(|(at: usize, value: u8)| {
        for (seed, body) in [(&bundle, bodies::bundle as fn(&[u8])), (&fleet, bodies::fleet)] {
            let mut bytes = seed.clone();
            let at = at % bytes.len();
            bytes[at] = value;
            body(&bytes);
        }
    });
}
