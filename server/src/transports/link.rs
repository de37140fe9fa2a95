//! One connection of a vessel.

use crate::AppState;
use crate::web::LinkOf;
use crate::web::outgoing::{self, Upgrade};
use axum::extract::State;
use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use axum::http::{HeaderMap, header};
use axum::response::Response;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt as _, StreamExt as _};
use link::{ConnectionId, DEAD_AFTER, MAX_MESSAGE_BYTES};
use shore::identity::People;
use shore::links::{Event, Links, OUTGOING, Out};
use std::time::Duration;
use tokio::sync::mpsc;

/// Time limit for closing.
const GOOD_BYE: Duration = Duration::from_secs(1);
/// Bytes that may be queued in a connection's socket: two of the longest messages. A vessel that pings and does not read
/// gets one pong for all of its pings.
const WAITING_BYTES: usize = 2 * MAX_MESSAGE_BYTES;
/// How often a connection's token is checked again: a revoked or expired one must not keep a connection open.
const LOOK: Duration = Duration::from_secs(5);

/// `GET /link`, by a vessel whose token was checked.
pub(crate) async fn open(
    State(state): State<AppState>,
    LinkOf(vessel): LinkOf,
    headers: HeaderMap,
    Upgrade(upgrade): Upgrade,
) -> Response {
    let (links, tasks) = (state.shore.links.clone(), state.shore.tasks.clone());
    let given = headers.get(header::AUTHORIZATION).and_then(|given| given.to_str().ok());
    let token = given.and_then(|given| given.strip_prefix("Bearer ")).unwrap_or_default().trim().to_owned();
    let invalid = until_invalid(state.shore.people.clone(), token, vessel);
    outgoing::bounded(upgrade, MAX_MESSAGE_BYTES, WAITING_BYTES)
        .on_upgrade(move |socket| tasks.track_future(serve(links, vessel, socket, invalid)))
}

async fn serve(links: Links, vessel: u16, socket: WebSocket, invalid: impl Future<Output = ()>) {
    let (id, events) = (links.next_connection(), links.vessel(vessel));
    let (sender, outgoing) = mpsc::channel(OUTGOING);
    if events.send(Event::Opened(id, sender)).await.is_err() {
        return;
    }
    let (sink, stream) = socket.split();
    tokio::select! {
        () = receive(stream, id, &events) => {}
        () = send(sink, outgoing) => {}
        () = invalid => tracing::warn!(vessel = %imc::Address(vessel), "its token does not hold any more"),
    }
    events.send(Event::Closed(id)).await.ok();
}

/// Waits until a token is no longer valid for `vessel`.
async fn until_invalid(people: People, token: String, vessel: u16) {
    loop {
        tokio::time::sleep(LOOK).await;
        // A database error is no reason to disconnect a vessel.
        if people.by_link_token(&token).await.is_ok_and(|holder| holder != Some(vessel)) {
            return;
        }
    }
}

/// Passes messages on. The session decides when a silent connection is dead; this ends with the socket.
async fn receive(mut stream: SplitStream<WebSocket>, id: ConnectionId, events: &mpsc::Sender<Event>) {
    while let Some(Ok(message)) = stream.next().await {
        match message {
            Message::Binary(bytes) => {
                if events.send(Event::Message(id, bytes)).await.is_err() {
                    return;
                }
            }
            Message::Close(_) => return,
            Message::Text(_) | Message::Ping(_) | Message::Pong(_) => {}
        }
    }
}

/// Writes the messages of the vessel's task until it closes the connection.
async fn send(mut sink: SplitSink<WebSocket, Message>, mut outgoing: mpsc::Receiver<Out>) {
    let mut reason = String::new();
    while let Some(out) = outgoing.recv().await {
        match out {
            Out::Message(bytes) => {
                // A socket that accepts nothing for this long is dead, whatever TCP reports.
                let sent = tokio::time::timeout(DEAD_AFTER, sink.send(Message::Binary(bytes))).await;
                if !matches!(sent, Ok(Ok(()))) {
                    return;
                }
            }
            Out::Close(why) => {
                reason = why;
                break;
            }
        }
    }
    let close = CloseFrame { code: close_code::NORMAL, reason: reason.into() };
    tokio::time::timeout(GOOD_BYE, sink.send(Message::Close(Some(close)))).await.ok();
}
