//! Importing charts into a set: all or nothing, one chart at a time in memory.

use crate::cells;
use crate::error::{ChartDbError, Result};
use crate::files::Found;
use crate::index_file;
use crate::lakes;
use crate::report::{ImportFailure, ImportOptions, ImportProgress, ImportReport, Imported};
use crate::stage::Stage;
use crate::supplements;
use crate::write::Entry;
use std::path::{Path, PathBuf};
use units::UtcTime;

/// Imports files and folders into a chart set, which is made where there is none.
///
/// `progress` is called before each chart and may return false to stop. Where any chart fails, the set stays
/// unchanged (unless [`ImportOptions::keep_going`]), the report has all failures, and a later import of the same
/// charts continues from what was read.
///
/// # Errors
/// When the set or an input cannot be read or written at all, or the caller asked to stop.
pub fn import(
    db: &Path,
    inputs: &[PathBuf],
    options: &ImportOptions,
    progress: &mut dyn FnMut(&ImportProgress<'_>) -> bool,
) -> Result<ImportReport> {
    let mut found = Found::of(inputs)?;
    let mut stage = Stage::resumed(db, &found.names())?;
    let of = found.count();
    let mut report = ImportReport {
        charts: Vec::new(),
        failures: Vec::new(),
        notices: std::mem::take(&mut found.notices),
        applied: false,
        digest: String::new(),
    };
    for (name, error) in std::mem::take(&mut found.failures) {
        found.cells.remove(&name);
        report.failures.push(ImportFailure { name, error });
    }
    let before = report.failures.len();
    let mut tell = |done: usize, name: &str| {
        let go_on = progress(&ImportProgress { done, of, name });
        if go_on { Ok(()) } else { Err(ChartDbError::Cancelled) }
    };
    report.read(&mut stage, &found, options, &mut tell)?;
    let fails_now = |name: &String| report.failures.iter().any(|failure| failure.name == *name);
    if stage.begun().iter().any(fails_now) {
        // Data of it from an earlier run must not go live with the others, nor count as the newer edition.
        stage.abandon()?;
        stage = Stage::fresh(db)?;
        report.charts.clear();
        report.failures.truncate(before);
        report.read(&mut stage, &found, options, &mut tell)?;
    }
    report.applied = report.failures.is_empty() || options.keep_going && !report.charts.is_empty();
    if report.applied {
        tell(of, "index")?;
        report.digest = hex::encode(stage.finish(&options.now.to_string())?);
        index_file::load_index(db)?;
    }
    Ok(report)
}

impl ImportReport {
    /// Reads all charts into the copy.
    fn read(
        &mut self,
        stage: &mut Stage,
        found: &Found,
        options: &ImportOptions,
        tell: &mut dyn FnMut(usize, &str) -> Result<()>,
    ) -> Result<()> {
        let mut done = 0;
        let mut next = |name: &str| {
            done += 1;
            tell(done - 1, name)
        };
        for (name, files) in &found.cells {
            next(name)?;
            self.add(name, cells::import(stage, name, files, found, options))?;
        }
        for path in &found.soundings {
            let name = supplements::name(path);
            next(&name)?;
            self.add(&name, supplements::soundings(stage, path, options))?;
        }
        for path in &found.land {
            let name = supplements::name(path);
            next(&name)?;
            self.add(&name, supplements::land(stage, path, options))?;
        }
        for path in &found.lakes {
            let name = supplements::name(path);
            next(&name)?;
            self.add(&name, lakes::import(stage, path, options))?;
        }
        Ok(())
    }

    /// Keeps the outcome of one chart. A fault of the chart is its failure; a fault of the disk
    /// or the database ends the import.
    fn add(&mut self, name: &str, outcome: Result<Imported>) -> Result<()> {
        match outcome {
            Ok(imported) => self.charts.push(imported),
            Err(error @ (ChartDbError::Cell(_) | ChartDbError::File { .. } | ChartDbError::Build(_))) => {
                self.failures.push(ImportFailure { name: name.to_owned(), error });
            }
            Err(error) => return Err(error),
        }
        Ok(())
    }
}

/// Removes charts from a set, and nothing else: the staged charts of a failed import are dropped.
///
/// Returns the digest of the set after that, in hexadecimal.
///
/// # Errors
/// When there is no set or no chart of a name, and when the set cannot be written; then it stays as it was.
pub fn remove(db: &Path, names: &[String], now: UtcTime) -> Result<String> {
    let charts = crate::read::ChartDb::open(db)?.charts_named(names)?;
    let mut stage = Stage::fresh(db)?;
    let time = now.to_string();
    for chart in &charts {
        let text = format!("edition {}, update {}", chart.edition, chart.update);
        let entry =
            Entry { source: None, cell: &chart.name, file: "", record: None, what: "removed", text: &text };
        stage.take_out(&time, &entry)?;
    }
    stage.finish(&time).map(hex::encode)
}
