//! Packets as a log, byte for byte as they came, from the archive.

use super::cells::{Exported, unwritable};
use super::select::Selection;
use crate::archive::{self, DayReader};
use crate::error::Result;
use crate::history::{GroupKey, Names, load_progress};
use crate::range::{NO_TIME_US, TimeRange};
use crate::reader::Reader;
use imc::{Address, PacketView};
use std::collections::BTreeMap;
use std::io::Write;
use std::path::Path;
use units::UtcTime;

/// Writes the packets of a selection as one log, in order of arrival. Fields cannot be chosen: a packet is whole.
///
/// Needs memory for a quarter of a megabyte of each system.
///
/// # Errors
/// When the selection names what does not exist, the archive cannot be read or `out` not be written. What was
/// written then is not all, but each packet of it is whole or cut at the very end, as readers of logs expect.
pub fn export_lsf(data: &Path, selection: &Selection, out: &mut dyn Write) -> Result<Exported> {
    let mut reader = Reader::open(data)?;
    let selection = &selection.known(&mut reader)?;
    let names = reader.names()?;
    let root = data.join("archive");
    let mut systems: BTreeMap<Address, Vec<archive::DayKey>> = BTreeMap::new();
    for key in days(&reader, &root, selection)? {
        systems.entry(key.src).or_default().push(key);
    }
    let mut sources = Vec::new();
    for days in systems.into_values() {
        let mut source = Source { days: days.into_iter().rev().collect(), reader: None, ahead: None };
        source.advance(&root)?;
        sources.push(source);
    }
    let mut exported = Exported::default();
    let mut filter = Filter { selection, names: &names, spans: BTreeMap::new() };
    // The system whose packet came first has its turn.
    while let Some(source) =
        sources.iter_mut().filter(|one| one.ahead.is_some()).min_by_key(|one| one.arrived())
    {
        if let Some((_, packet)) = &source.ahead
            && filter.wants(&PacketView::unchecked(packet)?)
        {
            out.write_all(packet).map_err(unwritable)?;
            exported.rows += 1;
            exported.bytes += packet.len() as u64;
        }
        source.advance(&root)?;
    }
    out.flush().map_err(unwritable)?;
    Ok(exported)
}

/// The days of the archive that may have packets of a selection.
pub(super) fn days(reader: &Reader, root: &Path, selection: &Selection) -> Result<Vec<archive::DayKey>> {
    let read = reader.ask_catalogue(load_progress)?.unwrap_or_default();
    let mut days = archive::days(root)?;
    days.retain(|key| {
        // For a day that the history has read to its end, the times that its packets state are known.
        let outside = read.get(key).is_some_and(|progress| {
            let whole = archive::bytes::plain_bytes(&key.folder(root), archive::DATA)
                .map_or(true, |bytes| bytes == Some(progress.lengths.data));
            whole
                && (progress.extent.last_us < selection.range.from_us
                    || progress.extent.first_us >= selection.range.to_us)
        });
        !outside && (selection.systems.is_empty() || selection.systems.contains(&key.src))
    });
    Ok(days)
}

/// One system's days, read one after the other.
struct Source {
    /// The last first.
    days: Vec<archive::DayKey>,
    reader: Option<DayReader>,
    ahead: Option<(UtcTime, Vec<u8>)>,
}

impl Source {
    fn arrived(&self) -> Option<UtcTime> {
        self.ahead.as_ref().map(|(arrived, _)| *arrived)
    }

    fn advance(&mut self, root: &Path) -> Result<()> {
        let mut packet = self.ahead.take().map(|(_, packet)| packet).unwrap_or_default();
        loop {
            if let Some(reader) = &mut self.reader
                && let Some(archived) = reader.next_packet()?
            {
                packet.clear();
                packet.extend_from_slice(archived.view.bytes());
                self.ahead = Some((archived.arrival.received, packet));
                return Ok(());
            }
            match self.days.pop() {
                Some(key) => self.reader = Some(DayReader::open(root, key, 0, 0)?),
                None => return Ok(()),
            }
        }
    }
}

/// Recognises the selected packets; caches the selected times of each series.
struct Filter<'s> {
    selection: &'s Selection,
    names: &'s Names,
    spans: BTreeMap<GroupKey, Vec<TimeRange>>,
}

impl Filter<'_> {
    fn wants(&mut self, view: &PacketView<'_>) -> bool {
        let Self { selection, names, spans } = self;
        let time_us = view.header().time().map_or(NO_TIME_US, UtcTime::micros);
        if !selection.range.contains(time_us) {
            return false;
        }
        let group = GroupKey { id: view.id(), src: view.src().0, src_ent: view.src_ent() };
        let wanted = spans.entry(group).or_insert_with(|| {
            if selection.has_message(group.id) {
                selection.spans(names, group.src, group.src_ent)
            } else {
                Vec::new()
            }
        });
        wanted.iter().any(|span| span.contains(time_us))
    }
}
