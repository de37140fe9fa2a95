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
    // A disk that is slow is told by `owners`, and no line of a log should hold a statement.
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
/// It is one, or cannot be read.
pub fn refuse_newer(folder: &Path) -> Result<(), Fault> {
    let path = folder.join("app.db");
    let named = |error| Fault::Folder(folder.display().to_string(), error);
    let known = MIGRATIONS.iter().map(|one| one.version).max().unwrap_or_default();
    match super::version::of(&path).map_err(named)? {
        Some(found) if found > known => Err(Fault::Newer { found, known }),
        _ => Ok(()),
    }
}

/// Makes an empty file that only its owner may read, before SQLite gives its log the same rights.
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

/// What SQLite says of the whole file: `ok`, or what is damaged.
///
/// # Errors
/// It cannot be read.
pub async fn check(db: &mut SqliteConnection) -> Result<String, Fault> {
    Ok(sqlx::query_scalar("PRAGMA quick_check").fetch_one(db).await?)
}

/// Brings the schema up to date, all or nothing; of two programs that open the file at once, one does. A file that is up
/// to date is only read, and waits for no writer.
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
        // Made before checksums were kept: the number alone says which migrations it has seen.
        MIGRATIONS.run_direct(Some(version), &mut *transaction, true).await?;
    }
    MIGRATIONS.run_direct(None, &mut *transaction, false).await?;
    // By this number programs that keep no checksums know that the file is newer than they are.
    let mark = AssertSqlSafe(format!("PRAGMA user_version = {known}"));
    sqlx::query(mark).execute(&mut *transaction).await?;
    transaction.commit().await?;
    Ok(())
}

/// Which migrations the file has seen: by its number, and by what is noted with checksums, if anything is.
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

/// Opens `app.db` in `folder`, does `work` with it and closes it, so that all of it is in one file again where no server uses
/// it: for the command line.
///
/// # Errors
/// What `work` says, or as [`open`].
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

/// Waits for `work` by a runtime of its own: for threads that may wait.
///
/// # Errors
/// What `work` says, or that there is no runtime to be had.
pub(crate) fn wait<R>(work: impl Future<Output = Result<R, Fault>>) -> Result<R, Fault> {
    let runtime = tokio::runtime::Builder::new_current_thread().enable_time().build();
    runtime.map_err(|error| Fault::Folder("app.db".to_owned(), error))?.block_on(work)
}

#[cfg(test)]
pub(crate) mod tests;
