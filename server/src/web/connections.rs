//! Limits connections: in total, and to a share for each address.
//!
//! A connection keeps its place until its stream is closed, also as a WebSocket, so the number of open files stays within
//! the process's limit. Connections beyond an address's share are closed: one machine, however slowly it sends, cannot lock
//! out vessels and other users.

use shore::identity::network;
use std::collections::BTreeMap;
use std::io;
use std::net::IpAddr;
use std::pin::Pin;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::task::{Context, Poll, ready};
use std::time::Duration;
use tokio::io::{AsyncRead, AsyncWrite, ReadBuf};
use tokio::sync::{OwnedSemaphorePermit, Semaphore};
use tokio::time::{Sleep, sleep};

/// One address may have one part in so many of all places.
const SHARE: usize = 4;
/// Least number of places of an address.
const LEAST: usize = 8;
/// A peer that reads nothing for this long is disconnected.
const STALLED: Duration = Duration::from_mins(1);

/// Number of places by address, without zeros.
type Taken = Arc<Mutex<BTreeMap<IpAddr, usize>>>;

/// All places.
pub(crate) struct Places {
    all: Arc<Semaphore>,
    share: usize,
    taken: Taken,
    /// Proxies connect for many clients.
    proxies: Vec<IpAddr>,
}

/// A place, released when dropped.
pub(crate) struct Place {
    _permit: OwnedSemaphorePermit,
    of: IpAddr,
    taken: Taken,
}

impl Places {
    pub(crate) fn new(all: usize, proxies: &[IpAddr]) -> Self {
        let share = (all / SHARE).max(LEAST);
        let (all, taken) = (Arc::new(Semaphore::new(all)), Taken::default());
        Self { all, share, taken, proxies: proxies.to_vec() }
    }

    /// Waits until any place is free.
    pub(crate) async fn free(&self) -> Option<OwnedSemaphorePermit> {
        Arc::clone(&self.all).acquire_owned().await.ok()
    }

    /// Gives it to an address that has not reached its share.
    pub(crate) fn take(&self, permit: OwnedSemaphorePermit, from: IpAddr) -> Option<Place> {
        let of = network(from);
        let mut taken = lock(&self.taken);
        let count = taken.entry(of).or_default();
        if *count >= self.share && !self.proxies.contains(&from.to_canonical()) {
            return None;
        }
        *count += 1;
        Some(Place { _permit: permit, of, taken: Arc::clone(&self.taken) })
    }
}

impl Drop for Place {
    fn drop(&mut self) {
        let mut taken = lock(&self.taken);
        if let Some(count) = taken.get_mut(&self.of) {
            *count -= 1;
            if *count == 0 {
                taken.remove(&self.of);
            }
        }
    }
}

fn lock(taken: &Taken) -> MutexGuard<'_, BTreeMap<IpAddr, usize>> {
    taken.lock().unwrap_or_else(PoisonError::into_inner)
}

/// A stream with a place; writing fails if its peer reads nothing for too long.
pub(crate) struct Placed<S> {
    stream: S,
    _place: Place,
    patience: Duration,
    stalled: Option<Pin<Box<Sleep>>>,
}

impl<S> Placed<S> {
    pub(crate) fn new(stream: S, place: Place) -> Self {
        Self { stream, _place: place, patience: STALLED, stalled: None }
    }

    /// The result of a write, with a limit on how long it may be pending.
    fn within<T>(&mut self, context: &mut Context<'_>, written: Poll<io::Result<T>>) -> Poll<io::Result<T>> {
        if written.is_ready() {
            self.stalled = None;
            return written;
        }
        let patience = self.patience;
        let stalled = self.stalled.get_or_insert_with(|| Box::pin(sleep(patience)));
        ready!(stalled.as_mut().poll(context));
        Poll::Ready(Err(io::Error::new(io::ErrorKind::TimedOut, "the peer takes nothing")))
    }
}

impl<S: AsyncRead + Unpin> AsyncRead for Placed<S> {
    fn poll_read(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
        buffer: &mut ReadBuf<'_>,
    ) -> Poll<io::Result<()>> {
        Pin::new(&mut self.get_mut().stream).poll_read(context, buffer)
    }
}

impl<S: AsyncWrite + Unpin> AsyncWrite for Placed<S> {
    fn poll_write(self: Pin<&mut Self>, context: &mut Context<'_>, bytes: &[u8]) -> Poll<io::Result<usize>> {
        let this = self.get_mut();
        let written = Pin::new(&mut this.stream).poll_write(context, bytes);
        this.within(context, written)
    }

    fn poll_write_vectored(
        self: Pin<&mut Self>,
        context: &mut Context<'_>,
        parts: &[io::IoSlice<'_>],
    ) -> Poll<io::Result<usize>> {
        let this = self.get_mut();
        let written = Pin::new(&mut this.stream).poll_write_vectored(context, parts);
        this.within(context, written)
    }

    fn is_write_vectored(&self) -> bool {
        self.stream.is_write_vectored()
    }

    fn poll_flush(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.get_mut().stream).poll_flush(context)
    }

    fn poll_shutdown(self: Pin<&mut Self>, context: &mut Context<'_>) -> Poll<io::Result<()>> {
        Pin::new(&mut self.get_mut().stream).poll_shutdown(context)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};

    async fn take(places: &Places, from: &str) -> Option<Place> {
        let permit = places.free().await?;
        places.take(permit, from.parse().unwrap())
    }

    #[tokio::test]
    async fn an_address_gets_its_share_and_no_more() {
        let places = Places::new(64, &["10.0.0.9".parse().unwrap()]);
        let mut held = Vec::new();
        for _ in 0..16 {
            held.push(take(&places, "10.0.0.1").await.expect("of its share"));
        }
        assert!(take(&places, "10.0.0.1").await.is_none());
        assert!(take(&places, "::ffff:10.0.0.1").await.is_none(), "the same address");
        assert!(take(&places, "10.0.0.2").await.is_some());
        for _ in 0..20 {
            held.push(take(&places, "10.0.0.9").await.expect("a proxy connects for many"));
        }
        for last in 1..=16 {
            held.push(take(&places, &format!("2001:db8::{last}")).await.expect("of the network's share"));
        }
        assert!(take(&places, "2001:db8::77").await.is_none());
        held.clear();
        assert!(take(&places, "10.0.0.1").await.is_some());
        assert!(lock(&places.taken).is_empty(), "nothing is kept of who is gone");
    }

    #[tokio::test]
    async fn a_place_is_free_again_when_its_stream_is_gone() {
        let places = Places::new(1, &[]);
        let (ours, _theirs) = tokio::io::duplex(8);
        let stream = Placed::new(ours, take(&places, "10.0.0.1").await.unwrap());
        assert_eq!(places.all.available_permits(), 0);
        drop(stream);
        assert_eq!(places.all.available_permits(), 1);
    }

    #[tokio::test]
    async fn who_takes_nothing_is_let_go() {
        let places = Places::new(8, &[]);
        let (ours, mut theirs) = tokio::io::duplex(8);
        let mut stream = Placed::new(ours, take(&places, "10.0.0.1").await.unwrap());
        let (written, read) =
            tokio::join!(stream.write_all(&[7; 80]), async { theirs.read_exact(&mut [0; 80]).await });
        assert!(written.is_ok() && read.is_ok() && stream.stalled.is_none());
        stream.patience = Duration::from_millis(20);
        assert_eq!(stream.write_all(&[7; 80]).await.unwrap_err().kind(), io::ErrorKind::TimedOut);
    }
}
