//! The VPN between shore and vessels: keys, the files of WireGuard or OpenVPN, and the firewall that lets
//! vessels reach the server's doors only.

mod key;
mod nftables;
pub mod openvpn;
pub mod wireguard;

#[cfg(test)]
mod tests;

pub use key::VpnKey;
pub use nftables::nftables;

use std::net::Ipv4Addr;

/// The name of the VPN's interface, ashore and aboard, and of its files.
pub const INTERFACE: &str = "lutra";

/// A vessel that may take part by WireGuard, and the public half of its key.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Peer {
    /// Its name.
    pub name: String,
    /// Its address in the VPN.
    pub address: Ipv4Addr,
    /// As [`VpnKey::public`] writes it.
    pub public: String,
}
