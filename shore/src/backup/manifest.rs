//! The manifest of a backup: `backup.json`, written last, so that an interrupted copy does not count as a backup.

use anyhow::{Context as _, ensure};
use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};
use std::fs::{self, File};
use std::io::{Read, Write};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Component, Path, PathBuf};
use std::time::{Duration, SystemTime};

/// The manifest's name.
pub(crate) const MANIFEST: &str = "backup.json";
/// The format version that is written.
const VERSION: u32 = 2;
/// The folder with the second place of each rewritten file.
pub(super) const ALTERNATE: &str = "alternate";
/// Folder for copies that a person must look at.
pub(super) const ASIDE: &str = "aside";
/// A file that was changed so shortly before a backup may change again within the same modification time.
const SETTLED: Duration = Duration::from_secs(2);

/// The manifest of a backup.
#[derive(Debug, Default, Serialize, Deserialize)]
pub(crate) struct Manifest {
    version: u32,
    /// Version of the program that wrote it.
    program: String,
    /// When it was made, µs since 1970 UTC.
    pub(super) made_us: i64,
    /// Its files.
    pub(super) files: Vec<Entry>,
    /// Files from outside of the data folder: original path, and name in the backup.
    pub(super) outside: Vec<(PathBuf, PathBuf)>,
}

/// One file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Entry {
    /// Below the data folder.
    pub(super) path: PathBuf,
    /// Its path below the backup, if not `path`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) at: Option<PathBuf>,
    /// Bytes from its start on that belong to the backup; a file of the archive may have grown since.
    pub(super) bytes: u64,
    /// SHA-256 of these, in hexadecimal digits.
    pub(super) sha256: String,
    /// Its permissions.
    pub(crate) mode: u32,
    /// Stamp of the source at the time of the copy; `None` where it could not be distinguished from a later version.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub(super) source: Option<Stamp>,
}

impl Entry {
    /// Its path below the backup.
    pub(super) fn at(&self) -> &Path {
        self.at.as_deref().unwrap_or(&self.path)
    }
}

/// Identifies one state of a file, to detect changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub(crate) struct Stamp {
    inode: u64,
    bytes: u64,
    changed_s: i64,
    changed_ns: i64,
}

impl Stamp {
    /// The stamp of a file; `None` if it changed so recently that it could change again unnoticed, or if a database's
    /// write-ahead log is not empty.
    pub(super) fn of(path: &Path, now: SystemTime) -> std::io::Result<Option<Self>> {
        let about = fs::metadata(path)?;
        let is_settled = now.duration_since(about.modified()?).is_ok_and(|age| age >= SETTLED);
        let has_log = ["-wal", "-journal"]
            .iter()
            .any(|end| fs::metadata(format!("{}{end}", path.display())).is_ok_and(|log| log.len() > 0));
        let stamp = Self {
            inode: about.ino(),
            bytes: about.len(),
            changed_s: about.mtime(),
            changed_ns: about.mtime_nsec(),
        };
        Ok(Some(stamp).filter(|_| is_settled && !has_log))
    }
}

impl Manifest {
    pub(crate) fn new(made_us: i64) -> Self {
        let program = concat!("lutra-server ", env!("CARGO_PKG_VERSION")).to_owned();
        Self { version: VERSION, program, made_us, ..Self::default() }
    }

    /// The manifest of a backup.
    ///
    /// # Errors
    /// The folder holds no backup, or one that this program cannot read.
    pub(crate) fn read(backup: &Path) -> anyhow::Result<Self> {
        let path = backup.join(MANIFEST);
        let text = fs::read(&path).with_context(|| {
            format!(
                "{} is not a whole backup: it has no {MANIFEST}; run `lutra-server backup` to its end, and again where an \
                 earlier version made it",
                backup.display()
            )
        })?;
        let manifest: Self = serde_json::from_slice(&text).with_context(|| {
            format!(
                "{} is damaged; take another backup, or choose another folder for a new one",
                path.display()
            )
        })?;
        ensure!(
            manifest.version <= VERSION,
            "{} was written by {}; restore it by that version or a later one",
            path.display(),
            manifest.program
        );
        for path in
            manifest.files.iter().flat_map(|entry| [&entry.path, entry.at.as_ref().unwrap_or(&entry.path)])
        {
            let inside = path.components().all(|part| matches!(part, Component::Normal(_)));
            ensure!(inside && path.file_name().is_some(), "{} leads out of the backup", path.display());
        }
        Ok(manifest)
    }

    /// Writes it atomically.
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

/// The digest of the first `bytes` bytes of a file that has at least that many.
pub(super) fn hash_prefix(path: &Path, bytes: u64) -> std::io::Result<String> {
    copy(File::open(path)?, bytes, &mut std::io::sink()).map(|(_, sha256)| sha256)
}

/// Copies at most `bytes` bytes; returns how many, and their digest.
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
