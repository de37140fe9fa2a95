//! Serial ports: found by stable names, opened exclusively and raw, with errors that name the remedy.

use super::open_error::OpenError;
use rustix::fs::{FlockOperation, Mode, OFlags, flock, open};
use rustix::io::Errno;
use rustix::termios::{
    ControlModes, OptionalActions, QueueSelector, SpecialCodeIndex, ioctl_tiocexcl, ioctl_tiocnxcl, isatty,
    tcflush, tcgetattr, tcsetattr,
};
use std::fs;
use std::os::fd::{AsFd, BorrowedFd, OwnedFd};
use std::path::{Path, PathBuf};

/// Where stable names of serial ports are.
const BY_ID: &str = "/dev/serial/by-id";
/// Name prefixes of pluggable serial ports.
const NAMES: [&str; 3] = ["ttyUSB", "ttyACM", "ttyAMA"];
/// Names listed in an error.
const MOST_NAMES: usize = 12;

/// An open serial port.
#[derive(Debug)]
pub(crate) struct Serial(OwnedFd);

impl Serial {
    /// Opens the one port that matches the path: raw, eight bits, no parity, one stop bit, at this speed (bit/s),
    /// exclusively.
    ///
    /// # Errors
    /// When it cannot be opened; the text has the remedy.
    pub(crate) fn open(path: &Path, baud: u32) -> Result<Self, OpenError> {
        let path = one_of(path)?;
        let flags = OFlags::RDWR | OFlags::NOCTTY | OFlags::NONBLOCK | OFlags::CLOEXEC;
        let fd = open(&path, flags, Mode::empty()).map_err(|errno| explain(&path, errno))?;
        if !isatty(&fd) {
            let text = format!("{} is not a serial port; a recording is written as file:{0}", path.display());
            return Err(OpenError(text));
        }
        // Two locks, as the kernel lets root bypass the first.
        ioctl_tiocexcl(&fd).map_err(|errno| explain(&path, errno))?;
        flock(&fd, FlockOperation::NonBlockingLockExclusive).map_err(|errno| explain(&path, errno))?;
        let serial = Self(fd);
        serial
            .set_raw(baud)
            .map_err(|errno| OpenError(format!("{} at {baud} bit/s: {errno}", path.display())))?;
        Ok(serial)
    }

    /// Changes the speed (bit/s) once all written bytes have been sent; received bytes are kept.
    pub(super) fn set_speed(&self, baud: u32) -> rustix::io::Result<()> {
        let mut settings = tcgetattr(&self.0)?;
        settings.set_speed(baud)?;
        tcsetattr(&self.0, OptionalActions::Drain, &settings)
    }

    fn set_raw(&self, baud: u32) -> rustix::io::Result<()> {
        let mut settings = tcgetattr(&self.0)?;
        settings.make_raw();
        settings.control_modes.remove(ControlModes::CSTOPB | ControlModes::CRTSCTS);
        settings.control_modes.insert(ControlModes::CLOCAL | ControlModes::CREAD);
        // With VMIN of one byte, a read of none means that the line was hung up.
        settings.special_codes[SpecialCodeIndex::VMIN] = 1;
        settings.special_codes[SpecialCodeIndex::VTIME] = 0;
        settings.set_speed(baud)?;
        tcsetattr(&self.0, OptionalActions::Now, &settings)?;
        // Discard bytes that were received before the port was opened.
        tcflush(&self.0, QueueSelector::IOFlush)
    }
}

impl Drop for Serial {
    fn drop(&mut self) {
        // If another program also has the line open, it would stay locked to later ones.
        ioctl_tiocnxcl(&self.0).ok();
    }
}

impl AsFd for Serial {
    fn as_fd(&self) -> BorrowedFd<'_> {
        self.0.as_fd()
    }
}

/// The serial ports of this computer: stable names first, then pluggable ones.
fn candidates() -> Vec<PathBuf> {
    let mut found = list(Path::new(BY_ID), |_| true);
    found.extend(list(Path::new("/dev"), |name| NAMES.iter().any(|start| name.starts_with(start))));
    found
}

fn list(folder: &Path, wanted: impl Fn(&str) -> bool) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    let names = entries.filter(|entry| entry.file_name().to_str().is_some_and(&wanted));
    let mut paths: Vec<PathBuf> = names.map(|entry| entry.path()).collect();
    paths.sort();
    paths
}

/// The path itself, or the only one that matches its `*`.
fn one_of(path: &Path) -> Result<PathBuf, OpenError> {
    let (Some(folder), Some(pattern)) = (path.parent(), path.file_name().and_then(|name| name.to_str()))
    else {
        return Ok(path.to_owned());
    };
    if !pattern.contains('*') {
        return Ok(path.to_owned());
    }
    let mut fitting = list(folder, |name| fits(pattern, name));
    match fitting.len() {
        0 => Err(absent(path)),
        1 => Ok(fitting.remove(0)),
        count => {
            let text = format!(
                "{count} devices fit {}: {}; write more of the name",
                path.display(),
                names(&fitting)
            );
            Err(OpenError(text))
        }
    }
}

/// Whether a name matches a pattern in which `*` matches anything.
fn fits(pattern: &str, name: &str) -> bool {
    let mut parts = pattern.split('*');
    let first = parts.next().unwrap_or_default();
    let Some(mut rest) = name.strip_prefix(first) else { return false };
    let mut parts: Vec<&str> = parts.collect();
    let Some(last) = parts.pop() else { return rest.is_empty() };
    for part in parts {
        let Some(place) = rest.find(part) else { return false };
        rest = &rest[place + part.len()..];
    }
    rest.ends_with(last)
}

fn names(paths: &[PathBuf]) -> String {
    let more = paths.len().saturating_sub(MOST_NAMES);
    let shown: Vec<String> = paths.iter().take(MOST_NAMES).map(|path| path.display().to_string()).collect();
    let more = if more > 0 { format!(" and {more} more") } else { String::new() };
    format!("{}{more}", shown.join(", "))
}

fn absent(path: &Path) -> OpenError {
    let there = match &candidates()[..] {
        [] => "this computer has no serial device that is plugged in: is the cable in, and does the device have power?"
            .to_owned(),
        some => format!("there are {}: write one of these, or plug the device in", names(some)),
    };
    OpenError(format!("there is no {}; {there}", path.display()))
}

/// Explains an error at opening, with the remedy.
fn explain(path: &Path, errno: Errno) -> OpenError {
    let shown = path.display();
    OpenError(match errno {
        Errno::NOENT | Errno::NODEV | Errno::NXIO | Errno::NOTDIR => return absent(path),
        Errno::ACCESS | Errno::PERM => format!(
            "no permission for {shown}: put the user in the group that owns it (`sudo usermod -aG dialout $USER`) and log in again"
        ),
        Errno::BUSY | Errno::AGAIN => match holder(path) {
            Some(holder) => format!("{shown} is in use by {holder}: end that program"),
            None => format!("{shown} is in use by another program: find it with `fuser {shown}` and end it"),
        },
        other => format!("{shown}: {other}"),
    })
}

/// The program that has a port open, by name and number, where this user may see that.
fn holder(path: &Path) -> Option<String> {
    let path = fs::canonicalize(path).ok()?;
    let own = std::process::id();
    for process in fs::read_dir("/proc").ok()?.flatten() {
        let Some(id) = process.file_name().to_str().and_then(|name| name.parse::<u32>().ok()) else {
            continue;
        };
        let mut open = fs::read_dir(process.path().join("fd")).into_iter().flatten().flatten();
        if open.any(|fd| fs::read_link(fd.path()).is_ok_and(|target| target == path)) {
            let name = fs::read_to_string(process.path().join("comm")).unwrap_or_default();
            let name = if id == own { "this program itself".to_owned() } else { name.trim().to_owned() };
            return Some(format!("{name} (process {id})"));
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::io::Pty;

    #[test]
    fn a_star_stands_for_anything() {
        for (pattern, name, expected) in [
            ("*Thelma*", "usb-Thelma_TB-if00", true),
            ("usb-*-if00", "usb-FTDI_A1-if00", true),
            ("usb-*-if01", "usb-FTDI_A1-if00", false),
            ("ttyUSB*", "ttyUSB0", true),
            ("a*a", "a", false),
            ("*", "", true),
        ] {
            assert_eq!(fits(pattern, name), expected, "{pattern} {name}");
        }
    }

    #[test]
    fn errors_name_the_path_and_what_to_do() {
        let text = |path: &Path| Serial::open(path, 19_200).unwrap_err().to_string();
        let absent = text(Path::new("/dev/serial/by-id/usb-nothing-if00"));
        assert!(absent.contains("there is no /dev/serial/by-id/usb-nothing-if00"), "{absent}");
        let file = text(&Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml"));
        assert!(file.contains("is not a serial port; a recording is written as file:/"), "{file}");
        let denied = explain(Path::new("/dev/ttyUSB7"), Errno::ACCESS).to_string();
        assert!(denied.contains("/dev/ttyUSB7") && denied.contains("dialout"), "{denied}");
    }

    #[test]
    fn a_port_is_for_one_program_and_free_again_when_it_is_closed() {
        let Some(pty) = Pty::for_test() else { return };
        let first = Serial::open(pty.path(), 115_200).unwrap();
        let busy = Serial::open(pty.path(), 115_200).unwrap_err().to_string();
        assert!(busy.contains("in use by") && busy.contains(&std::process::id().to_string()), "{busy}");
        drop(first);
        Serial::open(pty.path(), 115_200).unwrap();
    }

    #[test]
    fn a_name_that_several_devices_fit_is_refused_with_their_names() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["usb-A-if00", "usb-B-if00"] {
            fs::write(folder.path().join(name), "").unwrap();
        }
        let several = one_of(&folder.path().join("usb-*")).unwrap_err().to_string();
        assert!(several.contains("usb-A-if00") && several.contains("usb-B-if00"), "{several}");
        assert_eq!(one_of(&folder.path().join("*B*")).unwrap(), folder.path().join("usb-B-if00"));
        assert!(one_of(&folder.path().join("*C*")).is_err());
    }
}
