//! The archive: every packet as it came, appended to a log per system and UTC day of arrival.
//!
//! It is the primary data, from which all else can be made again. A day's folder holds `Data.lsf`, which Neptus
//! MRA opens, the definitions it wants beside it, and `Arrivals.idx` with how and when each packet came. Files
//! only ever grow at their ends, and those of past days never change, so that copies and hard links of them
//! are a backup. Some days later both are compressed, once ([`packed`]); every place in the archive still counts the bytes
//! of the plain files, and [`bytes`] reads either form by it.

mod arrival;
pub(crate) mod bytes;
mod day;
mod disk;
pub(crate) mod format;
mod layout;
mod packed;
mod recover;
mod scan;
pub(crate) mod shortened;
mod streams;

pub use arrival::Arrival;
pub(crate) use arrival::{ARRIVAL_BYTES, Record};
pub(crate) use day::{Lengths, Pending};
pub(crate) use disk::{Disk, RealDisk};
pub use layout::DayKey;
pub(crate) use layout::{
    ARRIVALS, DAMAGED, DATA, DEFINITIONS, PACKING, TRIMMED, days, is_trimmed, mark_trimmed, packed_name,
    sweep_packing,
};
pub use packed::Packed;
pub(crate) use packed::{Coding, FRAME_BYTES, Packer, Turn};
pub(crate) use recover::mend;
pub(crate) use scan::Records;
pub use scan::{Archived, DayReader};
pub(crate) use streams::{Recovered, Streams};

use crate::error::{Result, StoreError};
use crate::packet::Arrived;
use day::Day;
use imc::PacketView;
use link::{LinkSeq, Transport};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use units::UtcTime;

/// Most bytes of packets that wait for a commit.
pub(crate) const MAX_PENDING_BYTES: usize = 64 << 20;
/// Most days whose files stay open between commits.
const MAX_OPEN_DAYS: usize = 128;

/// The data that a commit put on disk for one day.
#[derive(Debug)]
pub(crate) struct Written {
    pub(crate) key: DayKey,
    /// The files' ends after it.
    pub(crate) lengths: Lengths,
    /// The packets and their records.
    pub(crate) batch: Pending,
}

/// The packets of a commit in order of arrival.
pub(crate) fn packets_of(written: &Written) -> impl Iterator<Item = Arrived<'_>> {
    let batch = &written.batch;
    let base = written.lengths.data - batch.data.len() as u64;
    let (records, _) = batch.arrivals.as_chunks::<{ arrival::ARRIVAL_BYTES }>();
    records.iter().filter_map(move |record| {
        let Some(arrival::Record::Packet(arrival)) = arrival::Record::read(record) else { return None };
        let bytes = batch.data.get((arrival.offset - base) as usize..)?;
        let view = PacketView::unchecked(bytes).ok()?;
        Some(Arrived { view, received_us: arrival.received.micros() })
    })
}

/// The archive, open for appending.
#[derive(Debug)]
pub(crate) struct Archive {
    root: PathBuf,
    disk: Box<dyn Disk>,
    days: BTreeMap<DayKey, Day>,
    /// Days that are compressed, or about to be: what still comes for them goes to a further part.
    closed: BTreeSet<DayKey>,
    pub(crate) streams: Streams,
    waiting_bytes: usize,
    spare: Vec<Pending>,
}

impl Archive {
    pub(crate) fn new(root: PathBuf, disk: Box<dyn Disk>) -> Self {
        Self {
            root,
            disk,
            days: BTreeMap::new(),
            closed: BTreeSet::new(),
            streams: Streams::default(),
            waiting_bytes: 0,
            spare: Vec::new(),
        }
    }

    pub(crate) fn root(&self) -> &Path {
        &self.root
    }

    /// Sets the lengths of a day's files, so that appending continues there.
    pub(crate) fn know(&mut self, key: DayKey, lengths: Lengths) {
        self.days.insert(key, Day::new(key, lengths));
    }

    /// Nothing is added to a day any more; false, and nothing is changed, if it has not this length or something waits
    /// for it. Its files are closed.
    pub(crate) fn close(&mut self, key: DayKey, lengths: Lengths) -> bool {
        let Some(day) = self.days.get_mut(&key) else { return false };
        if day.lengths != lengths || day.pending.packets > 0 || !day.close() {
            return false;
        }
        self.closed.insert(key);
        true
    }

    /// Whether nothing is added to a day any more.
    pub(crate) fn is_closed(&self, key: DayKey) -> bool {
        self.closed.contains(&key)
    }

    /// Forgets a day whose files were removed: what still comes for it begins new ones.
    pub(crate) fn forget(&mut self, key: DayKey) {
        self.days.remove(&key);
        self.closed.remove(&key);
    }

    /// The part of a day that packets which come now go to.
    fn open_part(&self, mut key: DayKey) -> DayKey {
        while self.closed.contains(&key) && key.may_close() {
            key = key.next_part();
        }
        key
    }

    /// Puts a packet behind those that wait; false when its number was accepted before.
    pub(crate) fn append(
        &mut self,
        view: &PacketView<'_>,
        received: UtcTime,
        transport: Transport,
        link: Option<LinkSeq>,
    ) -> Result<bool> {
        if self.is_full_for(view) {
            return Err(StoreError::Full { waiting: self.waiting_bytes });
        }
        let place = match link.map(|link| self.streams.accept(link)) {
            Some(None) => return Ok(false),
            Some(place) => place,
            None => None,
        };
        let key = self.open_part(DayKey::of(view.src(), received));
        let day = self.days.entry(key).or_insert_with(|| Day::new(key, Lengths::default()));
        let arrival =
            Arrival { offset: 0, received, transport, link, first: place.is_some_and(|place| place.first) };
        let jump =
            place.and_then(|place| place.after).map(|after| arrival::Record::Jump { offset: 0, after });
        day.push(view.bytes(), arrival, jump);
        self.waiting_bytes += view.bytes().len();
        Ok(true)
    }

    /// Whether one more packet would be too much.
    pub(crate) fn is_full_for(&self, view: &PacketView<'_>) -> bool {
        self.waiting_bytes + view.bytes().len() > MAX_PENDING_BYTES
    }

    /// How long a day's files are, as far as they are surely on disk.
    pub(crate) fn lengths(&self, key: DayKey) -> Lengths {
        self.days.get(&key).map_or(Lengths::default(), |day| day.lengths)
    }

    /// Each day with what is durable of it.
    pub(crate) fn marks(&self) -> impl Iterator<Item = (DayKey, Lengths)> + '_ {
        self.days.iter().map(|(key, day)| (*key, day.lengths)).filter(|(_, lengths)| lengths.data > 0)
    }

    /// Bytes of packets that wait.
    pub(crate) fn waiting_bytes(&self) -> usize {
        self.waiting_bytes
    }

    /// Puts everything that waits on disk, or nothing of it.
    pub(crate) fn sync(&mut self) -> Result<(Vec<Written>, Vec<LinkSeq>)> {
        if self.waiting_bytes == 0 {
            return Ok((Vec::new(), self.streams.settle()));
        }
        let touched: Vec<DayKey> =
            self.days.values().filter(|day| day.pending.packets > 0).map(|day| day.key).collect();
        if let Err(error) = self.write(&touched) {
            // The written part is cut off again, as far as the disk lets it; the next attempt cuts the rest.
            for key in &touched {
                if let Some(day) = self.days.get_mut(key) {
                    day.cut_back().ok();
                }
            }
            return Err(error);
        }
        let mut written = Vec::with_capacity(touched.len());
        for key in touched {
            if let Some(day) = self.days.get_mut(&key) {
                let batch = day.settle(self.spare.pop().unwrap_or_default());
                written.push(Written { key, lengths: day.lengths, batch });
            }
        }
        self.waiting_bytes = 0;
        self.close_surplus();
        Ok((written, self.streams.settle()))
    }

    /// Takes back the room of a batch that is not needed any more.
    pub(crate) fn recycle(&mut self, mut batch: Pending) {
        const KEPT: usize = 8;
        if self.spare.len() < KEPT && batch.data.capacity() <= 4 << 20 {
            batch.clear();
            self.spare.push(batch);
        }
    }

    fn write(&mut self, touched: &[DayKey]) -> Result<()> {
        for key in touched {
            if let Some(day) = self.days.get_mut(key) {
                day.write(&self.root, &mut *self.disk)?;
            }
        }
        for key in touched {
            if let Some(day) = self.days.get_mut(key) {
                day.sync(&mut *self.disk)?;
            }
        }
        Ok(())
    }

    /// Keeps the number of open files bounded; systems that send open theirs again.
    fn close_surplus(&mut self) {
        if self.days.values().filter(|day| day.is_open()).count() > MAX_OPEN_DAYS {
            for day in self.days.values_mut() {
                day.close();
            }
        }
    }
}
