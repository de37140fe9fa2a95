//! Making room: removing the least important packets of the oldest files.

use super::segment::{self, HEADER_BYTES, Header, Item, Level};
use super::{Info, Spool, identity, path};
use bytes::Bytes;
use link::{Gap, GapReason};
use std::fs;
use std::io;
use units::UtcTime;

impl Spool {
    /// Thins files until the size is within its limit or there is nothing to thin.
    pub(super) fn thin(&mut self) -> io::Result<()> {
        while self.bytes() > self.bounds.bytes {
            let Some(first) = self.thinnable() else { return Ok(()) };
            self.thin_one(first)?;
        }
        Ok(())
    }

    /// The oldest of the least thinned files, except the active one.
    fn thinnable(&self) -> Option<u64> {
        let closed = self.files.range(..self.active.first);
        let thinnable = closed.filter(|(_, info)| info.level < Level::Nothing);
        thinnable.min_by_key(|(first, info)| (info.level, **first)).map(|(first, _)| *first)
    }

    /// Removes a file's telemetry, or all that is left, and merges it into the previous one if possible.
    fn thin_one(&mut self, first: u64) -> io::Result<()> {
        let end = self.files.range(first + 1..).next().map_or(self.written, |(next, _)| *next);
        let level = match self.files[&first].level {
            Level::Whole => Level::Important,
            Level::Important | Level::Nothing => Level::Nothing,
        };
        let mut thinned = Thinned::default();
        let before = self.files.range(..first).next_back().filter(|(_, info)| info.level == level);
        let into =
            before.filter(|(_, info)| info.bytes < self.bounds.file_bytes / 2).map_or(first, |(b, _)| *b);
        if into != first {
            thinned.add_all(self.items(into, first)?, |_| true);
        }
        let telemetry = level == Level::Important;
        thinned.add_all(self.items(first, end)?, |important| telemetry && important);
        let mut bytes = Header { level, first: into, end: Some(end) }.to_bytes().to_vec();
        thinned.items.iter().for_each(|item| segment::put_item(&mut bytes, item));
        identity::write_whole(&path(&self.folder, into), &bytes)?;
        if into != first {
            fs::remove_file(path(&self.folder, first))?;
            self.files.remove(&first);
        }
        self.files.insert(into, Info { level, bytes: bytes.len() as u64 });
        self.thinned += thinned.packets;
        self.place = None;
        Ok(())
    }

    /// All entries of a file, damage as a gap.
    fn items(&self, first: u64, end: u64) -> io::Result<Vec<Item>> {
        let bytes = Bytes::from(fs::read(path(&self.folder, first))?);
        let (mut at, mut next, mut items) = (HEADER_BYTES.min(bytes.len()), first, Vec::new());
        while let Some((item, length)) = segment::take(&bytes.slice(at..)) {
            (at, next) = (at + length, item.end());
            items.push(item);
        }
        if next < end {
            let time = UtcTime::default();
            let reason = GapReason::Damaged;
            items.push(Item::Gap(Gap { from: next, to: end, since: time, until: time, reason }));
        }
        Ok(items)
    }
}

/// Entries of a thinned file; adjacent gaps with the same reason are merged.
#[derive(Debug, Default)]
struct Thinned {
    items: Vec<Item>,
    packets: u64,
}

impl Thinned {
    fn add_all(&mut self, items: Vec<Item>, stays: impl Fn(bool) -> bool) {
        for item in items {
            match item {
                Item::Record(record, important) if stays(important) => {
                    self.items.push(Item::Record(record, important));
                }
                Item::Record(record, _) => {
                    self.packets += 1;
                    let (from, time, reason) = (record.seq, record.recorded, GapReason::SpoolFull);
                    self.gap(Gap { from, to: from + 1, since: time, until: time, reason });
                }
                Item::Gap(gap) => self.gap(gap),
            }
        }
    }

    fn gap(&mut self, gap: Gap) {
        match self.items.last_mut() {
            Some(Item::Gap(last)) if last.to == gap.from && last.reason == gap.reason => {
                (last.to, last.until) = (gap.to, last.until.max(gap.until));
            }
            _ => self.items.push(Item::Gap(gap)),
        }
    }
}
