//! Plans ashore: stored with their revisions, checked as a vessel would, converted for vessels and other programs.
//!
//! A drawn plan is an [`api::PlanDocument`]. Only `translate` converts it to a PlanSpecification and back; `check` uses the
//! same code as vessels, so that a plan accepted here is accepted aboard, except for a vessel's own limits.

mod check;
mod files;
mod route;
mod store;
mod translate;
mod trouble;
mod unread;

#[cfg(test)]
mod tests;

pub use check::{aboard, check, check_with, limits, understood};
pub use files::{Format, read, write};
pub use route::route;
pub use store::{Change, Create, Delete, List, Load, Restore, Revisions, Row, Save};
pub use translate::{document, specification};
pub use trouble::said;
