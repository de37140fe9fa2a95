//! Files of detections: what was heard, with what the register knows of it, in any format of `research`.
//!
//! Page, API and command line write all of them by [`write()`]. Memory is constant, but for the detections that wait for their
//! neighbours where a format tells how far those are (`research::Lags`, bounded). Formats that are known whole only at their end
//! wait in a file without a name (`spool`, bounded). The same detections, names and register
//! give the same bytes.

mod file;
mod geopackage;
mod making;
mod page;
mod reading;
mod rows;
mod spool;

pub use file::HeardFile;
pub use page::page;
pub use reading::{packets, refusal};

use geopackage::GeoPackage;
use making::Making;
use rows::Rows;

use api::{DatasetContent, DatasetCovered};
use research::{CANONICAL_FORMAT, SOFTWARE, Study};
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::time::Instant;
use store::{DetectionsWanted, Exported, StoreError, TimeRange};
use tokio_util::sync::CancellationToken;

/// Writes a header, and a row for each detection that is wanted. Vessels are called by `names`, else as they announced. While detections
/// are read, `out` is flushed again and again, also when nothing was written: its error ends what is not waited for any more.
///
/// # Errors
/// When the history cannot be read or `out` not be written. A table of comma-separated values that was begun then ends with a line
/// that begins with `#ERROR`, as far as it can be written, and is not whole; files of other formats lack their end, without which no
/// program reads them.
pub fn write(
    data: &Path,
    wanted: &DetectionsWanted,
    names: &BTreeMap<u16, String>,
    study: &Study,
    file: &HeardFile,
    out: &mut dyn Write,
) -> store::Result<Exported> {
    Ok(write_told(data, wanted, names, study, file, out)?.0)
}

/// As [`write()`], and what the rows reach over.
fn write_told(
    data: &Path,
    wanted: &DetectionsWanted,
    names: &BTreeMap<u16, String>,
    study: &Study,
    file: &HeardFile,
    out: &mut dyn Write,
) -> store::Result<(Exported, DatasetCovered)> {
    let study = file.study(study);
    let mut rows = Rows::new(wanted, names, &study, file, out);
    let read = DetectionsWanted { range: file.read_range(wanted.range), ..wanted.clone() };
    let written = rows.write(data, &read);
    if let Err(error) = written {
        let line = format!("#ERROR the export is cut here: {error}\n").replace('\r', " ");
        if file.format.is_csv() {
            rows.out.write_all(line.as_bytes()).ok();
        }
        return Err(error);
    }
    Ok((rows.done, rows.covered))
}

/// What a file has, which is written to nowhere.
///
/// # Errors
/// When the history cannot be read, or the client no longer waits for it.
pub fn content(
    data: &Path,
    wanted: &DetectionsWanted,
    names: &BTreeMap<u16, String>,
    study: &Study,
    file: &HeardFile,
    given_up: &CancellationToken,
) -> store::Result<DatasetContent> {
    let mut hashed = Hashed { hash: Sha256::new(), given_up: given_up.clone() };
    let (done, covered) = write_told(data, wanted, names, study, file, &mut hashed)?;
    let sha256 = hex::encode(hashed.hash.finalize());
    let (format, software) = (CANONICAL_FORMAT, SOFTWARE.to_owned());
    Ok(DatasetContent { rows: done.rows, bytes: done.bytes, sha256, covered, format, software })
}

/// Takes bytes only to hash them.
struct Hashed {
    hash: Sha256,
    given_up: CancellationToken,
}

impl Write for Hashed {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        self.goes_on()?;
        self.hash.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.goes_on()
    }
}

impl Hashed {
    fn goes_on(&self) -> std::io::Result<()> {
        if self.given_up.is_cancelled() {
            return Err(std::io::Error::new(
                std::io::ErrorKind::BrokenPipe,
                "the client no longer waits for it",
            ));
        }
        Ok(())
    }
}

/// How much is read of a file to learn how long its rows are.
#[derive(Debug, Clone, Copy)]
pub(super) struct SampleBounds {
    /// Detections that are read.
    pub(super) detections: u64,
    /// No longer than until then, but for the first `LATE_EVERY` detections: each sample has some.
    pub(super) until: Instant,
}

/// A part of a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Sample {
    /// Detections that are wanted; formats leave out those that they have no row for.
    pub(super) wanted: u64,
    /// Their rows and bytes.
    pub(super) of_detections: Exported,
    /// What the file has whatever was heard: the header, and rows of the register.
    pub(super) fixed: Exported,
    /// Whether all that was wanted is there.
    pub(super) is_whole: bool,
}

/// Writes the begin of a file to nowhere, of what was reported within `wanted` and with the neighbours within `read`. Tags are looked
/// for among what is read, so that the bounds hold for rare ones too.
///
/// # Errors
/// When the history cannot be read.
pub(super) fn sample(
    data: &Path,
    (wanted, read): (&DetectionsWanted, TimeRange),
    names: &BTreeMap<u16, String>,
    study: &Study,
    file: &HeardFile,
    bounds: SampleBounds,
) -> store::Result<Sample> {
    let out = &mut std::io::sink();
    let study = file.study(study);
    let mut rows = Rows::new(wanted, names, &study, file, out);
    rows.bounds = Some(bounds);
    let read = DetectionsWanted { range: read, tags: Vec::new(), ..wanted.clone() };
    let is_whole = match rows.write(data, &read) {
        Err(StoreError::Cancelled) => false,
        written => written.map(|()| true)?,
    };
    rows.flush()?;
    let fixed = rows.fixed;
    let of_detections = Exported { rows: rows.done.rows - fixed.rows, bytes: rows.done.bytes - fixed.bytes };
    Ok(Sample { wanted: rows.wanted, of_detections, fixed, is_whole })
}

#[cfg(test)]
mod round_trip_tests;
#[cfg(test)]
mod tests;
