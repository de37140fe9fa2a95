//! Watches the tasks and threads that own state: the hub, the recorder, app.db and others.
//!
//! Each holds a [`Duty`] while it lives. A duty that is dropped before its owner called [`Duty::done`] means that the owner
//! panicked: [`Owners::failed`] reports it, the program flushes what it can and ends with an error, and its service
//! restarts it. An owner that has worked on one job for longer than `HANGS_AFTER` is reported by `/healthz`: most likely
//! its disk hangs, which a restart does not cure.

use crate::clock::Clock;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::watch;

/// Work on one job that takes longer is reported.
const HANGS_AFTER: Duration = Duration::from_secs(5);

/// All owners of state; cheap to clone.
#[derive(Debug, Clone)]
pub struct Owners(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    clock: Clock,
    /// The first owner that was lost.
    lost: watch::Sender<Option<&'static str>>,
    all: Mutex<Vec<Arc<Pulse>>>,
}

/// State of one owner.
#[derive(Debug)]
struct Pulse {
    name: &'static str,
    /// When its current job began, in milliseconds since the start, plus one; 0 while it is idle.
    busy_since_ms: AtomicU64,
    /// Makes a watched task panic, for tests.
    #[cfg(any(test, feature = "testing"))]
    fault: tokio::sync::Notify,
}

/// Held by an owner while it is in service.
#[derive(Debug)]
pub struct Duty {
    owners: Owners,
    pulse: Arc<Pulse>,
    done: bool,
}

/// One job, until it is dropped.
#[derive(Debug)]
pub struct Busy(Arc<Pulse>);

impl Owners {
    /// No owners yet; `clock` times their jobs.
    pub fn new(clock: Clock) -> Self {
        Self(Arc::new(Inner { clock, lost: watch::Sender::new(None), all: Mutex::default() }))
    }

    /// Registers an owner, by the name that is shown to people.
    pub fn duty(&self, name: &'static str) -> Duty {
        let pulse = Arc::new(Pulse {
            name,
            busy_since_ms: AtomicU64::new(0),
            #[cfg(any(test, feature = "testing"))]
            fault: tokio::sync::Notify::new(),
        });
        self.0.all.lock().unwrap_or_else(PoisonError::into_inner).push(Arc::clone(&pulse));
        Duty { owners: self.clone(), pulse, done: false }
    }

    /// Watches a task as an owner while it runs.
    pub fn watch<T, F: Future<Output = T>>(
        &self,
        name: &'static str,
        task: F,
    ) -> impl Future<Output = T> + use<T, F> {
        let duty = self.duty(name);
        async move {
            #[cfg(any(test, feature = "testing"))]
            let task = or_fault(Arc::clone(&duty.pulse), task);
            let outcome = task.await;
            duty.done();
            outcome
        }
    }

    /// Waits until an owner is lost, and returns its name.
    pub async fn failed(&self) -> &'static str {
        let mut lost = self.0.lost.subscribe();
        match lost.wait_for(Option::is_some).await.ok().and_then(|lost| *lost) {
            Some(name) => name,
            None => std::future::pending().await,
        }
    }

    /// What is wrong with the owners, if anything; safe to show to anyone.
    pub fn trouble(&self) -> Option<String> {
        if let Some(name) = *self.0.lost.borrow() {
            return Some(format!("{name} was lost to a fault; the server ends"));
        }
        let now_ms = self.now_ms();
        let all = self.0.all.lock().unwrap_or_else(PoisonError::into_inner);
        all.iter().find_map(|pulse| {
            let since_ms = pulse.busy_since_ms.load(Ordering::Relaxed);
            let busy = Duration::from_millis(now_ms.saturating_sub(since_ms));
            (since_ms > 0 && busy >= HANGS_AFTER).then(|| {
                format!("{} has not answered for {} s: does its disk hang?", pulse.name, busy.as_secs())
            })
        })
    }

    /// Whether no owner is lost.
    pub fn are_there(&self) -> bool {
        self.0.lost.borrow().is_none()
    }

    /// For tests: makes a watched task panic, as a bug would; returns whether there is one of this name.
    #[cfg(any(test, feature = "testing"))]
    pub fn lose(&self, name: &str) -> bool {
        let all = self.0.all.lock().unwrap_or_else(PoisonError::into_inner);
        all.iter().filter(|pulse| pulse.name == name).map(|pulse| pulse.fault.notify_one()).count() > 0
    }

    fn now_ms(&self) -> u64 {
        self.0.clock.mono().micros() / 1_000 + 1
    }
}

/// Runs the task, and panics when a test requests it.
#[cfg(any(test, feature = "testing"))]
async fn or_fault<T>(pulse: Arc<Pulse>, task: impl Future<Output = T>) -> T {
    tokio::select! {
        biased;
        () = pulse.fault.notified() => panic!("a fault in {}", pulse.name),
        outcome = task => outcome,
    }
}

impl Duty {
    /// The owner begins a job.
    pub fn busy(&self) -> Busy {
        self.pulse.busy_since_ms.store(self.owners.now_ms(), Ordering::Relaxed);
        Busy(Arc::clone(&self.pulse))
    }

    /// The owner ends normally.
    pub fn done(mut self) {
        self.done = true;
    }
}

impl Drop for Duty {
    fn drop(&mut self) {
        if !self.done {
            tracing::error!("{} was lost to a fault", self.pulse.name);
            self.owners.0.lost.send_if_modified(|lost| {
                let first = lost.is_none();
                lost.get_or_insert(self.pulse.name);
                first
            });
        }
        let mut all = self.owners.0.all.lock().unwrap_or_else(PoisonError::into_inner);
        all.retain(|pulse| !Arc::ptr_eq(pulse, &self.pulse));
    }
}

impl Drop for Busy {
    fn drop(&mut self) {
        self.0.busy_since_ms.store(0, Ordering::Relaxed);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn an_owner_that_is_lost_is_told_and_one_that_is_done_is_not() {
        let owners = Owners::new(Clock::real());
        owners.duty("the first").done();
        assert!(owners.are_there() && owners.trouble().is_none());
        let duty = owners.duty("the second");
        let lost = std::thread::spawn(move || {
            let _duty = duty;
            panic!("a fault");
        });
        assert!(lost.join().is_err());
        assert_eq!(owners.failed().await, "the second");
        drop(owners.duty("the third"));
        assert_eq!(owners.failed().await, "the second", "what came first is the cause");
        assert!(!owners.are_there() && owners.trouble().unwrap().contains("the second was lost"));
    }

    #[tokio::test]
    async fn a_task_that_panics_is_an_owner_that_is_lost() {
        let owners = Owners::new(Clock::real());
        tokio::spawn(owners.watch("what ends", tokio::task::yield_now())).await.unwrap();
        assert!(owners.are_there());
        let task = tokio::spawn(owners.watch("the task", async {
            tokio::task::yield_now().await;
            panic!("a fault");
        }));
        assert!(task.await.is_err());
        assert_eq!(owners.failed().await, "the task");
    }

    #[test]
    fn an_owner_that_hangs_is_told_while_it_does() {
        let (clock, hand) = Clock::with_hand();
        let owners = Owners::new(clock);
        let duty = owners.duty("app.db");
        let busy = duty.busy();
        assert!(owners.trouble().is_none());
        hand.advance(Duration::from_mins(1));
        assert!(owners.trouble().unwrap().contains("app.db has not answered for 60 s"));
        drop(busy);
        assert!(owners.trouble().is_none());
        duty.done();
    }
}
