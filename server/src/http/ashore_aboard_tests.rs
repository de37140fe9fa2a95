//! The same plans checked by the guard ashore and the one aboard, each end to end: a document through the API here, a
//! PlanSpecification to a brain in a simulated hull there. The server knows only what the vessel reported.

#[path = "../../../vehicle-agent/src/hull/mod.rs"]
#[allow(dead_code, reason = "the agent uses more of it")]
mod hull;
#[path = "../../../vehicle-agent/src/vehicle.rs"]
#[allow(dead_code, reason = "the agent uses more of it")]
mod vehicle;

use super::charts_tests::archipelago;
use super::testing::Boats;
use super::tests::{Shore, bearer};
use api::{PlanCheck, PlanDocument, PlanPlace, PlanSpeed, PlanStep, PlanTask, Role};
use axum::body::Body;
use axum::http::{Request, StatusCode};
use bytes::Bytes;
use charts::depth_index::ChartTrust;
use hull::Simulated;
use imc::messages::{
    Announce, EntityInfo, EntityList, EntityParameters, EstimatedState, Message, Payload as _, PlanControl,
    PlanControlOp, PlanControlType, QueryEntityParameters,
};
use imc::{Address, Header, Packet, PacketView};
use onboard::{Brain, Chart, GroundingSettings, Input, Output, Peer, Settings};
use shore::{clock, plans};
use sim::{GnssConfig, OutputForm, Vessel, VesselConfig};
use std::time::Duration;
use testkit::Numbers;
use units::{LatLon, LocalFrame, LocalPoint, Now};
use vehicle::{BrainEvent, Vehicle};

const OTTER: Address = Address(0x2810);
const CONSOLE: Address = Address(0x4001);
const PEER: Peer = Peer::Tcp(1);
/// Plans of each vessel: one as usual, one with limits and least circles of its own. All by `make test-long`.
fn plans_each() -> u32 {
    testkit::so_many(400, 5_000)
}

/// A vessel afloat in open water of the archipelago.
struct Afloat {
    vehicle: Vehicle<Simulated>,
    said: Vec<Bytes>,
    request: u16,
}

impl Afloat {
    fn new(settings: Settings) -> Self {
        let mut config = VesselConfig::at(middle().origin(), clock::now(), 7);
        config.form = OutputForm::Values;
        config.gnss = GnssConfig { rate_hz: 5, ..GnssConfig::default() }.perfect();
        config.gnss.baud = 115_200;
        let vessel = Vessel::new(&config).unwrap();
        let now = Now { mono: vessel.now(), utc: vessel.utc() };
        let brain = Brain::new(settings, now, mission::Kept::default()).unwrap();
        let mut afloat =
            Self { vehicle: Vehicle::new(Simulated::new(vessel), brain, now), said: Vec::new(), request: 0 };
        afloat.tell(Input::Connected(PEER));
        let ready = afloat.vehicle.now.mono + Duration::from_secs(15);
        while afloat.vehicle.now.mono < ready {
            let said = &mut afloat.said;
            afloat.vehicle.advance(ready, &mut |_, event| note(said, event));
        }
        afloat
    }

    fn tell(&mut self, input: Input) {
        let said = &mut self.said;
        self.vehicle.tell(input, &mut |_, event| note(said, event));
    }

    fn send(&mut self, message: impl Into<Message>) {
        let timestamp = self.vehicle.now.utc.seconds();
        let header = Header { timestamp, src: CONSOLE, dst: OTTER, ..Header::default() };
        self.tell(Input::Packet(PEER, Packet::new(header, message).encode().unwrap()));
    }

    /// All packets since the last call.
    fn heard(&mut self) -> Vec<Bytes> {
        std::mem::take(&mut self.said)
    }

    fn plan_control(&mut self, op: PlanControlOp, arg: Option<Message>) -> PlanControl {
        self.request += 1;
        self.heard();
        let request_id = self.request;
        self.send(PlanControl {
            r#type: PlanControlType::Request,
            op,
            request_id,
            plan_id: "p".into(),
            arg: arg.into(),
            ..PlanControl::default()
        });
        let heard = self.heard();
        let replies = heard.iter().filter_map(|bytes| {
            let reply: PlanControl = imc::decode(&PacketView::new(bytes).ok()?).ok()??;
            (reply.request_id == request_id && reply.r#type != PlanControlType::Request).then_some(reply)
        });
        replies.last().expect("an answer")
    }

    /// Why the vessel refuses to start a plan; `None` if it starts. No time passes, and it is stopped again.
    fn refusal(&mut self, plan: &PlanDocument) -> Option<String> {
        let specification = plans::specification(plan).unwrap();
        let reply = self.plan_control(PlanControlOp::Start, Some(specification.into()));
        if reply.r#type == PlanControlType::Failure {
            return Some(reply.info.to_str_lossy().into_owned());
        }
        self.plan_control(PlanControlOp::Stop, None);
        None
    }
}

fn note(said: &mut Vec<Bytes>, event: BrainEvent<'_>) {
    if let BrainEvent::Output(Output::Packet { bytes, .. }) = event {
        said.push(bytes.into());
    }
}

fn middle() -> LocalFrame {
    LocalFrame::new(LatLon::from_deg(63.446, 10.345).unwrap())
}

/// A place in the archipelago.
fn place(numbers: &mut Numbers, about: LocalPoint, half_m: f64) -> PlanPlace {
    let at = LocalPoint {
        north_m: about.north_m + numbers.within(-half_m, half_m),
        east_m: about.east_m + numbers.within(-half_m, half_m),
    };
    let place = middle().to_place(at);
    PlanPlace { lat_deg: place.lat_deg(), lon_deg: place.lon_deg() }
}

fn task(numbers: &mut Numbers, half_m: f64) -> PlanTask {
    let about = LocalPoint::default();
    let at = place(numbers, about, half_m);
    match (numbers.share() * 6.0) as u32 {
        0 | 1 => PlanTask::Goto { at },
        2 => {
            let count = 2 + (numbers.share() * 3.0) as usize;
            PlanTask::FollowPath { points: (0..count).map(|_| place(numbers, about, half_m)).collect() }
        }
        3 => PlanTask::StationKeeping { at, radius_m: numbers.within(3.0, 80.0), duration_s: 60 },
        4 => PlanTask::Loiter {
            at,
            radius_m: numbers.within(3.0, 80.0),
            duration_s: 60,
            clockwise: numbers.share() < 0.5,
        },
        _ => PlanTask::Rows {
            at,
            bearing_deg: numbers.within(0.0, 359.0),
            cross_angle_deg: 0.0,
            width_m: numbers.within(20.0, 80.0),
            length_m: numbers.within(20.0, 150.0),
            step_m: 10.0,
            curve_offset_m: 5,
            alternation_percent: 100,
            square_curve: numbers.share() < 0.5,
            curve_right: numbers.share() < 0.5,
        },
    }
}

fn plan(numbers: &mut Numbers) -> PlanDocument {
    let half_m = if numbers.share() < 0.6 { 120.0 } else { 500.0 };
    let count = 1 + (numbers.share() * 3.0) as usize;
    let step = |n: usize, numbers: &mut Numbers| PlanStep {
        id: format!("m{n}"),
        speed: PlanSpeed { value: 1.5, unit: api::SpeedUnit::Mps },
        task: task(numbers, half_m),
    };
    PlanDocument {
        name: "p".to_owned(),
        description: String::new(),
        vessel: Some(OTTER.0),
        repeat: numbers.share() < 0.2,
        maneuvers: (0..count).map(|n| step(n, numbers)).collect(),
    }
}

/// Lets the server hear the vessel: identity, position, and limits of its guard.
async fn introduce(boats: &Boats, afloat: &mut Afloat, shore: &Shore) {
    let of = |bytes: &&Bytes, ids: &[u16]| PacketView::new(bytes).is_ok_and(|view| ids.contains(&view.id()));
    let heard = afloat.heard();
    let known = [Announce::ID, EntityInfo::ID, EntityList::ID, EstimatedState::ID];
    boats.say(heard.iter().filter(|bytes| of(bytes, &known)).cloned().collect()).await;
    for name in ["Grounding Supervisor", "Maneuver"] {
        let name = name.into();
        afloat.send(QueryEntityParameters { name, visibility: "developer".into(), scope: "global".into() });
    }
    let told: Vec<Bytes> =
        afloat.heard().into_iter().filter(|bytes| of(&bytes, &[EntityParameters::ID])).collect();
    assert_eq!(told.len(), 2, "both parts answer");
    boats.say(told).await;
    assert!(shore.state.shore.fleet.place_now(OTTER).await.is_some());
}

async fn agree(shore: &Shore, settings: Settings, seed: u64) -> [u32; 2] {
    let token = shore.token(Some(OTTER.0), Role::Operator).await;
    let boats = Boats::join(&shore.state.shore.router).await;
    let limits = settings.guard_limits();
    let mut afloat = Afloat::new(settings);
    introduce(&boats, &mut afloat, shore).await;
    let told = shore
        .state
        .shore
        .fleet
        .guard_limits(OTTER, shore.state.shore.charts.limits())
        .await
        .expect("the vessel told them");
    assert_eq!(told, limits);
    let mut numbers = Numbers(seed);
    let mut outcomes = [0_u32; 2];
    for number in 0..plans_each() {
        if number % 5 == 0 {
            // Only a vessel that is heard is live, however slow the computer is.
            let heard = Packet::new(
                Header { timestamp: clock::now().seconds(), src: OTTER, ..Header::default() },
                imc::messages::Heartbeat,
            );
            boats.say(vec![heard.encode().unwrap().into()]).await;
        }
        let plan = plan(&mut numbers);
        let request = Request::post("/api/v1/plans/check").header("content-type", "application/json");
        let body = Body::from(serde_json::to_string(&plan).unwrap());
        let answer = shore.send(bearer(request, &token), body).await;
        assert_eq!(answer.status, StatusCode::OK, "{}", answer.body);
        let check: PlanCheck = serde_json::from_str(&answer.body).unwrap();
        assert_eq!(check.problems, [], "{plan:?}");
        let guard = check.guard.expect("there is a chart");
        let ashore = (guard.outcome == "refused").then_some(guard.text);
        let aboard = afloat.refusal(&plan);
        match (&ashore, &aboard) {
            (None, None) => {}
            (Some(ashore), Some(aboard)) => assert!(aboard.contains(ashore.as_str()), "{ashore} | {aboard}"),
            _ => panic!("{number}: ashore {ashore:?}, aboard {aboard:?}: {plan:?}"),
        }
        outcomes[usize::from(ashore.is_some())] += 1;
    }
    println!("accepted, refused: {outcomes:?}");
    outcomes
}

fn settings(shore: &Shore) -> Settings {
    let set = std::fs::read(chartdb::index_path(&shore.data().join("charts/chart.gpkg"))).unwrap();
    let grounding = GroundingSettings { chart: Chart::read("set", &set), ..GroundingSettings::default() };
    Settings { grounding, ..Settings::otter("ntnu-otter-01", OTTER) }
}

#[tokio::test(flavor = "multi_thread")]
async fn ashore_and_aboard_agree_on_ten_thousand_plans() {
    let shore = Shore::with(archipelago).await;
    let usual = Box::pin(agree(&shore, settings(&shore), 0x9E37_79B9_7F4A_7C15)).await;
    let shore = Shore::with(archipelago).await;
    let mut own = settings(&shore);
    own.grounding.limits.autonomous_m = 8.0;
    own.grounding.limits.cross_track_m = 4.0;
    own.grounding.limits.air_draught_m = None;
    own.grounding.limits.trust = ChartTrust::DepthErrors(ChartTrust::STANDARD);
    own.mission.engine.maneuver.loiter_min_radius_m = 25.0;
    own.mission.engine.maneuver.station_min_radius_m = 20.0;
    let own = Box::pin(agree(&shore, own, 77)).await;
    assert!(usual.into_iter().chain(own).all(|count| count > plans_each() / 10), "{usual:?}, {own:?}");
}
