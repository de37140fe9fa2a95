//! The acceptance check of a cell: its skin of the Earth covers what the cell says it covers.
//!
//! S-57 appendix B.1, 3.8.1: the areas of group 1 tile the covered area without gap or overlap. So their
//! areas add up to that of M_COVR with CATCOV 1. A cell that fails this was read wrongly or is damaged.

use super::cell::{Cell, Feature};
use super::codes::{AttributeCode, ObjectClass};
use super::geometry::Geometry;

/// The classes of group 1.
pub const SKIN_CLASSES: [ObjectClass; 7] = [
    ObjectClass::DEPARE,
    ObjectClass::DRGARE,
    ObjectClass::LNDARE,
    ObjectClass::UNSARE,
    ObjectClass::PONTON,
    ObjectClass::HULKES,
    ObjectClass::FLODOC,
];

/// The two sums that must agree.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinCheck {
    /// Of all areas of group 1 (square degrees).
    pub skin_deg2: f64,
    /// Of all areas that the cell covers (square degrees).
    pub coverage_deg2: f64,
    /// Areas of either kind whose boundary does not close.
    pub unreadable: usize,
}

impl SkinCheck {
    /// Whether they agree to one part in a hundred million, and there is anything at all.
    pub fn holds(&self) -> bool {
        let difference = (self.skin_deg2 - self.coverage_deg2).abs();
        self.unreadable == 0 && self.coverage_deg2 > 0.0 && difference <= self.coverage_deg2 * 1e-8
    }
}

impl Cell {
    /// Sums both sides.
    pub fn skin_check(&self) -> SkinCheck {
        let mut check = SkinCheck { skin_deg2: 0.0, coverage_deg2: 0.0, unreadable: 0 };
        for feature in &self.features {
            let skin = SKIN_CLASSES.contains(&feature.class);
            if !skin && !is_coverage(feature) {
                continue;
            }
            match &feature.geometry {
                Geometry::Area(area) if skin => check.skin_deg2 += area.area_deg2(),
                Geometry::Area(area) => check.coverage_deg2 += area.area_deg2(),
                Geometry::Unreadable { .. } => check.unreadable += 1,
                Geometry::None | Geometry::Point(_) | Geometry::Soundings(_) | Geometry::Lines(_) => {}
            }
        }
        check
    }
}

/// Whether a feature says where the cell has data.
pub(crate) fn is_coverage(feature: &Feature) -> bool {
    feature.class == ObjectClass::M_COVR && feature.code(AttributeCode::CATCOV) == Some(1)
}
