//! Tests of `imc` from outside, one program: it is linked once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod fuzz_seeds;
mod golden;
mod layouts;
mod logs;
mod properties;
mod recordings;
mod support;
