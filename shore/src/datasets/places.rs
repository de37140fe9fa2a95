//! Places for computations for links, separate from those for users with an account.

use super::Datasets;
use super::shares::OpenShare;
use crate::error::{Error, ErrorKind, Result};
use api::say;
use std::collections::BTreeSet;
use std::sync::{Arc, Mutex, PoisonError};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};

/// Files that are computed for links at the same time, for downloads and checks; of one link one download.
const PLACES: usize = 2;

#[derive(Clone)]
pub(super) struct LinkPlaces {
    all: Arc<Semaphore>,
    busy: Arc<Mutex<BTreeSet<i64>>>,
}

impl Default for LinkPlaces {
    fn default() -> Self {
        Self { all: Arc::new(Semaphore::new(PLACES)), busy: Arc::default() }
    }
}

impl LinkPlaces {
    pub(super) const fn all(&self) -> &Arc<Semaphore> {
        &self.all
    }

    fn take(&self, share: i64) -> Option<LinkPlace> {
        let place = Arc::clone(&self.all).try_acquire_owned().ok()?;
        let is_free = self.busy.lock().unwrap_or_else(PoisonError::into_inner).insert(share);
        is_free.then(|| LinkPlace { share, busy: Arc::clone(&self.busy), _place: place })
    }
}

/// A place for a download by a link, which is free again when it is dropped.
pub struct LinkPlace {
    share: i64,
    busy: Arc<Mutex<BTreeSet<i64>>>,
    _place: OwnedSemaphorePermit,
}

impl Drop for LinkPlace {
    fn drop(&mut self) {
        self.busy.lock().unwrap_or_else(PoisonError::into_inner).remove(&self.share);
    }
}

impl Datasets {
    /// A place to write a file that a link gives.
    ///
    /// # Errors
    /// This link, or all links together, have reached their limit.
    pub fn place(&self, open: &OpenShare) -> Result<LinkPlace> {
        self.places.take(open.share.id).ok_or_else(|| {
            let text =
                say("This link is downloading a file already, or too many links are; try again in a moment.");
            Error::new(ErrorKind::Busy, text)
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn links_have_two_places_and_each_link_one() {
        let places = LinkPlaces::default();
        let first = places.take(1).unwrap();
        assert!(places.take(1).is_none(), "one of a link");
        let second = places.take(2).unwrap();
        assert!(places.take(3).is_none(), "two of all");
        drop(first);
        let _again = places.take(1).unwrap();
        drop(second);
        assert!(places.take(3).is_some());
    }
}
