//! Data for researchers: the register of a study, and detections in the formats that portals and R packages take.
//!
//! - The register: the fields of an entry ([`columns`], [`slots`], [`check`], [`check_all`]), and entries as CSV
//!   ([`write_csv`], [`read_csv`], [`template`]).
//! - [`Study`] is a register by which detections are looked up: [`Study::heard`] says whose tag it was, where the receiver
//!   belonged, and what its sensor count means.
//! - [`summary()`] counts a million of them for plots; [`Narrowed`] are those of an area and of projects, and
//!   [`Heard::flags`] says why one is doubtful.
//! - Datasets: [`check_draft`], [`citation`], metadata ([`datacite`], [`json_ld`], [`datapackage`]), and the limits of a
//!   link to one ([`Limits`], [`Grid`]).
//! - [`Format`] is one file format: its header, and a row for a [`Heard`]. [`FORMATS`] lists them all.
//! - [`read_detections`] and [`read_parquet`] read detections from files: our own, and those of other receivers.
//!
//! It is pure: entries and detections in, bytes out. It knows what a detection is and what the API calls an entry; it knows
//! nothing of files, databases and HTTP.

mod check;
mod column;
mod csv;
mod dataset;
mod explore;
mod fields;
mod filters;
mod formats;
mod lag;
mod narrowed;
mod orcid;
mod quality;
mod reading;
mod study;
mod template;

pub use check::{Fault, check, check_all, name_taken};
pub use column::{Column, Rule, Slot};
pub use csv::{Difference, Names, ROWS, Read, ReadRow, WrongCell, differences, read_csv, write_csv};
pub use dataset::{
    Access, CANONICAL_FORMAT, Described, Grid, LICENCES, Limits, PRECISIONS_M, SOFTWARE, check_draft,
    citation, datacite, datapackage, doi, embargo_us, json_ld, lacking, licence_name, licence_page, python,
    r,
};
pub use explore::{Question, Rank, Ranks, Sightings, SightingsBuilder, ranks, summary};
pub use fields::{KINDS, blank, columns, kind_of, kind_said, kind_word, name_of, slots};
pub use filters::{area, tag};
pub use formats::{
    About, ColumnKind, DetectionColumn, FORMATS, Format, LUTRA, LUTRA_COLUMNS, Spool, TrackOf, Value, Writer,
    format, values, write_track,
};
pub use lag::{HORIZON_S, Lag, Lags};
pub use narrowed::Narrowed;
pub use orcid::is_orcid;
pub use reading::{Carriers, ReadDetections, is_detections, read_detections, read_parquet};
pub use study::{Heard, Sensor, Study};
pub use template::template;
