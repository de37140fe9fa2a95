//! Wakes a thread that waits for its port.

use rustix::event::{EventfdFlags, eventfd};
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::sync::atomic::{AtomicBool, Ordering};

/// A bell, and whether the thread is to end.
#[derive(Debug)]
pub(crate) struct Wake {
    bell: OwnedFd,
    ending: AtomicBool,
}

impl Wake {
    /// A bell that has not been rung.
    ///
    /// # Errors
    /// When the system has no more file descriptors.
    pub(crate) fn new() -> std::io::Result<Self> {
        let bell = eventfd(0, EventfdFlags::NONBLOCK | EventfdFlags::CLOEXEC)?;
        Ok(Self { bell, ending: AtomicBool::new(false) })
    }

    /// Wakes the thread; never waits.
    pub(crate) fn ring(&self) {
        // A full counter still wakes the thread.
        rustix::io::write(&self.bell, &1_u64.to_ne_bytes()).ok();
    }

    /// Tells the thread to end.
    pub(super) fn end(&self) {
        self.ending.store(true, Ordering::SeqCst);
        self.ring();
    }

    pub(super) fn is_ending(&self) -> bool {
        self.ending.load(Ordering::SeqCst)
    }

    /// Whether it was rung since the last call.
    pub(super) fn was_rung(&self) -> bool {
        rustix::io::read(&self.bell, &mut [0; 8]).is_ok()
    }
}

impl AsFd for Wake {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.bell.as_fd()
    }
}
