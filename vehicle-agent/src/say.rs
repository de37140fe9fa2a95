//! Output for people, which must never block the vessel.
//!
//! A closed pipe, a full disk behind a redirected log or a stopped terminal must not make a program that steers a boat fail
//! or wait. Lines of the log (`tracing`) go to standard error through their own thread; at most [`WAITING_LINES`] are
//! queued for a slow reader, further ones are dropped, counted and reported later.

use anyhow::Context as _;
use clap::ValueEnum;
use service::journal::{Journal, VesselNames};
use std::fmt::Arguments;
use std::io::{self, Write};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{self, Receiver, SyncSender};
use std::time::Duration;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::fmt::MakeWriter;
use tracing_subscriber::layer::SubscriberExt as _;
use tracing_subscriber::util::SubscriberInitExt as _;

/// Lines that may be queued for a slow reader.
const WAITING_LINES: usize = 1_000;
/// How long the end of the program waits for the last lines to be written.
const LAST_WORDS: Duration = Duration::from_millis(300);
/// Variable with the level if no option gives it.
const LEVEL_VARIABLE: &str = "LUTRA_LOG";

/// As `println!`, without failing when the reader is gone.
macro_rules! say {
    ($($text:tt)*) => { $crate::say::out(format_args!($($text)*)) };
}

/// As `eprintln!`, without failing when the reader is gone.
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

/// As [`say!`], giving up when the reader does not take it within a short time.
pub(crate) fn briefly(text: String) {
    let (end, ended) = mpsc::channel();
    let work = move || {
        out(format_args!("{text}"));
        io::stdout().flush().ok();
        end.send(()).ok();
    };
    if std::thread::Builder::new().spawn(work).is_ok() {
        ended.recv_timeout(LAST_WORDS).ok();
    }
}

/// How lines of the log look.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, ValueEnum)]
pub(crate) enum LogFormat {
    /// Time, level, part of the program, text and values.
    #[default]
    Human,
    /// One JSON object a line.
    Json,
}

/// Writes the log's lines to standard error, until dropped.
#[derive(Debug)]
pub(crate) struct Voice {
    ended: Receiver<()>,
    end: SyncSender<Line>,
}

enum Line {
    Text(Vec<u8>),
    End,
}

/// Non-blocking handle of the queue.
#[derive(Debug, Clone)]
struct Lines {
    waiting: SyncSender<Line>,
    dropped: Arc<AtomicU64>,
}

impl Write for Lines {
    /// Takes a whole line from the formatter.
    fn write(&mut self, line: &[u8]) -> io::Result<usize> {
        if self.waiting.try_send(Line::Text(line.to_vec())).is_err() {
            self.dropped.fetch_add(1, Ordering::Relaxed);
        }
        Ok(line.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl<'a> MakeWriter<'a> for Lines {
    type Writer = Self;

    fn make_writer(&'a self) -> Self {
        self.clone()
    }
}

/// What is logged: `info`, or by part of the program as in `warn,vessel=debug`.
///
/// # Errors
/// When the text is not valid.
pub(crate) fn level(option: Option<&str>, quiet: bool) -> anyhow::Result<Targets> {
    let variable = std::env::var(LEVEL_VARIABLE).ok();
    let (text, from) = match (option, quiet, &variable) {
        (Some(text), ..) => (text, "--log-level"),
        (None, true, _) => ("warn", "--quiet"),
        (None, false, Some(text)) => (text.as_str(), LEVEL_VARIABLE),
        (None, false, None) => ("info", ""),
    };
    text.parse().with_context(|| {
        format!("{from} `{text}`: write error, warn, info, debug, trace or off, or as in warn,vessel=debug")
    })
}

impl Voice {
    /// Starts the log; once in a program. Lines for people go into the journal, with fields, where the service manager connected
    /// standard error to it; `names` gets the vessel's name once it is known.
    pub(crate) fn start(format: LogFormat, level: Targets, names: &VesselNames) -> anyhow::Result<Self> {
        let (voice, lines) = Self::to(io::stderr())?;
        let layer = tracing_subscriber::fmt::layer().with_writer(lines).with_ansi(false);
        let registry = tracing_subscriber::registry().with(level);
        match format {
            LogFormat::Human => match Journal::of_service("lutra-agent", names.clone()) {
                Some(journal) => registry.with(journal).try_init(),
                None => registry.with(layer).try_init(),
            },
            LogFormat::Json => registry.with(layer.json().flatten_event(true)).try_init(),
        }
        .context("the log")?;
        Ok(voice)
    }

    fn to(mut sink: impl Write + Send + 'static) -> io::Result<(Self, Lines)> {
        let (waiting, lines) = mpsc::sync_channel(WAITING_LINES);
        let (end, ended) = mpsc::channel();
        let dropped = Arc::new(AtomicU64::new(0));
        let counted = Arc::clone(&dropped);
        std::thread::Builder::new().name("words".to_owned()).spawn(move || {
            for line in lines {
                let Line::Text(line) = line else { break };
                sink.write_all(&line).ok();
                let lost = counted.swap(0, Ordering::Relaxed);
                if lost > 0 {
                    tracing::warn!(lost, "lines were dropped: they were not read in time");
                }
            }
            sink.flush().ok();
            end.send(()).ok();
        })?;
        Ok((Self { ended, end: waiting.clone() }, Lines { waiting, dropped }))
    }
}

impl Drop for Voice {
    /// Waits a short time for the last lines.
    fn drop(&mut self) {
        if self.end.try_send(Line::End).is_ok() {
            self.ended.recv_timeout(LAST_WORDS).ok();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::mpsc::{Sender, channel};

    /// A reader that takes lines on request.
    struct Slow(Receiver<()>, Sender<String>);

    impl Write for Slow {
        fn write(&mut self, line: &[u8]) -> io::Result<usize> {
            self.0.recv().map_err(io::Error::other)?;
            self.1.send(String::from_utf8_lossy(line).into_owned()).map_err(io::Error::other)?;
            Ok(line.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    #[test]
    fn a_reader_that_stands_still_holds_nobody_up_and_lost_lines_are_told() {
        let ((go, wait), (line, read)) = (channel(), channel());
        let (_voice, lines) = Voice::to(Slow(wait, line)).unwrap();
        let told = tracing_subscriber::fmt().with_ansi(false).with_writer(lines.clone()).finish();
        tracing::subscriber::with_default(told, || {
            for number in 0..WAITING_LINES + 50 {
                tracing::info!(number, "a line");
            }
        });
        let dropped = lines.dropped.load(Ordering::Relaxed);
        // One may be in the reader's hands.
        assert!((49..=50).contains(&dropped), "{dropped}");
        go.send(()).unwrap();
        let first = read.recv_timeout(Duration::from_secs(20)).unwrap();
        assert!(first.contains("a line") && first.contains("number=0"), "{first}");
    }

    #[test]
    fn levels_are_words_or_words_by_part() {
        assert!(level(Some("warn,vessel=debug"), false).is_ok());
        assert!(level(None, true).is_ok());
        let refused = level(Some("shout=very"), false).unwrap_err();
        assert!(format!("{refused:#}").contains("--log-level"), "{refused:#}");
    }
}
