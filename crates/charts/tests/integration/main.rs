//! Tests of `charts` from outside, one program: it is linked once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod broken_cells;
mod depth_reference;
mod expected;
mod fuzz_seeds;
mod made_up;
mod made_up_updates;
mod masks_and_soundings;
mod regional;
mod restricted;
mod s58;
mod writer;
mod written;
