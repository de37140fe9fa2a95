//! Checks what the boat lacks besides the files of the bundle.

use super::place::CHART;
use crate::doctor::Finding;
use provision::{Bundle, Part, Port};
use std::path::Path;

/// Programs that set a computer's clock.
const CLOCK_KEEPERS: [&str; 4] = [
    "usr/sbin/chronyd",
    "usr/lib/systemd/systemd-timesyncd",
    "lib/systemd/systemd-timesyncd",
    "usr/sbin/ntpd",
];

pub(super) fn look(bundle: &Bundle, root: &Path) -> Vec<Finding> {
    let mut findings = vec![vpn(bundle, root), clock(root), chart(bundle, root)];
    if bundle.manifest.profile == "Hardware" {
        findings.extend(bundle.manifest.devices.iter().map(|port| device(port, root)));
    }
    findings
}

/// Checks that the program of the bundle's VPN is installed.
fn vpn(bundle: &Bundle, root: &Path) -> Finding {
    let (name, program, remedy) = match bundle.file(Part::OpenVpn) {
        Some(_) => ("OpenVPN", "usr/sbin/openvpn", "sudo apt install openvpn"),
        None => ("WireGuard", "usr/bin/wg-quick", "sudo apt install wireguard-tools"),
    };
    if root.join(program).exists() {
        return Finding::ok("VPN", format!("{name} is installed"));
    }
    Finding::warn("VPN", format!("{name} is not installed, so the shore is not reached"), remedy)
}

fn clock(root: &Path) -> Finding {
    if CLOCK_KEEPERS.iter().any(|program| root.join(program).exists()) {
        return Finding::ok("clock", "a program keeps it");
    }
    Finding::warn("clock", "nothing keeps this computer's clock", "sudo apt install chrony")
}

fn chart(bundle: &Bundle, root: &Path) -> Finding {
    match (root.join(CHART).exists(), bundle.file(Part::Chart).is_some()) {
        (true, _) => Finding::ok("chart", "one is aboard; the shore sends a newer one by the link"),
        (false, true) => Finding::ok("chart", "it is in the bundle"),
        (false, false) => {
            Finding::warn("chart", "no chart is aboard", "connect to the shore once before the first plan")
        }
    }
}

/// Checks that the device's port exists; a device that is off has none.
fn device(Port { device, port }: &Port, root: &Path) -> Finding {
    let path = port.strip_prefix("slcan:").unwrap_or(port);
    let place = match path.strip_prefix('/') {
        Some(_) if path.contains('*') => None,
        Some(below) => Some(root.join(below)),
        // A CAN interface of the system.
        None if !path.contains(':') => Some(root.join("sys/class/net").join(path)),
        None => None,
    };
    let text = |state: &str| format!("{device} at {port}{state}");
    match place {
        None => Finding::ok("device", text(", which cannot be looked for")),
        Some(place) if place.exists() => Finding::ok("device", text("")),
        Some(_) => Finding::warn(
            "device",
            text(" is not there"),
            "plug it in and switch it on; 60-lutra-agent.rules says how ports get names",
        ),
    }
}
