//! Where detections were, in squares.

use api::SummarySquare;

/// Squares along the longer side.
const ALONG: f64 = 60.0;
/// Squares are no smaller (m): as well as a boat knows where it is.
const LEAST_M: f64 = 5.0;
/// Metres in a degree of latitude, as a sphere of the Earth's mean radius has it; for squares that is near enough.
const M_PER_DEG: f64 = 111_195.0;

/// The bounds of places (deg).
#[derive(Debug, Clone, Copy)]
pub(super) struct Bounds {
    south: f64,
    west: f64,
    north: f64,
    east: f64,
}

impl Bounds {
    pub(super) const NONE: Self =
        Self { south: f64::INFINITY, west: f64::INFINITY, north: f64::NEG_INFINITY, east: f64::NEG_INFINITY };

    pub(super) fn add(&mut self, (lat, lon): (f64, f64)) {
        (self.south, self.north) = (self.south.min(lat), self.north.max(lat));
        (self.west, self.east) = (self.west.min(lon), self.east.max(lon));
    }
}

/// Squares of one size over all places: at most 61 by 61.
pub(super) struct Squares {
    bounds: Bounds,
    side_m: f64,
    m_per_deg_lon: f64,
    columns: usize,
    /// Detections, and the sums of their degrees beyond the south-western corner.
    all: Vec<(u64, f64, f64)>,
}

impl Squares {
    pub(super) fn new(bounds: Bounds) -> Self {
        if bounds.south > bounds.north {
            return Self { bounds, side_m: LEAST_M, m_per_deg_lon: M_PER_DEG, columns: 0, all: Vec::new() };
        }
        let middle = f64::midpoint(bounds.south, bounds.north).to_radians();
        let m_per_deg_lon = (M_PER_DEG * middle.cos()).max(1.0);
        let (up_m, right_m) =
            ((bounds.north - bounds.south) * M_PER_DEG, (bounds.east - bounds.west) * m_per_deg_lon);
        let side_m = (up_m.max(right_m) / ALONG).max(LEAST_M);
        let count = |length_m: f64| (length_m / side_m) as usize + 1;
        let columns = count(right_m);
        let all = vec![(0, 0.0, 0.0); columns * count(up_m)];
        Self { bounds, side_m, m_per_deg_lon, columns, all }
    }

    /// A place within the bounds.
    pub(super) fn add(&mut self, (lat, lon): (f64, f64)) {
        let (up, right) = (lat - self.bounds.south, lon - self.bounds.west);
        let row = (up * M_PER_DEG / self.side_m) as usize;
        let column = (right * self.m_per_deg_lon / self.side_m) as usize;
        if let Some((count, ups, rights)) = self.all.get_mut(row * self.columns + column) {
            (*count, *ups, *rights) = (*count + 1, *ups + up, *rights + right);
        }
    }

    /// Those with detections, and their side (m).
    pub(super) fn told(&self) -> (Vec<SummarySquare>, f64) {
        let square = |&(detections, up, right): &(u64, f64, f64)| SummarySquare {
            lat_deg: self.bounds.south + up / detections as f64,
            lon_deg: self.bounds.west + right / detections as f64,
            detections,
        };
        (self.all.iter().filter(|(count, ..)| *count > 0).map(square).collect(), self.side_m)
    }
}
