//! The way to the shore.
#![expect(dead_code, reason = "wired below")]
mod spool;
