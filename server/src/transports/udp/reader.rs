//! Reads datagrams in its own thread as they arrive, so that neither the hub nor other work of the server lets the kernel's
//! buffer overflow.
//!
//! Datagrams are queued in an [`Inbox`] of [`WAITING_BYTES`]. When that is full, the newest are dropped and counted.

use bytes::Bytes;
use shore::owners::Owners;
use std::collections::VecDeque;
use std::io;
use std::net::SocketAddr;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use tokio::net::UdpSocket;
use tokio::runtime::Builder;
use tokio::sync::Notify;
use tokio_util::sync::CancellationToken;

/// Bytes that may be queued for the hub, with their overhead.
const WAITING_BYTES: usize = 16 << 20;
const OVERHEAD_BYTES: usize = size_of::<Datagram>() + 32;
/// Most datagrams read from one socket before the other gets its turn.
const AT_ONCE: usize = 1_024;
/// Longest datagram.
const DATAGRAM_BYTES: usize = 65_536;

/// A received datagram.
#[derive(Debug)]
pub(super) struct Datagram {
    pub(super) from: SocketAddr,
    pub(super) bytes: Bytes,
    /// Whether it arrived at the discovery port.
    pub(super) discovery: bool,
}

/// Queue of datagrams that were read.
#[derive(Debug, Default)]
pub(super) struct Inbox {
    waiting: Mutex<Waiting>,
    ready: Notify,
}

#[derive(Debug, Default)]
struct Waiting {
    datagrams: VecDeque<Datagram>,
    bytes: usize,
    dropped: u64,
}

impl Inbox {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn push(&self, batch: &mut Vec<Datagram>) {
        let mut waiting = self.lock();
        for datagram in batch.drain(..) {
            let cost = datagram.bytes.len() + OVERHEAD_BYTES;
            if waiting.bytes + cost > WAITING_BYTES {
                waiting.dropped += 1;
            } else {
                waiting.bytes += cost;
                waiting.datagrams.push_back(datagram);
            }
        }
        drop(waiting);
        self.ready.notify_one();
    }

    /// Waits for datagrams, and takes all.
    pub(super) async fn take(&self) -> VecDeque<Datagram> {
        loop {
            let datagrams = self.take_now();
            if !datagrams.is_empty() {
                return datagrams;
            }
            self.ready.notified().await;
        }
    }

    fn take_now(&self) -> VecDeque<Datagram> {
        let mut waiting = self.lock();
        waiting.bytes = 0;
        std::mem::take(&mut waiting.datagrams)
    }

    /// Datagrams dropped for lack of room, since the start.
    pub(super) fn dropped(&self) -> u64 {
        self.lock().dropped
    }
}

/// The sockets, served by the thread that reads them; others may send by them.
pub(super) struct Sockets {
    pub(super) data: Arc<UdpSocket>,
    pub(super) inbox: Arc<Inbox>,
}

/// Starts the thread; it ends with `stop`.
pub(super) fn start(
    data: std::net::UdpSocket,
    discovery: Option<std::net::UdpSocket>,
    owners: &Owners,
    stop: CancellationToken,
) -> io::Result<Sockets> {
    let runtime = Builder::new_current_thread().enable_io().build()?;
    let entered = runtime.enter();
    let data = Arc::new(UdpSocket::from_std(data)?);
    let discovery = discovery.map(UdpSocket::from_std).transpose()?;
    drop(entered);
    let inbox = Arc::new(Inbox::default());
    let sockets = Sockets { data: Arc::clone(&data), inbox: Arc::clone(&inbox) };
    let read = async move { stop.run_until_cancelled(read(&data, discovery.as_ref(), &inbox)).await };
    let read = owners.watch("the UDP reader", read);
    std::thread::Builder::new().name("udp-reader".to_owned()).spawn(move || runtime.block_on(read))?;
    Ok(sockets)
}

async fn read(data: &UdpSocket, discovery: Option<&UdpSocket>, inbox: &Inbox) {
    let (mut buffer, mut batch) = (vec![0; DATAGRAM_BYTES], Vec::with_capacity(AT_ONCE));
    loop {
        tokio::select! {
            _ = data.readable() => drain(data, false, &mut buffer, &mut batch),
            _ = readable(discovery) => {
                if let Some(socket) = discovery {
                    drain(socket, true, &mut buffer, &mut batch);
                }
            }
        }
        if batch.is_empty() {
            // Woken without a datagram.
            tokio::task::yield_now().await;
        } else {
            inbox.push(&mut batch);
        }
    }
}

async fn readable(socket: Option<&UdpSocket>) -> io::Result<()> {
    match socket {
        Some(socket) => socket.readable().await,
        None => std::future::pending().await,
    }
}

/// Reads the available datagrams.
fn drain(socket: &UdpSocket, discovery: bool, buffer: &mut [u8], batch: &mut Vec<Datagram>) {
    for _ in 0..AT_ONCE {
        match socket.try_recv_from(buffer) {
            Ok((length, from)) => {
                let bytes = Bytes::copy_from_slice(&buffer[..length]);
                batch.push(Datagram { from, bytes, discovery });
            }
            Err(error) if error.kind() == io::ErrorKind::WouldBlock => return,
            // The error of an earlier sent datagram, whose receiver was unreachable.
            Err(_) => {}
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn what_has_no_room_is_dropped_and_counted() {
        let inbox = Inbox::default();
        let datagram = || Datagram {
            from: ([127, 0, 0, 1], 6002).into(),
            bytes: Bytes::from(vec![0; 60_000]),
            discovery: false,
        };
        let mut batch: Vec<Datagram> = (0..400).map(|_| datagram()).collect();
        inbox.push(&mut batch);
        let taken = inbox.take().await.len() as u64;
        assert!((200..300).contains(&taken), "{taken}");
        assert_eq!(taken + inbox.dropped(), 400);
        inbox.push(&mut vec![datagram()]);
        assert_eq!(inbox.take().await.len(), 1, "there is room again");
    }
}
