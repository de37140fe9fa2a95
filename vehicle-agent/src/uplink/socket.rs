//! A WebSocket to the shore: opened in a thread that may block, used by one that does not.

use super::server::Server;
use super::ways::{Door, Leaves};
use anyhow::Context as _;
use bytes::Bytes;
use link::{Failure, MAX_MESSAGE_BYTES};
use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use std::io::{self, Read, Write};
use std::net::{TcpStream, ToSocketAddrs as _};
use std::os::fd::{AsFd, BorrowedFd};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Duration;
use tungstenite::client::IntoClientRequest as _;
use tungstenite::http::{HeaderValue, header};
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, HandshakeError, Message, WebSocket};

/// The link itself keeps fewer bytes in flight.
const MOST_UNSENT_BYTES: usize = 4 << 20;

/// A connection to the shore.
#[derive(Debug)]
pub(super) struct Socket {
    socket: WebSocket<Stream>,
    /// Data could not be sent yet.
    pub(super) wants_to_write: bool,
}

#[derive(Debug)]
enum Stream {
    Plain(Counted),
    Secure(Box<StreamOwned<ClientConnection, Counted>>),
}

impl Stream {
    fn tcp(&self) -> &TcpStream {
        match self {
            Self::Plain(counted) => &counted.tcp,
            Self::Secure(tls) => &tls.sock.tcp,
        }
    }
}

/// Bytes that an attempt has transferred so far, in both directions: its cost on a metered way, successful or not.
#[derive(Debug, Clone, Default)]
pub(super) struct Carried(Arc<AtomicUsize>);

impl Carried {
    pub(super) fn bytes(&self) -> usize {
        self.0.load(Ordering::Relaxed)
    }

    fn count(&self, outcome: io::Result<usize>) -> io::Result<usize> {
        outcome.inspect(|bytes| {
            self.0.fetch_add(*bytes, Ordering::Relaxed);
        })
    }
}

/// A connection whose bytes are counted.
#[derive(Debug)]
struct Counted {
    tcp: TcpStream,
    carried: Carried,
}

impl Read for Counted {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        self.carried.count(self.tcp.read(buffer))
    }
}

impl Write for Counted {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.carried.count(self.tcp.write(bytes))
    }

    fn flush(&mut self) -> io::Result<()> {
        self.tcp.flush()
    }
}

impl Read for Stream {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        match self {
            Self::Plain(tcp) => tcp.read(buffer),
            Self::Secure(tls) => tls.read(buffer),
        }
    }
}

impl Write for Stream {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        match self {
            Self::Plain(tcp) => tcp.write(bytes),
            Self::Secure(tls) => tls.write(bytes),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        match self {
            Self::Plain(tcp) => tcp.flush(),
            Self::Secure(tls) => tls.flush(),
        }
    }
}

/// Connects and does the handshakes, each step within this time, and counts the bytes. Name lookup may block in addition.
///
/// # Errors
/// The reason for the link, and a text for people.
pub(super) fn connect(
    door: &Door,
    patience: Duration,
    carried: &Carried,
) -> Result<Socket, (Failure, String)> {
    let server = &door.server;
    let unanswered = |error: anyhow::Error| (Failure::Unanswered, format!("{error:#}"));
    let tcp = dial(server, &door.leaves, patience).map_err(unanswered)?;
    let tcp = Counted { tcp, carried: carried.clone() };
    let stream = match &server.authority {
        Some(authority) if server.is_secure() => {
            let tls =
                secure(server, authority, tcp).map_err(|error| (Failure::Refused, format!("{error:#}")))?;
            Stream::Secure(Box::new(tls))
        }
        _ => Stream::Plain(tcp),
    };
    let mut request = server.url.as_str().into_client_request().map_err(|error| unanswered(error.into()))?;
    let bearer = HeaderValue::try_from(format!("Bearer {}", server.token));
    request.headers_mut().insert(header::AUTHORIZATION, bearer.map_err(|error| unanswered(error.into()))?);
    let config = WebSocketConfig::default()
        .max_message_size(Some(MAX_MESSAGE_BYTES))
        .max_frame_size(Some(MAX_MESSAGE_BYTES))
        .max_write_buffer_size(MOST_UNSENT_BYTES);
    match tungstenite::client::client_with_config(request, stream, Some(config)) {
        Ok((socket, _)) => {
            let nonblocking = socket.get_ref().tcp().set_nonblocking(true);
            nonblocking.map_err(|error| unanswered(error.into()))?;
            Ok(Socket { socket, wants_to_write: false })
        }
        Err(HandshakeError::Failure(Error::Http(response))) => {
            let status = response.status();
            let hint = if status == 401 || status == 403 {
                "; is the token right, and for this vessel?"
            } else {
                ""
            };
            Err((Failure::Refused, format!("{} answers {status}{hint}", server.url)))
        }
        Err(HandshakeError::Failure(error)) => Err(unanswered(error.into())),
        Err(HandshakeError::Interrupted(_)) => {
            Err((Failure::Unanswered, format!("{} does not answer the greeting", server.url)))
        }
    }
}

fn dial(server: &Server, leaves: &Leaves, patience: Duration) -> anyhow::Result<TcpStream> {
    let Server { host, port, .. } = server;
    let found = (host.as_str(), *port).to_socket_addrs().with_context(|| format!("looking up {host}"))?;
    let addresses: Vec<_> = found.filter(|address| leaves.suits(address)).collect();
    let each = patience / u32::try_from(addresses.len().max(1)).unwrap_or(1);
    let mut last = None;
    for address in addresses {
        match leaves.connect(address, each) {
            Ok(tcp) => {
                tcp.set_nodelay(true)?;
                tcp.set_read_timeout(Some(patience))?;
                tcp.set_write_timeout(Some(patience))?;
                return Ok(tcp);
            }
            Err(error) => last = Some(error),
        }
    }
    let error = last.unwrap_or_else(|| io::Error::from(io::ErrorKind::AddrNotAvailable).into());
    Err(error).with_context(|| format!("connecting to {host}:{port}"))
}

/// TLS that trusts only the given certificates.
fn secure(
    server: &Server,
    authority: &std::path::Path,
    tcp: Counted,
) -> anyhow::Result<StreamOwned<ClientConnection, Counted>> {
    let mut roots = RootCertStore::empty();
    let reading = || format!("Certificate Authority: reading {}", authority.display());
    for certificate in CertificateDer::pem_file_iter(authority).with_context(reading)? {
        roots.add(certificate.with_context(reading)?).with_context(reading)?;
    }
    let provider = Arc::new(rustls::crypto::ring::default_provider());
    let config = ClientConfig::builder_with_provider(provider)
        .with_safe_default_protocol_versions()?
        .with_root_certificates(roots)
        .with_no_client_auth();
    let name = ServerName::try_from(server.host.clone())?;
    Ok(StreamOwned::new(ClientConnection::new(Arc::new(config), name)?, tcp))
}

impl Socket {
    /// The file descriptor to poll.
    pub(super) fn fd(&self) -> BorrowedFd<'_> {
        self.socket.get_ref().tcp().as_fd()
    }

    /// Queues a message; [`Socket::flush`] sends it.
    ///
    /// # Errors
    /// When the connection is broken, or its queue is full.
    pub(super) fn send(&mut self, message: Bytes) -> Result<(), String> {
        self.wants_to_write = true;
        waited(self.socket.write(Message::Binary(message))).map(|_| ())
    }

    /// Sends as much as the kernel accepts.
    ///
    /// # Errors
    /// When the connection is broken.
    pub(super) fn flush(&mut self) -> Result<(), String> {
        if self.wants_to_write {
            self.wants_to_write = waited(self.socket.flush())?.is_none();
        }
        Ok(())
    }

    /// The next available message.
    ///
    /// # Errors
    /// When the connection is broken or closed.
    pub(super) fn receive(&mut self) -> Result<Option<Bytes>, String> {
        loop {
            match waited(self.socket.read())? {
                None => return Ok(None),
                Some(Message::Binary(bytes)) => return Ok(Some(bytes)),
                Some(Message::Close(_)) => return Err("the server closed the connection".to_owned()),
                // Pings are answered by the library with the next flush.
                Some(Message::Ping(_)) => self.wants_to_write = true,
                Some(Message::Text(_) | Message::Pong(_) | Message::Frame(_)) => {}
            }
        }
    }
}

/// `None` if the operation would block.
fn waited<T>(outcome: Result<T, Error>) -> Result<Option<T>, String> {
    match outcome {
        Ok(value) => Ok(Some(value)),
        Err(Error::Io(error)) if error.kind() == io::ErrorKind::WouldBlock => Ok(None),
        Err(error) => Err(error.to_string()),
    }
}
