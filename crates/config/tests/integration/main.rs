//! Tests of `config` from outside, one program: it is linked once.

mod dialect;
mod hostile;
mod mistakes;
mod otters;
mod overlay;
mod schema;
