//! What a vessel that follows references reports to their sender.

use crate::event::Reference;

/// The phase of the maneuver.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum ReferencePhase {
    /// No reference has come.
    Wait,
    /// On the way.
    Goto,
    /// Motors off: near enough, or ordered to stop.
    Hover,
    /// The commander was silent too long.
    Timeout,
}

/// The state to report to the commander: after each reference and at each change of phase.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ReferenceState {
    /// The phase.
    pub phase: ReferencePhase,
    /// The reference as followed, what was absent filled in.
    pub reference: Option<Reference>,
    /// Whether the place is within the radius and the tolerance.
    pub near: bool,
}
