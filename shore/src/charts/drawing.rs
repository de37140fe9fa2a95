//! The charts of a set, for the tile renderer: features and coverages are read from the set on disk when needed, and
//! overviews are cached beside it.

use super::Changed;
use chartdb::{Chart, ChartDb, Overviews, Snapshot};
use charts::coverage::Polygon;
use charts::s57::Feature;
use sha2::{Digest as _, Sha256};
use std::path::Path;
use std::sync::{Mutex, PoisonError};
use tiles::{Sheet, SheetChart, SheetReader, Unread};

/// Most bytes of charts that are held in memory for drawing.
const SHEET_BYTES: usize = 64 << 20;

/// To be changed whenever charts are drawn differently.
const OVERVIEW: &[u8] = b"lutra overview 1";

#[derive(Debug)]
struct Drawing {
    /// The best first, as the sheet numbers them.
    charts: Vec<Chart>,
    /// Digest of the contents of each.
    marks: Vec<[u8; 32]>,
    set: Mutex<Snapshot>,
    /// `None` if the folder cannot be written: then they are not cached.
    overviews: Mutex<Option<Overviews>>,
}

/// The sheet of a set whose digest is this.
///
/// # Errors
/// The set cannot be read, or is another by now.
pub(super) fn sheet(path: &Path, digest: &str) -> Result<Sheet, String> {
    let set = Snapshot::open(path).map_err(|error| error.to_string())?;
    if hex::encode(set.digest()) != digest {
        return Err(Changed.to_string());
    }
    let overviews = Overviews::open(path).inspect_err(|error| {
        tracing::warn!(%error, "small zooms of the chart are made again at each start");
    });
    let mut charts: Vec<(Chart, [u8; 32])> = set.charts().iter().cloned().zip(set.marks()).collect();
    charts.sort_by_cached_key(|(chart, _)| chart.source().rank());
    let listed = charts.iter().map(|(chart, _)| SheetChart {
        source: chart.source(),
        bounds_deg: chart.bounds_deg,
        features: u32::try_from(chart.features).unwrap_or(u32::MAX),
    });
    let listed = listed.collect();
    let (charts, marks) = charts.into_iter().unzip();
    let drawing = Drawing { charts, marks, set: Mutex::new(set), overviews: Mutex::new(overviews.ok()) };
    Ok(Sheet::new(listed, Box::new(drawing), SHEET_BYTES))
}

impl Drawing {
    fn read<T>(&self, read: impl FnOnce(&ChartDb) -> chartdb::Result<T>) -> Result<T, Unread> {
        let read = self.set.lock().unwrap_or_else(PoisonError::into_inner).read(read);
        match read {
            Ok(Some(read)) => Ok(read),
            Ok(None) => Err(Unread::Changed),
            // An import is committing.
            Err(error) if error.is_busy() => Err(Unread::Changed),
            Err(error) => Err(Unread::Damaged(error.to_string())),
        }
    }

    /// Cache key of a chart's overview, drawn where the better charts do not cover it.
    fn key(&self, chart: usize, better: &[usize]) -> [u8; 32] {
        let mut hash = Sha256::new_with_prefix(OVERVIEW);
        for one in [&chart].into_iter().chain(better) {
            hash.update(self.marks[*one]);
        }
        hash.finalize().into()
    }
}

impl SheetReader for Drawing {
    fn features(&self, chart: usize) -> Result<Vec<Feature>, Unread> {
        self.read(|set| set.features(&self.charts[chart]))
    }

    fn coverage(&self, chart: usize) -> Result<Vec<Polygon>, Unread> {
        self.read(|set| set.coverage(&self.charts[chart])).map(|coverage| coverage.areas)
    }

    fn kept(&self, chart: usize, better: &[usize], zoom: u8) -> Option<Vec<u8>> {
        let overviews = self.overviews.lock().unwrap_or_else(PoisonError::into_inner);
        overviews.as_ref()?.get(&self.key(chart, better), zoom)
    }

    fn keep(&self, chart: usize, better: &[usize], zooms: &[Vec<u8>]) {
        let mut overviews = self.overviews.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(Err(error)) = overviews.as_mut().map(|kept| kept.put(&self.key(chart, better), zooms)) {
            tracing::warn!(%error, "small zooms of the chart are made again at the next start");
        }
    }

    fn sweep(&self, better: &[Vec<usize>]) {
        let keys = (0..).zip(better).map(|(chart, better)| self.key(chart, better)).collect();
        let mut overviews = self.overviews.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(Err(error)) = overviews.as_mut().map(|kept| kept.retain(&keys)) {
            tracing::warn!(%error, "what is kept of charts before stays on the disk");
        }
    }
}
