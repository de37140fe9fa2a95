//! The running number of the receiver's lines: gaps reveal lost lines, a number out of turn a restart.

use units::MonoTime;

/// Lines that a receiver can write in a second at most: the shortest train of pulses lasts about half of one.
const LINES_PER_S: u64 = 4;
/// Lines beyond that which are accepted, as clocks and buffers wait.
const SLACK_LINES: u64 = 10;

/// The verdict on a running number.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Step {
    /// The first.
    First,
    /// The one after the last.
    Next,
    /// The last one again.
    Again,
    /// So many lines were lost before it.
    Lost(u16),
    /// The receiver began to count again.
    Restarted,
}

/// The running number that came last.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) struct Continuity {
    last: Option<(u16, MonoTime)>,
}

impl Continuity {
    /// Takes the running number of a line that came at `now`. A gap that the receiver had no time to fill is a restart.
    pub(super) fn take(&mut self, now: MonoTime, counter: u16) -> Step {
        let Some((last, then)) = self.last.replace((counter, now)) else { return Step::First };
        let ahead = counter.wrapping_sub(last);
        let possible = now.since(then).as_secs().saturating_mul(LINES_PER_S).saturating_add(SLACK_LINES);
        match ahead {
            0 => Step::Again,
            1 => Step::Next,
            ahead if u64::from(ahead) <= possible => Step::Lost(ahead - 1),
            _ => Step::Restarted,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_wraps_and_restarts_are_told_apart() {
        let mut continuity = Continuity::default();
        for (second, counter, expected) in [
            (0, 65_530, Step::First),
            (1, 65_531, Step::Next),
            (2, 65_531, Step::Again),
            (10, 65_535, Step::Lost(3)),
            (11, 0, Step::Next),
            (12, 2, Step::Lost(1)),
            (3612, 9_000, Step::Lost(8_997)),
            (3613, 9_300, Step::Restarted),
            (3614, 5, Step::Restarted),
            (3615, 6, Step::Next),
        ] {
            let now = MonoTime::from_micros(second * 1_000_000);
            assert_eq!(continuity.take(now, counter), expected, "{counter} at {second} s");
        }
    }
}
