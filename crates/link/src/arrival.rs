//! How a packet came ashore, as hub, recorder and archive know it alike.

use std::fmt;

/// The way by which a packet came ashore. The numbers are those of the archive.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
#[repr(u8)]
pub enum Transport {
    /// Found in the archive without a record of its arrival, after a crash or the loss of the sidecar.
    Recovered = 0,
    /// The vessel link: records with sequence numbers, live values, commands that expire.
    Link = 1,
    /// The protocol of the IMCProxy: every packet to all others of this transport.
    Proxy = 2,
    /// Datagrams to and from an IMC node that announced itself.
    Udp = 3,
    /// A stream to or from an IMC node, such as DUNE's TCP server.
    Tcp = 4,
    /// A log that is read in.
    Import = 5,
    /// The shore's own people and programs.
    Shore = 6,
}

impl Transport {
    /// All of them, in the order of their numbers.
    pub const ALL: [Self; 7] =
        [Self::Recovered, Self::Link, Self::Proxy, Self::Udp, Self::Tcp, Self::Import, Self::Shore];

    /// A stable word for people and machines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Recovered => "recovered",
            Self::Link => "link",
            Self::Proxy => "imcproxy",
            Self::Udp => "udp",
            Self::Tcp => "tcp",
            Self::Import => "import",
            Self::Shore => "shore",
        }
    }

    /// The transport that the archive keeps as `code`.
    pub fn from_code(code: u8) -> Option<Self> {
        Self::ALL.get(usize::from(code)).copied()
    }

    /// Whether the same telemetry comes in copies through this transport, one for each receiver, that differ in
    /// nothing but their destination.
    pub fn brings_copies(self) -> bool {
        matches!(self, Self::Proxy | Self::Udp)
    }
}

impl fmt::Display for Transport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(self.name())
    }
}

/// The place of a packet in a vessel's record lane.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct LinkSeq {
    /// The run of numbers; a vessel starts another one when it lost its spool.
    pub stream: u64,
    /// The number, rising within a stream. Numbers may be left out (what was declared lost), never go back.
    pub seq: u64,
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_archive_reads_back_what_it_wrote() {
        for transport in Transport::ALL {
            assert_eq!(Transport::from_code(transport as u8), Some(transport));
        }
        assert_eq!(Transport::from_code(7), None);
    }
}
