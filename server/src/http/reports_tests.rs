//! Reports of vessels on request: permissions, stored reports, and the audit of parameters.

use super::testing::{Boats, FIRST, boat, packet};
use super::tests::{Shore, bearer};
use api::{PlanUnderWay, Role, VesselParameters, VesselQuerySent};
use axum::body::Body;
use axum::http::{Request, StatusCode};
use imc::PacketView;
use imc::messages::{
    EntityParameter, EntityParameters, Goto, Payload as _, PlanControlState, PlanControlStateState,
    PlanManeuver, PlanSpecification, QueryEntityParameters, SetEntityParameters, SpeedUnits,
};
use serde_json::{Value, json};
use shore::clock;

async fn post(shore: &Shore, what: &str, token: &str, body: &Value) -> (StatusCode, Value) {
    let request = Request::post(format!("/api/v1/vessels/{FIRST}/{what}"));
    let request = bearer(request, token).header("content-type", "application/json");
    let answer = shore.send(request, Body::from(body.to_string())).await;
    (answer.status, serde_json::from_str(&answer.body).unwrap())
}

async fn get<T: serde::de::DeserializeOwned>(shore: &Shore, what: &str, token: &str) -> T {
    let answer = shore.get(&format!("/api/v1/vessels/{FIRST}/{what}"), token).await;
    assert_eq!(answer.status, StatusCode::OK, "{}", answer.body);
    serde_json::from_str(&answer.body).unwrap()
}

fn told(values: &[(&str, &str)]) -> EntityParameters {
    let one = |(name, value): &(&str, &str)| EntityParameter { name: (*name).into(), value: (*value).into() };
    EntityParameters { name: "Navigation".into(), params: values.iter().map(one).collect() }
}

#[tokio::test]
async fn a_viewer_asks_and_reads_and_only_the_one_in_control_writes() {
    let shore = Shore::with(|_| ()).await;
    let viewer = shore.token(Some(FIRST), Role::Viewer).await;
    let elsewhere = shore.token(Some(FIRST + 1), Role::Operator).await;
    let operator = shore.token(Some(FIRST), Role::Operator).await;
    let ask = json!({"about": "parameters", "entities": ["Navigation"]});
    let (status, none) = post(&shore, "ask", &viewer, &ask).await;
    assert_eq!((status, none["error"]["code"].as_str()), (StatusCode::NOT_FOUND, Some("not_found")));
    let boats = Boats::join(&shore.state.shore.router).await;
    boats.say(boat(0, clock::now())).await;

    assert_eq!(post(&shore, "ask", &elsewhere, &ask).await.0, StatusCode::FORBIDDEN);
    let (status, asked) = post(&shore, "ask", &viewer, &ask).await;
    assert_eq!(status, StatusCode::OK, "{asked}");
    let asked: VesselQuerySent = serde_json::from_value(asked).unwrap();
    assert!(asked.reached && asked.packets == 1 && asked.entities == ["Navigation"]);
    let question = boats.heard(QueryEntityParameters::ID).await;
    let question: QueryEntityParameters = imc::decode(&PacketView::new(&question).unwrap()).unwrap().unwrap();
    assert_eq!(
        (question.name.as_str(), question.visibility.as_str()),
        (Some("Navigation"), Some("developer"))
    );
    // Repeated: the answer may be on its way, so nothing is sent.
    assert_eq!(post(&shore, "ask", &operator, &ask).await.1["packets"], 0);
    let unknown = json!({"about": "parameters", "entities": ["<b>x</b>"]});
    let (status, refused) = post(&shore, "ask", &viewer, &unknown).await;
    assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY);
    assert!(refused["error"]["text"].as_str().unwrap().contains("has no entity"), "{refused}");

    // Hostile names and values are data.
    let hostile = "<img src=x onerror=alert(1)>";
    let long = "y".repeat(50_000);
    let values = [("Origin Distance", "10"), ("Origin Distance - Saved", "9"), (hostile, long.as_str())];
    boats.say(vec![packet(0, 1, clock::now(), told(&values))]).await;
    let read: VesselParameters = get(&shore, "parameters", &viewer).await;
    let [entity] = &read.entities[..] else { panic!("{read:?}") };
    let [first, second] = &entity.parameters[..] else { panic!("{read:?}") };
    assert_eq!((first.name.as_str(), first.value.len(), first.cut), (hostile, 1_000, true));
    assert!(first.about.is_none(), "Lutra has no such parameter");
    assert_eq!((second.value.as_str(), second.saved.as_deref()), ("10", Some("9")));

    // Writing takes the role and control; the audit log has old and new value of each parameter.
    let set = json!({"order": {"kind": "parameters.set", "entity": "Navigation",
        "values": [{"name": "Origin Distance", "value": "11"}, {"name": "Other", "value": "z"}]}, "window": "a"});
    assert_eq!(post(&shore, "commands", &viewer, &set).await.0, StatusCode::FORBIDDEN);
    assert_eq!(post(&shore, "commands", &operator, &set).await.0, StatusCode::CONFLICT);
    let request = json!({"action": "request", "window": "a"});
    assert_eq!(post(&shore, "lease", &operator, &request).await.0, StatusCode::OK);
    let (status, command) = post(&shore, "commands", &operator, &set).await;
    assert_eq!(status, StatusCode::ACCEPTED, "{command}");
    boats.heard(SetEntityParameters::ID).await;
    let written = shore.audit().await;
    let of = |outcome: &str| -> Vec<String> {
        let set = written.iter().rev().filter(|one| one.action == "parameters.set");
        set.filter(|one| one.outcome.starts_with(outcome)).map(|one| one.subject.clone()).collect()
    };
    let id = command["id"].as_u64().unwrap();
    let both = ["Origin Distance 10 -> 11", "Other ? -> z"]
        .map(|set| format!("0x0814 Navigation: {set} [command {id}]"));
    assert_eq!(of("asked"), both);
    assert_eq!(of("You do not have control").len(), 2, "{written:?}");
}

#[tokio::test]
async fn after_a_restart_the_history_tells_the_last_known_values() {
    let shore = Shore::with(|data| {
        let mut store = store::Store::open(data).unwrap();
        for (ago_s, value) in [(20, "8"), (10, "9")] {
            let then = units::UtcTime::from_micros(clock::now().micros() - ago_s * 1_000_000);
            let packet =
                packet(0, 1, then, told(&[("Origin Distance", value), ("Origin Distance - Saved", "9")]));
            let accepted = store::Accepted {
                packet: &packet,
                received: then,
                transport: store::Transport::Link,
                link: None,
            };
            store.accept(&accepted).unwrap();
        }
        store.close().unwrap();
    })
    .await;
    let viewer = shore.token(Some(FIRST), Role::Viewer).await;
    let read: VesselParameters = get(&shore, "parameters", &viewer).await;
    assert!(read.recorded, "{read:?}");
    let one = &read.entities[0].parameters[0];
    assert_eq!(
        (one.name.as_str(), one.value.as_str(), one.saved.as_deref()),
        ("Origin Distance", "9", Some("9"))
    );
}

fn sails(plan_id: &str, maneuver: &str) -> PlanControlState {
    PlanControlState {
        state: PlanControlStateState::Executing,
        plan_id: plan_id.into(),
        man_id: maneuver.into(),
        ..PlanControlState::default()
    }
}

fn specification(id: &str, speed: f32) -> PlanSpecification {
    let (lat, lon) = (1.1, 0.18);
    let goto = Goto { lat, lon, speed, speed_units: SpeedUnits::MetersPs, ..Goto::default() };
    let data = imc::messages::Message::from(goto).into();
    let maneuver = PlanManeuver { maneuver_id: "there".into(), data, ..PlanManeuver::default() };
    PlanSpecification {
        plan_id: id.into(),
        start_man_id: "there".into(),
        maneuvers: [maneuver].into_iter().collect(),
        ..PlanSpecification::default()
    }
}

#[tokio::test]
async fn the_plan_that_a_vessel_sails_is_known_when_it_told_it_and_else_that_is_said() {
    let shore = Shore::with(|_| ()).await;
    let viewer = shore.token(Some(FIRST), Role::Viewer).await;
    let boats = Boats::join(&shore.state.shore.router).await;
    boats.say(boat(0, clock::now())).await;
    assert_eq!(get::<PlanUnderWay>(&shore, "plan", &viewer).await.plan_id, None);

    boats.say(vec![packet(0, 1, clock::now(), sails("survey", "there"))]).await;
    let unknown: PlanUnderWay = get(&shore, "plan", &viewer).await;
    assert_eq!((unknown.plan_id.as_deref(), unknown.source), (Some("survey"), None));
    assert!(unknown.trouble.unwrap().contains("has not reported this plan") && unknown.legs.is_empty());
    let (status, asked) = post(&shore, "ask", &viewer, &json!({"about": "plan", "plan_id": "survey"})).await;
    assert_eq!((status, asked["packets"].as_u64()), (StatusCode::OK, Some(1)));

    boats.say(vec![packet(0, 1, clock::now(), specification("survey", 1.0))]).await;
    let known: PlanUnderWay = get(&shore, "plan", &viewer).await;
    assert_eq!((known.source.as_deref(), known.maneuver.as_str()), (Some("vessel"), "there"));
    let [leg] = &known.legs[..] else { panic!("{known:?}") };
    assert!((leg.places[0].lat_deg - 1.1_f64.to_degrees()).abs() < 1e-9 && leg.id == "there");
    assert!(known.digest.unwrap().len() == 32 && known.trouble.is_none());

    boats.say(vec![packet(0, 1, clock::now(), sails("odd", "x"))]).await;
    boats.say(vec![packet(0, 1, clock::now(), specification("odd", -3.0))]).await;
    let odd: PlanUnderWay = get(&shore, "plan", &viewer).await;
    assert!(odd.trouble.unwrap().contains("cannot be drawn"));
}
