//! Control of a vessel and orders to it, from the request to the vessel's transport and the audit log.

use super::testing::{Boats, FIRST, boat};
use super::tests::{Shore, bearer};
use api::{AuditEntry, Command, Lease, Role};
use axum::body::Body;
use axum::http::{Request, StatusCode};
use imc::messages::{Payload as _, PlanControl, PlanControlState, PlanControlStateState, PlanControlType};
use imc::{Address, Header, Packet, PacketView};
use shore::clock;
use shore::identity::vessels;
use std::time::Duration;

async fn post(shore: &Shore, what: &str, token: &str, body: &str) -> (StatusCode, String) {
    let request = Request::post(format!("/api/v1/vessels/2068/{what}"));
    let request = bearer(request, token).header("content-type", "application/json");
    let answer = shore.send(request, Body::from(body.to_owned())).await;
    (answer.status, answer.body)
}

async fn lease(shore: &Shore, token: &str, body: &str) -> Result<Lease, String> {
    let (status, text) = post(shore, "lease", token, body).await;
    if status == StatusCode::OK { Ok(serde_json::from_str(&text).unwrap()) } else { Err(text) }
}

async fn audited(shore: &Shore) -> Vec<(String, String)> {
    shore
        .audit()
        .await
        .into_iter()
        .rev()
        .map(|AuditEntry { action, outcome, .. }| (action, outcome))
        .collect()
}

const REQUEST: &str = r#"{"action":"request","window":"a"}"#;
const START: &str = r#"{"order":{"kind":"plan.start","plan_id":"survey"},"window":"a"}"#;

#[tokio::test]
async fn of_two_people_one_has_control_and_everything_is_written_down() {
    let shore = Shore::with(|_| ()).await;
    let one = shore.token(Some(FIRST), Role::Operator).await;
    let two = shore.token(Some(FIRST), Role::Operator).await;
    let boats = Boats::join(&shore.state.shore.router).await;
    boats.say(boat(0, clock::now())).await;

    let (status, text) = post(&shore, "commands", &one, START).await;
    assert_eq!(status, StatusCode::CONFLICT);
    assert!(text.contains("no_control") && text.contains("take it first"), "{text}");
    let held = lease(&shore, &one, REQUEST).await.unwrap();
    let name = held.holder.unwrap().name;
    let waits = lease(&shore, &two, r#"{"action":"request","reason":"my turn"}"#).await.unwrap();
    assert_eq!(waits.waiting.unwrap().reason, "my turn");
    assert!(lease(&shore, &two, r#"{"action":"grant"}"#).await.unwrap_err().contains(&name));
    assert_eq!(post(&shore, "commands", &two, START).await.0, StatusCode::CONFLICT);
    assert_eq!(post(&shore, "commands", &one, START).await.0, StatusCode::ACCEPTED);
    let packet = boats.heard(PlanControl::ID).await;
    let sent: PlanControl = imc::decode(&PacketView::new(&packet).unwrap()).unwrap().unwrap();
    assert_eq!(sent.plan_id.as_str(), Some("survey"));
    let given = lease(&shore, &one, r#"{"action":"grant","window":"a"}"#).await.unwrap();
    assert_ne!(given.holder.unwrap().name, name);
    // Taking over needs a reason, and the former holder can no longer command.
    assert!(lease(&shore, &one, r#"{"action":"take"}"#).await.unwrap_err().contains("Say why"));
    lease(&shore, &one, r#"{"action":"take","reason":"it drifts","window":"a"}"#).await.unwrap();
    assert_eq!(post(&shore, "commands", &two, START).await.0, StatusCode::CONFLICT);

    let log = audited(&shore).await;
    for (action, outcome) in
        [("lease.request", "done"), ("lease.grant", "done"), ("lease.take", "done"), ("plan.start", "asked")]
    {
        assert!(log.contains(&(action.to_owned(), outcome.to_owned())), "{action}: {log:?}");
    }
    assert!(log.iter().any(|(action, outcome)| action == "plan.start" && outcome.contains("has it")));

    // A viewer sees who has control and what was ordered, and can neither have it nor order.
    let viewer = shore.token(Some(FIRST), Role::Viewer).await;
    let seen = shore.get("/api/v1/vessels/2068/lease", &viewer).await;
    assert!(seen.status == StatusCode::OK && seen.body.contains("it drifts"), "{}", seen.body);
    let seen = shore.get("/api/v1/vessels/2068/commands", &viewer).await;
    assert!(seen.body.contains("\"plan.start\""), "{}", seen.body);
    assert_eq!(post(&shore, "lease", &viewer, REQUEST).await.0, StatusCode::FORBIDDEN);
    assert_eq!(post(&shore, "commands", &viewer, START).await.0, StatusCode::FORBIDDEN);
}

#[tokio::test]
async fn a_start_is_followed_to_its_effect_by_what_the_vessel_says() {
    let shore = Shore::with(|_| ()).await;
    let token = shore.token(Some(FIRST), Role::Operator).await;
    let boats = Boats::join(&shore.state.shore.router).await;
    boats.say(boat(0, clock::now())).await;
    lease(&shore, &token, REQUEST).await.unwrap();
    let (_, text) = post(&shore, "commands", &token, START).await;
    let command: Command = serde_json::from_str(&text).unwrap();
    let stages: Vec<&str> = command.steps.iter().map(|step| step.stage.as_str()).collect();
    assert_eq!(stages, ["accepted", "sent"]);
    let packet = boats.heard(PlanControl::ID).await;
    let request: PlanControl = imc::decode(&PacketView::new(&packet).unwrap()).unwrap().unwrap();
    let say = |message: imc::Message, dst| {
        let timestamp = clock::now().seconds();
        let header = Header { src: Address(FIRST), dst, timestamp, ..Header::default() };
        vec![Packet::new(header, message).encode().unwrap().into()]
    };
    let answer = PlanControl { r#type: PlanControlType::Success, info: "plan loaded".into(), ..request };
    boats.say(say(answer.into(), shore.state.shore.router.address())).await;
    let state = PlanControlState {
        state: PlanControlStateState::Executing,
        plan_id: "survey".into(),
        ..PlanControlState::default()
    };
    boats.say(say(state.into(), Address(0xFFFF))).await;
    let path = format!("/api/v1/vessels/2068/commands/{}", command.id);
    let until = tokio::time::Instant::now() + Duration::from_secs(20);
    let command: Command = loop {
        let command: Command = serde_json::from_slice(&shore.get(&path, &token).await.bytes).unwrap();
        if command.over {
            break command;
        }
        assert!(tokio::time::Instant::now() < until, "{command:?}");
        tokio::task::yield_now().await;
    };
    let last = command.steps.last().unwrap();
    assert_eq!((last.stage.as_str(), last.text.as_str()), ("effect seen", "executing survey"));
}

#[tokio::test]
async fn what_cannot_be_sent_or_is_no_order_says_why() {
    let shore = Shore::with(|_| ()).await;
    let add = vessels::Add { address: FIRST, name: "otter-1".to_owned(), now: clock::now() };
    shore.state.shore.people.change(add).await.unwrap();
    let token = shore.token(Some(FIRST), Role::Operator).await;
    lease(&shore, &token, REQUEST).await.unwrap();
    let (status, text) = post(&shore, "commands", &token, START).await;
    assert_eq!(status, StatusCode::ACCEPTED);
    assert!(text.contains("no connection to the vessel"), "{text}");
    for (body, wrong) in [
        ("{}", "order"),
        (r#"{"order":{"kind":"fly"}}"#, "plan.start"),
        (r#"{"order":{"kind":"goto","lat_deg":99,"lon_deg":0,"speed_mps":1},"window":"a"}"#, "latitude"),
        (r#"{"order":{"kind":"goto","lat_deg":9,"lon_deg":0,"speed_mps":99},"window":"a"}"#, "speed_mps"),
        (r#"{"order":{"kind":"plan.start","plan_id":""},"window":"a"}"#, "plan_id"),
        (r#"{"order":{"kind":"plan.stop"},"window":"another"}"#, "Another of your windows"),
    ] {
        let (status, text) = post(&shore, "commands", &token, body).await;
        assert!(status.is_client_error() && text.contains(wrong), "{body}: {status} {text}");
    }
}
