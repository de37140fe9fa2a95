//! The server on the IMC network: its own address and the transports.

use hub::{Settings, Transport};
use imc::Address;
use serde::{Deserialize, Serialize};
use std::net::{IpAddr, SocketAddr};

/// The server as a system on the IMC network.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Imc {
    /// Its address, a number or registered name; a console's.
    pub address: String,
    /// The name that it announces.
    pub name: String,
    /// Whether it is an active console or only listens.
    pub active: bool,
}

/// Transports for IMC besides the vessel link.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Transports {
    /// Transports besides the link by which a vessel that has a link is believed too.
    pub trusted: Vec<String>,
    /// The IMCProxy's protocol.
    pub imcproxy: Imcproxy,
    /// The IMC node.
    pub udp: Udp,
    /// Streams to IMC nodes.
    pub tcp: Tcp,
}

/// The IMCProxy's protocol.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Imcproxy {
    /// Where to listen.
    pub listen: Listen,
    /// Addresses or networks that may connect; empty for all.
    pub allow: Vec<String>,
    /// Connections at once.
    pub max_peers: usize,
}

/// The IMC node.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Udp {
    /// Where to take datagrams.
    pub listen: Listen,
    /// Discovery ports.
    pub announce_ports: Vec<u16>,
    /// Addresses or networks that may take part; empty for all.
    pub allow: Vec<String>,
    /// Nodes at once.
    pub max_peers: usize,
}

/// Streams to IMC nodes.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Tcp {
    /// `host:port` of each.
    pub connect: Vec<String>,
}

/// An address and port to listen on, or an empty text for a transport that stays closed.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(try_from = "String", into = "String")]
pub struct Listen(Option<SocketAddr>);

impl Listen {
    /// Where, if anywhere.
    pub fn get(self) -> Option<SocketAddr> {
        self.0
    }
}

impl TryFrom<String> for Listen {
    type Error = String;
    fn try_from(text: String) -> Result<Self, String> {
        if text.is_empty() {
            return Ok(Self(None));
        }
        let address = text.parse().map_err(|_| {
            format!(
                "`{text}` is not an address and port, like 127.0.0.1:9090; leave it empty to keep the transport closed"
            )
        })?;
        Ok(Self(Some(address)))
    }
}

impl From<Listen> for String {
    fn from(listen: Listen) -> Self {
        listen.0.map(|address| address.to_string()).unwrap_or_default()
    }
}

impl Default for Imc {
    fn default() -> Self {
        Self { address: "0x4F00".to_owned(), name: "lutra".to_owned(), active: true }
    }
}

impl Default for Imcproxy {
    fn default() -> Self {
        Self { listen: Listen::default(), allow: Vec::new(), max_peers: 64 }
    }
}

impl Default for Udp {
    fn default() -> Self {
        let announce_ports = (30_100..=30_104).collect();
        Self { listen: Listen::default(), announce_ports, allow: Vec::new(), max_peers: 64 }
    }
}

impl Imc {
    /// Settings of the hub.
    pub(crate) fn settings(&self) -> Settings {
        let address = self.address.parse().unwrap_or(Address(0x4F00));
        Settings { address, name: self.name.clone(), active: self.active }
    }

    pub(super) fn problems(&self) -> Vec<String> {
        let mut problems = Vec::new();
        match self.address.parse::<Address>() {
            Ok(address) if address.is_ccu() => {}
            Ok(_) => problems.push(format!(
                "imc.address {} is not a console's: choose one of 0x4000 to 0x5FFF, or vessels do not count its \
                 heartbeats",
                self.address
            )),
            Err(error) => problems.push(format!("imc.address: {error}")),
        }
        if self.name.is_empty() || self.name.len() > 100 {
            problems.push("imc.name must have 1 to 100 characters".to_owned());
        }
        problems
    }
}

/// Transports without passwords.
const OPEN: [Transport; 3] = [Transport::Proxy, Transport::Udp, Transport::Tcp];

impl Transports {
    /// The transports besides the link by which a vessel that has a link is believed too.
    pub(crate) fn trusted(&self) -> Vec<Transport> {
        OPEN.into_iter()
            .filter(|transport| self.trusted.iter().any(|name| name == transport.name()))
            .collect()
    }

    pub(super) fn problems(&self) -> Vec<String> {
        let mut problems = Vec::new();
        let unknown =
            self.trusted.iter().filter(|name| OPEN.iter().all(|transport| transport.name() != *name));
        problems.extend(unknown.map(|name| {
            format!(
                "transports.trusted: `{name}` is not a transport without passwords: name imcproxy, udp or tcp"
            )
        }));
        let lists = [("imcproxy", &self.imcproxy.allow), ("udp", &self.udp.allow)];
        for (transport, allow) in lists {
            let bad = allow.iter().filter(|text| parse_network(text).is_none());
            problems.extend(bad.map(|text| {
                format!(
                    "transports.{transport}.allow: `{text}` is not an address or network, like 10.77.0.0/24"
                )
            }));
        }
        for (transport, peers) in [("imcproxy", self.imcproxy.max_peers), ("udp", self.udp.max_peers)] {
            if !(1..=10_000).contains(&peers) {
                problems.push(format!("transports.{transport}.max_peers must be 1 to 10000"));
            }
        }
        for node in &self.tcp.connect {
            let port = node.rsplit_once(':').filter(|(host, _)| !host.is_empty());
            if port.and_then(|(_, port)| port.parse::<u16>().ok()).is_none_or(|port| port == 0) {
                problems.push(format!(
                    "transports.tcp.connect: `{node}` is not a host:port, like 10.77.0.10:7001"
                ));
            }
        }
        problems
    }
}

/// An address, or a network as `address/bits`: the address and how many of its leading bits count.
pub fn parse_network(text: &str) -> Option<(IpAddr, u8)> {
    let (address, bits) = match text.split_once('/') {
        Some((address, bits)) => (address, Some(bits)),
        None => (text, None),
    };
    let address: IpAddr = address.parse().ok()?;
    let most = if address.is_ipv4() { 32 } else { 128 };
    let bits = bits.map_or(Some(most), |bits| bits.parse().ok())?;
    (bits <= most).then_some((address, bits))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn networks_are_read_or_refused() {
        assert_eq!(parse_network("10.77.0.0/24"), Some(([10, 77, 0, 0].into(), 24)));
        assert_eq!(parse_network("10.77.0.1"), Some(([10, 77, 0, 1].into(), 32)));
        assert_eq!(parse_network("::/0").map(|(_, bits)| bits), Some(0));
        for bad in ["", "10.77.0.0/33", "10.77.0/24", "vpn", "10.77.0.0/", "::1/129"] {
            assert_eq!(parse_network(bad), None, "{bad}");
        }
    }

    #[test]
    fn problems_name_the_key() {
        let imc = Imc { address: "0x0801".to_owned(), name: String::new(), active: true };
        let found = imc.problems();
        assert!(found[0].starts_with("imc.address") && found[1].starts_with("imc.name"), "{found:?}");
        let mut transports = Transports::default();
        transports.udp.allow = vec!["everywhere".to_owned()];
        transports.imcproxy.max_peers = 0;
        transports.tcp.connect = vec!["otter".to_owned(), ":7001".to_owned(), "otter:7001".to_owned()];
        transports.trusted = vec!["tcp".to_owned(), "link".to_owned()];
        assert_eq!(transports.problems().len(), 5);
        assert_eq!(transports.trusted(), [Transport::Tcp]);
    }

    #[test]
    fn an_empty_address_keeps_a_transport_closed() {
        assert_eq!(Listen::try_from(String::new()).unwrap().get(), None);
        assert_eq!(Listen::try_from("127.0.0.1:9090".to_owned()).unwrap().get().unwrap().port(), 9090);
        assert!(Listen::try_from("9090".to_owned()).unwrap_err().contains("127.0.0.1:9090"));
    }
}
