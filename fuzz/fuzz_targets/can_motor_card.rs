#![no_main]

#[path = "../bodies/motors.rs"]
mod bodies;

libfuzzer_sys::fuzz_target!(|data: &[u8]| bodies::motor_card(data));
