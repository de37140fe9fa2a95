//! The fuzz targets' bodies over their committed seeds and over everything they ever found.
//!
//! The seeds are this file's own: with LUTRA_WRITE_SEEDS set they are written again.

#[path = "../../../../fuzz/bodies/charts.rs"]
mod bodies;

use crate::writer::{DEPARE, DRVAL1, attributes, control, dsid, file, frid, point, sg2d, square, vrid};
use charts::depth_index::IndexBuilder;
use charts::iso8211::LexicalLevel;
use charts::s57::write::{
    CellDraft, EdgeEnd, EntryMap, FeatureChange, FeatureDraft, ListEdit, Style, UpdateDraft, VectorChange,
};
use charts::s57::{AttributeCode, Cell, GeoPoint, LinkRole, NamedBytes, ObjectClass, Sounding};

const NAME: &str = "NO5X0001.000";

fn cell() -> Vec<u8> {
    square(NAME, (63.0, 10.0), (63.02, 10.04), &[point(9, 153, &[(187, "4"), (116, "Stein")], 3)])
}

fn update() -> Vec<u8> {
    let mut changed = frid(2, 3, DEPARE, 2, 3);
    changed.push(attributes(&[(DRVAL1, "4.5")]));
    let bowed = vec![vrid(130, 1, 2, 3), control("SGCC", 1, 1, 1), sg2d(&[(63.01, 9.999)])];
    file(&[dsid(true, NAME, "1", "1"), changed, bowed])
}

fn with_update(base: &[u8], update: &[u8]) -> Vec<u8> {
    [&(base.len() as u16).to_le_bytes(), base, update].concat()
}

fn at(lat_deg: f64, lon_deg: f64) -> GeoPoint {
    GeoPoint { lon_deg, lat_deg }
}

/// A cell with every kind of field and record, and an update with every kind of edit.
fn rich(style: Style) -> (Vec<u8>, Vec<u8>) {
    let mut cell = CellDraft::new(NAME, 5, 10_000);
    cell.style = style;
    let records = &mut cell.records;
    let corners = [(63.0, 10.0), (63.02, 10.0), (63.02, 10.04), (63.0, 10.04)];
    let nodes = corners.map(|(lat, lon)| records.connected_node(at(lat, lon)));
    let bowed = [at(63.005, 9.999), at(63.01, 9.998), at(63.015, 9.999)];
    let sides = [0, 1, 2, 3]
        .map(|one| records.edge(nodes[one], nodes[(one + 1) % 4], if one == 0 { &bowed } else { &[] }));
    let ring = sides.map(|side| side.forward().data_limit());
    let shore = records.connected_node(at(63.008, 10.01));
    let islet = records.edge(shore, shore, &[at(63.01, 10.01), at(63.01, 10.02)]);
    let cover = FeatureDraft::area(ObjectClass::M_COVR, &ring).with(AttributeCode::CATCOV, "1");
    let cover = records.feature(cover);
    let mut bounds = ring.to_vec();
    bounds.push(islet.reverse().interior().masked());
    let depths = FeatureDraft::area(ObjectClass::DEPARE, &bounds).with(AttributeCode::DRVAL1, "5");
    let depths = records.feature(depths);
    let land = FeatureDraft::area(ObjectClass::LNDARE, &[islet.forward()]);
    let land =
        records.feature(land.with(AttributeCode::OBJNAM, "Holm").national(AttributeCode::NOBJNM, "Holm"));
    let measured = [(63.004, 10.03, 7.1), (63.006, 10.02, 5.4), (63.012, 10.03, -0.3)];
    let measured = measured.map(|(lat, lon, depth_m)| Sounding { at: at(lat, lon), depth_m });
    let spots = records.soundings(&measured);
    let soundings = records.feature(FeatureDraft::point(ObjectClass::SOUNDG, spots));
    let node = records.isolated_node(at(63.015, 10.02));
    let buoy = records.feature(FeatureDraft::point(ObjectClass::BOYLAT, node));
    let light = FeatureDraft::point(ObjectClass::LIGHTS, node).linked(buoy.object, LinkRole::Master);
    let light = records.feature(light.with(AttributeCode::OBJNAM, "Lykt"));
    records.feature(FeatureDraft::line(ObjectClass::COALNE, &[islet.forward()]));
    let mut update = UpdateDraft::new(&cell, 1);
    let records = &mut update.records;
    let more = records.connected_node(at(63.021, 10.02));
    let half = records.edge(more, nodes[2], &[]);
    let old = VectorChange::of(sides[1]).vertices(ListEdit::Plain(vec![at(63.0205, 10.01)]));
    let end = EdgeEnd { node: more, begins: false };
    records.change_vector(old.nodes(ListEdit::Replace { index: 2, items: vec![end] }));
    let mut bowed = sides[0];
    for edit in [
        ListEdit::Delete { index: 2, count: 1 },
        ListEdit::Replace { index: 1, items: vec![at(63.006, 9.997)] },
        ListEdit::Insert { index: 3, items: vec![at(63.018, 9.999)] },
    ] {
        bowed = records.change_vector(VectorChange::of(bowed).vertices(edit));
    }
    let one = Sounding { at: at(63.003, 10.02), depth_m: 6.2 };
    records.change_vector(VectorChange::of(spots).soundings(ListEdit::Insert { index: 4, items: vec![one] }));
    let edges = ListEdit::Insert { index: 3, items: vec![half.forward()] };
    let deeper = FeatureChange::of(depths).with(AttributeCode::DRVAL1, "4").edges(edges);
    let edges = ListEdit::Insert { index: 3, items: vec![half.forward().data_limit()] };
    records.change_feature(FeatureChange::of(cover).edges(edges));
    records.change_feature(deeper.with(AttributeCode::DRVAL2, "10"));
    records.change_feature(FeatureChange::of(land).without(AttributeCode::OBJNAM));
    let linked = ListEdit::Replace { index: 1, items: vec![(buoy.object, LinkRole::Peer)] };
    records.change_feature(FeatureChange::of(light).links(linked));
    records.delete_feature(soundings);
    (cell.to_bytes().unwrap(), update.to_bytes().unwrap())
}

fn rich_latin() -> (Vec<u8>, Vec<u8>) {
    let entries = EntryMap::Fixed { length: 4, position: 5 };
    rich(Style { national: LexicalLevel::Latin1, entries, ..Style::default() })
}

fn index() -> Vec<u8> {
    let cell = Cell::read(NamedBytes { name: NAME, bytes: &cell() }, &[]).unwrap();
    let mut builder = IndexBuilder::new();
    builder.add_cell(&cell).unwrap();
    builder.build().unwrap().to_bytes()
}

fn seeds() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let soundings = b"269927.5527 7044215.8950 12.4\n# end\n269927 7044216 -0.3\n".to_vec();
    let separated = b"568983.8234;7036662.9627;1.5e1\r\n\r\n568983.82,7036662.9,3\r\n".to_vec();
    let ((ucs, ucs_update), (latin, latin_update)) = (rich(Style::default()), rich_latin());
    vec![
        ("charts_iso8211", "rich", ucs.clone()),
        ("charts_iso8211", "rich_update", ucs_update.clone()),
        ("charts_iso8211", "rich_latin", latin.clone()),
        ("charts_s57", "rich", with_update(&ucs, &[])),
        ("charts_s57", "rich_and_update", with_update(&ucs, &ucs_update)),
        ("charts_s57", "rich_latin_and_update", with_update(&latin, &latin_update)),
        ("charts_iso8211", "cell", cell()),
        ("charts_iso8211", "update", update()),
        ("charts_s57", "cell", with_update(&cell(), &[])),
        ("charts_s57", "cell_and_update", with_update(&cell(), &update())),
        ("charts_text", "soundings", soundings),
        ("charts_text", "separated", separated),
        ("charts_index", "index", index()),
    ]
}

fn replay(target: &str, body: fn(&[u8])) {
    let folder = testkit::repository().join("fuzz/seeds").join(target);
    for (_, name, bytes) in seeds().into_iter().filter(|(of, _, _)| *of == target) {
        if std::env::var_os("LUTRA_WRITE_SEEDS").is_some() {
            std::fs::create_dir_all(&folder).unwrap();
            std::fs::write(folder.join(name), &bytes).unwrap();
        }
    }
    let mut files: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(!files.is_empty(), "{} has no seeds", folder.display());
    for file in files {
        println!("{}", file.display());
        body(&std::fs::read(file).unwrap());
    }
}

#[test]
fn container_seeds_hold() {
    replay("charts_iso8211", bodies::iso8211);
}

#[test]
fn cell_seeds_hold() {
    replay("charts_s57", bodies::s57);
}

/// A seed that is refused at its first byte leads a fuzzer nowhere.
#[test]
fn rich_seeds_are_read_whole() {
    for (base, update) in [rich(Style::default()), rich_latin()] {
        let update = NamedBytes { name: "NO5X0001.001", bytes: &update };
        let cell = Cell::read(NamedBytes { name: NAME, bytes: &base }, &[update]).unwrap();
        assert!(cell.notices.is_empty(), "{:?}", cell.notices);
        assert_eq!((cell.id.update.as_str(), cell.features.len()), ("1", 6));
        // As GDAL 3.12.4 reads base and update.
        let check = cell.skin_check();
        assert!((check.skin_deg2 - 0.000_851).abs() < 1e-15 && check.holds(), "{check:?}");
        let depths = cell.of_class(ObjectClass::DEPARE).next().unwrap();
        let charts::s57::Geometry::Area(area) = &depths.geometry else { panic!("{depths:?}") };
        assert_eq!((area.exteriors[0].points.len(), area.holes.len()), (10, 1));
    }
}

#[test]
fn text_seeds_hold() {
    replay("charts_text", bodies::text);
}

#[test]
fn index_seeds_hold() {
    replay("charts_index", bodies::index);
}

/// What a fuzzer would try first, without one.
#[test]
fn changed_seeds_hold() {
    let mut state = 0x9E37_79B9_7F4A_7C15_u64;
    let mut next = |below: usize| {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state % below as u64) as usize
    };
    for round in 0..800 {
        for (target, _, mut bytes) in seeds().into_iter().filter(|(target, _, _)| *target != "charts_index") {
            for _ in 0..=round % 4 {
                let at = next(bytes.len());
                bytes[at] = [0, 1, 0x1E, 0x1F, 0x7F, 0xFF, b'0', b'9', b'(', b','][next(10)];
            }
            match target {
                "charts_iso8211" => bodies::iso8211(&bytes),
                "charts_s57" => bodies::s57(&bytes),
                _ => bodies::text(&bytes),
            }
        }
    }
}
