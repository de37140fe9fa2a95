//! Which numbers of each vessel's record lane are durable.

use super::arrival::{Arrival, Record};
use super::scan::Records;
use crate::error::Result;
use link::LinkSeq;
use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

/// All streams.
#[derive(Debug, Default)]
pub(crate) struct Streams {
    streams: BTreeMap<u64, Stream>,
}

#[derive(Debug, Default)]
struct Stream {
    /// Up to here nothing is missing on disk.
    durable: Option<u64>,
    /// Up to here nothing is missing on disk or in the queue for it.
    accepted: Option<u64>,
    /// On disk, but behind a hole that a crash left.
    beyond: BTreeSet<u64>,
}

/// A packet's place, when it is a new one.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Place {
    pub(crate) first: bool,
    /// The number before, where that is not the one below.
    pub(crate) after: Option<LinkSeq>,
}

impl Streams {
    pub(crate) fn durable(&self, stream: u64) -> Option<u64> {
        self.streams.get(&stream)?.durable
    }

    pub(crate) fn all_durable(&self) -> impl Iterator<Item = LinkSeq> {
        self.streams
            .iter()
            .filter_map(|(stream, state)| Some(LinkSeq { stream: *stream, seq: state.durable? }))
    }

    /// `None` when the number was accepted before.
    pub(crate) fn accept(&mut self, link: LinkSeq) -> Option<Place> {
        let state = self.streams.entry(link.stream).or_default();
        let before = state.accepted;
        if before.is_some_and(|accepted| link.seq <= accepted) {
            return None;
        }
        state.accepted = Some(link.seq);
        if state.beyond.remove(&link.seq) {
            return None;
        }
        let after = before.filter(|before| before + 1 != link.seq);
        Some(Place { first: before.is_none(), after: after.map(|seq| LinkSeq { stream: link.stream, seq }) })
    }

    /// Everything accepted is on disk: returns the streams that advanced.
    pub(crate) fn settle(&mut self) -> Vec<LinkSeq> {
        let mut gained = Vec::new();
        for (stream, state) in &mut self.streams {
            if state.durable != state.accepted {
                state.durable = state.accepted;
                gained.extend(state.durable.map(|seq| LinkSeq { stream: *stream, seq }));
            }
        }
        gained
    }

    /// Starts from what an earlier run knew to be durable.
    pub(crate) fn start_from(&mut self, known: impl IntoIterator<Item = LinkSeq>) {
        for LinkSeq { stream, seq } in known {
            let state = self.streams.entry(stream).or_default();
            state.durable = state.durable.max(Some(seq));
            state.accepted = state.durable;
        }
    }

    /// Continues from the records of the archive, in any order. In an archive that was `trimmed` a stream may begin
    /// with any number: earlier records were removed.
    pub(crate) fn recover(&mut self, records: &Recovered, trimmed: bool) {
        for (stream, chain) in &records.chains {
            let state = self.streams.entry(*stream).or_default();
            for (at, (seq, before)) in chain.iter().enumerate() {
                let follows = match before {
                    Before::Nothing => true,
                    Before::Seq(before) => {
                        state.durable.map_or(trimmed && at == 0, |durable| durable >= *before)
                    }
                };
                if state.durable.is_some_and(|durable| *seq <= durable) {
                    continue;
                }
                if follows {
                    state.durable = Some(*seq);
                } else {
                    state.beyond.insert(*seq);
                }
            }
            state.accepted = state.durable;
        }
    }
}

/// The streams' numbers in the records.
#[derive(Debug, Default)]
pub(crate) struct Recovered {
    chains: BTreeMap<u64, BTreeMap<u64, Before>>,
}

#[derive(Debug, Clone, Copy)]
enum Before {
    Nothing,
    Seq(u64),
}

impl Recovered {
    /// Reads a day's records from byte `at` on.
    pub(crate) fn read(&mut self, folder: &Path, at: u64) -> Result<()> {
        let mut records = Records::open(folder, at)?;
        let mut jump = None;
        while let Some(record) = records.next()? {
            match record {
                Record::Jump { after, .. } => jump = Some(after),
                Record::Packet(arrival) => self.add(&arrival, jump.take()),
            }
        }
        Ok(())
    }

    fn add(&mut self, arrival: &Arrival, after: Option<LinkSeq>) {
        let Some(LinkSeq { stream, seq }) = arrival.link else { return };
        let before = match after {
            _ if arrival.first => Before::Nothing,
            Some(after) => Before::Seq(after.seq),
            None => seq.checked_sub(1).map_or(Before::Nothing, Before::Seq),
        };
        self.chains.entry(stream).or_default().insert(seq, before);
    }
}
