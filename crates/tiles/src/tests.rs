//! Tiles are decoded again by a reader of their own and compared with the chart they are of.

mod regional;

use super::*;
use charts::coverage::Source;
use charts::demo;
use charts::depth_index::{Demand, IndexBuilder, Water};
use charts::s57::write::{CellDraft, FeatureDraft, VectorRef};
use charts::s57::{AttributeCode, Cell, GeoPoint, Geometry, NamedBytes, ObjectClass};
use std::collections::{BTreeMap, BTreeSet};
use std::f64::consts::PI;
use units::LatLon;

/// A feature as it was read.
#[derive(Debug, Clone)]
struct Got {
    id: u64,
    says: BTreeMap<String, Said>,
    kind: u64,
    /// Rings and lines, or single points.
    parts: Vec<Vec<[i64; 2]>>,
}

#[derive(Debug, Clone, PartialEq)]
enum Said {
    Text(String),
    Number(f64),
}

impl Got {
    fn text(&self, key: &str) -> &str {
        match &self.says[key] {
            Said::Text(text) => text,
            Said::Number(number) => panic!("{key} is {number}"),
        }
    }

    fn number(&self, key: &str) -> Option<f64> {
        match self.says.get(key)? {
            Said::Number(number) => Some(*number),
            Said::Text(text) => panic!("{key} is {text}"),
        }
    }

    /// By the winding of rings, as renderers fill.
    fn holds(&self, [x, y]: [f64; 2]) -> bool {
        let mut winding = 0;
        for ring in &self.parts {
            for (number, a) in ring.iter().enumerate() {
                let b = ring[(number + 1) % ring.len()];
                let [ax, ay, bx, by] = [a[0] as f64, a[1] as f64, b[0] as f64, b[1] as f64];
                if (ay > y) != (by > y) && x < ax + (y - ay) / (by - ay) * (bx - ax) {
                    winding += if by > ay { 1 } else { -1 };
                }
            }
        }
        winding != 0
    }
}

fn varint(bytes: &mut &[u8]) -> u64 {
    let mut value = 0;
    for shift in (0..64).step_by(7) {
        let (first, rest) = bytes.split_first().unwrap();
        *bytes = rest;
        value |= u64::from(first & 0x7F) << shift;
        if first & 0x80 == 0 {
            break;
        }
    }
    value
}

enum Field<'a> {
    Number(u64),
    Double(f64),
    Bytes(&'a [u8]),
}

fn fields(mut bytes: &[u8]) -> Vec<(u64, Field<'_>)> {
    let mut all = Vec::new();
    while !bytes.is_empty() {
        let key = varint(&mut bytes);
        let field = match key & 7 {
            0 => Field::Number(varint(&mut bytes)),
            1 => {
                let (head, rest) = bytes.split_first_chunk::<8>().unwrap();
                bytes = rest;
                Field::Double(f64::from_le_bytes(*head))
            }
            2 => {
                let count = varint(&mut bytes) as usize;
                let (head, rest) = bytes.split_at(count);
                bytes = rest;
                Field::Bytes(head)
            }
            other => panic!("wire type {other}"),
        };
        all.push((key >> 3, field));
    }
    all
}

fn packed(mut bytes: &[u8]) -> Vec<u64> {
    let mut all = Vec::new();
    while !bytes.is_empty() {
        all.push(varint(&mut bytes));
    }
    all
}

fn said(bytes: &[u8]) -> Said {
    match fields(bytes).pop().unwrap() {
        (1, Field::Bytes(text)) => Said::Text(String::from_utf8(text.to_vec()).unwrap()),
        (3, Field::Double(number)) => Said::Number(number),
        (5, Field::Number(number)) => Said::Number(number as f64),
        (field, _) => panic!("value of field {field}"),
    }
}

fn parts(kind: u64, commands: &[u64]) -> Vec<Vec<[i64; 2]>> {
    let mut parts: Vec<Vec<[i64; 2]>> = Vec::new();
    let (mut pen, mut at) = ([0_i64, 0], 0);
    let signed = |value: u64| (value >> 1) as i64 ^ -((value & 1) as i64);
    while at < commands.len() {
        let (what, count) = (commands[at] & 7, commands[at] >> 3);
        at += 1;
        if what == 7 {
            assert_eq!((kind, count), (3, 1));
            continue;
        }
        for _ in 0..count {
            pen = [pen[0] + signed(commands[at]), pen[1] + signed(commands[at + 1])];
            at += 2;
            match what {
                1 => parts.push(vec![pen]),
                2 => parts.last_mut().unwrap().push(pen),
                other => panic!("command {other}"),
            }
        }
    }
    parts
}

/// Layers by name; asserts what the format demands.
fn decoded(tile: &[u8]) -> BTreeMap<String, Vec<Got>> {
    let mut layers = BTreeMap::new();
    for (field, layer) in fields(tile) {
        let Field::Bytes(layer) = layer else { panic!("a layer is bytes") };
        assert_eq!(field, 3);
        let (mut name, mut keys, mut values, mut raw) = (String::new(), Vec::new(), Vec::new(), Vec::new());
        for (field, value) in fields(layer) {
            match (field, value) {
                (15, Field::Number(version)) => assert_eq!(version, 2),
                (1, Field::Bytes(text)) => name = String::from_utf8(text.to_vec()).unwrap(),
                (2, Field::Bytes(feature)) => raw.push(feature),
                (3, Field::Bytes(key)) => keys.push(String::from_utf8(key.to_vec()).unwrap()),
                (4, Field::Bytes(value)) => values.push(said(value)),
                (5, Field::Number(extent)) => assert_eq!(extent, 4096),
                (other, _) => panic!("field {other} of a layer"),
            }
        }
        let feature = |bytes: &[u8]| {
            let mut got = Got { id: 0, says: BTreeMap::new(), kind: 0, parts: Vec::new() };
            for (field, value) in fields(bytes) {
                match (field, value) {
                    (1, Field::Number(id)) => got.id = id,
                    (2, Field::Bytes(tags)) => {
                        let pairs = packed(tags);
                        let says = pairs
                            .chunks(2)
                            .map(|pair| (keys[pair[0] as usize].clone(), values[pair[1] as usize].clone()));
                        got.says = says.collect();
                    }
                    (3, Field::Number(kind)) => got.kind = kind,
                    (4, Field::Bytes(commands)) => got.parts = parts(got.kind, &packed(commands)),
                    (other, _) => panic!("field {other} of a feature"),
                }
            }
            got
        };
        let features: Vec<Got> = raw.into_iter().map(feature).collect();
        for got in features.iter().filter(|got| got.kind == 3) {
            assert!(got.parts.iter().all(|ring| ring.len() >= 3));
            assert!(twice(&got.parts[0]) > 0, "the first ring is an outer one");
        }
        assert!(layers.insert(name, features).is_none(), "a layer stands once");
    }
    layers
}

fn twice(ring: &[[i64; 2]]) -> i64 {
    (0..ring.len())
        .map(|at| {
            let (a, b) = (ring[at], ring[(at + 1) % ring.len()]);
            a[0] * b[1] - b[0] * a[1]
        })
        .sum()
}

fn cells() -> Vec<Cell> {
    let files = demo::archipelago().unwrap();
    files
        .iter()
        .map(|file| Cell::read(NamedBytes { name: file.name, bytes: &file.bytes }, &[]).unwrap())
        .collect()
}

fn source(cell: &Cell) -> Source {
    Source {
        name: cell.id.name.split('.').next().unwrap().to_owned(),
        band: cell.id.band,
        scale: cell.parameters.scale,
        ..Source::default()
    }
}

/// All charts are kept once they were read.
fn sheet(cells: &[Cell]) -> Sheet {
    regional::sheet(cells, usize::MAX)
}

/// Where a place is, in the units of a tile; and the tile that holds it.
fn in_tile(place: GeoPoint, zoom: u8) -> ([u32; 2], [f64; 2]) {
    let x = (place.lon_deg + 180.0) / 360.0;
    let y = (1.0 - place.lat_deg.to_radians().tan().asinh() / PI) / 2.0;
    let wide = f64::from(1_u32 << zoom);
    let [x, y] = [x * wide, y * wide];
    ([x as u32, y as u32], [x.fract() * 4096.0, y.fract() * 4096.0])
}

/// Numbers in [0, 1) that are the same in every run.
fn numbers() -> impl FnMut() -> f64 {
    let mut state = 0x2545_F491_4F6C_DD1D_u64;
    move || {
        state ^= state << 13;
        state ^= state >> 7;
        state ^= state << 17;
        (state >> 11) as f64 / (1_u64 << 53) as f64
    }
}

#[test]
fn what_is_drawn_at_a_place_is_what_the_depth_index_says() {
    let cells = cells();
    let sheet = sheet(&cells);
    let mut builder = IndexBuilder::new();
    for cell in &cells {
        builder.add_features(source(cell), &cell.features).unwrap();
    }
    let index = builder.build().unwrap();
    let mut tiles: BTreeMap<(u8, [u32; 2]), BTreeMap<String, Vec<Got>>> = BTreeMap::new();
    let mut next = numbers();
    let (mut agreed, mut compared) = (0, 0);
    for _ in 0..3_000 {
        let place = GeoPoint { lat_deg: 63.428 + 0.05 * next(), lon_deg: 10.27 + 0.17 * next() };
        let zoom = if next() < 0.5 { 12 } else { 15 };
        let at = LatLon::from_deg(place.lat_deg, place.lon_deg).unwrap();
        let told = index.depth_at(at, &Demand::default());
        let deciding = told.object.and_then(|id| index.object(id));
        // Dangers of an extent lie on top of the skin, which alone is compared.
        if deciding.as_ref().is_some_and(|object| {
            !matches!(object.class, ObjectClass::DEPARE | ObjectClass::DRGARE | ObjectClass::LNDARE)
        }) {
            continue;
        }
        let (tile, local) = in_tile(place, zoom);
        let layers = tiles
            .entry((zoom, tile))
            .or_insert_with(|| decoded(&sheet.tile(zoom, tile[0], tile[1]).unwrap()));
        let holding = |layer: &str| -> Vec<&Got> {
            layers.get(layer).into_iter().flatten().filter(|got| got.holds(local)).collect()
        };
        let (water, land, cover) = (holding("water"), holding("land"), holding("cover"));
        compared += 1;
        agreed += u32::from(match told.water {
            Water::Land => !land.is_empty(),
            Water::NoData => cover.is_empty() && water.is_empty() && land.is_empty(),
            Water::Depth { least_m, .. } => {
                let scale = deciding.as_ref().map(|object| f64::from(index.source(object).scale));
                let ids: BTreeSet<u64> = water.iter().map(|got| got.id).collect();
                land.is_empty()
                    && ids.len() == 1
                    && water[0].number("drval1") == Some(least_m)
                    && water[0].number("scale") == scale
            }
            _ => false,
        });
    }
    // Simplified by half a pixel: places right at a border may be on its other side.
    assert!(compared > 2_000 && f64::from(agreed) > 0.985 * f64::from(compared), "{agreed} of {compared}");
}

#[test]
fn no_danger_is_lost_from_its_zoom_on() {
    let cells = cells();
    let sheet = sheet(&cells);
    let finest = cells.iter().max_by_key(|cell| cell.id.band).unwrap();
    let mut builder = IndexBuilder::new();
    for cell in &cells {
        builder.add_features(source(cell), &cell.features).unwrap();
    }
    let index = builder.build().unwrap();
    let dangerous = [ObjectClass::UWTROC, ObjectClass::WRECKS, ObjectClass::OBSTRN, ObjectClass::PILPNT];
    let (mut seen, mut in_water) = (0, 0);
    for feature in finest.features.iter().filter(|feature| dangerous.contains(&feature.class)) {
        let Some(place) = feature.geometry.points().next() else { continue };
        let object = sheet.object_of(&source(finest).name, feature.record).unwrap().unwrap();
        for zoom in ALL_DANGERS..=MOST_ZOOM {
            let ([x, y], local) = in_tile(place, zoom);
            let layers = decoded(&sheet.tile(zoom, x, y).unwrap());
            let found = layers["danger"].iter().find(|got| got.id == u64::from(object));
            let found =
                found.unwrap_or_else(|| panic!("{} {} at zoom {zoom}", feature.class, feature.record));
            if matches!(feature.geometry, Geometry::Point(_)) {
                let [x, y] = found.parts[0][0];
                assert!((x as f64 - local[0]).abs() <= 1.0 && (y as f64 - local[1]).abs() <= 1.0);
            }
            assert_eq!(found.text("cls"), feature.class.acronym().unwrap());
            let at = LatLon::from_deg(place.lat_deg, place.lon_deg).unwrap();
            if let Some(around_m) = found.number("around_m") {
                // The danger itself counts for the index: what it lies in is no shallower.
                let here = index.depth_at(at, &Demand::default()).water.least_m();
                assert!(here.is_none_or(|here| here <= around_m), "{} {}", feature.class, feature.record);
                in_water += 1;
            }
            seen += 1;
        }
    }
    assert!(seen > 50 && in_water > seen / 2, "{seen}, {in_water} of them in charted water");
}

#[test]
fn soundings_are_thinned_shallowest_first() {
    let cells = cells();
    let sheet = sheet(&cells);
    let shallowest = |cell: &Cell| {
        let all = cell.features.iter().filter_map(|feature| match &feature.geometry {
            Geometry::Soundings(list) => Some(list.clone()),
            _ => None,
        });
        all.flatten().min_by(|a, b| a.depth_m.total_cmp(&b.depth_m)).unwrap()
    };
    let finest = cells.iter().max_by_key(|cell| cell.id.band).unwrap();
    let least = shallowest(finest);
    let counts: Vec<usize> = (9..=16)
        .map(|zoom| {
            let ([x, y], _) = in_tile(least.at, zoom);
            let layers = decoded(&sheet.tile(zoom, x, y).unwrap());
            let soundings = &layers["sounding"];
            assert!(soundings.iter().any(|one| one.number("depth_m") == Some(least.depth_m)), "zoom {zoom}");
            // 16 by 16 squares and those that the buffer touches.
            assert!(soundings.len() <= 18 * 18, "zoom {zoom}: {}", soundings.len());
            soundings.len()
        })
        .collect();
    assert!(counts[3] > 50, "{counts:?}");
}

#[test]
fn tiles_that_are_none_are_refused_and_empty_ones_are_empty() {
    let sheet = sheet(&cells());
    assert_eq!(sheet.tile(19, 0, 0), Err(NoTile::Zoom(19)));
    assert_eq!(sheet.tile(255, u32::MAX, 0), Err(NoTile::Zoom(255)));
    assert_eq!(sheet.tile(3, 8, 0), Err(NoTile::Place { zoom: 3, last: 7 }));
    assert_eq!(sheet.tile(18, 0, u32::MAX), Err(NoTile::Place { zoom: 18, last: (1 << 18) - 1 }));
    for (x, y) in [(0, 0), (0, (1 << 18) - 1), ((1 << 18) - 1, 0), ((1 << 18) - 1, (1 << 18) - 1)] {
        assert_eq!(sheet.tile(18, x, y), Ok(Vec::new()));
    }
    assert!(!sheet.tile(0, 0, 0).unwrap().is_empty() || !sheet.tile(8, 135, 69).unwrap().is_empty());
    assert_eq!(super::tests::sheet(&[]).tile(9, 270, 138), Ok(Vec::new()));
}

#[test]
fn a_coarser_chart_is_cut_off_where_a_finer_one_begins() {
    let cells = cells();
    let sheet = sheet(&cells);
    let near = |lat_deg: f64, lon_deg: f64| {
        let found = sheet.near(LatLon::from_deg(lat_deg, lon_deg).unwrap(), 30.0, 50).unwrap();
        let names = found.iter().map(|one| {
            let about = sheet.about(one.object).unwrap().unwrap();
            (sheet.source(&about).name.clone(), about.class)
        });
        names.collect::<BTreeSet<_>>()
    };
    let inside = near(63.446, 10.345);
    assert!(inside.contains(&("XX5LUTRA".to_owned(), ObjectClass::DEPARE)));
    assert!(inside.iter().all(|(name, _)| name == "XX5LUTRA"), "{inside:?}");
    let outside = near(63.46, 10.28);
    assert!(outside.iter().all(|(name, _)| name == "XX4LUTRA") && !outside.is_empty(), "{outside:?}");
}

/// A cell of one square of water between two corners, and an obstruction on its western and eastern side.
fn square(name: &str, [west, south, east, north]: [f64; 4]) -> Cell {
    let mut draft = CellDraft::new(name, 5, 10_000);
    let at = |lon_deg, lat_deg| GeoPoint { lon_deg, lat_deg };
    let corners = [at(west, south), at(west, north), at(east, north), at(east, south)];
    let nodes = corners.map(|corner| draft.records.connected_node(corner));
    let sides = [0, 1, 2, 3].map(|one| draft.records.edge(nodes[one], nodes[(one + 1) % 4], &[]));
    let ring = sides.map(VectorRef::forward);
    for class in [ObjectClass::M_COVR, ObjectClass::DEPARE] {
        let area = FeatureDraft::area(class, &ring).with(AttributeCode::CATCOV, "1");
        draft.records.feature(area.with(AttributeCode::DRVAL1, "5"));
    }
    for lon_deg in [west, east] {
        let node = draft.records.isolated_node(at(lon_deg, f64::midpoint(south, north)));
        draft.records.feature(FeatureDraft::point(ObjectClass::OBSTRN, node));
    }
    Cell::read(NamedBytes { name, bytes: &draft.to_bytes().unwrap() }, &[]).unwrap()
}

#[test]
fn cells_that_meet_at_the_antimeridian_fill_the_tiles_on_both_sides_of_it() {
    let cells = [
        square("XX5A0001.000", [179.9, -16.6, 180.0, -16.5]),
        square("XX5A0002.000", [-180.0, -16.6, -179.9, -16.5]),
    ];
    let sheet = sheet(&cells);
    for zoom in 4..=MOST_ZOOM {
        let last = (1_u32 << zoom) - 1;
        let (wide, middle) = (4096.0, GeoPoint { lon_deg: 180.0, lat_deg: -16.55 });
        let ([_, row], [_, y]) = in_tile(middle, zoom);
        // The cell's width in the units of the tile, by what is left of it there.
        let width = (0.1 / 360.0 * f64::from(1_u32 << zoom) * wide).min(wide + 64.0);
        for (column, edge, inwards) in [(last, wide, -1.0), (0, 0.0, 1.0)] {
            let layers = decoded(&sheet.tile(zoom, column, row).unwrap());
            let stands = |one: &Got| (one.parts[0][0][0] as f64 - edge).abs() <= 1.0;
            let danger = layers.get("danger").is_some_and(|dangers| dangers.iter().any(stands));
            assert!(
                danger || zoom < ALL_DANGERS,
                "zoom {zoom}, column {column}: what stands on the meridian"
            );
            if width < 8.0 {
                continue;
            }
            let [water] = layers["water"].as_slice() else { panic!("zoom {zoom}: {:?}", layers["water"]) };
            let at = |share: f64| [edge + inwards * share * width, y];
            assert!(water.holds(at(0.02)) && water.holds(at(0.9)), "zoom {zoom}, column {column}");
            assert!(zoom > 11 || !water.holds(at(1.2)), "zoom {zoom}: only as far as it goes");
            // The last of the world's units stands for 180°: at the finest zoom it is one short of the edge.
            let reach = water.parts.iter().flatten().map(|[x, _]| (*x as f64 - edge) * inwards);
            let (least, most) = reach.fold((f64::MAX, f64::MIN), |(a, b), x| (a.min(x), b.max(x)));
            assert!(
                (-64.0..=1.0).contains(&least) && (most - width).abs() <= 2.0,
                "{zoom}: {least} to {most}"
            );
        }
    }
    // None spans the world: between them there is nothing.
    for column in [1, 7, 14] {
        let ([_, row], _) = in_tile(GeoPoint { lon_deg: 0.0, lat_deg: -16.55 }, 4);
        assert_eq!(sheet.tile(4, column, row), Ok(Vec::new()));
    }
}
