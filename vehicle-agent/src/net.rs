//! Sockets: announcements, datagrams, and a server of streams. Each socket has a thread that does nothing
//! but wait for it; what comes is handed to the one loop that owns the brain.
//!
//! Bounds: when the loop is behind, datagrams are dropped and counted, and streams wait. A client that does
//! not take its packets in time is disconnected rather than given gaps.

use anyhow::Context as _;
use imc::{Deframer, Frame};
use onboard::{Peer, Reachable};
use std::collections::BTreeMap;
use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, Shutdown, SocketAddr, SocketAddrV4, TcpListener, TcpStream, UdpSocket};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{Receiver, SyncSender, TrySendError, sync_channel};
use std::thread;
use std::time::Duration;

const GROUP: Ipv4Addr = Ipv4Addr::new(224, 0, 75, 69);
const EVENTS: usize = 1024;
const CLIENT_PACKETS: usize = 4096;
const CLIENTS: usize = 16;
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);

/// What came.
#[derive(Debug)]
pub(crate) enum Event {
    /// A packet.
    Packet(Peer, Vec<u8>),
    /// A client, and the way to it.
    Connected(u32, Client),
    /// A client is gone.
    Disconnected(u32),
}

/// The way to a client.
#[derive(Debug)]
pub(crate) struct Client {
    packets: SyncSender<Arc<[u8]>>,
    stream: TcpStream,
}

/// Where to listen.
#[derive(Debug, Clone)]
pub(crate) struct Ports {
    /// Interface.
    pub(crate) bind: Ipv4Addr,
    /// Datagrams; the next five are tried too. 0 lets the system choose.
    pub(crate) udp: u16,
    /// Streams; 0 lets the system choose.
    pub(crate) tcp: u16,
    /// Announcements: the first free one is listened on, all are sent to.
    pub(crate) announce: Vec<u16>,
}

/// The sockets.
#[derive(Debug)]
pub(crate) struct Net {
    udp: Arc<UdpSocket>,
    announce: Vec<u16>,
    bind: Ipv4Addr,
    pub(crate) reachable: Reachable,
    pub(crate) listening: String,
    pub(crate) events: Receiver<Event>,
    clients: BTreeMap<u32, Client>,
    dropped: Arc<AtomicU64>,
    /// Packets that could not be sent.
    pub(crate) unsent: u64,
}

impl Net {
    /// Opens all sockets and starts listening.
    pub(crate) fn open(ports: &Ports) -> anyhow::Result<Self> {
        let (sender, events) = sync_channel(EVENTS);
        let dropped = Arc::new(AtomicU64::new(0));
        let udp =
            first_free(ports.bind, ports.udp..=ports.udp.saturating_add(if ports.udp == 0 { 0 } else { 5 }))
                .with_context(|| format!("no free UDP port from {}", ports.udp))?;
        udp.set_broadcast(true).ok();
        let udp = Arc::new(udp);
        let udp_port = udp.local_addr()?.port();
        listen_udp("udp", Arc::clone(&udp), sender.clone(), Arc::clone(&dropped))?;
        let mut announce_port = 0;
        let free = ports.announce.iter().find_map(|port| UdpSocket::bind((ports.bind, *port)).ok());
        if let Some(socket) = free {
            announce_port = socket.local_addr()?.port();
            socket.join_multicast_v4(&GROUP, &Ipv4Addr::UNSPECIFIED).ok();
            listen_udp("announce", Arc::new(socket), sender.clone(), Arc::clone(&dropped))?;
        }
        let listener =
            TcpListener::bind((ports.bind, ports.tcp)).with_context(|| format!("TCP port {}", ports.tcp))?;
        let tcp_port = listener.local_addr()?.port();
        listen_tcp(listener, sender)?;
        let addresses = addresses(ports.bind);
        let at = |port| addresses.iter().map(|ip| SocketAddrV4::new(*ip, port)).collect::<Vec<_>>();
        Ok(Self {
            udp,
            announce: ports.announce.clone(),
            bind: ports.bind,
            reachable: Reachable { udp: at(udp_port), tcp: at(tcp_port) },
            listening: format!("udp={udp_port} tcp={tcp_port} announce={announce_port}"),
            events,
            clients: BTreeMap::new(),
            dropped,
            unsent: 0,
        })
    }

    /// Datagrams lost because the loop was behind.
    pub(crate) fn dropped(&self) -> u64 {
        self.dropped.load(Ordering::Relaxed)
    }

    pub(crate) fn connected(&mut self, number: u32, client: Client) {
        self.clients.insert(number, client);
    }

    pub(crate) fn disconnected(&mut self, number: u32) {
        self.clients.remove(&number);
    }

    /// Sends a packet to each of `to`.
    pub(crate) fn send(&mut self, bytes: &[u8], to: &[Peer]) {
        let mut shared: Option<Arc<[u8]>> = None;
        for peer in to {
            match peer {
                Peer::Udp(socket) => {
                    if self.udp.send_to(bytes, socket).is_err() {
                        self.unsent += 1;
                    }
                }
                Peer::Tcp(number) => {
                    let Some(client) = self.clients.get(number) else { continue };
                    let packet = shared.get_or_insert_with(|| bytes.into());
                    if let Err(TrySendError::Full(_)) = client.packets.try_send(Arc::clone(packet)) {
                        // Its reader ends by this and reports it gone.
                        client.stream.shutdown(Shutdown::Both).ok();
                    }
                }
            }
        }
    }

    /// Sends an announcement to all discovery ports: of this host, the group and, unless bound to loopback,
    /// everyone.
    pub(crate) fn announce(&mut self, bytes: &[u8]) {
        let mut hosts = vec![Ipv4Addr::LOCALHOST];
        if !self.bind.is_loopback() {
            hosts.extend([GROUP, Ipv4Addr::BROADCAST]);
        }
        for host in hosts {
            for port in self.announce.iter().filter(|port| **port != 0) {
                // A host without a network cannot send to the group; that is no news every ten seconds.
                self.udp.send_to(bytes, (host, *port)).ok();
            }
        }
    }
}

fn first_free(ip: Ipv4Addr, mut ports: impl Iterator<Item = u16>) -> Option<UdpSocket> {
    ports.find_map(|port| UdpSocket::bind((ip, port)).ok())
}

/// The addresses at which others reach this host: loopback, and the one that faces the network.
fn addresses(bind: Ipv4Addr) -> Vec<Ipv4Addr> {
    if !bind.is_unspecified() {
        return vec![bind];
    }
    let mut all = vec![Ipv4Addr::LOCALHOST];
    // Nothing is sent: connecting a datagram socket only chooses the interface.
    let facing = UdpSocket::bind((Ipv4Addr::UNSPECIFIED, 0))
        .and_then(|socket| socket.connect((GROUP, 30_100)).and_then(|()| socket.local_addr()));
    if let Ok(SocketAddr::V4(at)) = facing
        && !at.ip().is_unspecified()
        && !at.ip().is_loopback()
    {
        all.push(*at.ip());
    }
    all
}

fn listen_udp(
    name: &str,
    socket: Arc<UdpSocket>,
    events: SyncSender<Event>,
    dropped: Arc<AtomicU64>,
) -> anyhow::Result<()> {
    let work = move || {
        let mut buffer = vec![0; 65_536];
        loop {
            let Ok((length, SocketAddr::V4(from))) = socket.recv_from(&mut buffer) else { continue };
            match events.try_send(Event::Packet(Peer::Udp(from), buffer[..length].to_vec())) {
                Ok(()) => {}
                Err(TrySendError::Full(_)) => {
                    dropped.fetch_add(1, Ordering::Relaxed);
                }
                Err(TrySendError::Disconnected(_)) => return,
            }
        }
    };
    thread::Builder::new().name(name.to_owned()).spawn(work)?;
    Ok(())
}

fn listen_tcp(listener: TcpListener, events: SyncSender<Event>) -> anyhow::Result<()> {
    let work = move || {
        let alive = Arc::new(AtomicU64::new(0));
        for (number, stream) in (1..).zip(listener.incoming()) {
            let Ok(stream) = stream else { continue };
            if alive.load(Ordering::Relaxed) >= CLIENTS as u64 {
                continue;
            }
            let alive = Arc::clone(&alive);
            if serve(number, stream, events.clone(), alive).is_err() {
                return;
            }
        }
    };
    thread::Builder::new().name("tcp".to_owned()).spawn(work)?;
    Ok(())
}

/// One thread that writes to a client and one that reads from it.
fn serve(
    number: u32,
    stream: TcpStream,
    events: SyncSender<Event>,
    alive: Arc<AtomicU64>,
) -> anyhow::Result<()> {
    stream.set_nodelay(true).ok();
    stream.set_write_timeout(Some(WRITE_TIMEOUT)).ok();
    let (packets, queue) = sync_channel::<Arc<[u8]>>(CLIENT_PACKETS);
    let (mut reader, mut writer) = (stream.try_clone()?, stream.try_clone()?);
    alive.fetch_add(1, Ordering::Relaxed);
    events.send(Event::Connected(number, Client { packets, stream }))?;
    thread::Builder::new().name(format!("tcp-{number}-out")).spawn(move || {
        for packet in queue {
            if writer.write_all(&packet).is_err() {
                break;
            }
        }
        writer.shutdown(Shutdown::Both).ok();
    })?;
    thread::Builder::new().name(format!("tcp-{number}-in")).spawn(move || {
        let (mut deframer, mut buffer) = (Deframer::new(), vec![0; 16_384]);
        'connection: while let Ok(length @ 1..) = reader.read(&mut buffer) {
            deframer.push(&buffer[..length]);
            while let Some(frame) = deframer.next_frame() {
                if let Frame::Packet { view, .. } = frame
                    && events.send(Event::Packet(Peer::Tcp(number), view.bytes().to_vec())).is_err()
                {
                    break 'connection;
                }
            }
        }
        alive.fetch_sub(1, Ordering::Relaxed);
        events.send(Event::Disconnected(number)).ok();
    })?;
    Ok(())
}
