//! GeoJSON (RFC 7946): points and lines with their properties. Coordinates are longitude first; heights are
//! ignored. Another coordinate system than WGS 84 is refused, for then every position would be wrong.

use crate::{Geometry, MOST_POSITIONS, Position, Shape, Shapes, tidy};
use serde_json::{Map, Value, json};

/// Why a text is no GeoJSON of points and lines.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GeoJsonError {
    /// No JSON.
    #[error("this is no JSON: {0}; fetch the file again")]
    Json(String),
    /// A type that is none, or that holds neither points nor lines.
    #[error("{place}: a {found} is neither point nor line; export points and lines as a FeatureCollection")]
    Type {
        /// Where.
        place: String,
        /// Its type.
        found: String,
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
    /// Too many positions.
    #[error("{0}: the file has more than {MOST_POSITIONS} positions; divide it")]
    Long(String),
}

/// Reads all points and lines.
///
/// # Errors
/// At the first thing that is neither.
pub fn read(bytes: &[u8]) -> Result<Shapes, GeoJsonError> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let value: Value =
        serde_json::from_slice(bytes).map_err(|error| GeoJsonError::Json(error.to_string()))?;
    if let Some(crs) = value.get("crs") {
        let name = crs.pointer("/properties/name").and_then(Value::as_str).unwrap_or_default();
        if !["CRS84", "4326"].iter().any(|code| name.ends_with(code)) {
            return Err(GeoJsonError::System(short(crs)));
        }
    }
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

/// Writes a FeatureCollection. The names stand as property `name`.
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
                        self.shapes.notes.push(format!("{place} has no geometry and was left out"));
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
            _ => Err(GeoJsonError::Type {
                place: place.to_owned(),
                found: value.get("type").map_or_else(|| "thing without a type".to_owned(), short),
            }),
        }
    }

    fn each(
        &mut self,
        value: &Value,
        member: &str,
        place: &str,
        properties: Option<&Map<String, Value>>,
    ) -> Result<(), GeoJsonError> {
        let all = list(value.get(member).unwrap_or(&Value::Null), place)?;
        let one = if member == "features" { "feature" } else { "geometry" };
        for (index, value) in all.iter().enumerate() {
            let here = if place == "the file" { String::new() } else { format!("{place}, ") };
            self.object(value, &format!("{here}{one} {}", index + 1), properties)?;
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
        let number = |index| value.get(index).and_then(Value::as_f64);
        let position =
            number(0).zip(number(1)).and_then(|(lon_deg, lat_deg)| Position::new(lat_deg, lon_deg));
        position.ok_or_else(|| GeoJsonError::Position { place: place.to_owned(), found: short(value) })
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

fn list<'a>(value: &'a Value, place: &str) -> Result<&'a Vec<Value>, GeoJsonError> {
    let wrong = || GeoJsonError::Position { place: place.to_owned(), found: short(value) };
    value.as_array().ok_or_else(wrong)
}

/// The beginning of what stands somewhere.
fn short(value: &Value) -> String {
    let text = value.to_string();
    if text.chars().count() <= 60 { text } else { text.chars().take(59).chain(['…']).collect() }
}
