//! The shore's state machine: which connection counts, what is received, what is sent down.

use super::connected::{Connected, Joined};
use super::{Outcome, ShoreInput, ShoreOutput, ShoreSettings, ShoreStatus};
use crate::clocks::{ClockEstimate, Clocks};
use crate::commands::{Pending, Waiting};
use crate::frame::{
    Bye, ByeCode, Capabilities, ChartOffer, ChartRequest, Commander, Frame, Hello, OLDEST_VERSION, Receipt,
    VERSION, Verdict, Welcome, decode, message,
};
use crate::ways::MOST_WAYS;
use crate::{ConnectionId, GREETING_WITHIN, Latency, unpack};
use bytes::Bytes;
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;
use units::{MonoTime, Now};

/// Connections that may greet at once; the oldest is closed for one more.
const MOST_GREETING: usize = MOST_WAYS + 4;
const GREATEST_TTL: Duration = Duration::from_hours(24);

/// The shore's end of the link to one vessel, over all its connections. It holds commands that wait for an answer
/// (256 at most; one more is refused) and no records: those go out as they come.
#[derive(Debug)]
pub struct Shore {
    settings: ShoreSettings,
    pub(super) outputs: VecDeque<ShoreOutput>,
    greeting: BTreeMap<ConnectionId, Greeting>,
    /// The open ones: one, or one for each way of a vessel that has several.
    pub(super) sessions: BTreeMap<ConnectionId, Connected>,
    /// The records received over all of them; present while one is open.
    joined: Option<Joined>,
    /// The connection that commands go by, and the choice of the vessel's that it follows from.
    bearer: Option<ConnectionId>,
    choice: u64,
    /// The connection by which records came last.
    records_by: Option<ConnectionId>,
    /// The latest connection of each way; without ways the only one's.
    latest: BTreeMap<Option<u8>, Which>,
    /// The number of the newest live message of that start of the vessel's program.
    last_live: u64,
    pub(super) commands: Pending,
    pub(super) lease: Option<Commander>,
    /// The chart that vessels are to have, once that is known.
    pub(super) chart: Option<ChartOffer>,
    /// The part that the driver reads, over which connection it goes.
    pub(super) reading: Option<(ConnectionId, ChartRequest)>,
    /// When the lease is sent again.
    pub(super) next_lease: MonoTime,
    /// Leases sent to vessels with several ways.
    pub(super) leases: u64,
    transit: Latency,
    received_bytes: u64,
    repeated: u64,
    connections: u64,
}

/// The connection that counts, or counted last, on a way.
#[derive(Debug, Clone, Copy)]
struct Which {
    stream: u64,
    incarnation: u64,
    attempt: u64,
}

impl Which {
    fn of(hello: &Hello) -> Self {
        Self { stream: hello.stream, incarnation: hello.incarnation, attempt: hello.attempt }
    }

    /// Whether both are of one start of the vessel's program.
    fn is_same_start(self, other: Self) -> bool {
        (self.stream, self.incarnation) == (other.stream, other.incarnation)
    }

    /// Whether this connection is `latest` or an earlier one. A spool that was rebuilt counts from the beginning.
    fn is_no_later_than(self, latest: Self) -> bool {
        self.stream == latest.stream
            && (self.incarnation, self.attempt) <= (latest.incarnation, latest.attempt)
    }
}

/// A connection that is not open yet.
#[derive(Debug)]
struct Greeting {
    since: MonoTime,
    clocks: Clocks,
    bytes: u64,
    hello: Option<Hello>,
}

/// Why a connection is closed.
type End = (ByeCode, String);

fn protocol(reason: impl std::fmt::Display) -> End {
    (ByeCode::Protocol, reason.to_string())
}

impl Shore {
    /// A shore that waits for its vessel.
    pub fn new(settings: ShoreSettings) -> Self {
        Self {
            settings,
            outputs: VecDeque::new(),
            greeting: BTreeMap::new(),
            sessions: BTreeMap::new(),
            joined: None,
            bearer: None,
            choice: 0,
            records_by: None,
            latest: BTreeMap::new(),
            last_live: 0,
            commands: Pending::default(),
            lease: None,
            chart: None,
            reading: None,
            next_lease: MonoTime::default(),
            leases: 0,
            transit: Latency::default(),
            received_bytes: 0,
            repeated: 0,
            connections: 0,
        }
    }

    /// Takes an input.
    pub fn handle(&mut self, now: Now, input: ShoreInput) {
        match input {
            ShoreInput::Timer => {}
            ShoreInput::Opened(id) => self.opened(now, id),
            ShoreInput::Message(id, bytes) => {
                if let Err(end) = self.message(now, id, bytes) {
                    self.end(id, end);
                }
            }
            ShoreInput::Closed(id) => self.forget(id),
            ShoreInput::Resume(id, durable) => self.resume(now, id, durable),
            ShoreInput::Refuse(id, text) => self.end(id, (ByeCode::Refused, text)),
            ShoreInput::Durable { stream, seq } => self.kept(stream, seq),
            ShoreInput::Command { id, ttl, lease, order, overtakes, packet } => {
                self.command(
                    now,
                    id,
                    Waiting::new(lease, order, packet, now.mono + ttl.min(GREATEST_TTL)),
                    overtakes,
                );
            }
            ShoreInput::Lease(commander) => {
                self.lease = Some(commander);
                self.tell_lease(now);
            }
            ShoreInput::Chart(chart) => {
                self.chart = Some(chart.unwrap_or_else(ChartOffer::none));
                self.offer_chart(None);
            }
            ShoreInput::ChartPart(id, ask, bytes) => self.give_part(id, &ask, bytes),
            ShoreInput::Shutdown => {
                let all: Vec<ConnectionId> =
                    self.greeting.keys().chain(self.sessions.keys()).copied().collect();
                for id in all {
                    self.end(id, (ByeCode::Ending, "the server ends".to_owned()));
                }
            }
        }
        self.step(now);
    }

    /// The next output.
    pub fn poll_output(&mut self) -> Option<ShoreOutput> {
        self.outputs.pop_front()
    }

    /// When to come back with [`ShoreInput::Timer`] at the latest; `None` for never.
    pub fn poll_timeout(&self, now: Now) -> Option<MonoTime> {
        let greeting = self.greeting.values().map(|one| one.since + GREETING_WITHIN);
        let connected = self.sessions.values().map(|one| one.next_heartbeat.min(one.dead_at()));
        let late = self.commands.late_at(now.mono).filter(|_| self.sessions.len() > 1);
        greeting.chain(connected).chain(self.commands.next_end()).chain(self.lease_due()).chain(late).min()
    }

    /// The offset of the vessel's clocks to ours.
    pub fn clocks(&self, now: Now) -> Option<ClockEstimate> {
        self.carrier().and_then(|one| one.clocks.estimate(now))
    }

    /// Whether a greeting adds a connection to those that are open. Records, commands and leases then continue unchanged.
    pub fn joins(&self, id: ConnectionId) -> bool {
        let hello = self.greeting.get(&id).and_then(|greeting| greeting.hello.as_ref());
        hello.is_some_and(|hello| self.is_joining(hello))
    }

    /// Open connections.
    pub fn standing(&self) -> usize {
        self.sessions.len()
    }

    /// How the link is. Latencies start over.
    pub fn status(&mut self, now: Now) -> ShoreStatus {
        let carrier = self.carrier();
        ShoreStatus {
            up: carrier.is_some(),
            clocks: carrier.and_then(|one| one.clocks.estimate(now)),
            round_trip: carrier.and_then(|one| one.clocks.round_trip()),
            transit: std::mem::take(&mut self.transit),
            backlog: self.joined.as_ref().map(|joined| joined.backlog).unwrap_or_default(),
            received_bytes: self.received_bytes,
            repeated: self.repeated,
            connections: self.connections,
            standing: self.sessions.len() as u32,
        }
    }

    /// The connection that commands go by: the one that the vessel chose, or the one that was heard last.
    pub(super) fn carrier(&self) -> Option<&Connected> {
        let chosen = self.bearer.and_then(|id| self.sessions.get(&id));
        chosen.or_else(|| self.sessions.values().max_by_key(|one| one.heard))
    }

    /// Whether a connection by this greeting is kept beside others of the same start of the vessel's program, by other
    /// ways.
    fn is_joining(&self, hello: &Hello) -> bool {
        let Some(way) = &hello.way else { return false };
        let which = Which::of(hello);
        self.latest.values().all(|latest| latest.is_same_start(which))
            && self.sessions.values().all(|one| one.way.is_some())
            && self.sessions.values().any(|one| one.place() != Some(way.index))
    }

    fn kept(&mut self, stream: u64, seq: u64) {
        let Some(joined) = self.joined.as_mut().filter(|joined| joined.stream == stream) else { return };
        if joined.kept(seq.saturating_add(1)) {
            // The way that carried the records waits for it; over the other ways it goes with their next heartbeat.
            let sender = self.records_by.filter(|id| self.sessions.contains_key(id));
            let sender = sender.or_else(|| self.carrier().map(|one| one.id));
            if let Some(one) = sender.and_then(|id| self.sessions.get_mut(&id)) {
                one.ack_due = true;
            }
        }
    }

    fn opened(&mut self, now: Now, id: ConnectionId) {
        if self.greeting.len() >= MOST_GREETING
            && let Some(oldest) = self.greeting.keys().next().copied()
        {
            self.end(oldest, (ByeCode::Replaced, "too many connections that do not greet".to_owned()));
        }
        let greeting = Greeting { since: now.mono, clocks: Clocks::default(), bytes: 0, hello: None };
        self.greeting.insert(id, greeting);
    }

    /// Drops the state of a connection.
    fn forget(&mut self, id: ConnectionId) {
        self.greeting.remove(&id);
        if self.sessions.remove(&id).is_none() {
            return;
        }
        self.commands.forget(id);
        if self.sessions.is_empty() {
            (self.joined, self.bearer, self.records_by) = (None, None, None);
            self.outputs.push_back(ShoreOutput::Down);
        }
    }

    /// Closes a known connection.
    fn end(&mut self, id: ConnectionId, (code, text): End) {
        if !self.greeting.contains_key(&id) && !self.sessions.contains_key(&id) {
            return;
        }
        if code != ByeCode::Silent {
            self.send(id, &Frame::Bye(Bye { code, text: text.clone() }));
        }
        self.outputs.push_back(ShoreOutput::Close(id, code, text));
        self.forget(id);
    }

    pub(super) fn send(&mut self, id: ConnectionId, frame: &Frame) {
        self.outputs.push_back(ShoreOutput::Send(id, message(frame)));
    }

    fn message(&mut self, now: Now, id: ConnectionId, bytes: Bytes) -> Result<(), End> {
        let length = bytes.len() as u64;
        if let Some(connected) = self.sessions.get_mut(&id) {
            connected.heard = now.mono;
            connected.bytes += length;
        } else if let Some(greeting) = self.greeting.get_mut(&id) {
            greeting.bytes += length;
        } else {
            return Ok(());
        }
        self.received_bytes += length;
        for frame in decode(bytes).map_err(protocol)? {
            let frame = frame.map_err(protocol)?;
            if self.greeting.contains_key(&id) {
                self.greet(now, id, frame)?;
            } else {
                self.frame(now, id, frame)?;
            }
        }
        Ok(())
    }

    fn greet(&mut self, now: Now, id: ConnectionId, frame: Frame) -> Result<(), End> {
        let Some(greeting) = self.greeting.get_mut(&id) else { return Ok(()) };
        let hello = match frame {
            Frame::Hello(hello) if greeting.hello.is_none() => hello,
            Frame::Bye(bye) => return Err((ByeCode::Ending, bye.text)),
            _ => return Err(protocol("something else than one greeting before the welcome")),
        };
        if hello.oldest_version > VERSION || hello.version < OLDEST_VERSION {
            let text = format!(
                "the vessel speaks versions {} to {}, this server {OLDEST_VERSION} to {VERSION}; update the older",
                hello.oldest_version, hello.version
            );
            return Err((ByeCode::Version, text));
        }
        if self.is_overtaken(&hello) {
            return Err((ByeCode::Replaced, "a later connection of this vessel was seen".to_owned()));
        }
        if let Some(greeting) = self.greeting.get_mut(&id) {
            greeting.clocks.heard(now, hello.stamp);
            greeting.hello = Some(hello.clone());
        }
        self.outputs.push_back(ShoreOutput::Hello(id, Box::new(hello)));
        Ok(())
    }

    fn resume(&mut self, now: Now, id: ConnectionId, durable: Option<u64>) {
        let Some(Greeting { clocks, bytes, hello: Some(hello), .. }) = self.greeting.remove(&id) else {
            return;
        };
        if self.is_overtaken(&hello) {
            let text = "a later connection of this vessel was seen".to_owned();
            self.send(id, &Frame::Bye(Bye { code: ByeCode::Replaced, text: text.clone() }));
            self.outputs.push_back(ShoreOutput::Close(id, ByeCode::Replaced, text));
            return;
        }
        let resume = durable.map_or(0, |seq| seq.saturating_add(1));
        self.make_room(&hello, resume);
        self.connections += 1;
        let mut capabilities = hello.capabilities.and(Capabilities::ALL);
        if hello.way.is_none() {
            capabilities = capabilities.and(Capabilities::OF_ONE_WAY);
        }
        let welcome = Welcome {
            version: hello.version.min(VERSION),
            capabilities,
            resume,
            window_bytes: self.settings.window_bytes,
            stamp: clocks.stamp(now),
            run: hello.way.is_some().then_some(self.settings.run),
        };
        self.send(id, &Frame::Welcome(welcome));
        self.sessions.insert(id, Connected::new(now.mono, id, hello.way, (capabilities, clocks, bytes)));
        self.outputs.push_back(ShoreOutput::Up(id));
        // Before the commands, which are obeyed under it.
        self.tell_lease(now);
        self.commands(now);
        self.offer_chart(Some(id));
    }

    /// Closes the connections that a new one takes the place of, and begins the stream anew where none is left.
    fn make_room(&mut self, hello: &Hello, resume: u64) {
        let (way, which) = (hello.way.as_ref().map(|way| way.index), Which::of(hello));
        let joined = self.joined.take().filter(|_| self.is_joining(hello));
        let stays = |one: &Connected| joined.is_some() && one.place() != way;
        let replaced = self.sessions.values().filter(|one| !stays(one));
        for old in replaced.map(|one| one.id).collect::<Vec<_>>() {
            self.end(old, (ByeCode::Replaced, "the vessel connected again".to_owned()));
        }
        if self.latest.values().any(|latest| !latest.is_same_start(which)) {
            self.latest.clear();
            self.commands.started_again();
            (self.choice, self.last_live) = (0, 0);
        }
        self.latest.insert(way, which);
        let mut joined = joined.unwrap_or_else(|| {
            self.reading = None;
            Joined::new(hello, resume)
        });
        joined.again(resume);
        self.joined = Some(joined);
    }

    /// Whether a later connection was seen: of this way, or of a later start of the vessel's program.
    fn is_overtaken(&self, hello: &Hello) -> bool {
        let (way, which) = (hello.way.as_ref().map(|way| way.index), Which::of(hello));
        self.latest.iter().any(|(other, latest)| {
            let alike = *other == way || way.is_none() || other.is_none();
            let latest = if alike { *latest } else { Which { attempt: 0, ..*latest } };
            which.is_no_later_than(latest)
        })
    }

    fn frame(&mut self, now: Now, id: ConnectionId, frame: Frame) -> Result<(), End> {
        let (Some(one), Some(joined)) = (self.sessions.get_mut(&id), &mut self.joined) else { return Ok(()) };
        // The vessel measures its way by the delay of each answer: one that waits for the next heartbeat makes it suspect.
        one.ack_due |= one.way.is_some();
        match frame {
            Frame::Records(batch) => {
                (one.ack_due, self.records_by) = (true, Some(id));
                let records = unpack(&batch).map_err(protocol)?;
                let counters = (&mut self.transit, &mut self.repeated);
                let output = joined.records(now, &one.clocks, records, counters);
                self.outputs.extend(output.map_err(protocol)?);
            }
            Frame::Gap(gap) => {
                (one.ack_due, self.records_by) = (true, Some(id));
                self.outputs.extend(joined.gap(gap).map_err(protocol)?);
            }
            Frame::Live(batch) => {
                one.ack_due = true;
                let records = unpack(&batch).map_err(protocol)?;
                let newer = batch.first > self.last_live;
                self.last_live = self.last_live.max(batch.first);
                if one.way.is_none() || newer {
                    self.outputs.push_back(ShoreOutput::Live(records));
                }
            }
            Frame::Heartbeat(beat) => {
                one.clocks.heard(now, beat.stamp);
                let alone = self.records_by.is_none_or(|by| by == id);
                joined.heartbeat(&beat, alone || one.way.is_none());
            }
            Frame::Receipt(receipt) => self.receipt(receipt),
            Frame::ChartRequest(ask) => self.chart_ask(id, ask),
            Frame::ChartReport(report) => self.outputs.push_back(ShoreOutput::ChartReport(report)),
            Frame::Ways(report) => {
                if report.choice >= self.choice {
                    (self.choice, self.bearer) = (report.choice, Some(id));
                    self.outputs.push_back(ShoreOutput::Ways(report));
                }
            }
            Frame::Bye(bye) => {
                return Err((ByeCode::Ending, format!("the vessel closes the link: {}", bye.text)));
            }
            Frame::Hello(_)
            | Frame::Welcome(_)
            | Frame::Ack(_)
            | Frame::Command(_)
            | Frame::Lease(_)
            | Frame::Chart(_)
            | Frame::ChartPart(_) => {
                return Err(protocol("a frame that only a shore sends, or a second greeting"));
            }
        }
        Ok(())
    }

    fn receipt(&mut self, receipt: Receipt) {
        let id = receipt.id;
        let Some(command) = self.commands.answered(id) else {
            if receipt.order > 0 {
                self.outputs.push_back(ShoreOutput::Stray(receipt));
            }
            return;
        };
        let outcome = match receipt.verdict {
            Verdict::Received => Outcome::Received,
            // An earlier start of the vessel's program may have carried it out and not said so.
            _ if command.sent_before_start => Outcome::Unanswered,
            Verdict::Expired => Outcome::Expired,
            Verdict::Refused => Outcome::Refused(receipt.text),
        };
        self.outputs.push_back(ShoreOutput::Outcome(id, outcome));
    }

    fn step(&mut self, now: Now) {
        let silent: Vec<ConnectionId> = self
            .greeting
            .iter()
            .filter(|(_, one)| now.mono.since(one.since) >= GREETING_WITHIN)
            .map(|(id, _)| *id)
            .chain(self.sessions.values().filter(|one| now.mono >= one.dead_at()).map(|one| one.id))
            .collect();
        for id in silent {
            self.end(id, (ByeCode::Silent, "nothing heard in time".to_owned()));
        }
        if self.lease_due().is_some_and(|due| now.mono >= due) {
            self.tell_lease(now);
        }
        self.commands(now);
        if let Some(joined) = &self.joined {
            let due = self.sessions.values_mut().map(|one| (one.id, one.due(now, joined)));
            for (id, frames) in due.collect::<Vec<_>>() {
                for frame in frames {
                    self.send(id, &frame);
                }
            }
        }
        for (id, sent) in self.commands.overdue(now.mono) {
            let outcome = if sent { Outcome::Unanswered } else { Outcome::Expired };
            self.outputs.push_back(ShoreOutput::Outcome(id, outcome));
        }
    }
}
