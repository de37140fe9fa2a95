//! Sockets: announcements, datagrams, and TCP servers. Each socket has a thread that only waits for it; received packets
//! are queued in the [`Inbox`] of the loop that owns the brain. Transports that are off in the configuration are not
//! opened.

mod clients;
mod inbox;

pub(crate) use inbox::{Event, Inbox, Losses};

use anyhow::Context as _;
use clients::Clients;
use imc::Address;
use onboard::{Peer, Reachable};
use rustix::net::SendFlags;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, TcpListener, UdpSocket};
use std::sync::Arc;
use std::thread;
use std::time::Duration;

/// Ports after the configured one that are tried for datagrams.
const NEXT_PORTS: u16 = 5;
/// Pause after a failed receive, so that a broken socket does not occupy a processor.
const RECEIVE_PAUSE: Duration = Duration::from_millis(10);

/// Where to listen; `None` or empty if off.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Ports {
    /// Interface.
    pub(crate) bind: Ipv4Addr,
    /// Datagrams; the next five are tried too.
    pub(crate) udp: Option<Listen>,
    /// Servers of streams.
    pub(crate) tcp: Vec<Listen>,
    /// Announcements.
    pub(crate) announce: Option<AnnouncePorts>,
}

/// A socket to listen on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Listen {
    /// Its port; 0 lets the system choose.
    pub(crate) port: u16,
    /// Whether the announcement names it.
    pub(crate) announced: bool,
}

/// Where to announce.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct AnnouncePorts {
    /// Announcements are received on the first free one, and sent to all.
    pub(crate) ports: Vec<u16>,
    /// The multicast group.
    pub(crate) group: Ipv4Addr,
    /// Further destinations of announcements.
    pub(crate) hosts: Vec<Ipv4Addr>,
}

/// The sockets.
#[derive(Debug)]
pub(crate) struct Net {
    udp: Option<Arc<UdpSocket>>,
    /// For announcements.
    announcer: Option<Arc<UdpSocket>>,
    announce_to: Vec<SocketAddrV4>,
    clients: Arc<Clients>,
    pub(crate) reachable: Reachable,
    pub(crate) listening: String,
    pub(crate) inbox: Arc<Inbox>,
    /// Packets that could not be sent.
    pub(crate) unsent: u64,
}

impl Net {
    /// Opens all sockets of the system with this address and starts listening.
    pub(crate) fn open(ports: &Ports, own: Address) -> anyhow::Result<Self> {
        let inbox = Arc::new(Inbox::new(own));
        let addresses = addresses(ports.bind);
        let at = |port| addresses.iter().map(|ip| SocketAddrV4::new(*ip, port)).collect::<Vec<_>>();
        let mut reachable = Reachable::default();
        let name = |port: Option<u16>| port.map_or_else(|| "off".to_owned(), |port| port.to_string());

        let udp = ports.udp.map(|udp| bind_udp(ports.bind, udp.port)).transpose()?;
        let udp_port = udp.as_ref().map(|udp| udp.local_addr()).transpose()?.map(|at| at.port());
        if let Some(socket) = &udp {
            listen_udp("udp", Arc::clone(socket), Arc::clone(&inbox))?;
        }
        let announced = ports.udp.is_some_and(|udp| udp.announced);
        reachable.udp = udp_port.filter(|_| announced).map(at).unwrap_or_default();

        let (announcer, announce_port) = match &ports.announce {
            Some(announce) => {
                let port = listen_announce(ports.bind, announce, &inbox)?;
                let socket = match &udp {
                    Some(socket) => Arc::clone(socket),
                    None => bind_udp(ports.bind, 0)?,
                };
                (Some(socket), port)
            }
            None => (None, None),
        };
        let announce_to = ports.announce.iter().flat_map(|announce| {
            let pairs =
                announce.hosts.iter().flat_map(|host| announce.ports.iter().map(|port| (*host, *port)));
            pairs.filter(|(_, port)| *port != 0).map(|(host, port)| SocketAddrV4::new(host, port))
        });

        let clients = Arc::new(Clients::default());
        let mut tcp_ports = Vec::new();
        for (server, Listen { port, announced }) in (0..).zip(&ports.tcp) {
            let listener =
                TcpListener::bind((ports.bind, *port)).with_context(|| format!("TCP port {port}"))?;
            let port = listener.local_addr()?.port();
            clients::listen(server, listener, Arc::clone(&clients), Arc::clone(&inbox))?;
            tcp_ports.push(port.to_string());
            reachable.tcp.extend(at(port).into_iter().filter(|_| *announced));
        }
        let tcp = if tcp_ports.is_empty() { name(None) } else { tcp_ports.join(",") };
        Ok(Self {
            udp,
            announcer,
            announce_to: announce_to.collect(),
            clients,
            reachable,
            listening: format!("udp={} tcp={tcp} announce={}", name(udp_port), name(announce_port)),
            inbox,
            unsent: 0,
        })
    }

    /// Sends a packet to each of `to`; never waits.
    pub(crate) fn send(&mut self, bytes: &[u8], to: &[Peer]) {
        let mut shared: Option<Arc<[u8]>> = None;
        for peer in to {
            match (peer, &self.udp) {
                (Peer::Udp(socket), Some(udp)) => {
                    if !send_now(udp, bytes, *socket) {
                        self.unsent += 1;
                    }
                }
                (Peer::Udp(_), None) => {}
                (Peer::Tcp(number), _) => {
                    self.clients.send(*number, shared.get_or_insert_with(|| bytes.into()));
                }
            }
        }
    }

    /// Sends an announcement to all discovery ports.
    pub(crate) fn announce(&mut self, bytes: &[u8]) {
        let Some(socket) = &self.announcer else { return };
        for to in &self.announce_to {
            // A host without a network cannot send to the group; do not report that every ten seconds.
            send_now(socket, bytes, *to);
        }
    }
}

/// Sends a datagram if the system takes it at once.
fn send_now(socket: &UdpSocket, bytes: &[u8], to: SocketAddrV4) -> bool {
    rustix::net::sendto(socket, bytes, SendFlags::DONTWAIT, &to).is_ok()
}

fn bind_udp(ip: Ipv4Addr, port: u16) -> anyhow::Result<Arc<UdpSocket>> {
    let last = if port == 0 { 0 } else { port.saturating_add(NEXT_PORTS) };
    let free = (port..=last).find_map(|port| UdpSocket::bind((ip, port)).ok());
    let socket = free.with_context(|| format!("no free UDP port from {port}"))?;
    socket.set_broadcast(true).ok();
    Ok(Arc::new(socket))
}

/// Listens on the first free port; returns it.
fn listen_announce(
    bind: Ipv4Addr,
    announce: &AnnouncePorts,
    inbox: &Arc<Inbox>,
) -> anyhow::Result<Option<u16>> {
    let free = announce.ports.iter().find_map(|port| UdpSocket::bind((bind, *port)).ok());
    let Some(socket) = free else {
        tracing::warn!(ports = ?announce.ports, "no port for announcements is free; announcements are not heard");
        return Ok(None);
    };
    let port = socket.local_addr()?.port();
    socket.join_multicast_v4(&announce.group, &Ipv4Addr::UNSPECIFIED).ok();
    listen_udp("announce", Arc::new(socket), Arc::clone(inbox))?;
    Ok(Some(port))
}

/// The addresses at which others reach this host: loopback, and the one that faces the network.
fn addresses(bind: Ipv4Addr) -> Vec<Ipv4Addr> {
    if !bind.is_unspecified() {
        return vec![bind];
    }
    let mut all = vec![Ipv4Addr::LOCALHOST];
    // Nothing is sent: connecting a datagram socket only chooses the interface.
    let facing = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0)).and_then(|socket| {
        socket.connect((Ipv4Addr::new(224, 0, 75, 69), 30_100)).and_then(|()| socket.local_addr())
    });
    if let Ok(SocketAddr::V4(at)) = facing
        && !at.ip().is_unspecified()
        && !at.ip().is_loopback()
    {
        all.push(*at.ip());
    }
    all
}

fn listen_udp(name: &str, socket: Arc<UdpSocket>, inbox: Arc<Inbox>) -> anyhow::Result<()> {
    let work = move || {
        let mut buffer = vec![0; 65_536];
        loop {
            match socket.recv_from(&mut buffer) {
                Ok((length, SocketAddr::V4(from))) => inbox.packet(Peer::Udp(from), &buffer[..length]),
                // A peer that has gone is also reported here.
                Ok(_) | Err(_) => thread::sleep(RECEIVE_PAUSE),
            }
        }
    };
    thread::Builder::new().name(name.to_owned()).spawn(work)?;
    Ok(())
}
