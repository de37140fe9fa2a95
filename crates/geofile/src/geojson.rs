//! GeoJSON (RFC 7946): points and lines with their properties, or polygons. Own code in place of the crate `geojson`,
//! whose errors name no feature and no position: a person could not find what to repair.
//!
//! Coordinates are longitude first; heights are ignored. Another coordinate system than WGS 84 is refused, for then
//! every position would be wrong.

use crate::{Geometry, LeftOut, MOST_POSITIONS, Polygon, Position, Shape, Shapes, tidy};
use serde_json::{Map, Value, json};

/// Why a text is not GeoJSON of the wanted kind.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GeoJsonError {
    /// Not JSON.
    #[error("this is not JSON: {0}; fetch the file again")]
    Json(String),
    /// A type that is not valid, or that holds neither points nor lines.
    #[error("{place}: a {found} is neither point nor line; export points and lines as a FeatureCollection")]
    Type {
        /// Its place in the document, as `features[2].geometry`.
        place: String,
        /// Its type.
        found: String,
    },
    /// A type that is not valid, or that holds no polygons.
    #[error("{place}: a {found} is not a polygon; export polygons as a FeatureCollection")]
    NoPolygon {
        /// Its place in the document.
        place: String,
        /// Its type.
        found: String,
    },
    /// A ring that is not valid.
    #[error("{place}: a ring needs four positions or more, the last equal to the first; repair the polygon")]
    Ring {
        /// Its place in the document.
        place: String,
    },
    /// A position that is not valid.
    #[error("{place}: {found} is not longitude and latitude in degrees; convert the file to EPSG:4326")]
    Position {
        /// Its place in the document.
        place: String,
        /// The text found.
        found: String,
    },
    /// Another coordinate system.
    #[error("the coordinate system is {0}; convert the file to EPSG:4326")]
    System(String),
    /// Too many positions.
    #[error("{0}: the file has more than {MOST_POSITIONS} positions; divide it")]
    Long(String),
}

/// Reads all points and lines.
///
/// # Errors
/// At the first object that is neither.
pub fn read(bytes: &[u8]) -> Result<Shapes, GeoJsonError> {
    let value = parsed(bytes)?;
    let mut reader = Reader::default();
    let own = value.get("properties").and_then(Value::as_object).cloned().unwrap_or_default();
    let collection = value.get("type").and_then(Value::as_str) == Some("FeatureCollection");
    if collection {
        let name = value.get("name").or_else(|| own.get("name")).and_then(Value::as_str);
        reader.shapes.name = tidy(name.unwrap_or_default());
        reader.shapes.properties = own;
    }
    reader.object(&value, "the file", None)?;
    Ok(reader.shapes)
}

/// Reads all polygons. They may be many: the caller bounds the file.
///
/// # Errors
/// At the first object that is not valid.
pub fn read_polygons(bytes: &[u8]) -> Result<Vec<Polygon>, GeoJsonError> {
    let mut polygons = Vec::new();
    collect(&parsed(bytes)?, "the file", &mut polygons)?;
    Ok(polygons)
}

/// The text as JSON, if its coordinates are WGS 84.
fn parsed(bytes: &[u8]) -> Result<Value, GeoJsonError> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let value: Value =
        serde_json::from_slice(bytes).map_err(|error| GeoJsonError::Json(error.to_string()))?;
    if let Some(crs) = value.get("crs") {
        let name = crs.pointer("/properties/name").and_then(Value::as_str).unwrap_or_default();
        if !["CRS84", "4326"].iter().any(|code| name.ends_with(code)) {
            return Err(GeoJsonError::System(short(crs)));
        }
    }
    Ok(value)
}

/// Writes a FeatureCollection. The names are the property `name`.
pub fn write(shapes: &Shapes) -> String {
    let position = |position: &Position| json!([position.lon_deg, position.lat_deg]);
    let features: Vec<Value> = shapes
        .shapes
        .iter()
        .map(|shape| {
            let (kind, coordinates) = match &shape.geometry {
                Geometry::Point(at) => ("Point", position(at)),
                Geometry::Line(points) => ("LineString", points.iter().map(position).collect()),
            };
            let mut properties = shape.properties.clone();
            properties.insert("name".to_owned(), shape.name.clone().into());
            json!({
                "type": "Feature",
                "properties": properties,
                "geometry": { "type": kind, "coordinates": coordinates },
            })
        })
        .collect();
    let collection = json!({
        "type": "FeatureCollection",
        "name": shapes.name,
        "properties": shapes.properties,
        "features": features,
    });
    format!("{collection:#}\n")
}

#[derive(Debug, Default)]
struct Reader {
    shapes: Shapes,
    positions: usize,
}

impl Reader {
    /// The depth of the recursion is bounded by that of the JSON reader (128).
    fn object(
        &mut self,
        value: &Value,
        place: &str,
        properties: Option<&Map<String, Value>>,
    ) -> Result<(), GeoJsonError> {
        let coordinates = value.get("coordinates").unwrap_or(&Value::Null);
        match value.get("type").and_then(Value::as_str) {
            Some("FeatureCollection") => self.each(value, "features", place, None),
            Some("GeometryCollection") => self.each(value, "geometries", place, properties),
            Some("Feature") => {
                let own = value.get("properties").and_then(Value::as_object);
                match value.get("geometry") {
                    None | Some(Value::Null) => {
                        self.shapes.notes.push(LeftOut::NoGeometry(place.to_owned()));
                        Ok(())
                    }
                    Some(geometry) => self.object(geometry, place, own),
                }
            }
            Some("Point") => {
                let at = self.position(coordinates, place)?;
                self.add(Geometry::Point(at), properties);
                Ok(())
            }
            Some("LineString") => self.line(coordinates, place, properties),
            Some("MultiPoint") => {
                for (index, one) in list(coordinates, place)?.iter().enumerate() {
                    let at = self.position(one, &format!("{place}, point {}", index + 1))?;
                    self.add(Geometry::Point(at), properties);
                }
                Ok(())
            }
            Some("MultiLineString") => {
                for (index, one) in list(coordinates, place)?.iter().enumerate() {
                    self.line(one, &format!("{place}, line {}", index + 1), properties)?;
                }
                Ok(())
            }
            _ => Err(GeoJsonError::Type { place: place.to_owned(), found: kind(value) }),
        }
    }

    fn each(
        &mut self,
        value: &Value,
        member: &str,
        place: &str,
        properties: Option<&Map<String, Value>>,
    ) -> Result<(), GeoJsonError> {
        for (value, here) in members(value, member, place)? {
            self.object(value, &here, properties)?;
        }
        Ok(())
    }

    fn line(
        &mut self,
        coordinates: &Value,
        place: &str,
        properties: Option<&Map<String, Value>>,
    ) -> Result<(), GeoJsonError> {
        let mut points = Vec::new();
        for (index, one) in list(coordinates, place)?.iter().enumerate() {
            points.push(self.position(one, &format!("{place}, position {}", index + 1))?);
        }
        self.add(Geometry::Line(points), properties);
        Ok(())
    }

    fn position(&mut self, value: &Value, place: &str) -> Result<Position, GeoJsonError> {
        self.positions += 1;
        if self.positions > MOST_POSITIONS {
            return Err(GeoJsonError::Long(place.to_owned()));
        }
        position(value, place)
    }

    fn add(&mut self, geometry: Geometry, properties: Option<&Map<String, Value>>) {
        let mut properties = properties.cloned().unwrap_or_default();
        let name = match properties.get("name") {
            Some(Value::String(name)) => tidy(name),
            _ => String::new(),
        };
        properties.remove("name");
        self.shapes.shapes.push(Shape { name, geometry, properties });
    }
}

/// The polygons of a value; the depth of the recursion is bounded by that of the JSON reader (128).
fn collect(value: &Value, place: &str, polygons: &mut Vec<Polygon>) -> Result<(), GeoJsonError> {
    let coordinates = value.get("coordinates").unwrap_or(&Value::Null);
    match value.get("type").and_then(Value::as_str) {
        Some("FeatureCollection") => {
            let mut features = members(value, "features", place)?;
            features.try_for_each(|(feature, here)| collect(feature, &here, polygons))
        }
        Some("GeometryCollection") => {
            let mut geometries = members(value, "geometries", place)?;
            geometries.try_for_each(|(geometry, here)| collect(geometry, &here, polygons))
        }
        Some("Feature") => match value.get("geometry") {
            None | Some(Value::Null) => Ok(()),
            Some(geometry) => collect(geometry, place, polygons),
        },
        Some("Polygon") => {
            polygons.push(polygon(coordinates, place)?);
            Ok(())
        }
        Some("MultiPolygon") => {
            for (index, one) in list(coordinates, place)?.iter().enumerate() {
                polygons.push(polygon(one, &format!("{place}, polygon {}", index + 1))?);
            }
            Ok(())
        }
        _ => Err(GeoJsonError::NoPolygon { place: place.to_owned(), found: kind(value) }),
    }
}

fn polygon(value: &Value, place: &str) -> Result<Polygon, GeoJsonError> {
    let none = || GeoJsonError::Ring { place: place.to_owned() };
    let mut polygon = Polygon::new();
    for ring in list(value, place)? {
        let ring =
            list(ring, place)?.iter().map(|one| position(one, place)).collect::<Result<Vec<_>, _>>()?;
        if ring.len() < 4 || ring.first() != ring.last() {
            return Err(none());
        }
        polygon.push(ring);
    }
    if polygon.is_empty() { Err(none()) } else { Ok(polygon) }
}

fn position(value: &Value, place: &str) -> Result<Position, GeoJsonError> {
    let number = |index| value.get(index).and_then(Value::as_f64);
    let position = number(0).zip(number(1)).and_then(|(lon_deg, lat_deg)| Position::new(lat_deg, lon_deg));
    position.ok_or_else(|| GeoJsonError::Position { place: place.to_owned(), found: short(value) })
}

/// The values of a collection, each with its place in words.
fn members<'a>(
    value: &'a Value,
    member: &str,
    place: &str,
) -> Result<impl Iterator<Item = (&'a Value, String)>, GeoJsonError> {
    let all = list(value.get(member).unwrap_or(&Value::Null), place)?;
    let one = if member == "features" { "feature" } else { "geometry" };
    let here = if place == "the file" { String::new() } else { format!("{place}, ") };
    Ok((1_u32..).zip(all).map(move |(number, value)| (value, format!("{here}{one} {number}"))))
}

/// The type that something says it is.
fn kind(value: &Value) -> String {
    value.get("type").map_or_else(|| "thing without a type".to_owned(), short)
}

fn list<'a>(value: &'a Value, place: &str) -> Result<&'a Vec<Value>, GeoJsonError> {
    let wrong = || GeoJsonError::Position { place: place.to_owned(), found: short(value) };
    value.as_array().ok_or_else(wrong)
}

/// The beginning of the text at a place.
fn short(value: &Value) -> String {
    let text = value.to_string();
    if text.chars().count() <= 60 { text } else { text.chars().take(59).chain(['…']).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at((lat_deg, lon_deg): (f64, f64)) -> Position {
        Position { lat_deg, lon_deg }
    }

    #[test]
    fn reads_polygons_wherever_they_stand() {
        let text = br#"{"type":"FeatureCollection","features":[
            {"type":"Feature","properties":{},"geometry":{"type":"MultiPolygon","coordinates":[
              [[[10,63],[11,63],[11,64],[10,63]]],
              [[[0,0],[4,0],[4,4],[0,4],[0,0]],[[1,1],[2,1],[2,2],[1,2],[1,1]]]]}},
            {"type":"Feature","properties":{},"geometry":null}]}"#;
        let areas = read_polygons(text).unwrap();
        assert_eq!(areas.len(), 2);
        assert_eq!(areas[0], [[(63.0, 10.0), (63.0, 11.0), (64.0, 11.0), (63.0, 10.0)].map(at).to_vec()]);
        assert_eq!(areas[1].iter().map(Vec::len).collect::<Vec<_>>(), [5, 5], "with its hole");
    }

    #[test]
    fn says_what_is_no_land() {
        let fails = |text: &str| read_polygons(text.as_bytes()).unwrap_err().to_string();
        assert!(fails("[").contains("not JSON"));
        assert!(fails(r#"{"type":"Point","coordinates":[1,2]}"#).contains("\"Point\" is not a polygon"));
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
        let areas = read_polygons(&std::fs::read(path).unwrap()).unwrap();
        // Counts of data/charts/README.md.
        assert_eq!(areas.len(), 1106);
        let vertices: usize = areas.iter().flatten().map(Vec::len).sum();
        assert!((32_000..35_000).contains(&vertices), "{vertices}");
    }
}
