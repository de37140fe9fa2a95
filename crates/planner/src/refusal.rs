//! Why no route is given, in words that say what to do.

use crate::needs::NeedsError;
use crate::room::PlanError;
use charts::depth_index::{Restriction, Water};
use std::fmt;
use units::LatLon;

/// An end of a way, or of one of its stretches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// Where it begins.
    Start,
    /// A place to pass, by its number from 1.
    Via(usize),
    /// Where it leads.
    Goal,
}

impl fmt::Display for End {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Start => f.write_str("the start"),
            Self::Via(number) => write!(f, "place {number} on the way"),
            Self::Goal => f.write_str("the goal"),
        }
    }
}

/// Why no route is given.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refusal {
    /// Needs that nothing can meet.
    #[error(transparent)]
    Needs(#[from] NeedsError),
    /// An end lies in closed water, farther from open water than it may be moved.
    #[error("{}", closed_text(*.end, (*.water, *.refused, *.zoned), *.nearest_m, *.allowed_m))]
    Closed {
        /// The end that is meant.
        end: End,
        /// What there is.
        water: Water,
        /// How the place is closed to the vessel by a rule, if it is.
        refused: Option<Restriction>,
        /// It lies outside the allowed zone or in a forbidden one.
        zoned: bool,
        /// Distance to the nearest open water (m); `None` beyond 50 km.
        nearest_m: Option<f64>,
        /// How far it may be moved (m).
        allowed_m: f64,
    },
    /// Both ends lie in open water, but no open water connects them.
    #[error(
        "no route is deep enough and keeps this clearance; the nearest place that can be reached is {gap_m:.0} m from the \
         goal{}", searched_text(*.looked_km)
    )]
    NoWay {
        /// The place nearest to the goal that can be reached.
        nearest: LatLon,
        /// How far that is from the goal (m).
        gap_m: f64,
        /// How far from the start that place was searched for (km); `None` where all water was searched.
        looked_km: Option<f64>,
    },
    /// The depth index does not confirm a leg that was found. The route is withheld.
    #[error(
        "the check against the chart failed near {at}, so the route is withheld; please report this with the charts' names"
    )]
    NotConfirmed {
        /// The place.
        at: String,
    },
    /// Water that was looked at holds no way, and not all water was looked at.
    #[error(
        "no route was found in the water that was looked at, up to {looked_km:.0} km from the start; the nearest place there that \
         can be reached is {gap_m:.0} m from the goal: add places on the way"
    )]
    Unknown {
        /// How far from the start it was looked (km).
        looked_km: f64,
        /// The place nearest to the goal that can be reached, as far as it was looked.
        nearest: LatLon,
        /// How far that is from the goal (m).
        gap_m: f64,
    },
    /// The search for a long way was stopped before it came to an end.
    #[error("{}", gave_up_text(*.tiles, *.looked_km, *.spent))]
    GaveUp {
        /// So many tiles of the chart were searched.
        tiles: usize,
        /// How far from the start the farthest of them lies (km).
        looked_km: f64,
        /// What was used up.
        spent: Spent,
    },
    /// Start and goal are farther apart than routes are planned.
    #[error("{}", too_far_text(*.straight_km, *.most_km, .by))]
    TooFar {
        /// The straight distance (km).
        straight_km: f64,
        /// The greatest one (km).
        most_km: f64,
        /// Places on a way there that is deep enough, if one is known; a route by way of them has shorter stretches.
        by: Vec<LatLon>,
    },
    /// A route is longer than one that is of use.
    #[error("a route there is {:.1} km long or more; it may have {:.1} km", .length_m / 1e3, .most_m / 1e3)]
    TooLong {
        /// Its length, or how far the ends are apart (m).
        length_m: f64,
        /// The greatest that was asked for (m).
        most_m: f64,
    },
    /// Planning failed.
    #[error(transparent)]
    Plan(PlanError),
}

impl From<PlanError> for Refusal {
    fn from(error: PlanError) -> Self {
        match error {
            PlanError::Needs(error) => Self::Needs(error),
            PlanError::OutOfTime => Self::GaveUp { tiles: 0, looked_km: 0.0, spent: Spent::Time },
            other => Self::Plan(other),
        }
    }
}

impl Refusal {
    /// As the refusal of one of several stretches: what closes an end of it may lie at a place to pass.
    pub(crate) fn of_stretch(mut self, stretch: usize, stretches: usize) -> Self {
        if let Self::Closed { end, .. } = &mut self {
            *end = match end {
                End::Start if stretch > 0 => End::Via(stretch),
                End::Goal if stretch + 1 < stretches => End::Via(stretch + 1),
                End::Start | End::Via(_) | End::Goal => *end,
            };
        }
        self
    }
}

/// What a search had used up when it was stopped.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Spent {
    /// Its time.
    Time,
    /// The number of tiles, or the memory for what is known of them.
    Tiles,
}

fn searched_text(looked_km: Option<f64>) -> String {
    looked_km.map_or_else(String::new, |km| format!(" (searched {km:.0} km around the start)"))
}

fn gave_up_text(tiles: usize, looked_km: f64, spent: Spent) -> String {
    let spent = match spent {
        Spent::Time => "its time is used up",
        Spent::Tiles => "it may search no more of the chart",
    };
    format!(
        "the search was stopped: {spent}. It searched {tiles} tiles of the chart, up to {looked_km:.0} km from the start, and found \
         no route yet: add places on the way, or ask for a shorter route"
    )
}

fn too_far_text(straight_km: f64, most_km: f64, by: &[LatLon]) -> String {
    let places: Vec<String> =
        by.iter().map(|place| format!("{:.4}, {:.4}", place.lat_deg(), place.lon_deg())).collect();
    let such_as = if places.is_empty() { String::new() } else { format!(", such as {}", places.join("; ")) };
    format!(
        "start and goal are {straight_km:.0} km apart; routes are planned up to {most_km:.0} km: add places on the way{such_as}"
    )
}

fn closed_text(
    end: End,
    (water, refused, zoned): (Water, Option<Restriction>, bool),
    nearest_m: Option<f64>,
    allowed_m: f64,
) -> String {
    let here = match water {
        _ if zoned => "outside the allowed area or too near its border, or in a forbidden one".to_owned(),
        Water::Depth { .. } if refused.is_some() => {
            format!("in {}", refused.map_or("a closed area", Restriction::words))
        }
        Water::Land => "on land".to_owned(),
        Water::Obstacle => "at an obstacle".to_owned(),
        Water::UnknownDepth => "at a danger of unknown depth".to_owned(),
        Water::NoData => "where nothing is charted".to_owned(),
        Water::TooLow { .. } => "under something that is too low".to_owned(),
        Water::Depth { least_m, .. } => {
            format!("where the charted depth is {least_m:.1} m, or too near a danger")
        }
    };
    match nearest_m {
        Some(nearest_m) => format!(
            "{end} lies {here}; the nearest open water is {nearest_m:.0} m away, farther than the {allowed_m:.0} m by which it \
             may be moved"
        ),
        None => format!("{end} lies {here}, and there is no open water within 50 km"),
    }
}
