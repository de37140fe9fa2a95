//! Files of detections: what was heard, with what the register knows of it, in any format of `research`.
//!
//! Page, API and command line write all of them by [`write()`]. Memory is constant, but for the detections that wait for their
//! neighbours where a format tells how far those are (`research::Lags`, bounded). The same detections, names and register
//! give the same bytes.

use detections::Detection;
use research::{Format, HORIZON_S, LUTRA, Lag, Lags, Study, Writer, format};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use store::{DetectionsWanted, Exported, StoreError, TimeRange};
use tables::Dialect;

/// Bytes that are written at once.
const CHUNK: usize = 64 * 1024;

/// How a file of detections is written.
#[derive(Debug, Clone, Copy)]
pub struct HeardFile {
    /// Its format.
    pub format: Format,
    /// For whom; all formats but our own are for programs.
    pub dialect: Dialect,
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
        Ok(Self { format, dialect })
    }

    /// The time of which detections are read for rows of a time: the neighbours of the first and the last one too, where the
    /// format tells how far those are.
    pub fn read_range(&self, range: TimeRange) -> TimeRange {
        let beside_us = if self.format.has_lag { HORIZON_S * 1_000_000 } else { 0 };
        TimeRange {
            from_us: range.from_us.saturating_sub(beside_us),
            to_us: range.to_us.saturating_add(beside_us),
        }
    }

    /// The name of the file, without what packs it.
    pub fn name(&self) -> String {
        if self.format.name == LUTRA.name {
            "detections.csv".to_owned()
        } else {
            format!("detections-{}.csv", self.format.name)
        }
    }
}

/// Writes a header, and a row for each detection that is wanted. Vessels are called by `names`, else as they announced.
///
/// # Errors
/// When the history cannot be read or `out` not be written. A table that was begun then ends with a line that begins with
/// `#ERROR`, as far as it can be written, and is not whole.
pub fn write(
    data: &Path,
    wanted: &DetectionsWanted,
    names: &BTreeMap<u16, String>,
    study: &Study,
    file: HeardFile,
    out: &mut dyn Write,
) -> store::Result<Exported> {
    let writer = Writer::new(file.format, file.dialect);
    let mut rows = Rows {
        writer,
        study,
        names,
        range: wanted.range,
        announced: BTreeMap::new(),
        buffer: Vec::new(),
        out,
        done: Exported::default(),
    };
    let read = DetectionsWanted { range: file.read_range(wanted.range), ..wanted.clone() };
    let written = rows.write(data, &read, file.format);
    if let Err(error) = written {
        let line = format!("#ERROR the export is cut here: {error}\n").replace('\r', " ");
        rows.out.write_all(line.as_bytes()).ok();
        return Err(error);
    }
    Ok(rows.done)
}

/// Rows on their way into a file.
struct Rows<'r> {
    writer: Writer,
    study: &'r Study,
    names: &'r BTreeMap<u16, String>,
    /// Of which detections there are rows, by when they were reported.
    range: TimeRange,
    /// What vessels without a name by people announced.
    announced: BTreeMap<u16, String>,
    buffer: Vec<u8>,
    out: &'r mut dyn Write,
    done: Exported,
}

impl Rows<'_> {
    fn write(&mut self, data: &Path, wanted: &DetectionsWanted, format: Format) -> store::Result<()> {
        self.writer.header(&mut self.buffer);
        if format.is_of_detections() {
            let mut lags = format.has_lag.then(Lags::default);
            store::each_detection(data, wanted, &mut |one, announced| {
                let vessel = one.origin.system.0;
                if !self.names.contains_key(&vessel) && !self.announced.contains_key(&vessel) {
                    self.announced.insert(vessel, announced.to_owned());
                }
                let Some(lags) = &mut lags else { return self.row(&one, Lag::Unknown) };
                lags.push(one);
                while let Some((one, lag)) = lags.pop() {
                    self.row(&one, lag)?;
                }
                Ok(())
            })?;
            while let Some((one, lag)) = lags.as_mut().and_then(Lags::take) {
                self.row(&one, lag)?;
            }
        }
        self.done.rows += self.writer.rows_of(&mut self.buffer, self.study);
        self.flush()?;
        self.out.flush().map_err(unwritable)
    }

    fn row(&mut self, one: &Detection, lag: Lag) -> store::Result<()> {
        let reported_us = one.origin.reported.micros();
        if reported_us < self.range.from_us || reported_us >= self.range.to_us {
            return Ok(());
        }
        let vessel = one.origin.system.0;
        let called = self.names.get(&vessel).or_else(|| self.announced.get(&vessel)).map_or("", |name| name);
        let heard = self.study.heard(one, called, lag);
        self.done.rows += u64::from(self.writer.row(&mut self.buffer, &heard));
        if self.buffer.len() >= CHUNK { self.flush() } else { Ok(()) }
    }

    fn flush(&mut self) -> store::Result<()> {
        self.out.write_all(&self.buffer).map_err(unwritable)?;
        self.done.bytes += self.buffer.len() as u64;
        self.buffer.clear();
        Ok(())
    }
}

fn unwritable(source: std::io::Error) -> StoreError {
    StoreError::Io { path: "the export".into(), source }
}
