//! The contents of a chart set, now or after a change: its charts, each with the database that has its features.

use crate::blob;
use crate::error::Result;
use crate::read::{Chart, ChartDb, MEANING};
use charts::coverage::Source;
use charts::depth_index::{ChartToIndex, DepthIndex, assemble, assemble_after};
use charts::s57::Feature;
use sha2::{Digest as _, Sha256};
use std::collections::{BTreeMap, BTreeSet};

impl ChartDb {
    /// Digest of the contents: the charts in it, how they were read, and whether they were edited by hand since.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn digest(&self) -> Result<[u8; 32]> {
        Ok(Contents::of(self)?.digest())
    }
}

/// The charts of a set by name.
pub(crate) struct Contents<'a> {
    charts: Vec<(Chart, &'a ChartDb)>,
    /// The mark that manual editing left; empty where the set was not edited.
    edited: String,
}

impl<'a> Contents<'a> {
    /// Of the present state of a set.
    pub(crate) fn of(set: &'a ChartDb) -> Result<Self> {
        let charts = set.charts()?.into_iter().map(|chart| (chart, set));
        Ok(Self { charts: charts.collect(), edited: set.edited()? })
    }

    /// Of a set in which charts are replaced by those of a change, and some are taken out.
    pub(crate) fn changed(set: &'a ChartDb, change: &'a ChartDb, gone: &BTreeSet<String>) -> Result<Self> {
        let mut all: BTreeMap<String, (Chart, &ChartDb)> = BTreeMap::new();
        for one in [set, change] {
            for chart in one.charts()? {
                all.insert(chart.name.clone(), (chart, one));
            }
            if std::ptr::eq(one, set) {
                all.retain(|name, _| !gone.contains(name));
            }
        }
        Ok(Self { charts: all.into_values().collect(), edited: set.edited()? })
    }

    /// Digest of the contents: the charts, how they were read, and whether they were edited by hand since.
    pub(crate) fn digest(&self) -> [u8; 32] {
        let mut hash = Sha256::new_with_prefix(MEANING);
        for (chart, _) in &self.charts {
            hash.update(chart.contents().as_bytes());
            hash.update(b"\n");
        }
        hash.update(self.edited.as_bytes());
        hash.finalize().into()
    }

    /// Gives the bytes of the depth index of all charts, part after part; what did not change is taken over from the
    /// index before.
    pub(crate) fn make_index(
        &self,
        before: Option<&DepthIndex>,
        put: impl FnMut(&[u8]) -> Result<()>,
    ) -> Result<()> {
        assemble(self.entries()?, before, |source| self.features(source), put)
    }

    /// Gives the bytes that bring an index up to date where they follow its first `base_bytes`; the bytes of pieces that
    /// are in use then.
    pub(crate) fn change_index(
        &self,
        before: &DepthIndex,
        base_bytes: u64,
        put: impl FnMut(&[u8]) -> Result<()>,
    ) -> Result<u64> {
        assemble_after(self.entries()?, before, base_bytes, |source| self.features(source), put)
    }

    fn entries(&self) -> Result<Vec<ChartToIndex>> {
        let entry = |(chart, set): &(Chart, &ChartDb)| {
            let bounds_deg = if self.edited.is_empty() { chart.bounds_deg } else { bounds_now(set, chart)? };
            Ok(ChartToIndex { source: chart.source(), mark: chart.mark(&self.edited), bounds_deg })
        };
        self.charts.iter().map(entry).collect()
    }

    fn features(&self, source: &Source) -> Result<Vec<Feature>> {
        let found = self.charts.binary_search_by(|(chart, _)| chart.name.as_str().cmp(&source.name));
        found.map_or(Ok(Vec::new()), |at| {
            let (chart, set) = &self.charts[at];
            set.features(chart)
        })
    }
}

/// The bounding box of a chart that may have been edited by hand.
fn bounds_now(set: &ChartDb, chart: &Chart) -> Result<Option<[f64; 4]>> {
    let features = set.features(chart)?;
    let envelope = blob::Envelope::of(features.iter().flat_map(|feature| feature.geometry.points()));
    Ok(envelope.map(|blob::Envelope([west, east, south, north])| [west, south, east, north]))
}
