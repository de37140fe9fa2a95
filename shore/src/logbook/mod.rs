//! The log book that people keep: notes with time, place, vessel and photo.
//!
//! Nothing in it is deleted: a note is corrected or withdrawn by its author or an admin, and its earlier text is kept.
//! `rows` has the queries to app.db, `photos` keeps files in the data folder, `service` has the access rules, `csv` writes
//! the downloaded file.

mod csv;
mod photos;
mod rows;
mod service;
#[cfg(test)]
mod tests;

pub use csv::{CSV_HEAD, csv_row};
pub use photos::{PHOTO_BYTES, Photo};
pub use rows::{Filter, Notes, Row};
pub use service::{Cursor, Logbook};

pub(crate) use rows::NEWER;
pub(crate) use service::{TIMES_US, check_text, may_write, not_a_time};
