//! A simulated fault: the link of one Otter is cut, and restored.
//!
//! Its agent reaches the server by a TCP relay in this program. While cut, the relay silently carries nothing, like a radio
//! out of range: both ends must detect it, as they would at sea. Connections from before and during the cut are dead
//! afterwards, so that the vessel's link must reconnect and send what was missed.

use super::fleet::Otter;
use crate::AppState;
use crate::cli::say::say;
use imc::Address;
use shore::clock;
use std::io;
use std::net::{Ipv4Addr, SocketAddr};
use std::time::Duration;
use store::{Reader, Source, TimeRange};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;
use tokio_util::sync::CancellationToken;
use units::UtcTime;

/// How often the history is checked for the missed data.
const LOOK_EVERY: Duration = Duration::from_millis(250);
/// If they are missing for longer, something is wrong.
const LONGEST_RETURN: Duration = Duration::from_mins(1);
/// Pause after a failed accept.
const PAUSE: Duration = Duration::from_millis(200);
/// Most positions that are counted.
const COUNTED: usize = 1_000_000;

/// When a link is cut.
#[derive(Debug, Clone, Copy)]
pub(super) struct Times {
    /// For the first time, after its vessel began to sail.
    pub(super) first: Duration,
    /// How long.
    pub(super) lasts: Duration,
    /// From one cut to the next.
    pub(super) every: Duration,
}

/// A TCP relay to the server that can be cut.
#[derive(Debug)]
pub(super) struct Wire {
    /// Where it listens.
    pub(super) address: SocketAddr,
    /// Counts cuts and repairs: odd while it is cut.
    changes: watch::Sender<u32>,
}

impl Wire {
    /// Starts a relay to `server`, until `stop`.
    ///
    /// # Errors
    /// Loopback has no free port.
    pub(super) async fn lay(server: SocketAddr, stop: CancellationToken) -> io::Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, 0)).await?;
        let address = listener.local_addr()?;
        let (changes, seen) = watch::channel(0);
        tokio::spawn(stop.clone().run_until_cancelled_owned(async move {
            loop {
                match listener.accept().await {
                    Ok((stream, _)) => {
                        let carried = carry(stream, server, seen.clone());
                        tokio::spawn(stop.clone().run_until_cancelled_owned(carried));
                    }
                    Err(_) => tokio::time::sleep(PAUSE).await,
                }
            }
        }));
        Ok(Self { address, changes })
    }

    /// Cuts it, or restores it.
    fn change(&self) {
        self.changes.send_modify(|count| *count += 1);
    }
}

/// Carries bytes both ways until an end closes or the relay is cut; then holds both ends open until it is restored.
async fn carry(mut near: TcpStream, server: SocketAddr, mut changes: watch::Receiver<u32>) {
    let is_whole = |count: &u32| count.is_multiple_of(2);
    let (begun, mut far) = (*changes.borrow(), None);
    if is_whole(&begun) {
        let Ok(mut stream) = TcpStream::connect(server).await else { return };
        near.set_nodelay(true).and_then(|()| stream.set_nodelay(true)).ok();
        tokio::select! {
            biased;
            _ = changes.wait_for(|count| *count != begun) => far = Some(stream),
            _ = tokio::io::copy_bidirectional(&mut near, &mut stream) => return,
        }
    }
    changes.wait_for(is_whole).await.ok();
    drop((near, far));
}

/// Cuts the relay periodically, and prints what can be observed.
pub(super) async fn again_and_again(wire: Wire, otter: Otter, times: Times, state: AppState, url: String) {
    let (name, page) = (&otter.name, format!("{url}/vessels/{}", otter.address.0));
    let lasts_s = times.lasts.as_secs();
    tokio::time::sleep(times.first).await;
    loop {
        let begun = clock::now();
        wire.change();
        say!(
            "{name:<9} LINK CUT by this demo, for {lasts_s} s. See {page}?tab=Link+loss, and the alarm on every page"
        );
        tokio::time::sleep(times.lasts).await;
        let ended = clock::now();
        wire.change();
        say!("{name:<9} the link may come back");
        match filled(&state, otter.address, begun, ended).await {
            Some((positions, after)) => say!(
                "{name:<9} gap filled {:.1} s later: {positions} positions of those {lasts_s} s came from aboard. See \
                 {page}?span=300",
                after.as_secs_f64()
            ),
            None => say!("{name:<9} what it kept aboard did not come within {} s", LONGEST_RETURN.as_secs()),
        }
        tokio::time::sleep(times.every.saturating_sub(times.lasts)).await;
    }
}

/// Waits until the history has records from after the cut, and so everything before, as records arrive in order. Returns
/// the positions during the cut, and how long that took.
async fn filled(
    state: &AppState,
    vessel: Address,
    begun: UtcTime,
    ended: UtcTime,
) -> Option<(usize, Duration)> {
    let since = tokio::time::Instant::now();
    let mut looks = tokio::time::interval(LOOK_EVERY);
    while since.elapsed() < LONGEST_RETURN {
        looks.tick().await;
        let look = move |reader: &mut Reader| {
            let later = positions(reader, vessel, TimeRange::new(Some(ended), None), 1)?;
            if later == 0 {
                return Ok(None);
            }
            positions(reader, vessel, TimeRange::new(Some(begun), Some(ended)), COUNTED).map(Some)
        };
        if let Ok(Some(count)) = state.shore.history.ask(look).await {
            return Some((count, since.elapsed()));
        }
    }
    None
}

/// Number of positions of a vessel in a range of time.
fn positions(reader: &mut Reader, vessel: Address, range: TimeRange, most: usize) -> store::Result<usize> {
    let series = reader.series(Some(vessel))?;
    let estimates = series.into_iter().filter(|series| series.message == Some("EstimatedState"));
    let Some(most_often) = estimates.max_by_key(|series| series.extent.count) else { return Ok(0) };
    let source =
        Source { system: vessel, entity: most_often.group.src_ent, message: "EstimatedState".to_owned() };
    Ok(reader.samples(&source, &["u"], range, most)?.time_us.len())
}

#[cfg(test)]
mod tests {
    use super::*;
    use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};

    #[tokio::test]
    async fn a_cut_wire_carries_nothing_and_says_nothing_and_its_connections_end_with_the_cut() {
        let server = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let stop = CancellationToken::new();
        let wire = Wire::lay(server.local_addr().unwrap(), stop.clone()).await.unwrap();
        let mut before = TcpStream::connect(wire.address).await.unwrap();
        let (mut far, _) = server.accept().await.unwrap();
        let mut heard = [0; 4];
        before.write_all(b"ping").await.unwrap();
        far.read_exact(&mut heard).await.unwrap();
        far.write_all(b"pong").await.unwrap();
        before.read_exact(&mut heard).await.unwrap();
        assert_eq!(&heard, b"pong");

        wire.change();
        before.write_all(b"lost").await.unwrap();
        wire.change();
        // Bytes sent during the cut never arrive, and the connection is dead for both.
        assert!(matches!(far.read(&mut heard).await, Ok(0) | Err(_)));
        assert!(matches!(before.read(&mut heard).await, Ok(0) | Err(_)));

        let mut after = TcpStream::connect(wire.address).await.unwrap();
        let (mut far, _) = server.accept().await.unwrap();
        after.write_all(b"back").await.unwrap();
        far.read_exact(&mut heard).await.unwrap();
        assert_eq!(&heard, b"back");
        stop.cancel();
        assert!(matches!(after.read(&mut heard).await, Ok(0) | Err(_)));
    }
}
