//! The services of an `Announce`: where and how a system can be reached.
//!
//! `services = [ uri *( ";" uri ) [ ";" ] ]`, `uri = scheme "://" host [ ":" port ] [ "/" path ]`

use std::cmp::Reverse;
use std::fmt;
use std::net::{Ipv4Addr, SocketAddrV4};

/// One service.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Service<'a> {
    /// The protocol, such as `imc+udp`.
    pub scheme: &'a str,
    /// Host name or address; `0.0.0.0` where it means nothing.
    pub host: &'a str,
    /// Port, where one is given.
    pub port: Option<u16>,
    /// The path after host and port, without the first slash.
    pub path: &'a str,
}

impl<'a> Service<'a> {
    /// One URI; `None` when it is not valid or its port is not a port.
    pub fn parse(uri: &'a str) -> Option<Self> {
        let (scheme, rest) = uri.trim().split_once("://")?;
        let (authority, path) = rest.split_once('/').unwrap_or((rest, ""));
        let (host, port) = match authority.split_once(':') {
            Some((host, port)) => (host, Some(port_number(port)?)),
            None => (authority, None),
        };
        (!scheme.is_empty() && !host.is_empty()).then_some(Self { scheme, host, port, path })
    }

    /// The address and port to send to, when the host is an IPv4 address and the port is not 0.
    pub fn socket(&self) -> Option<SocketAddrV4> {
        let ip: Ipv4Addr = self.host.parse().ok()?;
        Some(SocketAddrV4::new(ip, self.port.filter(|port| *port != 0)?))
    }
}

impl fmt::Display for Service<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}://{}", self.scheme, self.host)?;
        if let Some(port) = self.port {
            write!(f, ":{port}")?;
        }
        write!(f, "/{}", self.path)
    }
}

/// A port without the sign that `parse` would take.
fn port_number(text: &str) -> Option<u16> {
    text.bytes().all(|digit| digit.is_ascii_digit()).then(|| text.parse().ok())?
}

/// All services of the text; what is not a URI is passed over, as other programs do.
pub fn parse(services: &str) -> impl Iterator<Item = Service<'_>> {
    services.split(';').filter_map(Service::parse)
}

/// The text of services, without a `;` at its end.
pub fn build<'a>(services: impl IntoIterator<Item = Service<'a>>) -> String {
    services.into_iter().map(|service| service.to_string()).collect::<Vec<_>>().join(";")
}

/// Where to send packets by UDP, given the address that the announcement came from.
///
/// The `imc+udp` service at that very address, else the one that shares most leading bits with it. Loopback
/// and unspecified addresses of another host are never taken: they would be this host.
pub fn udp_socket(services: &str, seen_from: Ipv4Addr) -> Option<SocketAddrV4> {
    let sockets = parse(services).filter(|service| service.scheme == "imc+udp").filter_map(|s| s.socket());
    let reachable = sockets.filter(|socket| {
        let ip = *socket.ip();
        ip == seen_from || seen_from.is_loopback() || !(ip.is_loopback() || ip.is_unspecified())
    });
    let shared_bits = |socket: &SocketAddrV4| (socket.ip().to_bits() ^ seen_from.to_bits()).leading_zeros();
    // Of several alike the first: `max_by_key` alone would take the last.
    reachable
        .enumerate()
        .max_by_key(|(at, socket)| (shared_bits(socket), Reverse(*at)))
        .map(|(_, socket)| socket)
}

/// The number that a system drew at its start; another number means that it started again.
pub fn uid(services: &str) -> Option<&str> {
    parse(services).find_map(|service| service.path.strip_prefix("uid/")).map(|uid| uid.trim_end_matches('/'))
}

/// The version of IMC that a system announces. It does not identify the message layouts.
pub fn imc_version(services: &str) -> Option<&str> {
    let mut info = parse(services).filter(|service| service.scheme == "imc+info");
    info.find_map(|service| service.path.strip_prefix("version/"))
        .map(|version| version.trim_end_matches('/'))
}

#[cfg(test)]
mod tests {
    use super::*;

    const DUNE: &str = "dune://0.0.0.0/uid/1763711007;dune://0.0.0.0/version/2026.01.0;ftp://10.0.2.7:30021/;\
        http://10.0.2.7:8080/dune;imc+info://0.0.0.0/version/5.4.31;imc+tcp://10.0.2.7:6003/;\
        imc+udp://127.0.0.1:6002/;imc+udp://10.0.2.7:6002/";

    #[test]
    fn reads_what_dune_announces() {
        let all: Vec<Service<'_>> = parse(DUNE).collect();
        assert_eq!(all.len(), 8);
        let http = Service { scheme: "http", host: "10.0.2.7", port: Some(8080), path: "dune" };
        assert_eq!(all[3], http);
        assert_eq!(uid(DUNE), Some("1763711007"));
        assert_eq!(imc_version(DUNE), Some("5.4.31"));
        assert_eq!(build(all), DUNE);
    }

    #[test]
    fn prefers_the_address_the_announcement_came_from() {
        let from = |ip: [u8; 4]| udp_socket(DUNE, ip.into());
        assert_eq!(from([10, 0, 2, 7]), "10.0.2.7:6002".parse().ok());
        assert_eq!(from([10, 9, 9, 9]), "10.0.2.7:6002".parse().ok());
        assert_eq!(from([127, 0, 0, 1]), "127.0.0.1:6002".parse().ok());
        let two = "imc+udp://10.8.0.7:6002/;imc+udp://192.168.1.7:6003/;imc+udp://192.168.1.9:6004/";
        assert_eq!(udp_socket(two, [192, 168, 1, 8].into()), "192.168.1.9:6004".parse().ok());
        assert_eq!(udp_socket(two, [192, 168, 200, 1].into()), "192.168.1.7:6003".parse().ok());
    }

    #[test]
    fn never_sends_to_ourselves_what_is_meant_for_another() {
        for services in ["imc+udp://127.0.0.1:6002/", "imc+udp://0.0.0.0:6002/", "imc+tcp://10.0.2.7:6003/"] {
            assert_eq!(udp_socket(services, [10, 8, 0, 1].into()), None);
        }
    }

    #[test]
    fn passes_over_what_is_no_service() {
        let services = ";;nonsense;imc+udp://;://x;imc+udp://h:99999/;imc+udp://h:+1/;imc+udp://1.2.3.4:0/;\
            neptus://a/b/;";
        let schemes: Vec<&str> = parse(services).map(|service| service.scheme).collect();
        assert_eq!(schemes, ["imc+udp", "neptus"]);
        assert_eq!(udp_socket(services, [1, 2, 3, 4].into()), None);
        assert_eq!(parse("").count(), 0);
    }
}
