//! Land masks as GeoJSON (RFC 7946): polygons that are land, without any depth.
//!
//! Rings of a polygon count under the even-odd rule. Coordinates are WGS 84 degrees, longitude first. A
//! member `crs` other than that is refused, for then every position would be wrong.

use crate::s57::{Area, GeoPoint, Path};
use serde_json::Value;

/// Why a text is no land mask.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GeoJsonError {
    /// No JSON.
    #[error("this is no JSON: {0}; fetch the file again")]
    Json(String),
    /// Not a type that can be land.
    #[error("{place}: a {found:?} is no polygon; export polygons as a FeatureCollection")]
    Type {
        /// Where.
        place: String,
        /// Its type.
        found: String,
    },
    /// A ring that is none.
    #[error("{place}: a ring needs four positions or more, the last equal to the first; repair the polygon")]
    Ring {
        /// Where.
        place: String,
    },
    /// A position that is none.
    #[error("{place}: {found} is no longitude and latitude in degrees; convert the file to EPSG:4326")]
    Position {
        /// Where.
        place: String,
        /// What stands there.
        found: String,
    },
    /// Another coordinate system.
    #[error("the coordinate system is {0}; convert the file to EPSG:4326")]
    System(String),
}

/// Reads all polygons.
///
/// # Errors
/// At the first thing that is no polygon.
pub fn read_areas(bytes: &[u8]) -> Result<Vec<Area>, GeoJsonError> {
    let value: Value =
        serde_json::from_slice(bytes).map_err(|error| GeoJsonError::Json(error.to_string()))?;
    if let Some(name) = value.pointer("/crs/properties/name").and_then(Value::as_str) {
        let wgs84 = ["CRS84", "4326"].iter().any(|code| name.ends_with(code));
        if !wgs84 {
            return Err(GeoJsonError::System(name.to_owned()));
        }
    }
    let mut areas = Vec::new();
    collect(&value, "the file", &mut areas)?;
    Ok(areas)
}

/// The depth of the recursion is bounded by that of the JSON reader (128).
fn collect(value: &Value, place: &str, areas: &mut Vec<Area>) -> Result<(), GeoJsonError> {
    let list = |name: &str| value[name].as_array().map(Vec::as_slice).unwrap_or_default();
    let kind = value["type"].as_str().unwrap_or_default();
    match kind {
        "FeatureCollection" => {
            for (at, feature) in list("features").iter().enumerate() {
                collect(feature, &format!("feature {at}"), areas)?;
            }
        }
        "Feature" if value["geometry"].is_null() => {}
        "Feature" => collect(&value["geometry"], place, areas)?,
        "GeometryCollection" => {
            for geometry in list("geometries") {
                collect(geometry, place, areas)?;
            }
        }
        "Polygon" => areas.push(area(list("coordinates"), place)?),
        "MultiPolygon" => {
            for polygon in list("coordinates") {
                areas.push(area(polygon.as_array().map(Vec::as_slice).unwrap_or_default(), place)?);
            }
        }
        _ => return Err(GeoJsonError::Type { place: place.to_owned(), found: kind.to_owned() }),
    }
    Ok(())
}

fn area(rings: &[Value], place: &str) -> Result<Area, GeoJsonError> {
    let mut area = Area::default();
    for ring in rings {
        let positions = ring.as_array().map(Vec::as_slice).unwrap_or_default();
        let points = positions.iter().map(|one| position(one, place)).collect::<Result<Vec<_>, _>>()?;
        if points.len() < 4 || points.first() != points.last() {
            return Err(GeoJsonError::Ring { place: place.to_owned() });
        }
        let path = Path { points, edges: Vec::new() };
        if area.exteriors.is_empty() { area.exteriors.push(path) } else { area.holes.push(path) }
    }
    if area.exteriors.is_empty() {
        return Err(GeoJsonError::Ring { place: place.to_owned() });
    }
    Ok(area)
}

fn position(value: &Value, place: &str) -> Result<GeoPoint, GeoJsonError> {
    let point = || {
        let point = GeoPoint { lon_deg: value.get(0)?.as_f64()?, lat_deg: value.get(1)?.as_f64()? };
        point.place().map(|_| point)
    };
    let fail = || GeoJsonError::Position { place: place.to_owned(), found: value.to_string() };
    point().ok_or_else(fail)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn reads_polygons_wherever_they_stand() {
        let text = br#"{"type":"FeatureCollection","features":[
            {"type":"Feature","properties":{},"geometry":{"type":"MultiPolygon","coordinates":[
              [[[10,63],[11,63],[11,64],[10,63]]],
              [[[0,0],[4,0],[4,4],[0,4],[0,0]],[[1,1],[2,1],[2,2],[1,2],[1,1]]]]}},
            {"type":"Feature","properties":{},"geometry":null}]}"#;
        let areas = read_areas(text).unwrap();
        assert_eq!(areas.len(), 2);
        assert_eq!((areas[0].area_deg2(), areas[1].area_deg2()), (0.5, 15.0));
    }

    #[test]
    fn says_what_is_no_land() {
        let fails = |text: &str| read_areas(text.as_bytes()).unwrap_err().to_string();
        assert!(fails("[").contains("no JSON"));
        assert!(fails(r#"{"type":"Point","coordinates":[1,2]}"#).contains("\"Point\" is no polygon"));
        assert!(
            fails(r#"{"type":"Polygon","coordinates":[[[1,2],[3,4],[1,2]]]}"#).contains("four positions")
        );
        assert!(fails(r#"{"type":"Polygon","coordinates":[[[269927,7044215]]]}"#).contains("EPSG:4326"));
        let other =
            r#"{"type":"FeatureCollection","crs":{"properties":{"name":"urn:ogc:def:crs:EPSG::25833"}}}"#;
        assert!(fails(other).contains("25833"));
    }

    #[test]
    fn reads_the_land_of_trondelag() {
        let Some(path) = testkit::shared("data/charts/trondelag_land_osm.geojson") else { return };
        let areas = read_areas(&std::fs::read(path).unwrap()).unwrap();
        // Counts of data/charts/README.md.
        assert_eq!(areas.len(), 1106);
        let vertices: usize = areas.iter().flat_map(Area::rings).map(|ring| ring.points.len()).sum();
        assert!((32_000..35_000).contains(&vertices), "{vertices}");
    }
}
