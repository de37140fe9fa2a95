//! One point for a feature, and the zone of confidence that it lies in.

use crate::blob::Envelope;
use charts::s57::{Area, AttributeCode, Feature, GeoPoint, Geometry, ObjectClass};

/// A point that stands for a feature: itself, the middle vertex of its longest line, or a point well within its
/// area.
pub(crate) fn representative(geometry: &Geometry) -> Option<GeoPoint> {
    match geometry {
        Geometry::Point(point) => Some(*point),
        Geometry::Area(area) => within(area).or_else(|| geometry.points().next()),
        Geometry::Lines(paths) | Geometry::Unreadable { paths, .. } => {
            let longest = paths.iter().max_by_key(|path| path.points.len())?;
            longest.points.get(longest.points.len() / 2).copied()
        }
        Geometry::Soundings(list) => list.first().map(|one| one.at),
        Geometry::None => None,
    }
}

/// Crossings of all rings with the parallel at `lat_deg`, from west to east: by the even-odd rule each second
/// stretch lies within.
fn crossings(area: &Area, lat_deg: f64) -> Vec<f64> {
    let mut found = Vec::new();
    for pair in area.rings().flat_map(|ring| ring.points.windows(2)) {
        let (a, b) = (pair[0], pair[1]);
        // Half open, so that a vertex on the parallel counts once.
        if (a.lat_deg > lat_deg) != (b.lat_deg > lat_deg) {
            let share = (lat_deg - a.lat_deg) / (b.lat_deg - a.lat_deg);
            found.push(a.lon_deg + share * (b.lon_deg - a.lon_deg));
        }
    }
    found.sort_by(f64::total_cmp);
    found
}

/// The middle of the widest stretch within an area on the parallel through its middle.
fn within(area: &Area) -> Option<GeoPoint> {
    let [_, _, south, north] = Envelope::of(area.rings().flat_map(|ring| ring.points.iter().copied()))?.0;
    let lat_deg = f64::midpoint(south, north);
    let all = crossings(area, lat_deg);
    let widest = all.chunks_exact(2).max_by(|a, b| (a[1] - a[0]).total_cmp(&(b[1] - b[0])))?;
    Some(GeoPoint { lon_deg: f64::midpoint(widest[0], widest[1]), lat_deg })
}

/// Zones of confidence (CATZOC) of a cell.
pub(crate) struct Zones<'a> {
    list: Vec<(Envelope, &'a Area, u32)>,
}

impl<'a> Zones<'a> {
    pub(crate) fn of(features: &'a [Feature]) -> Self {
        let zone = |feature: &'a Feature| {
            let Geometry::Area(area) = &feature.geometry else { return None };
            let envelope = Envelope::of(feature.geometry.points())?;
            Some((envelope, area, feature.code(AttributeCode::CATZOC)?))
        };
        let quality = features.iter().filter(|one| one.class == ObjectClass::M_QUAL);
        Self { list: quality.filter_map(zone).collect() }
    }

    /// The worst zone at a point; `None` where the chart does not tell.
    pub(crate) fn at(&self, at: GeoPoint) -> Option<u32> {
        let holds = |(Envelope([w, e, s, n]), area, _): &&(Envelope, &Area, u32)| {
            let near = (*w..=*e).contains(&at.lon_deg) && (*s..=*n).contains(&at.lat_deg);
            near && crossings(area, at.lat_deg).iter().filter(|lon| **lon < at.lon_deg).count() % 2 == 1
        };
        self.list.iter().filter(holds).map(|(_, _, zone)| *zone).max()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use charts::s57::Path;

    fn ring(points: &[(f64, f64)]) -> Path {
        let points =
            points.iter().map(|(lon_deg, lat_deg)| GeoPoint { lon_deg: *lon_deg, lat_deg: *lat_deg });
        Path { points: points.collect(), edges: Vec::new() }
    }

    #[test]
    fn the_point_of_an_area_lies_within_it_and_in_no_hole() {
        let area = Area {
            exteriors: vec![ring(&[(0.0, 0.0), (0.0, 4.0), (10.0, 4.0), (10.0, 0.0), (0.0, 0.0)])],
            holes: vec![ring(&[(1.0, 1.0), (7.0, 1.0), (7.0, 3.0), (1.0, 3.0), (1.0, 1.0)])],
        };
        let at = representative(&Geometry::Area(area)).unwrap();
        assert_eq!((at.lon_deg, at.lat_deg), (8.5, 2.0));
    }
}
