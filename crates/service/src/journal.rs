//! The log in the system's journal, with fields: `journalctl LUTRA_VESSEL=otter-1`, `journalctl LUTRA_COMMAND=…`.
//!
//! Each event is one datagram of the journal's native protocol (systemd.io/JOURNAL_NATIVE_PROTOCOL). Its message is the line
//! that the log has as text, so that `journalctl -u` shows as much; each value is a field `LUTRA_NAME` besides. The socket never waits: events
//! that a journal does not take are counted, and the next one says how many in its message. Values of spans, such as the number of
//! a request, are there as `LUTRA_SPAN_NAME`.

use crate::lines::harmless;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt::{Debug, Write as _};
use std::fs::File;
use std::io;
use std::os::fd::AsFd as _;
use std::os::unix::fs::MetadataExt as _;
use std::os::unix::net::UnixDatagram;
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, PoisonError, RwLock};
use tracing::field::{Field, Visit};
use tracing::span::{Attributes, Id};
use tracing::{Event, Level, Subscriber};
use tracing_subscriber::Layer;
use tracing_subscriber::layer::Context;
use tracing_subscriber::registry::{LookupSpan, Scope};

/// Where the journal listens.
const SOCKET: &str = "/run/systemd/journal/socket";
/// Most bytes of one value: an event must fit a datagram.
const VALUE_BYTES: usize = 16 * 1024;
/// Most fields of an event; further ones are in its message alone.
const MOST_FIELDS: usize = 64;
/// The field that says which vessel an event is about, by address and, where it is known, by name.
const VESSEL: &str = "vessel";

/// The vessels that events are about; shared with the program, which learns their names after its log has begun.
#[derive(Debug, Clone, Default)]
pub struct VesselNames(Arc<RwLock<Known>>);

#[derive(Debug, Default)]
struct Known {
    /// The vessel that the program steers; ashore none.
    own: Option<String>,
    /// Names by address, as events have it: those that people gave, and those that vessels give themselves.
    names: BTreeMap<String, BTreeSet<String>>,
}

impl VesselNames {
    /// These names from here on, by address; a vessel may have several.
    pub fn set(&self, names: impl IntoIterator<Item = (String, String)>) {
        let mut known: BTreeMap<String, BTreeSet<String>> = BTreeMap::new();
        for (address, name) in names.into_iter().filter(|(address, name)| address != name) {
            known.entry(address).or_default().insert(name);
        }
        self.0.write().unwrap_or_else(PoisonError::into_inner).names = known;
    }

    /// All events are about this vessel.
    pub fn steers(&self, own: &str) {
        self.0.write().unwrap_or_else(PoisonError::into_inner).own = Some(own.to_owned());
    }

    /// What an event about this address, or none, is found by.
    fn of(&self, address: Option<&String>) -> Vec<String> {
        let known = self.0.read().unwrap_or_else(PoisonError::into_inner);
        let names = address.and_then(|address| known.names.get(address)).into_iter().flatten();
        known.own.iter().chain(address).chain(names).cloned().collect()
    }
}

/// Writes events into the journal.
#[derive(Debug)]
pub struct Journal {
    socket: UnixDatagram,
    /// Where each event goes: a journal that was started again has another socket there.
    path: PathBuf,
    identifier: &'static str,
    names: VesselNames,
    lost: AtomicU64,
}

impl Journal {
    /// The journal, where the service manager connected standard error to it; `None` where it did not, or the journal
    /// does not listen: then the log is text. `identifier` is the program's name.
    pub fn of_service(identifier: &'static str, names: VesselNames) -> Option<Self> {
        let stream = std::env::var("JOURNAL_STREAM").ok()?;
        if !is_stderr(&stream) {
            return None;
        }
        Self::at(Path::new(SOCKET), identifier, names).ok()
    }

    fn at(path: &Path, identifier: &'static str, names: VesselNames) -> io::Result<Self> {
        let socket = UnixDatagram::unbound()?;
        socket.set_nonblocking(true)?;
        // Whether it listens at all.
        UnixDatagram::unbound()?.connect(path)?;
        Ok(Self { socket, path: path.to_owned(), identifier, names, lost: AtomicU64::new(0) })
    }

    /// The datagram of an event, after so many that were lost.
    fn entry(&self, event: &Event<'_>, spans: &[SpanValues], lost: u64) -> Vec<u8> {
        let mut found = Found::default();
        event.record(&mut found);
        let metadata = event.metadata();
        let mut line = found.line(metadata.target());
        for span in spans {
            line.push_str(&span.written);
        }
        if lost > 0 {
            write!(line, " ({lost} earlier lines were lost: the journal did not take them)").ok();
        }
        let mut out = Vec::with_capacity(512);
        put(&mut out, "MESSAGE", &harmless(&line, VALUE_BYTES));
        put(&mut out, "PRIORITY", priority(*metadata.level()));
        put(&mut out, "SYSLOG_IDENTIFIER", self.identifier);
        put(&mut out, "LUTRA_TARGET", metadata.target());
        for (name, value) in found.fields.iter().filter(|(name, _)| *name != VESSEL).take(MOST_FIELDS) {
            put(&mut out, &format!("LUTRA_{}", field_name(name)), &harmless(value, VALUE_BYTES));
        }
        for (name, value) in spans.iter().flat_map(|span| &span.fields).take(MOST_FIELDS) {
            put(&mut out, &format!("LUTRA_{}", field_name(name)), &harmless(value, VALUE_BYTES));
        }
        let address = found.fields.iter().find(|(name, _)| *name == VESSEL).map(|(_, value)| value);
        for vessel in self.names.of(address) {
            put(&mut out, "LUTRA_VESSEL", &harmless(&vessel, VALUE_BYTES));
        }
        if lost > 0 {
            put(&mut out, "LUTRA_EVENTS_LOST", &lost.to_string());
        }
        out
    }
}

impl<S: Subscriber + for<'l> LookupSpan<'l>> Layer<S> for Journal {
    fn on_new_span(&self, attributes: &Attributes<'_>, id: &Id, context: Context<'_, S>) {
        let mut found = Found::default();
        attributes.record(&mut found);
        let name = attributes.metadata().name();
        let fields =
            found.fields.into_iter().map(|(field, value)| (format!("{name}_{field}"), value)).collect();
        if let Some(span) = context.span(id) {
            span.extensions_mut()
                .insert(SpanValues { written: format!(" {name}:{}", found.written), fields });
        }
    }

    fn on_event(&self, event: &Event<'_>, context: Context<'_, S>) {
        let scope = context.event_scope(event).into_iter().flat_map(Scope::from_root);
        let spans: Vec<SpanValues> =
            scope.filter_map(|span| span.extensions().get::<SpanValues>().cloned()).collect();
        let lost = self.lost.load(Ordering::Relaxed);
        match self.socket.send_to(&self.entry(event, &spans, lost), &self.path) {
            Ok(_) => self.lost.fetch_sub(lost, Ordering::Relaxed),
            Err(_) => self.lost.fetch_add(1, Ordering::Relaxed),
        };
    }
}

/// The values of a span, as each event within it has them.
#[derive(Debug, Clone)]
struct SpanValues {
    /// As text logs write them.
    written: String,
    /// By the names of span and field.
    fields: Vec<(String, String)>,
}

/// Whether standard error is what JOURNAL_STREAM names, as `device:inode`: a program that inherited the variable and writes
/// elsewhere is not the journal's.
fn is_stderr(stream: &str) -> bool {
    let own = || {
        let file = File::from(io::stderr().as_fd().try_clone_to_owned().ok()?).metadata().ok()?;
        Some(format!("{}:{}", file.dev(), file.ino()))
    };
    own().is_some_and(|own| own == stream)
}

/// As syslog counts.
fn priority(level: Level) -> &'static str {
    match level {
        Level::ERROR => "3",
        Level::WARN => "4",
        Level::INFO => "6",
        Level::DEBUG | Level::TRACE => "7",
    }
}

/// A name as the journal takes it: capitals, digits and `_`.
fn field_name(name: &str) -> String {
    let letter =
        |letter: char| if letter.is_ascii_alphanumeric() { letter.to_ascii_uppercase() } else { '_' };
    name.chars().map(letter).take(50).collect()
}

/// Appends a field. A value with line ends goes behind its length.
fn put(out: &mut Vec<u8>, name: &str, value: &str) {
    out.extend(name.as_bytes());
    if value.contains('\n') {
        out.push(b'\n');
        out.extend((value.len() as u64).to_le_bytes());
    } else {
        out.push(b'=');
    }
    out.extend(value.as_bytes());
    out.push(b'\n');
}

/// What an event has: its message, and its values by name.
#[derive(Default)]
struct Found {
    message: String,
    fields: Vec<(&'static str, String)>,
    /// The same as text logs write them.
    written: String,
}

impl Found {
    fn line(&self, target: &str) -> String {
        format!("{target}: {}{}", self.message, self.written)
    }

    fn take(&mut self, field: &Field, value: String, written: &dyn Debug) {
        if field.name() == "message" {
            self.message = value;
            return;
        }
        write!(self.written, " {}={written:?}", field.name()).ok();
        self.fields.push((field.name(), value));
    }
}

impl Visit for Found {
    fn record_str(&mut self, field: &Field, value: &str) {
        self.take(field, value.to_owned(), &value);
    }

    fn record_debug(&mut self, field: &Field, value: &dyn Debug) {
        self.take(field, format!("{value:?}"), value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tempfile::TempDir;
    use tracing_subscriber::prelude::*;

    /// A journal that keeps datagrams.
    struct Fake {
        folder: TempDir,
        socket: UnixDatagram,
    }

    impl Fake {
        fn start() -> Self {
            let folder = tempfile::tempdir().unwrap();
            let socket = UnixDatagram::bind(folder.path().join("socket")).unwrap();
            socket.set_nonblocking(true).unwrap();
            Self { folder, socket }
        }

        fn client(&self, names: VesselNames) -> Journal {
            Journal::at(&self.folder.path().join("socket"), "lutra-x", names).unwrap()
        }

        fn next(&self) -> Option<Vec<String>> {
            let mut bytes = vec![0; 65_536];
            let length = self.socket.recv(&mut bytes).ok()?;
            Some(String::from_utf8_lossy(&bytes[..length]).lines().map(str::to_owned).collect())
        }
    }

    #[test]
    fn an_event_has_its_values_as_fields_and_its_line_as_message() {
        let fake = Fake::start();
        let names = VesselNames::default();
        let called = |name: &str| ("0x2810".to_owned(), name.to_owned());
        names.set(["otter-1", "grey-otter", "0x2810"].map(called));
        let log = tracing_subscriber::registry().with(fake.client(names));
        tracing::subscriber::with_default(log, || {
            tracing::warn!(command = 1_790_000_000_000_u64, vessel = %"0x2810", why = "no room", "refused");
        });
        let entry = fake.next().unwrap();
        for line in [
            "MESSAGE=service::journal::tests: refused command=1790000000000 vessel=0x2810 why=\"no room\"",
            "PRIORITY=4",
            "SYSLOG_IDENTIFIER=lutra-x",
            "LUTRA_COMMAND=1790000000000",
            "LUTRA_VESSEL=0x2810",
            "LUTRA_VESSEL=otter-1",
            "LUTRA_VESSEL=grey-otter",
            "LUTRA_WHY=no room",
        ] {
            assert!(entry.contains(&line.to_owned()), "{line}: {entry:?}");
        }
    }

    #[test]
    fn the_text_of_a_vessel_adds_no_field_and_an_agent_names_its_own() {
        let fake = Fake::start();
        let names = VesselNames::default();
        names.steers("otter-2");
        let log = tracing_subscriber::registry().with(fake.client(names));
        let text = "x\nPRIORITY=0\nLUTRA_VESSEL=other\u{1b}[2J";
        tracing::subscriber::with_default(log, || tracing::info!(text, name = %text, "{text}"));
        let entry = fake.next().unwrap();
        let begin = |name: &str| entry.iter().filter(|line| line.starts_with(name)).count();
        assert_eq!((begin("PRIORITY="), begin("LUTRA_VESSEL=")), (1, 1), "{entry:?}");
        assert!(entry.contains(&"LUTRA_VESSEL=otter-2".to_owned()), "{entry:?}");
    }

    #[test]
    fn a_journal_that_takes_nothing_holds_nothing_up_and_what_it_lost_is_told() {
        let fake = Fake::start();
        let log = tracing_subscriber::registry().with(fake.client(VesselNames::default()));
        tracing::subscriber::with_default(log, || {
            for number in 0..5_000 {
                tracing::info!(number, "an event");
            }
            let taken = std::iter::from_fn(|| fake.next()).count();
            assert!(taken < 5_000, "this test needs a queue that is full");
            tracing::info!("the next one");
            let lost = format!("LUTRA_EVENTS_LOST={}", 5_000 - taken);
            assert!(fake.next().unwrap().contains(&lost));
            tracing::info!("and one more");
            assert!(!fake.next().unwrap().iter().any(|line| line.starts_with("LUTRA_EVENTS_LOST")));
        });
    }
}
