//! Cells that real ones lack: bare edges, updates of every kind, re-issues, cancellations, delete markers,
//! UCS-2 names, the antimeridian, boundaries that do not close, damage.

use crate::writer::{
    Bytes, DEPARE, DRVAL1, DRVAL2, LNDARE, area, attributes, control, dsid, edge, file, frid, fspt, node,
    point, sg2d, square, vrid,
};
use charts::depth_index::{ChartTrust, Demand, DepthIndex, IndexBuilder, Leg, Water};
use charts::s57::{AttributeCode, Cell, ExchangeSet, Geometry, NamedBytes, ObjectClass, S57Error};
use units::{LatLon, LocalFrame, LocalPoint};

const NAME: &str = "NO5X0001.000";
const SOUTH_WEST: (f64, f64) = (63.0, 10.0);
const NORTH_EAST: (f64, f64) = (63.02, 10.04);

fn base() -> Vec<u8> {
    square(NAME, SOUTH_WEST, NORTH_EAST, &[])
}

fn read(base: &[u8], updates: &[Vec<u8>]) -> Result<Cell, S57Error> {
    let names: Vec<String> = (1..=updates.len()).map(|at| format!("NO5X0001.{at:03}")).collect();
    let updates: Vec<NamedBytes<'_>> =
        names.iter().zip(updates).map(|(name, bytes)| NamedBytes { name, bytes }).collect();
    Cell::read(NamedBytes { name: NAME, bytes: base }, &updates)
}

fn update(number: &str, records: &[Vec<(&'static str, Vec<u8>)>]) -> Vec<u8> {
    let mut all = vec![dsid(true, NAME, "1", number)];
    all.extend_from_slice(records);
    file(&all)
}

fn depare(cell: &Cell) -> &charts::s57::Feature {
    cell.of_class(ObjectClass::DEPARE).next().unwrap()
}

#[test]
fn bare_edges_are_straight_lines_between_their_nodes() {
    let cell = read(&base(), &[]).unwrap();
    assert!(cell.skin_check().holds(), "{:?}", cell.skin_check());
    let Geometry::Area(area) = &depare(&cell).geometry else { panic!("{:?}", depare(&cell)) };
    assert_eq!(area.exteriors[0].points.len(), 5);
    assert!((area.area_deg2() - 0.02 * 0.04).abs() < 1e-12);
    assert!(area.exteriors[0].signed_area_deg2() < 0.0, "exteriors run clockwise");
    assert_eq!((cell.id.band, cell.parameters.scale), (5, 10_000));
}

#[test]
fn updates_insert_change_and_delete_everything() {
    let mut changed = frid(2, 3, DEPARE, 2, 3);
    changed.push(attributes(&[(DRVAL1, "4.5"), (DRVAL2, "\u{7F}")]));
    let first = update(
        "1",
        &[
            // The case that GDAL gets wrong (OSGeo/gdal 5306): vertices for an edge that had none, no SGCC.
            vec![vrid(130, 1, 2, 3), sg2d(&[(63.005, 9.999), (63.015, 9.999)])],
            changed,
            node(9, (63.01, 10.02)),
            point(9, 153, &[(179, "1.2"), (187, "3")], 9),
        ],
    );
    let cell = read(&base(), std::slice::from_ref(&first)).unwrap();
    assert_eq!(cell.id.update, "1");
    assert_eq!(depare(&cell).number(AttributeCode::DRVAL1), Some(4.5));
    assert_eq!(depare(&cell).text(AttributeCode::DRVAL2), None);
    let vertices = |cell: &Cell| depare(cell).geometry.points().count();
    assert_eq!(vertices(&cell), 7);
    assert_eq!(cell.of_class(ObjectClass::UWTROC).count(), 1);
    let second = update(
        "2",
        &[
            vec![
                vrid(130, 1, 3, 3),
                control("SGCC", 2, 1, 1),
                control("SGCC", 3, 1, 1),
                sg2d(&[(63.012, 9.998)]),
            ],
            frid(9, 1, 153, 2, 2),
        ],
    );
    let cell = read(&base(), &[first, second]).unwrap();
    assert_eq!(vertices(&cell), 6);
    assert!(depare(&cell).geometry.points().any(|point| (point.lon_deg - 9.998).abs() < 1e-12));
    assert_eq!(cell.of_class(ObjectClass::UWTROC).count(), 0);
    assert!(cell.notices.is_empty(), "{:?}", cell.notices);
}

#[test]
fn updates_change_the_pointers_of_a_feature() {
    let hole = [node(5, (63.005, 10.01)), node(6, (63.01, 10.01)), node(7, (63.005, 10.02))];
    let mut records = hole.to_vec();
    records.extend([edge(5, 5, 6, &[]), edge(6, 6, 7, &[]), edge(7, 7, 5, &[])]);
    let ring = [(5, 1, 2), (6, 1, 2), (7, 1, 2)];
    let mut cut = frid(2, 3, DEPARE, 2, 3);
    cut.extend([control("FSPC", 1, 5, 3), fspt(&ring)]);
    records.push(cut);
    let island = ring.map(|(edge, orientation, _)| (edge, orientation, 1));
    records.push(area(8, LNDARE, &[(116, "Holm")], &island));
    let cell = read(&base(), &[update("1", &records)]).unwrap();
    let Geometry::Area(area) = &depare(&cell).geometry else { panic!("{:?}", depare(&cell)) };
    assert_eq!(area.holes.len(), 1);
    assert!(area.holes[0].signed_area_deg2() > 0.0, "holes run anticlockwise");
    assert!(cell.skin_check().holds());
}

#[test]
fn a_feature_without_attributes_gets_some() {
    let mut plain = frid(3, 255, 400, 1, 1);
    plain.truncate(2);
    let bytes = square(NAME, SOUTH_WEST, NORTH_EAST, &[plain]);
    let mut changed = frid(3, 255, 400, 2, 3);
    changed.push(attributes(&[(116, "Group")]));
    let cell = read(&bytes, &[update("1", &[changed])]).unwrap();
    let group = cell.of_class(ObjectClass(400)).next().unwrap();
    assert_eq!(group.text(AttributeCode::OBJNAM), Some("Group"));
}

#[test]
fn updates_that_do_not_fit_are_refused_with_the_remedy() {
    let says = |base: &[u8], updates: &[Vec<u8>]| read(base, updates).unwrap_err().to_string();
    let empty = |number: &str| update(number, &[]);
    let text = says(&base(), &[empty("2")]);
    assert!(text.starts_with("NO5X0001.001, record 1 at byte "), "{text}");
    assert!(text.ends_with(
        "this is update 2, but the next must be update 1; \
         fetch the missing update, or the newest re-issue of the base cell"
    ));
    assert!(says(&base(), &[empty("1"), empty("1")]).contains("this is update 1"));
    let other_edition = file(&[dsid(true, NAME, "2", "1")]);
    assert!(says(&base(), &[other_edition]).contains("edition 2, but the cell is edition 1; fetch the base"));
    let other_cell = file(&[dsid(true, "NO5X0002.000", "1", "1")]);
    assert!(says(&base(), &[other_cell]).contains("for cell NO5X0002.000"));
    assert!(says(&base(), &[base()]).contains("a base cell, not an update"));
    assert!(says(&empty("1"), &[]).contains("is an update, not a base cell"));
    let cancelled = file(&[dsid(true, NAME, "0", "1")]);
    assert!(says(&base(), &[cancelled]).contains("cancelled"));
    assert!(
        says(&base(), &[update("1", &[frid(77, 3, DEPARE, 2, 2)])]).contains("feature 77 is to be changed")
    );
    let beyond = vec![vrid(130, 1, 2, 3), control("SGCC", 2, 1, 9)];
    assert!(says(&base(), &[update("1", &[beyond])]).contains("beyond the end of a list"));
    let mixed = vec![vrid(110, 1, 1, 1), sg2d(&[(63.0, 10.0)]), ("SG3D", vec![0; 12])];
    assert!(says(&file(&[dsid(false, NAME, "1", "0"), mixed]), &[]).contains("with and without depths"));
    let lost = vec![vrid(130, 1, 2, 3), control("SGCC", 1, 1, 1)];
    assert!(says(&base(), &[update("1", &[lost])]).contains("another number of items"));
}

#[test]
fn a_reissue_contains_its_updates() {
    let mut records = crate::writer::square_records(NAME, SOUTH_WEST, NORTH_EAST, &[]);
    records[0] = dsid(false, NAME, "1", "2");
    let reissue = file(&records);
    let cell = read(&reissue, &[update("1", &[]), update("2", &[]), update("3", &[])]).unwrap();
    assert_eq!(cell.id.update, "3");
    assert_eq!(cell.notices.len(), 2, "{:?}", cell.notices);
    assert!(read(&reissue, &[update("4", &[])]).is_err());
}

#[test]
fn national_names_are_read_from_ucs_2() {
    let mut named = point(9, 153, &[(187, "4")], 3);
    named.insert(3, ("NATF", Bytes::default().u16(301).ucs2("Sørøya ᚠ").u16(300).ucs2("fare").0));
    let cell = read(&square(NAME, SOUTH_WEST, NORTH_EAST, &[named]), &[]).unwrap();
    let rock = cell.of_class(ObjectClass::UWTROC).next().unwrap();
    assert_eq!(rock.text(AttributeCode::NOBJNM), Some("Sørøya ᚠ"));
    assert_eq!(rock.national.len(), 2);
}

#[test]
fn a_boundary_that_does_not_close_is_told_and_is_no_water() {
    let bytes = square(NAME, SOUTH_WEST, NORTH_EAST, &[area(5, 86, &[(179, "30")], &[(1, 1, 1), (2, 1, 1)])]);
    let cell = read(&bytes, &[]).unwrap();
    assert_eq!(cell.notices.len(), 1);
    assert!(cell.notices[0].text.contains("OBSTRN 5 has no readable geometry: its boundary does not close"));
    let index = index(&[cell]);
    // Its box is that of the cell, so all of it counts as a danger of unknown depth.
    let answer = index.depth_at(place(63.001, 10.03), &Demand::default());
    assert_eq!((answer.water, answer.navigable), (Water::UnknownDepth, false));
}

fn index(cells: &[Cell]) -> DepthIndex {
    let mut builder = IndexBuilder::new();
    for cell in cells {
        builder.add_cell(cell).unwrap();
    }
    builder.build().unwrap()
}

fn place(lat_deg: f64, lon_deg: f64) -> LatLon {
    LatLon::from_deg(lat_deg, lon_deg).unwrap()
}

#[test]
fn cells_meet_at_the_antimeridian() {
    let west = square("NO5X0001.000", (0.0, 179.99), (0.01, 180.0), &[]);
    let east = square("NO5X0002.000", (0.0, -180.0), (0.01, -179.99), &[]);
    let cells = [("NO5X0001.000", &west), ("NO5X0002.000", &east)]
        .map(|(name, bytes)| Cell::read(NamedBytes { name, bytes }, &[]).unwrap());
    let index = index(&cells);
    let demand = Demand::least_depth(2.0);
    let leg = Leg { from: place(0.005, 179.995), to: place(0.005, -179.995) };
    let answer = index.shallowest_along(leg, 20.0, &demand);
    assert_eq!(answer.water, Water::Depth { least_m: 5.0, greatest_m: Some(10.0) });
    assert_eq!((answer.margin_m, answer.navigable), (Some(3.0), true));
    // Beyond the eastern cell there is nothing: 0.005 degrees of the equator less the half width.
    let beyond = Leg { from: leg.from, to: place(0.005, -179.98) };
    let danger = index.first_danger_along(beyond, 20.0, &demand).unwrap();
    assert_eq!(danger.water, Water::NoData);
    assert!((danger.along_m - (0.015 * 111_319.49 - 20.0)).abs() < 0.2, "{danger:?}");
    let near = index.distance_to_shallower(place(0.005, -179.999), 2.0, 5_000.0).unwrap();
    assert!((near.distance_m - 0.005 * 110_574.3).abs() < 0.2, "{near:?}");
}

#[test]
fn dangers_without_a_depth_block_and_margins_follow_the_demand() {
    let more = [
        node(11, (63.01, 10.01)),
        point(11, 153, &[(187, "4")], 11),
        node(12, (63.01, 10.02)),
        point(12, 86, &[(187, "3"), (93, "1")], 12),
        node(13, (63.01, 10.03)),
        point(13, 159, &[(179, "3.5"), (116, "Wreck")], 13),
        area(14, 308, &[(72, "3")], &[(1, 1, 1), (2, 1, 1), (3, 1, 1), (4, 2, 1)]),
        vec![vrid(130, 15, 1, 1), edge(15, 1, 3, &[])[1].clone()],
        {
            let mut bridge = frid(15, 2, 11, 1, 1);
            bridge.extend([attributes(&[(181, "3.0")]), fspt(&[(15, 1, 255)])]);
            bridge
        },
    ];
    let cell = read(&square(NAME, SOUTH_WEST, NORTH_EAST, &more), &[]).unwrap();
    assert!(cell.notices.is_empty(), "{:?}", cell.notices);
    let index = index(&[cell]);
    let demand =
        Demand { draught_m: 0.5, squat_m: 0.1, reserve_m: 0.4, water_level_m: 0.2, ..Demand::default() };
    let at = |lon_deg: f64| index.shallowest_within(place(63.01, lon_deg), 10.0, &demand);
    assert_eq!((at(10.01).water, at(10.01).navigable), (Water::UnknownDepth, false));
    assert_eq!(at(10.02).water.least_m(), Some(5.0), "EXPSOU 1: the area's depth holds");
    let wreck = at(10.03);
    assert_eq!(wreck.water.least_m(), Some(3.5));
    assert!((wreck.margin_m.unwrap() - 2.7).abs() < 1e-9);
    let object = index.object(wreck.object.unwrap()).unwrap();
    assert_eq!(
        (object.name.as_deref(), index.source(&object).scale, wreck.zone),
        (Some("Wreck"), 10_000, Some(3))
    );
    let careful = Demand { trust: ChartTrust::AllErrors(ChartTrust::STANDARD), ..demand };
    // Zone B: 1 m and 2 %, positions within 50 m.
    let wide = index.shallowest_within(place(63.01, 10.03), 10.0, &careful);
    assert!((wide.margin_m.unwrap() - (2.7 - 1.0 - 0.02 * 3.5)).abs() < 1e-9, "{wide:?}");
    assert!(wide.half_width_m > 60.0);
    // The rock is 508 m from the obstruction; the bridge runs from corner to corner.
    let leg = Leg { from: place(63.018, 10.001), to: place(63.018, 10.0395) };
    assert!(index.first_danger_along(leg, 5.0, &demand).is_none());
    let tall = Demand { air_draught_m: Some(3.5), ..demand };
    let under = index.first_danger_along(leg, 5.0, &tall).unwrap();
    assert_eq!(under.water, Water::TooLow { clearance_m: Some(3.0) });
    let low = Demand { air_draught_m: Some(2.0), ..demand };
    assert!(index.first_danger_along(leg, 5.0, &low).is_none());
    let interest = index.points_of_interest(place(63.01, 10.029), 2, 5_000.0, |_| true);
    let classes: Vec<_> =
        interest.iter().map(|one| index.object(one.object.unwrap()).unwrap().class).collect();
    assert_eq!(classes, [ObjectClass::WRECKS, ObjectClass::OBSTRN]);
    assert!(!index.depth_at(place(63.03, 10.01), &Demand::default()).navigable, "no data is never navigable");
    let nothing = Demand { draught_m: f64::NAN, ..Demand::default() };
    assert!(
        !index.depth_at(place(63.001, 10.03), &nothing).navigable,
        "a demand that is not a number is not met"
    );
}

#[test]
fn of_several_things_overhead_the_lowest_counts() {
    let over = |number: u32, clearance: &str| {
        let attributes: &[(u16, &str)] = if clearance.is_empty() { &[] } else { &[(181, clearance)] };
        area(number, 11, attributes, &[(1, 1, 1), (2, 1, 1), (3, 1, 1), (4, 2, 1)])
    };
    for (heights, lowest) in [
        (["3.0", "12.0"], Some(3.0)),
        (["12.0", "3.0"], Some(3.0)),
        (["", "12.0"], None),
        (["12.0", ""], None),
    ] {
        let more = [over(14, heights[0]), over(15, heights[1])];
        let cell = read(&square(NAME, SOUTH_WEST, NORTH_EAST, &more), &[]).unwrap();
        let index = index(&[cell]);
        let demand = Demand { air_draught_m: Some(5.0), ..Demand::default() };
        let (at, to) = (place(63.01, 10.01), place(63.01, 10.012));
        let too_low = Water::TooLow { clearance_m: lowest };
        assert_eq!(index.depth_at(at, &demand).water, too_low, "{heights:?}");
        let leg = Leg { from: at, to };
        assert_eq!(index.shallowest_along(leg, 5.0, &demand).water, too_low, "{heights:?}");
        assert_eq!(index.first_danger_along(leg, 5.0, &demand).unwrap().water, too_low, "{heights:?}");
        let everything = Demand { air_draught_m: None, ..demand };
        assert!(index.shallowest_along(leg, 5.0, &everything).navigable);
    }
}

#[test]
fn what_nobody_assessed_counts_as_far_as_it_may_be_wrong() {
    let more = [
        node(11, (63.001, 10.001)),
        node(12, (63.010, 10.001)),
        node(13, (63.010, 10.039)),
        node(14, (63.001, 10.039)),
        edge(11, 11, 12, &[]),
        edge(12, 12, 13, &[]),
        edge(13, 13, 14, &[]),
        edge(14, 14, 11, &[]),
        area(14, 308, &[(72, "1")], &[(11, 1, 1), (12, 1, 1), (13, 1, 1), (14, 1, 1)]),
    ];
    let cell = read(&square(NAME, SOUTH_WEST, NORTH_EAST, &more), &[]).unwrap();
    assert!(cell.notices.is_empty(), "{:?}", cell.notices);
    let index = index(&[cell]);
    let zone = |lat_deg: f64, trust: ChartTrust| {
        let demand = Demand { trust, ..Demand::default() };
        let leg = Leg { from: place(lat_deg, 10.018), to: place(lat_deg, 10.022) };
        index.shallowest_along(leg, 5.0, &demand).zone
    };
    let depths = ChartTrust::DepthErrors(ChartTrust::STANDARD);
    // 500 m from the border of zone A1, 3 m from it, beyond it.
    assert_eq!([63.0055, 63.00997, 63.015].map(|lat| zone(lat, depths)), [Some(1), Some(6), Some(6)]);
    // What was not assessed may lie 1000 m from where it is charted.
    assert_eq!(zone(63.0055, ChartTrust::AllErrors(ChartTrust::STANDARD)), Some(6));
}

#[test]
fn a_coarse_cell_answers_only_where_no_finer_one_does() {
    let shoal = [node(11, (63.01, 10.02)), point(11, 153, &[(179, "0.5")], 11)];
    let mut coarse = crate::writer::square_records("NO4X0001.000", (62.9, 9.9), (63.1, 10.1), &[]);
    let scale = coarse[0][0].1.iter().position(|byte| *byte == 5).unwrap();
    coarse[0][0].1[scale] = 4;
    let changed =
        area(2, DEPARE, &[(DRVAL1, "1"), (DRVAL2, "2")], &[(1, 1, 1), (2, 1, 1), (3, 1, 1), (4, 2, 1)]);
    coarse[11] = changed;
    coarse.extend(shoal);
    let cells = [("NO4X0001.000", file(&coarse)), ("NO5X0001.000", base())]
        .map(|(name, bytes)| Cell::read(NamedBytes { name, bytes: &bytes }, &[]).unwrap());
    let index = index(&cells);
    let least = |lat_deg, radius_m| {
        let answer = index.shallowest_within(place(lat_deg, 10.02), radius_m, &Demand::default());
        (answer.water.least_m().unwrap(), index.source(&index.object(answer.object.unwrap()).unwrap()).band)
    };
    assert_eq!(least(63.01, 100.0), (5.0, 5), "the coarse cell's rock is not there in the finer one");
    assert_eq!(least(63.03, 10.0), (1.0, 4));
    // 0.001 degrees north of the border: 111.5 m.
    assert_eq!(least(63.019, 111.0), (5.0, 5));
    assert_eq!(least(63.019, 112.0), (1.0, 4));
    assert_eq!(least(63.021, 112.0), (1.0, 4));
}

/// A cell of band 4 round the square, 5 to 10 m deep like it.
fn coarse() -> Vec<(&'static str, Vec<u8>)> {
    let mut head = dsid(false, "NO4X0001.000", "1", "0");
    let band = head[0].1.iter().position(|byte| *byte == 5).unwrap();
    head[0].1[band] = 4;
    head
}

#[test]
fn a_gap_at_the_border_of_a_finer_cell_is_no_data_from_without_too() {
    let mut around = crate::writer::square_records("NO4X0001.000", (62.9, 9.9), (63.1, 10.1), &[]);
    around[0] = coarse();
    let mut fine = crate::writer::square_records(NAME, SOUTH_WEST, NORTH_EAST, &[]);
    // The water leaves out a notch at the northern border; the border itself has no vertex there, and its middle is
    // beside the notch.
    fine.extend([
        node(5, (63.02, 10.025)),
        node(6, (63.015, 10.025)),
        node(7, (63.015, 10.03)),
        node(8, (63.02, 10.03)),
        edge(5, 2, 5, &[]),
        edge(6, 5, 6, &[]),
        edge(7, 6, 7, &[]),
        edge(8, 7, 8, &[]),
        edge(9, 8, 3, &[]),
    ]);
    let ring = [(1, 1, 1), (5, 1, 1), (6, 1, 1), (7, 1, 1), (8, 1, 1), (9, 1, 1), (3, 1, 1), (4, 2, 1)];
    fine[11] = area(2, DEPARE, &[(DRVAL1, "5"), (DRVAL2, "10")], &ring);
    let cells = [("NO4X0001.000", file(&around)), (NAME, file(&fine))]
        .map(|(name, bytes)| Cell::read(NamedBytes { name, bytes: &bytes }, &[]).unwrap());
    let index = index(&cells);
    let demand = Demand::least_depth(2.0);
    assert_eq!(index.depth_at(place(63.018, 10.0275), &demand).water, Water::NoData);
    // 111.5 m north of the border, and 125 m from the sides of the notch when it is in it.
    let leg = |lon_deg: f64| Leg { from: place(63.021, lon_deg), to: place(63.0185, lon_deg) };
    let danger = index.first_danger_along(leg(10.0275), 1.0, &demand).unwrap();
    assert_eq!(danger.water, Water::NoData);
    assert!((danger.along_m - 110.5).abs() < 0.5, "{danger:?}");
    let near = index.distance_to_shallower(place(63.021, 10.0275), 2.0, 1_000.0).unwrap();
    assert!((near.distance_m - 111.5).abs() < 0.5, "{near:?}");
    for beside in [10.024, 10.031] {
        assert!(index.first_danger_along(leg(beside), 1.0, &demand).is_none(), "{beside}");
    }
}

#[test]
fn structures_in_the_water_are_obstacles() {
    for class in ["LNDMRK", "BUISGL", "SILTNK", "CRANES", "FORSTC"] {
        let code = ObjectClass::from_acronym(class).unwrap().0;
        let more = [
            node(11, (63.01, 10.01)),
            point(11, code, &[], 11),
            node(12, (63.01, 10.03)),
            node(13, (63.012, 10.03)),
            node(14, (63.012, 10.032)),
            edge(12, 12, 13, &[]),
            edge(13, 13, 14, &[]),
            edge(14, 14, 12, &[]),
            area(12, code, &[], &[(12, 1, 1), (13, 1, 1), (14, 1, 1)]),
        ];
        let cell = read(&square(NAME, SOUTH_WEST, NORTH_EAST, &more), &[]).unwrap();
        assert!(cell.notices.is_empty(), "{:?}", cell.notices);
        let index = index(&[cell]);
        let demand = Demand::least_depth(2.0);
        let water = |lat_deg, lon_deg| index.shallowest_within(place(lat_deg, lon_deg), 5.0, &demand).water;
        assert_eq!(water(63.01, 10.01), Water::Obstacle, "{class}");
        assert_eq!(water(63.0115, 10.0305), Water::Obstacle, "{class}");
        assert_eq!(water(63.01, 10.02).least_m(), Some(5.0), "{class}");
        // The buildings of a town are not listed by name.
        assert!(index.points_of_interest(place(63.01, 10.01), 9, 5_000.0, |_| true).is_empty());
    }
}

#[test]
fn what_has_no_position_is_told() {
    let lost = frid(11, 1, 153, 1, 1);
    let group = frid(12, 255, 400, 1, 1);
    let astray = point(13, 86, &[(179, "1")], 99);
    let cell = read(&square(NAME, SOUTH_WEST, NORTH_EAST, &[lost, group, astray]), &[]).unwrap();
    let told: Vec<_> = cell.notices.iter().map(|one| (one.feature, one.text.as_str())).collect();
    assert_eq!(
        told,
        [
            (Some(11), "UWTROC 11 has no position: it is in the cell, but nowhere on the chart"),
            (Some(13), "OBSTRN 13 has no readable geometry: node 99 is not there"),
        ]
    );
}

#[test]
fn exchange_sets_are_read_whole_and_tell_what_is_wrong() {
    let entry = |id: u32, name: &str, crc: u32| {
        let bytes = Bytes::default()
            .fixed("CD")
            .fixed(&format!("{id:010}"))
            .text(name)
            .text("")
            .text("V01X01")
            .fixed("BIN");
        let bytes =
            bytes.text("63.0").text("10.0").text("63.02").text("10.04").text(&format!("{crc:08X}")).text("");
        vec![("CATD", bytes.0)]
    };
    let (cell, first, text) = (base(), update("1", &[]), b"Beware".to_vec());
    // CRC-32 of "Beware" is not 1: a text with a wrong checksum is reported, and does not stop the reading.
    let catalogue = file(&[entry(1, "NO5X0001\\NO5X0001.TXT", 1), entry(2, "NO5X0009\\NO5X0009.000", 0)]);
    let gap = update("3", &[]);
    let files = [
        ("ENC_ROOT/CATALOG.031", &catalogue),
        ("ENC_ROOT/NO5X0001/NO5X0001.000", &cell),
        ("ENC_ROOT/NO5X0001/NO5X0001.001", &first),
        ("ENC_ROOT/NO5X0001/NO5X0001.TXT", &text),
        ("ENC_ROOT/NO5X0003/NO5X0003.001", &first),
        ("ENC_ROOT/NO5X0004/NO5X0004.000", &text),
    ];
    let mut files: Vec<NamedBytes<'_>> =
        files.iter().map(|(name, bytes)| NamedBytes { name, bytes }).collect();
    let set = ExchangeSet::read(&files);
    assert_eq!(set.catalogue.as_ref().unwrap().entries.len(), 2);
    assert_eq!(set.catalogue.as_ref().unwrap().entries[0].limits_deg, Some([63.0, 10.0, 63.02, 10.04]));
    assert_eq!(set.cells.len(), 1);
    assert_eq!((set.cells[0].id.update.as_str(), set.failures.len(), set.notices.len()), ("1", 2, 2));
    let failures: Vec<String> = set.failures.iter().map(|one| one.error.to_string()).collect();
    assert!(failures[0].contains("no base cell"), "{failures:?}");
    assert!(failures[1].contains("NO5X0004.000"), "{failures:?}");
    files.push(NamedBytes { name: "ENC_ROOT/NO5X0001/NO5X0001.003", bytes: &gap });
    let set = ExchangeSet::read(&files);
    assert!(set.cells.is_empty() && set.failures[0].error.to_string().contains("fetch the missing update"));
}

#[test]
fn damaged_files_are_errors_and_never_worse() {
    let whole = square(NAME, SOUTH_WEST, NORTH_EAST, &[point(9, 153, &[(187, "4")], 3)]);
    let first = update("1", &[vec![vrid(130, 1, 2, 3), control("SGCC", 2, 1, 1)]]);
    for at in 0..whole.len() {
        if let Err(error) = read(&whole[..at], &[]) {
            assert!(error.to_string().contains(NAME), "{error}");
        }
        for bit in [0, 3, 7] {
            let mut changed = whole.clone();
            changed[at] ^= 1 << bit;
            if let Ok(cell) = read(&changed, std::slice::from_ref(&first)) {
                let index = index(&[cell]);
                index.shallowest_within(place(63.01, 10.02), 50.0, &Demand::default());
            }
        }
    }
}

#[test]
fn a_frame_round_a_place_finds_the_danger_at_its_distance() {
    let more = [node(11, (63.01, 10.02)), point(11, 153, &[(187, "4")], 11)];
    let index = index(&[read(&square(NAME, SOUTH_WEST, NORTH_EAST, &more), &[]).unwrap()]);
    let rock = place(63.01, 10.02);
    let frame = LocalFrame::new(rock);
    for bearing in 0..8 {
        let bearing_rad = f64::from(bearing) * std::f64::consts::FRAC_PI_4;
        let from = frame.to_place(LocalPoint::default().displaced(bearing_rad, 400.0));
        let leg = Leg { from, to: frame.to_place(LocalPoint::default().displaced(bearing_rad, -400.0)) };
        let danger = index.first_danger_along(leg, 25.0, &Demand::least_depth(1.0)).unwrap();
        assert!((danger.along_m - 375.0).abs() < 0.15, "{bearing}: {danger:?}");
        let near = index.distance_to_shallower(from, 1.0, 1_000.0).unwrap();
        assert!((near.distance_m - 400.0).abs() < 0.02, "{bearing}: {near:?}");
        assert!(index.shallowest_within(from, 399.8, &Demand::least_depth(1.0)).navigable);
        assert!(!index.shallowest_within(from, 400.1, &Demand::least_depth(1.0)).navigable);
    }
}
