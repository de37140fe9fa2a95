//! Counts of a log's contents.

use super::names;
use imc::lsf::LogItem;
use imc::names::Names;
use imc::{Address, PacketView, reflect};
use std::collections::BTreeMap;

/// Who sent: a system and its entity.
pub(crate) type Sender = (Address, u8);

/// Counts of one log.
#[derive(Debug, Default)]
pub(crate) struct Tally {
    pub(crate) all: Count,
    /// Time of the first packet, from which the log counts.
    pub(crate) start_s: Option<f64>,
    /// By message and sender.
    pub(crate) messages: BTreeMap<u16, BTreeMap<Sender, Count>>,
    /// Complete packets that cannot be decoded, by class.
    pub(crate) undecodable: BTreeMap<&'static str, u64>,
    pub(crate) damage: Damage,
    pub(crate) names: Names,
}

/// Bytes that are not packets.
#[derive(Debug, Default)]
pub(crate) struct Damage {
    pub(crate) runs: u64,
    pub(crate) bytes: u64,
    /// Where the first begins.
    pub(crate) first: Option<u64>,
    /// Where decompression failed, and why.
    pub(crate) cut: Option<(u64, String)>,
}

/// Packets of some kind.
#[derive(Debug, Clone, Default)]
pub(crate) struct Count {
    pub(crate) packets: u64,
    pub(crate) bytes: u64,
    pub(crate) earliest_s: Option<f64>,
    pub(crate) latest_s: Option<f64>,
}

impl Count {
    fn add(&mut self, view: &PacketView<'_>) {
        let time_s = Some(view.timestamp()).filter(|time| time.is_finite());
        self.merge(&Self {
            packets: 1,
            bytes: view.bytes().len() as u64,
            earliest_s: time_s,
            latest_s: time_s,
        });
    }

    /// Adds the packets of another kind.
    pub(crate) fn merge(&mut self, other: &Self) {
        self.packets += other.packets;
        self.bytes += other.bytes;
        let both = |a: Option<f64>, b: Option<f64>, pick: fn(f64, f64) -> f64| match (a, b) {
            (Some(a), Some(b)) => Some(pick(a, b)),
            (a, b) => a.or(b),
        };
        self.earliest_s = both(self.earliest_s, other.earliest_s, f64::min);
        self.latest_s = both(self.latest_s, other.latest_s, f64::max);
    }
}

impl Tally {
    /// Learns names, whether or not the packet is counted.
    pub(crate) fn learn(&mut self, view: &PacketView<'_>) {
        names::learn(&mut self.names, view);
    }

    /// Counts a packet.
    pub(crate) fn packet(&mut self, view: &PacketView<'_>) {
        self.all.add(view);
        if self.start_s.is_none() {
            self.start_s = Some(view.timestamp()).filter(|time| time.is_finite());
        }
        let senders = self.messages.entry(view.id()).or_default();
        senders.entry((view.src(), view.src_ent())).or_default().add(view);
        let class = match reflect::check(view) {
            None => "unknown_id",
            Some(Err(error)) => error.class(),
            Some(Ok(_)) => return,
        };
        *self.undecodable.entry(class).or_default() += 1;
    }

    /// Counts an item that is not a packet.
    pub(crate) fn other(&mut self, item: &LogItem<'_>) {
        match item {
            LogItem::Packet { .. } => {}
            LogItem::Damage(damage) => {
                self.damage.runs += 1;
                self.damage.bytes += damage.bytes;
                self.damage.first.get_or_insert(damage.offset);
            }
            LogItem::Cut { offset, problem } => self.damage.cut = Some((*offset, (*problem).to_owned())),
        }
    }

    /// Seconds from the first packet to the latest.
    pub(crate) fn span_s(&self) -> f64 {
        match (self.start_s, self.all.latest_s) {
            (Some(start), Some(latest)) => (latest - start).max(0.0),
            _ => 0.0,
        }
    }

    /// Packets per second over the whole span.
    pub(crate) fn rate_hz(&self, packets: u64) -> Option<f64> {
        let span_s = self.span_s();
        (span_s > 0.0).then(|| packets as f64 / span_s)
    }

    /// Counts by system.
    pub(crate) fn sources(&self) -> BTreeMap<Address, Count> {
        let mut sources: BTreeMap<Address, Count> = BTreeMap::new();
        for ((source, _), count) in self.messages.values().flatten() {
            sources.entry(*source).or_default().merge(count);
        }
        sources
    }

    /// Whether there is any damage.
    pub(crate) fn is_damaged(&self) -> bool {
        self.damage.runs > 0 || self.damage.cut.is_some() || !self.undecodable.is_empty()
    }
}
