//! `/api/v1/vessels/{vessel}/teleop`: the WebSocket of [`Steering`].

use crate::AppState;
use crate::web::outgoing::{self, Upgrade};
use crate::web::{OfVessel, Remote, Who, identify};
use api::{Role, TeleopMessage};
use axum::extract::State;
use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use axum::http::HeaderMap;
use axum::response::Response;
use imc::Address;
use shore::commands::Issuer;
use shore::commands::steering::Steering;
use shore::router::Stopped;
use std::time::Duration;
use tokio::time::MissedTickBehavior;

/// Bytes that a browser may send at once.
const SAY_BYTES: usize = 2 * 1024;
/// Bytes that may wait in the socket of a browser that takes nothing.
const WAITING_BYTES: usize = 64 * 1024;
/// Period at which the server processes its input and answers.
const TICK: Duration = Duration::from_millis(50);
/// A browser that reads nothing for this long is disconnected.
const PATIENCE: Duration = Duration::from_secs(1);
/// Number of ticks, one each [`TICK`], without a message from the browser after which it is disconnected and the helm is
/// released: 3 s. Counted in ticks, not time, as messages are not read while the server itself is delayed.
const SILENT_LOOKS: u32 = 60;
/// Permissions are checked at least this often.
const RIGHTS_EVERY: Duration = Duration::from_secs(30);

/// `GET /api/v1/vessels/{vessel}/teleop`.
pub(crate) async fn socket(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    Who(who): Who,
    remote: Remote,
    headers: HeaderMap,
    Upgrade(upgrade): Upgrade,
) -> Response {
    outgoing::bounded(upgrade, SAY_BYTES, WAITING_BYTES).on_upgrade(move |socket| {
        let tasks = state.shore.tasks.clone();
        let by = Issuer { who, from: remote.address.to_string(), window: String::new() };
        let steering = state.shore.steering(vessel, by);
        let connection = Connection { state, vessel, remote, headers, silent: 0 };
        tasks.track_future(connection.run(steering, socket))
    })
}

/// Why the socket is closed: close code and reason.
type End = (u16, &'static str);

struct Connection {
    state: AppState,
    vessel: Address,
    remote: Remote,
    headers: HeaderMap,
    /// Ticks since the browser's last message.
    silent: u32,
}

impl Connection {
    async fn run(mut self, mut steering: Steering, mut socket: WebSocket) {
        let (code, reason) = self.converse(&mut steering, &mut socket).await;
        let why = if reason.is_empty() { "the window was closed or its connection broke" } else { reason };
        steering.close(why).await;
        let close = Message::Close(Some(CloseFrame { code, reason: reason.into() }));
        tokio::time::timeout(PATIENCE, socket.send(close)).await.ok();
    }

    async fn converse(&mut self, steering: &mut Steering, socket: &mut WebSocket) -> End {
        let mut tick = tokio::time::interval(TICK);
        tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut rights = self.state.shore.people.changes();
        let mut rights_due = tokio::time::interval(RIGHTS_EVERY);
        loop {
            let step = tokio::select! {
                // Ticks come first, so that a flood of samples cannot delay a stop.
                biased;
                () = self.state.shore.stop.cancelled() => Err((close_code::AWAY, "the server is stopping")),
                _ = tick.tick() => self.tick(steering, socket).await,
                _ = rights.changed() => self.check_rights(steering).await,
                _ = rights_due.tick() => self.check_rights(steering).await,
                message = socket.recv() => self.on_message(steering, message).await,
            };
            if let Err(end) = step {
                return end;
            }
        }
    }

    /// Takes what the browser sent.
    async fn on_message(
        &mut self,
        steering: &mut Steering,
        message: Option<Result<Message, axum::Error>>,
    ) -> Result<(), End> {
        self.silent = 0;
        let text = match message {
            Some(Ok(Message::Text(text))) => text,
            Some(Ok(Message::Ping(_) | Message::Pong(_))) => return Ok(()),
            Some(Ok(Message::Binary(_))) => return Err((close_code::UNSUPPORTED, "send JSON as text")),
            Some(Ok(Message::Close(_)) | Err(_)) | None => return Err((close_code::NORMAL, "")),
        };
        match serde_json::from_str(&text) {
            Ok(TeleopMessage::Sample(sample)) => steering.sample(&sample).await.map_err(stopping),
            Ok(TeleopMessage::Begin { window }) => {
                steering.begin(window).await;
                Ok(())
            }
            Ok(TeleopMessage::Stop { why }) => steering.interrupt(why).await.map_err(stopping),
            Ok(TeleopMessage::End {}) => {
                steering.end().await;
                Ok(())
            }
            Err(_) => Err((close_code::POLICY, "not understood: /api/v1/openapi.json tells all")),
        }
    }

    /// Stops on stale sticks, and answers.
    async fn tick(&mut self, steering: &mut Steering, socket: &mut WebSocket) -> Result<(), End> {
        self.silent += 1;
        if self.silent > SILENT_LOOKS {
            // A computer that lost its network does not close the connection.
            return Err((close_code::POLICY, "nothing came from the window for 3 s"));
        }
        let told = steering.tick().await.map_err(stopping)?;
        let text = serde_json::to_string(&told).map_err(|_| (close_code::ERROR, "the server failed"))?;
        match tokio::time::timeout(PATIENCE, socket.send(Message::Text(text.into()))).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err((close_code::NORMAL, "")),
            Err(_) => Err((close_code::POLICY, "too slow: the window took nothing for 1 s")),
        }
    }

    /// Whether the person may still steer.
    async fn check_rights(&mut self, steering: &mut Steering) -> Result<(), End> {
        let ended = (close_code::POLICY, "not allowed any more");
        let who = match identify(&self.state, &self.headers, self.remote).await {
            Ok(who) => who.ok_or(ended)?,
            Err(error) if error.status.is_server_error() => return Ok(()),
            Err(_) => return Err(ended),
        };
        if who.grants.on(self.vessel.0) < Some(Role::Operator) {
            return Err(ended);
        }
        steering.is_of(who);
        Ok(())
    }
}

fn stopping(_: Stopped) -> End {
    (close_code::AWAY, "the server is stopping")
}
