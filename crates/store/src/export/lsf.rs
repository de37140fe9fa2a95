//! Packets as a log, byte for byte as they came, from the archive.

use super::csv::{Exported, unwritable};
use super::plan::{Selection, choose};
use crate::archive::{self, DayReader};
use crate::error::Result;
use crate::history::{GroupKey, load_progress};
use crate::reader::Reader;
use imc::{Address, PacketView};
use std::collections::{BTreeMap, BTreeSet};
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
    let reader = Reader::open(data)?;
    let names = reader.names()?;
    let root = data.join("archive");
    let read = reader.ask_catalogue(load_progress)?.unwrap_or_default();
    let mut systems: BTreeMap<Address, Vec<archive::DayKey>> = BTreeMap::new();
    for key in archive::days(&root)? {
        let progress = read.get(&key);
        // A day that the history has read to its end tells what times its packets state.
        let outside = progress.is_some_and(|progress| {
            let whole = std::fs::metadata(key.folder(&root).join(archive::DATA))
                .is_ok_and(|file| file.len() == progress.lengths.data);
            whole
                && (progress.extent.last_us < selection.range.from_us
                    || progress.extent.first_us >= selection.range.to_us)
        });
        if !outside && (selection.systems.is_empty() || selection.systems.contains(&key.src)) {
            systems.entry(key.src).or_default().push(key);
        }
    }
    let mut sources = Vec::new();
    for days in systems.into_values() {
        let mut source = Source { days: days.into_iter().rev().collect(), reader: None, ahead: None };
        source.advance(&root)?;
        sources.push(source);
    }
    let mut exported = Exported::default();
    let mut filter = Filter { selection, names: &names, known: BTreeSet::new(), refused: BTreeSet::new() };
    // The system whose packet came first has its turn.
    while let Some(source) =
        sources.iter_mut().filter(|one| one.ahead.is_some()).min_by_key(|one| one.arrived())
    {
        if let Some((_, packet)) = &source.ahead
            && filter.wants(&PacketView::unchecked(packet)?)?
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

/// Tells wanted packets; remembers which series are.
struct Filter<'s> {
    selection: &'s Selection,
    names: &'s crate::history::Names,
    known: BTreeSet<GroupKey>,
    refused: BTreeSet<GroupKey>,
}

impl Filter<'_> {
    fn wants(&mut self, view: &PacketView<'_>) -> Result<bool> {
        let time_us = view.header().time().map_or(0, UtcTime::micros);
        if !self.selection.range.contains(time_us) {
            return Ok(false);
        }
        let group = GroupKey { id: view.id(), src: view.src().0, src_ent: view.src_ent() };
        if !self.known.contains(&group) && !self.refused.contains(&group) {
            let wanted = choose(self.names, self.selection, std::iter::once(group))?;
            if wanted.is_empty() {
                self.refused.insert(group)
            } else {
                self.known.insert(group)
            };
        }
        Ok(self.known.contains(&group))
    }
}
