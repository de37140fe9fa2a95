//! Whatever goes wrong, the set is as it was.

use crate::support::{contents, import, options, put};
use chartdb::{ChartDb, ImportReport, Outcome, Snapshot, load_index};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

/// A set of one small cell in a folder of its own, and a folder of cells to import.
fn start(folder: &Path) -> Option<(PathBuf, PathBuf)> {
    let (set, cells) = (folder.join("set"), folder.join("cells"));
    std::fs::create_dir(&cells).unwrap();
    let first = put(&cells, "GB5X02SE", 0)?;
    let db = set.join("chart.gpkg");
    assert!(import(&db, &[first]).applied);
    Some((db, cells))
}

fn set_of(db: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files = contents(db.parent().unwrap());
    files.retain(|(path, _)| !path.to_string_lossy().contains(".part"));
    files
}

fn messages(report: &ImportReport) -> String {
    report.failures.iter().map(|failure| failure.error.to_string()).collect::<Vec<_>>().join("\n")
}

#[test]
fn a_damaged_cell_changes_nothing_and_the_good_ones_wait() {
    let folder = tempfile::tempdir().unwrap();
    let Some((db, cells)) = start(folder.path()) else { return };
    let before = set_of(&db);
    put(&cells, "GB5X01SE", 0).unwrap();
    let bad = put(&cells, "GB5X01NW", 0).unwrap();
    let whole = std::fs::read(&bad).unwrap();
    for at in [0, 10, 1000, whole.len() / 2, whole.len() - 1] {
        std::fs::write(&bad, &whole[..at]).unwrap();
        let report = import(&db, std::slice::from_ref(&cells));
        assert!(!report.applied);
        assert!(messages(&report).contains("GB5X01NW.000"), "{}", messages(&report));
        assert!(set_of(&db) == before, "cut at {at}");
    }
    // With the good one repaired, what was read before is not read again.
    std::fs::write(&bad, &whole).unwrap();
    let report = import(&db, std::slice::from_ref(&cells));
    assert!(report.applied);
    let outcome = |name: &str| report.charts.iter().find(|chart| chart.name == name).unwrap().outcome.clone();
    assert_eq!(outcome("GB5X01SE"), Outcome::Unchanged);
    assert_eq!(outcome("GB5X01NW"), Outcome::Added);
    assert_eq!(ChartDb::open(&db).unwrap().charts().unwrap().len(), 3);
}

fn names(db: &Path) -> Vec<String> {
    ChartDb::open(db).unwrap().charts().unwrap().into_iter().map(|chart| chart.name).collect()
}

/// A failed import of a good and a bad cell beside the set of [`start`]; the two cells.
fn fail(db: &Path, cells: &Path) -> [PathBuf; 2] {
    let good = put(cells, "GB5X01SE", 0).unwrap();
    let bad = put(cells, "GB5X01NW", 0).unwrap();
    std::fs::write(&bad, &std::fs::read(&bad).unwrap()[..1000]).unwrap();
    let inputs = [good, bad];
    assert!(!import(db, &inputs).applied);
    inputs
}

#[test]
fn what_a_failed_import_read_comes_in_with_nothing_else() {
    let folder = tempfile::tempdir().unwrap();
    let Some((db, cells)) = start(folder.path()) else { return };
    fail(&db, &cells);
    let other = put(&cells, "GB5X01NE", 0).unwrap();
    assert!(import(&db, &[other]).applied);
    assert_eq!(names(&db), ["GB5X01NE", "GB5X02SE"]);
    fail(&db, &cells);
    chartdb::remove(&db, &["GB5X01NE".to_owned()], options().now).unwrap();
    assert_eq!(names(&db), ["GB5X02SE"]);
    // Going on with one of the two is another import too.
    let [_, bad] = fail(&db, &cells);
    put(&cells, "GB5X01NW", 0).unwrap();
    assert!(import(&db, &[bad]).applied);
    assert_eq!(names(&db), ["GB5X01NW", "GB5X02SE"]);
}

#[test]
fn a_chart_that_fails_now_does_not_come_in_as_it_was_read_before() {
    let folder = tempfile::tempdir().unwrap();
    let Some((db, cells)) = start(folder.path()) else { return };
    let [good, bad] = fail(&db, &cells);
    put(&cells, "GB5X01NW", 0).unwrap();
    std::fs::write(&good, &std::fs::read(&good).unwrap()[..1000]).unwrap();
    let options = chartdb::ImportOptions { keep_going: true, ..options() };
    let report = chartdb::import(&db, &[good, bad], &options, &mut |_| true).unwrap();
    assert!(report.applied && report.charts.len() == 1 && report.failures.len() == 1, "{report:?}");
    assert_eq!(names(&db), ["GB5X01NW", "GB5X02SE"]);
}

#[test]
fn a_chart_is_too_old_for_the_set_and_not_for_what_a_failed_import_read() {
    let folder = tempfile::tempdir().unwrap();
    let Some((db, cells)) = start(folder.path()) else { return };
    let base = put(&cells, "US5WA22M", 1).unwrap();
    let bad = put(&cells, "GB5X01NW", 0).unwrap();
    let whole = std::fs::read(&bad).unwrap();
    std::fs::write(&bad, &whole[..1000]).unwrap();
    assert!(!import(&db, &[base.clone(), bad.clone()]).applied);
    std::fs::remove_file(cells.join("US5WA22M.001")).unwrap();
    std::fs::write(&bad, whole).unwrap();
    let report = import(&db, &[base, bad]);
    assert!(report.applied, "{}", messages(&report));
    assert_eq!(names(&db), ["GB5X01NW", "GB5X02SE", "US5WA22M"]);
}

#[test]
fn flipped_bits_are_refused_or_read_but_never_half_imported() {
    let folder = tempfile::tempdir().unwrap();
    let Some((db, cells)) = start(folder.path()) else { return };
    let path = cells.join("GB5X02SE.000");
    let whole = std::fs::read(&path).unwrap();
    let (mut refused, mut read) = (0, 0);
    for step in 0..40 {
        let mut bytes = whole.clone();
        let at = step * (whole.len() - 1) / 39;
        bytes[at] ^= 1 << (step % 8);
        std::fs::write(&path, &bytes).unwrap();
        let before = set_of(&db);
        let report = import(&db, std::slice::from_ref(&path));
        if report.applied {
            read += 1;
            let set = ChartDb::open(&db).unwrap();
            let chart = &set.charts().unwrap()[0];
            assert_eq!(set.features(chart).unwrap().len() as u64, chart.features);
            assert_eq!(load_index(&db).unwrap().rebuilt, None);
        } else {
            refused += 1;
            assert!(set_of(&db) == before, "byte {at}");
        }
    }
    println!("{refused} refused, {read} read");
    assert!(refused > 0);
}

#[test]
fn devices_and_what_is_far_too_large_are_refused_before_they_are_read() {
    let folder = tempfile::tempdir().unwrap();
    let path = |name: &str| folder.path().join(name);
    let db = path("set/chart.gpkg");
    let refused = |input: &Path, words: &str| {
        let found = match chartdb::import(&db, &[input.to_owned()], &options(), &mut |_| true) {
            Ok(report) => messages(&report),
            Err(error) => error.to_string(),
        };
        assert!(found.contains(words) && !db.exists(), "{found}");
    };
    for name in ["GB5X01SE.000", "survey.xyz", "land.geojson", "lakes.gpkg", "CATALOG.031"] {
        // It has no end; nothing that reads it would come back.
        std::os::unix::fs::symlink("/dev/zero", path(name)).unwrap();
        refused(&path(name), "this is not a file but a pipe");
    }
    std::fs::create_dir(path("cells")).unwrap();
    std::fs::rename(path("GB5X01SE.000"), path("cells/GB5X01SE.000")).unwrap();
    refused(&path("cells"), "GB5X01SE.000: this is not a file but a pipe");
    // Sparse: it takes no room.
    std::fs::remove_file(path("cells/GB5X01SE.000")).unwrap();
    std::fs::File::create(path("cells/GB5X01SE.000")).unwrap().set_len(300 << 20).unwrap();
    refused(&path("cells"), "GB5X01SE.000: 300 MB are too much for an S-57 cell");
}

#[test]
fn updates_that_do_not_fit_are_refused_with_a_remedy() {
    let folder = tempfile::tempdir().unwrap();
    let Some((db, cells)) = start(folder.path()) else { return };
    let before = set_of(&db);
    let base = put(&cells, "US5WA22M", 4).unwrap();
    let says = |inputs: &[PathBuf], words: &str| {
        let report = import(&db, inputs);
        assert!(!report.applied && messages(&report).contains(words), "{}", messages(&report));
        assert!(set_of(&db) == before, "{words}");
    };
    std::fs::remove_file(cells.join("US5WA22M.002")).unwrap();
    says(std::slice::from_ref(&base), "US5WA22M.003, record 1 at byte");
    says(std::slice::from_ref(&base), "the next must be update 2; fetch the missing update");
    std::fs::remove_file(&base).unwrap();
    says(&[cells.join("US5WA22M.001")], "no base cell (.000); add the base cell");
    std::fs::rename(cells.join("US5WA22M.001"), cells.join("US5WA22M.000")).unwrap();
    says(&[base], "is an update, not a base cell");
    std::fs::copy(cells.join("GB5X02SE.000"), cells.join("GB5X09XX.000")).unwrap();
    says(&[cells.join("GB5X09XX.000")], "GB5X02SE");
}

#[test]
fn an_older_state_of_a_cell_does_not_replace_a_newer_one() {
    let folder = tempfile::tempdir().unwrap();
    let cells = folder.path().join("cells");
    std::fs::create_dir(&cells).unwrap();
    let Some(base) = put(&cells, "US5WA22M", 1) else { return };
    let db = folder.path().join("set/chart.gpkg");
    assert!(import(&db, std::slice::from_ref(&base)).applied);
    let before = set_of(&db);
    std::fs::remove_file(cells.join("US5WA22M.001")).unwrap();
    let report = import(&db, &[base]);
    assert!(messages(&report).contains("older than what the chart set holds"), "{}", messages(&report));
    assert!(set_of(&db) == before);
}

#[test]
fn soundings_land_and_lakes_come_in_and_bad_ones_say_where() {
    let folder = tempfile::tempdir().unwrap();
    let db = folder.path().join("set/chart.gpkg");
    let path = |name: &str| folder.path().join(name);
    std::fs::write(path("survey.xyz"), "269927.5527 7044215.8950 12.4\n269937 7044215 -0.3\n").unwrap();
    std::fs::write(path("bad.xyz"), "269927.5527 7044215.8950 12.4\nno sounding\n").unwrap();
    let ring = "[[10,63],[11,63],[11,64],[10,63]]";
    std::fs::write(path("land.geojson"), format!(r#"{{"type":"Polygon","coordinates":[{ring}]}}"#)).unwrap();
    lakes(&path("lakes.shp"));
    let bring = |names: &[&str], epsg| {
        let inputs: Vec<PathBuf> = names.iter().map(|name| path(name)).collect();
        let depth_column = Some("depth".to_owned());
        let options = chartdb::ImportOptions { epsg, depth_column, ..options() };
        chartdb::import(&db, &inputs, &options, &mut |_| true).unwrap()
    };
    assert!(messages(&bring(&["survey.xyz"], None)).contains("--epsg 25833"));
    assert!(messages(&bring(&["bad.xyz"], Some(25833))).contains("bad.xyz: line 2 at byte 30"));
    assert!(!db.exists());
    let report = bring(&["survey.xyz", "land.geojson"], Some(25833));
    assert!(report.applied, "{}", messages(&report));
    let report = bring(&["lakes.shp"], Some(4326));
    assert!(report.applied, "{}", messages(&report));
    assert_eq!(report.charts[0].features, 2);
    assert!(report.charts[0].notices[0].contains("polygon 2: it has no depth"), "{:?}", report.charts[0]);
    let index = load_index(&db).unwrap().sealed.index;
    let water = |lat, lon| {
        let at = units::LatLon::from_deg(lat, lon).unwrap();
        index.depth_at(at, &charts::depth_index::Demand::default()).water
    };
    assert_eq!(water(60.05, 9.05).least_m(), Some(4.5));
    assert_eq!(water(60.05, 9.15), charts::depth_index::Water::UnknownDepth);
    assert_eq!(water(63.2, 10.8), charts::depth_index::Water::Land);
    let set = ChartDb::open(&db).unwrap();
    let survey = &set.charts_named(&["survey".to_owned()]).unwrap()[0];
    assert_eq!((survey.vertices, survey.kind.as_str()), (2, "soundings"));
}

/// Two squares beside each other, 4.5 m deep and of unknown depth.
fn lakes(path: &Path) {
    use shapefile::dbase::{FieldValue, Record, TableWriterBuilder};
    let table = TableWriterBuilder::new().add_numeric_field("depth".try_into().unwrap(), 10, 2);
    let mut writer = shapefile::Writer::from_path(path, table).unwrap();
    for (west, depth) in [(9.0, Some(4.5)), (9.1, None)] {
        let point = |x: f64, y: f64| shapefile::Point::new(west + x, 60.0 + y);
        let ring = vec![point(0.0, 0.0), point(0.0, 0.1), point(0.1, 0.1), point(0.1, 0.0), point(0.0, 0.0)];
        let polygon = shapefile::Polygon::new(shapefile::PolygonRing::Outer(ring));
        let mut record = Record::default();
        record.insert("depth".to_owned(), FieldValue::Numeric(depth));
        writer.write_shape_and_record(&polygon, &record).unwrap();
    }
}

/// Imports the folder and database of the environment; only as a process of the test below.
#[test]
fn child_that_imports() {
    let (Ok(db), Ok(cells)) = (std::env::var("LUTRA_TEST_DB"), std::env::var("LUTRA_TEST_CELLS")) else {
        return;
    };
    let stop_at: Option<u32> = std::env::var("LUTRA_TEST_STOP_AT").ok().and_then(|text| text.parse().ok());
    let mut step = 0;
    let report = chartdb::import(Path::new(&db), &[PathBuf::from(cells)], &options(), &mut |_| {
        step += 1;
        if stop_at == Some(step) {
            println!("at step {step}");
            // Until the kill: a busy computer would be at the next step before it comes.
            std::io::copy(&mut std::io::stdin(), &mut std::io::sink()).unwrap();
        }
        true
    });
    assert!(report.unwrap().applied);
}

#[test]
fn a_killed_import_leaves_the_old_set_whole() {
    use std::io::{BufRead as _, BufReader};
    let folder = tempfile::tempdir().unwrap();
    let Some((db, cells)) = start(folder.path()) else { return };
    let before = set_of(&db);
    for name in ["GB5X01SE", "GB5X01NE", "GB5X01NW"] {
        put(&cells, name, 0).unwrap();
    }
    for kill_at in 1..=5 {
        let mut child = Command::new(std::env::current_exe().unwrap())
            .args(["--exact", "all_or_nothing::child_that_imports", "--nocapture"])
            .env("LUTRA_TEST_DB", &db)
            .env("LUTRA_TEST_CELLS", &cells)
            .env("LUTRA_TEST_STOP_AT", kill_at.to_string())
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let wanted = format!("at step {kill_at}");
        let lines = BufReader::new(child.stdout.take().unwrap()).lines();
        let seen = lines.map_while(Result::ok).any(|line| line.ends_with(&wanted));
        child.kill().unwrap();
        child.wait().unwrap();
        assert!(seen, "{wanted}");
        // Killed at the index, the new set may be there already, and whole.
        if kill_at < 5 {
            assert!(set_of(&db) == before, "killed at {kill_at}");
        }
        let loaded = load_index(&db).unwrap();
        assert!([1, 4].contains(&loaded.sealed.index.sources().len()));
    }
    assert!(import(&db, std::slice::from_ref(&cells)).applied);
    assert_eq!(ChartDb::open(&db).unwrap().charts().unwrap().len(), 4);
}

/// QGIS added a field and left a write-ahead log, and a server has the set open for what it draws.
#[test]
fn what_qgis_left_hinders_no_import_while_somebody_reads() {
    let folder = tempfile::tempdir().unwrap();
    let Some((db, cells)) = start(folder.path()) else { return };
    let edit = rusqlite::Connection::open(&db).unwrap();
    edit.execute_batch("PRAGMA journal_mode = WAL; ALTER TABLE coverage ADD COLUMN mine TEXT").unwrap();
    drop(edit);
    let mut open = Snapshot::open(&db).unwrap();
    let before = open.digest();
    let second = put(&cells, "GB5X01SE", 0).unwrap();
    assert!(import(&db, &[second]).applied);
    assert_eq!(names(&db), ["GB5X01SE", "GB5X02SE"]);
    assert!(open.read(ChartDb::charts).unwrap().is_none(), "who reads is told that it is another set");
    // A copy is of one state, and whole by itself.
    let copy = folder.path().join("copy.gpkg");
    chartdb::copy(&db, &copy).unwrap();
    let digest = ChartDb::open(&db).unwrap().digest().unwrap();
    assert!(digest != before && ChartDb::open(&copy).unwrap().digest().unwrap() == digest);
    assert!(load_index(&copy).unwrap().sealed.digest == digest);
}
