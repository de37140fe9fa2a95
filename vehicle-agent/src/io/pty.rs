//! A pseudo-terminal: the device's end of a serial port, for simulated devices.

use rustix::event::{PollFd, PollFlags, Timespec, poll};
use rustix::fs::{Mode, OFlags, open};
use rustix::io::Errno;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{OptionalActions, tcgetattr, tcsetattr};
use std::ffi::OsStr;
use std::io;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::os::unix::ffi::OsStrExt as _;
use std::path::{Path, PathBuf};

/// The device's end. Dropping it is pulling the cable: a program that has the other end open sees the line hung up.
#[derive(Debug)]
pub(crate) struct Pty {
    device: OwnedFd,
    path: PathBuf,
}

impl Pty {
    /// A new one, not opened by any program.
    ///
    /// # Errors
    /// When the system has no more.
    pub(crate) fn open() -> io::Result<Self> {
        let flags = OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC;
        let device = openpt(flags)?;
        rustix::io::ioctl_fionbio(&device, true)?;
        grantpt(&device)?;
        unlockpt(&device)?;
        let name = ptsname(&device, Vec::new())?;
        let path = PathBuf::from(OsStr::from_bytes(name.to_bytes()));
        // Opened and closed once, so that it shows that no program has it open; and echo is switched off before the first
        // bytes.
        let other = open(&path, OFlags::RDWR | OFlags::NOCTTY | OFlags::CLOEXEC, Mode::empty())?;
        let mut settings = tcgetattr(&other)?;
        settings.make_raw();
        tcsetattr(&other, OptionalActions::Now, &settings)?;
        Ok(Self { device, path })
    }

    /// A new one for a test; `None`, with a note, where there cannot be one: qemu-user (7.2 at least) lacks the calls that
    /// set any terminal speed (`TCGETS2`).
    #[cfg(test)]
    pub(crate) fn for_test() -> Option<Self> {
        match Self::open() {
            Err(error) if error.kind() == io::ErrorKind::Unsupported => {
                testkit::absent(testkit::Need::Native, &format!("a pseudo-terminal: {error}"));
                None
            }
            opened => Some(opened.expect("a pseudo-terminal")),
        }
    }

    /// The path of the other end.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Whether a program has the other end open.
    pub(crate) fn is_open(&self) -> bool {
        let mut fds = [PollFd::new(&self.device, PollFlags::IN)];
        poll(&mut fds, Some(&Timespec::default())).is_ok() && !fds[0].revents().contains(PollFlags::HUP)
    }

    /// The speed that the other end has set (bit/s); `None` while it is not open.
    pub(crate) fn baud(&self) -> Option<u32> {
        tcgetattr(&self.device).ok().filter(|_| self.is_open()).map(|settings| settings.input_speed())
    }

    /// Sends bytes; returns how many were taken. Without a reader they are lost, as on a line.
    ///
    /// # Errors
    /// When the pseudo-terminal is gone.
    pub(crate) fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        if !self.is_open() {
            return Ok(0);
        }
        match rustix::io::write(&self.device, bytes) {
            Err(Errno::AGAIN | Errno::INTR | Errno::IO) => Ok(0),
            other => Ok(other?),
        }
    }

    /// Reads what came; `None` when nothing did.
    ///
    /// # Errors
    /// When the pseudo-terminal is gone.
    pub(crate) fn read(&mut self, buffer: &mut [u8]) -> io::Result<Option<usize>> {
        match rustix::io::read(&self.device, buffer) {
            // No program has the other end open.
            Err(Errno::AGAIN | Errno::INTR | Errno::IO) => Ok(None),
            other => Ok(Some(other?)),
        }
    }
}

impl AsFd for Pty {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.device.as_fd()
    }
}
