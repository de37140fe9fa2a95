//! The ways in for IMC: where they are open, who is there, whom they refused, what went wrong.

use crate::AppState;
use crate::pages::frame::{Frame, PageError, html};
use crate::pages::rows::{bytes, vessel_name};
use crate::pages::words::{t, word, worded};
use crate::web::ApiError;
use api::Vessel;
use askama::Template;
use axum::extract::State;
use axum::response::Response;
use hub::{Sources, Transport};
use link::ShoreStatus;
use shore::clock::written;
use shore::identity::Language;
use shore::router::{PeerFigures, TransportEvent, TransportRecord, Whose};
use units::UtcTime;

/// Every transport, what it is, and the key that opens it; empty for the one that is always open.
const TRANSPORTS: [(Transport, &str, &str); 4] = [
    (Transport::Link, word("Vessel link"), ""),
    (Transport::Proxy, "IMCProxy", "transports.imcproxy.listen"),
    (Transport::Udp, word("IMC node (UDP)"), "transports.udp.listen"),
    (Transport::Tcp, word("IMC nodes (TCP)"), "transports.tcp.connect"),
];

struct TransportRow {
    name: &'static str,
    /// Where it is open; empty while it is closed.
    address: String,
    /// What opens it.
    key: &'static str,
    here: usize,
    received: u64,
    refused: u64,
    lost: u64,
    refusal: String,
    error: String,
}

struct PeerRow {
    transport: &'static str,
    name: String,
    since: String,
    vessels: String,
    received: u64,
    refused: u64,
    delivered: u64,
    dropped: u64,
}

struct LinkRow {
    vessel: String,
    address: u16,
    up: bool,
    since: String,
    connections: u64,
    waiting: String,
    round_trip: String,
    clock: String,
    received: String,
}

#[derive(Template)]
#[template(path = "admin_connections.html")]
struct TransportsPage {
    frame: Frame,
    now: String,
    transports: Vec<TransportRow>,
    links: Vec<LinkRow>,
    peers: Vec<PeerRow>,
}

/// `GET /admin/connections`.
pub(in crate::pages) async fn page(
    State(state): State<AppState>,
    frame: Frame,
) -> Result<Response, PageError> {
    let known = state.shore.people.vessels();
    let peers = state.shore.router.peers().await.map_err(|_| ApiError::stopping())?;
    let (ledger, status) = (state.shore.router.ledger(), state.shore.links.status());
    let nodes = &state.config.transports.tcp.connect;
    let transports = TRANSPORTS.map(|(transport, name, key)| {
        let mut record = ledger.of(transport);
        if transport == Transport::Tcp {
            record.address = nodes.join(", ");
        }
        let of_it = || peers.iter().filter(move |peer| peer.state.peer.transport == transport);
        let here = match transport {
            // A vessel stays known when its link goes down.
            Transport::Link => status.iter().filter(|(_, status)| status.up).count(),
            _ => of_it().count(),
        };
        let received = of_it().map(|peer| peer.state.received).sum();
        transport_row((frame.language, &known), (name, key), record, here, received)
    });
    let links = status.into_iter().map(|(vessel, status)| {
        let since = ledger.link_since(vessel);
        link_row(frame.language, (vessel.0, &status), since, &known)
    });
    let links = links.collect();
    let peers = peers.into_iter().map(|peer| peer_row(frame.language, peer, &known)).collect();
    let page = TransportsPage {
        frame,
        now: written(state.shore.clock.utc()),
        transports: transports.into(),
        links,
        peers,
    };
    Ok(html(&page))
}

fn transport_row(
    (language, known): (Language, &[Vessel]),
    (name, key): (&'static str, &'static str),
    record: TransportRecord,
    here: usize,
    received: u64,
) -> TransportRow {
    let told = |happened: Option<TransportEvent>| {
        let Some(TransportEvent { at, whose, what }) = happened else { return String::new() };
        let whose = match whose {
            Whose::Vessel(address) => format!("{}: ", vessel_name(address.0, known)),
            Whose::Peer(address) => format!("{address}: "),
            Whose::Transport => String::new(),
        };
        format!("{}: {whose}{}", written(at), worded(language, &what))
    };
    let TransportRecord { address, refused, refusal, error, lost } = record;
    TransportRow {
        name,
        address,
        key,
        here,
        received,
        refused,
        lost,
        refusal: told(refusal),
        error: told(error),
    }
}

fn peer_row(language: Language, figures: PeerFigures, known: &[Vessel]) -> PeerRow {
    let PeerFigures { state, dropped } = figures;
    let vessels: Vec<String> = state.systems.iter().map(|system| vessel_name(system.0, known)).collect();
    let transport = TRANSPORTS.iter().find(|(transport, ..)| *transport == state.peer.transport);
    // A link is called by its vessel's address; people know its name.
    let name = match state.peer.sources {
        Sources::Only(ref all) if state.peer.transport == Transport::Link && all.len() == 1 => {
            t(language, "link of {vessel}").with("vessel", vessel_name(all[0].0, known)).to_string()
        }
        _ => state.peer.name,
    };
    PeerRow {
        transport: transport.map_or_else(|| state.peer.transport.name(), |(_, name, _)| name),
        name,
        since: written(state.since),
        vessels: vessels.join(", "),
        received: state.received,
        refused: state.refused,
        delivered: state.delivered,
        dropped,
    }
}

fn link_row(
    language: Language,
    (address, status): (u16, &ShoreStatus),
    since: Option<UtcTime>,
    known: &[Vessel],
) -> LinkRow {
    let seconds = status.backlog.waiting.as_secs_f64().round();
    let waiting = match status.backlog.records {
        _ if !status.up => t(language, "not known"),
        0 => t(language, "nothing"),
        1 => t(language, "1 packet, {seconds} s old").with("seconds", seconds),
        records => t(language, "{n} packets, {seconds} s old").with("n", records).with("seconds", seconds),
    };
    LinkRow {
        vessel: vessel_name(address, known),
        address,
        up: status.up,
        since: since.map_or_else(|| "—".to_owned(), written),
        connections: status.connections,
        waiting: waiting.to_string(),
        round_trip: status
            .round_trip
            .map_or_else(|| "—".to_owned(), |time| format!("{:.0} ms", time.as_secs_f64() * 1e3)),
        clock: status.clocks.map_or_else(|| "—".to_owned(), |clocks| ahead(clocks.utc_ahead_us)),
        received: bytes(status.received_bytes),
    }
}

/// How far a vessel's clock is ahead (µs), to the millisecond.
fn ahead(us: i64) -> String {
    let ms = (us as f64 / 1e3).round();
    let sign = if ms > 0.0 {
        "+"
    } else if ms < 0.0 {
        "−"
    } else {
        ""
    };
    format!("{sign}{:.3} s", ms.abs() / 1e3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_that_is_right_is_neither_ahead_nor_behind() {
        let told = [-499, 499, 1_500, -12_345_600].map(ahead);
        assert_eq!(told, ["0.000 s", "0.000 s", "+0.002 s", "−12.346 s"]);
    }

    #[test]
    fn what_went_wrong_with_a_vessel_s_link_is_told_by_its_name_and_in_the_reader_s_language() {
        let otter = Vessel { address: 0x2810, name: "otter-3".to_owned() };
        let at = UtcTime::from_micros(0);
        let event = |whose, what: api::Said| Some(TransportEvent { at, whose, what });
        let record = TransportRecord {
            error: event(Whose::Vessel(imc::Address(0x2810)), api::Said::as_is("closed by it")),
            refusal: event(
                Whose::Peer("10.0.0.7".to_owned()),
                api::say("not in transports.udp.allow").into(),
            ),
            ..TransportRecord::default()
        };
        let row = transport_row((Language::Bokmal, &[otter]), ("", ""), record, 1, 0);
        assert!(row.error.ends_with("Z: otter-3: closed by it"), "{}", row.error);
        assert!(row.refusal.ends_with("Z: 10.0.0.7: ikke i transports.udp.allow"), "{}", row.refusal);
    }

    #[test]
    fn what_a_link_that_is_down_keeps_aboard_is_not_known() {
        let up = ShoreStatus { up: true, ..ShoreStatus::default() };
        let row = link_row(Language::English, (0x2810, &up), None, &[]);
        assert_eq!(
            (row.vessel.as_str(), row.waiting.as_str(), row.clock.as_str()),
            ("0x2810", "nothing", "—")
        );
        let down = ShoreStatus::default();
        assert_eq!(link_row(Language::English, (0x2810, &down), None, &[]).waiting, "not known");
    }

    #[test]
    fn every_transport_but_the_link_has_a_key_that_is_in_the_configuration() {
        let documented: toml::Table = crate::config::DOCUMENTED.parse().unwrap();
        for (_, _, key) in TRANSPORTS.into_iter().filter(|(transport, ..)| *transport != Transport::Link) {
            let mut at = toml::Value::Table(documented.clone());
            for part in key.split('.') {
                at = at.get(part).unwrap_or_else(|| panic!("{key}")).clone();
            }
        }
    }
}
