//! The fuzz target's body over its committed seeds and over everything it ever found, whole, damaged, and over noise.

use proptest::prelude::*;

#[path = "../../../fuzz/bodies/motors.rs"]
mod bodies;

#[test]
fn motor_card_seeds_hold() {
    let folder = testkit::repository().join("fuzz/seeds/can_motor_card");
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{} has no seeds", folder.display());
    for file in files {
        let seed = std::fs::read(file).unwrap();
        bodies::motor_card(&seed);
        proptest!(ProptestConfig::with_cases(64), |(at in 0..seed.len(), value: u8, cut in 0..seed.len())| {
            let mut bytes = seed.clone();
            bytes[at] = value;
            bodies::motor_card(&bytes);
            bodies::motor_card(&bytes[cut..]);
        });
    }
}

proptest! {
    #[test]
    fn any_events_keep_the_motors_in_hand(bytes in proptest::collection::vec(any::<u8>(), 0..600)) {
        bodies::motor_card(&bytes);
    }
}
