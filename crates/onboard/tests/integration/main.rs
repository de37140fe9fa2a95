//! Tests of `onboard` from outside, one program: it is linked once.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod accuracy;
mod area;
mod common;
mod detections;
mod determinism;
mod drives;
mod faults;
mod gaps;
mod grounding;
mod leases;
mod maneuvers;
mod operators;
mod plans;
mod power;
mod preflight;
mod remedies;
mod remedy_matrix;
mod restart;
mod stillness;
mod ways;
