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

/// A number of things, `1 row` or `2 rows`, whose plural has an s.
pub(crate) fn counted(number: impl TryInto<u64>, thing: &str) -> String {
    match number.try_into() {
        Ok(1) => format!("1 {thing}"),
        Ok(number) => format!("{number} {thing}s"),
        Err(_) => format!("many {thing}s"),
    }
}

pub(crate) fn out(text: Arguments<'_>) {
    writeln!(io::stdout().lock(), "{text}").ok();
}

pub(crate) fn err(text: Arguments<'_>) {
    writeln!(io::stderr().lock(), "{text}").ok();
}

#[cfg(test)]
mod tests {
    use super::counted;

    #[test]
    fn one_thing_is_not_several() {
        assert_eq!([0_usize, 1, 2].map(|count| counted(count, "row")), ["0 rows", "1 row", "2 rows"]);
    }
}
