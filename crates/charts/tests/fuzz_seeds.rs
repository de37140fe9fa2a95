//! The fuzz targets' bodies over their committed seeds and over everything they ever found.
//!
//! The seeds are this file's own: with LUTRA_WRITE_SEEDS set they are written anew.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

#[path = "../../../fuzz/bodies/charts.rs"]
mod bodies;
mod writer;

use charts::depth_index::IndexBuilder;
use charts::s57::{Cell, NamedBytes};
use writer::{DEPARE, DRVAL1, attributes, control, dsid, file, frid, point, sg2d, square, vrid};

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

fn with_update(update: &[u8]) -> Vec<u8> {
    let base = cell();
    [&(base.len() as u16).to_le_bytes(), base.as_slice(), update].concat()
}

fn index() -> Vec<u8> {
    let cell = Cell::read(NamedBytes { name: NAME, bytes: &cell() }, &[]).unwrap();
    let mut builder = IndexBuilder::new();
    builder.add_cell(&cell).unwrap();
    builder.build().unwrap().to_bytes()
}

fn seeds() -> Vec<(&'static str, &'static str, Vec<u8>)> {
    let land = br#"{"type":"Polygon","coordinates":[[[10,63],[11,63],[11,64],[10,63]]]}"#.to_vec();
    vec![
        ("charts_iso8211", "cell", cell()),
        ("charts_iso8211", "update", update()),
        ("charts_s57", "cell", with_update(&[])),
        ("charts_s57", "cell_and_update", with_update(&update())),
        ("charts_text", "soundings", b"269927.5527 7044215.8950 12.4\n# end\n269927 7044216 -0.3\n".to_vec()),
        ("charts_text", "land", land),
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
    for round in 0..1500 {
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
