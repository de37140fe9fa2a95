//! Errors of a chart set, grouped by remedy.

use charts::depth_index::BuildError;
use charts::s57::S57Error;
use std::io;
use std::path::{Path, PathBuf};

/// Why something could not be done with a chart set.
#[derive(Debug, thiserror::Error)]
pub enum ChartDbError {
    /// A file or folder could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A database could not be read or written.
    #[error("{}: {source}", path.display())]
    Sqlite {
        /// The database's file.
        path: PathBuf,
        /// What SQLite says.
        source: rusqlite::Error,
    },
    /// A cell or update is damaged or does not fit; the message has file, record and remedy.
    #[error(transparent)]
    Cell(#[from] S57Error),
    /// No index can be made of the charts.
    #[error(transparent)]
    Build(#[from] BuildError),
    /// Something else is wrong with a file; the text has place and remedy.
    #[error("{file}: {problem}")]
    File {
        /// The file.
        file: String,
        /// What is wrong and what to do.
        problem: String,
    },
    /// There is no chart set yet.
    #[error("{}: there is no chart set; make one by `lutra-server chart import`", .0.display())]
    Absent(PathBuf),
    /// The file is not a chart set of Lutra's.
    #[error("{}: this is not a chart set of Lutra; give another file by --db, or import into a new one", .0.display())]
    Foreign(PathBuf),
    /// The chart set was written by a later version.
    #[error("{}: written by a later version of Lutra; use that one, or import the charts into a new file", .0.display())]
    Newer(PathBuf),
    /// The chart set was written by an earlier version, in a form that this one does not read.
    #[error(
        "{}: written by an earlier version of Lutra, in a form that this one does not read; give another file by --db or \
         charts.set and import the charts into it by `lutra-server chart import`, or use that version", .0.display()
    )]
    Older(PathBuf),
    /// The database's contents differ from what was written.
    #[error("{}: {problem}; remove the chart {chart} and import it again", path.display())]
    Damaged {
        /// The database.
        path: PathBuf,
        /// The chart in it.
        chart: String,
        /// What is wrong.
        problem: String,
    },
    /// Another process changes the chart set.
    #[error("{} is being changed by another process; wait for it to end and try again", .0.display())]
    Locked(PathBuf),
    /// A program holds the database open for writing.
    #[error(
        "{} is open for writing in another program (QGIS?); close it there and import again: \
         what was read is kept", .0.display()
    )]
    Busy(PathBuf),
    /// No such chart.
    #[error("the chart set holds no {name}; it holds {held}")]
    Unknown {
        /// What was asked for.
        name: String,
        /// What exists.
        held: String,
    },
    /// The caller asked to stop.
    #[error("stopped on request; the chart set is as it was, and importing again goes on where this stopped")]
    Cancelled,
}

/// Result of this crate's functions.
pub type Result<T, E = ChartDbError> = std::result::Result<T, E>;

impl ChartDbError {
    /// Whether another program uses the set at present, so that a later try may succeed.
    pub fn is_busy(&self) -> bool {
        let Self::Sqlite { source, .. } = self else {
            return matches!(self, Self::Busy(_) | Self::Locked(_));
        };
        // An import that was killed; the next program that opens the set for writing rolls it back.
        if source
            .sqlite_error()
            .is_some_and(|error| error.extended_code == rusqlite::ffi::SQLITE_READONLY_ROLLBACK)
        {
            return true;
        }
        let code = source.sqlite_error_code();
        matches!(code, Some(rusqlite::ErrorCode::DatabaseBusy | rusqlite::ErrorCode::DatabaseLocked))
    }

    pub(crate) fn file(file: impl Into<String>, problem: impl Into<String>) -> Self {
        Self::File { file: file.into(), problem: problem.into() }
    }
}

/// Puts the name of a file to an error.
pub(crate) trait Named<T> {
    /// The same with the name.
    fn named(self, path: &Path) -> Result<T>;
}

impl<T> Named<T> for io::Result<T> {
    fn named(self, path: &Path) -> Result<T> {
        self.map_err(|source| ChartDbError::Io { path: path.to_owned(), source })
    }
}

impl<T> Named<T> for rusqlite::Result<T> {
    fn named(self, path: &Path) -> Result<T> {
        self.map_err(|source| match source.sqlite_error_code() {
            Some(rusqlite::ErrorCode::NotADatabase) => ChartDbError::Foreign(path.to_owned()),
            _ => ChartDbError::Sqlite { path: path.to_owned(), source },
        })
    }
}
