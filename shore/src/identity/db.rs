//! `app.db`: opening, migrating, and the thread that owns it while a server runs.

use super::register::Register;
use crate::owners::Owners;
use rusqlite::Connection;
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;
use thiserror::Error;
use tokio::sync::{mpsc, oneshot};

/// Migrations in order; the database remembers how many it has seen. Only ever appended to.
const MIGRATIONS: [&str; 4] = [
    include_str!("../../../migrations/0001_people.sql"),
    include_str!("../../../migrations/0002_plans.sql"),
    include_str!("../../../migrations/0003_alarms.sql"),
    include_str!("../../../migrations/0004_register.sql"),
];
/// How many there are.
const KNOWN: u32 = MIGRATIONS.len() as u32;
/// Questions that may wait for the thread; askers wait, asynchronously, when there are more.
const WAITING: usize = 256;

/// Why the database did not do what was asked.
#[derive(Debug, Error)]
pub enum Fault {
    /// What was asked cannot be; the text says why and is meant for the one who asked.
    #[error("{0}")]
    Refused(String),
    /// SQLite failed.
    #[error("app.db: {0}; check the disk and the folder's rights")]
    Sqlite(#[from] rusqlite::Error),
    /// The file is of a later version.
    #[error(
        "app.db was written by a newer lutra-server (schema {found}, this one knows {known}): update this one"
    )]
    Newer {
        /// Migrations the file has seen.
        found: u32,
        /// Migrations this program knows.
        known: u32,
    },
    /// The data folder cannot be used.
    #[error("data folder {0}: {1}; make it writable or choose another by --data DIR")]
    Folder(String, std::io::Error),
    /// A token that opens nothing yet; the text says why.
    #[error("{0}")]
    NotYet(String),
    /// It does not answer.
    #[error(
        "app.db does not answer: does its disk hang, or has another program locked it? What was asked may be done once it \
         answers: look before asking again"
    )]
    Hangs,
    /// Too many passwords wait to be hashed.
    #[error("too many passwords are looked at: try again in some seconds")]
    Busy,
    /// The server is stopping.
    #[error("the server is stopping")]
    Stopped,
}

/// Opens `app.db` in `folder`, making both when absent, and brings it up to date.
///
/// # Errors
/// Folder or file cannot be used, or the file is of a later version.
pub fn open(folder: &Path) -> Result<Connection, Fault> {
    let named = |error| Fault::Folder(folder.display().to_string(), error);
    std::fs::create_dir_all(folder).map_err(named)?;
    let path = folder.join("app.db");
    let fresh = !path.exists();
    let mut connection = Connection::open(&path)?;
    if fresh {
        use std::os::unix::fs::PermissionsExt as _;
        std::fs::set_permissions(&path, std::fs::Permissions::from_mode(0o600)).map_err(named)?;
    }
    connection.busy_timeout(Duration::from_secs(5))?;
    connection.pragma_update(None, "journal_mode", "WAL")?;
    connection.pragma_update(None, "synchronous", "FULL")?;
    connection.pragma_update(None, "foreign_keys", true)?;
    migrate(&mut connection)?;
    Ok(connection)
}

/// Copies app.db into another folder, also while a server uses it. The copy appears whole or not at all.
///
/// # Errors
/// The database cannot be read, the folder not be written.
pub fn backup(folder: &Path, to: &Path) -> Result<(), Fault> {
    use std::os::unix::fs::PermissionsExt as _;
    let named = |error| Fault::Folder(to.display().to_string(), error);
    if !folder.join("app.db").exists() {
        return Ok(());
    }
    let part = to.join("app.db.part");
    std::fs::write(&part, []).map_err(named)?;
    std::fs::set_permissions(&part, std::fs::Permissions::from_mode(0o600)).map_err(named)?;
    open(folder)?.backup("main", &part, None)?;
    std::fs::rename(&part, to.join("app.db")).map_err(named)?;
    Ok(())
}

fn migrate(connection: &mut Connection) -> Result<(), Fault> {
    let transaction = connection.transaction_with_behavior(rusqlite::TransactionBehavior::Immediate)?;
    let found: u32 = transaction.pragma_query_value(None, "user_version", |row| row.get(0))?;
    if found > KNOWN {
        return Err(Fault::Newer { found, known: KNOWN });
    }
    for migration in MIGRATIONS.iter().skip(found as usize) {
        transaction.execute_batch(migration)?;
    }
    transaction.pragma_update(None, "user_version", KNOWN)?;
    transaction.commit()?;
    Ok(())
}

type Question = Box<dyn FnOnce(&mut Connection) + Send>;

/// The thread that owns the connection; ends when the last handle is gone.
#[derive(Debug, Clone)]
pub struct Db {
    questions: mpsc::Sender<Question>,
    register: Arc<Register>,
}

impl Db {
    /// Hands `connection` to a thread of its own, which brings `register` up to date after each change.
    ///
    /// # Errors
    /// There is no thread to be had.
    pub fn start(
        mut connection: Connection,
        register: Arc<Register>,
        owners: &Owners,
    ) -> std::io::Result<Self> {
        let (questions, mut asked) = mpsc::channel::<Question>(WAITING);
        let duty = owners.duty("app.db");
        std::thread::Builder::new().name("app.db".to_owned()).spawn(move || {
            while let Some(question) = asked.blocking_recv() {
                let _busy = duty.busy();
                question(&mut connection);
            }
            duty.done();
        })?;
        Ok(Self { questions, register })
    }

    /// Runs `work`, which changes nothing about who may come in, there some time, if anything can be changed at all.
    /// Nobody waits for it.
    pub fn change_some_time(&self, work: impl FnOnce(&Connection) -> Result<(), Fault> + Send + 'static) {
        let question: Question = Box::new(move |connection| {
            if let Err(fault) = within_transaction(connection, work) {
                tracing::debug!(%fault, "not written down");
            }
        });
        // Too much waits: it is offered again.
        self.questions.try_send(question).ok();
    }

    /// Brings the register up to date, if another program changed app.db.
    ///
    /// # Errors
    /// It cannot be read.
    pub async fn catch_up(&self) -> Result<(), Fault> {
        let register = Arc::clone(&self.register);
        self.ask(move |connection| register.catch_up(connection)).await
    }

    /// Runs `work`, which only reads, there.
    ///
    /// # Errors
    /// What `work` says, or that the server is stopping.
    pub async fn ask<R: Send + 'static>(
        &self,
        work: impl FnOnce(&Connection) -> Result<R, Fault> + Send + 'static,
    ) -> Result<R, Fault> {
        self.run(|connection| work(connection)).await
    }

    /// Runs `work` there, in a transaction that is kept only when it succeeds.
    ///
    /// # Errors
    /// What `work` says, or that the server is stopping.
    pub async fn change<R: Send + 'static>(
        &self,
        work: impl FnOnce(&Connection) -> Result<R, Fault> + Send + 'static,
    ) -> Result<R, Fault> {
        let register = Arc::clone(&self.register);
        self.run(move |connection| {
            let done = within_transaction(connection, work)?;
            // What was changed holds from the answer on.
            register.catch_up(connection)?;
            Ok(done)
        })
        .await
    }

    async fn run<R: Send + 'static>(
        &self,
        work: impl FnOnce(&mut Connection) -> Result<R, Fault> + Send + 'static,
    ) -> Result<R, Fault> {
        let (answer, answered) = oneshot::channel();
        let question: Question = Box::new(move |connection| {
            // Whoever asked may be gone; what was done stays done.
            answer.send(work(connection)).ok();
        });
        self.questions.send(question).await.map_err(|_| Fault::Stopped)?;
        answered.await.map_err(|_| Fault::Stopped)?
    }
}

/// Runs `work` in a transaction that is kept only when it succeeds.
pub fn within_transaction<R>(
    connection: &mut Connection,
    work: impl FnOnce(&Connection) -> Result<R, Fault>,
) -> Result<R, Fault> {
    let transaction = connection.transaction_with_behavior(rusqlite::TransactionBehavior::Immediate)?;
    let outcome = work(&transaction)?;
    transaction.commit()?;
    Ok(outcome)
}

#[cfg(test)]
pub(crate) mod tests {
    use super::*;

    /// A fresh database in memory.
    pub(crate) fn fresh() -> Connection {
        let mut connection = Connection::open_in_memory().unwrap();
        connection.pragma_update(None, "foreign_keys", true).unwrap();
        migrate(&mut connection).unwrap();
        connection
    }

    #[test]
    fn migrating_twice_changes_nothing() {
        let folder = tempfile::tempdir().unwrap();
        drop(open(folder.path()).unwrap());
        let connection = open(folder.path()).unwrap();
        let tables: i64 = connection
            .query_row("SELECT count(*) FROM sqlite_schema WHERE type = 'table'", [], |row| row.get(0))
            .unwrap();
        assert!(tables >= 7);
    }

    #[test]
    fn a_newer_file_is_refused_with_the_remedy() {
        let folder = tempfile::tempdir().unwrap();
        open(folder.path()).unwrap().pragma_update(None, "user_version", 99).unwrap();
        assert!(open(folder.path()).unwrap_err().to_string().contains("update this one"));
    }

    #[test]
    fn strangers_on_the_machine_cannot_read_it() {
        use std::os::unix::fs::PermissionsExt as _;
        let folder = tempfile::tempdir().unwrap();
        open(folder.path()).unwrap();
        let mode = std::fs::metadata(folder.path().join("app.db")).unwrap().permissions().mode();
        assert_eq!(mode & 0o077, 0);
    }

    #[tokio::test]
    async fn failed_work_leaves_nothing_behind() {
        let owners = Owners::new(crate::clock::Clock::real());
        let db = Db::start(fresh(), Arc::default(), &owners).unwrap();
        let add =
            |db: &Connection| db.execute("INSERT INTO vessel VALUES (1, 'a', 0)", []).map_err(Fault::from);
        let failed: Result<(), Fault> =
            db.change(move |db| add(db).and(Err(Fault::Refused("no".to_owned())))).await;
        assert!(failed.is_err());
        assert_eq!(db.change(add).await.unwrap(), 1);
    }
}
