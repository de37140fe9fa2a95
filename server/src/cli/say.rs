//! Output for people, which does not fail when the reader is gone.

use std::fmt::Arguments;
use std::io::{self, Write as _};

/// As `println!`, without failing when the reader is gone.
macro_rules! say {
    ($($text:tt)*) => { $crate::cli::say::out(format_args!($($text)*)) };
}

/// As `eprintln!`, without failing when the reader is gone.
macro_rules! complain {
    ($($text:tt)*) => { $crate::cli::say::err(format_args!($($text)*)) };
}

pub(crate) use {complain, say};

pub(crate) fn out(text: Arguments<'_>) {
    writeln!(io::stdout().lock(), "{text}").ok();
}

pub(crate) fn err(text: Arguments<'_>) {
    writeln!(io::stderr().lock(), "{text}").ok();
}
