//! Who is out there, and what goes to whom.
//!
//! As DUNE has it: a node gets UDP traffic once it announced an `imc+udp` address and something came from its
//! id by one of the announced addresses within the contact timeout; a TCP client gets everything listed from
//! the moment it connects; static destinations always receive. Each transport has its list of messages and
//! its rate limits, per message and entity; packets addressed to one system go to that system only on UDP and
//! are never limited.

use crate::input::Peer;
use crate::settings::{NodeSettings, TransportSettings};
use imc::Address;
use imc::messages::Announce;
use std::collections::{BTreeMap, BTreeSet};
use std::net::{Ipv4Addr, SocketAddrV4};
use std::time::Duration;
use units::MonoTime;

/// Systems remembered; beyond that the one silent for longest is forgotten.
const SYSTEMS_KEPT: usize = 256;
/// Sockets of one announcement that are read.
const SOCKETS_READ: usize = 16;

/// A system that announced itself.
#[derive(Debug, Clone)]
struct System {
    name: String,
    sockets: Vec<SocketAddrV4>,
    /// The socket in use and when something last came from there.
    contact: Option<(SocketAddrV4, MonoTime)>,
    heard: MonoTime,
}

/// The other systems, and what they are sent.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    settings: NodeSettings,
    systems: BTreeMap<Address, System>,
    tcp: BTreeSet<u32>,
    /// When a limited message may go next, per transport, message and entity.
    next: BTreeMap<(bool, u16, u8), MonoTime>,
}

/// What a packet tells about the system that sent it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Contact {
    /// Nothing that was not known.
    Known,
    /// A system is reachable that was not; its name.
    New(String),
}

impl Node {
    pub(crate) fn new(settings: NodeSettings) -> Self {
        Self { settings, systems: BTreeMap::new(), tcp: BTreeSet::new(), next: BTreeMap::new() }
    }

    pub(crate) fn reconfigure(&mut self, settings: NodeSettings) {
        self.settings = settings;
    }

    pub(crate) fn connected(&mut self, peer: Peer) {
        if let Peer::Tcp(number) = peer {
            self.tcp.insert(number);
        }
    }

    pub(crate) fn disconnected(&mut self, peer: Peer) {
        if let Peer::Tcp(number) = peer {
            self.tcp.remove(&number);
        }
    }

    /// A system's announcement, from a peer.
    pub(crate) fn announced(
        &mut self,
        now: MonoTime,
        id: Address,
        from: Peer,
        announce: &Announce,
    ) -> Contact {
        let services = announce.services.to_str_lossy();
        let all = imc::services::parse(&services).filter(|service| service.scheme == "imc+udp");
        let sockets: Vec<SocketAddrV4> =
            all.filter_map(|service| service.socket()).take(SOCKETS_READ).collect();
        if !self.systems.contains_key(&id) && self.systems.len() >= SYSTEMS_KEPT {
            let oldest = self.systems.iter().min_by_key(|(_, system)| system.heard).map(|(id, _)| *id);
            oldest.map(|id| self.systems.remove(&id));
        }
        let name = announce.sys_name.to_str_lossy().chars().take(100).collect();
        let before = self.systems.remove(&id);
        let contact = before.and_then(|system| system.contact).filter(|(at, _)| sockets.contains(at));
        self.systems.insert(id, System { name, sockets, contact, heard: now });
        self.heard(now, id, from)
    }

    /// Something came from a system.
    pub(crate) fn heard(&mut self, now: MonoTime, id: Address, from: Peer) -> Contact {
        let timeout = self.settings.contact_timeout;
        let Some(system) = self.systems.get_mut(&id) else { return Contact::Known };
        system.heard = now;
        let Peer::Udp(at) = from else { return Contact::Known };
        // The same host counts: a console may send from another port than the one it listens on.
        let Some(socket) = system.sockets.iter().find(|socket| socket.ip() == at.ip()).copied() else {
            return Contact::Known;
        };
        let was = system.contact.is_some_and(|(_, heard)| now.since(heard) < timeout);
        system.contact = Some((socket, now));
        if was { Contact::Known } else { Contact::New(system.name.clone()) }
    }

    /// Where a system is in contact by UDP.
    pub(crate) fn host_of(&self, id: Address) -> Option<Ipv4Addr> {
        self.systems.get(&id)?.contact.map(|(at, _)| *at.ip())
    }

    /// The name a system announced.
    pub(crate) fn name_of(&self, id: Address) -> Option<&str> {
        self.systems.get(&id).map(|system| system.name.as_str())
    }

    /// How many systems are in contact by UDP, and how many TCP clients there are.
    pub(crate) fn counts(&self, now: MonoTime) -> (usize, usize) {
        let timeout = self.settings.contact_timeout;
        let live = |system: &&System| system.contact.is_some_and(|(_, heard)| now.since(heard) < timeout);
        (self.systems.values().filter(live).count(), self.tcp.len())
    }

    /// TCP clients other than `from`, for what is passed on.
    pub(crate) fn tcp_but(&self, from: Peer) -> Vec<Peer> {
        self.tcp.iter().map(|number| Peer::Tcp(*number)).filter(|peer| *peer != from).collect()
    }

    /// Who gets a packet of this system.
    pub(crate) fn recipients(&mut self, now: MonoTime, id: u16, entity: u8, to: Address) -> Vec<Peer> {
        let mut peers = Vec::new();
        let addressed = !to.is_everyone();
        if !self.tcp.is_empty() && self.passes(now, true, id, entity, addressed) {
            peers.extend(self.tcp.iter().map(|number| Peer::Tcp(*number)));
        }
        let timeout = self.settings.contact_timeout;
        let mut live = self
            .systems
            .iter()
            .filter(|(address, _)| !addressed || **address == to)
            .filter_map(|(_, system)| system.contact)
            .filter(|(_, heard)| now.since(*heard) < timeout)
            .map(|(socket, _)| Peer::Udp(socket))
            .chain(self.settings.static_destinations.iter().map(|socket| Peer::Udp(*socket)))
            .collect::<BTreeSet<_>>();
        if !live.is_empty() && self.passes(now, false, id, entity, addressed) {
            peers.extend(std::mem::take(&mut live));
        }
        peers
    }

    fn passes(&mut self, now: MonoTime, tcp: bool, id: u16, entity: u8, addressed: bool) -> bool {
        let TransportSettings { left_out, most_per_s } =
            if tcp { &self.settings.tcp } else { &self.settings.udp };
        if addressed {
            return true;
        }
        if left_out.contains(&id) {
            return false;
        }
        let Some(rate) = most_per_s.get(&id) else { return true };
        let period = Duration::from_secs_f64(1.0 / rate.clamp(1e-3, 1e3));
        let next = self.next.entry((tcp, id, entity)).or_insert(now);
        if now < *next {
            return false;
        }
        // From when it was due, so that the mean rate is met; not from long ago.
        *next = if now.since(*next) < period { *next + period } else { now + period };
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const CONSOLE: Address = Address(0x4001);

    fn at(seconds: f64) -> MonoTime {
        MonoTime::from_micros((seconds * 1e6) as u64)
    }

    fn udp(port: u16) -> Peer {
        Peer::Udp(SocketAddrV4::new([127, 0, 0, 1].into(), port))
    }

    fn announce() -> Announce {
        Announce {
            sys_name: "console".into(),
            services: "imc+udp://127.0.0.1:6001/;imc+udp://10.1.1.1:6001/".into(),
            ..Announce::default()
        }
    }

    #[test]
    fn sends_after_an_announcement_and_until_the_contact_is_silent() {
        let mut node = Node::new(NodeSettings::default());
        assert_eq!(node.heard(at(0.0), CONSOLE, udp(5000)), Contact::Known);
        assert!(node.recipients(at(0.0), 350, 0, Address::NULL).is_empty());
        assert_eq!(node.announced(at(1.0), CONSOLE, udp(5000), &announce()), Contact::New("console".into()));
        assert_eq!(node.recipients(at(1.0), 500, 0, Address::NULL), [udp(6001)]);
        node.heard(at(25.0), CONSOLE, udp(5000));
        assert_eq!(node.recipients(at(54.0), 500, 0, Address::NULL), [udp(6001)]);
        assert!(node.recipients(at(56.0), 500, 0, Address::NULL).is_empty());
        // A heartbeat brings it back without another announcement; one from elsewhere does not.
        let elsewhere = Peer::Udp(SocketAddrV4::new([10, 9, 9, 9].into(), 6001));
        assert_eq!(node.heard(at(57.0), CONSOLE, elsewhere), Contact::Known);
        assert!(node.recipients(at(57.0), 500, 0, Address::NULL).is_empty());
        assert_eq!(node.heard(at(57.0), CONSOLE, udp(6001)), Contact::New("console".into()));
        assert_eq!(node.recipients(at(57.0), 500, 0, CONSOLE), [udp(6001)]);
        assert!(node.recipients(at(57.0), 500, 0, Address(0x4002)).is_empty());
    }

    #[test]
    fn limits_rates_on_udp_and_not_on_tcp() {
        let mut node = Node::new(NodeSettings::default());
        node.announced(at(0.0), CONSOLE, udp(6001), &announce());
        node.connected(Peer::Tcp(7));
        let (mut by_udp, mut by_tcp) = (0, 0);
        for step in 0..100 {
            for peer in node.recipients(at(f64::from(step) * 0.1), 350, 0, Address::NULL) {
                match peer {
                    Peer::Udp(_) => by_udp += 1,
                    Peer::Tcp(_) => by_tcp += 1,
                }
            }
        }
        assert_eq!((by_udp, by_tcp), (20, 100));
        node.disconnected(Peer::Tcp(7));
        assert_eq!(node.counts(at(10.0)), (1, 0));
    }
}
