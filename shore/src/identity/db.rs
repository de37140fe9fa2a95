//! `app.db`: opening it, bringing its schema up to date, copying it.

use super::fault::Fault;
use sqlx::migrate::Migrator;
use sqlx::sqlite::{SqliteConnectOptions, SqliteJournalMode, SqliteSynchronous};
use sqlx::{AssertSqlSafe, ConnectOptions as _, Connection as _, SqliteConnection};
use std::path::Path;
use std::time::Duration;

/// Migrations in order, each with its checksum. Only ever appended to.
static MIGRATIONS: Migrator = sqlx::migrate!("../migrations");
/// How long a connection waits for another program that writes.
const BUSY: Duration = Duration::from_secs(5);

/// How `app.db` in `folder` is opened, for reading and writing.
pub(super) fn options(folder: &Path) -> SqliteConnectOptions {
    let options = SqliteConnectOptions::new().filename(folder.join("app.db"));
    // A slow disk is reported by `owners`, and statements should not appear in the log.
    options.busy_timeout(BUSY).foreign_keys(true).disable_statement_logging()
}

/// Opens `app.db` in `folder`, making both when absent, and brings it up to date.
///
/// # Errors
/// Folder or file cannot be used, or the file is of a later version.
pub async fn open(folder: &Path) -> Result<SqliteConnection, Fault> {
    let named = |error| Fault::Folder(folder.display().to_string(), error);
    std::fs::create_dir_all(folder).map_err(named)?;
    let path = folder.join("app.db");
    if !path.exists() {
        make_private(&path).map_err(named)?;
    }
    refuse_newer(folder)?;
    let options = options(folder).journal_mode(SqliteJournalMode::Wal).synchronous(SqliteSynchronous::Full);
    let mut db = options.connect().await?;
    migrate(&mut db).await?;
    Ok(db)
}

/// Refuses an `app.db` of a later version; reads, and writes nothing.
///
/// # Errors
/// It is such a file, or cannot be read.
pub fn refuse_newer(folder: &Path) -> Result<(), Fault> {
    let path = folder.join("app.db");
    let named = |error| Fault::Folder(folder.display().to_string(), error);
    let known = MIGRATIONS.iter().map(|one| one.version).max().unwrap_or_default();
    match super::version::of(&path).map_err(named)? {
        Some(found) if found > known => Err(Fault::Newer { found, known }),
        _ => Ok(()),
    }
}

/// Makes an empty file that only its owner may read: SQLite gives its log the same permissions.
fn make_private(path: &Path) -> std::io::Result<()> {
    use std::os::unix::fs::{OpenOptionsExt as _, PermissionsExt as _};
    let file = std::fs::OpenOptions::new().create(true).append(true).mode(0o600).open(path)?;
    file.set_permissions(std::fs::Permissions::from_mode(0o600))
}

/// Copies app.db to a new file, also while a server uses it.
///
/// # Errors
/// The database cannot be read, the file not be written.
pub async fn backup(folder: &Path, to: &Path) -> Result<(), Fault> {
    make_private(to).map_err(|error| Fault::Folder(to.display().to_string(), error))?;
    // One read transaction; the server may write meanwhile.
    let mut db = open(folder).await?;
    sqlx::query("VACUUM INTO ?1").bind(to.to_string_lossy().as_ref()).execute(&mut db).await?;
    db.close().await?;
    Ok(())
}

/// SQLite's integrity check of the whole file: `ok`, or what is damaged.
///
/// # Errors
/// It cannot be read.
pub async fn check(db: &mut SqliteConnection) -> Result<String, Fault> {
    Ok(sqlx::query_scalar("PRAGMA quick_check").fetch_one(db).await?)
}

/// Brings the schema up to date, all or nothing; if two programs open the file at once, one of them does it. An up-to-date
/// file is only read, which waits for no writer.
async fn migrate(db: &mut SqliteConnection) -> Result<(), Fault> {
    let known = MIGRATIONS.iter().map(|one| one.version).max().unwrap_or_default();
    if seen(db).await? == (known, Some(known)) {
        return Ok(MIGRATIONS.run_direct(None, db, false).await?);
    }
    let mut transaction = db.begin_with("BEGIN IMMEDIATE").await?;
    let (version, noted) = seen(&mut transaction).await?;
    let found = noted.unwrap_or_default().max(version);
    if found > known {
        return Err(Fault::Newer { found, known });
    }
    if noted.is_none() && version > 0 {
        // Made before checksums were stored: only the number tells which migrations were applied.
        MIGRATIONS.run_direct(Some(version), &mut *transaction, true).await?;
    }
    MIGRATIONS.run_direct(None, &mut *transaction, false).await?;
    // Older programs without checksums recognise a newer file by this number.
    let mark = AssertSqlSafe(format!("PRAGMA user_version = {known}"));
    sqlx::query(mark).execute(&mut *transaction).await?;
    transaction.commit().await?;
    Ok(())
}

/// The last applied migration: by the file's number, and by the table of checksums, if there is one.
async fn seen(db: &mut SqliteConnection) -> Result<(i64, Option<i64>), Fault> {
    let version = sqlx::query_scalar("PRAGMA user_version").fetch_one(&mut *db).await?;
    let sql = "SELECT count(*) FROM sqlite_schema WHERE type = 'table' AND name = '_sqlx_migrations'";
    let tables: i64 = sqlx::query_scalar(sql).fetch_one(&mut *db).await?;
    if tables == 0 {
        return Ok((version, None));
    }
    let sql = "SELECT max(version) FROM _sqlx_migrations";
    Ok((version, sqlx::query_scalar(sql).fetch_one(db).await?))
}

/// For the command line: opens `app.db` in `folder`, runs `work` and closes it, so that all data are in one file again if
/// no server uses it.
///
/// # Errors
/// As `work`, or as [`open`].
pub fn with<R>(
    folder: &Path,
    work: impl AsyncFnOnce(&mut SqliteConnection) -> Result<R, Fault>,
) -> Result<R, Fault> {
    wait(async {
        let mut db = open(folder).await?;
        let done = work(&mut db).await;
        db.close().await?;
        done
    })
}

/// Runs `work` to its end on its own runtime, for threads that may block.
///
/// # Errors
/// As `work`, or no runtime can be created.
pub(crate) fn wait<R>(work: impl Future<Output = Result<R, Fault>>) -> Result<R, Fault> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build();
    runtime.map_err(|error| Fault::Folder("app.db".to_owned(), error))?.block_on(work)
}

#[cfg(test)]
pub(crate) mod tests;
