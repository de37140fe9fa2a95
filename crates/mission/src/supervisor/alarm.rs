//! A condition that counts once it has lasted.

use std::time::Duration;
use units::MonoTime;

/// On after the condition has been bad for a while, off after it has been good for as long.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Alarm {
    on: bool,
    /// Since when the condition has been contrary to `on`.
    contrary_since: Option<MonoTime>,
}

/// The state of a condition.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Condition {
    Bad,
    /// Neither; the alarm stays unchanged.
    Between,
    Good,
}

impl Alarm {
    pub(super) fn is_on(self) -> bool {
        self.on
    }

    /// When the alarm comes on if the condition stays bad.
    pub(super) fn due(self, lasting: Duration) -> Option<MonoTime> {
        self.contrary_since.filter(|_| !self.on).map(|since| since + lasting)
    }

    /// Takes the condition; answers whether the alarm went on or off.
    pub(super) fn update(&mut self, now: MonoTime, condition: Condition, lasting: Duration) -> bool {
        let contrary = condition == if self.on { Condition::Good } else { Condition::Bad };
        if !contrary {
            self.contrary_since = None;
            return false;
        }
        let since = *self.contrary_since.get_or_insert(now);
        if now.since(since) < lasting {
            return false;
        }
        self.on = !self.on;
        self.contrary_since = None;
        true
    }
}
