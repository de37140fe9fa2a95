//! Tests of `hub` from outside, one program: it is linked once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod echo;
mod linked;
mod routing;
mod support;
