//! Brings the shore's chart to the disk in a thread of its own, which may take its time for it.

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

/// The link hands over one at a time, and another offer on top of it.
const WAITING: usize = 4;

/// Something to do.
#[derive(Debug)]
pub(super) enum Job {
    /// Prepare to take this chart.
    Begin(ChartOffer),
    /// Keep a part of it.
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

/// What became of it.
#[derive(Debug)]
pub(super) enum Outcome {
    /// So much is there: the next part.
    GoOn(u64),
    /// All of it is there, as it should be.
    Kept(ChartFile),
    /// It cannot be taken, and why.
    Failed(String),
}

/// The thread.
#[derive(Debug)]
pub(super) struct Keeper {
    jobs: SyncSender<Job>,
    done: Receiver<(ChartDigest, Outcome)>,
}

impl Keeper {
    /// Starts the thread; it rings at the queue's thread when a job is done.
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

    /// Hands a job over; false when the thread does not take it.
    pub(super) fn hand(&self, job: Job) -> bool {
        self.jobs.try_send(job).is_ok()
    }

    /// What became of a job.
    pub(super) fn outcome(&self) -> Option<(ChartDigest, Outcome)> {
        self.done.try_recv().ok()
    }
}

/// Nothing for a part that nobody waits for any more.
fn carry_out(folder: &mut ChartFolder, job: Job) -> Option<Outcome> {
    let have = match job {
        Job::Begin(offer) => {
            // One that waits to be in force is there already.
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
