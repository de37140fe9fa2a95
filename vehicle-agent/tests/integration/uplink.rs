//! The real program and a shore, either of them killed, and a connection that goes dead: the vessel's packets are ashore
//! once.

use crate::common::{Agent, CONSOLE, DEADLINE, OTTER, ini};
use imc::lsf::{LogItem, LogReader};
use imc::messages::{
    Abort, LoggingControl, Message, PlanControl, PlanControlType, PlanDB, PlanDBOp, PlanDBType,
};
use imc::{Header, Packet, PacketView, Payload as _};
use link::{Commander, ConnectionId, Gap, GapReason, Outcome, Shore, ShoreInput, ShoreOutput, ShoreSettings};
use std::collections::BTreeMap;
use std::io;
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use tempfile::TempDir;
use tungstenite::{Message as Frame, WebSocket};
use units::{MonoTime, Now, UtcTime};

/// Received records are durable after this.
const COMMIT: Duration = Duration::from_millis(50);
const LOOK_EVERY: Duration = Duration::from_millis(2);

/// The shore's disk.
#[derive(Default)]
struct Disk {
    stream: Option<u64>,
    /// Nothing under the number of a declared gap.
    kept: BTreeMap<u64, Vec<u8>>,
    /// Gaps that were declared.
    gaps: Vec<Gap>,
}

impl Disk {
    fn packets(&self) -> impl Iterator<Item = &Vec<u8>> {
        self.kept.values().filter(|packet| !packet.is_empty())
    }
}

/// The shore's program: its state is lost when dropped.
struct SmallShore<'a> {
    disk: &'a mut Disk,
    listener: TcpListener,
    sockets: BTreeMap<u64, WebSocket<TcpStream>>,
    shore: Shore,
    pending: Vec<(u64, Vec<u8>)>,
    next_commit: Instant,
    started: Instant,
    accepted: u64,
    /// Connections up to this number are dead: nothing is read from them or sent.
    dead: u64,
    /// The vessel's next number in its last hello.
    greeted_next: u64,
    ups: u64,
    outcomes: Vec<Outcome>,
}

impl<'a> SmallShore<'a> {
    fn start(disk: &'a mut Disk, port: u16) -> Self {
        let listener = TcpListener::bind(("127.0.0.1", port)).unwrap();
        listener.set_nonblocking(true).unwrap();
        let started = Instant::now();
        Self {
            disk,
            listener,
            sockets: BTreeMap::new(),
            shore: Shore::new(ShoreSettings::default()),
            pending: Vec::new(),
            next_commit: started,
            started,
            accepted: 0,
            dead: 0,
            greeted_next: 0,
            ups: 0,
            outcomes: Vec::new(),
        }
    }

    fn now(&self) -> Now {
        let since = SystemTime::now().duration_since(UNIX_EPOCH).unwrap();
        let utc = UtcTime::from_micros(i64::try_from(since.as_micros()).unwrap());
        Now { mono: MonoTime::default() + self.started.elapsed(), utc }
    }

    fn kept(&self) -> usize {
        self.disk.kept.len()
    }

    fn serve_until(&mut self, what: &str, done: impl Fn(&Self) -> bool) {
        let until = Instant::now() + 2 * DEADLINE;
        while !done(self) {
            assert!(Instant::now() < until, "not {what}; {} kept", self.kept());
            if !self.serve() {
                std::thread::sleep(LOOK_EVERY);
            }
        }
    }

    /// Processes everything once; returns whether there was anything.
    fn serve(&mut self) -> bool {
        let mut busy = false;
        if let Ok((stream, _)) = self.listener.accept() {
            stream.set_nonblocking(false).unwrap();
            // An abandoned connection does not complete the handshake.
            if let Ok(socket) = tungstenite::accept(stream) {
                socket.get_ref().set_nonblocking(true).unwrap();
                self.accepted += 1;
                self.sockets.insert(self.accepted, socket);
                self.tell(ShoreInput::Opened(ConnectionId(self.accepted)));
            }
            busy = true;
        }
        for id in self.sockets.keys().copied().filter(|id| *id > self.dead).collect::<Vec<_>>() {
            let Some(socket) = self.sockets.get_mut(&id) else { continue };
            match socket.read() {
                Ok(Frame::Binary(bytes)) => {
                    self.tell(ShoreInput::Message(ConnectionId(id), bytes));
                    busy = true;
                }
                Ok(_) => {}
                Err(tungstenite::Error::Io(error)) if error.kind() == io::ErrorKind::WouldBlock => {}
                Err(_) => {
                    self.sockets.remove(&id);
                    self.tell(ShoreInput::Closed(ConnectionId(id)));
                }
            }
        }
        if Instant::now() >= self.next_commit {
            self.next_commit = Instant::now() + COMMIT;
            self.commit();
        }
        self.tell(ShoreInput::Timer);
        busy
    }

    fn commit(&mut self) {
        for (seq, packet) in std::mem::take(&mut self.pending) {
            // As the store does: a known number is dropped, and there are no holes.
            assert!(seq <= self.disk.kept.len() as u64, "a hole before {seq}");
            let before = self.disk.kept.insert(seq, packet.clone());
            assert!(before.is_none_or(|before| before == packet), "another packet under {seq}");
        }
        if let (Some(stream), Some((seq, _))) = (self.disk.stream, self.disk.kept.last_key_value()) {
            let seq = *seq;
            self.tell(ShoreInput::Durable { stream, seq });
        }
    }

    fn tell(&mut self, input: ShoreInput) {
        self.shore.handle(self.now(), input);
        while let Some(output) = self.shore.poll_output() {
            match output {
                ShoreOutput::Send(id, bytes) if id.0 > self.dead => {
                    if let Some(socket) = self.sockets.get_mut(&id.0) {
                        // A killed peer is detected by reading.
                        socket.send(Frame::Binary(bytes)).ok();
                    }
                }
                // The end of a dead connection does not reach the vessel.
                ShoreOutput::Close(id, ..) if id.0 > self.dead => {
                    self.sockets.remove(&id.0);
                }
                ShoreOutput::Hello(id, hello) => {
                    assert_eq!(*self.disk.stream.get_or_insert(hello.stream), hello.stream);
                    self.greeted_next = hello.next;
                    let durable = self.disk.kept.last_key_value().map(|(seq, _)| *seq);
                    self.shore.handle(self.now(), ShoreInput::Resume(id, durable));
                }
                ShoreOutput::Records { records, .. } => {
                    self.pending.extend(records.into_iter().map(|one| (one.seq, one.packet.to_vec())));
                }
                ShoreOutput::Outcome(_, outcome) => self.outcomes.push(outcome),
                ShoreOutput::Up(_) => self.ups += 1,
                ShoreOutput::Gap { gap, .. } => {
                    self.pending.extend((gap.from..gap.to).map(|seq| (seq, Vec::new())));
                    self.disk.gaps.push(gap);
                }
                ShoreOutput::Send(..)
                | ShoreOutput::Close(..)
                | ShoreOutput::Live(_)
                | ShoreOutput::ChartPart(..)
                | ShoreOutput::ChartReport(_)
                | ShoreOutput::Ways(_)
                | ShoreOutput::Sent { .. }
                | ShoreOutput::Stray(_)
                | ShoreOutput::Down => {}
            }
        }
    }
}

/// An Otter's configuration with the uplink.
fn configure(folder: &Path, port: u16) {
    let lutra = format!(
        "\n[Transports.Lutra]\nEnabled = Always\nURL = ws://127.0.0.1:{port}/link\nToken File = token\n"
    );
    std::fs::write(folder.join("otter.ini"), std::fs::read_to_string(ini()).unwrap() + &lutra).unwrap();
    std::fs::write(folder.join("token"), "secret\n").unwrap();
}

fn logs(folder: &Path) -> Vec<PathBuf> {
    let mut found = Vec::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        if path.is_dir() {
            found.extend(logs(&path));
        } else if path.ends_with("Data.lsf.gz") {
            found.push(path);
        }
    }
    found
}

fn plan_query() -> Vec<u8> {
    let query =
        PlanDB { r#type: PlanDBType::Request, op: PlanDBOp::GetState, request_id: 77, ..PlanDB::default() };
    let header = Header { src: CONSOLE, dst: OTTER, ..Header::default() };
    Packet::new(header, query).encode().unwrap()
}

/// A start of a plan that does not exist.
fn plan_start() -> Vec<u8> {
    let start =
        PlanControl { r#type: PlanControlType::Request, plan_id: "x".into(), ..PlanControl::default() };
    let header = Header { src: CONSOLE, dst: OTTER, ..Header::default() };
    Packet::new(header, start).encode().unwrap()
}

#[test]
fn the_vessel_itself_refuses_whoever_has_no_lease() {
    let folder = TempDir::new().unwrap();
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    configure(folder.path(), port);
    let mut disk = Disk::default();
    let agent = Agent::start(folder.path(), &[]);
    let mut shore = SmallShore::start(&mut disk, port);
    shore.serve_until("begun", |shore| shore.kept() > 50);
    let order = |shore: &mut SmallShore<'_>, id, lease, packet: Vec<u8>| {
        let ttl = Duration::from_secs(20);
        let before = shore.outcomes.len();
        shore.tell(ShoreInput::Command { id, ttl, lease, order: 0, overtakes: false, packet: packet.into() });
        shore.serve_until("answered", |shore| shore.outcomes.len() > before);
        shore.outcomes.last().unwrap().clone()
    };
    assert_eq!(order(&mut shore, 1, 0, plan_start()), Outcome::Received, "without a lease anybody commands");
    shore.tell(ShoreInput::Lease(Commander { epoch: 7, holder: Some("nils".to_owned()) }));
    assert_eq!(order(&mut shore, 2, 7, plan_start()), Outcome::Received);
    let Outcome::Refused(why) = order(&mut shore, 3, 0, plan_start()) else { panic!() };
    assert!(why.contains("nils has control"), "{why}");
    assert_eq!(order(&mut shore, 4, 0, plan_query()), Outcome::Received, "who only asks is answered");
    // A former holder is late.
    shore.tell(ShoreInput::Lease(Commander { epoch: 8, holder: Some("ada".to_owned()) }));
    let Outcome::Refused(why) = order(&mut shore, 5, 7, plan_start()) else { panic!() };
    assert!(why.contains("has ended"), "{why}");
    let header = Header { src: CONSOLE, dst: OTTER, ..Header::default() };
    let abort = Packet::new(header, Abort).encode().unwrap();
    assert_eq!(order(&mut shore, 6, 0, abort), Outcome::Received, "an Abort is never refused");
    agent.terminate();
}

#[test]
fn whoever_is_killed_each_packet_is_ashore_once() {
    let folder = TempDir::new().unwrap();
    let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
    configure(folder.path(), port);
    let mut disk = Disk::default();
    let mut agent = Agent::start(folder.path(), &[]);

    let mut shore = SmallShore::start(&mut disk, port);
    shore.serve_until("begun", |shore| shore.kept() > 200);
    // A command reaches the brain, and its answer comes like other packets.
    let ttl = Duration::from_secs(20);
    shore.tell(ShoreInput::Command {
        id: 1,
        ttl,
        lease: 0,
        order: 0,
        overtakes: false,
        packet: plan_query().into(),
    });
    shore.serve_until("answered", |shore| !shore.outcomes.is_empty());
    assert_eq!(shore.outcomes, [Outcome::Received]);
    let is_answer = |packet: &Vec<u8>| {
        let packet = Packet::decode(packet).unwrap();
        matches!(packet.message(), Some(Message::PlanDB(reply)) if reply.request_id == 77)
    };
    shore.serve_until("told the plans", |shore| shore.disk.packets().any(is_answer));

    // The shore dies with its uncommitted records.
    drop(shore);
    let mut shore = SmallShore::start(&mut disk, port);
    let before = shore.kept();
    shore.serve_until("on after the shore died", |shore| shore.kept() > before + 200);

    // The connection goes dead silently: the vessel makes another.
    shore.dead = shore.accepted;
    let (before, ups) = (shore.kept(), shore.ups);
    shore.serve_until("on over another connection", |shore| shore.ups > ups && shore.kept() > before + 200);

    // The vessel dies.
    agent.child.kill().unwrap();
    agent.child.wait().unwrap();
    let killed_s = SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs_f64();
    let agent = Agent::start(folder.path(), &[]);
    let (before, ups) = (shore.kept(), shore.ups);
    shore.serve_until("on after the vessel died", |shore| shore.ups > ups && shore.kept() > before + 200);

    // It ends in order; its last packets arrive after its next start.
    agent.terminate();
    let agent = Agent::start(folder.path(), &[]);
    let ups = shore.ups;
    shore.serve_until("complete", |shore| shore.ups > ups && shore.kept() as u64 > shore.greeted_next);
    drop(shore);

    // Every packet of the logs is ashore as often, except declared gaps.
    let mut ashore = BTreeMap::<&[u8], usize>::new();
    for packet in disk.packets() {
        *ashore.entry(packet).or_default() += 1;
    }
    let mut logged = BTreeMap::<Vec<u8>, usize>::new();
    let current = logs(&folder.path().join("logs"));
    for log in &current {
        let mut reader = LogReader::open(log).unwrap();
        while let Ok(Some(item)) = reader.next_item() {
            // Each log begins and ends with its own mark.
            if let LogItem::Packet { view, .. } = item
                && view.id() != LoggingControl::ID
            {
                *logged.entry(view.bytes().to_vec()).or_default() += 1;
            }
        }
    }
    let last_s = disk.packets().filter_map(|packet| Some(PacketView::new(packet).ok()?.timestamp()));
    let last_s = last_s.fold(0.0, f64::max);
    // Packets that the killed vessel had not spooled are declared, up to its next start. (A packet's time precedes its
    // recording.)
    let [gap] = &disk.gaps[..] else { panic!("{:?}", disk.gaps) };
    assert_eq!((gap.reason, gap.to - gap.from), (GapReason::Killed, 1));
    let declared_s = gap.since.seconds() - 0.5..gap.until.seconds();
    assert!(declared_s.contains(&killed_s), "{gap:?}");
    let mut compared = 0;
    for (packet, times) in &logged {
        let said_s = PacketView::new(packet).unwrap().timestamp();
        if said_s < last_s - 1.0 && !declared_s.contains(&said_s) {
            compared += times;
            assert_eq!(ashore.get(&packet[..]), Some(times), "{:?}", Packet::decode(packet));
        }
    }
    assert!(compared > 500, "{compared} of {} compared", disk.kept.len());
    println!("{} packets ashore, {compared} compared with {} logs", disk.packets().count(), current.len());
    agent.terminate();
}
