//! Currents that routes are weighed in: steady ones, and grids with time steps.
//!
//! A grid holds values at the crossings of latitudes and longitudes, at one or more times. Between them the current is
//! linear: in latitude, in longitude and in time. Beyond its edges, before its first time and after its last one, and
//! beside a value that is missing, the current is not known, and it is never taken to be zero without saying so.

use units::LatLon;

/// Values lie so far outside an axis only by rounding.
const ROUNDING: f64 = 1e-9;
/// Faster currents than this are taken for a mistake in the file (m/s).
pub const MOST_CURRENT_MPS: f32 = 15.0;
/// Most values of a grid for each component: such a grid takes 32 MiB.
pub const MOST_GRID_VALUES: usize = 4 << 20;

/// Where water flows to, and how fast.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Flow {
    /// Speed to the true east (m/s).
    pub east_mps: f64,
    /// Speed to the true north (m/s).
    pub north_mps: f64,
}

impl Flow {
    /// By the direction that the current flows to (rad, clockwise from true north) and its speed (m/s).
    pub fn set_and_drift(set_rad: f64, drift_mps: f64) -> Self {
        let (sin, cos) = set_rad.sin_cos();
        Self { east_mps: drift_mps * sin, north_mps: drift_mps * cos }
    }

    /// How fast (m/s).
    pub fn drift_mps(&self) -> f64 {
        self.east_mps.hypot(self.north_mps)
    }
}

/// Speed over ground (m/s) of a vessel that steers up against a current to make good a course; `None` where the current
/// is too strong for that. The current is given along the course and across it (m/s).
pub(crate) fn made_good_mps(through_water_mps: f64, along_mps: f64, across_mps: f64) -> Option<f64> {
    let left = through_water_mps.powi(2) - across_mps.powi(2);
    let made_good_mps = along_mps + left.max(0.0).sqrt();
    (left >= 0.0 && made_good_mps > 1e-3).then_some(made_good_mps)
}

/// The current at any place and time.
#[derive(Debug, Clone, PartialEq)]
pub enum Currents {
    /// The same everywhere and always.
    Steady(Flow),
    /// By a grid.
    Grid(CurrentGrid),
}

impl Default for Currents {
    /// Still water.
    fn default() -> Self {
        Self::Steady(Flow::default())
    }
}

impl Currents {
    /// The current at a place and time (s since 1970, UTC); `None` where it is not known.
    pub fn at(&self, place: LatLon, time_s: f64) -> Option<Flow> {
        match self {
            Self::Steady(flow) => Some(*flow),
            Self::Grid(grid) => grid.at(place, time_s),
        }
    }

    /// Whether there is no current anywhere.
    pub(crate) fn is_still(&self) -> bool {
        matches!(self, Self::Steady(flow) if flow.drift_mps() == 0.0)
    }

    /// Whether it changes from place to place or with time.
    pub(crate) fn varies(&self) -> bool {
        matches!(self, Self::Grid(_))
    }

    /// Whether it changes with time.
    pub(crate) fn varies_in_time(&self) -> bool {
        matches!(self, Self::Grid(grid) if grid.times_s.len() > 1)
    }

    /// The fastest anywhere (m/s).
    pub(crate) fn most_mps(&self) -> f64 {
        match self {
            Self::Steady(flow) => flow.drift_mps(),
            Self::Grid(grid) => grid.most_mps,
        }
    }
}

/// Why values are not a grid of currents.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum CurrentGridError {
    /// An axis does not rise.
    #[error("{axis}: value {number} is not a number or not greater than the one before; sort the grid")]
    Axis {
        /// The axis that is meant.
        axis: &'static str,
        /// Which value, from 1.
        number: usize,
    },
    /// An axis has too few values.
    #[error("{axis}: there are {found}; a grid needs {least} or more")]
    Few {
        /// The axis that is meant.
        axis: &'static str,
        /// How many there are.
        found: usize,
        /// How many are needed.
        least: usize,
    },
    /// An axis leaves the globe.
    #[error("{axis}: it goes from {first} to {last}; {limits}")]
    Range {
        /// The axis that is meant.
        axis: &'static str,
        /// Its first value.
        first: f64,
        /// Its last value.
        last: f64,
        /// What it may be.
        limits: &'static str,
    },
    /// More or fewer values than crossings.
    #[error(
        "{component}: there are {found} values; {times} times of {lats} latitudes and {lons} longitudes need {needed}"
    )]
    Count {
        /// Which component.
        component: &'static str,
        /// How many there are.
        found: usize,
        /// Times.
        times: usize,
        /// Latitudes.
        lats: usize,
        /// Longitudes.
        lons: usize,
        /// How many are needed.
        needed: usize,
    },
    /// Too many values.
    #[error(
        "the grid has {0} values; up to {MOST_GRID_VALUES} are read: cut it to the area and the time of the route"
    )]
    Large(usize),
    /// A speed that is too fast for a current.
    #[error("{component}: value {number} is {found} m/s; up to {MOST_CURRENT_MPS} m/s is taken: give m/s")]
    Speed {
        /// Which component.
        component: &'static str,
        /// Which value, from 1.
        number: usize,
        /// The value (m/s).
        found: f32,
    },
}

/// Currents at the crossings of latitudes and longitudes, at one or more times. A grid of one time holds at any time.
#[derive(Debug, Clone, PartialEq)]
pub struct CurrentGrid {
    times_s: Vec<f64>,
    lats_deg: Vec<f64>,
    lons_deg: Vec<f64>,
    /// By time, then latitude, then longitude: to the east and to the north (m/s); not a number where not known.
    flows: Vec<[f32; 2]>,
    most_mps: f64,
}

impl CurrentGrid {
    /// From rising times (s since 1970, UTC), latitudes and longitudes (°, also beyond 180), and the currents to the east
    /// and to the north (m/s) by time, then latitude, then longitude. A value that is not a number is a missing one.
    ///
    /// # Errors
    /// Which axis or value is wrong, and what it has to be.
    pub fn new(
        times_s: Vec<f64>,
        lats_deg: Vec<f64>,
        lons_deg: Vec<f64>,
        east_mps: &[f32],
        north_mps: &[f32],
    ) -> Result<Self, CurrentGridError> {
        for (axis, values, least) in
            [("times", &times_s, 1), ("latitudes", &lats_deg, 2), ("longitudes", &lons_deg, 2)]
        {
            if values.len() < least {
                return Err(CurrentGridError::Few { axis, found: values.len(), least });
            }
            let mut before = f64::NEG_INFINITY;
            for (number, value) in (1..).zip(values) {
                if !value.is_finite() || *value <= before {
                    return Err(CurrentGridError::Axis { axis, number });
                }
                before = *value;
            }
        }
        let ends = |values: &[f64]| (values[0], values[values.len() - 1]);
        let (south, north) = ends(&lats_deg);
        if south < -90.0 || north > 90.0 {
            let limits = "latitudes are within ±90°";
            return Err(CurrentGridError::Range { axis: "latitudes", first: south, last: north, limits });
        }
        let (west, east) = ends(&lons_deg);
        if west < -360.0 || east > 540.0 || east - west > 360.0 {
            let limits = "longitudes are degrees, and go round the globe once at most";
            return Err(CurrentGridError::Range { axis: "longitudes", first: west, last: east, limits });
        }
        let (times, lats, lons) = (times_s.len(), lats_deg.len(), lons_deg.len());
        let needed = times.saturating_mul(lats).saturating_mul(lons);
        if needed > MOST_GRID_VALUES {
            return Err(CurrentGridError::Large(needed));
        }
        for (component, values) in [("to the east", east_mps), ("to the north", north_mps)] {
            let found = values.len();
            if found != needed {
                return Err(CurrentGridError::Count { component, found, times, lats, lons, needed });
            }
            if let Some(at) = values.iter().position(|value| value.abs() > MOST_CURRENT_MPS) {
                return Err(CurrentGridError::Speed { component, number: at + 1, found: values[at] });
            }
        }
        let flows: Vec<[f32; 2]> = east_mps.iter().zip(north_mps).map(|(e, n)| [*e, *n]).collect();
        let drift_mps = |[e, n]: &[f32; 2]| f64::from(*e).hypot(f64::from(*n));
        let most_mps = flows.iter().map(drift_mps).filter(|mps| mps.is_finite()).fold(0.0, f64::max);
        Ok(Self { times_s, lats_deg, lons_deg, flows, most_mps })
    }

    /// Its first and last time (s since 1970, UTC).
    pub fn times_s(&self) -> (f64, f64) {
        (self.times_s[0], self.times_s[self.times_s.len() - 1])
    }

    /// The current at a place and time (s since 1970, UTC); `None` where it is not known.
    pub fn at(&self, place: LatLon, time_s: f64) -> Option<Flow> {
        let time = if self.times_s.len() == 1 { (0, 0.0) } else { between(&self.times_s, time_s)? };
        let lat = between(&self.lats_deg, place.lat_deg())?;
        let west_deg = self.lons_deg[0];
        let off_deg = (place.lon_deg() - west_deg).rem_euclid(360.0);
        let off_deg = if off_deg > 360.0 - ROUNDING { 0.0 } else { off_deg };
        let lon = between(&self.lons_deg, west_deg + off_deg)?;
        let mut flow = Flow::default();
        for (step, time_share) in ends(time) {
            for (row, lat_share) in ends(lat) {
                for (column, lon_share) in ends(lon) {
                    let share = time_share * lat_share * lon_share;
                    let at = (step * self.lats_deg.len() + row) * self.lons_deg.len() + column;
                    let [east_mps, north_mps] = *self.flows.get(at)?;
                    flow.east_mps += share * f64::from(east_mps);
                    flow.north_mps += share * f64::from(north_mps);
                }
            }
        }
        (flow.east_mps.is_finite() && flow.north_mps.is_finite()).then_some(flow)
    }
}

/// The two neighbours on an axis and their shares; a neighbour without a share is left out, so that what is missing there
/// does not count.
fn ends((first, share): (usize, f64)) -> impl Iterator<Item = (usize, f64)> {
    [(first, 1.0 - share), (first + 1, share)].into_iter().filter(|(_, share)| *share > 0.0)
}

/// Between which two values of a rising axis, and at what share of the way; `None` outside.
fn between(axis: &[f64], at: f64) -> Option<(usize, f64)> {
    let (first, last) = (*axis.first()?, *axis.last()?);
    if !(first - ROUNDING..=last + ROUNDING).contains(&at) {
        return None;
    }
    let before = axis.partition_point(|value| *value <= at).clamp(1, axis.len() - 1) - 1;
    let share = (at - axis[before]) / (axis[before + 1] - axis[before]);
    Some((before, share.clamp(0.0, 1.0)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    fn place(lat_deg: f64, lon_deg: f64) -> LatLon {
        LatLon::from_deg(lat_deg, lon_deg).unwrap()
    }

    /// To the east 0.1 × hours + 0.01 × rows + 0.001 × columns.
    fn grid(lons_deg: Vec<f64>) -> CurrentGrid {
        let (times_s, lats_deg) = (vec![0.0, 3_600.0], vec![63.0, 63.1, 63.3]);
        let mut east = Vec::new();
        for step in 0..2_u8 {
            for row in 0..3_u8 {
                east.extend(
                    (0..lons_deg.len())
                        .map(|column| 0.1 * f32::from(step) + 0.01 * f32::from(row) + 0.001 * column as f32),
                );
            }
        }
        let north = vec![0.5; east.len()];
        CurrentGrid::new(times_s, lats_deg, lons_deg, &east, &north).unwrap()
    }

    #[test]
    fn a_current_helps_hinders_sets_aside_and_stops() {
        let east = Flow::set_and_drift(FRAC_PI_2, 0.6);
        assert!((east.east_mps - 0.6).abs() < 1e-12 && east.north_mps.abs() < 1e-12);
        assert!((made_good_mps(1.0, 0.6, 0.0).unwrap() - 1.6).abs() < 1e-12);
        assert!((made_good_mps(1.0, -0.6, 0.0).unwrap() - 0.4).abs() < 1e-12);
        // 3, 4, 5.
        assert!((made_good_mps(1.0, 0.0, 0.6).unwrap() - 0.8).abs() < 1e-12);
        assert_eq!((made_good_mps(0.5, 0.0, 0.6), made_good_mps(0.6, -0.6, 0.0)), (None, None));
    }

    #[test]
    fn a_grid_is_linear_between_its_values_and_not_known_beyond_them() {
        let grid = grid(vec![10.0, 10.2]);
        let at = |lat: f64, lon: f64, time_s: f64| grid.at(place(lat, lon), time_s).map(|flow| flow.east_mps);
        let near = |found: Option<f64>, wanted: f64| (found.unwrap() - wanted).abs() < 1e-6;
        assert!(near(at(63.0, 10.0, 0.0), 0.0) && near(at(63.3, 10.2, 3_600.0), 0.121));
        assert!(near(at(63.05, 10.05, 900.0), 0.025 + 0.005 + 0.000_25));
        assert!(near(at(63.2, 10.1, 1_800.0), 0.05 + 0.015 + 0.000_5));
        for (lat, lon, time_s) in [
            (62.99, 10.1, 0.0),
            (63.31, 10.1, 0.0),
            (63.1, 9.9, 0.0),
            (63.1, 10.3, 0.0),
            (63.1, 10.1, -1.0),
            (63.1, 10.1, 3_601.0),
        ] {
            assert_eq!(at(lat, lon, time_s), None, "{lat} {lon} {time_s}");
        }
    }

    #[test]
    fn longitudes_beyond_180_are_the_same_places() {
        let grid = grid(vec![359.9, 360.1]);
        let flow = grid.at(place(63.0, 0.0), 0.0).unwrap();
        assert!((flow.east_mps - 0.000_5).abs() < 1e-7);
        assert!(grid.at(place(63.0, -0.1), 0.0).is_some() && grid.at(place(63.0, 0.2), 0.0).is_none());
    }

    #[test]
    fn beside_a_missing_value_the_current_is_not_known() {
        let east = [0.1, f32::NAN, 0.1, 0.1];
        let grid = CurrentGrid::new(vec![5.0], vec![63.0, 63.1], vec![10.0, 10.1], &east, &[0.0; 4]).unwrap();
        assert_eq!(grid.at(place(63.05, 10.05), 5.0), None);
        // One time holds at any time.
        assert!(grid.at(place(63.05, 10.0), 1e9).is_some());
    }

    #[test]
    fn values_that_are_not_a_grid_are_refused_by_name() {
        let try_new = |times: &[f64], lats: &[f64], lons: &[f64], east: &[f32]| {
            let north = vec![0.0; east.len()];
            CurrentGrid::new(times.to_vec(), lats.to_vec(), lons.to_vec(), east, &north)
                .unwrap_err()
                .to_string()
        };
        let (lats, lons) = ([63.0, 63.1], [10.0, 10.1]);
        for (text, part) in [
            (try_new(&[], &lats, &lons, &[]), "times: there are 0"),
            (try_new(&[0.0, 0.0], &lats, &lons, &[0.0; 8]), "times: value 2"),
            (try_new(&[0.0], &[63.0, f64::NAN], &lons, &[0.0; 4]), "latitudes: value 2"),
            (try_new(&[0.0], &[63.0, 91.0], &lons, &[0.0; 4]), "±90°"),
            (try_new(&[0.0], &lats, &[0.0, 361.0], &[0.0; 4]), "round the globe once"),
            (try_new(&[0.0], &lats, &lons, &[0.0; 3]), "need 4"),
            (try_new(&[0.0], &lats, &lons, &[0.0, 0.0, 40.0, 0.0]), "value 3 is 40 m/s"),
        ] {
            assert!(text.contains(part), "{text}");
        }
    }
}
