//! The shore's state machine: which connection counts, what is received, what is sent down.

use super::connected::Connected;
use super::{Outcome, ShoreInput, ShoreOutput, ShoreSettings, ShoreStatus};
use crate::clocks::{ClockEstimate, Clocks};
use crate::commands::{Pending, Waiting};
use crate::frame::{
    Bye, ByeCode, Capabilities, ChartOffer, ChartPart, ChartRequest, Command, Commander, Frame, Hello, Lease,
    MAX_PART_BYTES, OLDEST_VERSION, Receipt, VERSION, Verdict, Welcome, decode, message,
};
use crate::{ConnectionId, DEAD_AFTER, GREETING_WITHIN, Latency, unpack};
use bytes::Bytes;
use std::collections::{BTreeMap, VecDeque};
use std::time::Duration;
use units::{MonoTime, Now};

/// Connections that may greet at once; the oldest is closed for one more.
const MOST_GREETING: usize = 4;
const GREATEST_TTL: Duration = Duration::from_hours(24);
/// A lease is told again this often, and dies aboard when it was not for so long.
const LEASE_EVERY: Duration = Duration::from_secs(10);
const LEASE_LASTS: Duration = Duration::from_secs(30);

/// The shore's end of the link to one vessel, over all its connections. It holds commands that wait for an answer
/// (256 at most; one more is refused) and no records: those go out as they come.
#[derive(Debug)]
pub struct Shore {
    settings: ShoreSettings,
    outputs: VecDeque<ShoreOutput>,
    greeting: BTreeMap<ConnectionId, Greeting>,
    connected: Option<Connected>,
    latest: Option<Which>,
    commands: Pending,
    lease: Option<Commander>,
    /// What vessels are to have, once that is known.
    chart: Option<ChartOffer>,
    /// The part that the driver reads, over which connection it goes.
    reading: Option<(ConnectionId, ChartRequest)>,
    /// When the lease is told again.
    next_lease: MonoTime,
    transit: Latency,
    received_bytes: u64,
    repeated: u64,
    connections: u64,
}

/// The connection that counts, or counted last.
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

    /// Whether this connection is `latest` or an earlier one. A spool that was rebuilt counts from the beginning.
    fn is_no_later_than(self, latest: Self) -> bool {
        self.stream == latest.stream
            && (self.incarnation, self.attempt) <= (latest.incarnation, latest.attempt)
    }
}

/// A connection that does not stand yet.
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
            connected: None,
            latest: None,
            commands: Pending::default(),
            lease: None,
            chart: None,
            reading: None,
            next_lease: MonoTime::default(),
            transit: Latency::default(),
            received_bytes: 0,
            repeated: 0,
            connections: 0,
        }
    }

    /// Something happened.
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
            ShoreInput::Durable { stream, seq } => {
                if let Some(connected) = self.connected.as_mut().filter(|one| one.stream == stream) {
                    connected.kept(seq.saturating_add(1));
                }
            }
            ShoreInput::Command { id, ttl, lease, overtakes, packet } => {
                for off in if overtakes { self.commands.call_off() } else { Vec::new() } {
                    let text = "a stop was ordered before it could be sent".to_owned();
                    self.outputs.push_back(ShoreOutput::Outcome(off, Outcome::Refused(text)));
                }
                let expires = now.mono + ttl.min(GREATEST_TTL);
                if !self.commands.put(id, Waiting { lease, packet, expires, sent: false, called_off: false })
                {
                    let text = "too many commands wait for this vessel, or its identity is taken";
                    self.outputs.push_back(ShoreOutput::Outcome(id, Outcome::Refused(text.to_owned())));
                }
            }
            ShoreInput::Lease(commander) => {
                self.lease = Some(commander);
                self.tell_lease(now);
            }
            ShoreInput::Chart(chart) => {
                self.chart = Some(chart.unwrap_or_else(ChartOffer::none));
                self.offer_chart();
            }
            ShoreInput::ChartPart(id, ask, bytes) => self.give_part(id, &ask, bytes),
            ShoreInput::Shutdown => {
                let all: Vec<ConnectionId> =
                    self.greeting.keys().copied().chain(self.connected.iter().map(|one| one.id)).collect();
                for id in all {
                    self.end(id, (ByeCode::Ending, "the server ends".to_owned()));
                }
            }
        }
        self.step(now);
    }

    /// The next thing to do.
    pub fn poll_output(&mut self) -> Option<ShoreOutput> {
        self.outputs.pop_front()
    }

    /// When to come back with [`ShoreInput::Timer`] at the latest; `None` for never.
    pub fn poll_timeout(&self) -> Option<MonoTime> {
        let greeting = self.greeting.values().map(|one| one.since + GREETING_WITHIN);
        let connected = self.connected.iter().map(|one| one.next_heartbeat.min(one.heard + DEAD_AFTER));
        greeting.chain(connected).chain(self.commands.next_end()).chain(self.lease_due()).min()
    }

    /// How the vessel's clocks stand to ours.
    pub fn clocks(&self, now: Now) -> Option<ClockEstimate> {
        self.connected.as_ref().and_then(|one| one.clocks.estimate(now))
    }

    /// How the link is. Latencies start over.
    pub fn status(&mut self, now: Now) -> ShoreStatus {
        let connected = self.connected.as_ref();
        ShoreStatus {
            up: connected.is_some(),
            clocks: connected.and_then(|one| one.clocks.estimate(now)),
            round_trip: connected.and_then(|one| one.clocks.round_trip()),
            transit: std::mem::take(&mut self.transit),
            backlog: connected.map(|one| one.backlog).unwrap_or_default(),
            received_bytes: self.received_bytes,
            repeated: self.repeated,
            connections: self.connections,
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

    /// Drops what is known of a connection.
    fn forget(&mut self, id: ConnectionId) {
        self.greeting.remove(&id);
        if self.connected.take_if(|one| one.id == id).is_some() {
            self.outputs.push_back(ShoreOutput::Down);
        }
    }

    /// Closes a connection that is known.
    fn end(&mut self, id: ConnectionId, (code, text): End) {
        let known =
            self.greeting.contains_key(&id) || self.connected.as_ref().is_some_and(|one| one.id == id);
        if !known {
            return;
        }
        if code != ByeCode::Silent {
            self.send(id, &Frame::Bye(Bye { code, text: text.clone() }));
        }
        self.outputs.push_back(ShoreOutput::Close(id, code, text));
        self.forget(id);
    }

    fn send(&mut self, id: ConnectionId, frame: &Frame) {
        self.outputs.push_back(ShoreOutput::Send(id, message(frame)));
    }

    fn message(&mut self, now: Now, id: ConnectionId, bytes: Bytes) -> Result<(), End> {
        let length = bytes.len() as u64;
        if let Some(connected) = self.connected.as_mut().filter(|one| one.id == id) {
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
                self.frame(now, frame)?;
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
        if self.latest.is_some_and(|latest| Which::of(&hello).is_no_later_than(latest)) {
            return Err((ByeCode::Replaced, "a later connection of this vessel was seen".to_owned()));
        }
        greeting.clocks.heard(now, hello.stamp);
        greeting.hello = Some(hello.clone());
        self.outputs.push_back(ShoreOutput::Hello(id, Box::new(hello)));
        Ok(())
    }

    fn resume(&mut self, now: Now, id: ConnectionId, durable: Option<u64>) {
        let Some(Greeting { clocks, bytes, hello: Some(hello), .. }) = self.greeting.remove(&id) else {
            return;
        };
        let which = Which::of(&hello);
        if self.latest.is_some_and(|latest| which.is_no_later_than(latest)) {
            let text = "a later connection of this vessel was seen".to_owned();
            self.send(id, &Frame::Bye(Bye { code: ByeCode::Replaced, text: text.clone() }));
            self.outputs.push_back(ShoreOutput::Close(id, ByeCode::Replaced, text));
            return;
        }
        if let Some(old) = self.connected.as_ref().map(|one| one.id) {
            self.end(old, (ByeCode::Replaced, "the vessel connected again".to_owned()));
        }
        self.latest = Some(which);
        self.connections += 1;
        let resume = durable.map_or(0, |seq| seq.saturating_add(1));
        let capabilities = hello.capabilities.and(Capabilities::ALL);
        let welcome = Welcome {
            version: hello.version.min(VERSION),
            capabilities,
            resume,
            window_bytes: self.settings.window_bytes,
            stamp: clocks.stamp(now),
        };
        self.send(id, &Frame::Welcome(welcome));
        let rest = (capabilities, clocks, bytes);
        self.connected = Some(Connected::new(now.mono, id, hello.stream, resume, rest));
        self.outputs.push_back(ShoreOutput::Up(id));
        // Before the commands, which are obeyed by it.
        self.tell_lease(now);
        self.commands(now, true);
        self.reading = None;
        self.offer_chart();
    }

    fn frame(&mut self, now: Now, frame: Frame) -> Result<(), End> {
        let Some(connected) = &mut self.connected else { return Ok(()) };
        match frame {
            Frame::Records(batch) => {
                let records = unpack(&batch).map_err(protocol)?;
                let counters = (&mut self.transit, &mut self.repeated);
                self.outputs.extend(connected.records(now, records, counters).map_err(protocol)?);
            }
            Frame::Gap(gap) => self.outputs.extend(connected.gap(gap).map_err(protocol)?),
            Frame::Live(batch) => {
                connected.live();
                self.outputs.push_back(ShoreOutput::Live(unpack(&batch).map_err(protocol)?));
            }
            Frame::Heartbeat(beat) => connected.heartbeat(now, &beat),
            Frame::Receipt(Receipt { id, verdict, text }) => {
                if self.commands.answered(id) {
                    let outcome = match verdict {
                        Verdict::Received => Outcome::Received,
                        Verdict::Expired => Outcome::Expired,
                        Verdict::Refused => Outcome::Refused(text),
                    };
                    self.outputs.push_back(ShoreOutput::Outcome(id, outcome));
                }
            }
            Frame::ChartRequest(ask) => self.chart_ask(ask),
            Frame::ChartReport(report) => self.outputs.push_back(ShoreOutput::ChartReport(report)),
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

    fn offer_chart(&mut self) {
        let (Some(connected), Some(offer)) = (&self.connected, &self.chart) else { return };
        if connected.capabilities.has(Capabilities::CHARTS) {
            let (id, frame) = (connected.id, Frame::Chart(offer.clone()));
            self.send(id, &frame);
        }
    }

    /// Has a part read, if it is of the chart that is offered; one at a time, whatever a vessel asks.
    fn chart_ask(&mut self, ask: ChartRequest) {
        let Some(id) = self.connected.as_ref().map(|one| one.id) else { return };
        let offered = self.chart.as_ref().filter(|chart| chart.digest == ask.digest);
        let Some(left) =
            offered.and_then(|chart| chart.bytes.checked_sub(ask.offset)).filter(|left| *left > 0)
        else {
            self.send(id, &Frame::ChartPart(ChartPart::gone(&ask)));
            return;
        };
        if self.reading.is_none() {
            let length = u64::from(ask.length).min(MAX_PART_BYTES as u64).min(left) as u32;
            let ask = ChartRequest { length, ..ask };
            self.reading = Some((id, ask));
            self.outputs.push_back(ShoreOutput::ChartPart(id, ask));
        }
    }

    fn give_part(&mut self, id: ConnectionId, ask: &ChartRequest, bytes: Option<Bytes>) {
        if self.reading.take_if(|reading| *reading == (id, *ask)).is_none() {
            return;
        }
        let Some(connected) = self.connected.as_ref().filter(|one| one.id == id) else { return };
        let zstd = connected.capabilities.has(Capabilities::ZSTD);
        let bytes = bytes.filter(|bytes| !bytes.is_empty() && bytes.len() <= ask.length as usize);
        let part = bytes.map_or_else(|| ChartPart::gone(ask), |bytes| ChartPart::pack(ask, bytes, zstd));
        self.send(id, &Frame::ChartPart(part));
    }

    /// Sends the commands that can still be in time: all, or those that were not sent yet.
    fn commands(&mut self, now: Now, all: bool) {
        let Some(connected) = &self.connected else { return };
        if !connected.capabilities.has(Capabilities::COMMANDS) {
            return;
        }
        let id = connected.id;
        for (command, waiting) in self.commands.sendable(now.mono, all) {
            // Rounded down: better too early than too late.
            let ttl_ms = waiting.expires.since(now.mono).as_millis() as u32;
            let Waiting { lease, packet, .. } = waiting;
            let frame = Command { id: command, sent: now.mono, ttl_ms, lease, packet };
            self.send(id, &Frame::Command(frame));
        }
    }

    /// When the lease is to be told again: while somebody has it and the link stands.
    fn lease_due(&self) -> Option<MonoTime> {
        let held = matches!(self.lease, Some(Commander { holder: Some(_), .. }));
        self.connected.as_ref().filter(|_| held).map(|_| self.next_lease)
    }

    fn tell_lease(&mut self, now: Now) {
        self.next_lease = now.mono + LEASE_EVERY;
        let (Some(connected), Some(Commander { epoch, holder })) = (&self.connected, &self.lease) else {
            return;
        };
        let lasts = if holder.is_some() { LEASE_LASTS } else { Duration::ZERO };
        let frame = Lease {
            epoch: *epoch,
            ttl_ms: lasts.as_millis() as u32,
            holder: holder.clone().unwrap_or_default(),
        };
        self.send(connected.id, &Frame::Lease(frame));
    }

    fn step(&mut self, now: Now) {
        let silent: Vec<ConnectionId> = self
            .greeting
            .iter()
            .filter(|(_, one)| now.mono.since(one.since) >= GREETING_WITHIN)
            .map(|(id, _)| *id)
            .chain(
                self.connected.iter().filter(|one| now.mono.since(one.heard) >= DEAD_AFTER).map(|one| one.id),
            )
            .collect();
        for id in silent {
            self.end(id, (ByeCode::Silent, "nothing heard in time".to_owned()));
        }
        if self.lease_due().is_some_and(|due| now.mono >= due) {
            self.tell_lease(now);
        }
        self.commands(now, false);
        if let Some(connected) = &mut self.connected {
            let id = connected.id;
            for frame in connected.due(now) {
                self.send(id, &frame);
            }
        }
        for (id, sent) in self.commands.overdue(now.mono) {
            let outcome = if sent { Outcome::Unanswered } else { Outcome::Expired };
            self.outputs.push_back(ShoreOutput::Outcome(id, outcome));
        }
    }
}
