//! NetCDF for oceanographers: detections as points (CF-1.10, discrete sampling geometries) and the track of a vessel as a trajectory, with the
//! attributes of ACDD-1.3.
//!
//! The format is the classic one with offsets of 64 bits, which every NetCDF library reads.

mod classic;
mod points;
mod trajectory;

pub(super) use points::{FORMAT, Points};
pub use trajectory::{TrackOf, write_track};

use classic::{Attribute, Attributes, Kind, Over, Variable};

/// The figure of the earth that all places are of.
const CRS: &str = "crs";

/// The scalar that says so.
fn crs() -> Variable {
    let attributes = vec![
        ("grid_mapping_name", "latitude_longitude".into()),
        ("long_name", "WGS 84".into()),
        ("semi_major_axis", Attribute::Double(6_378_137.0)),
        ("inverse_flattening", Attribute::Double(298.257_223_563)),
        ("epsg_code", "EPSG:4326".into()),
    ];
    let values = vec![0; 4];
    Variable { name: CRS.to_owned(), kind: Kind::Int, over: Over::Nothing, attributes, values }
}

/// A coordinate of records: latitude, longitude or time.
fn coordinate(name: &str, axis: &str, long_name: &str, units: &str) -> Variable {
    let mut attributes = vec![
        ("standard_name", Attribute::from(name)),
        ("long_name", long_name.into()),
        ("units", units.into()),
        ("axis", axis.into()),
    ];
    if name == "time" {
        attributes.push(("calendar", "standard".into()));
    }
    Variable {
        name: name.to_owned(),
        kind: Kind::Double,
        over: Over::Records,
        attributes,
        values: Vec::new(),
    }
}

/// Seconds since then are the times of all files.
const SINCE: &str = "seconds since 1970-01-01T00:00:00Z";

/// Time, latitude and longitude.
fn coordinates(of: &str) -> [Variable; 3] {
    [
        coordinate("time", "T", of, SINCE),
        coordinate("latitude", "Y", "WGS 84 latitude of the vessel at that time", "degrees_north"),
        coordinate("longitude", "X", "WGS 84 longitude of the vessel at that time", "degrees_east"),
    ]
}

/// Seconds since 1970; a double tells microseconds until the year 2250.
fn seconds(time_us: i64) -> f64 {
    time_us as f64 / 1e6
}

/// What is said of every file.
fn common(kind: &str) -> Attributes {
    vec![
        ("Conventions", "CF-1.10, ACDD-1.3".into()),
        ("featureType", kind.into()),
        ("cdm_data_type", if kind == "point" { "Point".into() } else { "Trajectory".into() }),
        ("standard_name_vocabulary", "CF Standard Name Table v79".into()),
        ("history", Attribute::Text(format!("written by {} from its archive", crate::SOFTWARE))),
    ]
}

/// Where and when a file reaches.
fn extent(box_deg: Option<[f64; 4]>, first_us: Option<i64>, last_us: Option<i64>) -> Attributes {
    let mut all = Attributes::new();
    if let Some([south, west, north, east]) = box_deg {
        all.extend([
            ("geospatial_lat_min", Attribute::Double(south)),
            ("geospatial_lat_max", Attribute::Double(north)),
            ("geospatial_lon_min", Attribute::Double(west)),
            ("geospatial_lon_max", Attribute::Double(east)),
            ("geospatial_lat_units", "degrees_north".into()),
            ("geospatial_lon_units", "degrees_east".into()),
            ("geospatial_bounds_crs", "EPSG:4326".into()),
        ]);
    }
    if let (Some(first), Some(last)) = (first_us, last_us) {
        all.extend([
            ("time_coverage_start", Attribute::Text(super::about::iso(first))),
            ("time_coverage_end", Attribute::Text(super::about::iso(last))),
            (
                "time_coverage_duration",
                Attribute::Text(format!("PT{}S", seconds(last.saturating_sub(first)))),
            ),
        ]);
    }
    all
}

#[cfg(test)]
mod tests;
