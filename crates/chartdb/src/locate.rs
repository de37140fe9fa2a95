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

fn edges(area: &Area) -> impl Iterator<Item = [GeoPoint; 2]> + '_ {
    area.rings().flat_map(|ring| ring.points.windows(2)).map(|pair| [pair[0], pair[1]])
}

/// Where an edge crosses the parallel at `lat_deg` (degrees of longitude). Half open, so that a vertex on the
/// parallel counts once.
fn crossing([a, b]: &[GeoPoint; 2], lat_deg: f64) -> Option<f64> {
    if (a.lat_deg > lat_deg) == (b.lat_deg > lat_deg) {
        return None;
    }
    let share = (lat_deg - a.lat_deg) / (b.lat_deg - a.lat_deg);
    Some(a.lon_deg + share * (b.lon_deg - a.lon_deg))
}

/// Crossings of all rings with the parallel at `lat_deg`, from west to east: by the even-odd rule each second
/// stretch lies within.
fn crossings(area: &Area, lat_deg: f64) -> Vec<f64> {
    let mut found: Vec<f64> = edges(area).filter_map(|edge| crossing(&edge, lat_deg)).collect();
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
pub(crate) struct Zones(Vec<Zone>);

/// The edges of an area by bands of latitude: each of thousands of soundings is beside a few edges only.
struct Zone {
    envelope: Envelope,
    /// Edges that touch a band, from south to north; an edge may be in several.
    bands: Vec<Vec<[GeoPoint; 2]>>,
    catzoc: u32,
}

impl Zones {
    pub(crate) fn of(features: &[Feature]) -> Self {
        let zone = |feature: &Feature| match &feature.geometry {
            Geometry::Area(area) => Zone::of(area, feature.code(AttributeCode::CATZOC)?),
            _ => None,
        };
        let quality = features.iter().filter(|one| one.class == ObjectClass::M_QUAL);
        Self(quality.filter_map(zone).collect())
    }

    /// The worst zone at a point; `None` where it is not charted.
    pub(crate) fn at(&self, at: GeoPoint) -> Option<u32> {
        self.0.iter().filter(|zone| zone.holds(at)).map(|zone| zone.catzoc).max()
    }
}

impl Zone {
    /// Bands of an area, at most.
    const BANDS: usize = 1_024;

    fn of(area: &Area, catzoc: u32) -> Option<Self> {
        let envelope = Envelope::of(area.rings().flat_map(|ring| ring.points.iter().copied()))?;
        let edges: Vec<[GeoPoint; 2]> = edges(area).collect();
        let bands = vec![Vec::new(); edges.len().clamp(1, Self::BANDS)];
        let mut zone = Self { envelope, bands, catzoc };
        for [a, b] in edges {
            let (south, north) = (a.lat_deg.min(b.lat_deg), a.lat_deg.max(b.lat_deg));
            for band in zone.band(south)..=zone.band(north) {
                zone.bands[band].push([a, b]);
            }
        }
        Some(zone)
    }

    /// The band of a latitude of the area.
    fn band(&self, lat_deg: f64) -> usize {
        let Envelope([_, _, south, north]) = self.envelope;
        let share = (lat_deg - south) / (north - south).max(f64::MIN_POSITIVE);
        ((share * self.bands.len() as f64) as usize).min(self.bands.len() - 1)
    }

    fn holds(&self, at: GeoPoint) -> bool {
        let Envelope([west, east, south, north]) = self.envelope;
        let near = (west..=east).contains(&at.lon_deg) && (south..=north).contains(&at.lat_deg);
        let west_of = |pair: &&[GeoPoint; 2]| crossing(pair, at.lat_deg).is_some_and(|lon| lon < at.lon_deg);
        near && self.bands[self.band(at.lat_deg)].iter().filter(west_of).count() % 2 == 1
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

    proptest::proptest! {
        /// In bands as over all edges at once.
        #[test]
        fn a_zone_holds_what_its_rings_hold(
            ends in proptest::collection::vec((-20_i32..20, -20_i32..20), 3..40),
            at in (-42_i32..42, -42_i32..42),
        ) {
            let mut points: Vec<(f64, f64)> = ends.iter().map(|(x, y)| (f64::from(*x), f64::from(*y))).collect();
            points.push(points[0]);
            let area = Area { exteriors: vec![ring(&points)], holes: Vec::new() };
            let at = GeoPoint { lon_deg: f64::from(at.0) / 2.0, lat_deg: f64::from(at.1) / 2.0 };
            let at_once = crossings(&area, at.lat_deg).iter().filter(|lon| **lon < at.lon_deg).count();
            let zone = Zone::of(&area, 4).unwrap();
            proptest::prop_assert_eq!(zone.holds(at), at_once % 2 == 1);
        }
    }
}
