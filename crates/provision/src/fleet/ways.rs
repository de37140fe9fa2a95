//! The ways by which a vessel reaches the shore, such as 4G and a radio: the agent's `[Transports.LutraWay/…]`.

use super::fields::{Fields, Found, Report, ip_of, is_host, line};
use std::net::{IpAddr, Ipv6Addr};
use toml::de::DeTable;

/// The agent's limits (`link::MOST_WAYS`, `link::MOST_WAY_NAME_BYTES`, and IFNAMSIZ of Linux without its end).
const MOST: usize = 8;
const NAME_BYTES: usize = 32;
const INTERFACE_BYTES: usize = 15;
/// The most that the agent's `Daily Budget` takes (MiB).
const MOST_BUDGET_MIB: u32 = 1 << 20;

const WAY: [&str; 6] = ["name", "url", "interface", "source_address", "metered", "daily_budget_mib"];

/// Labels of other tasks of the packaged configuration (`vehicle-agent/etc/otter.ini`): a vessel's labels are unique.
const LABELS: [&str; 40] = [
    "Announce",
    "Clock",
    "Course & Speed Controller",
    "Direction & Speed Controller",
    "Entity Monitor",
    "Follow Reference Maneuver",
    "Follow System Maneuver",
    "Follow Trajectory Maneuver",
    "Fuel Level",
    "GPS",
    "Grounding Supervisor",
    "Host Resources",
    "Log Book",
    "Logger",
    "LostComms Supervisor",
    "Lutra Link",
    "Mainboard (Core)",
    "Motor 0",
    "Motor 1",
    "Multiplexer Maneuver",
    "Navigation",
    "Operational Limits",
    "Path Control",
    "Plan Database",
    "Plan Engine",
    "Receiver",
    "Remote Control",
    "Rows Coverage Maneuver",
    "Signal Light",
    "Simulation Engine",
    "SoundSpeedCalculator",
    "Stream Velocity Simulator",
    "TBLive",
    "TCP Server",
    "Tagged Fish",
    "Teleoperation Maneuver",
    "Torqeedo",
    "UDP",
    "Vehicle Supervisor",
    "Watchdog",
];

/// One way to the shore.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Way {
    /// For people and figures.
    pub name: String,
    /// Where the link is by this way; `None` for where it is in the VPN.
    pub url: Option<String>,
    /// The network interface that it goes by; `None` for the computer's routes.
    pub interface: Option<String>,
    /// The address of the vessel's computer that it goes from; `None` for the computer's choice.
    pub source_address: Option<IpAddr>,
    /// Its bytes cost.
    pub metered: bool,
    /// Its budget for a day (MiB); `None` for no bound.
    pub daily_budget_mib: Option<u32>,
}

/// The ways of a table, in the file's order. With `encrypted` the vessels have the authority that `wss` needs.
pub(super) fn ways(report: &mut Report<'_>, fields: &Fields<'_, '_>, encrypted: bool) -> Vec<Way> {
    let tables = fields.tables(report, "ways");
    if let Some(beyond) = tables.get(MOST) {
        let text = format!("more than {MOST} ways");
        fields.wrong(report, beyond.at, "ways", text, "take out those that matter least");
    }
    let mut ways: Vec<Way> = Vec::new();
    for (place, table) in tables.into_iter().take(MOST).enumerate() {
        let at = table.at;
        let Some(way) = way(report, table, format!("{}: way {}", fields.place, place + 1), encrypted) else {
            continue;
        };
        if ways.iter().any(|other| other.name == way.name) {
            let text = format!("two are called {:?}", way.name);
            fields.wrong(report, at, "ways", text, "give each a name of its own");
        }
        ways.push(way);
    }
    ways
}

fn way(report: &mut Report<'_>, table: Found<&DeTable<'_>>, place: String, encrypted: bool) -> Option<Way> {
    let way = Fields::new(report, table, place, &WAY);
    way.require(report, "name", "\"4G\"");
    let name = name(report, &way);
    let interface = line(report, &way, "interface");
    let fits = |name: &str| name.len() <= INTERFACE_BYTES && !name.contains(['/', ' ']);
    if let Some(found) = interface.filter(|found| !fits(found.value)) {
        let text = format!("{:?} cannot be a network interface", found.value);
        let remedy =
            format!("take a name of at most {INTERFACE_BYTES} letters, as `ip link` shows it aboard");
        way.wrong(report, found.at, "interface", text, remedy);
    }
    let source_address = ip_of(report, &way, "source_address", "an IP address", "192.0.2.7");
    let metered = way.flag(report, "metered").is_some_and(|found| found.value);
    let budget = way.whole(report, "daily_budget_mib", 1..=MOST_BUDGET_MIB);
    if let Some(found) = budget.filter(|_| !metered) {
        let text = "only a way that is metered has one";
        way.wrong(report, found.at, "daily_budget_mib", text, "write metered = true, or take it out");
    }
    let url = url(report, &way, encrypted);
    Some(Way {
        name: name?,
        url,
        interface: interface.map(|found| found.value.to_owned()),
        source_address: source_address.map(|found| found.value),
        metered,
        daily_budget_mib: budget.map(|found| found.value),
    })
}

/// The name, as the agent reads it: without spaces around it.
fn name(report: &mut Report<'_>, way: &Fields<'_, '_>) -> Option<String> {
    let found = line(report, way, "name")?;
    let name = found.value.trim();
    if name.len() > NAME_BYTES {
        way.wrong(report, found.at, "name", "too long", format!("take at most {NAME_BYTES} bytes"));
    }
    if LABELS.contains(&name) {
        let text = format!("another task aboard is called {name:?}");
        way.wrong(report, found.at, "name", text, "give the way a name of its own, such as \"4G\"");
    }
    Some(name.to_owned())
}

fn url(report: &mut Report<'_>, way: &Fields<'_, '_>, encrypted: bool) -> Option<String> {
    let found = line(report, way, "url")?;
    let url = found.value.trim();
    let (secure, plain) = (url.strip_prefix("wss://"), url.strip_prefix("ws://"));
    if !secure.or(plain).is_some_and(is_place) {
        let text = format!("{url:?} is not an address of the vessel link");
        let remedy = "write one with host, port where it is another than the usual one, and path, like \
                      wss://lutra.example.org/link";
        way.wrong(report, found.at, "url", text, remedy);
    } else if secure.is_some() && !encrypted {
        let text =
            "wss needs the certificate that vessels trust, and the link of this fleet has no certificate";
        way.wrong(report, found.at, "url", text, "set encrypted = true below [server], or write ws://");
    }
    Some(url.to_owned())
}

/// Whether it is a host, a port if need be, and a path.
fn is_place(text: &str) -> bool {
    let Some((authority, path)) = text.split_once('/') else { return false };
    let (host, port) = match authority.rsplit_once(':') {
        // A colon within brackets is of an address of IPv6.
        Some((host, port)) if !port.ends_with(']') => (host, Some(port)),
        _ => (authority, None),
    };
    let address = host.strip_prefix('[').and_then(|host| host.strip_suffix(']'));
    let good_host = address
        .map_or_else(|| !host.contains(':') && is_host(host), |address| address.parse::<Ipv6Addr>().is_ok());
    let is_port = |port: &str| {
        port.bytes().all(|byte| byte.is_ascii_digit()) && port.parse::<u16>().is_ok_and(|port| port > 0)
    };
    let good_path = !path.is_empty() && path.bytes().all(|byte| byte.is_ascii_graphic());
    good_host && port.is_none_or(is_port) && good_path
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::BTreeSet;

    const AGENT: &str = include_str!("../../../../vehicle-agent/etc/otter.ini");

    #[test]
    fn names_of_other_tasks_are_those_of_the_packaged_configuration() {
        let labels: BTreeSet<_> =
            AGENT.lines().filter_map(|line| line.strip_prefix("Entity Label = ")).map(str::trim).collect();
        // That of ways themselves.
        let others: Vec<_> = labels.into_iter().filter(|label| *label != "Way").collect();
        assert_eq!(others, LABELS);
    }

    #[test]
    fn an_address_has_a_host_a_port_and_a_path_that_can_be() {
        for good in
            ["lutra.example.org/link", "192.0.2.1:8080/link", "[2001:db8::1]/link", "[2001:db8::1]:1/a/b?c"]
        {
            assert!(is_place(good), "{good}");
        }
        for bad in [
            "",
            "/link",
            ":8080/link",
            "host",
            "host/",
            "host:8080",
            "host:/link",
            "host:0/link",
            "host:+80/link",
            "host:65536/link",
            "host:web/link",
            "a host/link",
            "user@host/link",
            "2001:db8::1/link",
            "[192.0.2.1]/link",
            "host/a link",
        ] {
            assert!(!is_place(bad), "{bad}");
        }
    }
}
