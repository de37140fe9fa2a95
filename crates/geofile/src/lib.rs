//! GPX 1.1 and GeoJSON (RFC 7946) as named points and lines, GeoJSON as polygons, and CSV and NetCDF as grids of currents.
//!
//! It knows these formats and positions in WGS 84 degrees; what a file means to a plan or a chart is left to the
//! caller. A file is read whole or refused with the place of the error; no stated size is trusted before the data is
//! there, and points and lines of more than [`MOST_POSITIONS`] positions are refused.
//!
//! - [`Shapes`] is what a file holds, each [`Shape`] with its [`Geometry`]: [`geojson::read`], [`gpx::read`].
//! - [`Polygon`]s are read by [`geojson::read_polygons`].
//! - [`currents::CurrentField`] is a grid of currents with time steps: [`currents::read`].

pub mod currents;
pub mod geojson;
pub mod gpx;

use serde_json::{Map, Value};
use std::fmt;

/// Most positions of a file.
pub const MOST_POSITIONS: usize = 50_000;
/// Letters that are kept of a name.
const LONGEST_NAME: usize = 200;

/// A place in degrees, WGS 84.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Position {
    /// Latitude (°), within ±90.
    pub lat_deg: f64,
    /// Longitude (°), within ±180.
    pub lon_deg: f64,
}

impl Position {
    /// From degrees; `None` where they are not a place.
    pub fn new(lat_deg: f64, lon_deg: f64) -> Option<Self> {
        let good = lat_deg.abs() <= 90.0 && lon_deg.abs() <= 180.0;
        good.then_some(Self { lat_deg, lon_deg })
    }
}

/// The geometry of a shape.
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry {
    /// At a place.
    Point(Position),
    /// Along places.
    Line(Vec<Position>),
}

/// The rings of a polygon, the outer one first; the last position of a ring is its first one.
pub type Polygon = Vec<Vec<Position>>;

/// A named shape of a file.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Its name; may be empty.
    pub name: String,
    /// Where it is.
    pub geometry: Geometry,
    /// Its other properties; always empty from GPX.
    pub properties: Map<String, Value>,
}

/// All that a file holds.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Shapes {
    /// The file's name for itself; may be empty.
    pub name: String,
    /// Its other properties; always empty from GPX.
    pub properties: Map<String, Value>,
    /// Its shapes, in their order.
    pub shapes: Vec<Shape>,
    /// Parts that were left out.
    pub notes: Vec<LeftOut>,
}

/// A part of a file that is not among its shapes; as a text in English.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum LeftOut {
    /// So many way points of GPX beside routes and tracks: mere marks.
    Marks(usize),
    /// The feature at this place of GeoJSON has no geometry.
    NoGeometry(String),
}

impl fmt::Display for LeftOut {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Marks(count) => {
                write!(f, "way points beside routes and tracks were left out: {count}")
            }
            Self::NoGeometry(place) => write!(f, "{place} has no geometry and was left out"),
        }
    }
}

/// A name as it is kept: without control characters and blanks around it, not too long.
fn tidy(text: &str) -> String {
    let seen = text.chars().map(|letter| if letter.is_control() { ' ' } else { letter });
    let kept: String = seen.collect::<String>().trim().chars().take(LONGEST_NAME).collect();
    kept.trim_end().to_owned()
}
