//! Lakes with depths: polygons of shapefiles and GeoPackages, in degrees and in metres, with holes, bands on top
//! of each other and what no lake is.

use crate::support::options;
use chartdb::{ChartDb, ImportOptions, ImportReport, load_index};
use charts::depth_index::{Demand, Water};
use charts::utm::{Datum, Utm};
use rusqlite::{Connection, params};
use shapefile::dbase::{FieldValue, Record, TableWriterBuilder};
use shapefile::{Point, Polygon, PolygonRing};
use std::path::Path;
use units::LatLon;

/// West, south, east, north (degrees).
type Box = [f64; 4];

const LAKE: Box = [9.0, 60.0, 9.1, 60.1];
const DEEP: Box = [9.02, 60.02, 9.08, 60.08];
const ISLAND: Box = [9.04, 60.04, 9.05, 60.05];

/// Corners of a box, clockwise, the first again at the end.
fn ring([west, south, east, north]: Box) -> Vec<(f64, f64)> {
    vec![(west, south), (west, north), (east, north), (east, south), (west, south)]
}

fn holding(depth_column: &str) -> ImportOptions {
    ImportOptions {
        depth_column: Some(depth_column.to_owned()),
        deepest_column: Some("deepest".to_owned()),
        ..options()
    }
}

fn bring(db: &Path, file: &Path, options: &ImportOptions) -> ImportReport {
    chartdb::import(db, &[file.to_owned()], options, &mut |_| true).unwrap()
}

fn told(report: &ImportReport) -> String {
    report.failures.iter().map(|failure| failure.error.to_string()).collect::<Vec<_>>().join("\n")
}

/// What the set says of the places that matter.
fn shores(db: &Path) {
    let index = load_index(db).unwrap().sealed.index;
    let water = |lat, lon| index.depth_at(LatLon::from_deg(lat, lon).unwrap(), &Demand::default()).water;
    let deep = Water::Depth { least_m: 12.5, greatest_m: Some(31.0) };
    assert_eq!(water(60.07, 9.07), deep);
    assert_eq!(water(60.01, 9.05), Water::Depth { least_m: 1.5, greatest_m: Some(12.5) });
    assert_eq!(water(60.045, 9.045), Water::NoData, "an island is not charted as water");
    assert_eq!(water(60.05, 9.25), Water::UnknownDepth, "a lake without a depth");
    assert_eq!(water(60.5, 9.5), Water::NoData);
    let demand = Demand::least_depth(1.0);
    assert!(!index.depth_at(LatLon::from_deg(60.05, 9.25).unwrap(), &demand).navigable);
    // The borders are where they were drawn, to a centimetre.
    let island = index.distance_to_shallower(LatLon::from_deg(60.045, 9.0501).unwrap(), 5.0, 100.0).unwrap();
    let metres = 0.0001 * 111_320.0 * 60.045_f64.to_radians().cos();
    assert!((island.distance_m - metres).abs() < 0.05, "{island:?}");
}

/// A row of a table: outer ring, holes, least and greatest depth.
type Row = (Box, Vec<Box>, Option<f64>, Option<f64>);

fn rows() -> Vec<Row> {
    vec![
        (LAKE, vec![DEEP], Some(1.5), Some(12.5)),
        (DEEP, vec![ISLAND], Some(12.5), Some(31.0)),
        ([9.2, 60.0, 9.3, 60.1], Vec::new(), None, None),
    ]
}

fn shapefile(path: &Path, place: &dyn Fn(f64, f64) -> (f64, f64)) {
    let column = |name: &str| name.try_into().unwrap();
    let table = TableWriterBuilder::new().add_numeric_field(column("depth"), 10, 2).add_numeric_field(
        column("deepest"),
        10,
        2,
    );
    let mut writer = shapefile::Writer::from_path(path, table).unwrap();
    for (outer, holes, least, greatest) in rows() {
        let points = |corners: Box| -> Vec<Point> {
            let at = |(x, y)| {
                let (x, y) = place(x, y);
                Point::new(x, y)
            };
            ring(corners).into_iter().map(at).collect()
        };
        let inner = holes.into_iter().map(|hole| PolygonRing::Inner(points(hole)));
        let rings: Vec<_> = std::iter::once(PolygonRing::Outer(points(outer))).chain(inner).collect();
        let mut record = Record::default();
        record.insert("depth".to_owned(), FieldValue::Numeric(least));
        record.insert("deepest".to_owned(), FieldValue::Numeric(greatest));
        writer.write_shape_and_record(&Polygon::with_rings(rings), &record).unwrap();
    }
}

#[test]
fn a_shapefile_in_degrees_and_one_in_metres_say_the_same() {
    let folder = tempfile::tempdir().unwrap();
    let (degrees, metres) = (folder.path().join("lakes.shp"), folder.path().join("utm.shp"));
    shapefile(&degrees, &|x, y| (x, y));
    let utm = Utm::new(33, false, Datum::Etrs89).unwrap();
    shapefile(&metres, &|x, y| {
        let point = utm.to_utm(LatLon::from_deg(y, x).unwrap());
        (point.easting_m, point.northing_m)
    });
    for (file, epsg) in [(&degrees, 4326), (&metres, 25833)] {
        let db = folder.path().join(format!("{epsg}/chart.gpkg"));
        let report = bring(&db, file, &ImportOptions { epsg: Some(epsg), ..holding("depth") });
        assert!(report.applied && report.charts[0].features == 3, "{}", told(&report));
        assert_eq!(report.charts[0].kind, "lakes");
        shores(&db);
    }
    // Metres that are taken for degrees are reported as metres.
    let db = folder.path().join("wrong/chart.gpkg");
    let report = bring(&db, &metres, &ImportOptions { epsg: Some(4326), ..holding("depth") });
    assert!(
        report.charts[0].notices.iter().any(|text| text.contains("give the system by --epsg")),
        "{report:?}"
    );
    assert_eq!(ChartDb::open(&db).unwrap().charts().unwrap()[0].features, 0);
}

#[test]
fn land_of_a_mask_is_land_beside_a_lake_whatever_the_names() {
    for (lakes, mask) in [("a.shp", "b.geojson"), ("b.shp", "a.geojson")] {
        let folder = tempfile::tempdir().unwrap();
        let (lakes, mask) = (folder.path().join(lakes), folder.path().join(mask));
        shapefile(&lakes, &|x, y| (x, y));
        let land = r#"{"type":"Polygon","coordinates":[[[8.9,60.03],[9.3,60.03],[9.3,60.06],[8.9,60.03]]]}"#;
        std::fs::write(&mask, land).unwrap();
        let db = folder.path().join("set/chart.gpkg");
        let options = ImportOptions { epsg: Some(4326), ..holding("depth") };
        let report = chartdb::import(&db, &[lakes, mask], &options, &mut |_| true).unwrap();
        assert!(report.applied, "{}", told(&report));
        let index = load_index(&db).unwrap().sealed.index;
        let water = |lat, lon| index.depth_at(LatLon::from_deg(lat, lon).unwrap(), &Demand::default()).water;
        for (lat, lon) in [(60.035, 9.06), (60.031, 9.09), (60.035, 9.15), (60.035, 9.25)] {
            assert_eq!(water(lat, lon), Water::Land, "{lat} {lon}");
        }
        assert_eq!(water(60.07, 9.07).least_m(), Some(12.5));
        assert_eq!(water(60.01, 9.15), Water::NoData);
    }
}

#[test]
fn what_a_shapefile_does_not_say_is_asked_for() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("lakes.shp");
    shapefile(&file, &|x, y| (x, y));
    let db = folder.path().join("set/chart.gpkg");
    let says = |options: &ImportOptions, words: &str| {
        let report = bring(&db, &file, options);
        assert!(!report.applied && told(&report).contains(words), "{}", told(&report));
        assert!(!db.exists());
    };
    says(&holding("depth"), "it does not say its coordinate system; give it by --epsg");
    std::fs::write(folder.path().join("lakes.prj"), "PROJCS[\"NGO_1948\"]").unwrap();
    says(&holding("depth"), "its coordinate system is \"NGO_1948\"; give its EPSG code by --epsg");
    std::fs::write(folder.path().join("lakes.prj"), "GEOGCS[\"GCS_WGS_1984\",DATUM[\"D_WGS_1984\"]]")
        .unwrap();
    says(&options(), "--depth-column; there are: depth, deepest");
    says(&holding("dybde"), "there is no column dybde; there are: depth, deepest");
    std::fs::rename(folder.path().join("lakes.dbf"), folder.path().join("away.dbf")).unwrap();
    says(&holding("depth"), "it holds the depths");
    std::fs::rename(folder.path().join("away.dbf"), folder.path().join("lakes.dbf")).unwrap();
    let whole = std::fs::read(&file).unwrap();
    std::fs::write(&file, &whole[..whole.len() - 20]).unwrap();
    says(&holding("depth"), "lakes.shp");
    std::fs::write(&file, whole).unwrap();
    assert!(bring(&db, &file, &holding("depth")).applied);
    shores(&db);
}

/// The geometry of a GeoPackage: a multipolygon of one polygon, in little endian.
fn blob(rings: &[Vec<(f64, f64)>]) -> Vec<u8> {
    let mut bytes = b"GP\x00\x01\xE6\x10\x00\x00".to_vec();
    let number = |value: u32, bytes: &mut Vec<u8>| bytes.extend(value.to_le_bytes());
    bytes.push(1);
    number(6, &mut bytes);
    number(1, &mut bytes);
    bytes.push(1);
    number(3, &mut bytes);
    number(rings.len() as u32, &mut bytes);
    for ring in rings {
        number(ring.len() as u32, &mut bytes);
        for (x, y) in ring {
            bytes.extend(x.to_le_bytes());
            bytes.extend(y.to_le_bytes());
        }
    }
    bytes
}

/// A GeoPackage as another program writes it.
fn geopackage(path: &Path) -> Connection {
    let db = Connection::open(path).unwrap();
    db.execute_batch(
        "PRAGMA application_id = 0x47504B47;
         CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT, srs_id INTEGER PRIMARY KEY, organization TEXT,
           organization_coordsys_id INTEGER, definition TEXT, description TEXT);
         INSERT INTO gpkg_spatial_ref_sys VALUES ('WGS 84', 4326, 'EPSG', 4326, '', '');
         CREATE TABLE gpkg_geometry_columns (table_name TEXT, column_name TEXT, geometry_type_name TEXT,
           srs_id INTEGER, z INTEGER, m INTEGER);
         INSERT INTO gpkg_geometry_columns VALUES ('innsjø', 'shape', 'MULTIPOLYGON', 4326, 0, 0);
         INSERT INTO gpkg_geometry_columns VALUES ('places', 'geom', 'POINT', 4326, 0, 0);
         CREATE TABLE \"innsjø\" (id INTEGER PRIMARY KEY, shape BLOB, \"dybde, m\" REAL, deepest TEXT);",
    )
    .unwrap();
    let mut insert = db.prepare("INSERT INTO \"innsjø\" VALUES (NULL, ?, ?, ?)").unwrap();
    for (outer, holes, least, greatest) in rows() {
        let rings: Vec<_> = std::iter::once(outer).chain(holes).map(ring).collect();
        let text = greatest.map(|depth: f64| depth.to_string());
        insert.execute(params![blob(&rings), least, text]).unwrap();
    }
    drop(insert);
    db
}

#[test]
fn a_geopackage_of_lakes_says_its_system_and_its_table() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("lakes.gpkg");
    let made = geopackage(&file);
    let db = folder.path().join("set/chart.gpkg");
    let report = bring(&db, &file, &holding("dybde, m"));
    assert!(report.applied && report.charts[0].features == 3, "{}", told(&report));
    assert!(report.charts[0].notices[0].contains("polygon 3: it has no depth"), "{report:?}");
    shores(&db);
    // Changed, it replaces what was there.
    made.execute("UPDATE \"innsjø\" SET \"dybde, m\" = 0.4 WHERE id = 1", []).unwrap();
    assert!(bring(&db, &file, &holding("dybde, m")).applied);
    let index = load_index(&db).unwrap().sealed.index;
    let at = LatLon::from_deg(60.01, 9.05).unwrap();
    assert_eq!(index.depth_at(at, &Demand::default()).water.least_m(), Some(0.4));
    assert_eq!(ChartDb::open(&db).unwrap().charts().unwrap().len(), 1);
}

#[test]
fn what_is_no_lake_in_a_geopackage_is_told_and_never_water() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("lakes.gpkg");
    let made = geopackage(&file);
    let mut cut = blob(&[ring(LAKE)]);
    cut.truncate(cut.len() - 9);
    let mut endless = blob(&[ring(LAKE)]);
    // The number of its points.
    endless[26..30].copy_from_slice(&u32::MAX.to_le_bytes());
    let open = blob(&[ring(LAKE)[..4].to_vec()]);
    let far = blob(&[ring([900.0, 0.0, 901.0, 1.0])]);
    for bytes in [cut, endless, open, far, Vec::new()] {
        made.execute("INSERT INTO \"innsjø\" VALUES (NULL, ?, 50, NULL)", [bytes]).unwrap();
    }
    made.execute("INSERT INTO \"innsjø\" VALUES (NULL, NULL, 50, NULL)", []).unwrap();
    let db = folder.path().join("set/chart.gpkg");
    let report = bring(&db, &file, &holding("dybde, m"));
    assert!(report.applied && report.charts[0].features == 3, "{}", told(&report));
    let dropped: Vec<&String> =
        report.charts[0].notices.iter().filter(|text| text.contains("dropped")).collect();
    assert_eq!(dropped.len(), 6, "{dropped:?}");
    assert!(dropped[2].contains("polygon 6: dropped: a ring of it is not closed"), "{dropped:?}");
    shores(&db);
    let db = folder.path().join("none/chart.gpkg");
    let says = |options: &ImportOptions, words: &str| {
        let report = bring(&db, &file, options);
        assert!(!report.applied && told(&report).contains(words), "{}", told(&report));
        assert!(!db.exists());
    };
    says(
        &ImportOptions { layer: Some("sjø".to_owned()), ..holding("dybde, m") },
        "--layer; with polygons there are: innsjø",
    );
    made.execute("INSERT INTO gpkg_geometry_columns VALUES ('hav', 'geom', 'POLYGON', 4326, 0, 0)", [])
        .unwrap();
    says(&holding("dybde, m"), "with polygons there are: hav, innsjø");
    std::fs::write(&file, "no GeoPackage").unwrap();
    says(&holding("dybde, m"), "give a GeoPackage with polygons");
}
