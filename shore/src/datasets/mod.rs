//! Datasets: the detections of a frozen query, published, cited, and shared by links.
//!
//! A published version consists of its query, its number of rows and the SHA-256 of its canonical CSV: the file itself is
//! made from the archive on request, and [`Datasets::check`] tells whether the archive still gives the same bytes. `rows`
//! keeps datasets in app.db, `links` keeps links; `contents` computes files; `service` has the access rules of datasets,
//! `sharing` those of links; `checks` compares with the archive; `places` limits the computation for links; `shares` serves
//! clients without an account, who have only the address of a link.

mod checks;
mod contents;
mod links;
mod places;
mod rows;
mod service;
mod shares;
mod sharing;
#[cfg(test)]
mod tests;

pub use contents::Frozen;
pub use places::LinkPlace;
pub use service::Datasets;
use service::find_version;
pub use shares::{OpenShare, ShareClosed};
