//! Tests of `link` from outside, one program: it is linked once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod fuzz_seeds;
mod sessions;
mod simulation;
mod ways;
mod world;
