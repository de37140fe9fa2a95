//! Writing into a backup so that the earlier one in the same folder can be restored at every moment.
//!
//! Files of the earlier manifest are never replaced and never shortened. A file that changed goes to the other of its two
//! places ([`Entry::at`]), `history/x` or `alternate/history/x`; to a file of the archive, which only grows, the new bytes
//! are appended, and the earlier manifest still has its own number of bytes. The manifest is written last; then files that
//! it does not name are removed. A kill at any moment leaves one manifest or the other, with all its files.
//!
//! A day that the server has compressed since is taken in that form, and its plain copy goes, once the compressed one was
//! unpacked in the backup and holds all that it held (`forms`).
//!
//! A file of the archive is append-only. If the server's file differs in what was copied before (a flipped bit, or
//! truncated by a crash), the earlier copy may be the only good one: it is set aside, as is a damaged copy of a file that
//! the server no longer has. Only a person removes these.

use super::forms;
use super::manifest::{ALTERNATE, Entry, Manifest, Stamp, hash_prefix};
use anyhow::{Context as _, ensure};
use sha2::{Digest as _, Sha256};
use std::collections::{BTreeMap, BTreeSet};
use std::ffi::OsStr;
use std::fs::{self, File, OpenOptions};
use std::io::{self, Read as _, Seek as _, SeekFrom, Write as _};
use std::os::unix::fs::{MetadataExt as _, PermissionsExt as _};
use std::path::{Path, PathBuf};

/// "Input/output error", as the system numbers it.
const EIO: i32 = 5;

/// Result of a backup.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct BackedUp {
    /// Files that are rewritten as a whole.
    pub copied: u64,
    /// Files of the archive to which new bytes were appended.
    pub grown: u64,
    /// Files of the archive that are links to the server's own.
    pub linked: u64,
    /// Files that were already up to date.
    pub kept: u64,
    /// Files of the archive that the earlier backup had in their other form, plain or compressed, and that are no longer
    /// kept in it: the new one holds all that they held.
    pub replaced: u64,
    /// Bytes that were written.
    pub bytes: u64,
    /// Files of the earlier backup that were damaged, and are copied again.
    pub damaged: Vec<PathBuf>,
    /// Copies that a person must look at.
    pub aside: Vec<Aside>,
    /// Files that only the earlier backup had, and that are missing there.
    pub lost: Vec<PathBuf>,
}

/// A copy that is kept apart.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Aside {
    /// Below the data folder.
    pub path: PathBuf,
    /// Its path below the backup.
    pub at: PathBuf,
    /// True if the copy is intact and the server's file differs. Otherwise the copy is damaged, and the server has no such
    /// file or another one.
    pub good: bool,
}

/// Writes a backup.
pub(super) struct Keeping<'a> {
    data: &'a Path,
    to: &'a Path,
    known: BTreeMap<PathBuf, Entry>,
    /// Whether what is kept is read and compared.
    verifies: bool,
    /// Folder for copies that a person must look at.
    aside: PathBuf,
    began: std::time::SystemTime,
    entries: BTreeMap<PathBuf, Entry>,
    pub(super) done: BackedUp,
}

impl<'a> Keeping<'a> {
    /// `aside` is below `to` and does not exist yet.
    pub(super) fn new(
        data: &'a Path,
        to: &'a Path,
        earlier: &Manifest,
        verifies: bool,
        aside: PathBuf,
    ) -> Self {
        let known = earlier.files.iter().map(|entry| (entry.path.clone(), entry.clone())).collect();
        let (began, entries, done) = (std::time::SystemTime::now(), BTreeMap::new(), BackedUp::default());
        Self { data, to, known, verifies, aside, began, entries, done }
    }

    /// Removes the partial files that an interrupted backup left beside files of the earlier manifest. Nothing else is
    /// touched: the folder may hold other files.
    pub(super) fn sweep_parts(&self) {
        for path in self.known.keys() {
            remove_part(&self.to.join(path));
            remove_part(&self.to.join(ALTERNATE).join(path));
        }
    }

    /// Backs up a file that is rewritten as a whole when it changes. `copy` writes a consistent state of it to a free
    /// place; its source is `from`.
    pub(super) fn take(
        &mut self,
        path: &Path,
        from: &Path,
        copy: impl FnOnce(&Path) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        // Read before copying: a change during the copy is then copied the next time.
        let stamp = Stamp::of(from, self.began).with_context(|| from.display().to_string())?;
        if let Some(entry) = self.known.get(path).cloned()
            && stamp.is_some()
            && entry.source == stamp
            && self.is_whole(&entry)?
        {
            self.keep(entry);
            return Ok(());
        }
        self.write(path, stamp, copy)
    }

    /// Backs up a file of the archive: only the bytes added since the earlier backup are copied.
    pub(super) fn grow(&mut self, path: &Path, grows_now: bool) -> anyhow::Result<()> {
        let from = self.data.join(path);
        let named = || from.display().to_string();
        let length = fs::metadata(&from).with_context(named)?.len();
        let stamp = Stamp::of(&from, self.began).with_context(named)?;
        let Some(entry) = self.known.get(path).cloned() else { return self.begin(path, stamp, grows_now) };
        let unchanged = stamp.is_some() && entry.source == stamp;
        // A start after a crash may have truncated bytes that an earlier backup still copied.
        let same = unchanged
            || length >= entry.bytes && hash_prefix(&from, entry.bytes).with_context(named)? == entry.sha256;
        if !same {
            let good = self.looks_whole(&entry)?;
            self.set_aside(&entry, good)?;
            return self.begin(path, stamp, false);
        }
        if !self.is_whole(&entry)? {
            return self.begin(path, stamp, false);
        }
        if length == entry.bytes {
            self.keep(Entry { source: stamp, ..entry });
            return Ok(());
        }
        let at = self.to.join(entry.at());
        let grown = append(&from, &at, &entry, length)
            .with_context(|| format!("cannot copy {} to {}", from.display(), at.display()))?;
        let Some(grown) = grown else {
            self.done.damaged.push(entry.path);
            return self.begin(path, stamp, false);
        };
        self.done.grown += 1;
        self.done.bytes += length - entry.bytes;
        self.keep_as(Entry { source: stamp, bytes: length, sha256: grown, ..entry });
        Ok(())
    }

    /// A file of the archive that is not in the backup yet: a hard link if possible and the file grows no more, else a
    /// copy.
    fn begin(&mut self, path: &Path, stamp: Option<Stamp>, grows_now: bool) -> anyhow::Result<()> {
        let from = self.data.join(path);
        let is_new = !self.known.contains_key(path);
        if is_new && !grows_now {
            let to = self.to.join(path);
            make_folder_of(&to)?;
            fs::remove_file(&to).ok();
            if fs::hard_link(&from, &to).is_ok() {
                if store::is_packed(path) {
                    // The plain copy may be removed for it.
                    File::open(to.parent().unwrap_or(&to))
                        .and_then(|folder| folder.sync_all())
                        .with_context(|| to.display().to_string())?;
                }
                self.done.linked += 1;
                let entry = self.entry(path, None, stamp)?;
                self.keep_as(entry);
                return Ok(());
            }
        }
        self.write(path, stamp, |to| {
            fs::copy(&from, to).with_context(|| format!("cannot copy {}", from.display())).map(drop)
        })
    }

    /// Rewrites a file at the place that the earlier backup does not use.
    fn write(
        &mut self,
        path: &Path,
        stamp: Option<Stamp>,
        copy: impl FnOnce(&Path) -> anyhow::Result<()>,
    ) -> anyhow::Result<()> {
        let is_taken = self.known.get(path).is_some_and(|entry| entry.at.is_none());
        let at = is_taken.then(|| Path::new(ALTERNATE).join(path));
        let to = self.to.join(at.as_deref().unwrap_or(path));
        make_folder_of(&to)?;
        let part = remove_part(&to);
        copy(&part).inspect_err(|_| drop(remove_part(&to)))?;
        let place = || -> io::Result<()> {
            File::open(&part)?.sync_all()?;
            fs::rename(&part, &to)?;
            to.parent().map_or(Ok(()), |folder| File::open(folder)?.sync_all())
        };
        place().with_context(|| format!("cannot write {}", to.display()))?;
        let entry = self.entry(path, at, stamp)?;
        self.done.copied += 1;
        self.done.bytes += entry.bytes;
        self.keep_as(entry);
        Ok(())
    }

    /// The manifest entry of a file in the backup.
    fn entry(&self, path: &Path, at: Option<PathBuf>, source: Option<Stamp>) -> anyhow::Result<Entry> {
        let full = self.to.join(at.as_deref().unwrap_or(path));
        let read = || -> io::Result<Entry> {
            let about = fs::metadata(&full)?;
            let (bytes, mode) = (about.len(), about.permissions().mode() & 0o7777);
            // A linked file may grow while it is read; later bytes are not part of this backup.
            let sha256 = hash_prefix(&full, bytes)?;
            Ok(Entry { path: path.to_owned(), at, bytes, sha256, mode, source })
        };
        read().with_context(|| format!("cannot read {}", full.display()))
    }

    fn keep(&mut self, entry: Entry) {
        self.done.kept += 1;
        self.keep_as(entry);
    }

    fn keep_as(&mut self, entry: Entry) {
        self.entries.insert(entry.path.clone(), entry);
    }

    /// Whether the file is as the earlier backup wrote it; damaged ones are noted.
    fn is_whole(&mut self, entry: &Entry) -> anyhow::Result<bool> {
        let whole = self.looks_whole(entry)?;
        if !whole {
            self.done.damaged.push(entry.path.clone());
        }
        Ok(whole)
    }

    fn looks_whole(&self, entry: &Entry) -> anyhow::Result<bool> {
        let path = self.to.join(entry.at());
        let look = || -> io::Result<bool> {
            let length = match fs::metadata(&path) {
                Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(false),
                about => about?.len(),
            };
            let fits = length == entry.bytes || length > entry.bytes && entry.path.starts_with("archive");
            Ok(fits && (!self.verifies || hash_prefix(&path, entry.bytes)? == entry.sha256))
        };
        // An unreadable sector counts as damage: it must not make all later backups fail.
        look()
            .or_else(|error| if error.raw_os_error() == Some(EIO) { Ok(false) } else { Err(error) })
            .with_context(|| format!("cannot read {}", path.display()))
    }

    /// Keeps files of the earlier backup that the server no longer has, such as removed days; not those from outside of the
    /// data folder, and not the access of vessels that was ended, lest a restore gives it back.
    pub(super) fn carry_over(&mut self, outside: &str) -> anyhow::Result<()> {
        let gone: Vec<Entry> = self
            .known
            .values()
            .filter(|entry| !self.entries.contains_key(&entry.path) && !entry.path.starts_with(outside))
            .filter(|entry| !self.is_ended_access(&entry.path))
            .cloned()
            .collect();
        for entry in gone {
            let whole = self.looks_whole(&entry)?;
            match self.other_form_holds(&entry)? {
                // Its place is swept once the new manifest is written.
                Some(true) => self.done.replaced += 1,
                // One day in two forms that differ: a person must say which is good.
                Some(false) => self.set_aside(&entry, whole)?,
                None if whole => self.keep(entry),
                None => self.set_aside(&entry, false)?,
            }
        }
        Ok(())
    }

    /// Whether a file that the server no longer has let a vessel in, while the rest of the fleet's folder is there: tokens and keys
    /// of vessels, and what root's files are copied from. The server's own keys let no vessel in.
    fn is_ended_access(&self, path: &Path) -> bool {
        let of_vessel = ["token", "vpn", "ovpn"].map(OsStr::new);
        let gives_access = path.starts_with("vpn")
            || path.starts_with("fleet") && path.extension().is_some_and(|end| of_vessel.contains(&end));
        gives_access && self.entries.contains_key(Path::new("fleet/fleet.toml"))
    }

    /// Whether the new backup has a day's file in its other form, compressed or plain, and all that an earlier entry held is
    /// in it; `None` where it has no such file.
    fn other_form_holds(&self, entry: &Entry) -> anyhow::Result<Option<bool>> {
        let Some(other) = store::other_form(&entry.path).and_then(|path| self.entries.get(&path)) else {
            return Ok(None);
        };
        let (was, is) = (self.to.join(entry.at()), self.to.join(other.at()));
        let holds = if store::is_packed(&other.path) {
            forms::begins_with(&is, entry.bytes, &entry.sha256)
        } else {
            forms::is_begin_of(&was, &is, other.bytes)
        };
        match holds {
            Err(error) if [io::ErrorKind::InvalidData, io::ErrorKind::NotFound].contains(&error.kind()) => {
                Ok(Some(false))
            }
            other => other
                .map(Some)
                .with_context(|| format!("cannot compare {} with {}", was.display(), is.display())),
        }
    }

    /// Gives a copy another name, under which it is neither replaced nor removed.
    fn set_aside(&mut self, entry: &Entry, good: bool) -> anyhow::Result<()> {
        let at = self.aside.join(&entry.path);
        let (from, to) = (self.to.join(entry.at()), self.to.join(&at));
        if !from.exists() {
            let lost = !self.data.join(&entry.path).exists();
            if lost { &mut self.done.lost } else { &mut self.done.damaged }.push(entry.path.clone());
            return Ok(());
        }
        make_folder_of(&to)?;
        fs::hard_link(&from, &to)
            .or_else(|_| fs::copy(&from, &to).and_then(|_| File::open(&to)?.sync_all()))
            .and_then(|()| File::open(to.parent().unwrap_or(&to))?.sync_all())
            .with_context(|| format!("cannot keep {} as {}", from.display(), to.display()))?;
        self.done.aside.push(Aside { path: entry.path.clone(), at, good });
        Ok(())
    }

    /// The files of the new manifest.
    pub(super) fn files(&self) -> Vec<Entry> {
        self.entries.values().cloned().collect()
    }

    /// Removes files that the new manifest, which must be on the disk, does not name.
    pub(super) fn sweep(&self) -> anyhow::Result<()> {
        let named: BTreeSet<&Path> = self.entries.values().map(Entry::at).collect();
        for at in self.known.values().map(Entry::at).filter(|at| !named.contains(at)) {
            match fs::remove_file(self.to.join(at)) {
                Err(error) if error.kind() != io::ErrorKind::NotFound => {
                    return Err(error)
                        .with_context(|| format!("cannot remove {}", self.to.join(at).display()));
                }
                _ => {}
            }
        }
        self.sweep_other_forms(&named)
    }

    /// Removes the copies of days in a form that is not named, which a kill in an earlier sweep left: only those that the
    /// named form is shown to hold. Others are left alone.
    fn sweep_other_forms(&self, named: &BTreeSet<&Path>) -> anyhow::Result<()> {
        for entry in self.entries.values() {
            let Some(other) = store::other_form(&entry.path) else { continue };
            for at in [other.clone(), Path::new(ALTERNATE).join(&other)] {
                let left = self.to.join(&at);
                if named.contains(at.as_path()) || !left.is_file() {
                    continue;
                }
                let is = self.to.join(entry.at());
                let holds = if store::is_packed(&entry.path) {
                    fs::metadata(&left)
                        .and_then(|about| Ok((about.len(), hash_prefix(&left, about.len())?)))
                        .and_then(|(bytes, sha256)| forms::begins_with(&is, bytes, &sha256))
                } else {
                    forms::is_begin_of(&left, &is, entry.bytes)
                };
                if holds.unwrap_or(false) {
                    fs::remove_file(&left).with_context(|| format!("cannot remove {}", left.display()))?;
                }
            }
        }
        Ok(())
    }
}

/// Appends the source's bytes after those of the entry, up to `length`, to the copy; returns the digest of all of it.
/// `None` if the copy does not match the entry: a digest over all of it would make the damage valid.
fn append(from: &Path, to: &Path, entry: &Entry, length: u64) -> io::Result<Option<String>> {
    let (mut source, there) = (File::open(from)?, fs::metadata(to)?);
    let is_link = (there.dev(), there.ino()) == {
        let about = source.metadata()?;
        (about.dev(), about.ino())
    };
    let mut hash = Sha256::new();
    let mut copy = OpenOptions::new().read(true).write(!is_link).open(to)?;
    io::copy(&mut (&mut copy).take(entry.bytes), &mut hash)?;
    if hex::encode(hash.clone().finalize()) != entry.sha256 {
        return Ok(None);
    }
    if is_link {
        io::copy(&mut copy.take(length - entry.bytes), &mut hash)?;
        return Ok(Some(hex::encode(hash.finalize())));
    }
    // Bytes beyond that are from an interrupted backup.
    copy.set_len(entry.bytes)?;
    copy.seek(SeekFrom::Start(entry.bytes))?;
    source.seek(SeekFrom::Start(entry.bytes))?;
    let (mut rest, mut buffer) = (source.take(length - entry.bytes), vec![0; 256 << 10]);
    loop {
        match rest.read(&mut buffer)? {
            0 => break,
            read => {
                hash.update(&buffer[..read]);
                copy.write_all(&buffer[..read])?;
            }
        }
    }
    if rest.limit() > 0 {
        return Err(io::Error::new(io::ErrorKind::UnexpectedEof, "it became shorter while it was copied"));
    }
    copy.sync_all()?;
    Ok(Some(hex::encode(hash.finalize())))
}

/// Removes the partial file of an interrupted copy; returns the path for the next one.
fn remove_part(to: &Path) -> PathBuf {
    let part = PathBuf::from(format!("{}.part", to.display()));
    for end in ["", "-wal", "-shm", "-journal"] {
        fs::remove_file(format!("{}{end}", part.display())).ok();
    }
    part
}

fn make_folder_of(path: &Path) -> anyhow::Result<()> {
    let folder = path.parent().unwrap_or(path);
    fs::create_dir_all(folder).with_context(|| format!("cannot make {}", folder.display()))
}

/// Holds a backup's folder, so that two backups do not write into it at once.
pub(super) fn lock(to: &Path) -> anyhow::Result<File> {
    let path = to.join("backup.lock");
    let file = OpenOptions::new().create(true).truncate(false).write(true).open(&path);
    let file = file.with_context(|| format!("cannot write {}", path.display()))?;
    ensure!(
        file.try_lock().is_ok(),
        "another backup writes into {}: wait until it is done, or choose another folder",
        to.display()
    );
    Ok(file)
}
