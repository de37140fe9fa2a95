//! An HTTPS client that trusts only one authority.

use rustls::pki_types::pem::PemObject as _;
use rustls::pki_types::{CertificateDer, ServerName};
use rustls::{ClientConfig, ClientConnection, RootCertStore, StreamOwned};
use std::io::{Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::path::Path;
use std::sync::Arc;
use std::time::Duration;

/// A client that trusts the authority of a file.
pub(crate) struct Trusting {
    config: Arc<ClientConfig>,
    /// Its source address on this computer.
    from: Ipv4Addr,
}

/// A connection that it made.
pub(crate) type Encrypted = StreamOwned<ClientConnection, TcpStream>;

impl Trusting {
    pub(crate) fn new(authority: &Path) -> Self {
        let mut roots = RootCertStore::empty();
        roots.add(CertificateDer::from_pem_file(authority).unwrap()).unwrap();
        let provider = Arc::new(rustls::crypto::ring::default_provider());
        let builder =
            ClientConfig::builder_with_provider(provider).with_safe_default_protocol_versions().unwrap();
        let config = Arc::new(builder.with_root_certificates(roots).with_no_client_auth());
        Self { config, from: Ipv4Addr::LOCALHOST }
    }

    /// The same, from another address of this computer.
    pub(crate) fn at(mut self, from: Ipv4Addr) -> Self {
        self.from = from;
        self
    }

    /// Connects with a TLS handshake for this name; an error if it does not trust the server.
    pub(crate) fn connect(&self, to: SocketAddr, name: &str) -> std::io::Result<Encrypted> {
        let name = ServerName::try_from(name.to_owned()).unwrap();
        let mut session = ClientConnection::new(Arc::clone(&self.config), name).unwrap();
        let socket = socket2::Socket::new(socket2::Domain::IPV4, socket2::Type::STREAM, None)?;
        socket.bind(&SocketAddr::from((self.from, 0)).into())?;
        socket.connect(&to.into())?;
        let mut socket = TcpStream::from(socket);
        socket.set_read_timeout(Some(Duration::from_mins(1)))?;
        while session.is_handshaking() {
            session.complete_io(&mut socket)?;
        }
        Ok(StreamOwned::new(session, socket))
    }

    /// The protocol that the server chooses of these, which the client offers in this order.
    pub(crate) fn protocol(&self, to: SocketAddr, name: &str, offered: &[&str]) -> Option<String> {
        let mut config = (*self.config).clone();
        config.alpn_protocols = offered.iter().map(|one| one.as_bytes().to_vec()).collect();
        let stream = Self { config: Arc::new(config), from: self.from }.connect(to, name).unwrap();
        stream.conn.alpn_protocol().map(|one| String::from_utf8_lossy(one).into_owned())
    }

    /// The server's certificate.
    pub(crate) fn certificate(&self, to: SocketAddr, name: &str) -> std::io::Result<CertificateDer<'static>> {
        let stream = self.connect(to, name)?;
        Ok(stream.conn.peer_certificates().unwrap()[0].clone().into_owned())
    }

    /// Head and body of the answer to a request whose head ends with `head`; the connection ends with it.
    pub(crate) fn ask(
        &self,
        to: SocketAddr,
        name: &str,
        head: &str,
        body: &[u8],
    ) -> std::io::Result<(String, String)> {
        let mut stream = self.connect(to, name)?;
        write!(stream, "{head}host: {name}\r\nconnection: close\r\n\r\n")?;
        stream.write_all(body)?;
        let mut answer = Vec::new();
        match stream.read_to_end(&mut answer) {
            Err(error) if error.kind() != std::io::ErrorKind::UnexpectedEof => return Err(error),
            _ => {}
        }
        let answer = String::from_utf8_lossy(&answer).into_owned();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap_or((&answer, ""));
        Ok((head.to_owned(), body.to_owned()))
    }
}

/// Sends a request on a persistent connection, and returns the status.
pub(crate) fn ask_on(stream: &mut Encrypted, path: &str) -> String {
    write!(stream, "GET {path} HTTP/1.1\r\nhost: shore\r\n\r\n").unwrap();
    let mut answer = Vec::new();
    let mut byte = [0];
    while !answer.ends_with(b"\r\n\r\n") {
        stream.read_exact(&mut byte).unwrap();
        answer.push(byte[0]);
    }
    let head = String::from_utf8_lossy(&answer).into_owned();
    let length =
        head.lines().find_map(|line| line.strip_prefix("content-length: ")?.trim().parse().ok()).unwrap();
    stream.read_exact(&mut vec![0; length]).unwrap();
    head.split(' ').nth(1).unwrap().to_owned()
}
