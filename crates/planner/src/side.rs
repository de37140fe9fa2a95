//! Straight parts of lines that may part two places: what they are, how far ways keep from them, and gaps between them.

use crate::PlanError;
use crate::plane::Point;

/// What a line is.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Kind {
    /// Land, shallow water, a danger, the end of the chart.
    Chart,
    /// The border of an area that may not be entered.
    Rule,
    /// The border of a zone that people drew.
    Zone,
    /// The end of the region that is looked at.
    Edge,
}

/// How far from lines ways keep (m).
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Reach {
    /// From what the chart has.
    pub(crate) chart_m: f64,
    /// From borders of zones.
    pub(crate) zone_m: f64,
}

impl Reach {
    pub(crate) fn of(&self, kind: Kind) -> f64 {
        match kind {
            Kind::Chart | Kind::Rule => self.chart_m,
            Kind::Zone => self.zone_m,
            Kind::Edge => 0.0,
        }
    }

    pub(crate) fn most_m(&self) -> f64 {
        self.chart_m.max(self.zone_m)
    }
}

/// A straight part of a line.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Side {
    pub(crate) ends: [Point; 2],
    /// It is in the way where more depth is needed (m).
    pub(crate) deeper_than_m: f64,
    pub(crate) kind: Kind,
}

impl Side {
    pub(crate) fn middle(&self) -> Point {
        self.ends[0].towards(self.ends[1], 0.5)
    }
}

/// Too many lines lie near each other.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Trouble {
    TooMany,
    Plan(PlanError),
}

impl From<PlanError> for Trouble {
    fn from(error: PlanError) -> Self {
        Self::Plan(error)
    }
}

/// The narrowest gap of the widest way.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Gap {
    /// How far ways can keep from the chart's lines at most (m).
    pub(crate) reach_m: f64,
    pub(crate) width_m: f64,
    /// The points of both sides that lie nearest to each other.
    pub(crate) between: [Point; 2],
}

impl Gap {
    /// None at all, at a place.
    pub(crate) fn shut(at: Point) -> Self {
        Self { reach_m: 0.0, width_m: 0.0, between: [at; 2] }
    }

    pub(crate) fn middle(&self) -> Point {
        self.between[0].towards(self.between[1], 0.5)
    }
}
