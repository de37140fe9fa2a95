//! The stages of an order: accepted, sent, received, executing, effect seen; or refused, expired, timed out.
//!
//! A vessel's answers are events, not one answer (DUNE's plan engine answers each change of state): a start is answered
//! several times under one request id, and a failure may come minutes later. So answers advance a command while it is
//! open, and the effect is taken from telemetry: the plan that PlanControlState reports as executed, the digest that the
//! plan database gives. Telemetry that could be from before the order counts only after an answer.
//!
//! A command that timed out is not forgotten: later evidence that the vessel has it, carries it out or refuses it
//! advances it, marked as late.
//!
//! [`KEPT`] commands are kept for each vessel; the oldest finished ones are dropped first.

mod answers;
mod dispatch;
mod order;
mod reports;
#[cfg(test)]
mod tests;

pub use order::{GOTO_PLAN, Order, TELEOPERATION_PLAN};
pub use reports::{EntityReport, ParameterReport, PlanReport, Question, Reports, is_same_value};

use api::{Said, say};
use hub::{CommandId, STOP_LIFE, TIME_TO_LIVE, Tag, Telecommand, Urgency};
use imc::{Address, Header, Packet};
use order::Effect;
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;
use units::{MonoTime, Now, UtcTime};

/// Commands kept for each vessel.
const KEPT: usize = 100;
/// Commands of one vessel that may be open at once.
const OPEN: usize = 20;
/// Answers kept for each vessel: they are large.
const ANSWERS_KEPT: usize = 10;
/// Vessels whose list of plans is kept: a peer may send with any number of addresses.
const VESSELS: usize = 256;
/// Most characters of what a stage says.
const TEXT_CHARS: usize = 500;
/// How long each stage may take. The link gives its own verdict before the first.
const RECEIVED_WITHIN: Duration = Duration::from_secs(15);
const ANSWERED_WITHIN: Duration = Duration::from_secs(10);
const EFFECT_WITHIN: Duration = Duration::from_secs(15);
/// So long after it timed out the state of the vessel still counts for a command that it never answered.
const LATE_STATE: Duration = Duration::from_mins(1);
/// At rest so long after a stop was sent, a vessel that rested before has obeyed it.
const REST_SEEN: Duration = Duration::from_secs(2);
/// Events of commands that were not fetched yet; the oldest is dropped first, and counted.
const EVENTS: usize = 10_000;

/// How far a command is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// It must be written into the audit log.
    Asked,
    /// It is in the audit log.
    Accepted,
    /// No way leads to the vessel: it waits for one, until its life ends.
    Waiting,
    /// It is on its way.
    Sent,
    /// The vessel has it.
    Received,
    /// The vessel carries it out.
    Executing,
    /// The vessel's report shows that it is done.
    EffectSeen,
    /// The vessel or the server refuses.
    Refused,
    /// It was not delivered in time and never will be.
    Expired,
    /// A stage did not come in time. Whether the vessel obeys is not known.
    TimedOut,
}

impl Stage {
    /// A stable word for people and machines.
    pub fn name(self) -> &'static str {
        match self {
            Self::Asked => "asked",
            Self::Accepted => "accepted",
            Self::Waiting => "waiting",
            Self::Sent => "sent",
            Self::Received => "received",
            Self::Executing => "executing",
            Self::EffectSeen => "effect seen",
            Self::Refused => "refused",
            Self::Expired => "expired",
            Self::TimedOut => "timed out",
        }
    }

    /// Whether nothing follows.
    pub fn is_last(self) -> bool {
        self >= Self::EffectSeen
    }
}

/// A stage that was reached.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Step {
    /// The stage that it has reached.
    pub stage: Stage,
    /// Time of that stage.
    pub at: UtcTime,
    /// The vessel's words, or why.
    pub text: Said,
    /// Whether it was reached after the command had timed out.
    pub late: bool,
}

impl Step {
    /// The same, with whether it is late.
    pub fn in_full(&self) -> Said {
        match (self.late, self.text.is_empty()) {
            (false, _) => self.text.clone(),
            (true, true) => say("late").into(),
            (true, false) => say("late: {why}").with_said("why", self.text.clone()).into(),
        }
    }
}

/// A vessel's answer to a query.
#[derive(Debug, Clone, PartialEq)]
pub enum Answer {
    /// A plan.
    Plan(Box<imc::messages::PlanSpecification>),
    /// An entity's parameters, names and values.
    Parameters(Vec<(String, String)>),
}

/// A plan that a vessel stores.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlanAboard {
    /// Its name.
    pub plan_id: String,
    /// Bytes of its specification.
    pub size: u16,
    /// When it was changed, by the vessel's clock.
    pub changed: Option<UtcTime>,
    /// Who changed it.
    pub changed_by: String,
    /// Its digest.
    pub md5: Vec<u8>,
}

/// The plans that a vessel stores, as last reported.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PlansAboard {
    /// When it was reported.
    pub at: UtcTime,
    /// By name.
    pub plans: Vec<PlanAboard>,
}

/// An order and its outcome.
#[derive(Debug, Clone, PartialEq)]
pub struct Command {
    /// Its number.
    pub id: CommandId,
    /// To whom.
    pub vessel: Address,
    /// Who ordered it.
    pub by: OrderedBy,
    /// The lease under which it was ordered; 0 for one that needs none.
    pub epoch: u64,
    /// Like `plan.start`.
    pub verb: &'static str,
    /// Its subject.
    pub subject: String,
    /// The stages reached, in order.
    pub steps: Vec<Step>,
    /// The vessel's answer.
    pub answer: Option<Answer>,
    /// Parameters that the vessel did not take, with its words.
    refusals: BTreeMap<String, String>,
    order: Option<Order>,
    /// Whether it commands, or is a query.
    commands: bool,
    effect: Effect,
    request_id: u16,
    /// The plan that ran when it was sent.
    ran: Option<String>,
    answered: bool,
    /// When it was sent, and when it timed out.
    sent: Option<MonoTime>,
    timed_out: Option<MonoTime>,
    deadline: Option<MonoTime>,
    revision: u64,
}

impl Command {
    /// How far it is.
    pub fn stage(&self) -> Stage {
        self.steps.last().map_or(Stage::Asked, |step| step.stage)
    }

    /// The furthest stage that it reached, timeouts left aside.
    fn furthest(&self) -> Stage {
        let reached = self.steps.iter().map(|step| step.stage).filter(|stage| *stage != Stage::TimedOut);
        reached.max().unwrap_or(Stage::Asked)
    }

    /// Whether the vessel's own state reports, which answer no order, still count for it.
    fn listens(&self, now: MonoTime) -> bool {
        self.answered || self.timed_out.is_none_or(|at| now.since(at) < LATE_STATE)
    }

    /// Whether nothing more is expected.
    pub fn is_over(&self) -> bool {
        // No report shows the effect of this one: receipt is all that is ever known.
        self.stage().is_last() || (self.effect == Effect::Silent && self.stage() >= Stage::Received)
    }
}

/// The outcome of a command on the vessel link.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Receipt {
    /// The vessel has it.
    Received,
    /// It came too late, or never.
    Expired,
    /// The vessel refuses it.
    Refused(String),
    /// It was sent and the vessel did not say.
    Unanswered,
}

/// Who ordered something.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct OrderedBy {
    /// The person.
    pub name: String,
    /// As the audit log names them: a person's script has a name other than the person.
    pub actor: String,
    /// From which network address.
    pub from: String,
}

/// Progress of a command, for the audit log.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct CommandEvent {
    /// Its number.
    pub id: CommandId,
    /// To whom.
    pub vessel: Address,
    /// Who ordered it.
    pub by: OrderedBy,
    /// Like `plan.start`.
    pub verb: &'static str,
    /// Its subject.
    pub subject: String,
    /// How far it is.
    pub step: Step,
}

/// A stop came before it.
pub(crate) fn called_off() -> Said {
    say("a stop was ordered before it could be sent").into()
}

/// The commands of all vessels.
#[derive(Debug)]
pub struct Commands {
    own: Address,
    all: BTreeMap<CommandId, Command>,
    /// With the time, by which the one that reported longest ago is found.
    aboard: BTreeMap<Address, (MonoTime, PlansAboard)>,
    reports: Reports,
    next_request: u16,
    last_id: u64,
    revision: u64,
    events: VecDeque<CommandEvent>,
    forgotten: u64,
    /// Stops that were ordered, of each vessel that was ever stopped.
    stops: BTreeMap<Address, u64>,
}

impl Commands {
    /// None yet, to be sent from this address.
    pub fn new(own: Address) -> Self {
        Self {
            own,
            all: BTreeMap::new(),
            aboard: BTreeMap::new(),
            reports: Reports::new(own),
            next_request: 0,
            last_id: 0,
            revision: 0,
            events: VecDeque::new(),
            forgotten: 0,
            stops: BTreeMap::new(),
        }
    }

    /// Takes an order that `by` gives under a lease, before it is written into the audit log.
    ///
    /// # Errors
    /// It is not valid, or too many of this vessel are open.
    pub fn begin(
        &mut self,
        now: Now,
        vessel: Address,
        by: &OrderedBy,
        epoch: u64,
        order: Order,
    ) -> Result<CommandId, Said> {
        order.check()?;
        let open = self.all.values().filter(|one| one.vessel == vessel && !one.is_over()).count();
        // A stop goes first, however many other commands are under way.
        if open >= OPEN && !order.is_stop() {
            return Err(say("{n} commands to this vessel are open: wait for them").with("n", open).into());
        }
        if order.is_stop() {
            self.call_off_unsent(now, vessel);
        }
        // Milliseconds of UTC are exact in JavaScript.
        let millis = u64::try_from(now.utc.micros() / 1_000).unwrap_or_default();
        self.last_id = (self.last_id + 1).max(millis);
        let id = CommandId(self.last_id);
        // In the upper half, from another point at each start: requests of others with this address, or of an earlier
        // start, are answered under other numbers.
        let next =
            if self.next_request == 0 { self.last_id as u16 } else { self.next_request.wrapping_add(2) };
        self.next_request = (next & 0x7FFE) | 0x8000;
        self.revision += 1;
        let command = Command {
            id,
            vessel,
            by: by.clone(),
            epoch,
            verb: order.verb(),
            subject: self.subjects(vessel, &order).join("; "),
            steps: Vec::new(),
            answer: None,
            refusals: BTreeMap::new(),
            effect: order.effect(),
            commands: order.commands(),
            order: Some(order),
            request_id: self.next_request,
            ran: None,
            answered: false,
            sent: None,
            timed_out: None,
            deadline: Some(now.mono + RECEIVED_WITHIN),
            revision: self.revision,
        };
        self.all.insert(id, command);
        self.forget(vessel);
        Ok(id)
    }

    /// Stops that were ordered of a vessel. Compared before and after an order is prepared: if a stop came in between,
    /// the order is not given.
    pub fn stops(&self, vessel: Address) -> u64 {
        self.stops.get(&vessel).copied().unwrap_or_default()
    }

    /// A stop is ordered: earlier orders that are not sent yet are cancelled.
    fn call_off_unsent(&mut self, now: Now, vessel: Address) {
        if self.stops.len() < VESSELS || self.stops.contains_key(&vessel) {
            *self.stops.entry(vessel).or_default() += 1;
        }
        let unsent =
            |one: &&Command| one.vessel == vessel && one.commands && one.order.is_some() && !one.is_over();
        let off: Vec<CommandId> = self.all.values().filter(unsent).map(|one| one.id).collect();
        for id in off {
            self.refused(now, id, called_off());
        }
    }

    /// It is in the audit log: what to send. `ran` is the plan that the vessel said it executes. Nothing for a
    /// command that is over or was sent.
    pub fn accepted(&mut self, now: Now, id: CommandId, ran: Option<String>) -> Option<Telecommand> {
        let own = self.own;
        let command = self.all.get_mut(&id).filter(|one| one.stage() == Stage::Asked)?;
        let order = command.order.take()?;
        let header = Header {
            timestamp: now.utc.seconds(),
            src: own,
            src_ent: u8::MAX,
            dst: command.vessel,
            dst_ent: u8::MAX,
        };
        command.ran = ran;
        let (vessel, epoch, request_id) = (command.vessel, command.epoch, command.request_id);
        let (urgency, life) =
            if order.is_stop() { (Urgency::Stop, STOP_LIFE) } else { (Urgency::Command, TIME_TO_LIVE) };
        let tag = Tag { id: Some(id), is_copy: false, epoch, expires: now.mono + life, urgency };
        self.step(now, id, Stage::Accepted, Said::default(), false);
        match Packet::new(header, order.message(request_id)).encode() {
            Ok(packet) => Some(Telecommand { vessel, tag, packet: packet.into() }),
            Err(error) => {
                self.refused(now, id, say("it fits no packet: {error}").with("error", error));
                None
            }
        }
    }

    /// The server does not send it, or the vessel does not take it.
    pub fn refused(&mut self, now: Now, id: CommandId, why: impl Into<Said>) {
        self.advance(now, id, Stage::Refused, why);
    }

    /// Takes the vessel link's report.
    pub fn receipt(&mut self, now: Now, id: CommandId, receipt: Receipt) {
        let one_of_several = self.all.get(&id).is_some_and(|one| one.effect == Effect::Aborts);
        match receipt {
            // A stop takes several ways; that one of them failed is not its end.
            Receipt::Expired | Receipt::Refused(_) if one_of_several => {
                let text = match receipt {
                    Receipt::Refused(why) => {
                        say("not by the link; perhaps by another connection: look at the vessel ({why})")
                            .with("why", why)
                    }
                    _ => say("not by the link; perhaps by another connection: look at the vessel"),
                };
                self.advance(now, id, Stage::TimedOut, text);
            }
            Receipt::Received => self.advance(now, id, Stage::Received, Said::default()),
            Receipt::Refused(why) => self.advance(now, id, Stage::Refused, Said::as_is(why)),
            Receipt::Expired => {
                let text = say("the vessel was not reached in time; it will not get it any more");
                self.advance(now, id, Stage::Expired, text);
            }
            Receipt::Unanswered => {
                let text = say("sent, and the vessel did not say that it has it");
                self.advance(now, id, Stage::TimedOut, text);
            }
        }
    }

    /// Times out commands whose next stage is overdue. Call it about once a second.
    pub fn tick(&mut self, now: Now) {
        let due =
            |one: &&Command| !one.is_over() && one.deadline.is_some_and(|deadline| now.mono >= deadline);
        let late: Vec<(CommandId, Stage)> =
            self.all.values().filter(due).map(|one| (one.id, one.stage())).collect();
        for (id, stage) in late {
            let text = match stage {
                Stage::Asked | Stage::Accepted | Stage::Waiting => say("it was not sent"),
                Stage::Sent => say("the vessel did not say that it has it"),
                Stage::Received => say("the vessel has it and does not answer"),
                _ => say("the vessel answered, but nothing shows the effect"),
            };
            self.advance(now, id, Stage::TimedOut, text);
        }
    }

    /// One command.
    pub fn get(&self, id: CommandId) -> Option<&Command> {
        self.all.get(&id)
    }

    /// The commands of a vessel, the newest first.
    pub fn of(&self, vessel: Address) -> impl Iterator<Item = &Command> {
        self.all.values().rev().filter(move |one| one.vessel == vessel)
    }

    /// All commands that changed after `revision`, in order of their numbers.
    pub fn changed(&self, revision: u64) -> impl Iterator<Item = &Command> {
        self.all.values().filter(move |one| one.revision > revision)
    }

    /// The plans that a vessel stores, as far as it said: kept of the 256 vessels that said so last, unknown again of
    /// others until they are asked again.
    pub fn aboard(&self, vessel: Address) -> Option<&PlansAboard> {
        self.aboard.get(&vessel).map(|(_, plans)| plans)
    }

    /// The vessels' own reports.
    pub fn reports(&self) -> &Reports {
        &self.reports
    }

    /// The vessels' own reports, to query them.
    pub fn reports_mut(&mut self) -> &mut Reports {
        &mut self.reports
    }

    /// The subject of an order, in words: of parameters the old and new values, one by one.
    pub fn subjects(&self, vessel: Address, order: &Order) -> Vec<String> {
        let Order::SetParameters { entity, values } = order else { return vec![order.subject()] };
        let change = |(name, value): &(String, String)| {
            let before =
                self.reports.parameter(vessel, entity, name).map_or("?", |known| known.value.as_str());
            format!("{entity}: {name} {} -> {}", reports::brief(before), reports::brief(value))
        };
        values.iter().map(change).collect()
    }

    /// Counts changes.
    pub fn revision(&self) -> u64 {
        self.revision
    }

    /// The events of commands since the last call, and how many were dropped because they were not fetched.
    pub fn drain(&mut self) -> (Vec<CommandEvent>, u64) {
        (self.events.drain(..).collect(), std::mem::take(&mut self.forgotten))
    }

    /// Goes on to a later stage; what is over stays as it is, but for what timed out: later evidence tells more than that
    /// none came in time.
    fn advance(&mut self, now: Now, id: CommandId, stage: Stage, text: impl Into<Said>) {
        let Some(command) = self.all.get(&id) else { return };
        let goes_on = !command.is_over() && command.stage() < stage;
        let revives =
            command.stage() == Stage::TimedOut && command.furthest() < stage && stage != Stage::TimedOut;
        if !(goes_on || revives) {
            return;
        }
        let late = command.timed_out.is_some() && stage != Stage::TimedOut;
        self.step(now, id, stage, text.into(), late);
    }

    fn step(&mut self, now: Now, id: CommandId, stage: Stage, text: Said, late: bool) {
        let Some(command) = self.all.get_mut(&id) else { return };
        self.revision += 1;
        command.revision = self.revision;
        let step = Step { stage, at: now.utc, text: text.at_most(TEXT_CHARS), late };
        match stage {
            Stage::Sent => command.sent = Some(now.mono),
            Stage::TimedOut => command.timed_out = Some(now.mono),
            _ => {}
        }
        // Queries are not audited; earlier stages are written to the audit log by the caller.
        if command.commands && stage >= Stage::Waiting {
            let event = CommandEvent {
                id,
                vessel: command.vessel,
                by: command.by.clone(),
                verb: command.verb,
                subject: command.subject.clone(),
                step: step.clone(),
            };
            if self.events.len() >= EVENTS {
                self.events.pop_front();
                self.forgotten += 1;
            }
            self.events.push_back(event);
        }
        command.steps.push(step);
        command.deadline = match stage {
            Stage::Asked | Stage::Accepted | Stage::Sent => Some(now.mono + RECEIVED_WITHIN),
            // Its life ends before, and that is reported.
            Stage::Waiting => Some(now.mono + STOP_LIFE + RECEIVED_WITHIN),
            Stage::Received => Some(now.mono + ANSWERED_WITHIN),
            Stage::Executing => Some(now.mono + EFFECT_WITHIN),
            _ => None,
        };
    }

    /// Drops a vessel's oldest commands beyond the limit.
    fn forget(&mut self, vessel: Address) {
        // Of the last stop it must be known whether it arrived.
        let stop = self.of(vessel).find(|one| one.effect == Effect::Aborts).map(|one| one.id);
        let over = self.of(vessel).filter(|one| one.is_over() && Some(one.id) != stop);
        let over: Vec<CommandId> = over.map(|one| one.id).collect();
        let all = self.of(vessel).count();
        for id in over.iter().rev().take(all.saturating_sub(KEPT)) {
            self.all.remove(id);
        }
        let answered: Vec<CommandId> =
            self.of(vessel).filter(|one| one.answer.is_some()).map(|one| one.id).skip(ANSWERS_KEPT).collect();
        for id in answered {
            if let Some(command) = self.all.get_mut(&id) {
                command.answer = None;
            }
        }
    }
}
