//! Converts the configuration's transports to sockets and settings; tasks that are not enabled are ignored.

use crate::disk::{Journal, Room};
use crate::net::{AnnouncePorts, Listen, Ports};
use config::schema::transport::{ANNOUNCE_SERVICE, FILTERS, MESSAGES, RATES, announce, logging, tcp, udp};
use config::{Config, Section};
use imc::Payload as _;
use imc::messages::Announce;
use onboard::{Entity, Labels, SERVERS, Settings, TransportSettings};
use std::collections::{BTreeMap, BTreeSet};
use std::net::Ipv4Addr;
use std::path::Path;
use std::time::Duration;

/// Ports from the command line, in place of the configured ones.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Given {
    pub(crate) bind: Ipv4Addr,
    pub(crate) udp: Option<u16>,
    pub(crate) tcp: Option<u16>,
    pub(crate) announce: Option<u16>,
}

/// Where to listen and announce, and warnings about options without effect.
pub(crate) fn ports(config: &Config, given: Given) -> (Ports, Vec<String>) {
    let listen = |section: &Section, given: Option<u16>, configured: i64| Listen {
        port: given.unwrap_or(port(configured)),
        announced: section.get(&ANNOUNCE_SERVICE),
    };
    let udp = config.running(&udp::UDP).next();
    let udp = udp.map(|section| listen(section, given.udp, section.get(&udp::PORT)));
    // The option is for the first server; others use it only if the system is to choose.
    let of_server = |number: usize| given.tcp.filter(|port| number == 0 || *port == 0);
    let tcp: Vec<Listen> = servers(config)
        .enumerate()
        .map(|(number, section)| listen(section, of_server(number), section.get(&tcp::PORT)))
        .collect();
    let announce = config.running(&announce::ANNOUNCE).next();
    let announce = announce.map(|section| announce_ports(section, given));
    let in_vain = [
        ("--udp-port", given.udp, udp.is_none()),
        ("--tcp-port", given.tcp, tcp.is_empty()),
        ("--announce-port", given.announce, announce.is_none()),
    ];
    let doubts = in_vain.into_iter().filter(|(_, given, off)| given.is_some() && *off);
    let doubts = doubts
        .map(|(option, ..)| format!("{option} has no effect: the configuration has that transport off"));
    (Ports { bind: given.bind, udp, tcp, announce }, doubts.collect())
}

/// The sections of servers that are opened, in the order of their numbers.
fn servers(config: &Config) -> impl Iterator<Item = &Section> {
    config.running(&tcp::SERVER).take(SERVERS.into())
}

fn announce_ports(section: &Section, given: Given) -> AnnouncePorts {
    let configured = || section.get(&announce::PORTS).into_iter().map(port).collect();
    let group = section.get(&announce::GROUP);
    let everyone = !given.bind.is_loopback();
    let hosts = [
        (section.get(&announce::LOOPBACK), Ipv4Addr::LOCALHOST),
        (everyone && section.get(&announce::MULTICAST), group),
        (everyone && section.get(&announce::BROADCAST), Ipv4Addr::BROADCAST),
    ];
    AnnouncePorts {
        ports: given.announce.map_or_else(configured, |port| vec![port]),
        group,
        hosts: hosts.into_iter().filter(|(wanted, _)| *wanted).map(|(_, host)| host).collect(),
    }
}

fn port(number: i64) -> u16 {
    // The schema keeps ports within 16 bits.
    u16::try_from(number).unwrap_or(0)
}

/// The brain's settings of the transports.
pub(crate) fn adopt(config: &Config, settings: &mut Settings, doubts: &mut Vec<String>) {
    let announces = config.running(&announce::ANNOUNCE).next().is_some();
    settings.node.tcp = servers(config)
        .map(|section| {
            let mut carried = carried(section, &settings.labels, doubts);
            let listed = section.get(&MESSAGES);
            if !listed.is_empty() {
                let is_listed =
                    |id: u16| imc::catalogue::by_id(id).is_some_and(|m| listed.iter().any(|l| l == m.abbrev));
                carried.left_out = (0..u16::MAX).filter(|id| !is_listed(*id)).collect();
            }
            if !announces {
                carried.left_out.insert(Announce::ID);
            }
            carried
        })
        .collect();
    let more = config.running(&tcp::SERVER).skip(SERVERS.into());
    doubts.extend(more.map(|more| format!("[{}] is not opened: there are {SERVERS} before it", more.name())));
    match config.running(&udp::UDP).next() {
        Some(section) => datagrams(section, settings, doubts),
        None => settings.node.static_destinations.clear(),
    }
}

fn datagrams(section: &Section, settings: &mut Settings, doubts: &mut Vec<String>) {
    let TransportSettings { most_per_s, only_of, .. } = carried(section, &settings.labels, doubts);
    let node = &mut settings.node;
    (node.udp.most_per_s, node.udp.only_of) = (most_per_s, only_of);
    // Messages listed in the files are carried; without a list those of DUNE's stock setup are.
    if section.parameter(udp::MESSAGES.spec.name).is_some_and(|given| given.setting().is_some()) {
        let listed = section.get(&udp::MESSAGES);
        let all = imc::catalogue::MESSAGES.iter();
        let left_out = all.filter(|m| m.id == Announce::ID || !listed.iter().any(|l| l == m.abbrev));
        node.udp.left_out = left_out.map(|m| m.id).collect();
    }
    node.dynamic_contacts = section.get(&udp::DYNAMIC_NODES);
    for (host, port) in section.get(&udp::STATIC_DESTINATIONS) {
        match format!("{host}:{port}").parse() {
            Ok(socket) => node.static_destinations.push(socket),
            Err(_) => doubts.push(format!("[{}] `{host}:{port}` is not an address", section.name())),
        }
    }
}

/// A transport's settings of messages besides their list: rates and entities.
fn carried(section: &Section, labels: &Labels, doubts: &mut Vec<String>) -> TransportSettings {
    let message = |key: &str, name: &str, doubts: &mut Vec<String>| {
        let known = imc::catalogue::by_abbrev(name).map(|message| message.id);
        if known.is_none() {
            doubts.push(format!("[{}] {key}: no message `{name}`", section.name()));
        }
        known
    };
    let mut most_per_s = BTreeMap::new();
    for (name, rate) in section.get(&RATES) {
        most_per_s.extend(message(RATES.spec.name, &name, doubts).map(|id| (id, rate)));
    }
    let mut only_of: BTreeMap<u16, BTreeSet<Entity>> = BTreeMap::new();
    for (name, entities) in section.get(&FILTERS) {
        let Some(id) = message(FILTERS.spec.name, &name, doubts) else { continue };
        for label in entities.split('+') {
            match labels.find(label.trim()) {
                Some(entity) => {
                    only_of.entry(id).or_default().insert(entity);
                }
                None => doubts.push(format!(
                    "[{}] {}: there is no part `{label}` aboard that could send {name}",
                    section.name(),
                    FILTERS.spec.name
                )),
            }
        }
    }
    TransportSettings { left_out: BTreeSet::new(), most_per_s, only_of }
}

/// The log, if it is on in the configuration.
pub(crate) fn journal(config: &Config, base: &Path, settings: &Settings, text: &str) -> Option<Journal> {
    let section = config.running(&logging::LOGGING).next()?;
    let room = Room {
        remove_oldest: section.get(&logging::REMOVE_OLDEST),
        keep_free_mib: section.get(&logging::KEEP_FREE).unsigned_abs(),
    };
    let flush = Duration::from_secs_f64(section.get(&logging::FLUSH));
    let compress = section.get(&logging::COMPRESSION) != "none";
    let journal = Journal::new(base, settings.address, Entity::Logger.number(), text.to_owned());
    Some(journal.with_room(room).with_form(flush, compress))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::setup;

    const GIVEN: Given = Given { bind: Ipv4Addr::UNSPECIFIED, udp: None, tcp: None, announce: None };

    fn listen(port: u16) -> Listen {
        Listen { port, announced: true }
    }

    /// The shipped configuration with lines after it.
    fn config(more: &str) -> Config {
        let text = format!("{}\n{more}", crate::OTTER_INI);
        let files = config::InMemory::new().with("otter.ini", text);
        let config = Config::load(&files, "otter.ini".as_ref(), &["Simulation"]);
        assert!(!config.report().has_errors(), "{}", config.report());
        config
    }

    #[test]
    fn the_shipped_configuration_has_all_on() {
        let (ports, doubts) = ports(&config(""), GIVEN);
        assert_eq!((ports.udp, ports.tcp), (Some(listen(6002)), vec![listen(7001)]));
        let announce = ports.announce.unwrap();
        assert_eq!(announce.ports, [30_100, 30_101, 30_102, 30_103, 30_104]);
        let hosts = [Ipv4Addr::LOCALHOST, Ipv4Addr::new(224, 0, 75, 69), Ipv4Addr::BROADCAST];
        assert_eq!(announce.hosts, hosts);
        assert!(doubts.is_empty(), "{doubts:?}");
    }

    #[test]
    fn what_is_never_enabled_is_not_there() {
        let off = "[Transports.UDP]\nEnabled = Never\n[Transports.TCP.Server]\nEnabled = Never\n\
                   [Transports.Announce]\nEnabled = Never\n[Transports.Logging]\nEnabled = Never\n";
        let config = config(off);
        let (ports, doubts) = ports(&config, Given { tcp: Some(0), ..GIVEN });
        let none = Ports { bind: Ipv4Addr::UNSPECIFIED, udp: None, tcp: Vec::new(), announce: None };
        assert_eq!(ports, none);
        assert_eq!(doubts.len(), 1, "{doubts:?}");
        let (settings, _) = setup::settings(&config, 1).unwrap();
        assert!(settings.node.tcp.is_empty());
        assert!(journal(&config, Path::new("logs"), &settings, "").is_none());
    }

    #[test]
    fn each_server_of_streams_has_a_list_and_rates_of_its_own() {
        let more = "[Transports.TCP.Server]\nTransports = Heartbeat, EstimatedState\n\
                    Rate Limiters = EstimatedState:4\n[Transports.TCP.Server/Two]\nEnabled = Always\n\
                    Entity Label = TCP Two\nPort = 9801\nTransports = PlanControl\nAnnounce Service = false\n\
                    [Transports.Announce]\nEnable Broadcast = false\n";
        let config = config(more);
        let (settings, doubts) = setup::settings(&config, 1).unwrap();
        assert_eq!(doubts, Vec::<String>::new());
        let [first, second] = &settings.node.tcp[..] else { panic!("{:?}", settings.node.tcp) };
        assert_eq!(first.most_per_s.get(&350), Some(&4.0));
        let carried = |server: &TransportSettings| {
            (0..1000).filter(|id| !server.left_out.contains(id)).collect::<Vec<u16>>()
        };
        assert_eq!((carried(first), carried(second)), (vec![150, 350], vec![559]));
        let open = |tcp| ports(&config, Given { tcp, ..GIVEN }).0.tcp;
        let hidden = |port| Listen { port, announced: false };
        assert_eq!(open(None), [listen(7001), hidden(9801)]);
        assert_eq!(open(Some(7100)), [listen(7100), hidden(9801)]);
        assert_eq!(open(Some(0)), [listen(0), hidden(0)]);
        let announce = ports(&config, GIVEN).0.announce.unwrap();
        assert!(!announce.hosts.contains(&Ipv4Addr::BROADCAST));
    }

    #[test]
    fn messages_of_some_parts_only_and_no_contacts_but_the_fixed_ones() {
        let more = "[Transports.UDP]\nFiltered Entities = CpuUsage:Daemon+Attic, Oops:Daemon\n\
                    Dynamic Nodes = false\n";
        let (settings, doubts) = setup::settings(&config(more), 1).unwrap();
        assert_eq!(settings.node.udp.only_of, [(7, [Entity::Daemon].into())].into());
        assert!(!settings.node.dynamic_contacts);
        let [attic, oops] = &doubts[..] else { panic!("{doubts:?}") };
        assert!(attic.contains("no part `Attic`") && oops.contains("no message `Oops`"), "{doubts:?}");
    }
}
