//! Checks the contents of a backup, before recordings are deleted.

use super::forms;
use super::manifest::{ASIDE, Entry, MANIFEST, Manifest, Stamp, hash_prefix};
use anyhow::{Context as _, ensure};
use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::time::SystemTime;
use units::UtcTime;

/// A backup whose contents are checked.
#[derive(Debug)]
pub struct Held {
    folder: PathBuf,
    files: BTreeMap<PathBuf, Entry>,
    made: UtcTime,
    /// The folders of what was set aside.
    aside: Vec<PathBuf>,
}

impl Held {
    /// The backup in a folder.
    ///
    /// # Errors
    /// The folder holds no backup, or one that this program cannot read.
    pub fn read(folder: &Path) -> anyhow::Result<Self> {
        ensure!(
            folder.join(MANIFEST).exists(),
            "there is no whole backup in {}: run `lutra-server backup` to its end",
            folder.display()
        );
        let manifest = Manifest::read(folder)?;
        let made = UtcTime::from_micros(manifest.made_us);
        let files = manifest.files.into_iter().map(|entry| (entry.path.clone(), entry)).collect();
        Ok(Self { folder: folder.to_owned(), files, made, aside: asides(folder)? })
    }

    /// When it was made.
    pub const fn made(&self) -> UtcTime {
        self.made
    }

    /// Why the backup lacks a file of a data folder, or anything in a folder there, byte for byte; `None` if it has all. A
    /// database is held if it did not change since it was copied. Unless it `reads`, only lengths are compared.
    ///
    /// # Errors
    /// Something cannot be read.
    pub fn lacks(&self, data: &Path, path: &Path, reads: bool) -> anyhow::Result<Option<String>> {
        let full = data.join(path);
        let mut files = Vec::new();
        if full.is_dir() {
            for entry in fs::read_dir(&full).with_context(|| full.display().to_string())? {
                files.push(path.join(entry?.file_name()));
            }
            files.sort();
        } else {
            files.push(path.to_owned());
        }
        for path in files {
            let why = self.lacks_file(data, &path, reads);
            if let Some(why) = why.with_context(|| format!("cannot compare {}", path.display()))? {
                return Ok(Some(format!("{} {why}", path.display())));
            }
        }
        Ok(None)
    }

    fn lacks_file(&self, data: &Path, path: &Path, reads: bool) -> std::io::Result<Option<String>> {
        // A person must decide which of the two is good.
        let forms = [Some(path.to_owned()), store::other_form(path)];
        let is_in = |aside: &&PathBuf| forms.iter().flatten().any(|path| aside.join(path).exists());
        if let Some(aside) = self.aside.iter().find(is_in) {
            return Ok(Some(format!("has another copy in {}, which a person must look at", aside.display())));
        }
        let Some(entry) = self.files.get(path) else {
            if let Some(entry) = store::other_form(path).and_then(|other| self.files.get(&other)) {
                return self.lacks_in_other_form(&data.join(path), path, entry, reads);
            }
            return Ok(Some(
                "is not in it; if a new backup lacks it too, it is not a file of Lutra's: move it away"
                    .to_owned(),
            ));
        };
        let (from, copy) = (data.join(path), self.folder.join(entry.at()));
        let Ok(there) = fs::metadata(&copy) else {
            return Ok(Some("is named in it and not there".to_owned()));
        };
        if there.len() < entry.bytes || reads && hash_prefix(&copy, entry.bytes)? != entry.sha256 {
            return Ok(Some("is damaged in it".to_owned()));
        }
        // A database is copied by its contents, not byte for byte.
        let same = if path.starts_with("history") {
            entry.source.is_some() && entry.source == Stamp::of(&from, SystemTime::now())?
        } else {
            fs::metadata(&from)?.len() == entry.bytes
                && (!reads || hash_prefix(&from, entry.bytes)? == entry.sha256)
        };
        Ok((!same).then(|| "differs from the copy in it".to_owned()))
    }

    /// The same of a day's file that the backup has in its other form, plain or compressed.
    fn lacks_in_other_form(
        &self,
        from: &Path,
        path: &Path,
        entry: &Entry,
        reads: bool,
    ) -> std::io::Result<Option<String>> {
        let copy = self.folder.join(entry.at());
        let Ok(there) = fs::metadata(&copy) else {
            return Ok(Some("is named in it and not there".to_owned()));
        };
        if there.len() < entry.bytes || reads && hash_prefix(&copy, entry.bytes)? != entry.sha256 {
            return Ok(Some("is damaged in it".to_owned()));
        }
        let same = if store::is_packed(path) {
            forms::plain_bytes(from)? == entry.bytes
                && (!reads || forms::begins_with(from, entry.bytes, &entry.sha256)?)
        } else {
            let bytes = fs::metadata(from)?.len();
            forms::plain_bytes(&copy)? == bytes
                && (!reads || forms::begins_with(&copy, bytes, &hash_prefix(from, bytes)?)?)
        };
        Ok((!same).then(|| "differs from the copy in it".to_owned()))
    }

    /// Whether it is on the disk of the data folder, where it protects against little.
    pub fn is_on_disk_of(&self, data: &Path) -> bool {
        on_one_disk(&self.folder, data)
    }
}

/// The folders below a backup in which copies that a person must look at are kept.
///
/// # Errors
/// They cannot be read.
pub fn asides(backup: &Path) -> anyhow::Result<Vec<PathBuf>> {
    let root = backup.join(ASIDE);
    let read = || -> std::io::Result<Vec<PathBuf>> {
        match fs::read_dir(&root) {
            Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(Vec::new()),
            entries => entries?.map(|entry| Ok(entry?.path())).collect(),
        }
    };
    let mut all = read().with_context(|| format!("cannot read {}", root.display()))?;
    all.sort();
    Ok(all)
}

/// Whether two folders are on one file system.
fn on_one_disk(one: &Path, other: &Path) -> bool {
    let disk = |path: &Path| fs::metadata(path).map(|about| about.dev()).ok();
    disk(one).is_some() && disk(one) == disk(other)
}
