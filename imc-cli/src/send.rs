//! `imc send`: packets to other systems.

use crate::input::Input;
use crate::json_lines::{BadLine, JsonLines, packet};
use crate::net::node::{Node, now_s};
use crate::net::peer::Peer;
use crate::net::tcp::TcpLink;
use crate::net::udp::{self, UdpLink};
use crate::net::ws::WsLink;
use crate::net::{Deadline, Link, seconds};
use crate::outcome::Outcome;
use crate::output::Output;
use crate::pick::{Pick, message_id};
use crate::report;
use crate::sink::{Flow, Sink};
use anyhow::{Context as _, anyhow, bail};
use imc::catalogue::{FieldKind, MessageDesc};
use imc::json::ReadDefaults;
use imc::{Address, Header};
use serde_json::{Map, Value, json};
use std::net::{Ipv4Addr, SocketAddrV4};
use std::path::PathBuf;
use std::time::Duration;

const EXAMPLES: &str = "\
Examples:
  imc send udp --to 10.0.10.60 --bind 0.0.0.0 --dst ntnu-otter-01 --message Abort
  imc send tcp 127.0.0.1:6003 --dst ntnu-otter-01 --message PlanControl type=REQUEST op=STOP
  imc send tcp 127.0.0.1:6003 --dst 0x2810 --message EntityList op=QUERY --wait 2 --reply EntityList
  imc send ws ws://10.0.10.1:9090 plan.json          packets from a file of JSON lines
  imc decode run1.lsf | imc send udp --now           a recording to 127.0.0.1:6002, as of now

Lines are as `imc decode` prints them and `imc encode` takes them. What a line leaves out is filled in: the \
time of sending, --src, --dst. Fields of --message that are left out hold their defaults; `imc info MESSAGE` \
lists them. A text field takes its value as it stands, any other a number, a label or JSON.

Packets go to this computer unless another destination is given; broadcast and multicast need --broadcast.
Exit status: 0 all was sent, 1 some lines could not be (each is reported) or replies were damaged, 2 misuse \
or no connection.";

const STREAM_EXAMPLES: &str = "\
Examples:
  imc send tcp 127.0.0.1:6003 --dst ntnu-otter-01 --message Abort
  imc send tcp 127.0.0.1:6003 --dst 0x2810 --message EntityList op=QUERY --wait 2 --reply EntityList
  imc send tcp 127.0.0.1:6003 lines.json";

const WS_EXAMPLES: &str = "\
Examples:
  imc send ws ws://10.0.10.1:9090 --dst ntnu-otter-01 --message Heartbeat
  imc send ws ws://10.0.10.1:9090 lines.json --wait 5";

const UDP_EXAMPLES: &str = "\
Examples:
  imc send udp --dst ntnu-otter-01 --message Abort                      to 127.0.0.1:6002
  imc send udp --bind 0.0.0.0 --to 10.0.10.60 --dst ntnu-otter-01 --message PlanControl op=STOP
  imc send udp --announce --dst 0x2810 --message EntityList op=QUERY --wait 8 --reply EntityList

A DUNE drops packets from systems that have not announced themselves, and answers to the announced address: \
--announce does that first. It may take five seconds to notice; `imc listen udp` in another terminal keeps \
the acquaintance alive.";

/// Sends packets made of JSON, or of one message on the command line.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Send {
    #[command(subcommand)]
    link: To,
}

#[derive(Debug, clap::Subcommand)]
enum To {
    /// Sends each packet as a datagram
    #[command(after_help = UDP_EXAMPLES)]
    Udp(Udp),
    /// Sends over a connection to a TCP server such as a DUNE's
    #[command(after_help = STREAM_EXAMPLES)]
    Tcp(Stream),
    /// Sends over a WebSocket connection to an IMCProxy
    #[command(after_help = WS_EXAMPLES)]
    Ws(WebSocket),
}

#[derive(Debug, clap::Args)]
struct Udp {
    /// Where to send; port 6002 unless given. May be given several times
    #[arg(long, value_name = "HOST[:PORT]", default_value = "127.0.0.1")]
    to: Vec<Peer>,
    /// Own address to send from; 0.0.0.0 lets the system choose
    #[arg(long, value_name = "IP", default_value = "127.0.0.1")]
    bind: Ipv4Addr,
    /// Own port; 0 lets the system choose
    #[arg(long, value_name = "PORT", default_value_t = 0)]
    port: u16,
    /// Let --to be a broadcast or multicast address
    #[arg(long)]
    broadcast: bool,
    /// First announce this console, as --src and --name, so that vehicles listen and answer
    #[arg(long)]
    announce: bool,
    /// Name to be known by with --announce
    #[arg(long, value_name = "NAME", default_value = "imc-cli")]
    name: String,
    #[command(flatten)]
    say: Say,
}

#[derive(Debug, clap::Args)]
struct Stream {
    /// The server
    #[arg(value_name = "HOST:PORT")]
    address: String,
    #[command(flatten)]
    say: Say,
}

#[derive(Debug, clap::Args)]
struct WebSocket {
    /// The server
    #[arg(value_name = "URL")]
    url: String,
    #[command(flatten)]
    say: Say,
}

/// What to send, and what to do with the answers.
#[derive(Debug, clap::Args)]
struct Say {
    /// JSON, one packet a line
    #[arg(value_name = "FILE", default_value = "-", conflicts_with = "message")]
    file: PathBuf,
    /// Send this one message, with these fields
    #[arg(long, short = 'm', num_args = 1.., value_names = ["MESSAGE", "FIELD=VALUE"])]
    message: Vec<String>,
    /// Source of packets that do not give one
    #[arg(long, value_name = "SYSTEM", default_value = "0x4001")]
    src: Address,
    /// Source entity of packets that do not give one
    #[arg(long, value_name = "N", default_value_t = 0)]
    src_ent: u8,
    /// Destination of packets that do not give one; everyone unless given
    #[arg(long, value_name = "SYSTEM", default_value = "0xffff", hide_default_value = true)]
    dst: Address,
    /// Destination entity of packets that do not give one
    #[arg(long, value_name = "N", default_value_t = 255)]
    dst_ent: u8,
    /// Give every packet the time of sending, also those that have a time
    #[arg(long)]
    now: bool,
    /// Then print what comes back for this long
    #[arg(long, value_name = "SECONDS", value_parser = seconds)]
    wait: Option<Duration>,
    /// Of what comes back, print only this message; may be given several times
    #[arg(long, value_name = "MESSAGE", value_parser = message_id, requires = "wait")]
    reply: Vec<u16>,
}

impl Send {
    pub(crate) fn run(&self, out: &mut Output) -> anyhow::Result<Outcome> {
        match &self.link {
            To::Udp(udp) => udp.say.over(|| udp.link(), out),
            To::Tcp(tcp) => tcp.say.over(|| TcpLink::connect(&tcp.address), out),
            To::Ws(ws) => ws.say.over(|| WsLink::connect(&ws.url), out),
        }
    }
}

impl Udp {
    fn link(&self) -> anyhow::Result<UdpLink> {
        let socket = udp::bind_first(self.bind, self.port..=self.port)?;
        socket.set_broadcast(self.broadcast)?;
        let mut link = UdpLink::new(socket)?;
        for peer in &self.to {
            let to = udp::destination(peer, self.broadcast)?;
            let own = udp::own_address(self.bind, to)?;
            link.add_destination(to);
            if self.announce {
                let announce =
                    Node::new(self.say.src, &self.name).announce(SocketAddrV4::new(own, link.port()?))?;
                for port in udp::ANNOUNCE_PORTS.chain([to.port()]) {
                    link.send_to(&announce, SocketAddrV4::new(*to.ip(), port))?;
                }
            }
        }
        Ok(link)
    }
}

impl Say {
    /// Sends everything and waits for the answers.
    fn over<L: Link>(
        &self,
        connect: impl FnOnce() -> anyhow::Result<L>,
        out: &mut Output,
    ) -> anyhow::Result<Outcome> {
        // Packets are checked before a connection is made.
        if let Some((message, fields)) = self.message.split_first() {
            let mut value = one_message(message, fields)?;
            let place = |problem| anyhow!("--message {message}: {problem}");
            let bytes = self.packet(&mut value).map_err(place)?;
            let mut link = connect()?;
            link.send(&bytes)?;
            return self.answers(&mut link, true, out);
        }
        let mut lines = JsonLines::new(Input::open(&self.file)?);
        let mut link = connect()?;
        let mut all_sent = true;
        while let Some(result) = lines.next(|value| self.packet(value))? {
            match result {
                Ok(bytes) => link.send(&bytes)?,
                Err(BadLine(problem)) => {
                    all_sent = false;
                    report::note(&format!("{problem} (not sent)"));
                }
            }
        }
        self.answers(&mut link, all_sent, out)
    }

    /// The bytes of a packet, completed by the flags.
    fn packet(&self, value: &mut Value) -> Result<Vec<u8>, String> {
        let header = Header {
            timestamp: now_s(),
            src: self.src,
            src_ent: self.src_ent,
            dst: self.dst,
            dst_ent: self.dst_ent,
        };
        if self.now
            && let Some(header) = value.get_mut("header").and_then(Value::as_object_mut)
        {
            header.remove("timestamp");
        }
        packet(value, &ReadDefaults { header, order: None })
    }

    fn answers(&self, link: &mut impl Link, all_sent: bool, out: &mut Output) -> anyhow::Result<Outcome> {
        let pick = Pick { messages: self.reply.clone(), ..Pick::default() };
        let mut sink = Sink::new(out, &pick, None);
        if let Some(span) = self.wait {
            let deadline = Deadline::after(Some(span));
            while let Some(wait) = deadline.wait(span) {
                if let Flow::Closed(reason) = link.receive(wait, &mut sink)? {
                    report::note(&reason);
                    break;
                }
            }
        }
        link.close();
        Ok(if all_sent { sink.outcome() } else { Outcome::Damaged })
    }
}

/// The JSON of a message given as `MESSAGE FIELD=VALUE ...`.
fn one_message(message: &str, fields: &[String]) -> anyhow::Result<Value> {
    let desc = tables::message(message)?;
    let mut object = Map::new();
    for pair in fields {
        let (name, text) = pair
            .split_once('=')
            .with_context(|| format!("`{pair}`: expected FIELD=VALUE after --message {message}"))?;
        let field = desc.fields.iter().find(|field| field.abbrev.eq_ignore_ascii_case(name));
        let field = field.ok_or_else(|| unknown_field(desc, name))?;
        let value = match field.kind {
            FieldKind::Text | FieldKind::Raw => Value::from(text),
            FieldKind::Message | FieldKind::List => {
                serde_json::from_str(text).with_context(|| format!("`{pair}`: expected JSON"))?
            }
            _ => text.parse().map_or_else(|_| Value::from(text), Value::Number),
        };
        if object.insert(field.abbrev.to_owned(), value).is_some() {
            bail!("`{pair}`: {} is given twice", field.abbrev);
        }
    }
    Ok(json!({"abbrev": desc.abbrev, "fields": object}))
}

fn unknown_field(desc: &MessageDesc, name: &str) -> anyhow::Error {
    if desc.fields.is_empty() {
        return anyhow!("{} has no fields, so no `{name}`", desc.abbrev);
    }
    let names: Vec<&str> = desc.fields.iter().map(|field| field.abbrev).collect();
    anyhow!("{} has no field `{name}`; it has {}", desc.abbrev, names.join(", "))
}
