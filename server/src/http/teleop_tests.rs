//! Steering by hand over real connections: permissions, packets to the vessel, and the audit log.

use super::testing::{Boats, FIRST, boat};
use crate::config::Config;
use crate::serve::{Serving, serve};
use api::{Role, TeleopPhase, TeleopStatus};
use futures_util::{SinkExt as _, StreamExt as _};
use imc::messages::{
    Payload as _, PlanControl, PlanControlState, PlanControlStateState, PlanControlType, RemoteActions,
    TeleoperationDone,
};
use imc::{Address, Header, Packet, PacketView};
use operations::{Holder, LeaseRequest};
use shore::clock;
use shore::identity::{audit, testing};
use std::time::Duration;
use tokio::net::TcpStream;
use tokio_tungstenite::tungstenite::Message;
use tokio_tungstenite::tungstenite::client::IntoClientRequest as _;
use tokio_tungstenite::{MaybeTlsStream, WebSocketStream, connect_async};

/// A generous time limit.
const DEADLINE: Duration = Duration::from_secs(30);

struct Shore {
    serving: Serving,
    boats: Boats,
    /// The boat reports its state until this is aborted.
    sailing: tokio::task::JoinHandle<()>,
    folder: tempfile::TempDir,
}

impl Shore {
    async fn start() -> Self {
        let folder = tempfile::tempdir().unwrap();
        let mut config = Config { data: folder.path().to_owned(), ..Config::default() };
        config.http.listen = "127.0.0.1:0".parse().unwrap();
        config.imc.active = false;
        let serving = serve(config).await.unwrap();
        let boats = Boats::join(&serving.state.shore.router).await;
        let boat_0 = boats.clone();
        let sailing = tokio::spawn(async move {
            let mut every = tokio::time::interval(Duration::from_millis(100));
            loop {
                every.tick().await;
                boat_0.say(boat(0, clock::now())).await;
            }
        });
        Self { serving, boats, sailing, folder }
    }

    /// A new person: their number and a token.
    async fn person(&self, name: &str, role: Role) -> (i64, String) {
        testing::script(self.folder.path(), name, Some(FIRST), role).await
    }

    async fn control(&self, (person, name): (i64, &str), ask: LeaseRequest) {
        let holder = Holder { person, name: name.to_owned(), key: "w".to_owned() };
        let ask = move |operations: &mut operations::Operations, now| {
            operations.leases_mut().ask(now, Address(FIRST), &holder, ask)
        };
        self.serving.state.shore.router.inspect(ask).await.unwrap().unwrap();
    }

    /// An operator with control of the vessel, which waits for teleoperation.
    async fn hands_of_anna(&self) -> Hands {
        let (anna, token) = self.person("anna", Role::Operator).await;
        self.control((anna, "anna"), LeaseRequest::Request(String::new())).await;
        let mut hands = self.connect(&token).await.unwrap();
        hands.begin().await;
        let ((), _) = tokio::join!(self.obey(), hands.until(false, |told| told.phase == TeleopPhase::Ready));
        hands
    }

    async fn connect(&self, token: &str) -> Result<Hands, String> {
        let path = format!("ws://{}/api/v1/vessels/{FIRST}/teleop", self.serving.address);
        let mut request = path.into_client_request().unwrap();
        request.headers_mut().insert("authorization", format!("Bearer {token}").parse().unwrap());
        let socket = connect_async(request).await.map_err(|error| error.to_string())?.0;
        Ok(Hands { socket, seq: 0, begun: std::time::Instant::now(), told: None })
    }

    /// Lines of the audit log about steering, in order: action, subject, outcome; without the stages of orders.
    async fn audited(&self) -> Vec<[String; 3]> {
        let entries = self
            .serving
            .state
            .shore
            .people
            .ask(audit::Entries { count: 100, ..Default::default() })
            .await
            .unwrap();
        let steering = entries.into_iter().rev().filter(|entry| entry.action.starts_with("teleop."));
        let stages =
            ["waiting", "sent", "received", "executing", "effect seen", "expired", "timed out", "refused"];
        let asked = steering.filter(|entry| !stages.iter().any(|stage| entry.outcome.starts_with(stage)));
        asked.map(|entry| [entry.action, entry.subject, entry.outcome]).collect()
    }

    /// The same, once there are `count` lines: they are written with a short delay.
    async fn audited_all(&self, count: usize) -> Vec<[String; 3]> {
        let end = tokio::time::Instant::now() + DEADLINE;
        loop {
            let log = self.audited().await;
            if log.len() >= count {
                return log;
            }
            assert!(tokio::time::Instant::now() < end, "{log:?}");
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
    }

    /// Answers the next order to begin, and reports teleoperation from then on.
    async fn obey(&self) {
        let packet = self.boats.heard(PlanControl::ID).await;
        let request: PlanControl = imc::decode(&PacketView::new(&packet).unwrap()).unwrap().unwrap();
        let say = |message: imc::Message, dst| {
            let timestamp = clock::now().seconds();
            let header = Header { src: Address(FIRST), dst, timestamp, ..Header::default() };
            vec![Packet::new(header, message).encode().unwrap().into()]
        };
        let state = PlanControlState {
            state: PlanControlStateState::Executing,
            plan_id: request.plan_id.clone(),
            ..PlanControlState::default()
        };
        let answer = PlanControl { r#type: PlanControlType::Success, ..request };
        self.boats.say(say(answer.into(), self.serving.state.shore.router.address())).await;
        self.boats.say(say(state.into(), Address(0xFFFF))).await;
    }
}

/// A window of a person who steers.
struct Hands {
    socket: WebSocketStream<MaybeTlsStream<TcpStream>>,
    seq: u64,
    begun: std::time::Instant,
    told: Option<TeleopStatus>,
}

impl Hands {
    async fn say(&mut self, text: &str) {
        self.socket.send(Message::Text(text.into())).await.unwrap();
    }

    /// Rests, or steers full ahead as soon as permitted, until the server reports the wanted status.
    async fn until(&mut self, steer: bool, wanted: impl Fn(&TeleopStatus) -> bool) -> TeleopStatus {
        let end = tokio::time::Instant::now() + DEADLINE;
        loop {
            assert!(tokio::time::Instant::now() < end, "{:?}", self.told);
            let next = tokio::time::timeout(DEADLINE, self.socket.next()).await.unwrap();
            let Some(Ok(Message::Text(text))) = next else { panic!("{next:?}") };
            let told: TeleopStatus = serde_json::from_str(&text).unwrap();
            if wanted(&told) {
                return told;
            }
            self.seq += 1;
            let (seq, stamp) = (self.seq, told.stamp_us);
            let (held, thrust) = match told.phase {
                TeleopPhase::Steering if steer => (true, 1.0),
                TeleopPhase::Ready if steer => (true, 0.0),
                _ => (false, 0.0),
            };
            let made_ms = self.begun.elapsed().as_secs_f64() * 1e3;
            let sample = format!(
                r#"{{"sample":{{"seq":{seq},"made_ms":{made_ms},"change":{seq},"stamp_us":{stamp},"stamp_held_ms":0,"held":{held},"thrust":{thrust},"turn":0}}}}"#
            );
            self.told = Some(told);
            self.say(&sample).await;
        }
    }

    async fn begin(&mut self) {
        self.until(false, |told| told.round_trip_ms.is_some()).await;
        self.say(r#"{"begin":{"window":"w"}}"#).await;
    }
}

#[tokio::test(flavor = "multi_thread")]
async fn only_who_has_control_steers_and_everything_is_written_down() {
    let shore = Shore::start().await;
    let (anna, anna_token) = shore.person("anna", Role::Operator).await;
    let (bert, _) = shore.person("bert", Role::Operator).await;
    let (_, viewer) = shore.person("vera", Role::Viewer).await;
    assert!(shore.connect(&viewer).await.err().unwrap().contains("403"));

    let mut hands = shore.connect(&anna_token).await.unwrap();
    hands.begin().await;
    let refused = hands.until(false, |told| !told.why.is_empty()).await;
    assert!(refused.why.starts_with("Not begun: ") && refused.why.contains("control"), "{refused:?}");
    assert_eq!(refused.phase, TeleopPhase::Idle);

    shore.control((anna, "anna"), LeaseRequest::Request(String::new())).await;
    hands.begin().await;
    // Samples are still sent while the vessel is asked.
    let ((), _) = tokio::join!(shore.obey(), hands.until(false, |told| told.phase == TeleopPhase::Ready));
    hands.until(true, |told| told.phase == TeleopPhase::Steering).await;
    let boats = shore.boats.clone();
    let ahead = tokio::spawn(async move {
        loop {
            let packet = boats.heard(RemoteActions::ID).await;
            let keys: RemoteActions = imc::decode(&PacketView::new(&packet).unwrap()).unwrap().unwrap();
            let text = keys.actions.to_str_lossy().into_owned();
            if text.starts_with("Port Motor=127;Starboard Motor=127;Life=") {
                return;
            }
        }
    });
    hands.until(true, |_| ahead.is_finished()).await;

    shore.control((bert, "bert"), LeaseRequest::Take("it drifts".to_owned())).await;
    let ended = hands.until(true, |told| told.phase == TeleopPhase::Idle).await;
    assert!(ended.why.contains("control of the vessel was lost"), "{ended:?}");
    assert!(ended.remedy.contains("Take control again"), "{ended:?}");
    hands.begin().await;
    let again = hands.until(true, |told| told.why.starts_with("Not begun: ")).await;
    assert!(again.why.contains("bert"), "{again:?}");

    let log = shore.audited_all(4).await;
    let is = |at: usize, action: &str, subject: &str, outcome: &str| {
        let [one, about, became] = &log[at];
        assert!(one == action && about.contains(subject) && became.contains(outcome), "{log:?}");
    };
    is(0, "teleop.begin", "", "take it first");
    is(1, "teleop.begin", "", "asked");
    is(2, "teleop.end", "control of the vessel was lost", "done");
    is(3, "teleop.begin", "", "bert");
    assert_eq!(log.len(), 4, "{log:?}");
}

#[tokio::test(flavor = "multi_thread")]
async fn what_is_no_stick_position_ends_the_conversation_and_its_end_is_written_down() {
    let shore = Shore::start().await;
    let mut hands = shore.hands_of_anna().await;
    hands.say(r#"{"sample":{"thrust":"full"}}"#).await;
    let close = tokio::time::timeout(DEADLINE, async {
        loop {
            match hands.socket.next().await {
                Some(Ok(Message::Text(_))) => {}
                other => return other,
            }
        }
    });
    let close = close.await.unwrap();
    let Some(Ok(Message::Close(Some(frame)))) = close else { panic!("{close:?}") };
    assert!(frame.reason.contains("not understood"), "{frame:?}");
    let log = shore.audited_all(2).await;
    let [action, subject, outcome] = log.last().unwrap();
    assert_eq!((action.as_str(), outcome.as_str()), ("teleop.end", "asked"), "{log:?}");
    assert!(subject.contains("not understood"), "{subject}");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_vessel_that_falls_silent_is_not_steered() {
    let shore = Shore::start().await;
    let mut hands = shore.hands_of_anna().await;
    hands.until(true, |told| told.phase == TeleopPhase::Steering).await;
    shore.sailing.abort();
    hands.until(true, |told| told.why == "the vessel is not heard").await;
}

#[tokio::test(flavor = "multi_thread")]
async fn a_vessel_without_a_link_is_stopped_and_let_go_when_control_of_it_is_lost() {
    let shore = Shore::start().await;
    let (bert, _) = shore.person("bert", Role::Operator).await;
    let mut hands = shore.hands_of_anna().await;
    hands.until(true, |told| told.phase == TeleopPhase::Steering).await;
    let (heard, mut all) = tokio::sync::watch::channel(Vec::new());
    let boats = shore.boats.clone();
    let listening = tokio::spawn(async move {
        loop {
            for packet in boats.heard_all().await {
                let view = PacketView::new(&packet).unwrap();
                let word = match imc::decode::<RemoteActions>(&view) {
                    Ok(Some(keys)) => keys.actions.to_str_lossy().into_owned(),
                    _ if view.id() == TeleoperationDone::ID => "done".to_owned(),
                    _ => continue,
                };
                heard.send_modify(|all: &mut Vec<String>| all.push(word));
            }
        }
    });
    let steers = |all: &Vec<String>| {
        all.last().is_some_and(|one| one.starts_with("Port Motor=127;Starboard Motor=127;"))
    };
    hands.until(true, |_| steers(&all.borrow())).await;
    shore.control((bert, "bert"), LeaseRequest::Take("it drifts".to_owned())).await;
    hands.until(true, |told| told.phase == TeleopPhase::Idle).await;
    // And the vessel leaves teleoperation.
    let stopped = |all: &Vec<String>| {
        all.ends_with(&["Port Motor=0;Starboard Motor=0;Stop=1".to_owned(), "done".to_owned()])
    };
    let told = tokio::time::timeout(DEADLINE, all.wait_for(stopped)).await.is_ok();
    assert!(told, "{:?}", all.borrow().last());
    listening.abort();
}

#[tokio::test(flavor = "multi_thread")]
async fn a_window_that_falls_silent_gives_the_helm_back() {
    let shore = Shore::start().await;
    let (anna, token) = shore.person("anna", Role::Operator).await;
    shore.control((anna, "anna"), LeaseRequest::Request(String::new())).await;
    let mut dead = shore.connect(&token).await.unwrap();
    dead.begin().await;
    let ((), _) = tokio::join!(shore.obey(), dead.until(false, |told| told.phase == TeleopPhase::Ready));
    let mut again = shore.connect(&token).await.unwrap();
    again.begin().await;
    let refused = again.until(false, |told| told.why.starts_with("Not begun: ")).await;
    assert!(refused.why.contains("another window"), "{refused:?}");
    // The first one is silent, and its connection is not closed either.
    let ended = async || shore.audited().await.into_iter().find(|[action, ..]| action == "teleop.end");
    let written = std::sync::atomic::AtomicBool::new(false);
    let look = async {
        while ended().await.is_none() {
            tokio::time::sleep(Duration::from_millis(20)).await;
        }
        written.store(true, std::sync::atomic::Ordering::Relaxed);
    };
    tokio::join!(look, again.until(false, |_| written.load(std::sync::atomic::Ordering::Relaxed)));
    let [_, subject, outcome] = ended().await.unwrap();
    assert!(subject.contains("nothing came from the window for 3 s") && outcome == "asked", "{subject}");
    again.begin().await;
    let ((), _) = tokio::join!(shore.obey(), again.until(false, |told| told.phase == TeleopPhase::Ready));
    drop(dead);
}
