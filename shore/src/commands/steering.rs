//! `/api/v1/vessels/{vessel}/teleop`: a person steers a vessel by hand, over a WebSocket.
//!
//! [`hub::Teleop`] decides what goes to the vessel; here are its socket, its clock and its doors. A stick position goes
//! out only while this window has control, by the vessel's link with a time to live, else by the door behind which the
//! vessel is heard. However the conversation ends, the vessel is told to stop and that steering by hand is over; when it
//! cannot be told, the life of the last stick position ends aboard. When control is lost the link itself stops the
//! vessel; one that is reached otherwise knows of no control, and is told to stop. Either is told that it is not steered by
//! hand any more, so that it does not wait in that mode for hands that nobody has there: whoever has control now begins anew.

mod to_vessel;

use self::to_vessel::{dispatch, keys, release};
use super::caller::Caller;
use super::guard::{OfVessel, Who, identify};
use super::orders::{Issuer, issue, running};
use super::outgoing;
use crate::people::Line;
use crate::shore::{AppState, Helm};
use api::{Role, TeleopPhase, TeleopSample, TeleopSay, TeleopStop, TeleopTold};
use axum::extract::State;
use axum::extract::ws::{CloseFrame, Message, WebSocket, WebSocketUpgrade, close_code};
use axum::http::HeaderMap;
use axum::response::Response;
use hub::{CommandId, Hub, Order, Stage, Sticks, TELEOPERATION_PLAN, Teleop, TeleopState, Why};
use imc::Address;
use std::time::Duration;
use tokio::time::MissedTickBehavior;
use units::{MonoTime, UtcTime};

/// Bytes that a browser may send at once.
const SAY_BYTES: usize = 2 * 1024;
/// Bytes that may wait in the socket of a browser that takes nothing.
const WAITING_BYTES: usize = 64 * 1024;
/// How often the server looks at what it has, and answers.
const TICK: Duration = Duration::from_millis(50);
/// A stop is still worth delivering after this, unlike a stick position.
const STOP_LASTS: Duration = Duration::from_secs(2);
/// A vessel that says nothing for so long is not steered: it says something many times a second.
const HEARD_WITHIN: Duration = hub::BUDGET;
/// A browser that takes nothing for so long is let go.
const PATIENCE: Duration = Duration::from_secs(1);
/// Looks without a word from the browser, one each [`TICK`], after which it is let go, and the helm with it: 3 s. What
/// holds up the server lets no time pass here, as what came meanwhile is not read yet.
const SILENT_LOOKS: u32 = 60;
/// Rights are looked at again at least so often.
const RIGHTS_EVERY: Duration = Duration::from_secs(30);

/// `GET /api/v1/vessels/{vessel}/teleop`.
pub(crate) async fn socket(
    State(state): State<AppState>,
    OfVessel(vessel): OfVessel,
    Who(who): Who,
    caller: Caller,
    headers: HeaderMap,
    upgrade: WebSocketUpgrade,
) -> Response {
    outgoing::bounded(upgrade, SAY_BYTES, WAITING_BYTES).on_upgrade(move |socket| {
        let tasks = state.tasks.clone();
        let late = state.links.late_sticks(vessel);
        let by = Issuer { who, from: caller.address.to_string(), window: String::new() };
        let session = Session {
            state,
            vessel,
            by,
            caller,
            headers,
            teleop: Teleop::new(),
            phase: Phase::Idle,
            helm: None,
            late,
            said: (String::new(), ""),
            silent: 0,
        };
        tasks.track_future(session.run(socket))
    })
}

/// Why the socket is closed: code and words of the protocol.
type End = (u16, &'static str);

#[derive(Debug, Clone, Copy)]
enum Phase {
    Idle,
    /// The vessel was asked.
    Starting(CommandId),
    /// It is in the sticks' hands.
    Live,
}

struct Session {
    state: AppState,
    vessel: Address,
    by: Issuer,
    caller: Caller,
    headers: HeaderMap,
    teleop: Teleop,
    phase: Phase,
    /// This window's place while it is not idle.
    helm: Option<Helm>,
    /// Stick positions that the vessel got too late or never, as counted by its link.
    late: u64,
    /// Why it is not begun, or ended, and what to do about that.
    said: (String, &'static str),
    /// Looks since the browser said something.
    silent: u32,
}

/// What the hub says when it is asked to steer.
struct Looked {
    may: bool,
    running: bool,
    heard: bool,
    begun: Option<(Stage, String)>,
}

impl Session {
    async fn run(mut self, mut socket: WebSocket) {
        let (code, reason) = self.converse(&mut socket).await;
        self.teleop.interrupt(Why::Person);
        let why = if reason.is_empty() { "the window was closed or its connection broke" } else { reason };
        self.finish(why, "").await;
        let close = Message::Close(Some(CloseFrame { code, reason: reason.into() }));
        tokio::time::timeout(PATIENCE, socket.send(close)).await.ok();
    }

    async fn converse(&mut self, socket: &mut WebSocket) -> End {
        let mut tick = tokio::time::interval(TICK);
        tick.set_missed_tick_behavior(MissedTickBehavior::Delay);
        let mut rights = self.state.people.changes();
        let mut rights_due = tokio::time::interval(RIGHTS_EVERY);
        loop {
            let step = tokio::select! {
                // What is due stops for certain; a flood of samples does not hold it up.
                biased;
                () = self.state.stop.cancelled() => Err((close_code::AWAY, "the server is stopping")),
                _ = tick.tick() => self.tick(socket).await,
                _ = rights.changed() => self.check_rights().await,
                _ = rights_due.tick() => self.check_rights().await,
                said = socket.recv() => self.heed(said).await,
            };
            if let Err(end) = step {
                return end;
            }
        }
    }

    /// Takes what the browser sent.
    async fn heed(&mut self, said: Option<Result<Message, axum::Error>>) -> Result<(), End> {
        self.silent = 0;
        let text = match said {
            Some(Ok(Message::Text(text))) => text,
            Some(Ok(Message::Ping(_) | Message::Pong(_))) => return Ok(()),
            Some(Ok(Message::Binary(_))) => return Err((close_code::UNSUPPORTED, "send JSON as text")),
            Some(Ok(Message::Close(_)) | Err(_)) | None => return Err((close_code::NORMAL, "")),
        };
        match serde_json::from_str(&text) {
            Ok(TeleopSay::Sample(sample)) => {
                let now = self.state.relay.clock().now();
                let sticks = self.noting(|teleop| teleop.sample(now.mono, &understood(&sample)));
                if matches!(self.phase, Phase::Live) && sticks.is_some() {
                    self.look(sticks, now.utc).await?;
                }
                Ok(())
            }
            Ok(TeleopSay::Begin { window }) => self.begin(window).await,
            Ok(TeleopSay::Stop { why }) => {
                self.noting(|teleop| teleop.interrupt(because(why)));
                self.stop_now().await
            }
            Ok(TeleopSay::End {}) => {
                self.teleop.interrupt(Why::Person);
                self.finish("the person ended it", "").await;
                Ok(())
            }
            Err(_) => Err((close_code::POLICY, "not understood: /api/v1/openapi.json tells all")),
        }
    }

    /// Asks the vessel to be steered by hand.
    async fn begin(&mut self, window: String) -> Result<(), End> {
        if !matches!(self.phase, Phase::Idle) {
            return Ok(());
        }
        if !self.teleop.may_begin() {
            let trip = self.teleop.round_trip();
            let ms = trip.map_or_else(|| "unknown".to_owned(), |trip| format!("{} ms", trip.as_millis()));
            self.said = (
                format!("Not begun: the round trip is {ms}; it may be 1000 ms."),
                "Try again when the network is faster, or send the vessel by a plan.",
            );
            return Ok(());
        }
        let Some(helm) = self.state.helms.take(self.vessel) else {
            let why = "Not begun: another window of yours steers this vessel.".to_owned();
            self.said = (why, "End it there first.");
            return Ok(());
        };
        self.by.window = window;
        let order = Order::Teleoperate { by: self.state.relay.address() };
        match issue(&self.state, self.vessel, &self.by, order).await {
            Ok(command) => {
                (self.phase, self.helm) = (Phase::Starting(CommandId(command.id)), Some(helm));
                self.said = (String::new(), "");
            }
            Err(error) => self.said = (format!("Not begun: {}", error.text), ""),
        }
        Ok(())
    }

    /// Does something with the hands; that they steer no more is worth a line.
    fn noting<T>(&mut self, work: impl FnOnce(&mut Teleop) -> T) -> T {
        let steered = self.teleop.state() == TeleopState::Steering;
        let done = work(&mut self.teleop);
        if steered && self.teleop.state() != TeleopState::Steering {
            let why = self.teleop.why().text();
            tracing::info!(vessel = %self.vessel, who = self.by.who.name, why, "steering by hand is interrupted");
        }
        done
    }

    /// Time passes: stops what is stale, and answers.
    async fn tick(&mut self, socket: &mut WebSocket) -> Result<(), End> {
        self.silent += 1;
        if self.silent > SILENT_LOOKS {
            // Of a computer that lost its network nothing tells that it is gone.
            return Err((close_code::POLICY, "nothing came from the window for 3 s"));
        }
        let trip = self.state.links.round_trip(self.vessel);
        self.teleop.vessel_trip(trip.unwrap_or_default());
        let now = self.state.relay.clock().now();
        let late = self.state.links.late_sticks(self.vessel);
        if std::mem::replace(&mut self.late, late) != late {
            self.noting(|teleop| teleop.interrupt(Why::Unreached));
        }
        let sticks = self.noting(|teleop| teleop.tick(now));
        if !matches!(self.phase, Phase::Idle) {
            let sticks = sticks.filter(|_| matches!(self.phase, Phase::Live));
            self.look(sticks, now.utc).await?;
        }
        let now = self.state.relay.clock().now().mono;
        let text = serde_json::to_string(&self.told(now, trip.is_some()))
            .map_err(|_| (close_code::ERROR, "the server failed"))?;
        match tokio::time::timeout(PATIENCE, socket.send(Message::Text(text.into()))).await {
            Ok(Ok(())) => Ok(()),
            Ok(Err(_)) => Err((close_code::NORMAL, "")),
            Err(_) => Err((close_code::POLICY, "too slow: the window took nothing for 1 s")),
        }
    }

    fn told(&self, now: MonoTime, with_vessel: bool) -> TeleopTold {
        let phase = match (self.phase, self.teleop.state()) {
            (Phase::Idle, _) => TeleopPhase::Idle,
            (Phase::Starting(_), _) => TeleopPhase::Starting,
            (Phase::Live, TeleopState::Steering) => TeleopPhase::Steering,
            (Phase::Live, TeleopState::Ready) => TeleopPhase::Ready,
            (Phase::Live, TeleopState::Locked) => TeleopPhase::Locked,
        };
        let (why, remedy) = match (phase, self.teleop.why(), self.teleop.hinders()) {
            (TeleopPhase::Idle, ..) => self.said.clone(),
            (TeleopPhase::Starting | TeleopPhase::Steering, ..) | (_, Why::Begun, None) => {
                (String::new(), "")
            }
            (_, Why::Begun, Some(now)) => (now.text().to_owned(), now.remedy()),
            (_, why, None) => (why.text().to_owned(), why.remedy()),
            (_, why, Some(now)) => (format!("{}; now {}", why.text(), now.text()), now.remedy()),
        };
        let trip = self.teleop.round_trip();
        TeleopTold {
            stamp_us: now.micros(),
            phase,
            why,
            remedy: remedy.to_owned(),
            round_trip_ms: trip.map(|trip| trip.as_secs_f64() * 1e3),
            with_vessel,
            slow: trip.is_some_and(|trip| trip > hub::WARN_OVER),
            cap: self.teleop.cap(),
        }
    }

    /// Looks where the hub lives whether this window may steer and the vessel lets itself be steered, and sends. The
    /// time of the packet is that at which the sample was judged: its life aboard counts from then.
    async fn look(&mut self, sticks: Option<Sticks>, at: UtcTime) -> Result<(), End> {
        let gone = (close_code::AWAY, "the server is stopping");
        let (vessel, holder) = (self.vessel, self.by.holder());
        let asked = match &self.phase {
            Phase::Starting(id) => Some(*id),
            _ => None,
        };
        let look = move |hub: &mut Hub, now: hub::Now| {
            let epoch = hub.leases().epoch(now, vessel, &holder);
            let begun = asked.and_then(|id| hub.commands().get(id)).map(|command| {
                (command.stage(), command.steps.last().map(|step| step.text.clone()).unwrap_or_default())
            });
            let running = running(hub, vessel).is_some_and(|plan| plan == TELEOPERATION_PLAN);
            if let (Ok(epoch), Some(sticks)) = (&epoch, sticks) {
                let life = if sticks.stop { STOP_LASTS } else { sticks.life };
                dispatch(hub, now, (vessel, *epoch), keys(&sticks), at.seconds(), life);
            }
            let heard = hub
                .fleet()
                .system(vessel)
                .is_some_and(|system| now.mono.since(system.last_heard()) <= HEARD_WITHIN);
            Looked { may: epoch.is_ok(), running, heard, begun }
        };
        let looked = self.state.relay.look(look).await.map_err(|_| gone)?;
        if !looked.heard {
            // Nobody steers what does not say how it is, and when it is heard again the sticks pass neutral first.
            self.noting(|teleop| teleop.interrupt(Why::Vessel));
        }
        self.follow(looked.may, looked.running, looked.begun).await;
        Ok(())
    }

    /// Goes on with what the hub knows.
    async fn follow(&mut self, may: bool, running: bool, begun: Option<(Stage, String)>) {
        match (self.phase, begun) {
            (Phase::Idle, _) => {}
            _ if !may => {
                self.noting(|teleop| teleop.interrupt(Why::Lease));
                self.let_go().await;
                let remedy = "The vessel's motors stand still, and it is not steered by hand any more. Take control \
                              again if you still need it.";
                self.over(Why::Lease.text(), remedy);
            }
            (Phase::Starting(_), Some((Stage::EffectSeen, _))) => {
                self.teleop.begin();
                self.phase = Phase::Live;
            }
            (Phase::Starting(_), Some((stage, text))) if stage.is_last() => {
                self.over(&format!("the vessel did not begin: {}: {text}", stage.name()), "");
            }
            (Phase::Starting(_), None) => self.over("the order to begin was forgotten", ""),
            (Phase::Live, _) if !running => {
                self.noting(|teleop| teleop.interrupt(Why::Person));
                let remedy =
                    "Somebody pressed STOP, or it does something else: see the commands and the log book.";
                self.over("the vessel says that it is not steered by hand any more", remedy);
            }
            (Phase::Starting(_) | Phase::Live, _) => {}
        }
    }

    /// Control is lost: stops the vessel if it does not learn of that by itself, and tells it that it is not steered by
    /// hand any more. No other window of this server steers it yet, as this one has the helm.
    async fn let_go(&mut self) {
        let stop = self.teleop.tick(self.state.relay.clock().now());
        if !matches!(self.phase, Phase::Live) {
            return;
        }
        let vessel = self.vessel;
        let look = move |hub: &mut Hub, now: hub::Now| release(hub, now, vessel, stop.as_ref());
        // When the hub is gone nothing is sent any more.
        self.state.relay.look(look).await.ok();
    }

    /// Nothing is steered from here on.
    fn rest(&mut self, why: &str, remedy: &'static str) {
        (self.phase, self.helm, self.said) = (Phase::Idle, None, (format!("Ended: {why}."), remedy));
    }

    /// It is over without a word to the vessel, which did or would not listen: writes that down.
    fn over(&mut self, why: &str, remedy: &'static str) {
        self.state.people.note(Line {
            actor: self.by.who.actor(),
            address: self.by.from.clone(),
            action: "teleop.end",
            subject: format!("{} {why}", self.vessel),
            outcome: "done".to_owned(),
        });
        self.rest(why, remedy);
    }

    /// Sends the stop that an interruption owes, without waiting for the next tick.
    async fn stop_now(&mut self) -> Result<(), End> {
        let now = self.state.relay.clock().now();
        let sticks = self.teleop.tick(now);
        if sticks.is_some() && matches!(self.phase, Phase::Live) {
            self.look(sticks, now.utc).await?;
        }
        Ok(())
    }

    /// Tells the vessel to stop and that it is not steered by hand any more.
    async fn finish(&mut self, why: &str, remedy: &'static str) {
        if matches!(self.phase, Phase::Idle) {
            return;
        }
        let stop = self.teleop.tick(self.state.relay.clock().now());
        let live = matches!(self.phase, Phase::Live);
        let (vessel, holder) = (self.vessel, self.by.holder());
        let look = move |hub: &mut Hub, now: hub::Now| {
            let Ok(epoch) = hub.leases().epoch(now, vessel, &holder) else {
                if live {
                    release(hub, now, vessel, stop.as_ref());
                }
                return false;
            };
            if let Some(stop) = stop {
                dispatch(hub, now, (vessel, epoch), keys(&stop), now.utc.seconds(), STOP_LASTS);
            }
            true
        };
        if !self.state.relay.look(look).await.unwrap_or(true) {
            // The vessel would not listen to an order from here.
            return self.over(Why::Lease.text(), Why::Lease.remedy());
        }
        let order = Order::EndTeleoperation { why: why.to_owned() };
        match issue(&self.state, self.vessel, &self.by, order).await {
            // A refusal is in the audit log too.
            Ok(_) => self.rest(why, remedy),
            Err(error) if error.status.is_client_error() => self.rest(why, remedy),
            Err(_) => self.over(why, remedy),
        }
    }

    /// Whether the person may still steer.
    async fn check_rights(&mut self) -> Result<(), End> {
        let ended = (close_code::POLICY, "not allowed any more");
        let who = match identify(&self.state, &self.headers, self.caller).await {
            Ok(who) => who.ok_or(ended)?,
            Err(error) if error.status.is_server_error() => return Ok(()),
            Err(_) => return Err(ended),
        };
        if who.grants.on(self.vessel.0) < Some(Role::Operator) {
            return Err(ended);
        }
        self.by.who = who;
        Ok(())
    }
}

/// Why a browser stops, as the hub has it.
fn because(why: TeleopStop) -> Why {
    match why {
        TeleopStop::Hidden => Why::Hidden,
        TeleopStop::Unfocused => Why::Unfocused,
        TeleopStop::GamepadGone => Why::GamepadGone,
        TeleopStop::TwoDevices => Why::TwoDevices,
        TeleopStop::Unmoved => Why::Unmoved,
        TeleopStop::Person => Why::Person,
    }
}

/// A sample as the hub has it.
fn understood(sample: &TeleopSample) -> hub::Sample {
    let TeleopSample { seq, made_ms, change, stamp_us, stamp_held_ms, held, thrust, turn } = *sample;
    let held_s = (stamp_held_ms / 1e3).max(0.0);
    hub::Sample {
        seq,
        made_ms,
        change,
        echo: stamp_us.map(MonoTime::from_micros),
        echo_held: Duration::try_from_secs_f64(held_s).unwrap_or_default(),
        held,
        thrust,
        turn,
    }
}
