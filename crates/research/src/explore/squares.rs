//! Where detections were, in squares.

use api::SummarySquare;

/// Squares along the longer side.
const ALONG: f64 = 60.0;
/// Squares are no smaller (m): as well as a boat knows where it is.
const LEAST_M: f64 = 5.0;
/// Metres in a degree of latitude, as a sphere of the Earth's mean radius has it; for squares that is near enough.
const M_PER_DEG: f64 = 111_195.0;

/// Degrees of longitude around the Earth, each of which is looked at by itself to find where nothing is.
const AROUND: usize = 360;

/// The bounds of places.
#[derive(Debug, Clone)]
pub(super) struct Bounds {
    south: f64,
    north: f64,
    /// For each degree of longitude, from -180 on, the western- and easternmost place in it.
    columns: Vec<Option<(f64, f64)>>,
}

/// A box (deg): `east` is more than 180 where it crosses the 180th meridian.
#[derive(Debug, Clone, Copy)]
struct Box {
    south: f64,
    west: f64,
    north: f64,
    east: f64,
}

impl Bounds {
    pub(super) fn new() -> Self {
        Self { south: f64::INFINITY, north: f64::NEG_INFINITY, columns: vec![None; AROUND] }
    }

    pub(super) fn add(&mut self, (lat, lon): (f64, f64)) {
        (self.south, self.north) = (self.south.min(lat), self.north.max(lat));
        // -180 to 180, which is the last column's.
        let column = ((lon + 180.0) as usize).min(AROUND - 1);
        let (west, east) = self.columns[column].unwrap_or((lon, lon));
        self.columns[column] = Some((west.min(lon), east.max(lon)));
    }

    /// The smallest box around them: it leaves out the widest stretch of longitude in which nothing is. `None` without places.
    fn around(&self) -> Option<Box> {
        let columns: Vec<(f64, f64)> = self.columns.iter().copied().flatten().collect();
        let (first, last) = (columns.first()?, columns.last()?);
        let (mut west, mut east, mut widest) = (first.0, last.1, first.0 + 360.0 - last.1);
        for pair in columns.windows(2) {
            let gap = pair[1].0 - pair[0].1;
            if gap > widest {
                (west, east, widest) = (pair[1].0, pair[0].1 + 360.0, gap);
            }
        }
        Some(Box { south: self.south, west, north: self.north, east })
    }
}

/// Squares of one size over all places: at most 61 by 61.
pub(super) struct Squares {
    south: f64,
    west: f64,
    side_m: f64,
    m_per_deg_lon: f64,
    rows: usize,
    columns: usize,
    /// Detections, and the sums of their degrees beyond the south-western corner.
    all: Vec<(u64, f64, f64)>,
}

impl Squares {
    pub(super) fn new(bounds: &Bounds) -> Self {
        let Some(bounds) = bounds.around() else {
            let (south, west, m_per_deg_lon) = (0.0, 0.0, M_PER_DEG);
            return Self {
                south,
                west,
                side_m: LEAST_M,
                m_per_deg_lon,
                rows: 0,
                columns: 0,
                all: Vec::new(),
            };
        };
        let Box { south, west, north, east } = bounds;
        let middle = f64::midpoint(south, north).to_radians();
        let m_per_deg_lon = (M_PER_DEG * middle.cos()).max(1.0);
        let (up_m, right_m) = ((north - south) * M_PER_DEG, (east - west) * m_per_deg_lon);
        let side_m = (up_m.max(right_m) / ALONG).max(LEAST_M);
        let count = |length_m: f64| (length_m / side_m) as usize + 1;
        let (rows, columns) = (count(up_m), count(right_m));
        Self { south, west, side_m, m_per_deg_lon, rows, columns, all: vec![(0, 0.0, 0.0); rows * columns] }
    }

    /// A place that the bounds were made of.
    pub(super) fn add(&mut self, (lat, lon): (f64, f64)) {
        let (up, east) = (lat - self.south, lon - self.west);
        let right = if east < 0.0 { east + 360.0 } else { east };
        // The easternmost place lies on an edge between two squares where the longer side is 60 of them long, and a longitude beyond the
        // 180th meridian is rounded in another way than the bounds were: a place that comes out beyond the last square is one of it,
        // not of the next row.
        let row = ((up * M_PER_DEG / self.side_m) as usize).min(self.rows.saturating_sub(1));
        let column =
            ((right * self.m_per_deg_lon / self.side_m) as usize).min(self.columns.saturating_sub(1));
        if let Some((count, ups, rights)) = self.all.get_mut(row * self.columns + column) {
            (*count, *ups, *rights) = (*count + 1, *ups + up, *rights + right);
        }
    }

    /// Those with detections, and their side (m).
    pub(super) fn told(&self) -> (Vec<SummarySquare>, f64) {
        let square = |&(detections, up, right): &(u64, f64, f64)| {
            let lon_deg = self.west + right / detections as f64;
            SummarySquare {
                lat_deg: self.south + up / detections as f64,
                lon_deg: if lon_deg > 180.0 { lon_deg - 360.0 } else { lon_deg },
                detections,
            }
        };
        (self.all.iter().filter(|(count, ..)| *count > 0).map(square).collect(), self.side_m)
    }
}
