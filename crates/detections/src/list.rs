//! Tuple lists, written and read.

use imc::tuples;
use std::fmt::Write as _;
use std::str::FromStr;

/// A tuple list that grows.
#[derive(Default)]
pub(crate) struct List(pub(crate) String);

impl List {
    pub(crate) fn put(&mut self, name: &str, value: impl std::fmt::Display) {
        let separator = if self.0.is_empty() { "" } else { ";" };
        write!(self.0, "{separator}{name}={value}").ok();
    }

    pub(crate) fn known(&mut self, name: &str, value: Option<impl std::fmt::Display>) {
        if let Some(value) = value {
            self.put(name, value);
        }
    }
}

pub(crate) fn number<T: FromStr>(list: &str, name: &str) -> Option<T> {
    tuples::get(list, name)?.parse().ok()
}
