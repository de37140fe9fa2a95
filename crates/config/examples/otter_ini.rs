//! Prints a complete, documented configuration: `cargo run -p config --example otter_ini -- NAME ADDRESS`.

use std::process::ExitCode;

use config::{Vessel, documented_ini, parse_int};

fn main() -> ExitCode {
    let mut vessel = Vessel::default();
    let mut arguments = std::env::args().skip(1);
    if let Some(name) = arguments.next() {
        vessel.name = name;
    }
    if let Some(text) = arguments.next() {
        let Some(address) = parse_int(&text).ok().and_then(|number| u16::try_from(number.value).ok()) else {
            eprintln!("`{text}` is not an IMC address; write it like 0x2810");
            return ExitCode::FAILURE;
        };
        vessel.address = address;
    }
    match documented_ini(&vessel) {
        Ok(text) => {
            print!("{text}");
            ExitCode::SUCCESS
        }
        Err(error) => {
            eprintln!("{error}");
            ExitCode::FAILURE
        }
    }
}
