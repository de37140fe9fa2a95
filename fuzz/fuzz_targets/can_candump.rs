#![no_main]

#[path = "../bodies/can.rs"]
mod bodies;

libfuzzer_sys::fuzz_target!(|data: &[u8]| bodies::candump(data));
