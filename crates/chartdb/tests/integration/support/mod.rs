//! What the tests of this crate share.

use chartdb::{ImportOptions, ImportReport};
use charts::s57::{Cell, NamedBytes};
use std::path::{Path, PathBuf};
use units::UtcTime;

pub(crate) const CELLS: [(&str, usize); 9] = [
    ("US4MD81M", 3),
    ("US5WA22M", 4),
    ("US5MD1MC", 0),
    ("US1BS01M", 0),
    ("GB4X0000", 0),
    ("GB5X01NE", 0),
    ("GB5X01NW", 0),
    ("GB5X01SE", 0),
    ("GB5X02SE", 0),
];

pub(crate) fn options() -> ImportOptions {
    // 2026-11-21T12:00:00Z.
    ImportOptions::new(UtcTime::from_micros(1_795_262_400_000_000))
}

pub(crate) fn import(db: &Path, inputs: &[PathBuf]) -> ImportReport {
    chartdb::import(db, inputs, &options(), &mut |_| true).unwrap()
}

/// Base and the first updates of a shared cell, copied into a folder.
pub(crate) fn put(folder: &Path, name: &str, updates: usize) -> Option<PathBuf> {
    for number in 0..=updates {
        let file = format!("{name}.{number:03}");
        std::fs::copy(testkit::shared(&format!("data/charts/{file}"))?, folder.join(file)).unwrap();
    }
    Some(folder.join(format!("{name}.000")))
}

/// The same as the reader of cells reads it.
pub(crate) fn cell(name: &str, updates: usize) -> Option<Cell> {
    let names: Vec<String> = (0..=updates).map(|number| format!("{name}.{number:03}")).collect();
    let mut files = Vec::new();
    for name in &names {
        files.push(std::fs::read(testkit::shared(&format!("data/charts/{name}"))?).unwrap());
    }
    let named: Vec<NamedBytes<'_>> =
        names.iter().zip(&files).map(|(name, bytes)| NamedBytes { name, bytes }).collect();
    Some(Cell::read(named[0], &named[1..]).unwrap())
}

/// Every file of a folder with its bytes, but those of the lock.
pub(crate) fn contents(folder: &Path) -> Vec<(PathBuf, Vec<u8>)> {
    let entries = std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let mut files: Vec<PathBuf> =
        entries.filter(|path| path.is_file() && !path.to_string_lossy().ends_with(".lock")).collect();
    files.sort();
    files.into_iter().map(|path| (path.clone(), std::fs::read(path).unwrap())).collect()
}
