//! What a backup holds: `backup.json`, written last, so that a copy that was broken off is none.

use anyhow::{Context as _, ensure};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::fs::{self, File};
use std::io::{Read, Write};
use std::path::{Component, Path, PathBuf};

/// The manifest's name.
pub(crate) const MANIFEST: &str = "backup.json";
/// The form of the manifest that is written.
const VERSION: u32 = 1;

/// What a backup holds.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct Manifest {
    version: u32,
    /// By which program.
    program: String,
    /// When it was made, µs since 1970 UTC.
    pub(super) made_us: i64,
    /// Its files.
    pub(super) files: Vec<Entry>,
    /// Files that lie outside of the data folder: where they lay, and their names here.
    pub(super) outside: Vec<(PathBuf, PathBuf)>,
}

/// One file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Entry {
    /// Below the folder.
    pub(super) path: PathBuf,
    /// Bytes from its start on that belong to the backup; a file of the archive may have grown since.
    pub(super) bytes: u64,
    /// SHA-256 of these, in hexadecimal digits.
    pub(super) sha256: String,
    /// Its rights.
    pub(crate) mode: u32,
}

impl Manifest {
    pub(crate) fn new(made_us: i64) -> Self {
        let program = concat!("lutra-server ", env!("CARGO_PKG_VERSION")).to_owned();
        Self { version: VERSION, program, made_us, ..Self::default() }
    }

    /// The manifest of a backup.
    ///
    /// # Errors
    /// There is none, or none that this program understands.
    pub(crate) fn read(backup: &Path) -> anyhow::Result<Self> {
        let path = backup.join(MANIFEST);
        let text = fs::read(&path).with_context(|| {
            format!(
                "{} is no whole backup: it has no {MANIFEST}; run `lutra-server backup` to its end, and again where an \
                 earlier version made it",
                backup.display()
            )
        })?;
        let manifest: Self =
            serde_json::from_slice(&text).with_context(|| format!("{} is damaged", path.display()))?;
        ensure!(
            manifest.version <= VERSION,
            "{} was written by {}; restore it by that version or a later one",
            path.display(),
            manifest.program
        );
        for path in manifest.files.iter().map(|entry| &entry.path) {
            let inside = path.components().all(|part| matches!(part, Component::Normal(_)));
            ensure!(inside && path.file_name().is_some(), "{} leads out of the backup", path.display());
        }
        Ok(manifest)
    }

    /// Writes it whole or not at all.
    pub(crate) fn write(&self, backup: &Path) -> anyhow::Result<()> {
        let (path, new) = (backup.join(MANIFEST), backup.join("backup.json.new"));
        let write = || -> std::io::Result<()> {
            let mut file = File::create(&new)?;
            file.write_all(&serde_json::to_vec_pretty(self).unwrap_or_default())?;
            file.sync_all()?;
            fs::rename(&new, &path)?;
            File::open(backup)?.sync_all()
        };
        write().with_context(|| format!("cannot write {}", path.display()))
    }
}

/// Copies the first `bytes` bytes of what is read, or all there are; how many, and their digest.
pub(crate) fn copy(from: impl Read, bytes: u64, to: &mut impl Write) -> std::io::Result<(u64, String)> {
    let (mut hash, mut copied, mut buffer) = (Sha256::new(), 0, vec![0; 256 << 10]);
    let mut from = from.take(bytes);
    loop {
        match from.read(&mut buffer) {
            Ok(0) => break,
            Ok(read) => {
                hash.update(&buffer[..read]);
                to.write_all(&buffer[..read])?;
                copied += read as u64;
            }
            Err(error) if error.kind() == std::io::ErrorKind::Interrupted => {}
            Err(error) => return Err(error),
        }
    }
    Ok((copied, hex::encode(hash.finalize())))
}
