//! The signal light: patterns of one or more lamps that show the vessel's state to people without a screen.
//!
//! A pattern is groups of one level for each lamp and a duration, over and over. Another pattern begins where the running
//! one ends, so that none is cut into something else. Patterns and what they mean: the DUNE task `UserInterfaces.LEDs`, which
//! has a pattern for low batteries and never shows it; here it is shown in place of the normal one.

use std::time::Duration;
use thiserror::Error;
use units::MonoTime;

/// The most lamps.
pub const MOST_LAMPS: usize = 8;
/// The most groups of a pattern.
const MOST_GROUPS: usize = 64;
/// The longest group (ms): more would look like a light that is broken.
const LONGEST_MS: i64 = 60_000;

/// The meaning of the light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Sign {
    /// At rest, without faults.
    Normal,
    /// At rest, with low batteries.
    FuelLow,
    /// A plan starts.
    Starting,
    /// A plan runs: the propellers may turn at any moment.
    Executing,
    /// There is a fault.
    Error,
    /// A part that every voyage needs has failed since the start of the program.
    Fatal,
    /// The power goes off.
    Shutdown,
}

/// The vessel's activity, in the terms of its supervisor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Activity {
    /// The program begins.
    #[default]
    Boot,
    /// At rest.
    Service,
    /// A plan is being started.
    Calibration,
    /// A plan runs.
    Maneuver,
    /// Another system steers.
    External,
    /// There is a fault.
    Error,
}

/// The inputs of the light.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Situation {
    /// The vessel's activity.
    pub activity: Activity,
    /// The batteries are low.
    pub fuel_low: bool,
    /// One of the critical parts has failed at this moment.
    pub critical_failed: bool,
    /// The power is being turned off.
    pub powering_off: bool,
}

/// Why numbers are not a pattern.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Error)]
pub enum PatternError {
    /// Not whole groups.
    #[error("a pattern of {numbers} numbers is not whole groups of {lamps} levels and a duration")]
    Groups {
        /// Numbers given.
        numbers: usize,
        /// Lamps of the light.
        lamps: usize,
    },
    /// Too many groups.
    #[error("a pattern has at most 64 groups")]
    TooLong,
    /// A level that is neither.
    #[error("{0} is not a level: 0 is off and 1 is on")]
    Level(i64),
    /// A duration that cannot be seen, or too long a one.
    #[error("{0} ms is not a duration between 1 and 60000 ms")]
    Duration(i64),
}

/// A pattern of a light.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Pattern {
    /// Lamps that are on, bit by bit, and for how long.
    groups: Vec<(u8, Duration)>,
}

impl Pattern {
    /// The pattern that these numbers of a configuration mean for a light of so many lamps.
    ///
    /// # Errors
    /// When they are not whole groups of levels (0 or 1) and a duration (ms).
    pub fn new(numbers: &[i64], lamps: usize) -> Result<Self, PatternError> {
        let one = lamps + 1;
        let whole = !numbers.is_empty() && numbers.len().is_multiple_of(one);
        if !whole || !(1..=MOST_LAMPS).contains(&lamps) {
            return Err(PatternError::Groups { numbers: numbers.len(), lamps });
        }
        if numbers.len() / one > MOST_GROUPS {
            return Err(PatternError::TooLong);
        }
        let groups: Result<_, _> = numbers.chunks_exact(one).map(|group| Self::group(group, lamps)).collect();
        Ok(Self { groups: groups? })
    }

    fn group(group: &[i64], lamps: usize) -> Result<(u8, Duration), PatternError> {
        let (levels, ms) = (&group[..lamps], group[lamps]);
        let mut on = 0;
        for (lamp, &level) in levels.iter().enumerate() {
            match level {
                0 => {}
                1 => on |= 1 << lamp,
                other => return Err(PatternError::Level(other)),
            }
        }
        let seen = (1..=LONGEST_MS).contains(&ms);
        // Within the range just asked for, which has no sign.
        if seen { Ok((on, Duration::from_millis(ms as u64))) } else { Err(PatternError::Duration(ms)) }
    }
}

/// The pattern of each sign.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Patterns {
    /// At rest, without faults.
    pub normal: Pattern,
    /// At rest, with low batteries.
    pub fuel_low: Pattern,
    /// A plan starts.
    pub starting: Pattern,
    /// A plan runs.
    pub executing: Pattern,
    /// There is a fault.
    pub error: Pattern,
    /// A critical part has failed.
    pub fatal: Pattern,
    /// The power goes off.
    pub shutdown: Pattern,
}

impl Patterns {
    fn of(&self, sign: Sign) -> &Pattern {
        match sign {
            Sign::Normal => &self.normal,
            Sign::FuelLow => &self.fuel_low,
            Sign::Starting => &self.starting,
            Sign::Executing => &self.executing,
            Sign::Error => &self.error,
            Sign::Fatal => &self.fatal,
            Sign::Shutdown => &self.shutdown,
        }
    }
}

/// The light.
#[derive(Debug, Clone)]
pub struct Light {
    lamps: u8,
    patterns: Patterns,
    /// A critical part has failed since the start: shown until the next one.
    fatal: bool,
    wanted: Sign,
    shown: Sign,
    /// The group at hand, and when it ends; `None` before the first.
    group: usize,
    until: Option<MonoTime>,
    /// Lamps as they are on, bit by bit, and which of them have still to be set.
    on: u8,
    to_set: u8,
}

impl Light {
    /// A light of so many lamps ([`MOST_LAMPS`] at most), all off. It begins at the first [`Self::show`].
    pub fn new(lamps: usize, patterns: Patterns) -> Self {
        // At most eight.
        let lamps = lamps.min(MOST_LAMPS) as u8;
        let to_set = 0xFF_u8.checked_shr(u32::from(8 - lamps)).unwrap_or(0);
        let sign = Sign::Error;
        Self {
            lamps,
            patterns,
            fatal: false,
            wanted: sign,
            shown: sign,
            group: 0,
            until: None,
            on: 0,
            to_set,
        }
    }

    /// The vessel is like this now.
    pub fn show(&mut self, now: MonoTime, situation: Situation) {
        self.fatal |= situation.critical_failed;
        self.wanted = self.sign(situation);
        self.tick(now);
        if self.until.is_none() {
            self.shown = self.wanted;
            self.begin(now, 0);
        }
    }

    /// The most urgent meaning. That the propellers may turn is more urgent to people nearby than a low battery.
    fn sign(&self, situation: Situation) -> Sign {
        if situation.powering_off {
            return Sign::Shutdown;
        }
        if self.fatal {
            return Sign::Fatal;
        }
        match situation.activity {
            Activity::Boot | Activity::Error => Sign::Error,
            Activity::Calibration => Sign::Starting,
            Activity::Maneuver | Activity::External => Sign::Executing,
            Activity::Service if situation.fuel_low => Sign::FuelLow,
            Activity::Service => Sign::Normal,
        }
    }

    /// Whether a critical part has failed since the start.
    pub fn is_fatal(&self) -> bool {
        self.fatal
    }

    /// Continues with the next group where the present one is over.
    pub fn tick(&mut self, now: MonoTime) {
        let Some(until) = self.until.filter(|until| *until <= now) else { return };
        let ended = self.group + 1 >= self.patterns.of(self.shown).groups.len();
        let next = if ended { 0 } else { self.group + 1 };
        if ended {
            self.shown = self.wanted;
        }
        let length = self.patterns.of(self.shown).groups[next].1;
        // The rhythm is kept where the loop is a little late; what was missed for longer is not made up for.
        let begin = if now.since(until) < length { until } else { now };
        self.begin(begin, next);
    }

    fn begin(&mut self, at: MonoTime, group: usize) {
        let (on, length) = self.patterns.of(self.shown).groups[group];
        self.to_set |= on ^ self.on;
        (self.on, self.group, self.until) = (on, group, Some(at + length));
    }

    /// The program ends: all lamps go off, and nothing turns them on until the next [`Self::show`].
    pub fn end(&mut self) {
        self.to_set |= self.on;
        (self.on, self.until) = (0, None);
    }

    /// The next lamp to set, by its place in the configuration, and whether on or off; `None` when there is no more.
    pub fn poll_output(&mut self) -> Option<(u8, bool)> {
        let lamp = (0..self.lamps).find(|lamp| self.to_set >> lamp & 1 == 1)?;
        self.to_set &= !(1 << lamp);
        Some((lamp, self.on >> lamp & 1 == 1))
    }

    /// When to call [`tick`](Self::tick) at the latest; `None` before the first [`Self::show`].
    pub fn poll_timeout(&self) -> Option<MonoTime> {
        self.until
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(ms: u64) -> MonoTime {
        MonoTime::from_micros(ms * 1000)
    }

    fn patterns() -> Patterns {
        let pattern = |numbers: &[i64]| Pattern::new(numbers, 1).unwrap();
        Patterns {
            normal: pattern(&[1, 2000, 0, 2000]),
            fuel_low: pattern(&[1, 200, 0, 200, 1, 200, 0, 2000]),
            starting: pattern(&[1, 200, 0, 2000]),
            executing: pattern(&[1, 500, 0, 500]),
            error: pattern(&[1, 200, 0, 2000]),
            fatal: pattern(&[1, 100, 0, 100]),
            shutdown: pattern(&[1, 300, 0, 300]),
        }
    }

    /// When the lamp was switched (ms), by the light's own deadlines.
    fn run(light: &mut Light, from_ms: u64, to_ms: u64) -> Vec<(u64, bool)> {
        let mut switched = Vec::new();
        let mut ms = from_ms;
        loop {
            while let Some((lamp, on)) = light.poll_output() {
                assert_eq!(lamp, 0);
                switched.push((ms, on));
            }
            let Some(due) = light.poll_timeout() else { return switched };
            ms = due.micros() / 1000;
            if ms >= to_ms {
                return switched;
            }
            light.tick(due);
        }
    }

    fn in_service() -> Situation {
        Situation { activity: Activity::Service, ..Situation::default() }
    }

    #[test]
    fn a_change_takes_effect_at_the_end_of_the_running_pattern() {
        let mut light = Light::new(1, patterns());
        assert_eq!(run(&mut light, 0, 10), [(0, false)], "off before anything is shown");
        light.show(at(0), in_service());
        assert_eq!(run(&mut light, 0, 2500), [(0, true), (2000, false)]);
        light.show(at(2500), Situation { activity: Activity::Maneuver, ..in_service() });
        let switched = run(&mut light, 2500, 5600);
        assert_eq!(switched, [(4000, true), (4500, false), (5000, true), (5500, false)]);
    }

    #[test]
    fn the_most_urgent_sign_is_shown() {
        let sign = |situation: Situation| {
            let mut light = Light::new(1, patterns());
            light.show(at(0), situation);
            light.shown
        };
        let with = |activity| Situation { activity, fuel_low: true, ..Situation::default() };
        assert_eq!(sign(Situation::default()), Sign::Error, "boot");
        assert_eq!(sign(in_service()), Sign::Normal);
        assert_eq!(sign(with(Activity::Service)), Sign::FuelLow);
        assert_eq!(sign(with(Activity::Calibration)), Sign::Starting);
        assert_eq!(sign(with(Activity::Maneuver)), Sign::Executing);
        assert_eq!(sign(with(Activity::External)), Sign::Executing);
        assert_eq!(sign(with(Activity::Error)), Sign::Error);
        assert_eq!(sign(Situation { critical_failed: true, ..in_service() }), Sign::Fatal);
        assert_eq!(
            sign(Situation { powering_off: true, critical_failed: true, ..in_service() }),
            Sign::Shutdown
        );
    }

    #[test]
    fn a_critical_failure_is_shown_until_the_next_start() {
        let mut light = Light::new(1, patterns());
        light.show(at(0), Situation { critical_failed: true, ..in_service() });
        light.show(at(50), in_service());
        run(&mut light, 50, 10_000);
        assert_eq!(light.shown, Sign::Fatal);
    }

    #[test]
    fn a_late_loop_keeps_the_rhythm_and_makes_nothing_up() {
        let mut light = Light::new(1, patterns());
        light.show(at(0), in_service());
        light.tick(at(2300));
        assert_eq!(light.poll_timeout(), Some(at(4000)), "the end of the second group, as if in time");
        light.tick(at(60_000));
        assert_eq!(light.poll_timeout(), Some(at(62_000)));
        light.end();
        assert_eq!(run(&mut light, 62_000, 99_000), [(62_000, false)]);
    }

    #[test]
    fn numbers_that_are_no_pattern_are_refused() {
        let groups = |numbers, lamps| Err(PatternError::Groups { numbers, lamps });
        assert_eq!(Pattern::new(&[1, 2000, 0], 1), groups(3, 1));
        assert_eq!(Pattern::new(&[], 1), groups(0, 1));
        assert_eq!(Pattern::new(&[100], 0), groups(1, 0));
        assert_eq!(Pattern::new(&[1; 10], 9), groups(10, 9));
        assert_eq!(Pattern::new(&[2, 100], 1), Err(PatternError::Level(2)));
        assert_eq!(Pattern::new(&[1, 0], 1), Err(PatternError::Duration(0)));
        assert_eq!(Pattern::new(&[1, -5], 1), Err(PatternError::Duration(-5)));
        assert_eq!(Pattern::new(&[1; 130], 1), Err(PatternError::TooLong));
        let two = Pattern::new(&[1, 0, 100, 0, 1, 100], 2).unwrap();
        let mut light = Light::new(2, Patterns { normal: two, ..patterns() });
        light.show(at(0), in_service());
        let first: Vec<_> = std::iter::from_fn(|| light.poll_output()).collect();
        light.tick(at(100));
        let second: Vec<_> = std::iter::from_fn(|| light.poll_output()).collect();
        assert_eq!((first, second), (vec![(0, true), (1, false)], vec![(0, false), (1, true)]));
    }
}
