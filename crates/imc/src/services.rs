//! The services of an `Announce`: where and how a system can be reached.
//!
//! `services = [ uri *( ";" uri ) [ ";" ] ]`, `uri = scheme "://" host [ ":" port ] [ "/" path ]`

use std::fmt;
use std::net::{Ipv4Addr, SocketAddrV4};

/// One service.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Service<'a> {
    /// What is spoken, such as `imc+udp`.
    pub scheme: &'a str,
    /// Host name or address; `0.0.0.0` where it means nothing.
    pub host: &'a str,
    /// Port, where one is given.
    pub port: Option<u16>,
    /// What comes after the host and port, without the first slash.
    pub path: &'a str,
}

impl<'a> Service<'a> {
    /// One URI; `None` when it is none or its port is no port.
    pub fn parse(uri: &'a str) -> Option<Self> {
        let (scheme, rest) = uri.trim().split_once("://")?;
        let (authority, path) = rest.split_once('/').unwrap_or((rest, ""));
        let (host, port) = match authority.split_once(':') {
            Some((host, port)) => (host, Some(port.parse().ok()?)),
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

/// All services of the text; what is no URI is passed over, as other programs do.
pub fn parse(services: &str) -> impl Iterator<Item = Service<'_>> {
    services.split(';').filter_map(Service::parse)
}

/// The text of services, without a `;` at its end.
pub fn build<'a>(services: impl IntoIterator<Item = Service<'a>>) -> String {
    services.into_iter().map(|service| service.to_string()).collect::<Vec<_>>().join(";")
}

/// Where to send packets by UDP: the `imc+udp` service at `seen_from`, the address that the announcement
/// came from, else the first one.
pub fn udp_socket(services: &str, seen_from: Option<Ipv4Addr>) -> Option<SocketAddrV4> {
    let sockets = || parse(services).filter(|service| service.scheme == "imc+udp").filter_map(|s| s.socket());
    sockets().find(|socket| Some(*socket.ip()) == seen_from).or_else(|| sockets().next())
}

/// The number that a system drew at its start; another number means that it started anew.
pub fn uid(services: &str) -> Option<&str> {
    parse(services).find_map(|service| service.path.strip_prefix("uid/")).map(|uid| uid.trim_end_matches('/'))
}

/// The version of IMC that a system says it speaks. It does not identify the message layouts.
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
        assert_eq!(udp_socket(DUNE, Some([10, 0, 2, 7].into())), "10.0.2.7:6002".parse().ok());
        assert_eq!(udp_socket(DUNE, Some([10, 9, 9, 9].into())), "127.0.0.1:6002".parse().ok());
        assert_eq!(udp_socket("imc+tcp://10.0.2.7:6003/", None), None);
    }

    #[test]
    fn passes_over_what_is_no_service() {
        let services = ";;nonsense;imc+udp://;://x;imc+udp://h:99999/;imc+udp://1.2.3.4:0/;neptus://a/b/;";
        let schemes: Vec<&str> = parse(services).map(|service| service.scheme).collect();
        assert_eq!(schemes, ["imc+udp", "neptus"]);
        assert_eq!(udp_socket(services, None), None);
        assert_eq!(parse("").count(), 0);
    }
}
