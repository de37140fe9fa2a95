//! A real server whose disk fills up: it acknowledges nothing, reports it to machines and people, and continues when there
//! is room, also after a kill and restart meanwhile. Nothing is lost.
//!
//! Needs root, for a disk of a few MiB in memory; prints a note where it cannot have one.

use crate::support::ashore::{
    all_that_was_logged_is_ashore, archived_bytes, every_number_came_once, newest_s, now_s,
};
use crate::support::browser::{Browser, ask};
use crate::support::program::{Agent, Line, Server, add_admin, agent_program, link_token, until};
use crate::support::{Client, archive_of, archived_packets, packet, packets_of};
use imc::messages::LogBookEntry;
use imc::{Address, PacketView};
use std::io::Write as _;
use std::path::PathBuf;
use std::process::Command;
use store::{Reader, TimeRange};
use tempfile::TempDir;

const DUNE: Address = Address(0x0801);
/// Packets that a vessel without a spool sends while the disk is full.
const SAID: u32 = 500;

/// A small disk in memory at `data` in a folder; gone when dropped.
pub(crate) struct Disk(TempDir);

impl Disk {
    /// `None`, with a note, where none may be mounted.
    pub(crate) fn mount() -> Option<Self> {
        let disk = Self(TempDir::new().unwrap());
        std::fs::create_dir(disk.data()).unwrap();
        let mut mount = Command::new("mount");
        let output =
            mount.args(["-t", "tmpfs", "-o", "size=24m", "lutra"]).arg(disk.data()).output().unwrap();
        if output.status.success() {
            return Some(disk);
        }
        testkit::absent(testkit::Need::Mount, String::from_utf8_lossy(&output.stderr).trim());
        None
    }

    pub(crate) fn data(&self) -> PathBuf {
        self.0.path().join("data")
    }

    fn filler(&self) -> PathBuf {
        self.data().join("filler")
    }

    /// Fills all free space.
    pub(crate) fn fill(&self) {
        let mut file = std::fs::File::options().create(true).append(true).open(self.filler()).unwrap();
        while file.write_all(&[0; 4096]).is_ok() {}
    }

    pub(crate) fn make_room(&self) {
        std::fs::remove_file(self.filler()).unwrap();
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        Command::new("umount").arg("--lazy").arg(self.data()).status().ok();
    }
}

/// Fills the disk until the server reports it, to machines and people.
async fn fill_until_told(disk: &Disk, server: &Server, person: &mut Browser) {
    until("told", || {
        disk.fill();
        let (status, body) = ask(server.web, "/healthz");
        (status == 503 && body.contains("the disk is full, nothing is recorded")).then_some(())
    })
    .await;
    // The data of the page's banner, for people who were logged in before; the page itself is still served.
    let recording = person.get("/api/v1/recording");
    assert!(recording.contains("make room, or remove old history"), "{recording}");
    assert!(person.get("/").contains("<main"));
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_full_disk_is_told_acknowledges_nothing_and_loses_nothing() {
    let Some(program) = agent_program() else { return };
    let Some(disk) = Disk::mount() else { return };
    let (data, aboard) = (disk.data(), TempDir::new().unwrap());
    let token = link_token(&data, "otter-1", "0x2810");
    add_admin(&data, "nils", "seven small boats");
    let mut server = Server::start(&data);
    let mut person = Browser::log_in(&server.web.to_string(), "nils", "seven small boats");
    let line = Line::to(server.web).await;
    let mut agent = Agent::start(&program, aboard.path(), line.address, &token);
    until("begun", || (archived_bytes(&data) > 20_000).then_some(())).await;

    // While it is full, the vessel keeps its packets, and the server keeps those of a vessel without a spool.
    fill_until_told(&disk, &server, &mut person).await;
    let archived = archived_bytes(&data);
    let mut dune = Client::connect(server.proxy).await;
    let begun_s = now_s();
    for number in 0..SAID {
        let entry = LogBookEntry { text: format!("{number}").as_str().into(), ..LogBookEntry::default() };
        dune.say(&packet(DUNE, Address::NULL, begun_s + f64::from(number) * 1e-3, entry)).await;
    }
    let waiting = "lutra_relay_packets_total{what=\"received\"} ";
    until("heard by the relay", || {
        let figures = ask(server.web, "/metrics").1;
        let heard = figures.lines().find_map(|line| line.strip_prefix(waiting)).map(str::parse::<u64>);
        heard.is_some_and(|heard| heard.unwrap() > u64::from(SAID)).then_some(())
    })
    .await;
    assert_eq!(archived_bytes(&data), archived, "half a packet was left, or one too many");
    disk.make_room();
    until("well again", || (ask(server.web, "/healthz").0 == 200).then_some(())).await;
    assert!(server.log().contains("recording goes on"));
    assert!(person.get("/api/v1/recording").contains("\"trouble\":null"));
    let back_s = now_s();
    until("on with room", || (newest_s(&data) > back_s).then_some(())).await;
    let kept = || archive_of(&data, DUNE).iter().map(|log| packets_of(log).len()).sum::<usize>();
    until("all of the vessel without a spool", || (kept() >= SAID as usize).then_some(())).await;

    // Full again; this time the server is killed.
    fill_until_told(&disk, &server, &mut person).await;
    server.process.kill();
    drop(server);
    disk.make_room();
    let mut server = Server::start(&data);
    line.passes(server.web);
    let back_s = now_s();
    until("on after its start", || (newest_s(&data) > back_s).then_some(())).await;

    // The vessel ends in order; its last packets arrive after its next start.
    let ended_s = now_s();
    agent.process.terminate();
    drop(agent);
    let mut agent = Agent::start(&program, aboard.path(), line.address, &token);
    until("complete", || (newest_s(&data) > ended_s + 1.0).then_some(())).await;
    agent.process.terminate();
    server.process.terminate();

    every_number_came_once(&data, 0);
    assert_eq!(Reader::open(&data).unwrap().gaps(None, TimeRange::ALL).unwrap(), []);
    let compared = all_that_was_logged_is_ashore(&data, aboard.path(), |said_s| said_s >= ended_s);
    let texts: Vec<String> = archived_packets(&data, DUNE)
        .iter()
        .filter_map(|one| imc::decode::<LogBookEntry>(&PacketView::new(one).unwrap()).unwrap())
        .map(|entry| entry.text.to_str_lossy().into_owned())
        .collect();
    assert_eq!(texts, (0..SAID).map(|number| number.to_string()).collect::<Vec<_>>());
    println!(
        "the disk was full twice: {compared} packets of the vessel's logs are ashore once, none missing"
    );
}
