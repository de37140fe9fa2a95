//! This command as an IMC node: a console that announces itself and sends heartbeats.
//!
//! A DUNE sends nothing by UDP to a system before that system has announced an `imc+udp` address, and stops
//! when it hears nothing for 30 s. It also counts only heartbeats from control units (0x4000 to 0x5FFF) as the presence of
//! an operator.

use anyhow::Context as _;
use imc::messages::{Announce, Heartbeat, SystemType};
use imc::services::{self, Service};
use imc::{ANY_ENTITY, Address, Header, Packet, catalogue};
use std::net::SocketAddrV4;
use std::time::{SystemTime, UNIX_EPOCH};

/// Identity of this command.
#[derive(Debug, Clone, clap::Args)]
pub(crate) struct Node {
    /// Address to be known by; a control unit's (0x4000 to 0x5FFF), or vehicles will not see an operator
    #[arg(long, value_name = "SYSTEM", default_value = "0x4001")]
    pub(crate) id: Address,
    /// Name to be known by
    #[arg(long, value_name = "NAME", default_value = "imc-cli")]
    name: String,
}

/// Seconds since 1970-01-01 by this computer's clock.
pub(crate) fn now_s() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).map_or(0.0, |since| since.as_secs_f64())
}

impl Node {
    /// A node with this address and name.
    pub(crate) fn new(id: Address, name: &str) -> Self {
        Self { id, name: name.to_owned() }
    }

    /// The packet that makes this node known, reachable at `at`.
    ///
    /// # Errors
    /// When the name is too long for a packet.
    pub(crate) fn announce(&self, at: SocketAddrV4) -> anyhow::Result<Vec<u8>> {
        let host = at.ip().to_string();
        let version = format!("version/{}", catalogue::VERSION);
        let udp = Service { scheme: "imc+udp", host: &host, port: Some(at.port()), path: "" };
        let info = Service { scheme: "imc+info", host: "0.0.0.0", port: None, path: &version };
        let message = Announce {
            sys_name: self.name.as_str().into(),
            sys_type: SystemType::Ccu,
            owner: Address::NULL.0,
            services: services::build([info, udp]).into(),
            ..Announce::default()
        };
        self.packet(Address::ANNOUNCE, message)
    }

    /// The packet that says this node is alive.
    ///
    /// # Errors
    /// Never in practice: it has no fields.
    pub(crate) fn heartbeat(&self) -> anyhow::Result<Vec<u8>> {
        self.packet(Address::NULL, Heartbeat)
    }

    fn packet(&self, dst: Address, message: impl Into<imc::Message>) -> anyhow::Result<Vec<u8>> {
        let header = Header { timestamp: now_s(), src: self.id, src_ent: 0, dst, dst_ent: ANY_ENTITY };
        Packet::new(header, message).encode().context("cannot announce this system")
    }
}
