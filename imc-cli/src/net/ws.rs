//! WebSocket, as a client of an IMCProxy: one binary message is one packet.

use super::{Link, is_timeout, peer};
use crate::report;
use crate::sink::{Flow, Sink};
use anyhow::{Context as _, anyhow, bail};
use std::net::TcpStream;
use std::time::{Duration, Instant};
use tungstenite::error::ProtocolError;
use tungstenite::http::Uri;
use tungstenite::protocol::WebSocketConfig;
use tungstenite::{Error, Message, WebSocket};

/// IMCProxy closes connections that are silent for 300 s.
const PING_EVERY: Duration = Duration::from_mins(1);
/// How long to wait for the answer to the opening and closing handshakes.
const HANDSHAKE_WAIT: Duration = Duration::from_secs(10);
/// Longest message taken; a packet has at most 65 557 bytes.
const MESSAGE_MAX: usize = 1 << 20;

/// A connection.
pub(crate) struct WsLink {
    url: String,
    socket: WebSocket<TcpStream>,
    pinged: Instant,
    /// Whether it was reported that text messages are ignored.
    text_told: bool,
}

impl WsLink {
    /// Connects to `ws://HOST[:PORT][/PATH]`.
    ///
    /// # Errors
    /// When the URL is not valid, no host answers, or it is not a WebSocket server.
    pub(crate) fn connect(url: &str) -> anyhow::Result<Self> {
        let stream = peer::connect(&host_port(url)?)?;
        stream.set_read_timeout(Some(HANDSHAKE_WAIT))?;
        let config =
            WebSocketConfig::default().max_message_size(Some(MESSAGE_MAX)).max_frame_size(Some(MESSAGE_MAX));
        let (socket, _) = tungstenite::client::client_with_config(url, stream, Some(config))
            .map_err(|error| anyhow!("{url} does not answer as a WebSocket server: {error}"))?;
        Ok(Self { url: url.to_owned(), socket, pinged: Instant::now(), text_told: false })
    }

    fn ping(&mut self) -> Result<(), Error> {
        if self.pinged.elapsed() < PING_EVERY {
            return Ok(());
        }
        self.pinged = Instant::now();
        self.socket.send(Message::Ping(Vec::new().into()))
    }

    fn mention_text(&mut self) {
        if !self.text_told {
            self.text_told = true;
            report::note(&format!("{} sends text messages, which are not packets: passed over", self.url));
        }
    }
}

/// Checks a URL and gives its host and port.
fn host_port(url: &str) -> anyhow::Result<String> {
    let example = "expected a URL such as ws://127.0.0.1:9090";
    let uri: Uri = url.parse().with_context(|| format!("`{url}`: {example}"))?;
    match (uri.scheme_str(), uri.host()) {
        (Some("ws"), Some(host)) => Ok(format!("{host}:{}", uri.port_u16().unwrap_or(80))),
        (Some("wss"), _) => {
            bail!("`{url}`: there is no TLS here; let a local proxy such as stunnel add it and use ws://")
        }
        _ => bail!("`{url}`: {example}"),
    }
}

impl Link for WsLink {
    fn send(&mut self, packet: &[u8]) -> anyhow::Result<()> {
        let message = Message::Binary(packet.to_vec().into());
        self.socket.send(message).with_context(|| format!("cannot send to {}", self.url))
    }

    fn receive(&mut self, wait: Duration, sink: &mut Sink<'_>) -> anyhow::Result<Flow> {
        self.socket.get_ref().set_read_timeout(Some(wait))?;
        let received = self.ping().and_then(|()| self.socket.read());
        let flow = match received {
            Ok(Message::Binary(bytes)) => sink.datagram(&bytes, &self.url)?,
            Ok(Message::Text(_)) => {
                self.mention_text();
                Flow::More
            }
            Ok(Message::Close(_)) => {
                // Answers the other side's close frame.
                self.socket.flush().ok();
                Flow::Closed("the other side closed the connection".to_owned())
            }
            Ok(Message::Ping(_) | Message::Pong(_) | Message::Frame(_)) => Flow::More,
            Err(Error::Io(error)) if is_timeout(&error) => Flow::More,
            Err(
                Error::ConnectionClosed
                | Error::AlreadyClosed
                | Error::Protocol(ProtocolError::ResetWithoutClosingHandshake),
            ) => Flow::Closed("the other side closed the connection".to_owned()),
            Err(error) => Flow::Closed(error.to_string()),
        };
        sink.flush()?;
        Ok(flow)
    }

    fn close(&mut self) {
        self.socket.get_ref().set_read_timeout(Some(HANDSHAKE_WAIT)).ok();
        if self.socket.close(None).is_ok() {
            let deadline = Instant::now() + HANDSHAKE_WAIT;
            while Instant::now() < deadline && self.socket.read().is_ok() {}
        }
    }
}
