//! The server as an IMC node: discovery, and datagrams to and from the nodes that announced themselves.
//!
//! The first free of the discovery ports is listened on, the multicast group joined; our own announcement goes to
//! all of them every ten seconds, and by unicast to every node that announced itself to us. A node is a peer from
//! its first packet by an announced address until it was silent for the contact timeout. What comes from an
//! address that never announced itself is dropped, as DUNE does.

use super::Access;
use crate::config::Udp as UdpConfig;
use crate::relay::{Connection, Outbox, Relay};
use anyhow::Context as _;
use bytes::Bytes;
use hub::{Door, Incoming, Peer, Role, Sources};
use imc::messages::{Announce, Payload as _, SystemType};
use imc::{Address, PacketView};
use std::collections::BTreeMap;
use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, SocketAddrV4};
use std::sync::Arc;
use std::time::{Duration, Instant};
use tokio::net::UdpSocket;
use tokio::sync::OwnedSemaphorePermit;
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// The multicast group of IMC's discovery.
const GROUP: Ipv4Addr = Ipv4Addr::new(224, 0, 75, 69);
/// How often we announce ourselves.
const ANNOUNCE_EVERY: Duration = Duration::from_secs(10);
/// A node that was silent for this long is no contact any more; it is one again with its next packet.
const CONTACT: Duration = Duration::from_secs(30);
/// A node that was silent for this long must announce itself anew.
const KNOWN: Duration = Duration::from_mins(10);
/// How often silent nodes are looked for.
const FORGET_EVERY: Duration = Duration::from_secs(1);
/// Bytes that may wait for one node.
const OUTBOX_BYTES: usize = 256 * 1024;
/// Nodes that announced themselves and are remembered; further ones are not until an old one is forgotten.
const NODES_KEPT: usize = 256;
/// Datagrams that are taken before the hub gets them.
const BATCH: usize = 128;
/// Ports tried after the configured one.
const NEXT_PORTS: u16 = 5;

impl Known {
    /// Ends the contact, if there is one.
    async fn part(&mut self) {
        if let Some(contact) = self.contact.take() {
            tracing::info!(name = %self.name, "an IMC node is gone");
            contact.stop.cancel();
            contact.connection.leave().await;
        }
    }
}

/// The sockets.
pub(super) struct Node {
    data: Arc<UdpSocket>,
    discovery: Option<UdpSocket>,
    announce_ports: Vec<u16>,
    access: Access,
}

/// A node that announced itself.
struct Known {
    name: String,
    kind: SystemType,
    sockets: Vec<SocketAddrV4>,
    heard: Instant,
    contact: Option<Contact>,
    /// Whether it was said that there is no place for it.
    refused: bool,
}

/// A node that talks with us.
struct Contact {
    connection: Connection,
    /// Where its packets are sent.
    to: Vec<SocketAddrV4>,
    stop: CancellationToken,
    _place: OwnedSemaphorePermit,
}

impl Node {
    /// Opens the sockets.
    pub(super) fn open(listen: SocketAddr, config: &UdpConfig, access: Access) -> anyhow::Result<Self> {
        let IpAddr::V4(ip) = listen.ip() else {
            anyhow::bail!("doors.udp.listen: IMC's discovery knows IPv4 only, {listen} is no such address");
        };
        let last = if listen.port() == 0 { 0 } else { listen.port().saturating_add(NEXT_PORTS) };
        let data = (listen.port()..=last).find_map(|port| bind(ip, port).ok()).with_context(|| {
            format!("cannot listen on {listen} nor on the next ports: choose another by doors.udp.listen")
        })?;
        data.set_broadcast(true)?;
        let discovery = config.announce_ports.iter().find_map(|port| bind(Ipv4Addr::UNSPECIFIED, *port).ok());
        match &discovery {
            Some(socket) => {
                // Without a network there is no group to join; loopback and unicast still work.
                if let Err(error) = socket.join_multicast_v4(GROUP, Ipv4Addr::UNSPECIFIED) {
                    tracing::warn!(%error, "cannot join the discovery group {GROUP}");
                }
            }
            None if config.announce_ports.is_empty() => {}
            None => tracing::warn!("no discovery port is free: nodes must be told where this server is"),
        }
        let announce_ports = config.announce_ports.clone();
        Ok(Self { data: Arc::new(data), discovery, announce_ports, access })
    }

    /// Where datagrams are taken.
    pub(super) fn address(&self) -> SocketAddr {
        self.data.local_addr().unwrap_or_else(|_| (Ipv4Addr::UNSPECIFIED, 0).into())
    }

    /// Where announcements are taken.
    pub(super) fn announce_address(&self) -> Option<SocketAddr> {
        self.discovery.as_ref()?.local_addr().ok()
    }

    /// Takes part until `stop`.
    pub(super) async fn run(self, relay: Relay, tasks: TaskTracker, stop: CancellationToken) {
        let services = self.services();
        relay.look(move |hub, _| hub.set_services(&services)).await.ok();
        let mut party = Party { node: self, relay, tasks, known: BTreeMap::new() };
        let (mut data, mut discovery) = (vec![0; 65_536], vec![0; 65_536]);
        let mut announce = tokio::time::interval(ANNOUNCE_EVERY);
        let mut second = tokio::time::interval(FORGET_EVERY);
        loop {
            tokio::select! {
                () = stop.cancelled() => break,
                _ = announce.tick() => party.announce().await,
                _ = second.tick() => party.forget().await,
                received = party.node.data.recv_from(&mut data) => party.data(&mut data, received).await,
                received = from(party.node.discovery.as_ref(), &mut discovery) => {
                    party.discovered(&discovery, received).await;
                }
            }
        }
        for known in party.known.values_mut() {
            known.part().await;
        }
    }

    /// The services by which others reach us: each address of this host that they may see.
    fn services(&self) -> String {
        let SocketAddr::V4(at) = self.address() else { return String::new() };
        let mut hosts = vec![*at.ip()];
        if at.ip().is_unspecified() {
            hosts = [Some(Ipv4Addr::LOCALHOST), facing()].into_iter().flatten().collect();
        }
        let uri = |ip: &Ipv4Addr| format!("imc+udp://{ip}:{}/", at.port());
        hosts.iter().map(uri).collect::<Vec<_>>().join(";")
    }
}

/// The address that faces the network. Nothing is sent: connecting a datagram socket only chooses the interface.
fn facing() -> Option<Ipv4Addr> {
    let socket = std::net::UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).ok()?;
    socket.connect((GROUP, 30_100)).ok()?;
    match socket.local_addr().ok()?.ip() {
        IpAddr::V4(ip) if !ip.is_unspecified() && !ip.is_loopback() => Some(ip),
        _ => None,
    }
}

fn bind(ip: Ipv4Addr, port: u16) -> io::Result<UdpSocket> {
    let socket = std::net::UdpSocket::bind((ip, port))?;
    socket.set_nonblocking(true)?;
    UdpSocket::from_std(socket)
}

async fn from(socket: Option<&UdpSocket>, buffer: &mut [u8]) -> io::Result<(usize, SocketAddr)> {
    match socket {
        Some(socket) => socket.recv_from(buffer).await,
        None => std::future::pending().await,
    }
}

/// The node and those it knows.
struct Party {
    node: Node,
    relay: Relay,
    tasks: TaskTracker,
    known: BTreeMap<Address, Known>,
}

impl Party {
    /// Datagrams: the one that came and what else is there.
    async fn data(&mut self, buffer: &mut [u8], first: io::Result<(usize, SocketAddr)>) {
        let mut batches: BTreeMap<Address, Vec<Incoming>> = BTreeMap::new();
        let mut next = first;
        for _ in 0..BATCH {
            // An error is an earlier datagram's: its receiver was not there.
            if let Ok((length, from)) = next
                && let Ok(view) = PacketView::new(&buffer[..length])
            {
                if view.id() == Announce::ID {
                    self.announced(&view, from);
                }
                if self.is_known(view.src(), from.ip()) {
                    let packet = Bytes::copy_from_slice(&buffer[..length]);
                    batches.entry(view.src()).or_default().push(packet.into());
                } else {
                    metrics::counter!("lutra_refused_total", "door" => "udp").increment(1);
                    // An announcement that was refused is told already.
                    if view.id() != Announce::ID {
                        let why = "a datagram of a node that has not announced itself from there";
                        self.relay.ledger().refused(Door::Udp, from.ip(), why);
                    }
                }
            }
            match self.node.data.try_recv_from(buffer) {
                Err(error) if error.kind() == io::ErrorKind::WouldBlock => break,
                received => next = received,
            }
        }
        for (source, batch) in batches {
            self.give(source, batch).await;
        }
    }

    /// A datagram at the discovery port.
    async fn discovered(&mut self, buffer: &[u8], received: io::Result<(usize, SocketAddr)>) {
        let Ok((length, from)) = received else { return };
        let Ok(view) = PacketView::new(&buffer[..length]) else { return };
        if view.id() != Announce::ID || !self.announced(&view, from) {
            return;
        }
        let source = view.src();
        let packet = Bytes::copy_from_slice(view.bytes());
        self.give(source, vec![packet.into()]).await;
    }

    /// Takes an announcement in. Whether its node is one to talk with.
    fn announced(&mut self, view: &PacketView<'_>, from: SocketAddr) -> bool {
        let ours = self.relay.address() == view.src();
        if ours || view.src().is_everyone() {
            return false;
        }
        if !self.node.access.admits(from.ip()) {
            self.relay.ledger().refused(Door::Udp, from.ip(), "not in doors.udp.allow");
            return false;
        }
        let Ok(Some(announce)) = imc::decode::<Announce>(view) else { return false };
        let services = announce.services.to_str_lossy();
        let all = imc::services::parse(&services).filter(|service| service.scheme == "imc+udp");
        // Of the addresses that it says, the one it speaks from is the one we reach it by.
        let mut sockets: Vec<SocketAddrV4> = all.filter_map(|service| service.socket()).take(16).collect();
        sockets.sort_by_key(|socket| IpAddr::V4(*socket.ip()) != from.ip());
        if !sockets.iter().any(|socket| IpAddr::V4(*socket.ip()) == from.ip()) {
            return false;
        }
        if !self.known.contains_key(&view.src()) && self.known.len() >= NODES_KEPT {
            self.relay.ledger().refused(Door::Udp, from.ip(), "too many nodes have announced themselves");
            return false;
        }
        let name = announce.sys_name.to_str_lossy().chars().take(100).collect();
        let kind = announce.sys_type;
        let entry = self.known.entry(view.src());
        let known = entry.or_insert_with(|| Known {
            name: String::new(),
            kind,
            sockets: Vec::new(),
            heard: Instant::now(),
            contact: None,
            refused: false,
        });
        (known.name, known.kind, known.sockets) = (name, kind, sockets);
        true
    }

    fn is_known(&self, source: Address, ip: IpAddr) -> bool {
        self.known
            .get(&source)
            .is_some_and(|known| known.sockets.iter().any(|socket| IpAddr::V4(*socket.ip()) == ip))
    }

    /// Hands packets of a node to the hub; the first makes it a peer.
    async fn give(&mut self, source: Address, batch: Vec<Incoming>) {
        let Some(known) = self.known.get_mut(&source) else { return };
        known.heard = Instant::now();
        if known.contact.as_ref().is_some_and(|contact| contact.to != known.sockets) {
            // It announced other addresses: what waits is sent there from now on.
            known.part().await;
        }
        if known.contact.is_none() {
            let Some(place) = self.node.access.permit() else {
                if !std::mem::replace(&mut known.refused, true) {
                    tracing::warn!(name = %known.name, "refused at the UDP door: doors.udp.max_peers are connected");
                    let ip = known.sockets.first().map_or(Ipv4Addr::UNSPECIFIED, |socket| *socket.ip());
                    self.relay.ledger().refused(Door::Udp, ip.into(), "doors.udp.max_peers are connected");
                }
                return;
            };
            let role = if known.kind == SystemType::Ccu { Role::Console } else { Role::Vessel };
            let sources = Sources::Only(vec![source]);
            let peer = Peer { door: Door::Udp, role, name: known.name.clone(), sources };
            let Ok(connection) = self.relay.join(peer, OUTBOX_BYTES).await else { return };
            known.refused = false;
            tracing::info!(name = %known.name, %source, "an IMC node is here");
            let stop = CancellationToken::new();
            let to = known.sockets.clone();
            let receiver = to.clone();
            let outbox = Arc::clone(&connection.outbox);
            let socket = Arc::clone(&self.node.data);
            let ended = stop.clone();
            self.tasks.spawn(async move {
                ended.run_until_cancelled(send(socket, receiver, outbox)).await;
            });
            known.contact = Some(Contact { connection, to, stop, _place: place });
        }
        if let Some(contact) = &known.contact {
            contact.connection.give(batch).await.ok();
        }
    }

    /// Says who we are to everyone who may listen.
    async fn announce(&mut self) {
        let Ok(Some(packet)) = self.relay.look(hub::Hub::announcement).await else { return };
        let mut hosts = vec![Ipv4Addr::LOCALHOST];
        if !self.node.address().ip().is_loopback() {
            hosts.extend([GROUP, Ipv4Addr::BROADCAST]);
        }
        let known = self.known.values().flat_map(|known| &known.sockets).map(|socket| *socket.ip());
        hosts.extend(known);
        hosts.sort_unstable();
        hosts.dedup();
        for host in hosts {
            for port in self.node.announce_ports.iter().filter(|port| **port != 0) {
                // A host without a network cannot send to the group; that is no news every ten seconds.
                self.node.data.send_to(&packet, (host, *port)).await.ok();
            }
        }
    }

    /// Lets nodes go that were silent for long.
    async fn forget(&mut self) {
        for known in self.known.values_mut().filter(|known| known.heard.elapsed() >= CONTACT) {
            known.part().await;
        }
        self.known.retain(|_, known| known.heard.elapsed() < KNOWN);
    }
}

/// Sends what waits for a node to the first of its sockets that the network knows a way to.
async fn send(socket: Arc<UdpSocket>, to: Vec<SocketAddrV4>, outbox: Arc<Outbox>) {
    while let Ok(packets) = outbox.take().await {
        for packet in packets {
            for address in &to {
                if socket.send_to(&packet, address).await.is_ok() {
                    break;
                }
            }
        }
    }
}
