//! `imc listen`: packets from other systems, as JSON lines.

mod udp;

use crate::net::tcp::TcpLink;
use crate::net::ws::WsLink;
use crate::net::{Deadline, Link, seconds};
use crate::outcome::Outcome;
use crate::output::Output;
use crate::pick::Pick;
use crate::report;
use crate::sink::{Flow, Sink};
use std::path::PathBuf;
use std::time::Duration;

const EXAMPLES: &str = "\
Examples:
  imc listen udp --to 127.0.0.1                      a simulated vehicle on this computer
  imc listen udp --bind 0.0.0.0 --to 10.0.10.60      a vehicle on the network
  imc listen tcp 10.0.10.60:6003 --save run1.lsf     its TCP server; also keep a log
  imc listen ws ws://10.0.10.1:9090 -m Announce      through an IMCProxy, announcements only
  imc listen tcp 127.0.0.1:6003 -m EstimatedState --count 10 | jq .fields.psi

Lines are as `imc decode` prints them; damage also tells the sender in `from`. Ctrl-C ends it.
Exit status: 0 all packets were decoded, 1 anything was damaged, 2 misuse.";

const STREAM_EXAMPLES: &str = "\
Examples:
  imc listen tcp 127.0.0.1:6003
  imc listen tcp 10.0.10.60:6003 -m GpsFix -s ntnu-otter-01 --for 60
  imc listen tcp 10.0.10.60:6003 --save run1.lsf > run1.jsonl

A DUNE sends its stream to every TCP client at once; no announcement is needed. The connection is made again \
when it is lost, unless --once is given.";

const WS_EXAMPLES: &str = "\
Examples:
  imc listen ws ws://10.0.10.1:9090
  imc listen ws ws://10.0.10.1:9090 -m EstimatedState --count 1

An IMCProxy passes on what other clients send it. A vehicle sends its telemetry only to systems that it \
knows, so nothing is heard while nobody controls it. There is no TLS. The connection is made again when it is \
lost, unless --once is given.";

/// Shortest and longest time between two attempts to connect.
const RETRY: (Duration, Duration) = (Duration::from_millis(500), Duration::from_secs(10));
/// How long to wait for bytes before looking at the clock again.
const TICK: Duration = Duration::from_secs(1);

/// Prints the packets that come from other systems.
#[derive(Debug, clap::Args)]
#[command(after_help = EXAMPLES)]
pub(crate) struct Listen {
    #[command(subcommand)]
    link: From,
}

#[derive(Debug, clap::Subcommand)]
enum From {
    Udp(udp::Udp),
    /// Connects to a TCP server such as a DUNE's
    #[command(after_help = STREAM_EXAMPLES)]
    Tcp(Stream),
    /// Connects to an IMCProxy by WebSocket
    #[command(after_help = WS_EXAMPLES)]
    Ws(WebSocket),
}

/// Which packets to show, for how long, and where to keep them.
#[derive(Debug, clap::Args)]
pub(crate) struct Show {
    #[command(flatten)]
    pick: Pick,
    /// Stop after this many packets
    #[arg(long, short = 'n', value_name = "N", value_parser = clap::value_parser!(u64).range(1..))]
    count: Option<u64>,
    /// Stop after this many seconds
    #[arg(long = "for", value_name = "SECONDS", value_parser = seconds)]
    span: Option<Duration>,
    /// Also write the packets, byte for byte as they came, to a new file
    #[arg(long, value_name = "FILE.lsf")]
    save: Option<PathBuf>,
}

#[derive(Debug, clap::Args)]
struct Stream {
    /// The server
    #[arg(value_name = "HOST:PORT")]
    address: String,
    #[command(flatten)]
    show: Show,
    /// End when the connection is lost or cannot be made, instead of trying again
    #[arg(long)]
    once: bool,
}

#[derive(Debug, clap::Args)]
struct WebSocket {
    /// The server
    #[arg(value_name = "URL")]
    url: String,
    #[command(flatten)]
    show: Show,
    /// End when the connection is lost or cannot be made, instead of trying again
    #[arg(long)]
    once: bool,
}

impl Listen {
    pub(crate) fn run(&self, out: &mut Output) -> anyhow::Result<Outcome> {
        match &self.link {
            From::Udp(udp) => udp.run(out),
            From::Tcp(tcp) => {
                let connect = || TcpLink::connect(&tcp.address);
                follow(&tcp.address, connect, &tcp.show, tcp.once, out)
            }
            From::Ws(ws) => follow(&ws.url, || WsLink::connect(&ws.url), &ws.show, ws.once, out),
        }
    }
}

impl Show {
    fn sink<'o>(&'o self, out: &'o mut Output) -> anyhow::Result<Sink<'o>> {
        let mut sink = Sink::new(out, &self.pick, self.count);
        if let Some(path) = &self.save {
            sink.save_to(path)?;
        }
        Ok(sink)
    }
}

/// Shows packets of a connection, and of the next when it is lost.
fn follow<L: Link>(
    name: &str,
    connect: impl Fn() -> anyhow::Result<L>,
    show: &Show,
    once: bool,
    out: &mut Output,
) -> anyhow::Result<Outcome> {
    let mut sink = show.sink(out)?;
    let deadline = Deadline::after(show.span);
    let mut retry = RETRY.0;
    loop {
        let problem = match connect() {
            Ok(mut link) => {
                report::note(&format!("connected to {name}"));
                retry = RETRY.0;
                match drain(&mut link, deadline, &mut sink)? {
                    Flow::Closed(reason) if !once => reason,
                    _ => return Ok(sink.outcome()),
                }
            }
            Err(error) if once => return Err(error),
            Err(error) => format!("{error:#}"),
        };
        let Some(wait) = deadline.wait(retry) else { return Ok(sink.outcome()) };
        report::note(&format!("{name}: {problem}; trying again in {:.1} s", retry.as_secs_f64()));
        std::thread::sleep(wait);
        retry = (retry * 2).min(RETRY.1);
    }
}

/// Shows packets of one connection until it is lost or no more are wanted.
fn drain(link: &mut impl Link, deadline: Deadline, sink: &mut Sink<'_>) -> anyhow::Result<Flow> {
    while let Some(wait) = deadline.wait(TICK) {
        match link.receive(wait, sink)? {
            Flow::More => {}
            flow => return Ok(flow),
        }
    }
    Ok(Flow::Done)
}
