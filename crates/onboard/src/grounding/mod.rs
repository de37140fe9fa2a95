//! The grounding supervisor: the sea chart is the eyes of a vessel without any sensor for land or depth.
//!
//! Plans are checked against the chart by [`mission::check_plan`] when they are stored and started. Under way the water
//! ahead is checked with every estimate: along the course over ground, in a corridor as wide as hull and
//! position uncertainty that widens with distance. In this order: warn, slow down, turn back to deep water (or
//! stop), and at last stop for good when the vessel lies in danger with its motors running. An operator's
//! thrust towards danger is blocked and what moves away is let through; near danger with a current that carries
//! the vessel in, the supervisor takes over. What it does goes through the [arbiter](crate::arbiter).
//!
//! At rest it acts only where the rest began in deep water: a vessel at the quay never starts on its own.

mod exemption;
mod settings;
mod watch;

pub(crate) use exemption::Answer as Exempted;
pub use settings::{Chart, ChartFile, GroundingAction, GroundingSettings};
pub(crate) use watch::{Advice, Doing, Grounding, Stage};

/// The run of the supervisor that leads back to deep water; no plan of the database bears this name in it.
pub(crate) const DEEP_WATER: &str = "deep water";
