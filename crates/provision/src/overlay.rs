//! What a vessel's agent is told of the fleet file: an .ini file that requires the packaged one and says what differs.

use crate::fleet::{Device, Fleet, Limits, Vessel};
use std::collections::BTreeMap;
use std::fmt::Write as _;

/// The packaged configuration, beside which the overlay lies.
pub const BASE_FILE: &str = "agent.ini";

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
    set("IMC Addresses", &vessel.name, &format!("0x{:04X}", vessel.imc_address));
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
    for setting in &vessel.settings {
        set(&setting.section, &setting.key, &setting.value);
    }
    written(&vessel.name, sections)
}

/// Where a device's port is configured.
const fn device_parameter(device: Device) -> (&'static str, &'static str) {
    match device {
        Device::Compass => ("Sensors.GPS", "Serial Port - Device"),
        Device::Hydrophone => ("Sensors.TBR700RT", "Serial Port - Device"),
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
