//! Places for work that takes memory.

use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// So much work is done at the same time; what comes beyond that waits for its turn, in order, and for no longer than a bound.
#[derive(Debug, Clone)]
pub struct Places {
    free: Arc<Semaphore>,
    patience: Duration,
}

impl Places {
    /// So many, for which so long may be waited.
    pub fn new(places: usize, patience: Duration) -> Self {
        Self { free: Arc::new(Semaphore::new(places)), patience }
    }

    /// A place, which is free again when it is dropped; `None` where none became free.
    pub async fn take(&self) -> Option<OwnedSemaphorePermit> {
        let place = Arc::clone(&self.free).acquire_owned();
        // It is never closed.
        tokio::time::timeout(self.patience, place).await.ok()?.ok()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test(start_paused = true)]
    async fn what_comes_beyond_the_places_waits_its_turn_and_no_longer_than_the_bound() {
        let places = Places::new(2, Duration::from_secs(5));
        let (first, _second) = (places.take().await.unwrap(), places.take().await.unwrap());
        let begun = tokio::time::Instant::now();
        assert!(places.take().await.is_none());
        assert_eq!(begun.elapsed().as_secs(), 5);
        let later = async {
            tokio::time::sleep(Duration::from_secs(3)).await;
            drop(first);
        };
        let (third, ()) = tokio::join!(places.take(), later);
        assert!(third.is_some(), "the place of the first");
        assert_eq!(begun.elapsed().as_secs(), 8);
    }
}
