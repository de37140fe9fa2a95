//! How a file of detections is written: its format, what is left out of it, and what it says of itself.

use super::spool::MOST;
use api::FlagCode;
use research::{About, Format, HORIZON_S, LUTRA, Limits, Narrowed, Study, format};
use std::borrow::Cow;
use store::{StoreError, TimeRange};
use tables::Dialect;

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
    /// Bytes that may wait on the disk until it is whole.
    pub most_waiting_bytes: u64,
    /// What it says of itself, where its format has room for that.
    pub about: About,
}

impl HeardFile {
    /// By the name of a format, and for which spreadsheet.
    ///
    /// # Errors
    /// There is no such format or spreadsheet, or the format is not for spreadsheets.
    pub fn new(name: Option<&str>, spreadsheet: Option<&str>) -> store::Result<Self> {
        let dialect = crate::history::export::dialect(spreadsheet)?;
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
            most_waiting_bytes: MOST,
            about: About::default(),
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
    pub(super) fn needs_lag(&self) -> bool {
        self.format.has_lag || self.without.contains(&FlagCode::Unconfirmed)
    }

    /// The register as rows are told by it.
    pub(super) fn study<'s>(&self, study: &'s Study) -> Cow<'s, Study> {
        match self.limits.cells_m() {
            Some(cells_m) => Cow::Owned(study.clone().without_places(cells_m)),
            None => Cow::Borrowed(study),
        }
    }

    /// The name of the file, without what packs it.
    pub fn name(&self) -> String {
        let Format { name, .. } = self.format;
        let ending = self.format.ending();
        if name == LUTRA.name || !(self.format.is_csv() || ending == "zip") {
            format!("detections.{ending}")
        } else {
            format!("detections-{name}.{ending}")
        }
    }

    /// Whether what it begins with tells nothing of how long one without a row is.
    pub(super) fn is_made_at_its_end(&self) -> bool {
        self.format.needs_spool() || self.format.is_database()
    }

    /// Whether the tracks of vessels stand in it too: in a database, of a plain question. Who gets a dataset or a part of one gets what
    /// was heard, and no more of where vessels were.
    pub(in super::super) fn has_tracks(&self) -> bool {
        self.format.is_database() && !self.is_closed && self.limits == Limits::default()
    }

    /// The messages that its bytes are made of.
    pub fn messages(&self) -> Vec<String> {
        let of_detections = ["TBRFishTag", "Event"].into_iter();
        of_detections.chain(self.has_tracks().then_some("EstimatedState")).map(str::to_owned).collect()
    }
}
