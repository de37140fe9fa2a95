//! The order in which routes are planned.
//!
//! Few routes are planned at once, and a bounded number waits. A long way over detailed charts can take tens of seconds the first
//! time: one of these is planned at a time, so that one turn at least is always for the others.

use crate::error::{Error, ErrorKind, Result};
use api::say;
use std::sync::Arc;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// So many are planned at once.
const AT_ONCE: usize = 2;
/// So many of these may be long ways.
const LONG_AT_ONCE: usize = 1;
/// So many more requests may wait; further ones are refused and may be sent again.
const MOST_WAITING: usize = 64;
/// So many of these may be long ways: they wait for each other, and leave places to the others.
const MOST_LONG_WAITING: usize = 4;

/// The turns of all requests; clones share them.
#[derive(Clone)]
pub(super) struct Turns {
    places: Arc<Semaphore>,
    long_places: Arc<Semaphore>,
    long: Arc<Semaphore>,
    working: Arc<Semaphore>,
}

/// A turn, until it is dropped.
pub(super) struct Taken {
    _place: OwnedSemaphorePermit,
    _long: Option<[OwnedSemaphorePermit; 2]>,
    _working: OwnedSemaphorePermit,
}

/// A turn for the server's own work, until it is dropped.
pub(super) struct Spare {
    _working: OwnedSemaphorePermit,
    working: Arc<Semaphore>,
}

impl Spare {
    /// Whether the next request would still begin at once.
    pub(super) fn is_spare(&self) -> bool {
        self.working.available_permits() > 0
    }
}

impl Default for Turns {
    fn default() -> Self {
        let of = |count: usize| Arc::new(Semaphore::new(count));
        Self {
            places: of(AT_ONCE + MOST_WAITING),
            long_places: of(LONG_AT_ONCE + MOST_LONG_WAITING),
            long: of(LONG_AT_ONCE),
            working: of(AT_ONCE),
        }
    }
}

impl Turns {
    /// Waits for a turn.
    ///
    /// # Errors
    /// Too many wait.
    pub(super) async fn take(&self, is_long: bool) -> Result<Taken> {
        let busy =
            || Error::new(ErrorKind::Busy, say("Too many routes are being planned; try again in a moment."));
        let place = |of: &Arc<Semaphore>| Arc::clone(of).try_acquire_owned().map_err(|_| busy());
        // First of the long ones: one that waits for another takes no turn from the others.
        let long = if is_long { Some([place(&self.long_places)?, acquire(&self.long).await?]) } else { None };
        let place = place(&self.places)?;
        Ok(Taken { _place: place, _long: long, _working: acquire(&self.working).await? })
    }

    /// A turn for work of our own, while no request is worked on.
    pub(super) fn spare(&self) -> Option<Spare> {
        let is_idle = self.working.available_permits() == AT_ONCE;
        let turn = is_idle.then(|| Arc::clone(&self.working).try_acquire_owned().ok()).flatten()?;
        Some(Spare { _working: turn, working: Arc::clone(&self.working) })
    }
}

async fn acquire(of: &Arc<Semaphore>) -> Result<OwnedSemaphorePermit> {
    Arc::clone(of).acquire_owned().await.map_err(|error| Error::internal(&error))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::pin::{Pin, pin};
    use std::task::{Context, Poll, Waker};

    /// A turn, if it comes at once.
    fn at_once(wait: Pin<&mut impl Future<Output = Result<Taken>>>) -> Option<Taken> {
        match wait.poll(&mut Context::from_waker(Waker::noop())) {
            Poll::Ready(taken) => Some(taken.unwrap_or_else(|_| panic!("it is refused"))),
            Poll::Pending => None,
        }
    }

    #[test]
    fn long_ways_leave_a_turn_to_the_others() {
        let turns = Turns::default();
        let long = at_once(pin!(turns.take(true))).unwrap();
        let mut other_long = pin!(turns.take(true));
        assert!(at_once(other_long.as_mut()).is_none(), "one at a time");
        for _ in 0..3 {
            assert!(at_once(pin!(turns.take(false))).is_some(), "the short ones pass");
        }
        let short = at_once(pin!(turns.take(false))).unwrap();
        assert!(at_once(pin!(turns.take(false))).is_none(), "two at once");
        drop(long);
        let long = at_once(other_long.as_mut()).unwrap();
        drop((short, long));
    }

    #[test]
    fn long_ways_that_wait_leave_places_to_the_others() {
        let turns = Turns::default();
        let _long = at_once(pin!(turns.take(true))).unwrap();
        let mut waiting: Vec<_> = (0..MOST_LONG_WAITING).map(|_| Box::pin(turns.take(true))).collect();
        assert!(waiting.iter_mut().all(|wait| at_once(wait.as_mut()).is_none()));
        for _ in 0..AT_ONCE + MOST_WAITING {
            let refused = pin!(turns.take(true)).poll(&mut Context::from_waker(Waker::noop()));
            assert!(matches!(refused, Poll::Ready(Err(_))), "further long ones are refused");
        }
        assert!(at_once(pin!(turns.take(false))).is_some(), "a short one still has a place");
    }

    #[test]
    fn own_work_begins_while_nothing_is_asked_and_is_called_off_by_the_next() {
        let turns = Turns::default();
        let asked = at_once(pin!(turns.take(false))).unwrap();
        assert!(turns.spare().is_none());
        drop(asked);
        let spare = turns.spare().unwrap();
        assert!(turns.spare().is_none(), "one at a time");
        assert!(spare.is_spare());
        let _asked = at_once(pin!(turns.take(false))).unwrap();
        assert!(!spare.is_spare());
    }

    #[test]
    fn of_many_that_wait_the_last_are_refused() {
        let turns = Turns::default();
        let _working: Vec<Taken> = (0..AT_ONCE).map(|_| at_once(pin!(turns.take(false))).unwrap()).collect();
        let mut waiting: Vec<_> = (0..MOST_WAITING).map(|_| Box::pin(turns.take(false))).collect();
        assert!(waiting.iter_mut().all(|wait| at_once(wait.as_mut()).is_none()));
        let refused = pin!(turns.take(false)).poll(&mut Context::from_waker(Waker::noop()));
        assert!(matches!(refused, Poll::Ready(Err(_))));
    }
}
