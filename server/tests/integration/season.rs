//! A season in fast motion: a fleet file is applied, three vessels are provisioned from their bundles and sail, links are cut,
//! each program is killed in turn, a vessel's disk is full, and the shore is lost and restored from a backup in another folder.
//! At the end every packet that a spool took is ashore exactly once, by the spools' own files, and the logs aboard say the same.
//!
//! `scripts/season` runs it and shows the table: a minute or two, or `scripts/season long`. Links go through relays on loopback, so that it
//! needs no namespaces; a disk that fills needs root, and is left out with a note elsewhere.

use crate::disk_full::Disk;
use crate::fleet::{Ashore, boat, provision, said};
use crate::support::ashore::{
    SAID_BEFORE_S, bytes_of, counted, link_numbers, logged_is_ashore, newest_of, now_s,
};
use crate::support::program::{Agent, Line, Server, agent_program, run, until};
use crate::support::spools::{Spooled, Witness};
use crate::support::{CONSOLE, Client, PATIENCE, archived_packets, packet};
use bytes::Bytes;
use imc::messages::{
    EstimatedState, Goto, Message, PlanControl, PlanControlOp, PlanControlType, SpeedUnits, ZUnits,
};
use imc::{Address, PacketView};
use std::collections::BTreeMap;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Instant;
use store::{Gap, Reader, TimeRange};
use tempfile::TempDir;
use testkit::so_many;

const EARTH_RADIUS_M: f64 = 6_371_000.0;
/// How far from its start each vessel has to come at least (m). A vessel that is killed begins at its start again.
const SAILED_M: f64 = 5.0;
/// Bytes of a vessel that have to come ashore before the next thing happens.
const MORE_BYTES: u64 = 15_000;

/// A provisioned vessel, its ways ashore and what happened to it.
struct Boat {
    name: &'static str,
    address: Address,
    /// The root of its file system, with what the bundle brought.
    root: TempDir,
    /// Its spool and logs.
    data: PathBuf,
    lines: Vec<Line>,
    agent: Option<Agent>,
    /// Of its spool.
    witness: Option<Witness>,
    cuts: usize,
    kills: usize,
    full: usize,
}

impl Boat {
    fn start(&mut self, program: &Path) {
        let config = self.root.path().join("etc/lutra/vessel.ini");
        self.agent = Some(Agent::run(Command::new(program), "Simulation", &config, &self.data));
    }

    fn kill(&mut self) {
        self.agent.take().unwrap().process.kill();
        self.kills += 1;
    }

    fn end(&mut self) {
        self.agent.take().unwrap().process.terminate();
    }

    fn errors(&self) -> String {
        self.agent.as_ref().unwrap().errors()
    }

    /// Waits until more of it is in the archive.
    async fn more(&self, data: &Path) {
        let more = bytes_of(data, self.address) + MORE_BYTES;
        until(&format!("more of {} ashore", self.name), || {
            (bytes_of(data, self.address) > more).then_some(())
        })
        .await;
    }

    /// Waits until its newest packet in the archive is younger than this moment.
    async fn is_current(&self, data: &Path) {
        let now_s = now_s();
        until(&format!("{} current ashore", self.name), || {
            (newest_of(data, self.address) > now_s).then_some(())
        })
        .await;
    }
}

/// The three vessels with their addresses, and the names of their ways.
const FLEET: [(&str, u16, &[&str]); 3] =
    [("otter-1", 0x2810, &["radio", "4G"]), ("otter-2", 0x2811, &["4G"]), ("otter-3", 0x2812, &["4G"])];

/// The fleet file, with a relay for each way.
fn fleet_file(lines: &[Vec<Line>]) -> String {
    let mut text = "[server]\npublic_name = \"192.0.2.1\"\n[vpn]\nnetwork = \"10.77.0.0/24\"\n\
                    server_address = \"10.77.0.1\"\n[common]\nprofile = \"Simulation\"\n"
        .to_owned();
    for (place, ((name, address, ways), lines)) in FLEET.iter().zip(lines).enumerate() {
        write!(
            text,
            "[[vessel]]\nname = \"{name}\"\nimc_address = {address}\nvpn_address = \"10.77.0.{}\"\n",
            place + 11
        )
        .unwrap();
        for (way, line) in ways.iter().zip(lines) {
            let url = format!("ws://{}/link", line.address);
            write!(text, "[[vessel.ways]]\nname = \"{way}\"\nurl = \"{url}\"\n").unwrap();
        }
    }
    text
}

/// Orders a vessel to a place 600 m away, by a console, until it says that it goes.
async fn sail(server: &Server, to: Address, request_id: u16) {
    let mut console = Client::connect(server.proxy).await;
    let goto = Goto {
        lat: 63.4515_f64.to_radians(),
        lon: 10.345_f64.to_radians(),
        z_units: ZUnits::Depth,
        speed: 1.5,
        speed_units: SpeedUnits::MetersPs,
        timeout: 3_000,
        ..Goto::default()
    };
    let request = PlanControl {
        r#type: PlanControlType::Request,
        op: PlanControlOp::Start,
        request_id,
        plan_id: "season".into(),
        arg: Some(Message::from(goto)).into(),
        ..PlanControl::default()
    };
    let end = Instant::now() + 2 * PATIENCE;
    let mut told = String::new();
    while Instant::now() < end {
        console.say(&packet(CONSOLE, to, now_s(), request.clone())).await;
        let answer = async {
            loop {
                let heard = console.hear().await;
                let view = PacketView::new(&heard).unwrap();
                if let Some(answer) = imc::decode::<PlanControl>(&view).unwrap()
                    && (answer.request_id, view.src()) == (request_id, to)
                    && matches!(answer.r#type, PlanControlType::Success | PlanControlType::Failure)
                {
                    return answer;
                }
            }
        };
        match tokio::time::timeout(PATIENCE / 10, answer).await {
            Ok(answer) if answer.r#type == PlanControlType::Success => return,
            // Such as while it has no position yet.
            Ok(answer) => {
                told = answer.info.to_str_lossy().into_owned();
                tokio::time::sleep(std::time::Duration::from_millis(500)).await;
            }
            Err(_) => {}
        }
    }
    panic!("{to:?} does not sail: {told}");
}

/// The farthest that a vessel was from where it began (m), by its own estimates in the archive.
fn sailed_m(data: &Path, address: Address) -> f64 {
    let states = archived_packets(data, address);
    let states = states.iter().filter_map(|one| {
        let state = imc::decode::<EstimatedState>(&PacketView::new(one).unwrap()).ok()??;
        let north_m = state.lat * EARTH_RADIUS_M + f64::from(state.x);
        Some((north_m, state.lon * EARTH_RADIUS_M * state.lat.cos() + f64::from(state.y)))
    });
    let places: Vec<(f64, f64)> = states.collect();
    let Some(first) = places.first() else { return 0.0 };
    places.iter().map(|one| (one.0 - first.0).hypot(one.1 - first.1)).fold(0.0, f64::max)
}

fn step(began: Instant, what: &str) {
    println!("{:5.1} s  {what}", began.elapsed().as_secs_f64());
}

/// What a vessel's spool took, and what is ashore of it.
#[derive(Debug, Default)]
struct Count {
    accepted: usize,
    /// Of these, packets that are ashore as often as the spool took them.
    ashore: usize,
    twice: usize,
    lost: usize,
    /// Numbers of packets that are not ashore at all, by which the reason can be found.
    absent: Vec<u64>,
    /// The last ones, which were not ashore when the vessel ended: they wait aboard for its next start.
    waiting: usize,
    /// Numbers that the vessel declared that it does not have.
    declared: u64,
    compared: usize,
    sailed_m: f64,
}

impl Count {
    /// Compares what a spool took with what is ashore. The shore also has its own copy of what others said to the vessel, such
    /// as orders: of these more may be there than the spool took.
    fn of(spooled: &Spooled, vessel: Address, ashore: &BTreeMap<Bytes, usize>) -> Self {
        let mut count =
            Self { declared: spooled.declared.iter().map(|(from, to)| to - from).sum(), ..Self::default() };
        let mut kept: Vec<(u64, &Bytes)> = spooled.kept().collect();
        while kept.pop_if(|(_, packet)| !ashore.contains_key(*packet)).is_some() {
            count.waiting += 1;
        }
        let absent = kept.iter().filter(|(_, packet)| !ashore.contains_key(*packet));
        count.absent = absent.map(|(number, _)| *number).collect();
        for (packet, took) in counted(kept.into_iter().map(|(_, packet)| packet.clone()).collect()) {
            let came = ashore.get(&packet).copied().unwrap_or(0);
            count.accepted += took;
            count.ashore += came.min(took);
            if PacketView::new(&packet).is_ok_and(|view| view.src() == vessel) {
                count.twice += came.saturating_sub(took);
            }
            count.lost += took.saturating_sub(came);
        }
        count
    }
}

#[test]
fn a_packet_that_came_twice_or_not_at_all_is_counted() {
    let (vessel, shore) = (Address(0x2810), CONSOLE);
    let said = |src: Address, time_s: u32| packet(src, vessel, time_s.into(), PlanControl::default());
    let mut spooled = Spooled::default();
    for (number, time_s) in [(3, 1), (4, 2), (5, 3), (6, 4), (7, 5), (8, 1)] {
        spooled.packets.insert(number, said(vessel, time_s));
    }
    spooled.packets.insert(9, said(shore, 1));
    spooled.packets.insert(10, said(vessel, 6));
    spooled.declared.push((6, 7));
    let ashore = [
        (said(vessel, 1), 2),
        (said(vessel, 2), 3),
        (said(vessel, 3), 1),
        (said(vessel, 9), 1),
        (said(shore, 1), 2),
    ];
    let count = Count::of(&spooled, vessel, &BTreeMap::from(ashore));
    assert_eq!((count.accepted, count.ashore, count.twice, count.lost, count.declared), (6, 5, 2, 1, 1));
    assert_eq!((count.waiting, count.absent), (1, vec![7]));
}

/// All packets in the archive, of all systems: a vessel also sends what others said.
fn all_ashore(data: &Path) -> BTreeMap<Bytes, usize> {
    let systems = std::fs::read_dir(data.join("archive")).unwrap().map(|entry| entry.unwrap().file_name());
    let systems = systems.filter_map(|name| u16::from_str_radix(name.to_str()?.strip_prefix("0x")?, 16).ok());
    counted(systems.flat_map(|system| archived_packets(data, Address(system))).collect())
}

fn count(
    data: &Path,
    boat: &Boat,
    spooled: &Spooled,
    ashore: &BTreeMap<Bytes, usize>,
    ended_s: f64,
) -> Count {
    let gaps = Reader::open(data).unwrap().gaps(Some(boat.address), TimeRange::ALL).unwrap();
    let covers =
        |gap: &Gap, at_s: f64| (gap.from.seconds() - SAID_BEFORE_S..gap.to.seconds()).contains(&at_s);
    let exempt = |said_s: f64| said_s >= ended_s || gaps.iter().any(|gap| covers(gap, said_s));
    Count {
        sailed_m: sailed_m(data, boat.address),
        compared: logged_is_ashore(data, &boat.data, boat.address, exempt),
        ..Count::of(spooled, boat.address, ashore)
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "takes a minute: scripts/season runs it"]
#[allow(clippy::too_many_lines, reason = "a season, step after step")]
async fn a_season_in_fast_motion_loses_nothing_and_doubles_nothing() {
    let Some(program) = agent_program() else { return };
    let (began, disk) = (Instant::now(), Disk::mount());
    let ashore = Ashore::new("");
    let (data, back) = (ashore.data(), ashore.beside("back"));
    std::fs::create_dir_all(&data).unwrap();
    let mut server = Server::start(&data);
    let mut lines = Vec::new();
    for (_, _, ways) in FLEET {
        let mut of_one = Vec::new();
        for _ in ways {
            of_one.push(Line::to(server.web).await);
        }
        lines.push(of_one);
    }
    ashore.says(&fleet_file(&lines));
    step(began, "the fleet file is applied, three bundles are made and brought aboard");
    ashore.apply(&[]);
    let mut boats = Vec::new();
    for ((name, address, _), lines) in FLEET.into_iter().zip(lines) {
        let ((bundle, passphrase), root) = (ashore.bundle(name), boat());
        let output = provision(&program, &bundle, &passphrase, root.path(), &[]);
        assert!(output.status.success(), "{}", said(&output));
        let on_disk = disk.as_ref().filter(|_| name == "otter-3");
        let data = on_disk.map_or_else(|| root.path().join("sailing"), super::disk_full::Disk::data);
        let (address, agent, witness) = (Address(address), None, Some(Witness::of(&data)));
        boats.push(Boat { name, address, root, data, lines, agent, witness, cuts: 0, kills: 0, full: 0 });
    }
    for boat in &mut boats {
        boat.start(&program);
    }
    for (place, boat) in boats.iter().enumerate() {
        boat.more(&data).await;
        sail(&server, boat.address, 900 + place as u16).await;
    }
    step(began, "three vessels sail");

    for round in 0..so_many(3, 20) {
        for place in 0..boats.len() {
            // Silence as behind a skerry, with the vessel killed in it; all of its ways at once.
            let boat = &mut boats[place];
            boat.lines.iter().for_each(Line::silent);
            boat.cuts += 1;
            boats[(place + 1) % FLEET.len()].more(&data).await;
            let boat = &mut boats[place];
            boat.kill();
            boat.start(&program);
            boat.lines.iter().for_each(|line| line.passes(server.web));
            boat.is_current(&data).await;
            step(began, &format!("round {}: {} was cut off, killed and is back", round + 1, boat.name));
        }
        // One of two ways alone.
        boats[0].lines[0].cut();
        boats[0].cuts += 1;
        boats[0].more(&data).await;
        boats[0].lines[0].passes(server.web);
        step(began, "otter-1 went on by its other way");

        server.process.kill();
        server = Server::start(&data);
        for boat in &boats {
            boat.lines.iter().for_each(|line| line.passes(server.web));
        }
        for boat in &boats {
            boat.is_current(&data).await;
        }
        step(began, "the server was killed and is back");

        if let Some(disk) = &disk {
            let boat = &mut boats[2];
            let is_told = |boat: &Boat| boat.errors().matches("the disk does not take the spool").count();
            let before = is_told(boat);
            until("told aboard", || {
                disk.fill();
                (is_told(boat) > before).then_some(())
            })
            .await;
            disk.make_room();
            boat.full += 1;
            boat.is_current(&data).await;
            step(began, "the disk of otter-3 was full and has room again");
        }
        for (place, boat) in boats.iter().enumerate() {
            sail(&server, boat.address, 1_000 + round * 10 + place as u16).await;
        }
    }

    // The computer ashore is lost with its power; what its disk has is backed up and restored on another.
    server.process.kill();
    boats[1].kill();
    boats[1].start(&program);
    let backup = ashore.beside("backup");
    run(&data, &["backup", backup.to_str().unwrap()]);
    run(&back, &["restore", backup.to_str().unwrap()]);
    let mut server = Server::start(&back);
    for boat in &boats {
        boat.lines.iter().for_each(|line| line.passes(server.web));
    }
    for (place, boat) in boats.iter().enumerate() {
        boat.is_current(&back).await;
        sail(&server, boat.address, 910 + place as u16).await;
    }
    step(began, "the shore was lost; restored into another folder it goes on with all vessels");

    // They end in order; their last packets arrive after the next start.
    let ended_s = now_s();
    for boat in &mut boats {
        boat.end();
        boat.start(&program);
    }
    for boat in &boats {
        until("complete", || (newest_of(&back, boat.address) > ended_s + 1.0).then_some(())).await;
    }
    boats.iter_mut().for_each(Boat::end);
    server.process.terminate();
    step(began, "all vessels have ended in order");

    println!(
        "\n{:8} {:>4} {:>5} {:>9} {:>9} {:>9} {:>7} {:>5} {:>8} {:>4} {:>13} {:>8}",
        "vessel",
        "cuts",
        "kills",
        "disk full",
        "accepted",
        "ashore",
        "waiting",
        "twice",
        "declared",
        "lost",
        "same as logs",
        "sailed m"
    );
    let (mut counts, all) = (Vec::new(), all_ashore(&back));
    for boat in &mut boats {
        let spooled = boat.witness.take().unwrap().tells();
        assert_eq!(spooled.unseen(), [0; 0], "{}: the witness did not see these numbers", boat.name);
        let count = count(&back, boat, &spooled, &all, ended_s);
        println!(
            "{:8} {:>4} {:>5} {:>9} {:>9} {:>9} {:>7} {:>5} {:>8} {:>4} {:>13} {:>8.0}",
            boat.name,
            boat.cuts,
            boat.kills,
            boat.full,
            count.accepted,
            count.ashore,
            count.waiting,
            count.twice,
            count.declared,
            count.lost,
            count.compared,
            count.sailed_m
        );
        counts.push(count);
    }
    println!(
        "accepted: packets in the files of the vessel's own spool, without those that wait there for the next start;\n\
         declared: the vessel said itself that it does not have them\n"
    );
    for (stream, mut numbers) in link_numbers(&back) {
        let came = numbers.len();
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!(numbers.len(), came, "numbers of {stream:#x} came twice");
    }
    for (boat, count) in boats.iter().zip(&counts) {
        assert!(count.lost == 0 && count.twice == 0, "{}: {count:?}", boat.name);
        // What was said in the last moment alone.
        assert!(count.waiting < 100, "{}: {count:?}", boat.name);
        assert!(count.accepted > 300, "{}: the witness saw too little: {count:?}", boat.name);
        assert!(count.compared > 300 && count.sailed_m > SAILED_M, "{}: {count:?}", boat.name);
    }
}
