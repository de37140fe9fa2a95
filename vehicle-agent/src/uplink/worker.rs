//! The thread that spools the vessel's packets and sends them ashore. It waits for packets, the sockets and the link's
//! deadlines at once; connecting and syncing, which can take long, have their own threads.

use super::chart::{Job, Keeper, Outcome};
use super::filter::{Disposition, RateFilter};
use super::queue::Queue;
use super::settings::UplinkSettings;
use super::socket::{Carried, Socket, connect};
use super::spool::{Spool, random};
use super::sync::Syncer;
use super::ways::{self, Ledger};
use super::{Deliver, FromShore};
use crate::clock::Clock;
use bytes::Bytes;
use link::{
    Answer, ChartAboard, ConnectionId, Failure, Receipt, Vessel, VesselInput, VesselOutput, VesselSettings,
};
use onboard::Mandate;
use rustix::event::{PollFd, PollFlags, Timespec, poll};
use std::collections::BTreeMap;
use std::os::fd::AsFd as _;
use std::os::unix::net::UnixStream;
use std::sync::Arc;
use std::sync::mpsc::{Receiver, Sender, channel};
use std::time::Duration;
use units::MonoTime;

const LONGEST_WAIT: Duration = Duration::from_secs(1);
/// Messages taken from a socket before packets are processed again.
const MESSAGES_AT_ONCE: usize = 32;
/// Most attempts of one way that may hang, mainly in name lookup.
const MOST_ATTEMPTS: usize = 3;
/// A persistent disk error is reported this often.
const TROUBLE_TOLD: Duration = Duration::from_secs(30);
const SOFTWARE: &str = concat!("lutra-agent ", env!("CARGO_PKG_VERSION"));

/// Result of an attempt to connect.
struct Attempt {
    way: usize,
    id: ConnectionId,
    carried_bytes: usize,
    outcome: Result<Socket, (Failure, String)>,
}

/// A connection of a way.
struct Connection {
    way: usize,
    socket: Socket,
}

pub(super) struct Worker {
    settings: UplinkSettings,
    clock: Clock,
    queue: Arc<Queue>,
    wake: UnixStream,
    spool: Spool,
    rate_filter: RateFilter,
    vessel: Vessel,
    deliver: Deliver,
    /// One for each way at most.
    connections: BTreeMap<ConnectionId, Connection>,
    /// The attempts that the link waits for: way, and deadline.
    opening: BTreeMap<ConnectionId, (usize, MonoTime)>,
    /// Attempts of each way that are under way.
    attempts: Vec<usize>,
    attempted: (Sender<Attempt>, Receiver<Attempt>),
    syncer: Option<Syncer>,
    /// `None` if the shore's chart is not wanted, or its thread could not be started.
    keeper: Option<Keeper>,
    /// The chart aboard, as last passed to the link.
    chart: Option<ChartAboard>,
    next_sync: MonoTime,
    /// The last reported connection error of each way.
    complaints: Vec<String>,
    ledger: Ledger,
    next_trouble: MonoTime,
    is_ending: bool,
}

impl Worker {
    pub(super) fn new(
        mut settings: UplinkSettings,
        spool: Spool,
        queue: Arc<Queue>,
        clock: Clock,
        wake: UnixStream,
        deliver: Deliver,
    ) -> Self {
        let now = clock.now();
        ways::load(&settings.spool, &mut settings.ways);
        let vessel = VesselSettings {
            address: settings.address,
            name: settings.name.clone(),
            software: SOFTWARE.to_owned(),
            incarnation: spool.starts(),
            seed: random().unwrap_or(u64::from(settings.address)),
            budget_bytes_per_s: settings.budget_bytes_per_s,
            spool: spool.state(),
            ways: settings.ways.iter().map(|door| door.way.clone()).collect(),
        };
        let syncer = Syncer::start(Arc::clone(&queue)).inspect_err(|error| {
            tracing::error!("uplink: no thread to sync the spool: {error}; it is synced when it is closed");
        });
        let keeper = settings.chart.as_deref().map(|data| Keeper::start(data, Arc::clone(&queue)));
        let keeper = keeper.transpose().inspect_err(|error| {
            tracing::error!("uplink: no thread for the shore's chart: {error}; the chart is not fetched");
        });
        Self {
            rate_filter: RateFilter::new(settings.filter.clone()),
            ledger: Ledger::new(now.mono, &settings.spool, &settings.ways),
            attempts: vec![0; vessel.ways.len()],
            complaints: vec![String::new(); vessel.ways.len()],
            vessel: Vessel::new(now, vessel),
            settings,
            clock,
            queue,
            wake,
            spool,
            deliver,
            connections: BTreeMap::new(),
            opening: BTreeMap::new(),
            attempted: channel(),
            syncer: syncer.ok(),
            keeper: keeper.ok().flatten(),
            chart: None,
            next_sync: now.mono,
            next_trouble: now.mono,
            is_ending: false,
        }
    }

    /// Works until the end of the program.
    pub(super) fn run(mut self) {
        loop {
            self.is_ending = self.take_packets();
            self.take_attempts();
            self.take_chart();
            let more = self.receive();
            self.handle(if self.is_ending { VesselInput::Shutdown } else { VesselInput::Timer });
            self.flush();
            self.sync();
            self.keep_used();
            if self.is_ending {
                if let Err(error) = self.spool.close() {
                    tracing::error!("uplink: closing the spool: {error:#}");
                }
                return;
            }
            self.wait(more);
        }
    }

    /// Spools the queued packets; returns whether the program is ending.
    fn take_packets(&mut self) -> bool {
        let waiting = self.queue.take(&mut self.wake);
        if waiting.packets.is_empty() && waiting.missed.is_none() {
            return waiting.ending;
        }
        let mut live = Vec::with_capacity(waiting.packets.len());
        for (recorded, packet) in waiting.packets {
            match self.rate_filter.disposition(recorded, &packet) {
                Disposition::Leave => continue,
                Disposition::LiveOnly => {}
                Disposition::Record(important) => self.spool.append(recorded, &packet, important),
            }
            live.push(Bytes::from(packet));
        }
        if let Some(missed) = waiting.missed {
            tracing::error!(packets = missed.count, "uplink: the queue was full; not recorded for the shore");
            self.spool.missed(missed.count, missed.since, missed.until);
        }
        let thinned = self.spool.thinned();
        let written = self.spool.write();
        if let Err(error) = &written {
            let text =
                format!("the disk does not take the spool: {error}; the shore gets the latest values only");
            if self.trouble(&text) {
                // The shore gets it by the live lane, like everything else.
                (self.deliver)(FromShore::NotSpooled(text)).ok();
            }
        }
        if self.spool.thinned() > thinned {
            self.trouble("the spool is full: the oldest telemetry gives way");
        }
        self.vessel.handle(self.clock.now(), VesselInput::SpoolRefused(written.is_err()));
        // First to disk, then live.
        for packet in live {
            self.vessel.handle(self.clock.now(), VesselInput::Live(packet));
        }
        self.handle(VesselInput::Spool(self.spool.state()));
        waiting.ending
    }

    /// Reports a disk error, at limited rate; returns whether it did.
    fn trouble(&mut self, text: &str) -> bool {
        let now = self.clock.now().mono;
        let due = now >= self.next_trouble;
        if due {
            self.next_trouble = now + TROUBLE_TOLD;
            tracing::error!("uplink: {text}");
        }
        due
    }

    fn take_attempts(&mut self) {
        while let Ok(Attempt { way, id, carried_bytes, outcome }) = self.attempted.1.try_recv() {
            self.attempts[way] -= 1;
            self.handle(VesselInput::Handshake(way, carried_bytes));
            // A connection that the link no longer waits for is closed by dropping it.
            if self.opening.remove(&id).is_none() {
                continue;
            }
            match outcome {
                Ok(socket) => {
                    self.connections.insert(id, Connection { way, socket });
                    self.handle(VesselInput::Opened(id));
                }
                Err((failure, text)) => {
                    self.complain(way, text);
                    self.handle(VesselInput::Failed(id, failure));
                }
            }
        }
        let now = self.clock.now().mono;
        let late = self.opening.iter().filter(|(_, (_, until))| now >= *until);
        for (id, way) in late.map(|(id, (way, _))| (*id, *way)).collect::<Vec<_>>() {
            self.opening.remove(&id);
            self.complain(way, format!("{} does not answer", self.settings.ways[way].server.url));
            self.handle(VesselInput::Failed(id, Failure::Unanswered));
        }
    }

    /// Reports why there is no connection by a way, once for each reason.
    fn complain(&mut self, way: usize, text: String) {
        if text != self.complaints[way] {
            match self.settings.ways[way].way.name.as_str() {
                "" => tracing::warn!("uplink: {text}"),
                name => tracing::warn!(way = name, "uplink: {text}"),
            }
            self.complaints[way] = text;
        }
    }

    /// Processes messages; returns whether more may be buffered in this process, which poll does not show.
    fn receive(&mut self) -> bool {
        let ids: Vec<ConnectionId> = self.connections.keys().copied().collect();
        let mut more = false;
        for id in ids {
            more |= self.receive_by(id);
        }
        more
    }

    fn receive_by(&mut self, id: ConnectionId) -> bool {
        for _ in 0..MESSAGES_AT_ONCE {
            let Some(connection) = self.connections.get_mut(&id) else { return false };
            match connection.socket.receive() {
                Ok(None) => return false,
                Ok(Some(message)) => self.handle(VesselInput::Message(id, message)),
                Err(error) => {
                    self.broken(id, error);
                    return false;
                }
            }
        }
        true
    }

    fn flush(&mut self) {
        let flushed = self.connections.iter_mut().map(|(id, one)| (*id, one.socket.flush()));
        let broken = flushed.filter_map(|(id, outcome)| outcome.err().map(|error| (id, error)));
        for (id, error) in broken.collect::<Vec<_>>() {
            self.broken(id, error);
        }
    }

    fn broken(&mut self, id: ConnectionId, error: String) {
        if let Some(connection) = self.connections.remove(&id) {
            self.complain(connection.way, error);
        }
        self.handle(VesselInput::Closed(id));
    }

    /// Passes an input to the link and carries out its outputs.
    fn handle(&mut self, input: VesselInput) {
        self.vessel.handle(self.clock.now(), input);
        while let Some(output) = self.vessel.poll_output() {
            self.carry_out(output);
        }
    }

    fn carry_out(&mut self, output: VesselOutput) {
        let tell = |worker: &mut Self, input| {
            let now = worker.clock.now();
            worker.vessel.handle(now, input);
        };
        match output {
            VesselOutput::Open(id, way, patience) => self.attempt(id, way, patience),
            VesselOutput::Send(id, message) => {
                let Some(connection) = self.connections.get_mut(&id) else { return };
                let way = connection.way;
                if let Err(error) = connection.socket.send(message) {
                    self.connections.remove(&id);
                    self.complain(way, error);
                    tell(self, VesselInput::Closed(id));
                }
            }
            VesselOutput::Close(id, reason) => {
                let given_up = self.opening.remove(&id).map(|(way, _)| way);
                let closed = self.connections.remove(&id).map(|mut connection| {
                    // Sends the last message, if the kernel accepts it at once.
                    connection.socket.flush().ok();
                    connection.way
                });
                if let Some(way) = closed.or(given_up).filter(|_| !self.is_ending) {
                    self.complain(way, reason);
                }
            }
            VesselOutput::Need(from, bytes) => {
                let entries = self.spool.read(from, bytes);
                tell(self, VesselInput::Entries(from, entries));
            }
            VesselOutput::Acknowledged(next) => {
                self.spool.acknowledged(next);
                let state = self.spool.state();
                tell(self, VesselInput::Spool(state));
            }
            VesselOutput::Renumber => self.renumber(),
            VesselOutput::Lease(lease) => {
                let lasts = Duration::from_millis(lease.ttl_ms.into());
                let lease = onboard::Lease { epoch: lease.epoch, lasts, holder: lease.holder };
                if let Err(error) = (self.deliver)(FromShore::Lease(lease)) {
                    self.trouble(&format!("who commands was not reported aboard: {error}"));
                }
            }
            VesselOutput::Command { id, lease, order, packet, expires } => {
                let answer = if self.clock.now().mono >= expires {
                    Answer::Expired
                } else {
                    let mandate = Mandate { lease, command: order };
                    let order = FromShore::Order { mandate, packet: &packet };
                    (self.deliver)(order).map_or_else(Answer::Refused, |()| Answer::Received)
                };
                tell(self, VesselInput::Answer(id, answer));
            }
            VesselOutput::Came { id, order, way, again } => {
                let way = &self.settings.ways[way].way.name;
                tracing::info!(command = order, link = id, way, again, "uplink: a command came");
            }
            VesselOutput::Answered(Receipt { id, verdict, text, order }) => {
                tracing::info!(
                    command = order,
                    link = id,
                    outcome = verdict.name(),
                    text,
                    "uplink: a command is answered"
                );
            }
            VesselOutput::ChartBegin(offer) => {
                tracing::info!(bytes = offer.bytes, "uplink: the shore has another chart: {}", offer.edition);
                self.keep_chart(Job::Begin(offer));
            }
            VesselOutput::ChartPart { digest, offset, bytes } => {
                self.keep_chart(Job::Part(digest, offset, bytes));
            }
            VesselOutput::Up(id) => self.is_up(id),
            VesselOutput::Switched(report) => {
                let name =
                    |place: Option<u8>| place.and_then(|place| self.settings.ways.get(usize::from(place)));
                let name = |place| name(place).map_or("none", |door| &door.way.name);
                tracing::info!(
                    live = name(report.live),
                    live_why = report.live_why.name(),
                    records = name(report.records),
                    records_why = report.records_why.name(),
                    "uplink: ways"
                );
            }
        }
    }

    fn is_up(&mut self, id: ConnectionId) {
        let Some(way) = self.connections.get(&id).map(|connection| connection.way) else { return };
        self.complaints[way].clear();
        let now = self.clock.now();
        let backlog = self.vessel.status(now).backlog;
        tracing::info!(backlog, "uplink: connected to {}", self.settings.ways[way].called());
    }

    fn keep_used(&mut self) {
        let now = self.clock.now().mono;
        if let Err(error) = self.ledger.keep(now, self.vessel.used(), self.is_ending) {
            self.trouble(&format!("what the ways have carried today cannot be kept: {error}"));
        }
    }

    /// Passes the chart aboard, and the progress of its transfer, to the link.
    fn take_chart(&mut self) {
        let aboard = self.queue.chart();
        let aboard = ChartAboard { takes: aboard.takes && self.keeper.is_some(), ..aboard };
        if self.chart.as_ref() != Some(&aboard) {
            self.chart = Some(aboard.clone());
            self.handle(VesselInput::ChartAboard(aboard));
        }
        while let Some((digest, outcome)) = self.keeper.as_ref().and_then(Keeper::outcome) {
            let input = match outcome {
                Outcome::GoOn(have) => VesselInput::ChartGoOn(digest, have),
                Outcome::Failed(why) => {
                    tracing::error!("uplink: the shore's chart is not taken: {why}");
                    VesselInput::ChartFailed(digest, why)
                }
                Outcome::Kept(chart) => {
                    tracing::info!("uplink: the shore's chart is aboard: {}", chart.edition());
                    match (self.deliver)(FromShore::Chart(chart)) {
                        Ok(()) => VesselInput::ChartKept(digest),
                        Err(why) => VesselInput::ChartFailed(digest, why),
                    }
                }
            };
            self.handle(input);
        }
    }

    fn renumber(&mut self) {
        tracing::error!("uplink: the shore has more than the spool ever knew; another stream begins");
        if let Err(error) = self.spool.renumber() {
            self.trouble(&format!("{error:#}"));
        }
        self.vessel.handle(self.clock.now(), VesselInput::Spool(self.spool.state()));
    }

    fn keep_chart(&mut self, job: Job) {
        let digest = job.digest();
        if self.keeper.as_ref().is_none_or(|keeper| !keeper.hand(job)) {
            let why = "too much waits for the vessel's disk".to_owned();
            self.vessel.handle(self.clock.now(), VesselInput::ChartFailed(digest, why));
        }
    }

    fn attempt(&mut self, id: ConnectionId, way: usize, patience: Duration) {
        let now = self.clock.now().mono;
        self.opening.insert(id, (way, now + patience * 2));
        if self.attempts[way] >= MOST_ATTEMPTS {
            return;
        }
        let door = self.settings.ways[way].clone();
        let (done, queue) = (self.attempted.0.clone(), Arc::clone(&self.queue));
        let work = move || {
            let carried = Carried::default();
            let outcome = connect(&door, patience, &carried);
            done.send(Attempt { way, id, carried_bytes: carried.bytes(), outcome }).ok();
            queue.ring();
        };
        match std::thread::Builder::new().name("uplink-connect".to_owned()).spawn(work) {
            Ok(_) => self.attempts[way] += 1,
            Err(error) => self.complain(way, format!("no thread to connect with: {error}")),
        }
    }

    fn sync(&mut self) {
        let now = self.clock.now().mono;
        let Some(syncer) = &mut self.syncer else { return };
        match syncer.outcome() {
            Some(Ok(next)) => self.spool.synced(next),
            Some(Err(error)) => {
                self.trouble(&format!("the spool cannot be synced: {error}"));
            }
            None => {}
        }
        let Some(syncer) = self.syncer.as_mut().filter(|syncer| !syncer.is_busy()) else { return };
        if now >= self.next_sync
            && let Some(job) = self.spool.unsynced()
        {
            self.next_sync = now + self.settings.sync_every;
            syncer.start_job(job);
        }
    }

    /// Waits until there is something to do; with `more` it only polls.
    fn wait(&mut self, more: bool) {
        let now = self.clock.now();
        let mut due = if more { now.mono } else { now.mono + LONGEST_WAIT };
        if let Some(at) = self.vessel.poll_timeout(now) {
            due = due.min(at);
        }
        due = self.opening.values().map(|(_, until)| *until).fold(due, MonoTime::min);
        if self.spool.is_unsynced() && self.syncer.as_ref().is_some_and(|syncer| !syncer.is_busy()) {
            due = due.min(self.next_sync);
        }
        let wait = due.since(now.mono);
        let timeout = Timespec { tv_sec: wait.as_secs() as i64, tv_nsec: wait.subsec_nanos().into() };
        let mut fds = vec![PollFd::from_borrowed_fd(self.wake.as_fd(), PollFlags::IN)];
        for Connection { socket, .. } in self.connections.values() {
            let write = if socket.wants_to_write { PollFlags::OUT } else { PollFlags::empty() };
            fds.push(PollFd::from_borrowed_fd(socket.fd(), PollFlags::IN | write));
        }
        // Interrupted or not: everything is checked next.
        poll(&mut fds, Some(&timeout)).ok();
    }
}
