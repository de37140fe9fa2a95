//! An exchange set: an ENC_ROOT tree with a catalogue, base cells and their updates.
//!
//! Pure: the caller reads the folder or archive and gives every file as a path with bytes. One bad cell does
//! not spoil the others; each failure names its file and remedy.

use super::catalogue::Catalogue;
use super::cell::Cell;
use super::error::{S57Error, S57Problem};
use super::named_bytes::NamedBytes;
use super::store::Notice;
use std::collections::BTreeMap;

/// A cell that could not be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CellFailure {
    /// The cell's name without extension.
    pub cell: String,
    /// Why it cannot be read.
    pub error: S57Error,
}

/// All cells of a tree.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ExchangeSet {
    /// The catalogue, where there is one.
    pub catalogue: Option<Catalogue>,
    /// Cells with all their updates, by name.
    pub cells: Vec<Cell>,
    /// Cells that the producer has withdrawn.
    pub cancelled: Vec<String>,
    /// Cells that could not be read.
    pub failures: Vec<CellFailure>,
    /// Other irregularities.
    pub notices: Vec<Notice>,
}

impl ExchangeSet {
    /// Reads all cells among some files; other files (texts, pictures) are passed over.
    pub fn read(files: &[NamedBytes<'_>]) -> Self {
        let mut set = Self::default();
        let mut groups: BTreeMap<String, BTreeMap<u16, NamedBytes<'_>>> = BTreeMap::new();
        for file in files {
            let name = base_name(file.name).to_ascii_uppercase();
            if name.starts_with("CATALOG.") {
                set.read_catalogue(*file);
                continue;
            }
            let Some((stem, number)) = cell_file(&name) else { continue };
            if groups.entry(stem).or_default().insert(number, *file).is_some() {
                let text = "there twice; the later one is taken".to_owned();
                set.notices.push(Notice { file: file.name.to_owned(), feature: None, text });
            }
        }
        set.compare_with_catalogue(files);
        let damaged: Vec<String> = set.failures.iter().map(|failure| failure.cell.clone()).collect();
        for (cell, files) in groups.into_iter().filter(|(cell, _)| !damaged.contains(cell)) {
            match read_group(&files) {
                Ok(read) => set.cells.push(read),
                Err(S57Error { problem: S57Problem::Cancelled, .. }) => set.cancelled.push(cell),
                Err(error) => set.failures.push(CellFailure { cell, error }),
            }
        }
        set
    }

    fn read_catalogue(&mut self, file: NamedBytes<'_>) {
        match Catalogue::read(file.name, file.bytes) {
            Ok(catalogue) => self.catalogue = Some(catalogue),
            Err(error) => self.failures.push(CellFailure { cell: "CATALOG".to_owned(), error }),
        }
    }

    /// Files that the catalogue lists must be there and have its checksums.
    fn compare_with_catalogue(&mut self, files: &[NamedBytes<'_>]) {
        let by_name: BTreeMap<String, &NamedBytes<'_>> =
            files.iter().map(|file| (base_name(file.name).to_ascii_uppercase(), file)).collect();
        for entry in self.catalogue.iter().flat_map(|catalogue| &catalogue.entries) {
            let name = base_name(&entry.file).to_ascii_uppercase();
            let Some(file) = by_name.get(&name) else {
                let text = "the catalogue lists it, but it is not there".to_owned();
                self.notices.push(Notice { file: entry.file.clone(), feature: None, text });
                continue;
            };
            let found = crc32fast::hash(file.bytes);
            let Some(expected) = entry.crc32.filter(|expected| *expected != found) else { continue };
            let problem = S57Problem::Checksum { expected, found };
            let error = S57Error { file: file.name.to_owned(), place: None, problem };
            let cell = name.split('.').next().unwrap_or_default().to_owned();
            // A text file with a wrong checksum spoils no chart.
            if cell_file(&name).is_some() {
                self.failures.push(CellFailure { cell, error });
            } else {
                self.notices.push(Notice {
                    file: file.name.to_owned(),
                    feature: None,
                    text: error.to_string(),
                });
            }
        }
    }
}

fn read_group(files: &BTreeMap<u16, NamedBytes<'_>>) -> Result<Cell, S57Error> {
    let mut files = files.values();
    let first = files.next().copied().unwrap_or(NamedBytes { name: "", bytes: &[] });
    if !first.name.ends_with(".000") {
        return Err(S57Error { file: first.name.to_owned(), place: None, problem: S57Problem::NoBase });
    }
    let updates: Vec<NamedBytes<'_>> = files.copied().collect();
    Cell::read(first, &updates)
}

fn base_name(path: &str) -> &str {
    path.rsplit(['/', '\\']).next().unwrap_or(path)
}

/// `US5WA22M.004` is cell `US5WA22M` and number 4: two letters, a band digit, five characters, three digits.
fn cell_file(name: &str) -> Option<(String, u16)> {
    let (stem, extension) = name.split_once('.')?;
    let bytes = stem.as_bytes();
    let named = bytes.len() == 8 && bytes.iter().all(u8::is_ascii_alphanumeric) && bytes[2].is_ascii_digit();
    let numbered = extension.len() == 3 && extension.bytes().all(|byte| byte.is_ascii_digit());
    if named && numbered { Some((stem.to_owned(), extension.parse().ok()?)) } else { None }
}
