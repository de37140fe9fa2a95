//! Alarms from the fleet's silence to an acknowledgement and the audit log.

use super::testing::{Boats, FIRST, boat};
use super::tests::{Shore, bearer};
use api::{Alarm, AlarmList, AuditEntry, Role};
use axum::body::Body;
use axum::http::{Request, StatusCode};
use operations::Operations;
use operations::alarms::ShoreState;
use shore::clock;
use shore::identity::vessels;
use std::time::Duration;
use units::Now;

/// Lets the hub evaluate alarms as if `seconds` had passed.
async fn later(shore: &Shore, seconds: u64, seen: ShoreState) {
    let look = move |operations: &mut Operations, now: Now| {
        operations.watch(Now { mono: now.mono + Duration::from_secs(seconds), ..now }, &seen);
    };
    shore.state.shore.router.inspect(look).await.unwrap();
}

async fn standing(shore: &Shore, token: &str) -> Vec<Alarm> {
    let answer = shore.get("/api/v1/alarms", token).await;
    serde_json::from_str::<AlarmList>(&answer.body).unwrap().standing
}

async fn post(shore: &Shore, path: &str, token: &str, body: &str) -> (StatusCode, String) {
    let request = bearer(Request::post(format!("/api/v1/alarms/{path}")), token);
    let request = request.header("content-type", "application/json");
    let answer = shore.send(request, Body::from(body.to_owned())).await;
    (answer.status, answer.body)
}

#[tokio::test]
async fn an_operator_of_the_vessel_acknowledges_and_shelves_and_it_is_written_down() {
    let shore = Shore::with(|_| ()).await;
    let operator = shore.token(Some(FIRST), Role::Operator).await;
    let viewer = shore.token(Some(FIRST), Role::Viewer).await;
    let elsewhere = shore.token(Some(FIRST + 7), Role::Operator).await;
    let both = shore.token(None, Role::Viewer).await;
    let boats = Boats::join(&shore.state.shore.router).await;
    boats.say(boat(0, clock::now())).await;
    later(&shore, 0, ShoreState::default()).await;
    assert!(standing(&shore, &viewer).await.is_empty());
    later(&shore, 20, ShoreState::default()).await;
    // At rest its silence is a caution, which needs no acknowledgement.
    let silent = standing(&shore, &viewer).await;
    assert_eq!((silent.len(), &*silent[0].kind, &*silent[0].priority), (1, "not_heard", "caution"));
    assert!(!silent[0].action.is_empty() && !silent[0].wants_acknowledgement);
    assert!(standing(&shore, &elsewhere).await.is_empty(), "not theirs to see");
    // As on its page: by its own name, unless people gave it one.
    assert_eq!(silent[0].vessel_name.as_deref(), Some("otter-0"));
    let named = vessels::Add { address: FIRST, name: "northern-otter".to_owned(), now: clock::now() };
    shore.state.shore.people.change(named).await.unwrap();
    assert_eq!(standing(&shore, &viewer).await[0].vessel_name.as_deref(), Some("northern-otter"));
    let acknowledge = format!("{}/acknowledge", silent[0].id);
    assert_eq!(post(&shore, &acknowledge, &operator, "").await.0, StatusCode::UNPROCESSABLE_ENTITY);

    // The server's own alarms are visible to all.
    let full = ShoreState { recording: Some("the disk is full".to_owned()), ..ShoreState::default() };
    later(&shore, 21, full).await;
    let all = standing(&shore, &elsewhere).await;
    assert_eq!((all.len(), &*all[0].kind, &*all[0].state), (1, "recording", "unacknowledged"));
    let recording = format!("{}/acknowledge", all[0].id);
    for (path, token, status) in [
        (&acknowledge, &elsewhere, StatusCode::NOT_FOUND),
        (&recording, &viewer, StatusCode::FORBIDDEN),
        (&recording, &both, StatusCode::FORBIDDEN),
        (&recording, &operator, StatusCode::OK),
        (&recording, &operator, StatusCode::UNPROCESSABLE_ENTITY),
    ] {
        assert_eq!(post(&shore, path, token, "").await.0, status, "{path}");
    }
    let shelve = format!("{}/shelve", all[0].id);
    let (status, text) = post(&shore, &shelve, &operator, r#"{"minutes":9999,"reason":"why"}"#).await;
    assert_eq!(status, StatusCode::UNPROCESSABLE_ENTITY);
    assert!(text.contains("12 hours"), "{text}");
    let (status, text) = post(&shore, &shelve, &operator, r#"{"minutes":30,"reason":"a disk comes"}"#).await;
    assert_eq!(status, StatusCode::OK, "{text}");
    assert_eq!(serde_json::from_str::<Alarm>(&text).unwrap().shelved.unwrap().reason, "a disk comes");
    let acts: Vec<(String, bool)> = shore
        .audit()
        .await
        .into_iter()
        .rev()
        .filter(|entry| entry.action.starts_with("alarm."))
        .map(|AuditEntry { action, outcome, .. }| (action, outcome == "done"))
        .collect();
    let (word, shelf) = ("alarm.acknowledge".to_owned(), "alarm.shelve".to_owned());
    let expected = [(&word, false), (&word, true), (&word, false), (&shelf, false), (&shelf, true)];
    assert_eq!(acts.iter().map(|(action, done)| (action, *done)).collect::<Vec<_>>(), expected);
}
