//! The history as rows with one set of columns, for programs that draw tables: Grafana, notebooks, spreadsheets.
//!
//! [`Asked`] is a validated question, [`Asked::rows`] its answer from the same buckets that plots have. [`choices`] lists what can be asked for,
//! [`detections()`] has a row for each detection, [`csv`] writes rows as CSV.

mod csv;
mod rows;
mod series;
#[cfg(test)]
mod tests;

pub use csv::{CsvRow, csv};
pub use rows::{Asked, detections};
pub use series::{SeriesName, choices};

use series::{Found, found};

use super::export;
use api::Vessel;
use imc::Address;
use std::collections::{BTreeMap, BTreeSet};
use store::{Reader, StoreError, TimeRange};
use units::UtcTime;

/// The last time that JavaScript represents exactly (µs since 1970 UTC).
const LAST_US: i64 = 9_007_199_254_740_991;

/// The error of an invalid question, with the name of the parameter.
fn wrong(name: &str, text: impl std::fmt::Display) -> StoreError {
    StoreError::Query(format!("{name}: {text}"))
}

/// Most names of one parameter, and the letters of the longest: more is refused before any of them is looked up.
const NAMES: usize = 500;
const NAME_LETTERS: usize = 300;

/// The values of a parameter that is given several times, or once with commas between them; each once.
///
/// # Errors
/// There are more than 500, or one is too long to be a name; the error names the parameter.
pub fn several(name: &str, texts: &[String]) -> store::Result<Vec<String>> {
    let (mut seen, mut all) = (BTreeSet::new(), Vec::new());
    for value in texts.iter().flat_map(|text| export::list(Some(text))) {
        if value.chars().count() > NAME_LETTERS {
            let shown: String = value.chars().take(60).collect();
            let text = format_args!("`{shown}…` is longer than {NAME_LETTERS} letters, which no name is");
            return Err(wrong(name, text));
        }
        if !seen.insert(value.clone()) {
            continue;
        }
        if all.len() == NAMES {
            return Err(wrong(name, format_args!("more than {NAMES} names; ask for fewer at once")));
        }
        all.push(value);
    }
    Ok(all)
}

/// A range of time from two texts: milliseconds since 1970 UTC, or ISO 8601.
///
/// # Errors
/// One is neither, or is not from 1970 to 2255, or the range ends before it begins; the error names the parameter.
pub fn range(from: &str, to: &str) -> store::Result<TimeRange> {
    let range = TimeRange { from_us: time("from", from)?, to_us: time("to", to)? };
    if range.to_us < range.from_us { Err(wrong("to", "is before `from`")) } else { Ok(range) }
}

/// Whole numbers up to this are not times in milliseconds: today's seconds since 1970 are among them (ms).
const EARLIEST_MS: i64 = 10_000_000_000;

fn time(name: &str, text: &str) -> store::Result<i64> {
    let text = text.trim();
    let is_whole = !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let time_us = if is_whole {
        // A small number is a year, a date or seconds.
        let ms = text.parse::<i64>().ok().filter(|ms| *ms == 0 || *ms > EARLIEST_MS);
        ms.and_then(|ms| ms.checked_mul(1_000))
    } else {
        text.parse::<UtcTime>().ok().map(UtcTime::micros)
    };
    time_us.filter(|time_us| (0..=LAST_US).contains(time_us)).ok_or_else(|| {
        let shown: String = text.chars().take(60).collect();
        let text = format_args!(
            "`{shown}` is not a time from 1970 to 2255; give milliseconds since 1970 UTC, or ISO 8601 such as 2026-11-21T08:00:00Z"
        );
        wrong(name, text)
    })
}

/// What rows call the vessels: by the name on the pages, else as they announced.
///
/// # Errors
/// The history cannot be read.
fn called(reader: &mut Reader, named: &[Vessel]) -> store::Result<BTreeMap<Address, String>> {
    let mut names: BTreeMap<Address, String> =
        reader.systems()?.into_iter().map(|system| (system.address, system.name)).collect();
    for vessel in named.iter().filter(|vessel| !vessel.name.is_empty()) {
        names.insert(Address(vessel.address), vessel.name.clone());
    }
    Ok(names)
}

/// Vessels to choose from, by name: those with a name on the pages, and others of which something is recorded unless they are consoles, as
/// far as `may` admits them. The value is the IMC address.
///
/// # Errors
/// The history cannot be read.
pub fn vessels(
    reader: &mut Reader,
    named: &[Vessel],
    may: &dyn Fn(u16) -> bool,
) -> store::Result<Vec<api::TableChoice>> {
    let names = called(reader, named)?;
    let is_named = |address: Address| named.iter().any(|vessel| vessel.address == address.0);
    let offered = names.into_iter().filter(|(address, _)| may(address.0));
    let offered = offered.filter(|(address, _)| is_named(*address) || !address.is_ccu());
    let choice =
        |(address, text): (Address, String)| api::TableChoice { text, value: format!("{:#06x}", address.0) };
    let mut choices: Vec<_> = offered.map(choice).collect();
    choices.sort();
    Ok(choices)
}
