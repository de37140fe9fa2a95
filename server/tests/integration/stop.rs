//! A stop, and control of a vessel, during faults that they must not depend on: a disk that hangs, a database locked by
//! another program, a full disk, and a client that disconnects in the middle.
//!
//! Needs root, for its own disks; prints a note where it cannot have one.

use crate::support::ashore::now_s;
use crate::support::browser::ask;
use crate::support::program::{Server, add_admin, run, until};
use crate::support::{Client, PATIENCE, packet};
use imc::messages::{
    Abort, EstimatedState, Payload as _, PlanControl, PlanControlState, PlanControlStateState, Voltage,
};
use imc::{Address, PacketView};
use std::io::Write as _;
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::Command;
use tempfile::TempDir;
use testkit::{Need, absent};

const DUNE: Address = Address(0x0801);

/// A disk in a file whose writes can be suspended, like those of a failing disk. Resumed and removed when dropped.
struct HangingDisk(TempDir);

impl HangingDisk {
    /// `None`, with a note, where none may be mounted.
    fn mount() -> Option<Self> {
        let disk = Self(TempDir::new().unwrap());
        std::fs::create_dir(disk.data()).unwrap();
        let image = disk.0.path().join("image");
        std::fs::File::create(&image).unwrap().set_len(96 << 20).unwrap();
        let steps = [
            Command::new("mkfs.ext4").arg("-q").arg(&image).output(),
            Command::new("mount").args(["-o", "loop"]).arg(&image).arg(disk.data()).output(),
        ];
        for step in steps {
            let why = match step {
                Ok(output) if output.status.success() => continue,
                Ok(output) => String::from_utf8_lossy(&output.stderr).trim().to_owned(),
                Err(error) => error.to_string(),
            };
            absent(Need::Mount, &format!("no disk that hangs can be made: {why}"));
            return None;
        }
        Some(disk)
    }

    fn data(&self) -> PathBuf {
        self.0.path().join("data")
    }

    fn freeze(&self, how: &str) -> bool {
        Command::new("fsfreeze").arg(how).arg(self.data()).status().is_ok_and(|status| status.success())
    }
}

impl Drop for HangingDisk {
    fn drop(&mut self) {
        self.freeze("--unfreeze");
        Command::new("umount").arg("--lazy").arg(self.data()).status().ok();
    }
}

/// An operator's script, with tokens that were never used.
struct Script {
    server: std::net::SocketAddr,
    token: String,
}

impl Script {
    /// For a server that does not run yet: names the vessel, so that it is known before it is heard, and makes a token.
    fn token(data: &Path) -> String {
        if run(data, &["vessel", "list"]).is_empty() {
            run(data, &["vessel", "add", "dune", &DUNE.0.to_string()]);
        }
        run(data, &["token", "create", "--person", "nils", "--role", "operator"]).trim().to_owned()
    }

    fn begin(&self, what: &str, body: &str) -> TcpStream {
        let mut stream = TcpStream::connect(self.server).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(
            stream,
            "POST /api/v1/vessels/{}/{what} HTTP/1.0\r\nhost: boat\r\nauthorization: Bearer {}\r\n\
             content-type: application/json\r\ncontent-length: {}\r\n\r\n{body}",
            DUNE.0,
            self.token,
            body.len()
        )
        .unwrap();
        stream
    }

    /// Status and body of the answer.
    fn post(&self, what: &str, body: &str) -> (u16, String) {
        let mut stream = self.begin(what, body);
        let mut answer = String::new();
        std::io::Read::read_to_string(&mut stream, &mut answer).unwrap();
        let (head, body) = answer.split_once("\r\n\r\n").unwrap();
        (head.split(' ').nth(1).unwrap().parse().unwrap(), body.to_owned())
    }
}

/// A vessel that uses the IMCProxy's transport and executes a plan.
async fn vessel(server: &Server) -> Client {
    let mut vessel = Client::connect(server.proxy).await;
    let state = PlanControlState {
        state: PlanControlStateState::Executing,
        plan_id: "survey".into(),
        ..PlanControlState::default()
    };
    vessel.say(&packet(DUNE, Address::NULL, now_s(), EstimatedState::default())).await;
    vessel.say(&packet(DUNE, Address::NULL, now_s(), state)).await;
    vessel
}

/// The next packet with this id, of the server.
async fn heard(vessel: &mut Client, id: u16) {
    while PacketView::new(&vessel.hear().await).unwrap().id() != id {}
}

/// Taking control, stopping and giving control back.
async fn control_and_stop(script: &Script, vessel: &mut Client) {
    for (what, body) in [("lease", r#"{"action":"request","window":"a"}"#), ("abort", "")] {
        let (status, answer) = script.post(what, body);
        assert_eq!(status, 200, "{what}: {answer}");
    }
    heard(vessel, Abort::ID).await;
    let (status, answer) = script.post("lease", r#"{"action":"release","window":"a"}"#);
    assert_eq!(status, 200, "{answer}");
}

/// Lines of the audit log about an action, the newest first.
fn audited(server: &Server, token: &str, action: &str) -> Vec<String> {
    let mut stream = TcpStream::connect(server.web).unwrap();
    write!(
        stream,
        "GET /api/v1/audit?count=100 HTTP/1.0\r\nhost: boat\r\nauthorization: Bearer {token}\r\n\r\n"
    )
    .unwrap();
    let mut answer = String::new();
    std::io::Read::read_to_string(&mut stream, &mut answer).unwrap();
    let body = answer.split_once("\r\n\r\n").unwrap().1;
    let entries: Vec<serde_json::Value> = serde_json::from_str(body).unwrap_or_default();
    let of = entries.iter().filter(|entry| entry["action"] == action);
    of.map(|entry| entry["outcome"].as_str().unwrap().to_owned()).collect()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_disk_that_hangs_delays_no_stop_and_what_happened_is_written_when_it_is_back() {
    let Some(disk) = HangingDisk::mount() else { return };
    let data = disk.data();
    add_admin(&data, "nils", "seven small boats");
    let (first, second) = (Script::token(&data), Script::token(&data));
    let admin = run(&data, &["token", "create", "--person", "nils", "--role", "admin"]).trim().to_owned();
    let server = Server::start(&data);
    let mut vessel = vessel(&server).await;
    until("heard", || {
        ask(server.web, "/metrics").1.contains("peers{transport=\"imcproxy\"} 1").then_some(())
    })
    .await;

    assert!(disk.freeze("--freeze"), "util-linux has fsfreeze");
    // Packets of vessels keep the recorder waiting for the disk, and the tokens' first use must be written.
    vessel.say(&packet(DUNE, Address::NULL, now_s(), Voltage { value: 12.0 })).await;
    for token in [&first, &second] {
        let script = Script { server: server.web, token: token.clone() };
        control_and_stop(&script, &mut vessel).await;
    }
    let sick = until("told", || Some(ask(server.web, "/healthz")).filter(|(status, _)| *status == 503)).await;
    assert!(sick.1.contains("has not answered for") || sick.1.contains("audit log"), "{}", sick.1);
    assert_eq!(ask(server.web, "/readyz").0, 200, "it still takes stops");

    assert!(disk.freeze("--unfreeze"));
    until("written", || {
        let outcomes = audited(&server, &admin, "vessel.abort");
        (outcomes.iter().filter(|outcome| *outcome == "asked").count() == 2
            && outcomes.iter().any(|outcome| outcome.starts_with("sent")))
        .then_some(())
    })
    .await;
    assert_eq!(audited(&server, &admin, "lease.release").len(), 2);
    until("well", || (ask(server.web, "/healthz").0 == 200).then_some(())).await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_database_that_another_program_locked_delays_no_stop() {
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    add_admin(&data, "nils", "seven small boats");
    let token = Script::token(&data);
    let server = Server::start(&data);
    let mut vessel = vessel(&server).await;
    let other = rusqlite::Connection::open(data.join("app.db")).unwrap();
    other.execute_batch("BEGIN EXCLUSIVE").unwrap();
    control_and_stop(&Script { server: server.web, token }, &mut vessel).await;
    drop(other);
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_disk_without_room_refuses_nobody() {
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    std::fs::create_dir(&data).unwrap();
    let mount = Command::new("mount").args(["-t", "tmpfs", "-o", "size=24m", "lutra"]).arg(&data).output();
    if !mount.is_ok_and(|output| output.status.success()) {
        absent(Need::Mount, "no disk can be mounted");
        return;
    }
    add_admin(&data, "nils", "seven small boats");
    let token = Script::token(&data);
    let server = Server::start(&data);
    let mut vessel = vessel(&server).await;
    let mut filler = std::fs::File::create(data.join("filler")).unwrap();
    while filler.write_all(&[0; 4096]).is_ok() {}
    // The first use of the token cannot be written.
    control_and_stop(&Script { server: server.web, token }, &mut vessel).await;
    drop(server);
    Command::new("umount").arg("--lazy").arg(&data).status().ok();
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn an_order_is_carried_out_though_its_client_leaves_in_the_middle() {
    let folder = TempDir::new().unwrap();
    let data = folder.path().join("data");
    add_admin(&data, "nils", "seven small boats");
    let token = Script::token(&data);
    let server = Server::start(&data);
    let mut vessel = vessel(&server).await;
    let script = Script { server: server.web, token };
    assert_eq!(script.post("lease", r#"{"action":"request","window":"a"}"#).0, 200);
    let commands = || {
        let stream = TcpStream::connect(server.web).unwrap();
        write!(
            &stream,
            "GET /api/v1/vessels/{}/commands HTTP/1.0\r\nhost: boat\r\nauthorization: Bearer {}\r\n\r\n",
            DUNE.0, script.token
        )
        .unwrap();
        let mut answer = String::new();
        std::io::Read::read_to_string(&mut &stream, &mut answer).unwrap();
        answer
    };
    // The audit log is blocked during the request, so that the client leaves before the order is sent.
    let other = rusqlite::Connection::open(data.join("app.db")).unwrap();
    other.execute_batch("BEGIN EXCLUSIVE").unwrap();
    let client =
        script.begin("commands", r#"{"order":{"kind":"plan.start","plan_id":"survey"},"window":"a"}"#);
    until("asked", || commands().contains("plan.start").then_some(())).await;
    drop(client);
    other.execute_batch("COMMIT").unwrap();
    heard(&mut vessel, PlanControl::ID).await;
    until("sent", || commands().contains("\"stage\":\"sent\"").then_some(())).await;
}
