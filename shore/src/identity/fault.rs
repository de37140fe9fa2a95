//! Errors of app.db.

use api::Said;
use thiserror::Error;

/// An error of the database.
#[derive(Debug, Error)]
pub enum Fault {
    /// The request is refused; the text is for the requester.
    #[error("{0}")]
    Refused(Said),
    /// SQLite failed.
    #[error("app.db: {}; check the disk and the folder's rights", words(.0))]
    Sqlite(#[source] sqlx::Error),
    /// The file is of a later version.
    #[error(
        "app.db was written by a newer lutra-server (schema {found}, this one knows {known}): nothing was changed. Install \
         that version again, or one after it; this one can only use a backup from before the upgrade"
    )]
    Newer {
        /// Migrations applied to the file.
        found: i64,
        /// Migrations this program knows.
        known: i64,
    },
    /// The schema cannot be brought up to date, and stays as it was.
    #[error("app.db cannot be brought up to date: {0}. Nothing was changed; {remedy}", remedy = remedy(.0))]
    Schema(#[from] sqlx::migrate::MigrateError),
    /// The data folder cannot be used.
    #[error("data folder {0}: {1}; make it writable or choose another by --data DIR")]
    Folder(String, std::io::Error),
    /// A token that is not valid yet; the text says why.
    #[error("{0}")]
    NotYet(Said),
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

impl From<sqlx::Error> for Fault {
    fn from(error: sqlx::Error) -> Self {
        // No reading connection became free in time.
        if matches!(error, sqlx::Error::PoolTimedOut) { Self::Hangs } else { Self::Sqlite(error) }
    }
}

impl Fault {
    /// What was asked cannot be, for this reason.
    pub fn refused(why: impl Into<Said>) -> Self {
        Self::Refused(why.into())
    }

    /// Refuses a change that changed no row.
    pub(crate) fn unless_changed(
        done: &sqlx::sqlite::SqliteQueryResult,
        text: impl Into<Said>,
    ) -> Result<(), Self> {
        if done.rows_affected() > 0 { Ok(()) } else { Err(Self::refused(text)) }
    }

    /// Whether the connection is gone for good: SQLite's thread behind it was lost.
    pub(super) fn is_crash(&self) -> bool {
        matches!(self, Self::Sqlite(sqlx::Error::WorkerCrashed))
    }
}

/// SQLite's message, if there is one.
fn words(error: &sqlx::Error) -> String {
    error.as_database_error().map_or_else(|| error.to_string(), |own| own.message().to_owned())
}

fn remedy(error: &sqlx::migrate::MigrateError) -> &'static str {
    use sqlx::migrate::MigrateError::{VersionMismatch, VersionMissing};
    if matches!(error, VersionMismatch(_) | VersionMissing(_)) {
        "its schema was made by another lutra-server: use that one, or put a backup in its place"
    } else {
        "check the disk and the folder's rights"
    }
}
