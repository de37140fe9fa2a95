//! Names that hold for a time: which label an entity had, which name a system.

use std::collections::BTreeMap;

/// Most changes of one name that are kept; a sender that changes it more often has no name worth keeping.
const MAX_RUNS: usize = 1_000;

/// One name and when it was heard first and last (µs since 1970-01-01 UTC).
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Run<T> {
    /// The name.
    pub name: T,
    /// When it was last heard.
    pub last_us: i64,
}

/// The names of one system or entity, by when each was first heard.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Runs<T> {
    /// By when each was first heard.
    pub runs: BTreeMap<i64, Run<T>>,
}

impl<T> Default for Runs<T> {
    fn default() -> Self {
        Self { runs: BTreeMap::new() }
    }
}

impl<T: Clone + PartialEq> Runs<T> {
    /// The name at a time; the first one for times before it was heard.
    pub fn at(&self, time_us: i64) -> Option<&T> {
        let run = self.runs.range(..=time_us).next_back().or_else(|| self.runs.first_key_value());
        run.map(|(_, run)| &run.name)
    }

    /// The last name heard.
    pub fn latest(&self) -> Option<&T> {
        self.runs.last_key_value().map(|(_, run)| &run.name)
    }

    /// Hears a name at a time, which may be before others; whether that says something new.
    pub fn hear(&mut self, time_us: i64, name: &T) -> bool {
        if let Some((from_us, before)) = self.runs.range_mut(..=time_us).next_back() {
            if before.name == *name {
                before.last_us = before.last_us.max(time_us);
                return false;
            }
            if *from_us == time_us {
                return false;
            }
            if before.last_us > time_us {
                // Another name within a run: it was heard before and after.
                let rest = Run { name: before.name.clone(), last_us: before.last_us };
                let resumed_us = before.last_us;
                before.last_us = time_us - 1;
                self.insert(resumed_us, rest);
            }
        }
        let after = self.runs.range(time_us..).next().map(|(from_us, run)| (*from_us, run.name == *name));
        let run = match after {
            Some((from_us, true)) => self.runs.remove(&from_us),
            _ => None,
        };
        self.insert(time_us, run.unwrap_or(Run { name: name.clone(), last_us: time_us }));
        true
    }

    fn insert(&mut self, from_us: i64, run: Run<T>) {
        if self.runs.len() < MAX_RUNS {
            self.runs.insert(from_us, run);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn heard(names: &[(i64, &'static str)]) -> Vec<(i64, &'static str)> {
        let mut runs = Runs::default();
        for (time_us, name) in names {
            runs.hear(*time_us, name);
        }
        runs.runs.iter().map(|(from_us, run)| (*from_us, run.name)).collect()
    }

    #[test]
    fn a_name_holds_from_when_it_was_first_heard() {
        assert_eq!(heard(&[(1, "a"), (5, "a"), (9, "b"), (12, "b")]), [(1, "a"), (9, "b")]);
    }

    #[test]
    fn names_heard_late_find_their_place() {
        assert_eq!(heard(&[(9, "b"), (1, "a")]), [(1, "a"), (9, "b")]);
        assert_eq!(heard(&[(9, "b"), (1, "b")]), [(1, "b")]);
        assert_eq!(heard(&[(1, "a"), (9, "a"), (5, "b")]), [(1, "a"), (5, "b"), (9, "a")]);
    }

    #[test]
    fn a_time_before_all_has_the_first_name() {
        let mut runs = Runs::default();
        runs.hear(5, &"a");
        runs.hear(9, &"b");
        assert_eq!((runs.at(0), runs.at(8), runs.at(9)), (Some(&"a"), Some(&"a"), Some(&"b")));
    }
}
