//! Listening by UDP, as an announced console.

use super::Show;
use crate::net::Deadline;
use crate::net::node::Node;
use crate::net::peer::Peer;
use crate::net::udp::{self, ANNOUNCE_GROUP, ANNOUNCE_PORTS, Datagram, UdpLink};
use crate::outcome::Outcome;
use crate::output::Output;
use crate::report;
use crate::sink::{Flow, Sink};
use imc::messages::Announce;
use imc::{Frame, Frames, services};
use std::net::{IpAddr, Ipv4Addr, SocketAddrV4, UdpSocket};
use std::time::{Duration, Instant};

const EXAMPLES: &str = "\
Examples:
  imc listen udp --to 127.0.0.1                      a simulated vehicle on this computer
  imc listen udp --bind 0.0.0.0 --to 10.0.10.60      a vehicle on the network
  imc listen udp --bind 0.0.0.0 --to 10.0.10.60 --save run1.lsf -m EstimatedState
  imc listen udp --bind 0.0.0.0 --multicast          who is there? announcements only

A DUNE sends telemetry only to systems it knows: those that have announced themselves and give a sign of \
life at least every 30 s. So each --to gets an Announce every 10 s (on its ports 30100 to 30104 and its data \
port) and a Heartbeat every second, from a control unit named --name with the address --id. Expect about \
five seconds until telemetry starts. Nothing is ever sent to anyone else.

Without --bind only this computer is heard. DUNE sends back what it is told: lines with your own --id as \
source are such echoes.";

const BEAT_EVERY: Duration = Duration::from_secs(1);
/// Beats from one announcement to the next.
const BEATS_PER_ANNOUNCE: u64 = 10;
/// Own ports tried after the first.
const PORTS_TRIED: u16 = 10;

/// Hears packets by UDP and keeps vehicles sending.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Udp {
    /// Vehicle to announce this console to; its data port is 6002, or what it announces, unless given.
    /// May be given several times
    #[arg(long, value_name = "HOST[:PORT]")]
    to: Vec<Peer>,
    /// Own address to listen on; 0.0.0.0 is all networks
    #[arg(long, value_name = "IP", default_value = "127.0.0.1")]
    bind: Ipv4Addr,
    /// Own port for packets; when it is taken, the next ones are tried. 0 lets the system choose
    #[arg(long, value_name = "PORT", default_value_t = 6001)]
    port: u16,
    /// Own port for announcements, instead of the first free one of 30100 to 30104
    #[arg(long, value_name = "PORT")]
    announce_port: Option<u16>,
    /// Join the group 224.0.75.69 to hear the announcements of all systems on the network
    #[arg(long)]
    multicast: bool,
    /// Let --to be a broadcast or multicast address
    #[arg(long)]
    broadcast: bool,
    #[command(flatten)]
    node: Node,
    #[command(flatten)]
    show: Show,
}

impl Udp {
    pub(crate) fn run(&self, out: &mut Output) -> anyhow::Result<Outcome> {
        let mut station = self.station()?;
        let mut sink = self.show.sink(out)?;
        let deadline = Deadline::after(self.show.span);
        if self.to.is_empty() && !self.multicast {
            report::note(
                "this console announces itself to no one: vehicles send nothing unless --to names them",
            );
        }
        while let Some(wait) = deadline.wait(station.beat()) {
            let Some(datagram) = station.link.next(wait)? else { continue };
            if station.is_own(&datagram) {
                continue;
            }
            station.learn(&datagram);
            if show(&datagram, &mut sink)? == Flow::Done {
                break;
            }
        }
        Ok(sink.outcome())
    }

    fn station(&self) -> anyhow::Result<Station<'_>> {
        let last = if self.port == 0 { 0 } else { self.port.saturating_add(PORTS_TRIED) };
        let data = udp::bind_first(self.bind, self.port..=last)?;
        data.set_broadcast(self.broadcast)?;
        let link = UdpLink::new(data)?;
        let mut contacts = Vec::new();
        for peer in &self.to {
            let to = udp::destination(peer, self.broadcast)?;
            let own = udp::own_address(self.bind, to)?;
            contacts.push(Contact { to, fixed: peer.port.is_some(), own });
        }
        let port = link.port()?;
        let announces = match self.announcements() {
            Ok(socket) => {
                let port = socket.local_addr()?.port();
                link.hear_also(socket)?;
                format!("announcements on port {port}")
            }
            Err(error) => format!("no announcements ({error:#})"),
        };
        let (bind, node) = (self.bind, self.node.id);
        report::note(&format!("listening on {bind}:{port}, {announces}; known as {:#06x}", node.0));
        Ok(Station { link, node: &self.node, port, contacts, beats: 0, due: Instant::now(), told: None })
    }

    fn announcements(&self) -> anyhow::Result<UdpSocket> {
        // A socket bound to one address would not hear the group.
        let at = if self.multicast { Ipv4Addr::UNSPECIFIED } else { self.bind };
        let socket = udp::bind_first(at, self.announce_port.map_or(ANNOUNCE_PORTS, |port| port..=port))?;
        if self.multicast {
            socket.join_multicast_v4(&ANNOUNCE_GROUP, &self.bind)?;
        }
        Ok(socket)
    }
}

fn show(datagram: &Datagram, sink: &mut Sink<'_>) -> anyhow::Result<Flow> {
    let flow = sink.datagram(&datagram.bytes, &datagram.from.to_string())?;
    sink.flush()?;
    Ok(flow)
}

/// A system that gets this console's announcements.
struct Contact {
    /// Where it hears packets.
    to: SocketAddrV4,
    /// Whether that was given, and overrides its announcements.
    fixed: bool,
    /// Our address as it sees it.
    own: Ipv4Addr,
}

/// This console on the network.
struct Station<'a> {
    link: UdpLink,
    node: &'a Node,
    port: u16,
    contacts: Vec<Contact>,
    beats: u64,
    due: Instant,
    /// The last reported send error.
    told: Option<String>,
}

impl Station<'_> {
    /// Sends due heartbeats and announcements. Returns the time until the next.
    fn beat(&mut self) -> Duration {
        let now = Instant::now();
        if now >= self.due {
            self.due = now + BEAT_EVERY;
            let trouble = self.send_signs().err().map(|error| format!("{error:#}"));
            if trouble != self.told {
                report::note(&trouble.clone().unwrap_or_else(|| "sending works again".to_owned()));
                self.told = trouble;
            }
            self.beats += 1;
        }
        self.due - now
    }

    fn send_signs(&self) -> anyhow::Result<()> {
        let mut result = Ok(());
        for contact in &self.contacts {
            if self.beats.is_multiple_of(BEATS_PER_ANNOUNCE) {
                let announce = self.node.announce(SocketAddrV4::new(contact.own, self.port))?;
                let discovery = ANNOUNCE_PORTS.map(|port| SocketAddrV4::new(*contact.to.ip(), port));
                let sent = discovery.chain([contact.to]).map(|to| self.link.send_to(&announce, to));
                result = sent.fold(result, anyhow::Result::and);
            }
            result = result.and(self.link.send_to(&self.node.heartbeat()?, contact.to));
        }
        result
    }

    /// Whether a datagram is this console's own announcement, heard on this computer.
    fn is_own(&self, datagram: &Datagram) -> bool {
        let ours = |contact: &Contact| IpAddr::V4(contact.own) == datagram.from.ip();
        datagram.from.port() == self.port && self.contacts.iter().any(ours)
    }

    /// Takes a contact's data port from its own announcement.
    fn learn(&mut self, datagram: &Datagram) {
        let IpAddr::V4(from) = datagram.from.ip() else { return };
        for frame in Frames::new(&datagram.bytes) {
            let Frame::Packet { view, .. } = frame else { continue };
            if view.src().is_ccu() {
                continue; // Another console on the vehicle's computer.
            }
            let Ok(Some(announce)) = imc::decode::<Announce>(&view) else { continue };
            let told = services::udp_socket(&announce.services.to_str_lossy(), from);
            // Any host can announce anything; packets are sent only to destinations that the user gave.
            let Some(told) = told.filter(|told| *told.ip() == from) else { continue };
            for contact in
                self.contacts.iter_mut().filter(|contact| !contact.fixed && *contact.to.ip() == from)
            {
                contact.to.set_port(told.port());
            }
        }
    }
}
