//! The ways (network paths) to the shore: interface or source address of each, and its traffic today.

use super::server::Server;
use super::spool::write_whole;
use anyhow::Context as _;
use link::{Used, WaySettings};
use socket2::{Domain, Protocol, SockAddr, Socket, Type};
use std::fmt::Write as _;
use std::io;
use std::net::{IpAddr, SocketAddr, TcpStream};
use std::path::{Path, PathBuf};
use std::thread::JoinHandle;
use std::time::Duration;
use units::MonoTime;

/// File beside the spool with the traffic of each way.
const FILE: &str = "ways";
/// The traffic of the ways is saved this often.
const KEPT_EVERY: Duration = Duration::from_secs(10);

/// A way, and its server.
#[derive(Debug, Clone)]
pub(crate) struct Door {
    pub(crate) way: WaySettings,
    pub(crate) server: Server,
    pub(crate) leaves: Leaves,
}

/// The local end of connections; by the routing table if nothing is given.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub(crate) struct Leaves {
    /// By this interface.
    pub(crate) interface: Option<String>,
    /// From this address.
    pub(crate) address: Option<IpAddr>,
}

impl Door {
    /// The single way if no others are configured.
    pub(crate) fn only(server: Server) -> Self {
        Self { way: WaySettings::default(), server, leaves: Leaves::default() }
    }

    /// For people: `4G (wss://…)`, or the URL if the way has no name.
    pub(crate) fn called(&self) -> String {
        let url = &self.server.url;
        if self.way.name.is_empty() { url.clone() } else { format!("{} ({url})", self.way.name) }
    }
}

impl Leaves {
    /// Connects to an address of the right family.
    pub(super) fn connect(&self, to: SocketAddr, patience: Duration) -> anyhow::Result<TcpStream> {
        if *self == Self::default() {
            return Ok(TcpStream::connect_timeout(&to, patience)?);
        }
        let socket = Socket::new(Domain::for_address(to), Type::STREAM, Some(Protocol::TCP))?;
        if let Some(interface) = &self.interface {
            socket
                .bind_device(Some(interface.as_bytes()))
                .map_err(|error| no_interface(interface, &error))?;
        }
        if let Some(address) = self.address {
            let from = SockAddr::from(SocketAddr::new(address, 0));
            socket.bind(&from).with_context(|| {
                format!("Source Address: {address} is not an address of this computer now (`ip address`)")
            })?;
        }
        socket.connect_timeout(&to.into(), patience)?;
        Ok(socket.into())
    }

    /// Whether an address can be reached from the source address.
    pub(super) fn suits(&self, to: &SocketAddr) -> bool {
        self.address.is_none_or(|from| from.is_ipv4() == to.is_ipv4())
    }
}

fn no_interface(interface: &str, error: &io::Error) -> anyhow::Error {
    match error.raw_os_error() {
        // ENODEV
        Some(19) => {
            anyhow::anyhow!("Interface: there is no `{interface}` now (`ip link` shows which there are)")
        }
        // EPERM
        Some(1) => anyhow::anyhow!(
            "Interface: this kernel (older than 5.7) lets only those with the right CAP_NET_RAW choose `{interface}`: give \
             `Source Address` instead, or add `CapabilityBoundingSet=CAP_NET_RAW` and `AmbientCapabilities=CAP_NET_RAW` to the \
             agent's unit (`systemctl edit lutra-agent`)"
        ),
        _ => anyhow::anyhow!("Interface: `{interface}` cannot be used: {error}"),
    }
}

/// Loads the saved traffic of each way; zero for an unknown one.
pub(super) fn load(folder: &Path, ways: &mut [Door]) {
    let text = std::fs::read_to_string(folder.join(FILE)).unwrap_or_default();
    for line in text.lines() {
        let mut parts = line.splitn(3, ' ');
        let (Some(day), Some(bytes), Some(name)) = (parts.next(), parts.next(), parts.next()) else {
            continue;
        };
        let (Ok(day), Ok(bytes)) = (day.parse(), bytes.parse()) else { continue };
        if let Some(door) = ways.iter_mut().find(|door| door.way.name == name) {
            door.way.used = Used { day, bytes };
        }
    }
}

/// Saves the traffic of the ways, so that little of it is lost at a restart.
#[derive(Debug)]
pub(super) struct Ledger {
    folder: PathBuf,
    ways: Vec<Door>,
    /// The saved values, or those being saved; `None` after a failure.
    used: Option<Vec<Used>>,
    next: MonoTime,
    keeping: Option<Keeping>,
}

type Save = Box<dyn FnOnce() -> io::Result<()> + Send>;
type Keeping = JoinHandle<io::Result<()>>;

impl Ledger {
    /// For these ways, with their loaded traffic.
    pub(super) fn new(now: MonoTime, folder: &Path, ways: &[Door]) -> Self {
        let used = ways.iter().map(|door| door.way.used).collect();
        let (folder, ways, used) = (folder.to_owned(), ways.to_vec(), Some(used));
        Self { folder, ways, used, next: now + KEPT_EVERY, keeping: None }
    }

    /// Saves the traffic if due: periodically, and `at_end` of the program.
    ///
    /// # Errors
    /// When the last attempt failed, or no thread can be started now. It is tried again when due next.
    pub(super) fn keep(&mut self, now: MonoTime, used: Vec<Used>, at_end: bool) -> io::Result<()> {
        let spawn = |save: Save| std::thread::Builder::new().name("uplink-keep".to_owned()).spawn(save);
        self.keep_by(spawn, now, used, at_end)
    }

    fn keep_by(
        &mut self,
        spawn: impl FnOnce(Save) -> io::Result<Keeping>,
        now: MonoTime,
        used: Vec<Used>,
        at_end: bool,
    ) -> io::Result<()> {
        let is_metered = self.ways.iter().any(|door| door.way.metered);
        if !is_metered || !(at_end || now >= self.next) {
            return Ok(());
        }
        self.next = now + KEPT_EVERY;
        // An older save is still running: it must not finish last.
        if !(at_end || self.keeping.as_ref().is_none_or(Keeping::is_finished)) {
            return Ok(());
        }
        let fault = |_| Err(io::Error::other("the thread that keeps what ways carried ended by a fault"));
        let before = self.keeping.take().map_or(Ok(()), |keeping| keeping.join().unwrap_or_else(fault));
        if before.is_err() {
            self.used = None;
        }
        if self.used.as_ref() == Some(&used) {
            return before;
        }
        let (folder, ways, its) = (self.folder.clone(), self.ways.clone(), used.clone());
        let save = move || save(&folder, &ways, &its);
        if at_end {
            return save();
        }
        // A disk may be slow, and live values must not wait for it.
        self.used = None;
        self.keeping = Some(spawn(Box::new(save))?);
        self.used = Some(used);
        before
    }
}

fn save(folder: &Path, ways: &[Door], used: &[Used]) -> io::Result<()> {
    let mut text = String::new();
    for (door, used) in ways.iter().zip(used) {
        writeln!(text, "{} {} {}", used.day, used.bytes, door.way.name).ok();
    }
    write_whole(&folder.join(FILE), text.as_bytes())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn door(name: &str) -> Door {
        let server = Server::at("ws://127.0.0.1:1/link".to_owned(), "t".to_owned(), None).unwrap();
        Door { way: WaySettings { name: name.to_owned(), ..WaySettings::default() }, ..Door::only(server) }
    }

    #[test]
    fn bytes_of_the_day_return_by_the_names_of_ways() {
        let folder = tempfile::tempdir().unwrap();
        let mut ways = vec![door("5 GHz radio"), door("4G")];
        load(folder.path(), &mut ways);
        assert_eq!(ways[0].way.used, Used::default(), "nothing is known yet");
        let used = [Used { day: 20_000, bytes: 7 }, Used { day: 20_001, bytes: u64::MAX }];
        save(folder.path(), &ways, &used).unwrap();
        let mut ways = vec![door("4G"), door("satellite"), door("5 GHz radio")];
        load(folder.path(), &mut ways);
        assert_eq!([ways[0].way.used, ways[2].way.used], [used[1], used[0]]);
        assert_eq!(ways[1].way.used, Used::default());
        std::fs::write(folder.path().join(FILE), "rubbish\n1 x 4G\n\n").unwrap();
        load(folder.path(), &mut ways);
    }

    #[test]
    fn what_the_disk_did_not_take_is_kept_later_although_nothing_was_carried_since() {
        let folder = tempfile::tempdir().unwrap();
        let missing = folder.path().join("missing");
        let mut metered = door("4G");
        metered.way.metered = true;
        let mut now = MonoTime::default();
        let mut ledger = Ledger::new(now, &missing, &[metered.clone()]);
        let used = vec![Used { day: 20_000, bytes: 7 }];
        let mut keep = |ledger: &mut Ledger, has_thread: bool| {
            now = now + KEPT_EVERY;
            // The disk answers at once.
            let spawn = |save: Save| -> io::Result<Keeping> {
                if !has_thread {
                    return Err(io::Error::other("no thread"));
                }
                let thread = std::thread::spawn(save);
                while !thread.is_finished() {
                    std::thread::yield_now();
                }
                Ok(thread)
            };
            ledger.keep_by(spawn, now, used.clone(), false)
        };
        assert_eq!(keep(&mut ledger, false).unwrap_err().to_string(), "no thread");
        keep(&mut ledger, true).unwrap();
        // It reports that the folder is missing, and tries again.
        assert_eq!(keep(&mut ledger, true).unwrap_err().kind(), io::ErrorKind::NotFound);
        std::fs::create_dir(&missing).unwrap();
        assert!(keep(&mut ledger, true).is_err(), "of the time before");
        keep(&mut ledger, true).unwrap();
        let mut ways = [metered];
        load(&missing, &mut ways);
        assert_eq!(ways[0].way.used, used[0]);
    }

    #[test]
    fn a_connection_leaves_from_where_it_is_to_and_says_why_it_cannot() {
        let listener = std::net::TcpListener::bind("127.0.0.1:0").unwrap();
        let to = listener.local_addr().unwrap();
        let patience = Duration::from_secs(5);
        let from = Leaves { address: Some("127.0.0.7".parse().unwrap()), interface: None };
        assert!(from.suits(&to) && !from.suits(&"[::1]:1".parse().unwrap()));
        let tcp = from.connect(to, patience).unwrap();
        assert_eq!(tcp.local_addr().unwrap().ip(), from.address.unwrap());
        let from = Leaves { address: Some("192.0.2.77".parse().unwrap()), interface: None };
        let why = format!("{:#}", from.connect(to, patience).unwrap_err());
        assert!(why.contains("192.0.2.77 is not an address of this computer"), "{why}");
        let by = Leaves { address: None, interface: Some("wwan77".to_owned()) };
        let why = format!("{:#}", by.connect(to, patience).unwrap_err());
        assert!(why.contains("there is no `wwan77`") || why.contains("CAP_NET_RAW"), "{why}");
        let why = no_interface("wwan0", &io::Error::from_raw_os_error(1)).to_string();
        assert!(why.contains("CapabilityBoundingSet=CAP_NET_RAW") && why.contains("Source Address"), "{why}");
    }
}
