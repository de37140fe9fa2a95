//! The vessel link's door: WebSockets at `/link`, each opened with the token of one vessel.
//!
//! Every vessel has one task ([`vessel`]) that owns its [`link::Shore`] over all its connections, from the first
//! connection until the server ends. A connection is two halves: what comes is handed to the vessel's task, what
//! the task says is written. A connection that takes nothing is closed by the task's bounded channel.

mod chart;
mod figures;
mod socket;
mod vessel;

pub(crate) use socket::open;

use crate::charts::{Charts, ChartsAboard};
use crate::relay::{Recorder, Relay};
use api::VesselChart;
use bytes::Bytes;
use imc::Address;
use link::{ConnectionId, ShoreStatus};
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
const OUTGOING: usize = 256;

/// What a connection tells its vessel's task.
enum Event {
    /// It is there; what is sent into the channel is written to it, and its end closes it.
    Opened(ConnectionId, mpsc::Sender<Out>),
    /// A message came.
    Message(ConnectionId, Bytes),
    /// It is gone.
    Closed(ConnectionId),
}

/// What a vessel's task tells a connection.
enum Out {
    /// Write this.
    Message(Bytes),
    /// Close, saying why.
    Close(String),
}

/// All vessels that came in by the link since the start; cheap to clone.
#[derive(Clone)]
pub(crate) struct Links {
    shared: Arc<Shared>,
}

struct Shared {
    relay: Relay,
    recorder: Recorder,
    charts: Charts,
    aboard: ChartsAboard,
    tasks: TaskTracker,
    stop: CancellationToken,
    vessels: Mutex<BTreeMap<u16, Handle>>,
    connections: AtomicU64,
}

/// The way to a vessel's task.
#[derive(Clone)]
struct Handle {
    events: mpsc::Sender<Event>,
    status: watch::Receiver<ShoreStatus>,
    /// Stick positions that came too late or never.
    late: Arc<AtomicU64>,
}

impl Links {
    /// The door, for which `/link` is the way in.
    pub(crate) fn new(
        relay: Relay,
        recorder: Recorder,
        (charts, aboard): (Charts, ChartsAboard),
        tasks: TaskTracker,
        stop: CancellationToken,
    ) -> Self {
        let (vessels, connections) = (Mutex::default(), AtomicU64::new(1));
        let shared = Shared { relay, recorder, charts, aboard, tasks, stop, vessels, connections };
        Self { shared: Arc::new(shared) }
    }

    /// Which chart a vessel holds, beside the one ashore.
    pub(crate) fn chart(&self, vessel: Address) -> VesselChart {
        let ashore = self.shared.charts.offered().borrow().as_ref().map(|parcel| parcel.digest());
        self.shared.aboard.chart(vessel, ashore)
    }

    /// How the links of all vessels are.
    pub(crate) fn status(&self) -> Vec<(Address, ShoreStatus)> {
        let vessels = self.shared.vessels.lock().unwrap_or_else(PoisonError::into_inner);
        vessels.iter().map(|(address, handle)| (Address(*address), *handle.status.borrow())).collect()
    }

    /// How many stick positions came to a vessel too late or never, since the start.
    pub(crate) fn late_sticks(&self, vessel: Address) -> u64 {
        let vessels = self.shared.vessels.lock().unwrap_or_else(PoisonError::into_inner);
        vessels.get(&vessel.0).map_or(0, |handle| handle.late.load(Ordering::Relaxed))
    }

    /// How long a vessel's link took there and back at last; nothing while it does not stand.
    pub(crate) fn round_trip(&self, vessel: Address) -> Option<Duration> {
        let vessels = self.shared.vessels.lock().unwrap_or_else(PoisonError::into_inner);
        let status = *vessels.get(&vessel.0)?.status.borrow();
        status.round_trip.filter(|_| status.up)
    }

    /// The task of a vessel; the first connection starts it.
    fn vessel(&self, address: u16) -> mpsc::Sender<Event> {
        let shared = &self.shared;
        let mut vessels = shared.vessels.lock().unwrap_or_else(PoisonError::into_inner);
        let index = vessels.len();
        let handle = vessels.entry(address).or_insert_with(|| {
            let (events, coming) = mpsc::channel(WAITING);
            let (told, status) = watch::channel(ShoreStatus::default());
            let late = Arc::new(AtomicU64::new(0));
            let task = vessel::Task::new(
                Address(address),
                shared.relay.clone(),
                shared.recorder.clone(),
                (shared.charts.offered(), shared.aboard.clone()),
                told,
                Arc::clone(&late),
                index,
            );
            shared.tasks.spawn(task.run(coming, shared.stop.clone()));
            Handle { events, status, late }
        });
        handle.events.clone()
    }

    fn next_connection(&self) -> ConnectionId {
        ConnectionId(self.shared.connections.fetch_add(1, Ordering::Relaxed))
    }
}
