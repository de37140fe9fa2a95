//! The chart set as vessels get it: the depth index built from the charts, identified by the SHA-256 of its bytes.

use bytes::Bytes;
use chartdb::{LoadedIndex, index_path};
use charts::depth_index::{IndexBytes as _, PackedIndex};
use link::{ChartDigest, ChartOffer};
use sha2::{Digest as _, Sha256};
use std::fs::File;
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};

/// The bytes, read from a file that is kept open: an import replaces the file and does not change the open one.
#[derive(Debug)]
pub struct ChartPackage {
    path: PathBuf,
    packed: PackedIndex,
    digest: ChartDigest,
    edition: String,
}

/// Bytes of a package that are in memory at a time.
const READ_BYTES: u64 = 256 << 10;

impl ChartPackage {
    /// The index beside the set at `db`, which must be the `loaded` one.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn open(db: &Path, loaded: &LoadedIndex) -> io::Result<Self> {
        let (packed, mut hash) = (loaded.sealed.packed(), Sha256::new());
        each(&packed, |bytes| {
            hash.update(bytes);
            Ok(())
        })?;
        let (digest, edition) = (hash.finalize().into(), loaded.sealed.index.edition());
        Ok(Self { path: index_path(db), packed, digest, edition })
    }

    /// Path of the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// The offer to vessels.
    pub fn offer(&self) -> ChartOffer {
        ChartOffer { digest: self.digest, bytes: self.packed.length(), edition: self.edition.clone() }
    }

    /// SHA-256 of the file.
    pub fn digest(&self) -> ChartDigest {
        self.digest
    }

    /// A part of it; `None` if it cannot be read.
    pub fn part(&self, offset: u64, length: u32) -> Option<Bytes> {
        let read = self.packed.read(offset, length as usize);
        let part =
            read.inspect_err(|error| tracing::error!(error, "the chart for the vessels cannot be read"));
        part.ok().map(Bytes::from)
    }

    /// Copies all of it to `to`, written under another name and renamed when complete.
    ///
    /// # Errors
    /// Reading or writing fails.
    pub fn copy(&self, to: &Path) -> io::Result<()> {
        let mut part = to.as_os_str().to_owned();
        part.push(".part");
        let part = PathBuf::from(part);
        let copy = || {
            let mut file = File::create(&part)?;
            each(&self.packed, |bytes| file.write_all(bytes))?;
            file.sync_all()?;
            std::fs::rename(&part, to)?;
            let folder =
                to.parent().filter(|folder| !folder.as_os_str().is_empty()).unwrap_or(Path::new("."));
            File::open(folder)?.sync_all()
        };
        copy().inspect_err(|_| {
            std::fs::remove_file(&part).ok();
        })
    }
}

/// Gives all bytes, part after part.
fn each(packed: &PackedIndex, mut give: impl FnMut(&[u8]) -> io::Result<()>) -> io::Result<()> {
    let mut offset = 0;
    while offset < packed.length() {
        let length = READ_BYTES.min(packed.length() - offset);
        give(&packed.read(offset, length as usize).map_err(io::Error::other)?)?;
        offset += length;
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_goes_out_as_it_was_opened_although_another_takes_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let (db, cells) = (folder.path().join("chart.gpkg"), folder.path().join("cells"));
        std::fs::create_dir(&cells).unwrap();
        for file in charts::demo::archipelago().unwrap() {
            std::fs::write(cells.join(file.name), file.bytes).unwrap();
        }
        let options = chartdb::ImportOptions::new(units::UtcTime::from_micros(0));
        assert!(chartdb::import(&db, &[cells], &options, &mut |_| true).unwrap().applied);
        let bytes = std::fs::read(index_path(&db)).unwrap();
        let package = ChartPackage::open(&db, &chartdb::load_index(&db).unwrap()).unwrap();
        assert_eq!(package.offer().digest[..], Sha256::digest(&bytes)[..]);
        assert_eq!(package.offer().bytes, bytes.len() as u64);

        let other = folder.path().join("other");
        std::fs::write(&other, b"something else").unwrap();
        std::fs::rename(&other, index_path(&db)).unwrap();
        assert_eq!(package.part(5, 20_000).unwrap(), bytes[5..20_005]);
        assert_eq!(package.part(bytes.len() as u64 - 5, 6), None);
        let copy = folder.path().join("copy");
        for _ in 0..2 {
            package.copy(&copy).unwrap();
            assert!(std::fs::read(&copy).unwrap() == bytes);
        }
    }
}
