//! The port of a device, as written in configurations and commands.

use anyhow::{Context as _, bail};
use std::fmt;
use std::path::PathBuf;

/// The port of a device.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Place {
    /// A serial port. `*` in the last part of the path matches anything; exactly one device must match.
    Serial {
        /// Its path, best a stable one below /dev/serial/by-id.
        path: PathBuf,
        /// Its speed (bit/s).
        baud: u32,
    },
    /// A stream: host and port.
    Tcp(String),
    /// Datagrams received at this address and port.
    Udp(String),
    /// A recording of bytes, played at the speed of a line (bit/s).
    Recording {
        /// The file.
        path: PathBuf,
        /// Speed of the line.
        baud: u32,
    },
    /// An interface of the system's own CAN bus.
    Can(String),
}

impl Place {
    /// Reads `/dev/...`, `tcp://host:port`, `udp://address:port` or `file:path`; `baud` is the speed of a serial line.
    ///
    /// # Errors
    /// When the text is none of these.
    pub(crate) fn parse(text: &str, baud: u32) -> anyhow::Result<Self> {
        let text = text.trim();
        if let Some(host) = text.strip_prefix("tcp://") {
            return Ok(Self::Tcp(with_port(host)?));
        }
        if let Some(address) = text.strip_prefix("udp://") {
            let address = with_port(address)?;
            return Ok(Self::Udp(if address.starts_with(':') {
                format!("0.0.0.0{address}")
            } else {
                address
            }));
        }
        if let Some(path) = text.strip_prefix("file:") {
            return Ok(Self::Recording { path: path.trim_start_matches("//").into(), baud });
        }
        if !text.starts_with('/') {
            bail!(
                "`{text}` is not a port: write a path as /dev/serial/by-id/..., tcp://host:port, udp://address:port or file:path"
            );
        }
        Ok(Self::Serial { path: text.into(), baud })
    }
}

/// The text, if it ends in a port.
fn with_port(text: &str) -> anyhow::Result<String> {
    let text = text.trim_end_matches('/');
    let (_, port) = text.rsplit_once(':').with_context(|| format!("`{text}` has no `:port`"))?;
    port.parse::<u16>().with_context(|| format!("`{port}` of `{text}` is not a port"))?;
    Ok(text.to_owned())
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Serial { path, baud } => write!(f, "{} ({baud} bit/s)", path.display()),
            Self::Tcp(host) => write!(f, "tcp://{host}"),
            Self::Udp(address) => write!(f, "udp://{address}"),
            Self::Recording { path, .. } => write!(f, "{}", path.display()),
            Self::Can(interface) => write!(f, "CAN interface {interface}"),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn places_are_read_as_they_are_written_and_others_refused() {
        let read = |text: &str| Place::parse(text, 19_200).map(|place| place.to_string());
        for (text, shown) in [
            ("/dev/ttyUSB0", "/dev/ttyUSB0 (19200 bit/s)"),
            (" /dev/serial/by-id/*Thelma* ", "/dev/serial/by-id/*Thelma* (19200 bit/s)"),
            ("tcp://localhost:2947", "tcp://localhost:2947"),
            ("tcp://10.0.0.7:4001/", "tcp://10.0.0.7:4001"),
            ("udp://:10110", "udp://0.0.0.0:10110"),
            ("file:/tmp/gnss.nmea", "/tmp/gnss.nmea"),
        ] {
            assert_eq!(read(text).unwrap(), shown);
        }
        for text in ["ttyUSB0", "", "tcp://localhost", "udp://1.2.3.4:99999", "http://x:1"] {
            assert!(read(text).is_err(), "{text}");
        }
    }
}
