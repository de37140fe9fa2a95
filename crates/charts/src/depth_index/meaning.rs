//! What a chart object means for a small vessel.
//!
//! S-57 appendix A, chapters 1 and 2; what is not known to be deep is not
//! deep. A danger without a depth blocks, unless the chart says that its depth lies within
//! that of the area around it (EXPSOU 1). Piles, buoys, beacons, platforms, structures and fish farms block
//! always. Areas that may not be entered are no danger and stand beside the depth.

use super::object::{Role, Stored, millimetres};
use super::restricted::{Restriction, restriction};
use crate::coverage::{is_coverage, is_skin};
use crate::s57::{AttributeCode as Attr, Feature, ObjectClass as Class};

/// Role and meaning of a feature; `None` for what has none for a vessel's way.
pub(super) fn meaning(feature: &Feature) -> Option<(Role, Stored)> {
    let skin = if is_skin(feature) { Role::Skin } else { Role::Danger };
    match feature.class {
        Class::M_COVR => is_coverage(feature).then_some((Role::Coverage, Stored::NoData)),
        Class::M_QUAL => Some((Role::Quality, Stored::NoData)),
        Class::DEPARE | Class::DRGARE => Some((skin, depth_area(feature))),
        Class::UNSARE => Some((skin, Stored::Unknown)),
        Class::LNDARE
        | Class::PONTON
        | Class::HULKES
        | Class::FLODOC
        | Class::SLCONS
        | Class::COALNE
        | Class::DAMCON
        | Class::CAUSWY
        | Class::DYKCON
        | Class::DRYDOC => Some((skin, Stored::Land)),
        Class::UWTROC | Class::WRECKS | Class::OBSTRN => danger(feature).map(|stored| (Role::Danger, stored)),
        // Each sounding has its own depth; this is the meaning of one that cannot be read.
        Class::SOUNDG => Some((Role::Danger, Stored::Unknown)),
        Class::BRIDGE | Class::CBLOHD | Class::PIPOHD | Class::CONVYR => {
            let clearance_m = clearance_m(|code| feature.number(code));
            Some((Role::Overhead, Stored::Overhead(clearance_m.map(millimetres))))
        }
        class if is_obstacle(class) => Some((Role::Danger, Stored::Obstacle)),
        class if class == Class::LIGHTS || class == Class::DAYMAR => Some((Role::Interest, Stored::NoData)),
        _ => entry(feature),
    }
}

/// The role of an area that is closed to vessels, whatever its depth.
fn entry(feature: &Feature) -> Option<(Role, Stored)> {
    let role = match restriction(feature)? {
        Restriction::EntryProhibited => Role::Prohibited,
        Restriction::EntryRestricted => Role::Restricted,
    };
    Some((role, Stored::NoData))
}

/// What stands or floats in the way.
const OBSTACLES: [Class; 28] = [
    Class::BCNCAR,
    Class::BCNISD,
    Class::BCNLAT,
    Class::BCNSAW,
    Class::BCNSPP,
    Class::BOYCAR,
    Class::BOYINB,
    Class::BOYISD,
    Class::BOYLAT,
    Class::BOYSAW,
    Class::BOYSPP,
    Class::FSHFAC,
    Class::GATCON,
    Class::GRIDRN,
    Class::ICEARE,
    Class::LITFLT,
    Class::LITVES,
    Class::LOGPON,
    Class::MARCUL,
    Class::MORFAC,
    Class::NEWOBJ,
    Class::OFSPLF,
    Class::OILBAR,
    Class::PILPNT,
    Class::PYLONS,
    Class::DISMAR,
    Class::RAPIDS,
    Class::WATFAL,
];

/// What stands on land mostly, where the land decides, but in the water too: wind turbines, towers, huts on piles.
const STRUCTURES: [Class; 5] = [Class::LNDMRK, Class::BUISGL, Class::SILTNK, Class::CRANES, Class::FORSTC];

/// Whether a vessel may have to keep off such a feature.
pub fn is_in_the_way(feature: &Feature) -> bool {
    meaning(feature).is_some_and(|(role, _)| matches!(role, Role::Skin | Role::Danger | Role::Overhead))
}

/// An object that vessels must keep clear of and that lies nowhere: neither a place that can be read nor one that it had.
/// A cell with such an object may call safe what is not.
pub fn lies_nowhere(features: &[Feature]) -> Option<&Feature> {
    let nowhere = |feature: &&Feature| {
        let must = meaning(feature).is_some_and(|(role, _)| matches!(role, Role::Danger | Role::Overhead));
        must && feature.geometry.points().next().is_none()
    };
    features.iter().find(nowhere)
}

/// Whether such an object is in the way whatever the depth.
pub fn is_obstacle(class: Class) -> bool {
    OBSTACLES.contains(&class) || is_structure(class)
}

/// Whether such an object mostly stands on land.
pub fn is_structure(class: Class) -> bool {
    STRUCTURES.contains(&class)
}

/// Whether an operator asks for it by name: the points of interest of the thesis' table A.1 and more of their
/// kind.
pub(super) fn is_of_interest(class: Class) -> bool {
    let dangers = [Class::OBSTRN, Class::UWTROC, Class::WRECKS, Class::LIGHTS, Class::DAYMAR];
    OBSTACLES.contains(&class) || dangers.contains(&class)
}

/// A missing DRVAL1 is unknown, not 0.
fn depth_area(feature: &Feature) -> Stored {
    let greatest = feature.number(Attr::DRVAL2).map(millimetres);
    feature.number(Attr::DRVAL1).map_or(Stored::Unknown, |least| Stored::Depth(millimetres(least), greatest))
}

fn danger(feature: &Feature) -> Option<Stored> {
    /// QUASOU: depth unknown.
    const DEPTH_UNKNOWN: u32 = 2;
    /// WATLEV: always under water.
    const ALWAYS_UNDER_WATER: u32 = 3;
    /// EXPSOU: within the range of depth of the surrounding area.
    const WITHIN_AREA: u32 = 1;
    let unknown = feature.list(Attr::QUASOU).any(|code| code == DEPTH_UNKNOWN);
    match feature.number(Attr::VALSOU).filter(|_| !unknown) {
        Some(depth_m) => Some(Stored::Depth(millimetres(depth_m), None)),
        None if feature.code(Attr::WATLEV) == Some(ALWAYS_UNDER_WATER)
            && feature.code(Attr::EXPSOU) == Some(WITHIN_AREA) =>
        {
            None
        }
        None => Some(Stored::Unknown),
    }
}

/// The least of all clearances that are given (m).
pub fn clearance_m(number: impl Fn(Attr) -> Option<f64>) -> Option<f64> {
    [Attr::VERCLR, Attr::VERCCL, Attr::VERCSA].into_iter().filter_map(number).min_by(f64::total_cmp)
}
