//! Missions that people record, with what the history tells of each.
//!
//! Nothing goes: a mission is changed or withdrawn, and what it said before stays. `rows` asks app.db, `summary` the history,
//! `service` decides who may what.

mod rows;
mod service;
mod summary;
#[cfg(test)]
mod tests;

pub use service::Missions;
