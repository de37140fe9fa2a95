//! The guard's answer: legs with their worst spot, and what it could not check.

use charts::depth_index::{DepthAnswer, DepthIndex, Restricted, Restriction, Water};
use std::fmt;
use units::LatLon;

/// Worst zone of confidence that is taken without a warning (CATZOC 4 = C).
const POOR_ZONE: u8 = 5;

/// The result of a check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Outcome {
    /// All of it was checked and is deep enough.
    Ok,
    /// What was checked is deep enough; a part was not checked, or the chart is poor.
    Warnings,
    /// Some of it is not known to be deep enough.
    Refused,
}

impl Outcome {
    /// A stable word for programs.
    pub fn code(self) -> &'static str {
        match self {
            Self::Ok => "ok",
            Self::Warnings => "warnings",
            Self::Refused => "refused",
        }
    }
}

/// The guard's answer about all that a vessel will sweep.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Verdict {
    /// Every leg that was checked, in the order they are sailed.
    pub legs: Vec<LegCheck>,
    /// Parts that were not checked, or not well.
    pub warnings: Vec<Warning>,
    /// It is more than the guard checks together ([`MOST_CORRIDORS`](crate::MOST_CORRIDORS)): it is refused.
    pub too_much: bool,
}

impl Verdict {
    /// The result.
    pub fn outcome(&self) -> Outcome {
        if self.too_much || self.refused().next().is_some() {
            Outcome::Refused
        } else if self.warnings.is_empty() {
            Outcome::Ok
        } else {
            Outcome::Warnings
        }
    }

    /// Whether it must not be sailed.
    pub fn is_refused(&self) -> bool {
        self.outcome() == Outcome::Refused
    }

    /// The legs that are the reason.
    pub fn refused(&self) -> impl Iterator<Item = &LegCheck> {
        self.legs.iter().filter(|leg| leg.reason.is_some())
    }

    /// The first reason and how many more there are, in one line for a reply.
    pub fn summary(&self) -> String {
        if self.too_much {
            return "the plan is too large to be checked against the chart; split it".to_owned();
        }
        let mut refused = self.refused();
        let Some(first) = refused.next() else {
            return match self.warnings.len() {
                0 => "deep enough by the chart".to_owned(),
                count => format!("deep enough by the chart where it was checked; {count} warnings"),
            };
        };
        match refused.count() {
            0 => first.to_string(),
            more => format!("{first} (and {more} more legs)"),
        }
    }
}

/// What a vessel does on a leg.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// The way from what came before to the first place.
    Transit,
    /// A leg of a path, a trajectory or rows, turns included.
    Track,
    /// A circle or an eight.
    Circle,
    /// Station keeping in a disc.
    Station,
    /// Drifting with the motors off.
    Drift,
}

impl Part {
    /// A stable word for programs.
    pub fn code(self) -> &'static str {
        match self {
            Self::Transit => "transit",
            Self::Track => "track",
            Self::Circle => "circle",
            Self::Station => "station",
            Self::Drift => "drift",
        }
    }
}

/// Why a leg is refused.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Reason {
    /// Land, or a construction on the ground.
    Land,
    /// An obstacle, whatever the depth.
    Obstacle,
    /// A danger of unknown depth, or an unsurveyed area.
    UnknownDepth,
    /// Nothing is charted.
    NoData,
    /// An overhead obstacle that is too low for the vessel.
    TooLow,
    /// Too shallow even for manual steering.
    TooShallow,
    /// Deep enough for manual steering, too shallow for autonomous sailing.
    TooShallowAlone,
    /// Deep enough, in an area that the vessel may not enter.
    Entry(
        /// How strictly it is closed.
        Restriction,
    ),
}

impl Reason {
    /// A stable word for programs.
    pub fn code(self) -> &'static str {
        match self {
            Self::Land => "land",
            Self::Obstacle => "obstacle",
            Self::UnknownDepth => "unknown-depth",
            Self::NoData => "no-data",
            Self::TooLow => "too-low",
            Self::TooShallow => "too-shallow",
            Self::TooShallowAlone => "too-shallow-alone",
            Self::Entry(restriction) => restriction.code(),
        }
    }
}

/// The worst spot of a leg.
#[derive(Debug, Clone, PartialEq)]
pub struct Spot {
    /// The place that is meant.
    pub at: LatLon,
    /// Least charted depth (m); negative where it dries, absent where it is not water of known depth.
    pub least_m: Option<f64>,
    /// Margin of the depth (m), negative = too shallow; absent like the depth.
    pub margin_m: Option<f64>,
    /// Class of the chart object that decides (S-57 acronym); absent where there is no data.
    pub class: Option<&'static str>,
    /// Its name, where it has one.
    pub name: Option<String>,
    /// Its record number in its cell.
    pub record: Option<u32>,
    /// Cell or file that it is from.
    pub cell: Option<String>,
    /// Edition and update of the cell.
    pub edition: Option<(String, String)>,
    /// Compilation scale of the cell, 1 : this; absent where unknown.
    pub scale: Option<u32>,
    /// Zone of confidence (CATZOC 1 to 6); absent where it is not charted.
    pub zone: Option<u8>,
}

impl Spot {
    /// From an answer of the index.
    pub fn of(answer: &DepthAnswer, index: &DepthIndex) -> Self {
        let object = answer.object.and_then(|id| index.object(id));
        let object = object.as_ref();
        let source = object.map(|object| index.source(object));
        Self {
            at: answer.at,
            least_m: answer.water.least_m(),
            margin_m: answer.margin_m,
            // No object is named for water that nothing charted decides.
            class: object.filter(|_| answer.water != Water::NoData).and_then(|object| object.class.acronym()),
            name: object.and_then(|object| object.name.clone()),
            record: object.map(|object| object.record),
            cell: source.map(|source| source.name.clone()),
            edition: source.map(|source| (source.edition.clone(), source.update.clone())),
            scale: source.map(|source| source.scale).filter(|scale| *scale > 0),
            zone: answer.zone,
        }
    }
}

/// A leg that was checked.
#[derive(Debug, Clone, PartialEq)]
pub struct LegCheck {
    /// Whose leg it is, such as the name of a maneuver.
    pub label: String,
    /// What the vessel does.
    pub part: Part,
    /// Number of the leg within the part, from 0.
    pub number: u32,
    /// Where it begins.
    pub from: LatLon,
    /// Where it ends.
    pub to: LatLon,
    /// Half width that was checked where it is worst, with all allowances (m).
    pub half_width_m: f64,
    /// Why it is refused, if it is.
    pub reason: Option<Reason>,
    /// The worst spot, also of a leg that is deep enough; where an area is the reason, the place in which it is entered.
    pub spot: Spot,
    /// Of the areas whose entry is prohibited or restricted the one that counts most, if the leg enters any.
    pub area: Option<Entered>,
}

/// An area whose entry is prohibited or restricted, and where a leg first comes into it.
#[derive(Debug, Clone, PartialEq)]
pub struct Entered {
    /// How strictly it is closed.
    pub restriction: Restriction,
    /// Where it is entered; the depth is the least of the whole leg.
    pub spot: Spot,
}

impl Entered {
    pub(crate) fn of(area: &Restricted, answer: &DepthAnswer, index: &DepthIndex) -> Self {
        let entry = DepthAnswer { at: area.at, object: Some(area.object), ..*answer };
        let found = Spot::of(&entry, index);
        let object = index.object(area.object);
        // The area itself is named also where the water is not charted.
        let class = object.and_then(|object| object.class.acronym());
        Self { restriction: area.restriction, spot: Spot { class, ..found } }
    }

    /// Its name, and its chart.
    fn name_and_chart(&self) -> String {
        let name = self.spot.name.as_deref().unwrap_or("no name");
        let cell = self.spot.cell.as_deref().unwrap_or("no chart");
        format!("{name} ({cell})")
    }
}

impl fmt::Display for LegCheck {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { label, part, spot, .. } = self;
        write!(f, "'{label}' ({} {}): ", part.code(), self.number + 1)?;
        if let (Some(Reason::Entry(restriction)), Some(area)) = (self.reason, &self.area) {
            let (at, what) = (area.spot.at, area.name_and_chart());
            let (lat_deg, lon_deg) = (at.lat_deg(), at.lon_deg());
            return write!(f, "enters {}: {what} at {lat_deg:.5}, {lon_deg:.5}", restriction.words());
        }
        match (self.reason, spot.least_m, spot.margin_m) {
            (Some(Reason::Land), ..) => write!(f, "land")?,
            (Some(Reason::Obstacle), ..) => write!(f, "an obstacle")?,
            (Some(Reason::UnknownDepth), ..) => write!(f, "unknown depth")?,
            (Some(Reason::NoData), ..) => write!(f, "not charted")?,
            (Some(Reason::TooLow), ..) => write!(f, "too low overhead")?,
            (_, Some(least_m), Some(margin_m)) if margin_m < 0.0 => {
                let needed_m = least_m - margin_m;
                if least_m < 0.0 {
                    write!(f, "dries {:.1} m; needs {needed_m:.1} m", -least_m)?;
                } else {
                    write!(f, "{least_m:.1} m deep; needs {needed_m:.1} m")?;
                }
            }
            (_, least_m, margin_m) => {
                let (least_m, margin_m) = (least_m.unwrap_or(0.0), margin_m.unwrap_or(0.0));
                write!(f, "{least_m:.1} m deep, {margin_m:.1} m more than needed")?;
            }
        }
        write!(f, " at {:.5}, {:.5}", spot.at.lat_deg(), spot.at.lon_deg())?;
        match (&spot.class, &spot.cell) {
            (Some(class), Some(cell)) => write!(f, " ({class} of {cell})"),
            _ => Ok(()),
        }
    }
}

/// A part that was not checked, or not well.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Warning {
    /// Where the vessel starts is not known: the way to the first place is unchecked.
    StartUnknown {
        /// The first part with a place.
        label: String,
    },
    /// Where this leads is not known beforehand.
    Unchecked {
        /// Whose way it is.
        label: String,
        /// What it is, in a word.
        kind: String,
    },
    /// The vessel drifts for a time that is not known beforehand.
    DriftsOn {
        /// Whose drifting it is.
        label: String,
    },
    /// It is deep enough by a survey of poor or unassessed quality (CATZOC D or U).
    PoorChart {
        /// Whose leg it is.
        label: String,
        /// Cell that decides, where one does.
        cell: Option<String>,
    },
    /// It enters an area whose entry is prohibited or restricted.
    Entry {
        /// Whose leg it is.
        label: String,
        /// How strictly the area is closed.
        restriction: Restriction,
        /// Its name and its chart, in words.
        area: String,
    },
}

impl Warning {
    /// A stable word for programs.
    pub fn code(&self) -> &'static str {
        match self {
            Self::StartUnknown { .. } => "start-unknown",
            Self::Unchecked { .. } => "unchecked",
            Self::DriftsOn { .. } => "drifts-on",
            Self::PoorChart { .. } => "poor-chart",
            Self::Entry { restriction, .. } => restriction.code(),
        }
    }

    /// Its subject, such as the name of a maneuver.
    pub fn label(&self) -> &str {
        match self {
            Self::StartUnknown { label }
            | Self::Unchecked { label, .. }
            | Self::DriftsOn { label }
            | Self::PoorChart { label, .. }
            | Self::Entry { label, .. } => label,
        }
    }

    pub(crate) fn of_quality(leg: &LegCheck) -> Option<Self> {
        let poor = leg.spot.zone.is_some_and(|zone| zone >= POOR_ZONE) && leg.reason.is_none();
        poor.then(|| Self::PoorChart { label: leg.label.clone(), cell: leg.spot.cell.clone() })
    }

    /// Of an area that is not the reason for which the leg is refused.
    pub(crate) fn of_area(leg: &LegCheck) -> Option<Self> {
        let entered = leg.area.as_ref().filter(|_| !matches!(leg.reason, Some(Reason::Entry(_))))?;
        let (restriction, area) = (entered.restriction, entered.name_and_chart());
        Some(Self::Entry { label: leg.label.clone(), restriction, area })
    }
}

impl fmt::Display for Warning {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::StartUnknown { label } => {
                write!(f, "'{label}': where the vessel comes from is not known; that way is not checked")
            }
            Self::Unchecked { label, kind } => {
                write!(f, "'{label}': it is not known beforehand where a {kind} leads, so it is not checked")
            }
            Self::DriftsOn { label } => {
                write!(f, "'{label}': the vessel drifts for a time that is not known; it is not checked")
            }
            Self::PoorChart { label, cell } => {
                let cell = cell.as_deref().unwrap_or("the chart");
                write!(f, "'{label}': deep enough by a survey of poor or unknown quality ({cell})")
            }
            Self::Entry { label, restriction, area } => {
                write!(f, "'{label}': enters {}: {area}", restriction.words())
            }
        }
    }
}
