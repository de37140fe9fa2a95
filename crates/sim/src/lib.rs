//! A simulated Otter.
#![doc = ""]
mod otter;
mod pair;
mod process;
mod range;
mod rng;

pub use otter::*;
pub use pair::{Pair, Side};
pub use range::OutOfRange;
