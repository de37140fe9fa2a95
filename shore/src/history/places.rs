//! Places for work that takes memory.

use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Limits concurrent work; further work waits in order, no longer than a bound.
#[derive(Debug, Clone)]
pub struct Places {
    free: Arc<Semaphore>,
    patience: Duration,
}

impl Places {
    /// So many places, with this longest wait.
    pub fn new(places: usize, patience: Duration) -> Self {
        Self { free: Arc::new(Semaphore::new(places)), patience }
    }

    /// A place, which is freed when dropped; `None` if none became free in time.
    pub async fn take(&self) -> Option<OwnedSemaphorePermit> {
        let place = Arc::clone(&self.free).acquire_owned();
        // It is never closed.
        tokio::time::timeout(self.patience, place).await.ok()?.ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::future::Future as _;

    #[tokio::test]
    async fn what_comes_beyond_the_places_waits_its_turn_and_no_longer_than_the_bound() {
        let at_once = Places::new(2, Duration::ZERO);
        let _taken = (at_once.take().await.unwrap(), at_once.take().await.unwrap());
        assert!(at_once.take().await.is_none(), "nothing is waited for");
        // Longer than any test takes.
        let places = Places::new(1, Duration::from_mins(1));
        let first = places.take().await.unwrap();
        let mut second = Box::pin(places.take());
        let waits = std::future::poll_fn(|context| {
            std::task::Poll::Ready(second.as_mut().poll(context).is_pending())
        });
        assert!(waits.await, "the place is taken");
        drop(first);
        assert!(second.await.is_some(), "the place of the first");
    }
}
