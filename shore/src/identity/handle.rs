//! The handle through which a running server asks about people.

use super::audit::Line;
use super::audit::{self, Acted};
use super::fault::Fault;
use super::hashing::Hashing;
use super::journal::Journal;
use super::limiter::Limiter;
use super::register::{Found, Register, Use};
use super::request::Request;
use super::roles::Principal;
use super::secret::{self, Secret};
use super::sessions::{self, Lifetime};
use super::writer::{Db, within_transaction};
use super::{password, persons, tokens};
use crate::clock::Clock;
use crate::owners::Owners;
use api::{Role, Vessel};
use imc::Address;
use sqlx::{Connection as _, SqliteConnection};
use std::path::Path;
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;
use units::{MonoTime, UtcTime};

/// How long a user or token that the register does not know waits for app.db.
const PATIENCE: Duration = Duration::from_secs(2);
/// How long a request waits for app.db before an error says that it hangs.
pub const ASK_PATIENCE: Duration = Duration::from_secs(10);
/// How often app.db is checked for changes by another program.
const LOOK_EVERY: Duration = Duration::from_secs(1);

/// Handle of accounts and access; cheap to clone.
#[derive(Debug, Clone)]
pub struct People {
    pub(super) db: Db,
    pub(super) life: Lifetime,
    pub(super) hashing: Hashing,
    register: Arc<Register>,
    journal: Journal,
    limiter: Arc<Mutex<Limiter>>,
    pub(super) clock: Clock,
    /// Counts changes after which open sockets must check their permissions again.
    changed: Arc<watch::Sender<u64>>,
}

/// The account made at the first start.
#[derive(Debug)]
pub struct FirstAdmin {
    /// Its name.
    pub name: &'static str,
    /// Good for one login, after which another must be chosen.
    pub one_time_password: String,
}

impl People {
    /// Opens the database in `folder`. If it has no people yet, makes an admin with a one-time password. Actions that a
    /// killed server left open are ended in the audit log.
    ///
    /// # Errors
    /// As [`super::open`].
    pub async fn start(
        folder: &Path,
        config: &super::Settings,
        owners: &Owners,
        clock: Clock,
    ) -> Result<(Self, Option<FirstAdmin>), Fault> {
        let mut connection = super::open(folder).await?;
        let first = within_transaction(&mut connection, FirstLook { now: clock.utc() }).await?;
        let register = Arc::new(Register::default());
        register.catch_up(&mut *connection.begin().await?).await?;
        let no_thread = |error| Fault::Folder(folder.display().to_string(), error);
        let people = Self {
            db: Db::start(connection, folder, Arc::clone(&register), owners).map_err(no_thread)?,
            life: Lifetime {
                idle: Duration::from_secs(u64::from(config.session_idle_h) * 3_600),
                whole: Duration::from_secs(u64::from(config.session_days) * 86_400),
            },
            hashing: Hashing::start(owners).map_err(no_thread)?,
            register,
            journal: Journal::new(clock.clone()),
            limiter: Arc::default(),
            clock,
            changed: Arc::new(watch::Sender::new(0)),
        };
        Ok((people, first))
    }

    /// Starts the background tasks: writing the journal, and following changes by other programs.
    pub fn keep(&self, owners: &Owners, tasks: &TaskTracker, stop: &CancellationToken) {
        let written = self.journal.clone().keep(self.db.clone(), stop.clone());
        tasks.spawn(owners.watch("the audit log", written));
        let (people, stop) = (self.clone(), stop.clone());
        tasks.spawn(owners.watch("the look for changes of app.db", async move {
            let mut every = tokio::time::interval(LOOK_EVERY);
            every.set_missed_tick_behavior(tokio::time::MissedTickBehavior::Delay);
            while stop.run_until_cancelled(every.tick()).await.is_some() {
                let before = people.register.version();
                // Only one query at a time waits for a disk that hangs.
                let looked = stop.run_until_cancelled(people.db.catch_up()).await;
                if matches!(looked, Some(Ok(()))) && people.register.version() != before {
                    people.changed.send_modify(|count| *count += 1);
                }
            }
        }));
    }

    /// For tests: makes the thread that writes app.db panic, as a bug would.
    ///
    /// # Errors
    /// What a caller gets when the thread is lost.
    #[cfg(any(test, feature = "testing"))]
    pub async fn lose_writer(&self) -> Result<(), Fault> {
        #[derive(Debug)]
        struct Lost;
        impl Request for Lost {
            type Answer = ();

            async fn run(self, _: &mut SqliteConnection) -> Result<(), Fault> {
                panic!("a fault in app.db")
            }
        }
        self.db.change(Lost).await
    }

    /// For tests: makes the thread that hashes passwords panic, as a bug would.
    #[cfg(any(test, feature = "testing"))]
    pub fn lose_hashing(&self) {
        self.hashing.lose();
    }

    /// Reads.
    ///
    /// # Errors
    /// As the request, or app.db does not answer.
    pub async fn ask<R: Request>(&self, request: R) -> Result<R::Answer, Fault> {
        tokio::time::timeout(ASK_PATIENCE, self.db.ask(request)).await.unwrap_or(Err(Fault::Hangs))
    }

    /// Changes something without a line in the audit log.
    ///
    /// # Errors
    /// As the request.
    pub async fn change<R: Request>(&self, request: R) -> Result<R::Answer, Fault> {
        self.db.change(request).await
    }

    /// Changes something on behalf of `who`; the change or its refusal is written into the audit log.
    ///
    /// # Errors
    /// As the request.
    pub async fn act<R: Request>(
        &self,
        who: &Principal,
        address: String,
        action: &'static str,
        subject: String,
        request: R,
    ) -> Result<R::Answer, Fault> {
        let line = Line { actor: who.actor(), address, action, subject, outcome: "done".to_owned() };
        let done = self.db.change(Acted { request, line: line.clone(), now: self.clock.utc() });
        let outcome = tokio::time::timeout(ASK_PATIENCE, done).await.unwrap_or(Err(Fault::Hangs));
        if let Err(Fault::Refused(reason)) = &outcome {
            let line = Line { outcome: reason.to_string(), ..line };
            self.db.change(audit::Record(vec![(self.clock.utc(), line)])).await?;
        }
        self.changed.send_modify(|count| *count += 1);
        outcome
    }

    /// Writes lines into the audit log; they are on the disk when it returns.
    ///
    /// # Errors
    /// app.db cannot be written, or does not answer within `patience`.
    pub async fn record(&self, lines: Vec<Line>, patience: Duration) -> Result<(), Fault> {
        let now = self.clock.utc();
        let lines = lines.into_iter().map(|line| (now, line)).collect();
        let written = self.db.change(audit::Record(lines));
        tokio::time::timeout(patience, written).await.unwrap_or(Err(Fault::Hangs))
    }

    /// Queues a line for the audit log; never waits.
    pub fn note(&self, line: Line) {
        self.journal.note(line);
    }

    /// Writes the queued lines, once everything else has ended.
    pub async fn finish(&self) {
        self.journal.finish(&self.db).await;
    }

    /// For tests, which have no task that does this: writes the queued lines.
    ///
    /// # Panics
    /// It cannot be written.
    #[cfg(any(test, feature = "testing"))]
    pub async fn write_notes(&self) {
        self.journal.write(&self.db).await.expect("the audit log is written");
    }

    /// Why the audit log is not written, if so; safe to show to anyone.
    pub fn trouble(&self) -> Option<&'static str> {
        self.journal.trouble()
    }

    /// Counts changes of permissions and sessions; open sockets then check theirs again.
    pub fn changes(&self) -> watch::Receiver<u64> {
        self.changed.subscribe()
    }

    /// The user of this session.
    ///
    /// # Errors
    /// It is unknown, and app.db, which may have it, does not answer.
    pub async fn by_session(&self, secret: &Secret) -> Result<Option<Principal>, Fault> {
        self.known(|register| register.session(secret, self.life, self.clock.utc())).await
    }

    /// The principal that this token acts for.
    ///
    /// # Errors
    /// It is unknown, and app.db, which may have it, does not answer; or it is not valid yet.
    pub async fn by_token(&self, token: &str) -> Result<Option<Principal>, Fault> {
        self.known(|register| register.token(token, self.clock.utc())).await
    }

    /// The vessel (IMC address) whose link this token opens.
    ///
    /// # Errors
    /// It is unknown, and app.db, which may have it, does not answer.
    pub async fn by_link_token(&self, token: &str) -> Result<Option<u16>, Fault> {
        self.known(|register| register.link(token, self.clock.utc())).await
    }

    /// The vessels that people have named.
    pub fn vessels(&self) -> Arc<[Vessel]> {
        self.register.vessels()
    }

    /// Whether people have named a vessel with this address.
    pub fn is_named(&self, vessel: Address) -> bool {
        self.register.vessels().iter().any(|named| named.address == vessel.0)
    }

    /// Vessels that have used their link, and still have a valid token.
    pub fn linked(&self) -> Vec<u16> {
        self.register.linked(self.clock.utc())
    }

    /// Looks in the register, and asks app.db only for what is not there.
    async fn known<T>(&self, look: impl Fn(&Register) -> Found<T>) -> Result<Option<T>, Fault> {
        let mut found = look(&self.register);
        if matches!(found, Found::Unknown) {
            tokio::time::timeout(PATIENCE, self.db.catch_up()).await.map_err(|_| Fault::Hangs)??;
            found = look(&self.register);
        }
        match found {
            Found::Known(who, due) => {
                if let Some(due) = due {
                    self.write_use(due);
                }
                Ok(Some(who))
            }
            Found::Refused(why) => Err(Fault::NotYet(why)),
            Found::Over | Found::Unknown => Ok(None),
        }
    }

    /// Records the use of a session or token when app.db is free. A failure refuses no request.
    fn write_use(&self, of: Use) {
        self.db.change_some_time(WriteUse {
            of,
            register: Arc::clone(&self.register),
            now: self.clock.utc(),
        });
    }

    /// Hashes a password.
    ///
    /// # Errors
    /// Too many wait.
    pub async fn hash(&self, password: String) -> Result<String, Fault> {
        self.hashing.hash(password).await.map_err(|_| Fault::Busy)
    }

    /// Accesses the budgets of guesses.
    pub(super) fn limit<R>(&self, ask: impl FnOnce(&mut Limiter, MonoTime) -> R) -> R {
        let now = self.clock.mono();
        // The limiter is valid even after a panic: every step leaves it consistent.
        ask(&mut self.limiter.lock().unwrap_or_else(PoisonError::into_inner), now)
    }
}

/// Records the use of a session or token.
#[derive(Debug)]
struct WriteUse {
    of: Use,
    register: Arc<Register>,
    now: UtcTime,
}

impl Request for WriteUse {
    type Answer = ();

    async fn run(self, db: &mut SqliteConnection) -> Result<(), Fault> {
        let Self { of, register, now } = self;
        match of {
            Use::Session(id) => sessions::touch(db, id, now).await?,
            Use::Token(id) => tokens::touch(db, id, now).await?,
        }
        register.written(of, now);
        Ok(())
    }
}

/// What a start writes: the missing ends after a killed server, and the first admin of an empty database.
#[derive(Debug)]
struct FirstLook {
    now: UtcTime,
}

impl Request for FirstLook {
    type Answer = Option<FirstAdmin>;

    async fn run(self, db: &mut SqliteConnection) -> Result<Option<FirstAdmin>, Fault> {
        let now = self.now;
        audit::close_open(db, now).await?;
        let people: i64 = sqlx::query_scalar("SELECT count(*) FROM person").fetch_one(&mut *db).await?;
        if people > 0 {
            return Ok(None);
        }
        let first = FirstAdmin { name: "admin", one_time_password: secret::one_time_password() };
        let id = persons::add(db, first.name, &password::hash(&first.one_time_password), true, now).await?;
        persons::set_permission(db, id, None, Some(Role::Admin)).await?;
        Ok(Some(first))
    }
}
