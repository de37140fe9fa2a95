//! Missions that people record, with a summary of each from the history.
//!
//! Nothing is deleted: a mission is changed or withdrawn, and its earlier state is kept. `rows` asks app.db, `summary` the history,
//! `service` decides who may what.

mod rows;
mod service;
mod summary;
#[cfg(test)]
mod tests;

pub use service::Missions;
