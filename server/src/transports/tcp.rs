//! A TCP stream to an IMC node, such as DUNE's TCP server: receives all its packets, and sends those addressed to it.
//!
//! No announcement and no heartbeat is needed for the stream to start. A stream is closed only by the node or the kernel:
//! while either side stalls TCP keeps the bytes, and a new stream would lose them. So a node that is silent for [`SILENCE`]
//! is only reported, and a new connection is made only if its computer does not answer for [`DEAD_AFTER`].

use api::{Fixed, Said, fixed, say};
use bytes::Bytes;
use hub::{Incoming, Peer, Role, Sources, Transport};
use imc::{Deframer, Frame};
use shore::router::{Connection, Ledger, Router, Stopped, Whose};
use socket2::{SockRef, TcpKeepalive};
use std::time::{Duration, Instant};
use tokio::io::{AsyncRead, AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::net::tcp::OwnedWriteHalf;
use tokio_util::sync::CancellationToken;

/// Bytes that may be queued for the node: commands are few. Those without room are dropped, which is reported.
const OUTBOX_BYTES: usize = 256 * 1024;
const READ_BYTES: usize = 64 * 1024;
/// A node that was silent for this long is reported: vehicles send something each second.
const SILENCE: Duration = Duration::from_secs(10);
/// A computer that acknowledges nothing for this long is gone.
const DEAD_AFTER: Duration = Duration::from_secs(30);
/// TCP keepalive: idle time before the first probe, and interval between probes.
const ASK: Duration = Duration::from_secs(10);
/// After how long an incomplete packet is skipped, if complete ones follow.
const REST: Duration = Duration::from_secs(2);
/// How often an idle stream is checked.
const LOOK: Duration = Duration::from_millis(500);
const CONNECT: Duration = Duration::from_secs(5);
/// Waits between attempts double from the first to the second of these.
const BACK_OFF: (Duration, Duration) = (Duration::from_secs(1), Duration::from_secs(15));

/// A factor from 0.5 to 1.5, so that peers disconnected together do not reconnect together.
fn jitter() -> f64 {
    // Without random numbers all wait equally long, which does no harm.
    let word = getrandom::u32().unwrap_or(u32::MAX / 2);
    0.5 + f64::from(word) / f64::from(u32::MAX)
}

/// Connects to `node` (host:port) again and again until `stop`.
pub(super) async fn keep_connected(node: String, router: Router, stop: CancellationToken) {
    let mut wait = BACK_OFF.0;
    let mut told = false;
    loop {
        let attempt = async {
            let stream = tokio::time::timeout(CONNECT, TcpStream::connect(&node)).await??;
            tracing::info!(%node, "connected");
            (wait, told) = (BACK_OFF.0, false);
            converse(stream, &node, &router).await
        };
        let outcome = stop.run_until_cancelled(attempt).await;
        let Some(outcome) = outcome else { return };
        if let Err(reason) = outcome {
            let own = reason.downcast_ref::<Fixed>().copied();
            let what = own.map_or_else(|| Said::as_is(reason.to_string()), Said::from);
            router.ledger().failed(Transport::Tcp, Whose::Peer(node.clone()), what);
            // Said once, not at each attempt of a night in harbour.
            if !told {
                tracing::warn!(%node, %reason, "not connected; trying again");
                told = true;
            }
        }
        let pause = wait.mul_f64(jitter());
        if stop.run_until_cancelled(tokio::time::sleep(pause)).await.is_none() {
            return;
        }
        wait = (wait * 2).min(BACK_OFF.1);
    }
}

async fn converse(stream: TcpStream, node: &str, router: &Router) -> anyhow::Result<()> {
    stream.set_nodelay(true)?;
    let socket = SockRef::from(&stream);
    socket.set_tcp_keepalive(&TcpKeepalive::new().with_time(ASK).with_interval(ASK))?;
    socket.set_tcp_user_timeout(Some(DEAD_AFTER))?;
    let (reader, writer) = stream.into_split();
    let peer =
        Peer { transport: Transport::Tcp, role: Role::Vessel, name: node.to_owned(), sources: Sources::Any };
    let connection = router.join(peer, OUTBOX_BYTES).await?;
    let outcome = tokio::select! {
        outcome = receive(reader, node, router.ledger(), |batch| connection.give(batch)) => outcome,
        outcome = send(writer, node, router.ledger(), &connection) => outcome,
    };
    connection.leave().await;
    outcome
}

async fn receive<Given: Future<Output = Result<(), Stopped>>>(
    mut reader: impl AsyncRead + Unpin,
    node: &str,
    ledger: &Ledger,
    mut give: impl FnMut(Vec<Incoming>) -> Given,
) -> anyhow::Result<()> {
    let (mut deframer, mut buffer) = (Deframer::new(), vec![0; READ_BYTES]);
    let (mut heard, mut told, mut looked) = (Instant::now(), false, false);
    loop {
        if let Ok(length) = tokio::time::timeout(LOOK, reader.read(&mut buffer)).await {
            let length = length?;
            if length == 0 {
                anyhow::bail!(fixed("the node closed the stream"));
            }
            if std::mem::take(&mut told) {
                tracing::info!(%node, silent_s = heard.elapsed().as_secs(), "the stream goes on");
            }
            (heard, looked) = (Instant::now(), false);
            deframer.push(&buffer[..length]);
        } else if heard.elapsed() >= SILENCE && !std::mem::replace(&mut told, true) {
            let silent =
                Said::from(say("silent for {s} s; the connection is open").with("s", SILENCE.as_secs()));
            tracing::warn!(%node, "{silent}");
            ledger.failed(Transport::Tcp, Whose::Peer(node.to_owned()), silent);
        }
        let mut batch = packets(&mut deframer, node);
        if batch.is_empty() && !looked && heard.elapsed() >= REST {
            looked = true;
            // A damaged length field waits for bytes that never arrive, with complete packets behind it. If there are none,
            // the rest of a packet is still on its way.
            let mut before = usize::MAX;
            while deframer.pending() < before && deframer.holds_packet() {
                before = deframer.pending();
                deframer.give_up();
                batch.extend(packets(&mut deframer, node));
            }
        }
        if !batch.is_empty() {
            give(batch).await?;
        }
    }
}

/// The complete packets received so far.
fn packets(deframer: &mut Deframer, node: &str) -> Vec<Incoming> {
    let mut batch = Vec::new();
    while let Some(frame) = deframer.next_frame() {
        match frame {
            Frame::Packet { view, .. } => batch.push(Incoming::from(Bytes::copy_from_slice(view.bytes()))),
            Frame::Damage(damage) => {
                metrics::counter!("lutra_damaged_bytes_total", "transport" => "tcp").increment(damage.bytes);
                tracing::debug!(%node, ?damage, "bytes that are not a packet");
            }
        }
    }
    batch
}

async fn send(
    mut writer: OwnedWriteHalf,
    node: &str,
    ledger: &Ledger,
    connection: &Connection,
) -> anyhow::Result<()> {
    loop {
        match connection.outbox.take_packets().await {
            Ok(packets) => {
                for packet in packets {
                    writer.write_all(&packet).await?;
                }
            }
            Err(overflow) => {
                tracing::error!(%node, %overflow, "what waited for the node is lost");
                let what = say("{overflow}: it is lost").with("overflow", overflow);
                ledger.failed(Transport::Tcp, Whose::Peer(node.to_owned()), what);
                connection.outbox.reopen();
            }
        }
    }
}
