//! The origin of a request, determined through trusted reverse proxies.

use super::peer::Peer;
use crate::config::Http;
use axum::extract::FromRequestParts;
use axum::http::HeaderMap;
use axum::http::request::Parts;
use std::convert::Infallible;
use std::net::{IpAddr, Ipv4Addr};

/// The client, as known from the network.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Remote {
    pub(crate) address: IpAddr,
    /// Whether the browser's connection is encrypted, here or at a trusted proxy.
    pub(crate) encrypted: bool,
    /// Whether the request was made on this machine and not forwarded by a proxy.
    pub(crate) here: bool,
}

impl Remote {
    /// Determines the client from the connection and the headers.
    pub(crate) fn of(peer: Peer, headers: &HeaderMap, http: &Http) -> Self {
        let connected = peer.address.ip().to_canonical();
        let trusted = |address: &IpAddr| http.trusted_proxies.contains(address);
        let forwarded = headers.get_all("x-forwarded-for").iter().filter_map(|value| value.to_str().ok());
        let hops: Vec<&str> = forwarded.flat_map(|value| value.split(',')).map(str::trim).collect();
        if !trusted(&connected) {
            let here = connected.is_loopback() && hops.is_empty();
            return Self { address: connected, encrypted: peer.encrypted, here };
        }
        // Every proxy appends the address it saw, so the last one that is not our proxy is the client.
        let hops = hops.iter().rev().map_while(|hop| hop.parse::<IpAddr>().ok());
        let address = hops.map(|hop| hop.to_canonical()).find(|hop| !trusted(hop)).unwrap_or(connected);
        let scheme = headers.get("x-forwarded-proto").and_then(|value| value.to_str().ok());
        Self { address, encrypted: peer.encrypted || scheme == Some("https"), here: false }
    }

    /// Scheme and host name by which the client reaches the server: for addresses in files. Invalid host names are ignored.
    pub(crate) fn origin(&self, headers: &HeaderMap) -> String {
        let host =
            headers.get(axum::http::header::HOST).and_then(|host| host.to_str().ok()).unwrap_or_default();
        let is_host = |one: u8| one.is_ascii_alphanumeric() || b".-:[]".contains(&one);
        let host = if !host.is_empty() && host.len() <= 255 && host.bytes().all(is_host) {
            host
        } else {
            "localhost"
        };
        format!("{}://{host}", if self.encrypted { "https" } else { "http" })
    }
}

impl<S: Sync> FromRequestParts<S> for Remote {
    type Rejection = Infallible;
    async fn from_request_parts(parts: &mut Parts, _: &S) -> Result<Self, Infallible> {
        let nobody = Self { address: IpAddr::V4(Ipv4Addr::UNSPECIFIED), encrypted: false, here: false };
        Ok(parts.extensions.get::<Self>().copied().unwrap_or(nobody))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn remote(from: &str, forwarded: &[&str], trusted: &[&str]) -> Remote {
        let mut headers = HeaderMap::new();
        for value in forwarded {
            headers.append("x-forwarded-for", value.parse().unwrap());
        }
        let trusted_proxies = trusted.iter().map(|address| address.parse().unwrap()).collect();
        let http = Http { trusted_proxies, ..Http::default() };
        Remote::of(Peer { address: from.parse().unwrap(), encrypted: false }, &headers, &http)
    }

    #[test]
    fn nobody_is_believed_but_trusted_proxies() {
        let stranger = remote("198.51.100.9:1", &["127.0.0.1"], &["127.0.0.1"]);
        assert_eq!((stranger.address.to_string().as_str(), stranger.here), ("198.51.100.9", false));
    }

    #[test]
    fn the_last_address_that_is_no_proxy_counts() {
        let behind =
            remote("127.0.0.1:1", &["1.1.1.1, 198.51.100.9", "10.0.0.1"], &["127.0.0.1", "10.0.0.1"]);
        assert_eq!(behind.address.to_string(), "198.51.100.9");
    }

    #[test]
    fn only_an_unforwarded_request_is_from_here() {
        assert!(remote("127.0.0.1:1", &[], &[]).here);
        assert!(remote("[::ffff:127.0.0.1]:1", &[], &[]).here);
        assert!(!remote("127.0.0.1:1", &["198.51.100.9"], &[]).here);
        assert!(!remote("127.0.0.1:1", &["rubbish"], &["127.0.0.1"]).here);
    }
}
