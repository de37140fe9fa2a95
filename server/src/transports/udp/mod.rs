//! The server as an IMC node: discovery, and datagrams to and from the nodes that announced themselves.
//!
//! The server listens on the first free discovery port and joins the multicast group; its own announcement goes to all
//! discovery ports every ten seconds, and by unicast to every announced node. A node is a peer from its first packet from
//! an announced address and port until it was silent for the contact timeout. Packets from a socket that was not announced
//! are dropped, as DUNE does; announced nodes are kept over a restart ([`memory`]).
//!
//! A datagram belongs to the node of its socket, not of its IMC source: a DUNE forwards packets of other consoles on its
//! host from its own socket, which are echoes. If several nodes announce the same IMC address, it belongs to the first that
//! sent packets, as long as that continues to send.
//!
//! Every queue of datagrams counts its losses: the kernel's ([`drops`]), then the [`reader`]'s inbox.

mod drops;
mod memory;
mod reader;

use super::Access;
use crate::config::Udp as UdpConfig;
use anyhow::Context as _;
use api::say;
use drops::Counted;
use hub::{Incoming, Peer, Role, Sources, Transport};
use imc::messages::{Announce, Payload as _, SystemType};
use imc::{Address, PacketView};
use memory::{Announced, Memory};
use reader::{Datagram, Inbox};
use shore::owners::Owners;
use shore::router::{Connection, Outbox, Router, Whose};
use std::collections::BTreeMap;
use std::io;
use std::net::{IpAddr, Ipv4Addr, SocketAddr, SocketAddrV4};
use std::path::Path;
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
/// A node that was silent for this long is no longer a contact, until its next packet.
const CONTACT: Duration = Duration::from_secs(30);
/// A node that was silent for this long must announce itself again.
const KNOWN: Duration = Duration::from_mins(10);
/// How often silent nodes are removed.
const FORGET_EVERY: Duration = Duration::from_secs(1);
/// Bytes that may be queued for one node.
const OUTBOX_BYTES: usize = 256 * 1024;
/// Most announced nodes that are kept; further ones are ignored until an old one is removed.
const NODES_KEPT: usize = 256;
/// Packets that the hub gets at once.
const BATCH: usize = 256;
/// Requested receive buffer of the kernel (bytes): some seconds of many vessels.
const KERNEL_BYTES: usize = 8 << 20;
/// A node that sent a packet within this time is present, and no other takes its IMC address. Vessels send each second.
const STEADY: Duration = Duration::from_secs(5);
/// Ports tried after the configured one.
const NEXT_PORTS: u16 = 5;

impl Known {
    fn new(announced: &Announced) -> Self {
        let Announced { name, sockets, .. } = announced.clone();
        let (heard, kind) = (Instant::now(), announced.kind());
        Self { name, kind, sockets, heard, contact: None, refused: false }
    }

    /// Stores its announcement; returns whether that is new.
    fn is_now(&mut self, announced: &Announced) -> bool {
        let Announced { name, sockets, .. } = announced.clone();
        let (before, now) = ((&self.name, self.kind, &self.sockets), (&name, announced.kind(), &sockets));
        let differs = before != now;
        (self.name, self.kind, self.sockets) = (name, announced.kind(), sockets);
        differs
    }

    fn announced(&self, address: Address) -> Announced {
        let (name, sockets) = (self.name.clone(), self.sockets.clone());
        Announced { address: address.0, name, kind: self.kind.value(), sockets }
    }

    /// Whether the announcement of these sockets is from another node than the present contact.
    fn is_another(&self, sockets: &[SocketAddrV4], from: IpAddr) -> bool {
        let speaks = self.contact.is_some() && self.heard.elapsed() < STEADY;
        let is_its_own =
            |socket: &SocketAddrV4| IpAddr::V4(*socket.ip()) == from && self.sockets.contains(socket);
        speaks && !sockets.iter().any(is_its_own)
    }

    /// Its name and address, for people.
    fn title(&self) -> String {
        self.sockets.first().map_or_else(|| self.name.clone(), |socket| format!("{} at {socket}", self.name))
    }

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
    data: std::net::UdpSocket,
    discovery: Option<std::net::UdpSocket>,
    announce_ports: Vec<u16>,
    access: Access,
    memory: Memory,
}

/// A node that announced itself.
struct Known {
    name: String,
    kind: SystemType,
    sockets: Vec<SocketAddrV4>,
    heard: Instant,
    contact: Option<Contact>,
    /// Whether it was reported that there is no place for it.
    refused: bool,
}

/// A node in contact.
struct Contact {
    connection: Connection,
    /// Where its packets are sent.
    to: Vec<SocketAddrV4>,
    stop: CancellationToken,
    _place: OwnedSemaphorePermit,
}

impl Node {
    /// Opens the sockets.
    pub(super) fn open(
        listen: SocketAddr,
        config: &UdpConfig,
        access: Access,
        folder: &Path,
    ) -> anyhow::Result<Self> {
        let IpAddr::V4(ip) = listen.ip() else {
            anyhow::bail!(
                "transports.udp.listen: IMC's discovery knows IPv4 only, {listen} is no such address"
            );
        };
        let last = if listen.port() == 0 { 0 } else { listen.port().saturating_add(NEXT_PORTS) };
        let data = (listen.port()..=last).find_map(|port| bind(ip, port).ok()).with_context(|| {
            format!(
                "cannot listen on {listen} nor on the next ports: choose another by transports.udp.listen"
            )
        })?;
        data.set_broadcast(true)?;
        let discovery = config.announce_ports.iter().find_map(|port| bind(Ipv4Addr::UNSPECIFIED, *port).ok());
        match &discovery {
            Some(socket) => {
                // Without a network there is no group to join; loopback and unicast still work.
                if let Err(error) = socket.join_multicast_v4(&GROUP, &Ipv4Addr::UNSPECIFIED) {
                    tracing::warn!(%error, "cannot join the discovery group {GROUP}");
                }
            }
            None if config.announce_ports.is_empty() => {}
            None => tracing::warn!("no discovery port is free: nodes must be told where this server is"),
        }
        widen(&data);
        let announce_ports = config.announce_ports.clone();
        Ok(Self { data, discovery, announce_ports, access, memory: Memory::open(folder) })
    }

    /// Address for datagrams.
    pub(super) fn address(&self) -> SocketAddr {
        self.data.local_addr().unwrap_or_else(|_| (Ipv4Addr::UNSPECIFIED, 0).into())
    }

    /// Address for announcements.
    pub(super) fn announce_address(&self) -> Option<SocketAddr> {
        self.discovery.as_ref()?.local_addr().ok()
    }

    /// Takes part until `stop`.
    pub(super) async fn run(
        self,
        router: Router,
        tasks: TaskTracker,
        owners: Owners,
        stop: CancellationToken,
    ) {
        let services = self.services();
        router.set_services(services).await.ok();
        let mut party = match Party::join(self, router.clone(), tasks, &owners, stop.clone()) {
            Ok(party) => party,
            Err(error) => {
                tracing::error!(%error, "the UDP transport cannot be served");
                let what = say("cannot be served: {error}").with("error", error);
                return router.ledger().failed(Transport::Udp, Whose::Transport, what);
            }
        };
        let inbox = Arc::clone(&party.inbox);
        let mut announce = tokio::time::interval(ANNOUNCE_EVERY);
        let mut second = tokio::time::interval(FORGET_EVERY);
        loop {
            tokio::select! {
                () = stop.cancelled() => break,
                _ = announce.tick() => party.announce().await,
                _ = second.tick() => {
                    party.forget().await;
                    party.count_lost();
                }
                datagrams = inbox.take() => party.take(datagrams).await,
            }
            party.remember();
        }
        for known in party.known.values_mut() {
            known.part().await;
        }
        party.memory.close().await;
    }

    /// The services to announce: each address of this host that others may reach.
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

fn bind(ip: Ipv4Addr, port: u16) -> io::Result<std::net::UdpSocket> {
    let socket = std::net::UdpSocket::bind((ip, port))?;
    socket.set_nonblocking(true)?;
    Ok(socket)
}

/// Requests a large receive buffer for bursts, and logs how to permit it if the system does not.
fn widen(socket: &std::net::UdpSocket) {
    let options = socket2::SockRef::from(socket);
    options.set_recv_buffer_size(KERNEL_BYTES).ok();
    // Linux doubles the value for its own bookkeeping.
    let granted_kib = options.recv_buffer_size().unwrap_or_default() / 2 / 1_024;
    let asked_kib = KERNEL_BYTES / 1_024;
    if granted_kib < asked_kib {
        tracing::warn!(
            granted_kib,
            asked_kib,
            "bursts of datagrams may be lost: the system gives the UDP transport a smaller buffer than it asks for; \
             set net.core.rmem_max = {KERNEL_BYTES} (sysctl)"
        );
    } else {
        tracing::info!(granted_kib, "the UDP transport's buffer in the kernel");
    }
}

/// This node and the nodes that it knows.
struct Party {
    /// For sending; the reader's thread receives on it.
    socket: Arc<UdpSocket>,
    inbox: Arc<Inbox>,
    counted: Option<Counted>,
    address: SocketAddr,
    announce_ports: Vec<u16>,
    access: Access,
    memory: Memory,
    router: Router,
    tasks: TaskTracker,
    known: BTreeMap<Address, Known>,
    /// Whether the known nodes differ from the file.
    changed: bool,
}

impl Party {
    fn join(
        node: Node,
        router: Router,
        tasks: TaskTracker,
        owners: &Owners,
        stop: CancellationToken,
    ) -> io::Result<Self> {
        let (address, counted) = (node.address(), Counted::of(&node.data));
        let Node { data, discovery, announce_ports, access, memory } = node;
        let reader::Sockets { data: socket, inbox } = reader::start(data, discovery, owners, stop)?;
        let admitted =
            |node: &&Announced| node.sockets.iter().any(|socket| access.admits(IpAddr::V4(*socket.ip())));
        let known = memory.nodes().iter().filter(admitted).take(NODES_KEPT);
        let known = known.map(|node| (node.address(), Known::new(node))).collect();
        Ok(Self {
            socket,
            inbox,
            counted,
            address,
            announce_ports,
            access,
            memory,
            router,
            tasks,
            known,
            changed: false,
        })
    }

    /// Processes received datagrams, in order.
    async fn take(&mut self, datagrams: impl IntoIterator<Item = Datagram>) {
        let mut batches: BTreeMap<Address, Vec<Incoming>> = BTreeMap::new();
        for Datagram { from, bytes, discovery } in datagrams {
            let Ok(view) = PacketView::new(&bytes) else { continue };
            let announces = view.id() == Announce::ID;
            let welcome = announces && self.announced(&view, from);
            let node = match (welcome, discovery) {
                // Nodes may announce themselves from a socket that serves nothing else.
                (true, _) => Some(view.src()),
                (false, true) => None,
                (false, false) => self.node_at(view.src(), from),
            };
            if let Some(node) = node {
                let batch = batches.entry(node).or_default();
                batch.push(bytes.into());
                if batch.len() >= BATCH {
                    let batch = std::mem::take(batch);
                    self.give(node, batch).await;
                }
            } else if !discovery {
                metrics::counter!("lutra_refused_total", "transport" => "udp").increment(1);
                // A refused announcement is reported already.
                if !announces {
                    let why = say("a datagram of a node that has not announced itself from there");
                    self.router.ledger().refused(Transport::Udp, from.ip(), why);
                }
            }
        }
        for (node, batch) in batches.into_iter().filter(|(_, batch)| !batch.is_empty()) {
            self.give(node, batch).await;
        }
    }

    /// The node that a socket belongs to: the packet's source if that announced it, else the node that did.
    fn node_at(&self, source: Address, from: SocketAddr) -> Option<Address> {
        let SocketAddr::V4(from) = from else { return None };
        let owns = |known: &Known| known.sockets.contains(&from);
        if self.known.get(&source).is_some_and(owns) {
            return Some(source);
        }
        self.known.iter().find(|(_, known)| owns(known)).map(|(address, _)| *address)
    }

    /// Processes an announcement. Returns whether its node is accepted.
    fn announced(&mut self, view: &PacketView<'_>, from: SocketAddr) -> bool {
        let ours = self.router.address() == view.src();
        if ours || view.src().is_everyone() {
            return false;
        }
        if !self.access.admits(from.ip()) {
            self.router.ledger().refused(Transport::Udp, from.ip(), say("not in transports.udp.allow"));
            return false;
        }
        let Ok(Some(announce)) = imc::decode::<Announce>(view) else { return false };
        let services = announce.services.to_str_lossy();
        let all = imc::services::parse(&services).filter(|service| service.scheme == "imc+udp");
        // Of the announced addresses, the one that it sends from comes first: it is known to be reachable.
        let mut sockets: Vec<SocketAddrV4> = all.filter_map(|service| service.socket()).take(16).collect();
        sockets.sort_by_key(|socket| IpAddr::V4(*socket.ip()) != from.ip());
        if !sockets.iter().any(|socket| IpAddr::V4(*socket.ip()) == from.ip()) {
            return false;
        }
        if !self.known.contains_key(&view.src()) && self.known.len() >= NODES_KEPT {
            self.router.ledger().refused(
                Transport::Udp,
                from.ip(),
                say("too many nodes have announced themselves"),
            );
            return false;
        }
        let name: String = announce.sys_name.to_str_lossy().chars().take(100).collect();
        let announced = Announced { address: view.src().0, name, kind: announce.sys_type.value(), sockets };
        match self.known.get_mut(&view.src()) {
            Some(known) if known.is_another(&announced.sockets, from.ip()) => {
                let there = known.sockets.first().map(SocketAddrV4::to_string).unwrap_or_default();
                let why = say("{address} is {name} at {there}, which is still speaking")
                    .with("address", view.src())
                    .with("name", &known.name)
                    .with("there", there);
                self.router.ledger().refused(Transport::Udp, from.ip(), why);
                return false;
            }
            Some(known) => self.changed |= known.is_now(&announced),
            None => {
                self.known.insert(view.src(), Known::new(&announced));
                self.changed = true;
            }
        }
        true
    }

    /// Passes packets of a node to the hub; the first makes it a peer.
    async fn give(&mut self, source: Address, batch: Vec<Incoming>) {
        let Some(known) = self.known.get_mut(&source) else { return };
        known.heard = Instant::now();
        if known.contact.as_ref().is_some_and(|contact| contact.to != known.sockets) {
            // It announced other addresses: queued packets are sent there from now on.
            known.part().await;
        }
        if known.contact.is_none() {
            let Some(place) = self.access.permit() else {
                if !std::mem::replace(&mut known.refused, true) {
                    tracing::warn!(name = %known.name, "refused at the UDP transport: transports.udp.max_peers are connected");
                    let ip = known.sockets.first().map_or(Ipv4Addr::UNSPECIFIED, |socket| *socket.ip());
                    self.router.ledger().refused(
                        Transport::Udp,
                        ip.into(),
                        say("transports.udp.max_peers are connected"),
                    );
                }
                return;
            };
            let role = if known.kind == SystemType::Ccu { Role::Console } else { Role::Vessel };
            let sources = Sources::Only(vec![source]);
            let peer = Peer { transport: Transport::Udp, role, name: known.title(), sources };
            let Ok(connection) = self.router.join(peer, OUTBOX_BYTES).await else { return };
            known.refused = false;
            tracing::info!(name = %known.name, %source, "an IMC node is here");
            let stop = CancellationToken::new();
            let to = known.sockets.clone();
            let receiver = to.clone();
            let outbox = Arc::clone(&connection.outbox);
            let socket = Arc::clone(&self.socket);
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

    /// Sends our announcement to all.
    async fn announce(&mut self) {
        let Ok(Some(packet)) = self.router.announcement().await else { return };
        let mut hosts = vec![Ipv4Addr::LOCALHOST];
        if !self.address.ip().is_loopback() {
            hosts.extend([GROUP, Ipv4Addr::BROADCAST]);
        }
        let known = self.known.values().flat_map(|known| &known.sockets).map(|socket| *socket.ip());
        hosts.extend(known);
        hosts.sort_unstable();
        hosts.dedup();
        for host in hosts {
            for port in self.announce_ports.iter().filter(|port| **port != 0) {
                // A host without a network cannot send to the group; do not report that every ten seconds.
                self.socket.send_to(&packet, (host, *port)).await.ok();
            }
        }
    }

    /// Removes nodes that were silent for long.
    async fn forget(&mut self) {
        for known in self.known.values_mut().filter(|known| known.heard.elapsed() >= CONTACT) {
            known.part().await;
        }
        let before = self.known.len();
        self.known.retain(|_, known| known.heard.elapsed() < KNOWN);
        self.changed |= self.known.len() < before;
    }

    /// Reports losses in the kernel and in the inbox.
    fn count_lost(&self) {
        let (kernel, here) =
            (self.counted.and_then(Counted::drops).unwrap_or_default(), self.inbox.dropped());
        metrics::counter!("lutra_udp_lost_total", "where" => "kernel").absolute(kernel);
        metrics::counter!("lutra_udp_lost_total", "where" => "server").absolute(here);
        self.router.ledger().lost(Transport::Udp, kernel + here);
    }

    /// Saves the known nodes for the next start.
    fn remember(&mut self) {
        if self.changed {
            let known = &self.known;
            self.changed =
                !self.memory.keep(|| known.iter().map(|(at, known)| known.announced(*at)).collect());
        }
    }
}

/// Sends queued packets to the first of a node's sockets that is reachable.
async fn send(socket: Arc<UdpSocket>, to: Vec<SocketAddrV4>, outbox: Arc<Outbox>) {
    loop {
        let Ok(packets) = outbox.take_packets().await else {
            tracing::error!(?to, "too much at once for an IMC node: what waited for it is lost");
            outbox.reopen();
            continue;
        };
        for packet in packets {
            for address in &to {
                if socket.send_to(&packet, address).await.is_ok() {
                    break;
                }
            }
        }
    }
}
