//! The outgoing side of a WebSocket, bounded.
//!
//! Every ping is answered by a pong, which waits in memory until the peer reads it. A peer that sends pings and reads
//! nothing must not fill the memory: the reading half stops while [`Outgoing::waits`], and a peer that reads nothing for
//! [`PATIENCE`] is disconnected.

use super::error::ApiError;
use api::say;
use axum::extract::FromRequestParts;
use axum::extract::ws::{Message, WebSocket, WebSocketUpgrade};
use axum::http::request::Parts;
use axum::response::IntoResponse as _;
use futures_util::SinkExt as _;
use futures_util::stream::SplitSink;
use std::time::Duration;
use tokio::time::{Instant, timeout_at};

/// A peer that reads nothing for this long is disconnected.
pub(crate) const PATIENCE: Duration = Duration::from_secs(10);
/// Size of the read buffer. The library's default of 128 KiB would be allocated for each socket.
const READ_AT_ONCE: usize = 16 * 1024;

/// A request for a WebSocket; another is refused with what to do instead.
pub(crate) struct Upgrade(pub(crate) WebSocketUpgrade);

impl<S: Send + Sync> FromRequestParts<S> for Upgrade {
    type Rejection = ApiError;
    async fn from_request_parts(parts: &mut Parts, state: &S) -> Result<Self, ApiError> {
        let upgrade = WebSocketUpgrade::from_request_parts(parts, state).await;
        upgrade.map(Self).map_err(|error| {
            let text = say("This address is a WebSocket: connect to it by ws:// or wss://");
            ApiError::malformed(error.into_response().status(), text)
        })
    }
}

/// An upgrade that reads messages of at most `read_bytes`, and queues at most `waiting_bytes` that its peer has not read:
/// beyond that pongs replace each other, and sending fails, which ends the socket.
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
    /// The peer reads nothing.
    TooSlow,
    /// The connection is gone.
    Gone,
}

/// The sending half of a socket. Queued messages are sent by [`Self::flushed`], which can be cancelled and called again.
pub(crate) struct Outgoing {
    sink: SplitSink<WebSocket, Message>,
    /// Since when messages are queued.
    since: Option<Instant>,
}

impl Outgoing {
    pub(crate) fn new(sink: SplitSink<WebSocket, Message>) -> Self {
        Self { sink, since: None }
    }

    /// Whether a message may not have been sent yet; until then nothing may be queued or read.
    pub(crate) fn waits(&self) -> bool {
        self.since.is_some()
    }

    /// A ping was read: its pong is queued.
    pub(crate) fn answers_ping(&mut self) {
        self.since.get_or_insert_with(Instant::now);
    }

    /// Queues a message. It does not wait if nothing [waits](Self::waits) except messages queued just before.
    ///
    /// # Errors
    /// The connection is gone, or the message is larger than the queue.
    pub(crate) async fn put(&mut self, message: Message) -> Result<(), Ended> {
        let since = *self.since.get_or_insert_with(Instant::now);
        match timeout_at(since + PATIENCE, self.sink.feed(message)).await {
            Ok(fed) => fed.map_err(|_| Ended::Gone),
            Err(_) => Err(Ended::TooSlow),
        }
    }

    /// Waits until everything has been sent.
    ///
    /// # Errors
    /// The peer reads nothing, or the connection is gone.
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
