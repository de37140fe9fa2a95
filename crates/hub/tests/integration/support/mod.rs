//! Peers and packets for tests of the hub.

use bytes::Bytes;
use hub::{Incoming, Peer, PeerId, Role, Settings, Sources, Transport};
use imc::messages::{self, Message};
use imc::{Address, Header, Packet};
use std::collections::BTreeMap;
use units::{MonoTime, Now, UtcTime};

pub(crate) const SERVER: Address = Address(0x4F00);
pub(crate) const CONSOLE: Address = Address(0x4001);
pub(crate) const OTTER: Address = Address(0x2810);

/// A hub that only routes.
pub(crate) type Hub = hub::Hub<()>;

pub(crate) fn at(seconds: f64) -> Now {
    let us = (seconds * 1e6) as u64;
    Now { mono: MonoTime::from_micros(us), utc: UtcTime::from_micros(1_700_000_000_000_000 + us as i64) }
}

pub(crate) fn hub(active: bool) -> Hub {
    Hub::new(Settings { address: SERVER, name: "shore".into(), active }, ())
}

pub(crate) fn join(hub: &mut Hub, transport: Transport, role: Role) -> PeerId {
    hub.join(at(0.0), Peer { transport, role, name: "test".into(), sources: Sources::Any })
}

pub(crate) fn packet(src: Address, dst: Address, timestamp: f64, message: impl Into<Message>) -> Bytes {
    let header = Header { timestamp, src, src_ent: 3, dst, dst_ent: 255 };
    Packet::new(header, message).encode().unwrap().into()
}

pub(crate) fn voltage(src: Address, dst: Address, timestamp: f64) -> Bytes {
    packet(src, dst, timestamp, messages::Voltage { value: 12.0 })
}

/// Passes a packet in and returns who got it.
pub(crate) fn pass(hub: &mut Hub, now: Now, from: PeerId, packet: &Bytes) -> Vec<PeerId> {
    hub.packets(now, from, [Incoming::from(packet.clone())]);
    let outcome = drain(hub);
    assert!(outcome.values().flatten().all(|out| out == packet), "only the original bytes go out");
    outcome.into_keys().collect()
}

/// The send queue of each peer.
pub(crate) fn drain(hub: &mut Hub) -> BTreeMap<PeerId, Vec<Bytes>> {
    let mut out = BTreeMap::new();
    hub.drain_deliveries(|peer, packets| {
        out.insert(peer, packets.into_iter().map(|delivery| delivery.packet).collect());
    });
    out
}
