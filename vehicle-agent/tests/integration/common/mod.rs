//! The real process and a console on a stream, for tests of the whole program.
//!
//! Nothing sleeps to let things settle: every wait is for a packet or a line, with a deadline.

pub(crate) mod devices;
pub(crate) mod receiver;

use imc::messages::*;
use imc::{Address, Deframer, Frame, Header, Packet, Payload};
use std::io::{BufRead as _, BufReader, Read as _, Write as _};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::time::{Duration, Instant};

pub(crate) const OTTER: Address = Address(0x2810);
pub(crate) const CONSOLE: Address = Address(0x4001);
pub(crate) const DEADLINE: Duration = Duration::from_secs(30);

/// The program, its folder, and the ports it chose.
pub(crate) struct Agent {
    pub(crate) child: Child,
    out: BufReader<ChildStdout>,
    pub(crate) listening: String,
    pub(crate) udp: u16,
    /// One for each server.
    pub(crate) tcp: Vec<u16>,
    pub(crate) announce: u16,
}

pub(crate) fn ini() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("etc/otter.ini")
}

pub(crate) fn program() -> Command {
    Command::new(env!("CARGO_BIN_EXE_lutra-agent"))
}

impl Agent {
    pub(crate) fn start(folder: &Path, more: &[&str]) -> Self {
        let config = folder.join("otter.ini");
        if !config.exists() {
            std::fs::copy(ini(), &config).unwrap();
        }
        Self::spawn(program().arg("run").arg(&config).arg("--quiet"), folder, more)
    }

    /// Starts it by a command that ends in the configuration.
    pub(crate) fn spawn(command: &mut Command, folder: &Path, more: &[&str]) -> Self {
        let mut child = command
            .arg("--data")
            .arg(folder)
            .args(["--bind", "127.0.0.1", "--udp-port", "0", "--tcp-port", "0", "--announce-port", "0"])
            .args(more)
            .stdout(Stdio::piped())
            .spawn()
            .unwrap();
        let mut out = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        out.read_line(&mut line).unwrap();
        let ports = |name: &str| -> Vec<u16> {
            let found = line.split_whitespace().find_map(|word| word.strip_prefix(&format!("{name}=")));
            // A transport that is off has no port.
            found.unwrap_or_else(|| panic!("{line}")).split(',').flat_map(str::parse).collect()
        };
        let port = |name: &str| ports(name).first().copied().unwrap_or(0);
        let (udp, tcp, announce) = (port("udp"), ports("tcp"), port("announce"));
        Self { child, out, listening: line, udp, tcp, announce }
    }

    /// Terminates it as an init system does; returns its last output.
    pub(crate) fn terminate(self) -> String {
        self.signal("TERM");
        self.ended()
    }

    pub(crate) fn signal(&self, name: &str) {
        let id = self.child.id().to_string();
        let sent = Command::new("kill").arg(format!("-{name}")).arg(&id).status().unwrap();
        assert!(sent.success());
    }

    /// Waits for its normal end; returns its last output.
    pub(crate) fn ended(mut self) -> String {
        let mut rest = String::new();
        self.out.read_to_string(&mut rest).unwrap();
        assert!(self.child.wait().unwrap().success());
        rest
    }
}

impl std::ops::Drop for Agent {
    fn drop(&mut self) {
        self.child.kill().ok();
        self.child.wait().ok();
    }
}

/// A console on a stream.
pub(crate) struct Console {
    pub(crate) stream: TcpStream,
    deframer: Deframer,
    beat: Instant,
    request: u16,
    pub(crate) seen: Vec<Packet>,
}

impl Console {
    pub(crate) fn connect(agent: &Agent) -> Self {
        Self::connect_to(agent.tcp[0])
    }

    pub(crate) fn connect_to(port: u16) -> Self {
        let stream = TcpStream::connect(("127.0.0.1", port)).unwrap();
        stream.set_read_timeout(Some(Duration::from_millis(200))).unwrap();
        let (deframer, seen) = (Deframer::new(), Vec::new());
        Self { stream, deframer, beat: Instant::now(), request: 0, seen }
    }

    pub(crate) fn send(&mut self, message: impl Into<Message>) {
        self.stream.write_all(&packet(message)).unwrap();
    }

    /// Reads until a packet matches.
    pub(crate) fn wait<T>(&mut self, what: &str, mut wanted: impl FnMut(&Packet) -> Option<T>) -> T {
        let until = Instant::now() + DEADLINE;
        while Instant::now() < until {
            if self.beat.elapsed() > Duration::from_millis(800) {
                self.beat = Instant::now();
                self.send(Heartbeat);
            }
            let mut buffer = [0; 8192];
            match self.stream.read(&mut buffer) {
                Ok(0) => panic!("{what}: the agent hung up"),
                Ok(length) => self.deframer.push(&buffer[..length]),
                Err(_) => {}
            }
            while let Some(frame) = self.deframer.next_frame() {
                let Frame::Packet { view, .. } = frame else { panic!("{what}: damage on the stream") };
                let packet = Packet::decode(view.bytes()).unwrap();
                if let Some(found) = wanted(&packet) {
                    return found;
                }
                self.seen.push(packet);
            }
        }
        panic!("{what}: not within {DEADLINE:?}; last: {:?}", self.seen.last());
    }

    pub(crate) fn wait_for<T: Payload + Clone>(
        &mut self,
        what: &str,
        mut wanted: impl FnMut(&T) -> bool,
    ) -> T {
        self.wait(what, |packet| packet.get::<T>().filter(|message| wanted(message)).cloned())
    }

    pub(crate) fn ready(&mut self) {
        self.wait_for::<VehicleState>("service", |state| state.op_mode == VehicleStateOpMode::Service);
    }

    pub(crate) fn ask(&mut self, op: PlanControlOp, plan_id: &str, arg: Option<Message>) -> u16 {
        self.request += 1;
        self.send(PlanControl {
            r#type: PlanControlType::Request,
            op,
            request_id: self.request,
            plan_id: plan_id.into(),
            arg: arg.into(),
            ..PlanControl::default()
        });
        self.request
    }

    pub(crate) fn start(&mut self, plan_id: &str, arg: Option<Message>) {
        let request = self.ask(PlanControlOp::Start, plan_id, arg);
        self.wait_for::<PlanControl>("executing", |reply| {
            let ours = reply.request_id == request && reply.r#type != PlanControlType::Request;
            assert!(!ours || reply.r#type == PlanControlType::Success, "{reply:?}");
            ours && reply.info.to_str_lossy().ends_with("executing maneuver")
        });
    }

    pub(crate) fn database(&mut self, op: PlanDBOp, plan_id: &str, arg: Option<Message>) -> PlanDB {
        self.request += 1;
        let request = self.request;
        self.send(PlanDB {
            r#type: PlanDBType::Request,
            op,
            request_id: request,
            plan_id: plan_id.into(),
            arg: arg.into(),
            ..PlanDB::default()
        });
        self.wait_for::<PlanDB>("plan database", |reply| {
            reply.request_id == request && matches!(reply.r#type, PlanDBType::Success | PlanDBType::Failure)
        })
    }
}

pub(crate) fn packet(message: impl Into<Message>) -> Vec<u8> {
    let since = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH).unwrap();
    let header = Header { timestamp: since.as_secs_f64(), src: CONSOLE, dst: OTTER, ..Header::default() };
    Packet::new(header, message).encode().unwrap()
}

pub(crate) fn far_plan() -> PlanSpecification {
    let goto = Goto {
        lat: 63.34_f64.to_radians(),
        lon: 10.083_333_f64.to_radians(),
        z_units: ZUnits::Depth,
        speed: 1.5,
        ..Goto::default()
    };
    let node = PlanManeuver { maneuver_id: "go".into(), data: goto.into(), ..PlanManeuver::default() };
    PlanSpecification {
        plan_id: "far".into(),
        start_man_id: "go".into(),
        maneuvers: [node].into_iter().collect(),
        ..PlanSpecification::default()
    }
}

/// All logs below a folder.
pub(crate) fn logs(folder: &Path) -> Vec<PathBuf> {
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
