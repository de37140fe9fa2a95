//! The chart set as it goes to the vessels: the depth index beside it, under the SHA-256 of its bytes.

use bytes::Bytes;
use chartdb::{LoadedIndex, index_path};
use charts::depth_index::SealedIndex;
use link::{ChartDigest, ChartOffer};
use sha2::{Digest as _, Sha256};
use std::fs::File;
use std::io::{self, Read as _};
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};

/// The file, held open: an import meanwhile puts another in its place and leaves this one as it is.
#[derive(Debug)]
pub struct Parcel {
    path: PathBuf,
    file: File,
    digest: ChartDigest,
    bytes: u64,
    edition: String,
}

impl Parcel {
    /// The index beside the set at `db`, which is what was `loaded`.
    ///
    /// # Errors
    /// When there is none, or it is of another state of the set.
    pub fn open(db: &Path, loaded: &LoadedIndex) -> io::Result<Self> {
        let path = index_path(db);
        let file = File::open(&path)?;
        let (mut hash, mut bytes, mut buffer) = (Sha256::new(), 0, vec![0; 256 << 10]);
        loop {
            let read = (&file).read(&mut buffer)?;
            if bytes == 0 && SealedIndex::digest_of(&buffer[..read]) != Some(loaded.sealed.digest) {
                return Err(io::Error::other("it belongs to another state of the chart set"));
            }
            if read == 0 {
                break;
            }
            hash.update(&buffer[..read]);
            bytes += read as u64;
        }
        let digest = hash.finalize().into();
        Ok(Self { path, file, digest, bytes, edition: loaded.sealed.index.edition() })
    }

    /// Where the file lies.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// What vessels are offered.
    pub fn offer(&self) -> ChartOffer {
        ChartOffer { digest: self.digest, bytes: self.bytes, edition: self.edition.clone() }
    }

    /// SHA-256 of the file.
    pub fn digest(&self) -> ChartDigest {
        self.digest
    }

    /// A part of it; nothing where it cannot be read.
    pub fn part(&self, offset: u64, length: u32) -> Option<Bytes> {
        let mut part = vec![0; length as usize];
        let read = self.file.read_exact_at(&mut part, offset);
        read.inspect_err(|error| tracing::error!(%error, "the chart for the vessels cannot be read")).ok()?;
        Some(part.into())
    }

    /// All of it, through a file at `to` that is whole as soon as it bears that name.
    ///
    /// # Errors
    /// A disk does not do it.
    pub fn copy(&self, to: &Path) -> io::Result<()> {
        let mut part = to.as_os_str().to_owned();
        part.push(".part");
        let part = PathBuf::from(part);
        let copy = || {
            let mut file = File::create(&part)?;
            let copied = io::copy(&mut &self.file_at_start()?, &mut file)?;
            if copied != self.bytes {
                return Err(io::Error::other("the chart set changed meanwhile; copy again"));
            }
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

    fn file_at_start(&self) -> io::Result<File> {
        use std::io::Seek as _;
        let mut file = self.file.try_clone()?;
        file.rewind()?;
        Ok(file)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_goes_out_as_it_was_opened_although_another_takes_its_place() {
        let folder = tempfile::tempdir().unwrap();
        let db = folder.path().join("chart.gpkg");
        let sealed = SealedIndex { digest: [7; 32], index: charts::depth_index::DepthIndex::default() };
        let bytes = sealed.to_bytes();
        std::fs::write(index_path(&db), &bytes).unwrap();
        let loaded = LoadedIndex { sealed, rebuilt: None };
        let parcel = Parcel::open(&db, &loaded).unwrap();
        assert_eq!(parcel.offer().digest[..], Sha256::digest(&bytes)[..]);
        assert_eq!((parcel.offer().bytes, &parcel.offer().edition[..]), (bytes.len() as u64, "no charts"));

        let other = folder.path().join("other");
        std::fs::write(&other, b"something else").unwrap();
        std::fs::rename(&other, index_path(&db)).unwrap();
        assert_eq!(parcel.part(5, 20).unwrap(), bytes[5..25]);
        assert_eq!(parcel.part(5, 2000), None);
        let copy = folder.path().join("copy");
        for _ in 0..2 {
            parcel.copy(&copy).unwrap();
            assert_eq!(std::fs::read(&copy).unwrap(), bytes);
        }
        assert!(Parcel::open(&db, &loaded).unwrap_err().to_string().contains("another state"));
    }
}
