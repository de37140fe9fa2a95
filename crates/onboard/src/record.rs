//! Inputs and outputs as bytes, so that a run can be recorded and replayed to the last bit.
//!
//! A record is the moment, a kind and fields, all little-endian; texts and lists carry their length first.
//! Numbers that are not valid (NaN) survive. Layouts belong to one version of the program; a recording says which.

mod read;
mod write;

pub use read::{Garbled, read_input};
pub use write::{write_input, write_output};
