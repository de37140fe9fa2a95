//! A stop over both of its transports, with real connections.

use super::live_tests::{DEADLINE, Raw, Shore, Socket, exchange};
use super::testing::{FIRST, boat, packet};
use api::{LiveAnswer, LiveStopped, Ordered, Role};
use futures_util::{SinkExt as _, StreamExt as _};
use imc::PacketView;
use imc::messages::{Abort, LogBookEntry, Payload as _};
use shore::clock;
use std::time::Duration;
use tokio::io::AsyncWriteExt as _;
use tokio::time::{Instant, timeout};
use tokio_tungstenite::tungstenite::Message;

async fn post(shore: &Shore, token: &str, query: &str) -> Ordered {
    let request = format!(
        "POST /api/v1/vessels/2068/abort{query} HTTP/1.1\r\nhost: x\r\nauthorization: Bearer {token}\r\n\
         content-length: 0\r\nconnection: close\r\n\r\n"
    );
    let answer = exchange(shore, &request).await;
    serde_json::from_str(answer.split_once("\r\n\r\n").unwrap().1).expect(&answer)
}

async fn connect(shore: &Shore, token: &str) -> Socket {
    shore.connect("authorization", &format!("Bearer {token}"), "http://anything").await.unwrap()
}

async fn stop(socket: &mut Socket, text: &str) -> LiveStopped {
    socket.send(Message::Text(format!("{{\"stop\":{text}}}").into())).await.unwrap();
    loop {
        if let Message::Text(text) = timeout(DEADLINE, socket.next()).await.unwrap().unwrap().unwrap()
            && let Ok(LiveAnswer::Stop(stopped)) = serde_json::from_str(&text)
        {
            return stopped;
        }
    }
}

/// Number of Aborts that reached the boats so far: those before a mark that is sent after them.
async fn aborts(shore: &Shore) -> usize {
    let mark = packet(1, 255, clock::now(), LogBookEntry::default());
    let mut count = 0;
    let relay = &shore.serving.state.shore.router;
    relay.send(addressed(&mark)).await.unwrap();
    loop {
        for heard in timeout(DEADLINE, shore.boats.heard_all()).await.unwrap() {
            match PacketView::new(&heard).unwrap().id() {
                Abort::ID => count += 1,
                LogBookEntry::ID => return count,
                _ => {}
            }
        }
    }
}

/// A packet of the server's to the first boat.
fn addressed(mark: &[u8]) -> bytes::Bytes {
    let message = imc::decode::<LogBookEntry>(&PacketView::new(mark).unwrap()).unwrap().unwrap();
    let header = imc::Header {
        src: imc::Address(0x4000),
        dst: imc::Address(FIRST),
        timestamp: clock::now().seconds(),
        ..imc::Header::default()
    };
    imc::Packet::new(header, message).encode().unwrap().into()
}

/// The queue of a connection is full.
#[tokio::test]
async fn a_stop_that_finds_no_room_is_said_to_wait_and_is_the_first_to_leave() {
    let shore = Shore::start().await;
    let token = shore.token(Some(FIRST), Role::Operator).await;
    shore.boats.say(boat(0, clock::now())).await;
    let entry = LogBookEntry { text: "x".repeat(60_000).as_str().into(), ..LogBookEntry::default() };
    for number in 0..30 {
        let mark = packet(1, 255, units::UtcTime::from_micros(clock::now().micros() + number), entry.clone());
        shore.serving.state.shore.router.send(addressed(&mark)).await.unwrap();
    }
    shore.boats.say(boat(0, clock::now())).await;
    let ordered = post(&shore, &token, "").await;
    assert!(ordered.waits, "{ordered:?}");
    shore.boats.reopen().await;
    let heard = timeout(DEADLINE, shore.boats.heard_all()).await.unwrap();
    assert_eq!(PacketView::new(&heard[0]).unwrap().id(), Abort::ID);
    let look = move |operations: &mut operations::Operations, _| {
        operations.commands().get(hub::CommandId(ordered.id)).map(operations::Command::stage)
    };
    assert_eq!(
        shore.serving.state.shore.router.inspect(look).await.unwrap(),
        Some(operations::Stage::Waiting),
        "it is not refused"
    );
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stop_that_comes_by_socket_and_request_is_one_stop_with_one_answer() {
    let shore = Shore::start().await;
    shore.boats.say(boat(0, clock::now())).await;
    let token = shore.token(Some(FIRST), Role::Operator).await;
    let mut socket = connect(&shore, &token).await;
    let (by_socket, by_request) = tokio::join!(
        stop(&mut socket, "{\"vessel\":2068,\"window\":\"w\",\"key\":\"one\"}"),
        post(&shore, &token, "?window=w&key=one"),
    );
    assert_eq!((by_socket.vessel, by_socket.key.as_str()), (FIRST, "one"));
    assert_eq!(by_socket.ordered.as_ref(), Some(&by_request), "{by_socket:?}");
    assert!(by_request.reached && !by_request.waits, "{by_request:?}");
    // Repeated over each transport, long after: the answer of the first.
    assert_eq!(post(&shore, &token, "?window=w&key=one").await, by_request);
    let again = stop(&mut socket, "{\"vessel\":2068,\"key\":\"one\"}").await;
    assert_eq!(again.ordered.as_ref(), Some(&by_request));
    assert_eq!(aborts(&shore).await, 1);

    // Another key, no key, and another person's same key are separate stops.
    let second = stop(&mut socket, "{\"vessel\":2068,\"key\":\"two\"}").await.ordered.unwrap();
    let third = post(&shore, &token, "").await;
    let fourth = post(&shore, &token, "").await;
    let admin = shore.token(None, Role::Admin).await;
    let fifth = post(&shore, &admin, "?key=one").await;
    let mut ids: Vec<u64> =
        [&by_request, &second, &third, &fourth, &fifth].iter().map(|one| one.id).collect();
    ids.dedup();
    assert_eq!(ids.len(), 5, "{ids:?}");
    assert_eq!(aborts(&shore).await, 1, "of those that wait for a connection the newest stands for all");
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stop_by_the_socket_is_refused_to_whom_the_request_is() {
    let shore = Shore::start().await;
    shore.boats.say(boat(0, clock::now())).await;
    let viewer = shore.token(Some(FIRST), Role::Researcher).await;
    let mut socket = connect(&shore, &viewer).await;
    let answer = stop(&mut socket, "{\"vessel\":2068,\"key\":\"a\"}").await;
    assert_eq!(answer.ordered, None);
    assert!(answer.refused.unwrap().contains("it takes an operator"));
    let operator = shore.token(Some(FIRST), Role::Operator).await;
    let mut socket = connect(&shore, &operator).await;
    let other = stop(&mut socket, "{\"vessel\":2069,\"key\":\"a\"}").await;
    assert!(other.refused.unwrap().contains("may not stop vessel 2069"));
    let says = other.says.unwrap();
    assert_eq!(says.template, "{name} may not stop vessel {vessel}: it takes an operator.");
    assert_eq!(says.values["vessel"], "2069", "of which pages make their words");
    let long = format!("{{\"vessel\":2068,\"key\":\"{}\"}}", "k".repeat(65));
    assert!(stop(&mut socket, &long).await.refused.unwrap().contains("64 bytes at most"));
    let none = stop(&mut socket, "{\"vessel\":2068,\"key\":\"\"}").await;
    assert!(none.refused.unwrap().contains("a key of its own"));
    assert_eq!(aborts(&shore).await, 0);
}

#[tokio::test(flavor = "multi_thread")]
async fn a_stop_is_carried_out_though_nothing_goes_back_to_its_sender() {
    let shore = Shore::start().await;
    let token = shore.token(None, Role::Operator).await;
    let mut client = Raw::connect(&shore, &token).await;
    client.say(1, b"{\"subscribe\":{\"every_ms\":2}}").await;
    // More than the buffers hold: the client reads nothing, so that a frame of the server stays half sent.
    let text = "x".repeat(60_000);
    for _ in 0..200 {
        let entry = LogBookEntry { text: text.as_str().into(), ..LogBookEntry::default() };
        shore.boats.say(vec![packet(0, 1, clock::now(), entry)]).await;
    }
    client.say(1, b"{\"stop\":{\"vessel\":2068,\"key\":\"blind\"}}").await;
    timeout(Duration::from_secs(5), shore.boats.heard(Abort::ID)).await.expect("the vessel was stopped");
}

/// Pages of this process in memory, bytes.
fn resident_bytes() -> u64 {
    let pages = std::fs::read_to_string("/proc/self/statm").unwrap();
    pages.split(' ').nth(1).unwrap().parse::<u64>().unwrap() * 4_096
}

#[tokio::test(flavor = "multi_thread")]
async fn who_sends_pings_and_takes_nothing_fills_no_memory_and_is_let_go() {
    let shore = Shore::start().await;
    let token = shore.token(None, Role::Viewer).await;
    let mut client = Raw::connect(&shore, &token).await;
    let ping = [&[0x89, 0xFD, 0, 0, 0, 0][..], &[7; 125]].concat();
    let many = ping.repeat(1_000);
    let (before, begun, mut sent) = (resident_bytes(), Instant::now(), 0);
    // The buffers hold some MiB; a server that continues to read would take all of it.
    while sent < 400 << 20 {
        let written = timeout(DEADLINE, client.0.write_all(&many)).await;
        if written.expect("it is let go in time").is_err() {
            break;
        }
        sent += many.len();
    }
    let grown = resident_bytes().saturating_sub(before);
    assert!(sent < 100 << 20, "the server read {sent} bytes of pings from who takes no answer");
    assert!(grown < 32 << 20, "{grown} bytes of memory");
    assert!(begun.elapsed() < DEADLINE, "{:?}", begun.elapsed());
    println!("{sent} bytes of pings taken, {grown} bytes of memory more, let go after {:?}", begun.elapsed());
}

#[tokio::test(flavor = "multi_thread")]
async fn pings_whose_answers_nobody_takes_fill_no_memory_at_any_socket() {
    let shore = Shore::start().await;
    let (operator, link) = (shore.token(None, Role::Operator).await, shore.link_token(FIRST).await);
    let ping = [&[0x89, 0xFD, 0, 0, 0, 0][..], &[7; 125]].concat().repeat(1_000);
    let steering = format!("/api/v1/vessels/{FIRST}/teleop");
    for (path, token) in [("/link", &link), (steering.as_str(), &operator)] {
        let mut client = Raw::to(&shore, path, token).await;
        let (before, mut sent) = (resident_bytes(), 0);
        while sent < 64 << 20 {
            // A server that disconnects, or stops reading, fills no memory either.
            match timeout(Duration::from_secs(2), client.0.write_all(&ping)).await {
                Ok(Ok(())) => sent += ping.len(),
                Ok(Err(_)) | Err(_) => break,
            }
        }
        let grown = resident_bytes().saturating_sub(before);
        assert!(grown < 24 << 20, "{path}: {grown} bytes of memory for {sent} bytes of pings");
    }
}
