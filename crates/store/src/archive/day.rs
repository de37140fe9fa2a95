//! One day's files, growing at their ends only.

use super::arrival::{Arrival, Record};
use super::disk::Disk;
use super::layout::{self, ARRIVALS, DATA, DayKey};
use crate::error::{Named as _, Result};
use std::fs::{File, OpenOptions};
use std::path::{Path, PathBuf};

/// The lengths up to which both files are consistent.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) struct Lengths {
    pub(crate) data: u64,
    pub(crate) arrivals: u64,
}

/// Packets that wait for the disk, or were just put there.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Pending {
    /// The packets, back to back.
    pub(crate) data: Vec<u8>,
    /// Their records.
    pub(crate) arrivals: Vec<u8>,
    /// How many packets.
    pub(crate) packets: u64,
}

impl Pending {
    pub(crate) fn clear(&mut self) {
        self.data.clear();
        self.arrivals.clear();
        self.packets = 0;
    }
}

/// A day that is being written to.
#[derive(Debug)]
pub(crate) struct Day {
    pub(crate) key: DayKey,
    pub(crate) lengths: Lengths,
    pub(crate) pending: Pending,
    files: Option<Files>,
    /// Whether a write failed, so that the files may continue beyond `lengths`.
    torn: bool,
}

#[derive(Debug)]
struct Files {
    folder: PathBuf,
    data: File,
    arrivals: File,
}

impl Day {
    pub(crate) fn new(key: DayKey, lengths: Lengths) -> Self {
        Self { key, lengths, pending: Pending::default(), files: None, torn: false }
    }

    /// Puts a packet behind those that wait.
    pub(crate) fn push(&mut self, packet: &[u8], arrival: Arrival, jump: Option<Record>) {
        let offset = self.lengths.data + self.pending.data.len() as u64;
        self.pending.data.extend_from_slice(packet);
        if let Some(Record::Jump { after, .. }) = jump {
            Record::Jump { offset, after }.write(&mut self.pending.arrivals);
        }
        Record::Packet(Arrival { offset, ..arrival }).write(&mut self.pending.arrivals);
        self.pending.packets += 1;
    }

    /// Appends what waits to both files, without waiting for the disk.
    pub(crate) fn write(&mut self, archive: &Path, disk: &mut dyn Disk) -> Result<()> {
        if self.torn {
            self.cut_back()?;
        }
        let key = self.key;
        let files = match &mut self.files {
            Some(files) => files,
            none => none.insert(Files::open(archive, key)?),
        };
        self.torn = true;
        // Records first: what a kill leaves half written then has its number, or is cut off and sent again. A packet that is
        // whole and has no record would be kept, and be there twice once its vessel sends it again.
        disk.append(&files.arrivals, &self.pending.arrivals).named(&files.folder.join(ARRIVALS))?;
        disk.append(&files.data, &self.pending.data).named(&files.folder.join(DATA))
    }

    /// Waits for the disk.
    pub(crate) fn sync(&mut self, disk: &mut dyn Disk) -> Result<()> {
        if let Some(files) = &self.files {
            disk.sync(&files.data).named(&files.folder.join(DATA))?;
            disk.sync(&files.arrivals).named(&files.folder.join(ARRIVALS))?;
        }
        Ok(())
    }

    /// Counts what waited as written, and gives it out in exchange for empty room.
    pub(crate) fn settle(&mut self, room: Pending) -> Pending {
        self.lengths.data += self.pending.data.len() as u64;
        self.lengths.arrivals += self.pending.arrivals.len() as u64;
        self.torn = false;
        std::mem::replace(&mut self.pending, room)
    }

    /// Takes back what a failed write left behind the end.
    pub(crate) fn cut_back(&mut self) -> Result<()> {
        if let Some(files) = &self.files {
            files.data.set_len(self.lengths.data).named(&files.folder.join(DATA))?;
            files.arrivals.set_len(self.lengths.arrivals).named(&files.folder.join(ARRIVALS))?;
        }
        self.torn = false;
        Ok(())
    }

    /// Closes the files; the next write opens them again. False if a failed write left something behind the end.
    pub(crate) fn close(&mut self) -> bool {
        if !self.torn {
            self.files = None;
        }
        !self.torn
    }

    pub(crate) fn is_open(&self) -> bool {
        self.files.is_some()
    }
}

impl Files {
    fn open(archive: &Path, key: DayKey) -> Result<Self> {
        let folder = key.folder(archive);
        let folder = if folder.join(ARRIVALS).exists() { folder } else { layout::make_day(archive, key)? };
        let open = |name: &str| {
            let path = folder.join(name);
            OpenOptions::new().append(true).create(true).open(&path).named(&path)
        };
        let (data, arrivals) = (open(DATA)?, open(ARRIVALS)?);
        // A file whose name the disk forgets is lost, however well its bytes were synced.
        File::open(&folder).and_then(|folder| folder.sync_all()).named(&folder)?;
        Ok(Self { folder, data, arrivals })
    }
}
