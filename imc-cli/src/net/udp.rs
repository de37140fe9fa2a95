//! UDP: one packet a datagram.

use super::{Link, peer};
use crate::sink::{Flow, Sink};
use anyhow::{Context as _, bail};
use std::io;
use std::net::{Ipv4Addr, SocketAddr, SocketAddrV4, UdpSocket};
use std::ops::RangeInclusive;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, RecvTimeoutError, SyncSender, sync_channel};
use std::time::Duration;

/// Where announcements are heard: systems take the first port that is free.
pub(crate) const ANNOUNCE_PORTS: RangeInclusive<u16> = 30_100..=30_104;
/// The group that announcements are sent to.
pub(crate) const ANNOUNCE_GROUP: Ipv4Addr = Ipv4Addr::new(224, 0, 75, 69);
/// Where a DUNE hears packets unless configured otherwise.
pub(crate) const VEHICLE_PORT: u16 = 6002;
/// Most queued datagrams; beyond that the system's own buffer fills and then drops.
const QUEUE: usize = 1024;

/// A datagram and its sender.
pub(crate) struct Datagram {
    pub(crate) bytes: Vec<u8>,
    pub(crate) from: SocketAddr,
}

/// Our socket, destinations, and the datagrams received on it and on others.
pub(crate) struct UdpLink {
    socket: Arc<UdpSocket>,
    destinations: Vec<SocketAddrV4>,
    queue: Receiver<io::Result<Datagram>>,
    sender: SyncSender<io::Result<Datagram>>,
}

impl UdpLink {
    /// Starts to receive on a socket.
    ///
    /// # Errors
    /// When no thread can be started.
    pub(crate) fn new(socket: UdpSocket) -> anyhow::Result<Self> {
        let (sender, queue) = sync_channel(QUEUE);
        let link = Self { socket: Arc::new(socket), destinations: Vec::new(), queue, sender };
        hear(Arc::clone(&link.socket), link.sender.clone())?;
        Ok(link)
    }

    /// Receives on another socket too.
    ///
    /// # Errors
    /// When no thread can be started.
    pub(crate) fn hear_also(&self, socket: UdpSocket) -> anyhow::Result<()> {
        hear(Arc::new(socket), self.sender.clone())
    }

    /// Sends every packet there too.
    pub(crate) fn add_destination(&mut self, to: SocketAddrV4) {
        self.destinations.push(to);
    }

    /// The own port.
    ///
    /// # Errors
    /// When the system does not report it.
    pub(crate) fn port(&self) -> io::Result<u16> {
        Ok(self.socket.local_addr()?.port())
    }

    /// Sends one packet to one destination.
    ///
    /// # Errors
    /// When the system refuses.
    pub(crate) fn send_to(&self, packet: &[u8], to: SocketAddrV4) -> anyhow::Result<()> {
        match self.socket.send_to(packet, to) {
            Ok(_) => Ok(()),
            Err(error) if error.kind() == io::ErrorKind::PermissionDenied => Err(error).with_context(|| {
                format!("cannot send to {to}: if it is a broadcast address, add --broadcast")
            }),
            Err(error) => Err(error).with_context(|| format!("cannot send {} bytes to {to}", packet.len())),
        }
    }

    /// The next datagram, if one comes in time.
    ///
    /// # Errors
    /// When a socket fails.
    pub(crate) fn next(&self, wait: Duration) -> anyhow::Result<Option<Datagram>> {
        match self.queue.recv_timeout(wait) {
            Ok(Ok(datagram)) => Ok(Some(datagram)),
            Ok(Err(error)) => Err(error).context("cannot receive by UDP"),
            Err(RecvTimeoutError::Timeout) => Ok(None),
            Err(RecvTimeoutError::Disconnected) => bail!("cannot receive by UDP any more"),
        }
    }
}

impl Link for UdpLink {
    fn send(&mut self, packet: &[u8]) -> anyhow::Result<()> {
        self.destinations.iter().try_for_each(|to| self.send_to(packet, *to))
    }

    fn receive(&mut self, wait: Duration, sink: &mut Sink<'_>) -> anyhow::Result<Flow> {
        let Some(datagram) = self.next(wait)? else { return Ok(Flow::More) };
        let flow = sink.datagram(&datagram.bytes, &datagram.from.to_string())?;
        sink.flush()?;
        Ok(flow)
    }

    fn close(&mut self) {}
}

/// Queues what a socket receives, until the link is dropped or the socket fails.
fn hear(socket: Arc<UdpSocket>, sender: SyncSender<io::Result<Datagram>>) -> anyhow::Result<()> {
    let receive = move || {
        let mut buffer = vec![0; 1 << 16];
        loop {
            let received = match socket.recv_from(&mut buffer) {
                Ok((count, from)) => Ok(Datagram { bytes: buffer[..count].to_vec(), from }),
                // The ICMP error of an earlier datagram, not a failure of this socket.
                Err(error) if is_bounce(&error) => continue,
                Err(error) => Err(error),
            };
            let failed = received.is_err();
            if sender.send(received).is_err() || failed {
                return;
            }
        }
    };
    std::thread::Builder::new().name("udp".to_owned()).spawn(receive).context("cannot start a thread")?;
    Ok(())
}

fn is_bounce(error: &io::Error) -> bool {
    use io::ErrorKind::{ConnectionRefused, ConnectionReset, Interrupted};
    matches!(error.kind(), ConnectionRefused | ConnectionReset | Interrupted)
}

/// A socket on the first port that is free.
///
/// # Errors
/// When none is, or the address is not this computer's.
pub(crate) fn bind_first(at: Ipv4Addr, ports: RangeInclusive<u16>) -> anyhow::Result<UdpSocket> {
    let place = format!("cannot listen on {at}, ports {} to {}", ports.start(), ports.end());
    let mut last = None;
    for port in ports {
        match UdpSocket::bind((at, port)) {
            Ok(socket) => return Ok(socket),
            Err(error) => last = Some(error),
        }
    }
    Err(last.map_or_else(|| anyhow::anyhow!("no port"), anyhow::Error::from)).context(place)
}

/// The own address that packets to `to` leave from.
///
/// # Errors
/// When the socket's address cannot reach it.
pub(crate) fn own_address(bind: Ipv4Addr, to: SocketAddrV4) -> anyhow::Result<Ipv4Addr> {
    if bind.is_loopback() && !to.ip().is_loopback() {
        bail!("{} cannot be reached from {bind}: add --bind 0.0.0.0, or the address of one network", to.ip());
    }
    if !bind.is_unspecified() {
        return Ok(bind);
    }
    let probe = UdpSocket::bind((bind, 0))?;
    // Nothing is sent: this asks the system for the route.
    probe.set_broadcast(true)?;
    probe.connect(to).with_context(|| format!("there is no way to {}", to.ip()))?;
    match probe.local_addr()? {
        SocketAddr::V4(own) => Ok(*own.ip()),
        SocketAddr::V6(_) => bail!("no IPv4 address leads to {}", to.ip()),
    }
}

/// Resolves a destination and checks that it is intended.
///
/// # Errors
/// When it cannot be found, or is a broadcast or multicast address and `broadcast` is not set.
pub(crate) fn destination(peer: &peer::Peer, broadcast: bool) -> anyhow::Result<SocketAddrV4> {
    let to = peer.resolve(VEHICLE_PORT)?;
    peer::guard(*to.ip(), broadcast)?;
    Ok(to)
}
