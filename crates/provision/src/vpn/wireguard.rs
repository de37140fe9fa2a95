//! WireGuard's configurations, as `wg-quick` reads them (its manual page names the keys).
//!
//! The server's side is also the record of who has a place: a vessel whose own file ashore is damaged or lost keeps its peer.

use super::{Peer, VpnKey};
use crate::fleet::{Fleet, Vessel};
use std::fmt::Write as _;
use std::net::{IpAddr, Ipv6Addr};

/// Stands between the blocks of a file.
const GAP: &str = "\n\n";

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

/// The peers in what [`ashore`] wrote; what is damaged in it is left out.
pub fn peers(ashore: &str) -> Vec<Peer> {
    ashore.split(GAP).filter_map(peer).collect()
}

/// What [`ashore`] wrote without the peer of this vessel, whatever its block says besides the name.
pub fn without(ashore: &str, name: &str) -> String {
    let own = format!("# {name}\n");
    let mut blocks: Vec<&str> = ashore.split(GAP).collect();
    blocks.retain(|block| !block.starts_with(&own));
    blocks.join(GAP).trim_end().to_owned() + "\n"
}

fn peer(block: &str) -> Option<Peer> {
    let mut lines = block.lines();
    let name = lines.next()?.strip_prefix("# ")?.to_owned();
    (lines.next()? == "[Peer]").then_some(())?;
    let public = lines.next()?.strip_prefix("PublicKey = ")?.to_owned();
    let address = lines.next()?.strip_prefix("AllowedIPs = ")?.strip_suffix("/32")?.parse().ok()?;
    Some(Peer { name, address, public })
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
