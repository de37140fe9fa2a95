//! The log folders of a run: one writer, rotated at every plan; a full disk does no harm.

use imc::Address;
use imc::lsf::{LogOptions, LogWriter};
use std::fs;
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;
use units::{MonoTime, UtcTime};

/// Default flush interval.
const FLUSH: Duration = Duration::from_secs(5);
/// Pause before a log that failed is opened again.
const RETRY: Duration = Duration::from_secs(30);

/// How free disk space is kept.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct Room {
    /// Whether the oldest closed logs may be removed.
    pub(crate) remove_oldest: bool,
    /// Room that is to be kept free (MiB).
    pub(crate) keep_free_mib: u64,
}

/// The log.
#[derive(Debug)]
pub(crate) struct Journal {
    room: Room,
    flush: Duration,
    base: PathBuf,
    options: LogOptions,
    log: Option<LogWriter>,
    label: String,
    next_flush: MonoTime,
    retry: Option<MonoTime>,
}

impl Journal {
    /// A log below `base`, with the configuration in every log folder.
    pub(crate) fn new(base: &Path, system: Address, entity: u8, config: String) -> Self {
        Self {
            room: Room::default(),
            flush: FLUSH,
            base: base.to_owned(),
            options: LogOptions { system, entity, compress: true, config },
            log: None,
            label: String::new(),
            next_flush: MonoTime::default(),
            retry: None,
        }
    }

    /// The same, keeping room on the disk.
    pub(crate) fn with_room(self, room: Room) -> Self {
        Self { room, ..self }
    }

    /// The same, with the data on the disk after this time at the latest, and compressed or not.
    pub(crate) fn with_form(mut self, flush: Duration, compress: bool) -> Self {
        self.flush = flush;
        self.options.compress = compress;
        self
    }

    /// Closes the open log and opens another; returns its name.
    ///
    /// # Errors
    /// When it cannot be opened; it is tried again later.
    pub(crate) fn open(&mut self, now: MonoTime, utc: UtcTime, label: &str) -> io::Result<String> {
        label.clone_into(&mut self.label);
        if let Err(error) = self.close(utc) {
            // The previous log is cut short; open the next one all the same.
            tracing::error!("the log before is cut short: {error}");
        }
        if let Err(error) = self.make_room() {
            tracing::error!("old logs could not be removed for room: {error}");
        }
        match LogWriter::create(&self.base, utc, label, self.options.clone()) {
            Ok(log) => {
                let name = log.name().to_owned();
                self.log = Some(log);
                self.retry = None;
                self.next_flush = now + self.flush;
                Ok(name)
            }
            Err(error) => {
                self.retry = Some(now + RETRY);
                Err(error)
            }
        }
    }

    /// Closes the open log.
    ///
    /// # Errors
    /// When its end cannot be written: what was not flushed is lost.
    pub(crate) fn close(&mut self, utc: UtcTime) -> io::Result<()> {
        self.log.take().map_or(Ok(()), |log| log.finish(utc))
    }

    /// Appends a packet; returns whether a log is open.
    ///
    /// # Errors
    /// When it cannot be written: the log is then given up and opened again later.
    pub(crate) fn write(&mut self, now: MonoTime, packet: &[u8]) -> io::Result<bool> {
        self.with(now, |log| log.write(packet))
    }

    /// Appends a line of text; returns whether a log is open.
    ///
    /// # Errors
    /// As [`Journal::write`].
    pub(crate) fn line(&mut self, now: MonoTime, line: &str) -> io::Result<bool> {
        self.with(now, |log| log.write_line(line))
    }

    /// Periodic work: returns the outcome of reopening a failed log.
    ///
    /// # Errors
    /// When the log cannot be flushed.
    pub(crate) fn tick(&mut self, now: MonoTime, utc: UtcTime) -> io::Result<Option<io::Result<String>>> {
        if self.retry.is_some_and(|at| now >= at) {
            let label = self.label.clone();
            return Ok(Some(self.open(now, utc, &label)));
        }
        if now >= self.next_flush {
            self.next_flush = now + self.flush;
            self.with(now, LogWriter::flush)?;
        }
        Ok(None)
    }

    /// Removes the oldest logs until there is room, when that is allowed. The open log is closed by now, and
    /// the newest of the closed ones is never touched.
    fn make_room(&self) -> io::Result<()> {
        let Room { remove_oldest, keep_free_mib } = self.room;
        if !remove_oldest {
            return Ok(());
        }
        let mut logs = closed_logs(&self.base);
        logs.pop();
        for log in logs {
            if free_mib(&self.base).is_none_or(|free| free >= keep_free_mib) {
                return Ok(());
            }
            fs::remove_dir_all(&log)?;
            // Also removes the day's folder if it is empty now.
            log.parent().map(fs::remove_dir);
        }
        Ok(())
    }

    fn with(
        &mut self,
        now: MonoTime,
        act: impl FnOnce(&mut LogWriter) -> io::Result<()>,
    ) -> io::Result<bool> {
        let Some(log) = &mut self.log else { return Ok(false) };
        let outcome = act(log);
        if outcome.is_err() {
            self.log = None;
            self.retry = Some(now + RETRY);
        }
        outcome.map(|()| true)
    }
}

/// The folders of logs below `base`, oldest first: two levels of names that begin with digits.
fn closed_logs(base: &Path) -> Vec<PathBuf> {
    let below = |folder: &Path| {
        let entries = fs::read_dir(folder).into_iter().flatten().filter_map(Result::ok);
        let mut found: Vec<PathBuf> = entries
            .filter(|entry| {
                entry.file_name().to_str().is_some_and(|name| name.starts_with(|c: char| c.is_ascii_digit()))
            })
            .map(|entry| entry.path())
            .filter(|path| path.is_dir())
            .collect();
        found.sort();
        found
    };
    below(base).iter().flat_map(|day| below(day)).filter(|log| log.join("IMC.xml.gz").exists()).collect()
}

fn free_mib(path: &Path) -> Option<u64> {
    let state = rustix::fs::statvfs(path).ok()?;
    Some(state.f_bavail.saturating_mul(state.f_frsize) >> 20)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_log_that_cannot_be_opened_is_tried_again_and_nothing_breaks_meanwhile() {
        let folder = tempfile::tempdir().unwrap();
        let base = folder.path().join("logs");
        std::fs::write(&base, "in the way").unwrap();
        let utc = UtcTime::from_micros(1_790_000_000_000_000);
        let at = |seconds| MonoTime::default() + Duration::from_secs(seconds);
        let mut journal = Journal::new(&base, Address(0x2810), 1, String::new());
        assert!(journal.open(at(0), utc, "plan").is_err());
        assert!(!journal.write(at(1), b"lost").unwrap());
        assert!(!journal.line(at(1), "lost").unwrap());
        assert!(journal.tick(at(10), utc).unwrap().is_none());
        std::fs::remove_file(&base).unwrap();
        let name = journal.tick(at(31), utc).unwrap().unwrap().unwrap();
        assert!(name.ends_with("_plan"), "{name}");
        assert!(journal.tick(at(32), utc).unwrap().is_none());
        journal.close(utc).unwrap();
        assert!(base.join(name).join("Data.lsf.gz").exists());
    }

    #[test]
    fn oldest_logs_go_only_when_allowed_and_never_the_newest() {
        let folder = tempfile::tempdir().unwrap();
        let utc = |hour: i64| UtcTime::from_micros(1_790_000_000_000_000 + hour * 3_600_000_000);
        let open = |room: Room, hour: i64| {
            let mut journal = Journal::new(folder.path(), Address(1), 1, String::new()).with_room(room);
            journal.open(MonoTime::default(), utc(hour), "").unwrap();
            journal.close(utc(hour)).unwrap();
        };
        std::fs::create_dir_all(folder.path().join("notes/1")).unwrap();
        for hour in 0..5 {
            open(Room { remove_oldest: false, keep_free_mib: u64::MAX }, hour);
        }
        assert_eq!(closed_logs(folder.path()).len(), 5);
        open(Room { remove_oldest: true, keep_free_mib: 0 }, 5);
        assert_eq!(closed_logs(folder.path()).len(), 6);
        open(Room { remove_oldest: true, keep_free_mib: u64::MAX }, 6);
        assert_eq!(closed_logs(folder.path()).len(), 2);
        assert!(folder.path().join("notes/1").exists());
    }
}
