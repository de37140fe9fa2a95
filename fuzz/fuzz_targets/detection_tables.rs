#![no_main]

#[path = "../bodies/detection_tables.rs"]
mod bodies;

libfuzzer_sys::fuzz_target!(|data: &[u8]| bodies::table(data));
