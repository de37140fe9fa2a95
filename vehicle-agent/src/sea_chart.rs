//! The sea chart that the shore sends, on the disk.
//!
//! The folder holds `chart.lutra-index`, the last complete one, and `<digest>.part`, the received part of the next. A part
//! becomes the chart by one rename, after its digest was compared and all of it was read as a chart: until then the old one
//! stays. A `chart.lutra-index` that an operator puts there is read at the next start.

use link::{ChartDigest, ChartOffer};
use onboard::ChartFile;
use sha2::{Digest as _, Sha256};
use std::fs::{self, File};
use std::io::{self, ErrorKind};
use std::os::unix::fs::FileExt as _;
use std::path::{Path, PathBuf};

const FILE: &str = "chart.lutra-index";
/// Disk space that a chart must leave free, for the vessel's records.
const RESERVE_BYTES: u64 = 64 << 20;
/// Largest chart: the chart in force is in memory as a whole.
const MOST_BYTES: u64 = 512 << 20;
/// Received data are synced to disk after so many bytes.
const SYNC_EVERY_BYTES: u64 = 1 << 20;

/// The folder, and the part that is being written.
#[derive(Debug)]
pub(crate) struct ChartFolder {
    folder: PathBuf,
    coming: Option<Coming>,
}

#[derive(Debug)]
struct Coming {
    offer: ChartOffer,
    file: File,
    have: u64,
    synced: u64,
}

impl ChartFolder {
    /// The folder in the agent's data folder; it is made when needed.
    pub(crate) fn new(data: &Path) -> Self {
        Self { folder: data.join("chart"), coming: None }
    }

    fn path(&self) -> PathBuf {
        self.folder.join(FILE)
    }

    fn part(&self, digest: &ChartDigest) -> PathBuf {
        self.folder.join(format!("{}.part", hex::encode(digest)))
    }

    /// The stored chart, if any.
    ///
    /// # Errors
    /// When it cannot be read.
    pub(crate) fn load(&self) -> Result<Option<ChartFile>, String> {
        let path = self.path();
        let name = path.display().to_string();
        match fs::read(&path) {
            Err(error) if error.kind() == ErrorKind::NotFound => Ok(None),
            Err(error) => Err(format!("{name}: {error}")),
            Ok(bytes) => ChartFile::read(&name, &bytes).map(Some).map_err(|error| format!("{name}: {error}")),
        }
    }

    /// Prepares to receive a chart; returns how many bytes of it are there.
    ///
    /// # Errors
    /// When it cannot be received; the text is for people ashore.
    pub(crate) fn begin(&mut self, offer: ChartOffer) -> Result<u64, String> {
        self.coming = None;
        if offer.bytes > MOST_BYTES {
            let (has, most) = (mebibytes(offer.bytes), mebibytes(MOST_BYTES));
            return Err(format!("the chart has {has} MiB, {most} are the most aboard; leave charts out"));
        }
        let part = self.part(&offer.digest);
        let open = || -> io::Result<(File, u64)> {
            fs::create_dir_all(&self.folder)?;
            self.forget_others(&part)?;
            let file = File::options().create(true).truncate(false).write(true).open(&part)?;
            let have = file.metadata()?.len();
            if have <= offer.bytes {
                return Ok((file, have));
            }
            file.set_len(0)?;
            Ok((file, 0))
        };
        let (file, have) = open().map_err(|error| format!("{}: {error}", part.display()))?;
        let needed = offer.bytes - have;
        let free = rustix::fs::statvfs(&self.folder).map(|disk| disk.f_bavail * disk.f_frsize);
        if let Some(free) = free.ok().filter(|free| *free < needed + RESERVE_BYTES) {
            let (free, needed, stays) = (mebibytes(free), mebibytes(needed), mebibytes(RESERVE_BYTES));
            return Err(format!(
                "the vessel's disk is full: {free} MiB are free, the chart needs {needed} and {stays} stay free"
            ));
        }
        self.coming = Some(Coming { offer, file, have, synced: have });
        Ok(have)
    }

    /// Removes parts of other charts.
    fn forget_others(&self, part: &Path) -> io::Result<()> {
        for entry in fs::read_dir(&self.folder)? {
            let path = entry?.path();
            if path != part && path.extension().is_some_and(|extension| extension == "part") {
                fs::remove_file(path)?;
            }
        }
        Ok(())
    }

    /// Stores a part of the chart; returns how many bytes of it are there. `None` for a part of another chart or with
    /// another offset.
    ///
    /// # Errors
    /// When it cannot be written; the text is for people ashore.
    pub(crate) fn keep(
        &mut self,
        digest: &ChartDigest,
        offset: u64,
        bytes: &[u8],
    ) -> Result<Option<u64>, String> {
        let Some(coming) = self.coming.as_mut().filter(|coming| coming.offer.digest == *digest) else {
            return Ok(None);
        };
        let end = offset.saturating_add(bytes.len() as u64);
        if offset != coming.have || end > coming.offer.bytes {
            return Ok(None);
        }
        let mut write = || -> io::Result<()> {
            coming.file.write_all_at(bytes, offset)?;
            if end - coming.synced >= SYNC_EVERY_BYTES {
                coming.file.sync_data()?;
                coming.synced = end;
            }
            Ok(())
        };
        write().map_err(|error| match error.kind() {
            ErrorKind::StorageFull => "the vessel's disk is full: make room aboard".to_owned(),
            _ => format!("the vessel's disk does not take the chart: {error}"),
        })?;
        coming.have = end;
        Ok(Some(end))
    }

    /// Whether the chart is complete.
    pub(crate) fn is_whole(&self) -> bool {
        self.coming.as_ref().is_some_and(|coming| coming.have == coming.offer.bytes)
    }

    /// Replaces the previous chart by the complete new one, if it matches the offer and is a valid chart.
    ///
    /// # Errors
    /// When it is not, or a file operation fails; the text is for people ashore. Received data that are not valid are
    /// removed.
    pub(crate) fn finish(&mut self) -> Result<ChartFile, String> {
        let Some(Coming { offer, file, .. }) = self.coming.take() else {
            return Err("no chart was begun".to_owned());
        };
        let (part, path) = (self.part(&offer.digest), self.path());
        let trouble = |error: io::Error| format!("the vessel's disk does not keep the chart: {error}");
        file.sync_all().map_err(trouble)?;
        let bytes = fs::read(&part).map_err(trouble)?;
        let refuse = |why: String| {
            fs::remove_file(&part).ok();
            why
        };
        if Sha256::digest(&bytes)[..] != offer.digest {
            let why = "the chart came damaged: its SHA-256 is not the one that was offered";
            return Err(refuse(why.to_owned()));
        }
        let chart = ChartFile::read(&path.display().to_string(), &bytes);
        let chart = chart.map_err(|error| refuse(format!("what came cannot be used aboard: {error}")))?;
        fs::rename(&part, &path).and_then(|()| File::open(&self.folder)?.sync_all()).map_err(trouble)?;
        Ok(chart)
    }
}

fn mebibytes(bytes: u64) -> u64 {
    bytes.div_ceil(1 << 20)
}

#[cfg(test)]
mod tests {
    use super::*;
    use units::LatLon;

    fn chart(depth_m: f64) -> (ChartOffer, Vec<u8>) {
        let middle = LatLon::from_deg(63.33, 10.08).unwrap();
        let bytes = testkit::sea::Sea::new(middle, 500.0, depth_m).index().to_bytes();
        (offer(&bytes), bytes)
    }

    fn offer(bytes: &[u8]) -> ChartOffer {
        let digest = Sha256::digest(bytes).into();
        ChartOffer { digest, bytes: bytes.len() as u64, edition: "sea".to_owned() }
    }

    fn names(data: &Path) -> Vec<String> {
        let names = fs::read_dir(data.join("chart")).unwrap();
        names.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect()
    }

    #[test]
    fn a_chart_comes_in_parts_over_restarts_and_takes_the_place_of_the_one_before() {
        let data = tempfile::tempdir().unwrap();
        let mut folder = ChartFolder::new(data.path());
        assert_eq!(folder.load(), Ok(None));
        for depth_m in [20.0, 30.0] {
            let (offer, bytes) = chart(depth_m);
            let middle = bytes.len() / 2;
            assert_eq!(folder.begin(offer.clone()), Ok(0));
            assert_eq!(folder.keep(&offer.digest, 0, &bytes[..middle]), Ok(Some(middle as u64)));
            // A part that does not continue the stored one is not stored.
            assert_eq!(folder.keep(&offer.digest, 0, &bytes[..middle]), Ok(None));
            assert_eq!(folder.keep(&[0; 32], middle as u64, &bytes[middle..]), Ok(None));
            folder = ChartFolder::new(data.path());
            assert_eq!(folder.begin(offer.clone()), Ok(middle as u64));
            assert!(!folder.is_whole());
            folder.keep(&offer.digest, middle as u64, &bytes[middle..]).unwrap();
            assert!(folder.is_whole());
            let whole = folder.finish().unwrap();
            assert_eq!(whole.digest(), offer.digest);
            assert_eq!(folder.load(), Ok(Some(whole)));
            assert_eq!(names(data.path()), [FILE]);
        }
    }

    #[test]
    fn what_is_damaged_or_no_chart_is_refused_and_the_old_one_stays() {
        let data = tempfile::tempdir().unwrap();
        let mut folder = ChartFolder::new(data.path());
        let mut bring = |offer: ChartOffer, bytes: &[u8]| {
            folder.begin(offer.clone())?;
            folder.keep(&offer.digest, 0, bytes)?;
            folder.finish()
        };
        let (good, bytes) = chart(20.0);
        bring(good.clone(), &bytes).unwrap();
        let (better, mut damaged) = chart(30.0);
        damaged[100] ^= 1;
        assert!(bring(better, &damaged).unwrap_err().contains("came damaged"));
        // A hostile shore: the digest matches, but the file is not a chart.
        assert!(bring(offer(&damaged), &damaged).unwrap_err().contains("cannot be used aboard"));
        assert!(bring(offer(b"not a chart"), b"not a chart").unwrap_err().contains("cannot be used aboard"));
        let huge = ChartOffer { bytes: u64::MAX, ..good.clone() };
        assert!(bring(huge, &bytes).unwrap_err().contains("the most aboard"));
        assert_eq!(folder.load().unwrap().unwrap().digest(), good.digest);
        assert_eq!(names(data.path()), [FILE]);
    }

    #[test]
    fn a_full_disk_is_told_and_what_came_of_another_chart_makes_room() {
        let data = tempfile::tempdir().unwrap();
        let mut folder = ChartFolder::new(data.path());
        let (old, _) = chart(10.0);
        folder.begin(old.clone()).unwrap();
        let (new, bytes) = chart(20.0);
        // A file that cannot be written.
        std::os::unix::fs::symlink("/dev/full", folder.part(&new.digest)).unwrap();
        assert_eq!(folder.begin(new.clone()), Ok(0));
        assert!(!folder.part(&old.digest).exists());
        let refused = folder.keep(&new.digest, 0, &bytes).unwrap_err();
        assert!(refused.contains("disk is full"), "{refused}");
    }
}
