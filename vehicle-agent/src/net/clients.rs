//! TCP servers: their clients, the outbox of each, and which are disconnected.
//!
//! Bounds: at most [`CLIENTS`] at a time; a further one replaces the client that has been silent for longest. At most
//! [`OUTBOX_BYTES`] are queued for a client here and [`SOCKET_BYTES`] in the system; one that does not read its packets in
//! time is disconnected rather than given gaps. Both are reported.

use super::inbox::Inbox;
use anyhow::Context as _;
use imc::{Deframer, Frame};
use onboard::Peer;
use std::collections::{BTreeMap, VecDeque};
use std::io::{ErrorKind, Read as _, Write as _};
use std::net::{Shutdown, SocketAddr, TcpListener, TcpStream};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread;
use std::time::{Duration, Instant};

/// Clients at a time.
const CLIENTS: usize = 16;
/// Most connections whose end the loop has not processed; beyond this further ones are refused.
const STREAMS: usize = 2 * CLIENTS;
/// Most bytes queued for a client here, with the overhead of entries.
const OUTBOX_BYTES: usize = 512 << 10;
const ENTRY_BYTES: usize = 32;
/// Most bytes queued for a client in the system; Linux doubles the value.
const SOCKET_BYTES: usize = 96 << 10;
/// A client that reads nothing for this long is stuck.
const WRITE_TIMEOUT: Duration = Duration::from_secs(5);
/// Pause after a failed accept: file descriptors may become free.
const ACCEPT_PAUSE: Duration = Duration::from_millis(200);
/// Failures to accept are reported at most once in this time.
const ACCEPT_TOLD: Duration = Duration::from_mins(1);

/// All clients.
#[derive(Debug, Default)]
pub(super) struct Clients {
    all: Mutex<BTreeMap<u32, Arc<Client>>>,
}

/// One client.
#[derive(Debug)]
struct Client {
    from: SocketAddr,
    stream: TcpStream,
    outbox: Mutex<Outbox>,
    filled: Condvar,
    heard: Mutex<Instant>,
}

#[derive(Debug, Default)]
struct Outbox {
    packets: VecDeque<Arc<[u8]>>,
    bytes: usize,
    closed: bool,
}

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Clients {
    /// Puts a packet into a client's outbox; one whose outbox is full is disconnected.
    pub(super) fn send(&self, number: u32, packet: &Arc<[u8]>) {
        let all = lock(&self.all);
        let Some(client) = all.get(&number) else { return };
        if !client.put(packet) {
            tracing::warn!(client = %client.from, "does not read what it is sent; disconnected");
            client.close();
        }
    }

    /// The client that has been silent for longest.
    fn idlest(&self) -> Option<(u32, Arc<Client>)> {
        let all = lock(&self.all);
        let idlest = all.iter().min_by_key(|(_, client)| *lock(&client.heard))?;
        Some((*idlest.0, Arc::clone(idlest.1)))
    }

    fn insert(&self, number: u32, client: Arc<Client>) {
        while lock(&self.all).len() >= CLIENTS {
            let Some((idle, client)) = self.idlest() else { break };
            let silent_s = lock(&client.heard).elapsed().as_secs();
            tracing::warn!(
                client = %client.from, silent_s,
                "disconnected: the most silent of {CLIENTS} makes room for another"
            );
            client.close();
            lock(&self.all).remove(&idle);
        }
        lock(&self.all).insert(number, client);
    }
}

impl Client {
    /// Queues a packet; returns whether there was room.
    fn put(&self, packet: &Arc<[u8]>) -> bool {
        let mut outbox = lock(&self.outbox);
        if outbox.closed {
            // It was reported already.
            return true;
        }
        let bytes = outbox.bytes + packet.len() + ENTRY_BYTES;
        if bytes > OUTBOX_BYTES {
            return false;
        }
        outbox.bytes = bytes;
        outbox.packets.push_back(Arc::clone(packet));
        drop(outbox);
        self.filled.notify_one();
        true
    }

    /// The next packet to write; `None` after the end.
    fn next(&self) -> Option<Arc<[u8]>> {
        let mut outbox = lock(&self.outbox);
        loop {
            if outbox.closed {
                return None;
            }
            if let Some(packet) = outbox.packets.pop_front() {
                outbox.bytes -= packet.len() + ENTRY_BYTES;
                return Some(packet);
            }
            outbox = self.filled.wait(outbox).unwrap_or_else(PoisonError::into_inner);
        }
    }

    /// Ends the connection, and with it both threads.
    fn close(&self) {
        *lock(&self.outbox) = Outbox { closed: true, ..Outbox::default() };
        self.filled.notify_all();
        self.stream.shutdown(Shutdown::Both).ok();
    }

    fn write(&self) {
        while let Some(packet) = self.next() {
            if let Err(error) = (&self.stream).write_all(&packet) {
                if !lock(&self.outbox).closed {
                    let stuck = matches!(error.kind(), ErrorKind::WouldBlock | ErrorKind::TimedOut);
                    let why =
                        if stuck { "takes nothing of what it is sent".to_owned() } else { error.to_string() };
                    tracing::warn!(client = %self.from, "disconnected: {why}");
                }
                break;
            }
        }
        self.close();
    }

    fn read(&self, number: u32, inbox: &Inbox) {
        let (mut deframer, mut buffer) = (Deframer::new(), vec![0; 16_384]);
        while let Ok(length @ 1..) = (&self.stream).read(&mut buffer) {
            *lock(&self.heard) = Instant::now();
            deframer.push(&buffer[..length]);
            while let Some(frame) = deframer.next_frame() {
                if let Frame::Packet { view, .. } = frame {
                    inbox.packet(Peer::Tcp(number), view.bytes());
                }
            }
        }
        self.close();
    }
}

/// Accepts clients of a server from here on.
pub(super) fn listen(
    server: u8,
    listener: TcpListener,
    clients: Arc<Clients>,
    inbox: Arc<Inbox>,
) -> anyhow::Result<()> {
    let work = move || {
        let mut told: Option<Instant> = None;
        for number in (1..).map(|count| Peer::number(server, count)) {
            let accepted = listener.accept().map_err(anyhow::Error::from);
            let outcome = accepted.and_then(|(stream, from)| {
                // Connections that come and go faster than the loop processes them are refused.
                if inbox.streams() >= STREAMS {
                    Ok(())
                } else {
                    serve(number, stream, from, &clients, &inbox)
                }
            });
            if let Err(error) = outcome {
                if told.is_none_or(|told| told.elapsed() >= ACCEPT_TOLD) {
                    told = Some(Instant::now());
                    tracing::error!("a connection could not be accepted: {error:#}");
                }
                thread::sleep(ACCEPT_PAUSE);
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
    from: SocketAddr,
    clients: &Arc<Clients>,
    inbox: &Arc<Inbox>,
) -> anyhow::Result<()> {
    stream.set_nodelay(true).ok();
    stream.set_write_timeout(Some(WRITE_TIMEOUT)).context("the write time-out")?;
    rustix::net::sockopt::set_socket_keepalive(&stream, true).ok();
    rustix::net::sockopt::set_socket_send_buffer_size(&stream, SOCKET_BYTES).context("the send buffer")?;
    let client = Arc::new(Client {
        from,
        stream,
        outbox: Mutex::default(),
        filled: Condvar::new(),
        heard: Mutex::new(Instant::now()),
    });
    let writing = Arc::clone(&client);
    let writer = thread::Builder::new().name(format!("tcp-{number}-out"));
    let writer = writer.spawn(move || writing.write()).context("a thread")?;
    // Register the client before announcing it: packets that the loop sends at once must not be lost.
    clients.insert(number, Arc::clone(&client));
    inbox.connected(number);
    let (reading, clients, inbox) = (Arc::clone(&client), Arc::clone(clients), Arc::clone(inbox));
    let (gone, forget) = (Arc::clone(&inbox), Arc::clone(&clients));
    let reader = thread::Builder::new().name(format!("tcp-{number}-in")).spawn(move || {
        reading.read(number, &inbox);
        writer.join().ok();
        lock(&clients.all).remove(&number);
        inbox.disconnected(number);
    });
    if let Err(error) = reader {
        client.close();
        lock(&forget.all).remove(&number);
        gone.disconnected(number);
        return Err(error).context("a thread");
    }
    tracing::info!(client = %from, number, "connected");
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::super::Event;
    use super::*;
    use imc::Address;

    struct Server {
        clients: Arc<Clients>,
        inbox: Arc<Inbox>,
        at: SocketAddr,
    }

    fn server() -> Server {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let at = listener.local_addr().unwrap();
        let (clients, inbox) = (Arc::new(Clients::default()), Arc::new(Inbox::new(Address(0x2810))));
        listen(0, listener, Arc::clone(&clients), Arc::clone(&inbox)).unwrap();
        Server { clients, inbox, at }
    }

    const DEADLINE: Duration = Duration::from_secs(30);

    impl Server {
        fn connect(&self) -> (u32, TcpStream) {
            let stream = TcpStream::connect(self.at).unwrap();
            stream.set_read_timeout(Some(DEADLINE)).unwrap();
            loop {
                if let Event::Connected(number) = self.inbox.take(DEADLINE).unwrap() {
                    return (number, stream);
                }
            }
        }
    }

    #[test]
    fn one_more_takes_the_place_of_the_most_silent() {
        let server = server();
        let mut all: Vec<(u32, TcpStream)> = (0..CLIENTS).map(|_| server.connect()).collect();
        // The first sends; then the second is the one silent for longest.
        let beat = imc::Packet::new(imc::Header::default(), imc::messages::Heartbeat).encode().unwrap();
        all[0].1.write_all(&beat).unwrap();
        assert!(matches!(server.inbox.take(DEADLINE), Some(Event::Packet(..))));
        let (number, mut newest) = server.connect();
        assert_eq!(all[1].1.read(&mut [0; 8]).unwrap(), 0, "the second is disconnected");
        let packet: Arc<[u8]> = beat.as_slice().into();
        server.clients.send(number, &packet);
        server.clients.send(all[0].0, &packet);
        let mut got = vec![0; beat.len()];
        newest.read_exact(&mut got).unwrap();
        all[0].1.read_exact(&mut got).unwrap();
        assert_eq!(got, beat);
    }

    #[test]
    fn a_client_that_does_not_read_costs_little_and_is_disconnected() {
        let server = server();
        let (number, mut stream) = server.connect();
        let packet: Arc<[u8]> = vec![7; 1000].into();
        let mut handed = 0;
        // The client's own system buffers more on top of what is held here.
        while lock(&server.clients.all).get(&number).is_some_and(|client| !lock(&client.outbox).closed) {
            server.clients.send(number, &packet);
            let all = lock(&server.clients.all);
            let held = all.get(&number).map_or(0, |client| lock(&client.outbox).bytes);
            assert!(held <= OUTBOX_BYTES);
            handed += packet.len();
            assert!(handed < 1 << 30, "it is never disconnected");
        }
        loop {
            if let Event::Disconnected(gone) = server.inbox.take(DEADLINE).unwrap() {
                break assert_eq!(gone, number);
            }
        }
        // Packets under way still arrive, then the end.
        let mut rest = Vec::new();
        stream.read_to_end(&mut rest).ok();
        assert!(rest.len() < handed);
        assert!(lock(&server.clients.all).is_empty());
    }
}
