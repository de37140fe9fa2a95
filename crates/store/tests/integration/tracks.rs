//! Where a system went, thinned to so many positions.

use crate::support::{OTTER, START_US, accept, packet, state};
use store::{Reader, Store, TimeRange, Transport};

#[test]
fn time_without_a_recording_thins_no_track() {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for second in 0..1_000 {
        let time_us = START_US + second * 1_000_000;
        accept(&mut store, &packet(time_us, 9, &state(second as f32)), time_us, Transport::Tcp);
    }
    store.commit().unwrap();
    let mut reader = Reader::open(folder.path()).unwrap();
    let mut points = |range| reader.track(OTTER, range, 1_000, 0.0).unwrap().points.len();
    let of_recording = points(TimeRange { from_us: START_US, to_us: START_US + 1_000_000_000 });
    assert!(of_recording > 900, "{of_recording} positions of 1000");
    // From 1970 to a hundred years later.
    let wide = TimeRange { from_us: 0, to_us: START_US + 3_155_760_000_000_000 };
    assert_eq!(points(wide), of_recording);
    assert_eq!(points(TimeRange::ALL), of_recording);
    let before = TimeRange { from_us: 0, to_us: START_US };
    assert_eq!(points(before), 0, "nothing is recorded then");
    let half = TimeRange { from_us: 0, to_us: START_US + 500_000_000 };
    assert!((450..=500).contains(&points(half)), "the end still counts");
}
