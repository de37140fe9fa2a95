//! A person steers a vessel by hand.
//!
//! [`operations::Teleop`] decides what is sent to the vessel; this module has its clock and its downlink. A stick position
//! is sent only while this window has control: over the vessel's link with a time to live, otherwise over the connection on
//! which the vessel is heard. However the session ends, the vessel is sent a stop and the end of teleoperation; if it
//! cannot be reached, the time to live of the last stick position ends aboard. When control is lost, the link itself stops
//! the vessel; a vessel on another transport does not know of leases and is sent a stop. Both are sent the end of
//! teleoperation, so that the vessel leaves that mode: the new controller starts over.

mod to_vessel;

use self::to_vessel::{dispatch, keys, release};
use super::{Commands, Helm, Helms, Issuer};
use crate::identity::{Line, Principal};
use crate::links::Links;
use crate::router::Stopped;
use api::{Said, TeleopPhase, TeleopSample, TeleopStatus, TeleopStop, say};
use hub::CommandId;
use imc::Address;
use operations::{Operations, Order, Stage, Sticks, TELEOPERATION_PLAN, Teleop, TeleopState, WARN_OVER, Why};
use std::time::Duration;
use units::{MonoTime, Now, UtcTime};

/// A stop is still worth delivering after this, unlike a stick position.
const STOP_LASTS: Duration = Duration::from_secs(2);
/// A vessel that is silent for this long is not steered: it normally sends many messages a second.
const HEARD_WITHIN: Duration = operations::BUDGET;

#[derive(Debug, Clone, Copy)]
enum Phase {
    Idle,
    /// The request to the vessel is under way.
    Starting(CommandId),
    /// The sticks steer the vessel.
    Live,
}

/// One window's steering of one vessel, for the life of its connection.
pub struct Steering {
    commands: Commands,
    links: Links,
    helms: Helms,
    vessel: Address,
    by: Issuer,
    teleop: Teleop,
    phase: Phase,
    /// This window's hold on the helm, while not idle.
    helm: Option<Helm>,
    /// Stick positions that the vessel got too late or never, counted by its link.
    late: u64,
    /// Why it has not begun, or has ended, and the remedy.
    said: (Said, Said),
}

/// The hub's answer to a request to steer.
struct Answer {
    may: bool,
    running: bool,
    heard: bool,
    begun: Option<(Stage, Said)>,
}

impl Steering {
    /// Nothing is steered before [`Steering::begin`].
    pub fn new(commands: Commands, links: Links, helms: Helms, vessel: Address, by: Issuer) -> Self {
        let late = links.late_sticks(vessel);
        let (teleop, phase, said) = (Teleop::new(), Phase::Idle, (Said::default(), Said::default()));
        Self { commands, links, helms, vessel, by, teleop, phase, helm: None, late, said }
    }

    /// Updates the person after their rights were checked again.
    pub fn is_of(&mut self, who: Principal) {
        self.by.who = who;
    }

    /// Takes a stick position.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn sample(&mut self, sample: &TeleopSample) -> Result<(), Stopped> {
        let now = self.now();
        let sticks = self.noting(|teleop| teleop.sample(now.mono, &understood(sample)));
        if matches!(self.phase, Phase::Live) && sticks.is_some() {
            self.steer(sticks, now.utc).await?;
        }
        Ok(())
    }

    /// The window stops automatically, or the person releases the sticks.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn interrupt(&mut self, why: TeleopStop) -> Result<(), Stopped> {
        self.noting(|teleop| teleop.interrupt(because(why)));
        self.stop_now().await
    }

    /// The person ends it.
    pub async fn end(&mut self) {
        self.teleop.interrupt(Why::Person);
        self.finish(say("the person ended it").into(), Said::default()).await;
    }

    /// The connection is closed.
    pub async fn close(mut self, why: &str) {
        self.teleop.interrupt(Why::Person);
        // The window is gone: this goes to the logs alone.
        self.finish(Said::as_is(why), Said::default()).await;
    }

    fn now(&self) -> Now {
        self.commands.router.clock().now()
    }

    /// Asks the vessel to enter teleoperation.
    pub async fn begin(&mut self, window: String) {
        if !matches!(self.phase, Phase::Idle) {
            return;
        }
        if !self.teleop.may_begin() {
            let trip = self.teleop.round_trip();
            let why = match trip {
                Some(trip) => say("Not begun: the round trip is {ms} ms; at most 1000 ms is allowed.")
                    .with("ms", trip.as_millis()),
                None => say("Not begun: the round trip is not known yet; at most 1000 ms is allowed."),
            };
            let remedy = say("Try again when the network is faster, or send the vessel by a plan.");
            self.said = (why.into(), remedy.into());
            return;
        }
        let Some(helm) = self.helms.take(self.vessel) else {
            let why = say("Not begun: another window of yours steers this vessel.");
            self.said = (why.into(), say("End it there first.").into());
            return;
        };
        self.by.window = window;
        let order = Order::Teleoperate { by: self.commands.router.address() };
        match self.commands.issue(self.vessel, &self.by, order).await {
            Ok(command) => {
                (self.phase, self.helm) = (Phase::Starting(CommandId(command.id)), Some(helm));
                self.said = (Said::default(), Said::default());
            }
            Err(error) => {
                self.said = (say("Not begun: {why}").with_said("why", error.text).into(), Said::default());
            }
        }
    }

    /// Changes the teleoperation state, and logs when it stops steering.
    fn noting<T>(&mut self, work: impl FnOnce(&mut Teleop) -> T) -> T {
        let steered = self.teleop.state() == TeleopState::Steering;
        let done = work(&mut self.teleop);
        if steered && self.teleop.state() != TeleopState::Steering {
            let why = self.teleop.why().text();
            tracing::info!(vessel = %self.vessel, who = self.by.who.name, why, "steering by hand is interrupted");
        }
        done
    }

    /// To be called periodically: stops on stale sticks, and returns the status.
    ///
    /// # Errors
    /// The server is stopping.
    pub async fn tick(&mut self) -> Result<TeleopStatus, Stopped> {
        let trip = self.links.round_trip(self.vessel);
        self.teleop.vessel_trip(trip.unwrap_or_default());
        let now = self.now();
        let late = self.links.late_sticks(self.vessel);
        if std::mem::replace(&mut self.late, late) != late {
            self.noting(|teleop| teleop.interrupt(Why::Unreached));
        }
        let sticks = self.noting(|teleop| teleop.tick(now));
        if !matches!(self.phase, Phase::Idle) {
            let sticks = sticks.filter(|_| matches!(self.phase, Phase::Live));
            self.steer(sticks, now.utc).await?;
        }
        Ok(self.told(self.now().mono, trip.is_some()))
    }

    fn told(&self, now: MonoTime, with_vessel: bool) -> TeleopStatus {
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
                (Said::default(), Said::default())
            }
            (_, Why::Begun, Some(now)) => (now.said(), now.remedy_said()),
            (_, why, None) => (why.said(), why.remedy_said()),
            (_, why, Some(now)) => {
                let both = say("{why}; now {now}").with_said("why", why.said()).with_said("now", now.said());
                (both.into(), now.remedy_said())
            }
        };
        let trip = self.teleop.round_trip();
        let ((why, why_says), (remedy, remedy_says)) = (why.into_parts(), remedy.into_parts());
        TeleopStatus {
            stamp_us: now.micros(),
            phase,
            why,
            why_says,
            remedy,
            remedy_says,
            round_trip_ms: trip.map(|trip| trip.as_secs_f64() * 1e3),
            with_vessel,
            slow: trip.is_some_and(|trip| trip > WARN_OVER),
            cap: self.teleop.cap(),
        }
    }

    /// Checks with the hub that this window may steer and that the vessel accepts it, and sends. The time of the packet is
    /// that at which the sample was judged: its life aboard counts from then.
    async fn steer(&mut self, sticks: Option<Sticks>, at: UtcTime) -> Result<(), Stopped> {
        let (vessel, holder) = (self.vessel, self.by.holder());
        let asked = match &self.phase {
            Phase::Starting(id) => Some(*id),
            _ => None,
        };
        let steer = move |operations: &mut Operations, now: Now| {
            let epoch = operations.leases().epoch(now, vessel, &holder);
            let begun = asked.and_then(|id| operations.commands().get(id)).map(|command| {
                (command.stage(), command.steps.last().map(operations::Step::in_full).unwrap_or_default())
            });
            let running = operations.running(vessel).is_some_and(|plan| plan == TELEOPERATION_PLAN);
            if let (Ok(epoch), Some(sticks)) = (&epoch, sticks) {
                let life = if sticks.stop { STOP_LASTS } else { sticks.life };
                dispatch(operations, now, (vessel, *epoch), keys(&sticks), at.seconds(), life);
            }
            let heard = operations
                .fleet()
                .system(vessel)
                .is_some_and(|system| now.mono.since(system.last_heard()) <= HEARD_WITHIN);
            Answer { may: epoch.is_ok(), running, heard, begun }
        };
        let answer = self.commands.router.ask(steer).await?;
        if !answer.heard {
            // A silent vessel is not steered; when it is heard again, the sticks must pass neutral first.
            self.noting(|teleop| teleop.interrupt(Why::Vessel));
        }
        self.follow(answer.may, answer.running, answer.begun).await;
        Ok(())
    }

    /// Continues with the hub's answer.
    async fn follow(&mut self, may: bool, running: bool, begun: Option<(Stage, Said)>) {
        match (self.phase, begun) {
            (Phase::Idle, _) => {}
            _ if !may => {
                self.noting(|teleop| teleop.interrupt(Why::Lease));
                self.let_go().await;
                let remedy = say(
                    "The vessel's motors stand still, and it is not steered by hand any more. Take control \
                              again if you still need it.",
                );
                self.over(Why::Lease.said(), remedy.into());
            }
            (Phase::Starting(_), Some((Stage::EffectSeen, _))) => {
                self.teleop.begin();
                self.phase = Phase::Live;
            }
            (Phase::Starting(_), Some((stage, text))) if stage.is_last() => {
                let stage = match stage {
                    Stage::Refused => say("refused"),
                    Stage::Expired => say("expired"),
                    _ => say("timed out without an effect"),
                };
                let why = say("the vessel did not begin: {stage}: {why}").with_said("stage", stage);
                self.over(why.with_said("why", text).into(), Said::default());
            }
            (Phase::Starting(_), None) => {
                self.over(say("the order to begin was forgotten").into(), Said::default());
            }
            (Phase::Live, _) if !running => {
                self.noting(|teleop| teleop.interrupt(Why::Person));
                let remedy = say(
                    "Somebody pressed STOP, or it does something else: see the commands and the log book.",
                );
                let why = say("the vessel says that it is not steered by hand any more");
                self.over(why.into(), remedy.into());
            }
            (Phase::Starting(_) | Phase::Live, _) => {}
        }
    }

    /// Control is lost: stops the vessel if its link does not do so, and sends it the end of teleoperation. No other window
    /// of this server steers it yet, as this one holds the helm.
    async fn let_go(&mut self) {
        let stop = self.teleop.tick(self.now());
        if !matches!(self.phase, Phase::Live) {
            return;
        }
        let vessel = self.vessel;
        let let_go =
            move |operations: &mut Operations, now: Now| release(operations, now, vessel, stop.as_ref());
        // Without a hub nothing can be sent.
        self.commands.router.ask(let_go).await.ok();
    }

    /// Returns to idle, with the reason and remedy.
    fn rest(&mut self, why: Said, remedy: Said) {
        let ended = say("Ended: {why}.").with_said("why", why);
        (self.phase, self.helm, self.said) = (Phase::Idle, None, (ended.into(), remedy));
    }

    /// Ends without a message to the vessel, which did not or would not accept it, and logs that.
    fn over(&mut self, why: Said, remedy: Said) {
        self.commands.people.note(Line {
            actor: self.by.who.actor(),
            address: self.by.from.clone(),
            action: "teleop.end",
            subject: format!("{} {why}", self.vessel),
            outcome: "done".to_owned(),
        });
        self.rest(why, remedy);
    }

    /// Sends the stop that follows an interruption at once, without waiting for the next tick.
    async fn stop_now(&mut self) -> Result<(), Stopped> {
        let now = self.now();
        let sticks = self.teleop.tick(now);
        if sticks.is_some() && matches!(self.phase, Phase::Live) {
            self.steer(sticks, now.utc).await?;
        }
        Ok(())
    }

    /// Sends the vessel a stop and the end of teleoperation.
    async fn finish(&mut self, why: Said, remedy: Said) {
        if matches!(self.phase, Phase::Idle) {
            return;
        }
        let stop = self.teleop.tick(self.now());
        let live = matches!(self.phase, Phase::Live);
        let (vessel, holder) = (self.vessel, self.by.holder());
        let finish = move |operations: &mut Operations, now: Now| {
            let Ok(epoch) = operations.leases().epoch(now, vessel, &holder) else {
                if live {
                    release(operations, now, vessel, stop.as_ref());
                }
                return false;
            };
            if let Some(stop) = stop {
                dispatch(operations, now, (vessel, epoch), keys(&stop), now.utc.seconds(), STOP_LASTS);
            }
            true
        };
        if !self.commands.router.ask(finish).await.unwrap_or(true) {
            // The vessel would not accept an order from here.
            return self.over(Why::Lease.said(), Why::Lease.remedy_said());
        }
        let order = Order::EndTeleoperation { why: why.to_string() };
        match self.commands.issue(self.vessel, &self.by, order).await {
            // A refusal is in the audit log too.
            Ok(_) => self.rest(why, remedy),
            Err(error) if error.is_final() => self.rest(why, remedy),
            Err(_) => self.over(why, remedy),
        }
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
fn understood(sample: &TeleopSample) -> operations::Sample {
    let TeleopSample { seq, made_ms, change, stamp_us, stamp_held_ms, held, thrust, turn } = *sample;
    let held_s = (stamp_held_ms / 1e3).max(0.0);
    operations::Sample {
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
