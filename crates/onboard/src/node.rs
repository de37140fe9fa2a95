//! The systems in contact, and which messages each of them gets.
//!
//! As DUNE has it: a node gets UDP traffic once it announced an `imc+udp` address and something came from its
//! id by one of the announced addresses within the contact timeout; a TCP client gets everything listed from
//! the moment it connects; static destinations always receive. Each transport has its list of messages and
//! its rate limits, per message and entity; packets addressed to one system go to that system only on UDP and
//! are never limited.
//!
//! Any host can announce any system. So an announcement alone opens a contact for some seconds only; it lasts when
//! another message comes from there, too. A system in contact is neither redirected by another host's announcement
//! nor pushed out by many new ones, and few can be in contact at once.

use crate::entity::Entity;
use crate::peer::Peer;
use crate::settings::{NodeSettings, TransportSettings};
use imc::Address;
use imc::messages::Announce;
use std::collections::{BTreeMap, BTreeSet};
use std::net::{Ipv4Addr, SocketAddrV4};
use std::time::Duration;
use units::MonoTime;

/// Systems remembered; beyond that the one silent for longest is forgotten, but none in contact.
const SYSTEMS_KEPT: usize = 256;
/// Systems in contact by UDP at once; more are not sent to.
const CONTACTS: usize = 32;
/// Of these, those that have only announced themselves.
const STRANGERS: usize = 8;
/// How long an announcement alone keeps a contact.
const PROBATION: Duration = Duration::from_secs(10);
/// Sockets of one announcement that are read.
const SOCKETS_READ: usize = 16;

/// A system that announced itself.
#[derive(Debug, Clone)]
struct System {
    name: String,
    sockets: Vec<SocketAddrV4>,
    contact: Option<Link>,
    heard: MonoTime,
}

/// The way to a system.
#[derive(Debug, Clone, Copy)]
struct Link {
    /// The socket in use.
    at: SocketAddrV4,
    /// When something last came from there.
    heard: MonoTime,
    /// When it was opened.
    since: MonoTime,
    /// A message other than an announcement came from there.
    proven: bool,
}

impl Link {
    fn is_live(&self, now: MonoTime, timeout: Duration) -> bool {
        now.since(self.heard) < timeout && (self.proven || now.since(self.since) < PROBATION)
    }
}

/// The other systems, and what they are sent.
#[derive(Debug, Clone)]
pub(crate) struct Node {
    settings: NodeSettings,
    systems: BTreeMap<Address, System>,
    tcp: BTreeSet<Peer>,
    /// When a limited message may go next, per transport, message and entity.
    next: BTreeMap<(Option<usize>, u16, u8), MonoTime>,
}

/// What a packet says about the system that sent it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Contact {
    /// Nothing new.
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
        if matches!(peer, Peer::Tcp(_)) {
            self.tcp.insert(peer);
        }
    }

    pub(crate) fn disconnected(&mut self, peer: Peer) {
        self.tcp.remove(&peer);
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
        let timeout = self.settings.contact_timeout;
        let live = |system: &System| system.contact.filter(|link| link.is_live(now, timeout));
        if let (Some(link), Peer::Udp(at)) = (self.systems.get(&id).and_then(live), from)
            && link.at.ip() != at.ip()
        {
            return Contact::Known;
        }
        if !self.systems.contains_key(&id) && self.systems.len() >= SYSTEMS_KEPT {
            let idle = self.systems.iter().filter(|(_, system)| live(system).is_none());
            let Some(oldest) = idle.min_by_key(|(_, system)| system.heard).map(|(id, _)| *id) else {
                return Contact::Known;
            };
            self.systems.remove(&oldest);
        }
        let name = announce.sys_name.to_str_lossy().chars().take(100).collect();
        let before = self.systems.remove(&id);
        let contact = before.and_then(|system| system.contact).filter(|link| sockets.contains(&link.at));
        self.systems.insert(id, System { name, sockets, contact, heard: now });
        self.met(now, id, from, false)
    }

    /// A packet came from a system.
    pub(crate) fn heard(&mut self, now: MonoTime, id: Address, from: Peer) -> Contact {
        self.met(now, id, from, true)
    }

    fn met(&mut self, now: MonoTime, id: Address, from: Peer, proof: bool) -> Contact {
        let timeout = self.settings.contact_timeout;
        let others = self.systems.iter().filter(|(other, _)| **other != id);
        let others = others.filter_map(|(_, system)| system.contact);
        let (mut proven, mut strangers) = (0, 0);
        for link in others.filter(|link| link.is_live(now, timeout)) {
            if link.proven { proven += 1 } else { strangers += 1 }
        }
        let Some(system) = self.systems.get_mut(&id) else { return Contact::Known };
        system.heard = now;
        let Peer::Udp(at) = from else { return Contact::Known };
        if !self.settings.dynamic_contacts {
            return Contact::Known;
        }
        // The same host counts: a console may send from another port than the one it listens on.
        let Some(socket) = system.sockets.iter().find(|socket| socket.ip() == at.ip()).copied() else {
            return Contact::Known;
        };
        let before = system.contact.filter(|link| link.at.ip() == socket.ip());
        let was = before.is_some_and(|link| link.is_live(now, timeout));
        // Announcements never end: only another message restores a former contact.
        let known = before.filter(|link| was || !proof || link.proven);
        let link = match known {
            Some(link) => Link { at: socket, heard: now, proven: link.proven || proof, ..link },
            None => Link { at: socket, heard: now, since: now, proven: proof },
        };
        let room = was || if link.proven { proven < CONTACTS } else { strangers < STRANGERS };
        if !room {
            return Contact::Known;
        }
        system.contact = Some(link);
        if was || !link.is_live(now, timeout) { Contact::Known } else { Contact::New(system.name.clone()) }
    }

    /// Where a system is in contact by UDP.
    pub(crate) fn host_of(&self, id: Address) -> Option<Ipv4Addr> {
        self.systems.get(&id)?.contact.map(|link| *link.at.ip())
    }

    /// The name a system announced.
    pub(crate) fn name_of(&self, id: Address) -> Option<&str> {
        self.systems.get(&id).map(|system| system.name.as_str())
    }

    /// How many systems are in contact by UDP, and how many TCP clients there are.
    pub(crate) fn counts(&self, now: MonoTime) -> (usize, usize) {
        let timeout = self.settings.contact_timeout;
        let live = |system: &&System| system.contact.is_some_and(|link| link.is_live(now, timeout));
        (self.systems.values().filter(live).count(), self.tcp.len())
    }

    /// TCP clients other than `from` whose server carries a message, for what is passed on.
    pub(crate) fn tcp_but(&self, from: Peer, id: u16) -> Vec<Peer> {
        let carries = |peer: &&Peer| !self.carried(peer.server()).left_out.contains(&id);
        self.tcp.iter().filter(|peer| **peer != from).filter(carries).copied().collect()
    }

    /// The receivers of a packet of this system.
    pub(crate) fn recipients(&mut self, now: MonoTime, id: u16, entity: u8, to: Address) -> Vec<Peer> {
        let mut peers = Vec::new();
        let addressed = !to.is_everyone();
        // In order of their servers, of which each decides once.
        let mut of_server = (None, false);
        for peer in self.tcp.clone() {
            if of_server.0 != peer.server() {
                of_server = (peer.server(), self.passes(now, peer.server(), id, entity, addressed));
            }
            peers.extend(Some(peer).filter(|_| of_server.1));
        }
        let timeout = self.settings.contact_timeout;
        let mut live = self
            .systems
            .iter()
            .filter(|(address, _)| !addressed || **address == to)
            .filter_map(|(_, system)| system.contact)
            .filter(|link| link.is_live(now, timeout))
            .map(|link| Peer::Udp(link.at))
            .chain(self.settings.static_destinations.iter().map(|socket| Peer::Udp(*socket)))
            .collect::<BTreeSet<_>>();
        if !live.is_empty() && self.passes(now, None, id, entity, addressed) {
            peers.extend(std::mem::take(&mut live));
        }
        peers
    }

    /// The messages that a TCP server carries, or UDP.
    fn carried(&self, server: Option<usize>) -> &TransportSettings {
        static EVERYTHING: TransportSettings = TransportSettings {
            left_out: BTreeSet::new(),
            most_per_s: BTreeMap::new(),
            only_of: BTreeMap::new(),
        };
        match server {
            None => &self.settings.udp,
            Some(server) => self.settings.tcp.get(server).unwrap_or(&EVERYTHING),
        }
    }

    fn passes(&mut self, now: MonoTime, server: Option<usize>, id: u16, entity: u8, addressed: bool) -> bool {
        if addressed {
            return true;
        }
        let TransportSettings { left_out, most_per_s, only_of } = self.carried(server);
        let is_one = |entities: &BTreeSet<Entity>| entities.iter().any(|one| one.number() == entity);
        if left_out.contains(&id) || only_of.get(&id).is_some_and(|entities| !is_one(entities)) {
            return false;
        }
        let Some(rate) = most_per_s.get(&id) else { return true };
        let period = Duration::from_secs_f64(1.0 / rate.clamp(1e-3, 1e3));
        let next = self.next.entry((server, id, entity)).or_insert(now);
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

    fn named(name: &str, host: u8) -> (Peer, Announce) {
        let services = format!("imc+udp://10.0.0.{host}:6001/").as_str().into();
        let from = Peer::Udp(SocketAddrV4::new([10, 0, 0, host].into(), 6001));
        (from, Announce { sys_name: name.into(), services, ..Announce::default() })
    }

    #[test]
    fn an_announcement_alone_is_answered_for_seconds_however_often_it_comes() {
        let mut node = Node::new(NodeSettings::default());
        let (from, announce) = named("victim", 9);
        let sent = |node: &mut Node, seconds| !node.recipients(at(seconds), 500, 0, Address::NULL).is_empty();
        for second in 0..120 {
            node.announced(at(f64::from(second)), CONSOLE, from, &announce);
            assert_eq!(sent(&mut node, f64::from(second)), second < 10, "{second}");
        }
        assert_eq!(node.heard(at(120.0), CONSOLE, from), Contact::New("victim".into()));
        node.announced(at(140.0), CONSOLE, from, &announce);
        assert!(sent(&mut node, 165.0), "who spoke once is kept by its announcements");
    }

    #[test]
    fn a_flood_of_announcements_neither_pushes_a_console_out_nor_takes_its_place() {
        let mut node = Node::new(NodeSettings::default());
        let (console, announce) = named("console", 1);
        node.announced(at(0.0), CONSOLE, console, &announce);
        node.heard(at(0.0), CONSOLE, console);
        for n in 0..1000 {
            let (from, announce) = named("flood", 2 + (n % 200) as u8);
            node.announced(at(1.0 + 0.001 * f64::from(n)), Address(0x4100 + n), from, &announce);
        }
        let sent = node.recipients(at(2.5), 500, 0, Address::NULL);
        assert!(sent.contains(&console) && sent.len() <= 1 + STRANGERS, "{sent:?}");
        // Another host in the console's name gets nothing and changes nothing.
        let (thief, announce) = named("console", 66);
        node.announced(at(3.0), CONSOLE, thief, &announce);
        node.heard(at(3.0), CONSOLE, thief);
        assert_eq!(node.recipients(at(3.0), 500, 0, CONSOLE), [console]);
        // When the console is gone from its host, another host is accepted.
        node.announced(at(40.0), CONSOLE, thief, &announce);
        assert_eq!(node.recipients(at(40.0), 500, 0, CONSOLE), [thief]);
    }

    #[test]
    fn each_server_of_streams_carries_its_own_list_and_rates() {
        let entities = [Entity::Gps].into();
        let tcp = vec![
            TransportSettings { left_out: [150].into(), ..TransportSettings::default() },
            TransportSettings { only_of: [(150, entities)].into(), ..TransportSettings::default() },
            TransportSettings { most_per_s: [(150, 1.0)].into(), ..TransportSettings::default() },
        ];
        let mut node = Node::new(NodeSettings { tcp, ..NodeSettings::default() });
        let [first, second, third, fourth] = [0, 1, 2, 3].map(|server| Peer::Tcp(Peer::number(server, 5)));
        for peer in [first, second, third, fourth] {
            node.connected(peer);
        }
        let gps = Entity::Gps.number();
        assert_eq!(node.recipients(at(0.0), 150, gps, Address::NULL), [second, third, fourth]);
        assert_eq!(node.recipients(at(0.1), 150, gps, Address::NULL), [second, fourth]);
        let other = Entity::Navigation.number();
        assert_eq!(node.recipients(at(0.1), 150, other, Address::NULL), [third, fourth]);
        // Answers go to all, whatever the lists say.
        assert_eq!(node.recipients(at(0.1), 150, other, CONSOLE), [first, second, third, fourth]);
        assert_eq!(node.tcp_but(second, 150), [third, fourth]);
    }

    #[test]
    fn without_dynamic_contacts_only_fixed_destinations_are_sent_to() {
        let fixed = SocketAddrV4::new([10, 0, 0, 7].into(), 6001);
        let static_destinations = vec![fixed];
        let settings =
            NodeSettings { dynamic_contacts: false, static_destinations, ..NodeSettings::default() };
        let mut node = Node::new(settings);
        assert_eq!(node.announced(at(0.0), CONSOLE, udp(6001), &announce()), Contact::Known);
        assert_eq!(node.heard(at(0.0), CONSOLE, udp(6001)), Contact::Known);
        assert_eq!(node.recipients(at(0.0), 500, 0, Address::NULL), [Peer::Udp(fixed)]);
    }

    #[test]
    fn limits_rates_on_udp_and_not_on_tcp() {
        let mut node = Node::new(NodeSettings::default());
        node.announced(at(0.0), CONSOLE, udp(6001), &announce());
        node.heard(at(0.0), CONSOLE, udp(6001));
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
