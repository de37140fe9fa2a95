//! Keys and files of the VPN. Whether `wg` and `nft` take the files is tested where the server writes them.

use super::*;
use crate::fleet::{Fleet, Vessel};

const EXAMPLE: &str = include_str!("../../../../deploy/fleet.example.toml");

fn peer(vessel: &Vessel, public: &str) -> Peer {
    Peer { name: vessel.name.clone(), address: vessel.vpn_address, public: public.to_owned() }
}

/// The pair of RFC 7748, section 6.1; `wg pubkey` says the same.
#[test]
fn a_public_key_is_that_of_the_standard() {
    let private = VpnKey::parse("dwdtCnMYpX08FsFyUbJmRd9ML4frwJkqsXf7pR25LCo=").unwrap();
    assert_eq!(private.public(), "hSDwCYkwp1R0i33ctD73Wg2/Og0mOBr066SpjqqbTmo=");
}

#[test]
fn a_key_is_read_as_it_was_written_and_does_not_show_itself() {
    let key = VpnKey::from_random([7; 32]);
    let read = VpnKey::parse(&format!("{}\n", key.private())).unwrap();
    assert_eq!((read.private(), read.public()), (key.private(), key.public()));
    assert_eq!(format!("{key:?}"), "VpnKey(…)");
    for text in ["", "AAAA", &"A".repeat(44), &key.private()[1..]] {
        assert!(VpnKey::parse(text).is_none(), "{text}");
    }
}

#[test]
fn each_side_lets_through_what_is_for_the_other_alone() {
    let fleet = Fleet::read(EXAMPLE).unwrap();
    let (shore, boat) = (VpnKey::from_random([1; 32]), VpnKey::from_random([2; 32]));
    let (vessel, public) = (&fleet.vessels[0], boat.public());
    let ashore = wireguard::ashore(&fleet, &shore, &[peer(vessel, &public)]);
    let aboard = wireguard::aboard(&fleet, vessel, &boat, &shore.public());
    assert!(ashore.contains("AllowedIPs = 10.8.0.11/32") && ashore.contains(&public), "{ashore}");
    assert!(!ashore.contains("10.8.0.12") && !ashore.contains(&boat.private()));
    for line in [
        "Address = 10.8.0.11/32",
        "AllowedIPs = 10.8.0.1/32",
        "Endpoint = lutra.example.org:51820",
        "PersistentKeepalive = 25",
    ] {
        assert!(aboard.lines().any(|one| one == line), "{line} in {aboard}");
    }
    assert!(aboard.contains(&boat.private()) && !aboard.contains(&shore.private()));
}

#[test]
fn the_firewall_opens_the_doors_and_nothing_else() {
    let text = EXAMPLE.replace("doors = []", "doors = [\"udp/6001\", \"tcp/9090\"]");
    let fleet = Fleet::read(&text).unwrap();
    let peers: Vec<Peer> = fleet.vessels.iter().map(|vessel| peer(vessel, "")).collect();
    let rules = nftables(&fleet, &peers[..2]);
    assert!(rules.contains("ip daddr 10.8.0.1 tcp dport { 8080, 9090 } accept"), "{rules}");
    assert!(rules.contains("ip daddr 10.8.0.1 udp dport { 6001 } accept"), "{rules}");
    assert!(rules.contains("ip saddr != { 10.8.0.11, 10.8.0.12 } drop"), "{rules}");
    let closed = nftables(&fleet, &[]);
    assert!(!closed.contains("accept\n\t\tip") && !closed.contains("dport"), "{closed}");
}
