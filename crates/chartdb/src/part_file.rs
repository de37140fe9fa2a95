//! Files that have a temporary name until they are whole, and files that may not exist.

use crate::error::{Named as _, Result};
use std::fs;
use std::path::{Path, PathBuf};

/// The name under which a file is written until it is whole.
pub(crate) fn part_of(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

/// Removes a file that may not be there.
pub(crate) fn forget(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(error) if error.kind() != std::io::ErrorKind::NotFound => Err(error).named(path),
        _ => Ok(()),
    }
}
