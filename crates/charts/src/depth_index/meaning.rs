//! The meaning of a chart object for a small vessel.
//!
//! S-57 appendix A, chapters 1 and 2; what is not known to be deep is not
//! deep. A danger without a depth blocks, unless the chart says that its depth lies within
//! that of the area around it (EXPSOU 1). What contradicts itself, is there twice or can be no depth counts as the worst
//! that it may mean, as does [`unsafe_to_use`] with what has no whole shape. Piles, buoys, beacons, platforms, structures and fish farms block
//! always. Areas that may not be entered are not dangers and are reported beside the depth.

use super::object::{Role, Stored, millimetres};
use super::restricted::{Restriction, restriction};
use crate::coverage::{is_coverage, is_skin};
use crate::s57::{
    AttributeCode as Attr, Cell, Feature, Geometry, ObjectClass as Class, S57Problem, SkinCheck,
};

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
            Some((Role::Overhead, Stored::Overhead(overhead_m(feature).map(millimetres))))
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

/// Classes that stand or float in the way.
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

/// Classes that stand on land mostly, where the land decides, but in the water too: wind turbines, towers, huts on piles.
const STRUCTURES: [Class; 5] = [Class::LNDMRK, Class::BUISGL, Class::SILTNK, Class::CRANES, Class::FORSTC];

/// Whether a vessel may have to keep off such a feature.
pub fn is_in_the_way(feature: &Feature) -> bool {
    meaning(feature).is_some_and(|(role, _)| matches!(role, Role::Skin | Role::Danger | Role::Overhead))
}

/// Why a cell must not be used, if it must not: it does not say how deep it is or where it has data, or it has an
/// object that vessels must keep clear of, but whose position or extent is unknown.
pub fn unsafe_to_use(cell: &Cell, skin: &SkinCheck) -> Option<S57Problem> {
    if let Some(feature) = lies_nowhere(&cell.features) {
        return Some(S57Problem::Nowhere { class: feature.class, record: feature.record });
    }
    let water = |class: Class| matches!(class, Class::DEPARE | Class::DRGARE | Class::UNSARE);
    let broken = |feature: &&Feature| {
        // Where a depth area is missing there are no data, which is never safe.
        let counts =
            is_in_the_way(feature) && !water(feature.class) && cell.incomplete.contains(&feature.record);
        // Where a chart's coverage cannot be read, a coarser chart would answer.
        let unreadable = matches!(feature.geometry, Geometry::Unreadable { .. });
        counts || unreadable && is_coverage(feature)
    };
    if let Some(feature) = cell.features.iter().find(broken) {
        return Some(S57Problem::Incomplete { class: feature.class, record: feature.record });
    }
    (skin.coverage_deg2 <= 0.0 || skin.skin_deg2 <= 0.0).then_some(S57Problem::NoWater)
}

/// An object that vessels must keep clear of and that has no place, neither a readable one nor an earlier one.
fn lies_nowhere(features: &[Feature]) -> Option<&Feature> {
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

/// QUASOU: depth unknown.
const DEPTH_UNKNOWN: u32 = 2;
/// No sea is deeper (m).
const DEEPEST_M: f64 = 12_000.0;

/// The least value of an attribute (m); `None` where the attribute is absent, or a value is not a number.
fn least_m(feature: &Feature, code: Attr) -> Option<f64> {
    let value = |text: &str| text.parse().ok().filter(|value: &f64| value.is_finite());
    let all: Option<Vec<f64>> = feature.texts(code).map(value).collect();
    all?.into_iter().min_by(f64::total_cmp)
}

/// The same for a depth, which is nothing where no sea is as deep or no land as high.
fn depth_m(feature: &Feature, code: Attr) -> Option<f64> {
    least_m(feature, code).filter(|depth_m| depth_m.abs() <= DEEPEST_M)
}

fn is_depth_unknown(feature: &Feature) -> bool {
    feature.list(Attr::QUASOU).any(|code| code == DEPTH_UNKNOWN)
}

/// A missing DRVAL1 is unknown, not 0. Where it is beyond DRVAL2 either may be wrong: the lesser counts.
fn depth_area(feature: &Feature) -> Stored {
    let [first_m, second_m] = [Attr::DRVAL1, Attr::DRVAL2].map(|code| depth_m(feature, code));
    let Some(first_m) = first_m.filter(|_| !is_depth_unknown(feature)) else { return Stored::Unknown };
    let ends = second_m.map(|second_m| (first_m.min(second_m), first_m.max(second_m)));
    let least_m = ends.map_or(first_m, |(least_m, _)| least_m);
    Stored::Depth(millimetres(least_m), ends.map(|(_, greatest_m)| millimetres(greatest_m)))
}

fn danger(feature: &Feature) -> Option<Stored> {
    /// WATLEV: always under water.
    const ALWAYS_UNDER_WATER: u32 = 3;
    /// EXPSOU: within the range of depth of the surrounding area.
    const WITHIN_AREA: u32 = 1;
    let only = |code: Attr, wanted: u32| {
        let mut all = feature.list(code).peekable();
        all.peek().is_some() && all.all(|code| code == wanted)
    };
    // What dries, floats or is awash is not deep down, whatever VALSOU says.
    let under_water = feature.list(Attr::WATLEV).all(|code| code == ALWAYS_UNDER_WATER);
    let possible = |depth_m: &f64| !is_depth_unknown(feature) && (under_water || *depth_m <= 0.0);
    let given = feature.texts(Attr::VALSOU).any(|value| !value.is_empty());
    match depth_m(feature, Attr::VALSOU).filter(possible) {
        Some(depth_m) => Some(Stored::Depth(millimetres(depth_m), None)),
        None if !given && only(Attr::WATLEV, ALWAYS_UNDER_WATER) && only(Attr::EXPSOU, WITHIN_AREA) => None,
        None => Some(Stored::Unknown),
    }
}

/// The vertical clearance of something overhead (m); `None` where the chart does not give it, or a value is not a number.
fn overhead_m(feature: &Feature) -> Option<f64> {
    let codes = [Attr::VERCLR, Attr::VERCCL, Attr::VERCSA];
    let readable = |code: &Attr| least_m(feature, *code).is_some();
    let mut given = codes.into_iter().filter(|code| feature.texts(*code).any(|value| !value.is_empty()));
    given.all(|code| readable(&code)).then(|| clearance_m(|code| least_m(feature, code))).flatten()
}

/// The least of all clearances that are given (m).
pub fn clearance_m(number: impl Fn(Attr) -> Option<f64>) -> Option<f64> {
    [Attr::VERCLR, Attr::VERCCL, Attr::VERCSA].into_iter().filter_map(number).min_by(f64::total_cmp)
}
