#![no_main]

#[path = "../bodies/detections.rs"]
mod bodies;

libfuzzer_sys::fuzz_target!(|data: &[u8]| bodies::report(data));
