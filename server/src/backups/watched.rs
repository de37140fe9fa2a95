//! Checks the configured backup, and which recordings may be deleted thanks to it, without blocking on its disk.
//!
//! System calls on a disk or share that hangs do not return. So each check runs in its own thread with a time limit; while
//! one hangs no other begins, and the state says that it hangs. Pages show the last result.

use super::{State, checked, look};
use crate::config::Config;
use crate::retention;
use shore::clock;
use std::sync::Arc;
use std::sync::mpsc;
use std::time::Duration;
use store::{Check, Health};
use tokio::sync::{oneshot, watch};
use tokio_util::sync::CancellationToken;
use units::UtcTime;

/// How often a running server checks.
const LOOK_EVERY: Duration = Duration::from_mins(10);
/// A disk that has not answered by then counts as hanging; a sleeping one takes 15 s to spin up.
const LOOK_WITHIN: Duration = Duration::from_secs(30);

/// Result of a check.
#[derive(Debug, Clone)]
pub(crate) struct Seen {
    pub(crate) state: State,
    /// What the next removal of recordings would do, which depends on the backup.
    retention: Check,
}

impl Seen {
    fn look(config: &Config, now: UtcTime) -> Self {
        Self { state: look(config, now), retention: retention::check(config, now) }
    }

    /// No result, for this reason.
    fn not(why: String) -> Self {
        let retention = Check {
            name: retention::NAME,
            health: Health::Warning,
            found: why.clone(),
            remedy: String::new(),
        };
        Self { state: State { made: None, trouble: Some(why), is_set_up: true }, retention }
    }

    fn hangs(config: &Config) -> Self {
        Self::not(format!(
            "backup.folder {} does not answer: its disk, or the computer that shares it, hangs. Look at `dmesg` and `findmnt`; \
             `umount -f -l` and mounting it again may help",
            config.backup.folder.display()
        ))
    }

    fn checks(self, config: &Config) -> [Check; 2] {
        [checked(config, self.state), self.retention]
    }
}

/// Begins a check, in its own thread.
fn begin(
    look: impl FnOnce() -> Seen + Send + 'static,
    done: impl FnOnce(Seen) + Send + 'static,
) -> std::io::Result<()> {
    std::thread::Builder::new().name("backup-look".to_owned()).spawn(move || done(look())).map(drop)
}

/// For the doctor: checks now.
pub(crate) fn checks(config: &Config, now: UtcTime) -> [Check; 2] {
    let (sender, receiver) = mpsc::channel();
    let its = config.clone();
    let begun = begin(move || Seen::look(&its, now), move |seen| drop(sender.send(seen)));
    let seen = match begun.map(|()| receiver.recv_timeout(LOOK_WITHIN)) {
        Ok(Ok(seen)) => seen,
        Ok(Err(mpsc::RecvTimeoutError::Timeout)) => Seen::hangs(config),
        Ok(Err(mpsc::RecvTimeoutError::Disconnected)) => Seen::not(FAULT.to_owned()),
        Err(error) => Seen::not(format!("the backup is not looked at, there is no thread for it: {error}")),
    };
    seen.checks(config)
}

const FAULT: &str = "the backup could not be looked at, by a fault of this program: its log has more";

/// The last result of a running server.
#[derive(Debug, Clone)]
pub(crate) struct Watched(watch::Sender<Option<Seen>>);

impl Watched {
    pub(crate) fn new() -> Self {
        Self(watch::Sender::new(None))
    }

    /// The last state; `None` before the first check has finished.
    pub(crate) fn state(&self) -> Option<State> {
        self.0.borrow().as_ref().map(|seen| seen.state.clone())
    }

    /// For the page *Storage*: the last results.
    pub(crate) fn checks(&self, config: &Config) -> [Check; 2] {
        let seen = self.0.borrow().clone();
        seen.unwrap_or_else(|| Seen::not("it is being looked at: ask again in a minute".to_owned()))
            .checks(config)
    }

    /// Checks periodically until the server ends.
    pub(crate) async fn keep(self, config: Arc<Config>, clock: clock::Clock, stop: CancellationToken) {
        let mut every = tokio::time::interval(LOOK_EVERY);
        every.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
        while stop.run_until_cancelled(every.tick()).await.is_some() {
            let (its, clock) = (Arc::clone(&config), clock.clone());
            let look = move || Seen::look(&its, clock.utc());
            let limit = tokio::time::sleep(LOOK_WITHIN);
            stop.run_until_cancelled(self.look(look, limit, &config)).await;
        }
    }

    /// Checks once. At the `limit` it reports that the disk hangs; it returns only when the check has returned, however
    /// long that takes, so that no other begins before.
    async fn look(
        &self,
        look: impl FnOnce() -> Seen + Send + 'static,
        limit: impl Future<Output = ()>,
        config: &Config,
    ) {
        let (sender, mut looked) = oneshot::channel();
        if let Err(error) = begin(look, move |seen| drop(sender.send(seen))) {
            tracing::error!(%error, "there is no thread to look at the backup with; tried again");
            return;
        }
        let in_time = tokio::select! {
            biased;
            seen = &mut looked => Some(seen),
            () = limit => None,
        };
        let seen = if let Some(seen) = in_time {
            seen
        } else {
            self.take(Seen::hangs(config));
            looked.await
        };
        self.take(seen.unwrap_or_else(|_| Seen::not(FAULT.to_owned())));
    }

    /// Stores a result. The time of the last backup is kept while the disk cannot be accessed, so that its age continues to
    /// grow.
    fn take(&self, mut seen: Seen) {
        let before = self.state().unwrap_or(State { made: None, trouble: None, is_set_up: false });
        let state = &mut seen.state;
        state.made = state.made.or(before.made);
        match (&before.trouble, &state.trouble) {
            // If no backup was set up, only the doctor reports it, not the log of each start.
            (None, Some(trouble)) if !state.is_set_up => tracing::debug!("{trouble}"),
            (None, Some(trouble)) => tracing::warn!("{trouble}"),
            (Some(_), None) => tracing::info!("the backup is well again"),
            _ => {}
        }
        self.0.send_replace(Some(seen));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn well(made: i64) -> Seen {
        let retention = Check {
            name: retention::NAME,
            health: Health::Good,
            found: String::new(),
            remedy: String::new(),
        };
        let made = Some(UtcTime::from_micros(made));
        Seen { state: State { made, trouble: None, is_set_up: true }, retention }
    }

    #[test]
    fn when_the_last_one_was_made_stays_known_while_its_disk_is_away() {
        let watched = Watched::new();
        watched.take(well(7));
        watched.take(Seen::not("away".to_owned()));
        let state = watched.state().unwrap();
        assert_eq!((state.made, state.trouble.as_deref()), (Some(UtcTime::from_micros(7)), Some("away")));
    }

    #[tokio::test]
    async fn a_disk_that_hangs_is_said_and_not_looked_at_again_before_it_answers() {
        let mut config = Config::default();
        config.backup.folder = "/mnt/hangs".into();
        let (release, hangs) = mpsc::channel::<()>();
        let look = move || {
            hangs.recv().ok();
            well(9)
        };
        let watched = Watched::new();
        assert!(watched.checks(&config)[0].found.contains("is being looked at"));
        let (mut seen, its, its_config) = (watched.0.subscribe(), watched.clone(), config.clone());
        // The limit is reached at once.
        let looks = tokio::spawn(async move { its.look(look, std::future::ready(()), &its_config).await });
        seen.changed().await.unwrap();
        for check in watched.checks(&config) {
            assert!(check.found.contains("/mnt/hangs does not answer"), "{}", check.found);
            assert_eq!(check.health, Health::Warning);
        }
        tokio::task::yield_now().await;
        assert!(!looks.is_finished(), "the next look would begin");
        release.send(()).unwrap();
        looks.await.unwrap();
        assert_eq!(watched.state(), Some(well(9).state));
    }
}
