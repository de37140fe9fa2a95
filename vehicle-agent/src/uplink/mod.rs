//! The uplink to the shore: a queue that the loop fills without waiting, and a thread that spools and sends.
//!
//! The loop's side is [`Uplink`]. Its queue holds 4 MiB; packets that arrive while it is full are counted and declared as a
//! gap of the record. The thread puts everything on disk first ([`spool`]), speaks the protocol of [`link`] with the shore,
//! and passes commands on as they arrive. A panic of the thread is logged and it starts over: neither the voyage nor its
//! recording ends.

mod chart;
mod filter;
mod queue;
mod server;
mod settings;
mod socket;
mod spool;
mod sync;
#[cfg(test)]
mod tests;
mod ways;
mod worker;

pub(crate) use settings::UplinkSettings;

use crate::clock::Clock;
use crate::disk::InUse;
use crate::ending::UPLINK_THREADS;
use anyhow::Context as _;
use link::ChartAboard;
use queue::Queue;
use spool::Spool;
use std::os::unix::net::UnixStream;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Mutex, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use worker::Worker;

/// How long the end of the program waits for the last packets to be on disk.
const END_WITHIN: Duration = Duration::from_secs(3);
/// Interval of attempts to open a spool after a failure.
const OPEN_EVERY: Duration = Duration::from_secs(5);
/// Pause after a panic before the thread starts over: a recurring one must not fill the log.
const ANEW_AFTER: Duration = Duration::from_secs(1);
const LOOK_EVERY: Duration = Duration::from_millis(5);

/// Connects to the shore as the vessel would, by each of its ways, and disconnects. Returns what was reached.
///
/// # Errors
/// Why the shore is not reached or refuses.
pub(crate) fn reach(settings: &UplinkSettings, patience: Duration) -> Result<String, String> {
    let (mut reached, mut failed) = (Vec::new(), Vec::new());
    for door in &settings.ways {
        match socket::connect(door, patience, &socket::Carried::default()) {
            Ok(_) => reached.push(door.called()),
            Err((_, why)) if settings.ways.len() > 1 => failed.push(format!("{}: {why}", door.way.name)),
            Err((_, why)) => failed.push(why),
        }
    }
    if failed.is_empty() { Ok(reached.join(", ")) } else { Err(failed.join("; ")) }
}

/// A message from the shore, or from the uplink itself.
#[derive(Debug)]
pub(crate) enum FromShore<'a> {
    /// The spool could not store packets, and why.
    NotSpooled(String),
    /// The controller of the vessel.
    Lease(onboard::Lease),
    /// A packet for the vessel.
    Order {
        /// Under what it comes.
        mandate: onboard::Mandate,
        /// The packet.
        packet: &'a [u8],
    },
    /// A chart of the shore's is on the disk.
    Chart(onboard::ChartFile),
}

/// Processes a message of the shore; an error says why it is refused.
pub(crate) type Deliver = Box<dyn FnMut(FromShore<'_>) -> Result<(), String> + Send>;

/// The loop's side of the uplink.
#[derive(Debug)]
pub(crate) struct Uplink {
    queue: Arc<Queue>,
    /// Returns whether it ended normally.
    thread: Option<JoinHandle<bool>>,
    clock: Clock,
}

impl Uplink {
    /// Opens the spool and starts the thread. A disk fault must not keep a vessel from sailing: the thread tries again, and
    /// packets without room in the queue until then are declared as a gap.
    ///
    /// # Errors
    /// When another agent uses the spool, or the thread cannot be started.
    pub(crate) fn start(
        settings: UplinkSettings,
        chart: ChartAboard,
        clock: Clock,
        deliver: Deliver,
    ) -> anyhow::Result<Self> {
        let opened = match open(&settings, &clock) {
            Ok(spool) => Some(spool),
            Err(error) if error.is::<InUse>() => return Err(error),
            Err(error) => {
                tracing::error!("uplink: {error:#}; tried again every {} s", OPEN_EVERY.as_secs());
                None
            }
        };
        let (queue, wake) = Queue::new().context("making the queue to the shore")?;
        queue.put_chart(chart);
        let queue = Arc::new(queue);
        let shared = Arc::clone(&queue);
        let its_clock = clock.clone();
        let work = move || work(&settings, &shared, &its_clock, &wake, opened, deliver);
        let thread = std::thread::Builder::new().name(UPLINK_THREADS.to_owned()).spawn(work)?;
        Ok(Self { queue, thread: Some(thread), clock })
    }

    /// Queues a packet of the vessel. Never waits; it is sent with the next [`Uplink::flush`].
    pub(crate) fn record(&self, packet: &[u8]) {
        self.queue.put(self.clock.utc(), packet);
    }

    /// Wakes the thread for the queued packets: those of one cycle go to disk and ashore together.
    pub(crate) fn flush(&self) {
        self.queue.flush();
    }

    /// Sets the chart aboard, for the report to the shore.
    pub(crate) fn chart(&self, chart: ChartAboard) {
        self.queue.put_chart(chart);
    }

    /// Puts the queue on disk and closes the link; returns whether that was done in time.
    pub(crate) fn end(mut self) -> bool {
        self.queue.end();
        let Some(thread) = self.thread.take() else { return true };
        let until = Instant::now() + END_WITHIN;
        while !thread.is_finished() && Instant::now() < until {
            std::thread::sleep(LOOK_EVERY);
        }
        thread.is_finished() && thread.join().unwrap_or(false)
    }
}

/// Works until the end of the program, again after each panic; returns whether it ended normally. Packets lost in a panic
/// are declared by the spool, which was not closed.
fn work(
    settings: &UplinkSettings,
    queue: &Arc<Queue>,
    clock: &Clock,
    wake: &UnixStream,
    mut opened: Option<Spool>,
    deliver: Deliver,
) -> bool {
    let deliver = Arc::new(Mutex::new(deliver));
    loop {
        let spool = opened.take();
        let run = catch_unwind(AssertUnwindSafe(|| -> std::io::Result<()> {
            if let Some(spool) = spool.or_else(|| open_later(settings, queue, clock)) {
                let deliver = Arc::clone(&deliver);
                let deliver: Deliver =
                    Box::new(move |packet| deliver.lock().unwrap_or_else(PoisonError::into_inner)(packet));
                let wake = wake.try_clone()?;
                Worker::new(settings.clone(), spool, Arc::clone(queue), clock.clone(), wake, deliver).run();
            }
            Ok(())
        }));
        match run {
            Ok(Ok(())) => return true,
            Ok(Err(error)) => tracing::error!("uplink: {error}"),
            // The panic hook has logged it.
            Err(_) => {}
        }
        if queue.is_ending() {
            return false;
        }
        tracing::error!("uplink: starts over after a fault of its own");
        let begun = Instant::now();
        while begun.elapsed() < ANEW_AFTER && !queue.is_ending() {
            std::thread::sleep(LOOK_EVERY * 10);
        }
    }
}

fn open(settings: &UplinkSettings, clock: &Clock) -> anyhow::Result<Spool> {
    let (spool, remarks) = Spool::open(&settings.spool, settings.bounds, clock.utc())?;
    for remark in remarks {
        tracing::warn!("spool: {remark}");
    }
    Ok(spool)
}

/// Tries until the spool can be opened; `None` if the program ends before that.
fn open_later(settings: &UplinkSettings, queue: &Queue, clock: &Clock) -> Option<Spool> {
    let mut next = clock.elapsed() + OPEN_EVERY;
    while !queue.is_ending() {
        std::thread::sleep(LOOK_EVERY * 10);
        if clock.elapsed() >= next {
            next = clock.elapsed() + OPEN_EVERY;
            if let Ok(spool) = open(settings, clock) {
                tracing::info!("uplink: the spool is open");
                return Some(spool);
            }
        }
    }
    None
}
