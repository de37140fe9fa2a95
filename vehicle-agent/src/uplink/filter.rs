//! Which packets go to the shore, how often, and which are kept longest.

use imc::PacketView;
use std::collections::{BTreeMap, BTreeSet};
use units::UtcTime;

/// The configured message settings, by id.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Filter {
    /// Those that are carried; `None` for all.
    pub(super) carried: Option<BTreeSet<u16>>,
    /// Greatest rate for each entity (1/s).
    pub(super) most_per_s: BTreeMap<u16, f64>,
    /// Those that are kept longest.
    pub(super) important: BTreeSet<u16>,
}

/// What to do with a packet.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Disposition {
    /// It is not carried.
    Leave,
    /// It came too soon after the last of its kind: it is sent live only, not recorded.
    LiveOnly,
    /// It is recorded, and whether it is kept longest.
    Record(bool),
}

/// A filter at work.
#[derive(Debug)]
pub(super) struct RateFilter {
    filter: Filter,
    /// When the last of a kind was recorded, by message, entity and, for thrusters, number.
    last: BTreeMap<(u16, u8, u8), UtcTime>,
}

impl RateFilter {
    pub(super) fn new(filter: Filter) -> Self {
        Self { filter, last: BTreeMap::new() }
    }

    /// What to do with a packet of this time.
    pub(super) fn disposition(&mut self, now: UtcTime, packet: &[u8]) -> Disposition {
        let Ok(view) = PacketView::unchecked(packet) else { return Disposition::Leave };
        let id = view.id();
        if self.filter.carried.as_ref().is_some_and(|carried| !carried.contains(&id)) {
            return Disposition::Leave;
        }
        if let Some(rate) = self.filter.most_per_s.get(&id).filter(|rate| **rate > 0.0) {
            // The thrusters of one entity are distinguished by their first payload byte.
            let kind = (id, view.src_ent(), view.payload().first().copied().unwrap_or(0));
            let kind = if id == SET_THRUSTER_ACTUATION { kind } else { (kind.0, kind.1, 0) };
            let period_us = (1e6 / rate) as i64;
            // A clock that was set back is no reason to wait.
            if self.last.get(&kind).is_some_and(|last| (0..period_us).contains(&(now - *last))) {
                return Disposition::LiveOnly;
            }
            self.last.insert(kind, now);
        }
        Disposition::Record(self.filter.important.contains(&id))
    }
}

const SET_THRUSTER_ACTUATION: u16 = 301;

#[cfg(test)]
mod tests {
    use super::*;
    use imc::messages::{Rpm, SetThrusterActuation, TBRFishTag};
    use imc::{Header, Message, Packet};

    fn packet(message: impl Into<Message>) -> Vec<u8> {
        Packet::new(Header::default(), message.into()).encode().unwrap()
    }

    #[test]
    fn rates_hold_for_each_thruster_and_detections_are_kept_longest() {
        let filter = Filter {
            carried: Some(BTreeSet::from([301, 2007])),
            most_per_s: BTreeMap::from([(301, 1.0)]),
            important: BTreeSet::from([2007]),
        };
        let mut rate_filter = RateFilter::new(filter);
        let thrust = |id| packet(SetThrusterActuation { id, value: 0.5 });
        let at = |ms: i64| UtcTime::from_micros(ms * 1000);
        let mut dispositions = Vec::new();
        for (ms, id) in [(0, 0), (1, 1), (900, 0), (1000, 0), (1001, 1), (500, 0)] {
            dispositions.push(rate_filter.disposition(at(ms), &thrust(id)));
        }
        let recorded = Disposition::Record(false);
        assert_eq!(dispositions, [recorded, recorded, Disposition::LiveOnly, recorded, recorded, recorded]);
        assert_eq!(rate_filter.disposition(at(0), &packet(TBRFishTag::default())), Disposition::Record(true));
        assert_eq!(rate_filter.disposition(at(0), &packet(Rpm { value: 1 })), Disposition::Leave);
        assert_eq!(rate_filter.disposition(at(0), b"no packet"), Disposition::Leave);
    }
}
