//! WireGuard's configurations, as `wg-quick` reads them (its manual page names the keys).

use super::{Peer, VpnKey};
use crate::fleet::{Fleet, Vessel};
use std::fmt::Write as _;
use std::net::{IpAddr, Ipv6Addr};

/// The server's side: it knows every peer by key and single address.
pub fn ashore(fleet: &Fleet, key: &VpnKey, peers: &[Peer]) -> String {
    let vpn = &fleet.vpn;
    let mut text = format!(
        "# Lutra's VPN, the server's side. Written by `lutra-server fleet apply`: change the fleet file.\n\
         [Interface]\n# No tunnel without its firewall.\nPreUp = nft -f /etc/wireguard/lutra.nft\n\
         Address = {}/{}\nListenPort = {}\nPrivateKey = {}\n",
        vpn.server_address,
        vpn.network.bits(),
        vpn.port,
        key.private()
    );
    for Peer { name, address, public } in peers {
        write!(text, "\n# {name}\n[Peer]\nPublicKey = {public}\nAllowedIPs = {address}/32\n").ok();
    }
    text
}

/// A vessel's side: through the tunnel goes what is for the server, and nothing else.
pub fn aboard(fleet: &Fleet, vessel: &Vessel, key: &VpnKey, server_public: &str) -> String {
    let vpn = &fleet.vpn;
    let host = match fleet.server.public_name.parse::<Ipv6Addr>() {
        Ok(address) => format!("[{}]", IpAddr::from(address)),
        Err(_) => fleet.server.public_name.clone(),
    };
    format!(
        "# Lutra's VPN, the side of {}. Written by `lutra-agent provision`: change the fleet file ashore.\n\
         [Interface]\nAddress = {}/32\nPrivateKey = {}\n\n\
         # The shore.\n[Peer]\nPublicKey = {server_public}\nAllowedIPs = {}/32\nEndpoint = {host}:{}\nPersistentKeepalive = {}\n",
        vessel.name,
        vessel.vpn_address,
        key.private(),
        vpn.server_address,
        vpn.port,
        vpn.keepalive_s
    )
}
