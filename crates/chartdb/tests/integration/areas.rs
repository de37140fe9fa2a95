//! No-go areas in a chart set: the depth index knows them as areas where entry is prohibited, over every chart, and a set
//! without them is the one that it was before.

use crate::support::options;
use chartdb::{
    ChartDb, ChartDbError, NO_GO_AREAS, NoGoArea, load_index, no_go_digest, no_go_digest_of, put_no_go_areas,
};
use charts::demo::SeaFloor;
use charts::depth_index::{Demand, EntryRules, Leg, Restriction};
use std::path::{Path, PathBuf};
use units::{LatLon, LocalFrame, LocalPoint, UtcTime};

const NOW: UtcTime = UtcTime::from_micros(1_790_000_000_000_000);

fn set(folder: &Path) -> PathBuf {
    let (db, cells) = (folder.join("chart.gpkg"), folder.join("cells"));
    std::fs::create_dir(&cells).unwrap();
    for file in charts::demo::archipelago().unwrap() {
        std::fs::write(cells.join(file.name), file.bytes).unwrap();
    }
    assert!(chartdb::import(&db, &[cells], &options(), &mut |_| true).unwrap().applied);
    db
}

fn origin() -> LatLon {
    LatLon::from_deg(SeaFloor::ORIGIN.lat_deg, SeaFloor::ORIGIN.lon_deg).unwrap()
}

fn at(north_m: f64, east_m: f64) -> LatLon {
    LocalFrame::new(origin()).to_place(LocalPoint { north_m, east_m })
}

fn farm() -> NoGoArea {
    let corners = vec![at(-40.0, -40.0), at(-40.0, 40.0), at(40.0, 40.0), at(40.0, -40.0)];
    NoGoArea { number: 3, name: "Lakseanlegg Ørnes".to_owned(), corners }
}

#[test]
fn nobody_sails_into_a_no_go_area_until_it_is_lifted() {
    let folder = tempfile::tempdir().unwrap();
    let db = set(folder.path());
    let digest = || ChartDb::open(&db).unwrap().digest().unwrap();
    let held = || no_go_digest_of(&ChartDb::open(&db).unwrap().charts().unwrap());
    let before = digest();
    assert_eq!(held(), no_go_digest(&[]));
    put_no_go_areas(&db, &[], NOW).unwrap();
    assert_eq!(digest(), before, "without areas nothing changes");

    put_no_go_areas(&db, &[farm()], NOW).unwrap();
    assert_eq!(held(), no_go_digest(&[farm()]));
    let with = digest();
    assert_ne!(with, before);
    let loaded = load_index(&db).unwrap();
    assert_eq!(loaded.rebuilt, None);
    let index = loaded.sealed.index;
    let demand = Demand { entry: EntryRules::default(), ..Demand::least_depth(1.0) };
    let inside = index.depth_at(origin(), &demand);
    assert!(!inside.navigable && inside.margin_m.is_some(), "its water is as deep as before: {inside:?}");
    let area = inside.area.unwrap();
    assert_eq!(area.restriction, Restriction::EntryProhibited);
    assert_eq!(index.object(area.object).unwrap().name.as_deref(), Some("Lakseanlegg Ørnes"));
    let beside = Leg { from: at(-60.0, 55.0), to: at(60.0, 55.0) };
    assert!(index.shallowest_along(beside, 10.0, &demand).navigable);
    assert!(!index.shallowest_along(beside, 16.0, &demand).navigable, "the vessel strays into it");

    // The same again changes nothing; another name does.
    put_no_go_areas(&db, &[farm()], NOW).unwrap();
    assert_eq!(digest(), with);
    let renamed = NoGoArea { name: "Farm".to_owned(), ..farm() };
    put_no_go_areas(&db, std::slice::from_ref(&renamed), NOW).unwrap();
    assert_ne!(digest(), with);
    assert_eq!(ChartDb::open(&db).unwrap().charts().unwrap().len(), 3);

    put_no_go_areas(&db, &[], NOW).unwrap();
    assert_eq!(digest(), before, "the set is the one that it was");
    assert!(load_index(&db).unwrap().sealed.index.depth_at(origin(), &demand).navigable);
}

#[test]
fn without_a_chart_set_there_is_nothing_to_put_them_in_and_nothing_of_that_name_is_overwritten() {
    let folder = tempfile::tempdir().unwrap();
    let none = folder.path().join("none.gpkg");
    assert!(matches!(put_no_go_areas(&none, &[farm()], NOW), Err(ChartDbError::Absent(_))));
    assert!(!none.exists());
    assert!(matches!(put_no_go_areas(folder.path(), &[farm()], NOW), Err(ChartDbError::Foreign(_))));
    let db = set(folder.path());
    let land = folder.path().join(format!("{NO_GO_AREAS}.geojson"));
    let ring = "[[10.0,63.0],[10.0,63.1],[10.1,63.1],[10.0,63.0]]";
    std::fs::write(&land, format!(r#"{{"type":"Polygon","coordinates":[{ring}]}}"#)).unwrap();
    assert!(chartdb::import(&db, &[land], &options(), &mut |_| true).unwrap().applied);
    let told = put_no_go_areas(&db, &[farm()], NOW).unwrap_err().to_string();
    assert!(told.contains("no-go-areas (land)"), "{told}");
}
