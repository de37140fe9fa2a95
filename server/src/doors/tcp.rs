//! A stream to an IMC node, such as DUNE's TCP server: everything it says comes in, what is for it goes out.
//!
//! No announcement and no heartbeat is needed for the stream to start. A node that says nothing for
//! [`SILENCE`] is taken for gone (vehicles say something each second), and is connected to anew.

use crate::relay::{Connection, Relay};
use bytes::Bytes;
use hub::{Door, Incoming, Peer, Role, Sources};
use imc::{Deframer, Frame};
use std::time::{Duration, Instant};
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::TcpStream;
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio_util::sync::CancellationToken;

/// Bytes that may wait for the node: commands are few.
const OUTBOX_BYTES: usize = 256 * 1024;
const READ_BYTES: usize = 64 * 1024;
/// A node that was silent for this long is gone.
const SILENCE: Duration = Duration::from_secs(10);
/// How long the rest of a packet may take to come.
const REST: Duration = Duration::from_secs(2);
/// How often a stream on which nothing comes is looked at.
const LOOK: Duration = Duration::from_millis(500);
const CONNECT: Duration = Duration::from_secs(5);
/// A node that takes nothing for this long is gone.
const STALLED: Duration = Duration::from_secs(10);
/// Waits between attempts double from the first to the second of these.
const BACK_OFF: (Duration, Duration) = (Duration::from_secs(1), Duration::from_secs(15));

/// Between a half and one and a half, so that what was cut off at once does not come back at once.
fn jitter() -> f64 {
    // Without a source of randomness all wait alike, which is no harm.
    let word = getrandom::u32().unwrap_or(u32::MAX / 2);
    0.5 + f64::from(word) / f64::from(u32::MAX)
}

/// Connects to `node` (host:port) again and again until `stop`.
pub(super) async fn keep_connected(node: String, relay: Relay, stop: CancellationToken) {
    let mut wait = BACK_OFF.0;
    let mut told = false;
    loop {
        let attempt = async {
            let stream = tokio::time::timeout(CONNECT, TcpStream::connect(&node)).await??;
            tracing::info!(%node, "connected");
            (wait, told) = (BACK_OFF.0, false);
            converse(stream, &node, &relay).await
        };
        let outcome = stop.run_until_cancelled(attempt).await;
        let Some(outcome) = outcome else { return };
        if let Err(reason) = outcome {
            relay.ledger().failed(Door::Tcp, &format!("{node}: {reason}"));
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

async fn converse(stream: TcpStream, node: &str, relay: &Relay) -> anyhow::Result<()> {
    stream.set_nodelay(true)?;
    let (reader, writer) = stream.into_split();
    let peer = Peer { door: Door::Tcp, role: Role::Vessel, name: node.to_owned(), sources: Sources::Any };
    let connection = relay.join(peer, OUTBOX_BYTES).await?;
    let outcome = tokio::select! {
        outcome = receive(reader, node, &connection) => outcome,
        outcome = send(writer, &connection) => outcome,
    };
    connection.leave().await;
    outcome
}

async fn receive(mut reader: OwnedReadHalf, node: &str, connection: &Connection) -> anyhow::Result<()> {
    let (mut deframer, mut buffer) = (Deframer::new(), vec![0; READ_BYTES]);
    let (mut heard, mut progress) = (Instant::now(), Instant::now());
    loop {
        match tokio::time::timeout(LOOK, reader.read(&mut buffer)).await {
            Ok(length) => {
                let length = length?;
                if length == 0 {
                    anyhow::bail!("the node closed the stream");
                }
                heard = Instant::now();
                deframer.push(&buffer[..length]);
            }
            Err(_nothing_came) if heard.elapsed() >= SILENCE => {
                anyhow::bail!("silent for {} s", SILENCE.as_secs());
            }
            Err(_nothing_came) => {}
        }
        let mut batch = packets(&mut deframer, node);
        while batch.is_empty() && deframer.pending() > 0 && progress.elapsed() >= REST {
            // A damaged length claims what never comes, and whole packets wait behind it.
            let pending = deframer.pending();
            deframer.give_up();
            batch = packets(&mut deframer, node);
            if deframer.pending() == pending {
                break;
            }
        }
        if !batch.is_empty() || deframer.pending() == 0 {
            progress = Instant::now();
        }
        if !batch.is_empty() {
            connection.give(batch).await?;
        }
    }
}

/// The whole packets that came so far.
fn packets(deframer: &mut Deframer, node: &str) -> Vec<Incoming> {
    let mut batch = Vec::new();
    while let Some(frame) = deframer.next_frame() {
        match frame {
            Frame::Packet { view, .. } => batch.push(Incoming::from(Bytes::copy_from_slice(view.bytes()))),
            Frame::Damage(damage) => {
                metrics::counter!("lutra_damaged_bytes_total", "door" => "tcp").increment(damage.bytes);
                tracing::debug!(%node, ?damage, "bytes that are no packet");
            }
        }
    }
    batch
}

async fn send(mut writer: OwnedWriteHalf, connection: &Connection) -> anyhow::Result<()> {
    loop {
        for packet in connection.outbox.take().await? {
            tokio::time::timeout(STALLED, writer.write_all(&packet)).await??;
        }
    }
}
