//! Datasets: detections of a frozen question that are published, cited, and given to others by links.
//!
//! A published version is its question, its count of rows and the SHA-256 of its canonical CSV: the file itself is made of the
//! archive whenever it is asked for, and [`Datasets::check`] tells whether the archive still gives the same bytes. `rows` keeps
//! datasets in app.db and `links` what concerns links; `contents` computes files; `service` decides who may what, `sharing`
//! the same of links; `checks` compares with the archive; `places` bounds what links compute; `shares` is what somebody without an account gets, who has nothing but the address of a link.

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
