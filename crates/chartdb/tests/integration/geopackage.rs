//! The set as other programs see it: by the rules of the OGC GeoPackage, and by GDAL where it is installed.

use crate::support::import;
use rusqlite::Connection;
use std::path::{Path, PathBuf};
use std::process::Command;

const LAYERS: [&str; 6] = ["skin", "areas", "lines", "points", "soundings", "points_of_interest"];
/// West, south, east, north of a part of the archipelago (degrees).
const PART: [f64; 4] = [10.33, 63.44, 10.37, 63.455];

/// A set of the fictitious archipelago.
fn set(folder: &Path) -> PathBuf {
    let cells = folder.join("cells");
    std::fs::create_dir(&cells).unwrap();
    for file in charts::demo::archipelago().unwrap() {
        std::fs::write(cells.join(file.name), file.bytes).unwrap();
    }
    let db = folder.join("chart.gpkg");
    assert!(import(&db, &[cells]).applied);
    db
}

fn number<T: rusqlite::types::FromSql>(connection: &Connection, text: &str) -> T {
    connection.query_row(text, [], |row| row.get(0)).unwrap_or_else(|error| panic!("{text}: {error}"))
}

#[test]
fn extents_and_extensions_are_what_they_say() {
    let folder = tempfile::tempdir().unwrap();
    let db = Connection::open(set(folder.path())).unwrap();
    for layer in LAYERS {
        // An R-tree holds numbers of 32 bits, rounded outwards: half a metre here.
        let apart = format!(
            "SELECT max(abs(c.min_x - r.w), abs(c.min_y - r.s), abs(c.max_x - r.e), abs(c.max_y - r.n)) \
             FROM gpkg_contents c, (SELECT min(minx) w, min(miny) s, max(maxx) e, max(maxy) n \
             FROM rtree_{layer}_geom) r WHERE table_name = '{layer}'"
        );
        let apart: f64 = number(&db, &apart);
        assert!(apart < 1e-5, "{layer}: the extent is off by {apart} degrees");
        let extension = format!(
            "SELECT count(*) FROM gpkg_extensions WHERE table_name = '{layer}' AND column_name = 'geom' \
             AND extension_name = 'gpkg_rtree_index' AND scope = 'write-only' AND definition LIKE 'http%'"
        );
        assert_eq!(number::<i64>(&db, &extension), 1, "{layer}");
    }
    // Every table is described, but those that the description and the R-trees consist of.
    let strange = "SELECT group_concat(name) FROM sqlite_master WHERE type = 'table' AND name NOT LIKE 'gpkg_%' \
                   AND name NOT LIKE 'rtree_%' AND name NOT LIKE 'sqlite_%' \
                   AND name NOT IN (SELECT table_name FROM gpkg_contents)";
    assert_eq!(number::<Option<String>>(&db, strange), None);
    let kinds = "SELECT group_concat(DISTINCT data_type) FROM gpkg_contents";
    assert_eq!(number::<String>(&db, kinds), "features,attributes");
    let dated = "SELECT count(*) FROM gpkg_contents WHERE last_change NOT GLOB '????-??-??T??:??:??*Z'";
    assert_eq!(number::<i64>(&db, dated), 0);
}

/// What GDAL's `ogrinfo` says of a layer, within a box where one is given; `None` without GDAL.
fn ogrinfo(db: &Path, layer: &str, within: Option<[f64; 4]>) -> Option<String> {
    let mut command = Command::new("ogrinfo");
    command.args(["-ro", "-so"]);
    if let Some(within) = within {
        command.arg("-spat").args(within.map(|side| side.to_string()));
    }
    let output = command.arg(db).arg(layer).output().ok()?;
    let complaint = String::from_utf8_lossy(&output.stderr).into_owned();
    assert!(output.status.success() && complaint.is_empty(), "{complaint}");
    Some(String::from_utf8(output.stdout).unwrap())
}

fn count(told: &str) -> i64 {
    let line = told.lines().find_map(|line| line.strip_prefix("Feature Count: "));
    line.unwrap_or_else(|| panic!("{told}")).parse().unwrap()
}

#[test]
fn gdal_counts_the_same_knows_where_it_is_and_looks_by_the_r_tree() {
    let folder = tempfile::tempdir().unwrap();
    let path = set(folder.path());
    let db = Connection::open(&path).unwrap();
    let [west, south, east, north] = PART;
    for layer in LAYERS {
        let Some(told) = ogrinfo(&path, layer, None) else {
            return testkit::absent(testkit::Need::Gdal, "apt-get install gdal-bin");
        };
        assert_eq!(count(&told), number::<i64>(&db, &format!("SELECT count(*) FROM {layer}")), "{layer}");
        assert!(told.contains("WGS 84") && told.contains("ID[\"EPSG\",4326]"), "{told}");
        assert!(told.contains("FID Column = fid") && told.contains("Geometry Column = geom"), "{told}");
        let (extent, sides) =
            ("Extent: (", "SELECT printf('%.6f', min_x) FROM gpkg_contents WHERE table_name =");
        let least: String = number(&db, &format!("{sides} '{layer}'"));
        assert!(told.contains(&format!("{extent}{least}")), "{least}: {told}");
    }
    let inside = format!(
        "FROM rtree_soundings_geom WHERE maxx >= {west} AND minx <= {east} AND maxy >= {south} AND miny <= {north}"
    );
    let expected: i64 = number(&db, &format!("SELECT count(*) {inside}"));
    let all: i64 = number(&db, "SELECT count(*) FROM soundings");
    let seen = || count(&ogrinfo(&path, "soundings", Some(PART)).unwrap());
    assert!(expected > 10 && expected < all, "{expected} of {all}");
    assert_eq!(seen(), expected);
    // What is taken out of the R-tree alone is no longer found: it is looked at, not every feature.
    db.execute(&format!("DELETE FROM rtree_soundings_geom WHERE id = (SELECT min(id) {inside})"), [])
        .unwrap();
    assert_eq!(seen(), expected - 1);
    assert_eq!(count(&ogrinfo(&path, "soundings", None).unwrap()), all);
}
