//! Destinations, and a check of those that need confirmation.

use crate::report;
use anyhow::{Context as _, bail};
use std::net::{IpAddr, Ipv4Addr, SocketAddr, SocketAddrV4, TcpStream, ToSocketAddrs as _};
use std::str::FromStr;
use std::time::Duration;

/// How long to wait for a connection.
const CONNECT_WAIT: Duration = Duration::from_secs(10);

/// A host, with or without a port.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Peer {
    /// Name or IPv4 address.
    pub(crate) host: String,
    /// Port, when one was given.
    pub(crate) port: Option<u16>,
}

impl FromStr for Peer {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (host, port) = match text.rsplit_once(':') {
            Some((host, port)) => {
                let port = port.parse().ok().filter(|port| *port != 0);
                (host, Some(port.ok_or("the port is not a number from 1 to 65535")?))
            }
            None => (text, None),
        };
        if host.is_empty() {
            return Err("expected HOST or HOST:PORT, such as 10.0.10.60:6002".to_owned());
        }
        Ok(Self { host: host.to_owned(), port })
    }
}

impl Peer {
    /// The IPv4 address, with `default_port` if none was given.
    ///
    /// # Errors
    /// When the host has none.
    pub(crate) fn resolve(&self, default_port: u16) -> anyhow::Result<SocketAddrV4> {
        let port = self.port.unwrap_or(default_port);
        let host = &self.host;
        let all = (host.as_str(), port).to_socket_addrs().with_context(|| format!("cannot find {host}"))?;
        let first = all.into_iter().find_map(|address| match address {
            SocketAddr::V4(address) => Some(address),
            SocketAddr::V6(_) => None,
        });
        first.with_context(|| format!("{host} has no IPv4 address, and vehicles speak no other"))
    }
}

/// Refuses destinations that reach more than one system unless that is wanted, and prints a note for public addresses.
///
/// # Errors
/// When the destination is a broadcast or multicast address and `broadcast` is not set.
pub(crate) fn guard(to: Ipv4Addr, broadcast: bool) -> anyhow::Result<()> {
    if (to.is_broadcast() || to.is_multicast()) && !broadcast {
        bail!("{to} reaches every system on the network, vehicles under way too: add --broadcast to mean it");
    }
    mention_public(IpAddr::V4(to));
    Ok(())
}

/// Prints a note if packets go to an address outside local networks.
pub(crate) fn mention_public(to: IpAddr) {
    let local = match to {
        IpAddr::V4(to) => {
            to.is_loopback()
                || to.is_private()
                || to.is_link_local()
                || to.is_broadcast()
                || to.is_multicast()
                || to.is_unspecified()
        }
        IpAddr::V6(to) => to.is_loopback() || to.is_unique_local() || to.is_unicast_link_local(),
    };
    if !local {
        report::note(&format!(
            "{to} is a public address: IMC goes there unprotected, readable by anyone between"
        ));
    }
}

/// Connects to the first address of `HOST:PORT` that answers.
///
/// # Errors
/// When the text is not an address or none answers.
pub(crate) fn connect(host_port: &str) -> anyhow::Result<TcpStream> {
    let place = || format!("cannot find {host_port}: expected HOST:PORT, such as 127.0.0.1:6003");
    let mut last = None;
    for address in host_port.to_socket_addrs().with_context(place)? {
        match TcpStream::connect_timeout(&address, CONNECT_WAIT) {
            Ok(stream) => {
                mention_public(address.ip());
                stream.set_nodelay(true)?;
                stream.set_write_timeout(Some(CONNECT_WAIT))?;
                return Ok(stream);
            }
            Err(error) => last = Some(error),
        }
    }
    let error = last.map_or_else(|| anyhow::anyhow!("it has no address"), anyhow::Error::from);
    Err(error.context(format!("cannot connect to {host_port}")))
}
