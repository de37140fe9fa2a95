//! The vessel's state machine: when to connect by which way, what to send, what to accept.

use super::chart::{Pull, Want};
use super::records::LagTracker;
use super::up::Step;
use super::way::{Open, Phase, Way};
use super::{Entry, Failure, VesselInput, VesselOutput, VesselSettings, VesselStatus};
use crate::clocks::Clocks;
use crate::commands::Seen;
use crate::frame::{Bye, ByeCode, Capabilities, Frame, Hello, OLDEST_VERSION, VERSION, message};
use crate::live::LiveSet;
use crate::pace::Pace;
use crate::ways::{MOST_WAYS, Used, WayHello, WaySettings, WayState, WaysReport};
use crate::{ConnectionId, GREETING_WITHIN, Latency};
use bytes::Bytes;
use std::collections::VecDeque;
use std::time::Duration;
use units::{MonoTime, Now};

/// Time for a connection to be made. A link that has just come back is found by the next attempt, so they are
/// short; every fifth is patient, for links on which a handshake takes seconds.
const ATTEMPT: Duration = Duration::from_millis(1500);
const PATIENT_ATTEMPT: Duration = Duration::from_secs(4);
/// While something waits for its answer, the program looks at least this often: so it notices its own stalls.
const LOOKS_EVERY: Duration = Duration::from_millis(200);
/// A step that comes this much late: the program was stalled.
const AWAY: Duration = Duration::from_millis(100);

/// The vessel's end of the link. The backlog stays in the spool; what is held here is bounded: the live lane's
/// values and the identities of the last commands.
#[derive(Debug)]
pub struct Vessel {
    pub(super) settings: VesselSettings,
    pub(super) outputs: VecDeque<VesselOutput>,
    /// One at least.
    pub(super) ways: Vec<Way>,
    /// Connections, over all ways.
    attempt: u64,
    /// The shore accepts parallel connections, as far as known.
    pub(super) joint: bool,
    /// While it does not: the way whose turn it is.
    pub(super) turn: usize,
    /// The metered way that was left to go back to an unmetered one, until the shore has answered there.
    pub(super) left: Option<usize>,
    /// Which way carries what. The places hold good while nothing has broken since the last step.
    pub(super) report: WaysReport,
    pub(super) next_report: MonoTime,
    pub(super) told_states: Vec<WayState>,
    pub(super) growth: LagTracker,
    pub(super) live: LiveSet,
    pub(super) live_number: u64,
    /// The last look, and when the next was to be; nothing before the first that was agreed.
    looked: MonoTime,
    next_look: Option<MonoTime>,
    pub(super) pull: Pull,
    pub(super) seen: Seen,
    /// The shore's start, and the greatest numbers of a command and of a lease received from it.
    pub(super) run: Option<u64>,
    /// Starts of the shore that another followed, the last few.
    pub(super) past_runs: VecDeque<u64>,
    pub(super) newest_command: u64,
    pub(super) newest_lease: u64,
    /// The last number that the shore called durable.
    pub(super) durable: u64,
    pub(super) connections: u64,
    sent_bytes: u64,
    pub(super) arriving: Latency,
    pub(super) keeping: Latency,
}

/// Why a connection is given up: for the other side, and for the log.
pub(super) struct End {
    pub(super) code: Option<ByeCode>,
    pub(super) reason: String,
    pub(super) refused: bool,
}

impl End {
    pub(super) fn protocol(reason: impl std::fmt::Display) -> Self {
        Self { code: Some(ByeCode::Protocol), reason: reason.to_string(), refused: true }
    }

    pub(super) fn ending(reason: impl std::fmt::Display) -> Self {
        Self { code: Some(ByeCode::Ending), reason: reason.to_string(), refused: false }
    }

    pub(super) fn silent(reason: impl std::fmt::Display) -> Self {
        Self { code: None, reason: reason.to_string(), refused: false }
    }
}

impl Vessel {
    /// A vessel that connects at once.
    pub fn new(now: Now, mut settings: VesselSettings) -> Self {
        settings.ways.truncate(MOST_WAYS);
        if settings.ways.is_empty() {
            settings.ways.push(WaySettings::default());
        }
        // Not the same chance on each way, and on the first what it was without others.
        let seed = |place: usize| settings.seed ^ (place as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let ways = settings.ways.iter().enumerate();
        let ways = ways.map(|(place, way)| Way::new(now.mono, seed(place), way.clone())).collect();
        Self {
            outputs: VecDeque::new(),
            ways,
            attempt: 0,
            joint: false,
            turn: 0,
            left: None,
            report: WaysReport::default(),
            next_report: now.mono,
            told_states: Vec::new(),
            growth: LagTracker::new(now, settings.spool),
            live: LiveSet::default(),
            live_number: 0,
            looked: now.mono,
            next_look: None,
            pull: Pull::new(now.mono),
            seen: Seen::default(),
            run: None,
            past_runs: VecDeque::new(),
            newest_command: 0,
            newest_lease: 0,
            durable: settings.spool.first,
            connections: 0,
            sent_bytes: 0,
            arriving: Latency::default(),
            keeping: Latency::default(),
            settings,
        }
    }

    /// Takes an input.
    pub fn handle(&mut self, now: Now, input: VesselInput) {
        match input {
            VesselInput::Spool(spool) => self.spool(now, spool),
            VesselInput::SpoolRefused(refused) => self.growth.refuse(refused),
            VesselInput::Entries(from, entries) => self.entries(now, from, entries),
            VesselInput::Live(packet) => {
                self.live.put(now, packet);
            }
            VesselInput::Opened(id) => {
                if let Some(place) = self.current(id) {
                    self.opened(now, place);
                }
            }
            VesselInput::Failed(id, failure) => {
                if let Some(place) = self.current(id) {
                    self.pause(now, place, failure == Failure::Refused);
                }
            }
            VesselInput::Message(id, bytes) => {
                if let Some(place) = self.current(id)
                    && let Err(end) = self.message(now, place, bytes)
                {
                    self.end(now, place, end);
                }
            }
            VesselInput::Closed(id) => {
                if let Some(place) = self.current(id) {
                    self.pause(now, place, false);
                }
            }
            VesselInput::Handshake(place, bytes) => {
                if let Some(way) = self.ways.get_mut(place) {
                    way.meter.count(now, bytes);
                }
            }
            VesselInput::Timer => {}
            VesselInput::Answer(id, answer) => self.answer(now, id, answer),
            VesselInput::ChartAboard(aboard) => {
                let want = self.pull.aboard(aboard);
                self.want(now, want);
            }
            VesselInput::ChartGoOn(digest, have) => self.pull.go_on(now.mono, &digest, have),
            VesselInput::ChartKept(digest) => self.pull.kept(&digest),
            VesselInput::ChartFailed(digest, text) => self.pull.failed(now.mono, &digest, text),
            VesselInput::Shutdown => {
                self.end_all(now, |_| true, || End::ending("the program ends"));
                for way in &mut self.ways {
                    way.phase = Phase::Ended;
                }
            }
        }
        self.step(now);
    }

    /// The next output.
    pub fn poll_output(&mut self) -> Option<VesselOutput> {
        self.outputs.pop_front()
    }

    /// When to come back with [`VesselInput::Timer`] at the latest; `None` for never.
    pub fn poll_timeout(&mut self, now: Now) -> Option<MonoTime> {
        let due = (0..self.ways.len()).filter_map(|place| self.way_timeout(now, place)).min();
        let look = self.ways.iter().any(Way::waits_for_answer).then_some(self.looked + LOOKS_EVERY);
        self.next_look = [due, look].into_iter().flatten().min();
        self.next_look
    }

    /// Notes a stall of the program: messages that came meanwhile have not been read yet.
    fn notice_absence(&mut self, now: Now) {
        let waits = self.ways.iter().any(Way::waits_for_answer);
        let look = self.looked + LOOKS_EVERY;
        let due = self.next_look.map(|due| if waits { due.min(look) } else { due }.max(self.looked));
        if due.is_some_and(|due| now.mono.since(due) > AWAY) {
            self.ways.iter_mut().for_each(|way| way.excuse(now.mono));
        }
        self.looked = now.mono;
    }

    fn way_timeout(&mut self, now: Now, place: usize) -> Option<MonoTime> {
        let opens_at = self.opens_at(place);
        let several = self.ways.len() > 1;
        let lanes = self.lanes(place);
        let way = &mut self.ways[place];
        let dead = way.open().map(|open| way.dead_at(open));
        let suspect = way.suspect_at().filter(|at| several && *at > now.mono);
        let proven = way.proven_at().filter(|at| several && *at > now.mono);
        let open = match &mut way.phase {
            Phase::Pausing(_) => return opens_at,
            Phase::Opening | Phase::Ended => return None,
            Phase::Open(open) => open,
        };
        let Open { greeting_until, clocks, pace, up, .. } = &mut **open;
        let Some(up) = up else { return dead.map(|dead| dead.min(*greeting_until)) };
        let (spool, growth, live) = (self.settings.spool, &self.growth, &mut self.live);
        let mut step = Step { lanes, live_number: None, now, spool, pace, clocks, growth, live };
        let due = up.poll_timeout(&mut step);
        let chart = self.pull.poll_timeout().filter(|_| lanes.records);
        let report = (self.joint && lanes.live).then_some(self.next_report);
        [dead, suspect, proven, chart, report].into_iter().flatten().chain([due]).min()
    }

    /// How the link is. Latencies start over.
    pub fn status(&mut self, now: Now) -> VesselStatus {
        let cursor = self.records_at();
        let live = self.report.live.and_then(|place| self.ways.get(usize::from(place)));
        let clocks = live.and_then(Way::open).and_then(|open| open.clocks.estimate(now));
        VesselStatus {
            up: self.ways.iter().any(Way::stands),
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

    /// The bytes that each way has carried today, in their order.
    pub fn used(&self) -> Vec<Used> {
        self.ways.iter().map(|way| way.meter.used()).collect()
    }

    /// The place of the way whose connection this is.
    fn current(&self, id: ConnectionId) -> Option<usize> {
        self.ways.iter().position(|way| way.id() == id && way.is_active())
    }

    fn spool(&mut self, now: Now, spool: super::SpoolState) {
        let renumbered = spool.stream != self.settings.spool.stream;
        self.settings.spool = spool;
        if renumbered {
            self.growth = LagTracker::new(now, spool);
            self.durable = spool.first;
            self.end_all(now, |_| true, || End::ending("the spool began another stream"));
        }
    }

    fn opened(&mut self, now: Now, place: usize) {
        if !self.joint {
            // It would be replaced by the greeting, and then count as refused.
            self.left = self.ways.iter().position(Way::stands).filter(|stood| *stood != place);
            if let Some(stood) = self.left {
                self.ways[stood].leave(now.mono);
            }
            // Before the one that stood ends: what is left for this one is no fault of that.
            self.turn = place;
            let why = || End::silent("an unmetered way is there again");
            self.end_all(now, |other| other != place, why);
        }
        let clocks = Clocks::default();
        let several = self.ways.len() > 1;
        let way = &self.ways[place];
        let hello = Hello {
            version: VERSION,
            oldest_version: OLDEST_VERSION,
            capabilities: if several { Capabilities::ALL } else { Capabilities::OF_ONE_WAY },
            address: self.settings.address,
            incarnation: self.settings.incarnation,
            attempt: way.attempt,
            stream: self.settings.spool.stream,
            first: self.settings.spool.first,
            next: self.settings.spool.next,
            stamp: clocks.stamp(now),
            name: self.settings.name.clone(),
            software: self.settings.software.clone(),
            way: several.then(|| WayHello {
                index: place as u8,
                metered: way.settings.metered,
                name: way.settings.name.clone(),
            }),
        };
        let pace = Pace::new(now.mono, self.settings.budget_bytes_per_s);
        self.ways[place].phase = Phase::Open(Box::new(Open::new(now.mono, GREETING_WITHIN, clocks, pace)));
        self.send(now, place, message(&Frame::Hello(hello)));
    }

    pub(super) fn send(&mut self, now: Now, place: usize, message: Bytes) {
        let way = &mut self.ways[place];
        let Some(open) = way.open_mut() else { return };
        open.pace.sent(now.mono, message.len());
        way.meter.count(now, message.len());
        self.sent_bytes += message.len() as u64;
        self.outputs.push_back(VesselOutput::Send(way.id(), message));
    }

    fn pause(&mut self, now: Now, place: usize, refused: bool) {
        if self.report.records == Some(place as u8) {
            self.pull.unlinked(now.mono);
        }
        let left = if self.turn == place { self.left.take() } else { None };
        let way = &mut self.ways[place];
        if left.is_some() {
            way.gone_back_to_in_vain();
        }
        way.lost(now.mono);
        let pause = if refused { way.backoff.refused() } else { way.backoff.unanswered() };
        way.phase = Phase::Pausing(now.mono + pause);
        if self.turn == place {
            self.turn = left.unwrap_or((place + 1) % self.ways.len());
        }
    }

    /// Closes the connection of a way.
    pub(super) fn end(&mut self, now: Now, place: usize, end: End) {
        if !self.ways[place].is_active() {
            return;
        }
        if let Some(code) = end.code {
            self.send(now, place, message(&Frame::Bye(Bye { code, text: end.reason.clone() })));
        }
        self.outputs.push_back(VesselOutput::Close(self.ways[place].id(), end.reason));
        self.pause(now, place, end.refused);
    }

    pub(super) fn end_all(&mut self, now: Now, which: impl Fn(usize) -> bool, why: impl Fn() -> End) {
        for place in (0..self.ways.len()).filter(|place| which(*place)) {
            self.end(now, place, why());
        }
    }

    /// When a way that pauses may connect. A shore that keeps one connection at a time gets the next when the last has
    /// ended; beside an open metered one, an unmetered way is tried now and then.
    fn opens_at(&self, place: usize) -> Option<MonoTime> {
        let way = &self.ways[place];
        let Phase::Pausing(until) = way.phase else { return None };
        if self.joint || (self.turn == place && !self.ways.iter().any(Way::is_active)) {
            return Some(until);
        }
        let costs = self.ways.iter().any(|other| other.stands() && other.settings.metered);
        (costs && !way.settings.metered).then_some(until.max(way.return_at))
    }

    fn step(&mut self, now: Now) {
        self.notice_absence(now);
        self.growth.mark(now.mono, self.settings.spool.next);
        for way in &mut self.ways {
            way.meter.turn(now);
        }
        for place in 0..self.ways.len() {
            self.look(now, place);
        }
        self.assign(now);
        // A way that was ended by now may give its turn to one before it.
        for _ in 0..2 {
            for place in 0..self.ways.len() {
                self.open(now, place);
            }
        }
        for place in 0..self.ways.len() {
            self.carry(now, place);
        }
        self.tell_ways(now);
    }

    fn open(&mut self, now: Now, place: usize) {
        if self.opens_at(place).is_some_and(|at| now.mono >= at) {
            self.attempt += 1;
            let way = &mut self.ways[place];
            (way.attempt, way.phase) = (self.attempt, Phase::Opening);
            let patience = if self.attempt.is_multiple_of(5) { PATIENT_ATTEMPT } else { ATTEMPT };
            self.outputs.push_back(VesselOutput::Open(ConnectionId(self.attempt), place, patience));
        }
    }

    /// Closes a connection that is silent for too long, and notes one that does not answer in time.
    fn look(&mut self, now: Now, place: usize) {
        let several = self.ways.len() > 1;
        let way = &mut self.ways[place];
        let Some(open) = way.open() else { return };
        if now.mono >= way.dead_at(open) {
            let silent = now.mono.since(open.heard).as_secs();
            return self.end(now, place, End::silent(format_args!("nothing heard for {silent} s")));
        }
        if open.up.is_none() && now.mono >= open.greeting_until {
            return self.end(now, place, End::silent("the greeting was not answered"));
        }
        if several && way.look(now.mono) && !self.joint {
            way.backoff.succeeded();
            self.end(now, place, End::silent("it does not answer in time, the next way is tried"));
        }
    }

    /// Sends what is due over an open connection.
    fn carry(&mut self, now: Now, place: usize) {
        let lanes = self.lanes(place);
        let several = self.ways.len() > 1;
        let Some(Open { clocks, pace, up: Some(up), .. }) = self.ways[place].open_mut() else { return };
        let (spool, growth, live) = (self.settings.spool, &self.growth, &mut self.live);
        let live_number = (several && self.joint).then_some(&mut self.live_number);
        let mut step = Step { lanes, live_number, now, spool, pace, clocks, growth, live };
        let (messages, need) = up.step(&mut step);
        for message in messages {
            self.send(now, place, message);
        }
        self.outputs.extend(need.map(|(from, bytes)| VesselOutput::Need(from, bytes)));
        if lanes.records {
            // Last: nothing of the vessel's own waits for it.
            let wants = self.pull.step(now.mono);
            self.want(now, wants);
        }
    }

    /// Carries out the chart's outputs, by the way of the records.
    pub(super) fn want(&mut self, now: Now, wants: impl IntoIterator<Item = Want>) {
        for want in wants {
            match (want, self.report.records) {
                (Want::Send(frame), Some(place)) => self.send(now, usize::from(place), message(&frame)),
                (Want::Send(_), None) => {}
                (Want::Begin(offer), _) => self.outputs.push_back(VesselOutput::ChartBegin(offer)),
            }
        }
    }

    fn entries(&mut self, now: Now, from: u64, entries: Vec<Entry>) {
        let Some(place) = self.report.records.map(usize::from) else { return };
        let lanes = self.lanes(place);
        let Some(Open { clocks, pace, up: Some(up), .. }) = self.ways[place].open_mut() else { return };
        let (spool, growth, live) = (self.settings.spool, &self.growth, &mut self.live);
        let step = Step { lanes, live_number: None, now, spool, pace, clocks, growth, live };
        let messages = up.entries(&step, from, entries);
        for message in messages {
            self.send(now, place, message);
        }
    }
}
