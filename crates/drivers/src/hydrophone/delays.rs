//! How long after its stamp a line comes, kept for each kind of line separately.
//!
//! The same tag sends the same train of pulses each time, and a command is acknowledged after the same wait: where such a
//! delay jumps and stays, a clock jumped. Its normal scatter is learned, so that a slow receiver raises no alarm.

use std::collections::{BTreeMap, VecDeque};
use units::MonoTime;

/// Delays before one is judged.
const LEARNED: usize = 4;
/// Delays that the usual ones are taken from.
const KEPT: usize = 8;
/// Odd ones in a row that are a jump.
const AGREE: usize = 3;
/// Less than this is no jump (s): a command with the full time is ten characters longer than one without, a millisecond each,
/// and a loaded computer adds to the arrival of a line.
const LEAST_S: f64 = 0.012;
/// Sorts of lines that are kept; the one that came least lately makes room.
const SORTS: usize = 64;

/// The delays of lines by their sort.
#[derive(Debug, Clone, Default)]
pub(super) struct Delays {
    sorts: BTreeMap<String, (MonoTime, Delay)>,
}

/// The delays of one sort.
#[derive(Debug, Clone, Default)]
struct Delay {
    usual: VecDeque<f64>,
    /// Those in a row that were not.
    odd: Vec<f64>,
}

impl Delays {
    /// Takes a delay; answers by how much it has jumped, if it has (s, positive is later).
    pub(super) fn take(&mut self, now: MonoTime, sort: &str, delay_s: f64) -> Option<f64> {
        if !self.sorts.contains_key(sort) && self.sorts.len() >= SORTS {
            let oldest = self.sorts.iter().min_by_key(|(_, (at, _))| *at).map(|(sort, _)| sort.clone());
            self.sorts.remove(&oldest?);
        }
        let (at, delay) = self.sorts.entry(sort.to_owned()).or_default();
        *at = now;
        delay.take(delay_s)
    }

    pub(super) fn clear(&mut self) {
        self.sorts.clear();
    }
}

impl Delay {
    fn take(&mut self, delay_s: f64) -> Option<f64> {
        let (least, most) = span(&self.usual);
        let slack = LEAST_S.max(2.0 * (most - least));
        if self.usual.len() < LEARNED || (least - slack..=most + slack).contains(&delay_s) {
            self.odd.clear();
            if self.usual.len() >= KEPT {
                self.usual.pop_front();
            }
            self.usual.push_back(delay_s);
            return None;
        }
        self.odd.push(delay_s);
        if self.odd.len() < AGREE {
            return None;
        }
        self.usual = std::mem::take(&mut self.odd).into();
        let jump_s = span(&self.usual).0 - least;
        (jump_s.abs() >= LEAST_S).then_some(jump_s)
    }
}

/// The least and the greatest.
fn span(delays: &VecDeque<f64>) -> (f64, f64) {
    delays
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(least, most), &one| (least.min(one), most.max(one)))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn jumps(delays: &mut Delays, sort: &str, all: &[f64]) -> Vec<f64> {
        all.iter().filter_map(|one| delays.take(MonoTime::default(), sort, *one)).collect()
    }

    #[test]
    fn a_jump_that_stays_is_told_once_and_one_late_line_is_not() {
        let mut delays = Delays::default();
        let steady = [3.600, 3.601, 3.600, 3.602, 3.600];
        assert!(jumps(&mut delays, "a", &steady).is_empty());
        assert!(jumps(&mut delays, "a", &[3.640, 3.601, 3.700, 3.600]).is_empty());
        let jumped = jumps(&mut delays, "a", &[3.616, 3.615, 3.615, 3.616, 3.615]);
        assert!(matches!(jumped[..], [one] if (one - 0.015).abs() < 1e-9), "{jumped:?}");
        let back = jumps(&mut delays, "a", &[3.616, 3.600, 3.600, 3.600]);
        assert!(matches!(back[..], [one] if (one + 0.015).abs() < 1e-9), "{back:?}");
    }

    #[test]
    fn a_delay_that_scatters_by_itself_raises_no_alarm_and_each_sort_has_its_own() {
        let mut delays = Delays::default();
        let scattered: Vec<f64> = (0..200).map(|n| 3.6 + 0.05 * f64::from(n * 7 % 11) / 11.0).collect();
        assert!(jumps(&mut delays, "a", &scattered).is_empty());
        for n in 0..1000_u32 {
            assert!(jumps(&mut delays, &n.to_string(), &[f64::from(n)]).is_empty());
        }
        assert!(delays.sorts.len() <= SORTS);
    }
}
