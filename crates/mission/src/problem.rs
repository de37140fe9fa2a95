//! Errors of a plan, and warnings.

use std::fmt;
use thiserror::Error;
use units::Speed;

/// How many problems a text lists before it counts the others.
const LISTED: usize = 10;

/// Everything that is wrong with a plan; never empty.
#[derive(Debug, Clone, PartialEq, Error)]
pub struct PlanProblems(pub Vec<PlanProblem>);

impl fmt::Display for PlanProblems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (index, problem) in self.0.iter().take(LISTED).enumerate() {
            let separator = if index == 0 { "" } else { "; " };
            write!(f, "{separator}{problem}")?;
        }
        let more = self.0.len().saturating_sub(LISTED);
        if more > 0 { write!(f, "; and {more} more") } else { Ok(()) }
    }
}

/// One error, and where.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanProblem {
    /// Name of the maneuver; `None` for the plan itself.
    pub maneuver: Option<String>,
    /// The kind of problem.
    pub kind: ProblemKind,
}

impl PlanProblem {
    pub(crate) fn of_plan(kind: ProblemKind) -> Self {
        Self { maneuver: None, kind }
    }

    pub(crate) fn of(maneuver: &str, kind: ProblemKind) -> Self {
        Self { maneuver: Some(maneuver.to_owned()), kind }
    }
}

impl fmt::Display for PlanProblem {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.maneuver {
            Some(maneuver) => write!(f, "{maneuver}: {}", self.kind),
            None => write!(f, "{}", self.kind),
        }
    }
}

/// What is wrong.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum ProblemKind {
    /// The plan has no name.
    #[error("the plan has no name")]
    NoPlanId,
    /// The plan has no maneuvers.
    #[error("the plan has no maneuvers")]
    Empty,
    /// The plan has too many maneuvers.
    #[error("{count} maneuvers, {limit} are allowed")]
    TooManyManeuvers {
        /// How many.
        count: usize,
        /// The limit.
        limit: usize,
    },
    /// A maneuver's name is empty or reserved.
    #[error("a maneuver needs a name other than _done_")]
    BadId,
    /// Two maneuvers have one name.
    #[error("the name is used twice")]
    DuplicateId,
    /// There is no maneuver to start with.
    #[error("the first maneuver, '{0}', does not exist")]
    UnknownStart(String),
    /// A transition from nowhere.
    #[error("a transition leads from '{0}', which does not exist")]
    TransitionFrom(String),
    /// A transition to nowhere.
    #[error("a transition leads to '{0}', which does not exist")]
    TransitionTo(String),
    /// No transition leads here.
    #[error("no transition leads to it")]
    Unreachable,
    /// A maneuver without content.
    #[error("it holds no maneuver")]
    NoManeuver,
    /// This vessel does not do such maneuvers.
    #[error("maneuver {0} is not supported")]
    Unsupported(String),
    /// Deeper than the vessel can.
    #[error("a depth of {depth_m} m is wanted, {limit_m} m is possible")]
    Depth {
        /// The wanted value (m).
        depth_m: f64,
        /// The possible value (m).
        limit_m: f64,
    },
    /// Two numbers are not a place.
    #[error("{0}")]
    Place(#[from] units::PlaceError),
    /// Both coordinates are exactly 0: a position that was never filled in.
    #[error("the position is 0, 0")]
    NullIsland,
    /// A place outside the area of operation.
    #[error("it leaves the area of operation by {0:.0} m")]
    OutsideArea(f64),
    /// A speed that is not a number above 0 within the limit.
    #[error("a speed of {0} is not possible")]
    Speed(Speed),
    /// A number that is not valid, or out of its range.
    #[error("{what} {value} is not within {min} to {max}")]
    Range {
        /// Of what.
        what: &'static str,
        /// It.
        value: f64,
        /// Least value.
        min: f64,
        /// Largest value.
        max: f64,
    },
    /// A fault in a part that a draft does not have, found by its maker.
    #[error("{0}")]
    Refused(String),
    /// Too many points.
    #[error("{count} points, {limit} are allowed")]
    TooManyPoints {
        /// How many.
        count: usize,
        /// The limit.
        limit: usize,
    },
    /// Times that do not start at 0 or do not grow.
    #[error("the time of point {point} is not possible")]
    Timetable {
        /// Which point, from 0.
        point: usize,
    },
}

/// A warning for the author of a plan.
#[derive(Debug, Clone, PartialEq, Eq, Error)]
pub enum PlanWarning {
    /// The maneuvers follow each other in a circle.
    #[error("the plan never ends by itself")]
    Cycle,
    /// Only transitions that are ignored lead to a maneuver.
    #[error("{0}: never reached")]
    NeverReached(String),
    /// Not the first transition out of its maneuver.
    #[error("{from}: the transition to '{to}' is ignored, the first one counts")]
    TransitionIgnored {
        /// The maneuver.
        from: String,
        /// Where it would lead.
        to: String,
    },
    /// A loiter of a shape that is not sailed here.
    #[error("{0}: a circle is sailed in place of the shape")]
    CircleInstead(String),
    /// A path without points is done at once.
    #[error("{0}: has no points and is done at once")]
    NoPoints(String),
    /// A part that is left out, found by the maker of the draft.
    #[error("{}{text}", of(maneuver.as_deref()))]
    Unheeded {
        /// The maneuver; `None` for the plan itself.
        maneuver: Option<String>,
        /// What is wrong, in words.
        text: String,
    },
}

fn of(maneuver: Option<&str>) -> String {
    maneuver.map_or_else(String::new, |maneuver| format!("{maneuver}: "))
}
