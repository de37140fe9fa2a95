//! Doors through which IMC comes in and goes out, one module each.

mod closed;

pub(crate) use closed::closed;
