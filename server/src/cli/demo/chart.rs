//! The demo's chart: the fictitious archipelago, imported in the usual way.

use crate::cli::say::say;
use anyhow::{Context as _, bail};
use chartdb::{ImportOptions, index_path};
use shore::clock;
use std::fs;
use std::path::{Path, PathBuf};

/// Imports the archipelago into the chart set at `set`; returns the depth index that agents read.
///
/// # Errors
/// A file cannot be written or imported completely.
pub(super) fn bring_in(folder: &Path, set: &Path) -> anyhow::Result<PathBuf> {
    let cells = folder.join("chart");
    fs::create_dir_all(&cells).with_context(|| format!("cannot make {}", cells.display()))?;
    for file in charts::demo::archipelago()? {
        let path = cells.join(format!("{}.000", file.name.trim_end_matches(".000")));
        fs::write(&path, file.bytes).with_context(|| format!("cannot write {}", path.display()))?;
    }
    if let Some(parent) = set.parent() {
        fs::create_dir_all(parent).with_context(|| format!("cannot make {}", parent.display()))?;
    }
    let report = chartdb::import(set, &[cells], &ImportOptions::new(clock::now()), &mut |_| true)?;
    if let Some(failure) = report.failures.first() {
        bail!("the demo's chart {} does not come in: {}", failure.name, failure.error);
    }
    say!("chart     a fictitious archipelago, NOT FOR NAVIGATION");
    Ok(index_path(set))
}
