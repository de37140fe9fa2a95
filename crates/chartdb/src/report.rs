//! The options of an import, and its result.

use crate::error::ChartDbError;
use crate::read::Chart;
use charts::s57::SkinCheck;
use charts::xyz::Vertical;
use units::UtcTime;

/// How to read what does not say it itself.
#[derive(Debug, Clone, PartialEq)]
pub struct ImportOptions {
    /// EPSG code of soundings, and of lakes that do not name theirs: a zone of UTM, or 4326 or 4258 for
    /// degrees.
    pub epsg: Option<u32>,
    /// Which way the z of soundings counts.
    pub vertical: Vertical,
    /// Column of the least depth of lakes (m).
    pub depth_column: Option<String>,
    /// Column of the greatest depth of lakes (m).
    pub deepest_column: Option<String>,
    /// Table of a GeoPackage with lakes, where it has several.
    pub layer: Option<String>,
    /// Import what is whole although others are not.
    pub keep_going: bool,
    /// The time to note.
    pub now: UtcTime,
}

impl ImportOptions {
    /// The defaults.
    pub fn new(now: UtcTime) -> Self {
        Self {
            epsg: None,
            vertical: Vertical::DepthDown,
            depth_column: None,
            deepest_column: None,
            layer: None,
            keep_going: false,
            now,
        }
    }
}

/// How far an import is.
#[derive(Debug, Clone, Copy)]
pub struct ImportProgress<'a> {
    /// Charts that are done.
    pub done: usize,
    /// Charts in all.
    pub of: usize,
    /// The chart that is next, or `index`.
    pub name: &'a str,
}

/// What was done with a chart.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
#[serde(tag = "outcome", rename_all = "snake_case")]
pub enum Outcome {
    /// It is new in the set.
    Added,
    /// It took the place of an older one.
    Replaced {
        /// Edition and update before.
        before: String,
    },
    /// It was there already, the same.
    Unchanged,
    /// Its producer has withdrawn it, and it is out of the set.
    Withdrawn,
}

/// A chart that was read.
#[derive(Debug, Clone, PartialEq)]
pub struct Imported {
    /// Name.
    pub name: String,
    /// `cell`, `soundings`, `land` or `lakes`.
    pub kind: &'static str,
    /// What was done.
    pub outcome: Outcome,
    /// Edition, for cells.
    pub edition: String,
    /// Last update, for cells.
    pub update: String,
    /// Number of features.
    pub features: u64,
    /// The acceptance check, for cells.
    pub skin: Option<SkinCheck>,
    /// What was dropped or repaired; it is in the import log too.
    pub notices: Vec<String>,
}

/// A chart that could not be read.
#[derive(Debug)]
pub struct ImportFailure {
    /// Name.
    pub name: String,
    /// Why, with file, place and remedy.
    pub error: ChartDbError,
}

/// The result of an import.
#[derive(Debug)]
pub struct ImportReport {
    /// Charts that were read.
    pub charts: Vec<Imported>,
    /// Charts that could not be read.
    pub failures: Vec<ImportFailure>,
    /// Other notices.
    pub notices: Vec<String>,
    /// Whether the set was changed, or was this already.
    pub applied: bool,
    /// Digest of the set now, in hexadecimal; empty where there is no set.
    pub digest: String,
}

/// The outcome, by what was there before.
pub(crate) fn outcome(before: Option<&Chart>) -> Outcome {
    before.map_or(Outcome::Added, |chart| Outcome::Replaced {
        before: if chart.kind == "cell" {
            format!("edition {}, update {}", chart.edition, chart.update)
        } else {
            format!("imported {}", chart.imported)
        },
    })
}

/// A chart that was there already.
pub(crate) fn unchanged(chart: &Chart, kind: &'static str) -> Imported {
    Imported {
        name: chart.name.clone(),
        kind,
        outcome: Outcome::Unchanged,
        edition: chart.edition.clone(),
        update: chart.update.clone(),
        features: chart.features,
        skin: None,
        notices: Vec::new(),
    }
}
