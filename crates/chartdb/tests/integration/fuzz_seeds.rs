//! The body of the fuzz target `lakes` over its committed seeds, cut and with bits flipped, and over everything it
//! ever found.
//!
//! The seeds are this file's own: with LUTRA_WRITE_SEEDS set they are written again.

#[path = "../../../../fuzz/bodies/lakes.rs"]
mod bodies;

use shapefile::dbase::{FieldValue, Record, TableWriterBuilder};
use shapefile::{Point, Polygon, PolygonRing};
use std::path::PathBuf;

const LAKE: [(f64, f64); 5] = [(9.0, 60.0), (9.0, 60.1), (9.1, 60.1), (9.1, 60.0), (9.0, 60.0)];
const ISLAND: [(f64, f64); 5] = [(9.04, 60.04), (9.05, 60.04), (9.05, 60.05), (9.04, 60.05), (9.04, 60.04)];

fn shapefile() -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("lakes.shp");
    let table = TableWriterBuilder::new().add_numeric_field("depth".try_into().unwrap(), 6, 2);
    let mut writer = shapefile::Writer::from_path(&path, table).unwrap();
    let points = |ring: [(f64, f64); 5]| ring.map(|(x, y)| Point::new(x, y)).to_vec();
    let rings = vec![PolygonRing::Outer(points(LAKE)), PolygonRing::Inner(points(ISLAND))];
    for depth in [Some(4.5), None] {
        let mut record = Record::default();
        record.insert("depth".to_owned(), FieldValue::Numeric(depth));
        writer.write_shape_and_record(&Polygon::with_rings(rings.clone()), &record).unwrap();
    }
    drop(writer);
    let shapes = std::fs::read(&path).unwrap();
    let mut table = std::fs::read(path.with_extension("dbf")).unwrap();
    // The day on which it was written.
    table[1..4].copy_from_slice(&[126, 11, 21]);
    [&[bodies::SHAPEFILE], &(shapes.len() as u16).to_le_bytes()[..], &shapes, &table].concat()
}

fn geopackage() -> Vec<u8> {
    let mut bytes = [&[bodies::GEOPACKAGE], &b"GP\x00\x01\xE6\x10\x00\x00"[..]].concat();
    let number = |bytes: &mut Vec<u8>, value: u32| bytes.extend(value.to_le_bytes());
    for (kind, count) in [(6, 1), (3, 2)] {
        bytes.push(1);
        number(&mut bytes, kind);
        number(&mut bytes, count);
    }
    for ring in [LAKE, ISLAND] {
        number(&mut bytes, ring.len() as u32);
        for (x, y) in ring {
            bytes.extend(x.to_le_bytes());
            bytes.extend(y.to_le_bytes());
        }
    }
    bytes
}

fn seeds() -> Vec<(PathBuf, Vec<u8>)> {
    let folder = testkit::repository().join("fuzz/seeds/lakes");
    let made = [("shapefile", shapefile()), ("geopackage", geopackage())];
    if std::env::var_os("LUTRA_WRITE_SEEDS").is_some() {
        std::fs::create_dir_all(&folder).unwrap();
        for (name, bytes) in &made {
            std::fs::write(folder.join(name), bytes).unwrap();
        }
    }
    for (name, bytes) in &made {
        assert!(std::fs::read(folder.join(name)).unwrap() == *bytes, "{name} is not what this file makes");
    }
    let mut files: Vec<PathBuf> =
        std::fs::read_dir(&folder).unwrap().map(|one| one.unwrap().path()).collect();
    files.sort();
    files.into_iter().map(|path| (path.clone(), std::fs::read(path).unwrap())).collect()
}

#[test]
fn seeds_hold_whole_cut_and_with_bits_flipped() {
    for (path, bytes) in seeds() {
        println!("{}", path.display());
        bodies::lakes(&bytes);
        // A set takes tens of milliseconds to make: some of all places.
        for step in 0..40 {
            let at = step * (bytes.len() - 1) / 39;
            bodies::lakes(&bytes[..at]);
            let mut flipped = bytes.clone();
            flipped[at] ^= 1 << (step % 8);
            bodies::lakes(&flipped);
        }
    }
}
