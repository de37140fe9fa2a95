//! The shore side of the vessel link, without its sockets: the server opens those at `/link`, each with the token of one
//! vessel.
//!
//! Every vessel has one task (`vessel`) that owns its [`link::Shore`] over all its connections, from the first
//! connection until the server ends. A connection has two halves: incoming messages are passed to the vessel's task, and
//! its outgoing messages are written. A connection that does not drain the task's bounded channel is closed.

mod chart;
mod figures;
mod named;
mod orders;
mod vessel;
mod ways;

use crate::charts::{Charts, ChartsAboard};
use crate::recorder::Recorder;
use crate::router::Router;
use api::VesselChart;
use bytes::Bytes;
use imc::Address;
use link::{ConnectionId, ShoreStatus, WaysReport};
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::Duration;
use tokio::sync::{mpsc, watch};
use tokio_util::sync::CancellationToken;
use tokio_util::task::TaskTracker;

/// Messages of all its connections that may wait for a vessel's task; connections wait beyond that.
const WAITING: usize = 64;
/// Messages that may wait for one connection; beyond that it is closed. Data comes up, so little goes down.
pub const OUTGOING: usize = 256;

/// An event from a connection to its vessel's task.
pub enum Event {
    /// It is open; messages sent into the channel are written to it, and dropping the channel closes it.
    Opened(ConnectionId, mpsc::Sender<Out>),
    /// A message came.
    Message(ConnectionId, Bytes),
    /// It is closed.
    Closed(ConnectionId),
}

/// An instruction from a vessel's task to a connection.
pub enum Out {
    /// Write this.
    Message(Bytes),
    /// Close, saying why.
    Close(String),
}

/// All vessels that have connected by link since the start; cheap to clone.
#[derive(Clone)]
pub struct Links {
    shared: Arc<Shared>,
}

struct Shared {
    router: Router,
    recorder: Recorder,
    charts: Charts,
    aboard: ChartsAboard,
    tasks: TaskTracker,
    stop: CancellationToken,
    vessels: Mutex<BTreeMap<u16, Handle>>,
    connections: AtomicU64,
}

/// Handle of a vessel's task.
#[derive(Clone)]
struct Handle {
    events: mpsc::Sender<Event>,
    status: watch::Receiver<ShoreStatus>,
    ways: watch::Receiver<Option<WaysReport>>,
    /// Stick positions that came too late or never.
    late: Arc<AtomicU64>,
    /// The vessel's index, in the order of first connection.
    index: usize,
}

impl Links {
    /// The transport behind `/link`.
    pub fn new(
        router: Router,
        recorder: Recorder,
        (charts, aboard): (Charts, ChartsAboard),
        tasks: TaskTracker,
        stop: CancellationToken,
    ) -> Self {
        let (vessels, connections) = (Mutex::default(), AtomicU64::new(1));
        let shared = Shared { router, recorder, charts, aboard, tasks, stop, vessels, connections };
        Self { shared: Arc::new(shared) }
    }

    /// Which chart a vessel holds, compared with the one ashore.
    pub fn chart(&self, vessel: Address) -> VesselChart {
        let ashore = self.shared.charts.offered().borrow().as_ref().map(|package| package.digest());
        self.shared.aboard.chart(vessel, ashore)
    }

    /// State of the links of all vessels.
    pub fn status(&self) -> Vec<(Address, ShoreStatus)> {
        let vessels = self.shared.vessels.lock().unwrap_or_else(PoisonError::into_inner);
        vessels.iter().map(|(address, handle)| (Address(*address), *handle.status.borrow())).collect()
    }

    /// The last report of a vessel with several ways (network paths) to the shore.
    pub fn ways(&self, vessel: Address) -> Option<WaysReport> {
        let vessels = self.shared.vessels.lock().unwrap_or_else(PoisonError::into_inner);
        let ways = vessels.get(&vessel.0)?.ways.borrow();
        ways.clone()
    }

    /// How many stick positions came to a vessel too late or never, since the start.
    pub fn late_sticks(&self, vessel: Address) -> u64 {
        let vessels = self.shared.vessels.lock().unwrap_or_else(PoisonError::into_inner);
        vessels.get(&vessel.0).map_or(0, |handle| handle.late.load(Ordering::Relaxed))
    }

    /// Last round-trip time of a vessel's link; `None` while it is down.
    pub fn round_trip(&self, vessel: Address) -> Option<Duration> {
        let vessels = self.shared.vessels.lock().unwrap_or_else(PoisonError::into_inner);
        let status = *vessels.get(&vessel.0)?.status.borrow();
        status.round_trip.filter(|_| status.up)
    }

    /// The channel to the task of a vessel; the first connection starts it.
    pub fn vessel(&self, address: u16) -> mpsc::Sender<Event> {
        let shared = &self.shared;
        let mut vessels = shared.vessels.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(handle) = vessels.get(&address).filter(|handle| !handle.events.is_closed()) {
            return handle.events.clone();
        }
        // A task that panicked does not lock its vessel out: a new one takes its place and its index.
        let lost = vessels.remove(&address);
        if lost.is_some() && !shared.stop.is_cancelled() {
            tracing::error!(vessel = %Address(address), "the task of the link was lost to a fault, and is started again");
        }
        let index = lost.map_or(vessels.len(), |lost| lost.index);
        let (events, coming) = mpsc::channel(WAITING);
        let (told, status) = watch::channel(ShoreStatus::default());
        let (told_ways, ways) = watch::channel(None);
        let late = Arc::new(AtomicU64::new(0));
        let task = vessel::Task::new(
            Address(address),
            shared.router.clone(),
            shared.recorder.clone(),
            (shared.charts.offered(), shared.aboard.clone()),
            (told, told_ways),
            Arc::clone(&late),
            index,
        );
        shared.tasks.spawn(task.run(coming, shared.stop.clone()));
        vessels.insert(address, Handle { events: events.clone(), status, ways, late, index });
        events
    }

    /// A number for a new connection.
    pub fn next_connection(&self) -> ConnectionId {
        ConnectionId(self.shared.connections.fetch_add(1, Ordering::Relaxed))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[tokio::test]
    async fn a_vessel_whose_task_was_lost_comes_in_again_by_a_new_one() {
        let folder = tempfile::tempdir().unwrap();
        let hub = hub::Settings { address: Address(0x4F00), name: "shore".into(), active: false };
        let settings = crate::Settings {
            data: folder.path().to_owned(),
            hub,
            trusted: Vec::new(),
            people: crate::identity::Settings::default(),
            charts: crate::charts::Settings::default(),
            sinks: crate::sinks::Settings::default(),
            notices: crate::notices::Settings::default(),
            compress_after_days: 0,
            compress_months_after_days: 0,
            most_unpacked_bytes: 1 << 20,
        };
        let running =
            crate::Opened::open(settings, crate::clock::Clock::real()).unwrap().assemble().await.unwrap();
        let links = &running.shore.links;
        let events = links.vessel(0x2810);
        let other = links.vessel(0x2811);
        assert!(events.same_channel(&links.vessel(0x2810)), "one task for each vessel");
        // As after a panic: no task receives the connections' events.
        let lost = mpsc::channel(1).0;
        let index = {
            let mut vessels = links.shared.vessels.lock().unwrap();
            let handle = vessels.get_mut(&0x2810).unwrap();
            handle.events = lost;
            handle.index
        };
        let events = links.vessel(0x2810);
        assert!(!events.is_closed());
        assert!(events.same_channel(&links.vessel(0x2810)) && other.same_channel(&links.vessel(0x2811)));
        assert_eq!(
            links.shared.vessels.lock().unwrap()[&0x2810].index,
            index,
            "its figures keep their numbers"
        );
        running.shore.stop.cancel();
        running.end().await;
    }
}
