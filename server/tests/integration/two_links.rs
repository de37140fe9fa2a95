//! Two real networks between a vessel and its shore: each way of the vessel is bound to one of them, by `Interface` or by `Source
//! Address`, although the routes alone would send everything by the first. One network after the other falls silent.
//!
//! Needs root and `ip`; prints a note where no network namespace can be made.

use crate::support::ashore::{
    all_that_was_logged_is_ashore, archived_bytes, every_number_came_once, newest_s, now_s,
};
use crate::support::program::{Agent, SERVER, Server, agent_program, link_token, until};
use crate::vpn::{Cable, ip, run};
use std::net::SocketAddr;
use std::path::Path;
use store::{Reader, TimeRange};
use tempfile::TempDir;
use testkit::so_many;

/// The shore's address, which lies in neither network.
const SHORE: &str = "203.0.113.1";
/// The networks, without the last number: the shore is 1 in each, the vessel 2.
const NETWORKS: [&str; 2] = ["192.0.2", "198.51.100"];
const NAMES: [&str; 2] = ["radio", "4G"];
/// The table of routes from the second source address.
const TABLE: u8 = 100;

/// Both networks, between the namespaces of a cable.
struct Networks {
    cable: Cable,
}

impl Networks {
    /// The routes of the vessel prefer the first network for everything; the second is there for whatever is bound to it.
    fn lay() -> Option<Self> {
        let cable = Cable::lay("two")?;
        let (shore, vessel) = (cable.shore(), cable.vessel());
        let radio = [cable.end('s'), cable.end('v')];
        let mobile = [cable.end('m'), cable.end('w')];
        for line in [
            format!("link add {} netns {shore} type veth peer name {} netns {vessel}", mobile[0], mobile[1]),
            format!("-n {shore} addr add {}.1/24 dev {}", NETWORKS[1], mobile[0]),
            format!("-n {vessel} addr add {}.2/24 dev {}", NETWORKS[1], mobile[1]),
            format!("-n {shore} link set {} up", mobile[0]),
            format!("-n {vessel} link set {} up", mobile[1]),
            format!("-n {shore} addr add {SHORE}/32 dev lo"),
            format!("-n {vessel} route add {SHORE} via {}.1 dev {} metric 100", NETWORKS[0], radio[1]),
            format!("-n {vessel} route add {SHORE} via {}.1 dev {} metric 200", NETWORKS[1], mobile[1]),
            format!("-n {vessel} route add {SHORE} via {}.1 dev {} table {TABLE}", NETWORKS[1], mobile[1]),
            format!("-n {vessel} rule add from {}.2 lookup {TABLE}", NETWORKS[1]),
        ] {
            ip(&line).unwrap();
        }
        // Answers by the second network are no forgeries, whatever the distribution's default is.
        let loose = "for one in /proc/sys/net/ipv4/conf/*/rp_filter; do echo 2 > $one; done";
        run("ip", &["netns", "exec", &vessel, "sh", "-c", loose]).unwrap();
        Some(Self { cable })
    }

    /// The interface of the vessel in a network.
    fn interface(&self, place: usize) -> String {
        self.cable.end(['v', 'w'][place])
    }

    /// Whether a network carries anything. Its far end is cut, so that the vessel keeps interface, address and routes: nothing tells it.
    fn carries(&self, place: usize, does: bool) {
        let end = self.cable.end(['s', 'm'][place]);
        ip(&format!("-n {} link set {end} {}", self.cable.shore(), if does { "up" } else { "down" }))
            .unwrap();
    }

    /// Bytes that the vessel has sent into a network.
    fn sent(&self, place: usize) -> u64 {
        let path = format!("/sys/class/net/{}/statistics/tx_bytes", self.interface(place));
        run("ip", &["netns", "exec", &self.cable.vessel(), "cat", &path]).unwrap().parse().unwrap()
    }

    /// Whether the server reports a way as up.
    fn is_up(&self, way: &str) -> bool {
        // Figures are for the server's own computer alone.
        let url = "http://127.0.0.1:8080/metrics";
        let figures = run("ip", &["netns", "exec", &self.cable.shore(), "curl", "--silent", url]);
        let way = format!("way=\"{way}\"");
        figures
            .unwrap_or_default()
            .lines()
            .any(|line| line.starts_with("lutra_way_up{") && line.contains(&way) && line.ends_with(" 1"))
    }
}

/// Sails with the two ways bound as `bound` says, and cuts the networks by turns.
async fn sail(program: &Path, networks: &Networks, bound: [String; 2]) {
    let (shore, aboard) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let data = shore.path().join("data");
    let token = link_token(&data, "otter-1", "0x2810");
    let address: SocketAddr = format!("{SHORE}:8080").parse().unwrap();
    let beyond = ["--set", "http.plain_beyond_loopback=true"];
    let mut server =
        Server::start_by(Cable::inside(&networks.cable.shore(), SERVER), &data, "0.0.0.0:8080", &beyond);
    let ways: Vec<String> = (0..2)
        .map(|place| {
            format!(
                "\n[Transports.LutraWay/{place}]\nEnabled = Always\nEntity Label = {}\nURL = ws://{address}/link\n{}\n",
                NAMES[place], bound[place]
            )
        })
        .collect();
    let vessel = Cable::inside(&networks.cable.vessel(), program.to_str().unwrap());
    let mut agent = Agent::start_with(vessel, aboard.path(), address, &token, &ways.concat());
    for name in NAMES {
        until("up by both ways", || networks.is_up(name).then_some(())).await;
    }
    // A log can be read once its first packets are there.
    until("recorded", || (archived_bytes(&data) > 5_000).then_some(())).await;
    for cut in 0..so_many(2, 20) {
        let place = cut % 2;
        let before = networks.sent(1 - place);
        networks.carries(place, false);
        let cut_s = now_s();
        until("ashore by the other network", || (newest_s(&data) > cut_s + 1.0).then_some(())).await;
        until("the dead way is given up", || (!networks.is_up(NAMES[place])).then_some(())).await;
        assert!(networks.sent(1 - place) > before + 1_000, "the other network carried it");
        networks.carries(place, true);
        for name in NAMES {
            until("up again by both", || networks.is_up(name).then_some(())).await;
        }
    }
    let ended_s = now_s();
    until("complete", || (newest_s(&data) > ended_s + 1.0).then_some(())).await;
    agent.process.terminate();
    server.process.terminate();
    every_number_came_once(&data, 0);
    assert_eq!(Reader::open(&data).unwrap().gaps(None, TimeRange::ALL).unwrap(), []);
    let compared = all_that_was_logged_is_ashore(&data, aboard.path(), |said_s| said_s >= ended_s);
    assert!(compared > 100 && archived_bytes(&data) > 0, "{compared}");
}

/// A way that is not bound would follow the routes into the network that is cut: some 12 s each, as the ways must be given up and
/// found again.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn ways_bound_to_interfaces_keep_to_their_networks() {
    let Some(program) = agent_program() else { return };
    let Some(networks) = Networks::lay() else { return };
    let bound = [0, 1].map(|place| format!("Interface = {}", networks.interface(place)));
    sail(&program, &networks, bound).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn ways_bound_to_source_addresses_keep_to_their_networks() {
    let Some(program) = agent_program() else { return };
    let Some(networks) = Networks::lay() else { return };
    let bound = NETWORKS.map(|network| format!("Source Address = {network}.2"));
    sail(&program, &networks, bound).await;
}
