//! Everything on disk: logs, plans, parameters, recordings, served by a dedicated thread.
//!
//! The control loop passes work on without waiting; the outcome comes back as [`Done`]. Work waits in one ordered queue of
//! at most [`QUEUE_BYTES`]:
//!
//! - measurements, states and lines of text may fill three quarters of it. Further ones are dropped and counted;
//! - detections, commands and messages that explain a log ([`is_record`]) may fill all of it. Further ones are lost, which
//!   is reported as an error to the consoles;
//! - changes of plans and parameters, the task under way and the opening and closing of logs are always taken: their number
//!   is limited by the requesting code (64 changes of plans; logs as below). A change is acknowledged when it is on the
//!   disk, never before;
//! - a recording (`--record`) with a gap is of no use: when a record cannot be taken, the recording ends and reports it.
//!
//! Logs are opened at most [`worker::ROTATIONS`] times in a row and then once in [`worker::ROTATION_PAUSE`]; earlier
//! requests wait, and only the last of them is carried out.

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

/// A piece of work for the disk.
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
    /// Store the task under way, or that there is none.
    UnderWay(Option<Vec<u8>>),
    /// A record of the recording: its kind and bytes.
    Record(u8, Vec<u8>),
    /// A record could not be taken: end the recording.
    EndRecording,
    /// Periodic work, once a second.
    Tick(MonoTime, UtcTime),
}

/// The outcome of work.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Done {
    /// A log was opened under this name, or could not be, or broke.
    LogOpened(Result<String, String>),
    /// A change of the plans is on the disk, or could not be written.
    Stored(Ticket, Result<(), String>),
    /// The parameters of the entity with this label are saved, or could not be.
    ParametersKept(String, Result<(), String>),
    /// Other data could not be stored.
    NotKept(String),
    /// The state of the computer, at every [`Work::Tick`].
    Host(HostReading),
    /// A sea chart of the shore's is on the disk.
    Chart(ChartFile),
}

/// Whether a packet is a record that must not be dropped in favour of others: detections, commands and their execution, and
/// messages that explain a log.
pub(crate) fn is_record(id: u16) -> bool {
    const EXPLAIN: [u16; 4] = [3, 5, 102, 103];
    const COMMANDS: [u16; 18] =
        [301, 305, 460, 468, 479, 500, 501, 507, 550, 551, 556, 559, 802, 803, 804, 805, 889, 478];
    // An Event carries a detection whole, and alone where the receiver's clock is not set.
    const DETECTIONS: [u16; 5] = [273, 660, 800, 2007, 2008];
    EXPLAIN.contains(&id) || COMMANDS.contains(&id) || DETECTIONS.contains(&id)
}

/// Handle of the disk's thread.
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
            // Dropping it writes the buffer of the recording.
            drop(worker);
            end.send(()).ok();
        })?;
        Ok(Self { queue, ended, recording })
    }

    /// Queues work; work that cannot be taken is counted.
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

    /// Whether inputs and outputs of the brain are to be recorded.
    pub(crate) fn is_recording(&self) -> bool {
        self.recording
    }

    /// Losses since the last call.
    pub(crate) fn take_lost(&self) -> Lost {
        self.queue.take_lost()
    }

    /// Lets the thread finish its queue; returns whether it did within this time.
    pub(crate) fn finish(self, longest: Duration) -> bool {
        self.queue.close();
        self.ended.recv_timeout(longest).is_ok()
    }
}
