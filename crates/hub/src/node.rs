//! The server as a console on the network: it announces itself, keeps vessels sending and asks what their
//! entities are called.
//!
//! A DUNE vessel sends to a console that announced itself and continues to send; its supervisors count
//! heartbeats of console addresses only. So every vessel gets a Heartbeat each second, addressed to it, because an
//! IMCProxy passes nothing on that is addressed to everyone.

use crate::fleet::{Fleet, Liveness, System};
use bytes::Bytes;
use imc::messages::{Announce, EntityList, EntityListOp, Heartbeat, Payload, SystemType};
use imc::{Address, Header};
use std::collections::BTreeMap;
use std::time::Duration;
use units::{MonoTime, Now};

/// DUNE and Neptus announce themselves as often.
const ANNOUNCE_EVERY: Duration = Duration::from_secs(10);
/// How often a system whose entities are not known is asked.
const ASK_EVERY: Duration = Duration::from_secs(10);
/// How often it is asked when they are known: a vessel may restart without a message.
const ASK_AGAIN_EVERY: Duration = Duration::from_mins(1);

/// A system that was silent for longer gets no more heartbeats.
const THERE_FOR: Duration = Duration::from_mins(1);

/// The hub's settings, fixed at its start.
#[derive(Debug, Clone, PartialEq)]
pub struct Settings {
    /// This server's own address, a console's (0x4000 to 0x5FFF), or vessels would not count its heartbeats.
    pub address: Address,
    /// This server's own name.
    pub name: String,
    /// Whether the server takes part as a console: announces itself, sends heartbeats so that vessels keep
    /// sending, and asks for names of entities. Without it the server only listens.
    pub active: bool,
}

#[derive(Debug)]
pub(crate) struct Node {
    address: Address,
    name: String,
    active: bool,
    services: String,
    announced: Option<MonoTime>,
    asked: BTreeMap<Address, MonoTime>,
}

impl Node {
    pub(crate) fn new(settings: &Settings) -> Self {
        Self {
            address: settings.address,
            name: settings.name.chars().take(100).collect(),
            active: settings.active,
            services: String::new(),
            announced: None,
            asked: BTreeMap::new(),
        }
    }

    pub(crate) fn set_services(&mut self, services: &str) {
        self.services = services.chars().take(4_096).collect();
    }

    /// The announcement sent to a peer that joins, so that a vessel behind it learns of us at once.
    pub(crate) fn announce_to_newcomer(&self, now: Now) -> Option<Bytes> {
        self.active.then(|| self.announcement(now))
    }

    pub(crate) fn announcement(&self, now: Now) -> Bytes {
        let announce = Announce {
            sys_name: self.name.as_str().into(),
            sys_type: SystemType::Ccu,
            owner: 0xFFFF,
            services: self.services.as_str().into(),
            ..Announce::default()
        };
        self.packet(now, Address::ANNOUNCE, &announce)
    }

    pub(crate) fn tick(&mut self, now: Now, fleet: &Fleet) -> Vec<Bytes> {
        let mut packets = Vec::new();
        if self.announced.is_none_or(|last| now.mono.since(last) >= ANNOUNCE_EVERY) {
            self.announced = Some(now.mono);
            packets.push(self.announcement(now));
        }
        let there = |system: &&System| {
            !system.address().is_ccu()
                && !system.address().is_everyone()
                && now.mono.since(system.last_heard()) < THERE_FOR
        };
        for system in fleet.systems().filter(there) {
            let address = system.address();
            packets.push(self.packet(now, address, &Heartbeat));
            let every = if system.entities().is_empty() { ASK_EVERY } else { ASK_AGAIN_EVERY };
            let due = self.asked.get(&address).is_none_or(|asked| now.mono.since(*asked) >= every);
            if due && system.liveness(now.mono) == Liveness::Live {
                self.asked.insert(address, now.mono);
                let query = EntityList { op: EntityListOp::Query, ..EntityList::default() };
                packets.push(self.packet(now, address, &query));
            }
        }
        self.asked.retain(|address, _| fleet.system(*address).is_some());
        packets
    }

    fn packet<T: Payload>(&self, now: Now, dst: Address, message: &T) -> Bytes {
        let header = Header { timestamp: now.utc.seconds(), src: self.address, dst, ..Header::default() };
        let mut bytes = Vec::new();
        // Cannot fail: names and services are cut, and all else has a fixed length.
        imc::encode_into(&mut bytes, &header, message).ok();
        bytes.into()
    }
}
