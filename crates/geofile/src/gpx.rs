//! GPX 1.0 and 1.1: way points and routes as points, tracks as a line for each segment. Own code over `quick-xml` in
//! place of the crate `gpx`, whose errors name no line, and which refuses files for elements and times that are of no
//! use here.
//!
//! The points of routes come before stand-alone way points, which are often mere marks. Elevations, times and
//! extensions are ignored. A document type is refused: GPX has none, and entities could blow a file up.

use crate::{Geometry, LeftOut, MOST_POSITIONS, Position, Shape, Shapes, tidy};
use quick_xml::Reader;
use quick_xml::escape::{escape, resolve_predefined_entity};
use quick_xml::events::{BytesStart, Event};
use serde_json::Map;

/// How deep elements may be nested.
const DEEPEST: usize = 64;
/// Bytes of a name that are read.
const NAME_BYTES: usize = 4_096;

/// Why a text is not GPX.
#[derive(Debug, Clone, PartialEq, Eq, thiserror::Error)]
pub enum GpxError {
    /// Not in UTF-8.
    #[error("the file is not in UTF-8 from byte {0} on; save it as UTF-8")]
    Text(usize),
    /// No XML.
    #[error("line {line}: this is not XML: {what}; fetch the file again")]
    Xml {
        /// Line of the file.
        line: usize,
        /// What is wrong.
        what: String,
    },
    /// Some other XML.
    #[error("the file holds <{0}> in place of <gpx>; export it as GPX")]
    NoGpx(String),
    /// A document type.
    #[error("line {0}: GPX has no <!DOCTYPE>; take it out")]
    DocType(usize),
    /// A point without a place.
    #[error("line {line}: <{element}> needs lat within ±90 and lon within ±180 in degrees, it has {found}")]
    Position {
        /// Line of the file.
        line: usize,
        /// The element.
        element: String,
        /// The text found.
        found: String,
    },
    /// Too many positions.
    #[error("line {0}: the file has more than {MOST_POSITIONS} positions; divide it")]
    Long(usize),
    /// Too deep.
    #[error("line {0}: elements are nested more than {DEEPEST} deep; export the file again")]
    Deep(usize),
    /// The end is missing.
    #[error("the file ends within <{0}>; fetch it again, whole")]
    Cut(String),
}

/// Reads all points and tracks.
///
/// # Errors
/// At the first error.
pub fn read(bytes: &[u8]) -> Result<Shapes, GpxError> {
    let bytes = bytes.strip_prefix(b"\xEF\xBB\xBF").unwrap_or(bytes);
    let text = std::str::from_utf8(bytes).map_err(|error| GpxError::Text(error.valid_up_to()))?;
    let mut reader = Reader::from_str(text);
    let mut found = Found::default();
    loop {
        let at = reader.buffer_position();
        let line = || line(text, at);
        let event = reader.read_event().map_err(|error| GpxError::Xml {
            line: self::line(text, reader.error_position()),
            what: error.to_string(),
        })?;
        match event {
            Event::Start(start) => found.open(&start, &line)?,
            Event::Empty(start) => {
                found.open(&start, &line)?;
                found.close();
            }
            Event::End(_) => found.close(),
            Event::Text(text) => found.text(&text.xml10_content()),
            Event::CData(text) => found.text(&text.xml10_content()),
            Event::GeneralRef(reference) => {
                let name = reference.xml10_content();
                let known = match reference.resolve_char_ref() {
                    Ok(Some(letter)) => Some(letter.to_string()),
                    _ => resolve_predefined_entity(&name).map(str::to_owned),
                };
                let unknown = || GpxError::Xml { line: line(), what: format!("&{name}; is unknown") };
                found.text(&known.ok_or_else(unknown)?);
            }
            Event::DocType(_) => return Err(GpxError::DocType(line())),
            Event::Decl(_) | Event::PI(_) | Event::Comment(_) => {}
            Event::Eof => return found.finish(),
        }
    }
}

/// Writes a route with a point for each position. A line's points are named after it.
pub fn write(shapes: &Shapes) -> String {
    let mut lines = vec![
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>".to_owned(),
        "<gpx version=\"1.1\" creator=\"Lutra\" xmlns=\"http://www.topografix.com/GPX/1/1\">".to_owned(),
        format!("<rte>\n  <name>{}</name>", escape(shapes.name.as_str())),
    ];
    for shape in &shapes.shapes {
        let points = match &shape.geometry {
            Geometry::Point(at) => std::slice::from_ref(at),
            Geometry::Line(points) => points,
        };
        let name = escape(shape.name.as_str());
        let line = |Position { lat_deg, lon_deg }: &Position| {
            format!("  <rtept lat=\"{lat_deg}\" lon=\"{lon_deg}\"><name>{name}</name></rtept>")
        };
        lines.extend(points.iter().map(line));
    }
    lines.push("</rte>\n</gpx>\n".to_owned());
    lines.join("\n")
}

/// Writes a track: a segment for each part that was sailed without a break, each position with its time (ISO 8601, UTC).
pub fn write_track(name: &str, segments: &[Vec<(Position, String)>]) -> String {
    let mut lines = vec![
        "<?xml version=\"1.0\" encoding=\"UTF-8\"?>".to_owned(),
        "<gpx version=\"1.1\" creator=\"Lutra\" xmlns=\"http://www.topografix.com/GPX/1/1\">".to_owned(),
        format!("<trk>\n  <name>{}</name>", escape(name)),
    ];
    for segment in segments {
        lines.push("  <trkseg>".to_owned());
        lines.extend(segment.iter().map(|(Position { lat_deg, lon_deg }, time)| {
            format!(
                "    <trkpt lat=\"{lat_deg:.8}\" lon=\"{lon_deg:.8}\"><time>{}</time></trkpt>",
                escape(time.as_str())
            )
        }));
        lines.push("  </trkseg>".to_owned());
    }
    lines.push("</trk>\n</gpx>\n".to_owned());
    lines.join("\n")
}

/// The line of a byte, from 1.
fn line(text: &str, at: u64) -> usize {
    let before = text.as_bytes().get(..at as usize).unwrap_or(text.as_bytes());
    before.split(|byte| *byte == b'\n').count()
}

#[derive(Debug, Default)]
struct Found {
    open: Vec<String>,
    begun: bool,
    file_name: String,
    route_name: String,
    track_name: String,
    /// The text of the name under way.
    name: String,
    /// The way point or point of a route under way.
    point: Option<Position>,
    point_name: String,
    segment: Vec<Position>,
    marks: Vec<Shape>,
    shapes: Vec<Shape>,
    positions: usize,
}

impl Found {
    fn open(&mut self, start: &BytesStart<'_>, line: &dyn Fn() -> usize) -> Result<(), GpxError> {
        let element = start.local_name().as_ref().to_owned();
        if self.open.is_empty() {
            if element != "gpx" || self.begun {
                return Err(GpxError::NoGpx(element.chars().take(40).collect()));
            }
            self.begun = true;
        }
        if self.open.len() >= DEEPEST {
            return Err(GpxError::Deep(line()));
        }
        match (self.inside(), element.as_str()) {
            ("gpx", "wpt") | ("rte", "rtept") => {
                self.point = Some(self.position(start, &element, line)?);
                self.point_name.clear();
            }
            ("trkseg", "trkpt") => {
                let position = self.position(start, &element, line)?;
                self.segment.push(position);
            }
            ("gpx", "rte") => self.route_name.clear(),
            ("gpx", "trk") => self.track_name.clear(),
            (_, "name") => self.name.clear(),
            _ => {}
        }
        self.open.push(element);
        Ok(())
    }

    fn inside(&self) -> &str {
        self.open.last().map_or("", String::as_str)
    }

    fn close(&mut self) {
        let Some(element) = self.open.pop() else { return };
        match (self.inside(), element.as_str()) {
            ("metadata" | "gpx", "name") => self.file_name = tidy(&self.name),
            ("rte", "name") => self.route_name = tidy(&self.name),
            ("trk", "name") => self.track_name = tidy(&self.name),
            ("wpt" | "rtept", "name") => self.point_name = tidy(&self.name),
            (_, "wpt" | "rtept") => {
                if let Some(at) = self.point.take() {
                    let name = std::mem::take(&mut self.point_name);
                    let list = if element == "wpt" { &mut self.marks } else { &mut self.shapes };
                    list.push(Shape { name, geometry: Geometry::Point(at), properties: Map::new() });
                }
            }
            ("gpx", "rte") if self.file_name.is_empty() => self.file_name.clone_from(&self.route_name),
            ("gpx", "trk") if self.file_name.is_empty() => self.file_name.clone_from(&self.track_name),
            (_, "trkseg") if !self.segment.is_empty() => {
                let points = std::mem::take(&mut self.segment);
                self.shapes.push(Shape {
                    name: self.track_name.clone(),
                    geometry: Geometry::Line(points),
                    properties: Map::new(),
                });
            }
            _ => {}
        }
    }

    fn text(&mut self, text: &str) {
        if self.inside() == "name" && self.name.len() < NAME_BYTES {
            self.name.push_str(text);
        }
    }

    fn position(
        &mut self,
        start: &BytesStart<'_>,
        element: &str,
        line: &dyn Fn() -> usize,
    ) -> Result<Position, GpxError> {
        self.positions += 1;
        if self.positions > MOST_POSITIONS {
            return Err(GpxError::Long(line()));
        }
        let value = |name: &str| {
            let attribute = start.try_get_attribute(name).ok().flatten()?;
            attribute.value.trim().parse::<f64>().ok()
        };
        let position = value("lat").zip(value("lon")).and_then(|(lat, lon)| Position::new(lat, lon));
        position.ok_or_else(|| {
            let attributes: String = start.attributes_raw().trim().chars().take(80).collect();
            let found = if attributes.is_empty() { "neither".to_owned() } else { attributes };
            GpxError::Position { line: line(), element: element.to_owned(), found }
        })
    }

    fn finish(mut self) -> Result<Shapes, GpxError> {
        if let Some(element) = self.open.pop() {
            return Err(GpxError::Cut(element));
        }
        if !self.begun {
            return Err(GpxError::NoGpx("nothing".to_owned()));
        }
        let mut notes = Vec::new();
        let shapes = if self.shapes.is_empty() {
            self.marks
        } else {
            if !self.marks.is_empty() {
                notes.push(LeftOut::Marks(self.marks.len()));
            }
            self.shapes
        };
        Ok(Shapes { name: self.file_name, shapes, notes, ..Shapes::default() })
    }
}
