//! Values that vessels of a fleet must not share, and where their addresses must be.

use super::fields::Report;
use super::{Vessel, Vpn};
use std::collections::BTreeMap;

/// A vessel and the byte offsets of its names and addresses in the file.
#[derive(Debug)]
pub(super) struct Placed {
    pub(super) vessel: Vessel,
    pub(super) name_at: usize,
    pub(super) imc_at: usize,
    pub(super) vpn_at: usize,
}

/// Reports duplicates, and addresses outside the VPN; `vpn` comes with the byte offset of the server's address.
pub(super) fn check(report: &mut Report<'_>, vpn: Option<(&Vpn, usize)>, vessels: &[Placed]) {
    let mut names = BTreeMap::new();
    let mut imc = BTreeMap::new();
    let mut addresses = BTreeMap::new();
    if let Some((vpn, at)) = vpn {
        addresses.insert(vpn.server_address, "the server");
        if !vpn.network.has_host(vpn.server_address) {
            let text = format!("vpn: server_address: {} is not in {}", vpn.server_address, vpn.network);
            report.tell(at, text, "take an address between its first and last");
        }
    }
    for Placed { vessel, name_at, imc_at, vpn_at } in vessels {
        let name = vessel.name.as_str();
        if let Some(other) = names.insert(name.to_ascii_lowercase(), name) {
            report.tell(
                *name_at,
                format!("vessel {name}: another vessel is called {other}"),
                "give each a name of its own",
            );
        }
        if let Some(other) = imc.insert(vessel.imc_address, name) {
            let text = format!("vessel {name}: imc_address: 0x{:04X} is {other}'s", vessel.imc_address);
            report.tell(*imc_at, text, "give each vessel an address of its own");
        }
        if let Some(other) = addresses.insert(vessel.vpn_address, name) {
            let text = format!("vessel {name}: vpn_address: {} is {other}'s", vessel.vpn_address);
            report.tell(*vpn_at, text, "give each an address of its own");
        }
        if let Some((vpn, _)) = vpn.filter(|(vpn, _)| !vpn.network.has_host(vessel.vpn_address)) {
            let text =
                format!("vessel {name}: vpn_address: {} is not in {}", vessel.vpn_address, vpn.network);
            report.tell(*vpn_at, text, "take an address between its first and last");
        }
    }
}
