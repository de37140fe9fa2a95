//! The ports of the server that vessels may reach.

use std::collections::BTreeSet;
use std::fmt;

/// The transport protocol of a port.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Protocol {
    /// Streams.
    Tcp,
    /// Datagrams.
    Udp,
}

/// A port of the server.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub struct Door {
    /// How it is spoken through.
    pub protocol: Protocol,
    /// Its number.
    pub port: u16,
}

/// Doors, each once.
pub type Doors = BTreeSet<Door>;

impl Door {
    /// Reads `tcp/8080` or `udp/6001`.
    ///
    /// # Errors
    /// In words: what to write.
    pub fn parse(text: &str) -> Result<Self, String> {
        let wrong = || "write protocol and port, like tcp/8080 or udp/6001".to_owned();
        let (protocol, port) = text.split_once('/').ok_or_else(wrong)?;
        let protocol = match protocol {
            "tcp" => Protocol::Tcp,
            "udp" => Protocol::Udp,
            _ => return Err(wrong()),
        };
        match port.parse() {
            Ok(port) if port > 0 => Ok(Self { protocol, port }),
            _ => Err(wrong()),
        }
    }
}

impl fmt::Display for Door {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let protocol = match self.protocol {
            Protocol::Tcp => "tcp",
            Protocol::Udp => "udp",
        };
        write!(f, "{protocol}/{}", self.port)
    }
}
