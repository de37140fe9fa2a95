//! Cells and updates from drafts for what the real ones lack: re-issues, cancellations, delete markers at every
//! lexical level, soundings edited in place, holes that touch, records beyond 99,999 bytes, wrong units.

use charts::depth_index::{Demand, IndexBuilder, Water};
use charts::iso8211::LexicalLevel;
use charts::s57::write::{
    CellDraft, FeatureChange, FeatureDraft, FeatureRef, ListEdit, UpdateDraft, VectorChange, VectorRef,
    VectorUse,
};
use charts::s57::{
    AttributeCode, Cell, ExchangeSet, Feature, GeoPoint, Geometry, LinkRole, NamedBytes, ObjectClass,
    S57Error, S57Problem, Sounding,
};
use units::LatLon;

const NAME: &str = "NO5X0001.000";

fn at(lat_deg: f64, lon_deg: f64) -> GeoPoint {
    GeoPoint { lon_deg, lat_deg }
}

/// A cell of one square of water, 5 to 10 m deep, and the ring round it.
struct Square {
    cell: CellDraft,
    holes: Vec<VectorUse>,
    water: FeatureRef,
}

/// `holes` are cut out of the water by a function that lays them.
fn square(holes: impl FnOnce(&mut CellDraft, [VectorRef; 4]) -> Vec<VectorUse>) -> Square {
    let mut cell = CellDraft::new(NAME, 5, 10_000);
    let corners = [at(63.0, 10.0), at(63.02, 10.0), at(63.02, 10.04), at(63.0, 10.04)];
    let nodes = corners.map(|corner| cell.records.connected_node(corner));
    let sides = [0, 1, 2, 3].map(|one| cell.records.edge(nodes[one], nodes[(one + 1) % 4], &[]));
    let ring: Vec<_> = sides.iter().map(|side| side.forward()).collect();
    let cover = FeatureDraft::area(ObjectClass::M_COVR, &ring).with(AttributeCode::CATCOV, "1");
    cell.records.feature(cover);
    let holes = holes(&mut cell, nodes);
    let bounds: Vec<_> = ring.iter().copied().chain(holes.iter().map(|edge| edge.interior())).collect();
    let water = FeatureDraft::area(ObjectClass::DEPARE, &bounds).with(AttributeCode::DRVAL1, "5");
    let water = cell.records.feature(water.with(AttributeCode::DRVAL2, "10"));
    Square { cell, holes, water }
}

fn open() -> Square {
    square(|_, _| Vec::new())
}

fn read_files(base: &[u8], updates: &[Vec<u8>]) -> Result<Cell, S57Error> {
    let names: Vec<String> = (1..=updates.len()).map(|at| format!("NO5X0001.{at:03}")).collect();
    let updates: Vec<_> = names.iter().zip(updates).map(|(name, bytes)| NamedBytes { name, bytes }).collect();
    Cell::read(NamedBytes { name: NAME, bytes: base }, &updates)
}

fn read(cell: &CellDraft, updates: &[&UpdateDraft]) -> Result<Cell, S57Error> {
    let files: Vec<_> = updates.iter().map(|update| update.to_bytes().unwrap()).collect();
    read_files(&cell.to_bytes().unwrap(), &files)
}

fn only(cell: &Cell, class: ObjectClass) -> &Feature {
    let mut all = cell.of_class(class);
    let first = all.next().unwrap();
    assert!(all.next().is_none(), "more than one {class}");
    first
}

fn depth_at(cell: &Cell, lat_deg: f64, lon_deg: f64) -> Water {
    let mut builder = IndexBuilder::new();
    builder.add_cell(cell).unwrap();
    let place = LatLon::from_deg(lat_deg, lon_deg).unwrap();
    builder.build().unwrap().depth_at(place, &Demand::default()).water
}

#[test]
fn a_re_issue_is_the_base_with_its_updates_and_takes_the_next_one() {
    let Square { mut cell, water, .. } = open();
    let mut updates = vec![UpdateDraft::new(&cell, 1)];
    let change = FeatureChange::of(water).with(AttributeCode::DRVAL1, "4");
    let first = updates[0].records.change_feature(change);
    let mut second = updates[0].next();
    let change = FeatureChange::of(first).with(AttributeCode::DRVAL1, "3");
    let changed = second.records.change_feature(change);
    let mut third = second.next();
    third.records.change_feature(FeatureChange::of(changed).with(AttributeCode::DRVAL1, "2"));
    updates.extend([second, third]);
    let all: Vec<_> = updates.iter().collect();
    let updated = read(&cell, &all).unwrap();
    // The re-issue has the object as it is after update 2, in its version, with the purpose "re-issue".
    (cell.id.purpose, cell.id.update) = (1, "2".to_owned());
    cell.records.delete_feature(water);
    let refused = read(&cell, &[]).unwrap_err();
    assert!(
        refused.to_string().contains("feature 2 is to be changed or deleted, but not there"),
        "{refused}"
    );
    let mut reissue = open();
    reissue.cell.id.update = "2".to_owned();
    let text = read(&reissue.cell, &all).unwrap();
    assert_eq!(text.id.update, "3");
    assert_eq!(only(&text, ObjectClass::DEPARE).text(AttributeCode::DRVAL1), Some("2"));
    assert_eq!(only(&updated, ObjectClass::DEPARE).text(AttributeCode::DRVAL1), Some("2"));
    // 1 and 2 are skipped; version 1 -> 4 is reported.
    assert_eq!(text.notices.len(), 3, "{:?}", text.notices);
    let gap = [all[0], all[2]];
    assert_eq!(read(&reissue.cell, &gap).unwrap().id.update, "3", "update 2 is in the re-issue");
    let problem = read(&open().cell, &gap).unwrap_err().problem;
    assert_eq!(problem, S57Problem::OutOfOrder { expected: 2, found: 3 });
    let backwards = read(&open().cell, &[all[1], all[0]]).unwrap_err().problem;
    assert_eq!(backwards, S57Problem::OutOfOrder { expected: 1, found: 2 });
}

#[test]
fn a_cancelled_cell_is_no_cell_alone_and_in_a_set() {
    let Square { cell, .. } = open();
    let mut cancel = UpdateDraft::new(&cell, 1);
    cancel.id.edition = "0".to_owned();
    assert_eq!(read(&cell, &[&cancel]).unwrap_err().problem, S57Problem::Cancelled);
    let mut whole = cell.clone();
    whole.id.edition = "0".to_owned();
    assert_eq!(read(&whole, &[]).unwrap_err().problem, S57Problem::Cancelled);
    let (base, cancel) = (cell.to_bytes().unwrap(), cancel.to_bytes().unwrap());
    let files = [("ENC_ROOT/NO5X0001.000", &base), ("ENC_ROOT/NO5X0001.001", &cancel)];
    let set = ExchangeSet::read(&files.map(|(name, bytes)| NamedBytes { name, bytes }));
    assert!(set.cells.is_empty());
    assert_eq!((set.cancelled.as_slice(), set.failures.len()), (&["NO5X0001".to_owned()][..], 0));
}

#[test]
fn delete_markers_take_attributes_away_at_every_level() {
    for (level, name) in [
        (LexicalLevel::Ascii, "Soroya"),
        (LexicalLevel::Latin1, "Sørøya"),
        (LexicalLevel::Ucs2, "Sørøya, Čáhcesuolu ἒ Ḟ"),
    ] {
        let Square { mut cell, .. } = open();
        (cell.style.attributes, cell.style.national) = (level, level);
        let node = cell.records.isolated_node(at(63.01, 10.02));
        let rock = FeatureDraft::point(ObjectClass::UWTROC, node).with(AttributeCode::VALSOU, "1.2");
        let rock = rock.with(AttributeCode::OBJNAM, name).with(AttributeCode::WATLEV, "");
        let rock = cell.records.feature(rock.national(AttributeCode::NOBJNM, name));
        let before = read(&cell, &[]).unwrap();
        let found = only(&before, ObjectClass::UWTROC);
        assert_eq!((found.text(AttributeCode::NOBJNM), found.national.len()), (Some(name), 1));
        assert_eq!(found.text(AttributeCode::WATLEV), None, "known to be unknown");
        assert_eq!(found.attributes.len(), 3);
        let mut update = UpdateDraft::new(&cell, 1);
        let change = FeatureChange::of(rock)
            .without(AttributeCode::VALSOU)
            .without(AttributeCode::QUASOU)
            .with(AttributeCode::WATLEV, "3")
            .without_national(AttributeCode::NOBJNM)
            .national(AttributeCode(300), name);
        update.records.change_feature(change);
        let after = read(&cell, &[&update]).unwrap();
        let found = only(&after, ObjectClass::UWTROC);
        let left: Vec<_> = found.attributes.iter().map(|one| (one.code, one.value.as_str())).collect();
        assert_eq!(left, [(AttributeCode::OBJNAM, name), (AttributeCode::WATLEV, "3")]);
        assert_eq!((found.national.len(), found.text(AttributeCode(300))), (1, Some(name)));
    }
}

#[test]
fn a_feature_without_any_attribute_field_is_changed_and_linked() {
    let Square { mut cell, .. } = open();
    let node = cell.records.isolated_node(at(63.01, 10.02));
    let buoy = cell.records.feature(FeatureDraft::point(ObjectClass::BOYLAT, node));
    let light = cell.records.feature(FeatureDraft::point(ObjectClass::LIGHTS, node));
    let mut update = UpdateDraft::new(&cell, 1);
    update.records.change_feature(FeatureChange::of(buoy).with(AttributeCode::OBJNAM, "Flua"));
    let link = ListEdit::Plain(vec![(buoy.object, LinkRole::Master)]);
    update.records.change_feature(FeatureChange::of(light).links(link));
    let after = read(&cell, &[&update]).unwrap();
    assert_eq!(only(&after, ObjectClass::BOYLAT).text(AttributeCode::OBJNAM), Some("Flua"));
    let light = only(&after, ObjectClass::LIGHTS);
    assert_eq!((light.links[0].to, light.links[0].role), (buoy.object, LinkRole::Master));
}

#[test]
fn soundings_are_inserted_replaced_and_deleted_in_place() {
    let Square { mut cell, .. } = open();
    let spot = |metres: i32| Sounding {
        at: at(63.001 + f64::from(metres) * 0.001, 10.02),
        depth_m: f64::from(metres) + 0.5,
    };
    let node = cell.records.soundings(&[6, 7, 8, 9].map(spot));
    cell.records.feature(FeatureDraft::point(ObjectClass::SOUNDG, node));
    let mut update = UpdateDraft::new(&cell, 1);
    let mut node = node;
    for edit in [
        ListEdit::Delete { index: 2, count: 2 },
        ListEdit::Replace { index: 1, items: vec![spot(-1)] },
        ListEdit::Insert { index: 3, items: vec![spot(3), spot(4)] },
    ] {
        node = update.records.change_vector(VectorChange::of(node).soundings(edit));
    }
    let depths = |cell: &Cell| -> Vec<f64> {
        let Geometry::Soundings(list) = &only(cell, ObjectClass::SOUNDG).geometry else { panic!() };
        list.iter().map(|one| one.depth_m).collect()
    };
    let after = read(&cell, &[&update]).unwrap();
    assert_eq!(depths(&after), [-0.5, 9.5, 3.5, 4.5]);
    assert_eq!(depth_at(&after, 63.0, 10.02), Water::Depth { least_m: 5.0, greatest_m: Some(10.0) });
    // Positions without depths do not belong into a list of soundings.
    let mut flat = update.next();
    let change = VectorChange::of(node).vertices(ListEdit::Insert { index: 1, items: vec![at(63.0, 10.0)] });
    flat.records.change_vector(change);
    let refused = read(&cell, &[&update, &flat]).unwrap_err().to_string();
    assert!(
        refused.contains("vector record 1 is given positions without depths among soundings"),
        "{refused}"
    );
}

/// Two triangles that meet at a node, and one that touches the cell's border at a corner.
fn touching(cell: &mut CellDraft, nodes: [VectorRef; 4]) -> Vec<VectorUse> {
    let records = &mut cell.records;
    let middle = records.connected_node(at(63.01, 10.02));
    let mut triangle = |corner: VectorRef, others: [(f64, f64); 2]| {
        let between = others.map(|(lat, lon)| at(lat, lon));
        let far = records.connected_node(between[0]);
        // The last edge is stored the other way round.
        let sides = [records.edge(corner, far, &[]), records.edge(corner, far, &between[1..])];
        [sides[0].forward(), sides[1].reverse()]
    };
    let first = triangle(middle, [(63.015, 10.01), (63.005, 10.01)]);
    let second = triangle(middle, [(63.015, 10.03), (63.005, 10.03)]);
    let third = triangle(nodes[0], [(63.003, 10.008), (63.001, 10.008)]);
    // Not in the order of the rings: the reader has to find what joins.
    vec![first[0], second[0], third[0], first[1], third[1], second[1]]
}

#[test]
fn holes_that_touch_are_holes_all_the_same() {
    let mut all = square(touching);
    let [a, b, c, a_back, c_back, b_back] = all.holes[..] else { panic!("three holes of two edges") };
    for [out, back] in [[a, a_back], [b, b_back], [c, c_back]] {
        let land = FeatureDraft::area(ObjectClass::LNDARE, &[out, back]);
        all.cell.records.feature(land);
    }
    let cell = read(&all.cell, &[]).unwrap();
    assert!(cell.notices.is_empty(), "{:?}", cell.notices);
    assert!(cell.skin_check().holds(), "{:?}", cell.skin_check());
    for (lat, lon) in [(63.01, 10.012), (63.01, 10.028), (63.002, 10.007)] {
        assert_eq!(depth_at(&cell, lat, lon), Water::Land, "{lat} {lon}");
    }
    for (lat, lon) in [(63.018, 10.02), (63.002, 10.02), (63.01, 10.005), (63.006, 10.002)] {
        assert_eq!(depth_at(&cell, lat, lon).least_m(), Some(5.0), "{lat} {lon}");
    }
    // At the node where they meet is land, whichever way one looks.
    assert_eq!(depth_at(&cell, 63.01, 10.02), Water::Land);
}

#[test]
fn records_beyond_what_a_leader_can_say_are_read() {
    let Square { mut cell, .. } = open();
    let many: Vec<_> = (0..20_000)
        .map(|one| {
            let (row, column) = (f64::from(one / 200), f64::from(one % 200));
            Sounding {
                at: at((630_000.0 + row) / 1e4, (100_000.0 + column) / 1e4),
                depth_m: f64::from(one % 50),
            }
        })
        .collect();
    let node = cell.records.soundings(&many);
    cell.records.feature(FeatureDraft::point(ObjectClass::SOUNDG, node));
    let found = read(&cell, &[]).unwrap();
    let Geometry::Soundings(list) = &only(&found, ObjectClass::SOUNDG).geometry else { panic!() };
    assert_eq!(list.len(), many.len());
    assert_eq!(list[19_999], many[19_999]);
    // The record after the big one was found.
    assert_eq!(found.features.len(), 3);
}

#[test]
fn wrong_datum_and_units_are_refused_by_name() {
    type Spoil = fn(&mut CellDraft);
    let says = |change: Spoil| {
        let Square { mut cell, .. } = open();
        change(&mut cell);
        read(&cell, &[]).unwrap_err().to_string()
    };
    let cases: [(Spoil, &str); 5] = [
        (|cell| cell.parameters.horizontal_datum = 4, "the horizontal datum (HDAT) is 4, not 2 (WGS 84)"),
        (|cell| cell.units.depth = 2, "the depth unit (DUNI) is 2, not 1 (metres)"),
        (|cell| cell.units.height = 2, "the height unit (HUNI) is 2, not 1 (metres)"),
        (|cell| cell.units.coordinate = 2, "the coordinate unit (COUN) is 2, not 1 (degrees)"),
        (|cell| cell.units.accuracy = 2, "the unit of accuracy (PUNI) is 2, not 1 (metres)"),
    ];
    for (change, expected) in cases {
        let text = says(change);
        assert!(text.starts_with("NO5X0001.000, record 2 at byte ") && text.contains(expected), "{text}");
    }
}

/// Where records end, but the last.
fn record_ends(bytes: &[u8]) -> Vec<usize> {
    let mut ends = Vec::new();
    let mut at = 0;
    while at < bytes.len() {
        at += std::str::from_utf8(&bytes[at..at + 5]).unwrap().parse::<usize>().unwrap();
        ends.push(at);
    }
    assert_eq!(ends.pop(), Some(bytes.len()));
    ends
}

#[test]
fn files_cut_between_two_records_are_refused() {
    let Square { mut cell, .. } = open();
    let rock = |records: &mut charts::s57::write::Records, lat_deg, lon_deg| {
        let node = records.isolated_node(at(lat_deg, lon_deg));
        records.feature(FeatureDraft::point(ObjectClass::UWTROC, node).with(AttributeCode::VALSOU, "1"));
    };
    rock(&mut cell.records, 63.01, 10.01);
    let base = cell.to_bytes().unwrap();
    let mut update = UpdateDraft::new(&cell, 1);
    rock(&mut update.records, 63.01, 10.02);
    rock(&mut update.records, 63.01, 10.03);
    let update = update.to_bytes().unwrap();
    assert!(read_files(&base, std::slice::from_ref(&update)).unwrap().notices.is_empty());
    for end in record_ends(&base) {
        let error = read_files(&base[..end], &[]).unwrap_err();
        assert_eq!(error.file, NAME);
        assert!(error.to_string().contains("cut"), "{error}");
    }
    let ends = record_ends(&update);
    // The first cut leaves no identification, as above.
    for end in ends.into_iter().skip(1) {
        let error = read_files(&base, &[update[..end].to_vec()]).unwrap_err();
        assert_eq!(error.file, "NO5X0001.001");
        assert!(matches!(error.problem, S57Problem::Cut { .. }), "{error}");
    }
}
