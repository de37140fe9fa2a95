//! How many packets of other systems go to the log.
//!
//! Any system that can send packets could fill the disk, and a full disk ends the log. So each system has a
//! budget, and all together another; packets beyond it are acted upon as usual but neither logged nor passed on,
//! and the log states how many they were.

use imc::Address;
use std::collections::BTreeMap;
use std::time::Duration;
use units::MonoTime;

/// Packets and bytes a second that one system and all together may have logged, and the seconds' worth that
/// may come at once.
const OF_ONE: (f64, f64) = (200.0, 64_000.0);
const OF_ALL: (f64, f64) = (1000.0, 256_000.0);
const BURST_S: f64 = 2.0;
/// Systems with a budget of their own; the others share one.
const SYSTEMS: usize = 64;
/// Time between two declarations of what was left out.
const DECLARE: Duration = Duration::from_secs(10);

/// A budget that fills with time.
#[derive(Debug, Clone, Copy)]
struct Budget {
    packets: f64,
    bytes: f64,
    at: MonoTime,
}

impl Budget {
    fn full(now: MonoTime, rate: (f64, f64)) -> Self {
        Self { packets: BURST_S * rate.0, bytes: BURST_S * rate.1, at: now }
    }

    fn fill(&mut self, now: MonoTime, rate: (f64, f64)) {
        let span_s = now.since(self.at).as_secs_f64();
        self.packets = (self.packets + span_s * rate.0).min(BURST_S * rate.0);
        self.bytes = (self.bytes + span_s * rate.1).min(BURST_S * rate.1);
        self.at = now;
    }

    fn has(&self, bytes: f64) -> bool {
        self.packets >= 1.0 && self.bytes >= bytes
    }

    fn take(&mut self, bytes: f64) {
        self.packets -= 1.0;
        self.bytes -= bytes;
    }
}

/// The budgets.
#[derive(Debug, Clone)]
pub(crate) struct Intake {
    all: Budget,
    others: Budget,
    systems: BTreeMap<Address, Budget>,
    left_out: u64,
    next: MonoTime,
}

impl Intake {
    pub(crate) fn new(now: MonoTime) -> Self {
        let others = Budget::full(now, OF_ONE);
        Self { all: Budget::full(now, OF_ALL), others, systems: BTreeMap::new(), left_out: 0, next: now }
    }

    /// Whether a packet of a system is logged.
    pub(crate) fn admits(&mut self, now: MonoTime, system: Address, bytes: usize) -> bool {
        if !self.systems.contains_key(&system) && self.systems.len() >= SYSTEMS {
            // A system that was quiet long enough to have its full budget back needs no entry.
            let quiet = Duration::from_secs_f64(BURST_S);
            self.systems.retain(|_, budget| now.since(budget.at) < quiet);
        }
        let own = if self.systems.contains_key(&system) || self.systems.len() < SYSTEMS {
            self.systems.entry(system).or_insert_with(|| Budget::full(now, OF_ONE))
        } else {
            &mut self.others
        };
        // A packet has at most 64 KiB.
        let bytes = bytes as f64;
        own.fill(now, OF_ONE);
        self.all.fill(now, OF_ALL);
        let admitted = own.has(bytes) && self.all.has(bytes);
        if admitted {
            own.take(bytes);
            self.all.take(bytes);
        } else {
            self.left_out += 1;
        }
        admitted
    }

    /// How many packets were left out, when it is time to say so.
    pub(crate) fn declare(&mut self, now: MonoTime) -> Option<u64> {
        if self.left_out == 0 || now < self.next {
            return None;
        }
        self.next = now + DECLARE;
        Some(std::mem::take(&mut self.left_out))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_micros(ms * 1000)
    }

    #[test]
    fn a_flood_of_one_system_leaves_room_for_the_others_and_is_declared() {
        let mut intake = Intake::new(at(0));
        let (mut flood, mut console) = (0, 0);
        for ms in 0..10_000 {
            flood += usize::from(intake.admits(at(ms), Address(0x4002), 100));
            if ms % 20 == 0 {
                console += usize::from(intake.admits(at(ms), Address(0x4001), 100));
            }
        }
        assert_eq!(console, 500);
        assert!((2300..=2500).contains(&flood), "{flood}");
        let declared = intake.declare(at(10_000)).unwrap();
        assert_eq!(declared as usize, 10_000 - flood);
        assert_eq!(intake.declare(at(30_000)), None);
    }

    #[test]
    fn many_systems_and_large_packets_are_bounded_as_well() {
        let mut intake = Intake::new(at(0));
        let bytes: usize = (0..10_000_u64)
            .filter(|ms| intake.admits(at(*ms), Address((*ms % 5000) as u16), 10_000))
            .map(|_| 10_000)
            .sum();
        assert!(bytes <= 12 * 256_000, "{bytes}");
        assert!(intake.systems.len() <= SYSTEMS);
    }
}
