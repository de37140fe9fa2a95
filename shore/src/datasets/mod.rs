//! Datasets: detections of a frozen question that are published, cited, and given to others by links.
//!
//! A published version is its question, its count of rows and the SHA-256 of its canonical CSV: the file itself is made of the
//! archive whenever it is asked for, and [`Datasets::check`] tells whether the archive still gives the same bytes. `rows` keeps
//! datasets in app.db and `links` what concerns links; `contents` computes files; `service` decides who may what; `shares` is what
//! somebody without an account gets, who has nothing but the address of a link.

mod contents;
mod links;
mod rows;
mod service;
mod shares;
#[cfg(test)]
mod tests;

pub use contents::Frozen;
pub use service::Datasets;
pub use shares::{OpenShare, ShareClosed};
