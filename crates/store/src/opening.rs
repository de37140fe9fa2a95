//! Opens a database for reading: beside its writer, where nothing may be written, and while the file itself is replaced.

use rusqlite::{Connection, ErrorCode, OpenFlags};
use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::path::Path;

/// Which file has a name, whatever name it gets later.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct FileId {
    device: u64,
    inode: u64,
}

impl FileId {
    /// The file that has a name now, if any has.
    pub(crate) fn of(path: &Path) -> Option<Self> {
        let file = fs::metadata(path).ok()?;
        Some(Self { device: file.dev(), inode: file.ino() })
    }
}

/// Reading beside a writer takes files beside the database. In a folder that cannot be written they cannot be made, nor
/// by a writer: there the database is read as it stands.
///
/// A month can get another file while it is opened: `months` waits for all that have the old one open, and who waits for that in turn
/// opens the new one.
pub(crate) fn connect(path: &Path) -> rusqlite::Result<(Connection, FileId)> {
    loop {
        let before = FileId::of(path);
        let connection = connect_once(path)?;
        if let Some(file) = FileId::of(path).filter(|file| before == Some(*file)) {
            return Ok((connection, file));
        }
    }
}

/// Makes a database one with a log, where it is not.
pub(crate) fn keep_log(path: &Path) -> rusqlite::Result<()> {
    // A name that has no file gets none.
    let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = Connection::open_with_flags(path, flags)?;
    if has_log(&connection)? { Ok(()) } else { connection.execute_batch("PRAGMA journal_mode = WAL") }
}

/// Whether a database is one with a log. All months are, but one whose compression was broken off at its very end.
pub(crate) fn has_log(connection: &Connection) -> rusqlite::Result<bool> {
    connection.query_row("PRAGMA journal_mode", (), |row| Ok(row.get_ref(0)?.as_str()? == "wal"))
}

fn connect_once(path: &Path) -> rusqlite::Result<Connection> {
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let probe = |connection: Connection| {
        connection.query_row("PRAGMA schema_version", (), |_| Ok(()))?;
        Ok(connection)
    };
    let failed = match Connection::open_with_flags(path, flags).and_then(probe) {
        Err(rusqlite::Error::SqliteFailure(failed, _))
            if matches!(failed.code, ErrorCode::CannotOpen | ErrorCode::ReadOnly) =>
        {
            failed
        }
        other => return other,
    };
    let told = |text: String| Err(rusqlite::Error::SqliteFailure(failed, Some(text)));
    if let Err(error) = fs::File::open(path) {
        return told(format!("{error}; let the user who runs this read it"));
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    if rustix::fs::access(folder, rustix::fs::Access::WRITE_OK).is_ok() {
        return told(failed.to_string());
    }
    let mut beside = path.to_owned().into_os_string();
    beside.push("-wal");
    if fs::metadata(&beside).is_ok_and(|file| file.len() > 0) {
        return told(format!(
            "{} holds more, and its folder cannot be written: copy the data folder to where it can",
            Path::new(&beside).display()
        ));
    }
    let Some(text) = path.to_str() else { return told("its path is not UTF-8".to_owned()) };
    let quoted = text.replace('%', "%25").replace('?', "%3f").replace('#', "%23");
    let uri = format!("file:{quoted}?immutable=1");
    Connection::open_with_flags(uri, flags | OpenFlags::SQLITE_OPEN_URI).and_then(probe)
}
