//! The history: all messages, in tables that answer queries quickly.
//!
//! A file of SQLite per month of the samples' own time, and a catalogue. Everything here can be made again from
//! the archive; a row that is there already is left alone, so nothing is ever there twice.

mod catalogue;
pub(crate) mod chunk;
pub(crate) mod columns;
mod group;
pub(crate) mod look;
pub(crate) mod missing;
mod month;
mod month_key;
mod order;
pub(crate) mod pack;
pub(crate) mod rollup;
mod row;
pub(crate) mod rows;
pub(crate) mod schema;

pub(crate) use catalogue::{FILE as CATALOGUE, Progress, load_months, load_names, load_progress};
pub use group::GroupKey;
pub(crate) use imc::names::Names;
pub use month::Extent;
pub(crate) use month::{PACKED_VERSION, TRIAL_VERSION, VERSION};
pub use month_key::MonthKey;
pub use order::Order;
pub(crate) use schema::ESTIMATED_STATE;
pub use schema::Table;
pub use tables::{Column, ColumnKind};

use crate::archive::{DATA, DayKey, bytes, shortened};
use crate::aside;
use crate::error::{Named as _, Result};
use crate::fingerprint;
use crate::layout::ARCHIVE;
use crate::opening::keep_log;
use crate::packet::Arrived;
use crate::range::NO_TIME_US;
use catalogue::Catalogue;
use chunk::Place;
use imc::PacketView;
use imc::names::{self, Told};
use link::LinkSeq;
use look::Sound;
use month::{Due, Entry, Month};
use row::Sample;
use rusqlite::{Connection, OpenFlags};
use schema::Schema;
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::path::{Path, PathBuf};

/// A compressed month that has no name yet.
pub(crate) const PART: &str = "packing.sqlite";
/// Most months that stay open for writing.
const MAX_OPEN_MONTHS: usize = 6;
/// Samples that are rolled up at least, when any wait, by one commit.
const MIN_ROLL_UP: u64 = 20_000;

/// The history, open for writing.
#[derive(Debug)]
pub(crate) struct History {
    folder: PathBuf,
    schema: Schema,
    months: BTreeMap<MonthKey, (u64, Month)>,
    catalogue: Catalogue,
    commit: u64,
    is_new: bool,
    /// Databases that were written to since the progress was saved.
    unsynced: BTreeSet<PathBuf>,
}

impl History {
    /// Opens it. What is damaged goes aside, `distrusted` too, and its days count as not read; what that was, in
    /// words.
    ///
    /// # Errors
    /// When files cannot be read or written. A history of a later version is left as it is.
    pub(crate) fn open(folder: PathBuf, distrusted: Option<&Path>) -> Result<(Self, Vec<String>)> {
        fs::create_dir_all(&folder).named(&folder)?;
        remove_part(&folder)?;
        let mut found = look::look(&folder)?;
        look::refuse_newer(&folder, &found)?;
        for (name, sound) in &mut found {
            if *sound == Sound::Yes && distrusted == Some(&folder.join(name)) {
                *sound = Sound::No("it cannot be read everywhere".to_owned());
            }
        }
        let mut notes = Vec::new();
        if let Some((_, Sound::No(why))) = found.iter().find(|(name, _)| name == CATALOGUE) {
            notes.push(put_aside(&folder, CATALOGUE, why)?);
        }
        let mut history = Self {
            schema: Schema::new(),
            months: BTreeMap::new(),
            catalogue: Catalogue::open(&folder)?,
            is_new: !found.iter().any(|(name, sound)| name == CATALOGUE && *sound == Sound::Yes),
            folder,
            commit: 0,
            unsynced: BTreeSet::new(),
        };
        history.take_stock(&found, &mut notes)?;
        Ok((history, notes))
    }

    /// Holds the months that were found against those that must be there.
    fn take_stock(&mut self, found: &[(String, Sound)], notes: &mut Vec<String>) -> Result<()> {
        for (name, sound) in found {
            let Some(key) = MonthKey::from_file_name(name) else { continue };
            let why = match sound {
                Sound::No(why) => why,
                Sound::Empty if self.catalogue.has_month(key) => "it is empty",
                Sound::Empty | Sound::Newer => continue,
                Sound::Yes => {
                    // One whose compression was broken off at its end has none. What cannot be written now is written later.
                    keep_log(&self.folder.join(name)).ok();
                    self.catalogue.add_month(key);
                    continue;
                }
            };
            self.unread_month(key)?;
            notes.push(put_aside(&self.folder, name, why)?);
        }
        for key in self.catalogue.months() {
            let name = key.file_name();
            if !found.iter().any(|(there, _)| *there == name) {
                self.unread_month(key)?;
                notes.push(format!("history/{name} is gone: it is made again from the archive"));
            }
        }
        Ok(())
    }

    /// Has the days that may have samples in a month read again. A day that the archive lacks, or has less of than was read, is written
    /// down before it is forgotten that it was read.
    fn unread_month(&mut self, key: MonthKey) -> Result<()> {
        let root = self.folder.parent().unwrap_or(&self.folder).join(ARCHIVE);
        let (mut days, mut gone) = (Vec::new(), Vec::new());
        for (day, progress) in self.catalogue.days_of(key) {
            let there = bytes::plain_bytes(&day.folder(&root), DATA);
            if let Ok(is) = there.as_ref().map(|bytes| bytes.unwrap_or(0))
                && is < progress.lengths.data
            {
                shortened::add(&root, &day.name(), progress.lengths.data, is)?;
            }
            // One that cannot be read now is read when it can.
            let list = if matches!(there, Ok(None)) { &mut gone } else { &mut days };
            list.push(day);
        }
        self.catalogue.unread_month(key, &days, &gone)
    }

    /// Whether there was no catalogue, and so nothing that says what was read.
    pub(crate) fn is_new(&self) -> bool {
        self.is_new
    }

    /// Removes a month.
    pub(crate) fn forget_month(&mut self, key: MonthKey) -> Result<()> {
        self.months.remove(&key);
        self.catalogue.forget_month(key)
    }

    /// Every day of which something was read, and how far.
    pub(crate) fn all_progress(&self) -> Vec<(DayKey, Progress)> {
        self.catalogue.all_progress()
    }

    /// Adds the packets that are not there yet; how many those were, and what times they state.
    pub(crate) fn write<'a>(&mut self, packets: impl Iterator<Item = Arrived<'a>>) -> Result<(u64, Extent)> {
        self.commit += 1;
        let mut extent = Extent::NONE;
        let mut heard = false;
        let mut entries: Vec<Entry<'a>> = Vec::with_capacity(packets.size_hint().0);
        for packet in packets {
            let entry = entry(packet);
            extent.add(entry.sample.time_us);
            heard |= self.hear(&entry);
            entries.push(entry);
        }
        // A series' rows lie together, and so should the work on them. What came first stays first.
        entries.sort_by_key(|entry| (entry.month, entry.group, entry.sample.time_us));
        let mut rows = 0;
        for run in entries.chunk_by(|a, b| a.month == b.month) {
            let commit = self.commit;
            self.open_month(run[0].month)?;
            if let Some((_, month)) = self.months.get_mut(&run[0].month) {
                rows += month.write(&self.schema, run, commit)?;
                self.unsynced.insert(month.path().to_owned());
            }
        }
        if heard {
            self.catalogue.save(None)?;
        }
        Ok((rows, extent))
    }

    /// Rolls up complete windows: in proportion to what was written, so that it keeps pace.
    pub(crate) fn tend(&mut self, rows_written: u64) -> Result<()> {
        let mut budget = MIN_ROLL_UP.max(rows_written + rows_written / 4);
        let commit = self.commit;
        for (_, month) in self.months.values_mut() {
            let read = month.roll_up(&self.schema, Due::Quiet { commit }, budget)?;
            if read > 0 {
                self.unsynced.insert(month.path().to_owned());
            }
            budget = budget.saturating_sub(read);
            if budget == 0 {
                break;
            }
        }
        Ok(())
    }

    /// Counts a commit that brought nothing, so that windows of entities that fell silent have their turn.
    pub(crate) fn tick(&mut self) -> Result<()> {
        self.commit += 1;
        self.tend(0)
    }

    /// Rolls up everything in all months.
    pub(crate) fn roll_up_all(&mut self) -> Result<()> {
        for key in months(&self.folder)? {
            self.open_month(key)?;
            if let Some((_, month)) = self.months.get_mut(&key).filter(|(_, month)| month.stale() > 0) {
                month.roll_up(&self.schema, Due::All, u64::MAX)?;
                self.unsynced.insert(month.path().to_owned());
            }
        }
        Ok(())
    }

    /// Whether the very message is there already, and since when: its first arrival (µs).
    pub(crate) fn arrival_of(&mut self, view: &PacketView<'_>) -> Result<Option<i64>> {
        let entry = entry(Arrived { view: *view, received_us: 0 });
        if !self.months.contains_key(&entry.month) {
            let file = self.folder.join(entry.month.file_name());
            if !file.exists() {
                return Ok(None);
            }
            self.open_month(entry.month)?;
        }
        match self.months.get_mut(&entry.month) {
            Some((_, month)) => month.arrival_of(&self.schema, &entry),
            None => Ok(None),
        }
    }

    pub(crate) fn progress(&self, key: DayKey) -> Progress {
        self.catalogue.progress(key)
    }

    pub(crate) fn set_progress(&mut self, key: DayKey, progress: Progress) {
        self.catalogue.set_progress(key, progress);
    }

    /// A day is gone from the archive, or will be: see [`Self::forget_gone`].
    pub(crate) fn unread_gone(&mut self, key: DayKey) {
        self.catalogue.unread_gone(key);
    }

    /// Forgets what came on days of which nothing is left, neither in the archive nor in a month.
    pub(crate) fn forget_gone(&mut self) {
        self.catalogue.forget_gone();
    }

    /// The first of `count` times of arrival, from `now_us` on, that no import had before.
    pub(crate) fn reserve_arrivals(&mut self, now_us: i64, count: usize) -> Result<i64> {
        self.catalogue.reserve_arrivals(now_us, count)
    }

    pub(crate) fn streams(&self) -> Result<Vec<LinkSeq>> {
        self.catalogue.streams()
    }

    /// Makes sure that everything written is on the disk, then says so in the catalogue.
    pub(crate) fn save_progress(&mut self, streams: &[LinkSeq]) -> Result<()> {
        for path in std::mem::take(&mut self.unsynced) {
            let mut log = path.clone().into_os_string();
            log.push("-wal");
            let log = PathBuf::from(log);
            let synced = match File::open(&log) {
                Ok(file) => file.sync_data(),
                // Closing a month writes it back and takes its log away.
                Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(()),
                Err(error) => Err(error),
            };
            if synced.is_err() {
                self.unsynced.insert(path);
            }
            synced.named(&log)?;
        }
        self.catalogue.save(Some(streams))
    }

    /// Rolls up in a month until about `budget` samples were read; where that is everything, closes it. Whether it is.
    pub(crate) fn ready_month(&mut self, key: MonthKey, budget: u64) -> Result<bool> {
        self.open_month(key)?;
        let Some((_, month)) = self.months.get_mut(&key) else { return Ok(false) };
        if month.stale() > 0 {
            month.roll_up(&self.schema, Due::All, budget)?;
            self.unsynced.insert(month.path().to_owned());
        }
        let is_ready = month.stale() == 0;
        if is_ready {
            self.close_month(key);
        }
        Ok(is_ready)
    }

    /// Moves a damaged chunk of a month's file out of the way; the days that may have what it held count as not read. False where
    /// the file is no month.
    pub(crate) fn set_chunk_aside(&mut self, path: &Path, place: Place) -> Result<bool> {
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let Some(key) = MonthKey::from_file_name(&name) else { return Ok(false) };
        self.close_month(key);
        let flags = OpenFlags::SQLITE_OPEN_READ_WRITE | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let mut connection = Connection::open_with_flags(path, flags).named(path)?;
        chunk::set_aside(&mut connection, place).named(path)?;
        if matches!(place, Place::Rows(_)) {
            self.unread_month(key)?;
        }
        Ok(true)
    }

    /// Closes a month; it is opened again when needed.
    pub(crate) fn close_month(&mut self, key: MonthKey) {
        self.months.remove(&key);
    }

    pub(crate) fn close_months(&mut self) {
        self.months.clear();
    }

    fn open_month(&mut self, key: MonthKey) -> Result<()> {
        if !self.months.contains_key(&key) {
            if self.months.len() >= MAX_OPEN_MONTHS
                && let Some(oldest) =
                    self.months.iter().min_by_key(|(_, (used, _))| *used).map(|(key, _)| *key)
            {
                self.months.remove(&oldest);
            }
            self.months.insert(key, (0, Month::open(&self.folder, key)?));
            self.catalogue.add_month(key);
        }
        if let Some((used, _)) = self.months.get_mut(&key) {
            *used = self.commit;
        }
        Ok(())
    }

    /// Hears names in what passes; whether one is new.
    fn hear(&mut self, entry: &Entry<'_>) -> bool {
        let (view, time_us) = (&entry.sample.view, entry.sample.time_us);
        let mut new = false;
        for told in names::told(view) {
            new |= match told {
                Told::System(name) => self.catalogue.hear_system(view.src(), time_us, &name),
                Told::Entity(entity, label) => {
                    self.catalogue.hear_entity(view.src(), entity, time_us, &label)
                }
            };
        }
        new
    }
}

/// Moves a damaged file away and returns the report for people.
fn put_aside(folder: &Path, name: &str, why: &str) -> Result<String> {
    let data = folder.parent().unwrap_or(folder);
    let kept = aside::put(data, &folder.join(name))?;
    let kept = kept.strip_prefix(data).unwrap_or(&kept).display();
    Ok(format!("history/{name} is damaged ({why}): it is kept as {kept} and is made again from the archive"))
}

/// What tells a packet's row from all others of its message, system and entity: when it was said (µs since 1970-01-01 UTC,
/// [`NO_TIME_US`] where its stamp is no time) and the fingerprint of its payload.
pub fn row_key(view: &PacketView<'_>) -> (i64, i64) {
    let time_us = view.header().time().map_or(NO_TIME_US, units::UtcTime::micros);
    (time_us, fingerprint::of_payload(view.payload()))
}

fn entry(packet: Arrived<'_>) -> Entry<'_> {
    let view = packet.view;
    let (time_us, hash) = row_key(&view);
    Entry {
        month: MonthKey::of(time_us),
        group: GroupKey { id: view.id(), src: view.src().0, src_ent: view.src_ent() },
        sample: Sample { view, received_us: packet.received_us, time_us, hash },
    }
}

/// Removes a compressed month that was not finished.
pub(crate) fn remove_part(folder: &Path) -> Result<()> {
    for end in ["", "-wal", "-shm", "-journal"] {
        let part = folder.join(format!("{PART}{end}"));
        match fs::remove_file(&part) {
            Err(error) if error.kind() != std::io::ErrorKind::NotFound => return Err(error).named(&part),
            _ => {}
        }
    }
    Ok(())
}

/// The latest version of the layout of a file that is known.
pub(crate) fn latest_version(file: &Path) -> i64 {
    if file.ends_with(CATALOGUE) { VERSION } else { PACKED_VERSION }
}

/// The months that there are, the undated first.
pub(crate) fn months(folder: &Path) -> Result<Vec<MonthKey>> {
    let entries = match fs::read_dir(folder) {
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => return Ok(Vec::new()),
        other => other.named(folder)?,
    };
    let mut found = Vec::new();
    for entry in entries {
        let name = entry.named(folder)?.file_name();
        found.extend(MonthKey::from_file_name(&name.to_string_lossy()));
    }
    found.sort();
    Ok(found)
}
