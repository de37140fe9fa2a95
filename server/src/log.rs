//! The server's log: exactly one line for each event on standard error, whatever text comes from vessels or people, or the
//! system's journal with fields.

use crate::config::{Log, LogFormat};
use service::journal::{Journal, VesselNames};
use service::lines::is_forging;
use std::borrow::Cow;
use std::fmt::Write as _;
use std::io::{self, IsTerminal as _, Write};
use tracing_subscriber::filter::Targets;
use tracing_subscriber::prelude::*;

/// Most bytes of a line; the number of bytes cut off is given at its end.
const LINE_BYTES: usize = 16 * 1024;

/// Starts logging as configured: into the journal where the service manager connected standard error to it and the lines are
/// for people. The names of vessels are given to it by `names`. A second call in one process changes nothing.
pub(crate) fn start(log: &Log, names: &VesselNames) {
    let filter: Targets = log.level.parse().unwrap_or_default();
    let registry = tracing_subscriber::registry().with(filter);
    let colours = io::stderr().is_terminal();
    let lines = tracing_subscriber::fmt::layer().with_ansi(colours);
    let started = match log.format {
        LogFormat::Human => match Journal::of_service("lutra-server", names.clone()) {
            Some(journal) => registry.with(journal).try_init(),
            None => registry
                .with(lines.with_target(true).with_writer(move || OneLine { to: io::stderr(), colours }))
                .try_init(),
        },
        // JSON escapes line ends and control characters already.
        LogFormat::Json => registry.with(lines.with_writer(io::stderr).json().flatten_event(true)).try_init(),
    };
    if started.is_err() {
        tracing::debug!("logging was started before");
    }
}

/// Writes each event, which arrives in one piece with a line feed at its end, as one line.
struct OneLine<W> {
    to: W,
    /// Whether colour sequences are kept.
    colours: bool,
}

impl<W: Write> Write for OneLine<W> {
    fn write(&mut self, event: &[u8]) -> io::Result<usize> {
        self.to.write_all(one_line(&String::from_utf8_lossy(event), self.colours).as_bytes())?;
        Ok(event.len())
    }

    fn flush(&mut self) -> io::Result<()> {
        self.to.flush()
    }
}

/// An event with only its own line end, without control characters, and not too long.
fn one_line(event: &str, colours: bool) -> Cow<'_, str> {
    let line = event.strip_suffix('\n').unwrap_or(event);
    if line.len() <= LINE_BYTES && !line.chars().any(is_forging) {
        return Cow::Borrowed(event);
    }
    let mut safe = String::with_capacity(line.len().min(2 * LINE_BYTES) + 64);
    for (at, letter) in line.char_indices() {
        if safe.len() >= LINE_BYTES {
            write!(safe, " … {} bytes more", line.len() - at).ok();
            break;
        }
        let stays = !is_forging(letter) || (colours && is_colour(&line[at..]));
        if stays { safe.push(letter) } else { safe.extend(letter.escape_default()) }
    }
    safe.push('\n');
    Cow::Owned(safe)
}

/// Whether a text begins with a colour sequence.
fn is_colour(text: &str) -> bool {
    let rest = text.strip_prefix("\u{1b}[");
    let rest =
        rest.map(|rest| rest.trim_start_matches(|letter: char| letter.is_ascii_digit() || letter == ';'));
    rest.is_some_and(|rest| rest.starts_with('m'))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::sync::{Arc, Mutex};
    use tracing_subscriber::fmt::MakeWriter;

    /// Captures the output to standard error.
    #[derive(Clone, Default)]
    struct Kept(Arc<Mutex<Vec<u8>>>);

    impl Write for Kept {
        fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
            self.0.lock().unwrap().extend_from_slice(bytes);
            Ok(bytes.len())
        }

        fn flush(&mut self) -> io::Result<()> {
            Ok(())
        }
    }

    impl<'a> MakeWriter<'a> for Kept {
        type Writer = OneLine<Self>;
        fn make_writer(&'a self) -> Self::Writer {
            OneLine { to: self.clone(), colours: false }
        }
    }

    fn logged(work: impl FnOnce()) -> String {
        let kept = Kept::default();
        let lines = tracing_subscriber::fmt().with_ansi(false).with_writer(kept.clone()).finish();
        tracing::subscriber::with_default(lines, work);
        let bytes = kept.0.lock().unwrap().clone();
        String::from_utf8(bytes).unwrap()
    }

    #[test]
    fn nobody_forges_a_line_by_what_they_call_themselves() {
        let name = "otter\n2026-01-01T00:00:00.000000Z  WARN server: all vessels are stopped\r\u{85}\u{2028}\u{202e}x\u{1b}[2J";
        let log = logged(|| tracing::info!(name = %name, again = name, "a vessel greets {name}"));
        assert_eq!(log.lines().count(), 1, "{log}");
        let line = log.strip_suffix('\n').unwrap();
        assert!(!line.chars().any(is_forging), "{line:?}");
        assert!(log.contains("otter\\n2026-01-01") && log.contains("\\u{202e}x"), "{log}");
    }

    #[test]
    fn a_terminal_gets_its_colours_and_nothing_else_that_leads_it() {
        let event = "\u{1b}[1;32mINFO\u{1b}[0m gone\u{1b}[2J\u{1b}]0;title\u{7}\n";
        let line = one_line(event, true);
        assert_eq!(line, "\u{1b}[1;32mINFO\u{1b}[0m gone\\u{1b}[2J\\u{1b}]0;title\\u{7}\n");
        assert!(!one_line(event, false).contains('\u{1b}'));
    }

    #[test]
    fn a_line_is_bounded_and_an_ordinary_one_stays_as_it_is() {
        let long = "ø".repeat(100_000);
        let log = logged(|| tracing::warn!(text = %long, "refused"));
        assert!(log.len() < LINE_BYTES + 100 && log.ends_with(" bytes more\n"), "{}", log.len());
        let log = logged(|| tracing::info!(vessel = %"0x0814", place = "Gløshaugen\t1", "here"));
        assert!(log.contains("here vessel=0x0814 place=\"Gløshaugen\\t1\"\n"), "{log}");
    }
}
