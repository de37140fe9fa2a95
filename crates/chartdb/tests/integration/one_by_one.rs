//! Charts that come and go one by one leave the set, the index and the answers that charts leave which came all at once;
//! and a reader sees one whole state, also after a loss of power.

use crate::support::{contents, import, options, put};
use chartdb::{ChartDb, Snapshot, load_index};
use charts::coverage::ChartCoverage;
use charts::depth_index::IndexBytes as _;
use rusqlite::Connection;
use std::path::{Path, PathBuf};

const TABLES: [&str; 6] = ["skin", "areas", "lines", "points", "soundings", "points_of_interest"];

/// All that a database says, whatever numbers its rows have.
fn told(db: &Path) -> Vec<String> {
    let connection = Connection::open(db).unwrap();
    let list = |text: &str| -> Vec<String> {
        let mut select = connection.prepare(text).unwrap();
        let columns = select.column_count();
        let row = |row: &rusqlite::Row<'_>| {
            let values = (0..columns).map(|at| row.get::<_, rusqlite::types::Value>(at).unwrap());
            Ok(format!("{:?}", values.collect::<Vec<_>>()))
        };
        select.query_map([], row).unwrap().map(Result::unwrap).collect()
    };
    assert_eq!(list("PRAGMA integrity_check"), ["[Text(\"ok\")]"]);
    let mut all = list("SELECT type, name, sql FROM sqlite_master ORDER BY type, name");
    all.extend(list(
        "SELECT name, sha256, edition, update_no, features, min_x, max_y FROM cells ORDER BY name",
    ));
    all.extend(list("SELECT cell, record, covered, area_deg2 FROM coverage ORDER BY cell, id"));
    all.extend(list("SELECT cell, record, class, attributes FROM objects ORDER BY cell, record, fid"));
    all.extend(list("SELECT table_name, min_x, min_y, max_x, max_y FROM gpkg_contents ORDER BY table_name"));
    for table in TABLES {
        all.extend(list(&format!(
            "SELECT t.*, r.minx, r.maxx, r.miny, r.maxy FROM (SELECT fid, geom, cell, record, scale FROM {table}) t \
             LEFT JOIN rtree_{table}_geom r ON r.id = t.fid ORDER BY cell, record, t.fid"
        )).into_iter().map(|row| row.split_once(',').unwrap().1.to_owned()));
        all.extend(list(&format!("SELECT count(*) FROM rtree_{table}_geom")));
    }
    all
}

#[test]
fn charts_that_come_one_by_one_make_the_set_that_all_at_once_make() {
    let folder = tempfile::tempdir().unwrap();
    let cells = folder.path().join("cells");
    std::fs::create_dir(&cells).unwrap();
    let names = ["GB4X0000", "GB5X01NE", "GB5X01SE", "GB5X02SE"];
    let all: Option<Vec<PathBuf>> = names.iter().map(|name| put(&cells, name, 0)).collect();
    let Some(mut all) = all else { return };
    let early = put(&cells, "US5WA22M", 1).unwrap();
    let (slow, quick) = (folder.path().join("slow/chart.gpkg"), folder.path().join("quick/chart.gpkg"));
    assert!(import(&slow, &[early]).applied);
    for one in all.iter().rev() {
        assert!(import(&slow, std::slice::from_ref(one)).applied);
    }
    let gone = put(&cells, "US5MD1MC", 0).unwrap();
    assert!(import(&slow, &[gone]).applied);
    chartdb::remove(&slow, &["US5MD1MC".to_owned()], options().now).unwrap();
    // Its updates come later, and take the place of what was there.
    all.push(put(&cells, "US5WA22M", 4).unwrap());
    assert!(import(&slow, &[all[4].clone()]).applied);
    assert!(import(&quick, &all).applied);

    let (one, other) = (told(&slow), told(&quick));
    assert!(one.len() > 1_000 && one.len() == other.len(), "{} and {}", one.len(), other.len());
    for (one, other) in one.iter().zip(&other) {
        assert_eq!(one, other);
    }
    let (one, other) = (ChartDb::open(&slow).unwrap(), ChartDb::open(&quick).unwrap());
    assert_eq!(one.digest().unwrap(), other.digest().unwrap());
    for (a, b) in one.charts().unwrap().iter().zip(&other.charts().unwrap()) {
        assert!(one.features(a).unwrap() == other.features(b).unwrap(), "{}", a.name);
    }
    let bytes = |db: &Path| {
        let packed = load_index(db).unwrap().sealed.packed();
        packed.read(0, packed.length() as usize).unwrap()
    };
    assert!(bytes(&slow) == bytes(&quick));
    assert!(bytes(&slow) == std::fs::read(chartdb::index_path(&quick)).unwrap());
}

#[test]
fn a_change_that_lost_power_is_undone_by_the_next_who_looks() {
    let folder = tempfile::tempdir().unwrap();
    let (set, cells) = (folder.path().join("set"), folder.path().join("cells"));
    std::fs::create_dir(&cells).unwrap();
    let Some(first) = put(&cells, "GB5X01SE", 0) else { return };
    let db = set.join("chart.gpkg");
    assert!(import(&db, &[first]).applied);
    let before = contents(&set);
    // Half of a change is in the file when the power goes.
    let connection = Connection::open(&db).unwrap();
    connection.pragma_update(None, "cache_size", 2).unwrap();
    connection.execute_batch("BEGIN IMMEDIATE; DELETE FROM skin; DELETE FROM objects").unwrap();
    let later = folder.path().join("later");
    std::fs::create_dir(&later).unwrap();
    for (path, bytes) in contents(&set) {
        std::fs::write(later.join(path.file_name().unwrap()), bytes).unwrap();
    }
    drop(connection);
    assert!(later.join("chart.gpkg-journal").exists());
    let half = std::fs::read(later.join("chart.gpkg")).unwrap();
    assert!(before.iter().all(|(_, bytes)| *bytes != half), "nothing of the change was in the file");

    let index = load_index(&later.join("chart.gpkg")).unwrap();
    assert_eq!(index.rebuilt, None);
    let after = contents(&later).into_iter().map(|(_, bytes)| bytes);
    assert!(after.eq(before.into_iter().map(|(_, bytes)| bytes)), "the set is as it was");
}

#[test]
fn who_reads_a_set_over_hours_notices_that_it_changed() {
    let folder = tempfile::tempdir().unwrap();
    let cells = folder.path().join("cells");
    std::fs::create_dir(&cells).unwrap();
    let Some(first) = put(&cells, "GB5X01SE", 0) else { return };
    let db = folder.path().join("chart.gpkg");
    assert!(import(&db, std::slice::from_ref(&first)).applied);
    let mut snapshot = Snapshot::open(&db).unwrap();
    let chart = snapshot.charts()[0].clone();
    let count = |snapshot: &mut Snapshot| {
        snapshot.read(|set| set.features(&chart)).unwrap().map(|features| features.len() as u64)
    };
    assert_eq!(count(&mut snapshot), Some(chart.features));
    // Another program changes a description; the charts stay the same.
    let text = "UPDATE gpkg_contents SET description = 'mine' WHERE table_name = 'skin'";
    Connection::open(&db).unwrap().execute(text, []).unwrap();
    assert_eq!(count(&mut snapshot), Some(chart.features));
    let second = put(&cells, "GB5X01NE", 0).unwrap();
    assert!(import(&db, &[second]).applied);
    assert_eq!(count(&mut snapshot), None);
    assert_eq!(count(&mut snapshot), None);
    assert_eq!(count(&mut Snapshot::open(&db).unwrap()), Some(chart.features));
}

#[test]
fn what_a_chart_covers_is_read_alone_as_of_all_its_features() {
    let folder = tempfile::tempdir().unwrap();
    let cells = folder.path().join("cells");
    std::fs::create_dir(&cells).unwrap();
    let Some(first) = put(&cells, "GB4X0000", 0) else { return };
    put(&cells, "US5MD1MC", 0).unwrap();
    let db = folder.path().join("chart.gpkg");
    assert!(import(&db, &[cells, first]).applied);
    // One that does not say where it has data covers its skin.
    let text =
        "UPDATE areas SET class = 'M_QUAL', class_code = 308 WHERE class = 'M_COVR' AND cell = 'US5MD1MC'";
    let connection = Connection::open(&db).unwrap();
    for number in 1..=4 {
        // They need functions that only the editing program has.
        connection.execute_batch(&format!("DROP TRIGGER rtree_areas_geom_update{number}")).unwrap();
    }
    connection.execute(text, []).unwrap();
    let set = ChartDb::open(&db).unwrap();
    for chart in set.charts().unwrap() {
        let coverage = set.coverage(&chart).unwrap();
        assert_eq!(coverage.by_skin, chart.name == "US5MD1MC");
        assert!(!coverage.areas.is_empty());
        assert_eq!(coverage, ChartCoverage::of(chart.source(), &set.features(&chart).unwrap()));
    }
}
