//! Missions: permissions to read, write, change and withdraw, and summaries from the history.

use super::history_tests::put;
use super::tests::{Answer, Shore, bearer};
use api::{Mission, MissionSummary, Missions, Role};
use axum::body::Body;
use axum::http::{Request, StatusCode};
use imc::messages::{
    Current, EstimatedState, FuelLevel, PlanControlState, PlanControlStateState as Plan, TBRFishTag, Voltage,
};
use serde_json::{Value, json};

/// 2026-11-21 08:00 UTC.
const START_US: i64 = 1_795_248_000_000_000;
const OTTER: u16 = 0x0814;
const OTHER: u16 = OTTER + 1;

async fn say(shore: &Shore, method: &str, path: &str, token: &str, body: Value) -> Answer {
    let request = bearer(Request::builder().method(method).uri(format!("/api/v1/missions{path}")), token);
    shore.send(request.header("content-type", "application/json"), Body::from(body.to_string())).await
}

fn ask(vessels: &[u16], from_us: i64, to_us: Option<i64>) -> Value {
    json!({
        "name": "Salmon, autumn", "people": "Kari, Nils", "purpose": "where they winter", "notes": "",
        "vessels": vessels, "from_us": from_us, "to_us": to_us,
    })
}

async fn created(shore: &Shore, token: &str, body: Value) -> Mission {
    let answer = say(shore, "POST", "", token, body).await;
    assert_eq!(answer.status, StatusCode::OK, "{}", answer.body);
    serde_json::from_str(&answer.body).unwrap()
}

#[tokio::test]
async fn operators_of_all_its_vessels_keep_a_mission_and_others_see_their_part() {
    let shore = Shore::with(|_| ()).await;
    let both = shore.token(None, Role::Operator).await;
    let one = shore.token(Some(OTTER), Role::Operator).await;
    let viewer = shore.token(Some(OTHER), Role::Viewer).await;
    let elsewhere = shore.token(Some(7), Role::Operator).await;
    let mission = created(&shore, &both, ask(&[OTTER, OTHER, OTTER], 5, None)).await;
    assert_eq!(mission.mission.vessels, [OTTER, OTHER]);
    assert_eq!(
        say(&shore, "POST", "", &one, ask(&[OTTER, OTHER], 5, None)).await.status,
        StatusCode::FORBIDDEN
    );
    let path = format!("/{}", mission.id);
    let seen = shore.get(&format!("/api/v1/missions{path}"), &viewer).await;
    let seen: Mission = serde_json::from_str(&seen.body).unwrap();
    assert_eq!((&seen.mission.vessels[..], seen.may_change), (&[OTHER][..], false));
    for path in [path.clone(), format!("{path}/summary")] {
        let hidden = shore.get(&format!("/api/v1/missions{path}"), &elsewhere).await;
        assert_eq!(hidden.status, StatusCode::NOT_FOUND);
    }
    let listed = async |token: &str, query: &str| {
        let answer = shore.get(&format!("/api/v1/missions{query}"), token).await;
        serde_json::from_str::<Missions>(&answer.body).unwrap().missions.len()
    };
    assert_eq!((listed(&viewer, "").await, listed(&elsewhere, "").await), (1, 0));

    // A user who may not see all its vessels cannot change it, as some would be lost.
    let change = |revision: u32| json!({"revision": revision, "mission": ask(&[OTTER], 5, Some(9))});
    assert_eq!(say(&shore, "PATCH", &path, &one, change(1)).await.status, StatusCode::FORBIDDEN);
    assert_eq!(say(&shore, "DELETE", &path, &one, json!({})).await.status, StatusCode::FORBIDDEN);
    let changed = say(&shore, "PATCH", &path, &both, change(1)).await;
    assert_eq!(serde_json::from_str::<Mission>(&changed.body).unwrap().revision, 2);
    assert_eq!(say(&shore, "PATCH", &path, &both, change(1)).await.status, StatusCode::CONFLICT);
    assert_eq!(say(&shore, "DELETE", &path, &one, json!({})).await.status, StatusCode::OK);
    assert_eq!(say(&shore, "PATCH", &path, &both, change(2)).await.status, StatusCode::UNPROCESSABLE_ENTITY);
    assert_eq!((listed(&both, "").await, listed(&both, "?withdrawn=true").await), (0, 1));
    let acts: Vec<String> = shore.audit().await.into_iter().rev().map(|entry| entry.action).collect();
    let acts: Vec<&str> = acts.iter().map(|one| &**one).filter(|one| one.starts_with("mission.")).collect();
    assert_eq!(acts, ["mission.create", "mission.change", "mission.withdraw"]);
}

#[tokio::test]
async fn what_cannot_be_a_mission_is_refused_at_its_field() {
    let shore = Shore::with(|_| ()).await;
    let operator = shore.token(None, Role::Operator).await;
    for (name, value, told) in [
        ("name", json!(" "), "name: empty"),
        ("name", json!("a\nb"), "name: has several lines"),
        ("people", json!("x".repeat(501)), "people: has 501"),
        ("purpose", json!("x".repeat(2_001)), "purpose: has 2001"),
        ("vessels", json!([]), "vessels: choose 1 to 32"),
        ("vessels", json!((1..=33).collect::<Vec<u16>>()), "vessels: choose 1 to 32"),
        ("from_us", json!(-1), "from_us: -1 is not a time"),
        ("to_us", json!(5), "to_us: the end is not after"),
        ("to_us", json!(400_i64 * 86_400_000_000), "to_us: a mission has a year"),
        ("colour", json!(1), "colour"),
    ] {
        let mut body = ask(&[OTTER], 5, Some(9));
        body[name] = value;
        let answer = say(&shore, "POST", "", &operator, body).await;
        assert!(answer.status.is_client_error() && answer.body.contains(told), "{told}: {}", answer.body);
    }
}

#[tokio::test]
async fn the_history_tells_distance_hours_battery_and_tags_of_a_mission() {
    let shore = Shore::with(|data| {
        let mut said = Vec::new();
        for second in 0..=600_i64 {
            // North by 2e-5°, 2.2 m, a second.
            let lat = (63.44 + second as f64 * 2e-5).to_radians();
            let state = EstimatedState { lat, lon: 10.4_f64.to_radians(), ..EstimatedState::default() };
            said.push((1, START_US + second * 1_000_000, state.into()));
        }
        for (second, value) in [(1, 90.0), (300, 85.0), (599, 80.5)] {
            said.push((2, START_US + second * 1_000_000, FuelLevel { value, ..FuelLevel::default() }.into()));
        }
        for second in 0..=600_i64 {
            let time_us = START_US + second * 1_000_000;
            said.push((2, time_us, Voltage { value: 24.0 }.into()));
            said.push((2, time_us, Current { value: 15.0 }.into()));
            // A rail of the electronics: what it takes is the battery's already.
            said.push((4, time_us, Voltage { value: 12.0 }.into()));
            said.push((4, time_us, Current { value: 2.0 }.into()));
        }
        for (second, state, plan_id) in [
            (1, Plan::Ready, "old"),
            (5, Plan::Executing, "rows"),
            (6, Plan::Executing, "rows"),
            (9, Plan::Executing, "home"),
        ] {
            let plan_id = plan_id.into();
            let plan = PlanControlState { state, plan_id, ..PlanControlState::default() };
            said.push((5, START_US + second * 1_000_000, plan.into()));
        }
        for (second, trans_id) in [(10, 101), (20, 102), (30, 101), (900, 103)] {
            let unix_timestamp = (START_US / 1_000_000 + second) as u32;
            let tag = TBRFishTag { unix_timestamp, trans_id, ..TBRFishTag::default() };
            said.push((3, START_US + second * 1_000_000, tag.into()));
        }
        put(data, &said);
    })
    .await;
    let operator = shore.token(None, Role::Operator).await;
    let until = START_US + 601_000_000;
    let mission = created(&shore, &operator, ask(&[OTTER, OTHER], START_US, Some(until))).await;
    let path = format!("/api/v1/missions/{}/summary", mission.id);
    let told: MissionSummary = serde_json::from_str(&shore.get(&path, &operator).await.body).unwrap();
    assert_eq!((told.to_us, told.vessels.len()), (until, 2));
    let [otter, other] = &told.vessels[..] else { panic!("two vessels") };
    // 0.012° of latitude at 63.4°N: 1 337.6 m by the meridian's radius there, 6 386.6 km; within a metre.
    assert!((otter.distance_m - 1_337.6).abs() < 1.0, "{}", otter.distance_m);
    assert!((otter.recorded_s - 600.0).abs() < 1e-6, "{}", otter.recorded_s);
    assert_eq!((otter.first_us, otter.last_us), (Some(START_US), Some(START_US + 600_000_000)));
    assert_eq!((otter.battery_first_percent, otter.battery_last_percent), (Some(90.0), Some(80.5)));
    // 24 V and 15 A for ten minutes: 60 Wh.
    assert!((otter.energy_wh.unwrap() - 60.0).abs() < 1e-6, "{:?}", otter.energy_wh);
    assert_eq!(otter.plans, ["rows", "home"], "those that it sailed");
    assert_eq!((otter.detections, otter.tags), (3, 2), "those of its time");
    assert_eq!((other.first_us, other.distance_m, other.battery_first_percent), (None, 0.0, None));
    assert_eq!((other.energy_wh, other.plans.len()), (None, 0));
    // While it has not ended, it is summarised up to now.
    let open = created(&shore, &operator, ask(&[OTTER], START_US + 700_000_000, None)).await;
    let told = shore.get(&format!("/api/v1/missions/{}/summary", open.id), &operator).await;
    assert_eq!(told.status, StatusCode::OK, "{}", told.body);
}
