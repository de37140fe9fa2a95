//! Which files are to be imported: cells with their updates, gathered from folders or named one by one.

use crate::error::{ChartDbError, Named as _, Result};
use crate::supplements;
use charts::s57::{Catalogue, S57Error, S57Problem};
use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::path::{Path, PathBuf};

/// Folders in folders; an ENC_ROOT has four or five.
const DEEPEST: usize = 32;

/// A file larger than this is not a cell: by the standard they have 5 MB at most (S-57 appendix B.1, 2.2).
const MOST_CELL_BYTES: u64 = 256 << 20;

/// What to import, in order.
#[derive(Debug, Default)]
pub(crate) struct Found {
    /// Base and updates of each cell by name, by their number.
    pub(crate) cells: BTreeMap<String, BTreeMap<u16, PathBuf>>,
    pub(crate) soundings: Vec<PathBuf>,
    pub(crate) land: Vec<PathBuf>,
    pub(crate) lakes: Vec<PathBuf>,
    /// Checksums by file name in capitals.
    pub(crate) checksums: BTreeMap<String, u32>,
    /// Oddities that do not stop the import.
    pub(crate) notices: Vec<String>,
    /// Files that spoil a cell, by the cell's name.
    pub(crate) failures: Vec<(String, ChartDbError)>,
}

impl Found {
    pub(crate) fn count(&self) -> usize {
        self.cells.len() + self.soundings.len() + self.land.len() + self.lakes.len()
    }

    /// The names that the charts have in a set.
    pub(crate) fn names(&self) -> BTreeSet<String> {
        let files = self.soundings.iter().chain(&self.land).chain(&self.lakes);
        self.cells.keys().cloned().chain(files.map(|path| supplements::name(path))).collect()
    }

    /// Looks through folders for cells, and takes files for what their endings say.
    pub(crate) fn of(inputs: &[PathBuf]) -> Result<Self> {
        let mut found = Self::default();
        for input in inputs {
            if fs::metadata(input).named(input)?.is_dir() {
                let before = found.cells.len();
                found.folder(input, DEEPEST)?;
                if found.cells.len() == before {
                    let problem = "there is no S-57 cell (a file like NO4D1620.000) in this folder; \
                                   give the ENC_ROOT folder, and soundings, land and lakes as files";
                    return Err(ChartDbError::file(input.display().to_string(), problem));
                }
            } else {
                found.file(input)?;
            }
        }
        Ok(found)
    }

    fn folder(&mut self, folder: &Path, deepest: usize) -> Result<()> {
        let mut paths = Vec::new();
        for entry in fs::read_dir(folder).named(folder)? {
            paths.push(entry.named(folder)?.path());
        }
        paths.sort();
        for path in paths {
            // A link to a folder could lead round in a circle.
            let kind = fs::symlink_metadata(&path).named(&path)?;
            if kind.is_dir() && deepest > 0 {
                self.folder(&path, deepest - 1)?;
            } else if is_catalogue(&path) {
                self.catalogue(&path)?;
            } else if let Some((name, number)) = cell_file(&path).filter(|(name, _)| is_cell_name(name)) {
                self.cell(name, number, &path)?;
            }
        }
        Ok(())
    }

    fn file(&mut self, path: &Path) -> Result<()> {
        size_of(path)?;
        if is_catalogue(path) {
            return self.catalogue(path);
        }
        if let Some((name, number)) = cell_file(path) {
            self.cell(name.clone(), number, path)?;
            return self.siblings(path, &name);
        }
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        match ending.as_deref() {
            Some("xyz") => self.soundings.push(path.to_owned()),
            Some("geojson" | "json") => self.land.push(path.to_owned()),
            Some("shp" | "gpkg") => self.lakes.push(path.to_owned()),
            _ => {
                let problem = "nothing is known of files with this ending; give S-57 cells (.000 and updates) or \
                               folders of them, soundings (.xyz), land (.geojson) or lakes (.shp, .gpkg)";
                return Err(ChartDbError::file(path.display().to_string(), problem));
            }
        }
        Ok(())
    }

    /// A cell that is named by one of its files comes with all updates beside it.
    fn siblings(&mut self, path: &Path, name: &str) -> Result<()> {
        let folder = path.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
        for entry in fs::read_dir(folder).named(folder)? {
            let sibling = entry.named(folder)?.path();
            if let Some((other, number)) = cell_file(&sibling).filter(|(other, _)| other == name) {
                self.cell(other, number, &sibling)?;
            }
        }
        Ok(())
    }

    fn cell(&mut self, name: String, number: u16, path: &Path) -> Result<()> {
        let files = self.cells.entry(name.clone()).or_default();
        let Some(before) = files.insert(number, path.to_owned()) else { return Ok(()) };
        let same_file = fs::canonicalize(&before).named(&before)? == fs::canonicalize(path).named(path)?;
        if !same_file && read(&before)? != read(path)? {
            let problem = format!("{} is another file of the same name; keep one of them", before.display());
            self.failures.push((name, ChartDbError::file(path.display().to_string(), problem)));
        }
        Ok(())
    }

    fn catalogue(&mut self, path: &Path) -> Result<()> {
        let bytes = read(path)?;
        let name = path.display().to_string();
        match Catalogue::read(&name, &bytes) {
            Ok(catalogue) => {
                let root = path.parent().unwrap_or(Path::new(""));
                for entry in catalogue.entries {
                    let relative: PathBuf = entry.file.split(['/', '\\']).collect();
                    let file = base_name(&relative);
                    if !file.is_empty() && !root.join(&relative).exists() && !root.join(&file).exists() {
                        let text = format!("{name}: {} is listed, but it is not there", entry.file);
                        self.notices.push(text);
                    }
                    if let Some(checksum) = entry.crc32 {
                        self.checksums.insert(file, checksum);
                    }
                }
            }
            Err(error) => self.failures.push(("CATALOG".to_owned(), error.into())),
        }
        Ok(())
    }

    /// Compares a file with what the catalogue says of it.
    pub(crate) fn verify(&self, path: &Path, bytes: &[u8]) -> Result<(), S57Error> {
        let Some(expected) = self.checksums.get(&base_name(path)).copied() else { return Ok(()) };
        let found = crc32fast::hash(bytes);
        if found == expected {
            return Ok(());
        }
        let problem = S57Problem::Checksum { expected, found };
        Err(S57Error { file: path.display().to_string(), place: None, problem })
    }
}

/// The bytes of a cell, an update or a catalogue. What cannot be one is refused before it is read.
pub(crate) fn read(path: &Path) -> Result<Vec<u8>> {
    let bytes = size_of(path)?;
    if bytes > MOST_CELL_BYTES {
        let problem = format!(
            "{} MB are too much for an S-57 cell, which has 5 MB at most; give the cells as their producer gives them",
            bytes >> 20
        );
        return Err(ChartDbError::file(path.display().to_string(), problem));
    }
    fs::read(path).named(path)
}

/// The size of a file. Anything else is refused: a pipe would wait for ever, and a device has no end.
fn size_of(path: &Path) -> Result<u64> {
    let about = fs::metadata(path).named(path)?;
    if about.is_file() {
        return Ok(about.len());
    }
    let problem = "this is not a file but a pipe, a device or a folder; give the file itself";
    Err(ChartDbError::file(path.display().to_string(), problem))
}

fn base_name(path: &Path) -> String {
    path.file_name().map(|name| name.to_string_lossy().to_ascii_uppercase()).unwrap_or_default()
}

fn is_catalogue(path: &Path) -> bool {
    matches!(base_name(path).as_str(), "CATALOG.031" | "CATALOG.030")
}

/// Name and number of a file with three digits as its ending.
fn cell_file(path: &Path) -> Option<(String, u16)> {
    let name = base_name(path);
    let (stem, ending) = name.rsplit_once('.')?;
    let numbered = ending.len() == 3 && ending.bytes().all(|byte| byte.is_ascii_digit());
    if numbered && stem != "CATALOG" { Some((stem.to_owned(), ending.parse().ok()?)) } else { None }
}

/// Two letters, a band digit, five characters (S-57 appendix B.1, 5.6.3).
fn is_cell_name(name: &str) -> bool {
    let bytes = name.as_bytes();
    bytes.len() == 8 && bytes.iter().all(u8::is_ascii_alphanumeric) && bytes[2].is_ascii_digit()
}
