//! The vessel's state machine: when to connect, what to say, what to believe.

use super::chart::{Pull, Want};
use super::records::LagTracker;
use super::up::{Step, Up};
use super::{Answer, Entry, Failure, VesselInput, VesselOutput, VesselSettings, VesselStatus};
use crate::backoff::Backoff;
use crate::clocks::Clocks;
use crate::commands::{First, Seen};
use crate::frame::{
    Bye, ByeCode, Capabilities, ChartPart, Command, Frame, Hello, OLDEST_VERSION, VERSION, Verdict, Welcome,
    decode, message,
};
use crate::live::LiveSet;
use crate::pace::Pace;
use crate::{ConnectionId, DEAD_AFTER, GREETING_WITHIN, Latency};
use bytes::Bytes;
use std::collections::VecDeque;
use std::time::Duration;
use units::{MonoTime, Now};

/// Time for a connection to be made. A link that has just come back is found by the next attempt, so they are
/// short; every fifth is patient, for links on which a handshake takes seconds.
const ATTEMPT: Duration = Duration::from_millis(1500);
const PATIENT_ATTEMPT: Duration = Duration::from_secs(4);

/// The vessel's end of the link. The backlog stays in the spool; what is held here is bounded: the live lane's
/// values and the identities of the last commands.
#[derive(Debug)]
pub struct Vessel {
    settings: VesselSettings,
    outputs: VecDeque<VesselOutput>,
    phase: Phase,
    attempt: u64,
    backoff: Backoff,
    growth: LagTracker,
    live: LiveSet,
    pull: Pull,
    seen: Seen,
    /// What the shore last called durable.
    durable: u64,
    connections: u64,
    sent_bytes: u64,
    arriving: Latency,
    keeping: Latency,
}

#[derive(Debug)]
enum Phase {
    /// Until then no attempt is made.
    Pausing(MonoTime),
    /// The driver connects.
    Opening,
    /// A connection is there.
    Open(Box<Open>),
    /// For good.
    Ended,
}

#[derive(Debug)]
struct Open {
    heard: MonoTime,
    /// Given up when the shore has not agreed by then.
    greeting_until: MonoTime,
    clocks: Clocks,
    pace: Pace,
    /// After the shore agreed.
    up: Option<Up>,
}

/// Why a connection is given up: what to tell the other side, what to tell the log.
struct End {
    code: Option<ByeCode>,
    reason: String,
    refused: bool,
}

impl End {
    fn protocol(reason: impl std::fmt::Display) -> Self {
        Self { code: Some(ByeCode::Protocol), reason: reason.to_string(), refused: true }
    }
}

impl Vessel {
    /// A vessel that connects at once.
    pub fn new(now: Now, settings: VesselSettings) -> Self {
        Self {
            outputs: VecDeque::new(),
            phase: Phase::Pausing(now.mono),
            attempt: 0,
            backoff: Backoff::new(settings.seed),
            growth: LagTracker::new(now, settings.spool),
            live: LiveSet::default(),
            pull: Pull::new(now.mono),
            seen: Seen::default(),
            durable: settings.spool.first,
            connections: 0,
            sent_bytes: 0,
            arriving: Latency::default(),
            keeping: Latency::default(),
            settings,
        }
    }

    /// Something happened.
    pub fn handle(&mut self, now: Now, input: VesselInput) {
        match input {
            VesselInput::Spool(spool) => {
                let renumbered = spool.stream != self.settings.spool.stream;
                self.settings.spool = spool;
                if renumbered {
                    self.growth = LagTracker::new(now, spool);
                    self.durable = spool.first;
                    let reason = "the spool began another stream".to_owned();
                    self.end(now, End { code: Some(ByeCode::Ending), reason, refused: false });
                }
            }
            VesselInput::SpoolRefused(refused) => self.growth.refuse(refused),
            VesselInput::Entries(from, entries) => self.entries(now, from, entries),
            VesselInput::Live(packet) => {
                self.live.put(now, packet);
            }
            VesselInput::Opened(id) if self.is_current(id) => self.opened(now),
            VesselInput::Failed(id, failure) if self.is_current(id) => {
                self.pause(now, failure == Failure::Refused);
            }
            VesselInput::Message(id, bytes) if self.is_current(id) => {
                if let Err(end) = self.message(now, bytes) {
                    self.end(now, end);
                }
            }
            VesselInput::Closed(id) if self.is_current(id) => self.pause(now, false),
            // Only time has passed, or it is about a connection that was given up.
            VesselInput::Timer
            | VesselInput::Opened(_)
            | VesselInput::Failed(..)
            | VesselInput::Message(..)
            | VesselInput::Closed(_) => {}
            VesselInput::Answer(id, answer) => self.answer(now, id, answer),
            VesselInput::ChartAboard(aboard) => {
                let want = self.pull.aboard(aboard);
                self.want(now, want);
            }
            VesselInput::ChartGoOn(digest, have) => self.pull.go_on(now.mono, &digest, have),
            VesselInput::ChartKept(digest) => self.pull.kept(&digest),
            VesselInput::ChartFailed(digest, text) => self.pull.failed(now.mono, &digest, text),
            VesselInput::Shutdown => {
                let reason = "the program ends".to_owned();
                self.end(now, End { code: Some(ByeCode::Ending), reason, refused: false });
                self.phase = Phase::Ended;
            }
        }
        self.step(now);
    }

    /// The next thing to do.
    pub fn poll_output(&mut self) -> Option<VesselOutput> {
        self.outputs.pop_front()
    }

    /// When to come back with [`VesselInput::Timer`] at the latest; `None` for never.
    pub fn poll_timeout(&mut self, now: Now) -> Option<MonoTime> {
        match &mut self.phase {
            Phase::Pausing(until) => Some(*until),
            Phase::Opening | Phase::Ended => None,
            Phase::Open(open) => {
                let Open { heard, greeting_until, clocks, pace, up } = &mut **open;
                let dead = *heard + DEAD_AFTER;
                Some(match up {
                    None => dead.min(*greeting_until),
                    Some(up) => {
                        let (spool, growth, live) = (self.settings.spool, &self.growth, &mut self.live);
                        let due = up.poll_timeout(&mut Step { now, spool, pace, clocks, growth, live });
                        dead.min(self.pull.poll_timeout().map_or(due, |chart| chart.min(due)))
                    }
                })
            }
        }
    }

    /// How the link is. Latencies start over.
    pub fn status(&mut self, now: Now) -> VesselStatus {
        let (clocks, cursor) = match &self.phase {
            Phase::Open(open) => (open.clocks.estimate(now), open.up.as_ref().map(|up| up.cursor)),
            _ => (None, None),
        };
        VesselStatus {
            up: cursor.is_some(),
            backlog: self.settings.spool.next.saturating_sub(self.durable.max(self.settings.spool.first)),
            lagging: cursor.is_none_or(|cursor| self.growth.lags(now.mono, cursor)),
            connections: self.connections,
            sent_bytes: self.sent_bytes,
            live_left_out: self.live.left_out(),
            clocks,
            arriving: std::mem::take(&mut self.arriving),
            keeping: std::mem::take(&mut self.keeping),
        }
    }

    fn is_current(&self, id: ConnectionId) -> bool {
        id.0 == self.attempt && matches!(self.phase, Phase::Opening | Phase::Open(_))
    }

    fn opened(&mut self, now: Now) {
        let clocks = Clocks::default();
        let hello = Hello {
            version: VERSION,
            oldest_version: OLDEST_VERSION,
            capabilities: Capabilities::ALL,
            address: self.settings.address,
            incarnation: self.settings.incarnation,
            attempt: self.attempt,
            stream: self.settings.spool.stream,
            first: self.settings.spool.first,
            next: self.settings.spool.next,
            stamp: clocks.stamp(now),
            name: self.settings.name.clone(),
            software: self.settings.software.clone(),
        };
        self.phase = Phase::Open(Box::new(Open {
            heard: now.mono,
            greeting_until: now.mono + GREETING_WITHIN,
            clocks,
            pace: Pace::new(now.mono, self.settings.budget_bytes_per_s),
            up: None,
        }));
        self.send(now, message(&Frame::Hello(hello)));
    }

    fn send(&mut self, now: Now, message: Bytes) {
        let Phase::Open(open) = &mut self.phase else { return };
        open.pace.sent(now.mono, message.len());
        self.sent_bytes += message.len() as u64;
        self.outputs.push_back(VesselOutput::Send(ConnectionId(self.attempt), message));
    }

    fn pause(&mut self, now: Now, refused: bool) {
        self.pull.unlinked(now.mono);
        let pause = if refused { self.backoff.refused() } else { self.backoff.unanswered() };
        self.phase = Phase::Pausing(now.mono + pause);
    }

    /// Gives the connection up.
    fn end(&mut self, now: Now, end: End) {
        if !matches!(self.phase, Phase::Opening | Phase::Open(_)) {
            return;
        }
        if let Some(code) = end.code {
            self.send(now, message(&Frame::Bye(Bye { code, text: end.reason.clone() })));
        }
        self.outputs.push_back(VesselOutput::Close(ConnectionId(self.attempt), end.reason));
        self.pause(now, end.refused);
    }

    fn step(&mut self, now: Now) {
        self.growth.mark(now.mono, self.settings.spool.next);
        match &mut self.phase {
            Phase::Pausing(until) if now.mono >= *until => {
                self.attempt += 1;
                self.phase = Phase::Opening;
                let patience = if self.attempt.is_multiple_of(5) { PATIENT_ATTEMPT } else { ATTEMPT };
                self.outputs.push_back(VesselOutput::Open(ConnectionId(self.attempt), patience));
            }
            Phase::Open(open) if now.mono.since(open.heard) >= DEAD_AFTER => {
                let reason = format!("nothing heard for {} s", DEAD_AFTER.as_secs());
                self.end(now, End { code: None, reason, refused: false });
            }
            Phase::Open(open) => {
                let Open { greeting_until, clocks, pace, up, .. } = &mut **open;
                let Some(up) = up else {
                    if now.mono >= *greeting_until {
                        let reason = "the greeting was not answered".to_owned();
                        self.end(now, End { code: None, reason, refused: false });
                    }
                    return;
                };
                let (spool, growth, live) = (self.settings.spool, &self.growth, &mut self.live);
                let (messages, need) = up.step(&mut Step { now, spool, pace, clocks, growth, live });
                for message in messages {
                    self.send(now, message);
                }
                self.outputs.extend(need.map(|(from, bytes)| VesselOutput::Need(from, bytes)));
                // Last: nothing of the vessel's own waits for it.
                let wants = self.pull.step(now.mono);
                self.want(now, wants);
            }
            Phase::Pausing(_) | Phase::Opening | Phase::Ended => {}
        }
    }

    fn want(&mut self, now: Now, wants: impl IntoIterator<Item = Want>) {
        for want in wants {
            match want {
                Want::Send(frame) => self.send(now, message(&frame)),
                Want::Begin(offer) => self.outputs.push_back(VesselOutput::ChartBegin(offer)),
            }
        }
    }

    fn entries(&mut self, now: Now, from: u64, entries: Vec<Entry>) {
        let Phase::Open(open) = &mut self.phase else { return };
        let Open { clocks, pace, up: Some(up), .. } = &mut **open else { return };
        let (spool, growth, live) = (self.settings.spool, &self.growth, &mut self.live);
        let messages = up.entries(&Step { now, spool, pace, clocks, growth, live }, from, entries);
        for message in messages {
            self.send(now, message);
        }
    }

    fn message(&mut self, now: Now, bytes: Bytes) -> Result<(), End> {
        if let Phase::Open(open) = &mut self.phase {
            open.heard = now.mono;
        }
        for frame in decode(bytes).map_err(End::protocol)? {
            self.frame(now, frame.map_err(End::protocol)?)?;
        }
        Ok(())
    }

    fn frame(&mut self, now: Now, frame: Frame) -> Result<(), End> {
        let Phase::Open(open) = &mut self.phase else { return Ok(()) };
        match (frame, &mut open.up) {
            (Frame::Bye(bye), _) => {
                let refused = !matches!(bye.code, ByeCode::Ending | ByeCode::Silent);
                let reason = format!("the shore closes the link: {} ({:?})", bye.text, bye.code);
                return Err(End { code: None, reason, refused });
            }
            (Frame::Welcome(welcome), None) => return self.welcome(now, &welcome),
            (Frame::Ack(ack), Some(up)) => {
                if let Some(took) = open.pace.arrived(now.mono, ack.bytes) {
                    self.arriving.add(took);
                }
                match up.ack(now.mono, ack, &mut self.keeping) {
                    None => return Err(End::protocol("the shore acknowledges what was never sent")),
                    Some(true) => {
                        self.durable = ack.durable;
                        self.outputs.push_back(VesselOutput::Acknowledged(ack.durable));
                    }
                    Some(false) => {}
                }
            }
            (Frame::Heartbeat(beat), Some(_)) => {
                // A shore that welcomes and then throws out is no success.
                self.backoff.succeeded();
                open.clocks.heard(now, beat.stamp);
                if let Some(took) = open.pace.arrived(now.mono, beat.bytes) {
                    self.arriving.add(took);
                }
            }
            (Frame::Command(command), Some(_)) => self.command(now, command),
            (Frame::Lease(lease), Some(_)) => self.outputs.push_back(VesselOutput::Lease(lease)),
            (Frame::Chart(offer), Some(_)) => {
                let want = self.pull.offered(offer);
                self.want(now, want);
            }
            (Frame::ChartPart(part), Some(_)) => return self.chart_part(now, &part),
            (
                Frame::Ack(_)
                | Frame::Heartbeat(_)
                | Frame::Command(_)
                | Frame::Lease(_)
                | Frame::Chart(_)
                | Frame::ChartPart(_),
                None,
            ) => {
                return Err(End::protocol("the shore speaks before it agreed"));
            }
            (_, _) => return Err(End::protocol("a frame that only a vessel sends, or a second welcome")),
        }
        Ok(())
    }

    fn chart_part(&mut self, now: Now, part: &ChartPart) -> Result<(), End> {
        let Phase::Open(open) = &self.phase else { return Ok(()) };
        let round_trip = open.clocks.shortest_round_trip();
        let came = self.pull.part(now.mono, part, round_trip).map_err(End::protocol)?;
        self.outputs.extend(came.map(|(offset, bytes)| VesselOutput::ChartPart {
            digest: part.digest,
            offset,
            bytes,
        }));
        Ok(())
    }

    fn welcome(&mut self, now: Now, welcome: &Welcome) -> Result<(), End> {
        if welcome.version > VERSION || welcome.version < OLDEST_VERSION {
            return Err(End::protocol(format_args!(
                "the shore chose version {}, this program speaks {OLDEST_VERSION} to {VERSION}",
                welcome.version
            )));
        }
        if welcome.resume > self.settings.spool.next {
            self.outputs.push_back(VesselOutput::Renumber);
            let reason = format!("the shore has records below {}, more than were spooled", welcome.resume);
            return Err(End { code: Some(ByeCode::Ending), reason, refused: false });
        }
        let Phase::Open(open) = &mut self.phase else { return Ok(()) };
        open.clocks.heard(now, welcome.stamp);
        open.up = Some(Up::new(now.mono, welcome, self.settings.budget_bytes_per_s));
        self.pull.linked(welcome.capabilities.has(Capabilities::CHARTS));
        self.connections += 1;
        self.live.refresh();
        self.outputs.push_back(VesselOutput::Up);
        if welcome.resume > self.durable {
            self.durable = welcome.resume;
            self.outputs.push_back(VesselOutput::Acknowledged(welcome.resume));
        }
        Ok(())
    }

    fn command(&mut self, now: Now, command: Command) {
        let Phase::Open(open) = &self.phase else { return };
        let id = command.id;
        let age = open.clocks.greatest_age(now.mono, command.sent);
        match self.seen.look(id) {
            First::Unanswered => {}
            First::Answered(receipt) => self.send(now, message(&Frame::Receipt(receipt))),
            First::New => {
                let left = age.and_then(|age| {
                    let ttl = Duration::from_millis(u64::from(command.ttl_ms));
                    ttl.checked_sub(age).filter(|left| !left.is_zero())
                });
                match left {
                    Some(left) => {
                        let (lease, packet, expires) = (command.lease, command.packet, now.mono + left);
                        self.outputs.push_back(VesselOutput::Command { id, lease, packet, expires });
                    }
                    None => self.answer(now, id, Answer::Expired),
                }
            }
        }
    }

    fn answer(&mut self, now: Now, id: u64, answer: Answer) {
        let (verdict, text) = match answer {
            Answer::Received => (Verdict::Received, String::new()),
            Answer::Expired => (Verdict::Expired, String::new()),
            Answer::Refused(text) => (Verdict::Refused, text),
        };
        let receipt = self.seen.answer(id, verdict, text);
        let is_up = matches!(&self.phase, Phase::Open(open) if open.up.is_some());
        if let Some(receipt) = receipt.filter(|_| is_up) {
            self.send(now, message(&Frame::Receipt(receipt)));
        }
    }
}
