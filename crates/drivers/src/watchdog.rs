//! The watchdog of the computer's board (Sfera Labs Strato Pi CAN), by its four pins.
//!
//! While the watchdog is on, the board waits for pulses and cuts the computer's power for a moment when they stay away. A
//! pulse is given only while the brain's own count of life moves: a program that still runs but no longer steers does not
//! keep the vessel from being restarted. [`Watchdog::shut_down`] turns the watchdog off first; a program that ends without
//! it leaves it on, and is restarted by the board. Pins and times: the DUNE task `Safety.StratoPIWatchdog`.

use crate::{Note, State};
use std::collections::VecDeque;
use std::time::Duration;
use units::MonoTime;

/// A pin of the board.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Pin {
    /// Output: pulses keep the board quiet.
    Heartbeat,
    /// Output: high while the watchdog is on.
    Enable,
    /// Input: high when the board is about to cut the power.
    Expiry,
    /// Output: would have the board cut the power at once; kept low.
    Force,
}

impl Pin {
    /// Its number, as Broadcom counts the pins of the computer.
    pub const fn bcm(self) -> u8 {
        match self {
            Self::Heartbeat => 5,
            Self::Enable => 6,
            Self::Expiry => 12,
            Self::Force => 16,
        }
    }
}

/// An output of the watchdog.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum WatchdogOutput {
    /// Set an output, in this order.
    Set {
        /// The pin.
        pin: Pin,
        /// Its level.
        high: bool,
    },
    /// Its state changed.
    State(State),
    /// An entry for the log.
    Note(Note),
}

/// Times of the watchdog.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct WatchdogConfig {
    /// From one pulse to the next.
    pub period: Duration,
    /// How long a pulse is high; shorter than the period.
    pub pulse: Duration,
}

impl Default for WatchdogConfig {
    /// A pulse of a quarter second every two seconds.
    fn default() -> Self {
        Self { period: Duration::from_secs(2), pulse: Duration::from_millis(250) }
    }
}

/// The state of the watchdog.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Phase {
    /// Off, until the brain shows life.
    Waiting,
    /// On; the next pulse is due.
    Low(MonoTime),
    /// On, with a pulse that ends.
    High(MonoTime),
    /// Off for good.
    Ended,
}

/// The machine of the pins.
#[derive(Debug, Clone)]
pub struct Watchdog {
    config: WatchdogConfig,
    phase: Phase,
    /// The brain's count, at the last pulse and now.
    pulsed_at: u64,
    count: u64,
    /// When the count moved last.
    moved: MonoTime,
    expiring: bool,
    last_state: Option<State>,
    /// At most one level for each pin, one state, and two notes; see [`Self::set`] and [`Self::note`].
    out: VecDeque<WatchdogOutput>,
}

impl Watchdog {
    /// A watchdog at `now`: its pins are low, and it starts at the first sign of life. So a program that cannot start, as
    /// by an error in its configuration, is not restarted for ever and can be repaired remotely.
    pub fn new(now: MonoTime, config: WatchdogConfig) -> Self {
        let mut watchdog = Self {
            config: WatchdogConfig { pulse: config.pulse.min(config.period / 2), ..config },
            phase: Phase::Waiting,
            pulsed_at: 0,
            count: 0,
            moved: now,
            expiring: false,
            last_state: None,
            out: VecDeque::new(),
        };
        for pin in [Pin::Force, Pin::Heartbeat, Pin::Enable] {
            watchdog.set(pin, false);
        }
        watchdog.state(State::Starting);
        watchdog
    }

    /// The brain's count of life, which moves while it steers.
    pub fn alive(&mut self, now: MonoTime, count: u64) {
        if count == self.count {
            return self.tick(now);
        }
        (self.count, self.moved) = (count, now);
        if self.phase == Phase::Waiting {
            self.set(Pin::Enable, true);
            self.phase = Phase::Low(now);
        }
        self.tick(now);
    }

    /// The level of [`Pin::Expiry`], which is to be read at least once in a period.
    pub fn expiry(&mut self, now: MonoTime, high: bool) {
        if high != self.expiring && self.phase != Phase::Ended {
            self.expiring = high;
            let text = if high {
                "the board's watchdog is about to cut the power: the pulses do not reach it in time"
            } else {
                "the board's watchdog is content again"
            };
            self.note(Note { warning: high, text: text.to_owned() });
        }
        self.tick(now);
    }

    /// Does what is due at `now`.
    pub fn tick(&mut self, now: MonoTime) {
        match self.phase {
            Phase::Low(due) if now >= due => {
                if self.count == self.pulsed_at {
                    // No life, no pulse. It is checked again after a period, so that a brain that was only held up keeps
                    // the vessel.
                    self.phase = Phase::Low(now + self.config.period);
                } else {
                    self.pulsed_at = self.count;
                    self.set(Pin::Heartbeat, true);
                    self.phase = Phase::High(now + self.config.pulse);
                }
            }
            Phase::High(until) if now >= until => {
                self.set(Pin::Heartbeat, false);
                self.phase = Phase::Low(now + self.config.period.saturating_sub(self.config.pulse));
            }
            Phase::Low(_) | Phase::High(_) | Phase::Waiting | Phase::Ended => {}
        }
        self.judge(now);
    }

    /// The program ends cleanly: the watchdog goes off first, and nothing turns it on again.
    pub fn shut_down(&mut self) {
        if self.phase == Phase::Ended {
            return;
        }
        self.phase = Phase::Ended;
        self.out.clear();
        self.set(Pin::Enable, false);
        self.set(Pin::Heartbeat, false);
        self.note(Note { warning: false, text: "the board's watchdog is off".to_owned() });
    }

    /// The next output; `None` when there is no more.
    pub fn poll_output(&mut self) -> Option<WatchdogOutput> {
        self.out.pop_front()
    }

    /// When to call [`tick`](Self::tick) at the latest; `None` while nothing is due.
    pub fn poll_timeout(&self) -> Option<MonoTime> {
        match self.phase {
            Phase::Low(at) | Phase::High(at) => Some(at),
            Phase::Waiting | Phase::Ended => None,
        }
    }

    fn judge(&mut self, now: MonoTime) {
        let still = now.since(self.moved);
        let state = match self.phase {
            Phase::Waiting | Phase::Ended => return,
            _ if self.expiring => State::Failing(
                "the board is about to cut the computer's power: look at the pulse's pin and at the load".to_owned(),
            ),
            // Two periods: one pulse may have been due just before the count would have moved.
            _ if still >= 2 * self.config.period => State::Failing(
                "the brain does not move on: no pulse is given until it does, and the board will restart the computer"
                    .to_owned(),
            ),
            _ => State::Working,
        };
        self.state(state);
    }

    fn state(&mut self, state: State) {
        if self.last_state.as_ref() != Some(&state) {
            self.last_state = Some(state.clone());
            self.out.retain(|output| !matches!(output, WatchdogOutput::State(_)));
            self.out.push_back(WatchdogOutput::State(state));
        }
    }

    /// Of a pin only its last level counts: a level not yet written is replaced.
    fn set(&mut self, pin: Pin, high: bool) {
        self.out.retain(|output| !matches!(output, WatchdogOutput::Set { pin: other, .. } if *other == pin));
        self.out.push_back(WatchdogOutput::Set { pin, high });
    }

    /// The two last notes are kept.
    fn note(&mut self, note: Note) {
        let notes = self.out.iter().filter(|output| matches!(output, WatchdogOutput::Note(_))).count();
        if notes >= 2 {
            let first = self.out.iter().position(|output| matches!(output, WatchdogOutput::Note(_)));
            first.and_then(|place| self.out.remove(place));
        }
        self.out.push_back(WatchdogOutput::Note(note));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    struct Board {
        watchdog: Watchdog,
        /// Levels of the pins as they were set, with the time (ms).
        levels: Vec<(u64, Pin, bool)>,
        states: Vec<State>,
        notes: Vec<Note>,
    }

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_micros(ms * 1000)
    }

    impl Board {
        fn new() -> Self {
            let watchdog = Watchdog::new(at(0), WatchdogConfig::default());
            let mut board = Self { watchdog, levels: Vec::new(), states: Vec::new(), notes: Vec::new() };
            board.poll(0);
            board
        }

        fn poll(&mut self, ms: u64) {
            while let Some(output) = self.watchdog.poll_output() {
                match output {
                    WatchdogOutput::Set { pin, high } => self.levels.push((ms, pin, high)),
                    WatchdogOutput::State(state) => self.states.push(state),
                    WatchdogOutput::Note(note) => self.notes.push(note),
                }
            }
        }

        /// Lets the time pass by the machine's own deadlines; `lives` says whether the brain moves on, at 10 Hz.
        fn pass(&mut self, from_ms: u64, to_ms: u64, lives: bool) {
            for ms in from_ms..to_ms {
                if lives && ms % 100 == 0 {
                    self.watchdog.alive(at(ms), ms / 100 + 1);
                }
                if self.watchdog.poll_timeout().is_some_and(|due| due <= at(ms)) {
                    self.watchdog.tick(at(ms));
                }
                self.poll(ms);
            }
        }

        fn pulses(&self) -> Vec<u64> {
            let high = self.levels.iter().filter(|(_, pin, high)| *pin == Pin::Heartbeat && *high);
            high.map(|(ms, ..)| *ms).collect()
        }
    }

    #[test]
    fn pulses_come_every_two_seconds_while_the_brain_lives() {
        let mut board = Board::new();
        let low = [(0, Pin::Force, false), (0, Pin::Heartbeat, false), (0, Pin::Enable, false)];
        assert_eq!(board.levels, low);
        board.pass(1, 1000, false);
        assert_eq!(board.levels.len(), 3, "it is off until the brain lives");
        board.pass(1000, 6000, true);
        let expected = [
            (1000, Pin::Enable, true),
            (1000, Pin::Heartbeat, true),
            (1250, Pin::Heartbeat, false),
            (3000, Pin::Heartbeat, true),
            (3250, Pin::Heartbeat, false),
            (5000, Pin::Heartbeat, true),
            (5250, Pin::Heartbeat, false),
        ];
        assert_eq!(board.levels[3..], expected);
        assert_eq!(board.states, [State::Starting, State::Working]);
    }

    #[test]
    fn a_brain_that_stands_still_gets_no_pulse_until_it_moves_again() {
        let mut board = Board::new();
        board.pass(0, 3000, true);
        board.pass(3000, 20_000, false);
        assert_eq!(board.pulses(), [0, 2000, 4000], "the last for what moved just before 3 s");
        assert!(matches!(&board.states[2], State::Failing(why) if why.contains("does not move on")));
        board.pass(20_000, 23_000, true);
        assert_eq!(board.pulses().len(), 5, "{:?}", board.pulses());
        assert_eq!(board.states.last(), Some(&State::Working));
    }

    #[test]
    fn the_board_s_warning_is_a_failure_while_it_lasts() {
        let mut board = Board::new();
        board.pass(0, 3000, true);
        board.watchdog.expiry(at(3000), true);
        board.watchdog.expiry(at(3000), true);
        board.pass(3000, 4000, true);
        assert!(
            matches!(board.states.last(), Some(State::Failing(why)) if why.contains("cut the computer's power"))
        );
        assert!(board.notes.len() == 1 && board.notes[0].warning);
        board.watchdog.expiry(at(4000), false);
        board.pass(4000, 5000, true);
        assert_eq!(board.states.last(), Some(&State::Working));
    }

    #[test]
    fn a_clean_end_turns_it_off_first_and_for_good() {
        let mut board = Board::new();
        board.pass(0, 2100, true);
        let before = board.levels.len();
        board.watchdog.shut_down();
        board.pass(2100, 9000, true);
        assert_eq!(board.levels[before..], [(2100, Pin::Enable, false), (2100, Pin::Heartbeat, false)]);
        assert_eq!(board.watchdog.poll_timeout(), None);
    }

    #[test]
    fn what_nobody_polls_stays_bounded_and_the_last_level_counts() {
        let mut watchdog = Watchdog::new(at(0), WatchdogConfig::default());
        for ms in 0..60_000 {
            watchdog.alive(at(ms), ms + 1);
            watchdog.expiry(at(ms), ms % 3 == 0);
        }
        assert!(watchdog.out.len() <= 6, "{:?}", watchdog.out);
        let pulses =
            watchdog.out.iter().filter(|o| matches!(o, WatchdogOutput::Set { pin: Pin::Heartbeat, .. }));
        assert_eq!(pulses.count(), 1);
    }

    #[test]
    fn pins_are_those_of_the_board() {
        let pins = [Pin::Heartbeat, Pin::Enable, Pin::Expiry, Pin::Force];
        assert_eq!(pins.map(Pin::bcm), [5, 6, 12, 16]);
    }
}
