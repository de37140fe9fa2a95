//! The history made again from the archive.
//!
//! It grows in `history.new` beside the one that is asked meanwhile, and takes its place when it is whole. A
//! rebuild that was broken off goes on where it stopped.

use crate::error::{Named as _, Result, StoreError};
use crate::history::Extent;
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
    /// Samples that it held before.
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
    let before = samples(data, HISTORY)?;
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

fn samples(data: &Path, folder: &str) -> Result<u64> {
    let mut reader = Reader::open_folder(data, folder)?;
    let mut all = Extent::NONE;
    reader.extents()?.into_values().for_each(|extent| all.merge(extent));
    Ok(all.count)
}
