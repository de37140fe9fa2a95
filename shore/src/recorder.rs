//! The thread that owns the store: everything the hub wants recorded goes to the archive and the history here.
//!
//! The hub never waits for a disk. Records wait in a queue; the thread takes all of them, and makes them durable at least
//! every `COMMIT_EVERY`. Packets of the vessel link are acknowledged only then, and stay queued however long the disk
//! fails: the link's window limits them, and the vessel keeps its copy. Of other transports [`WAITING_BYTES`] may be
//! queued; further packets are not recorded, which is counted, shown on the page and logged, as they cannot be sent again.

use crate::owners::{Duty, Owners};
use hub::Record;
use std::collections::BTreeMap;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::{Arc, Condvar, Mutex, MutexGuard, PoisonError};
use std::thread::JoinHandle;
use std::time::{Duration, Instant};
use store::{Accepted, Store, StoreError};
use tokio::sync::{oneshot, watch};

/// How long an accepted packet may wait for the disk.
const COMMIT_EVERY: Duration = Duration::from_millis(100);
/// How often the history is maintained while no records arrive: roll-ups, and saving its progress.
const IDLE_EVERY: Duration = Duration::from_secs(1);
/// How long to wait after a failure before the next attempt.
const RETRY_AFTER: Duration = Duration::from_secs(1);
/// Most queued bytes of packets of transports other than the link.
pub const WAITING_BYTES: usize = 16 << 20;
/// Bytes of packets that are given to the store before a commit: until then it holds a second copy.
const SLICE_BYTES: usize = 2 << 20;
/// Memory of a queued packet besides its bytes.
const OVERHEAD_BYTES: usize = size_of::<Record>();

/// The highest durable number of each link stream that was heard since the start.
pub type Durable = BTreeMap<u64, u64>;

/// Work that needs the store itself.
type Work = Box<dyn FnOnce(&mut Store) + Send>;

/// Why nothing can be recorded.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Trouble {
    /// Safe to show to anyone.
    pub short: &'static str,
    /// With the remedy and the system's error text, for logged-in users.
    pub text: String,
}

/// State of the recording, for people.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct RecorderState {
    /// Why nothing can be recorded at the moment.
    pub trouble: Option<Trouble>,
    /// Why the history lacks part of the archive.
    pub history_behind: Option<String>,
    /// Packets recorded since the start.
    pub recorded: u64,
    /// Packets that were dropped because the queue was full.
    pub not_recorded: u64,
}

impl RecorderState {
    /// A message for people, if something is wrong.
    pub fn problem(&self) -> Option<String> {
        let behind = |reason: &String| format!("the history is behind the archive: {reason}");
        let trouble = self.trouble.as_ref().map(|trouble| trouble.text.clone());
        trouble.or_else(|| self.history_behind.as_ref().map(behind))
    }
}

/// Handle of the thread; cheap to clone.
#[derive(Clone)]
pub struct Recorder {
    shared: Arc<Shared>,
}

struct Shared {
    waiting: Mutex<Waiting>,
    ready: Condvar,
    durable: watch::Sender<Durable>,
    state: watch::Sender<RecorderState>,
}

#[derive(Default)]
struct Waiting {
    records: Vec<Record>,
    /// Bytes that are not on disk yet, in the queue or in the thread.
    bytes: usize,
    work: Vec<Work>,
    not_recorded: u64,
    closed: bool,
}

impl Recorder {
    /// Starts the thread. It ends after [`Recorder::close`], once everything is durable that can be.
    ///
    /// # Errors
    /// The thread cannot be started.
    pub fn start(store: Store, owners: &Owners) -> std::io::Result<(Self, JoinHandle<()>)> {
        let shared = Arc::new(Shared {
            waiting: Mutex::default(),
            ready: Condvar::new(),
            durable: watch::Sender::default(),
            // Set from the start: before the first commit the history must not be taken as complete.
            state: watch::Sender::new(RecorderState {
                history_behind: store.behind(),
                ..RecorderState::default()
            }),
        });
        let recorder = Self { shared: Arc::clone(&shared) };
        let duty = owners.duty("the recorder");
        let (taken, committed) = (Vec::new(), Instant::now());
        let thread = Thread { store, shared, taken, committed, accepted_bytes: 0, dirty: false };
        let handle = std::thread::Builder::new().name("recorder".to_owned()).spawn(|| thread.serve(duty))?;
        Ok((recorder, handle))
    }

    /// Queues records; never waits for the disk.
    pub fn submit(&self, records: Vec<Record>) {
        let mut waiting = self.shared.lock();
        for record in records {
            let cost = record.packet.len() + OVERHEAD_BYTES;
            if record.link.is_none() && waiting.bytes + cost > WAITING_BYTES {
                waiting.not_recorded += 1;
                metrics::counter!("lutra_not_recorded_total").increment(1);
                continue;
            }
            waiting.bytes += cost;
            waiting.records.push(record);
        }
        drop(waiting);
        self.shared.ready.notify_one();
    }

    /// Queued bytes.
    pub fn waiting_bytes(&self) -> usize {
        self.shared.lock().bytes
    }

    /// Runs `work` on the thread that owns the store and returns its result; `None` when the thread has ended.
    pub async fn with_store<T: Send + 'static>(
        &self,
        work: impl FnOnce(&mut Store) -> T + Send + 'static,
    ) -> Option<T> {
        let (reply, answer) = oneshot::channel();
        let work: Work = Box::new(move |store| {
            reply.send(work(store)).ok();
        });
        if !self.queue(work) {
            return None;
        }
        answer.await.ok()
    }

    /// Queues work; returns whether the thread is running.
    fn queue(&self, work: Work) -> bool {
        let mut waiting = self.shared.lock();
        if !waiting.closed {
            waiting.work.push(work);
        }
        self.shared.ready.notify_one();
        !waiting.closed
    }

    /// The last durable number of each stream, as it grows.
    pub fn durable(&self) -> watch::Receiver<Durable> {
        self.shared.durable.subscribe()
    }

    /// State of the recording.
    pub fn state(&self) -> watch::Receiver<RecorderState> {
        self.shared.state.subscribe()
    }

    /// Lets the thread end once the queue is on disk.
    pub fn close(&self) {
        self.shared.lock().closed = true;
        self.shared.ready.notify_one();
    }
}

impl Shared {
    fn lock(&self) -> MutexGuard<'_, Waiting> {
        self.waiting.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

struct Thread {
    store: Store,
    shared: Arc<Shared>,
    /// Records taken from the queue and not accepted yet, in reverse order.
    taken: Vec<Record>,
    committed: Instant,
    /// Bytes accepted since the last commit, which also wait for the disk.
    accepted_bytes: usize,
    /// Whether something was accepted since the last commit.
    dirty: bool,
}

impl Thread {
    /// Records until the end. After a panic, records that were taken are made durable if possible, and pending requests are
    /// dropped.
    fn serve(mut self, duty: Duty) {
        if catch_unwind(AssertUnwindSafe(|| self.run(&duty))).is_ok() {
            if let Err(error) = self.store.close() {
                tracing::warn!(%error, "the history will be brought up to date at the next start");
            }
            return duty.done();
        }
        let saved = catch_unwind(AssertUnwindSafe(|| {
            self.take_records(&mut self.shared.clone().lock());
            self.accept().and_then(|()| self.commit(true))
        }));
        if !matches!(saved, Ok(Ok(()))) {
            tracing::error!(
                lost = self.taken.len(),
                "packets are not recorded after a fault of the recorder"
            );
        }
        let mut waiting = self.shared.lock();
        waiting.closed = true;
        waiting.work.clear();
    }

    fn run(&mut self, duty: &Duty) {
        loop {
            let (closed, work) = self.take();
            let _busy = duty.busy();
            for work in work {
                work(&mut self.store);
            }
            let outcome = self.accept().and_then(|()| self.commit(closed));
            if let Err(error) = outcome {
                self.trouble(&error);
                if closed {
                    let lost = self.taken.len();
                    tracing::error!(%error, "{lost} packets are not recorded: the disk is in trouble at the end");
                    return;
                }
                self.pause();
            } else if closed && self.taken.is_empty() && !self.dirty {
                return;
            }
        }
    }

    /// Takes the queue; waits for records, but not past the next commit. Returns whether the end is requested, and work to
    /// be done.
    fn take(&mut self) -> (bool, Vec<Work>) {
        let shared = Arc::clone(&self.shared);
        let mut waiting = shared.lock();
        if self.taken.is_empty() {
            let idle = |waiting: &mut Waiting| {
                waiting.records.is_empty() && waiting.work.is_empty() && !waiting.closed
            };
            let rest = self.every().saturating_sub(self.committed.elapsed());
            let waited = shared.ready.wait_timeout_while(waiting, rest, idle);
            waiting = waited.unwrap_or_else(PoisonError::into_inner).0;
            self.take_records(&mut waiting);
            if !self.dirty && !self.taken.is_empty() {
                // The first record after a pause waits a full interval too, so that more are committed with it.
                self.committed = Instant::now();
            }
        }
        (waiting.closed, std::mem::take(&mut waiting.work))
    }

    fn take_records(&mut self, waiting: &mut Waiting) {
        let mut records = std::mem::take(&mut waiting.records);
        records.reverse();
        records.append(&mut self.taken);
        self.taken = records;
    }

    fn accept(&mut self) -> Result<(), StoreError> {
        let mut slice = 0;
        while let Some(record) = self.taken.last() {
            let accepted = Accepted {
                packet: &record.packet,
                received: record.received,
                transport: record.transport,
                link: record.link,
            };
            // The hub has checked its checksum.
            match self.store.accept_checked(&accepted) {
                Ok(_) => {}
                // The store's buffer is full: make room, then continue with this one.
                Err(StoreError::Full { .. }) => {
                    self.dirty = true;
                    self.commit(true)?;
                    continue;
                }
                Err(error @ (StoreError::Packet(_) | StoreError::Trailing { .. })) => {
                    // The hub passes on whole packets only.
                    tracing::error!(%error, "a packet cannot be recorded");
                }
                Err(error) => return Err(error),
            }
            self.dirty = true;
            if let Some(record) = self.taken.pop() {
                slice += record.packet.len();
                self.accepted_bytes += record.packet.len() + OVERHEAD_BYTES;
            }
            if slice >= SLICE_BYTES {
                slice = 0;
                self.commit(true)?;
            }
        }
        Ok(())
    }

    fn commit(&mut self, now: bool) -> Result<(), StoreError> {
        let due = self.committed.elapsed() >= self.every();
        if !(due || now && self.dirty) {
            return Ok(());
        }
        let committed = self.store.sync()?;
        self.shared.lock().bytes -= std::mem::take(&mut self.accepted_bytes);
        self.committed = Instant::now();
        self.dirty = false;
        metrics::histogram!("lutra_commit_packets").record(committed.packets as f64);
        metrics::counter!("lutra_recorded_total").increment(committed.packets);
        metrics::counter!("lutra_recorded_bytes_total").increment(committed.bytes);
        if !committed.durable.is_empty() {
            self.shared.durable.send_modify(|durable| {
                durable.extend(committed.durable.iter().map(|link| (link.stream, link.seq)));
            });
        }
        // Acknowledge first: the history can always be rebuilt from the archive.
        let behind = self.store.index().map_or_else(|error| Some(error.to_string()), |_| self.store.behind());
        self.tell(committed.packets, behind);
        Ok(())
    }

    /// Interval between two commits. An incomplete history catches up by a slice with each.
    fn every(&self) -> Duration {
        if self.dirty || self.store.is_behind() { COMMIT_EVERY } else { IDLE_EVERY }
    }

    fn tell(&self, recorded: u64, history_behind: Option<String>) {
        let not_recorded = self.shared.lock().not_recorded;
        self.shared.state.send_if_modified(|state| {
            let before = state.clone();
            if let Some(trouble) = state.trouble.take() {
                tracing::warn!(trouble = %trouble.text, "recording goes on");
            }
            if history_behind.is_some() && history_behind != state.history_behind {
                tracing::warn!(reason = ?history_behind, "the history is behind the archive");
            }
            state.history_behind = history_behind;
            state.recorded += recorded;
            state.not_recorded = not_recorded;
            *state != before
        });
    }

    fn trouble(&self, error: &StoreError) {
        let trouble = if error.is_disk_full() {
            let short = "the disk is full, nothing is recorded";
            Trouble { short, text: format!("{short}: make room, or remove old history ({error})") }
        } else {
            let short = "nothing can be recorded";
            Trouble { short, text: format!("{short}: {error}") }
        };
        let not_recorded = self.shared.lock().not_recorded;
        self.shared.state.send_if_modified(|state| {
            if state.trouble.as_ref() != Some(&trouble) {
                tracing::error!("{}", trouble.text);
            }
            (state.trouble, state.not_recorded) = (Some(trouble), not_recorded);
            true
        });
    }

    /// Waits before the next attempt, but not when the end is requested.
    fn pause(&self) {
        let waiting = self.shared.lock();
        let open = |waiting: &mut Waiting| !waiting.closed;
        drop(self.shared.ready.wait_timeout_while(waiting, RETRY_AFTER, open));
    }
}
