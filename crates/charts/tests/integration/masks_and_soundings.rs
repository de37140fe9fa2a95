//! Land masks and single soundings: they can forbid, but never allow.

use charts::depth_index::{Demand, DepthIndex, IndexBuilder, Leg, Water};
use charts::s57::{Area, Cell, GeoPoint, NamedBytes, Path};
use charts::utm::Utm;
use charts::xyz::{self, Vertical, XyzError};
use geofile::{Position, geojson};
use units::LatLon;

fn place(lat_deg: f64, lon_deg: f64) -> LatLon {
    LatLon::from_deg(lat_deg, lon_deg).unwrap()
}

/// The polygons of a GeoJSON file as land.
fn land(bytes: &[u8]) -> Vec<Area> {
    let point = |at: Position| GeoPoint { lon_deg: at.lon_deg, lat_deg: at.lat_deg };
    let path =
        |ring: Vec<Position>| Path { points: ring.into_iter().map(point).collect(), edges: Vec::new() };
    let area = |polygon: geofile::Polygon| {
        let mut rings = polygon.into_iter().map(path);
        Area { exteriors: rings.next().into_iter().collect(), holes: rings.collect() }
    };
    geojson::read_polygons(bytes).unwrap().into_iter().map(area).collect()
}

#[test]
fn the_land_of_trondelag_is_land_and_its_sea_is_no_data() {
    let Some(path) = testkit::shared("data/charts/trondelag_land_osm.geojson") else { return };
    let mut builder = IndexBuilder::new();
    builder.add_land("osm", &land(&std::fs::read(path).unwrap())).unwrap();
    let index = builder.build().unwrap();
    let demand = Demand::default();
    // The cathedral of Trondheim, and the fjord north of Munkholmen.
    assert_eq!(index.depth_at(place(63.4269, 10.3969), &demand).water, Water::Land);
    let fjord = index.depth_at(place(63.47, 10.38), &demand);
    assert_eq!((fjord.water, fjord.navigable), (Water::NoData, false));
    let leg = Leg { from: place(63.47, 10.38), to: place(63.4269, 10.3969) };
    assert_eq!(index.shallowest_along(leg, 10.0, &demand).water, Water::Land);
    assert_eq!(DepthIndex::from_bytes(&index.to_bytes()).unwrap(), index);
}

#[test]
fn land_of_a_mask_is_land_under_any_cell() {
    let bytes = crate::writer::square("NO5X0001.000", (63.0, 10.0), (63.02, 10.04), &[]);
    let cell = Cell::read(NamedBytes { name: "NO5X0001.000", bytes: &bytes }, &[]).unwrap();
    let mask =
        br#"{"type":"Polygon","coordinates":[[[10.01,63.005],[10.02,63.005],[10.02,63.01],[10.01,63.005]]]}"#;
    let mut builder = IndexBuilder::new();
    builder.add_cell(&cell).unwrap();
    builder.add_land("mask", &land(mask)).unwrap();
    let index = builder.build().unwrap();
    let demand = Demand::least_depth(2.0);
    let islet = index.depth_at(place(63.006, 10.018), &demand);
    assert_eq!((islet.water, islet.navigable), (Water::Land, false));
    assert_eq!(index.source(&index.object(islet.object.unwrap()).unwrap()).name, "mask");
    let across = Leg { from: place(63.006, 10.03), to: place(63.006, 10.005) };
    let danger = index.first_danger_along(across, 5.0, &demand).unwrap();
    assert_eq!(danger.water, Water::Land);
    assert_eq!(index.shallowest_along(across, 5.0, &demand).water, Water::Land);
    // It hides nothing and opens nothing around it.
    assert_eq!(index.depth_at(place(63.015, 10.03), &demand).water.least_m(), Some(5.0));
    assert_eq!(index.depth_at(place(63.03, 10.03), &demand).water, Water::NoData);
    let clear = Leg { from: place(63.015, 10.005), to: place(63.015, 10.035) };
    assert!(index.shallowest_along(clear, 5.0, &demand).navigable);
    assert_eq!(DepthIndex::from_bytes(&index.to_bytes()).unwrap(), index);
}

/// A square of water 5 to 10 m deep at 63.0°N to 63.02°N, 10.0°E to 10.04°E, with soundings.
fn with_soundings(text: &str) -> Result<DepthIndex, XyzError> {
    let bytes = crate::writer::square("NO5X0001.000", (63.0, 10.0), (63.02, 10.04), &[]);
    let cell = Cell::read(NamedBytes { name: "NO5X0001.000", bytes: &bytes }, &[]).unwrap();
    let mut builder = IndexBuilder::new();
    builder.add_cell(&cell).unwrap();
    let utm = Utm::from_epsg(25833).unwrap();
    builder.add_soundings("survey", &xyz::read(text.as_bytes(), utm, Vertical::DepthDown)?).unwrap();
    Ok(builder.build().unwrap())
}

#[test]
fn a_sounding_shows_a_shoal_that_the_cell_lacks_and_opens_nothing() {
    let at = place(63.01, 10.02);
    let inside = Utm::from_epsg(25833).unwrap().to_utm(at);
    let outside = Utm::from_epsg(25833).unwrap().to_utm(place(63.05, 10.02));
    let line = |point: charts::utm::UtmPoint, depth_m| {
        format!("{:.4} {:.4} {depth_m}\n", point.easting_m, point.northing_m)
    };
    let index = with_soundings(&(line(inside, 1.5) + &line(outside, 80.0))).unwrap();
    let demand = Demand::least_depth(2.0);
    let shoal = index.shallowest_within(at, 5.0, &demand);
    assert_eq!((shoal.water.least_m(), shoal.navigable), (Some(1.5), false));
    assert_eq!(index.source(&index.object(shoal.object.unwrap()).unwrap()).name, "survey");
    assert!(index.shallowest_within(place(63.015, 10.02), 5.0, &demand).navigable);
    assert_eq!(index.shallowest_within(place(63.05, 10.02), 5.0, &demand).water, Water::NoData);
}

#[test]
fn higher_water_makes_the_same_shoal_navigable() {
    let at = place(63.01, 10.02);
    let point = Utm::from_epsg(25833).unwrap().to_utm(at);
    let index = with_soundings(&format!("{:.4} {:.4} -0.5", point.easting_m, point.northing_m)).unwrap();
    let at_level = |water_level_m| {
        let demand = Demand { water_level_m, draught_m: 0.4, reserve_m: 0.6, ..Demand::default() };
        index.shallowest_within(at, 5.0, &demand)
    };
    assert!(at_level(0.0).water.is_intertidal() && !at_level(0.0).navigable);
    assert!(at_level(1.6).navigable && !at_level(1.4).navigable);
}
