//! Identity of the spool: the stream's number, the count of starts.

use anyhow::Context as _;
use std::fs::{self, File};
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// Data stored beside the entries.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Identity {
    /// The present stream.
    pub(crate) stream: u64,
    /// Starts of the program with this spool.
    pub(crate) starts: u64,
    /// Boot id of the computer when it was last used.
    pub(crate) boot: String,
    /// Whether everything was on the disk when it was last closed.
    pub(crate) clean: bool,
}

impl Identity {
    /// A new stream.
    pub(crate) fn fresh(starts: u64) -> anyhow::Result<Self> {
        Ok(Self { stream: random()?, starts, boot: boot(), clean: false })
    }

    /// Reads it from the folder; `None` if there is none that can be read.
    pub(crate) fn load(folder: &Path) -> Option<Self> {
        let text = fs::read_to_string(path(folder)).ok()?;
        let value = |key: &str| text.lines().find_map(|line| line.strip_prefix(key)?.strip_prefix(" = "));
        Some(Self {
            stream: value("stream")?.parse().ok()?,
            starts: value("starts")?.parse().ok()?,
            boot: value("boot")?.to_owned(),
            clean: value("clean")?.parse().ok()?,
        })
    }

    /// Writes it to disk atomically.
    pub(crate) fn save(&self, folder: &Path) -> anyhow::Result<()> {
        let Self { stream, starts, boot, clean } = self;
        let text = format!("stream = {stream}\nstarts = {starts}\nboot = {boot}\nclean = {clean}\n");
        write_whole(&path(folder), text.as_bytes())
            .with_context(|| format!("writing {}", path(folder).display()))
    }
}

/// The computer's boot id; empty if the system has none.
pub(crate) fn boot() -> String {
    let text = fs::read_to_string("/proc/sys/kernel/random/boot_id").unwrap_or_default();
    text.trim().to_owned()
}

/// A random number.
pub(crate) fn random() -> anyhow::Result<u64> {
    use std::io::Read as _;
    let mut bytes = [0; 8];
    File::open("/dev/urandom")
        .and_then(|mut file| file.read_exact(&mut bytes))
        .context("reading /dev/urandom")?;
    Ok(u64::from_le_bytes(bytes))
}

/// Writes a file so that after a power failure it is either the old one or this.
pub(crate) fn write_whole(path: &Path, bytes: &[u8]) -> std::io::Result<()> {
    let beside = path.with_extension("tmp");
    let mut file = File::create(&beside)?;
    file.write_all(bytes).and_then(|()| file.sync_data()).inspect_err(|_| {
        fs::remove_file(&beside).ok();
    })?;
    fs::rename(&beside, path)?;
    sync_folder(path.parent().unwrap_or(Path::new(".")))
}

/// Syncs the names of new, renamed and removed files to disk.
pub(crate) fn sync_folder(folder: &Path) -> std::io::Result<()> {
    File::open(folder)?.sync_all()
}

fn path(folder: &Path) -> PathBuf {
    folder.join("identity")
}
