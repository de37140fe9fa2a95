//! The layout of a data folder, and the free space of its disk.

use crate::error::{Named as _, Result};
use std::fs;
use std::path::Path;

/// The archive.
pub(crate) const ARCHIVE: &str = "archive";
/// The history that is asked.
pub(crate) const HISTORY: &str = "history";
/// The one that grows.
pub(crate) const GROWING: &str = "history.new";
/// The one that was replaced.
pub(crate) const REPLACED: &str = "history.old";

/// See [`reserved_bytes`].
const RESERVED_BYTES: u64 = 512 << 20;

/// Bytes that can still be written to the disk of a folder.
///
/// # Errors
/// When there is no such folder, or the system does not say.
pub fn free_bytes(folder: &Path) -> Result<u64> {
    let disk = rustix::fs::statvfs(folder).map_err(std::io::Error::from).named(folder)?;
    Ok(disk.f_bavail.saturating_mul(disk.f_frsize))
}

/// Bytes on the disk of a folder that derived data leave to recording: 512 MiB, of a small disk a twentieth.
pub(crate) fn reserved_bytes(folder: &Path) -> Result<u64> {
    let disk = rustix::fs::statvfs(folder).map_err(std::io::Error::from).named(folder)?;
    Ok(RESERVED_BYTES.min(disk.f_blocks.saturating_mul(disk.f_frsize) / 20))
}

/// Ends a change from one history to another that a crash broke off.
pub(crate) fn finish_swap(data: &Path) -> Result<()> {
    let (history, growing, replaced) = (data.join(HISTORY), data.join(GROWING), data.join(REPLACED));
    if replaced.exists() {
        if !history.exists() && growing.exists() {
            fs::rename(&growing, &history).named(&growing)?;
        }
        fs::remove_dir_all(&replaced).named(&replaced)?;
    }
    Ok(())
}
