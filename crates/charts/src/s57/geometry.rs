//! The geometry of a feature.

/// A position as the chart gives it: degrees of longitude and latitude on WGS 84. A chart is a file, so its
/// positions stay in the file's unit; [`GeoPoint::place`] leaves it.
#[derive(Debug, Clone, Copy, PartialEq, PartialOrd)]
pub struct GeoPoint {
    /// Longitude, east positive (degrees).
    pub lon_deg: f64,
    /// Latitude, north positive (degrees).
    pub lat_deg: f64,
}

impl GeoPoint {
    /// The place, if the degrees are in range.
    pub fn place(self) -> Option<units::LatLon> {
        units::LatLon::from_deg(self.lat_deg, self.lon_deg).ok()
    }
}

/// One measured depth.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Sounding {
    /// The place.
    pub at: GeoPoint,
    /// Below the chart's sounding datum (m); negative where it dries.
    pub depth_m: f64,
}

/// One edge within a path, for drawing and for finding neighbours.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EdgeUse {
    /// The edge's record number in its cell: neighbours share it.
    pub edge: u32,
    /// Index in the path's points at which the edge starts.
    pub from: usize,
    /// Whether the path runs it from its end to its beginning.
    pub reversed: bool,
    /// Whether the producer asks not to draw it. It bounds its area all the same.
    pub masked: bool,
    /// Whether it is where the data end, not where the object does.
    pub data_limit: bool,
}

/// A line of edges joined by their nodes; a ring repeats its first point at its end.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Path {
    /// The vertices.
    pub points: Vec<GeoPoint>,
    /// The edges that they come from.
    pub edges: Vec<EdgeUse>,
}

impl Path {
    /// Twice the area is summed: positive anticlockwise (square degrees).
    pub fn signed_area_deg2(&self) -> f64 {
        let Some(first) = self.points.first() else { return 0.0 };
        // Relative to the first vertex, so that small rings far from the origin keep their digits.
        let sum: f64 = self
            .points
            .windows(2)
            .map(|pair| {
                let (ax, ay) = (pair[0].lon_deg - first.lon_deg, pair[0].lat_deg - first.lat_deg);
                let (bx, by) = (pair[1].lon_deg - first.lon_deg, pair[1].lat_deg - first.lat_deg);
                ax * by - bx * ay
            })
            .sum();
        sum / 2.0
    }
}

/// A surface. Exteriors run clockwise and holes anticlockwise, as S-57 has it.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Area {
    /// Outer rings; one in an ENC.
    pub exteriors: Vec<Path>,
    /// Rings cut out of them.
    pub holes: Vec<Path>,
}

impl Area {
    /// Exteriors less holes (square degrees).
    pub fn area_deg2(&self) -> f64 {
        let sum = |paths: &[Path]| paths.iter().map(|path| path.signed_area_deg2().abs()).sum::<f64>();
        sum(&self.exteriors) - sum(&self.holes)
    }

    /// All rings.
    pub fn rings(&self) -> impl Iterator<Item = &Path> {
        self.exteriors.iter().chain(&self.holes)
    }
}

/// The geometry of a feature.
#[derive(Debug, Clone, PartialEq)]
pub enum Geometry {
    /// A collection or a feature without any.
    None,
    /// One position.
    Point(GeoPoint),
    /// The soundings of a sounding feature.
    Soundings(Vec<Sounding>),
    /// One line, or several where its edges do not join.
    Lines(Vec<Path>),
    /// A surface.
    Area(Area),
    /// A surface whose boundary does not close. It must count as dangerous.
    Unreadable {
        /// The part of the boundary that could be read.
        paths: Vec<Path>,
        /// Why it is not a surface.
        reason: String,
    },
}

impl Geometry {
    /// All positions, in no particular order.
    pub fn points(&self) -> Box<dyn Iterator<Item = GeoPoint> + '_> {
        match self {
            Self::None => Box::new(std::iter::empty()),
            Self::Point(point) => Box::new(std::iter::once(*point)),
            Self::Soundings(soundings) => Box::new(soundings.iter().map(|one| one.at)),
            Self::Lines(paths) | Self::Unreadable { paths, .. } => {
                Box::new(paths.iter().flat_map(|path| path.points.iter().copied()))
            }
            Self::Area(area) => Box::new(area.rings().flat_map(|path| path.points.iter().copied())),
        }
    }
}
