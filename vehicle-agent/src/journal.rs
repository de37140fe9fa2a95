//! The log folders of a run: one writer, rotated at every plan, and no harm when the disk is full.

use imc::Address;
use imc::lsf::{LogOptions, LogWriter};
use std::io;
use std::path::{Path, PathBuf};
use std::time::Duration;
use units::{MonoTime, UtcTime};

const FLUSH: Duration = Duration::from_secs(5);
/// Pause before a log that failed is opened anew.
const RETRY: Duration = Duration::from_secs(30);

/// The log.
#[derive(Debug)]
pub(crate) struct Journal {
    base: PathBuf,
    options: LogOptions,
    log: Option<LogWriter>,
    label: String,
    next_flush: MonoTime,
    retry: Option<MonoTime>,
}

impl Journal {
    /// A log below `base`, with the configuration beside every part.
    pub(crate) fn new(base: &Path, system: Address, entity: u8, config: String) -> Self {
        Self {
            base: base.to_owned(),
            options: LogOptions { system, entity, compress: true, config },
            log: None,
            label: String::new(),
            next_flush: MonoTime::default(),
            retry: None,
        }
    }

    /// Closes the open log and opens another; answers its name.
    ///
    /// # Errors
    /// When it cannot be opened; it is tried again later.
    pub(crate) fn open(&mut self, now: MonoTime, utc: UtcTime, label: &str) -> io::Result<String> {
        label.clone_into(&mut self.label);
        self.close(utc);
        match LogWriter::create(&self.base, utc, label, self.options.clone()) {
            Ok(log) => {
                let name = log.name().to_owned();
                self.log = Some(log);
                self.retry = None;
                self.next_flush = now + FLUSH;
                Ok(name)
            }
            Err(error) => {
                self.retry = Some(now + RETRY);
                Err(error)
            }
        }
    }

    /// Closes the open log. What cannot be written any more is lost.
    pub(crate) fn close(&mut self, utc: UtcTime) {
        if let Some(log) = self.log.take() {
            log.finish(utc).ok();
        }
    }

    /// Appends a packet.
    ///
    /// # Errors
    /// When it cannot be written: the log is then given up and opened anew later.
    pub(crate) fn write(&mut self, now: MonoTime, packet: &[u8]) -> io::Result<()> {
        self.with(now, |log| log.write(packet))
    }

    /// Appends a line of text.
    ///
    /// # Errors
    /// As [`Journal::write`].
    pub(crate) fn line(&mut self, now: MonoTime, line: &str) -> io::Result<()> {
        self.with(now, |log| log.write_line(line))
    }

    /// What falls due: answers the outcome of opening a failed log anew.
    ///
    /// # Errors
    /// When the log cannot be flushed.
    pub(crate) fn tick(&mut self, now: MonoTime, utc: UtcTime) -> io::Result<Option<io::Result<String>>> {
        if self.retry.is_some_and(|at| now >= at) {
            let label = self.label.clone();
            return Ok(Some(self.open(now, utc, &label)));
        }
        if now >= self.next_flush {
            self.next_flush = now + FLUSH;
            self.with(now, LogWriter::flush)?;
        }
        Ok(None)
    }

    fn with(&mut self, now: MonoTime, act: impl FnOnce(&mut LogWriter) -> io::Result<()>) -> io::Result<()> {
        let Some(log) = &mut self.log else { return Ok(()) };
        act(log).inspect_err(|_| {
            self.log = None;
            self.retry = Some(now + RETRY);
        })
    }
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
        journal.write(at(1), b"lost").unwrap();
        journal.line(at(1), "lost").unwrap();
        assert!(journal.tick(at(10), utc).unwrap().is_none());
        std::fs::remove_file(&base).unwrap();
        let name = journal.tick(at(31), utc).unwrap().unwrap().unwrap();
        assert!(name.ends_with("_plan"), "{name}");
        assert!(journal.tick(at(32), utc).unwrap().is_none());
        journal.close(utc);
        assert!(base.join(name).join("Data.lsf.gz").exists());
    }
}
