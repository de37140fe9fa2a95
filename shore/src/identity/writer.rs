//! Who reads and who writes app.db while a server runs.
//!
//! One thread owns the only connection that writes: requests reach it one after another over a queue of [`WAITING`],
//! and who asks waits, asynchronously, when it is full. [`READERS`] connections read beside it and never wait for the
//! disk to take what is written: in SQLite's write-ahead log every reader sees what stood when it began.

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
/// How long a question waits for one of them.
const PATIENCE: Duration = Duration::from_secs(10);

/// The ways to app.db; the thread that writes ends when the last of them is gone. Cheap to clone.
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
    /// There is no thread to be had.
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
            // What a failed disk left of a transaction would show this one's moment to all who come after.
            .before_acquire(|connection, _| Box::pin(async move { Ok(!connection.is_in_transaction()) }))
            .connect_lazy_with(db::options(folder).read_only(true));
        Ok(Self { jobs, readers, register })
    }

    /// Answers a question that only reads, beside whatever is written.
    ///
    /// # Errors
    /// What the request says, or that no connection is free.
    pub(super) async fn ask<R: Request>(&self, request: R) -> Result<R::Answer, Fault> {
        let mut moment = self.readers.begin().await?;
        let answer = request.run(&mut moment).await?;
        moment.commit().await?;
        Ok(answer)
    }

    /// Carries `request` out in a transaction that is kept only when it succeeds. What was changed about who may come in
    /// holds from the answer on.
    ///
    /// # Errors
    /// What the request says, or that the server is stopping.
    pub(super) async fn change<R: Request>(&self, request: R) -> Result<R::Answer, Fault> {
        let (answer, answered) = oneshot::channel();
        let job = Box::new(Asked { request, answer });
        self.jobs.send(job).await.map_err(|_| Fault::Stopped)?;
        answered.await.map_err(|_| Fault::Stopped)?
    }

    /// Carries `request` out some time, if there is room for it in the queue. Nobody waits for it.
    pub(super) fn change_some_time<R: Request>(&self, request: R) {
        // Too much waits: it is offered again.
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

/// A request on its way to the thread that writes.
trait Job: Send {
    /// Carries it out and answers; whether the connection can be used further.
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
            // Whoever asked may be gone; what was done stays done.
            if let Err(Err(fault)) = answer.send(outcome) {
                tracing::debug!(%fault, "not written down");
            }
            usable
        })
    }
}

/// Writes until nobody can ask for it any more.
async fn write(
    mut db: SqliteConnection,
    folder: PathBuf,
    mut asked: mpsc::Receiver<Box<dyn Job>>,
    register: Arc<Register>,
    duty: Duty,
) {
    while let Some(job) = asked.recv().await {
        let _busy = duty.busy();
        // When the disk is full or fails, SQLite undoes a transaction by itself, and sqlx, whose rollback of nothing fails,
        // goes on counting it: no other would begin on this connection.
        if db.is_in_transaction() {
            match db::open(&folder).await {
                Ok(fresh) => db = fresh,
                Err(fault) => tracing::error!(%fault, "app.db cannot be opened again"),
            }
        }
        if !job.run(&mut db, &register).await {
            // The duty is dropped undone: the program ends, and its service starts it again.
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
    // Ended here and not by being dropped, which only queues the end: the connection would still seem to be in it when
    // the next request comes, and be given up for no reason.
    moment.rollback().await?;
    caught_up?;
    Ok(done)
}

/// Carries `request` out in a transaction that is kept only when it succeeds.
///
/// # Errors
/// What the request says.
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
        // What was queued for the connection, such as the end of the transaction, is done when it answers.
        db.ping().await.ok();
    }
    outcome
}

#[cfg(test)]
pub(super) mod tests;
