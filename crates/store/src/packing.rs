//! Compressing days of the archive to which nothing is added.
//!
//! [`plan_packing`] says which; a [`Packing`] works on one of them, some bytes at a time, beside the writer and without it;
//! [`Store::adopt`] then gives the compressed files their names and removes the plain ones, which takes a few syncs. A kill
//! at any [`PackStep`] leaves the plain file or a compressed one that was read back against it, and mostly both. Nothing is
//! added to a day that has a compressed file, and the next run goes on with what it finds.

use crate::archive::{
    self, ARRIVALS, Coding, DAMAGED, DATA, DayKey, Disk, FRAME_BYTES, Lengths, PACKING, Packed, Packer,
    RealDisk, Turn, packed_name,
};
use crate::error::{Named as _, Result, StoreError};
use crate::layout::{ARCHIVE, free_bytes, reserved_bytes};
use crate::store::Store;
use std::fs::{self, File};
use std::io;
use std::path::{Path, PathBuf};
use units::UtcTime;

const DAY_US: i64 = 86_400_000_000;

/// A day that can be compressed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Packable {
    /// The day.
    pub key: DayKey,
    /// Bytes of its plain files.
    pub plain_bytes: u64,
}

/// What compressing a day did.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct PackedDay {
    /// The day.
    pub key: DayKey,
    /// Bytes of its plain files.
    pub plain_bytes: u64,
    /// Bytes of the compressed ones.
    pub packed_bytes: u64,
}

/// The steps of compressing a day, for tests that end a process at one of them.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PackStep {
    /// The format of the archive is raised.
    Noted,
    /// A file is being written.
    Begun,
    /// A file is written and synced.
    Written,
    /// A file is read back against the plain one.
    Checked,
    /// The packets' file has its name.
    DataNamed,
    /// The records' file has its name.
    ArrivalsNamed,
    /// Both names are synced.
    NamesSynced,
    /// The plain packets are removed.
    DataRemoved,
    /// The plain records are removed.
    ArrivalsRemoved,
}

impl PackStep {
    /// All, in their order.
    pub const ALL: [Self; 9] = [
        Self::Noted,
        Self::Begun,
        Self::Written,
        Self::Checked,
        Self::DataNamed,
        Self::ArrivalsNamed,
        Self::NamesSynced,
        Self::DataRemoved,
        Self::ArrivalsRemoved,
    ];
}

/// The days that can be compressed, the oldest first: those that ended `after_days` days ago or before, without the newest
/// day of the archive. A day that is dated wrongly does no harm: packets that still come for it go to a further part.
///
/// # Errors
/// When folders cannot be read.
pub fn plan_packing(data: &Path, after_days: u16, now: UtcTime) -> Result<Vec<Packable>> {
    let root = data.join(ARCHIVE);
    let days = archive::days(&root)?;
    let newest = days.iter().map(|key| key.day).max();
    let ended_before_us = now.micros().saturating_sub(i64::from(after_days) * DAY_US);
    let mut found = Vec::new();
    for key in days {
        let ended = key.start().is_some_and(|start| start.micros() + DAY_US <= ended_before_us);
        if !ended || Some(key.day) == newest || !key.may_close() {
            continue;
        }
        let folder = key.folder(&root);
        let size = |name: &str| fs::metadata(folder.join(name)).map_or(0, |file| file.len());
        let plain_bytes = size(DATA) + size(ARRIVALS);
        if plain_bytes > 0 {
            found.push(Packable { key, plain_bytes });
        }
    }
    found.sort_by_key(|one| (one.key.day, one.key.part, one.key.src));
    Ok(found)
}

/// The work of compressing one day. Dropping it leaves the day as it was.
pub struct Packing {
    root: PathBuf,
    key: DayKey,
    disk: Box<dyn Disk>,
    steps: Box<dyn FnMut(PackStep) + Send>,
    frame_bytes: u32,
    /// The plain files that are there, packets first.
    waiting: Vec<&'static str>,
    current: Option<Packer>,
    done: Vec<Packer>,
}

impl std::fmt::Debug for Packing {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        formatter
            .debug_struct("Packing")
            .field("key", &self.key)
            .field("current", &self.current)
            .finish_non_exhaustive()
    }
}

impl Packing {
    /// Begins. From here on programs that know no compressed days refuse the archive.
    ///
    /// # Errors
    /// The disk has no room for it beside what recording needs, or cannot be written.
    pub fn begin(data: &Path, day: &Packable) -> Result<Self> {
        Self::begin_watched(data, day, Box::new(|_| ()))
    }

    /// As [`Self::begin`]; `steps` is called after each step, for tests.
    ///
    /// # Errors
    /// As [`Self::begin`].
    pub fn begin_watched(
        data: &Path,
        day: &Packable,
        steps: Box<dyn FnMut(PackStep) + Send>,
    ) -> Result<Self> {
        Self::begin_on(data, day, steps, Box::new(RealDisk), FRAME_BYTES)
    }

    pub(crate) fn begin_on(
        data: &Path,
        day: &Packable,
        mut steps: Box<dyn FnMut(PackStep) + Send>,
        disk: Box<dyn Disk>,
        frame_bytes: u32,
    ) -> Result<Self> {
        let root = data.join(ARCHIVE);
        let (free, needed) = (free_bytes(&root)?, reserved_bytes(&root)?.saturating_add(day.plain_bytes));
        if free < needed {
            return Err(StoreError::NoRoom { what: format!("{ARCHIVE}/{}", day.key.name()), free, needed });
        }
        archive::format::note_packed(&root)?;
        steps(PackStep::Noted);
        let packing = root.join(PACKING);
        fs::create_dir_all(&packing).named(&packing)?;
        let folder = day.key.folder(&root);
        // Taken from the end.
        let waiting = [ARRIVALS, DATA].into_iter().filter(|name| folder.join(name).exists()).collect();
        Ok(Self { root, key: day.key, disk, steps, frame_bytes, waiting, current: None, done: Vec::new() })
    }

    /// The day.
    pub fn key(&self) -> DayKey {
        self.key
    }

    /// Works on about so many bytes of the plain files; whether there is more to do. Then [`Store::adopt`] ends it.
    ///
    /// # Errors
    /// A file cannot be read or written, the disk is full, or a compressed file is not what the plain one is: the plain one
    /// stays.
    pub fn work(&mut self, bytes: u64) -> Result<bool> {
        let outcome = self.turn(bytes);
        if outcome.is_err() {
            self.discard();
        }
        outcome
    }

    /// Removes the files that are half made, or made and have no place yet. One that cannot be removed is removed at the
    /// next start.
    fn discard(&mut self) {
        let folder = self.root.join(PACKING);
        self.current = None;
        self.done.clear();
        for name in [DATA, ARRIVALS] {
            fs::remove_file(folder.join(self.own_name(name))).ok();
        }
        // Unless something else lies there.
        fs::remove_dir(&folder).ok();
    }

    fn turn(&mut self, bytes: u64) -> Result<bool> {
        let Some(packer) = &mut self.current else {
            let Some(name) = self.waiting.pop() else { return Ok(false) };
            self.current = Some(self.begin_file(name)?);
            (self.steps)(PackStep::Begun);
            return Ok(true);
        };
        match packer.work(bytes, &mut *self.disk)? {
            Turn::More => {}
            Turn::Written => (self.steps)(PackStep::Written),
            Turn::Done => {
                (self.steps)(PackStep::Checked);
                self.done.extend(self.current.take());
            }
        }
        Ok(self.current.is_some() || !self.waiting.is_empty())
    }

    fn begin_file(&mut self, name: &str) -> Result<Packer> {
        let folder = self.key.folder(&self.root);
        let coding = if name == DATA { Coding::Bytes } else { Coding::Records };
        let (plain, packed) = (folder.join(name), folder.join(packed_name(name)));
        let part = self.root.join(PACKING).join(self.own_name(name));
        match Packed::read(&packed) {
            Err(error) if error.kind() == io::ErrorKind::NotFound => {}
            // A run before was ended between the names, or somebody put a file there.
            Ok(found) if found.has_digest() => {
                return Packer::check(&plain, &packed, found, &part, coding, self.frame_bytes);
            }
            Ok(found) => {
                let plain_bytes = fs::metadata(&plain).named(&plain)?.len();
                if found.plain_bytes() > plain_bytes {
                    let packed_bytes = found.plain_bytes();
                    return Err(StoreError::Differs { packed, packed_bytes, plain, plain_bytes });
                }
                self.set_aside(name, &packed)?;
            }
            Err(error) if error.kind() == io::ErrorKind::InvalidData => self.set_aside(name, &packed)?,
            Err(error) => return Err(error).named(&packed),
        }
        Packer::write(&plain, &part, coding, self.frame_bytes, &mut *self.disk)
    }
}

impl Packing {
    /// A name for the compressed form of a file, for which no other day has a use.
    fn own_name(&self, name: &str) -> String {
        format!("{}-{}", self.key.name().replace('/', "-"), packed_name(name))
    }

    /// Moves a compressed file that cannot be read, and lies beside a plain one, to a folder from which only a person
    /// removes it.
    fn set_aside(&self, name: &str, packed: &Path) -> Result<()> {
        let folder = self.root.join(DAMAGED);
        fs::create_dir_all(&folder).named(&folder)?;
        let own = self.own_name(name);
        let mut to = folder.join(&own);
        let mut number = 2;
        while to.exists() {
            to = folder.join(format!("{own}.{number}"));
            number += 1;
        }
        fs::rename(packed, &to).named(packed)?;
        sync(&folder)?;
        sync(&self.key.folder(&self.root))
    }
}

impl Drop for Packing {
    fn drop(&mut self) {
        self.discard();
    }
}

fn sync(folder: &Path) -> Result<()> {
    File::open(folder).and_then(|open| open.sync_all()).named(folder)
}

impl Store {
    /// Puts the compressed files of a day in the place of the plain ones. `None`, and nothing is changed, if something came
    /// for the day meanwhile or is about to: it can be compressed later. The work holds the plain files open: drop it where
    /// it may take a moment for the disk to free their room.
    ///
    /// # Errors
    /// The work is not done, or a name cannot be changed or synced. The plain file then stays, or the compressed one is
    /// complete in its place.
    pub fn adopt(&mut self, packing: &mut Packing) -> Result<Option<PackedDay>> {
        let Packing { root, key, steps, waiting, current, done, .. } = packing;
        let key = *key;
        if current.is_some() || !waiting.is_empty() || *root != self.folder().join(ARCHIVE) {
            return Err(StoreError::Query(format!("archive/{} is not compressed to its end", key.name())));
        }
        let folder = key.folder(root);
        let lengths = self.archive_mut().lengths(key);
        if !self.archive_mut().is_closed(key) {
            let of = |name: &str| {
                let path = folder.join(name);
                done.iter().find(|one| one.plain() == path).map_or(0, Packer::plain_bytes)
            };
            let packed = Lengths { data: of(DATA), arrivals: of(ARRIVALS) };
            // The writer counts what is durable; both files must have the length that was compressed.
            if packed != lengths || !self.archive_mut().close(key, lengths) {
                return Ok(None);
            }
        }
        for one in done.iter() {
            let is_data = one.plain().ends_with(DATA);
            let to = folder.join(packed_name(if is_data { DATA } else { ARRIVALS }));
            if one.part() != to {
                fs::rename(one.part(), &to).named(one.part())?;
            }
            steps(if is_data { PackStep::DataNamed } else { PackStep::ArrivalsNamed });
        }
        sync(&folder)?;
        sync(&root.join(PACKING))?;
        steps(PackStep::NamesSynced);
        for one in done.iter() {
            fs::remove_file(one.plain()).named(one.plain())?;
            let is_data = one.plain().ends_with(DATA);
            // Packets without their records must not be what a power cut leaves.
            sync(&folder)?;
            steps(if is_data { PackStep::DataRemoved } else { PackStep::ArrivalsRemoved });
        }
        let plain_bytes = done.iter().map(Packer::plain_bytes).sum();
        let packed_bytes = done.iter().filter_map(Packer::packed_bytes).sum();
        Ok(Some(PackedDay { key, plain_bytes, packed_bytes }))
    }
}
