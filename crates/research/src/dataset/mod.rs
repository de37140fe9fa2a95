//! Datasets: what their drafts may say, how they are cited, how they are described to others, and what a link gives of one.

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
