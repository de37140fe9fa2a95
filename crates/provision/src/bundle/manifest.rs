//! The manifest of a bundle.

use serde::{Deserialize, Serialize};
use sha2::{Digest as _, Sha256};

/// The purpose of a file of a bundle. The agent decides its path; a bundle holds none.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Part {
    /// The overlay of the agent's configuration.
    Overlay,
    /// The token of the link.
    Token,
    /// The certificate of the authority that the server's is checked by.
    Authority,
    /// WireGuard's configuration.
    Vpn,
    /// OpenVPN's configuration.
    OpenVpn,
    /// The sea chart's index.
    Chart,
}

impl Part {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Overlay, Self::Token, Self::Authority, Self::Vpn, Self::OpenVpn, Self::Chart];

    /// As the manifest calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Overlay => "vessel.ini",
            Self::Token => "lutra.token",
            Self::Authority => "ca.pem",
            Self::Vpn => "lutra.conf",
            Self::OpenVpn => "openvpn.conf",
            Self::Chart => "chart.lutra-index",
        }
    }

    /// From its name in the manifest.
    pub fn named(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|part| part.name() == name)
    }
}

/// The manifest of a bundle; it holds no secret.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Manifest {
    /// The format, at most [`crate::FORMAT`].
    pub format: u16,
    /// The vessel's name.
    pub vessel: String,
    /// Its IMC address.
    pub imc_address: u16,
    /// The profile that its agent runs with.
    pub profile: String,
    /// When the bundle was made (µs since 1970, UTC).
    pub made_us: i64,
    /// By which version of the server.
    pub made_by: String,
    /// Where its devices are plugged in.
    pub devices: Vec<Port>,
    /// The files.
    pub files: Vec<Item>,
}

/// A device and its port.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Port {
    /// As the fleet file calls it.
    pub device: String,
    /// As the agent's configuration has it.
    pub port: String,
}

/// A file of a bundle.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Item {
    /// Its purpose, as [`Part::name`].
    pub name: String,
    /// How long it is.
    pub bytes: u64,
    /// SHA-256 of its bytes, in hexadecimal digits.
    pub sha256: String,
}

impl Item {
    pub(super) fn of(part: Part, bytes: &[u8]) -> Self {
        let sha256 = hex::encode(Sha256::digest(bytes));
        Self { name: part.name().to_owned(), bytes: bytes.len() as u64, sha256 }
    }
}
