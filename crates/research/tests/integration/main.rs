//! Tables of detections from outside: the fuzz target's body over its committed seeds, cut and damaged.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

#[path = "../../../../fuzz/bodies/detection_tables.rs"]
mod bodies;

use research::{About, Carriers, Lag, Study, Writer, format, read_detections};
use std::fs;
use tables::Dialect;

/// A table of ours in a format, of one detection.
fn ours(name: &str) -> Vec<u8> {
    let seed = testkit::repository().join("fuzz/seeds/detection_tables/vue.csv");
    let (study, mut out) = (Study::default(), Vec::new());
    let mut writer = Writer::new(format(name).unwrap(), Dialect::Plain);
    writer.header(&mut out).unwrap();
    let carriers = Carriers { system: Some(0x2810), address: &|_| Ok(0x2810), study: &study };
    let mut take = |one| writer.row(&mut out, &study.heard(&one, "otter-1", Lag::Unknown)).map(drop);
    assert_eq!(read_detections(&*fs::read(seed).unwrap(), &carriers, &mut take).unwrap().rows, 1);
    writer.end(&mut out, &study, &About::default()).unwrap();
    out
}

/// A table holds as it is, cut, and damaged at each byte; of a larger one at a thousand of them.
fn holds(whole: &[u8]) {
    bodies::table(whole);
    for at in (0..whole.len()).step_by(1 + whole.len() / 1_000) {
        bodies::table(&whole[..at]);
        let mut damaged = whole.to_vec();
        for bit in [0x01, 0x80] {
            damaged[at] ^= bit;
            bodies::table(&damaged);
            damaged[at] ^= bit;
        }
    }
}

#[test]
fn our_own_tables_hold_cut_and_damaged() {
    for name in ["lutra", "parquet"] {
        let whole = ours(name);
        println!("{name}: {} bytes", whole.len());
        holds(&whole);
    }
}

#[test]
fn seeds_hold_cut_and_damaged_at_any_byte() {
    let folder = testkit::repository().join("fuzz/seeds/detection_tables");
    let mut files: Vec<_> = fs::read_dir(&folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    files.sort();
    assert!(files.len() > 3, "{} lacks seeds", folder.display());
    for file in files {
        println!("{}", file.display());
        holds(&fs::read(file).unwrap());
    }
}
