//! The outgoing side of a WebSocket, bounded.
//!
//! Every ping is answered by a pong, which waits in memory until the peer takes it. A peer that sends pings and takes
//! nothing must not fill it: whoever reads the socket stops while [`Outgoing::waits`], and one that takes nothing for
//! [`PATIENCE`] is let go.

use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use futures_util::SinkExt as _;
use futures_util::stream::SplitSink;
use std::time::Duration;
use tokio::time::{Instant, timeout_at};

/// A peer that takes nothing for so long is let go.
pub(crate) const PATIENCE: Duration = Duration::from_secs(10);
/// Bytes that are read at once. The library's 128 KiB are taken for each socket, whatever comes.
const READ_AT_ONCE: usize = 16 * 1024;

/// An upgrade that reads messages of `read_bytes` at most, and that holds `waiting_bytes` at most of what its peer has
/// not taken: beyond it pongs replace each other, and sending fails, with which the socket ends.
pub(crate) fn bounded(
    upgrade: WebSocketUpgrade,
    read_bytes: usize,
    waiting_bytes: usize,
) -> WebSocketUpgrade {
    upgrade
        .read_buffer_size(READ_AT_ONCE)
        .write_buffer_size(READ_AT_ONCE.min(waiting_bytes / 2))
        .max_write_buffer_size(waiting_bytes)
        .max_message_size(read_bytes)
        .max_frame_size(read_bytes)
}

/// Why nothing more can be sent.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Ended {
    /// The peer takes nothing.
    TooSlow,
    /// The connection is gone.
    Gone,
}

/// The half of a socket that sends. What is put in leaves by [`Self::flushed`], which can be dropped and called again.
pub(crate) struct Outgoing {
    sink: SplitSink<WebSocket, Message>,
    /// Since when something waits.
    since: Option<Instant>,
}

impl Outgoing {
    pub(crate) fn new(sink: SplitSink<WebSocket, Message>) -> Self {
        Self { sink, since: None }
    }

    /// Whether something may not have left yet; nothing is to be put in and nothing more read until it has.
    pub(crate) fn waits(&self) -> bool {
        self.since.is_some()
    }

    /// A ping was read: the answer to it waits.
    pub(crate) fn answers_ping(&mut self) {
        self.since.get_or_insert_with(Instant::now);
    }

    /// Puts a message in. It does not wait where nothing [waits](Self::waits) but what was put in just before.
    ///
    /// # Errors
    /// The connection is gone, or the message is larger than all that may wait.
    pub(crate) async fn put(&mut self, message: Message) -> Result<(), Ended> {
        let since = *self.since.get_or_insert_with(Instant::now);
        match timeout_at(since + PATIENCE, self.sink.feed(message)).await {
            Ok(fed) => fed.map_err(|_| Ended::Gone),
            Err(_) => Err(Ended::TooSlow),
        }
    }

    /// Waits until everything has left.
    ///
    /// # Errors
    /// The peer takes nothing, or the connection is gone.
    pub(crate) async fn flushed(&mut self) -> Result<(), Ended> {
        let since = *self.since.get_or_insert_with(Instant::now);
        match timeout_at(since + PATIENCE, self.sink.flush()).await {
            Ok(Ok(())) => {
                self.since = None;
                Ok(())
            }
            Ok(Err(_)) => Err(Ended::Gone),
            Err(_) => Err(Ended::TooSlow),
        }
    }
}
