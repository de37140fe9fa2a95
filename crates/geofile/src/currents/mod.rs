//! Grids of currents with time steps, from CSV and NetCDF.
//!
//! Both formats give a [`CurrentField`]: times, latitudes and longitudes that rise, and the current to the east and to the
//! north at their crossings. What a file leaves out is not a number. A file is read whole or refused with the place of
//! the error and the remedy.

mod csv;
mod header;
mod netcdf;

/// Columns of CSV, in any order.
pub const COLUMNS: [&str; 5] = ["time", "lat", "lon", "east_mps", "north_mps"];
/// Most crossings of a grid: times × latitudes × longitudes.
pub const MOST_CROSSINGS: usize = 4 << 20;

/// Currents at the crossings of latitudes and longitudes, at one or more times.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct CurrentField {
    /// Times (s since 1970, UTC), rising.
    pub times_s: Vec<f64>,
    /// Latitudes (°), rising.
    pub lats_deg: Vec<f64>,
    /// Longitudes (°), rising; also beyond 180.
    pub lons_deg: Vec<f64>,
    /// To the true east (m/s) by time, then latitude, then longitude; not a number where the file has no value.
    pub east_mps: Vec<f32>,
    /// To the true north (m/s), as to the east.
    pub north_mps: Vec<f32>,
}

/// Why a file is not a grid of currents.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum CurrentsError {
    /// The file is not in UTF-8.
    #[error("the file is neither NetCDF nor text in UTF-8; give CSV or NetCDF-3")]
    Text,
    /// A line of CSV is wrong.
    #[error("line {line}: {trouble}")]
    Line {
        /// Which, from 1.
        line: usize,
        /// What is wrong with it.
        trouble: LineTrouble,
    },
    /// The points of the file are not a grid: too few latitudes or longitudes.
    #[error("the file has {lats} latitudes and {lons} longitudes; a grid has two of each or more")]
    TooFew {
        /// Different latitudes.
        lats: usize,
        /// Different longitudes.
        lons: usize,
    },
    /// They make more crossings than are read, or many more than the file has lines.
    #[error(
        "{times} times, {lats} latitudes and {lons} longitudes make {crossings} crossings, and the file has {lines} lines: give \
         points on a grid of latitudes and longitudes, {MOST_CROSSINGS} at most"
    )]
    Scattered {
        /// Different times.
        times: usize,
        /// Different latitudes.
        lats: usize,
        /// Different longitudes.
        lons: usize,
        /// Crossings that these make.
        crossings: usize,
        /// Lines with values.
        lines: usize,
    },
    /// A NetCDF file that cannot be read.
    #[error("NetCDF: {0}")]
    NetCdf(String),
}

/// What is wrong with a line of CSV, and the remedy.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum LineTrouble {
    /// It is one too many.
    #[error("the file has more than {most} lines; cut it to the area and the time")]
    TooMany {
        /// So many are read.
        most: usize,
    },
    /// The heading lacks a column.
    #[error("the heading has no column {name}; begin the file with {}", COLUMNS.join(","))]
    NoColumn {
        /// Which.
        name: &'static str,
    },
    /// It ends before a column.
    #[error("there is no {name}: it has {columns} columns; write one for each in the heading")]
    Short {
        /// Which column.
        name: &'static str,
        /// Columns that it has.
        columns: usize,
    },
    /// Its time cannot be read.
    #[error("time: {text} is not a time such as 2026-11-21T07:00:00Z")]
    NoTime {
        /// What stands there.
        text: String,
    },
    /// Its latitude or longitude is not one.
    #[error("{name}: {text} is not within {least} to {most} degrees")]
    NoDegrees {
        /// Which of the two columns.
        name: &'static str,
        /// What stands there.
        text: String,
        /// Least degrees.
        least: i16,
        /// Most degrees.
        most: i16,
    },
    /// A speed cannot be read.
    #[error("{name}: {text} is not a speed in m/s; leave it empty where it is not known")]
    NoSpeed {
        /// Which of the two columns.
        name: &'static str,
        /// What stands there.
        text: String,
    },
    /// Its time and place had a line before.
    #[error("the same time and place as in line {first}; remove one")]
    Twice {
        /// The other line, from 1.
        first: usize,
    },
}

/// Reads a file: NetCDF by its first bytes, else CSV.
///
/// CSV has a heading with `time`, `lat`, `lon`, `east_mps` and `north_mps` in any order, and a line for each crossing in
/// any order: an ISO 8601 time, degrees, metres a second. An empty speed, or a line that is missing, is a value that is
/// not known. NetCDF is of the classic format (CDF-1 or CDF-2) and by the CF conventions: currents are found by
/// `standard_name`, or by the usual names of variables.
///
/// # Errors
/// What is wrong, where, and what to do.
pub fn read(bytes: &[u8]) -> Result<CurrentField, CurrentsError> {
    if bytes.starts_with(b"CDF") || bytes.starts_with(b"\x89HDF") {
        return netcdf::read(bytes);
    }
    let text = std::str::from_utf8(bytes).map_err(|_| CurrentsError::Text)?;
    csv::read(text.trim_start_matches('\u{feff}'))
}
