//! Every shared cell with its updates goes into a chart set and comes out as it was.

use crate::support::{CELLS, cell, contents, import, options, put};
use chartdb::{ChartDb, Outcome, index_path, load_index};
use charts::depth_index::IndexBuilder;
use charts::s57::{Feature, Geometry};
use rusqlite::Connection;
use std::path::PathBuf;

/// A group of soundings without any is the same as none.
fn plain(mut feature: Feature) -> Feature {
    if matches!(&feature.geometry, Geometry::Soundings(list) if list.is_empty()) {
        feature.geometry = Geometry::None;
    }
    feature
}

#[test]
fn features_and_index_come_back_as_they_were() {
    let folder = tempfile::tempdir().unwrap();
    let mut inputs = Vec::new();
    for (name, updates) in CELLS {
        let Some(path) = put(folder.path(), name, updates) else { return };
        inputs.push(path);
    }
    let db = folder.path().join("set/chart.gpkg");
    let report = import(&db, &inputs);
    assert!(report.applied && report.failures.is_empty(), "{:?}", report.failures);
    assert!(report.charts.iter().all(|chart| chart.outcome == Outcome::Added && chart.notices.is_empty()));
    assert!(report.charts.iter().all(|chart| chart.skin.is_some_and(|check| check.holds())));

    let set = ChartDb::open(&db).unwrap();
    let charts = set.charts().unwrap();
    assert_eq!(charts.len(), CELLS.len());
    let mut builder = IndexBuilder::new();
    for (name, updates) in CELLS {
        let cell = cell(name, updates).unwrap();
        let chart = charts.iter().find(|chart| chart.name == name).unwrap();
        assert_eq!((&chart.edition, &chart.update), (&cell.id.edition, &cell.id.update));
        let features = set.features(chart).unwrap();
        assert_eq!(features.len(), cell.features.len(), "{name}");
        for (found, expected) in features.into_iter().zip(&cell.features) {
            assert_eq!(found, plain(expected.clone()), "{name}");
        }
        builder.add_cell(&cell).unwrap();
    }
    let loaded = load_index(&db).unwrap();
    assert_eq!(loaded.rebuilt, None);
    assert_eq!(loaded.sealed.digest, set.digest().unwrap());
    assert!(loaded.sealed.index == builder.build().unwrap(), "the index differs from that of the cells");

    compare_counts(&set, &Connection::open(&db).unwrap());

    // The index is a function of the database.
    let bytes = std::fs::read(index_path(&db)).unwrap();
    std::fs::write(index_path(&db), &bytes[..bytes.len() / 2]).unwrap();
    assert!(load_index(&db).unwrap().rebuilt.unwrap().contains("damaged"));
    assert_eq!(std::fs::read(index_path(&db)).unwrap(), bytes);

    // Again: nothing is read twice, nothing changes.
    let before = contents(db.parent().unwrap());
    let again = import(&db, &inputs);
    assert!(again.charts.iter().all(|chart| chart.outcome == Outcome::Unchanged));
    assert!(contents(db.parent().unwrap()) == before);
    assert_eq!(again.digest, report.digest);
}

/// Counts by class and soundings against those of GDAL, with all updates.
fn compare_counts(set: &ChartDb, connection: &Connection) {
    let path = testkit::shared("data/charts/expected.json").unwrap();
    let expected: serde_json::Value = serde_json::from_slice(&std::fs::read(path).unwrap()).unwrap();
    let mut compared = 0;
    for chart in set.charts().unwrap() {
        let key = match CELLS.iter().find(|(name, _)| *name == chart.name).unwrap() {
            (name, 0) => (*name).to_owned(),
            (name, updates) => format!("{name}+{updates}"),
        };
        let counts = set.counts(&chart).unwrap();
        for (class, values) in expected[&key]["classes"].as_object().unwrap() {
            assert_eq!(counts.get(class).copied().unwrap_or(0), values["count"], "{key} {class}");
            compared += 1;
            let Some(points) = values.get("points") else { continue };
            let all =
                "SELECT count(*), min(depth_m), max(depth_m), sum(depth_m) FROM soundings WHERE cell = ?1";
            let row = |row: &rusqlite::Row<'_>| Ok((row.get(0)?, [1, 2, 3].map(|at| row.get(at).unwrap())));
            let (count, depths): (i64, [f64; 3]) = connection.query_row(all, [&chart.name], row).unwrap();
            assert_eq!(count, points.as_i64().unwrap(), "{key}");
            for (found, listed) in depths.iter().zip(values["depth_min_max_sum"].as_array().unwrap()) {
                assert!((found - listed.as_f64().unwrap()).abs() < 1e-6, "{key}");
            }
        }
    }
    println!("{compared} counts compared");
    assert!(compared > 100, "{compared}");
}

#[test]
fn the_set_is_a_geopackage() {
    let folder = tempfile::tempdir().unwrap();
    let Some(input) = put(folder.path(), "US5WA22M", 4) else { return };
    let db = folder.path().join("chart.gpkg");
    assert!(import(&db, &[input]).applied);
    let connection = Connection::open(&db).unwrap();
    let number = |text: &str| connection.query_row(text, [], |row| row.get::<_, i64>(0)).unwrap();
    assert_eq!(number("PRAGMA application_id"), 0x4750_4B47);
    assert_eq!(number("PRAGMA user_version"), 10_300);
    assert_eq!(number("SELECT count(*) FROM gpkg_spatial_ref_sys WHERE srs_id IN (4326, -1, 0)"), 3);
    let text = |text: &str| connection.query_row(text, [], |row| row.get::<_, String>(0)).unwrap();
    assert_eq!((text("PRAGMA integrity_check"), text("PRAGMA journal_mode")), ("ok".into(), "delete".into()));
    assert_eq!(number("SELECT count(*) FROM pragma_foreign_key_check"), 0);
    for table in ["skin", "areas", "lines", "points", "soundings", "points_of_interest"] {
        let features = number(&format!("SELECT count(*) FROM {table} WHERE geom NOT NULL"));
        assert!(features > 0, "{table}");
        assert_eq!(number(&format!("SELECT count(*) FROM rtree_{table}_geom")), features, "{table}");
        let described = format!(
            "SELECT count(*) FROM gpkg_contents c JOIN gpkg_geometry_columns g USING (table_name) \
             JOIN gpkg_extensions e USING (table_name) WHERE table_name = '{table}' AND c.srs_id = 4326 \
             AND data_type = 'features' AND extension_name = 'gpkg_rtree_index' AND min_x BETWEEN -123 AND -122 \
             AND max_y BETWEEN 47 AND 48"
        );
        assert_eq!(number(&described), 1, "{table}");
        let triggers = format!(
            "SELECT count(*) FROM sqlite_master WHERE type = 'trigger' AND name LIKE 'rtree_{table}_geom_%'"
        );
        assert_eq!(number(&triggers), 6, "{table}");
        let magic = format!("SELECT count(*) FROM {table} WHERE substr(geom, 1, 8) != x'47500003E6100000'");
        assert_eq!(number(&magic), 0, "{table}");
    }
    // 20 wrecks of the census, with what is known of their depths.
    assert_eq!(number("SELECT count(*) FROM points_of_interest WHERE class = 'WRECKS'"), 20);
    assert_eq!(
        number("SELECT count(*) FROM points_of_interest WHERE class = 'OBSTRN' AND depth_m NOT NULL"),
        18
    );
    let near = "SELECT count(*) FROM points_of_interest JOIN rtree_points_of_interest_geom r ON r.id = fid \
                WHERE maxx >= -122.45 AND minx <= -122.40 AND maxy >= 47.26 AND miny <= 47.30";
    assert!(number(near) > 0);
    assert_eq!(number("SELECT skin_holds FROM cells"), 1);
    assert_eq!(number("SELECT count(*) FROM coverage WHERE covered = 1"), 1);
}

#[test]
fn an_edit_makes_another_set_and_another_index() {
    let folder = tempfile::tempdir().unwrap();
    let Some(input) = put(folder.path(), "GB5X02SE", 0) else { return };
    let db = folder.path().join("chart.gpkg");
    import(&db, std::slice::from_ref(&input));
    let before = ChartDb::open(&db).unwrap().digest().unwrap();
    let connection = Connection::open(&db).unwrap();
    // An editing program has the functions that these call; this one has not.
    for name in ["insert", "update1", "update2", "update3", "update4", "delete"] {
        connection.execute_batch(&format!("DROP TRIGGER rtree_skin_geom_{name}")).unwrap();
    }
    connection
        .execute("UPDATE skin SET attributes = '{\"DRVAL1\":\"1\"}' WHERE class = 'DEPARE'", [])
        .unwrap();
    drop(connection);
    assert_ne!(ChartDb::open(&db).unwrap().digest().unwrap(), before);
    assert!(load_index(&db).unwrap().rebuilt.unwrap().contains("another state"));
    assert_eq!(load_index(&db).unwrap().rebuilt, None);
}

#[test]
fn a_removed_cell_leaves_nothing_behind() {
    let folder = tempfile::tempdir().unwrap();
    let inputs: Option<Vec<PathBuf>> =
        ["GB5X01NE", "GB5X01NW"].iter().map(|name| put(folder.path(), name, 0)).collect();
    let Some(inputs) = inputs else { return };
    let db = folder.path().join("chart.gpkg");
    import(&db, &inputs[..1]);
    let alone = ChartDb::open(&db).unwrap().digest().unwrap();
    import(&db, &inputs[1..]);
    let error = chartdb::remove(&db, &["GB5X09XX".to_owned()], options().now).unwrap_err().to_string();
    assert!(error.contains("no GB5X09XX; it holds GB5X01NE, GB5X01NW"), "{error}");
    chartdb::remove(&db, &["GB5X01NW".to_owned()], options().now).unwrap();
    assert_eq!(ChartDb::open(&db).unwrap().digest().unwrap(), alone);
    let connection = Connection::open(&db).unwrap();
    for table in ["skin", "areas", "lines", "points", "objects", "soundings", "points_of_interest"] {
        let text = format!("SELECT count(*) FROM {table} WHERE cell = 'GB5X01NW'");
        assert_eq!(connection.query_row(&text, [], |row| row.get::<_, i64>(0)).unwrap(), 0, "{table}");
    }
    assert_eq!(load_index(&db).unwrap().sealed.index.sources().len(), 1);
}
