//! A cell through its life in a chart set: updates, a re-issue, a newer edition, its cancellation; and cells
//! that must not be used for navigation.

#[path = "../../../charts/tests/integration/writer/mod.rs"]
mod writer;

use crate::support::{contents, import};
use chartdb::{ChartDb, ImportReport, Outcome, load_index};
use charts::depth_index::{Demand, Leg, Water};
use charts::s57::write::{CellDraft, FeatureChange, FeatureDraft, FeatureRef, UpdateDraft, VectorUse};
use charts::s57::{AttributeCode, GeoPoint, ObjectClass};
use std::path::{Path, PathBuf};
use tempfile::TempDir;
use units::LatLon;

const NAME: &str = "NO5X0001";

/// A set in a folder of its own, and a folder of cells to import.
struct Shelf {
    folder: TempDir,
    db: PathBuf,
    cells: PathBuf,
}

impl Shelf {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let (db, cells) = (folder.path().join("set/chart.gpkg"), folder.path().join("ENC_ROOT"));
        std::fs::create_dir(&cells).unwrap();
        Self { folder, db, cells }
    }

    fn put(&self, number: u32, bytes: Vec<u8>) -> PathBuf {
        let path = self.cells.join(format!("{NAME}.{number:03}"));
        std::fs::write(&path, bytes).unwrap();
        path
    }

    fn take(&self, number: u32) {
        std::fs::remove_file(self.cells.join(format!("{NAME}.{number:03}"))).unwrap();
    }

    fn import(&self) -> ImportReport {
        import(&self.db, std::slice::from_ref(&self.cells))
    }

    fn accepted(&self) -> Outcome {
        let report = self.import();
        assert!(report.applied, "{}", told(&report));
        report.charts[0].outcome.clone()
    }

    /// What is wrong; nothing of the set is another then.
    fn refused(&self) -> String {
        let set = self.db.parent().unwrap();
        let state = || if set.exists() { whole(set) } else { Vec::new() };
        let before = state();
        let report = self.import();
        assert!(!report.applied && state() == before, "{}", told(&report));
        told(&report)
    }

    fn held(&self) -> Vec<(String, String)> {
        let charts = ChartDb::open(&self.db).unwrap().charts().unwrap();
        charts.into_iter().map(|chart| (chart.edition, chart.update)).collect()
    }

    fn water(&self) -> Water {
        let index = load_index(&self.db).unwrap().sealed.index;
        index.depth_at(LatLon::from_deg(63.01, 10.02).unwrap(), &Demand::default()).water
    }
}

/// The files of a set; what an import that failed has read waits beside them.
fn whole(set: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let mut files = contents(set);
    files.retain(|(path, _)| !path.to_string_lossy().contains(".part"));
    files
}

fn told(report: &ImportReport) -> String {
    report.failures.iter().map(|failure| failure.error.to_string()).collect::<Vec<_>>().join("\n")
}

/// A cell without features, and the ring round its water.
fn bare(edition: u32) -> (CellDraft, Vec<VectorUse>) {
    let mut cell = CellDraft::new(&format!("{NAME}.000"), 5, 10_000);
    cell.id.edition = edition.to_string();
    let corners = [(63.0, 10.0), (63.02, 10.0), (63.02, 10.04), (63.0, 10.04)];
    let nodes = corners.map(|(lat_deg, lon_deg)| cell.records.connected_node(GeoPoint { lon_deg, lat_deg }));
    let sides = [0, 1, 2, 3].map(|one| cell.records.edge(nodes[one], nodes[(one + 1) % 4], &[]));
    (cell, sides.iter().map(|side| side.forward()).collect())
}

fn cover(cell: &mut CellDraft, ring: &[VectorUse]) {
    let cover = FeatureDraft::area(ObjectClass::M_COVR, ring).with(AttributeCode::CATCOV, "1");
    cell.records.feature(cover);
}

fn water(cell: &mut CellDraft, ring: &[VectorUse], least_m: &str) -> FeatureRef {
    let water = FeatureDraft::area(ObjectClass::DEPARE, ring).with(AttributeCode::DRVAL1, least_m);
    cell.records.feature(water.with(AttributeCode::DRVAL2, "40"))
}

/// A cell of one square of water.
fn square(edition: u32, least_m: &str) -> (CellDraft, FeatureRef) {
    let (mut cell, ring) = bare(edition);
    cover(&mut cell, &ring);
    let water = water(&mut cell, &ring, least_m);
    (cell, water)
}

/// Updates that make the water 4, 3 and 2 m deep.
fn updates(cell: &CellDraft, water: FeatureRef) -> Vec<UpdateDraft> {
    let mut updates: Vec<UpdateDraft> = Vec::new();
    let mut water = water;
    for least_m in ["4", "3", "2"] {
        let mut next = updates.last().map_or_else(|| UpdateDraft::new(cell, 1), UpdateDraft::next);
        let change = FeatureChange::of(water).with(AttributeCode::DRVAL1, least_m);
        water = next.records.change_feature(change);
        updates.push(next);
    }
    updates
}

fn edition(edition: &str, update: &str) -> (String, String) {
    (edition.to_owned(), update.to_owned())
}

#[test]
fn updates_a_re_issue_and_a_newer_edition_replace_what_was_there() {
    let shelf = Shelf::new();
    let (cell, water) = square(1, "5");
    let updates = updates(&cell, water);
    shelf.put(0, cell.to_bytes().unwrap());
    assert_eq!(shelf.accepted(), Outcome::Added);
    assert_eq!(shelf.accepted(), Outcome::Unchanged);
    shelf.put(1, updates[0].to_bytes().unwrap());
    assert_eq!(shelf.accepted(), Outcome::Replaced { before: "edition 1, update 0".to_owned() });
    assert_eq!((shelf.held(), shelf.water().least_m()), (vec![edition("1", "1")], Some(4.0)));
    // The re-issue has updates 1 and 2 in it; 3 follows it.
    let (mut reissue, _) = square(1, "3");
    reissue.id.update = "2".to_owned();
    shelf.take(1);
    shelf.put(0, reissue.to_bytes().unwrap());
    assert_eq!(shelf.accepted(), Outcome::Replaced { before: "edition 1, update 1".to_owned() });
    assert_eq!((shelf.held(), shelf.water().least_m()), (vec![edition("1", "2")], Some(3.0)));
    shelf.put(3, updates[2].to_bytes().unwrap());
    shelf.accepted();
    assert_eq!((shelf.held(), shelf.water().least_m()), (vec![edition("1", "3")], Some(2.0)));
    // The next edition starts over, and nothing of the last one is left.
    shelf.take(3);
    shelf.put(0, square(2, "9").0.to_bytes().unwrap());
    assert_eq!(shelf.accepted(), Outcome::Replaced { before: "edition 1, update 3".to_owned() });
    assert_eq!((shelf.held(), shelf.water().least_m()), (vec![edition("2", "0")], Some(9.0)));
    let db = ChartDb::open(&shelf.db).unwrap();
    assert_eq!(db.features(&db.charts().unwrap()[0]).unwrap().len(), 2);
    shelf.put(0, square(1, "5").0.to_bytes().unwrap());
    assert!(shelf.refused().contains("older than what the chart set holds (edition 2, update 0)"));
    // An update of the previous edition does not belong to this one.
    shelf.put(0, square(2, "9").0.to_bytes().unwrap());
    shelf.put(1, updates[0].to_bytes().unwrap());
    let text = shelf.refused();
    assert!(text.contains(&format!("{NAME}.001")) && text.contains("edition"), "{text}");
}

/// Three waters side by side: one of them a hundredth of a degree too far east, so that it leaves a gap on one side and
/// lies over its neighbour on the other, and all together are as large as what is covered.
#[test]
fn a_gap_is_told_though_an_overlap_is_as_large() {
    let shelf = Shelf::new();
    let (mut cell, ring) = bare(1);
    cover(&mut cell, &ring);
    for [west, east] in [[10.0, 10.01], [10.02, 10.03], [10.02, 10.04]] {
        let corners = [(63.0, west), (63.02, west), (63.02, east), (63.0, east)];
        let nodes =
            corners.map(|(lat_deg, lon_deg)| cell.records.connected_node(GeoPoint { lon_deg, lat_deg }));
        let sides = [0, 1, 2, 3].map(|one| cell.records.edge(nodes[one], nodes[(one + 1) % 4], &[]));
        let ring: Vec<VectorUse> = sides.iter().map(|side| side.forward()).collect();
        water(&mut cell, &ring, "5");
    }
    shelf.put(0, cell.to_bytes().unwrap());
    let report = shelf.import();
    let skin = report.charts[0].skin.unwrap();
    assert!((skin.skin_deg2 - skin.coverage_deg2).abs() < 1e-12, "the sums agree: {skin:?}");
    assert!(!skin.holds() && skin.amiss_deg2 >= 0.000_4 - 1e-9, "{skin:?}");
    let db = ChartDb::open(&shelf.db).unwrap();
    let chart = db.charts().unwrap().remove(0);
    assert_eq!(chart.skin_holds, Some(false));
    let told = db.log(&chart).unwrap();
    assert!(told.iter().any(|entry| entry.text.contains("gaps or overlaps, most at 63.")), "{told:?}");
    // And no route leads through the gap.
    let index = load_index(&shelf.db).unwrap().sealed.index;
    let place = |lon_deg: f64| LatLon::from_deg(63.01, lon_deg).unwrap();
    let leg = Leg { from: place(10.005), to: place(10.025) };
    let demand = Demand::least_depth(2.0);
    assert_eq!(index.shallowest_along(leg, 5.0, &demand).water, Water::NoData);
    let danger = index.first_danger_along(leg, 5.0, &demand).unwrap();
    assert!((danger.along_m - 0.005 * 50_630.0 + 5.0).abs() < 2.0, "{danger:?}");
    let within = Leg { from: place(10.022), to: place(10.038) };
    assert!(index.shallowest_along(within, 5.0, &demand).navigable, "an overlap is not a gap");
}

#[test]
fn an_update_that_is_missing_or_of_another_place_changes_nothing() {
    let shelf = Shelf::new();
    let (cell, water) = square(1, "5");
    let updates = updates(&cell, water);
    shelf.put(0, cell.to_bytes().unwrap());
    shelf.accepted();
    shelf.put(2, updates[1].to_bytes().unwrap());
    let text = shelf.refused();
    assert!(text.contains(&format!("{NAME}.002")) && text.contains("fetch the missing update"), "{text}");
    // Named 1, but numbered 2.
    shelf.take(2);
    shelf.put(1, updates[1].to_bytes().unwrap());
    let text = shelf.refused();
    assert!(text.contains("the next must be update 1"), "{text}");
    assert_eq!((shelf.held(), shelf.water().least_m()), (vec![edition("1", "0")], Some(5.0)));
}

#[test]
fn a_cancelled_cell_leaves_the_set() {
    let shelf = Shelf::new();
    let (cell, _) = square(1, "5");
    shelf.put(0, cell.to_bytes().unwrap());
    shelf.accepted();
    assert_eq!(shelf.water().least_m(), Some(5.0));
    let mut cancel = UpdateDraft::new(&cell, 1);
    cancel.id.edition = "0".to_owned();
    shelf.put(1, cancel.to_bytes().unwrap());
    assert_eq!(shelf.accepted(), Outcome::Withdrawn);
    assert_eq!((shelf.held(), shelf.water()), (Vec::new(), Water::NoData));
    let connection = rusqlite::Connection::open(&shelf.db).unwrap();
    let logged = "SELECT count(*) FROM import_log WHERE what = 'removed' AND text LIKE 'cancelled%'";
    assert_eq!(connection.query_row(logged, [], |row| row.get::<_, i64>(0)).unwrap(), 1);
}

#[test]
fn a_file_that_is_not_what_its_catalogue_says_changes_nothing() {
    use writer::Bytes;
    let shelf = Shelf::new();
    let bytes = square(1, "5").0.to_bytes().unwrap();
    let path = shelf.put(0, bytes.clone());
    let entry = |id: u32, name: &str, checksum: &str| {
        let bytes = Bytes::default().fixed("CD").fixed(&format!("{id:010}")).text(name).text("");
        let bytes = bytes.text("V01X01").fixed("BIN").text("63.0").text("10.0").text("63.02").text("10.04");
        vec![("CATD", bytes.text(checksum).text("").0)]
    };
    let catalogue = |checksum: u32| {
        let cell = entry(1, &format!("{NAME}.000"), &format!("{checksum:08X}"));
        let text = entry(2, "NO5X0001.TXT", "");
        std::fs::write(shelf.cells.join("CATALOG.031"), writer::file(&[cell, text])).unwrap();
    };
    let right = crc32fast::hash(&bytes);
    catalogue(right ^ 1);
    let text = shelf.refused();
    let (expected, found) = (format!("{:08X}", right ^ 1), format!("{right:08X}"));
    assert!(text.contains(&path.display().to_string()), "{text}");
    assert!(text.contains(&expected) && text.contains(&found) && !shelf.db.exists(), "{text}");
    catalogue(right);
    let report = shelf.import();
    assert!(report.applied && report.charts[0].outcome == Outcome::Added, "{}", told(&report));
    // Files that are listed but missing are reported.
    assert!(report.notices[0].contains("NO5X0001.TXT is listed, but it is not there"), "{report:?}");
    std::fs::write(shelf.cells.join("CATALOG.031"), "no catalogue").unwrap();
    assert!(shelf.refused().contains("CATALOG.031"));
    assert!(shelf.folder.path().exists());
}

#[test]
fn cells_that_are_none_to_sail_by_are_refused_by_name() {
    type Spoil = fn(&mut CellDraft);
    let shelf = Shelf::new();
    let cases: [(Spoil, &str); 2] = [
        (|cell| cell.parameters.horizontal_datum = 4, "the horizontal datum (HDAT) is 4, not 2 (WGS 84)"),
        (|cell| cell.units.depth = 2, "the depth unit (DUNI) is 2, not 1 (metres)"),
    ];
    for (spoil, why) in cases {
        let (mut cell, _) = square(1, "5");
        spoil(&mut cell);
        shelf.put(0, cell.to_bytes().unwrap());
        let text = shelf.refused();
        assert!(text.contains(&format!("{NAME}.000, record 2 at byte ")) && text.contains(why), "{text}");
    }
    let (mut dry, ring) = bare(1);
    cover(&mut dry, &ring);
    let (mut nowhere, ring) = bare(1);
    water(&mut nowhere, &ring, "5");
    for cell in [dry, nowhere] {
        shelf.put(0, cell.to_bytes().unwrap());
        let text = shelf.refused();
        assert!(text.contains("no depth areas or does not say where it has data (M_COVR)"), "{text}");
        assert!(text.contains(&format!("{NAME}.000")), "{text}");
    }
    assert!(!shelf.db.exists());
}
