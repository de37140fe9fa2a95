//! What must hold for any bytes that claim to be lakes with depths. The fuzz target calls this with bytes of its own
//! making, and `make test` with the committed seeds and everything that was ever found.

use chartdb::{ChartDb, ImportOptions, import, load_index};
use charts::depth_index::Demand;
use rusqlite::Connection;
use std::fs;
use std::path::{Path, PathBuf};
use units::{LatLon, UtcTime};

/// In what the bytes come.
pub(crate) const SHAPEFILE: u8 = 0;
pub(crate) const GEOPACKAGE: u8 = 1;

/// The first byte tells whether a shapefile follows, its length in two bytes before it and its table of depths after
/// it, or the geometry of a row of a GeoPackage. They are imported into a set of their own or refused in words; what
/// is imported can be read and asked, and no data is never navigable.
pub(crate) fn lakes(data: &[u8]) {
    let Some((kind, data)) = data.split_first() else { return };
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
    let folder = folder.expect("a scratch folder");
    let lakes = match kind % 2 {
        SHAPEFILE => shapefile(folder.path(), data),
        _ => Some(geopackage(folder.path(), data)),
    };
    let Some(lakes) = lakes else { return };
    let db = folder.path().join("set/chart.gpkg");
    let depth_column = Some("depth".to_owned());
    let options =
        ImportOptions { epsg: Some(4326), depth_column, ..ImportOptions::new(UtcTime::from_micros(0)) };
    let report = import(&db, &[lakes], &options, &mut |_| true).expect("the disk is well");
    if !report.applied {
        assert!(!db.exists(), "nothing is half imported");
        return assert!(report.failures[0].error.to_string().contains("lakes."), "{report:?}");
    }
    let set = ChartDb::open(&db).expect("it was written");
    let charts = set.charts().expect("it was written");
    let features = set.features(&charts[0]).expect("it was written");
    assert_eq!(features.len() as u64, report.charts[0].features);
    let index = load_index(&db).expect("it was written").sealed.index;
    let demand = Demand::least_depth(1.0);
    let places = features.iter().filter_map(|feature| feature.geometry.points().next()?.place());
    let elsewhere = LatLon::from_deg(-48.9, -123.4).expect("in range");
    for place in places.take(3).chain([elsewhere]) {
        let answer = index.depth_at(place, &demand);
        assert!(!answer.navigable || answer.water.least_m().is_some_and(|least_m| least_m >= 1.0));
    }
}

fn shapefile(folder: &Path, data: &[u8]) -> Option<PathBuf> {
    let [low, high, data @ ..] = data else { return None };
    let (shapes, table) = data.split_at(usize::from(u16::from_le_bytes([*low, *high])).min(data.len()));
    let path = folder.join("lakes.shp");
    fs::write(&path, shapes).expect("room");
    fs::write(folder.join("lakes.dbf"), table).expect("room");
    Some(path)
}

fn geopackage(folder: &Path, geometry: &[u8]) -> PathBuf {
    let path = folder.join("lakes.gpkg");
    let db = Connection::open(&path).expect("room");
    db.execute_batch(
        "PRAGMA synchronous = off;
         CREATE TABLE gpkg_spatial_ref_sys (srs_id INTEGER PRIMARY KEY, organization_coordsys_id INTEGER);
         INSERT INTO gpkg_spatial_ref_sys VALUES (4326, 4326);
         CREATE TABLE gpkg_geometry_columns (table_name, column_name, geometry_type_name, srs_id);
         INSERT INTO gpkg_geometry_columns VALUES ('lakes', 'geom', 'MULTIPOLYGON', 4326);
         CREATE TABLE lakes (geom BLOB, depth REAL);",
    )
    .expect("room");
    db.execute("INSERT INTO lakes VALUES (?, 4.5)", [geometry]).expect("room");
    path
}
