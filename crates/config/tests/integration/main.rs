//! Tests of `config` from outside, one program: it is linked once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod dialect;
mod hostile;
mod mistakes;
mod otters;
mod overlay;
mod schema;
