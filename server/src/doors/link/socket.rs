//! One connection of a vessel.

use super::{Event, Links, OUTGOING, Out};
use crate::http::guard::LinkOf;
use crate::shore::AppState;
use axum::extract::State;
use axum::extract::ws::{CloseFrame, Message, WebSocket, WebSocketUpgrade, close_code};
use axum::response::Response;
use futures_util::stream::{SplitSink, SplitStream};
use futures_util::{SinkExt as _, StreamExt as _};
use link::{ConnectionId, DEAD_AFTER, MAX_MESSAGE_BYTES};
use std::time::Duration;
use tokio::sync::mpsc;

/// How long good-bye may take.
const GOOD_BYE: Duration = Duration::from_secs(1);

/// `GET /link`, by a vessel whose token was looked at.
pub(crate) async fn open(
    State(state): State<AppState>,
    LinkOf(vessel): LinkOf,
    upgrade: WebSocketUpgrade,
) -> Response {
    let (links, tasks) = (state.links, state.tasks);
    upgrade
        .max_message_size(MAX_MESSAGE_BYTES)
        .max_frame_size(MAX_MESSAGE_BYTES)
        .on_upgrade(move |socket| tasks.track_future(serve(links, vessel, socket)))
}

async fn serve(links: Links, vessel: u16, socket: WebSocket) {
    let (id, events) = (links.next_connection(), links.vessel(vessel));
    let (sender, outgoing) = mpsc::channel(OUTGOING);
    if events.send(Event::Opened(id, sender)).await.is_err() {
        return;
    }
    let (sink, stream) = socket.split();
    tokio::select! {
        () = receive(stream, id, &events) => {}
        () = send(sink, outgoing) => {}
    }
    events.send(Event::Closed(id)).await.ok();
}

/// Hands on what comes. The session decides when silence is death; this ends with the socket.
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

/// Writes what the vessel's task says until it closes the connection.
async fn send(mut sink: SplitSink<WebSocket, Message>, mut outgoing: mpsc::Receiver<Out>) {
    let mut reason = String::new();
    while let Some(out) = outgoing.recv().await {
        match out {
            Out::Message(bytes) => {
                // A socket that takes nothing for so long is dead, whatever TCP hopes.
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
