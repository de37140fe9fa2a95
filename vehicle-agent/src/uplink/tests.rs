//! The thread against a small shore on a real socket.

use super::*;
use crate::uplink::filter::Filter;
use crate::uplink::server::Server;
use crate::uplink::spool::Bounds;
use crate::uplink::ways::Door;
use link::{ConnectionId, Outcome, Shore, ShoreInput, ShoreOutput, ShoreSettings};
use onboard::Mandate;
use std::collections::BTreeMap;
use std::io;
use std::net::TcpListener;
use std::sync::mpsc::{Receiver, Sender, channel};
use tungstenite::{Message, WebSocket};
use units::{MonoTime, Now};

const DEADLINE: Duration = Duration::from_mins(1);

fn settings(folder: &std::path::Path, port: u16) -> UplinkSettings {
    UplinkSettings {
        address: 0x2810,
        name: "ntnu-otter-01".to_owned(),
        ways: vec![Door::only(server(port))],
        filter: Filter::default(),
        spool: folder.join("spool"),
        bounds: Bounds::of(16 << 20),
        budget_bytes_per_s: None,
        sync_every: Duration::from_millis(20),
        chart: None,
    }
}

fn server(port: u16) -> Server {
    Server::at(format!("ws://127.0.0.1:{port}/link"), "secret".to_owned(), None).unwrap()
}

fn packet(number: u64) -> Vec<u8> {
    let header = imc::Header { timestamp: number as f64, ..imc::Header::default() };
    imc::Packet::new(header, imc::messages::Rpm { value: number as i16 }).encode().unwrap()
}

/// A shore that keeps records in memory and serves one connection after the other.
struct SmallShore {
    /// Nothing under the number of a declared gap.
    kept: BTreeMap<u64, Vec<u8>>,
    gaps: Vec<link::GapReason>,
    shore: Shore,
    outcomes: Vec<(u64, Outcome)>,
    /// Packets received by the live lane.
    live: Vec<Vec<u8>>,
    started: Instant,
}

fn shore() -> (TcpListener, u16, SmallShore) {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let shore = Shore::new(ShoreSettings::default());
    let (kept, gaps, outcomes, live) = (BTreeMap::new(), Vec::new(), Vec::new(), Vec::new());
    (listener, port, SmallShore { kept, gaps, shore, outcomes, live, started: Instant::now() })
}

impl SmallShore {
    fn now(&self) -> Now {
        let mono = MonoTime::default() + self.started.elapsed();
        Now { mono, utc: Clock::system().utc() }
    }

    /// Serves a connection until `done`.
    fn serve(&mut self, id: u64, stream: std::net::TcpStream, done: impl Fn(&Self) -> bool) {
        let broken = self.serve_while(id, stream, done);
        assert!(broken.is_ok(), "{broken:?}");
    }

    /// Serves a connection until `done`, or until the vessel breaks it.
    #[expect(clippy::result_large_err, reason = "the library's type for a refusal")]
    fn serve_while(
        &mut self,
        id: u64,
        stream: std::net::TcpStream,
        done: impl Fn(&Self) -> bool,
    ) -> Result<(), tungstenite::Error> {
        let token = |request: &tungstenite::handshake::server::Request, response| {
            assert_eq!(request.headers()["authorization"], "Bearer secret");
            Ok(response)
        };
        let mut socket = tungstenite::accept_hdr(stream, token).unwrap();
        socket.get_ref().set_read_timeout(Some(Duration::from_millis(5))).unwrap();
        let id = ConnectionId(id);
        self.shore.handle(self.now(), ShoreInput::Opened(id));
        let until = Instant::now() + DEADLINE;
        let mut outcome = Ok(());
        while outcome.is_ok() && !done(self) {
            assert!(Instant::now() < until, "{} kept", self.kept.len());
            match socket.read() {
                Ok(Message::Binary(bytes)) => self.shore.handle(self.now(), ShoreInput::Message(id, bytes)),
                Ok(_) => {}
                Err(tungstenite::Error::Io(error)) if error.kind() == io::ErrorKind::WouldBlock => {
                    self.shore.handle(self.now(), ShoreInput::Timer);
                }
                Err(error) => outcome = Err(error),
            }
            self.carry_out(&mut socket);
        }
        self.shore.handle(self.now(), ShoreInput::Closed(id));
        outcome
    }

    fn carry_out(&mut self, socket: &mut WebSocket<std::net::TcpStream>) {
        while let Some(output) = self.shore.poll_output() {
            match output {
                // A vessel that is gone is detected by reading.
                ShoreOutput::Send(_, bytes) => drop(socket.send(Message::Binary(bytes))),
                ShoreOutput::Hello(id, hello) => {
                    assert_eq!((hello.address, &hello.name[..]), (0x2810, "ntnu-otter-01"));
                    let durable = self.kept.last_key_value().map(|(seq, _)| *seq);
                    self.shore.handle(self.now(), ShoreInput::Resume(id, durable));
                }
                ShoreOutput::Records { stream, records } => {
                    for record in records {
                        assert_eq!(record.seq, self.kept.len() as u64, "in order and once");
                        self.kept.insert(record.seq, record.packet.to_vec());
                    }
                    let seq = self.kept.len() as u64 - 1;
                    self.shore.handle(self.now(), ShoreInput::Durable { stream, seq });
                }
                ShoreOutput::Outcome(id, outcome) => self.outcomes.push((id, outcome)),
                ShoreOutput::Close(_, code, text) => panic!("{code:?} {text}"),
                ShoreOutput::Gap { gap, .. } => {
                    self.kept.extend((gap.from..gap.to).map(|seq| (seq, Vec::new())));
                    self.gaps.push(gap.reason);
                }
                ShoreOutput::Live(packets) => {
                    self.live.extend(packets.into_iter().map(|record| record.packet.to_vec()));
                }
                ShoreOutput::Up(_)
                | ShoreOutput::Down
                | ShoreOutput::ChartPart(..)
                | ShoreOutput::ChartReport(_)
                | ShoreOutput::Ways(_)
                | ShoreOutput::Sent { .. }
                | ShoreOutput::Stray(_) => {}
            }
        }
    }
}

fn commands() -> (Deliver, Receiver<Vec<u8>>) {
    let (sender, receiver): (Sender<Vec<u8>>, _) = channel();
    let deliver = move |what: FromShore<'_>| match what {
        FromShore::Lease(_) | FromShore::Chart(_) | FromShore::NotSpooled(_) => Ok(()),
        FromShore::Order { packet: b"refused", .. } => Err("not this one".to_owned()),
        FromShore::Order { mandate: Mandate { lease: 7, .. }, packet } => {
            sender.send(packet.to_vec()).map_err(|error| error.to_string())
        }
        FromShore::Order { mandate, .. } => Err(format!("under lease {}", mandate.lease)),
    };
    (Box::new(deliver), receiver)
}

#[test]
fn everything_arrives_once_over_connections_that_break_and_starts_that_follow() {
    let folder = tempfile::tempdir().unwrap();
    let (listener, port, mut small) = shore();
    let mut said = 0;
    let mut connection = 0;
    for _ in 0..3 {
        let (deliver, delivered) = commands();
        let uplink =
            Uplink::start(settings(folder.path(), port), ChartAboard::default(), Clock::system(), deliver)
                .unwrap();
        for _ in 0..3 {
            for _ in 0..400 {
                uplink.record(&packet(said));
                uplink.flush();
                said += 1;
            }
            connection += 1;
            // The connection breaks when a part has arrived; the rest comes over the next.
            let (stream, _) = listener.accept().unwrap();
            let enough = said - 100;
            small.serve(connection, stream, |small| small.kept.len() as u64 >= enough);
        }
        let command = |id, packet: &'static [u8]| ShoreInput::Command {
            id,
            ttl: Duration::from_secs(30),
            lease: 7,
            order: id,
            overtakes: false,
            packet: bytes::Bytes::from_static(packet),
        };
        small.shore.handle(small.now(), command(connection, b"go"));
        small.shore.handle(small.now(), command(connection + 1000, b"refused"));
        connection += 1;
        let (stream, _) = listener.accept().unwrap();
        let before = small.outcomes.len();
        small.serve(connection, stream, |small| {
            small.kept.len() as u64 == said && small.outcomes.len() == before + 2
        });
        assert_eq!(delivered.recv_timeout(DEADLINE).unwrap(), b"go");
        assert!(uplink.end());
    }
    let refused = small.outcomes.iter().filter(|(_, outcome)| *outcome != Outcome::Received);
    assert!(refused.clone().count() == 3);
    assert!(refused.into_iter().all(|(_, how)| *how == Outcome::Refused("not this one".to_owned())));
    for (seq, kept) in &small.kept {
        assert_eq!(*kept, packet(*seq));
    }
    assert_eq!((small.kept.len() as u64, small.gaps), (said, vec![]));
}

#[test]
fn after_a_fault_of_its_own_it_begins_anew_and_declares_what_that_took() {
    let folder = tempfile::tempdir().unwrap();
    let (listener, port, mut small) = shore();
    let mut faults = 0;
    let deliver: Deliver = Box::new(move |_| {
        faults += 1;
        if faults == 1 { panic!("a fault of the program") } else { Ok(()) }
    });
    let uplink =
        Uplink::start(settings(folder.path(), port), ChartAboard::default(), Clock::system(), deliver)
            .unwrap();
    (0..100).for_each(|number| uplink.record(&packet(number)));
    uplink.flush();
    let (stream, _) = listener.accept().unwrap();
    small.serve(1, stream, |small| small.kept.len() == 100);
    let command = || ShoreInput::Command {
        id: 1,
        ttl: Duration::from_secs(50),
        lease: 0,
        order: 0,
        overtakes: false,
        packet: bytes::Bytes::from_static(b"go"),
    };
    small.shore.handle(small.now(), command());
    // The connection breaks with the thread: the shore sends the command again over the next.
    let (stream, _) = listener.accept().unwrap();
    assert!(small.serve_while(2, stream, |_| false).is_err());
    (100..200).for_each(|number| uplink.record(&packet(number)));
    uplink.flush();
    let (stream, _) = listener.accept().unwrap();
    small.serve(3, stream, |small| small.kept.len() == 201 && !small.outcomes.is_empty());
    assert_eq!(small.gaps, [link::GapReason::Killed]);
    let packets: Vec<_> = small.kept.values().filter(|one| !one.is_empty()).cloned().collect();
    assert_eq!(packets, (0..200).map(packet).collect::<Vec<_>>());
    assert!(uplink.end());
}

#[test]
fn a_url_says_where_the_shore_is_or_what_is_wrong() {
    let at = |url: &str, authority: Option<&str>| {
        let server = Server::at(url.to_owned(), "t".to_owned(), authority.map(Into::into));
        server.map(|server| (server.host, server.port)).map_err(|error| format!("{error:#}"))
    };
    assert_eq!(at("ws://10.77.0.1:8080/link", None), Ok(("10.77.0.1".to_owned(), 8080)));
    assert_eq!(at("ws://shore/link", None), Ok(("shore".to_owned(), 80)));
    assert_eq!(at("wss://[fd00::1]/link", Some("ca.pem")), Ok(("fd00::1".to_owned(), 443)));
    for (url, wrong) in [
        ("http://x/", "ws:// or wss://"),
        ("wss://x/", "Certificate Authority"),
        ("ws//", "URL"),
        ("", "URL"),
    ] {
        assert!(at(url, None).unwrap_err().contains(wrong), "{url}");
    }
}

/// The result of one attempt at a server that handles its first connection by `serve`.
fn attempt(
    url: impl Fn(u16) -> String,
    authority: Option<std::path::PathBuf>,
    handle: impl FnOnce(std::net::TcpStream) + Send + 'static,
) -> Result<socket::Socket, (link::Failure, String)> {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    let serving = std::thread::spawn(move || handle(listener.accept().unwrap().0));
    let server = Server::at(url(port), "secret".to_owned(), authority).unwrap();
    let carried = socket::Carried::default();
    let outcome = socket::connect(&Door::only(server), Duration::from_secs(10), &carried);
    serving.join().unwrap();
    // The request alone, made or not.
    assert!(carried.bytes() > 100, "{carried:?}");
    outcome
}

#[test]
#[expect(clippy::result_large_err, reason = "the library's type for a refusal")]
fn a_wrong_token_is_a_refusal_that_says_so() {
    let outcome = attempt(
        |port| format!("ws://127.0.0.1:{port}/link"),
        None,
        |stream| {
            let refuse = |_: &tungstenite::handshake::server::Request, _| {
                Err(tungstenite::http::Response::builder().status(401).body(None).unwrap())
            };
            assert!(tungstenite::accept_hdr(stream, refuse).is_err());
        },
    );
    let (failure, text) = outcome.unwrap_err();
    assert_eq!(failure, link::Failure::Refused);
    assert!(text.contains("401") && text.contains("token"), "{text}");
}

#[test]
fn over_tls_only_the_given_authority_is_trusted() {
    let folder = tempfile::tempdir().unwrap();
    let make = |name: &str| {
        let made = rcgen::generate_simple_self_signed(vec!["127.0.0.1".to_owned()]).unwrap();
        let path = folder.path().join(name);
        std::fs::write(&path, made.cert.pem()).unwrap();
        (path, made)
    };
    let ((ours, _), (theirs, made)) = (make("ours.pem"), make("theirs.pem"));
    let connect = |trusted: std::path::PathBuf| {
        let (certificate, key) = (made.cert.der().clone(), made.signing_key.serialize_der());
        attempt(
            |port| format!("wss://127.0.0.1:{port}/link"),
            Some(trusted),
            move |stream| {
                let provider = Arc::new(rustls::crypto::ring::default_provider());
                let key = rustls::pki_types::PrivateKeyDer::Pkcs8(key.into());
                let config = rustls::ServerConfig::builder_with_provider(provider)
                    .with_safe_default_protocol_versions()
                    .unwrap()
                    .with_no_client_auth()
                    .with_single_cert(vec![certificate], key)
                    .unwrap();
                let tls = rustls::ServerConnection::new(Arc::new(config)).unwrap();
                // A client that does not trust this server disconnects.
                if let Ok(mut socket) = tungstenite::accept(rustls::StreamOwned::new(tls, stream)) {
                    socket.send(Message::Binary(bytes::Bytes::from_static(b"over tls"))).unwrap();
                }
            },
        )
    };
    let (_, text) = connect(ours).unwrap_err();
    assert!(text.contains("certificate"), "{text}");
    let mut socket = connect(theirs).unwrap();
    let until = Instant::now() + DEADLINE;
    let heard = loop {
        if let Some(heard) = socket.receive().unwrap() {
            break heard;
        }
        assert!(Instant::now() < until);
        std::thread::yield_now();
    };
    assert_eq!(&heard[..], b"over tls");
}

#[test]
fn a_disk_that_refuses_the_spool_does_not_stop_the_vessel() {
    let folder = tempfile::tempdir().unwrap();
    let (deliver, _delivered) = commands();
    let settings = settings(folder.path(), 1);
    std::fs::write(&settings.spool, "in the way").unwrap();
    let uplink = Uplink::start(settings.clone(), ChartAboard::default(), Clock::system(), deliver).unwrap();
    uplink.record(&packet(1));
    uplink.flush();
    std::fs::remove_file(&settings.spool).unwrap();
    let until = Instant::now() + DEADLINE;
    while !settings.spool.join("identity").exists() {
        assert!(Instant::now() < until);
        std::thread::sleep(LOOK_EVERY);
    }
    assert!(uplink.end());
    let mut spool = Spool::open(&settings.spool, settings.bounds, Clock::system().utc()).unwrap().0;
    assert!(
        matches!(&spool.read(0, 1000)[..], [link::Entry::Record(record)] if record.packet[..] == packet(1))
    );
}

/// A disk of a MiB in memory; removed when dropped. `None`, with a note, where none may be mounted.
struct SmallDisk(tempfile::TempDir);

impl SmallDisk {
    fn mount() -> Option<Self> {
        let disk = Self(tempfile::tempdir().unwrap());
        let mut mount = std::process::Command::new("mount");
        let output =
            mount.args(["-t", "tmpfs", "-o", "size=1m", "lutra"]).arg(disk.0.path()).output().unwrap();
        if output.status.success() {
            return Some(disk);
        }
        testkit::absent(testkit::Need::Mount, String::from_utf8_lossy(&output.stderr).trim());
        None
    }

    /// Fills all free space.
    fn fill(&self) {
        let path = self.0.path().join("filler");
        let mut file = std::fs::File::options().create(true).append(true).open(path).unwrap();
        while std::io::Write::write_all(&mut file, &[0; 512]).is_ok() {}
    }

    fn make_room(&self) {
        std::fs::remove_file(self.0.path().join("filler")).unwrap();
    }
}

impl Drop for SmallDisk {
    fn drop(&mut self) {
        std::process::Command::new("umount").arg("--lazy").arg(self.0.path()).status().ok();
    }
}

#[test]
fn a_full_disk_ends_the_record_but_not_what_is_live_and_says_so() {
    let Some(disk) = SmallDisk::mount() else { return };
    let (listener, port, mut shore) = shore();
    let told = Arc::new(Mutex::new(Vec::new()));
    let words = Arc::clone(&told);
    let deliver: Deliver = Box::new(move |what| {
        if let FromShore::NotSpooled(text) = what {
            words.lock().unwrap().push(text);
        }
        Ok(())
    });
    let uplink =
        Uplink::start(settings(disk.0.path(), port), ChartAboard::default(), Clock::system(), deliver)
            .unwrap();
    let queue = Arc::clone(&uplink.queue);
    uplink.record(&packet(1));
    uplink.flush();
    let (stream, _) = listener.accept().unwrap();
    let mut number = 1;
    let clock = Clock::system();
    let say = |number: u64| {
        queue.put(clock.utc(), &packet(number));
        queue.flush();
    };
    let until = Instant::now() + DEADLINE;
    let (mut filled, mut back) = (false, false);
    // Served until packets from long after the disk was full have come by the live lane, and until records come again.
    let said = std::cell::RefCell::new(|shore: &SmallShore| {
        assert!(Instant::now() < until, "live: {}, kept: {}", shore.live.len(), shore.kept.len());
        if !filled && !shore.kept.is_empty() {
            disk.fill();
            filled = true;
        }
        number += 1;
        say(number);
        let live = shore.live.iter().filter(|live| **live != packet(1)).count();
        if filled && !back && live >= 5 && !told.lock().unwrap().is_empty() {
            disk.make_room();
            back = true;
        }
        back && !shore.gaps.is_empty() && shore.kept.values().last().is_some_and(|last| !last.is_empty())
    });
    shore.serve(1, stream, |shore| (said.borrow_mut())(shore));
    assert_eq!(shore.gaps, [link::GapReason::NotRecorded]);
    let text = told.lock().unwrap()[0].clone();
    assert!(text.contains("the disk does not take the spool"), "{text}");
    drop(uplink);
}

/// The ways of these sections, or why they are refused.
fn ways(sections: &str) -> Result<Vec<Door>, String> {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("lutra.token"), "secret").unwrap();
    let text = format!(
        "[General]\nVehicle = ntnu-otter-01\n[IMC Addresses]\nntnu-otter-01 = 0x2810\n[Transports.Lutra]\nEnabled = Always\n{sections}"
    );
    let files = config::InMemory::new().with("otter.ini", text);
    let config = config::Config::load(&files, "otter.ini".as_ref(), &["Hardware"]);
    let settings =
        UplinkSettings::read(&config, &folder.path().join("otter.ini"), folder.path(), &mut Vec::new());
    settings.map(|settings| settings.unwrap().ways).map_err(|error| format!("{error:#}"))
}

#[test]
fn ways_are_what_their_sections_say() {
    let only = ways("").unwrap();
    assert_eq!((only.len(), &only[0].way.name[..], &only[0].server.host[..]), (1, "", "127.0.0.1"));
    let two = ways(
        "[Transports.LutraWay/1]\nEnabled = Always\nEntity Label = radio\nInterface = wlan5\n\
         [Transports.LutraWay/2]\nEnabled = Always\nEntity Label = 4G\nURL = ws://10.77.0.1:8080/link\n\
         Source Address = 10.77.0.11\nMetered = true\nDaily Budget = 50\n\
         [Transports.LutraWay/3]\nEnabled = Never\nEntity Label = satellite\n",
    );
    let [radio, mobile] = &two.unwrap()[..] else { panic!("two are enabled") };
    assert_eq!((&radio.way.name[..], radio.way.metered, radio.way.daily_bytes), ("radio", false, None));
    assert_eq!((radio.leaves.interface.as_deref(), radio.leaves.address), (Some("wlan5"), None));
    assert_eq!(
        (&mobile.way.name[..], mobile.way.metered, mobile.way.daily_bytes),
        ("4G", true, Some(50 << 20))
    );
    assert_eq!((&mobile.server.host[..], &mobile.server.token[..]), ("10.77.0.1", "secret"));
    assert_eq!(mobile.leaves.address, Some("10.77.0.11".parse().unwrap()));
}

#[test]
fn a_way_that_cannot_be_used_is_refused_with_its_section() {
    let way =
        |more: &str| ways(&format!("[Transports.LutraWay/4G]\nEnabled = Always\nEntity Label = 4G\n{more}"));
    for (more, wrong) in [
        ("Source Address = wwan0", "`wwan0` is not an IP address"),
        ("Interface = an-interface-too-long", "longer than a name of an interface"),
        ("Daily Budget = 5", "only a way that is `Metered`"),
        ("URL = http://x/", "ws:// or wss://"),
    ] {
        let why = way(more).unwrap_err();
        assert!(why.contains("[Transports.LutraWay/4G]") && why.contains(wrong), "{why}");
    }
    let one = |at| format!("[Transports.LutraWay/{at}]\nEnabled = Always\nEntity Label = way {at}\n");
    let many = (0..9).map(one).collect::<Vec<_>>().concat();
    assert!(ways(&many).unwrap_err().contains("at most 8"));
}
