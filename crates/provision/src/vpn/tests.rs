//! Keys and files of the VPN. Whether `wg`, `openvpn` and `nft` take the files is tested where the server writes them.

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
fn who_has_a_place_is_read_from_the_servers_side_and_one_is_taken_out_of_it() {
    let fleet = Fleet::read(EXAMPLE).unwrap();
    let key = VpnKey::from_random([1; 32]);
    let all: Vec<_> = fleet.vessels.iter().map(|vessel| peer(vessel, &key.public())).collect();
    let text = wireguard::ashore(&fleet, &key, &all);
    assert_eq!(wireguard::peers(&text), all);
    assert_eq!(
        wireguard::without(&text, "ntnu-otter-02"),
        wireguard::ashore(&fleet, &key, &[&all[..1], &all[2..]].concat())
    );
    assert_eq!(wireguard::without(&text, "ntnu-otter"), text, "a name that begins others");
    assert_eq!(
        wireguard::without(&wireguard::ashore(&fleet, &key, &all[..1]), &all[0].name),
        wireguard::ashore(&fleet, &key, &[])
    );
    assert_eq!(wireguard::peers(&text.replace("AllowedIPs = 10.8.0.12/32", "AllowedIPs = half")).len(), 3);
    assert!(wireguard::peers(&text[..text.len() / 3]).len() < 4 && wireguard::peers("").is_empty());
    let place = openvpn::place(fleet.vpn.network, all[0].address);
    assert_eq!(openvpn::placed(&place), Some(all[0].address));
    assert_eq!(["", "half", "ifconfig-push", "ifconfig-push 10.8"].map(openvpn::placed), [None; 4]);
}

#[test]
fn the_firewall_opens_the_doors_and_nothing_else() {
    let text = EXAMPLE.replace("doors = []", "doors = [\"udp/6001\", \"tcp/9090\"]");
    let fleet = Fleet::read(&text).unwrap();
    let vessels: Vec<_> = fleet.vessels.iter().map(|vessel| vessel.vpn_address).collect();
    let rules = nftables(&fleet, &vessels[..2]);
    assert!(rules.contains("ip daddr 10.8.0.1 tcp dport { 8080, 9090 } accept"), "{rules}");
    assert!(rules.contains("ip daddr 10.8.0.1 udp dport { 6001 } accept"), "{rules}");
    assert!(rules.contains("ip saddr != { 10.8.0.11, 10.8.0.12 } drop"), "{rules}");
    let closed = nftables(&fleet, &[]);
    assert!(!closed.contains("accept\n\t\tip") && !closed.contains("dport"), "{closed}");
}

fn pem(label: &str, body: &str) -> String {
    format!("-----BEGIN {label}-----\n{body}\n-----END {label}-----\n")
}

fn identity(body: &str) -> openvpn::Identity {
    openvpn::Identity {
        certificate: pem("CERTIFICATE", body),
        key: pem("PRIVATE KEY", &format!("{body}+secret")),
    }
}

fn shore() -> openvpn::Shore {
    openvpn::Shore {
        authority: identity("authority"),
        server: identity("server"),
        shield: openvpn::static_key(&[0xAB; 256]),
    }
}

#[test]
fn openvpn_gives_each_side_its_own_secrets_and_not_those_of_the_authority() {
    let text = EXAMPLE.replace("\"wireguard\"", "\"openvpn\"").replace("port = 51820", "");
    let fleet = Fleet::read(&text).unwrap();
    let (shore, vessel) = (shore(), &fleet.vessels[0]);
    let own = openvpn::Aboard { identity: identity("boat"), authority: shore.authority.certificate.clone() };
    let ashore = openvpn::ashore(&fleet, &shore);
    let aboard = openvpn::aboard(&fleet, vessel, &own, &shore.shield);
    for line in [
        "port 1194",
        "ifconfig 10.8.0.1 255.255.255.0",
        "keepalive 25 75",
        "ccd-exclusive",
        "tls-version-min 1.2",
        "server+secret",
    ] {
        assert!(ashore.lines().any(|one| one == line), "{line} in {ashore}");
    }
    for line in ["remote lutra.example.org 1194", "verify-x509-name lutra-server name", "boat+secret"] {
        assert!(aboard.lines().any(|one| one == line), "{line} in {aboard}");
    }
    assert!(!format!("{ashore}{aboard}").contains("authority+secret") && !aboard.contains("server+secret"));
    let place = openvpn::place(fleet.vpn.network, vessel.vpn_address);
    assert_eq!(place, "ifconfig-push 10.8.0.11 255.255.255.0\n");
}

#[test]
fn openvpn_secrets_are_read_as_they_were_written_and_do_not_show_themselves() {
    let shore = shore();
    assert_eq!(openvpn::Shore::parse(&shore.written()), Some(shore.clone()));
    let aboard = openvpn::Aboard { identity: identity("boat"), authority: pem("CERTIFICATE", "authority") };
    assert_eq!(openvpn::Aboard::parse(&format!("10.8.0.11\n{}", aboard.written())), Some(aboard.clone()));
    let shown = format!("{shore:?} {aboard:?} {:?}", shore.server);
    assert!(!shown.contains("secret") && !shown.contains("abab"), "{shown}");
    let (shore, aboard) = (shore.written(), aboard.written());
    for text in ["", "words", &shore[..shore.len() - 9], &aboard, &shore.replace("PRIVATE", "PUBLIC")] {
        assert!(openvpn::Shore::parse(text).is_none(), "{text}");
    }
    for text in ["", &aboard[..aboard.len() / 2], &shore] {
        assert!(openvpn::Aboard::parse(text).is_none(), "{text}");
    }
    // As `openvpn --genkey secret` writes it: 16 lines of 32 digits.
    let key = openvpn::static_key(&[7; 256]);
    let digits: Vec<_> = key.lines().filter(|line| !line.starts_with("-----")).collect();
    assert!(digits.len() == 16 && digits.iter().all(|line| *line == "07".repeat(16)), "{key}");
}
