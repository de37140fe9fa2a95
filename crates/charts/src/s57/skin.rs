//! The acceptance check of a cell: its skin of the Earth covers what the cell says it covers.
//!
//! S-57 appendix B.1, 3.8.1: the areas of group 1 tile the covered area without gap or overlap. So their
//! areas add up to that of M_COVR with CATCOV 1, and every side of their boundaries is there once in each
//! direction, but for the sides that bound the covered area. What is left then goes around gaps and overlaps:
//! sums alone would not distinguish a gap from an overlap as large. A cell that fails this was read wrongly or is damaged.

use super::cell::Cell;
use super::codes::{AttributeCode, ObjectClass, SKIN_CLASSES};
use super::feature::Feature;
use super::geometry::{Area, GeoPoint, Geometry, Path};
use std::collections::BTreeMap;

/// The two sums that must agree, and where they do not.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SkinCheck {
    /// Of all areas of group 1 (square degrees).
    pub skin_deg2: f64,
    /// Of all areas that the cell covers (square degrees).
    pub coverage_deg2: f64,
    /// Areas of either kind whose boundary does not close.
    pub unreadable: usize,
    /// Of all gaps and overlaps (square degrees), more where the borders around them share no corners; those as narrow
    /// as coordinates are rounded do not count.
    pub amiss_deg2: f64,
    /// A corner of the largest.
    pub amiss_at: Option<GeoPoint>,
}

impl SkinCheck {
    /// Whether they agree to one part in a hundred million, there is no gap or overlap, and anything at all.
    pub fn holds(&self) -> bool {
        let difference = (self.skin_deg2 - self.coverage_deg2).abs();
        let agree = self.coverage_deg2 > 0.0 && difference <= self.coverage_deg2 * 1e-8;
        self.unreadable == 0 && agree && self.amiss_at.is_none()
    }
}

impl Cell {
    /// Sums both sides, and looks for gaps and overlaps.
    pub fn skin_check(&self) -> SkinCheck {
        let (mut skin_deg2, mut coverage_deg2, mut unreadable) = (0.0, 0.0, 0);
        let mut sides = Sides::default();
        for feature in &self.features {
            let skin = SKIN_CLASSES.contains(&feature.class);
            if !skin && !is_coverage(feature) {
                continue;
            }
            match &feature.geometry {
                Geometry::Area(area) => {
                    *(if skin { &mut skin_deg2 } else { &mut coverage_deg2 }) += area.area_deg2();
                    sides.add(area, skin);
                }
                Geometry::Unreadable { .. } => unreadable += 1,
                Geometry::None | Geometry::Point(_) | Geometry::Soundings(_) | Geometry::Lines(_) => {}
            }
        }
        // A node in the middle of a straight border is off it by as much as coordinates are rounded.
        let rounded_deg = 1.0 / f64::from(self.parameters.coordinate_factor.max(1));
        let (amiss_deg2, amiss_at) = sides.amiss(rounded_deg);
        SkinCheck { skin_deg2, coverage_deg2, unreadable, amiss_deg2, amiss_at }
    }
}

/// A corner by the bits of its coordinates: areas that share an edge have the very same numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Corner {
    lon: u64,
    lat: u64,
}

impl Corner {
    fn of(point: GeoPoint) -> Self {
        // -0 is 0.
        Self { lon: (point.lon_deg + 0.0).to_bits(), lat: (point.lat_deg + 0.0).to_bits() }
    }

    fn point(self) -> GeoPoint {
        GeoPoint { lon_deg: f64::from_bits(self.lon), lat_deg: f64::from_bits(self.lat) }
    }
}

/// The sides of boundaries: corners in order, and whether it runs from the first to the second.
#[derive(Debug, Default)]
struct Sides(Vec<([Corner; 2], bool)>);

impl Sides {
    /// The rings of an area, the area to their right; those of the coverage, against which the others stand, the
    /// other way round.
    fn add(&mut self, area: &Area, skin: bool) {
        for (rings, clockwise) in [(&area.exteriors, true), (&area.holes, false)] {
            for ring in rings {
                let is_clockwise = ring.signed_area_deg2() < 0.0;
                let onward = (is_clockwise == clockwise) == skin;
                for pair in ring.points.windows(2) {
                    let (from, to) = (Corner::of(pair[0]), Corner::of(pair[1]));
                    match from.cmp(&to) {
                        std::cmp::Ordering::Less => self.0.push(([from, to], onward)),
                        std::cmp::Ordering::Equal => {}
                        std::cmp::Ordering::Greater => self.0.push(([to, from], !onward)),
                    }
                }
            }
        }
    }

    /// All gaps and overlaps together (square degrees), and a corner of the largest.
    fn amiss(self, rounded_deg: f64) -> (f64, Option<GeoPoint>) {
        let (mut amiss_deg2, mut worst_deg2, mut at) = (0.0, 0.0, None);
        for ring in self.left() {
            let length = |pair: &[GeoPoint]| {
                (pair[1].lon_deg - pair[0].lon_deg).hypot(pair[1].lat_deg - pair[0].lat_deg)
            };
            let around_deg: f64 = ring.points.windows(2).map(length).sum();
            let area_deg2 = ring.signed_area_deg2().abs();
            if area_deg2 <= rounded_deg * around_deg {
                continue;
            }
            amiss_deg2 += area_deg2;
            if area_deg2 > worst_deg2 {
                (worst_deg2, at) = (area_deg2, ring.points.first().copied());
            }
        }
        (amiss_deg2, at)
    }

    /// Takes away what is there in both directions, and gives the rest as rings.
    fn left(mut self) -> Vec<Path> {
        self.0.sort_unstable();
        let mut onward: BTreeMap<Corner, Vec<Corner>> = BTreeMap::new();
        for same in self.0.chunk_by(|one, next| one.0 == next.0) {
            let [first, second] = same[0].0;
            let there = same.iter().filter(|(_, onward)| *onward).count();
            let back = same.len() - there;
            let (from, to) = if there > back { (first, second) } else { (second, first) };
            for _ in 0..there.abs_diff(back) {
                onward.entry(from).or_default().push(to);
            }
        }
        rings(onward)
    }
}

/// Follows sides from corner to corner; where a corner is met again, a ring is closed. Rings are closed, so at every
/// corner as many sides end as begin.
fn rings(mut onward: BTreeMap<Corner, Vec<Corner>>) -> Vec<Path> {
    let mut rings = Vec::new();
    while let Some((start, _)) = onward.first_key_value() {
        let (mut way, mut places) = (vec![*start], BTreeMap::from([(*start, 0)]));
        while let Some(here) = way.last() {
            let Some(next) = onward.get_mut(here).and_then(Vec::pop) else { break };
            if onward.get(here).is_some_and(Vec::is_empty) {
                onward.remove(here);
            }
            if let Some(met) = places.get(&next).copied() {
                let mut points: Vec<GeoPoint> = way[met..].iter().map(|corner| corner.point()).collect();
                points.push(next.point());
                rings.push(Path { points, edges: Vec::new() });
                for left in way.drain(met + 1..) {
                    places.remove(&left);
                }
            } else {
                places.insert(next, way.len());
                way.push(next);
            }
        }
    }
    rings
}

/// Whether a feature says where the cell has data.
pub(crate) fn is_coverage(feature: &Feature) -> bool {
    feature.class == ObjectClass::M_COVR && feature.code(AttributeCode::CATCOV) == Some(1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn ring(corners: &[(f64, f64)]) -> Path {
        let closed = corners.iter().chain(corners.first());
        let points = closed.map(|(lon_deg, lat_deg)| GeoPoint { lon_deg: *lon_deg, lat_deg: *lat_deg });
        Path { points: points.collect(), edges: Vec::new() }
    }

    fn area(corners: &[(f64, f64)]) -> Area {
        Area { exteriors: vec![ring(corners)], holes: Vec::new() }
    }

    fn oblong(west: f64, east: f64) -> Area {
        area(&[(west, 0.0), (east, 0.0), (east, 1.0), (west, 1.0)])
    }

    fn amiss(skin: &[Area], coverage: &[Area]) -> (f64, Option<GeoPoint>) {
        let mut sides = Sides::default();
        for (area, skin) in skin.iter().map(|one| (one, true)).chain(coverage.iter().map(|one| (one, false)))
        {
            sides.add(area, skin);
        }
        sides.amiss(1e-7)
    }

    #[test]
    fn a_gap_and_an_overlap_as_large_do_not_cancel() {
        let skin = [oblong(0.0, 1.0), oblong(1.1, 2.1), oblong(2.0, 3.0)];
        let sum: f64 = skin.iter().map(Area::area_deg2).sum();
        assert!((sum - 3.0).abs() < 1e-12, "the sums agree");
        let (deg2, at) = amiss(&skin, &[oblong(0.0, 3.0)]);
        assert!(deg2 > 0.2 - 1e-9 && at.is_some(), "{deg2}");
    }

    #[test]
    fn areas_that_tile_leave_nothing_however_they_run() {
        let (here, mut there) = (oblong(0.0, 1.0), oblong(1.0, 3.0));
        there.exteriors[0].points.reverse();
        let pond = ring(&[(1.2, 0.2), (1.4, 0.2), (1.4, 0.4)]);
        there.holes.push(pond.clone());
        let islet = Area { exteriors: vec![pond], holes: Vec::new() };
        let coverage = [oblong(0.0, 3.0)];
        assert_eq!(amiss(&[here.clone(), there.clone(), islet], &coverage), (0.0, None));
        // Without what is in the hole.
        let (deg2, at) = amiss(&[here, there], &coverage);
        assert!((deg2 - 0.02).abs() < 1e-12 && at.unwrap().lon_deg > 1.1, "{deg2}");
    }

    #[test]
    fn corners_on_a_straight_border_are_no_gaps_unless_they_are_off_it() {
        let coverage = [area(&[(0.0, 0.0), (0.3, 0.1), (0.0, 0.1)])];
        let with = |off: f64| [area(&[(0.0, 0.0), (0.1, 0.1 / 3.0 + off), (0.3, 0.1), (0.0, 0.1)])];
        assert_eq!(amiss(&with(5e-8), &coverage), (0.0, None));
        assert!(amiss(&with(1e-4), &coverage).1.is_some());
    }

    #[test]
    fn the_same_area_twice_is_an_overlap() {
        let skin = [oblong(0.0, 1.0), oblong(0.0, 1.0)];
        let (deg2, _) = amiss(&skin, &[oblong(0.0, 1.0)]);
        assert!((deg2 - 1.0).abs() < 1e-12, "{deg2}");
    }
}
