//! Tests of `vehicle-agent` from outside, one program: it is linked once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod clock;
mod common;
mod doctor;
mod faults;
mod gpsd;
mod hardware;
mod killed;
mod process;
mod readers;
mod sniff;
mod sources;
mod uplink;
