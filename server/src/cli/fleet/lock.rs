//! One command at a time writes the fleet's folder and the files of the VPN: two at once could each undo a revocation of the
//! other.

use anyhow::{Context as _, bail};
use std::fs::{DirBuilder, File, OpenOptions, TryLockError};
use std::io::{Read as _, Seek as _, Write as _};
use std::os::unix::fs::{DirBuilderExt as _, OpenOptionsExt as _};
use std::path::Path;
use std::thread;
use std::time::{Duration, Instant};

/// How long a command waits for another one.
const PATIENCE: Duration = Duration::from_secs(5);
const LOOK_EVERY: Duration = Duration::from_millis(50);

/// Held while a command writes; the system releases it when the process ends in any way.
#[derive(Debug)]
pub(super) struct FleetLock(File);

impl FleetLock {
    /// Locks the fleet of a data folder, which is made if it is missing. Waits some seconds for another command.
    pub(super) fn take(data: &Path, command: &str) -> anyhow::Result<Self> {
        Self::take_within(data, command, PATIENCE)
    }

    fn take_within(data: &Path, command: &str, patience: Duration) -> anyhow::Result<Self> {
        let path = data.join("fleet.lock");
        let named = || format!("cannot write {}", path.display());
        DirBuilder::new().recursive(true).mode(0o700).create(data).with_context(named)?;
        let mut options = OpenOptions::new();
        options.read(true).write(true).create(true).truncate(false).mode(0o600);
        let mut file = options.open(&path).with_context(named)?;
        let end = Instant::now() + patience;
        loop {
            match file.try_lock() {
                Ok(()) => break,
                Err(TryLockError::WouldBlock) if Instant::now() < end => thread::sleep(LOOK_EVERY),
                Err(TryLockError::WouldBlock) => {
                    let mut holder = String::new();
                    file.read_to_string(&mut holder).ok();
                    let holder = holder.trim();
                    let holder = if holder.is_empty() { "another command" } else { holder };
                    bail!("{holder} is changing this fleet: wait until it is done, then do this again");
                }
                Err(TryLockError::Error(error)) => return Err(error).with_context(named),
            }
        }
        // Only for people; on a full disk the lock holds without it.
        let note = file.set_len(0).and_then(|()| file.rewind());
        note.and_then(|()| writeln!(file, "process {} (`lutra-server {command}`)", std::process::id())).ok();
        Ok(Self(file))
    }
}

impl Drop for FleetLock {
    fn drop(&mut self) {
        self.0.set_len(0).ok();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_commands_do_not_write_at_once_and_the_second_names_the_first() {
        let folder = tempfile::tempdir().unwrap();
        let data = folder.path().join("data");
        let first = FleetLock::take(&data, "fleet apply").unwrap();
        let why = FleetLock::take_within(&data, "fleet revoke", Duration::ZERO).unwrap_err().to_string();
        let holder = format!("process {} (`lutra-server fleet apply`) is changing", std::process::id());
        assert!(why.contains(&holder) && why.contains("do this again"), "{why}");
        // The second waits, and goes on once the first is done.
        let waiting = thread::spawn(move || FleetLock::take(&data, "fleet revoke").is_ok());
        drop(first);
        assert!(waiting.join().unwrap());
    }
}
