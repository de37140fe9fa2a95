//! Link statistics as ordinary series: they are recorded, plotted and exported like data of vessels.
//!
//! Each vessel has four entities of this server, with labels that name vessel and figure. The three latencies are
//! LinkLatency (s, of the vessel in `sys_src`); the offset by which the vessel's clock is ahead is LinkLevel (s), as IMC
//! has no message for it.

use bytes::Bytes;
use imc::messages::{EntityInfo, LinkLatency, LinkLevel, Message};
use imc::{Address, Header, Packet};
use link::ShoreStatus;
use std::time::Duration;
use units::UtcTime;

/// Lower entity numbers are for the server itself.
const FIRST_ENTITY: usize = 16;
/// Figures of each vessel.
const LABELS: [&str; 4] = ["round trip", "from aboard to ashore", "from sent to kept", "clock ahead"];
/// The labels are repeated after this many figures.
const LABELS_EVERY: u32 = 60;

/// Makes the statistics packets of one vessel's link.
pub(crate) struct Figures {
    own: Address,
    vessel: Address,
    /// The first of the vessel's entities; `None` beyond the last number that IMC has.
    entity: Option<u8>,
    told: u32,
}

impl Figures {
    /// For the vessel with this index, in the order of first connection.
    pub(crate) fn new(own: Address, vessel: Address, index: usize) -> Self {
        let first = FIRST_ENTITY + index * LABELS.len();
        let entity = u8::try_from(first).ok().filter(|first| *first <= 250);
        Self { own, vessel, entity, told: 0 }
    }

    /// The figures as packets of this server; nothing while the link is down.
    pub(crate) fn packets(&mut self, status: &ShoreStatus, now: UtcTime) -> Vec<Bytes> {
        let Some(entity) = self.entity.filter(|_| status.up) else { return Vec::new() };
        let mut packets = Vec::new();
        let mut say = |place: u8, message: Message| {
            let header = Header {
                timestamp: now.seconds(),
                src: self.own,
                src_ent: entity + place,
                // Addressed to the server itself: a broadcast would be sent to every vessel by radio.
                dst: self.own,
                ..Header::default()
            };
            packets.extend(Packet::new(header, message).encode().ok().map(Bytes::from));
        };
        if self.told.is_multiple_of(LABELS_EVERY) {
            for (place, label) in (0..).zip(LABELS) {
                let label = format!("{} link: {label}", self.vessel);
                let component = "Link".into();
                let info = EntityInfo {
                    id: entity + place,
                    label: label.as_str().into(),
                    component,
                    ..Default::default()
                };
                say(place, info.into());
            }
        }
        self.told = self.told.wrapping_add(1);
        let kept = Some(status.backlog.keeping).filter(|keeping| !keeping.is_zero());
        for (place, latency) in (0..).zip([status.round_trip, status.transit.mean(), kept]) {
            let latency: Option<Duration> = latency;
            if let Some(latency) = latency {
                say(place, LinkLatency { value: latency.as_secs_f32(), sys_src: self.vessel.0 }.into());
            }
        }
        if let Some(clocks) = status.clocks {
            say(3, LinkLevel { value: clocks.utc_ahead_us as f32 / 1e6 }.into());
        }
        packets
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::PacketView;
    use link::ClockEstimate;

    fn status() -> ShoreStatus {
        let clocks = ClockEstimate {
            utc_ahead_us: -1_500_000,
            uncertainty_us: 10,
            round_trip: Duration::from_millis(80),
        };
        let round_trip = Some(Duration::from_millis(80));
        ShoreStatus { up: true, clocks: Some(clocks), round_trip, ..ShoreStatus::default() }
    }

    #[test]
    fn figures_are_series_with_labels() {
        let mut figures = Figures::new(Address(0x4F00), Address(0x2810), 1);
        let now = UtcTime::from_micros(1_000_000);
        let packets = figures.packets(&status(), now);
        let said: Vec<(u16, u8)> = packets
            .iter()
            .map(|packet| PacketView::new(packet).map(|view| (view.id(), view.src_ent())).unwrap())
            .collect();
        assert_eq!(said, [(3, 20), (3, 21), (3, 22), (3, 23), (182, 20), (155, 23)]);
        let ahead = Packet::decode(packets.last().unwrap()).unwrap();
        assert!((ahead.get::<LinkLevel>().unwrap().value + 1.5).abs() < 1e-6);
        assert_eq!(figures.packets(&status(), now).len(), 2, "labels are said once in a while");
    }

    #[test]
    fn a_link_that_is_down_has_none_and_numbers_end() {
        let now = UtcTime::from_micros(0);
        let mut figures = Figures::new(Address(0x4F00), Address(0x2810), 0);
        assert!(figures.packets(&ShoreStatus::default(), now).is_empty());
        assert!(Figures::new(Address(0x4F00), Address(0x2810), 60).packets(&status(), now).is_empty());
    }
}
