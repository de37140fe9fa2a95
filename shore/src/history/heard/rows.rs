//! Detections on their way into a file, whatever its format: which of them are given, and what the file then has.

use super::{HeardFile, Making, SampleBounds};
use api::{DatasetCovered, FlagCode};
use detections::{Detection, TagFilter};
use research::{Heard, Lag, Lags, Study};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use std::time::Instant;
use store::{DetectionsWanted, Exported, StoreError, TimeRange};

/// Bytes that are written at once.
const CHUNK: usize = 64 * 1024;
/// Detections that are read before it is asked whether the file is still waited for.
const ASK_EVERY: u64 = 1_000;
/// Detections that are read before the time is looked at.
const LATE_EVERY: u64 = 100;

/// Rows on their way into a file.
pub(super) struct Rows<'r> {
    /// Absent before the header and after the end.
    making: Option<Making>,
    study: &'r Study,
    names: &'r BTreeMap<u16, String>,
    /// Of which detections there are rows, by when they were reported.
    range: TimeRange,
    tags: &'r [TagFilter],
    file: &'r HeardFile,
    /// What vessels without a name by people announced.
    announced: BTreeMap<u16, String>,
    buffer: Vec<u8>,
    pub(super) out: &'r mut dyn Write,
    pub(super) done: Exported,
    /// Of those, what does not come of detections.
    pub(super) fixed: Exported,
    pub(super) covered: DatasetCovered,
    /// Detections that are wanted, whether the format has a row for them or not.
    pub(super) wanted: u64,
    /// Detections that were read.
    read: u64,
    /// Where to end; at the end where absent.
    pub(super) bounds: Option<SampleBounds>,
}

impl<'r> Rows<'r> {
    pub(super) fn new(
        wanted: &'r DetectionsWanted,
        names: &'r BTreeMap<u16, String>,
        study: &'r Study,
        file: &'r HeardFile,
        out: &'r mut dyn Write,
    ) -> Self {
        Self {
            making: None,
            study,
            names,
            range: wanted.range,
            tags: &wanted.tags,
            file,
            announced: BTreeMap::new(),
            buffer: Vec::new(),
            out,
            done: Exported::default(),
            fixed: Exported::default(),
            covered: DatasetCovered::default(),
            wanted: 0,
            read: 0,
            bounds: None,
        }
    }

    pub(super) fn write(&mut self, data: &Path, wanted: &DetectionsWanted) -> store::Result<()> {
        self.begin(data)?;
        if self.file.format.is_of_detections() {
            let mut lags = self.file.needs_lag().then(Lags::default);
            let read = store::each_detection(data, wanted, &mut |one, announced| {
                let vessel = one.origin.system.0;
                if !self.names.contains_key(&vessel) && !self.announced.contains_key(&vessel) {
                    self.announced.insert(vessel, announced.to_owned());
                }
                self.goes_on()?;
                let Some(lags) = &mut lags else { return self.row(&one, Lag::Unknown) };
                if self.file.is_closed && self.given(&one, Lag::Unknown).is_none() {
                    return Ok(());
                }
                lags.push(one);
                while let Some((one, lag)) = lags.pop() {
                    self.row(&one, lag)?;
                }
                Ok(())
            });
            if !matches!(read, Ok(()) | Err(StoreError::Cancelled)) {
                return read;
            }
            // A sample has what waits for its neighbours too: they hardly change how long a row is.
            while let Some((one, lag)) = lags.as_mut().and_then(Lags::take) {
                self.row(&one, lag)?;
            }
            if read.is_err() {
                // Of some formats rows are written by thousands, or at the end: here are those of a sample.
                self.end(data, wanted)?;
                return read;
            }
        }
        let before = self.done.bytes + self.buffer.len() as u64;
        let rows = self.end(data, wanted)?;
        self.done.rows += rows;
        if !self.file.format.is_of_detections() {
            self.fixed.rows += rows;
            self.fixed.bytes += self.done.bytes - before;
        }
        self.out.flush().map_err(unwritable)
    }

    /// Writes what the file begins with.
    fn begin(&mut self, data: &Path) -> store::Result<()> {
        let mut making = Making::new(data, self.file).map_err(unwritable)?;
        making.header(&mut self.buffer).map_err(unwritable)?;
        self.making = Some(making);
        self.fixed.bytes += match self.bounds {
            Some(_) if self.file.is_made_at_its_end() => self.empty_bytes(data)?,
            _ => self.buffer.len() as u64,
        };
        Ok(())
    }

    /// How long a file without a row is.
    fn empty_bytes(&self, data: &Path) -> store::Result<u64> {
        let (mut begin, mut rest) = (Vec::new(), Counted { out: &mut std::io::sink(), bytes: 0 });
        let mut making = Making::new(data, self.file).map_err(unwritable)?;
        making.header(&mut begin).map_err(unwritable)?;
        making.end(&mut rest, self.study, &self.file.about).map_err(unwritable)?;
        Ok(begin.len() as u64 + rest.bytes)
    }

    /// Writes what the file ends with; how many rows of the register that is.
    fn end(&mut self, data: &Path, wanted: &DetectionsWanted) -> store::Result<u64> {
        self.flush()?;
        let Some(mut making) = self.making.take() else { return Ok(0) };
        if self.file.has_tracks() && self.bounds.is_none() {
            let called = |vessel| self.names.get(&vessel).or_else(|| self.announced.get(&vessel));
            let out = &mut *self.out;
            let goes_on = &mut || out.flush().map_err(unwritable);
            making.tracks(data, wanted, self.range, &|vessel| called(vessel).cloned(), goes_on)?;
        }
        let mut counted = Counted { out: self.out, bytes: 0 };
        let rows = making.end(&mut counted, self.study, &self.file.about).map_err(unwritable)?;
        self.done.bytes += counted.bytes;
        Ok(rows)
    }

    /// Ends where the file is not waited for any more, also while nothing of it goes out, and a sample where it is long enough.
    fn goes_on(&mut self) -> store::Result<()> {
        self.read += 1;
        if self.read.is_multiple_of(ASK_EVERY) {
            self.out.flush().map_err(unwritable)?;
        }
        let Some(bounds) = self.bounds else { return Ok(()) };
        let is_late = self.read.is_multiple_of(LATE_EVERY) && Instant::now() >= bounds.until;
        if self.read > bounds.detections || is_late { Err(StoreError::Cancelled) } else { Ok(()) }
    }

    /// The detection as the file gives it; `None` where it does not. With an unknown lag no flag that comes of neighbours is asked.
    fn given<'d>(&self, one: &'d Detection, lag: Lag) -> Option<Cow<'d, Detection>>
    where
        'r: 'd,
    {
        let reported_us = one.origin.reported.micros();
        let is_asked = self.tags.is_empty() || self.tags.iter().any(|tag| tag.admits(one));
        if reported_us < self.range.from_us || reported_us >= self.range.to_us || !is_asked {
            return None;
        }
        let heard = self.study.heard(one, "", lag);
        let HeardFile { narrowed, without, limits, .. } = self.file;
        let is_without = |code: &FlagCode| !without.contains(code);
        if !narrowed.admits(&heard)
            || (!without.is_empty() && !heard.flags().iter().map(|flag| &flag.code).all(is_without))
        {
            return None;
        }
        limits.given(&heard)
    }

    fn row(&mut self, one: &Detection, lag: Lag) -> store::Result<()> {
        let Some(given) = self.given(one, lag) else { return Ok(()) };
        let lag = if self.file.limits.hides_neighbours() { Lag::Unknown } else { lag };
        let vessel = one.origin.system.0;
        let called = self.names.get(&vessel).or_else(|| self.announced.get(&vessel)).map_or("", |name| name);
        let heard = self.study.heard(&given, called, lag);
        self.wanted += 1;
        let Some(making) = &mut self.making else { return Ok(()) };
        if making.row(&mut self.buffer, &heard).map_err(unwritable)? {
            self.done.rows += 1;
            cover(&mut self.covered, &heard);
        }
        if self.buffer.len() >= CHUNK { self.flush() } else { Ok(()) }
    }

    pub(super) fn flush(&mut self) -> store::Result<()> {
        self.out.write_all(&self.buffer).map_err(unwritable)?;
        self.done.bytes += self.buffer.len() as u64;
        self.buffer.clear();
        Ok(())
    }
}

/// Counts the bytes that go through.
struct Counted<'c> {
    out: &'c mut dyn Write,
    bytes: u64,
}

impl Write for Counted<'_> {
    fn write(&mut self, bytes: &[u8]) -> std::io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> std::io::Result<()> {
        self.out.flush()
    }
}

/// Widens what is covered by a detection.
fn cover(covered: &mut DatasetCovered, heard: &Heard<'_>) {
    let time = Some(heard.time_us);
    covered.first_us = covered.first_us.map_or(time, |first| time.map(|time| time.min(first)));
    covered.last_us = covered.last_us.max(time);
    let Some(place) = heard.detection.pose.map(|pose| pose.place) else { return };
    let (lat, lon) = (rounded(place.lat_deg()), rounded(place.lon_deg()));
    let least = |old: Option<f64>, new: f64| Some(old.map_or(new, |old| old.min(new)));
    let most = |old: Option<f64>, new: f64| Some(old.map_or(new, |old| old.max(new)));
    covered.south_deg = least(covered.south_deg, lat);
    covered.north_deg = most(covered.north_deg, lat);
    covered.west_deg = least(covered.west_deg, lon);
    covered.east_deg = most(covered.east_deg, lon);
}

/// To seven decimals (1 cm), so that JSON has no tail of digits.
fn rounded(degrees: f64) -> f64 {
    (degrees * 1e7).round() / 1e7
}

fn unwritable(source: std::io::Error) -> StoreError {
    StoreError::Io { path: "the export".into(), source }
}
