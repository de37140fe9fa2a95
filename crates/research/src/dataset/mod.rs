//! Datasets: their drafts, citations, metadata, and the limits of links to them.

mod canonical;
mod draft;
mod grid;
mod limits;
mod metadata;
mod notebook;

pub use canonical::{CANONICAL_FORMAT, SOFTWARE};
pub use draft::{LICENCES, check_draft, citation, doi, embargo_us, lacking, licence_name, licence_page};
pub use grid::{Grid, PRECISIONS_M};
pub use limits::Limits;
pub use metadata::{Described, datacite, datapackage, json_ld};
pub use notebook::{Access, python, r};
