//! Tests of `sim` from outside, one program: it is linked once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod compass;
mod motors;
mod reference;
mod vessel;
