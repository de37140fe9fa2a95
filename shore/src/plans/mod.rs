//! Plans ashore: kept with their revisions, checked as a vessel would, written for vessels and for other programs.
//!
//! What people draw is an [`api::PlanDocument`]. `translate` alone knows how it becomes a PlanSpecification and
//! back; `check` asks the very code that vessels judge plans by, so that what is good here is good aboard, but
//! for limits of a vessel's own.

mod check;
mod files;
mod route;
mod store;
mod translate;
mod trouble;

#[cfg(test)]
mod tests;

pub use check::{aboard, check, check_with, limits, understood};
pub use files::{Format, read, write};
pub use route::route;
pub use store::{Change, Create, Delete, List, Load, Restore, Revisions, Row, Save};
pub use translate::{document, specification};
