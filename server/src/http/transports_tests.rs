//! Reports about connections and recording, also during a disk fault.

use super::testing::{Boats, FIRST, boat};
use super::tests::{Answer, Shore};
use api::{LinkStatus, Recording, Role, TransportPeer};
use axum::http::StatusCode;
use hub::{Peer, Sources, Transport};
use shore::clock;
use std::time::Duration;

/// Longer than anything here takes on a loaded machine.
const DEADLINE: Duration = Duration::from_mins(2);

fn read<T: serde::de::DeserializeOwned>(answer: &Answer) -> T {
    assert_eq!(answer.status, StatusCode::OK, "{}", answer.body);
    serde_json::from_str(&answer.body).unwrap()
}

#[tokio::test]
async fn peers_are_told_to_those_who_may_see_their_vessels() {
    let shore = Shore::with(|_| ()).await;
    let boats = Boats::join(&shore.state.shore.router).await;
    let console = Peer {
        transport: Transport::Proxy,
        role: hub::Role::Console,
        name: "<b>192.0.2.7:1".to_owned(),
        sources: Sources::Any,
    };
    // It never reads, and has little room.
    let _console = shore.state.shore.router.join(console, 2_000).await.unwrap();
    let mut given = 0;
    for step in 0..40 {
        let packets: Vec<_> = boat(0, units::UtcTime::from_micros(clock::now().micros() + step * 1_000));
        given += packets.len() as u64;
        boats.say(packets).await;
    }
    let all = shore.token(None, Role::Viewer).await;
    let peers: Vec<TransportPeer> = read(&shore.get("/api/v1/connections", &all).await);
    let (vessel, console) = (&peers[0], &peers[1]);
    assert_eq!(
        (vessel.transport.as_str(), &vessel.systems[..], vessel.received),
        ("link", &[FIRST][..], given)
    );
    assert_eq!((console.transport.as_str(), console.name.as_str()), ("imcproxy", "<b>192.0.2.7:1"));
    assert!(
        console.delivered > 0 && console.dropped > 0 && console.dropped <= console.delivered,
        "{console:?}"
    );
    let own = shore.token(Some(FIRST), Role::Viewer).await;
    let peers: Vec<TransportPeer> = read(&shore.get("/api/v1/connections", &own).await);
    assert_eq!(peers.iter().map(|peer| peer.id).collect::<Vec<_>>(), [vessel.id]);
    let other = shore.token(Some(FIRST + 1), Role::Viewer).await;
    assert!(read::<Vec<TransportPeer>>(&shore.get("/api/v1/connections", &other).await).is_empty());
    assert!(read::<Vec<LinkStatus>>(&shore.get("/api/v1/links", &all).await).is_empty());
}

#[tokio::test]
async fn trouble_with_the_disk_is_told_everywhere_and_passes() {
    let shore = Shore::with(|_| ()).await;
    let token = shore.token(Some(FIRST), Role::Viewer).await;
    let health = async || shore.get("/healthz", "").await;
    let recording = async || read::<Recording>(&shore.get("/api/v1/recording", &token).await);
    assert_eq!(health().await.status, StatusCode::OK);
    assert_eq!((recording().await.trouble, recording().await.waiting_bytes), (None, 0));

    // A file is in place of the archive's folder.
    let (archive, aside) = (shore.data().join("archive"), shore.data().join("aside"));
    std::fs::rename(&archive, &aside).unwrap();
    std::fs::write(&archive, "").unwrap();
    let boats = Boats::join(&shore.state.shore.router).await;
    let packets = boat(0, clock::now());
    let given = packets.len() as u64;
    boats.say(packets).await;
    let mut state = shore.state.shore.recorder.state();
    let troubled = state.wait_for(|state| state.trouble.is_some());
    drop(tokio::time::timeout(DEADLINE, troubled).await.unwrap().unwrap());
    let ill = health().await;
    assert_eq!(ill.status, StatusCode::SERVICE_UNAVAILABLE);
    assert!(ill.body.contains("nothing can be recorded"), "{}", ill.body);
    assert!(!ill.body.contains(&*shore.data().to_string_lossy()), "strangers learn no folders: {}", ill.body);
    let trouble = recording().await.trouble.unwrap();
    assert!(trouble.contains("archive"), "{trouble}");
    assert_eq!(shore.state.shore.recorder.state().borrow().problem(), Some(trouble));

    std::fs::remove_file(&archive).unwrap();
    std::fs::rename(&aside, &archive).unwrap();
    let well = state.wait_for(|state| state.trouble.is_none() && state.recorded == given);
    drop(tokio::time::timeout(DEADLINE, well).await.unwrap().unwrap());
    assert_eq!(health().await.status, StatusCode::OK);
    assert_eq!((recording().await.recorded, recording().await.not_recorded), (given, 0));
}
