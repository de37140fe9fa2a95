//! `/api/live`: the fleet as it changes, over a WebSocket.
//!
//! The socket's task queries the fleet for changes since the revision it sent last, not more often than its client
//! requests, so that a slow client gets the latest values and delays no other. Each frame is followed by a ping, which
//! every client answers automatically: frames whose ping was not answered are in flight, and their number is limited, or a
//! slow network would deliver old data. At least once a second a frame is sent, by which the client knows that the server
//! is alive. When any user's permissions change, the task checks its own again.
//!
//! The client's messages are read concurrently, so that a stop is carried out however long a frame, or a check of
//! permissions, takes. Only a client that does not read, or that sends too many messages, is not read.

mod compact;

use self::compact::Compact;
use crate::AppState;
use crate::web::{
    ApiError, Remote, Who, identify,
    outgoing::Ended,
    outgoing::Outgoing,
    outgoing::PATIENCE,
    outgoing::{Upgrade, bounded},
};
use api::{
    LiveAnswer, LiveFrame, LiveRequest, LiveStop, LiveStopped, Role, Subscription, System, Update, say,
};
use axum::extract::State;
use axum::extract::ws::{CloseFrame, Message, WebSocket, close_code};
use axum::http::HeaderMap;
use axum::response::Response;
use bytes::Bytes;
use futures_util::StreamExt as _;
use futures_util::stream::{FuturesUnordered, SplitStream};
use imc::Address;
use shore::commands::{Issuer, Stop};
use shore::identity::{Principal, Via};
use shore::{Wanted, alarms};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::time::Duration;
use tokio::sync::{mpsc, watch};
use tokio::time::Instant;
use tokio_tungstenite::tungstenite;

/// Bytes of a request at most.
const REQUEST_BYTES: usize = 64 * 1024;
/// Bytes that are read of a longer one, so that its client also gets the reason why the socket is closed.
const READ_BYTES: usize = 1 << 20;
/// A frame is sent at least so often.
const HEARTBEAT: Duration = Duration::from_secs(1);
/// The state of systems is sent not more often than this: each of their packets changes it a little.
const SYSTEMS_EVERY: Duration = Duration::from_millis(100);
/// Most frames in flight to a client: enough for ten a second with a round trip of 300 ms.
const ON_THE_WAY: u64 = 4;
/// Permissions are checked at least this often, as tokens and sessions also expire.
const RIGHTS_EVERY: Duration = Duration::from_secs(30);
/// Addresses and names in a subscription at most.
const LISTED: usize = 1_000;
/// Bytes of the largest frame.
const FRAME_BYTES: usize = 64 << 20;
/// Most unanswered messages of a client, and most stops that wait for their outcome; beyond either it is not read.
const WAITING_MESSAGES: usize = 64;
const STOPS: usize = 32;

/// `GET /api/live`.
pub(crate) async fn socket(
    State(state): State<AppState>,
    Who(who): Who,
    remote: Remote,
    headers: HeaderMap,
    Upgrade(upgrade): Upgrade,
) -> Response {
    bounded(upgrade, READ_BYTES, FRAME_BYTES).on_upgrade(move |socket| {
        let tasks = state.shore.tasks.clone();
        let client = Client::new(state, who, remote, headers);
        tasks.track_future(client.run(socket))
    })
}

/// An event from the reading half, for the sending half.
enum ClientMessage {
    Subscribe(Subscription),
    Pinged,
    /// A ping of ours was answered.
    Answered(Bytes),
    /// It stops a vessel.
    Stop(LiveStop, Result<Stop, ApiError>),
}

/// The half that reads.
struct Listener {
    state: AppState,
    who: watch::Receiver<Principal>,
    from: String,
    told: mpsc::Sender<ClientMessage>,
}

struct Client {
    state: AppState,
    who: watch::Sender<Principal>,
    remote: Remote,
    /// The client's credentials at connection, to be checked again.
    headers: HeaderMap,
    wanted: Option<Arc<Wanted>>,
    every: Duration,
    /// The stream of compact frames, once the client has requested them, and whether it wants them now.
    compact: Option<Compact>,
    is_compact: bool,
    /// The last revision sent to the client; 0 for none.
    known: u64,
    /// The same for leases, commands and alarms.
    known_control: (u64, u64, u64),
    /// Number of values of each series when it was sent last, to count skipped ones.
    counts: BTreeMap<(u16, u16, u8, Option<u8>), u64>,
    /// The last sent state of each system, and when it may be sent again.
    systems: BTreeMap<u16, System>,
    systems_not_before: Instant,
    /// When the next frame may be sent, and when it must.
    not_before: Instant,
    not_after: Instant,
    /// Number of frames sent, number arrived, and when the last of either was.
    sent: u64,
    arrived: u64,
    moved: Instant,
}

/// Why a socket is closed: close code and reason.
type End = (u16, &'static str);
const TOO_SLOW: End = (close_code::POLICY, "too slow");

const TOO_LARGE: End =
    (close_code::SIZE, "a request has 65536 bytes at most; list fewer systems and messages");

const NOT_UNDERSTOOD: End = (
    close_code::POLICY,
    "not understood: send {\"subscribe\": {}} or {\"stop\": {\"vessel\": 1, \"key\": \"a\"}}",
);

impl From<Ended> for End {
    fn from(ended: Ended) -> Self {
        match ended {
            Ended::TooSlow => TOO_SLOW,
            Ended::Gone => (close_code::NORMAL, ""),
        }
    }
}

/// Whether a message was too long to be read at all.
fn is_too_large(error: &axum::Error) -> bool {
    let cause = std::error::Error::source(error).and_then(|cause| cause.downcast_ref());
    matches!(cause, Some(tungstenite::Error::Capacity(_)))
}

impl Listener {
    /// Reads until the client leaves or sends an invalid message.
    async fn listen(self, mut stream: SplitStream<WebSocket>) -> End {
        loop {
            let said = match self.understand(stream.next().await) {
                Ok(said) => said,
                Err(end) => return end,
            };
            if let Some(said) = said
                && self.told.send(said).await.is_err()
            {
                return (close_code::NORMAL, "");
            }
        }
    }

    fn understand(
        &self,
        message: Option<Result<Message, axum::Error>>,
    ) -> Result<Option<ClientMessage>, End> {
        let text = match message {
            Some(Ok(Message::Text(text))) if text.len() > REQUEST_BYTES => return Err(TOO_LARGE),
            Some(Ok(Message::Binary(bytes))) if bytes.len() > REQUEST_BYTES => return Err(TOO_LARGE),
            Some(Err(error)) if is_too_large(&error) => return Err(TOO_LARGE),
            Some(Ok(Message::Text(text))) => text,
            Some(Ok(Message::Ping(_))) => return Ok(Some(ClientMessage::Pinged)),
            Some(Ok(Message::Pong(answer))) => return Ok(Some(ClientMessage::Answered(answer))),
            Some(Ok(Message::Binary(_))) => return Err((close_code::UNSUPPORTED, "send JSON as text")),
            Some(Ok(Message::Close(_)) | Err(_)) | None => return Err((close_code::NORMAL, "")),
        };
        match serde_json::from_str(&text).map_err(|_| NOT_UNDERSTOOD)? {
            LiveRequest::Subscribe(subscription) => {
                let Subscription { systems, messages, of_others, .. } = &subscription;
                let names = [messages, of_others].into_iter().flatten().map(Vec::len).sum::<usize>();
                let listed = systems.as_ref().map_or(0, Vec::len) + names;
                if listed > LISTED {
                    return Err((close_code::POLICY, "too many systems and messages listed"));
                }
                Ok(Some(ClientMessage::Subscribe(subscription)))
            }
            LiveRequest::Stop(ask) => {
                let stop = self.stop(&ask);
                Ok(Some(ClientMessage::Stop(ask, stop)))
            }
        }
    }

    /// Begins to stop a vessel, before anything else is processed.
    fn stop(&self, ask: &LiveStop) -> Result<Stop, ApiError> {
        let who = self.who.borrow().clone();
        if who.grants.on(ask.vessel) < Some(Role::Operator) {
            let text = say("{name} may not stop vessel {vessel}: it takes an operator.");
            return Err(ApiError::forbidden(text.with("name", &who.name).with("vessel", ask.vessel)));
        }
        if ask.key.is_empty() {
            return Err(ApiError::bad_request(say("key: give each stop a key of its own")));
        }
        let by = Issuer { who, from: self.from.clone(), window: ask.window.clone() };
        Ok(self.state.shore.commands.begin_stop(Address(ask.vessel), by, &ask.key)?)
    }
}

/// The outcome of a stop, as sent to the client.
async fn answered(LiveStop { vessel, key, .. }: LiveStop, stop: Result<Stop, ApiError>) -> LiveAnswer {
    let outcome = match stop {
        Ok(stop) => stop.outcome().await.map_err(ApiError::from),
        Err(refused) => Err(refused),
    };
    let (ordered, refused, says) = match outcome {
        Ok(ordered) => (Some(ordered), None, None),
        Err(error) => {
            let (text, says) = error.text.into_parts();
            (None, Some(text), says)
        }
    };
    LiveAnswer::Stop(LiveStopped { vessel, key, ordered, refused, says })
}

impl Client {
    fn new(state: AppState, who: Principal, remote: Remote, headers: HeaderMap) -> Self {
        let now = Instant::now();
        Self {
            state,
            who: watch::Sender::new(who),
            remote,
            headers,
            wanted: None,
            every: Duration::from_millis(100),
            compact: None,
            is_compact: false,
            known: 0,
            known_control: (0, 0, 0),
            counts: BTreeMap::new(),
            systems: BTreeMap::new(),
            systems_not_before: now,
            not_before: now,
            not_after: now + HEARTBEAT,
            sent: 0,
            arrived: 0,
            moved: now,
        }
    }

    async fn run(mut self, socket: WebSocket) {
        metrics::gauge!("lutra_live_clients").increment(1);
        let (sink, stream) = socket.split();
        let (told, said) = mpsc::channel(WAITING_MESSAGES);
        let from = self.remote.address.to_string();
        let listener = Listener { state: self.state.clone(), who: self.who.subscribe(), from, told };
        let mut out = Outgoing::new(sink);
        let (code, reason) = tokio::select! {
            end = listener.listen(stream) => end,
            end = self.converse(&mut out, said) => end,
        };
        metrics::gauge!("lutra_live_clients").decrement(1);
        let close = Message::Close(Some(CloseFrame { code, reason: reason.into() }));
        let good_bye = async { out.put(close).await.is_ok() && out.flushed().await.is_ok() };
        tokio::time::timeout(Duration::from_secs(1), good_bye).await.ok();
    }

    async fn converse(&mut self, out: &mut Outgoing, mut said: mpsc::Receiver<ClientMessage>) -> End {
        let mut revision = self.state.shore.fleet.revision();
        let mut rights = self.state.shore.people.changes();
        let mut rights_due = tokio::time::interval(RIGHTS_EVERY);
        let mut stops = FuturesUnordered::new();
        loop {
            // While a message has not been sent, none is queued behind it and no more are read.
            let free = !out.waits();
            let step = tokio::select! {
                left = out.flushed(), if !free => self.left(left),
                Some(said) = said.recv(), if free && stops.len() < STOPS => {
                    match said {
                        ClientMessage::Subscribe(subscription) => self.subscribe(subscription),
                        ClientMessage::Pinged => out.answers_ping(),
                        ClientMessage::Answered(answer) => self.answered(&answer),
                        ClientMessage::Stop(ask, stop) => stops.push(answered(ask, stop)),
                    }
                    Ok(())
                }
                Some(answer) = stops.next(), if free => tell(out, &answer).await,
                () = due(self.not_before, self.not_after, &mut revision), if free && self.wanted.is_some() && !self.full() => {
                    self.send(out).await
                }
                () = tokio::time::sleep_until(self.moved + PATIENCE), if free && self.full() => Err(TOO_SLOW),
                _ = rights.changed() => self.check_rights().await,
                _ = rights_due.tick() => self.check_rights().await,
                () = self.state.shore.stop.cancelled() => Err((close_code::AWAY, "the server is stopping")),
            };
            if let Err(end) = step {
                return end;
            }
        }
    }

    /// The queued messages have been sent, or sending has failed.
    fn left(&mut self, left: Result<(), Ended>) -> Result<(), End> {
        self.moved = Instant::now();
        left.map_err(End::from)
    }

    fn subscribe(&mut self, asked: Subscription) {
        let Subscription { systems, messages, of_others, events, every_ms, compact } = asked;
        // The stream of a connection continues across subscriptions.
        if compact && self.compact.is_none() {
            self.compact = Some(Compact::new());
        }
        self.is_compact = compact;
        self.every = Duration::from_millis(u64::from(every_ms.clamp(2, 10_000)));
        (self.known, self.known_control) = (0, (0, 0, 0));
        self.counts.clear();
        // At once, but not faster than its requested rate, however often it subscribes.
        self.not_after = self.not_before.max(Instant::now());
        self.wanted = Some(Arc::new(Wanted {
            grants: self.who.borrow().grants.clone(),
            systems: systems.map(|systems| systems.into_iter().collect()),
            messages: messages.map(|messages| messages.into_iter().collect()),
            of_others: of_others.map(|messages| messages.into_iter().collect()),
            events,
        }));
    }

    /// Whether the limit of frames in flight is reached.
    fn full(&self) -> bool {
        self.sent - self.arrived >= ON_THE_WAY
    }

    /// A ping was answered: its frame and those before it have arrived.
    fn answered(&mut self, answer: &[u8]) {
        let Ok(number) = answer.try_into().map(u64::from_be_bytes) else { return };
        if number > self.arrived && number <= self.sent {
            self.arrived = number;
            self.moved = Instant::now();
        }
    }

    /// Sends what changed.
    async fn send(&mut self, out: &mut Outgoing) -> Result<(), End> {
        let Some(wanted) = self.wanted.clone() else { return Ok(()) };
        let gone = (close_code::AWAY, "the server is stopping");
        let (begun, snapshot) = (Instant::now(), self.known == 0);
        let described = snapshot || begun >= self.systems_not_before;
        let mut changes = self
            .state
            .shore
            .fleet
            .changes(self.known, self.known_control, wanted, described)
            .await
            .ok_or(gone)?;
        alarms::name(&self.state.shore.people, &mut changes.alarms);
        if described {
            self.systems_not_before = begun + SYSTEMS_EVERY;
            if snapshot {
                self.systems.clear();
            }
            changes.systems.retain(|system| self.systems.get(&system.address) != Some(system));
            self.systems.extend(changes.systems.iter().map(|system| (system.address, system.clone())));
        }
        let skipped = changes.values.iter().map(|value| self.skipped(value)).sum();
        let frame = LiveFrame {
            now_us: self.state.shore.clock.utc().micros(),
            snapshot,
            systems: changes.systems,
            values: changes.values,
            series: Vec::new(),
            samples: Vec::new(),
            events: changes.events,
            detections: changes.detections,
            skipped,
            events_missed: changes.events_missed,
            leases: changes.leases,
            commands: changes.commands,
            alarms: changes.alarms,
            recording: self.state.shore.recorder.state().borrow().problem(),
        };
        self.known = changes.revision.max(1);
        self.known_control = changes.control;
        let message = match self.compact.as_mut().filter(|_| self.is_compact) {
            Some(compact) => compact.message(frame).map(Message::Binary),
            None => serde_json::to_string(&frame).map(|text| Message::Text(text.into())),
        };
        let message = message.map_err(|_| (close_code::ERROR, "the server failed"))?;
        self.sent += 1;
        let ping = Message::Ping(Bytes::copy_from_slice(&self.sent.to_be_bytes()));
        for message in [message, ping] {
            out.put(message).await?;
        }
        let now = Instant::now();
        self.moved = now;
        self.not_before = now + self.every;
        self.not_after = now + HEARTBEAT.max(self.every);
        Ok(())
    }

    /// Number of values of a series that were skipped since it was sent last.
    fn skipped(&mut self, value: &Update) -> u64 {
        let key = (value.system, value.id, value.entity, value.instance);
        let before = self.counts.insert(key, value.count);
        before.map_or(0, |before| value.count.saturating_sub(before + 1))
    }

    /// Checks whether the client is still authorised, and updates what it may see.
    async fn check_rights(&mut self) -> Result<(), End> {
        let ended = (close_code::POLICY, "not logged in any more");
        let who = match identify(&self.state, &self.headers, self.remote).await {
            Ok(who) => who.ok_or(ended)?,
            Err(ApiError { status, .. }) if status.is_server_error() => return Ok(()),
            Err(_) => return Err(ended),
        };
        if matches!(who.via, Via::Session { must_change_password: true, .. })
            || who.grants.somewhere().is_none()
        {
            return Err(ended);
        }
        if who.grants != self.who.borrow().grants {
            if let Some(wanted) = &self.wanted {
                self.wanted = Some(Arc::new(Wanted { grants: who.grants.clone(), ..Wanted::clone(wanted) }));
            }
            (self.known, self.known_control) = (0, (0, 0, 0));
            self.who.send_replace(who);
        }
        Ok(())
    }
}

/// Sends an answer.
async fn tell(out: &mut Outgoing, answer: &LiveAnswer) -> Result<(), End> {
    let text = serde_json::to_string(answer).map_err(|_| (close_code::ERROR, "the server failed"))?;
    Ok(out.put(Message::Text(text.into())).await?)
}

/// Waits until a frame may be sent and there is something new, or until one must be sent.
async fn due(not_before: Instant, not_after: Instant, revision: &mut watch::Receiver<u64>) {
    let changed = async {
        tokio::time::sleep_until(not_before).await;
        if revision.changed().await.is_err() {
            std::future::pending::<()>().await;
        }
    };
    tokio::select! {
        () = changed => {}
        () = tokio::time::sleep_until(not_after) => {}
    }
}
