//! Tests of `planner` from outside, one program: it is linked once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod long;
mod objectives;
mod routes;
mod traffic;
mod waters;
mod weighed;
