//! A vessel's agent settings from the fleet file: an .ini file that requires the packaged one and states the differences.

use crate::fleet::{Device, Fleet, Limits, VESSEL_ADDRESSES, Vessel, Way};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The packaged configuration, beside which the overlay lies.
pub const BASE_FILE: &str = "agent.ini";

/// The vessel that it is for, as `config::Vessel::default()` says.
const PACKAGED: (&str, u16) = ("ntnu-otter-01", 0x2810);

/// Sections, each with its parameters in order; a later value of a parameter is the one that holds.
type Sections = BTreeMap<String, Vec<(String, String)>>;

/// The overlay of `vessel`. `token` and `authority` name the files that lie beside it, `authority` only where the link is
/// encrypted.
pub fn overlay(fleet: &Fleet, vessel: &Vessel, token: &str, authority: Option<&str>) -> String {
    let mut sections = Sections::new();
    let mut set = |section: &str, key: &str, value: &str| put(&mut sections, section, key, value);
    set("General", "Vehicle", &vessel.name);
    if let Some(hull) = &vessel.hull {
        set("General", "Vehicle Type", hull);
    }
    for (name, address) in addresses(fleet, vessel) {
        set("IMC Addresses", &name, &format!("0x{address:04X}"));
    }
    set("Transports.Lutra", "Enabled", "Always");
    set("Transports.Lutra", "URL", &fleet.link_url());
    set("Transports.Lutra", "Token File", token);
    if let Some(authority) = authority {
        set("Transports.Lutra", "Certificate Authority", authority);
    }
    for (device, port) in &vessel.devices {
        let (section, key) = device_parameter(*device);
        set(section, key, port);
    }
    for (section, key, value) in limit_parameters(&vessel.limits) {
        if let Some(value) = value {
            set(section, key, &value.to_string());
        }
    }
    for (number, way) in (1..).zip(&vessel.ways) {
        for (key, value) in way_parameters(way) {
            set(&format!("Transports.LutraWay/{number}"), key, &value);
        }
    }
    for setting in &vessel.settings {
        set(&setting.section, &setting.key, &setting.value);
    }
    written(&vessel.name, sections)
}

/// The addresses of the whole fleet. The packaged file gives one to an Otter of its own, which must not be this vessel's: where
/// no vessel is called so, that name gets an address that no vessel has.
fn addresses(fleet: &Fleet, vessel: &Vessel) -> Vec<(String, u16)> {
    let (name, address) = PACKAGED;
    let mut all: Vec<(String, u16)> =
        fleet.vessels.iter().map(|one| (one.name.clone(), one.imc_address)).collect();
    if vessel.imc_address == address && all.iter().all(|(known, _)| known != name) {
        let free = VESSEL_ADDRESSES.rev().find(|free| all.iter().all(|(_, taken)| taken != free));
        all.extend(free.map(|free| (name.to_owned(), free)));
    }
    all
}

/// Where a device's port is configured.
const fn device_parameter(device: Device) -> (&'static str, &'static str) {
    match device {
        Device::Compass => ("Sensors.GPS", "Serial Port - Device"),
        Device::Hydrophone => ("Sensors.ThelmaHydrophone", "Serial Port - Device"),
        Device::Motors => ("Actuators.Torqeedo", "CAN Port - Device"),
    }
}

const fn limit_parameters(limits: &Limits) -> [(&'static str, &'static str, Option<f64>); 5] {
    [
        ("Supervisors.OperationalLimits", "Maximum Speed", limits.top_speed_mps),
        ("Supervisors.Grounding", "Navigable Depth", limits.navigable_depth_m),
        ("Supervisors.Grounding", "Autonomous Depth", limits.autonomous_depth_m),
        ("Supervisors.Grounding", "Draught", limits.draught_m),
        ("Supervisors.ASV.LostComms", "Lost Comms Timeout", limits.lost_link_s),
    ]
}

/// The section of a way; values left open are the agent's own.
fn way_parameters(way: &Way) -> impl Iterator<Item = (&'static str, String)> {
    let all = [
        ("Enabled", Some("Always".to_owned())),
        ("Entity Label", Some(way.name.clone())),
        ("URL", way.url.clone()),
        ("Interface", way.interface.clone()),
        ("Source Address", way.source_address.map(|address| address.to_string())),
        ("Metered", Some(way.metered.to_string())),
        ("Daily Budget", way.daily_budget_mib.map(|budget| budget.to_string())),
    ];
    all.into_iter().filter_map(|(key, value)| value.map(|value| (key, value)))
}

fn put(sections: &mut Sections, section: &str, key: &str, value: &str) {
    let parameters = sections.entry(section.to_owned()).or_default();
    parameters.retain(|(known, _)| known != key);
    parameters.push((key.to_owned(), value.to_owned()));
}

fn written(name: &str, sections: Sections) -> String {
    let mut text = format!(
        "# What {name} has of its own, from the fleet file ashore by `lutra-agent provision`.\n\
         # Change it ashore: what is changed here is lost when the next bundle comes.\n[Require {BASE_FILE}]\n"
    );
    for (section, parameters) in sections {
        write!(text, "\n[{section}]\n").ok();
        for (key, value) in parameters {
            writeln!(text, "{key} = {value}").ok();
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    const EXAMPLE: &str = include_str!("../../../deploy/fleet.example.toml");

    #[test]
    fn a_vessel_gets_what_is_its_own_and_the_addresses_of_all() {
        let fleet = Fleet::read(EXAMPLE).unwrap();
        let text = overlay(&fleet, &fleet.vessels[3], "lutra.token", Some("ca.pem"));
        for line in [
            "[Require agent.ini]",
            "Vehicle = ntnu-otter-04",
            "ntnu-otter-01 = 0x2810",
            "ntnu-otter-04 = 0x2813",
            "URL = ws://10.8.0.1:8080/link",
            "Certificate Authority = ca.pem",
            "CAN Port - Device = can0",
            "Maximum Speed = 1.5",
            "Air Draught = 1.5",
        ] {
            assert_eq!(text.lines().filter(|one| *one == line).count(), 1, "{line} in {text}");
        }
    }

    #[test]
    fn ways_are_sections_of_their_own_in_the_files_order() {
        let ways = "[[vessel.ways]]\nname = \"5 GHz radio\"\ninterface = \"wlan5\"\n[[vessel.ways]]\nname = \"4G\"\n\
                    url = \"ws://192.0.2.1:8080/link\"\nsource_address = \"192.0.2.7\"\nmetered = true\ndaily_budget_mib = 50\n";
        let fleet = Fleet::read(&format!("{EXAMPLE}\n{ways}")).unwrap();
        let text = overlay(&fleet, &fleet.vessels[3], "lutra.token", None);
        let radio = "[Transports.LutraWay/1]\nEnabled = Always\nEntity Label = 5 GHz radio\nInterface = wlan5\nMetered = false\n";
        let mobile = "[Transports.LutraWay/2]\nEnabled = Always\nEntity Label = 4G\nURL = ws://192.0.2.1:8080/link\n\
                      Source Address = 192.0.2.7\nMetered = true\nDaily Budget = 50\n";
        assert!(text.contains(radio) && text.contains(mobile), "{text}");
        assert!(!overlay(&fleet, &fleet.vessels[0], "lutra.token", None).contains("LutraWay"));
    }

    #[test]
    fn the_packaged_vessel_does_not_keep_another_ones_address() {
        let fleet = Fleet::read(&EXAMPLE.replace("ntnu-otter", "skerry")).unwrap();
        let text = overlay(&fleet, &fleet.vessels[0], "lutra.token", None);
        assert!(text.contains("skerry-01 = 0x2810") && text.contains("ntnu-otter-01 = 0x3FFF"), "{text}");
        assert!(!overlay(&fleet, &fleet.vessels[1], "lutra.token", None).contains("ntnu-otter-01"));
    }
}
