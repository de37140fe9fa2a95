//! The fuzz target's body over its committed seeds and over everything it ever found.

use proptest::prelude::*;

#[path = "../../../../fuzz/bodies/detections.rs"]
mod bodies;

#[test]
fn report_seeds_hold() {
    let folder = testkit::repository().join("fuzz/seeds/detection_report");
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{} has no seeds", folder.display());
    for file in files {
        println!("{}", file.display());
        bodies::report(&std::fs::read(file).unwrap());
    }
}

/// Damages the seeds, for those who do not run the fuzzer.
#[test]
fn damaged_seeds_hold() {
    let seed = std::fs::read(testkit::repository().join("fuzz/seeds/detection_report/whole")).unwrap();
    proptest!(|(at in 0..seed.len(), value: u8, cut in 0..seed.len())| {
        let mut bytes = seed.clone();
        bytes[at] = value;
        bodies::report(&bytes);
        bodies::report(&bytes[cut..]);
        bodies::report(&bytes[..cut]);
    });
}
