#![no_main]

#[path = "../bodies/store.rs"]
mod bodies;

libfuzzer_sys::fuzz_target!(|data: &[u8]| bodies::chunk(data));
