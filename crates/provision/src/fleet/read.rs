//! From the text of a fleet file to a [`Fleet`], or to everything that is wrong with it.

use super::fields::{Fields, Found, Report, ip_of, is_host, is_plain, line};
use super::rules::{self, Placed};
use super::ways::{Way, ways};
use super::{
    Device, Door, Doors, Fleet, Limits, Network, Problem, Profile, Server, Setting, Vessel, Vpn, VpnKind,
};
use std::net::Ipv4Addr;
use toml::de::DeTable;

/// The largest fleet file that is read, in bytes.
pub const MAX_FILE_BYTES: usize = 1 << 20;
/// Vessels in a file at most.
pub const MAX_VESSELS: usize = 1_000;

const FILE: [&str; 4] = ["server", "vpn", "common", "vessel"];
const SERVER: [&str; 4] = ["public_name", "link_port", "encrypted", "doors"];
const VPN: [&str; 5] = ["kind", "network", "server_address", "port", "keepalive_s"];
const COMMON: [&str; 6] = ["profile", "hull", "devices", "limits", "ways", "settings"];
const VESSEL: [&str; 9] =
    ["name", "imc_address", "vpn_address", "profile", "hull", "devices", "limits", "ways", "settings"];
const LIMITS: [&str; 5] =
    ["top_speed_mps", "navigable_depth_m", "autonomous_depth_m", "draught_m", "lost_link_s"];

/// Addresses of systems on the water; consoles and others come after.
pub(crate) const VESSEL_ADDRESSES: std::ops::RangeInclusive<u16> = 0x0001..=0x3FFF;
/// Characters of a name; it is part of names of files.
const NAME_CHARS: usize = 32;

/// Defaults of all vessels, which each may override.
#[derive(Debug, Clone, Default)]
struct Outfit {
    profile: Option<Profile>,
    hull: Option<String>,
    devices: Vec<(Device, String)>,
    limits: Limits,
    ways: Vec<Way>,
    settings: Vec<Setting>,
}

pub(super) fn fleet(text: &str) -> Result<Fleet, Vec<Problem>> {
    let mut report = Report::new(text);
    if text.len() > MAX_FILE_BYTES {
        report.tell(0, format!("the file has more than {MAX_FILE_BYTES} bytes"), "is it a fleet file?");
        return Err(report.into_problems());
    }
    let (root, errors) = DeTable::parse_recoverable(text);
    for error in errors {
        let at = error.span().map_or(0, |span| span.start);
        report.tell(at, error.message().trim().replace('\n', ", "), "mend the TOML there");
    }
    let root = Found { value: root.get_ref(), at: 0 };
    let file = Fields::new(&mut report, root, "the file".to_owned(), &FILE);
    let server = server(&mut report, &file);
    let vpn = vpn(&mut report, &file);
    let encrypted = server.as_ref().is_some_and(|server| server.encrypted);
    let common = match file.table(&mut report, "common") {
        Some(table) => {
            let common = Fields::new(&mut report, table, "common".to_owned(), &COMMON);
            outfit(&mut report, &common, encrypted)
        }
        None => Outfit::default(),
    };
    let vessels = vessels(&mut report, &file, &common, encrypted);
    let network = vpn.as_ref().map(|(vpn, at)| (vpn, *at));
    rules::check(&mut report, network, &vessels);
    let whole = report.is_clean().then_some(()).and(server).zip(vpn);
    match whole {
        Some((server, (vpn, _))) => {
            Ok(Fleet { server, vpn, vessels: vessels.into_iter().map(|placed| placed.vessel).collect() })
        }
        None => Err(report.into_problems()),
    }
}

fn server(report: &mut Report<'_>, file: &Fields<'_, '_>) -> Option<Server> {
    file.require(report, "server", "…, as a table [server]");
    let table = file.table(report, "server")?;
    let server = Fields::new(report, table, "server".to_owned(), &SERVER);
    server.require(report, "public_name", "\"lutra.example.org\"");
    let public_name = server.text(report, "public_name").and_then(|found| {
        let good = is_host(found.value);
        if !good {
            let text = format!("{:?} is neither a name nor an address", found.value);
            server.wrong(
                report,
                found.at,
                "public_name",
                text,
                "write it without scheme and port, like lutra.example.org",
            );
        }
        good.then(|| found.value.to_owned())
    });
    let link_port = server.whole(report, "link_port", 1..=u16::MAX).map_or(8080, |found| found.value);
    let encrypted = server.flag(report, "encrypted").is_some_and(|found| found.value);
    let mut doors = Doors::new();
    for Found { value, at } in server.texts(report, "doors") {
        match Door::parse(value) {
            Ok(door) if !doors.insert(door) => {
                server.wrong(report, at, "doors", format!("{door} stands there twice"), "take one out");
            }
            Ok(_) => {}
            Err(remedy) => server.wrong(report, at, "doors", format!("{value:?} is not a door"), remedy),
        }
    }
    Some(Server { public_name: public_name?, link_port, encrypted, doors })
}

/// The VPN, and its byte offset.
fn vpn(report: &mut Report<'_>, file: &Fields<'_, '_>) -> Option<(Vpn, usize)> {
    file.require(report, "vpn", "…, as a table [vpn]");
    let table = file.table(report, "vpn")?;
    let vpn = Fields::new(report, table, "vpn".to_owned(), &VPN);
    vpn.require(report, "network", "\"10.8.0.0/24\"");
    vpn.require(report, "server_address", "\"10.8.0.1\"");
    let kind = vpn.text(report, "kind").and_then(|found| {
        let kind = VpnKind::ALL.into_iter().find(|kind| kind.name() == found.value);
        if kind.is_none() {
            let text = format!("{:?} is not a VPN that Lutra sets up", found.value);
            vpn.wrong(report, found.at, "kind", text, "take \"wireguard\" or \"openvpn\"");
        }
        kind
    });
    let kind = kind.unwrap_or(VpnKind::WireGuard);
    let network = vpn.text(report, "network").and_then(|found| match Network::parse(found.value) {
        Ok(network) => Some(network),
        Err(remedy) => {
            vpn.wrong(report, found.at, "network", format!("{:?} cannot be", found.value), remedy);
            None
        }
    });
    let server = ip(report, &vpn, "server_address");
    let port = vpn.whole(report, "port", 1..=u16::MAX).map_or(kind.port(), |found| found.value);
    let keepalive_s = vpn.whole(report, "keepalive_s", 1..=300_u16).map_or(25, |found| found.value);
    let (network, server) = (network?, server?);
    Some((Vpn { kind, network, server_address: server.value, port, keepalive_s }, server.at))
}

fn vessels(report: &mut Report<'_>, file: &Fields<'_, '_>, common: &Outfit, encrypted: bool) -> Vec<Placed> {
    let tables = file.tables(report, "vessel");
    if tables.is_empty() {
        report.tell(0, "there is no vessel", "write [[vessel]] with name, imc_address and vpn_address");
    }
    if tables.len() > MAX_VESSELS {
        let text = format!("there are more than {MAX_VESSELS} vessels");
        report.tell(tables[MAX_VESSELS].at, text, "take a file for each part of the fleet");
    }
    let mut placed = Vec::new();
    for (at, table) in tables.into_iter().take(MAX_VESSELS).enumerate() {
        placed.extend(vessel(report, table, at + 1, common, encrypted));
    }
    placed
}

fn vessel(
    report: &mut Report<'_>,
    table: Found<&DeTable<'_>>,
    number: usize,
    common: &Outfit,
    encrypted: bool,
) -> Option<Placed> {
    let name = table.value.get("name").and_then(|name| name.get_ref().as_str());
    let place = match name {
        Some(name) if is_name(name) => format!("vessel {name}"),
        _ => format!("vessel {number}"),
    };
    let vessel = Fields::new(report, table, place, &VESSEL);
    vessel.require(report, "name", "\"otter-01\"");
    vessel.require(report, "imc_address", "0x2810");
    vessel.require(report, "vpn_address", "\"10.8.0.11\"");
    let name = vessel.text(report, "name").and_then(|found| {
        let good = is_name(found.value);
        if !good {
            let text = format!("{:?} cannot be a vessel's name", found.value);
            let remedy =
                format!("take 1 to {NAME_CHARS} letters (a to z), digits and . _ -, a letter or digit first");
            vessel.wrong(report, found.at, "name", text, remedy);
        }
        good.then(|| Found { value: found.value.to_owned(), at: found.at })
    });
    let imc_address = vessel.whole(report, "imc_address", 0..=u16::MAX).and_then(|found| {
        let good = VESSEL_ADDRESSES.contains(&found.value);
        if !good {
            let text = format!("0x{:04X} is not a vessel's address", found.value);
            vessel.wrong(
                report,
                found.at,
                "imc_address",
                text,
                "take 0x0001 to 0x3FFF, as 0x2810 for an Otter",
            );
        }
        good.then_some(found)
    });
    let vpn_address = ip(report, &vessel, "vpn_address");
    let own = outfit(report, &vessel, encrypted);
    let (name, imc_address, vpn_address) = (name?, imc_address?, vpn_address?);
    let outfit = own.over(common);
    Some(Placed {
        name_at: name.at,
        imc_at: imc_address.at,
        vpn_at: vpn_address.at,
        vessel: Vessel {
            name: name.value,
            imc_address: imc_address.value,
            vpn_address: vpn_address.value,
            profile: outfit.profile.unwrap_or(Profile::Hardware),
            hull: outfit.hull,
            devices: outfit.devices,
            limits: outfit.limits,
            ways: outfit.ways,
            settings: outfit.settings,
        },
    })
}

fn outfit(report: &mut Report<'_>, fields: &Fields<'_, '_>, encrypted: bool) -> Outfit {
    let profile = fields.text(report, "profile").and_then(|found| {
        let profile = Profile::ALL.into_iter().find(|profile| profile.name() == found.value);
        if profile.is_none() {
            let text = format!("{:?} is not a profile", found.value);
            fields.wrong(report, found.at, "profile", text, "take \"Hardware\" or \"Simulation\"");
        }
        profile
    });
    let hull = line(report, fields, "hull").map(|found| found.value.to_owned());
    Outfit {
        profile,
        hull,
        devices: devices(report, fields),
        limits: limits(report, fields),
        ways: ways(report, fields, encrypted),
        settings: settings(report, fields),
    }
}

fn devices(report: &mut Report<'_>, fields: &Fields<'_, '_>) -> Vec<(Device, String)> {
    let Some(table) = fields.table(report, "devices") else { return Vec::new() };
    let known = Device::ALL.map(Device::name);
    let inner = Fields::new(report, table, format!("{}: devices", fields.place), &known);
    let mut devices: Vec<(Device, Found<&str>)> = Vec::new();
    for device in Device::ALL {
        let Some(found) = line(report, &inner, device.name()) else { continue };
        if let Some((other, _)) = devices.iter().find(|(_, other)| other.value == found.value) {
            let text = format!("{:?} is the {}'s already", found.value, other.name());
            inner.wrong(report, found.at, device.name(), text, "each device has a port of its own");
        }
        devices.push((device, found));
    }
    devices.into_iter().map(|(device, found)| (device, found.value.to_owned())).collect()
}

fn limits(report: &mut Report<'_>, fields: &Fields<'_, '_>) -> Limits {
    let Some(table) = fields.table(report, "limits") else { return Limits::default() };
    let inner = Fields::new(report, table, format!("{}: limits", fields.place), &LIMITS);
    let limits = Limits {
        top_speed_mps: inner.number(report, "top_speed_mps", 0.1..=20.0),
        navigable_depth_m: inner.number(report, "navigable_depth_m", 0.1..=100.0),
        autonomous_depth_m: inner.number(report, "autonomous_depth_m", 0.1..=100.0),
        draught_m: inner.number(report, "draught_m", 0.0..=20.0),
        lost_link_s: inner.number(report, "lost_link_s", 1.0..=86_400.0),
    };
    if let (Some(drive), Some(alone)) = (limits.navigable_depth_m, limits.autonomous_depth_m)
        && drive > alone
    {
        let text = format!("{alone} m is less than navigable_depth_m, {drive} m");
        inner.wrong(
            report,
            table.at,
            "autonomous_depth_m",
            text,
            "a vessel that goes by itself needs as much water or more",
        );
    }
    limits
}

fn settings(report: &mut Report<'_>, fields: &Fields<'_, '_>) -> Vec<Setting> {
    let Some(table) = fields.table(report, "settings") else { return Vec::new() };
    let place = format!("{}: settings", fields.place);
    let names: Vec<&str> = table.value.keys().map(|key| key.get_ref().as_ref()).collect();
    let sections = Fields::new(report, table, place.clone(), &names);
    let mut settings = Vec::new();
    for (section, inner) in sections.inner(report) {
        if ["require ", "include "].iter().any(|word| section.value.to_lowercase().starts_with(word)) {
            let text = "is a directive of .ini files, no section";
            sections.wrong(report, section.at, section.value, text, "take it out");
            continue;
        }
        if inner.value.len() > MOST_SETTINGS || settings.len() > MOST_SETTINGS {
            let text = format!("more than {MOST_SETTINGS} settings");
            sections.wrong(
                report,
                section.at,
                section.value,
                text,
                "put them into a configuration of your own aboard",
            );
            return settings;
        }
        let keys: Vec<&str> = inner.value.keys().map(|key| key.get_ref().as_ref()).collect();
        let inner = Fields::new(report, inner, format!("{place}: {}", section.value), &keys);
        for (key, value) in inner.values(report) {
            if [section.value, key.value, &value].into_iter().all(is_plain) && !key.value.contains('=') {
                let (section, key) = (section.value.to_owned(), key.value.to_owned());
                settings.push(Setting { section, key, value });
            } else {
                inner.wrong(
                    report,
                    key.at,
                    key.value,
                    "cannot stand in an .ini file",
                    "take out [ ] # ; and line ends",
                );
            }
        }
    }
    settings
}

/// Settings of one table; every vessel has those of all.
const MOST_SETTINGS: usize = 500;

fn ip(report: &mut Report<'_>, fields: &Fields<'_, '_>, key: &str) -> Option<Found<Ipv4Addr>> {
    ip_of(report, fields, key, "an IPv4 address", "10.8.0.11")
}

/// Whether it can be a vessel's name: part of names of files, and of lines of configurations.
pub(crate) fn is_name(text: &str) -> bool {
    let good = |letter: char| letter.is_ascii_alphanumeric() || "._-".contains(letter);
    (1..=NAME_CHARS).contains(&text.len())
        && text.chars().all(good)
        && text.starts_with(|first: char| first.is_ascii_alphanumeric())
}

impl Outfit {
    /// This, and of `common` what it leaves open.
    fn over(self, common: &Self) -> Self {
        let mut devices = self.devices;
        for (device, port) in &common.devices {
            if !devices.iter().any(|(own, _)| own == device) {
                devices.push((*device, port.clone()));
            }
        }
        let own = |wanted: &Setting| {
            self.settings.iter().any(|one| (&one.section, &one.key) == (&wanted.section, &wanted.key))
        };
        let mut settings: Vec<Setting> = common.settings.iter().filter(|one| !own(one)).cloned().collect();
        settings.extend(self.settings.iter().cloned());
        let (own, theirs) = (self.limits, common.limits);
        Self {
            profile: self.profile.or(common.profile),
            hull: self.hull.or_else(|| common.hull.clone()),
            devices,
            limits: Limits {
                top_speed_mps: own.top_speed_mps.or(theirs.top_speed_mps),
                navigable_depth_m: own.navigable_depth_m.or(theirs.navigable_depth_m),
                autonomous_depth_m: own.autonomous_depth_m.or(theirs.autonomous_depth_m),
                draught_m: own.draught_m.or(theirs.draught_m),
                lost_link_s: own.lost_link_s.or(theirs.lost_link_s),
            },
            // A vessel's own are all that it has: each computer has its own interfaces.
            ways: if self.ways.is_empty() { common.ways.clone() } else { self.ways },
            settings,
        }
    }
}
