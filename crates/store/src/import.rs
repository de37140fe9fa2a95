//! Logs into the store: LSF files, compressed or not, whole folders of them.
//!
//! Importing the same again adds nothing, neither to the history nor to the archive, also when an import was
//! broken off in between. What a log holds twice is archived twice, as it stands.

use crate::error::{Named as _, Result, StoreError};
use crate::packet::Outcome;
use crate::store::Store;
use imc::lsf::{LogItem, LogReader};
use std::fs;
use std::path::{Path, PathBuf};
use units::UtcTime;

/// Packets between two commits and two reports of progress.
const COMMIT_PACKETS: u64 = 20_000;
/// Bytes between two commits.
const COMMIT_BYTES: usize = 8 << 20;

/// How far an import is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct ImportProgress<'a> {
    /// The log being read.
    pub file: &'a Path,
    /// Its number, from 1.
    pub number: usize,
    /// Logs altogether.
    pub files: usize,
    /// Bytes of this log read so far, unpacked.
    pub bytes: u64,
    /// Packets found so far in all logs.
    pub packets: u64,
    /// Those that were new.
    pub added: u64,
}

/// What an import did.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Imported {
    /// Logs read.
    pub files: usize,
    /// Packets found.
    pub packets: u64,
    /// Packets that were new to the archive.
    pub added: u64,
    /// Bytes that are no packets.
    pub damaged_bytes: u64,
    /// What is wrong with which log, and what to do about it.
    pub problems: Vec<String>,
}

impl Store {
    /// Imports logs: files of any name, and from folders all that are named as logs. `now` is the time by the
    /// shore's clock; `progress` may stop the import by returning false, what was read before stays.
    ///
    /// # Errors
    /// When a file cannot be read or the archive not written, and [`StoreError::Cancelled`]. A file that holds
    /// no packets is no error but a problem that is told.
    pub fn import(
        &mut self,
        paths: &[PathBuf],
        now: UtcTime,
        progress: &mut dyn FnMut(&ImportProgress<'_>) -> bool,
    ) -> Result<Imported> {
        let mut imported = Imported::default();
        let mut files = Vec::new();
        for path in paths {
            if path.is_dir() {
                let before = files.len();
                find_logs(path, &mut files, &mut imported.problems)?;
                if files.len() == before {
                    imported.problems.push(format!("{}: holds no logs (*.lsf, *.lsf.gz)", path.display()));
                }
            } else {
                files.push(path.clone());
            }
        }
        self.commit_all()?;
        // Each log has an arrival of its own, by which its packets are told from those that came before.
        let start_us = self.reserve_arrivals(now.micros(), files.len())?;
        for (at, file) in files.iter().enumerate() {
            let received = UtcTime::from_micros(start_us + at as i64);
            self.import_file(file, received, (at + 1, files.len()), &mut imported, progress)?;
            imported.files += 1;
        }
        self.settle()?;
        Ok(imported)
    }

    fn import_file(
        &mut self,
        file: &Path,
        received: UtcTime,
        (number, files): (usize, usize),
        imported: &mut Imported,
        progress: &mut dyn FnMut(&ImportProgress<'_>) -> bool,
    ) -> Result<()> {
        let mut log = LogReader::open(file).named(file)?;
        let before = imported.packets;
        let mut first_damage = None;
        loop {
            match log.next_item().named(file)? {
                Some(LogItem::Packet { view, .. }) => {
                    imported.packets += 1;
                    if self.accept_from_log(&view, received)? == Outcome::Recorded {
                        imported.added += 1;
                    }
                }
                Some(LogItem::Damage(damage)) => {
                    imported.damaged_bytes += damage.bytes;
                    first_damage.get_or_insert(damage);
                    continue;
                }
                Some(LogItem::Cut { offset, problem }) => {
                    imported
                        .problems
                        .push(format!("{}: {problem} ({offset} bytes were unpacked)", file.display()));
                    continue;
                }
                None => break,
            }
            if imported.packets.is_multiple_of(COMMIT_PACKETS) || self.waiting_bytes() >= COMMIT_BYTES {
                self.commit_all()?;
                let (packets, added, bytes) = (imported.packets, imported.added, log.unpacked_bytes());
                if !progress(&ImportProgress { file, number, files, bytes, packets, added }) {
                    return Err(StoreError::Cancelled);
                }
            }
        }
        self.commit_all()?;
        let name = file.display();
        if imported.packets == before {
            let what = first_damage.map_or_else(
                || "is empty".to_owned(),
                |damage| format!("is no IMC log: {} at its first byte", damage.error),
            );
            imported.problems.push(format!("{name}: {what}"));
        } else if let Some(damage) = first_damage {
            imported.problems.push(format!("{name}: damaged from byte {}: {}", damage.offset, damage.error));
        }
        let (packets, added, bytes) = (imported.packets, imported.added, log.unpacked_bytes());
        if progress(&ImportProgress { file, number, files, bytes, packets, added }) {
            Ok(())
        } else {
            Err(StoreError::Cancelled)
        }
    }

    /// A commit whose history must follow: what is already there is known by the history.
    fn commit_all(&mut self) -> Result<()> {
        self.sync()?;
        self.index()?;
        while self.is_behind() {
            self.index()?;
        }
        Ok(())
    }
}

/// All logs below a folder, in order of their names.
fn find_logs(folder: &Path, files: &mut Vec<PathBuf>, problems: &mut Vec<String>) -> Result<()> {
    let mut entries: Vec<PathBuf> = Vec::new();
    for entry in fs::read_dir(folder).named(folder)? {
        entries.push(entry.named(folder)?.path());
    }
    entries.sort();
    for path in entries {
        let name = path.file_name().unwrap_or_default().to_string_lossy().to_lowercase();
        if fs::symlink_metadata(&path).named(&path)?.is_dir() {
            find_logs(&path, files, problems)?;
        } else if [".lsf", ".lsf.gz", ".imc", ".imc.gz"].iter().any(|end| name.ends_with(end)) {
            files.push(path);
        } else if name.ends_with(".lsf.bz2") {
            problems.push(format!("{}: is packed by bzip2; unpack it with `bunzip2` first", path.display()));
        }
    }
    Ok(())
}
