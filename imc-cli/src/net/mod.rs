//! Links to other systems: UDP, TCP, and WebSocket to an IMCProxy.

pub(crate) mod node;
pub(crate) mod peer;
pub(crate) mod tcp;
pub(crate) mod udp;
pub(crate) mod ws;

use crate::sink::{Flow, Sink};
use std::time::{Duration, Instant};

/// A connection with another system.
pub(crate) trait Link {
    /// Sends one packet.
    ///
    /// # Errors
    /// When it cannot be sent.
    fn send(&mut self, packet: &[u8]) -> anyhow::Result<()>;

    /// Waits for at most this long and passes received data to the sink.
    ///
    /// # Errors
    /// When the sink fails. A lost link is [`Flow::Closed`].
    fn receive(&mut self, wait: Duration, sink: &mut Sink<'_>) -> anyhow::Result<Flow>;

    /// Closes the connection so that no sent data are lost.
    fn close(&mut self);
}

/// When to stop, if ever.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Deadline(Option<Instant>);

impl Deadline {
    /// After this long; never if that is beyond the clock's range.
    pub(crate) fn after(span: Option<Duration>) -> Self {
        Self(span.and_then(|span| Instant::now().checked_add(span)))
    }

    /// How long to wait now, at most `longest`; `None` when it is over.
    pub(crate) fn wait(self, longest: Duration) -> Option<Duration> {
        let Some(end) = self.0 else { return Some(longest) };
        let left = end.saturating_duration_since(Instant::now());
        (!left.is_zero()).then(|| left.min(longest))
    }
}

/// Parses a positive number of seconds from a flag.
pub(crate) fn seconds(text: &str) -> Result<Duration, String> {
    let seconds: f64 = text.parse().map_err(|_| "expected seconds, such as 2.5".to_owned())?;
    Duration::try_from_secs_f64(seconds).map_err(|error| error.to_string())
}

/// Whether a read error is only a timeout.
fn is_timeout(error: &std::io::Error) -> bool {
    use std::io::ErrorKind::{Interrupted, TimedOut, WouldBlock};
    matches!(error.kind(), WouldBlock | TimedOut | Interrupted)
}
