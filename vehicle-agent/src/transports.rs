//! From the configuration's transports to what is opened: a task that is not enabled is not there.

use crate::disk::{Journal, Room};
use crate::net::{AnnouncePorts, Ports};
use config::schema::transport::{MESSAGES, RATES, announce, logging, tcp, udp};
use config::{Config, Section};
use onboard::{Entity, Settings};
use std::net::Ipv4Addr;
use std::path::Path;
use std::time::Duration;

const ANNOUNCE: u16 = 151;

/// Ports that the command line gives in place of the configured ones.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Given {
    pub(crate) bind: Ipv4Addr,
    pub(crate) udp: Option<u16>,
    pub(crate) tcp: Option<u16>,
    pub(crate) announce: Option<u16>,
}

/// Where to listen and announce, and what of the command line has no effect.
pub(crate) fn ports(config: &Config, given: Given) -> (Ports, Vec<String>) {
    let mut doubts = Vec::new();
    let mut pick = |option: &str, given: Option<u16>, configured: Option<u16>| {
        if given.is_some() && configured.is_none() {
            doubts.push(format!("{option} has no effect: the configuration has that transport off"));
        }
        configured.map(|configured| given.unwrap_or(configured))
    };
    let udp = config.running(&udp::UDP).next().map(|section| port(section.get(&udp::PORT)));
    let tcp = config.running(&tcp::SERVER).next().map(|section| port(section.get(&tcp::PORT)));
    let announce = config.running(&announce::ANNOUNCE).next();
    let ports = Ports {
        bind: given.bind,
        udp: pick("--udp-port", given.udp, udp),
        tcp: pick("--tcp-port", given.tcp, tcp),
        announce: announce.map(|section| announce_ports(section, given)),
    };
    pick("--announce-port", given.announce, announce.map(|_| 0));
    (ports, doubts)
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

/// What the brain has to know of the transports besides UDP's lists.
pub(crate) fn adopt(config: &Config, settings: &mut Settings, doubts: &mut Vec<String>) {
    let mut servers = config.running(&tcp::SERVER);
    if let Some(section) = servers.next() {
        let streams = &mut settings.node.tcp;
        for (name, rate) in section.get(&RATES) {
            match imc::catalogue::by_abbrev(&name) {
                Some(message) => {
                    streams.most_per_s.insert(message.id, rate);
                }
                None => doubts.push(format!("[{}] Rate Limiters: no message `{name}`", section.name())),
            }
        }
        let listed = section.get(&MESSAGES);
        if !listed.is_empty() {
            let carried =
                |id: u16| imc::catalogue::by_id(id).is_some_and(|m| listed.iter().any(|l| l == m.abbrev));
            streams.left_out = (0..u16::MAX).filter(|id| !carried(*id)).collect();
        }
    }
    doubts.extend(servers.map(|more| format!("[{}] a second TCP server is not opened", more.name())));
    if config.running(&announce::ANNOUNCE).next().is_none() {
        settings.node.tcp.left_out.insert(ANNOUNCE);
    }
    if config.running(&udp::UDP).next().is_none() {
        settings.node.static_destinations.clear();
    }
}

/// The log, where the configuration has it on.
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
        assert_eq!((ports.udp, ports.tcp), (Some(6002), Some(7001)));
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
        let none = Ports { bind: Ipv4Addr::UNSPECIFIED, udp: None, tcp: None, announce: None };
        assert_eq!(ports, none);
        assert_eq!(doubts.len(), 1, "{doubts:?}");
        let (settings, _) = setup::settings(&config, 1).unwrap();
        assert!(settings.node.tcp.left_out.contains(&ANNOUNCE));
        assert!(journal(&config, Path::new("logs"), &settings, "").is_none());
    }

    #[test]
    fn streams_have_a_list_and_rates_of_their_own() {
        let more = "[Transports.TCP.Server]\nTransports = Heartbeat, EstimatedState\n\
                    Rate Limiters = EstimatedState:4\n[Transports.TCP.Server/Two]\nEnabled = Always\n\
                    Entity Label = TCP Two\nPort = 9801\n[Transports.Announce]\nEnable Broadcast = false\n";
        let config = config(more);
        let (settings, doubts) = setup::settings(&config, 1).unwrap();
        let streams = &settings.node.tcp;
        assert_eq!(streams.most_per_s.get(&350), Some(&4.0));
        let carried: Vec<u16> = (0..1000).filter(|id| !streams.left_out.contains(id)).collect();
        assert_eq!(carried, [150, 350]);
        assert!(doubts.iter().any(|doubt| doubt.contains("TCP.Server/Two")), "{doubts:?}");
        let announce = ports(&config, GIVEN).0.announce.unwrap();
        assert!(!announce.hosts.contains(&Ipv4Addr::BROADCAST));
    }
}
