//! Areas of ordered traffic near a route, read from the charts that reach there.
//!
//! They are a preference and not a rule: what cannot be read is left out and logged.

use chartdb::{Chart, ChartDb};
use charts::s57::{AttributeCode, Feature, GeoPoint, Geometry, ObjectClass};
use planner::{TrafficArea, TrafficKind, Zone};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};
use units::LatLon;

/// So far around the box of a route's places, as a share of its size and at least this (degrees), areas are looked for.
const AROUND: f64 = 0.25;
const LEAST_AROUND_DEG: f64 = 0.05;
/// No more areas are minded in one question.
const MOST_AREAS: usize = 200;
/// Areas of more corners are left out: none of these is a lane.
const MOST_CORNERS: usize = 2_000;

/// The areas of a chart set, each chart read when a route comes near.
#[derive(Debug)]
pub struct Traffic {
    path: PathBuf,
    charts: Vec<Chart>,
    known: Mutex<BTreeMap<i64, Areas>>,
}

/// West, south, east and north (degrees).
type Box4 = [f64; 4];
/// Areas of a chart, each with its box.
type Areas = Arc<Vec<(TrafficArea, Box4)>>;

impl Traffic {
    /// Of a set in a file.
    pub fn new(path: &Path, charts: Vec<Chart>) -> Self {
        Self { path: path.to_owned(), charts, known: Mutex::default() }
    }

    /// The areas around the places of a route; none where these lie on both sides of 180°.
    pub fn near(&self, places: &[LatLon]) -> Vec<TrafficArea> {
        let around = around(places);
        if around[2] - around[0] > 180.0 {
            return Vec::new();
        }
        let charts = self.charts.iter().filter(|chart| {
            chart.kind == "cell" && chart.bounds_deg.is_some_and(|bounds| meet(bounds, around))
        });
        let mut areas = Vec::new();
        for chart in charts {
            match self.of(chart) {
                Ok(all) => areas.extend(
                    all.iter().filter(|(_, bounds)| meet(*bounds, around)).map(|(area, _)| area.clone()),
                ),
                Err(error) => {
                    tracing::warn!(chart = chart.name, %error, "routes do not mind its traffic lanes");
                }
            }
        }
        areas.truncate(MOST_AREAS);
        areas
    }

    fn of(&self, chart: &Chart) -> chartdb::Result<Areas> {
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(areas) = known().get(&chart.id) {
            return Ok(Arc::clone(areas));
        }
        let db = ChartDb::open(&self.path)?;
        // The file may be another set by now: its areas are not those of this one.
        let same = db.charts_named(std::slice::from_ref(&chart.name))?;
        let Some(same) = same.into_iter().find(|one| one.contents() == chart.contents()) else {
            return Ok(Arc::default());
        };
        let areas: Vec<(TrafficArea, Box4)> = db.traffic(&same)?.iter().flat_map(areas).collect();
        let areas = Arc::new(areas);
        known().insert(chart.id, Arc::clone(&areas));
        Ok(areas)
    }
}

fn around(places: &[LatLon]) -> Box4 {
    let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
    for place in places {
        add(&mut bounds, place.lat_deg(), place.lon_deg());
    }
    let more = |size_deg: f64| (AROUND * size_deg).max(LEAST_AROUND_DEG);
    // As far to both sides as to the north: lanes are as likely there.
    let more_deg = more((bounds[2] - bounds[0]).max(bounds[3] - bounds[1]));
    [bounds[0] - more_deg, bounds[1] - more_deg, bounds[2] + more_deg, bounds[3] + more_deg]
}

fn add(bounds: &mut Box4, lat_deg: f64, lon_deg: f64) {
    *bounds =
        [bounds[0].min(lon_deg), bounds[1].min(lat_deg), bounds[2].max(lon_deg), bounds[3].max(lat_deg)];
}

fn meet(one: Box4, other: Box4) -> bool {
    one[0] <= other[2] && other[0] <= one[2] && one[1] <= other[3] && other[1] <= one[3]
}

/// What a feature is, by its outer rings; holes count as part of it.
fn areas(feature: &Feature) -> Vec<(TrafficArea, Box4)> {
    let kind = match feature.class {
        ObjectClass::TSSLPT => TrafficKind::Lane,
        ObjectClass::TSEZNE => TrafficKind::SeparationZone,
        ObjectClass::TSSCRS | ObjectClass::TSSRON => TrafficKind::Junction,
        ObjectClass::DWRTPT => TrafficKind::DeepWater,
        _ => return Vec::new(),
    };
    let Geometry::Area(area) = &feature.geometry else { return Vec::new() };
    let one_way = matches!(kind, TrafficKind::Lane);
    let towards_rad = feature
        .number(AttributeCode::ORIENT)
        .filter(|deg| one_way && (0.0..=360.0).contains(deg))
        .map(f64::to_radians);
    let of_ring = |points: &[GeoPoint]| {
        let mut bounds = [f64::INFINITY, f64::INFINITY, f64::NEG_INFINITY, f64::NEG_INFINITY];
        for at in points {
            add(&mut bounds, at.lat_deg, at.lon_deg);
        }
        let corners: Vec<LatLon> =
            points.iter().filter_map(|at| LatLon::from_deg(at.lat_deg, at.lon_deg).ok()).collect();
        let is_closed = corners.len() > 1 && corners.first() == corners.last();
        let corners = corners[..corners.len() - usize::from(is_closed)].to_vec();
        let zone = Zone::new(corners).ok()?;
        Some((TrafficArea { zone, kind, towards_rad }, bounds))
    };
    let rings = area.exteriors.iter().filter(|ring| ring.points.len() <= MOST_CORNERS);
    rings.filter_map(|ring| of_ring(&ring.points)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use charts::s57::{Area, Attribute, ObjectId, Path as Ring};

    fn feature(class: ObjectClass, orient: Option<&str>) -> Feature {
        let corners = [(63.0, 10.0), (63.0, 10.1), (63.1, 10.1), (63.0, 10.0)];
        let points = corners.map(|(lat_deg, lon_deg)| GeoPoint { lat_deg, lon_deg }).to_vec();
        let attribute = |value: &str| Attribute { code: AttributeCode::ORIENT, value: value.to_owned() };
        Feature {
            record: 1,
            object: ObjectId { agency: 1, number: 1, subdivision: 1 },
            class,
            group: 2,
            version: 1,
            attributes: orient.map(attribute).into_iter().collect(),
            national: Vec::new(),
            links: Vec::new(),
            geometry: Geometry::Area(Area {
                exteriors: vec![Ring { points, edges: Vec::new() }],
                holes: Vec::new(),
            }),
        }
    }

    #[test]
    fn a_lane_has_the_direction_of_its_ships_and_a_zone_has_none() {
        let lane = areas(&feature(ObjectClass::TSSLPT, Some("270")));
        let (area, bounds) = &lane[0];
        assert_eq!((lane.len(), area.kind, *bounds), (1, TrafficKind::Lane, [10.0, 63.0, 10.1, 63.1]));
        assert!((area.towards_rad.unwrap() - 1.5 * std::f64::consts::PI).abs() < 1e-12);
        let inside = LatLon::from_deg(63.02, 10.06).unwrap();
        assert!(area.zone.holds(inside));
        for orient in [None, Some("400"), Some("west")] {
            assert_eq!(areas(&feature(ObjectClass::TSSLPT, orient))[0].0.towards_rad, None);
        }
        let zone = &areas(&feature(ObjectClass::TSEZNE, Some("270")))[0].0;
        assert_eq!((zone.kind, zone.towards_rad), (TrafficKind::SeparationZone, None));
        assert!(areas(&feature(ObjectClass::RESARE, None)).is_empty());
    }

    #[test]
    fn areas_are_looked_for_around_the_places_of_a_route() {
        let place = |lat, lon| LatLon::from_deg(lat, lon).unwrap();
        let near = around(&[place(63.0, 10.0), place(63.2, 10.4)]);
        let expected = [9.9, 62.9, 10.5, 63.3];
        assert!(near.iter().zip(expected).all(|(one, other)| (one - other).abs() < 1e-9), "{near:?}");
        assert!(meet(near, [10.45, 63.0, 11.0, 63.1]) && !meet(near, [10.6, 63.0, 11.0, 63.1]));
    }
}
