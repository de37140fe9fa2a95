//! Tests of `vehicle-agent` from outside, one program: it is linked once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod common;
mod faults;
mod killed;
mod process;
mod readers;
mod uplink;
