//! Files of detections: what was heard, with what the register knows of it, in any format of `research`.
//!
//! Page, API and command line write all of them by [`write()`]. Memory is constant, but for the detections that wait for their
//! neighbours where a format tells how far those are (`research::Lags`, bounded). The same detections, names and register
//! give the same bytes.

use crate::decode;
use api::{DatasetContent, DatasetCovered, FlagCode};
use detections::{Detection, TagFilter};
use research::{
    CANONICAL_FORMAT, Format, HORIZON_S, Heard, LUTRA, Lag, Lags, Limits, Narrowed, SOFTWARE, Study, Writer,
    format,
};
use sha2::{Digest as _, Sha256};
use std::borrow::Cow;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::Path;
use std::time::Instant;
use store::{DetectionsWanted, Exported, Order, Page, Reader, StoreError, TimeRange};
use tables::Dialect;
use tokio_util::sync::CancellationToken;

/// Bytes that are written at once.
const CHUNK: usize = 64 * 1024;

/// How a file of detections is written.
#[derive(Debug, Clone)]
pub struct HeardFile {
    /// Its format.
    pub format: Format,
    /// For whom; all formats but our own are for programs.
    pub dialect: Dialect,
    /// Of which projects and places.
    pub narrowed: Narrowed,
    /// Detections with one of these flags are left out.
    pub without: Vec<FlagCode>,
    /// What others are given of it.
    pub limits: Limits,
    /// Whether a neighbour is only a detection that may itself stand in the file: what lies outside changes nothing then.
    pub is_closed: bool,
}

impl HeardFile {
    /// By the name of a format, and for which spreadsheet.
    ///
    /// # Errors
    /// There is no such format or spreadsheet, or the format is not for spreadsheets.
    pub fn new(name: Option<&str>, spreadsheet: Option<&str>) -> store::Result<Self> {
        let dialect = super::export::dialect(spreadsheet)?;
        let wanted = name.map_or("", str::trim);
        let found = if wanted.is_empty() { Ok(LUTRA) } else { format(wanted) };
        let format = found.map_err(|text| StoreError::Query(format!("format: {text}")))?;
        Self::of(format, dialect)
    }

    /// Of a format.
    ///
    /// # Errors
    /// The format is not for spreadsheets.
    pub fn of(format: Format, dialect: Dialect) -> store::Result<Self> {
        if format.name != LUTRA.name && dialect != Dialect::Plain {
            let text = format!(
                "spreadsheet: the format {} is for programs, which a spreadsheet's marks would disturb; leave one of both out",
                format.name
            );
            return Err(StoreError::Query(text));
        }
        Ok(Self {
            format,
            dialect,
            narrowed: Narrowed::default(),
            without: Vec::new(),
            limits: Limits::default(),
            is_closed: false,
        })
    }

    /// The time of which detections are read for rows of a time: the neighbours of the first and the last one too, where the
    /// format tells how far those are.
    pub fn read_range(&self, range: TimeRange) -> TimeRange {
        let beside_us = if self.needs_lag() && !self.is_closed { HORIZON_S * 1_000_000 } else { 0 };
        TimeRange {
            from_us: range.from_us.saturating_sub(beside_us),
            to_us: range.to_us.saturating_add(beside_us),
        }
    }

    /// Whether a row takes the neighbours of its detection.
    fn needs_lag(&self) -> bool {
        self.format.has_lag || self.without.contains(&FlagCode::Unconfirmed)
    }

    /// The register as rows are told by it.
    fn study<'s>(&self, study: &'s Study) -> Cow<'s, Study> {
        match self.limits.cells_m() {
            Some(cells_m) => Cow::Owned(study.clone().without_places(cells_m)),
            None => Cow::Borrowed(study),
        }
    }

    /// The name of the file, without what packs it.
    pub fn name(&self) -> String {
        let Format { name, .. } = self.format;
        if name == LUTRA.name || !self.format.is_csv() {
            format!("detections.{}", self.format.ending())
        } else {
            format!("detections-{name}.csv")
        }
    }
}

/// Writes a header, and a row for each detection that is wanted. Vessels are called by `names`, else as they announced.
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
/// When the history cannot be read, or nobody waits for it any more.
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
        if self.given_up.is_cancelled() {
            return Err(std::io::Error::new(std::io::ErrorKind::BrokenPipe, "nobody waits for it any more"));
        }
        self.hash.update(bytes);
        Ok(bytes.len())
    }

    fn flush(&mut self) -> std::io::Result<()> {
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

/// Detections that are read before the time is looked at.
const LATE_EVERY: u64 = 100;

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

/// Detections that are read to tell the neighbours of a page.
const NEIGHBOURS: usize = 200_000;

/// A page of the detections that are wanted, of projects and places, each with its nearest neighbour and its flags. Where more
/// than 200,000 would have to be read for that, the rest has no neighbour and no flags.
///
/// # Errors
/// The history cannot be read.
pub fn page(
    data: &Path,
    reader: &mut Reader,
    wanted: &DetectionsWanted,
    (order, page): (Order, Page),
    study: &Study,
    (narrowed, flags): (&Narrowed, bool),
) -> store::Result<api::Detections> {
    let is_wanted =
        |one: &Detection| narrowed.is_all() || narrowed.admits(&study.heard(one, "", Lag::Unknown));
    let found = reader.detections_where(wanted, order, page, is_wanted)?;
    let next = found.next.map(|rest| super::next(rest, wanted.range, order));
    let lags = if flags { lags(data, wanted, &found.items)? } else { BTreeMap::new() };
    let told = |one: Detection| {
        let lag = lags.get(&(one.origin.system.0, one.id())).copied();
        let told = lag.map(|lag| (lag.seconds(), study.heard(&one, "", lag).flags()));
        let (min_lag_s, flags) = told.unzip();
        api::Detection { min_lag_s: min_lag_s.flatten(), flags, ..decode::detection(one) }
    };
    Ok(api::Detections { detections: found.items.into_iter().map(told).collect(), next })
}

/// The nearest neighbours of detections, by vessel and id.
fn lags(
    data: &Path,
    wanted: &DetectionsWanted,
    items: &[Detection],
) -> store::Result<BTreeMap<(u16, String), Lag>> {
    let times = || items.iter().map(|one| one.origin.reported.micros());
    let (Some(first_us), Some(last_us)) = (times().min(), times().max()) else { return Ok(BTreeMap::new()) };
    let beside_us = HORIZON_S * 1_000_000;
    let range =
        TimeRange { from_us: first_us.saturating_sub(beside_us), to_us: last_us.saturating_add(beside_us) };
    let mut tags: Vec<TagFilter> = items.iter().filter_map(|one| one.tag().parse().ok()).collect();
    tags.sort_by_key(|tag| format!("{tag:?}"));
    tags.dedup();
    let near = DetectionsWanted { range, tags, came_from: None, ..wanted.clone() };
    let ids: BTreeSet<(u16, String)> = items.iter().map(|one| (one.origin.system.0, one.id())).collect();
    let (mut lags, mut told, mut read) = (Lags::default(), BTreeMap::new(), 0);
    let mut tell = |(one, lag): (Detection, Lag)| {
        let reported_us = one.origin.reported.micros();
        let key = (one.origin.system.0, one.id());
        if (first_us..=last_us).contains(&reported_us) && ids.contains(&key) {
            told.insert(key, lag);
        }
    };
    let read_all = store::each_detection(data, &near, &mut |one, _| {
        read += 1;
        if read > NEIGHBOURS {
            return Err(StoreError::Cancelled);
        }
        lags.push(one);
        while let Some(one) = lags.pop() {
            tell(one);
        }
        Ok(())
    });
    match read_all {
        // What still waits may have a neighbour that was not read.
        Err(StoreError::Cancelled) => return Ok(told),
        read => read?,
    }
    while let Some(one) = lags.take() {
        tell(one);
    }
    Ok(told)
}

/// Rows on their way into a file.
struct Rows<'r> {
    writer: Writer,
    study: &'r Study,
    names: &'r BTreeMap<u16, String>,
    /// Of which detections there are rows, by when they were reported.
    range: TimeRange,
    tags: &'r [TagFilter],
    file: &'r HeardFile,
    /// What vessels without a name by people announced.
    announced: BTreeMap<u16, String>,
    buffer: Vec<u8>,
    out: &'r mut dyn Write,
    done: Exported,
    /// Of those, what does not come of detections.
    fixed: Exported,
    covered: DatasetCovered,
    /// Detections that are wanted, whether the format has a row for them or not.
    wanted: u64,
    /// Detections that were read.
    read: u64,
    /// Where to end; at the end where absent.
    bounds: Option<SampleBounds>,
}

impl<'r> Rows<'r> {
    fn new(
        wanted: &'r DetectionsWanted,
        names: &'r BTreeMap<u16, String>,
        study: &'r Study,
        file: &'r HeardFile,
        out: &'r mut dyn Write,
    ) -> Self {
        Self {
            writer: Writer::new(file.format, file.dialect),
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

    fn write(&mut self, data: &Path, wanted: &DetectionsWanted) -> store::Result<()> {
        self.writer.header(&mut self.buffer).map_err(unwritable)?;
        self.fixed.bytes += self.buffer.len() as u64;
        if self.file.format.is_of_detections() {
            let mut lags = self.file.needs_lag().then(Lags::default);
            let read = store::each_detection(data, wanted, &mut |one, announced| {
                let vessel = one.origin.system.0;
                if !self.names.contains_key(&vessel) && !self.announced.contains_key(&vessel) {
                    self.announced.insert(vessel, announced.to_owned());
                }
                self.is_within_bounds()?;
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
                // Of a table rows are written by thousands: here are those of a sample.
                self.writer.end(&mut self.buffer, self.study).map_err(unwritable)?;
                return read;
            }
        }
        let before = self.buffer.len();
        let rows = self.writer.end(&mut self.buffer, self.study).map_err(unwritable)?;
        self.done.rows += rows;
        if !self.file.format.is_of_detections() {
            self.fixed.rows += rows;
            self.fixed.bytes += (self.buffer.len() - before) as u64;
        }
        self.flush()?;
        self.out.flush().map_err(unwritable)
    }

    /// Ends a sample where it is long enough.
    fn is_within_bounds(&mut self) -> store::Result<()> {
        let Some(bounds) = self.bounds else { return Ok(()) };
        self.read += 1;
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
        if self.writer.row(&mut self.buffer, &heard).map_err(unwritable)? {
            self.done.rows += 1;
            cover(&mut self.covered, &heard);
        }
        if self.buffer.len() >= CHUNK { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> store::Result<()> {
        self.out.write_all(&self.buffer).map_err(unwritable)?;
        self.done.bytes += self.buffer.len() as u64;
        self.buffer.clear();
        Ok(())
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
