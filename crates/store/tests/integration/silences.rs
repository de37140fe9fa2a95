//! Silences that the shore finds on its own, at every scale, and what closes them.

use crate::support::*;
use imc::messages::{Heartbeat, Temperature};
use proptest::prelude::*;
use store::{Reader, Store, TimeRange, Transport};
use tempfile::TempDir;

const S: i64 = 1_000_000;

/// A store that heard temperatures at these times (µs after the start).
fn heard(times_us: impl IntoIterator<Item = i64>) -> (TempDir, Store) {
    let folder = tempfile::tempdir().unwrap();
    let mut store = Store::open(folder.path()).unwrap();
    for time_us in times_us {
        accept(&mut store, &temperature(START_US + time_us, 8.5), START_US + time_us, Transport::Tcp);
    }
    store.commit().unwrap();
    (folder, store)
}

/// The silences in a range, in µs after the start.
fn silences_in(folder: &TempDir, range: TimeRange) -> Vec<(i64, i64)> {
    let found = Reader::open(folder.path()).unwrap().silences(OTTER, range).unwrap();
    found.iter().map(|one| (one.from_us - START_US, one.to_us - START_US)).collect()
}

fn silences(folder: &TempDir) -> Vec<(i64, i64)> {
    silences_in(folder, TimeRange::ALL)
}

#[test]
fn a_silence_lies_between_two_packets_whatever_they_say() {
    let (folder, mut store) = heard((0..100).chain(130..160).chain(171..200).map(|at| at * S));
    // Exactly ten seconds are none, eleven are.
    assert_eq!(silences(&folder), [(99 * S, 130 * S), (159 * S, 171 * S)]);
    // The part of it that was asked for; nothing before the first packet, nor after the last.
    let part = |from: i64, to: i64| TimeRange { from_us: START_US + from * S, to_us: START_US + to * S };
    assert_eq!(silences_in(&folder, part(-500, 115)), [(99 * S, 115 * S)]);
    assert_eq!(silences_in(&folder, part(195, 900)), []);
    let other = Reader::open(folder.path()).unwrap().silences(imc::Address(0x2811), TimeRange::ALL).unwrap();
    assert_eq!(other, []);

    // Heartbeats have no fields and no roll-ups, unknown messages no table, and a NaN is not a number: all were heard.
    let mut late = vec![packet(START_US + 105 * S, 9, &Heartbeat)];
    late.push(packet(START_US + 112 * S, 6, &Temperature { value: f32::NAN }));
    let mut unknown = packet(START_US + 121 * S, 9, &Heartbeat);
    let id = unknown.len() - 2 - 18;
    unknown[id..id + 2].copy_from_slice(&60_001_u16.to_le_bytes());
    let end = unknown.len() - 2;
    let crc = imc::crc16(&unknown[..end]);
    unknown[end..].copy_from_slice(&crc.to_le_bytes());
    late.push(unknown);
    for packet in late {
        accept(&mut store, &packet, START_US + 1_000 * S, Transport::Import);
    }
    store.commit().unwrap();
    assert_eq!(silences(&folder), [(159 * S, 171 * S)], "what came late closes a silence");
}

#[test]
fn over_days_and_months_the_roll_ups_find_the_longer_ones() {
    // Three days, a sample every four seconds but for these stretches.
    let quiet = [(1_000, 1_019), (50_000, 50_030), (90_000, 94_000), (200_000, 200_600)];
    let inside = |at: i64| quiet.iter().any(|(from, to)| (from + 1..*to).contains(&at));
    let samples = (0..3 * 86_400).step_by(4).filter(|at| !inside(*at)).map(|at| at * S);
    let (folder, store) = heard(samples);
    store.close().unwrap();
    // Twenty seconds and more; the ends are samples.
    assert_eq!(
        silences(&folder),
        [(50_000 * S, 50_032 * S), (90_000 * S, 94_000 * S), (200_000 * S, 200_600 * S)]
    );
    // A closer look shows the shorter one too.
    let range = TimeRange { from_us: START_US + 900 * S, to_us: START_US + 2_000 * S };
    assert_eq!(silences_in(&folder, range), [(1_000 * S, 1_020 * S)]);

    // Over months only silences longer than twenty minutes are reported.
    let times = (0..40 * 86_400).step_by(60).filter(|at| !(100_000..110_000).contains(at)).map(|at| at * S);
    let (folder, _store) = heard(times.chain([200_001 * S]));
    assert_eq!(silences(&folder), [(99_960 * S, 110_040 * S)]);
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(12))]
    /// As the times of the packets say, in whatever series they came.
    #[test]
    fn silences_are_what_the_times_say(
        steps in proptest::collection::vec((prop_oneof![6 => 1..9_i64, 1 => 9..4_000_i64], 0..3_u8), 2..400),
    ) {
        let folder = tempfile::tempdir().unwrap();
        let mut store = Store::open(folder.path()).unwrap();
        let (mut at, mut times) = (0, Vec::new());
        for (step_s, entity) in steps {
            at += step_s * S;
            times.push(at);
            accept(&mut store, &packet(START_US + at, entity, &Temperature { value: 1.0 }), START_US, Transport::Tcp);
        }
        store.commit().unwrap();
        let span_s = (at - times[0]) / S;
        let least_s = if span_s <= 6 * 3_600 { 10 } else { 20 };
        let expected: Vec<(i64, i64)> = times
            .windows(2)
            .map(|two| (two[0], two[1]))
            .filter(|(from, to)| to - from > least_s * S)
            .collect();
        prop_assert_eq!(silences(&folder), expected);
    }
}
