//! Words for people, which must never stop the vessel.
//!
//! A closed pipe, a full disk behind a redirected log or a terminal that nobody reads is no reason for a program
//! that steers a boat to fail or to wait.

use std::fmt::Arguments;
use std::io::{self, Write as _};
use std::sync::mpsc::{self, Receiver, SyncSender, TrySendError};
use std::time::Duration;

/// Lines that may wait for a slow reader; more are dropped and counted.
const WAITING_LINES: usize = 1_000;
/// How long the end of the program waits for the last lines to be taken.
const LAST_WORDS: Duration = Duration::from_millis(300);

/// As `println!`, without failing when nobody reads.
macro_rules! say {
    ($($text:tt)*) => { $crate::say::out(format_args!($($text)*)) };
}

/// As `eprintln!`, without failing when nobody reads.
macro_rules! complain {
    ($($text:tt)*) => { $crate::say::err(format_args!($($text)*)) };
}

pub(crate) use {complain, say};

pub(crate) fn out(text: Arguments<'_>) {
    writeln!(io::stdout().lock(), "{text}").ok();
}

pub(crate) fn err(text: Arguments<'_>) {
    writeln!(io::stderr().lock(), "{text}").ok();
}

/// Writes lines to standard error from a thread of its own, so that the loop that steers never waits for it.
#[derive(Debug)]
pub(crate) struct Console {
    lines: Option<SyncSender<String>>,
    ended: Receiver<()>,
    dropped: u64,
}

impl Console {
    pub(crate) fn start() -> Self {
        let (lines, waiting) = mpsc::sync_channel::<String>(WAITING_LINES);
        let (end, ended) = mpsc::channel();
        std::thread::spawn(move || {
            for line in waiting {
                err(format_args!("{line}"));
            }
            end.send(()).ok();
        });
        Self { lines: Some(lines), ended, dropped: 0 }
    }

    /// Hands a line over; drops it when too many wait.
    pub(crate) fn line(&mut self, line: String) {
        let Some(lines) = &self.lines else { return };
        if let Err(TrySendError::Full(_)) = lines.try_send(line) {
            self.dropped += 1;
        } else if self.dropped > 0 {
            let told = lines.try_send(format!("{} lines were dropped: nobody read them", self.dropped));
            self.dropped = if told.is_ok() { 0 } else { self.dropped };
        }
    }
}

impl Drop for Console {
    /// Gives the last lines a moment, and no more.
    fn drop(&mut self) {
        self.lines = None;
        self.ended.recv_timeout(LAST_WORDS).ok();
    }
}
