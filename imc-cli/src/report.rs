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
