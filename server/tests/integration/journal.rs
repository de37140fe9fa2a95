//! The real programs as services: their logs come into the system's journal with fields, and are text everywhere else.
//!
//! The journal is a socket of this test where the programs see `/run/systemd/journal`. That needs a mount namespace of
//! their own, and so root.

use crate::support::program::{Agent, SERVER, Server, agent_program, link_token, until};
use std::os::unix::net::UnixDatagram;
use std::process::Command;
use tempfile::TempDir;
use testkit::{Need, absent};

/// Runs what follows as a service whose standard error is connected to the journal in `$0`.
const AS_A_SERVICE: &str = "mount -t tmpfs none /run && mkdir -p /run/systemd/journal && \
    mount --bind \"$0\" /run/systemd/journal && \
    JOURNAL_STREAM=$(stat -L -c %d:%i /proc/self/fd/2) exec \"$@\"";

struct Journal {
    folder: TempDir,
    socket: UnixDatagram,
    entries: Vec<Vec<String>>,
}

impl Journal {
    fn start() -> Self {
        let folder = TempDir::new().unwrap();
        let socket = UnixDatagram::bind(folder.path().join("socket")).unwrap();
        socket.set_nonblocking(true).unwrap();
        Self { folder, socket, entries: Vec::new() }
    }

    fn runs(&self, program: &str) -> Command {
        let mut command = Command::new("unshare");
        command.args(["--mount", "sh", "-c", AS_A_SERVICE]).arg(self.folder.path()).arg(program);
        command
    }

    /// Whether an event with all of these fields has come.
    fn has(&mut self, fields: &[&str]) -> Option<()> {
        let mut bytes = vec![0; 1 << 18];
        while let Ok(length) = self.socket.recv(&mut bytes) {
            let entry = String::from_utf8_lossy(&bytes[..length]).into_owned();
            self.entries.push(entry.lines().map(str::to_owned).collect());
        }
        let wanted = |entry: &Vec<String>| fields.iter().all(|field| entry.contains(&(*field).to_owned()));
        self.entries.iter().any(wanted).then_some(())
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn services_write_fields_into_the_journal_and_text_elsewhere() {
    let Some(program) = agent_program() else { return };
    let may = Command::new("unshare").args(["--mount", "mount", "-t", "tmpfs", "none", "/run"]).output();
    if !may.is_ok_and(|output| output.status.success()) {
        return absent(Need::Mount, "a mount namespace for a journal of this test's own cannot be made");
    }
    let (shore, aboard) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let data = shore.path().join("data");
    let token = link_token(&data, "grey-otter", "0x2810");
    let (mut ashore, mut on_board) = (Journal::start(), Journal::start());
    let mut server = Server::start_by(ashore.runs(SERVER), &data, "127.0.0.1:0", &[]);
    let mut command = on_board.runs(program.to_str().unwrap());
    command.env("LUTRA_LOG", "info");
    let mut agent = Agent::start_by(command, aboard.path(), server.web, &token);
    // By the vessel's own name, and ashore by its name in IMC and by the one that people gave it.
    until("told aboard", || {
        on_board.has(&["SYSLOG_IDENTIFIER=lutra-agent", "LUTRA_VESSEL=ntnu-otter-01", "PRIORITY=6"])
    })
    .await;
    let greets = ["SYSLOG_IDENTIFIER=lutra-server", "LUTRA_VESSEL=ntnu-otter-01", "LUTRA_VESSEL=grey-otter"];
    until("told ashore", || ashore.has(&greets)).await;
    assert_eq!((server.log(), agent.errors()), (String::new(), String::new()), "nothing is told twice");
    agent.process.terminate();
    server.process.terminate();

    // The variable alone is not enough: a program that was started by a service writes where it was told to.
    let mut inherited = Command::new(SERVER);
    inherited.env("JOURNAL_STREAM", "1:1");
    let mut server = Server::start_by(inherited, &data, "127.0.0.1:0", &[]);
    server.process.terminate();
    assert!(server.log().contains("stopping"), "{}", server.log());
}
