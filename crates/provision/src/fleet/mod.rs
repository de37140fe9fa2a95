//! The contents of a fleet file, in types that cannot hold invalid values.
//!
//! `fields` reads tables and keeps the position of each value, `read` makes the types from them, `rules` compares vessels
//! with each other and with the VPN, `problem` is the report of a mistake.

mod door;
mod fields;
mod network;
mod problem;
mod read;
mod rules;
mod ways;

#[cfg(test)]
mod tests;

pub use door::{Door, Doors, Protocol};
pub use network::Network;
pub use problem::Problem;
pub use read::{MAX_FILE_BYTES, MAX_VESSELS};
pub(crate) use read::{VESSEL_ADDRESSES, is_name};
pub use ways::Way;

use std::net::Ipv4Addr;

/// A fleet, as one file describes it.
#[derive(Debug, Clone, PartialEq)]
pub struct Fleet {
    /// The shore.
    pub server: Server,
    /// The network between shore and vessels.
    pub vpn: Vpn,
    /// The vessels, in the file's order; no two share a name or an address.
    pub vessels: Vec<Vessel>,
}

/// The shore's server, as vessels see it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Server {
    /// Name or address by which the internet reaches it: where vessels send the VPN's packets.
    pub public_name: String,
    /// Port of the vessel link, inside the VPN.
    pub link_port: u16,
    /// Whether the link is encrypted once more inside the VPN (`wss`).
    pub encrypted: bool,
    /// Its other ports that vessels may reach.
    pub doors: Doors,
}

/// The program that makes the VPN.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum VpnKind {
    /// WireGuard.
    WireGuard,
    /// OpenVPN 2.5 or later, over UDP.
    OpenVpn,
}

impl VpnKind {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::WireGuard, Self::OpenVpn];

    /// As the fleet file calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::WireGuard => "wireguard",
            Self::OpenVpn => "openvpn",
        }
    }

    /// The one that is not this.
    #[must_use]
    pub const fn other(self) -> Self {
        match self {
            Self::WireGuard => Self::OpenVpn,
            Self::OpenVpn => Self::WireGuard,
        }
    }

    /// Its usual UDP port.
    const fn port(self) -> u16 {
        match self {
            Self::WireGuard => 51_820,
            Self::OpenVpn => 1_194,
        }
    }
}

/// The VPN.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Vpn {
    /// The program that makes it.
    pub kind: VpnKind,
    /// Where all its addresses are.
    pub network: Network,
    /// The server's.
    pub server_address: Ipv4Addr,
    /// UDP port of the server.
    pub port: u16,
    /// How often a vessel that has nothing to say keeps its way open (s).
    pub keepalive_s: u16,
}

/// One vessel.
#[derive(Debug, Clone, PartialEq)]
pub struct Vessel {
    /// Its name everywhere: on the pages, in IMC, of its files.
    pub name: String,
    /// Its IMC address.
    pub imc_address: u16,
    /// Its address in the VPN.
    pub vpn_address: Ipv4Addr,
    /// How its agent is run.
    pub profile: Profile,
    /// `Vehicle Type` of its configuration.
    pub hull: Option<String>,
    /// Its devices and where they are plugged in, each once.
    pub devices: Vec<(Device, String)>,
    /// Its limits.
    pub limits: Limits,
    /// Its ways to the shore; none for the one by its computer's routes.
    pub ways: Vec<Way>,
    /// Any other parameter of its configuration.
    pub settings: Vec<Setting>,
}

/// How an agent is run.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Profile {
    /// With the devices aboard.
    Hardware,
    /// With a simulated hull.
    Simulation,
}

impl Profile {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Hardware, Self::Simulation];

    /// As the agent calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Hardware => "Hardware",
            Self::Simulation => "Simulation",
        }
    }
}

/// A device whose place differs from boat to boat.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Device {
    /// Satellite positions and heading.
    Compass,
    /// The hydrophone.
    Hydrophone,
    /// The motors' card on its CAN bus.
    Motors,
}

impl Device {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Compass, Self::Hydrophone, Self::Motors];

    /// As the fleet file calls it.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Compass => "compass",
            Self::Hydrophone => "hydrophone",
            Self::Motors => "motors",
        }
    }
}

/// The limits of a vessel; `None` leaves the agent's own.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Limits {
    /// Top speed (m/s).
    pub top_speed_mps: Option<f64>,
    /// Least depth in which an operator may steer it by hand (m).
    pub navigable_depth_m: Option<f64>,
    /// Least depth in which it may sail autonomously (m).
    pub autonomous_depth_m: Option<f64>,
    /// How far it reaches below the water (m).
    pub draught_m: Option<f64>,
    /// How long it continues without the shore (s).
    pub lost_link_s: Option<f64>,
}

/// A parameter of a vessel's configuration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Setting {
    /// The section, without brackets.
    pub section: String,
    /// The parameter.
    pub key: String,
    /// Its value.
    pub value: String,
}

impl Fleet {
    /// Reads a fleet file.
    ///
    /// # Errors
    /// Everything that is wrong with it, in the file's order.
    pub fn read(text: &str) -> Result<Self, Vec<Problem>> {
        read::fleet(text)
    }

    /// The vessel of this name, capital and small letters being the same.
    pub fn vessel(&self, name: &str) -> Option<&Vessel> {
        self.vessels.iter().find(|vessel| vessel.name.eq_ignore_ascii_case(name))
    }

    /// Where vessels find the link.
    pub fn link_url(&self) -> String {
        let scheme = if self.server.encrypted { "wss" } else { "ws" };
        format!("{scheme}://{}:{}/link", self.vpn.server_address, self.server.link_port)
    }
}
