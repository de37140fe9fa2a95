//! Messages for people, on standard error. A closed standard error is not an error.

use std::io::{self, Write as _};

/// A note that does not stop the command.
pub(crate) fn note(text: &str) {
    writeln!(io::stderr(), "imc: {text}").ok();
}

/// The error that ends the command, with its causes.
pub(crate) fn error(error: &anyhow::Error) {
    writeln!(io::stderr(), "imc: {error:#}").ok();
}

/// A number of things, `1 packet` or `2 packets`, whose plural has an s.
pub(crate) fn counted(number: u64, thing: &str) -> String {
    let s = if number == 1 { "" } else { "s" };
    format!("{number} {thing}{s}")
}
