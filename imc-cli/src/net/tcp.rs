//! TCP: packets back to back, as a DUNE's TCP server sends them to every client at once.

use super::{Link, is_timeout, peer};
use crate::input::CHUNK;
use crate::sink::{Flow, Sink};
use anyhow::Context as _;
use imc::Deframer;
use std::io::{Read as _, Write as _};
use std::net::{Shutdown, TcpStream};
use std::time::{Duration, Instant};

/// How long to wait for the other side to read the last bytes.
const CLOSE_WAIT: Duration = Duration::from_secs(1);

/// A connection.
pub(crate) struct TcpLink {
    address: String,
    stream: TcpStream,
    deframer: Deframer,
    chunk: Vec<u8>,
}

impl TcpLink {
    /// Connects to `HOST:PORT`.
    ///
    /// # Errors
    /// When there is no such host or it does not answer.
    pub(crate) fn connect(address: &str) -> anyhow::Result<Self> {
        let stream = peer::connect(address)?;
        Ok(Self { address: address.to_owned(), stream, deframer: Deframer::new(), chunk: vec![0; CHUNK] })
    }

    fn show(&mut self, sink: &mut Sink<'_>) -> anyhow::Result<Flow> {
        let mut flow = Flow::More;
        while flow == Flow::More
            && let Some(frame) = self.deframer.next_frame()
        {
            flow = sink.frame(&frame, &self.address)?;
        }
        sink.flush()?;
        Ok(flow)
    }
}

impl Link for TcpLink {
    fn send(&mut self, packet: &[u8]) -> anyhow::Result<()> {
        self.stream.write_all(packet).with_context(|| format!("cannot send to {}", self.address))
    }

    fn receive(&mut self, wait: Duration, sink: &mut Sink<'_>) -> anyhow::Result<Flow> {
        self.stream.set_read_timeout(Some(wait))?;
        let closed = match self.stream.read(&mut self.chunk) {
            Ok(0) => "the other side closed the connection".to_owned(),
            Ok(count) => {
                self.deframer.push(&self.chunk[..count]);
                return self.show(sink);
            }
            Err(error) if is_timeout(&error) => return Ok(Flow::More),
            Err(error) => error.to_string(),
        };
        self.deframer.finish();
        Ok(match self.show(sink)? {
            Flow::More => Flow::Closed(closed),
            flow => flow,
        })
    }

    /// Ends the sending half and reads until the other side ends its own: closing with unread bytes would
    /// reset the connection, and what was sent could be lost.
    fn close(&mut self) {
        let deadline = Instant::now() + CLOSE_WAIT;
        let mut open = self.stream.shutdown(Shutdown::Write).is_ok();
        while open && Instant::now() < deadline {
            self.stream.set_read_timeout(Some(CLOSE_WAIT)).ok();
            open = self.stream.read(&mut self.chunk).is_ok_and(|count| count > 0);
        }
    }
}
