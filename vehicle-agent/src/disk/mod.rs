//! Everything on the disk: logs, plans, parameters, recordings, and a thread that does nothing else.
//!
//! The loop that steers hands over what is to be written and goes on; what became of it comes back as
//! [`Done`]. The work waits in one queue, in order, of at most [`QUEUE_BYTES`]:
//!
//! - measurements, states and lines of text may fill three quarters of it. Beyond that they are dropped and
//!   counted;
//! - detections, commands and what explains a log ([`is_record`]) may fill all of it. Beyond that they are
//!   lost, and said to be, as errors to the consoles;
//! - changes of plans and parameters, what is under way and the opening and closing of logs are always taken: their number is
//!   bounded by whoever asks for them (64 changes of plans; logs as below). A change is acknowledged when it is
//!   on the disk, never before;
//! - a recording (`--record`) with a gap is of no use: when it cannot be taken, it ends and says so.
//!
//! Logs are opened at most [`worker::ROTATIONS`] times in a row and then once in [`worker::ROTATION_PAUSE`];
//! requests that come sooner wait, and the last of them counts.

mod host;
mod journal;
mod lock;
mod queue;
pub(crate) mod recording;
mod store;
mod worker;

pub(crate) use host::Host;
pub(crate) use journal::{Journal, Room};
pub(crate) use lock::{DataLock, InUse};
pub(crate) use queue::Lost;
pub(crate) use store::Store;
pub(crate) use worker::{Tools, Worker};

use mission::{Effect, Ticket};
use onboard::{ChartFile, HostReading};
use queue::Queue;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, channel};
use std::time::Duration;
use units::{MonoTime, UtcTime};

/// Work waiting for the disk (bytes): some minutes of a vessel's messages.
const QUEUE_BYTES: usize = 8 << 20;

/// Something for the disk.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Work {
    /// A packet for the log.
    Packet(MonoTime, Vec<u8>),
    /// A line for the log's text.
    Line(MonoTime, String),
    /// Close the log and open another with this label.
    Open(MonoTime, UtcTime, String),
    /// Close the log: nothing follows.
    Close(UtcTime),
    /// Change the plans.
    Plans(Effect),
    /// Save values of an entity's parameters: its label, then names and values.
    Parameters(String, Vec<(String, String)>),
    /// Keep what is under way, or that nothing is.
    UnderWay(Option<Vec<u8>>),
    /// A record of the recording: its kind and bytes.
    Record(u8, Vec<u8>),
    /// Nothing more of the recording could be taken.
    EndRecording,
    /// What falls due, once a second.
    Tick(MonoTime, UtcTime),
}

/// What became of it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Done {
    /// A log was opened under this name, or could not be, or broke.
    LogOpened(Result<String, String>),
    /// A change of the plans is on the disk, or could not be brought there.
    Stored(Ticket, Result<(), String>),
    /// The parameters of the entity with this label are kept, or could not be.
    ParametersKept(String, Result<(), String>),
    /// Something else could not be kept.
    NotKept(String),
    /// The state of the computer, at every [`Work::Tick`].
    Host(HostReading),
    /// A sea chart of the shore's is on the disk.
    Chart(ChartFile),
}

/// Whether a packet is a record that must not be dropped for others: detections, what the vessel was told to do
/// and did, and what explains a log.
pub(crate) fn is_record(id: u16) -> bool {
    const EXPLAIN: [u16; 4] = [3, 5, 102, 103];
    const COMMANDS: [u16; 18] =
        [301, 305, 460, 468, 479, 500, 501, 507, 550, 551, 556, 559, 802, 803, 804, 805, 889, 478];
    // An Event carries a detection whole, and alone where the receiver's clock is not set.
    const DETECTIONS: [u16; 5] = [273, 660, 800, 2007, 2008];
    EXPLAIN.contains(&id) || COMMANDS.contains(&id) || DETECTIONS.contains(&id)
}

/// The way to the disk.
#[derive(Debug)]
pub(crate) struct Disk {
    queue: Arc<Queue>,
    ended: Receiver<()>,
    recording: bool,
}

impl Disk {
    /// Starts the thread; `answer` is called by it and must not wait.
    pub(crate) fn start(mut worker: Worker, answer: impl Fn(Done) + Send + 'static) -> anyhow::Result<Self> {
        let queue = Arc::new(Queue::new(QUEUE_BYTES));
        let (end, ended) = channel();
        let recording = worker.is_recording();
        let work = Arc::clone(&queue);
        std::thread::Builder::new().name("disk".to_owned()).spawn(move || {
            while let Some(next) = work.take() {
                worker.carry_out(next, &answer);
            }
            // What the recording still holds is written with it.
            drop(worker);
            end.send(()).ok();
        })?;
        Ok(Self { queue, ended, recording })
    }

    /// Hands work over; what cannot be taken is counted.
    pub(crate) fn hand(&mut self, work: Work) {
        let is_recording = matches!(work, Work::Record(..));
        if is_recording && !self.recording {
            return;
        }
        if !self.queue.put(work) && is_recording {
            self.recording = false;
            self.queue.put(Work::EndRecording);
        }
    }

    /// Whether what the brain is told and wants is to be handed over as well.
    pub(crate) fn is_recording(&self) -> bool {
        self.recording
    }

    /// What was lost since the last call.
    pub(crate) fn take_lost(&self) -> Lost {
        self.queue.take_lost()
    }

    /// Lets the disk finish what waits; answers whether it did within this time.
    pub(crate) fn finish(self, longest: Duration) -> bool {
        self.queue.close();
        self.ended.recv_timeout(longest).is_ok()
    }
}
