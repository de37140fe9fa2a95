//! The ways by which a vessel reaches the shore, such as 4G and a radio: the agent's `[Transports.LutraWay/…]`.

use super::fields::{Fields, Found, Report, ip_of, line};
use std::net::IpAddr;
use toml::de::DeTable;

/// What the agent takes at most (`link::MOST_WAYS`, `link::MOST_WAY_NAME_BYTES`, and IFNAMSIZ of Linux without its end).
const MOST: usize = 8;
const NAME_BYTES: usize = 32;
const INTERFACE_BYTES: usize = 15;
/// The most that the agent's `Daily Budget` takes (MiB).
const MOST_BUDGET_MIB: u32 = 1 << 20;

const WAY: [&str; 6] = ["name", "url", "interface", "source_address", "metered", "daily_budget_mib"];

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
    /// What it may carry in a day (MiB); `None` for no bound.
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
    let name = line(report, &way, "name");
    if let Some(found) = name.filter(|found| found.value.len() > NAME_BYTES) {
        way.wrong(report, found.at, "name", "too long", format!("take at most {NAME_BYTES} bytes"));
    }
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
        name: name?.value.to_owned(),
        url,
        interface: interface.map(|found| found.value.to_owned()),
        source_address: source_address.map(|found| found.value),
        metered,
        daily_budget_mib: budget.map(|found| found.value),
    })
}

fn url(report: &mut Report<'_>, way: &Fields<'_, '_>, encrypted: bool) -> Option<String> {
    let found = line(report, way, "url")?;
    let is_secure = found.value.starts_with("wss://");
    if !is_secure && !found.value.starts_with("ws://") {
        let text = format!("{:?} is no address of the vessel link", found.value);
        way.wrong(report, found.at, "url", text, "write one like wss://lutra.example.org/link");
    } else if is_secure && !encrypted {
        let text = "wss needs the certificate that vessels trust, and the link of this fleet has none";
        way.wrong(report, found.at, "url", text, "set encrypted = true below [server], or write ws://");
    }
    Some(found.value.to_owned())
}
