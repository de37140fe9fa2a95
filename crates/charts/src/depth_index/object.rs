//! The data that an index has of a chart object, and of its chart.

use super::places::Hold;
use super::restricted::Restriction;
use crate::s57::{ObjectClass, ObjectId};

/// What is charted at a place, or on the way, in order of precedence: the first is the worst.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Water {
    /// Land, or a construction that stands on the ground.
    Land,
    /// An obstacle whatever the depth: a pile, a buoy, a fish farm.
    Obstacle,
    /// A danger of uncharted depth, or an unsurveyed area.
    UnknownDepth,
    /// Not charted. Never navigable.
    NoData,
    /// An overhead obstacle that is too low for the vessel; `None` where its height is not charted.
    TooLow {
        /// Clearance above high water (m).
        clearance_m: Option<f64>,
    },
    /// Water.
    Depth {
        /// Least charted depth (m); negative where it dries by that much.
        least_m: f64,
        /// Greatest charted depth of the area (m), where given.
        greatest_m: Option<f64>,
    },
}

impl Water {
    /// The least charted depth (m), if it is water of known depth.
    pub fn least_m(self) -> Option<f64> {
        if let Self::Depth { least_m, .. } = self { Some(least_m) } else { None }
    }

    /// Whether it falls dry at chart datum and is covered at higher water.
    pub fn is_intertidal(self) -> bool {
        self.least_m().is_some_and(|least_m| least_m < 0.0)
    }
}

/// [`Water`] as stored: depths in whole millimetres.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Stored {
    Land,
    Obstacle,
    Unknown,
    NoData,
    /// Clearance (mm).
    Overhead(Option<i32>),
    /// Least and greatest depth (mm).
    Depth(i32, Option<i32>),
}

impl Stored {
    /// The order of precedence: less is worse. No depth is below any depth.
    pub(super) fn least_mm(self) -> i32 {
        match self {
            Self::Land => i32::MIN,
            Self::Obstacle => i32::MIN + 1,
            Self::Unknown => i32::MIN + 2,
            Self::NoData => i32::MIN + 3,
            Self::Overhead(_) => i32::MIN + 4,
            Self::Depth(least_mm, _) => least_mm,
        }
    }

    pub(super) fn water(self) -> Water {
        let metres = |mm: i32| f64::from(mm) / 1000.0;
        match self {
            Self::Land => Water::Land,
            Self::Obstacle => Water::Obstacle,
            Self::Unknown => Water::UnknownDepth,
            Self::NoData => Water::NoData,
            Self::Overhead(clearance) => Water::TooLow { clearance_m: clearance.map(metres) },
            Self::Depth(least, greatest) => {
                Water::Depth { least_m: metres(least), greatest_m: greatest.map(metres) }
            }
        }
    }

    /// Clearance of an overhead obstacle (m); `None` where it is not charted.
    pub(super) fn clearance_m(self) -> Option<f64> {
        if let Water::TooLow { clearance_m } = self.water() { clearance_m } else { None }
    }
}

/// What is charted at a point.
#[derive(Debug, Clone, Copy)]
pub(super) struct State {
    pub(super) stored: Stored,
    pub(super) object: Option<u32>,
    pub(super) zone: Option<u8>,
    /// The lowest overhead obstacle, and its number.
    pub(super) overhead: Option<(Stored, u32)>,
    /// An area of each [`Restriction`] that holds the point.
    pub(super) areas: [Option<u32>; 2],
}

impl State {
    /// Takes in an overhead obstacle. One of unknown height counts as the lowest.
    pub(super) fn pass_under(&mut self, stored: Stored, object: u32) {
        let lower = |(held, _): (Stored, u32)| stored.clearance_m() < held.clearance_m();
        if self.overhead.is_none_or(lower) {
            self.overhead = Some((stored, object));
        }
    }

    /// Takes in an area that holds the point; the first of each restriction is reported.
    pub(super) fn enter(&mut self, restriction: Restriction, object: u32) {
        self.areas[restriction as usize].get_or_insert(object);
    }

    /// Takes in the state beside it: the worse counts, and the end of the chart is no worse than the chart.
    pub(super) fn meet(&mut self, beside: &Self) {
        if beside.stored != Stored::NoData && beside.stored.least_mm() < self.stored.least_mm() {
            (self.stored, self.object) = (beside.stored, beside.object);
        }
        self.zone = self.zone.max(beside.zone);
        if let Some((stored, object)) = beside.overhead {
            self.pass_under(stored, object);
        }
        for (area, beside) in self.areas.iter_mut().zip(beside.areas) {
            *area = area.or(beside);
        }
    }
}

/// Depths are kept in millimetres, rounded to the shallower side and within ±2000 km.
pub(super) fn millimetres(depth_m: f64) -> i32 {
    // 2.3 m is 2299.9999999999995 mm in floating point; a nanometre is not a depth.
    (depth_m * 1000.0 + 1e-6).floor().clamp(-2e9, 2e9) as i32
}

/// The role of a chart object in an index.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(super) enum Role {
    /// Says where its cell has data.
    Coverage,
    /// Part of the skin of the Earth: depth areas, land.
    Skin,
    /// A danger within the skin.
    Danger,
    /// Gives the quality of the survey.
    Quality,
    /// Above the water.
    Overhead,
    /// Of interest, but no danger.
    Interest,
    /// An area whose entry is prohibited.
    Prohibited,
    /// An area whose entry is restricted, or that is to be avoided.
    Restricted,
}

impl Role {
    /// Its restriction of entry, if it has one.
    pub(super) fn restriction(self) -> Option<Restriction> {
        match self {
            Self::Prohibited => Some(Restriction::EntryProhibited),
            Self::Restricted => Some(Restriction::EntryRestricted),
            Self::Coverage | Self::Skin | Self::Danger | Self::Quality | Self::Overhead | Self::Interest => {
                None
            }
        }
    }
}

/// One chart object.
#[derive(Debug, Clone, PartialEq)]
pub struct ChartObject {
    /// Class.
    pub class: ObjectClass,
    /// Identity over editions.
    pub id: ObjectId,
    /// Record number in its cell.
    pub record: u32,
    /// Index of its source: [`super::DepthIndex::source`].
    pub source: u32,
    /// Name, where it has one.
    pub name: Option<String>,
    /// Zone of confidence (CATZOC 1 to 6), of quality areas.
    pub zone: Option<u8>,
    pub(super) stored: Stored,
    pub(super) role: Role,
    pub(super) interest: bool,
}

impl ChartObject {
    /// What it means for a vessel.
    pub fn water(&self) -> Water {
        self.stored.water()
    }

    /// Its restriction of entry, if it has one.
    pub fn restriction(&self) -> Option<Restriction> {
        self.role.restriction()
    }

    /// When its area holds a point: water only where there is no doubt.
    pub(super) fn hold(&self) -> Hold {
        let water = self.role == Role::Skin && matches!(self.stored, Stored::Depth(..));
        if water { Hold::Plainly } else { Hold::AtAll }
    }
}
