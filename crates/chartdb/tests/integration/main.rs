//! Tests of `chartdb` from outside, one program: it is linked once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod all_or_nothing;
mod areas;
mod editions;
mod fuzz_seeds;
mod geopackage;
mod lakes;
mod one_by_one;
mod real_cells;
mod support;
