//! A running server and peers of its transports, for tests.

use bytes::Bytes;
use futures_util::{SinkExt as _, StreamExt as _};
use imc::lsf::{LogItem, LogReader};
use imc::messages::{self, Message};
use imc::{Address, ByteOrder, Header, Packet};
use server::Serving;
use server::config::Config;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::time::Duration;
use tempfile::TempDir;
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::Message as Frame;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};

pub(crate) mod ashore;
pub(crate) mod browser;
pub(crate) mod program;
pub(crate) mod slow;
pub(crate) mod spools;
pub(crate) mod trusting;

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
    /// Starts one with the IMCProxy transport open and what `change` adds.
    pub(crate) async fn start(change: impl FnOnce(&mut Config)) -> Self {
        let data = TempDir::new().unwrap();
        let mut config = Config { data: data.path().to_owned(), ..Config::default() };
        config.http.listen = "127.0.0.1:0".parse().unwrap();
        config.imc.active = false;
        config.transports.imcproxy.listen = "127.0.0.1:0".to_owned().try_into().unwrap();
        change(&mut config);
        Self { serving: server::serve(config).await.unwrap(), data }
    }

    pub(crate) fn proxy(&self) -> SocketAddr {
        self.serving.transports.imcproxy.unwrap()
    }
}

/// A client of the IMCProxy transport.
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

/// Packets that must stay unchanged: big-endian packets, unknown ids, bytes after the last field.
pub(crate) fn odd_packets(timestamp: f64) -> Vec<Bytes> {
    let known = Packet::new(Header { timestamp, src: OTTER, ..Header::default() }, messages::Heartbeat);
    let big = Packet { order: ByteOrder::Big, ..known.clone() };
    let body = imc::Body::Unknown { id: 60_001, payload: vec![1, 2, 3] };
    let unknown = Packet { body, ..known.clone() };
    let trailing = Packet { trailing: vec![9; 7], ..known };
    [big, unknown, trailing].iter().map(|packet| packet.encode().unwrap().into()).collect()
}

/// All packets of a log, in order.
pub(crate) fn packets_of(log: &Path) -> Vec<Bytes> {
    let mut reader = LogReader::open(log).unwrap();
    let mut packets = Vec::new();
    while let Ok(Some(item)) = reader.next_item() {
        if let LogItem::Packet { view, .. } = item {
            packets.push(Bytes::copy_from_slice(view.bytes()));
        }
    }
    packets
}

/// The logs of a system's archive, day after day.
pub(crate) fn archive_of(data: &Path, system: Address) -> Vec<PathBuf> {
    let days = std::fs::read_dir(data.join(format!("archive/{:#06x}", system.0)));
    let mut logs: Vec<PathBuf> =
        days.into_iter().flatten().map(|day| day.unwrap().path().join("Data.lsf")).collect();
    logs.sort();
    logs
}

/// All bytes of a system's archive, day after day.
pub(crate) fn archived(data: &Path, system: Address) -> Vec<u8> {
    archive_of(data, system).iter().flat_map(|log| std::fs::read(log).unwrap()).collect()
}

/// All packets of a system's archive, day after day.
pub(crate) fn archived_packets(data: &Path, system: Address) -> Vec<Bytes> {
    archive_of(data, system).iter().flat_map(|log| packets_of(log)).collect()
}
