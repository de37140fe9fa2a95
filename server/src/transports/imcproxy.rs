//! The IMCProxy transport: a WebSocket server that speaks the Java IMCProxy's protocol, but transparently.
//!
//! One binary message is one packet, and every packet goes to all other connections with the bytes it came with.
//! Text is ignored, as there. Beyond the original: a peer that does not read delays no other, and all packets are also
//! recorded. The protocol has neither names nor passwords, so the transport is off unless configured and belongs on
//! loopback or the VPN; `allow` restricts it to declared addresses.

use super::Access;
use api::{Said, say};
use bytes::Bytes;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{FutureExt as _, SinkExt as _, StreamExt as _};
use hub::{Incoming, Peer, Role, Sources, Transport};
use shore::router::{AT_ONCE_BYTES, Connection, Router, Whose};
use std::net::SocketAddr;
use std::time::Duration;
use tokio::net::{TcpListener, TcpStream};
use tokio_tungstenite::WebSocketStream;
use tokio_tungstenite::tungstenite::protocol::{CloseFrame, WebSocketConfig, frame::coding::CloseCode};
use tokio_tungstenite::tungstenite::{Error, Message};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// Longest message, as in the original.
const MESSAGE_BYTES: usize = 65_536;
/// Bytes that may be queued for a peer.
const OUTBOX_BYTES: usize = 512 * 1024;
const WRITE_BYTES: usize = 128 * 1024;
const SOCKET_BYTES: usize = 256 * 1024;
/// A peer that does not read costs no more than 1 MiB.
const _: () = assert!(OUTBOX_BYTES + AT_ONCE_BYTES + WRITE_BYTES + SOCKET_BYTES <= 1 << 20);
/// Packets handed to the hub at once.
const BATCH: usize = 256;
/// Size at which a batch is complete.
const BATCH_BYTES: usize = 256 * 1024;
/// How long a peer may take for its handshake.
const HANDSHAKE: Duration = Duration::from_secs(10);
/// A peer that reads nothing for this long is disconnected, as in the original.
const STALLED: Duration = Duration::from_mins(5);
/// How often a silent peer is pinged.
const PING: Duration = Duration::from_secs(20);

type Socket = WebSocketStream<TcpStream>;

/// Serves the transport until `stop`.
pub(super) async fn serve(
    listener: TcpListener,
    access: Access,
    router: Router,
    tasks: TaskTracker,
    stop: CancellationToken,
) {
    loop {
        let accepted = tokio::select! {
            accepted = listener.accept() => accepted,
            () = stop.cancelled() => return,
        };
        let (stream, from) = match accepted {
            Ok(accepted) => accepted,
            Err(error) => {
                // Usually out of file handles: that is temporary, the listener stays.
                tracing::warn!(%error, "the IMCProxy transport cannot accept a connection");
                let what = say("cannot accept a connection: {error}").with("error", error);
                router.ledger().failed(Transport::Proxy, Whose::Transport, what);
                tokio::time::sleep(Duration::from_millis(200)).await;
                continue;
            }
        };
        if !access.admits(from.ip()) {
            tracing::warn!(peer = %from, "refused at the IMCProxy transport: not in transports.imcproxy.allow");
            router.ledger().refused(Transport::Proxy, from.ip(), say("not in transports.imcproxy.allow"));
            continue;
        }
        let Some(permit) = access.permit() else {
            tracing::warn!(peer = %from, "refused at the IMCProxy transport: transports.imcproxy.max_peers are connected");
            router.ledger().refused(
                Transport::Proxy,
                from.ip(),
                say("transports.imcproxy.max_peers are connected"),
            );
            continue;
        };
        let (router, stop) = (router.clone(), stop.clone());
        tasks.spawn(async move {
            if let Err(reason) = peer(stream, from, router.clone(), stop).await {
                tracing::info!(peer = %from, %reason, "an IMCProxy peer is gone");
                let whose = Whose::Peer(from.to_string());
                router.ledger().failed(Transport::Proxy, whose, Said::as_is(reason.to_string()));
            }
            drop(permit);
        });
    }
}

async fn peer(
    stream: TcpStream,
    from: SocketAddr,
    router: Router,
    stop: CancellationToken,
) -> anyhow::Result<()> {
    stream.set_nodelay(true)?;
    let socket = socket2::SockRef::from(&stream);
    // Bounds what the kernel holds for a peer that does not read.
    socket.set_send_buffer_size(SOCKET_BYTES)?;
    socket.set_tcp_keepalive(&socket2::TcpKeepalive::new().with_time(PING).with_interval(PING))?;
    let config = WebSocketConfig::default()
        .max_message_size(Some(MESSAGE_BYTES))
        .max_frame_size(Some(MESSAGE_BYTES))
        .write_buffer_size(WRITE_BYTES / 2)
        .max_write_buffer_size(WRITE_BYTES + MESSAGE_BYTES);
    let handshake = tokio_tungstenite::accept_async_with_config(stream, Some(config));
    let socket = tokio::time::timeout(HANDSHAKE, handshake).await??;
    tracing::info!(peer = %from, "an IMCProxy peer is here");
    let peer = Peer {
        transport: Transport::Proxy,
        role: Role::Console,
        name: from.to_string(),
        sources: Sources::Any,
    };
    let connection = router.join(peer, OUTBOX_BYTES).await?;
    let (sink, stream) = socket.split();
    let outcome = tokio::select! {
        outcome = receive(stream, &connection) => outcome,
        outcome = send(sink, &connection) => outcome,
        () = stop.cancelled() => Ok(()),
    };
    connection.leave().await;
    outcome
}

/// Receives packets, in batches of those available.
async fn receive(mut stream: SplitStream<Socket>, connection: &Connection) -> anyhow::Result<()> {
    let mut next = stream.next().await;
    while next.is_some() {
        let (mut batch, mut bytes, mut end) = (Vec::new(), 0, None);
        while let Some(message) = next.take() {
            match message {
                Ok(Message::Binary(packet)) => {
                    bytes += packet.len();
                    // Copied: a message is a slice of a larger read buffer, which one retained packet would keep in memory.
                    batch.push(Incoming::from(Bytes::copy_from_slice(&packet)));
                }
                Ok(Message::Close(_)) | Err(Error::ConnectionClosed) => end = Some(Ok(())),
                Ok(_) => {}
                Err(error) => end = Some(Err(error.into())),
            }
            if end.is_none() && batch.len() < BATCH && bytes < BATCH_BYTES {
                next = stream.next().now_or_never().flatten();
            }
        }
        if !batch.is_empty() {
            connection.give(batch).await?;
        }
        if let Some(end) = end {
            return end;
        }
        next = stream.next().await;
    }
    Ok(())
}

/// Sends the queued packets to the peer.
async fn send(mut sink: SplitSink<Socket, Message>, connection: &Connection) -> anyhow::Result<()> {
    loop {
        let packets = match tokio::time::timeout(PING, connection.outbox.take_packets()).await {
            Ok(Ok(packets)) => packets,
            Ok(Err(overflow)) => {
                let reason = CloseFrame { code: CloseCode::Again, reason: "you do not read".into() };
                tokio::time::timeout(Duration::from_secs(1), sink.send(Message::Close(Some(reason))))
                    .await
                    .ok();
                return Err(overflow.into());
            }
            Err(_silence) => {
                tokio::time::timeout(STALLED, sink.send(Message::Ping(Bytes::new()))).await??;
                continue;
            }
        };
        let write = async {
            for packet in packets {
                sink.feed(Message::Binary(packet)).await?;
            }
            sink.flush().await
        };
        tokio::time::timeout(STALLED, write).await??;
    }
}
