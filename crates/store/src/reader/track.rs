//! Where a system went.

use super::{Reader, Source};
use crate::error::Result;
use crate::history::ESTIMATED_STATE;
use crate::range::TimeRange;
use imc::Address;
use units::{LatLon, LocalFrame, UtcTime};

/// A place and when the system was there.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct TrackPoint {
    /// Time of the position.
    pub time: UtcTime,
    /// Where: the reference point of `EstimatedState` displaced by its offset.
    pub place: LatLon,
}

/// A way through the water, in order of time.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Track {
    /// Positions as they were estimated; no positions are made up in between.
    pub points: Vec<TrackPoint>,
    /// Time that can lie between two positions looked at, however far the system went in it (µs).
    pub step_us: i64,
}

impl Reader {
    /// A system's track from at most about `max_points` of its positions, without those that lie within
    /// `tolerance_m` of the line between others; a tolerance of 0 keeps all, also of a system that lies still.
    ///
    /// When several entities estimate the state, the one that did it most often is taken.
    ///
    /// # Errors
    /// When the history cannot be read.
    pub fn track(
        &mut self,
        system: Address,
        range: TimeRange,
        max_points: usize,
        tolerance_m: f64,
    ) -> Result<Track> {
        self.track_while(system, (range, max_points), tolerance_m, &mut || Ok(()))
    }

    /// As [`Self::track`]; before each month that is read `goes_on` is asked, whose error ends it.
    ///
    /// # Errors
    /// That of `goes_on`, or when the history cannot be read.
    pub fn track_while(
        &mut self,
        system: Address,
        (range, max_points): (TimeRange, usize),
        tolerance_m: f64,
        goes_on: &mut dyn FnMut() -> Result<()>,
    ) -> Result<Track> {
        let extents = self.extents()?;
        let estimates =
            extents.iter().filter(|(group, _)| group.id == ESTIMATED_STATE && group.src == system.0);
        let Some((group, _)) = estimates.max_by_key(|(_, extent)| extent.count) else {
            return Ok(Track::default());
        };
        // Positions are thinned by the width of the range: time from which nothing is recorded must not widen it.
        let range = self.recorded(*group, range)?;
        if range.is_empty() {
            return Ok(Track::default());
        }
        let source = Source { system, entity: group.src_ent, message: "EstimatedState".to_owned() };
        let [lat_deg, lon_deg] = tables::TRUE_POSITION;
        let (grid, lat) = self.cells_while(&source, lat_deg, (range, max_points), goes_on)?;
        let (_, lon) = self.cells_while(&source, lon_deg, (range, max_points), goes_on)?;
        let point = |(lat, lon): (Option<_>, Option<_>)| {
            let (lat, lon): (crate::history::rollup::Cell, crate::history::rollup::Cell) = (lat?, lon?);
            let place = LatLon::from_deg(lat.first, lon.first).ok()?;
            // Both were written by one message or neither was.
            (lat.first_us == lon.first_us)
                .then_some(TrackPoint { time: UtcTime::from_micros(lat.first_us), place })
        };
        let points: Vec<TrackPoint> = lat.into_iter().zip(lon).filter_map(point).collect();
        Ok(Track { points: simplified(&points, tolerance_m), step_us: grid.width_us })
    }
}

/// The points that matter: D. Douglas and T. Peucker, "Algorithms for the reduction of the number of points
/// required to represent a digitized line or its caricature" (1973).
fn simplified(points: &[TrackPoint], tolerance_m: f64) -> Vec<TrackPoint> {
    let (Some(first), Some(last)) = (points.first(), points.last()) else { return Vec::new() };
    // A position on the line between two others still says when the system was there.
    if points.len() < 3 || tolerance_m <= 0.0 {
        return points.to_vec();
    }
    let frame = LocalFrame::new(first.place);
    let places: Vec<(f64, f64)> = points
        .iter()
        .map(|point| {
            let at = frame.to_local(point.place);
            (at.north_m, at.east_m)
        })
        .collect();
    let mut kept = vec![false; points.len()];
    (kept[0], kept[points.len() - 1]) = (true, true);
    let mut open = vec![(0, points.len() - 1)];
    while let Some((from, to)) = open.pop() {
        let far = (from + 1..to)
            .map(|at| (at, distance_m(places[at], places[from], places[to])))
            .max_by(|a, b| a.1.total_cmp(&b.1));
        if let Some((at, _)) = far.filter(|(_, distance)| *distance > tolerance_m) {
            kept[at] = true;
            open.extend([(from, at), (at, to)]);
        }
    }
    debug_assert!(first.time <= last.time, "positions come in order of time");
    points.iter().zip(kept).filter(|(_, kept)| *kept).map(|(point, _)| *point).collect()
}

/// From a point to a line between two others.
fn distance_m(point: (f64, f64), from: (f64, f64), to: (f64, f64)) -> f64 {
    let (along, across) = (to.0 - from.0, to.1 - from.1);
    let squared = along * along + across * across;
    let (north, east) = (point.0 - from.0, point.1 - from.1);
    let part = if squared > 0.0 { ((north * along + east * across) / squared).clamp(0.0, 1.0) } else { 0.0 };
    (north - part * along).hypot(east - part * across)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_on_a_line_go_and_corners_stay() {
        let at = |north: f64, east: f64, second: i64| TrackPoint {
            time: UtcTime::from_micros(second * 1_000_000),
            place: LatLon::from_deg(63.44 + north / 111_500.0, 10.35 + east / 49_900.0).unwrap(),
        };
        let mut points: Vec<TrackPoint> =
            (0..=100).map(|step| at(f64::from(step), 0.0, step.into())).collect();
        points.extend((1..=50).map(|step| at(100.0, f64::from(step), 100 + i64::from(step))));
        let kept = simplified(&points, 0.5);
        let seconds: Vec<i64> = kept.iter().map(|point| point.time.micros() / 1_000_000).collect();
        assert_eq!(seconds, [0, 100, 150]);
        assert_eq!(simplified(&points, 0.0), points);
    }
}
