#![no_main]

#[path = "../bodies/lakes.rs"]
mod bodies;

libfuzzer_sys::fuzz_target!(|data: &[u8]| bodies::lakes(data));
