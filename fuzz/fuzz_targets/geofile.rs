#![no_main]

#[path = "../bodies/geofile.rs"]
mod bodies;

libfuzzer_sys::fuzz_target!(|data: &[u8]| bodies::file(data));
