//! Answers about the chart, as the API reports them.

use super::{Charts, Set};
use api::{
    ChartAttribute, ChartBounds, ChartCell, ChartCorridor, ChartDepth, ChartNear, ChartObject, ChartPiece,
    ChartProfilePoint, ChartSet,
};
use charts::depth_index::{Demand, DepthAnswer, Leg, Water};
use charts::s57::{attribute_words, class_words, value_words};
use guard::GuardLimits;
use tiles::{Changed, Near, Sheet};
use units::LatLon;

/// Most objects that are reported of a place.
const OBJECTS: usize = 50;
/// Points of a profile, about, beside the given ones; but none nearer than 1 m to each other.
const PROFILE: f64 = 400.0;

/// Describes the current chart set.
pub fn described(charts: &Charts) -> ChartSet {
    let limits = charts.limits();
    let empty = ChartSet {
        trouble: charts.trouble(),
        navigable_m: limits.navigable_m,
        autonomous_m: limits.autonomous_m,
        ..ChartSet::default()
    };
    let Some(set) = charts.set() else { return empty };
    let undrawn = Some(set.undrawn()).filter(|all| !all.is_empty()).map(|all| all.join("; "));
    let empty = ChartSet { trouble: empty.trouble.or(undrawn), ..empty };
    let cell = |chart: &chartdb::Chart| ChartCell {
        name: chart.name.clone(),
        edition: chart.edition.clone(),
        update: chart.update.clone(),
        scale: chart.scale,
        band: chart.band,
        issued: chart.issued.clone(),
        comment: chart.comment.clone(),
        whole: chart.skin_holds,
    };
    let cells: Vec<ChartCell> = set.charts.iter().filter(|chart| !chart.is_no_go_areas()).map(cell).collect();
    let warned = |cell: &ChartCell| cell.comment.to_ascii_uppercase().contains("NOT FOR NAVIGATION");
    ChartSet {
        set: Some(set.digest.clone()),
        bounds: set.charts.iter().filter_map(|chart| chart.bounds_deg).map(bounds).reduce(around),
        not_for_navigation: cells.iter().any(warned),
        cells,
        ..empty
    }
}

fn bounds([west_deg, south_deg, east_deg, north_deg]: [f64; 4]) -> ChartBounds {
    ChartBounds { south_deg, west_deg, north_deg, east_deg }
}

fn around(a: ChartBounds, b: ChartBounds) -> ChartBounds {
    ChartBounds {
        south_deg: a.south_deg.min(b.south_deg),
        west_deg: a.west_deg.min(b.west_deg),
        north_deg: a.north_deg.max(b.north_deg),
        east_deg: a.east_deg.max(b.east_deg),
    }
}

/// The name of a kind of water.
fn kind(water: Water) -> &'static str {
    match water {
        Water::Land => "land",
        Water::Obstacle => "obstacle",
        Water::UnknownDepth => "unknown-depth",
        Water::NoData => "no-data",
        Water::TooLow { .. } => "too-low",
        Water::Depth { .. } if water.is_intertidal() => "intertidal",
        Water::Depth { .. } => "water",
    }
}

/// The demands at the place itself, without an allowance for position errors.
fn demands(limits: &GuardLimits) -> (Demand, Demand) {
    let exact = |least_m: f64| Demand { position_m: 0.0, ..limits.demand(least_m) };
    (exact(limits.autonomous_m), exact(limits.navigable_m))
}

fn depth(set: &Set, sheet: &Sheet, answer: &DepthAnswer, navigable: bool) -> Result<ChartDepth, Changed> {
    let (least_m, greatest_m) = match answer.water {
        Water::Depth { least_m, greatest_m } => (Some(least_m), greatest_m),
        _ => (None, None),
    };
    let object = answer.object.and_then(|id| set.index.object(id));
    let object = object.as_ref();
    let source = object.map(|object| set.index.source(object));
    let drawn = match object.zip(source) {
        Some((object, source)) => sheet.object_of(&source.name, object.record)?,
        None => None,
    };
    Ok(ChartDepth {
        kind: kind(answer.water).to_owned(),
        least_m,
        greatest_m,
        margin_m: answer.margin_m,
        autonomous: answer.navigable,
        navigable,
        lat_deg: answer.at.lat_deg(),
        lon_deg: answer.at.lon_deg(),
        object: drawn,
        class: object.map(|object| object.class.to_string()),
        words: object.map(|object| class_words(object.class)),
        name: object.and_then(|object| object.name.clone()),
        cell: source.map(|source| source.name.clone()),
        edition: source.map(|source| source.edition.clone()),
        update: source.map(|source| source.update.clone()),
        scale: source.map(|source| source.scale).filter(|scale| *scale > 0),
        zone: answer.zone,
    })
}

/// What is charted at a place.
///
/// # Errors
/// The charts cannot be read.
pub fn at(set: &Set, limits: &GuardLimits, place: LatLon, within_m: f64) -> Result<ChartNear, String> {
    let sheet = set.sheet()?;
    let (autonomous, navigable) = demands(limits);
    let answer = set.index.depth_at(place, &autonomous);
    let may_be_driven = set.index.depth_at(place, &navigable).navigable;
    let near = || -> Result<ChartNear, Changed> {
        let found = sheet.near(place, within_m, OBJECTS)?;
        let mut objects = Vec::with_capacity(found.len());
        for near in &found {
            objects.extend(object(sheet, near)?);
        }
        Ok(ChartNear { depth: depth(set, sheet, &answer, may_be_driven)?, objects })
    };
    near().map_err(|changed| changed.to_string())
}

fn object(sheet: &Sheet, near: &Near) -> Result<Option<ChartObject>, Changed> {
    let Some(about) = sheet.about(near.object)? else { return Ok(None) };
    let source = sheet.source(&about);
    let attribute = |one: &charts::s57::Attribute| ChartAttribute {
        name: one.code.to_string(),
        words: attribute_words(one.code),
        value: one.value.clone(),
        text: value_words(one.code, &one.value),
    };
    Ok(Some(ChartObject {
        id: near.object,
        class: about.class.to_string(),
        words: class_words(about.class),
        name: about.name().map(str::to_owned),
        geometry: near.geometry.to_owned(),
        distance_m: near.distance_m,
        depth_m: near.depth_m,
        attributes: about.attributes.iter().map(attribute).collect(),
        cell: source.name.clone(),
        edition: source.edition.clone(),
        update: source.update.clone(),
        scale: source.scale,
    }))
}

/// How deep it is along a way of at least two points.
///
/// # Errors
/// The charts cannot be read.
pub fn corridor(
    set: &Set,
    limits: &GuardLimits,
    points: &[LatLon],
    half_width_m: f64,
) -> Result<ChartCorridor, String> {
    let sheet = set.sheet()?;
    let (autonomous, navigable) = demands(limits);
    let legs: Vec<Leg> = points.windows(2).map(|pair| Leg { from: pair[0], to: pair[1] }).collect();
    let length_m: f64 = legs.iter().map(|leg| leg.length_m()).sum();
    let step_m = (length_m / PROFILE).max(1.0);
    let mut from_m = 0.0;
    let (mut pieces, mut profile) = (Vec::new(), Vec::new());
    for leg in legs {
        let worst = set.index.shallowest_along(leg, half_width_m, &autonomous);
        let may_be_driven = set.index.first_danger_along(leg, half_width_m, &navigable).is_none();
        let piece_m = leg.length_m();
        pieces.push(ChartPiece {
            from_m,
            length_m: piece_m,
            along_m: from_m + worst.along_m,
            worst: depth(set, sheet, &worst, may_be_driven).map_err(|changed| changed.to_string())?,
        });
        let points = set.index.profile(leg, step_m);
        profile.extend(points.into_iter().map(|(along_m, water)| ChartProfilePoint {
            along_m: from_m + along_m,
            depth_m: water.least_m(),
            kind: kind(water).to_owned(),
        }));
        from_m += piece_m;
    }
    Ok(ChartCorridor { length_m, pieces, profile })
}

/// Length of a way (m).
pub fn way_m(points: &[LatLon]) -> f64 {
    points.windows(2).map(|pair| Leg { from: pair[0], to: pair[1] }.length_m()).sum()
}
