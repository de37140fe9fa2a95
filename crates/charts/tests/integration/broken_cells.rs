//! Cells that are whole as files and wrong as charts, of the kinds that validation by IHO S-58 looks for: a danger whose
//! node or edge an update deletes, objects without a place, edges round the globe. None may make a danger vanish.

use charts::depth_index::{Demand, IndexBuilder, Leg, unsafe_to_use};
use charts::s57::write::{
    CellDraft, FeatureChange, FeatureDraft, ListEdit, UpdateDraft, VectorChange, VectorRef,
};
use charts::s57::{AttributeCode, Cell, GeoPoint, NamedBytes, ObjectClass, S57Error, S57Problem, Sounding};
use units::LatLon;

const NAME: &str = "NO5X0002.000";
const ROCK: (f64, f64) = (63.01, 10.02);

fn at((lat_deg, lon_deg): (f64, f64)) -> GeoPoint {
    GeoPoint { lon_deg, lat_deg }
}

/// A square of water of 20 m with its sides.
fn water() -> (CellDraft, [VectorRef; 4]) {
    let mut cell = CellDraft::new(NAME, 5, 10_000);
    let nodes = [(63.0, 10.0), (63.02, 10.0), (63.02, 10.04), (63.0, 10.04)]
        .map(|corner| cell.records.connected_node(at(corner)));
    let sides = [0, 1, 2, 3].map(|one| cell.records.edge(nodes[one], nodes[(one + 1) % 4], &[]));
    let ring: Vec<_> = sides.iter().map(|side| side.forward()).collect();
    cell.records.feature(FeatureDraft::area(ObjectClass::M_COVR, &ring).with(AttributeCode::CATCOV, "1"));
    cell.records.feature(FeatureDraft::area(ObjectClass::DEPARE, &ring).with(AttributeCode::DRVAL1, "20"));
    (cell, nodes)
}

fn read(cell: &CellDraft, updates: &[&UpdateDraft]) -> Result<Cell, S57Error> {
    let base = cell.to_bytes().unwrap();
    let files: Vec<_> = updates
        .iter()
        .enumerate()
        .map(|(at, update)| (format!("NO5X0002.{:03}", at + 1), update.to_bytes().unwrap()))
        .collect();
    let updates: Vec<_> = files.iter().map(|(name, bytes)| NamedBytes { name, bytes }).collect();
    Cell::read(NamedBytes { name: NAME, bytes: &base }, &updates)
}

/// Whether a leg of some 500 m from west to east, past a place, is safe for 5 m.
fn is_safe_past(cell: &Cell, (lat, lon): (f64, f64)) -> bool {
    let mut builder = IndexBuilder::new();
    builder.add_cell(cell).unwrap();
    let index = builder.build().unwrap();
    let place = |lon| LatLon::from_deg(lat, lon).unwrap();
    let leg = Leg { from: place(lon - 0.005), to: place(lon + 0.005) };
    index.shallowest_along(leg, 10.0, &Demand::least_depth(5.0)).navigable
}

/// An update that takes something of the cell away by itself, without the object that lies there.
fn after(cell: &CellDraft, change: impl FnOnce(&mut UpdateDraft)) -> Cell {
    let mut update = UpdateDraft::new(cell, 1);
    change(&mut update);
    read(cell, &[&update]).unwrap()
}

#[test]
fn a_danger_whose_node_is_deleted_stays_where_it_was() {
    let (mut cell, _) = water();
    let node = cell.records.isolated_node(at(ROCK));
    cell.records.feature(FeatureDraft::point(ObjectClass::UWTROC, node));
    let before = read(&cell, &[]).unwrap();
    assert!(!is_safe_past(&before, ROCK) && is_safe_past(&before, (63.005, 10.02)));

    let gone = after(&cell, |update| update.records.delete_vector(node));
    assert!(!is_safe_past(&gone, ROCK), "{:?}", gone.notices);
    // It may lie a little beside; further off the water is what it was.
    assert!(!is_safe_past(&gone, (ROCK.0 + 0.0007, ROCK.1)), "80 m beside");
    assert!(is_safe_past(&gone, (ROCK.0 + 0.002, ROCK.1)), "220 m beside");
    assert!(gone.notices.iter().any(|one| one.text.contains("has no readable geometry")));
    assert_eq!(unsafe_to_use(&gone, &gone.skin_check()), None);

    let emptied = after(&cell, |update| {
        update
            .records
            .change_vector(VectorChange::of(node).vertices(ListEdit::Delete { index: 1, count: 1 }));
    });
    assert!(!is_safe_past(&emptied, ROCK), "a node that lost its position");
}

#[test]
fn a_danger_whose_edge_is_deleted_stays_where_it_was() {
    let (mut cell, nodes) = water();
    let corners = [(63.008, 10.018), (63.012, 10.018), (63.012, 10.022), (63.008, 10.022)]
        .map(|corner| cell.records.connected_node(at(corner)));
    let sides = [0, 1, 2, 3].map(|one| cell.records.edge(corners[one], corners[(one + 1) % 4], &[]));
    let ring: Vec<_> = sides.iter().map(|side| side.forward()).collect();
    cell.records.feature(FeatureDraft::area(ObjectClass::OBSTRN, &ring));
    let bar = cell.records.edge(nodes[0], corners[0], &[at((63.004, 10.03))]);
    cell.records.feature(FeatureDraft::line(ObjectClass::OBSTRN, &[bar.forward()]));
    assert!(!is_safe_past(&read(&cell, &[]).unwrap(), ROCK));

    for side in sides {
        let gone = after(&cell, |update| update.records.delete_vector(side));
        assert!(!is_safe_past(&gone, ROCK), "without one side: {:?}", gone.notices);
    }
    let all = after(&cell, |update| sides.iter().for_each(|side| update.records.delete_vector(*side)));
    assert!(!is_safe_past(&all, ROCK), "without any side");
    let line = after(&cell, |update| update.records.delete_vector(bar));
    assert!(!is_safe_past(&line, (63.004, 10.03)), "the line's own vertices");
}

#[test]
fn soundings_whose_node_is_deleted_stay_where_they_were() {
    let (mut cell, _) = water();
    let node = cell.records.soundings(&[Sounding { at: at(ROCK), depth_m: 1.5 }]);
    cell.records.feature(FeatureDraft::point(ObjectClass::SOUNDG, node));
    assert!(!is_safe_past(&read(&cell, &[]).unwrap(), ROCK));
    assert!(!is_safe_past(&after(&cell, |update| update.records.delete_vector(node)), ROCK));
}

#[test]
fn a_danger_that_an_update_leaves_without_a_place_stays_where_it_was() {
    let (mut cell, nodes) = water();
    let bar = cell.records.edge(nodes[0], nodes[2], &[at(ROCK)]);
    let danger = cell.records.feature(FeatureDraft::line(ObjectClass::OBSTRN, &[bar.forward()]));
    let gone = after(&cell, |update| {
        let edges = ListEdit::Delete { index: 1, count: 1 };
        update.records.change_feature(FeatureChange::of(danger).edges(edges));
    });
    assert!(!is_safe_past(&gone, ROCK), "{:?}", gone.notices);
}

#[test]
fn a_danger_that_never_had_a_place_is_named() {
    let (mut cell, _) = water();
    cell.records.feature(FeatureDraft::collection(ObjectClass::WRECKS));
    let read = read(&cell, &[]).unwrap();
    let problem = unsafe_to_use(&read, &read.skin_check());
    assert_eq!(problem, Some(S57Problem::Nowhere { class: ObjectClass::WRECKS, record: 3 }));
}

#[test]
fn an_edge_round_the_globe_is_refused() {
    let mut cell = CellDraft::new(NAME, 1, 10_000_000);
    let nodes = [(10.0, -170.0), (20.0, -170.0), (20.0, 170.0), (10.0, 170.0)]
        .map(|corner| cell.records.connected_node(at(corner)));
    let sides = [0, 1, 2, 3].map(|one| cell.records.edge(nodes[one], nodes[(one + 1) % 4], &[]));
    let ring: Vec<_> = sides.iter().map(|side| side.forward()).collect();
    cell.records.feature(FeatureDraft::area(ObjectClass::DEPARE, &ring).with(AttributeCode::DRVAL1, "20"));
    let refused = read(&cell, &[]).unwrap_err();
    assert!(matches!(refused.problem, S57Problem::Span { class: ObjectClass::DEPARE, .. }), "{refused}");
    assert!(refused.to_string().contains("more than 180 degrees of longitude"), "{refused}");
}

#[test]
fn rapids_waterfalls_gridirons_and_new_objects_are_in_the_way() {
    for class in [ObjectClass::RAPIDS, ObjectClass::WATFAL, ObjectClass::GRIDRN, ObjectClass::NEWOBJ] {
        let (mut cell, nodes) = water();
        let line = cell.records.edge(nodes[0], nodes[2], &[at(ROCK)]);
        cell.records.feature(FeatureDraft::line(class, &[line.forward()]));
        assert!(!is_safe_past(&read(&cell, &[]).unwrap(), ROCK), "{class}");
    }
}

#[test]
fn on_the_border_the_shallower_side_counts() {
    let mut cell = CellDraft::new(NAME, 5, 10_000);
    let corners = [(63.0, 10.0), (63.02, 10.0), (63.02, 10.02), (63.02, 10.04), (63.0, 10.04), (63.0, 10.02)];
    let nodes = corners.map(|corner| cell.records.connected_node(at(corner)));
    let sides = [0, 1, 2, 3, 4, 5].map(|one| cell.records.edge(nodes[one], nodes[(one + 1) % 6], &[]));
    let middle = cell.records.edge(nodes[2], nodes[5], &[]);
    let all: Vec<_> = sides.iter().map(|side| side.forward()).collect();
    cell.records.feature(FeatureDraft::area(ObjectClass::M_COVR, &all).with(AttributeCode::CATCOV, "1"));
    let west = [sides[0].forward(), sides[1].forward(), middle.forward(), sides[5].forward()];
    let east = [sides[2].forward(), sides[3].forward(), sides[4].forward(), middle.reverse()];
    cell.records.feature(FeatureDraft::area(ObjectClass::DEPARE, &west).with(AttributeCode::DRVAL1, "3"));
    cell.records.feature(FeatureDraft::area(ObjectClass::DEPARE, &east).with(AttributeCode::DRVAL1, "30"));
    let cell = read(&cell, &[]).unwrap();
    let mut builder = IndexBuilder::new();
    builder.add_cell(&cell).unwrap();
    let index = builder.build().unwrap();
    let water = |lat, lon| index.depth_at(LatLon::from_deg(lat, lon).unwrap(), &Demand::default()).water;
    for step in 1..40 {
        let lat = 63.0 + f64::from(step) * 0.0005;
        assert_eq!(water(lat, 10.02).least_m(), Some(3.0), "{lat}: on the border");
        assert_eq!(water(lat, 10.020_001).least_m(), Some(30.0), "{lat}: east of it");
    }
}
