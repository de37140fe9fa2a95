//! Writes the shore's chart to disk in its own thread, which may be slow.

use super::queue::Queue;
use crate::ending::UPLINK_THREADS;
use crate::sea_chart::ChartFolder;
use bytes::Bytes;
use link::{ChartDigest, ChartOffer};
use onboard::ChartFile;
use std::io;
use std::path::Path;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};

/// The link passes one job at a time, and possibly another offer in addition.
const WAITING: usize = 4;

/// A job.
#[derive(Debug)]
pub(super) enum Job {
    /// Prepare to receive this chart.
    Begin(ChartOffer),
    /// Store a part of it.
    Part(ChartDigest, u64, Bytes),
}

impl Job {
    pub(super) fn digest(&self) -> ChartDigest {
        match self {
            Self::Begin(offer) => offer.digest,
            Self::Part(digest, ..) => *digest,
        }
    }
}

/// The outcome of a job.
#[derive(Debug)]
pub(super) enum Outcome {
    /// So many bytes are there: request the next part.
    GoOn(u64),
    /// It is complete and valid.
    Kept(ChartFile),
    /// It cannot be received, and why.
    Failed(String),
}

/// The thread.
#[derive(Debug)]
pub(super) struct Keeper {
    jobs: SyncSender<Job>,
    done: Receiver<(ChartDigest, Outcome)>,
}

impl Keeper {
    /// Starts the thread; it wakes the queue's thread when a job is done.
    pub(super) fn start(data: &Path, queue: Arc<Queue>) -> io::Result<Self> {
        let mut folder = ChartFolder::new(data);
        let (jobs, todo) = sync_channel::<Job>(WAITING);
        let (tell, done) = channel();
        std::thread::Builder::new().name(format!("{UPLINK_THREADS}-chart")).spawn(move || {
            for job in todo {
                let digest = job.digest();
                let Some(outcome) = carry_out(&mut folder, job) else { continue };
                if tell.send((digest, outcome)).is_err() {
                    return;
                }
                queue.ring();
            }
        })?;
        Ok(Self { jobs, done })
    }

    /// Queues a job; false if the thread does not take it.
    pub(super) fn hand(&self, job: Job) -> bool {
        self.jobs.try_send(job).is_ok()
    }

    /// The outcome of a job, if there is one.
    pub(super) fn outcome(&self) -> Option<(ChartDigest, Outcome)> {
        self.done.try_recv().ok()
    }
}

/// `None` for a part that is no longer needed.
fn carry_out(folder: &mut ChartFolder, job: Job) -> Option<Outcome> {
    let have = match job {
        Job::Begin(offer) => {
            // A chart that is not in force yet may be stored already.
            let there = folder.load().ok().flatten().filter(|chart| chart.digest() == offer.digest);
            if let Some(chart) = there {
                return Some(Outcome::Kept(chart));
            }
            folder.begin(offer)
        }
        Job::Part(digest, offset, bytes) => folder.keep(&digest, offset, &bytes).transpose()?,
    };
    Some(match have {
        Err(why) => Outcome::Failed(why),
        Ok(_) if folder.is_whole() => folder.finish().map_or_else(Outcome::Failed, Outcome::Kept),
        Ok(have) => Outcome::GoOn(have),
    })
}
