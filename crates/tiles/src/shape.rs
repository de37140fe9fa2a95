//! Where chart objects are, in the world's square.

use crate::layer::Kind;
use crate::world::{Bounds, Point, point};
use charts::s57::{Feature, Geometry, Path};

/// Outer ring and holes; rings are not closed by a repeated point.
pub(crate) type Polygon = Vec<Vec<Point>>;

/// Where something is.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Shape {
    Point(Point),
    /// A sounding with its depth (m).
    Sounding(Point, f64),
    Lines(Vec<Vec<Point>>),
    Areas(Vec<Polygon>),
}

impl Shape {
    pub(crate) fn bounds(&self) -> Bounds {
        match self {
            Self::Point(at) | Self::Sounding(at, _) => Bounds { min: *at, max: *at },
            Self::Lines(lines) => Bounds::of(lines.iter().flatten()),
            Self::Areas(areas) => Bounds::of(areas.iter().flatten().flatten()),
        }
    }

    /// A place for its name: the middle of its box if that is in it, else its first vertex.
    pub(crate) fn inner(&self) -> Point {
        let Bounds { min, max } = self.bounds();
        let middle = Point::new(min.x + (max.x - min.x) / 2, min.y + (max.y - min.y) / 2);
        match self {
            Self::Point(at) | Self::Sounding(at, _) => *at,
            Self::Lines(lines) => lines.iter().flatten().next().copied().unwrap_or(middle),
            Self::Areas(areas) if areas.iter().any(|area| contains(area, middle)) => middle,
            Self::Areas(areas) => areas.iter().flatten().flatten().next().copied().unwrap_or(middle),
        }
    }

    /// About how much memory its vertices take.
    pub(crate) fn bytes(&self) -> usize {
        let line = |line: &Vec<Point>| 24 + 8 * line.len();
        match self {
            Self::Point(_) | Self::Sounding(..) => 0,
            Self::Lines(lines) => lines.iter().map(line).sum(),
            Self::Areas(areas) => areas.iter().map(|area| 24 + area.iter().map(line).sum::<usize>()).sum(),
        }
    }

    pub(crate) fn kind(&self) -> Kind {
        match self {
            Self::Point(_) | Self::Sounding(..) => Kind::Point,
            Self::Lines(_) => Kind::Line,
            Self::Areas(_) => Kind::Area,
        }
    }
}

/// The shapes of a feature.
pub(crate) fn shapes(feature: &Feature) -> Vec<Shape> {
    let line = |path: &Path| path.points.iter().map(|at| point(*at)).collect::<Vec<_>>();
    let ring = |path: &Path| {
        let mut ring = line(path);
        if ring.first() == ring.last() {
            ring.pop();
        }
        ring
    };
    match &feature.geometry {
        Geometry::None => Vec::new(),
        Geometry::Point(at) => vec![Shape::Point(point(*at))],
        Geometry::Soundings(list) => {
            list.iter().map(|one| Shape::Sounding(point(one.at), one.depth_m)).collect()
        }
        Geometry::Lines(paths) | Geometry::Unreadable { paths, .. } => {
            vec![Shape::Lines(paths.iter().map(line).collect())]
        }
        Geometry::Area(area) => {
            let mut outer: Vec<Polygon> = area.exteriors.iter().map(|path| vec![ring(path)]).collect();
            // Of several outer rings (land from elsewhere) a hole goes with the first: what is filled is the same,
            // for rings are filled by parity.
            if let Some(first) = outer.first_mut() {
                first.extend(area.holes.iter().map(ring));
            }
            vec![Shape::Areas(outer)]
        }
    }
}

/// Whether a polygon holds a point, by the parity of crossings.
pub(crate) fn contains(polygon: &Polygon, at: Point) -> bool {
    let mut inside = false;
    for ring in polygon {
        for (a, b) in edges(ring) {
            if (a.y > at.y) != (b.y > at.y) {
                let (ax, ay) = (f64::from(a.x), f64::from(a.y));
                let (bx, by) = (f64::from(b.x), f64::from(b.y));
                inside ^= f64::from(at.x) < ax + (f64::from(at.y) - ay) / (by - ay) * (bx - ax);
            }
        }
    }
    inside
}

/// The edges of a ring.
pub(crate) fn edges(ring: &[Point]) -> impl Iterator<Item = (Point, Point)> + '_ {
    (0..ring.len()).map(|at| (ring[at], ring[(at + 1) % ring.len()]))
}
