//! What the writer writes, the reader reads: random cells of shared edges, random edits of every list, all
//! lexical levels and entry maps. Where GDAL is on the machine it must count the same.

use charts::iso8211::LexicalLevel;
use charts::s57::write::{
    CellDraft, EdgeEnd, EntryMap, FeatureChange, FeatureDraft, ListEdit, Style, UpdateDraft, VectorChange,
    VectorUse, WriteError,
};
use charts::s57::{
    Attribute, AttributeCode, Cell, Feature, FeatureLink, GeoPoint, Geometry, LinkRole, NamedBytes,
    ObjectClass, ObjectId, Path, Sounding,
};
use proptest::prelude::*;
use proptest::sample::Index;

const NAME: &str = "NO5X0001.000";
const FACTOR: i32 = 500_000;

fn read(cell: &CellDraft, updates: &[UpdateDraft]) -> Cell {
    let base = cell.to_bytes().unwrap();
    let files: Vec<Vec<u8>> = updates.iter().map(|update| update.to_bytes().unwrap()).collect();
    let names: Vec<String> = (1..=updates.len()).map(|at| format!("NO5X0001.{at:03}")).collect();
    let updates: Vec<_> = names.iter().zip(&files).map(|(name, bytes)| NamedBytes { name, bytes }).collect();
    Cell::read(NamedBytes { name: NAME, bytes: &base }, &updates).unwrap_or_else(|error| panic!("{error}"))
}

/// A position that the file's factor holds exactly.
fn point() -> impl Strategy<Value = GeoPoint> {
    (-90 * FACTOR..=90 * FACTOR, -90 * FACTOR..=90 * FACTOR).prop_map(|(x, y)| GeoPoint {
        lon_deg: f64::from(x) / f64::from(FACTOR),
        lat_deg: f64::from(y) / f64::from(FACTOR),
    })
}

fn points(most: usize) -> impl Strategy<Value = Vec<GeoPoint>> {
    prop::collection::vec(point(), 0..=most)
}

fn level() -> impl Strategy<Value = LexicalLevel> {
    prop::sample::select(vec![LexicalLevel::Ascii, LexicalLevel::Latin1, LexicalLevel::Ucs2])
}

/// Characters that a level has; the delete marker alone is not a value, so it stands in none.
fn text(level: LexicalLevel) -> BoxedStrategy<String> {
    let pattern = match level {
        LexicalLevel::Ascii => "[ -~]{0,12}",
        LexicalLevel::Latin1 => "[ -~\u{a0}-\u{ff}]{0,12}",
        // The low bytes of U+1E1E and U+1F1F are those of the terminators.
        LexicalLevel::Ucs2 => "[ -~\u{a0}-\u{2ff}\u{1e1e}\u{1f1f}\u{1e00}\u{4e00}-\u{4eff}]{0,12}",
    };
    pattern.prop_map(String::from).boxed()
}

fn attributes(level: LexicalLevel) -> impl Strategy<Value = Vec<Attribute>> {
    let one = (any::<u16>(), text(level));
    let attribute = |(code, value)| Attribute { code: AttributeCode(code), value };
    prop::collection::vec(one.prop_map(attribute), 0..5)
}

fn entries() -> impl Strategy<Value = EntryMap> {
    let fixed = (5_u8..=9, 5_u8..=9).prop_map(|(length, position)| EntryMap::Fixed { length, position });
    prop_oneof![Just(EntryMap::Shortest), fixed]
}

fn role() -> impl Strategy<Value = LinkRole> {
    prop::sample::select(vec![LinkRole::Master, LinkRole::Slave, LinkRole::Peer, LinkRole::Other])
}

fn links() -> impl Strategy<Value = Vec<(ObjectId, LinkRole)>> {
    let object = (any::<u16>(), any::<u32>(), any::<u16>());
    let id = |(agency, number, subdivision)| ObjectId { agency, number, subdivision };
    prop::collection::vec((object.prop_map(id), role()), 0..4)
}

#[derive(Debug, Clone)]
struct Described {
    style: Style,
    first: Vec<Attribute>,
    second: Vec<Attribute>,
    links: Vec<(ObjectId, LinkRole)>,
}

fn described() -> impl Strategy<Value = Described> {
    (level(), level(), entries()).prop_flat_map(|(level, national, entries)| {
        (attributes(level), attributes(national), links()).prop_map(move |(first, second, links)| Described {
            style: Style { attributes: level, national, entries },
            first,
            second,
            links,
        })
    })
}

/// The corners of a ring, each with the vertices to the next and whether that edge is stored the other way.
fn ring() -> impl Strategy<Value = Vec<(GeoPoint, Vec<GeoPoint>, bool)>> {
    prop::collection::vec((point(), points(6), any::<bool>()), 1..7)
}

fn draft(style: Style) -> CellDraft {
    let mut cell = CellDraft::with_factors(NAME, 5, 10_000, FACTOR as u32, 100);
    cell.style = style;
    cell
}

/// Puts a ring into a draft; gives its edges in order, and its points.
fn lay(cell: &mut CellDraft, ring: &[(GeoPoint, Vec<GeoPoint>, bool)]) -> (Vec<VectorUse>, Vec<GeoPoint>) {
    let nodes: Vec<_> = ring.iter().map(|(at, _, _)| cell.records.connected_node(*at)).collect();
    let (mut uses, mut line) = (Vec::new(), vec![ring[0].0]);
    for (at, (_, between, turned)) in ring.iter().enumerate() {
        let next = (at + 1) % ring.len();
        line.extend(between.iter().copied().chain([ring[next].0]));
        if *turned {
            let backwards: Vec<_> = between.iter().rev().copied().collect();
            uses.push(cell.records.edge(nodes[next], nodes[at], &backwards).reverse());
        } else {
            uses.push(cell.records.edge(nodes[at], nodes[next], between).forward());
        }
    }
    (uses, line)
}

/// Exteriors are turned clockwise and holes anticlockwise by the reader.
fn oriented(mut points: Vec<GeoPoint>, interior: bool) -> Vec<GeoPoint> {
    let path = Path { points: points.clone(), edges: Vec::new() };
    if (path.signed_area_deg2() > 0.0) != interior {
        points.reverse();
    }
    points
}

fn only(cell: &Cell, class: ObjectClass) -> &Feature {
    cell.of_class(class).next().unwrap()
}

/// An edit of a list of some length, made from random numbers, and what it does to a list.
fn edited<T: Clone>(model: &mut Vec<T>, kind: u8, at: Index, count: usize, items: Vec<T>) -> ListEdit<T> {
    match kind {
        0 => {
            let index = at.index(model.len() + 1);
            model.splice(index..index, items.iter().cloned());
            ListEdit::Insert { index: index + 1, items }
        }
        1 => {
            let index = at.index(model.len() + 1);
            let count = count.min(model.len() - index);
            model.drain(index..index + count);
            ListEdit::Delete { index: index + 1, count }
        }
        _ => {
            let index = at.index(model.len() + 1);
            let items = items[..items.len().min(model.len() - index)].to_vec();
            model.splice(index..index + items.len(), items.iter().cloned());
            ListEdit::Replace { index: index + 1, items }
        }
    }
}

proptest! {
    #[test]
    fn areas_lines_and_text_come_back(
        described in described(),
        outer in ring(),
        inner in ring(),
        order in any::<Index>(),
    ) {
        let mut cell = draft(described.style);
        let (bounds, outline) = lay(&mut cell, &outer);
        let (hole, hole_line) = lay(&mut cell, &inner);
        // Holes before, between and after the edges of the exterior.
        let mut all = bounds.clone();
        let at = order.index(all.len() + 1);
        all.splice(at..at, hole.iter().map(|edge| edge.interior()));
        let mut area = FeatureDraft::area(ObjectClass::DEPARE, &all);
        for one in &described.first {
            area = area.with(one.code, one.value.clone());
        }
        for one in &described.second {
            area = area.national(one.code, one.value.clone());
        }
        for (to, role) in &described.links {
            area = area.linked(*to, *role);
        }
        let area = cell.records.feature(area);
        cell.records.feature(FeatureDraft::line(ObjectClass::DEPCNT, &bounds));
        cell.records.feature(FeatureDraft::area(ObjectClass::LNDARE, &hole));
        let read = read(&cell, &[]);
        prop_assert_eq!(&read.notices, &[]);
        prop_assert_eq!((&read.id, &read.parameters), (&cell.id, &cell.parameters));
        prop_assert_eq!(read.structure.edges as usize, outer.len() + inner.len());
        let found = only(&read, ObjectClass::DEPARE);
        prop_assert_eq!((found.record, found.object, found.group), (area.record, area.object, 1));
        prop_assert_eq!(&found.attributes, &described.first);
        prop_assert_eq!(&found.national, &described.second);
        let links: Vec<_> = described.links.iter().map(|(to, role)| FeatureLink { to: *to, role: *role }).collect();
        prop_assert_eq!(&found.links, &links);
        let Geometry::Area(shape) = &found.geometry else { panic!("{found:?}") };
        prop_assert_eq!(&shape.exteriors[0].points, &oriented(outline.clone(), false));
        prop_assert_eq!(&shape.holes[0].points, &oriented(hole_line.clone(), true));
        let Geometry::Area(land) = &only(&read, ObjectClass::LNDARE).geometry else { panic!("{read:?}") };
        prop_assert_eq!(&land.exteriors[0].points, &oriented(hole_line, false));
        let Geometry::Lines(lines) = &only(&read, ObjectClass::DEPCNT).geometry else { panic!("{read:?}") };
        prop_assert_eq!(lines.len(), 1);
        prop_assert_eq!(&lines[0].points, &outline);
    }

    #[test]
    fn edits_of_lists_do_what_they_say(
        middle in points(8),
        spots in prop::collection::vec((point(), -30_000_i32..=100_000), 1..8),
        linked in links(),
        edits in prop::collection::vec(
            (0_u8..3, any::<Index>(), 0_usize..4, prop::collection::vec((point(), -500_i32..500), 0..4), links()),
            1..5,
        ),
        split in any::<bool>(),
    ) {
        let mut cell = draft(Style::default());
        let (from, to) = (GeoPoint { lon_deg: 1.0, lat_deg: 1.0 }, GeoPoint { lon_deg: 2.0, lat_deg: 3.0 });
        let nodes = [from, to].map(|at| cell.records.connected_node(at));
        let mut edge = cell.records.edge(nodes[0], nodes[1], &middle);
        let line = cell.records.feature(FeatureDraft::line(ObjectClass::DEPCNT, &[edge.forward()]));
        let depth = |(at, z): (GeoPoint, i32)| Sounding { at, depth_m: f64::from(z) / 100.0 };
        let mut depths: Vec<Sounding> = spots.into_iter().map(depth).collect();
        let mut node = cell.records.soundings(&depths);
        let mut soundings = FeatureDraft::point(ObjectClass::SOUNDG, node);
        for (to, role) in &linked {
            soundings = soundings.linked(*to, *role);
        }
        let mut soundings = cell.records.feature(soundings);
        let (mut vertices, mut links) = (middle, linked);
        // All edits in one update, or one in each.
        let mut updates = vec![UpdateDraft::new(&cell, 1)];
        for (kind, at, count, positions, more) in edits {
            if split {
                let next = updates[updates.len() - 1].next();
                updates.push(next);
            }
            let last = updates.len() - 1;
            let records = &mut updates[last].records;
            let new: Vec<_> = positions.iter().map(|(at, _)| *at).collect();
            let change = edited(&mut vertices, kind, at, count, new);
            edge = records.change_vector(VectorChange::of(edge).vertices(change));
            let new: Vec<_> = positions.into_iter().map(depth).collect();
            let change = edited(&mut depths, kind, at, count, new);
            node = records.change_vector(VectorChange::of(node).soundings(change));
            let change = FeatureChange::of(soundings).links(edited(&mut links, kind, at, count, more));
            soundings = records.change_feature(change);
        }
        let moved = GeoPoint { lon_deg: -4.0, lat_deg: 5.0 };
        let last = updates.len() - 1;
        let records = &mut updates[last].records;
        records.change_vector(
            VectorChange::of(nodes[1]).vertices(ListEdit::Replace { index: 1, items: vec![moved] }),
        );
        let read = read(&cell, &updates);
        // A sounding feature may lose all its soundings; that is the only notice.
        let told = usize::from(depths.is_empty());
        prop_assert_eq!(read.notices.len(), told, "{:?}", read.notices);
        let found = only(&read, ObjectClass::DEPCNT);
        prop_assert_eq!(found.record, line.record);
        let Geometry::Lines(lines) = &found.geometry else { panic!("{found:?}") };
        let expected: Vec<_> = [from].into_iter().chain(vertices).chain([moved]).collect();
        prop_assert_eq!(&lines[0].points, &expected);
        let found = only(&read, ObjectClass::SOUNDG);
        prop_assert_eq!(found.version, soundings.version);
        let links: Vec<_> = links.into_iter().map(|(to, role)| FeatureLink { to, role }).collect();
        prop_assert_eq!(&found.links, &links);
        match &found.geometry {
            Geometry::Soundings(found) => prop_assert_eq!(found, &depths),
            Geometry::Unreadable { .. } => prop_assert!(depths.is_empty()),
            other => panic!("{other:?}"),
        }
    }

    #[test]
    fn edges_of_features_are_edited(
        edits in prop::collection::vec((0_u8..3, any::<Index>(), 0_usize..4, 0_usize..4), 1..6),
    ) {
        let mut cell = draft(Style::default());
        let at = |one: usize| GeoPoint { lon_deg: one as f64, lat_deg: (one * one % 7) as f64 };
        let nodes: Vec<_> = (0..8).map(|one| cell.records.connected_node(at(one))).collect();
        let edges: Vec<_> =
            (0..7).map(|one| cell.records.edge(nodes[one], nodes[one + 1], &[]).forward()).collect();
        let mut model = edges[..3].to_vec();
        let mut line = cell.records.feature(FeatureDraft::line(ObjectClass::DEPCNT, &model));
        let mut update = UpdateDraft::new(&cell, 1);
        for (kind, index, count, from) in edits {
            let edit = edited(&mut model, kind, index, count, edges[from..from + count].to_vec());
            line = update.records.change_feature(FeatureChange::of(line).edges(edit));
        }
        let read = read(&cell, &[update]);
        let number = |edge: &VectorUse| edges.iter().position(|one| one == edge).unwrap() as u32 + 1;
        let expected: Vec<u32> = model.iter().map(number).collect();
        let found = match &only(&read, ObjectClass::DEPCNT).geometry {
            Geometry::Lines(lines) => lines.iter().flat_map(|line| &line.edges).map(|one| one.edge).collect(),
            // It lay somewhere before.
            Geometry::Unreadable { paths, .. } if !paths[0].points.is_empty() => Vec::new(),
            other => panic!("{other:?}"),
        };
        prop_assert_eq!(found, expected);
    }
}

#[test]
fn an_edge_is_led_to_another_node() {
    let mut cell = draft(Style::default());
    let at = |lon_deg: f64| GeoPoint { lon_deg, lat_deg: 1.0 };
    let nodes = [0.0, 1.0, 2.0].map(|lon_deg| cell.records.connected_node(at(lon_deg)));
    let edge = cell.records.edge(nodes[0], nodes[1], &[]);
    cell.records.feature(FeatureDraft::line(ObjectClass::DEPCNT, &[edge.forward()]));
    let mut update = UpdateDraft::new(&cell, 1);
    let end = EdgeEnd { node: nodes[2], begins: false };
    let change = VectorChange::of(edge).nodes(ListEdit::Replace { index: 2, items: vec![end] });
    update.records.change_vector(change);
    update.records.delete_vector(nodes[1]);
    let read = read(&cell, &[update]);
    let Geometry::Lines(lines) = &only(&read, ObjectClass::DEPCNT).geometry else { panic!("{read:?}") };
    assert_eq!(lines[0].points, [at(0.0), at(2.0)]);
}

#[test]
fn what_no_file_can_hold_is_refused() {
    let says = |change: fn(&mut CellDraft)| {
        let mut cell = CellDraft::new(NAME, 5, 10_000);
        change(&mut cell);
        cell.to_bytes().unwrap_err().to_string()
    };
    let named = |cell: &mut CellDraft, name: &str| {
        let group = FeatureDraft::collection(ObjectClass(400));
        cell.records.feature(group.with(AttributeCode::OBJNAM, name).national(AttributeCode::NOBJNM, name));
    };
    let mut cell = CellDraft::new(NAME, 5, 10_000);
    named(&mut cell, "Č");
    let (character, level) = ('Č', LexicalLevel::Latin1);
    assert_eq!(cell.to_bytes(), Err(WriteError::Character { character, level }));
    cell.style.attributes = LexicalLevel::Ucs2;
    assert!(cell.to_bytes().is_ok());
    named(&mut cell, "\u{1F41F}");
    assert!(cell.to_bytes().unwrap_err().to_string().contains("cannot be written in lexical level Ucs2"));
    assert!(says(|cell| cell.id.comment = "a\u{1F}b".to_owned()).contains("lexical level Ascii"));
    assert!(says(|cell| cell.id.issue_date = "2026".to_owned()).contains("has not 8 characters"));
    let beyond = |cell: &mut CellDraft| {
        cell.records.isolated_node(GeoPoint { lon_deg: 300.0, lat_deg: 0.0 });
    };
    assert!(says(beyond).starts_with("300 times the factor 10000000 is beyond four bytes"));
    assert!(
        says(|cell| cell.style.entries = EntryMap::Fixed { length: 2, position: 3 })
            .contains("needs 3 digits in the directory")
    );
}

/// GDAL applies the first of several and leaves the others out; so may others.
#[test]
fn a_record_has_one_edit_of_a_list() {
    let mut cell = draft(Style::default());
    let at = |lon_deg: f64| GeoPoint { lon_deg, lat_deg: 1.0 };
    let nodes = [0.0, 1.0].map(|lon_deg| cell.records.connected_node(at(lon_deg)));
    let edge = cell.records.edge(nodes[0], nodes[1], &[]);
    let mut update = UpdateDraft::new(&cell, 1);
    let insert = || ListEdit::Insert { index: 1, items: vec![at(0.5)] };
    update.records.change_vector(VectorChange::of(edge).vertices(insert()).vertices(insert()));
    let told = update.to_bytes().unwrap_err().to_string();
    assert_eq!(told, "a record has room for one SGCC; make a change of its own of each edit of a list");
}

/// GDAL reads the records of the format, not this crate's idea of them.
#[test]
fn gdal_counts_the_same() {
    let mut cell = CellDraft::new(NAME, 5, 10_000);
    let corners = [(10.0, 63.0), (10.0, 63.02), (10.04, 63.02), (10.04, 63.0)];
    let ring = corners.map(|(lon_deg, lat_deg)| (GeoPoint { lon_deg, lat_deg }, Vec::new(), false));
    let (bounds, _) = lay(&mut cell, &ring);
    for class in [ObjectClass::M_COVR, ObjectClass::DEPARE] {
        let area = FeatureDraft::area(class, &bounds).with(AttributeCode::DRVAL1, "5");
        cell.records.feature(area.with(AttributeCode::CATCOV, "1"));
    }
    for lon_deg in [10.01, 10.02] {
        let node = cell.records.isolated_node(GeoPoint { lon_deg, lat_deg: 63.01 });
        cell.records.feature(FeatureDraft::point(ObjectClass::UWTROC, node));
    }
    let folder = std::env::temp_dir().join(format!("lutra-gdal-{}", std::process::id()));
    std::fs::create_dir_all(&folder).unwrap();
    let file = folder.join(NAME);
    std::fs::write(&file, cell.to_bytes().unwrap()).unwrap();
    let told = std::process::Command::new("ogrinfo").args(["-ro", "-al", "-so"]).arg(&file).output();
    std::fs::remove_dir_all(&folder).unwrap();
    let Ok(told) = told else {
        return testkit::absent(testkit::Need::Gdal, "apt-get install gdal-bin");
    };
    let text = String::from_utf8_lossy(&told.stdout).into_owned();
    for (layer, count) in [("M_COVR", 1), ("DEPARE", 1), ("UWTROC", 2)] {
        let after = text.split(&format!("Layer name: {layer}\n")).nth(1).unwrap_or_else(|| panic!("{text}"));
        let counted = after.lines().find(|line| line.starts_with("Feature Count:")).unwrap();
        assert_eq!(counted, format!("Feature Count: {count}"), "{layer}");
    }
}
