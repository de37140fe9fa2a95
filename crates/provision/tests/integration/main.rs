//! Tests of `provision` from outside.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod fuzz_seeds;
