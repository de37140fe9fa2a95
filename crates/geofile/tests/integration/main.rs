//! Tests of `geofile` from outside, one program: it is linked once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod currents;
mod files;
mod fuzz_seeds;
