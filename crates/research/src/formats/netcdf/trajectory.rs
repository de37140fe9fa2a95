//! The track of one vessel as a trajectory of NetCDF.

use super::super::about::iso;
use super::classic::{Attribute, Classic, Kind, Over, Variable};
use super::{common, coordinates, crs, extent, seconds};
use api::TrackPoint;

/// Whose track it is.
#[derive(Debug, Clone, Copy)]
pub struct TrackOf<'t> {
    /// What people call the vessel.
    pub vessel: &'t str,
    /// Positions in order of time.
    pub points: &'t [TrackPoint],
    /// Time between two of them where nothing is missing, µs.
    pub step_us: i64,
}

/// The file: time, latitude and longitude of each position.
pub fn write_track(of: &TrackOf<'_>) -> Vec<u8> {
    let TrackOf { vessel, points, step_us } = *of;
    let times = || points.iter().map(|point| point.time_us);
    let (first, last) = (times().min(), times().max());
    let mut attributes = common("trajectory");
    attributes.extend([
        ("title", Attribute::Text(format!("Track of {vessel}"))),
        ("summary", "Positions of an uncrewed surface vessel as it estimated them aboard; no positions are made up in between.".into()),
        ("keywords", "vessel track, uncrewed surface vehicle".into()),
        ("source", "navigation of an uncrewed surface vessel: satellite positioning and heading".into()),
        ("processing_level", "as estimated aboard, thinned to about one position in time_coverage_resolution".into()),
        ("time_coverage_resolution", Attribute::Text(format!("PT{}S", seconds(step_us)))),
    ]);
    attributes.extend(last.map(|last| ("date_created", Attribute::Text(iso(last)))));
    attributes.extend(extent(around(points), first, last));
    let file = Classic {
        records: ("obs", u32::try_from(points.len()).unwrap_or(u32::MAX)),
        attributes,
        variables: [name(vessel), crs()]
            .into_iter()
            .chain(coordinates("when the vessel was there, by its clock"))
            .collect(),
    };
    let mut out = Vec::new();
    // Writing to memory does not fail.
    file.write(&mut out).ok();
    for point in points {
        for value in [seconds(point.time_us), point.lat_deg, point.lon_deg] {
            out.extend_from_slice(&value.to_be_bytes());
        }
    }
    out
}

/// The name of the trajectory: there is one, so it needs no dimension.
fn name(vessel: &str) -> Variable {
    let values = if vessel.is_empty() { b"vessel".to_vec() } else { vessel.as_bytes().to_vec() };
    let attributes = vec![
        ("cf_role", "trajectory_id".into()),
        ("long_name", "name of the vessel".into()),
        ("_Encoding", "utf-8".into()),
    ];
    let kind = Kind::Text(values.len() as u32);
    Variable { name: "trajectory".to_owned(), kind, over: Over::Nothing, attributes, values }
}

/// South, west, north, east, degrees.
fn around(points: &[TrackPoint]) -> Option<[f64; 4]> {
    let lats = || points.iter().map(|point| point.lat_deg);
    let lons = || points.iter().map(|point| point.lon_deg);
    let (south, north) = (lats().min_by(f64::total_cmp)?, lats().max_by(f64::total_cmp)?);
    Some([south, lons().min_by(f64::total_cmp)?, north, lons().max_by(f64::total_cmp)?])
}
