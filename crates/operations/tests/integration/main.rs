//! Tests of `operations` with the hub below it, one program: it is linked once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod downlink;
mod other_source;
