//! Export requests, validated and translated for the store.
//!
//! Every error names the parameter and says what to do instead.

use crate::error::asked_wrong;
use api::{ExportQuery, LogQuery, Said, Vessel, say};
use imc::Address;
use std::collections::BTreeMap;
use std::num::NonZeroI64;
use std::str::FromStr;
use store::{Angles, CsvOptions, RAW, Reader, Selection, Shape, StoreError, TimeRange};
use tables::Dialect;
use units::UtcTime;

/// Tags in one question: each detection is compared with each.
const TAGS: usize = 200;
/// Seconds from a row to the next.
const EVERY_S: std::ops::RangeInclusive<f64> = 0.001..=86_400.0;

/// The error of an invalid request.
type Wrong = StoreError;

fn wrong(name: &str, text: impl std::fmt::Display) -> Wrong {
    StoreError::Query(format!("{name}: {text}"))
}

/// Names with commas between them; a comma within a name is written `\,`, and `\\` is a backslash. Other backslashes stand for themselves.
pub fn list(text: Option<&str>) -> Vec<String> {
    let (mut names, mut name) = (Vec::new(), String::new());
    let mut letters = text.unwrap_or_default().chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '\\' => name.push(letters.next_if(|next| [',', '\\'].contains(next)).unwrap_or(letter)),
            ',' => names.push(std::mem::take(&mut name)),
            _ => name.push(letter),
        }
    }
    names.push(name);
    names.retain_mut(|name| {
        *name = name.trim().to_owned();
        !name.is_empty()
    });
    names
}

/// A message that the catalogue has, by name or number.
///
/// # Errors
/// IMC has no such message; the error names a similar one.
pub fn message(name: &str) -> Result<&'static str, Wrong> {
    tables::message(name).map(|desc| desc.abbrev).map_err(|error| wrong("message", error))
}

/// For whom a table is written.
///
/// # Errors
/// There is no such dialect.
pub fn dialect(spreadsheet: Option<&str>) -> Result<Dialect, Wrong> {
    match spreadsheet.map_or("", str::trim) {
        "" => Ok(Dialect::Plain),
        "comma" => Ok(Dialect::SpreadsheetComma),
        "point" => Ok(Dialect::SpreadsheetPoint),
        text => {
            let text = format_args!("`{}` is neither `comma` nor `point`, the decimal sign", shown(text));
            Err(wrong("spreadsheet", text))
        }
    }
}

/// Shortens a client's text for an error message.
fn shown(text: &str) -> String {
    text.chars().take(60).collect()
}

fn time(name: &str, text: Option<&str>) -> Result<Option<UtcTime>, Wrong> {
    let Some(text) = text.map(str::trim).filter(|text| !text.is_empty()) else { return Ok(None) };
    UtcTime::from_str(text).map(Some).map_err(|error| wrong(name, format_args!("`{}`: {error}", shown(text))))
}

fn range(from: Option<&str>, to: Option<&str>) -> Result<TimeRange, Wrong> {
    let range = TimeRange::new(time("from", from)?, time("to", to)?);
    if range.from_us > range.to_us {
        return Err(wrong("to", "is before `from`"));
    }
    Ok(range)
}

/// Seconds between rows, in the unit of the store.
fn every(seconds: Option<f64>) -> Result<Option<NonZeroI64>, Wrong> {
    let Some(seconds) = seconds else { return Ok(None) };
    if !EVERY_S.contains(&seconds) {
        return Err(wrong(
            "every_s",
            format_args!("{seconds} is not within {} to {} s", EVERY_S.start(), EVERY_S.end()),
        ));
    }
    Ok(NonZeroI64::new((seconds * 1e6).round() as i64))
}

fn one_of<T>(name: &str, text: Option<&str>, choices: [(&str, T); 2]) -> Result<T, Wrong> {
    let [first, second] = choices;
    let words = format!("`{}` nor `{}`", first.0, second.0);
    match text.map_or("", str::trim) {
        "" => Ok(first.1),
        text if text == first.0 => Ok(first.1),
        text if text == second.0 => Ok(second.1),
        text => Err(wrong(name, format_args!("`{}` is neither {words}", shown(text)))),
    }
}

/// A parsed export request; what it may contain is decided by `Wanted`.
#[derive(Debug, Clone)]
pub struct Export {
    messages: Vec<String>,
    /// As given; empty for all that the user may export.
    pub vessels: Vec<String>,
    entities: Vec<String>,
    fields: Vec<String>,
    range: TimeRange,
    /// How the table is written.
    pub options: CsvOptions,
    /// Whether it is compressed.
    pub gzip: bool,
}

impl Export {
    /// A table.
    ///
    /// # Errors
    /// The error names the parameter.
    pub fn csv(query: &ExportQuery) -> Result<Self, Wrong> {
        let messages = messages(Some(&query.message))?;
        if messages.is_none() {
            let text = "name messages, separated by commas, or `*` for all that the catalogue explains, or `_raw` \
                        for the rest";
            return Err(wrong("message", text));
        }
        let degrees = ("deg", Angles::Degrees);
        let long = ("long", Shape::Long);
        let options = CsvOptions {
            shape: one_of("shape", query.shape.as_deref(), [("wide", Shape::Wide), long])?,
            angles: one_of("angles", query.angles.as_deref(), [("rad", Angles::Radians), degrees])?,
            units: query.units.unwrap_or(true),
            labels: query.labels.unwrap_or(false),
            guard: query.guard.unwrap_or(true),
            received: query.received.unwrap_or(false),
            dialect: dialect(query.spreadsheet.as_deref())?,
            every_us: every(query.every_s)?,
        };
        Ok(Self {
            messages: messages.unwrap_or_default(),
            vessels: list(query.vessel.as_deref()),
            entities: list(query.entity.as_deref()),
            fields: list(query.field.as_deref()),
            range: range(query.from.as_deref(), query.to.as_deref())?,
            options,
            gzip: query.gzip.unwrap_or(false),
        })
    }

    /// A table as Parquet.
    ///
    /// # Errors
    /// The error names the parameter.
    pub fn parquet(query: &ExportQuery) -> Result<Self, Wrong> {
        let export = Self::csv(query)?;
        store::check_parquet(&export.messages, &export.options)?;
        Ok(export)
    }

    /// A log.
    ///
    /// # Errors
    /// The error names the parameter.
    pub fn log(query: &LogQuery) -> Result<Self, Wrong> {
        Ok(Self {
            messages: messages(query.message.as_deref())?.unwrap_or_default(),
            vessels: list(query.vessel.as_deref()),
            entities: list(query.entity.as_deref()),
            fields: Vec::new(),
            range: range(query.from.as_deref(), query.to.as_deref())?,
            options: CsvOptions::default(),
            gzip: query.gzip.unwrap_or(false),
        })
    }

    /// The file's name, without extension.
    pub fn file_name(&self) -> &str {
        match &self.messages[..] {
            [one] => one,
            _ => "lutra",
        }
    }

    /// The selection for the store, of the vessels that `may` admits; the store reports what does not exist.
    ///
    /// # Errors
    /// A vessel does not exist, or there is nothing that may be exported.
    pub fn selection(
        self,
        reader: &mut Reader,
        named: &[Vessel],
        may: &dyn Fn(u16) -> bool,
    ) -> store::Result<Selection> {
        let systems = systems(reader, &self.vessels, named, may)?;
        // To the store an empty list means all; here it means nothing that this person may have.
        if systems.is_empty() {
            let text = say("nothing is recorded that you may export");
            return Err(asked_wrong(Said::from(text).of_field("vessel")));
        }
        Ok(Selection {
            messages: self.messages,
            systems,
            entities: self.entities,
            fields: self.fields,
            range: self.range,
        })
    }
}

/// The requested vessels, by name or address, among those that are recorded or `named` and that `may` admits; all recorded
/// ones if none is requested.
///
/// # Errors
/// One does not exist; the error lists those that do.
pub fn systems(
    reader: &mut Reader,
    asked: &[String],
    named: &[Vessel],
    may: &dyn Fn(u16) -> bool,
) -> store::Result<Vec<Address>> {
    let mut known: BTreeMap<Address, Vec<String>> = BTreeMap::new();
    for system in reader.systems()?.into_iter().filter(|system| may(system.address.0)) {
        let registered = system.address.name().map(str::to_owned);
        known.insert(system.address, std::iter::once(system.name).chain(registered).collect());
    }
    if asked.is_empty() {
        return Ok(known.into_keys().collect());
    }
    for vessel in named.iter().filter(|vessel| may(vessel.address)) {
        known.entry(Address(vessel.address)).or_default().insert(0, vessel.name.clone());
    }
    asked.iter().map(|text| store::system(&known, text)).collect()
}

/// Addresses in the request: these can be refused before anything is looked up.
pub fn addresses(asked: &[String]) -> impl Iterator<Item = u16> {
    asked.iter().filter_map(|text| crate::identity::vessels::address(text).ok())
}

/// `None` for nothing, an empty list for all.
fn messages(text: Option<&str>) -> Result<Option<Vec<String>>, Wrong> {
    let names = list(text);
    if names.is_empty() {
        return Ok(None);
    }
    if names == ["*"] {
        return Ok(Some(Vec::new()));
    }
    if names == [RAW] {
        return Ok(Some(names));
    }
    names.iter().map(|name| message(name).map(str::to_owned)).collect::<Result<_, _>>().map(Some)
}

/// Tags by protocol and number, or by number; empty for all.
///
/// # Errors
/// One is not a tag, or there are more than 200.
pub fn tags(text: Option<&str>) -> Result<Vec<detections::TagFilter>, Wrong> {
    let names = list(text);
    if names.len() > TAGS {
        let text = say("{count} tags are more than {most}; ask for fewer, or by project")
            .with("count", names.len())
            .with("most", TAGS);
        return Err(asked_wrong(Said::from(text).of_field("tag")));
    }
    let tag = |text: &String| {
        research::tag(text).map_err(|why| {
            let wrong = say("`{tag}`: {error}").with("tag", shown(text)).with_said("error", why);
            asked_wrong(Said::from(wrong).of_field("tag"))
        })
    };
    names.iter().map(tag).collect()
}
