//! Properties that hold for any packets in any order.

use crate::support::{OTTER, START_US, accept, dump, packet, utc};
use imc::messages::{EulerAngles, Temperature};
use proptest::prelude::*;
use std::path::Path;
use store::{Bucket, Reader, Source, Store, TimeRange, Transport};

fn scratch() -> tempfile::TempDir {
    let memory = Path::new("/dev/shm");
    if memory.is_dir() { tempfile::tempdir_in(memory).unwrap() } else { tempfile::tempdir().unwrap() }
}

/// One message: of which entity, when, and what.
#[derive(Debug, Clone, Copy)]
struct Said {
    entity: u8,
    time_us: i64,
    value: i8,
    angles: bool,
}

impl Said {
    fn packet(self) -> Vec<u8> {
        if self.angles {
            let psi = f64::from(self.value) / 7.0;
            packet(self.time_us, self.entity, &EulerAngles { psi, ..EulerAngles::default() })
        } else {
            let value = if self.value == 0 { f32::NAN } else { f32::from(self.value) };
            packet(self.time_us, self.entity, &Temperature { value })
        }
    }

    /// When it came: the same each time it is sent, so that two stores can be compared.
    fn received_us(self) -> i64 {
        START_US + self.time_us.rem_euclid(1_000)
    }
}

/// Times within some windows, over the end of a month, and a few unbelievable ones.
fn said() -> impl Strategy<Value = Said> {
    const DECEMBER_US: i64 = 1_796_083_200_000_000;
    let near = (-2_000_i64..2_000).prop_map(|second| DECEMBER_US + second * 1_000_000);
    let fine = (0_i64..50_000_000).prop_map(|us| DECEMBER_US + us);
    let time = prop_oneof![5 => near, 4 => fine, 1 => 0_i64..1_000];
    (1_u8..3, time, any::<i8>(), any::<bool>()).prop_map(|(entity, time_us, value, angles)| Said {
        entity,
        time_us,
        value,
        angles,
    })
}

#[derive(Debug, Clone, Copy)]
enum Event {
    Say(usize),
    Commit,
    /// The program is gone before it closes, or after.
    Restart,
    Settle,
}

fn events(count: usize) -> impl Strategy<Value = Vec<Event>> {
    let event = prop_oneof![
        20 => (0..count).prop_map(Event::Say),
        3 => Just(Event::Commit),
        1 => Just(Event::Restart),
        1 => Just(Event::Settle),
    ];
    proptest::collection::vec(event, 0..120)
}

fn say(store: &mut Store, said: Said) {
    accept(store, &said.packet(), said.received_us(), Transport::Tcp);
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 24, ..ProptestConfig::default() })]

    #[test]
    fn late_data_resends_and_restarts_give_the_same_store(
        all in proptest::collection::vec(said(), 1..60),
        events in events(60),
    ) {
        let (one, other) = (scratch(), scratch());
        let mut store = Store::open(one.path()).unwrap();
        let mut ordered = all.clone();
        ordered.sort_by_key(|said| said.time_us);
        for said in ordered {
            say(&mut store, said);
        }
        store.commit().unwrap();
        store.settle().unwrap();
        store.close().unwrap();

        let mut store = Store::open(other.path()).unwrap();
        for event in events {
            match event {
                Event::Say(at) => say(&mut store, all[at % all.len()]),
                Event::Commit => {
                    store.commit().unwrap();
                }
                Event::Restart => {
                    drop(store);
                    store = Store::open(other.path()).unwrap();
                }
                Event::Settle => store.settle().unwrap(),
            }
        }
        // Packets lost with a restart are sent again, with all others.
        all.iter().rev().for_each(|said| say(&mut store, *said));
        store.commit().unwrap();
        store.settle().unwrap();
        store.close().unwrap();
        prop_assert_eq!(dump(one.path()), dump(other.path()));
    }

    #[test]
    fn buckets_are_what_the_samples_give(
        all in proptest::collection::vec(said(), 1..300),
        settle_after in 0_usize..300,
        from_s in -2_100_i64..2_000,
        length_s in 1_i64..6_000,
        offset_us in 0_i64..1_000_000,
        count in 1_usize..400,
    ) {
        let folder = scratch();
        let mut store = Store::open(folder.path()).unwrap();
        for (at, said) in all.iter().enumerate() {
            say(&mut store, *said);
            if at == settle_after {
                store.commit().unwrap();
                store.settle().unwrap();
            }
        }
        store.commit().unwrap();
        let mut reader = Reader::open(folder.path()).unwrap();
        let from_us = 1_796_083_200_000_000 + from_s * 1_000_000 + offset_us;
        let range = TimeRange::new(Some(utc(from_us)), Some(utc(from_us + length_s * 1_000_000)));
        for (message, field) in [("Temperature", "value"), ("EulerAngles", "psi")] {
            let source = Source { system: OTTER, entity: 1, message: message.to_owned() };
            let found = reader.buckets(&source, field, range, count).unwrap();
            let samples = reader.samples(&source, &[field], range, usize::MAX).unwrap();
            prop_assert_eq!(samples.time_us.iter().filter(|time_us| !range.contains(**time_us)).count(), 0);
            let finite: Vec<(i64, f64)> = samples
                .time_us
                .iter()
                .copied()
                .zip(samples.values[0].iter().copied())
                .filter(|(_, value)| value.is_finite())
                .collect();
            prop_assert!(found.buckets.len() <= count + 1);
            prop_assert_eq!(found.buckets.iter().map(|bucket| bucket.count).sum::<u64>(), finite.len() as u64);
            for bucket in &found.buckets {
                check(bucket, found.width_us, &finite, field == "psi")?;
            }
        }
    }
}

fn check(
    bucket: &Bucket,
    width_us: i64,
    finite: &[(i64, f64)],
    are_angles: bool,
) -> Result<(), TestCaseError> {
    let inside: Vec<(i64, f64)> = finite
        .iter()
        .copied()
        .filter(|(time_us, _)| (bucket.start_us..bucket.start_us + width_us).contains(time_us))
        .collect();
    let values = || inside.iter().map(|(_, value)| *value);
    prop_assert_eq!(bucket.count, inside.len() as u64);
    prop_assert_eq!(bucket.first_us, inside[0].0);
    prop_assert_eq!(bucket.first.to_bits(), inside[0].1.to_bits());
    prop_assert_eq!(bucket.last.to_bits(), inside[inside.len() - 1].1.to_bits());
    prop_assert_eq!(bucket.min.to_bits(), values().fold(f64::INFINITY, f64::min).to_bits());
    prop_assert_eq!(bucket.max.to_bits(), values().fold(f64::NEG_INFINITY, f64::max).to_bits());
    if are_angles {
        // Turned by the mean, all point ahead on average.
        let sin: f64 = values().map(|value| (value - bucket.mean).sin()).sum();
        let cos: f64 = values().map(|value| (value - bucket.mean).cos()).sum();
        prop_assert!(
            sin.abs() < 1e-10 && cos > -1e-10,
            "{} is not the mean direction: {sin}, {cos}",
            bucket.mean
        );
        return Ok(());
    }
    // Sums of at most 300 values below 128 in another order: rounding stays far below this.
    let mean = values().sum::<f64>() / inside.len() as f64;
    prop_assert!((bucket.mean - mean).abs() < 1e-10, "{} is not {mean}", bucket.mean);
    Ok(())
}
