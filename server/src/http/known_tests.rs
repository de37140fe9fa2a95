//! Which vessels requests may name, and how: by name and address alike, and unknown ones are refused, but to STOP.

use super::testing::{Boats, FIRST, boat};
use super::tests::{Shore, bearer, request};
use crate::serve::router;
use crate::web::{Kind, Need};
use api::{Ordered, Role};
use axum::body::Body;
use axum::http::{Request, StatusCode, header};
use shore::clock;
use shore::identity::vessels;

const NAME: &str = "otter-1";

/// A server that knows one vessel by name, and an operator's token.
async fn start() -> (Shore, String) {
    let shore = Shore::with(|_| ()).await;
    let add = vessels::Add { address: FIRST, name: NAME.to_owned(), now: clock::now() };
    shore.state.shore.people.change(add).await.unwrap();
    let token = shore.token(None, Role::Operator).await;
    (shore, token)
}

async fn post(shore: &Shore, token: &str, path: &str, body: &'static str) -> (StatusCode, String) {
    let request = Request::post(path).header(header::CONTENT_TYPE, "application/json");
    let answer = shore.send(bearer(request, token), Body::from(body)).await;
    (answer.status, answer.body)
}

#[tokio::test]
async fn what_is_asked_of_an_unknown_vessel_is_refused_with_the_vessel_that_was_meant() {
    let (shore, token) = start().await;
    let of_vessels = router::table().into_iter().filter(|route| {
        route.kind != Kind::Page && matches!(route.need, Need::OnVessel(_)) && !route.to_unknown
    });
    let mut count = 0;
    for route in of_vessels {
        // The address of the tests of rights, which no vessel has here.
        let answer = shore.send(bearer(request(&route), &token), Body::empty()).await;
        assert_eq!(answer.status, StatusCode::NOT_FOUND, "{} {}: {}", route.method, route.path, answer.body);
        assert!(answer.body.contains("\"code\":\"not_found\""), "{}", answer.body);
        assert!(
            answer.body.contains("There is no vessel 0x0007; there are otter-1 (0x0814)."),
            "{}",
            answer.body
        );
        count += 1;
    }
    assert!(count > 15, "{count}");
    for (query, field) in [
        ("series?system=oter-1", "system: "),
        ("alarms/history?vessel=oter-1", "vessel: "),
        ("logbook?vessel=oter-1", "vessel: "),
    ] {
        let answer = shore.get(&format!("/api/v1/{query}"), &token).await;
        assert_eq!(answer.status, StatusCode::NOT_FOUND, "{query}: {}", answer.body);
        let said = format!("{field}There is no vessel oter-1; did you mean otter-1?");
        assert!(answer.body.contains(&said), "{query}: {}", answer.body);
    }
}

#[tokio::test]
async fn a_vessel_is_named_by_name_and_by_address_alike() {
    let (shore, token) = start().await;
    for vessel in [NAME, "OTTER-1", "2068", "0x0814"] {
        for path in ["vessels/V/lease", "vessels/V/entities", "series?system=V", "alarms/history?vessel=V"] {
            let path = format!("/api/v1/{}", path.replace('V', vessel));
            let answer = shore.get(&path, &token).await;
            assert_eq!(answer.status, StatusCode::OK, "{path}: {}", answer.body);
        }
    }
    // By a name that the vessel alone gives itself.
    let boats = Boats::join(&shore.state.shore.router).await;
    boats.say(boat(1, clock::now())).await;
    let heard = shore.state.shore.fleet.heard().await.unwrap();
    let (_, name) = heard.into_iter().find(|(address, _)| address.0 == FIRST + 1).unwrap();
    let path = format!("/api/v1/vessels/{}/lease", name.unwrap());
    assert_eq!(shore.get(&path, &token).await.status, StatusCode::OK, "{path}");
}

#[tokio::test]
async fn whose_vessels_are_others_is_told_neither_their_names_nor_whether_there_are() {
    let (shore, _) = start().await;
    let token = shore.token(Some(9), Role::Operator).await;
    let by_address = shore.get("/api/v1/alarms/history?vessel=2068", &token).await;
    assert_eq!(by_address.status, StatusCode::FORBIDDEN, "{}", by_address.body);
    let by_name = shore.get("/api/v1/vessels/otter-1/lease", &token).await;
    assert_eq!(by_name.status, StatusCode::NOT_FOUND, "{}", by_name.body);
    assert!(by_name.body.contains("no vessel is known here that you may see"), "{}", by_name.body);
}

#[tokio::test]
async fn a_stop_goes_out_to_an_unknown_vessel_and_says_so_and_control_of_it_is_refused() {
    let (shore, token) = start().await;
    let (status, body) = post(&shore, &token, "/api/v1/vessels/2069/abort", "").await;
    assert_eq!(status, StatusCode::OK, "{body}");
    let ordered: Ordered = serde_json::from_str(&body).unwrap();
    assert!(!ordered.known && ordered.waits, "{ordered:?}");
    let (_, body) = post(&shore, &token, "/api/v1/vessels/otter-1/abort", "").await;
    assert!(serde_json::from_str::<Ordered>(&body).unwrap().known, "{body}");

    let take = r#"{"action": "request", "reason": "", "window": "a"}"#;
    let (status, body) = post(&shore, &token, "/api/v1/vessels/2069/lease", take).await;
    assert_eq!(status, StatusCode::NOT_FOUND, "{body}");
    assert!(body.contains("did you mean 0x0814?"), "{body}");
    let (status, body) = post(&shore, &token, "/api/v1/vessels/2068/lease", take).await;
    assert_eq!(status, StatusCode::OK, "{body}");
    for everyone in ["0", "65535", "0xFFF0"] {
        for (path, body) in [("abort", ""), ("lease", take)] {
            let path = format!("/api/v1/vessels/{everyone}/{path}");
            let (status, body) = post(&shore, &token, &path, body).await;
            assert_eq!(status, StatusCode::BAD_REQUEST, "{path}: {body}");
            assert!(body.contains("is not the address of one vessel"), "{path}: {body}");
        }
    }
}
