//! Names of series as people write them, `Voltage.2.value`, and the series that they mean.

use super::wrong;
use crate::history;
use imc::Address;
use std::collections::{BTreeMap, BTreeSet};
use std::fmt;
use store::{Reader, Series, Source, StoreError};
use tokio_util::sync::CancellationToken;

/// Most series that are offered for choice.
const CHOICES: usize = 20_000;
/// Most series of vessels in one answer: each is read by itself.
const SERIES: usize = 500;
/// Most names that an error lists.
const LISTED: usize = 10;

/// A series as it was asked for: `Message.entity.field` or `Message.field`.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SeriesName {
    message: &'static str,
    /// A number or a label; absent for the entity that sent the message most often.
    entity: Option<String>,
    field: String,
}

impl SeriesName {
    /// Reads a name. A label may have dots and commas in it.
    ///
    /// # Errors
    /// It is not a name of a series, or IMC has no such message; the error says what to write.
    pub fn new(text: &str) -> store::Result<Self> {
        let shown: String = text.chars().take(60).collect();
        let unreadable = || {
            wrong(
                "series",
                format_args!(
                    "`{shown}` is not a series; write message, entity and field, such as Voltage.2.value, or message and field, such as \
                     EstimatedState.psi. /api/v1/table/series lists them"
                ),
            )
        };
        let (message, rest) = text.trim().split_once('.').ok_or_else(unreadable)?;
        let (entity, field) = match rest.rsplit_once('.') {
            Some((entity, field)) => (Some(entity.trim().to_owned()), field),
            None => (None, rest),
        };
        if message.is_empty() || field.is_empty() || entity.as_ref().is_some_and(String::is_empty) {
            return Err(unreadable());
        }
        let message = tables::message(message).map_err(|error| wrong("series", error))?.abbrev;
        Ok(Self { message, entity, field: field.to_owned() })
    }

    /// Checks that the message has such a field.
    fn check_field(&self, reader: &Reader) -> store::Result<()> {
        let columns = &reader.table(self.message)?.columns;
        let numbers = || columns.iter().filter(|column| column.is_number()).map(|column| column.name);
        if numbers().any(|name| name == self.field) {
            return Ok(());
        }
        let near = suggest::alike(&self.field, numbers());
        let remedy = if near.is_empty() {
            format!("it has {}", numbers().take(LISTED).collect::<Vec<_>>().join(", "))
        } else {
            format!("did you mean `{}`?", near.join("` or `"))
        };
        let field: String = self.field.chars().take(60).collect();
        Err(wrong(
            "series",
            format_args!("{} has no field `{field}` that holds numbers; {remedy}", self.message),
        ))
    }

    /// The number of the entity, where it is one.
    fn number(&self) -> Option<u8> {
        self.entity.as_deref()?.parse().ok()
    }

    /// The series that it means, of one vessel.
    fn of<'s>(&self, recorded: &Recorded<'s>, vessel: Address) -> Vec<&'s Series> {
        let sent = recorded.get(&(vessel.0, self.message)).into_iter().flatten().copied();
        match (&self.entity, self.number()) {
            (None, _) => sent.max_by_key(|one| one.extent.count).into_iter().collect(),
            (_, Some(number)) => sent.filter(|one| one.group.src_ent == number).collect(),
            (Some(label), None) => {
                let is_called =
                    |one: &&Series| one.label.as_ref().is_some_and(|own| own.eq_ignore_ascii_case(label));
                sent.filter(is_called).collect()
            }
        }
    }
}

/// A series that is recorded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Found {
    pub(super) source: Source,
    pub(super) field: String,
    /// The entity's last label, or its number.
    pub(super) entity: String,
}

impl fmt::Display for Found {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(out, "{}.{}.{}", self.source.message, self.source.entity, self.field)
    }
}

/// Series by vessel and message.
type Recorded<'s> = BTreeMap<(u16, &'static str), Vec<&'s Series>>;

/// The series that names mean, of these vessels; each once. A vessel that lacks one has fewer.
///
/// # Errors
/// A message has no such field, no vessel has an entity of that name, there are more than 500, the question was given up, or the history
/// cannot be read.
pub(super) fn found(
    reader: &mut Reader,
    names: &[SeriesName],
    vessels: &[Address],
    given_up: &CancellationToken,
) -> store::Result<Vec<Found>> {
    let series = reader.series(None)?;
    let mut recorded = Recorded::new();
    for one in &series {
        if let Some(message) = one.message {
            recorded.entry((one.group.src, message)).or_default().push(one);
        }
    }
    let (mut seen, mut all) = (BTreeSet::new(), Vec::new());
    for name in names {
        history::goes_on(given_up)?;
        name.check_field(reader)?;
        let mut is_anywhere = false;
        for vessel in vessels {
            for one in name.of(&recorded, *vessel) {
                is_anywhere = true;
                let entity = one.group.src_ent;
                if seen.insert((*vessel, name.message, entity, name.field.as_str())) {
                    if all.len() == SERIES {
                        let text = format_args!(
                            "more than {SERIES} series of these vessels; ask for fewer series or vessels at once"
                        );
                        return Err(wrong("series", text));
                    }
                    all.push(Found {
                        source: Source { system: *vessel, entity, message: name.message.to_owned() },
                        field: name.field.clone(),
                        entity: one.label.clone().unwrap_or_else(|| entity.to_string()),
                    });
                }
            }
        }
        if !is_anywhere {
            name.check_label(&series, vessels)?;
        }
    }
    Ok(all)
}

impl SeriesName {
    /// Refuses a label that no entity has. A number that sent nothing yet is no mistake.
    fn check_label(&self, series: &[Series], vessels: &[Address]) -> store::Result<()> {
        let (Some(label), None) = (&self.entity, self.number()) else { return Ok(()) };
        let of_vessels = |one: &&Series| vessels.contains(&Address(one.group.src));
        let sent = series.iter().filter(of_vessels).filter(|one| one.message == Some(self.message));
        let labels: BTreeSet<&str> = sent.filter_map(|one| one.label.as_deref()).collect();
        let near = suggest::alike(label, labels.iter().copied());
        let remedy = if !near.is_empty() {
            format!("did you mean `{}`?", near.join("` or `"))
        } else if labels.is_empty() {
            "give the number of the entity".to_owned()
        } else {
            format!("there are {}", labels.into_iter().take(LISTED).collect::<Vec<_>>().join(", "))
        };
        let shown: String = label.chars().take(60).collect();
        Err(wrong(
            "series",
            format_args!(
                "no entity with the label `{shown}` sent {} on these vessels; {remedy}",
                self.message
            ),
        ))
    }
}

/// The series of these vessels to choose from, by name: all fields that hold numbers.
///
/// # Errors
/// There are more than 20,000, the question was given up, or the history cannot be read.
pub fn choices(
    reader: &mut Reader,
    vessels: &[Address],
    given_up: &CancellationToken,
) -> store::Result<Vec<api::TableChoice>> {
    let mut known: BTreeMap<String, String> = BTreeMap::new();
    let sent = reader.series(None)?;
    for one in sent.iter().filter(|one| one.dated.count > 0 && vessels.contains(&Address(one.group.src))) {
        history::goes_on(given_up)?;
        let (Some(message), Some(table)) = (one.message, reader.table_of(one.group)) else { continue };
        let entity = one.group.src_ent;
        let label = one.label.clone().unwrap_or_else(|| entity.to_string());
        for column in table.columns.iter().filter(|column| column.is_number()) {
            let unit = column.unit.map(|unit| format!(" [{unit}]")).unwrap_or_default();
            let text = format!("{message} {label} {}{unit}", column.name);
            known.entry(format!("{message}.{entity}.{}", column.name)).or_insert(text);
        }
        if known.len() > CHOICES {
            let text = format!("these vessels have more than {CHOICES} series; name fewer vessels");
            return Err(StoreError::Query(format!("vessel: {text}")));
        }
    }
    let mut choices: Vec<_> =
        known.into_iter().map(|(value, text)| api::TableChoice { text, value }).collect();
    choices.sort();
    Ok(choices)
}
