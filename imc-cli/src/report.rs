//! What is said to people, on standard error. A closed standard error is no reason to fail.

use std::io::{self, Write as _};

/// A remark: something worth knowing that stops nothing.
pub(crate) fn note(text: &str) {
    writeln!(io::stderr(), "imc: {text}").ok();
}

/// The error that ends the command, with its causes.
pub(crate) fn error(error: &anyhow::Error) {
    writeln!(io::stderr(), "imc: {error:#}").ok();
}
