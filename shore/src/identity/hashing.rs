//! The one place where passwords are hashed: a thread of its own.
//!
//! A hash takes 19 MiB and tens of milliseconds on purpose. In one thread all of them share the same memory, and guesses by
//! strangers load one core at most. At most [`WAITING`] requests are queued; further ones are refused as busy, and those
//! whose requester has gone are skipped.

use super::password;
use crate::owners::Owners;
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use tokio::sync::oneshot;

/// Passwords that may be queued.
const WAITING: usize = 64;

/// Handle of the thread; cheap to clone.
#[derive(Debug, Clone)]
pub(crate) struct Hashing(SyncSender<Work>);

/// Too many wait.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Busy;

#[derive(Debug)]
enum Work {
    Hash(String, oneshot::Sender<String>),
    Compare(String, Option<String>, oneshot::Sender<bool>),
    #[cfg(any(test, feature = "testing"))]
    Fault,
}

impl Hashing {
    /// Starts the thread; it ends with the last handle.
    pub(crate) fn start(owners: &Owners) -> std::io::Result<Self> {
        let (sender, work) = sync_channel(WAITING);
        let duty = owners.duty("the hashing of passwords");
        std::thread::Builder::new().name("hashing".to_owned()).spawn(move || {
            run(&work);
            duty.done();
        })?;
        Ok(Self(sender))
    }

    /// The password's hash.
    ///
    /// # Errors
    /// Too many wait.
    pub(crate) async fn hash(&self, password: String) -> Result<String, Busy> {
        let (answer, answered) = oneshot::channel();
        self.queue(Work::Hash(password, answer))?;
        answered.await.map_err(|_| Busy)
    }

    /// Whether `password` matches the hash `kept`; as slow for `None`, which never matches.
    ///
    /// # Errors
    /// Too many wait.
    pub(crate) async fn is_right(&self, password: String, kept: Option<String>) -> Result<bool, Busy> {
        let (answer, answered) = oneshot::channel();
        self.queue(Work::Compare(password, kept, answer))?;
        answered.await.map_err(|_| Busy)
    }

    /// For tests: makes the thread panic, as a bug would.
    #[cfg(any(test, feature = "testing"))]
    pub(crate) fn lose(&self) {
        self.queue(Work::Fault).expect("there is room in the queue");
    }

    fn queue(&self, work: Work) -> Result<(), Busy> {
        self.0.try_send(work).map_err(|error| match error {
            TrySendError::Full(_) | TrySendError::Disconnected(_) => Busy,
        })
    }
}

fn run(work: &Receiver<Work>) {
    let mut memory = password::Memory::default();
    while let Ok(work) = work.recv() {
        match work {
            #[cfg(any(test, feature = "testing"))]
            Work::Fault => panic!("a fault in the hashing"),
            Work::Hash(password, answer) => {
                if !answer.is_closed() {
                    answer.send(password::hash(&password)).ok();
                }
            }
            Work::Compare(password, kept, answer) => {
                if !answer.is_closed() {
                    answer.send(password::is_right(&mut memory, &password, kept.as_deref())).ok();
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn of_too_many_at_once_the_last_are_told_to_come_again() {
        let owners = Owners::new(crate::clock::Clock::real());
        let hashing = Hashing::start(&owners).unwrap();
        let kept = hashing.hash("nine otters swim".to_owned()).await.unwrap();
        assert_eq!(hashing.is_right("nine otters swim".to_owned(), Some(kept)).await, Ok(true));
        // None of these is polled again: each stays in the queue, and is skipped once dropped.
        let mut waiting = Vec::new();
        let mut busy = 0;
        for _ in 0..WAITING * 2 {
            let mut one = Box::pin(hashing.is_right("x".to_owned(), None));
            if let Ok(outcome) = tokio::time::timeout(std::time::Duration::ZERO, one.as_mut()).await {
                assert_eq!(outcome, Err(Busy));
                busy += 1;
            }
            waiting.push(one);
        }
        assert!(busy >= WAITING / 2, "{busy}");
        drop(waiting);
        let found = loop {
            if let Ok(found) = hashing.is_right("nine".to_owned(), None).await {
                break found;
            }
            tokio::task::yield_now().await;
        };
        assert!(!found);
    }
}
