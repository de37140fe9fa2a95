//! Syncs files to disk in its own thread: a memory card may take a second for it.

use super::queue::Queue;
use std::fs::File;
use std::io;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, SyncSender, channel, sync_channel};

type Job = (Vec<Arc<File>>, u64);

/// The thread; one job at a time.
#[derive(Debug)]
pub(super) struct Syncer {
    jobs: SyncSender<Job>,
    done: Receiver<io::Result<u64>>,
    busy: bool,
}

impl Syncer {
    /// Starts the thread; it wakes the queue's thread when a job is done.
    pub(super) fn start(queue: Arc<Queue>) -> io::Result<Self> {
        let (jobs, todo) = sync_channel::<Job>(1);
        let (tell, done) = channel();
        std::thread::Builder::new().name("uplink-sync".to_owned()).spawn(move || {
            for (files, next) in todo {
                let outcome = files.iter().try_for_each(|file| file.sync_data()).map(|()| next);
                if tell.send(outcome).is_err() {
                    return;
                }
                queue.ring();
            }
        })?;
        Ok(Self { jobs, done, busy: false })
    }

    pub(super) fn is_busy(&self) -> bool {
        self.busy
    }

    /// Starts a job; only while the thread is not busy.
    pub(super) fn start_job(&mut self, job: Job) {
        self.busy = self.jobs.try_send(job).is_ok();
    }

    /// The outcome of the job, once.
    pub(super) fn outcome(&mut self) -> Option<io::Result<u64>> {
        let outcome = self.done.try_recv().ok()?;
        self.busy = false;
        Some(outcome)
    }
}
