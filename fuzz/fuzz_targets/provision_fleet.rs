#![no_main]

#[path = "../bodies/provision.rs"]
mod bodies;

libfuzzer_sys::fuzz_target!(|data: &[u8]| bodies::fleet(data));
