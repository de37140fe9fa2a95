//! The history made again from the archive.
//!
//! It grows in `history.new` beside the one that is asked meanwhile, and takes its place when it is whole. A
//! rebuild that was broken off goes on where it stopped.

use crate::archive;
use crate::aside;
use crate::error::{Named as _, Result, StoreError};
use crate::history::Extent;
use crate::history::look::{self, Sound};
use crate::reader::Reader;
use crate::store::Store;
use std::fs;
use std::path::Path;

/// The history that is asked.
pub(crate) const HISTORY: &str = "history";
/// The one that grows.
pub(crate) const GROWING: &str = "history.new";
/// The one that was replaced.
pub(crate) const REPLACED: &str = "history.old";

/// What making it again did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Reindexed {
    /// Packets read from the archive by this run.
    pub packets: u64,
    /// Samples that the history holds.
    pub samples: u64,
    /// Samples that it held before; 0 where files of it could not be read.
    pub before: u64,
}

/// Makes the history again from the archive. No other process may write to the folder; `progress` is told how
/// many packets were read and may stop by returning false.
///
/// # Errors
/// When files cannot be read or written, and [`StoreError::Cancelled`]. Also when the archive holds fewer samples
/// than the history, because old days were removed from it: with `accept_loss` the history then shrinks.
pub fn reindex(data: &Path, accept_loss: bool, progress: &mut dyn FnMut(u64) -> bool) -> Result<Reindexed> {
    finish_swap(data)?;
    let unusable = unusable(data)?;
    if !unusable.is_empty() && archive::is_trimmed(&data.join("archive")) && !accept_loss {
        return Err(StoreError::Query(format!(
            "days were removed from the archive, and what {} held of them cannot be counted. The history is as it was; \
             to go on, allow the loss: the file is kept in {}",
            unusable.join(" and "),
            aside::ASIDE
        )));
    }
    let before = if unusable.is_empty() { samples(data, HISTORY)? } else { 0 };
    let mut store = Store::open_growing(data, progress)?;
    let packets = store.repairs().replayed;
    store.settle()?;
    let grown = samples(data, GROWING)?;
    if grown < before && !accept_loss {
        return Err(StoreError::Query(format!(
            "the archive gives {grown} samples and the history holds {before}: days were removed from the archive. \
             The history is as it was; to give up what only it holds, allow the loss"
        )));
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

/// Ends a swap that a crash broke off.
pub(crate) fn finish_swap(data: &Path) -> Result<()> {
    let (history, growing, replaced) = (data.join(HISTORY), data.join(GROWING), data.join(REPLACED));
    if replaced.exists() {
        if !history.exists() && growing.exists() {
            fs::rename(&growing, &history).named(&growing)?;
        }
        fs::remove_dir_all(&replaced).named(&replaced)?;
    }
    Ok(())
}

/// The files of the history that cannot be asked: damaged, or of a later version.
fn unusable(data: &Path) -> Result<Vec<String>> {
    let found = look::look(&data.join(HISTORY))?;
    let bad = |(name, sound): (String, Sound)| matches!(sound, Sound::No(_) | Sound::Newer).then_some(name);
    Ok(found.into_iter().filter_map(bad).collect())
}

fn samples(data: &Path, folder: &str) -> Result<u64> {
    let mut reader = Reader::open_folder(data, folder)?;
    let mut all = Extent::NONE;
    reader.extents()?.into_values().for_each(|extent| all.merge(extent));
    Ok(all.count)
}
