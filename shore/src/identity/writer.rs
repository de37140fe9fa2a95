//! The connections that read and write app.db while a server runs.
//!
//! One thread owns the only connection that writes: requests reach it one after another over a queue of [`WAITING`], and a
//! requester waits asynchronously when it is full. [`READERS`] connections read in parallel and never wait for writes: with
//! SQLite's write-ahead log every reader sees the state at its begin.

use super::db;
use super::fault::Fault;
use super::register::Register;
use super::request::Request;
use crate::owners::{Duty, Owners};
use sqlx::sqlite::{SqlitePool, SqlitePoolOptions};
use sqlx::{Connection as _, SqliteConnection};
use std::path::{Path, PathBuf};
use std::pin::Pin;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{mpsc, oneshot};

/// Requests that may wait for the thread that writes.
const WAITING: usize = 256;
/// Connections that read.
const READERS: u32 = 4;
/// How long a query waits for one of them.
const PATIENCE: Duration = Duration::from_secs(10);

/// Handle of app.db; the writing thread ends with the last one. Cheap to clone.
#[derive(Debug, Clone)]
pub(super) struct Db {
    jobs: mpsc::Sender<Box<dyn Job>>,
    readers: SqlitePool,
    register: Arc<Register>,
}

impl Db {
    /// Hands `connection` to a thread of its own, which brings `register` up to date after each change, and opens
    /// `app.db` in `folder` for reading.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub(super) fn start(
        connection: SqliteConnection,
        folder: &Path,
        register: Arc<Register>,
        owners: &Owners,
    ) -> std::io::Result<Self> {
        let (jobs, asked) = mpsc::channel(WAITING);
        let (duty, written) = (owners.duty("app.db"), Arc::clone(&register));
        let place = folder.to_owned();
        let runtime = tokio::runtime::Builder::new_current_thread().build()?;
        std::thread::Builder::new()
            .name("app.db".to_owned())
            .spawn(move || runtime.block_on(write(connection, place, asked, written, duty)))?;
        let readers = SqlitePoolOptions::new()
            .max_connections(READERS)
            .acquire_timeout(PATIENCE)
            .idle_timeout(None)
            .max_lifetime(None)
            .test_before_acquire(false)
            // A transaction left open by a failed disk would show its old snapshot to all later queries.
            .before_acquire(|connection, _| Box::pin(async move { Ok(!connection.is_in_transaction()) }))
            .connect_lazy_with(db::options(folder).read_only(true));
        Ok(Self { jobs, readers, register })
    }

    /// Answers a query that only reads, in parallel with writes.
    ///
    /// # Errors
    /// As the request, or no connection is free.
    pub(super) async fn ask<R: Request>(&self, request: R) -> Result<R::Answer, Fault> {
        let mut moment = self.readers.begin().await?;
        let answer = request.run(&mut moment).await?;
        moment.commit().await?;
        Ok(answer)
    }

    /// Carries `request` out in a transaction that is committed only when it succeeds. Changes of access are in force when
    /// it returns.
    ///
    /// # Errors
    /// As the request, or the server is stopping.
    pub(super) async fn change<R: Request>(&self, request: R) -> Result<R::Answer, Fault> {
        let (answer, answered) = oneshot::channel();
        let job = Box::new(Asked { request, answer });
        self.jobs.send(job).await.map_err(|_| Fault::Stopped)?;
        answered.await.map_err(|_| Fault::Stopped)?
    }

    /// Carries `request` out later, if there is room in the queue. No task waits for it.
    pub(super) fn change_some_time<R: Request>(&self, request: R) {
        // The queue is full: it is offered again later.
        self.jobs.try_send(Box::new(Asked { request, answer: oneshot::channel().0 })).ok();
    }

    /// Brings the register up to date, if another program changed app.db.
    ///
    /// # Errors
    /// It cannot be read.
    pub(super) async fn catch_up(&self) -> Result<(), Fault> {
        let mut moment = self.readers.begin().await?;
        self.register.catch_up(&mut moment).await
    }
}

/// A queued request to the writing thread.
trait Job: Send {
    /// Carries it out and answers; returns whether the connection is still usable.
    fn run<'a>(
        self: Box<Self>,
        db: &'a mut SqliteConnection,
        register: &'a Register,
    ) -> Pin<Box<dyn Future<Output = bool> + 'a>>;
}

struct Asked<R: Request> {
    request: R,
    answer: oneshot::Sender<Result<R::Answer, Fault>>,
}

impl<R: Request> Job for Asked<R> {
    fn run<'a>(
        self: Box<Self>,
        db: &'a mut SqliteConnection,
        register: &'a Register,
    ) -> Pin<Box<dyn Future<Output = bool> + 'a>> {
        Box::pin(async move {
            let Self { request, answer } = *self;
            let outcome = changed(request, db, register).await;
            let usable = !matches!(&outcome, Err(fault) if fault.is_crash());
            // The requester may be gone; the change is kept.
            if let Err(Err(fault)) = answer.send(outcome) {
                tracing::debug!(%fault, "not written down");
            }
            usable
        })
    }
}

/// Writes until the last handle is gone.
async fn write(
    mut db: SqliteConnection,
    folder: PathBuf,
    mut asked: mpsc::Receiver<Box<dyn Job>>,
    register: Arc<Register>,
    duty: Duty,
) {
    while let Some(job) = asked.recv().await {
        let _busy = duty.busy();
        // When the disk is full or fails, SQLite rolls a transaction back on its own; the rollback by sqlx then fails, and
        // sqlx still counts the transaction as open: no other could begin on this connection.
        if db.is_in_transaction() {
            match db::open(&folder).await {
                Ok(fresh) => db = fresh,
                Err(fault) => tracing::error!(%fault, "app.db cannot be opened again"),
            }
        }
        if !job.run(&mut db, &register).await {
            // The duty is dropped unfinished: the program ends, and its service restarts it.
            return;
        }
    }
    db.close().await.ok();
    duty.done();
}

async fn changed<R: Request>(
    request: R,
    db: &mut SqliteConnection,
    register: &Register,
) -> Result<R::Answer, Fault> {
    let done = within_transaction(db, request).await?;
    let mut moment = db.begin().await?;
    let caught_up = register.catch_up(&mut moment).await;
    // Ended explicitly, as dropping only queues the rollback: at the next request the connection would still seem to be in
    // a transaction, and be discarded for no reason.
    moment.rollback().await?;
    caught_up?;
    Ok(done)
}

/// Carries `request` out in a transaction that is committed only when it succeeds.
///
/// # Errors
/// As the request.
pub async fn within_transaction<R: Request>(
    db: &mut SqliteConnection,
    request: R,
) -> Result<R::Answer, Fault> {
    let mut transaction = db.begin_with("BEGIN IMMEDIATE").await?;
    let outcome = match request.run(&mut transaction).await {
        Ok(answer) => transaction.commit().await.map(|()| answer).map_err(Fault::from),
        Err(fault) => {
            transaction.rollback().await.ok();
            Err(fault)
        }
    };
    if outcome.is_err() {
        // Once it answers, queued work such as a rollback is done.
        db.ping().await.ok();
    }
    outcome
}

#[cfg(test)]
pub(super) mod tests;
