//! A service manager as a program under test sees systemd: a socket to which it reports its state.

use std::os::unix::net::UnixDatagram;
use std::process::Command;
use std::time::Duration;
use tempfile::TempDir;

/// No wait takes longer.
const PATIENCE: Duration = Duration::from_secs(30);

/// Receives the notifications of a program.
#[derive(Debug)]
pub struct ServiceManager {
    folder: TempDir,
    socket: UnixDatagram,
}

impl ServiceManager {
    /// One with a socket of its own.
    ///
    /// # Panics
    /// No socket can be made.
    pub fn start() -> Self {
        let folder = tempfile::tempdir().expect("a folder");
        let socket = UnixDatagram::bind(folder.path().join("notify")).expect("a socket");
        socket.set_read_timeout(Some(PATIENCE)).expect("a time limit");
        Self { folder, socket }
    }

    /// Has a program notify it, at least once in `watchdog` while it lives.
    pub fn watches(&self, command: &mut Command, watchdog: Duration) {
        command
            .env("NOTIFY_SOCKET", self.folder.path().join("notify"))
            .env("WATCHDOG_USEC", watchdog.as_micros().to_string());
    }

    /// The next notification.
    ///
    /// # Panics
    /// None comes for half a minute.
    pub fn told(&self) -> String {
        let mut bytes = [0; 256];
        let length = self.socket.recv(&mut bytes).expect("the program tells how it is");
        String::from_utf8_lossy(&bytes[..length]).trim().to_owned()
    }

    /// Skips notifications until `wanted`.
    ///
    /// # Panics
    /// None comes for half a minute.
    pub fn waits_for(&self, wanted: &str) {
        while self.told() != wanted {}
    }
}
