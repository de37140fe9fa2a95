//! The real programs: a server and an agent, each in a process that can be killed, and the cable between them.

use super::{PATIENCE, packets_of};
use bytes::Bytes;
use std::fs::File;
use std::io::{BufRead as _, BufReader, Write as _};
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::process::{Child, ChildStdout, Command, Stdio};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::tcp::{OwnedReadHalf, OwnedWriteHalf};
use tokio::net::{TcpListener, TcpStream};
use tokio::sync::watch;

pub(crate) const SERVER: &str = env!("CARGO_BIN_EXE_lutra-server");
/// How often a condition is checked.
const LOOK_EVERY: std::time::Duration = std::time::Duration::from_millis(20);

/// Waits until a condition holds; panics with `what` if it does not within twice [`PATIENCE`].
pub(crate) async fn until<T>(what: &str, mut look: impl FnMut() -> Option<T>) -> T {
    let end = Instant::now() + 2 * PATIENCE;
    loop {
        if let Some(found) = look() {
            return found;
        }
        assert!(Instant::now() < end, "not {what}");
        tokio::time::sleep(LOOK_EVERY).await;
    }
}

/// Runs the server's command line on a data folder; returns its output.
pub(crate) fn run(data: &Path, arguments: &[&str]) -> String {
    let output = Command::new(SERVER).args(arguments).arg("--data").arg(data).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// A new token for the link of a vessel, which is named if it is not yet.
pub(crate) fn link_token(data: &Path, name: &str, address: &str) -> String {
    let is_new = !data.join("app.db").exists();
    if is_new || !run(data, &["vessel", "list"]).contains(name) {
        run(data, &["vessel", "add", name, address]);
    }
    run(data, &["token", "create", "--link", name]).trim().to_owned()
}

/// A person who may do everything, with a password that need not be changed.
pub(crate) fn add_admin(data: &Path, name: &str, password: &str) {
    let mut command = Command::new(SERVER);
    command.args(["user", "add", name, "--role", "admin", "--password-stdin", "--data"]).arg(data);
    let mut child = command.stdin(Stdio::piped()).stdout(Stdio::null()).spawn().unwrap();
    child.stdin.take().unwrap().write_all(format!("{password}\n").as_bytes()).unwrap();
    assert!(child.wait().unwrap().success());
}

/// A token for scripts, of the admin `nils`.
pub(crate) fn script_token(data: &Path) -> String {
    run(data, &["token", "create", "--person", "nils", "--role", "admin"]).trim().to_owned()
}

/// A process that ends with the test.
pub(crate) struct Process(pub(crate) Child);

impl Process {
    /// Kills it (SIGKILL).
    pub(crate) fn kill(&mut self) {
        self.0.kill().unwrap();
        self.0.wait().unwrap();
    }

    /// Terminates it (SIGTERM), as an init system does.
    pub(crate) fn terminate(&mut self) {
        assert!(Command::new("kill").arg(self.0.id().to_string()).status().unwrap().success());
        assert!(self.0.wait().unwrap().success());
    }

    /// Resident memory, bytes.
    pub(crate) fn resident_bytes(&self) -> u64 {
        let status = std::fs::read_to_string(format!("/proc/{}/status", self.0.id())).unwrap();
        let line = status.lines().find_map(|line| line.strip_prefix("VmRSS:")).unwrap();
        line.trim().trim_end_matches(" kB").parse::<u64>().unwrap() * 1024
    }
}

impl Drop for Process {
    fn drop(&mut self) {
        self.0.kill().ok();
        self.0.wait().ok();
    }
}

/// A server with the IMCProxy transport open.
pub(crate) struct Server {
    pub(crate) process: Process,
    pub(crate) web: SocketAddr,
    pub(crate) proxy: SocketAddr,
    log: PathBuf,
    /// Kept open, or the server could not print.
    _out: BufReader<ChildStdout>,
}

impl Server {
    /// Starts one; its log goes to a file beside the data folder.
    pub(crate) fn start(data: &Path) -> Self {
        Self::start_by(Command::new(SERVER), data, "127.0.0.1:0", &[])
    }

    /// Starts one by a command that ends in the program, on an address.
    pub(crate) fn start_by(mut command: Command, data: &Path, listen: &str, more: &[&str]) -> Self {
        let mut log = data.as_os_str().to_owned();
        log.push(".log");
        let log = PathBuf::from(log);
        let errors = File::options().create(true).append(true).open(&log).unwrap();
        let mut child = command
            .args(["serve", "--listen", listen, "--set", "transports.imcproxy.listen=127.0.0.1:0"])
            .args(["--set", "imc.active=false", "--data"])
            .arg(data)
            .args(more)
            .stdout(Stdio::piped())
            .stderr(errors)
            .spawn()
            .unwrap();
        let mut out = BufReader::new(child.stdout.take().unwrap());
        let mut told = |prefix: &str| {
            let mut line = String::new();
            out.read_line(&mut line).unwrap();
            // With a certificate it is https.
            let plain = line.trim().replace("listening https://", "listening http://");
            let address = plain.strip_prefix(prefix).map(str::parse);
            address.unwrap_or_else(|| panic!("{line:?}; {}", std::fs::read_to_string(&log).unwrap())).unwrap()
        };
        let (web, proxy) = (told("listening http://"), told("imcproxy ws://"));
        Self { process: Process(child), web, proxy, log, _out: out }
    }

    /// Everything that was logged so far, by earlier servers on the same data too.
    pub(crate) fn log(&self) -> String {
        std::fs::read_to_string(&self.log).unwrap()
    }
}

/// The program aboard, if it was built: beside the server's, as it is by `make test`.
pub(crate) fn agent_program() -> Option<PathBuf> {
    let path = Path::new(SERVER).with_file_name("lutra-agent");
    if path.exists() {
        return Some(path);
    }
    testkit::absent(testkit::Need::Agent, "cargo build -p vehicle-agent");
    None
}

/// A simulated Otter aboard its own process.
pub(crate) struct Agent {
    pub(crate) process: Process,
    /// Its port for consoles by TCP.
    pub(crate) tcp: u16,
    folder: PathBuf,
    _out: BufReader<ChildStdout>,
}

impl Agent {
    /// Starts one in a folder, with the uplink to a port of this computer.
    pub(crate) fn start(program: &Path, folder: &Path, shore: SocketAddr, token: &str) -> Self {
        Self::start_by(Command::new(program), folder, shore, token)
    }

    /// Starts one by a command that ends in the program.
    pub(crate) fn start_by(command: Command, folder: &Path, shore: SocketAddr, token: &str) -> Self {
        Self::start_with(command, folder, shore, token, "")
    }

    /// Starts one whose configuration ends with `more`.
    pub(crate) fn start_with(
        command: Command,
        folder: &Path,
        shore: SocketAddr,
        token: &str,
        more: &str,
    ) -> Self {
        Self::start_in(command, "Simulation", folder, shore, token, more)
    }

    /// Starts one with an encrypted uplink, which trusts an authority.
    pub(crate) fn start_encrypted(
        program: &Path,
        folder: &Path,
        shore: SocketAddr,
        token: &str,
        authority: &Path,
    ) -> Self {
        let link = format!("URL = wss://{shore}/link\nCertificate Authority = {}\n", authority.display());
        Self::start_by_link(Command::new(program), "Simulation", folder, token, &link)
    }

    /// The same in another profile.
    pub(crate) fn start_in(
        command: Command,
        profile: &str,
        folder: &Path,
        shore: SocketAddr,
        token: &str,
        more: &str,
    ) -> Self {
        let link = format!("URL = ws://{shore}/link\n{more}");
        Self::start_by_link(command, profile, folder, token, &link)
    }

    /// Starts one by a command that ends in the program, with these settings of its link, and what follows them.
    fn start_by_link(command: Command, profile: &str, folder: &Path, token: &str, link: &str) -> Self {
        let otter = testkit::repository().join("vehicle-agent/etc/otter.ini");
        let link = format!("\n[Transports.Lutra]\nEnabled = Always\nToken File = lutra.token\n{link}");
        let config = folder.join("otter.ini");
        std::fs::write(&config, std::fs::read_to_string(otter).unwrap() + &link).unwrap();
        std::fs::write(folder.join("lutra.token"), token).unwrap();
        Self::run(command, profile, &config, folder)
    }

    /// Starts one by a command that ends in the program, with a configuration that lies ready and this data folder.
    pub(crate) fn run(mut command: Command, profile: &str, config: &Path, folder: &Path) -> Self {
        std::fs::create_dir_all(folder).unwrap();
        let errors = File::options().create(true).append(true).open(folder.join("errors")).unwrap();
        // Whoever wants more of its log says so by the variable.
        let told = command.get_envs().any(|(name, _)| name == "LUTRA_LOG");
        let mut child = command
            .arg("run")
            .arg(config)
            .args(["--profile", profile, "--bind", "127.0.0.1"])
            .args((!told).then_some("--quiet"))
            .arg("--data")
            .arg(folder)
            .args(["--udp-port", "0", "--tcp-port", "0", "--announce-port", "0"])
            .stdout(Stdio::piped())
            .stderr(errors)
            .spawn()
            .unwrap();
        let mut out = BufReader::new(child.stdout.take().unwrap());
        let mut line = String::new();
        out.read_line(&mut line).unwrap();
        assert!(line.starts_with("listening "), "{line:?}");
        let tcp = line.split_whitespace().find_map(|word| word.strip_prefix("tcp=")?.parse().ok()).unwrap();
        Self { process: Process(child), tcp, folder: folder.to_owned(), _out: out }
    }

    /// Errors that it has logged so far.
    pub(crate) fn errors(&self) -> String {
        std::fs::read_to_string(self.folder.join("errors")).unwrap()
    }
}

/// Everything in the logs below an agent's folder, one log after the other.
pub(crate) fn logged(folder: &Path) -> Vec<Bytes> {
    let mut packets = Vec::new();
    let mut entries: Vec<PathBuf> =
        std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()).collect();
    entries.sort();
    for path in entries {
        if path.is_dir() {
            packets.extend(logged(&path));
        } else if path.ends_with("Data.lsf.gz") {
            packets.extend(packets_of(&path));
        }
    }
    packets
}

/// State of a relay.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Cable {
    Passes(SocketAddr),
    /// Carries nothing, without closing connections, as in a radio shadow.
    Silent,
    /// Connections are closed, new ones too.
    Cut,
}

/// A TCP relay to a server that can be cut, and moved to another server.
pub(crate) struct Line {
    pub(crate) address: SocketAddr,
    state: watch::Sender<Cable>,
    accepted: Arc<AtomicU64>,
    /// Bytes a second each way; 0 for no bound.
    rate: Arc<AtomicU64>,
}

impl Line {
    pub(crate) async fn to(server: SocketAddr) -> Self {
        let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
        let address = listener.local_addr().unwrap();
        let (state, watching) = watch::channel(Cable::Passes(server));
        let accepted = Arc::new(AtomicU64::new(0));
        let (count, rate) = (Arc::clone(&accepted), Arc::new(AtomicU64::new(0)));
        let bound = Arc::clone(&rate);
        tokio::spawn(async move {
            while let Ok((stream, _)) = listener.accept().await {
                count.fetch_add(1, Ordering::Relaxed);
                tokio::spawn(connect(stream, watching.clone(), Arc::clone(&bound)));
            }
        });
        Self { address, state, accepted, rate }
    }

    /// Connections accepted so far.
    pub(crate) fn accepted(&self) -> u64 {
        self.accepted.load(Ordering::Relaxed)
    }

    /// Limits the rate from here on, in each direction of each connection; 0 for no limit.
    pub(crate) fn carries(&self, bytes_per_s: u64) {
        self.rate.store(bytes_per_s, Ordering::Relaxed);
    }

    pub(crate) fn passes(&self, server: SocketAddr) {
        self.state.send_replace(Cable::Passes(server));
    }

    pub(crate) fn silent(&self) {
        self.state.send_replace(Cable::Silent);
    }

    pub(crate) fn cut(&self) {
        self.state.send_replace(Cable::Cut);
    }
}

/// Carries one connection to the server, when it can, until it is cut.
async fn connect(vessel: TcpStream, mut state: watch::Receiver<Cable>, rate: Arc<AtomicU64>) {
    let Ok(now) = state.wait_for(|state| *state != Cable::Silent).await.map(|state| *state) else { return };
    let Cable::Passes(server) = now else { return };
    let Ok(shore) = TcpStream::connect(server).await else { return };
    vessel.set_nodelay(true).unwrap();
    shore.set_nodelay(true).unwrap();
    let ((from_vessel, to_vessel), (from_shore, to_shore)) = (vessel.into_split(), shore.into_split());
    let mut cut = state.clone();
    tokio::select! {
        () = carry(from_vessel, to_shore, state.clone(), &rate) => {}
        () = carry(from_shore, to_vessel, state, &rate) => {}
        // Another server needs another connection.
        _ = cut.wait_for(|state| *state != Cable::Silent && *state != Cable::Passes(server)) => {}
    }
}

async fn carry(
    mut from: OwnedReadHalf,
    mut to: OwnedWriteHalf,
    mut state: watch::Receiver<Cable>,
    rate: &AtomicU64,
) {
    let mut buffer = vec![0; 4_096];
    loop {
        let Ok(length @ 1..) = from.read(&mut buffer).await else { return };
        if state.wait_for(|state| *state != Cable::Silent).await.is_err() {
            return;
        }
        if let Some(us) = (length as u64 * 1_000_000).checked_div(rate.load(Ordering::Relaxed)) {
            tokio::time::sleep(std::time::Duration::from_micros(us)).await;
        }
        if to.write_all(&buffer[..length]).await.is_err() {
            return;
        }
    }
}
