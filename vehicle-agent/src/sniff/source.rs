//! Sources of `sniff`: a serial port, opened as by the running agent ([`Serial`]), a file or standard input.

use crate::io::Serial;
use anyhow::{Context as _, bail};
use rustix::fs::{OFlags, fcntl_getfl, fcntl_setfl};
use std::fs::{self, File};
use std::io::{self, Read};
use std::os::unix::fs::FileTypeExt as _;
use std::path::Path;

/// An open source of bytes.
#[derive(Debug)]
pub(super) enum Source {
    /// A serial port.
    Port(Serial),
    /// A recording or a pipe with a name.
    File(File),
    /// Standard input.
    Standard(io::Stdin),
}

impl Source {
    /// Opens a port, a file, or standard input for `-`. A port runs at `baud`, at `usual` where none is given.
    ///
    /// # Errors
    /// When it does not exist, may not be read or is in use; the error has the remedy.
    pub(super) fn open(path: &Path, baud: Option<u32>, usual: u32) -> anyhow::Result<Self> {
        if path.as_os_str() == "-" {
            return Ok(Self::Standard(io::stdin()));
        }
        // A path that does not exist may be an unplugged port, or a pattern of names.
        let kind = fs::metadata(path).ok().map(|about| about.file_type());
        match kind {
            Some(kind) if kind.is_dir() => {
                bail!("{} is a folder: give a serial port, a recording or -", path.display())
            }
            Some(kind) if !kind.is_char_device() => {
                let opening = || format!("opening {}: make sure that you may read it", path.display());
                Ok(Self::File(File::open(path).with_context(opening)?))
            }
            None if !path.starts_with("/dev") => {
                bail!("there is no {}: check the name; serial ports are in /dev/serial/by-id", path.display())
            }
            _ => {
                let port = Serial::open(path, baud.unwrap_or(usual))?;
                // Reads are blocking here.
                let flags = fcntl_getfl(&port).map_err(io::Error::from)?;
                fcntl_setfl(&port, flags - OFlags::NONBLOCK).map_err(io::Error::from)?;
                Ok(Self::Port(port))
            }
        }
    }

    /// Whether it is a serial port, so that data have a time of arrival.
    pub(super) const fn is_port(&self) -> bool {
        matches!(self, Self::Port(_))
    }

    /// Remedy when it cannot be read any more.
    pub(super) const fn remedy(&self) -> &'static str {
        match self {
            Self::Port(_) => "the port is gone; check the cable and its plug, then start again",
            Self::File(_) => "the file cannot be read; check the disk",
            Self::Standard(_) => "standard input cannot be read; check what writes to it",
        }
    }
}

impl Read for Source {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        match self {
            // A port has no end: a read of zero bytes means that its line was hung up.
            Self::Port(port) => match rustix::io::read(port, &mut *bytes)? {
                0 if !bytes.is_empty() => Err(io::Error::new(io::ErrorKind::UnexpectedEof, "hung up")),
                count => Ok(count),
            },
            Self::File(file) => file.read(bytes),
            Self::Standard(input) => input.read(bytes),
        }
    }
}
