//! Recorded missions, with a summary of each from the history.
//!
//! Nothing is deleted: a mission is changed or withdrawn, and its earlier state is kept. `rows` has the queries to app.db,
//! `summary` those to the history, `service` has the access rules.

mod rows;
mod service;
mod summary;
#[cfg(test)]
mod tests;

pub use service::Missions;
