//! Machines that watch the vessel and step in: lost communications, battery reserve, operational limits.
//!
//! Each is pure and small: it is told what it watches, answers what to do, and can say at any time what it
//! will do next and when ([`Outlook`]). The caller carries actions out through the engine.

mod area;

pub use area::{Area, AreaError};
