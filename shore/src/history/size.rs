//! Estimates the size of a file of detections before it is written.
//!
//! A short file is written to a null sink, and its rows and bytes are counted. For a long one the explorer knows the number
//! of detections and where equal parts of them begin: the begin of each part is written as a sample of the part. The header
//! is counted once. Tracks of vessels, which a GeoPackage has too, are not counted: its size is always an estimate.

use super::heard::{self, HeardFile, Sample, SampleBounds};
use api::ExportSize;
use research::{HORIZON_S, Rank, Ranks, Study};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{Duration, Instant};
use store::{DetectionsWanted, Exported, TimeRange};

/// Number of parts that are sampled.
pub const PARTS: usize = 25;
/// Most detections that are read, of one part after another or of the whole.
const SAMPLE_READ: u64 = 50_000;
/// Time limit of each of two steps: testing whether the file is short, and sampling it if not.
const SAMPLE_TIME: Duration = Duration::from_secs(1);

/// A file whose size is estimated.
#[derive(Debug)]
pub struct Measured<'m> {
    /// Which detections.
    pub wanted: &'m DetectionsWanted,
    /// Names of vessels.
    pub names: &'m BTreeMap<u16, String>,
    /// The register.
    pub study: &'m Study,
    /// The format.
    pub file: &'m HeardFile,
}

impl Measured<'_> {
    /// The size of the file; `None` if the detections that `ranks` counted are gone.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn size(&self, data: &Path, ranks: &Ranks) -> store::Result<Option<ExportSize>> {
        self.size_by(data, ranks, SAMPLE_READ)
    }

    /// The same, from at most `most` detections.
    fn size_by(&self, data: &Path, ranks: &Ranks, most: u64) -> store::Result<Option<ExportSize>> {
        let is_of_detections = self.file.format.is_of_detections();
        // A sample has no tracks, however whole it is.
        let has_tracks = self.file.has_tracks();
        if ranks.detections == 0 && is_of_detections {
            // However many others are in between: they need not be read.
            let from_us = self.wanted.range.from_us;
            let nothing = TimeRange { from_us, to_us: from_us };
            let until = Instant::now() + SAMPLE_TIME;
            let Exported { rows, bytes } = self.sample(data, nothing, nothing, most, until)?.fixed;
            return Ok(Some(ExportSize { rows, bytes, estimated: has_tracks }));
        }
        if ranks.detections <= most || !is_of_detections {
            let all = self.wanted.range;
            let found =
                self.sample(data, all, self.file.read_range(all), most, Instant::now() + SAMPLE_TIME)?;
            if found.is_whole {
                let Sample { of_detections: of, fixed, .. } = found;
                let (rows, bytes) = (of.rows + fixed.rows, of.bytes + fixed.bytes);
                return Ok(Some(ExportSize { rows, bytes, estimated: has_tracks }));
            }
        }
        self.estimate(data, ranks, most / PARTS as u64)
    }

    /// Estimates by sampling each part.
    fn estimate(&self, data: &Path, ranks: &Ranks, most: u64) -> store::Result<Option<ExportSize>> {
        let until = Instant::now() + SAMPLE_TIME;
        let ends = ranks.parts.iter().skip(1).map(|part| part.from_us).chain([self.wanted.range.to_us]);
        let (mut sums, mut seen, mut fixed) = ((0.0, 0.0), 0, Exported::default());
        for (Rank { from_us, detections }, to_us) in ranks.parts.iter().zip(ends) {
            let part = TimeRange { from_us: *from_us, to_us };
            // The neighbours before a part hardly affect the length of its rows, and may be more than the whole sample.
            let beside_us = if self.file.format.has_lag { HORIZON_S * 1_000_000 } else { 0 };
            let read = TimeRange { to_us: to_us.saturating_add(beside_us), ..part };
            let found = self.sample(data, part, read, most, until)?;
            fixed = found.fixed;
            if found.wanted > 0 {
                let share = *detections as f64 / found.wanted as f64;
                let of = found.of_detections;
                sums = (sums.0 + share * of.rows as f64, sums.1 + share * of.bytes as f64);
                seen += detections;
            }
        }
        if seen == 0 {
            return Ok(None);
        }
        // Parts without any, as the data changed meanwhile, are assumed to be like the others.
        let of_all = |sum: f64| (sum * ranks.detections as f64 / seen as f64).round() as u64;
        let (rows, bytes) = (of_all(sums.0) + fixed.rows, of_all(sums.1) + fixed.bytes);
        Ok(Some(ExportSize { rows, bytes, estimated: true }))
    }

    fn sample(
        &self,
        data: &Path,
        range: TimeRange,
        read: TimeRange,
        detections: u64,
        until: Instant,
    ) -> store::Result<Sample> {
        let wanted = DetectionsWanted { range, ..self.wanted.clone() };
        let bounds = SampleBounds { detections, until };
        heard::sample(data, (&wanted, read), self.names, self.study, self.file, bounds)
    }
}

#[cfg(test)]
#[path = "size_tests.rs"]
mod tests;
