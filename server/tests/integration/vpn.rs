//! A vessel's link through a real tunnel between two network namespaces whose cable is cut for eight seconds, or ten minutes with
//! `LUTRA_LONG`. TCP alone needs some five more seconds to notice that the cable is back; the link does not wait for it. Then the vessel
//! gets another address, as from another mobile network: the tunnel follows.
//!
//! Needs root, `ip`, and OpenVPN or userspace WireGuard (`make test` installs them); prints a note where they are absent.

use crate::support::ashore::{
    all_that_was_logged_is_ashore, archived_bytes, every_number_came_once, newest_s, now_s, time_s,
};
use crate::support::program::{Agent, Process, SERVER, Server, agent_program, link_token, until};
use crate::support::{OTTER, archived_packets};
use imc::PacketView;
use std::net::SocketAddr;
use std::path::Path;
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};
use store::{Reader, TimeRange};
use tempfile::TempDir;
use testkit::{Need, absent, so_many};

/// How long the cable is cut: as long as a boat is behind a skerry, or out of reach of the mobile network.
fn cut_lasts() -> Duration {
    Duration::from_secs(so_many(8, 600))
}

const SHORE_INSIDE: &str = "10.77.0.1";

/// Runs a command; returns its output, or its error text.
pub(crate) fn run(program: &str, arguments: &[&str]) -> Result<String, String> {
    let output = Command::new(program).args(arguments).stdin(Stdio::null()).output();
    let output = output.map_err(|error| format!("{program}: {error}"))?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim().to_owned();
    if output.status.success() {
        Ok(text(&output.stdout))
    } else {
        Err(format!("{program} {}: {}", arguments.join(" "), text(&output.stderr)))
    }
}

/// `ip` with words from one line.
pub(crate) fn ip(line: &str) -> Result<String, String> {
    run("ip", &line.split(' ').collect::<Vec<_>>())
}

pub(crate) fn is_there(program: &str) -> bool {
    run("which", &[program]).is_ok()
}

/// A shore and a vessel in namespaces of their own, with a cable between them; gone when dropped.
pub(crate) struct Cable {
    /// Makes names unique on this computer.
    id: String,
}

impl Cable {
    /// Sets it up; `None`, with a note, where this computer does not permit it.
    pub(crate) fn lay(kind: &str) -> Option<Self> {
        let cable = Self { id: format!("{}{}", kind.chars().next()?, std::process::id()) };
        let (shore, vessel) = (cable.shore(), cable.vessel());
        let first = ip(&format!("netns add {shore}"));
        if let Err(error) = first {
            absent(Need::Netns, &format!("no network namespace can be made: {error}"));
            return None;
        }
        let (s, v) = (cable.end('s'), cable.end('v'));
        for line in [
            format!("netns add {vessel}"),
            format!("link add {s} netns {shore} type veth peer name {v} netns {vessel}"),
            format!("-n {shore} addr add 192.0.2.1/24 dev {s}"),
            format!("-n {vessel} addr add 192.0.2.2/24 dev {v}"),
            format!("-n {shore} link set {s} up"),
            format!("-n {vessel} link set {v} up"),
            format!("-n {shore} link set lo up"),
            format!("-n {vessel} link set lo up"),
        ] {
            ip(&line).unwrap();
        }
        Some(cable)
    }

    pub(crate) fn shore(&self) -> String {
        format!("lutra-{}-shore", self.id)
    }

    pub(crate) fn vessel(&self) -> String {
        format!("lutra-{}-vessel", self.id)
    }

    /// An interface of one end; at most 15 characters.
    pub(crate) fn end(&self, side: char) -> String {
        format!("l{side}{}", self.id)
    }

    /// A tunnel's interface of one end.
    pub(crate) fn tunnel(&self, side: char) -> String {
        format!("t{side}{}", self.id)
    }

    /// Whether anything passes.
    fn set(&self, state: &str) {
        ip(&format!("-n {} link set {} {state}", self.vessel(), self.end('v'))).unwrap();
    }

    /// The vessel's end gets another address.
    fn roam(&self) {
        // First the old one goes: it would take a second one of its network along.
        for change in ["del 192.0.2.2/24", "add 192.0.2.3/24"] {
            ip(&format!("-n {} addr {change} dev {}", self.vessel(), self.end('v'))).unwrap();
        }
    }

    pub(crate) fn inside(namespace: &str, program: &str) -> Command {
        let mut command = Command::new("ip");
        command.args(["netns", "exec", namespace, program]);
        command
    }
}

impl Drop for Cable {
    fn drop(&mut self) {
        for namespace in [self.shore(), self.vessel()] {
            ip(&format!("netns del {namespace}")).ok();
        }
    }
}

/// Starts a daemon of the tunnel that stays in the foreground.
pub(crate) fn daemon(namespace: &str, program: &str, arguments: &[&str], log: &Path) -> Process {
    let log = std::fs::File::create(log).unwrap();
    let errors = log.try_clone().unwrap();
    let mut command = Cable::inside(namespace, program);
    Process(command.args(arguments).stdin(Stdio::null()).stdout(log).stderr(errors).spawn().unwrap())
}

/// OpenVPN as the Otters use it: a server ashore that gives addresses, certificates known by their fingerprints.
async fn openvpn(cable: &Cable, folder: &Path) -> Vec<Process> {
    let mut prints = Vec::new();
    for name in ["shore", "vessel"] {
        let (key, certificate) = (folder.join(format!("{name}.key")), folder.join(format!("{name}.crt")));
        let (key, certificate) = (key.to_str().unwrap(), certificate.to_str().unwrap());
        let subject = format!("/CN={name}");
        let curve = "ec_paramgen_curve:prime256v1";
        let make =
            ["req", "-x509", "-newkey", "ec", "-pkeyopt", curve, "-nodes", "-days", "2", "-subj", &subject];
        run("openssl", &[&make[..], &["-keyout", key, "-out", certificate]].concat()).unwrap();
        let print = ["x509", "-in", certificate, "-noout", "-fingerprint", "-sha256"];
        let print = run("openssl", &print).unwrap();
        prints.push(print.split('=').nth(1).unwrap().to_owned());
    }
    let common = |name: &str, peer: usize, side| {
        format!(
            "proto udp\ndev {}\ndev-type tun\ncert {name}.crt\nkey {name}.key\nverb 3\n\
             data-ciphers AES-256-GCM:CHACHA20-POLY1305\n<peer-fingerprint>\n{}\n</peer-fingerprint>\n",
            cable.tunnel(side),
            prints[peer]
        )
    };
    let ashore = format!(
        "{}mode server\ntls-server\nlocal 192.0.2.1\nport 1194\ntopology subnet\n\
         ifconfig {SHORE_INSIDE} 255.255.255.0\nifconfig-pool 10.77.0.10 10.77.0.50\n\
         push \"topology subnet\"\npush \"route-gateway {SHORE_INSIDE}\"\ndh none\nkeepalive 1 5\n",
        common("shore", 1, 's')
    );
    let aboard = format!(
        "{}client\nremote 192.0.2.1 1194\nnobind\nconnect-retry 1 2\npersist-tun\npersist-key\n",
        common("vessel", 0, 'v')
    );
    let mut daemons = Vec::new();
    for (name, text, namespace) in [("shore", ashore, cable.shore()), ("vessel", aboard, cable.vessel())] {
        let config = format!("{name}.ovpn");
        std::fs::write(folder.join(&config), text).unwrap();
        let arguments = ["--cd", folder.to_str().unwrap(), "--config", &config];
        let log = folder.join(format!("{name}.vpn.log"));
        daemons.push(daemon(&namespace, "openvpn", &arguments, &log));
        let log = || std::fs::read_to_string(&log).unwrap();
        let up = || log().contains("Initialization Sequence Completed").then_some(());
        until(&format!("OpenVPN up: {name}"), up).await;
    }
    daemons
}

/// WireGuard in userspace; its interfaces have names that are unique on the computer.
async fn wireguard(cable: &Cable, folder: &Path) -> Vec<Process> {
    let mut keys = Vec::new();
    for name in ["shore", "vessel"] {
        let (private, path) = (run("wg", &["genkey"]).unwrap(), folder.join(format!("{name}.private")));
        std::fs::write(&path, format!("{private}\n")).unwrap();
        let public = run("sh", &["-c", &format!("wg pubkey < {}", path.display())]).unwrap();
        keys.push((private, public));
    }
    let aboard = "Endpoint = 192.0.2.1:51820\nPersistentKeepalive = 1\n";
    let ends = [
        ("shore", 's', cable.shore(), SHORE_INSIDE, "10.77.0.2", "ListenPort = 51820\n", ""),
        ("vessel", 'v', cable.vessel(), "10.77.0.2", SHORE_INSIDE, "", aboard),
    ];
    let mut daemons = Vec::new();
    for (at, (name, side, namespace, own, other, ours, theirs)) in ends.into_iter().enumerate() {
        let (config, device) = (folder.join(format!("{name}.wg")), cable.tunnel(side));
        let (private, public) = (&keys[at].0, &keys[1 - at].1);
        let text = format!(
            "[Interface]\nPrivateKey = {private}\n{ours}[Peer]\nPublicKey = {public}\nAllowedIPs = {other}/32\n{theirs}"
        );
        std::fs::write(&config, text).unwrap();
        daemons.push(daemon(
            &namespace,
            "wireguard-go",
            &["-f", &device],
            &folder.join(format!("{name}.log")),
        ));
        let set = ["netns", "exec", &namespace, "wg", "setconf", &device, config.to_str().unwrap()];
        until(&format!("WireGuard up: {name}"), || run("ip", &set).ok()).await;
        ip(&format!("-n {namespace} addr add {own}/24 dev {device}")).unwrap();
        ip(&format!("-n {namespace} link set {device} up")).unwrap();
    }
    daemons
}

/// How often a text is in the shore's log.
fn said(server: &Server, what: &str) -> usize {
    server.log().matches(what).count()
}

/// Arrival of the first packet with a time after `from_s` (s since 1970), from the archive.
fn first_ashore_s(data: &Path, from_s: f64) -> Option<f64> {
    let newer = |packet: &[u8]| PacketView::new(packet).is_ok_and(|view| view.timestamp() >= from_s);
    archived_packets(data, OTTER).iter().any(|one| newer(one)).then(now_s)
}

/// Sails with a tunnel whose cable is cut, and checks the outcome.
async fn sail(name: &str, cable: &Cable, program: &Path) {
    let (shore, aboard) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let data = shore.path().join("data");
    let token = link_token(&data, "otter-1", "0x2810");
    let inside: SocketAddr = format!("{SHORE_INSIDE}:8080").parse().unwrap();
    let beyond = ["--set", "http.plain_beyond_loopback=true"];
    let mut server =
        Server::start_by(Cable::inside(&cable.shore(), SERVER), &data, &inside.to_string(), &beyond);
    let vessel = Cable::inside(&cable.vessel(), program.to_str().unwrap());
    let mut agent = Agent::start_by(vessel, aboard.path(), inside, &token);
    until("begun", || (archived_bytes(&data) > 50_000).then_some(())).await;

    let (stood, down) = (said(&server, "the link stands"), said(&server, "the link is down"));
    cable.set("down");
    let cut = Instant::now();
    until("noticed by the shore", || (said(&server, "the link is down") > down).then_some(())).await;
    let shore_noticed = cut.elapsed();
    // The duration of the cut is part of the test.
    tokio::time::sleep(cut_lasts().saturating_sub(cut.elapsed())).await;
    assert_eq!(said(&server, "the link stands"), stood, "nothing passes a cut cable");
    cable.set("up");
    let (back, back_s) = (Instant::now(), now_s());
    until("live again", || (said(&server, "the link stands") > stood).then_some(())).await;
    let stands = back.elapsed();
    let ashore_s = until("heard again", || first_ashore_s(&data, back_s)).await;
    println!(
        "{name}: cable cut {:.1} s; the shore declared the link dead after {:.1} s; after the cable's return \
         the link stood in {:.1} s, and all of the outage with the first word after it was ashore in {:.1} s",
        (back - cut).as_secs_f64(),
        shore_noticed.as_secs_f64(),
        stands.as_secs_f64(),
        ashore_s - back_s
    );

    // Userspace WireGuard goes on sending from the address of before until 15 s without an answer: meanwhile the link may go down.
    cable.roam();
    let roamed_s = now_s();
    let ashore_s = until("heard from the other address", || first_ashore_s(&data, roamed_s)).await;
    println!("{name}: from another address the first word was ashore in {:.1} s", ashore_s - roamed_s);

    // It ends in order; its last packets arrive after its next start.
    let ended_s = now_s();
    agent.process.terminate();
    drop(agent);
    let vessel = Cable::inside(&cable.vessel(), program.to_str().unwrap());
    let mut agent = Agent::start_by(vessel, aboard.path(), inside, &token);
    until("complete", || (newest_s(&data) > ended_s + 1.0).then_some(())).await;
    agent.process.terminate();
    server.process.terminate();

    every_number_came_once(&data, 0);
    assert_eq!(Reader::open(&data).unwrap().gaps(None, TimeRange::ALL).unwrap(), []);
    let compared = all_that_was_logged_is_ashore(&data, aboard.path(), |said_s| said_s >= ended_s);
    let outage = |packet: &[u8]| (back_s - cut_lasts().as_secs_f64()..back_s).contains(&time_s(packet));
    let outage = archived_packets(&data, OTTER).iter().filter(|one| outage(one)).count();
    assert!(outage > 100 && compared > outage, "{outage} of the outage, {compared} compared");
    println!(
        "{name}: {compared} packets of the vessel's logs are ashore once, {outage} of them said in the outage"
    );
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn through_openvpn_a_cut_and_another_address_cost_nothing() {
    let Some(program) = agent_program() else { return };
    if !is_there("openvpn") || !is_there("openssl") {
        absent(Need::Openvpn, "apt-get install openvpn openssl");
        return;
    }
    let folder = TempDir::new().unwrap();
    let Some(cable) = Cable::lay("openvpn") else { return };
    let _daemons = openvpn(&cable, folder.path()).await;
    sail("OpenVPN", &cable, &program).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn through_wireguard_a_cut_and_another_address_cost_nothing() {
    let Some(program) = agent_program() else { return };
    if !is_there("wireguard-go") || !is_there("wg") {
        absent(Need::Wireguard, "apt-get install wireguard-go wireguard-tools");
        return;
    }
    let folder = TempDir::new().unwrap();
    let Some(cable) = Cable::lay("wireguard") else { return };
    let _daemons = wireguard(&cable, folder.path()).await;
    sail("WireGuard", &cable, &program).await;
}
