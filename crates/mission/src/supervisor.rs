//! Machines that watch the vessel and step in: lost communications, battery reserve, operational limits.
//!
//! Each is pure and small: it takes what it watches as input, answers what to do ([`Remedy`]), and can say at any
//! time what it will do next and when ([`Outlook`]). The caller carries remedies out through the engine, as
//! plans that ignore errors, and reports to the machine when one could not be.

mod alarm;
mod battery;
mod limits;
mod lost_comms;

pub use battery::{BatteryConfig, BatteryOutput, BatteryReserve, BatteryStage};
pub use limits::{LimitsConfig, LimitsOutput, OperationalLimits, Violation};
pub use lost_comms::{Activity, LostComms, LostCommsConfig, LostCommsInput, LostCommsOutput, Step};

use std::fmt;
use units::MonoTime;

/// A supervisor's remedy.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Remedy {
    /// Keep station where the vessel is.
    Hold,
    /// Run the stored plan of this name.
    Run {
        /// The plan.
        plan_id: String,
    },
    /// End what runs and drift.
    Stop,
}

impl fmt::Display for Remedy {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Hold => f.write_str("hold station"),
            Self::Run { plan_id } => write!(f, "run plan {plan_id}"),
            Self::Stop => f.write_str("stop"),
        }
    }
}

/// What a supervisor will do next if nothing changes.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Outlook {
    /// The next remedy.
    pub remedy: Remedy,
    /// When, as far as known.
    pub at: Option<MonoTime>,
}
