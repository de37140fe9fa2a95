//! The guard against grounding: is the water that a vessel sweeps deep enough, by the sea chart?
//!
//! It compares the area that a vessel sweeps with the [depth index](charts::depth_index), and knows geometry only:
//! ways, tracks, circles and places with a label that names their owner. `mission` turns plans and maneuvers into these;
//! a route planner asks leg by leg; a vessel under way asks for the water around it. So each question about safety has
//! one function, ashore and aboard, and equal charts, limits and ways give equal answers. It knows nothing of plans,
//! IMC, files or the clock.
//!
//! - [`Check`] takes all that is swept, in the order it is sailed, and gives a [`Verdict`]; [`check_way`] one straight
//!   way.
//! - [`WaterAround`] is what the vessel under way asks: is it clear here and ahead, where is a [`Refuge`]?
//! - [`Waters`] is where the vessel may sail autonomously: the [`Area`] of operation and the chart.
//! - [`GuardLimits`] state the depth required, and the uncertainty of position, track and chart.
//!
//! SI units and radians; bearings turn clockwise from north.

mod area;
mod check;
mod limits;
mod refuge;
mod reported;
mod sweep;
mod verdict;
mod water_around;
mod waters;

pub use area::{Area, AreaError};
pub use check::{Check, LONGEST_WAY_M, MOST_CORRIDORS, check_way};
pub use limits::{GuardLimits, LimitsError};
pub use refuge::Refuge;
pub use reported::ReportedLeg;
pub use sweep::Disc;
pub use verdict::{Entered, LegCheck, Outcome, Part, Reason, Spot, Verdict, Warning};
pub use water_around::{Ahead, WaterAround};
pub use waters::{WaterChart, Waters};
