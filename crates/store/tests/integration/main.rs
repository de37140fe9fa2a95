//! Tests of `store` from outside, one program: it is linked once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod compressed;
mod damage;
mod dialect;
mod export;
mod fuzz_seeds;
mod kill;
mod kinds;
mod months;
mod parquet;
mod properties;
mod recordings;
mod silences;
mod support;
mod tracks;
mod upkeep;
