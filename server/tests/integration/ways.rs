//! A real server and a real Otter with two ways (network paths) between them, each cut in turn silently: live values
//! continue, and nothing is lost, duplicated or carried out twice.

use crate::support::ashore::{
    all_that_was_logged_is_ashore, every_number_came_once, newest_s, now_s, time_s,
};
use crate::support::program::{Agent, Line, Server, agent_program, link_token, logged, until};
use crate::support::{CONSOLE, Client, OTTER, packet};
use imc::messages::{EstimatedState, Payload as _, PlanDB, PlanDBOp, PlanDBType};
use imc::{Packet, PacketView};
use std::collections::{BTreeMap, BTreeSet};
use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::process::Command;
use std::sync::{Arc, Mutex};
use std::time::{Duration, Instant};
use tempfile::TempDir;
use testkit::so_many;

const SEED: u64 = 0x5DEE_CE66_D1CE_4E5B;
/// First request id during a cut.
const FIRST_REQUEST: u16 = 700;

fn next(chance: &mut u64, most: u64) -> u64 {
    *chance ^= *chance << 13;
    *chance ^= *chance >> 7;
    *chance ^= *chance << 17;
    *chance % most
}

/// Whether the server reports a way as up.
fn is_up(server: SocketAddr, way: &str) -> bool {
    let mut stream = TcpStream::connect(server).unwrap();
    stream.write_all(b"GET /metrics HTTP/1.1\r\nHost: x\r\nConnection: close\r\n\r\n").unwrap();
    let mut figures = String::new();
    stream.read_to_string(&mut figures).unwrap();
    let way = format!("way=\"{way}\"");
    figures
        .lines()
        .any(|line| line.starts_with("lutra_way_up{") && line.contains(&way) && line.ends_with(" 1"))
}

/// Positions of the vessel that a viewer has received.
#[derive(Default)]
struct Heard {
    states: u64,
    newest_s: f64,
    last: Option<Instant>,
    /// The longest time without a newer one.
    longest: Duration,
    said_us: BTreeSet<i64>,
    doubled: u64,
    /// On a busy computer a way may be given up late, and the newest values go before records that lag for a second.
    overtaken: u64,
}

impl Heard {
    fn state(&mut self, said_s: f64) {
        let now = Instant::now();
        self.doubled += u64::from(!self.said_us.insert((said_s * 1e6).round() as i64));
        self.states += 1;
        if said_s < self.newest_s {
            self.overtaken += 1;
            return;
        }
        self.longest = self.longest.max(self.last.map_or(Duration::ZERO, |last| now - last));
        (self.newest_s, self.last) = (said_s, Some(now));
    }
}

async fn listen(mut client: Client, heard: Arc<Mutex<Heard>>) {
    loop {
        let packet = client.hear().await;
        let view = PacketView::new(&packet).unwrap();
        if view.id() == EstimatedState::ID && view.src() == OTTER {
            heard.lock().unwrap().state(view.timestamp());
        }
    }
}

fn ask(number: u16) -> PlanDB {
    PlanDB {
        r#type: PlanDBType::Request,
        op: PlanDBOp::GetState,
        request_id: FIRST_REQUEST + number,
        ..PlanDB::default()
    }
}

/// How often each request was answered aboard.
fn answers(aboard: &std::path::Path) -> BTreeMap<u16, usize> {
    let mut answers = BTreeMap::new();
    for packet in logged(aboard) {
        let Ok(packet) = Packet::decode(&packet) else { continue };
        if packet.header.src == OTTER
            && let Some(answer) = packet.get::<PlanDB>().filter(|one| one.r#type != PlanDBType::Request)
        {
            *answers.entry(answer.request_id).or_default() += 1;
        }
    }
    answers
}

/// The vessel sails for as long as the cuts take: about 9 s, or a minute for all twenty by `make test-long`.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn cut_by_turns_what_is_seen_goes_on_and_all_is_ashore_once() {
    let Some(program) = agent_program() else { return };
    let cuts = so_many(3_u16, 20);
    let (shore, aboard) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let data = shore.path().join("data");
    let token = link_token(&data, "otter-1", "0x2810");
    let mut server = Server::start(&data);
    let lines = [Line::to(server.web).await, Line::to(server.web).await];
    let names = ["radio", "4G"];
    let mut more = String::new();
    for (place, (line, name)) in lines.iter().zip(names).enumerate() {
        let url = format!("ws://{}/link", line.address);
        let metered = place == 1;
        let section = format!("\n[Transports.LutraWay/{place}]\nEnabled = Always\nEntity Label = {name}\n");
        more.extend([section, format!("URL = {url}\nMetered = {metered}\n")]);
    }
    let command = Command::new(&program);
    let mut agent = Agent::start_with(command, aboard.path(), lines[0].address, &token, &more);
    for name in names {
        until("up by both ways", || is_up(server.web, name).then_some(())).await;
    }
    let heard = Arc::new(Mutex::new(Heard::default()));
    let listening = tokio::spawn(listen(Client::connect(server.proxy).await, Arc::clone(&heard)));
    let mut console = Client::connect(server.proxy).await;
    until("seen", || (heard.lock().unwrap().states > 3).then_some(())).await;
    heard.lock().unwrap().longest = Duration::ZERO;

    let mut chance = SEED;
    for cut in 0..cuts {
        let line = &lines[usize::from(cut) % 2];
        line.silent();
        let asked = packet(CONSOLE, OTTER, now_s(), ask(cut));
        console.say(&asked).await;
        let before = heard.lock().unwrap().states;
        until("seen in spite of the cut", || (heard.lock().unwrap().states > before + 3).then_some(())).await;
        // The rest of the cut is part of the test.
        tokio::time::sleep(Duration::from_millis(next(&mut chance, 1_000))).await;
        line.passes(server.web);
        for name in names {
            until("up again", || is_up(server.web, name).then_some(())).await;
        }
    }
    until("answered", || (answers_ashore(&data) >= usize::from(cuts)).then_some(())).await;
    let ended_s = now_s();
    until("complete", || (newest_s(&data) > ended_s + 1.0).then_some(())).await;
    agent.process.terminate();
    for name in names {
        until("down with the vessel", || (!is_up(server.web, name)).then_some(())).await;
    }
    listening.abort();
    server.process.terminate();

    every_number_came_once(&data, 0);
    let compared = all_that_was_logged_is_ashore(&data, aboard.path(), |said_s| said_s >= ended_s);
    assert!(compared > 100, "{compared}");
    let asked: BTreeMap<u16, usize> = (0..cuts).map(|cut| (FIRST_REQUEST + cut, 1)).collect();
    assert_eq!(answers(aboard.path()), asked, "each question is answered once");
    let heard = heard.lock().unwrap();
    assert_eq!(heard.doubled, 0, "values are seen once");
    println!(
        "{cuts} cuts: {compared} packets are ashore once; {} positions seen, {} after a newer one, the longest pause {:.2} s",
        heard.states,
        heard.overtaken,
        heard.longest.as_secs_f64()
    );
    // From the vessel's point of view: by which way, and why.
    assert!(server.log().contains("failover"), "no way was left");
}

fn answers_ashore(data: &std::path::Path) -> usize {
    let packets = crate::support::archived_packets(data, OTTER);
    let answers = packets.iter().filter(|packet| time_s(packet) > 0.0).filter(|packet| {
        let decoded = Packet::decode(packet).ok();
        decoded
            .and_then(|packet| packet.get::<PlanDB>().cloned())
            .is_some_and(|one| one.r#type != PlanDBType::Request && one.request_id >= FIRST_REQUEST)
    });
    answers.count()
}
