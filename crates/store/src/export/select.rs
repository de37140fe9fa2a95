//! The selection: checked against the recorded data, before anything is written.
//!
//! A slip of the finger is an error that names what may have been meant, never an empty file.

use crate::error::{Result, StoreError};
use crate::history::{GroupKey, Names};
use crate::range::TimeRange;
use crate::reader::Reader;
use imc::Address;
use imc::catalogue::{MESSAGES, MessageDesc};
use std::collections::{BTreeMap, BTreeSet};
use tables::Style;

/// The name by which all that the catalogue does not explain is asked for, beside messages' names.
pub const RAW: &str = "_raw";

/// The selection. An empty list means all.
#[derive(Debug, Clone)]
pub struct Selection {
    /// Messages by name or number; `_raw` alone for those that the catalogue does not explain.
    pub messages: Vec<String>,
    /// Systems.
    pub systems: Vec<Address>,
    /// Entities by number, or by a label in any case: then their messages while they had it.
    pub entities: Vec<String>,
    /// Fields by name, for all messages that have them (`psi`) or for one (`EulerAngles.psi`).
    pub fields: Vec<String>,
    /// By the senders' clocks.
    pub range: TimeRange,
}

impl Default for Selection {
    /// Everything.
    fn default() -> Self {
        Self {
            messages: Vec::new(),
            systems: Vec::new(),
            entities: Vec::new(),
            fields: Vec::new(),
            range: TimeRange::ALL,
        }
    }
}

/// Most names that a refusal lists.
const TOLD: usize = 30;

fn wrong(name: &str, text: impl std::fmt::Display) -> StoreError {
    StoreError::Query(format!("{name}: {text}"))
}

impl Selection {
    /// The same in the words of the catalogue and the history.
    ///
    /// # Errors
    /// It names a message, a field, a system or an entity that there is not; the error says which may have been meant.
    pub fn known(&self, reader: &mut Reader) -> Result<Self> {
        let mut known = self.clone();
        known.messages = self.messages.iter().map(message).collect::<Result<_>>()?;
        if known.messages.iter().any(|name| name == RAW)
            && (known.messages.len() > 1 || !self.fields.is_empty())
        {
            let text = format!("`{RAW}` has columns of its own: ask for it alone and without fields");
            return Err(wrong("message", text));
        }
        known.fields =
            self.fields.iter().map(|field| known_field(&known.messages, field)).collect::<Result<_>>()?;
        check_systems(reader, &self.systems)?;
        check_entities(&reader.names()?, self)?;
        Ok(known)
    }

    /// Whether what the catalogue does not explain is asked for, which has a table of its own.
    pub(crate) fn is_raw(&self) -> bool {
        self.messages.iter().any(|name| name == RAW)
    }

    /// Whether a message is asked for.
    pub(crate) fn has_message(&self, id: u16) -> bool {
        let named = |name: &String| imc::catalogue::by_abbrev(name).is_some_and(|desc| desc.id == id);
        self.messages.is_empty() || self.messages.iter().any(named)
    }

    /// Whether a column of a message is asked for.
    pub(crate) fn has_field(&self, desc: &MessageDesc, column: &str) -> bool {
        let wanted = |wanted: &String| match wanted.split_once('.') {
            Some((message, field)) => message == desc.abbrev && field == column,
            None => wanted == column,
        };
        self.fields.is_empty() || self.fields.iter().any(wanted)
    }

    /// Whether a series is asked for, at some time.
    pub(crate) fn has_series(&self, names: &Names, group: GroupKey) -> bool {
        self.has_message(group.id) && !self.spans(names, group.src, group.src_ent).is_empty()
    }

    /// The times in which an entity of a system belongs to the selection. After a restart a number can belong to another part,
    /// so a label counts only while the entity had it.
    pub(crate) fn spans(&self, names: &Names, src: u16, src_ent: u8) -> Vec<TimeRange> {
        if !self.systems.is_empty() && !self.systems.contains(&Address(src)) {
            return Vec::new();
        }
        if self.entities.is_empty() || self.entities.iter().any(|wanted| wanted.parse() == Ok(src_ent)) {
            return vec![TimeRange::ALL];
        }
        let Some(runs) = names.entities.get(&(src, src_ent)) else { return Vec::new() };
        let starts: Vec<i64> = runs.runs.keys().copied().collect();
        let span = |at: usize| TimeRange {
            from_us: if at == 0 { i64::MIN } else { starts[at] },
            to_us: starts.get(at + 1).copied().unwrap_or(i64::MAX),
        };
        let wanted = |label: &str| self.entities.iter().any(|wanted| wanted.eq_ignore_ascii_case(label));
        let labels = runs.runs.values().enumerate();
        labels.filter(|(_, run)| wanted(&run.name)).map(|(at, _)| span(at)).collect()
    }

    /// Whether an entity of a system is asked for at a time.
    pub(crate) fn says(&self, names: &Names, src: u16, src_ent: u8, time_us: i64) -> bool {
        self.spans(names, src, src_ent).iter().any(|span| span.contains(time_us))
    }
}

fn message(name: &String) -> Result<String> {
    if name == RAW {
        return Ok(RAW.to_owned());
    }
    tables::message(name).map(|desc| desc.abbrev.to_owned()).map_err(|error| wrong("message", error))
}

/// A field with the name of its message as the catalogue spells it.
fn known_field(messages: &[String], wanted: &str) -> Result<String> {
    let (of, name) = wanted.split_once('.').map_or((None, wanted), |(of, name)| (Some(of), name));
    let of = of
        .map(tables::message)
        .transpose()
        .map_err(|error| wrong("field", format!("`{wanted}`: {error}")))?;
    let asked: Vec<&MessageDesc> = match of {
        Some(desc) => vec![desc],
        None => MESSAGES.to_vec(),
    };
    let is_asked =
        |desc: &MessageDesc| messages.is_empty() || messages.iter().any(|name| name == desc.abbrev);
    let columns: BTreeSet<&str> =
        asked.iter().filter(|desc| is_asked(desc)).flat_map(|desc| column_names(desc)).collect();
    if columns.contains(name) {
        return Ok(of.map_or_else(|| name.to_owned(), |desc| format!("{}.{name}", desc.abbrev)));
    }
    let whose = match (of, messages) {
        (Some(desc), _) if !is_asked(desc) => format!("{} is not among the messages asked for", desc.abbrev),
        (Some(desc), _) => format!("{} has no field `{}`", desc.abbrev, shown(name)),
        (None, []) => format!("no message has a field `{}`", shown(name)),
        (None, [one]) => format!("{one} has no field `{}`", shown(name)),
        (None, several) => format!("none of {} has a field `{}`", several.join(", "), shown(name)),
    };
    let alike = suggest::alike(name, columns.iter().copied());
    let remedy = match alike.as_slice() {
        [] if (1..=TOLD).contains(&columns.len()) => {
            format!("there are {}", columns.into_iter().collect::<Vec<_>>().join(", "))
        }
        [] => "`imc info MESSAGE` and GET /api/v1/series tell a message's fields".to_owned(),
        names => format!("did you mean `{}`?", names.join("` or `")),
    };
    Err(wrong("field", format!("{whose}; {remedy}")))
}

fn column_names(desc: &MessageDesc) -> Vec<&'static str> {
    let known = imc::catalogue::by_id(desc.id);
    known.map_or_else(Vec::new, |desc| {
        tables::fields(desc, Style::default()).iter().map(|field| field.name).collect()
    })
}

fn check_systems(reader: &mut Reader, systems: &[Address]) -> Result<()> {
    if systems.is_empty() {
        return Ok(());
    }
    let recorded: BTreeSet<u16> = reader.extents()?.keys().map(|group| group.src).collect();
    match systems.iter().find(|system| !recorded.contains(&system.0)) {
        None => Ok(()),
        Some(system) => Err(wrong("vessel", format!("nothing is recorded of {system} ({:#06x})", system.0))),
    }
}

fn check_entities(names: &Names, selection: &Selection) -> Result<()> {
    let of = |src: u16| selection.systems.is_empty() || selection.systems.contains(&Address(src));
    let runs =
        names.entities.iter().filter(|((src, _), _)| of(*src)).flat_map(|(_, runs)| runs.runs.values());
    let labels: BTreeSet<&str> = runs.map(|run| run.name.as_str()).collect();
    let is_known = |wanted: &str| {
        wanted.parse::<u8>().is_ok() || labels.iter().any(|label| label.eq_ignore_ascii_case(wanted))
    };
    let Some(unknown) = selection.entities.iter().find(|wanted| !is_known(wanted)) else { return Ok(()) };
    let remedy = match suggest::alike(unknown, labels.iter().copied()).as_slice() {
        [] if labels.is_empty() => "no labels were reported; give a number, 0 to 255".to_owned(),
        [] => format!(
            "there are {}; or give a number, 0 to 255",
            labels.iter().take(TOLD).copied().collect::<Vec<_>>().join(", ")
        ),
        names => format!("did you mean `{}`?", names.join("` or `")),
    };
    Err(wrong("entity", format!("no entity is called `{}`; {remedy}", shown(unknown))))
}

/// The system that a text names, of those that are `known` by names: one of its names in any case, or its address,
/// decimal or hexadecimal after `0x`.
///
/// # Errors
/// No system has that name; the error lists those that are known.
pub fn system(known: &BTreeMap<Address, Vec<String>>, text: &str) -> Result<Address> {
    let text = text.trim();
    let called = |names: &[String]| names.iter().any(|name| name.eq_ignore_ascii_case(text));
    if let Some((address, _)) = known.iter().find(|(_, names)| called(names)) {
        return Ok(*address);
    }
    if let Some(address) = text.parse().ok().filter(|address| known.contains_key(address)) {
        return Ok(address);
    }
    let names: Vec<&str> = known.values().flatten().map(String::as_str).collect();
    let remedy = match suggest::alike(text, names.into_iter()).as_slice() {
        [] if known.is_empty() => "nothing at all is recorded that you may see".to_owned(),
        [] => {
            let told = known.iter().take(TOLD).map(|(address, names)| match names.first() {
                Some(name) => format!("{name} ({:#06x})", address.0),
                None => format!("{:#06x}", address.0),
            });
            format!("there are {}", told.collect::<Vec<_>>().join(", "))
        }
        names => format!("did you mean `{}`?", names.join("` or `")),
    };
    Err(wrong("vessel", format!("nothing is recorded of `{}`; {remedy}", shown(text))))
}

/// The beginning of a user's text, enough to find it by.
fn shown(text: &str) -> String {
    text.chars().take(60).collect()
}
