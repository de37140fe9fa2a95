//! The history made again from the archive.
//!
//! It grows in `history.new` beside the one in use, and takes its place when it is whole. An
//! interrupted rebuild continues where it stopped.

use crate::archive::{self, shortened};
use crate::aside;
use crate::error::{Named as _, Result, StoreError};
use crate::history::look::{self, Sound};
use crate::history::{Extent, load_progress};
use crate::layout::{ARCHIVE, GROWING, HISTORY, REPLACED, finish_swap};
use crate::reader::Reader;
use crate::store::Store;
use std::collections::BTreeMap;
use std::path::Path;
use std::{fs, io};

/// In the one that grows: why it did not take its place.
const REFUSED: &str = "refused";

/// The action after a refusal.
pub(crate) const ACCEPT: &str = "copy what is missing from a backup into the archive, or import the vessel's own log, \
                                 and run `lutra-server reindex` again; or give up what only the history holds by \
                                 `lutra-server reindex --accept-loss`, which goes on with history.new; or remove \
                                 history.new and keep the history";

/// The result of the rebuild.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reindexed {
    /// Packets read from the archive by this run.
    pub packets: u64,
    /// Samples that the history holds.
    pub samples: u64,
    /// Samples that it held before; 0 where files of it could not be read.
    pub before: u64,
}

/// Makes the history again from the archive. No other process may write to the folder; `progress` gets the number
/// of packets read and may stop by returning false.
///
/// # Errors
/// When files cannot be read or written, and [`StoreError::Cancelled`]. Also when the archive holds fewer samples
/// than the history, because old days were removed from it: with `accept_loss` the history then shrinks.
pub fn reindex(data: &Path, accept_loss: bool, progress: &mut dyn FnMut(u64) -> bool) -> Result<Reindexed> {
    finish_swap(data)?;
    let unusable = unusable(data)?;
    if !unusable.is_empty() && archive::is_trimmed(&data.join(ARCHIVE)) && !accept_loss {
        return Err(StoreError::Query(format!(
            "days were removed from the archive, and what {} held of them cannot be counted. The history is as it was; \
             to go on: lutra-server reindex --accept-loss, which keeps the file in {}",
            unusable.join(" and "),
            aside::ASIDE
        )));
    }
    let before = if unusable.is_empty() { samples(data, HISTORY)? } else { 0 };
    let shortened = shortened_days(data)?;
    match fs::remove_file(data.join(GROWING).join(REFUSED)) {
        Err(error) if error.kind() != io::ErrorKind::NotFound => {
            return Err(error).named(&data.join(GROWING));
        }
        _ => {}
    }
    let mut store = Store::open_growing(data, progress)?;
    let packets = store.repairs().replayed;
    store.settle()?;
    let grown = samples(data, GROWING)?;
    if grown < before && !accept_loss {
        let why = why_less(data, grown, before, &shortened)?;
        // Only for the doctor: the refusal holds without it.
        fs::write(data.join(GROWING).join(REFUSED), &why).ok();
        return Err(StoreError::Query(format!("{why} The history is as it was: {ACCEPT}")));
    }
    // The history that knew it goes.
    let written = shortened::written(&data.join(ARCHIVE))?;
    for (day, (was, is)) in shortened.iter().filter(|(day, bytes)| written.get(*day) != Some(*bytes)) {
        shortened::add(&data.join(ARCHIVE), day, *was, *is)?;
    }
    // The databases are closed while the lock is still held.
    let lock = store.close_keeping_lock()?;
    let (history, growing, replaced) = (data.join(HISTORY), data.join(GROWING), data.join(REPLACED));
    for name in unusable {
        aside::put(data, &history.join(name))?;
    }
    if history.exists() {
        fs::rename(&history, &replaced).named(&history)?;
    }
    fs::rename(&growing, &history).named(&growing)?;
    if replaced.exists() {
        fs::remove_dir_all(&replaced).named(&replaced)?;
    }
    drop(lock);
    Ok(Reindexed { packets, samples: grown, before })
}

/// Why the last rebuild was refused, if it was and its history still waits.
pub(crate) fn refused(data: &Path) -> Option<String> {
    fs::read_to_string(data.join(GROWING).join(REFUSED)).ok()
}

/// Days of which the archive holds less than it did, as far as the history that is asked knows.
fn shortened_days(data: &Path) -> Result<BTreeMap<String, shortened::Bytes>> {
    let read = Reader::open(data)?.ask_catalogue(load_progress).ok().flatten().unwrap_or_default();
    shortened::seen(&data.join(ARCHIVE), read.iter().map(|(key, progress)| (*key, progress.lengths)))
}

/// The data that would be lost, and why, in words.
fn why_less(
    data: &Path,
    grown: u64,
    before: u64,
    shortened: &BTreeMap<String, shortened::Bytes>,
) -> Result<String> {
    let names = Reader::open(data)?.names()?;
    let mut causes: Vec<String> = Vec::new();
    for (day, (was, is)) in shortened {
        let (system, date) = day.split_once('/').unwrap_or((day, ""));
        let name = system.parse().map_or_else(|_| system.to_owned(), |address| names.system(address));
        let who = if name.eq_ignore_ascii_case(system) { name } else { format!("{name} ({system})") };
        let lost = was.saturating_sub(*is);
        let date = match (date.get(..4), date.get(4..6), date.get(6..)) {
            (Some(year), Some(month), Some(day)) => format!("{year}-{month}-{day}"),
            _ => date.to_owned(),
        };
        causes.push(format!(
            "of what came from {who} on {date}, {lost} of {was} bytes are gone from archive/{day}"
        ));
    }
    if archive::is_trimmed(&data.join(ARCHIVE)) {
        causes.push("days were removed from the archive by `prune`".to_owned());
    }
    if causes.is_empty() {
        causes.push("something was taken out of the archive, and nothing says what".to_owned());
    }
    Ok(format!(
        "the archive gives {grown} samples and the history holds {before}, so {} would be lost: {}.",
        before.saturating_sub(grown),
        causes.join("; ")
    ))
}

/// The files of the history that cannot be asked: damaged, or of a later version.
fn unusable(data: &Path) -> Result<Vec<String>> {
    let found = look::look(&data.join(HISTORY))?;
    let bad = |(name, sound): (String, Sound)| matches!(sound, Sound::No(_) | Sound::Newer).then_some(name);
    Ok(found.into_iter().filter_map(bad).collect())
}

fn samples(data: &Path, folder: &str) -> Result<u64> {
    let reader = Reader::open_folder(data, folder)?;
    let mut all = Extent::NONE;
    reader.extents()?.into_values().for_each(|extent| all.merge(extent));
    Ok(all.count)
}
