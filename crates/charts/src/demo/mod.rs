//! A fictitious archipelago for demonstrations and tests: two cells of S-57 about the place where the Otters of
//! `lutra-server demo` sail. **Not for navigation**: nothing of it is real.
//!
//! The sea floor is a function of position (`sea`). It is sampled on a grid, contours are drawn through it
//! (`contour`), the areas between them found (`faces`), and all of it written as nodes, edges and features
//! (`cell`), so that neighbours share their edges and the areas of depth and land fill the cell without gap or
//! overlap. The same code gives the same bytes on every computer.

mod cell;
mod contour;
mod faces;
mod noise;
mod objects;
mod sea;
#[cfg(test)]
mod tests;

use crate::s57::GeoPoint;
use crate::s57::write::WriteError;
use sea::Sea;
use units::LatLon;

/// What the cells say of themselves.
pub const NOT_FOR_NAVIGATION: &str = "LUTRA DEMONSTRATION - NOT FOR NAVIGATION - NOTHING OF THIS IS REAL";

/// Where local coordinates begin, north and east (degrees): the start of the demonstration's first Otter.
const ORIGIN_DEG: [f64; 2] = [63.446, 10.345];
/// Metres per degree of latitude and longitude there. All that is drawn is drawn with these two numbers.
const METRES_PER_DEG: [f64; 2] = [111_463.0, 49_905.0];

/// A file of the archipelago.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct DemoFile {
    /// Its name, such as `XX5LUTRA.000`; XX is not a country.
    pub name: &'static str,
    /// The cell.
    pub bytes: Vec<u8>,
}

/// What a cell covers and how finely.
struct Extent {
    name: &'static str,
    band: u8,
    scale: u32,
    /// Metres from the origin.
    south_west: [f64; 2],
    step_m: f64,
    /// Points of the grid along x and y.
    size: [usize; 2],
    /// Depths of the coastline and of the contours (m).
    levels: &'static [f64],
    /// Points of the grid per sounding, along each axis.
    block: usize,
    /// CATZOC.
    zone: &'static str,
}

impl Extent {
    /// Whether it shows the harbour in detail.
    fn fine(&self) -> bool {
        self.band >= 5
    }

    fn limits(&self) -> sea::Box {
        let [west, south] = self.south_west;
        let far = |axis: usize| self.south_west[axis] + self.step_m * (self.size[axis] - 1) as f64;
        sea::Box { west, south, east: far(0), north: far(1) }
    }
}

const APPROACH: Extent = Extent {
    name: "XX4LUTRA.000",
    band: 4,
    scale: 50_000,
    south_west: [-4_000.0, -2_200.0],
    step_m: 40.0,
    size: [226, 161],
    levels: &[cell::COAST_M, 0.0, 5.0, 10.0, 20.0, 50.0, 100.0],
    block: 10,
    zone: "3",
};

const HARBOUR: Extent = Extent {
    name: "XX5LUTRA.000",
    band: 5,
    scale: 12_000,
    south_west: [-1_500.0, -1_450.0],
    step_m: 12.5,
    size: [289, 257],
    levels: &[cell::COAST_M, 0.0, 2.0, 3.0, 5.0, 10.0, 20.0, 30.0, 50.0],
    block: 11,
    zone: "1",
};

/// The cells: an approach of some 9 by 6 km and a harbour in it. They read back without a notice.
///
/// # Errors
/// Should a text or position of the archipelago not fit the format; the tests show that all do.
pub fn archipelago() -> Result<Vec<DemoFile>, WriteError> {
    let sea = Sea::new();
    let file =
        |extent: &Extent| Ok(DemoFile { name: extent.name, bytes: cell::lay(extent, &sea).to_bytes()? });
    [&APPROACH, &HARBOUR].into_iter().map(file).collect()
}

/// The sea floor that the cells of [`archipelago`] are drawn from.
pub fn sea_floor() -> SeaFloor {
    SeaFloor(Sea::new())
}

/// What the cells are a chart of.
pub struct SeaFloor(Sea);

impl SeaFloor {
    /// Where the demonstration's first Otter starts.
    pub const ORIGIN: GeoPoint = GeoPoint { lon_deg: ORIGIN_DEG[1], lat_deg: ORIGIN_DEG[0] };

    /// Depth at a place (m) below chart datum; negative on land. What people put there, such as pontoons and
    /// piles, is not the floor.
    pub fn depth_m(&self, place: LatLon) -> f64 {
        let local = |deg: f64, axis: usize| (deg - ORIGIN_DEG[1 - axis]) * METRES_PER_DEG[1 - axis];
        -self.0.height_m([local(place.lon_deg(), 0), local(place.lat_deg(), 1)])
    }
}

/// The place of a local point.
fn degrees([east_m, north_m]: [f64; 2]) -> GeoPoint {
    GeoPoint {
        lon_deg: ORIGIN_DEG[1] + east_m / METRES_PER_DEG[1],
        lat_deg: ORIGIN_DEG[0] + north_m / METRES_PER_DEG[0],
    }
}
