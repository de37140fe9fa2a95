//! A real server and a real Otter over the vessel link: whichever is killed and however the connection fails, each packet
//! is ashore once, and commands arrive or expire.

use crate::support::ashore::{
    SAID_BEFORE_S, all_that_was_logged_is_ashore, archived_bytes, every_number_came_once, newest_s, now_s,
    time_s,
};
use crate::support::program::{Agent, Line, Server, agent_program, link_token, logged, run, until};
use crate::support::{CONSOLE, Client, OTTER, PATIENCE, archived_packets, packet};
use futures_util::SinkExt as _;
use imc::PacketView;
use imc::messages::{self, Payload as _, PlanControl, PlanControlOp, PlanControlType};
use std::collections::BTreeSet;
use std::path::Path;
use std::time::Instant;
use store::{GapKind, Reader};
use tempfile::TempDir;
use tokio_tungstenite::tungstenite;
use tokio_tungstenite::tungstenite::Message as Frame;
use tokio_tungstenite::tungstenite::client::IntoClientRequest as _;

/// Waits until much more of the vessel is in the archive.
async fn until_more(what: &str, data: &Path) {
    let before = archived_bytes(data);
    until(what, || (archived_bytes(data) > before + 20_000).then_some(())).await;
}

/// Waits until the console gets live packets of the vessel.
async fn until_live(console: &mut Client) {
    let live = async {
        loop {
            let heard = console.hear().await;
            let view = PacketView::new(&heard).unwrap();
            if view.src() == OTTER && (view.timestamp() - now_s()).abs() < 2.0 {
                return;
            }
        }
    };
    tokio::time::timeout(2 * PATIENCE, live).await.unwrap();
}

/// Requests a missing plan, repeatedly until the vessel answers.
async fn ask(console: &mut Client, request_id: u16) {
    let question = PlanControl {
        r#type: PlanControlType::Request,
        op: PlanControlOp::Start,
        request_id,
        plan_id: "no such plan".into(),
        ..PlanControl::default()
    };
    let end = Instant::now() + 2 * PATIENCE;
    while Instant::now() < end {
        console.say(&packet(CONSOLE, OTTER, now_s(), question.clone())).await;
        if tokio::time::timeout(PATIENCE / 10, answered(console, request_id)).await.is_ok() {
            return;
        }
    }
    panic!("{request_id} was not answered");
}

/// Waits until the vessel has answered a request with a failure.
async fn answered(console: &mut Client, request_id: u16) {
    loop {
        let heard = console.hear().await;
        let view = PacketView::new(&heard).unwrap();
        if let Some(answer) = imc::decode::<PlanControl>(&view).unwrap()
            && (answer.request_id, view.src()) == (request_id, OTTER)
        {
            assert_eq!(answer.r#type, PlanControlType::Failure);
            return;
        }
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn whoever_is_killed_and_however_the_line_fails_each_packet_is_ashore_once() {
    let Some(program) = agent_program() else { return };
    let (shore, aboard) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let data = shore.path().join("data");
    let mut server = Server::start(&data);
    let token = link_token(&data, "otter-1", "0x2810");
    let line = Line::to(server.web).await;
    let mut agent = Agent::start(&program, aboard.path(), line.address, &token);
    until("begun", || (archived_bytes(&data) > 20_000).then_some(())).await;

    // A command of a console at another transport reaches the vessel, and the answer reaches that console.
    let mut console = Client::connect(server.proxy).await;
    until_live(&mut console).await;
    ask(&mut console, 701).await;

    // More commands than there is room for do not block the link.
    let long = messages::PlanDB { info: "x".repeat(60_000).as_str().into(), ..Default::default() };
    for n in 0..50 {
        let said_s = now_s() + f64::from(n) * 1e-6;
        console.0.feed(Frame::Binary(packet(CONSOLE, OTTER, said_s, long.clone()))).await.unwrap();
    }
    ask(&mut console, 702).await;

    // The server dies in the middle.
    server.process.kill();
    drop(console);
    let mut server = Server::start(&data);
    line.passes(server.web);
    until_more("on after the server died", &data).await;

    // Nothing passes, without any notification: the vessel drops the connection and requests another.
    let mut console = Client::connect(server.proxy).await;
    until_live(&mut console).await;
    let connections = line.accepted();
    line.silent();
    let (stick, stop) = (now_s(), now_s() + 0.001);
    let forward = messages::RemoteActions { actions: "Thrust=1".into() };
    console.say(&packet(CONSOLE, OTTER, stick, forward)).await;
    console.say(&packet(CONSOLE, OTTER, stop, messages::Abort)).await;
    until("given up by the vessel", || (line.accepted() > connections).then_some(())).await;
    until("noticed by the server", || server.log().contains("the link is down").then_some(())).await;
    line.passes(server.web);
    until_live(&mut console).await;
    ask(&mut console, 703).await;
    until_more("on after silence", &data).await;

    // Connections break and cannot be made.
    line.cut();
    let connections = line.accepted();
    until("tried again by the vessel", || (line.accepted() > connections).then_some(())).await;
    line.passes(server.web);
    until_live(&mut console).await;
    until_more("on after a cut", &data).await;

    // The vessel dies.
    agent.process.kill();
    let killed_s = now_s();
    drop(agent);
    let mut agent = Agent::start(&program, aboard.path(), line.address, &token);
    until_live(&mut console).await;
    until_more("on after the vessel died", &data).await;

    // It ends in order; its last packets arrive after its next start.
    agent.process.terminate();
    let ended_s = now_s();
    drop(agent);
    let mut agent = Agent::start(&program, aboard.path(), line.address, &token);
    until("complete", || (newest_s(&data) > ended_s + 1.0).then_some(())).await;
    agent.process.terminate();
    server.process.terminate();
    // It logs the connection errors, and the kill as seen by its spool.
    let errors = agent.errors();
    let of_spool: Vec<&str> = errors.lines().filter(|line| line.contains("spool")).collect();
    assert!(matches!(of_spool[..], [line] if line.contains("was killed")), "{errors}");

    // Every number once; one is missing, which represents the packets that the killed vessel had not spooled.
    every_number_came_once(&data, 1);
    let mut reader = Reader::open(&data).unwrap();
    let gaps = reader.gaps(None, store::TimeRange::ALL).unwrap();
    assert!(
        matches!(&gaps[..], [gap] if gap.kind == GapKind::NotRecorded && gap.reason.contains("killed")),
        "{gaps:?}"
    );
    assert!(gaps[0].from.seconds() <= killed_s + 0.1 && gaps[0].to.seconds() >= killed_s, "{gaps:?}");

    // Every packet of the vessel's logs is ashore as often, except around the kill, and after the last one that arrived.
    let (from_s, to_s) = (gaps[0].from.seconds() - SAID_BEFORE_S, gaps[0].to.seconds());
    let exempt = |said_s: f64| said_s >= ended_s - 1.0 || (from_s..to_s).contains(&said_s);
    let compared = all_that_was_logged_is_ashore(&data, aboard.path(), exempt);
    assert!(compared > 1_000 && newest_s(&data) > ended_s, "{compared} compared");

    // The stop was delivered, however late; the stick was not.
    let said = logged(aboard.path());
    let commands = |id| said.iter().filter(move |one| PacketView::new(one).unwrap().id() == id);
    let aborts = commands(messages::Abort::ID).filter(|one| time_s(one).to_bits() == stop.to_bits());
    assert_eq!(aborts.count(), 1);
    assert_eq!(commands(messages::RemoteActions::ID).count(), 0);

    // The history holds each sample once.
    let samples: u64 = reader.series(Some(OTTER)).unwrap().iter().map(|series| series.extent.count).sum();
    let ashore: BTreeSet<_> = archived_packets(&data, OTTER).into_iter().collect();
    assert_eq!(samples, ashore.len() as u64);
    println!("{} different packets of the vessel ashore, {compared} compared with its logs", ashore.len());
}

/// The transport's answer to a token.
async fn greeted(server: &Server, token: Option<&str>) -> Result<(), u16> {
    let mut request = format!("ws://{}/link", server.web).into_client_request().unwrap();
    if let Some(token) = token {
        let bearer = format!("Bearer {token}").parse().unwrap();
        request.headers_mut().insert("authorization", bearer);
    }
    match tokio_tungstenite::connect_async(request).await {
        Ok(_) => Ok(()),
        Err(tungstenite::Error::Http(response)) => Err(response.status().as_u16()),
        Err(error) => panic!("{error}"),
    }
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn only_its_own_valid_token_lets_a_vessel_in() {
    let Some(program) = agent_program() else { return };
    let shore = TempDir::new().unwrap();
    let data = shore.path().join("data");
    let server = Server::start(&data);
    let token = link_token(&data, "otter-1", "0x2810");
    let other = link_token(&data, "otter-2", "0x2811");
    let script = run(&data, &["token", "create", "--person", "admin", "--role", "admin"]);
    assert_eq!(greeted(&server, Some(&token)).await, Ok(()));
    for wrong in [None, Some("lutra_link_nonsense"), Some(&token[..token.len() - 1]), Some(script.trim())] {
        assert!(matches!(greeted(&server, wrong).await, Err(401 | 403)), "{wrong:?}");
    }

    // The token of another vessel opens the socket, but not to this vessel.
    let aboard = TempDir::new().unwrap();
    let stranger = Agent::start(&program, aboard.path(), server.web, &other);
    until("refused", || stranger.errors().contains("this token is for").then_some(())).await;
    drop(stranger);
    assert_eq!(archived_bytes(&data), 0);

    // A revoked one does not open it, and its open connection is closed.
    let agent = Agent::start(&program, aboard.path(), server.web, &token);
    until("begun", || (archived_bytes(&data) > 20_000).then_some(())).await;
    let list = run(&data, &["token", "list"]);
    let id = list.lines().find(|line| line.contains("0x2810")).unwrap().split('\t').next().unwrap();
    run(&data, &["token", "revoke", id]);
    let end = std::time::Instant::now() + crate::support::PATIENCE;
    while greeted(&server, Some(&token)).await != Err(401) {
        assert!(std::time::Instant::now() < end, "a revoked token still opens the transport");
    }
    until("shown out", || agent.errors().contains("is the token right").then_some(())).await;
}

/// A vessel that has used its link is trusted only there, from the start of the server on and while it is away.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn nobody_speaks_for_a_vessel_that_has_a_link() {
    let Some(program) = agent_program() else { return };
    let (shore, aboard) = (TempDir::new().unwrap(), TempDir::new().unwrap());
    let data = shore.path().join("data");
    let mut server = Server::start(&data);
    let token = link_token(&data, "otter-1", "0x2810");
    let line = Line::to(server.web).await;
    let mut agent = Agent::start(&program, aboard.path(), line.address, &token);
    until("begun", || (archived_bytes(&data) > 0).then_some(())).await;
    agent.process.kill();
    server.process.kill();
    let server = Server::start(&data);
    let (mut forger, mut console) =
        (Client::connect(server.proxy).await, Client::connect(server.proxy).await);
    let place = messages::EstimatedState { lat: 1.0, lon: 0.2, ..messages::EstimatedState::default() };
    forger.say(&packet(OTTER, imc::Address::NULL, now_s(), place)).await;
    let end = packet(CONSOLE, imc::Address::NULL, now_s(), messages::Heartbeat);
    forger.say(&end).await;
    assert_eq!(console.hear().await, end, "and nothing before it");
    until("told", || server.log().contains("sends as this vessel by the transport imcproxy").then_some(()))
        .await;
}
