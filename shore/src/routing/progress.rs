//! How far questions have come that take long: each under a name that its client gave it, as long as it is worked on.

use super::{MOST_TIME, malformed};
use crate::error::{Error, ErrorKind, Result};
use api::{SeaRouteProgress, say};
use planner::Progress;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::Instant;

/// Letters of a name: a client makes it up, so that no other one has it.
const NAME: std::ops::RangeInclusive<usize> = 8..=64;

type ByName = Arc<Mutex<BTreeMap<String, Arc<Seen>>>>;

/// The questions that are worked on; clones share them. There are no more than have or wait for a turn.
#[derive(Clone, Default)]
pub(super) struct UnderWay(ByName);

/// A question that is worked on, until it is dropped.
pub(super) struct Asked {
    seen: Arc<Seen>,
    /// Where it is found, if it has a name.
    listed: Option<(String, ByName)>,
}

struct Seen {
    since: Instant,
    /// It has its turn.
    begun: AtomicBool,
    tiles: AtomicUsize,
    most_tiles: AtomicUsize,
}

impl UnderWay {
    /// Begins a question, which is found by its name from now on.
    ///
    /// # Errors
    /// The name is malformed.
    pub(super) fn begin(&self, name: Option<&str>) -> Result<Asked> {
        let seen = Arc::new(Seen {
            since: Instant::now(),
            begun: AtomicBool::new(false),
            tiles: AtomicUsize::new(0),
            most_tiles: AtomicUsize::new(0),
        });
        let Some(name) = name else { return Ok(Asked { seen, listed: None }) };
        let plain = |letter: char| letter.is_ascii_alphanumeric() || letter == '-';
        if !NAME.contains(&name.len()) || !name.chars().all(plain) {
            let (least, most) = NAME.into_inner();
            let text = say("progress: give a name of {least} to {most} letters, digits and hyphens");
            return Err(malformed(text.with("least", least).with("most", most)));
        }
        lock(&self.0).insert(name.to_owned(), Arc::clone(&seen));
        Ok(Asked { seen, listed: Some((name.to_owned(), Arc::clone(&self.0))) })
    }

    /// How far the question of this name has come.
    ///
    /// # Errors
    /// No question of this name is worked on.
    pub(super) fn of(&self, name: &str) -> Result<SeaRouteProgress> {
        let missing = || {
            Error::new(
                ErrorKind::NotFound,
                say("No route is being planned under this name; it may be answered."),
            )
        };
        let seen = lock(&self.0).get(name).cloned().ok_or_else(missing)?;
        Ok(SeaRouteProgress {
            waiting: !seen.begun.load(Ordering::Relaxed),
            tiles: seen.tiles.load(Ordering::Relaxed),
            most_tiles: seen.most_tiles.load(Ordering::Relaxed),
            spent_s: seen.since.elapsed().as_secs_f64(),
            most_s: MOST_TIME.as_secs_f64(),
        })
    }
}

impl Asked {
    /// It has its turn.
    pub(super) fn begun(&self) {
        self.seen.begun.store(true, Ordering::Relaxed);
    }

    /// The search for a long way has come so far.
    pub(super) fn report(&self, Progress { tiles, most_tiles }: Progress) {
        self.seen.tiles.store(tiles, Ordering::Relaxed);
        self.seen.most_tiles.store(most_tiles, Ordering::Relaxed);
    }
}

impl Drop for Asked {
    fn drop(&mut self) {
        let Some((name, all)) = self.listed.take() else { return };
        let mut all = lock(&all);
        // A later question may have taken the name.
        if all.get(&name).is_some_and(|seen| Arc::ptr_eq(seen, &self.seen)) {
            all.remove(&name);
        }
    }
}

fn lock<T>(all: &Mutex<T>) -> MutexGuard<'_, T> {
    all.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_question_is_found_by_its_name_until_it_is_answered() {
        let under_way = UnderWay::default();
        assert!(under_way.of("question-1").is_err());
        let asked = under_way.begin(Some("question-1")).unwrap();
        let first = under_way.of("question-1").unwrap();
        assert_eq!((first.waiting, first.tiles), (true, 0));
        asked.begun();
        asked.report(Progress { tiles: 7, most_tiles: 90 });
        let next = under_way.of("question-1").unwrap();
        assert_eq!((next.waiting, next.tiles, next.most_tiles), (false, 7, 90));
        // One that takes its name is not taken away with it.
        let later = under_way.begin(Some("question-1")).unwrap();
        drop(asked);
        assert!(under_way.of("question-1").unwrap().waiting);
        drop(later);
        assert!(under_way.of("question-1").is_err());
        for bad in ["short", "with a blank in it", &"x".repeat(65)] {
            assert!(under_way.begin(Some(bad)).is_err(), "{bad}");
        }
    }
}
