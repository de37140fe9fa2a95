//! Reads the last applied migration of app.db without opening it as a database, which would create files beside it.

use std::fs::{self, File};
use std::io::{self, Read as _};
use std::path::Path;

/// SQLite's file format: the magic bytes of a database, and the offset of `user_version` in its header.
const MAGIC: &[u8; 16] = b"SQLite format 3\0";
const USER_VERSION: std::ops::Range<usize> = 60..64;
const HEADER_BYTES: usize = 100;
/// Bytes of a log's header, and of a frame's header.
const LOG_HEADER_BYTES: usize = 32;
const FRAME_HEADER_BYTES: usize = 24;

/// The number of the newest migration, from the log if it is there, else from the file; `None` if there is no database.
///
/// # Errors
/// One of them cannot be read.
pub(super) fn of(path: &Path) -> io::Result<Option<i64>> {
    let Some(whole) = in_file(path)? else { return Ok(None) };
    let logged = in_log(Path::new(&format!("{}-wal", path.display())))?;
    Ok(Some(logged.unwrap_or(whole)))
}

fn in_file(path: &Path) -> io::Result<Option<i64>> {
    let mut head = Vec::with_capacity(HEADER_BYTES);
    match File::open(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        file => file?.take(HEADER_BYTES as u64).read_to_end(&mut head)?,
    };
    Ok(user_version(&head))
}

/// The number in the write-ahead log, if it is not in the file yet. A log has some MiB at most.
fn in_log(path: &Path) -> io::Result<Option<i64>> {
    let log = match fs::read(path) {
        Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(None),
        log => log?,
    };
    let Some(page_bytes) = number(&log, 8).filter(|bytes| *bytes >= 512) else { return Ok(None) };
    let frames = log.get(LOG_HEADER_BYTES..).unwrap_or_default();
    // Old frames from before the log was restarted have another salt.
    let first_pages = frames
        .chunks_exact(FRAME_HEADER_BYTES + page_bytes as usize)
        .take_while(|frame| frame[8..16] == log[16..24])
        .filter(|frame| number(frame, 0) == Some(1))
        .filter_map(|frame| user_version(&frame[FRAME_HEADER_BYTES..]));
    Ok(first_pages.last())
}

fn user_version(page: &[u8]) -> Option<i64> {
    page.starts_with(MAGIC).then(|| number(page, USER_VERSION.start).map(i64::from)).flatten()
}

fn number(bytes: &[u8], at: usize) -> Option<u32> {
    bytes.get(at..at + 4)?.try_into().ok().map(u32::from_be_bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_number_is_read_from_the_file_and_from_its_log() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("app.db");
        assert_eq!(of(&path).unwrap(), None);
        fs::write(&path, "no database").unwrap();
        assert_eq!(of(&path).unwrap(), None);
        fs::remove_file(&path).unwrap();
        let db = rusqlite::Connection::open(&path).unwrap();
        db.execute_batch("PRAGMA journal_mode = WAL; CREATE TABLE a (b); PRAGMA user_version = 7;").unwrap();
        assert_eq!(of(&path).unwrap(), Some(7), "it is in the log alone");
        db.execute_batch("PRAGMA wal_checkpoint(TRUNCATE)").unwrap();
        assert_eq!(of(&path).unwrap(), Some(7));
        db.execute_batch("PRAGMA user_version = 12").unwrap();
        assert_eq!(of(&path).unwrap(), Some(12));
        db.execute_batch("PRAGMA user_version = 11").unwrap();
        assert_eq!(of(&path).unwrap(), Some(11), "the newest counts");
        // A torn log is ignored.
        fs::write(folder.path().join("app.db-wal"), [0xFF; 37]).unwrap();
        assert_eq!(of(&path).unwrap(), Some(7));
    }
}
