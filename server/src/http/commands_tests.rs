//! A stop, from the request to the vessel's transport and the audit log.

use super::testing::{Boats, FIRST, boat};
use super::tests::{Shore, bearer};
use api::{AuditEntry, Ordered, Role};
use axum::body::Body;
use axum::http::{Request, StatusCode};
use imc::PacketView;
use imc::messages::{Abort, Payload as _};
use shore::clock;

async fn stop(shore: &Shore, vessel: &str, token: &str) -> Result<Ordered, StatusCode> {
    let request = bearer(Request::post(format!("/api/v1/vessels/{vessel}/abort")), token);
    let answer = shore.send(request, Body::empty()).await;
    if answer.status != StatusCode::OK {
        return Err(answer.status);
    }
    Ok(serde_json::from_slice(&answer.bytes).unwrap())
}

async fn audited(shore: &Shore) -> Vec<AuditEntry> {
    shore.audit().await.into_iter().filter(|entry| entry.action == "vessel.abort").collect()
}

#[tokio::test]
async fn a_stop_goes_to_its_vessel_by_name_of_the_server_and_into_the_audit_log() {
    let shore = Shore::with(|_| ()).await;
    let operator = shore.token(Some(FIRST), Role::Operator).await;
    let boats = Boats::join(&shore.state.shore.router).await;
    boats.say(boat(0, clock::now())).await;

    let ordered = stop(&shore, "0x0814", &operator).await.unwrap();
    assert!(ordered.reached && !ordered.waits, "{ordered:?}");
    let packet = boats.heard(Abort::ID).await;
    let view = PacketView::new(&packet).unwrap();
    assert_eq!((view.src(), view.dst().0), (shore.state.shore.router.address(), FIRST));
    let entries = audited(&shore).await;
    assert_eq!(entries.len(), 1);
    assert_eq!(entries[0].outcome, "asked");

    // This person may not stop another vessel, and nothing was sent.
    assert_eq!(stop(&shore, "2069", &operator).await, Err(StatusCode::FORBIDDEN));
    let viewer = shore.token(Some(FIRST), Role::Researcher).await;
    assert_eq!(stop(&shore, "2068", &viewer).await, Err(StatusCode::FORBIDDEN));
    assert_eq!(audited(&shore).await.len(), 1);
}

#[tokio::test]
async fn a_stop_that_no_transport_leads_to_waits_for_its_vessel() {
    let shore = Shore::with(|_| ()).await;
    let operator = shore.token(None, Role::Operator).await;
    let ordered = stop(&shore, "2068", &operator).await.unwrap();
    assert!(!ordered.reached && ordered.waits, "{ordered:?}");
    let boats = Boats::join(&shore.state.shore.router).await;
    boats.say(boat(0, clock::now())).await;
    boats.heard(Abort::ID).await;
}
