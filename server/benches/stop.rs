//! How soon a stop leaves the server under various loads: `cargo bench -p server --bench stop`.
//!
//! Measured from the beginning of a script's request (its connection included) to the packet at the vessel, which
//! listens at the IMCProxy's transport. The real program runs beside its load on the same cores. LUTRA_SERVER=PROGRAM measures
//! another build, STOPS=N takes more stops than 200. Measurements with their own disk need root, and are reported as
//! skipped without it.

#![expect(clippy::unwrap_used, reason = "a benchmark ends where it unwraps nothing")]

mod support;

use imc::messages::{Abort, EstimatedState, Payload as _, Voltage};
use imc::{Address, Header};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::{Ipv4Addr, SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU32, Ordering};
use std::sync::mpsc::{Receiver, channel};
use std::thread;
use std::time::{Duration, Instant, SystemTime, UNIX_EPOCH};
use support::{connect, frame};

const VESSEL: Address = Address(0x0801);
/// How long a stop may take before it counts as never sent.
const PATIENCE: Duration = Duration::from_secs(10);

fn main() {
    let stops = std::env::var("STOPS").ok().and_then(|text| text.parse().ok()).unwrap_or(200);
    let plain = || Some(Disk::folder());
    run("idle", stops, plain(), |_| Vec::new());
    run("50 000 msg/s ingested", stops, plain(), |bench| vec![ingest(bench.proxy, 50_000, &bench.ends)]);
    run("a full disk", stops, Disk::small(), |bench| {
        bench.disk.fill();
        Vec::new()
    });
    run("a disk that hangs", stops, Disk::hanging(), |bench| {
        bench.disk.freeze("--freeze");
        vec![ingest(bench.proxy, 100, &bench.ends)]
    });
    run("200 logins/s", stops, plain(), |bench| logins(bench.web, &bench.ends));
    run("five readers that do not read, 2 000 msg/s", stops, plain(), |bench| {
        let mut load: Vec<_> = (0..5).map(|_| stalled(bench.web, &bench.token, &bench.ends)).collect();
        load.push(ingest(bench.proxy, 2_000, &bench.ends));
        load
    });
}

/// A data folder, on its own disk if requested.
struct Disk {
    folder: tempfile::TempDir,
    mounted: bool,
}

impl Disk {
    fn folder() -> Self {
        let folder = tempfile::tempdir().unwrap();
        std::fs::create_dir(folder.path().join("data")).unwrap();
        Self { folder, mounted: false }
    }

    fn mount(mut disk: Self, arguments: &[&str], what: &Path) -> Option<Self> {
        let mount = Command::new("mount").args(arguments).arg(what).arg(disk.data()).output();
        disk.mounted = mount.is_ok_and(|output| output.status.success());
        if disk.mounted {
            return Some(disk);
        }
        println!("skipped: no disk can be mounted");
        None
    }

    fn small() -> Option<Self> {
        Self::mount(Self::folder(), &["-t", "tmpfs", "-o", "size=24m"], Path::new("lutra"))
    }

    fn hanging() -> Option<Self> {
        let disk = Self::folder();
        let image = disk.folder.path().join("image");
        std::fs::File::create(&image).unwrap().set_len(96 << 20).unwrap();
        Command::new("mkfs.ext4").arg("-q").arg(&image).output().ok()?;
        Self::mount(disk, &["-o", "loop"], &image)
    }

    fn data(&self) -> PathBuf {
        self.folder.path().join("data")
    }

    fn fill(&self) {
        let mut filler = std::fs::File::create(self.data().join("filler")).unwrap();
        while filler.write_all(&[0; 4096]).is_ok() {}
    }

    fn freeze(&self, how: &str) {
        Command::new("fsfreeze").arg(how).arg(self.data()).stderr(Stdio::null()).status().ok();
    }
}

impl Drop for Disk {
    fn drop(&mut self) {
        if self.mounted {
            self.freeze("--unfreeze");
            Command::new("umount").arg("--lazy").arg(self.data()).status().ok();
        }
    }
}

struct Bench {
    server: Child,
    web: SocketAddr,
    proxy: SocketAddr,
    token: String,
    disk: Disk,
    ends: Arc<AtomicBool>,
}

type Load = Vec<thread::JoinHandle<()>>;

/// Measures stops under the load that `load` starts.
fn run(what: &str, stops: usize, disk: Option<Disk>, load: impl FnOnce(&Bench) -> Load) {
    let Some(disk) = disk else { return };
    let program =
        std::env::var("LUTRA_SERVER").unwrap_or_else(|_| env!("CARGO_BIN_EXE_lutra-server").to_owned());
    let command = |arguments: &[&str]| {
        let mut command = Command::new(&program);
        command.args(arguments).arg("--data").arg(disk.data());
        command
    };
    let mut add = command(&["user", "add", "nils", "--role", "admin", "--password-stdin"]);
    let mut child = add.stdin(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(b"seven small boats\n").unwrap();
    assert!(child.wait().unwrap().success());
    let made = command(&["token", "create", "--person", "nils", "--role", "operator"]).output().unwrap();
    let token = String::from_utf8(made.stdout).unwrap().trim().to_owned();
    let serve = ["serve", "--listen", "127.0.0.1:0", "--set", "transports.imcproxy.listen=127.0.0.1:0"];
    let mut serve = command(&serve);
    let server = serve.args(["--set", "imc.active=false"]).stdout(Stdio::piped()).stderr(Stdio::null());
    let mut server = server.spawn().unwrap();
    let mut out = BufReader::new(server.stdout.take().unwrap());
    let mut told = |prefix: &str| {
        let mut line = String::new();
        out.read_line(&mut line).unwrap();
        line.trim().strip_prefix(prefix).and_then(|address| address.parse().ok()).unwrap()
    };
    let (web, proxy) = (told("listening http://"), told("imcproxy ws://"));
    let mut bench = Bench { server, web, proxy, token, disk, ends: Arc::default() };
    let came = vessel(bench.proxy, &bench.ends);
    let load = load(&bench);
    thread::sleep(Duration::from_millis(500));
    println!("stop beside {what}: {}", measure(&bench, &came, stops));
    bench.ends.store(true, Ordering::Relaxed);
    for one in load {
        one.join().ok();
    }
    bench.disk.freeze("--unfreeze");
    bench.server.kill().ok();
    bench.server.wait().ok();
}

fn measure(bench: &Bench, came: &Receiver<Instant>, stops: usize) -> String {
    let (mut took_ms, mut never, mut refused) = (Vec::new(), 0, 0);
    for _ in 0..stops {
        while came.try_recv().is_ok() {}
        let begun = Instant::now();
        let mut stream = TcpStream::connect(bench.web).unwrap();
        write!(
            stream,
            "POST /api/v1/vessels/{}/abort HTTP/1.0\r\nhost: boat\r\nauthorization: Bearer {}\r\ncontent-length: 0\r\n\r\n",
            VESSEL.0, bench.token
        )
        .unwrap();
        match came.recv_timeout(PATIENCE) {
            Ok(at) => took_ms.push((at - begun).as_secs_f64() * 1e3),
            Err(_) => never += 1,
        }
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        let mut answer = String::new();
        stream.read_to_string(&mut answer).ok();
        refused += usize::from(!answer.starts_with("HTTP/1.0 200"));
        if never >= 5 {
            break;
        }
        thread::sleep(Duration::from_millis(10));
    }
    took_ms.sort_by(f64::total_cmp);
    let share = |share: f64| took_ms.get(((took_ms.len().max(1) - 1) as f64 * share) as usize).copied();
    let [p50, p99, most] = [0.5, 0.99, 1.0].map(|at| share(at).unwrap_or(f64::NAN));
    let count = took_ms.len();
    format!(
        "p50 {p50:.2} ms, p99 {p99:.2} ms, most {most:.1} ms ({count} came, {never} never within 10 s, {refused} without a good answer)"
    )
}

fn now_s() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs_f64()
}

/// A vessel that sends a packet each 100 ms; returns the times at which stops reached it.
fn vessel(proxy: SocketAddr, ends: &Arc<AtomicBool>) -> Receiver<Instant> {
    let mut stream = connect(proxy);
    let (mut speaker, ends) = (stream.try_clone().unwrap(), Arc::clone(ends));
    thread::spawn(move || {
        while !ends.load(Ordering::Relaxed) {
            let mut out = Vec::new();
            let header = Header { timestamp: now_s(), src: VESSEL, src_ent: 1, ..Header::default() };
            frame(&mut out, &header, &EstimatedState::default());
            if speaker.write_all(&out).is_err() {
                return;
            }
            thread::sleep(Duration::from_millis(100));
        }
    });
    let (sender, came) = channel();
    thread::spawn(move || {
        let (mut buffer, mut filled) = (vec![0; 1 << 20], 0);
        while let Ok(read @ 1..) = stream.read(&mut buffer[filled..]) {
            filled += read;
            let mut at = 0;
            while filled - at >= 4 {
                let (head, length) = match buffer[at + 1] & 0x7F {
                    126 => (4, usize::from(buffer[at + 2]) << 8 | usize::from(buffer[at + 3])),
                    short => (2, usize::from(short)),
                };
                if filled - at < head + length {
                    break;
                }
                let packet = &buffer[at + head..at + head + length];
                let id = imc::PacketView::unchecked(packet).map(|view| view.id());
                if id.is_ok_and(|id| id == Abort::ID) && sender.send(Instant::now()).is_err() {
                    return;
                }
                at += head + length;
            }
            buffer.copy_within(at..filled, 0);
            filled -= at;
        }
    });
    came
}

/// Packets at a steady rate over the IMCProxy's transport, from another system.
fn ingest(proxy: SocketAddr, per_s: u32, ends: &Arc<AtomicBool>) -> thread::JoinHandle<()> {
    let (mut stream, ends) = (connect(proxy), Arc::clone(ends));
    // Packets relayed to this client are read and dropped.
    let mut reader = stream.try_clone().unwrap();
    thread::spawn(move || std::io::copy(&mut reader, &mut std::io::sink()));
    thread::spawn(move || {
        let (begun, mut said) = (Instant::now(), 0_u32);
        while !ends.load(Ordering::Relaxed) {
            let due = (begun.elapsed().as_secs_f64() * f64::from(per_s)) as u32;
            let mut out = Vec::new();
            let (from, to) = (said, due.min(said + 1_000).max(said));
            for n in from..to {
                let timestamp = now_s() + f64::from(n % 1_000) * 1e-9;
                let header = Header { timestamp, src: Address(0x2810), src_ent: 7, ..Header::default() };
                frame(&mut out, &header, &Voltage { value: n as f32 });
            }
            said = to;
            if stream.write_all(&out).is_err() {
                return;
            }
            thread::sleep(Duration::from_millis(1));
        }
    })
}

/// Logins with wrong passwords, 200 a second, from addresses and to accounts that no limit knows yet.
fn logins(web: SocketAddr, ends: &Arc<AtomicBool>) -> Load {
    let mut page = TcpStream::connect(web).unwrap();
    write!(page, "GET /login HTTP/1.0\r\nhost: {web}\r\n\r\n").unwrap();
    let mut text = String::new();
    page.read_to_string(&mut text).unwrap();
    let cut = |from: &str, to: char| text.split_once(from).unwrap().1.split(to).next().unwrap().to_owned();
    let (cookie, csrf) = (cut("lutra_login=", ';'), cut("name=\"csrf\" value=\"", '"'));
    let count = Arc::new(AtomicU32::new(0));
    (0..40)
        .map(|_| {
            let (ends, count) = (Arc::clone(ends), Arc::clone(&count));
            let (cookie, csrf) = (cookie.clone(), csrf.clone());
            thread::spawn(move || {
                while !ends.load(Ordering::Relaxed) {
                    let n = count.fetch_add(1, Ordering::Relaxed);
                    let from = Ipv4Addr::from_bits(0x7F01_0000 + (n % 60_000));
                    let socket =
                        socket2::Socket::new(socket2::Domain::IPV4, socket2::Type::STREAM, None).unwrap();
                    socket.bind(&SocketAddr::from((from, 0)).into()).unwrap();
                    if socket.connect(&web.into()).is_ok() {
                        let mut stream = TcpStream::from(socket);
                        stream.set_read_timeout(Some(Duration::from_secs(1))).ok();
                        let body = format!("name=person{n}&password=seven+large+boats&csrf={csrf}&next=");
                        write!(
                            stream,
                            "POST /login HTTP/1.0\r\nhost: {web}\r\norigin: http://{web}\r\ncookie: lutra_login={cookie}\r\n\
                             content-type: application/x-www-form-urlencoded\r\ncontent-length: {}\r\n\r\n{body}",
                            body.len()
                        )
                        .ok();
                        stream.read_to_end(&mut Vec::new()).ok();
                    }
                    thread::sleep(Duration::from_millis(200));
                }
            })
        })
        .collect()
}

/// A viewer of the live socket that subscribes to everything and never reads.
fn stalled(web: SocketAddr, token: &str, ends: &Arc<AtomicBool>) -> thread::JoinHandle<()> {
    let mut stream = TcpStream::connect(web).unwrap();
    write!(
        stream,
        "GET /api/live HTTP/1.1\r\nHost: boat\r\nUpgrade: websocket\r\nConnection: Upgrade\r\nAuthorization: Bearer {token}\r\n\
         Sec-WebSocket-Key: dGhlIHNhbXBsZSBub25jZQ==\r\nSec-WebSocket-Version: 13\r\n\r\n"
    )
    .unwrap();
    let ask = b"{\"subscribe\":{\"every_ms\":2}}";
    let mut out = vec![0x81, 0x80 | ask.len() as u8, 0, 0, 0, 0];
    out.extend_from_slice(ask);
    stream.write_all(&out).unwrap();
    let ends = Arc::clone(ends);
    thread::spawn(move || {
        // Pings whose answers are never read.
        while !ends.load(Ordering::Relaxed) {
            if stream.write_all(&[0x89, 0x80, 0, 0, 0, 0]).is_err() {
                return;
            }
            thread::sleep(Duration::from_millis(1));
        }
    })
}
