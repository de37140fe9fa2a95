//! Depth grids and contour vertices for other programs, and for comparison with the thesis that Lutra grew from.
//!
//! A grid point holds the water at that point, or, where the grid adapts, the shallowest of its square. Points
//! on land and without data are left out, as the thesis has it: what is absent is not navigable. Rows are given
//! one by one, so memory does not grow with their number.

use crate::error::Result;
use crate::read::ChartDb;
use charts::depth_index::{Demand, DepthIndex, Water};
use charts::s57::{AttributeCode, Geometry, ObjectClass};
use units::{LatLon, LocalFrame, LocalPoint};

/// The box and spacing of a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Grid {
    /// South-western corner.
    pub south_west: LatLon,
    /// North-eastern corner; east of the other one.
    pub north_east: LatLon,
    /// Distance of points, the same north and east at the middle of the box (m).
    pub spacing_m: f64,
    /// Where it is deeper, squares grow up to the spacing of this (m); `None` for a fixed spacing.
    pub adapt: Option<Adapt>,
}

/// How a grid adapts.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Adapt {
    /// Squares of which every part is at least this deep are not divided (m).
    pub deep_m: f64,
    /// The largest squares (m).
    pub coarsest_m: f64,
}

/// One point of a grid.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct GridRow {
    /// The place.
    pub at: LatLon,
    /// Side of the square that it stands for (m).
    pub size_m: f64,
    /// Least charted depth (m).
    pub least_m: f64,
    /// Greatest charted depth of the area (m), where it is charted.
    pub greatest_m: Option<f64>,
}

/// Distance of two places of one neighbourhood (m).
fn distance_m(a: LatLon, b: LatLon) -> f64 {
    LocalFrame::new(a).to_local(b).distance_m(LocalPoint::default())
}

/// Degrees of a length north and east round a latitude.
fn degrees(lat_deg: f64, length_m: f64) -> (f64, f64) {
    let at = LatLon::from_deg(lat_deg.clamp(-89.0, 89.0), 0.0).expect("invariant: clamped to the range");
    let north = LatLon::from_deg(at.lat_deg() + 1e-3, 0.0).expect("invariant: 1e-3 from a clamped latitude");
    let east = LatLon::from_deg(at.lat_deg(), 1e-3).expect("invariant: a clamped latitude");
    (1e-3 * length_m / distance_m(at, north), 1e-3 * length_m / distance_m(at, east))
}

impl Grid {
    /// How often the spacing is doubled for the largest squares.
    fn doublings(&self) -> f64 {
        let most = |adapt: Adapt| (adapt.coarsest_m / self.spacing_m).max(1.0).log2().floor().min(20.0);
        self.adapt.map_or(0.0, most)
    }

    /// Side of the largest squares (m): the spacing doubled as often as it fits.
    fn start_m(&self) -> f64 {
        self.spacing_m * self.doublings().exp2()
    }

    /// Rows and columns of the largest squares, and their sides north and east (°).
    fn squares(&self) -> ([u64; 2], [f64; 2]) {
        let (from, to) = (self.south_west, self.north_east);
        let middle_deg = f64::midpoint(from.lat_deg(), to.lat_deg());
        let (north_deg, east_deg) = degrees(middle_deg, self.start_m());
        let steps = |from: f64, to: f64, step: f64| ((to - from) / step).ceil().max(1.0) as u64;
        let rows = steps(from.lat_deg(), to.lat_deg(), north_deg);
        ([rows, steps(from.lon_deg(), to.lon_deg(), east_deg)], [north_deg, east_deg])
    }

    /// Points that the box has at the spacing: the most that are looked at, and given.
    pub fn points(&self) -> u64 {
        let [rows, columns] = self.squares().0;
        let each = self.doublings().exp2().powi(2) as u64;
        rows.saturating_mul(columns).saturating_mul(each)
    }
}

/// Gives the points of a grid from south to north and west to east until `give` returns false. `looked` gets the share of the box
/// that is done, from 0 to 1, after each row of the largest squares.
///
/// Returns how many were given.
pub fn grid(
    index: &DepthIndex,
    grid: &Grid,
    looked: &mut dyn FnMut(f64),
    give: &mut dyn FnMut(&GridRow) -> bool,
) -> u64 {
    let start_m = grid.start_m();
    let ([rows, columns], [north_deg, east_deg]) = grid.squares();
    let from = grid.south_west;
    let mut walk = Walk { index, grid, give, count: 0 };
    for row in 0..rows {
        looked(row as f64 / rows as f64);
        for column in 0..columns {
            let lat_deg = from.lat_deg() + (row as f64 + 0.5) * north_deg;
            let lon_deg = from.lon_deg() + (column as f64 + 0.5) * east_deg;
            if !walk.square(lat_deg, lon_deg, [north_deg, east_deg], start_m) {
                return walk.count;
            }
        }
    }
    walk.count
}

struct Walk<'a> {
    index: &'a DepthIndex,
    grid: &'a Grid,
    give: &'a mut dyn FnMut(&GridRow) -> bool,
    count: u64,
}

impl Walk<'_> {
    /// False to stop. The recursion is at most 20 deep.
    fn square(&mut self, lat_deg: f64, lon_deg: f64, side_deg: [f64; 2], size_m: f64) -> bool {
        let Ok(at) = LatLon::from_deg(lat_deg, lon_deg) else { return true };
        let demand = Demand::default();
        let answer = match self.grid.adapt {
            None => self.index.depth_at(at, &demand),
            // The circle round the square holds all of it.
            Some(_) => self.index.shallowest_within(at, size_m * std::f64::consts::FRAC_1_SQRT_2, &demand),
        };
        let divide = self.grid.adapt.is_some_and(|adapt| {
            let deep = answer.water.least_m().is_some_and(|least_m| least_m >= adapt.deep_m);
            !deep && size_m > self.grid.spacing_m * 1.5
        });
        if divide {
            let [north_deg, east_deg] = side_deg.map(|side| side / 4.0);
            return [(-1.0, -1.0), (-1.0, 1.0), (1.0, -1.0), (1.0, 1.0)].into_iter().all(|(north, east)| {
                let half = side_deg.map(|side| side / 2.0);
                let (lat_deg, lon_deg) = (lat_deg + north * north_deg, lon_deg + east * east_deg);
                self.square(lat_deg, lon_deg, half, size_m / 2.0)
            });
        }
        let Water::Depth { least_m, greatest_m } = answer.water else { return true };
        self.count += 1;
        (self.give)(&GridRow { at, size_m, least_m, greatest_m })
    }
}

/// A vertex of the border of a depth area.
#[derive(Debug, Clone, PartialEq)]
pub struct ContourVertex {
    /// The place.
    pub at: LatLon,
    /// Least depth of the area (m).
    pub least_m: f64,
    /// Greatest depth of the area (m), where it is charted.
    pub greatest_m: Option<f64>,
    /// The cell.
    pub chart: String,
}

/// Gives the vertices of the borders of all depth areas, and between them so many more that none are farther
/// apart than `spacing_m`, until `give` returns false. Areas whose least depth exceeds `deepest_m` are left out.
///
/// Only one chart at a time is held in memory. Returns how many were given.
///
/// # Errors
/// When the database cannot be read.
pub fn vertices(
    charts: &ChartDb,
    spacing_m: f64,
    deepest_m: f64,
    give: &mut dyn FnMut(&ContourVertex) -> bool,
) -> Result<u64> {
    let mut count = 0;
    for chart in charts.charts()? {
        for feature in charts.features(&chart)? {
            let least = feature.number(AttributeCode::DRVAL1).filter(|least_m| *least_m <= deepest_m);
            let (Geometry::Area(area), Some(least_m)) = (&feature.geometry, least) else { continue };
            if ![ObjectClass::DEPARE, ObjectClass::DRGARE].contains(&feature.class) {
                continue;
            }
            let greatest_m = feature.number(AttributeCode::DRVAL2);
            for pair in area.rings().flat_map(|ring| ring.points.windows(2)) {
                let (Some(a), Some(b)) = (pair[0].place(), pair[1].place()) else { continue };
                let parts = (distance_m(a, b) / spacing_m).ceil().clamp(1.0, 1e7) as u32;
                for part in 0..parts {
                    let share = f64::from(part) / f64::from(parts);
                    let between = |from: f64, to: f64| from + share * (to - from);
                    let lat_deg = between(pair[0].lat_deg, pair[1].lat_deg);
                    let lon_deg = between(pair[0].lon_deg, pair[1].lon_deg);
                    let Ok(at) = LatLon::from_deg(lat_deg, lon_deg) else { continue };
                    count += 1;
                    if !give(&ContourVertex { at, least_m, greatest_m, chart: chart.name.clone() }) {
                        return Ok(count);
                    }
                }
            }
        }
    }
    Ok(count)
}
