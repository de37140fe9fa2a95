//! The handle through which a running server asks about people.

use super::audit::{self, Act};
use super::db::{Db, Fault};
use super::limiter::Limiter;
use super::roles::{Principal, Via};
use super::secret::{self, Secret};
use super::sessions::{self, Lifetime};
use super::{password, persons, tokens};
use crate::clock;
use crate::config;
use api::Role;
use rusqlite::Connection;
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};
use tokio::sync::{Semaphore, watch};
use units::MonoTime;

/// Hashes computed at once; each takes 19 MiB.
const HASHING: usize = 2;

/// Cheap to clone.
#[derive(Debug, Clone)]
pub(crate) struct People {
    pub(super) db: Db,
    pub(super) life: Lifetime,
    pub(super) hashing: Arc<Semaphore>,
    limiter: Arc<Mutex<Limiter>>,
    begun: Instant,
    /// Counts changes after which open sockets must show their rights again.
    changed: Arc<watch::Sender<u64>>,
}

/// The account made at the first start.
#[derive(Debug)]
pub(crate) struct FirstAdmin {
    pub(crate) name: &'static str,
    pub(crate) one_time_password: String,
}

impl People {
    /// Opens the database in `folder`. When nobody is in it yet, makes an admin with a one-time password. What an
    /// earlier server was killed in the middle of gets its end in the audit log.
    ///
    /// # Errors
    /// As [`super::open`].
    pub(crate) fn start(folder: &Path, config: &config::People) -> Result<(Self, Option<FirstAdmin>), Fault> {
        let mut connection = super::open(folder)?;
        let first = super::db::within_transaction(&mut connection, first_admin)?;
        audit::close_open(&connection, clock::now())?;
        let people = Self {
            db: Db::start(connection),
            life: Lifetime {
                idle: Duration::from_secs(u64::from(config.session_idle_h) * 3_600),
                whole: Duration::from_secs(u64::from(config.session_days) * 86_400),
            },
            hashing: Arc::new(Semaphore::new(HASHING)),
            limiter: Arc::default(),
            begun: Instant::now(),
            changed: Arc::new(watch::Sender::new(0)),
        };
        Ok((people, first))
    }

    /// Reads.
    ///
    /// # Errors
    /// What `work` says.
    pub(crate) async fn ask<R: Send + 'static>(
        &self,
        work: impl FnOnce(&Connection) -> Result<R, Fault> + Send + 'static,
    ) -> Result<R, Fault> {
        self.db.ask(work).await
    }

    /// Changes something without a line in the audit log.
    ///
    /// # Errors
    /// What `work` says.
    pub(crate) async fn change<R: Send + 'static>(
        &self,
        work: impl FnOnce(&Connection) -> Result<R, Fault> + Send + 'static,
    ) -> Result<R, Fault> {
        self.db.change(work).await
    }

    /// Changes something in `who`'s name, with its line in the audit log, or refuses, with its line too.
    ///
    /// # Errors
    /// What `work` says.
    pub(crate) async fn act<R: Send + 'static>(
        &self,
        who: &Principal,
        address: String,
        action: &'static str,
        subject: String,
        work: impl FnOnce(&Connection) -> Result<R, Fault> + Send + 'static,
    ) -> Result<R, Fault> {
        let actor = who.name.clone();
        let note = move |db: &Connection, outcome: &str| {
            let act = Act { actor: &actor, address: &address, action, subject: &subject, outcome };
            audit::record(db, act, clock::now())
        };
        let again = note.clone();
        let outcome = self
            .db
            .change(move |db| {
                let done = work(db)?;
                note(db, "done")?;
                Ok(done)
            })
            .await;
        if let Err(Fault::Refused(reason)) = &outcome {
            let reason = reason.clone();
            self.db.change(move |db| again(db, &reason)).await?;
        }
        self.changed.send_modify(|count| *count += 1);
        outcome
    }

    /// Writes down what happened by itself, or to somebody.
    ///
    /// # Errors
    /// The log cannot be written.
    pub(crate) async fn write_down(
        &self,
        actor: String,
        action: &'static str,
        subject: String,
        outcome: String,
    ) -> Result<(), Fault> {
        self.db
            .change(move |db| {
                let (actor, subject, outcome) = (actor.as_str(), subject.as_str(), outcome.as_str());
                audit::record(db, Act { actor, address: "", action, subject, outcome }, clock::now())
            })
            .await
    }

    /// Counts changes of anybody's rights or sessions; those who hold a socket open look again then.
    pub(crate) fn changes(&self) -> watch::Receiver<u64> {
        self.changed.subscribe()
    }

    /// Who has this session.
    pub(crate) async fn by_session(&self, secret: Secret) -> Result<Option<Principal>, Fault> {
        let life = self.life;
        let found = self.db.ask(move |db| sessions::find(db, &secret, life, clock::now())).await?;
        let Some(found) = found else { return Ok(None) };
        if let (true, &Via::Session { id, .. }) = (found.stale, &found.principal.via) {
            self.db.change(move |db| sessions::touch(db, id, clock::now())).await?;
        }
        Ok(Some(found.principal))
    }

    /// For whom this token acts.
    pub(crate) async fn by_token(&self, token: String) -> Result<Option<Principal>, Fault> {
        let found = self.db.ask(move |db| tokens::find(db, &token, clock::now())).await?;
        let Some(found) = found else { return Ok(None) };
        if found.stale {
            self.db.change(move |db| tokens::touch(db, found.id, clock::now())).await?;
        }
        Ok(Some(found.who))
    }

    /// The vessel (IMC address) whose link this token opens.
    pub(crate) async fn by_link_token(&self, token: String) -> Result<Option<u16>, Fault> {
        let found = self.db.ask(move |db| tokens::find_link(db, &token, clock::now())).await?;
        let Some(found) = found else { return Ok(None) };
        if found.stale {
            self.db.change(move |db| tokens::touch(db, found.id, clock::now())).await?;
        }
        Ok(Some(found.who))
    }

    /// Hashes a password on a thread where slow work may be done.
    pub(crate) async fn hash(&self, password: String) -> Result<String, Fault> {
        let turn = Arc::clone(&self.hashing).acquire_owned().await.map_err(|_| Fault::Stopped)?;
        let hashed = tokio::task::spawn_blocking(move || {
            let _turn = turn;
            password::hash(&password)
        });
        hashed.await.map_err(|_| Fault::Stopped)
    }

    /// Asks the budgets of guesses.
    pub(super) fn limit<R>(&self, ask: impl FnOnce(&mut Limiter, MonoTime) -> R) -> R {
        let now = MonoTime::from_micros(self.begun.elapsed().as_micros() as u64);
        // A limiter left by a panic is as good as before: every step of it is whole.
        ask(&mut self.limiter.lock().unwrap_or_else(PoisonError::into_inner), now)
    }
}

fn first_admin(db: &Connection) -> Result<Option<FirstAdmin>, Fault> {
    let people: i64 = db.query_row("SELECT count(*) FROM person", [], |row| row.get(0))?;
    if people > 0 {
        return Ok(None);
    }
    let first = FirstAdmin { name: "admin", one_time_password: secret::one_time_password() };
    let id = persons::add(db, first.name, &password::hash(&first.one_time_password), true, clock::now())?;
    persons::set_permission(db, id, None, Some(Role::Admin))?;
    Ok(Some(first))
}
