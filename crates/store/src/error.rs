//! Errors of a store, grouped by remedy.

use crate::history::chunk;
use imc::FrameError;
use std::io;
use std::path::{Path, PathBuf};

/// Why the store could not do something.
#[derive(Debug, thiserror::Error)]
pub enum StoreError {
    /// A file or folder could not be read or written.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// What the system says.
        source: io::Error,
    },
    /// A database of the history could not be read or written.
    #[error("{}: {source}", path.display())]
    Sqlite {
        /// The database's file.
        path: PathBuf,
        /// What SQLite says.
        source: rusqlite::Error,
    },
    /// A database was written by a later version of this program.
    #[error("{} was written by a later version of Lutra; use that one, or rebuild the history by `reindex`", path.display())]
    Newer {
        /// The database's file.
        path: PathBuf,
    },
    /// A month was compressed by a trial version.
    #[error(
        "{} was compressed by an earlier trial version, which this one does not read: start the server, which keeps it in \
         history.aside and makes it again from the archive",
        path.display()
    )]
    Trial {
        /// The month's file.
        path: PathBuf,
    },
    /// The archive was written by a later version of this program, whose files this one would cut off as damaged.
    #[error(
        "{} was written by Lutra {program} (form {found}, this program knows {known}): nothing was changed. Install that \
         version again, or one after it; this one can only use a backup from before the upgrade",
        path.display()
    )]
    NewerArchive {
        /// The archive's folder.
        path: PathBuf,
        /// Its form.
        found: u64,
        /// The latest form that is known here.
        known: u64,
        /// The version that wrote it.
        program: String,
    },
    /// A compressed file of the archive does not hold what the plain file beside it holds. The longer one is in use.
    #[error(
        "{} ({packed_bytes} bytes when unpacked) does not hold the same as {} ({plain_bytes} bytes): both are kept, and the {} \
         one is in use. Check the disk, and compare both with a backup before you move the other one away",
        packed.display(), plain.display(), if packed_bytes >= plain_bytes { "compressed" } else { "plain" }
    )]
    Differs {
        /// The compressed file.
        packed: PathBuf,
        /// Bytes that it holds, unpacked.
        packed_bytes: u64,
        /// The plain file.
        plain: PathBuf,
        /// Its bytes.
        plain_bytes: u64,
    },
    /// There is no room to compress a day or a month.
    #[error(
        "{what} is not compressed: {} MiB of the disk are free, and {} are needed beside what is left to recording; make room",
        free >> 20, (needed >> 20) + 1
    )]
    NoRoom {
        /// The day or the month, below the data folder.
        what: String,
        /// Bytes that are free.
        free: u64,
        /// Bytes that must be free.
        needed: u64,
    },
    /// The history does not hold all of the archive yet, and what was asked for needs that.
    #[error("{0}; it can be done when that is over")]
    Behind(String),
    /// Another process writes to the folder.
    #[error("{} is in use by another process{}; stop it first, or choose another folder", path.display(), holder(.pid))]
    Locked {
        /// The folder.
        path: PathBuf,
        /// The process that holds it, as it noted itself; empty when it did not.
        pid: String,
    },
    /// A file that says how far the archive was carried says something else.
    #[error("{} does not say how far the archive was carried; remove it, and everything is carried again", path.display())]
    Place {
        /// The file.
        path: PathBuf,
    },
    /// The bytes are not a packet.
    #[error("no IMC packet: {0}")]
    Packet(#[from] FrameError),
    /// More bytes came than the packet has.
    #[error("{extra} bytes follow the packet; give one packet at a time")]
    Trailing {
        /// How many.
        extra: usize,
    },
    /// As much waits to be written as may.
    #[error("{waiting} bytes wait for the disk, which is the most; commit before accepting more")]
    Full {
        /// Bytes that wait.
        waiting: usize,
    },
    /// A question that has no answer as it was asked.
    #[error("{0}")]
    Query(String),
    /// The same by the caller of this crate while it makes the question, in words of its own kind.
    #[error("{0}")]
    Asked(Box<dyn std::error::Error + Send + Sync>),
    /// The caller asked to stop.
    #[error("stopped on request")]
    Cancelled,
}

/// Result of this crate's functions.
pub type Result<T, E = StoreError> = std::result::Result<T, E>;

fn holder(pid: &str) -> String {
    if pid.is_empty() { String::new() } else { format!(" (process {pid})") }
}

impl StoreError {
    /// The database of the history that is damaged, if that is what went wrong.
    pub(crate) fn damaged_database(&self) -> Option<&Path> {
        match self {
            Self::Sqlite { path, source } if is_damage(source) => Some(path),
            _ => None,
        }
    }

    /// The chunk of a compressed month that is damaged, if that is what went wrong.
    pub(crate) fn damaged_chunk(&self) -> Option<chunk::Place> {
        match self {
            Self::Sqlite { source, .. } => chunk::damaged(source),
            _ => None,
        }
    }

    /// Whether the disk is full or a limit on a file's size was reached: what was accepted still waits, and a
    /// later commit can succeed.
    pub fn is_disk_full(&self) -> bool {
        match self {
            Self::Io { source, .. } => matches!(
                source.kind(),
                io::ErrorKind::StorageFull | io::ErrorKind::QuotaExceeded | io::ErrorKind::FileTooLarge
            ),
            Self::Sqlite { source, .. } => source.sqlite_error_code() == Some(rusqlite::ErrorCode::DiskFull),
            _ => false,
        }
    }
}

/// Whether an error says that the file itself is damaged, so that a retry does not help.
pub(crate) fn is_damage(error: &rusqlite::Error) -> bool {
    matches!(
        error.sqlite_error_code(),
        Some(rusqlite::ErrorCode::DatabaseCorrupt | rusqlite::ErrorCode::NotADatabase)
    ) || chunk::damaged(error).is_some()
}

/// Puts the name of a file to an error.
pub(crate) trait Named<T> {
    /// The same with the name.
    fn named(self, path: &Path) -> Result<T>;
}

impl<T> Named<T> for io::Result<T> {
    fn named(self, path: &Path) -> Result<T> {
        self.map_err(|source| StoreError::Io { path: path.to_owned(), source })
    }
}

impl<T> Named<T> for rusqlite::Result<T> {
    fn named(self, path: &Path) -> Result<T> {
        self.map_err(|source| StoreError::Sqlite { path: path.to_owned(), source })
    }
}
