//! The firewall of the server for what comes by the VPN, as `nft -f` reads it.
//!
//! It is a table of its own and drops only: what other tables refuse stays refused, and what is not from the VPN's interface
//! passes it by.

use super::INTERFACE;
use crate::fleet::{Door, Fleet, Protocol};
use std::fmt::Write as _;
use std::net::Ipv4Addr;

/// Lets the vessels at these addresses reach the server's ports, and neither each other nor any host beyond it.
pub fn nftables(fleet: &Fleet, vessels: &[Ipv4Addr]) -> String {
    let mut text = format!(
        "# Written by `lutra-server fleet apply`: change the fleet file.\n\
         # Vessels reach the doors of this server and nothing else: not each other, not what lies behind it.\n\
         table inet {INTERFACE}\ndelete table inet {INTERFACE}\n\n\
         table inet {INTERFACE} {{\n\
         \tchain input {{\n\t\ttype filter hook input priority filter; policy accept;\n\
         \t\tiifname \"{INTERFACE}\" jump vessels\n\t}}\n\n\
         \tchain vessels {{\n"
    );
    let addresses: Vec<String> = vessels.iter().map(ToString::to_string).collect();
    let server = fleet.vpn.server_address;
    if !addresses.is_empty() {
        writeln!(text, "\t\tip saddr != {{ {} }} drop", addresses.join(", ")).ok();
        text.push_str("\t\tct state established,related accept\n");
        for protocol in [Protocol::Tcp, Protocol::Udp] {
            let ports = ports(fleet, protocol);
            if !ports.is_empty() {
                let name = if protocol == Protocol::Tcp { "tcp" } else { "udp" };
                writeln!(text, "\t\tip daddr {server} {name} dport {{ {ports} }} accept").ok();
            }
        }
        writeln!(text, "\t\tip daddr {server} icmp type echo-request limit rate 10/second accept").ok();
    }
    writeln!(
        text,
        "\t\tdrop\n\t}}\n\n\tchain forward {{\n\t\ttype filter hook forward priority filter; policy accept;\n\
         \t\tiifname \"{INTERFACE}\" drop\n\t\toifname \"{INTERFACE}\" drop\n\t}}\n}}"
    )
    .ok();
    text
}

fn ports(fleet: &Fleet, protocol: Protocol) -> String {
    let mut doors = fleet.server.doors.clone();
    doors.insert(Door { protocol: Protocol::Tcp, port: fleet.server.link_port });
    let ports = doors.iter().filter(|door| door.protocol == protocol).map(|door| door.port.to_string());
    ports.collect::<Vec<_>>().join(", ")
}
