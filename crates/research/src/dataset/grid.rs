//! Places of sensitive animals, coarsened.
//!
//! A place becomes the middle of the cell in which it lies. The cell depends on the place and on the size alone: not on the
//! query, not on chance, so that repeated or varied queries, or the mean of many answers, reveal nothing more. Cells of a
//! larger size are made of whole cells of the smaller ones, so that two sizes together reveal no more than the smaller one.
//!
//! Cells are 0.001, 0.01 or 0.1 degrees of latitude high. In longitude they are as many degrees wide up to 60 degrees of latitude, and
//! twice, four and eight times as many from 60, 75 and 83 degrees on, where meridians draw together.

use api::{Wording, say};
use units::LatLon;

/// Sizes that there are: about how long a side is (m).
pub const PRECISIONS_M: [u32; 3] = [100, 1_000, 10_000];

/// Parts of a degree in which is reckoned: 1 cm, and exact, where fractions of a degree are not.
const PARTS: i64 = 10_000_000;

/// Cells of one size over the whole earth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Grid {
    /// Height of a cell, in parts of a degree; a whole number of them makes a degree.
    step: i64,
}

impl Grid {
    /// With cells of about this size.
    ///
    /// # Errors
    /// There is no such size; the text says which there are.
    pub fn new(precision_m: u32) -> Result<Self, Wording> {
        let step = match precision_m {
            100 => PARTS / 1_000,
            1_000 => PARTS / 100,
            10_000 => PARTS / 10,
            _ => {
                return Err(say("{precision_m} m is not a size of cells: choose 100, 1000 or 10000 m")
                    .with("precision_m", precision_m));
            }
        };
        Ok(Self { step })
    }

    /// The middle of the cell in which a place lies. There always is one; were there none, nothing would be given.
    pub fn middle(self, place: LatLon) -> Option<LatLon> {
        let (lat, lon) = (parts(place.lat_deg()), parts(place.lon_deg()));
        let width = self.step * widening(lat);
        let lat = middle(lat, 90 * PARTS, self.step);
        let lon = middle(lon, 180 * PARTS, width);
        LatLon::from_deg(lat as f64 / PARTS as f64, lon as f64 / PARTS as f64).ok()
    }
}

fn parts(degrees: f64) -> i64 {
    (degrees * PARTS as f64).floor() as i64
}

/// The middle of the cell of a length, counted from `-most`; what lies on the last edge belongs to the last cell.
fn middle(value: i64, most: i64, length: i64) -> i64 {
    let last = 2 * most / length - 1;
    let cell = (value + most).div_euclid(length).clamp(0, last);
    cell * length + length / 2 - most
}

/// By how much cells are wider at a latitude. It changes at whole degrees, which are edges of cells of all sizes.
fn widening(lat: i64) -> i64 {
    let degree = lat.div_euclid(PARTS);
    match if degree < 0 { -degree - 1 } else { degree } {
        ..60 => 1,
        60..75 => 2,
        75..83 => 4,
        _ => 8,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn middle_of(precision_m: u32, lat: f64, lon: f64) -> (f64, f64) {
        let place = Grid::new(precision_m).unwrap().middle(LatLon::from_deg(lat, lon).unwrap()).unwrap();
        (place.lat_deg(), place.lon_deg())
    }

    fn is_near((lat, lon): (f64, f64), (lat_wanted, lon_wanted): (f64, f64)) -> bool {
        (lat - lat_wanted).abs() < 1e-9 && (lon - lon_wanted).abs() < 1e-9
    }

    #[test]
    fn a_place_becomes_the_middle_of_its_cell() {
        assert!(is_near(middle_of(1_000, 63.4321, 10.3987), (63.435, 10.39)));
        assert!(is_near(middle_of(1_000, 63.4399, 10.3801), (63.435, 10.39)), "all of a cell alike");
        assert!(is_near(middle_of(100, 59.9996, 10.0004), (59.9995, 10.0005)));
        assert!(is_near(middle_of(10_000, -0.01, -0.01), (-0.05, -0.05)));
        for (lat, lon) in [(90.0, 180.0), (-90.0, -180.0), (89.999, 179.999)] {
            let (lat, lon) = middle_of(10_000, lat, lon);
            assert!(lat.abs() < 90.0 && lon.abs() < 180.0);
        }
        assert!(Grid::new(500).unwrap_err().to_string().contains("100, 1000 or 10000 m"));
    }

    proptest! {
        #[test]
        fn it_depends_on_the_cell_alone_and_coarser_follows_from_finer(lat in -90.0..90.0_f64, lon in -180.0..180.0_f64) {
            let place = LatLon::from_deg(lat, lon).unwrap();
            let [fine, medium, coarse] = PRECISIONS_M.map(|size| Grid::new(size).unwrap());
            for grid in [fine, medium, coarse] {
                let once = grid.middle(place);
                prop_assert_eq!(once, grid.middle(place));
                prop_assert_eq!(once, grid.middle(once.unwrap()), "the middle lies in its own cell");
            }
            prop_assert_eq!(medium.middle(fine.middle(place).unwrap()), medium.middle(place));
            prop_assert_eq!(coarse.middle(fine.middle(place).unwrap()), coarse.middle(place));
            prop_assert_eq!(coarse.middle(medium.middle(place).unwrap()), coarse.middle(place));
        }
    }
}
