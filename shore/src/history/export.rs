//! What somebody wants to take out, checked and in the words of the store.
//!
//! Every error names the parameter and says what to do instead.

use crate::identity::vessels::address;
use api::{ExportQuery, LogQuery};
use imc::Address;
use std::num::NonZeroI64;
use std::str::FromStr;
use store::{Angles, CsvOptions, Reader, Selection, Shape, StoreError, TimeRange};
use units::UtcTime;

/// What the catalogue does not explain, in the words of the store.
const RAW: &str = "_raw";

/// Seconds from a row to the next.
const EVERY_S: std::ops::RangeInclusive<f64> = 0.001..=86_400.0;

/// What is wrong with a question.
type Wrong = StoreError;

fn wrong(name: &str, text: impl std::fmt::Display) -> Wrong {
    StoreError::Query(format!("{name}: {text}"))
}

/// Things separated by commas.
pub fn list(text: Option<&str>) -> Vec<String> {
    let parts = text.unwrap_or_default().split(',').map(str::trim);
    parts.filter(|part| !part.is_empty()).map(str::to_owned).collect()
}

/// A message that the catalogue has.
///
/// # Errors
/// IMC has no such message; the error names a similar one.
pub fn message(name: &str) -> Result<&'static str, Wrong> {
    if let Some(desc) = imc::catalogue::by_abbrev(name) {
        return Ok(desc.abbrev);
    }
    let remedy = match suggest::nearest(name, imc::catalogue::MESSAGES.iter().map(|desc| desc.abbrev)) {
        Some(abbrev) => format!("did you mean `{abbrev}`?"),
        None => "GET /api/v1/recorded lists what is recorded".to_owned(),
    };
    Err(wrong("message", format_args!("IMC has no message `{}`; {remedy}", shown(name))))
}

/// Not more of what somebody sent than helps to find it.
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

/// The lists of a question; what an export may hold is decided by `Wanted`.
#[derive(Debug, Clone)]
pub struct Export {
    messages: Vec<String>,
    /// Empty for all that one may export.
    pub vessels: Vec<u16>,
    entities: Vec<String>,
    fields: Vec<String>,
    range: TimeRange,
    /// How the table is written.
    pub options: CsvOptions,
    /// Whether it is packed.
    pub gzip: bool,
}

impl Export {
    /// A table.
    ///
    /// # Errors
    /// What is wrong with which parameter.
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
            every_us: every(query.every_s)?,
        };
        Ok(Self {
            messages: messages.unwrap_or_default(),
            vessels: vessels(query.vessel.as_deref())?,
            entities: list(query.entity.as_deref()),
            fields: list(query.field.as_deref()),
            range: range(query.from.as_deref(), query.to.as_deref())?,
            options,
            gzip: query.gzip.unwrap_or(false),
        })
    }

    /// A log.
    ///
    /// # Errors
    /// What is wrong with which parameter.
    pub fn log(query: &LogQuery) -> Result<Self, Wrong> {
        Ok(Self {
            messages: messages(query.message.as_deref())?.unwrap_or_default(),
            vessels: vessels(query.vessel.as_deref())?,
            entities: list(query.entity.as_deref()),
            fields: Vec::new(),
            range: range(query.from.as_deref(), query.to.as_deref())?,
            options: CsvOptions::default(),
            gzip: query.gzip.unwrap_or(false),
        })
    }

    /// What to call the file, without an ending.
    pub fn file_name(&self) -> &str {
        match &self.messages[..] {
            [one] => one,
            _ => "lutra",
        }
    }

    /// What the store is asked for, of the vessels that `may` admits.
    ///
    /// # Errors
    /// It names an entity or field that is not there, or there is nothing that may be exported.
    pub fn selection(self, reader: &mut Reader, may: &dyn Fn(u16) -> bool) -> store::Result<Selection> {
        let systems: Vec<Address> = if self.vessels.is_empty() {
            reader.systems()?.into_iter().map(|system| system.address).filter(|one| may(one.0)).collect()
        } else {
            self.vessels.into_iter().map(Address).collect()
        };
        // The store takes an empty list for all; here it means that there is nothing this person may have.
        if systems.is_empty() {
            return Err(wrong("vessel", "nothing is recorded that you may export"));
        }
        let selection = Selection {
            messages: self.messages,
            systems,
            entities: self.entities,
            fields: self.fields,
            range: self.range,
        };
        check_entities(reader, &selection)?;
        check_fields(reader, &selection)?;
        Ok(selection)
    }
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

/// Vessels by their addresses; empty for all.
///
/// # Errors
/// One is no address.
pub fn vessels(text: Option<&str>) -> Result<Vec<u16>, Wrong> {
    list(text).iter().map(|text| address(text).map_err(|error| wrong("vessel", error))).collect()
}

/// Tags by protocol and number, or by number; empty for all.
///
/// # Errors
/// One is no tag.
pub fn tags(text: Option<&str>) -> Result<Vec<detections::TagFilter>, Wrong> {
    let tag = |text: &String| {
        text.parse().map_err(|error| wrong("tag", format_args!("`{}`: {error}", shown(text))))
    };
    list(text).iter().map(tag).collect()
}

fn check_entities(reader: &Reader, selection: &Selection) -> store::Result<()> {
    let mut named: Vec<&String> =
        selection.entities.iter().filter(|entity| entity.parse::<u8>().is_err()).collect();
    for system in &selection.systems {
        if named.is_empty() {
            return Ok(());
        }
        let known = reader.entities(*system)?;
        named.retain(|wanted| known.iter().all(|name| name.label != **wanted));
    }
    match named.first() {
        None => Ok(()),
        Some(name) => Err(wrong(
            "entity",
            format_args!(
                "none is called `{}`; GET /api/v1/vessels/VESSEL/entities lists their labels, or give its \
                 number, 0 to 255",
                shown(name)
            ),
        )),
    }
}

fn check_fields(reader: &Reader, selection: &Selection) -> store::Result<()> {
    for name in &selection.fields {
        let (message, field) = name.split_once('.').map_or((None, name.as_str()), |(m, f)| (Some(m), f));
        let all = imc::catalogue::MESSAGES.iter().map(|desc| desc.abbrev);
        let mut wanted = all.filter(|abbrev| {
            selection.messages.is_empty() || selection.messages.iter().any(|one| one == abbrev)
        });
        let has = |abbrev: &str| reader.table(abbrev).is_ok_and(|table| table.column(field).is_some());
        if !wanted.any(|abbrev| message.is_none_or(|message| message == abbrev) && has(abbrev)) {
            let text = format_args!(
                "none of the messages asked for has a field `{}`; GET /api/v1/series lists them",
                shown(name)
            );
            return Err(wrong("field", text));
        }
    }
    Ok(())
}
