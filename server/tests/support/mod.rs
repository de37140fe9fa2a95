//! A running server and peers of its doors, for tests.

#![allow(dead_code, reason = "each test file uses what it needs")]

use bytes::Bytes;
use futures_util::{SinkExt as _, StreamExt as _};
use imc::messages::Message;
use imc::{Address, Header, Packet};
use server::Serving;
use server::config::Config;
use std::net::SocketAddr;
use std::time::Duration;
use tempfile::TempDir;
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::Message as Frame;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};

pub(crate) const OTTER: Address = Address(0x2810);
pub(crate) const CONSOLE: Address = Address(0x4001);
/// Longer than anything here takes on a loaded machine.
pub(crate) const PATIENCE: Duration = Duration::from_secs(30);

/// A server on free ports with its data in a scratch folder.
pub(crate) struct Shore {
    pub(crate) serving: Serving,
    pub(crate) data: TempDir,
}

impl Shore {
    /// Starts one with the IMCProxy door open and what `change` adds.
    pub(crate) async fn start(change: impl FnOnce(&mut Config)) -> Self {
        let data = TempDir::new().unwrap();
        let mut config = Config { data: data.path().to_owned(), ..Config::default() };
        config.http.listen = "127.0.0.1:0".parse().unwrap();
        config.imc.active = false;
        config.doors.imcproxy.listen = "127.0.0.1:0".to_owned().try_into().unwrap();
        change(&mut config);
        Self { serving: server::serve(config).await.unwrap(), data }
    }

    pub(crate) fn proxy(&self) -> SocketAddr {
        self.serving.doors.imcproxy.unwrap()
    }
}

/// A client of the IMCProxy door.
pub(crate) struct Client(pub(crate) WebSocketStream<MaybeTlsStream<TcpStream>>);

impl Client {
    pub(crate) async fn connect(to: SocketAddr) -> Self {
        Self(connect_async(format!("ws://{to}/any/path?and=query")).await.unwrap().0)
    }

    pub(crate) async fn say(&mut self, packet: &[u8]) {
        self.0.send(Frame::Binary(Bytes::copy_from_slice(packet))).await.unwrap();
    }

    /// The next packet.
    pub(crate) async fn hear(&mut self) -> Bytes {
        let next = async {
            loop {
                match self.0.next().await.unwrap().unwrap() {
                    Frame::Binary(packet) => return packet,
                    Frame::Ping(_) | Frame::Pong(_) => {}
                    other => panic!("{other:?}"),
                }
            }
        };
        tokio::time::timeout(PATIENCE, next).await.unwrap()
    }
}

/// A packet with a time.
pub(crate) fn packet(src: Address, dst: Address, timestamp: f64, message: impl Into<Message>) -> Bytes {
    let header = Header { timestamp, src, src_ent: 3, dst, dst_ent: 255 };
    Packet::new(header, message).encode().unwrap().into()
}
