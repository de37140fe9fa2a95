//! One vessel's link: the session that joins its connections, the hub and the recorder.

use super::figures::Figures;
use super::named::Named;
use super::orders::LinkOrders;
use super::{Event, Out};
use crate::charts::{ChartPackage, ChartsAboard};
use crate::recorder::Recorder;
use crate::router::{Connection, Router, Whose};
use api::Said;
use bytes::Bytes;
use hub::{Delivery, Incoming, Lane, LinkSeq, Peer, Role, Sources, TIME_TO_LIVE, Tag, Transport, Urgency};
use imc::messages::{self as m, Payload as _};
use imc::{Address, PacketView};
use link::{
    ByeCode, ChartRequest, Commander, ConnectionId, Gap, GapReason, Hello, Outcome, Record, Shore,
    ShoreInput, ShoreOutput, ShoreSettings, ShoreStatus, WaysReport,
};
use operations::{Operations, Receipt};
use std::collections::BTreeMap;
use std::sync::Arc;
use std::sync::atomic::AtomicU64;
use std::time::Duration;
use store::GapKind;
use tokio::sync::{mpsc, watch};
use tokio_util::sync::CancellationToken;
use units::{Now, UtcTime};

/// Bytes that may wait for the session: commands are few.
const OUTBOX_BYTES: usize = 256 * 1024;
/// A record that is older than this on arrival belongs to the past: the live lane shows the present.
const PRESENT: Duration = Duration::from_secs(5);
/// How often the link's figures are published.
const FIGURES: Duration = Duration::from_secs(1);
/// Its latency is recorded once in so many times.
const RECORD_EVERY: u32 = 10;

/// An answer from the disk.
pub(crate) enum Answer {
    /// The last durable number of the stream that said hello on this connection.
    Durable(ConnectionId, u64, Option<u64>),
    /// A gap of a stream is kept: its first number and the one after its last.
    Kept(u64, u64, u64),
    /// A part of the chart was read.
    Part(ConnectionId, ChartRequest, Option<Bytes>),
}

/// Owns a vessel's session.
pub(crate) struct Task {
    pub(super) vessel: Address,
    router: Router,
    recorder: Recorder,
    shore: Shore,
    connections: BTreeMap<ConnectionId, mpsc::Sender<Out>>,
    /// The chart that vessels are offered, and their reports about theirs.
    pub(super) chart: watch::Receiver<Option<Arc<ChartPackage>>>,
    pub(super) aboard: ChartsAboard,
    /// Answers from the disk.
    pub(super) answers: (mpsc::Sender<Answer>, mpsc::Receiver<Answer>),
    stream: Option<u64>,
    /// Highest durable number of the stream, as the store reported.
    durable: Option<u64>,
    /// Declared gaps of the stream that are kept: the first missing number and the one after the last.
    gaps: BTreeMap<u64, u64>,
    /// The controller that the session was last told.
    control: Option<Commander>,
    orders: LinkOrders,
    figures: Figures,
    status: watch::Sender<ShoreStatus>,
    /// The vessel's last report about its ways; `None` if it has only one.
    pub(super) ways: watch::Sender<Option<WaysReport>>,
    pub(super) named: Named,
    /// The connection that said hello last belongs to a vessel with several ways.
    has_ways: bool,
    /// How often the figures were published.
    told: u32,
}

impl Task {
    pub(crate) fn new(
        vessel: Address,
        router: Router,
        recorder: Recorder,
        (chart, aboard): (watch::Receiver<Option<Arc<ChartPackage>>>, ChartsAboard),
        (status, ways): (watch::Sender<ShoreStatus>, watch::Sender<Option<WaysReport>>),
        late: Arc<AtomicU64>,
        index: usize,
    ) -> Self {
        let figures = Figures::new(router.address(), vessel, index);
        // Commands are numbered from a random number at each start, so that no start repeats another's numbers, whatever
        // the clock says.
        let somewhere = getrandom::u64().unwrap_or_else(|_| router.clock().now().utc.micros().unsigned_abs());
        let run = somewhere >> 1;
        Self {
            vessel,
            router,
            recorder,
            shore: Shore::new(ShoreSettings { run, ..ShoreSettings::default() }),
            connections: BTreeMap::new(),
            chart,
            aboard,
            answers: mpsc::channel(16),
            stream: None,
            durable: None,
            gaps: BTreeMap::new(),
            control: None,
            orders: LinkOrders::new(vessel, run, late),
            figures,
            status,
            ways,
            named: Named::default(),
            has_ways: false,
            told: 0,
        }
    }

    pub(crate) async fn run(mut self, mut events: mpsc::Receiver<Event>, stop: CancellationToken) {
        let name = format!("link of {}", self.vessel);
        let sources = Sources::Only(vec![self.vessel]);
        let peer = Peer { transport: Transport::Link, role: Role::Vessel, name, sources };
        let Ok(hub) = self.router.join(peer, OUTBOX_BYTES).await else { return };
        let mut durable = self.recorder.durable();
        let mut figures = tokio::time::interval(FIGURES);
        let mut control = self.router.control();
        self.tell_control();
        let mut chart = self.chart.clone();
        self.offer_chart();
        loop {
            let due = self.shore.poll_timeout(self.now());
            tokio::select! {
                () = stop.cancelled() => break,
                event = events.recv() => match event {
                    Some(event) => self.event(event),
                    None => break,
                },
                packets = hub.outbox.take() => {
                    if let Ok(packets) = packets {
                        for packet in packets {
                            self.hand_down(packet);
                        }
                    } else {
                        tracing::warn!(vessel = %self.vessel, "too many commands at once: some are lost");
                        hub.outbox.reopen();
                    }
                }
                Some(answer) = self.answers.1.recv() => self.answered(answer),
                changed = durable.changed() => {
                    if changed.is_err() {
                        break;
                    }
                    let seq = self.stream.and_then(|stream| durable.borrow_and_update().get(&stream).copied());
                    self.durable = seq.or(self.durable);
                    self.acknowledge();
                }
                () = until(&self.router, due) => self.handle(ShoreInput::Timer),
                changed = control.changed() => {
                    if changed.is_err() {
                        break;
                    }
                    self.tell_control();
                }
                Ok(()) = chart.changed() => self.offer_chart(),
                _ = figures.tick() => self.figures().await,
            }
            if self.carry_out(&hub).await.is_err() {
                break;
            }
        }
        self.handle(ShoreInput::Shutdown);
        self.carry_out(&hub).await.ok();
        hub.leave().await;
    }

    pub(super) fn now(&self) -> Now {
        self.router.clock().now()
    }

    pub(crate) fn handle(&mut self, input: ShoreInput) {
        let now = self.now();
        self.shore.handle(now, input);
    }

    fn event(&mut self, event: Event) {
        match event {
            Event::Opened(id, sender) => {
                self.connections.insert(id, sender);
                self.handle(ShoreInput::Opened(id));
            }
            Event::Message(id, bytes) => self.handle(ShoreInput::Message(id, bytes)),
            Event::Closed(id) => {
                self.connections.remove(&id);
                self.handle(ShoreInput::Closed(id));
            }
        }
    }

    /// Sends the vessel its controller, if that has changed.
    fn tell_control(&mut self) {
        let now = self.router.control().borrow().get(&self.vessel).cloned();
        if let Some(commander) = now.filter(|now| self.control.as_ref() != Some(now)) {
            self.control = Some(commander.clone());
            self.handle(ShoreInput::Lease(commander));
        }
    }

    /// A packet for the vessel: an order, or a message of another system.
    fn hand_down(&mut self, Delivery { packet, tag }: Delivery) {
        let (id, order) = self.orders.given(tag.as_ref());
        let (mut ttl, mut lease, mut overtakes) = (time_to_live(&packet), 0, false);
        if let Some(Tag { epoch, expires, urgency, .. }) = tag {
            (ttl, lease, overtakes) = (expires.since(self.now().mono), epoch, urgency == Urgency::Stop);
            // The vessel must know the lease before an order under it.
            self.tell_control();
        }
        self.handle(ShoreInput::Command { id, ttl, lease, order, overtakes, packet });
    }

    /// Tells the hub whether the link is up: orders then take the link, or other transports.
    async fn tell_stands(&self, hub: &Connection, stands: bool) -> Result<(), crate::router::Stopped> {
        let peer = hub.id;
        let tell =
            move |operations: &mut Operations, now| operations.hub_mut().link_stands(now, peer, stands);
        self.router.ask(tell).await
    }

    /// Carries out the session's actions.
    async fn carry_out(&mut self, hub: &Connection) -> Result<(), crate::router::Stopped> {
        while let Some(output) = self.shore.poll_output() {
            match output {
                ShoreOutput::Send(id, bytes) => self.tell(id, Out::Message(bytes)),
                ShoreOutput::Close(id, code, reason) => {
                    if code != ByeCode::Replaced {
                        tracing::info!(vessel = %self.vessel, ?code, %reason, "a link connection is closed");
                        let whose = Whose::Vessel(self.vessel);
                        self.router.ledger().failed(Transport::Link, whose, Said::as_is(reason.clone()));
                    }
                    self.tell(id, Out::Close(reason));
                    self.connections.remove(&id);
                }
                ShoreOutput::Hello(id, hello) => self.greeted(id, &hello),
                ShoreOutput::Up(_) if self.shore.standing() > 1 => {
                    tracing::info!(vessel = %self.vessel, "the link stands by one more way");
                    self.tell_status();
                }
                ShoreOutput::Up(_) => {
                    tracing::info!(vessel = %self.vessel, "the link stands");
                    if !self.has_ways {
                        self.one_way();
                    }
                    self.router.ledger().link_changed(self.vessel);
                    self.tell_status();
                    self.tell_stands(hub, true).await?;
                }
                ShoreOutput::Down => {
                    tracing::warn!(vessel = %self.vessel, "the link is down");
                    self.ways_down();
                    self.router.ledger().link_changed(self.vessel);
                    self.tell_status();
                    self.tell_stands(hub, false).await?;
                }
                ShoreOutput::Records { stream, records } => {
                    let now = self.now();
                    let ahead_us = self.vessel_ahead_us();
                    let batch = records.into_iter().map(|record| incoming(stream, record, now.utc, ahead_us));
                    hub.give(batch.collect()).await?;
                }
                ShoreOutput::Gap { stream, gap } => self.gap(stream, gap),
                ShoreOutput::Live(records) => {
                    let live =
                        |record: Record| Incoming { packet: record.packet, link: None, lane: Lane::Live };
                    hub.give(records.into_iter().map(live).collect()).await?;
                }
                ShoreOutput::ChartPart(id, ask) => self.read_chart(id, ask),
                ShoreOutput::ChartReport(report) => self.chart_aboard(report),
                ShoreOutput::Ways(report) => self.ways_told(report),
                ShoreOutput::Sent { id, order, over, times } => {
                    // A connection whose channel was full is gone by now.
                    let is_taken = self.connections.contains_key(&over);
                    self.orders.sent((id, order), (over, is_taken), times);
                }
                ShoreOutput::Stray(receipt) => self.orders.stray(&receipt),
                ShoreOutput::Outcome(id, outcome) => {
                    if let Some(command) = self.orders.outcome(id, &outcome) {
                        let receipt = receipt(outcome);
                        let tell = move |operations: &mut Operations, now| {
                            operations.commands_mut().receipt(now, command, receipt);
                        };
                        self.router.ask(tell).await?;
                    }
                }
            }
        }
        Ok(())
    }

    fn tell(&mut self, id: ConnectionId, out: Out) {
        let Some(connection) = self.connections.get(&id) else { return };
        if connection.try_send(out).is_err() {
            // It does not drain its channel; its half of the socket ends with the channel.
            self.connections.remove(&id);
            self.handle(ShoreInput::Closed(id));
        }
    }

    /// Looks up what is durable of the stream that says hello.
    fn greeted(&mut self, id: ConnectionId, hello: &Hello) {
        if hello.address != self.vessel.0 {
            let text = format!("this token is for {}, not for {}", self.vessel, Address(hello.address));
            tracing::warn!(vessel = %self.vessel, %text, "a vessel was refused");
            return self.handle(ShoreInput::Refuse(id, text));
        }
        tracing::info!(vessel = %self.vessel, name = %hello.name, software = %hello.software, "a vessel greets");
        self.has_ways = hello.way.is_some();
        let way = hello.way.as_ref().map(|way| way.name.as_str());
        self.orders.greeted(id, way, |id| self.connections.contains_key(id));
        let stream = hello.stream;
        let (recorder, answers) = (self.recorder.clone(), self.answers.0.clone());
        tokio::spawn(async move {
            if let Some(durable) = recorder.with_store(move |store| store.durable(stream)).await {
                answers.send(Answer::Durable(id, stream, durable)).await.ok();
            }
        });
    }

    fn answered(&mut self, answer: Answer) {
        match answer {
            Answer::Durable(id, stream, durable) => {
                if self.shore.joins(id) {
                    // One more way of the same vessel: the progress over the others stays valid.
                    self.durable = self.durable.max(durable);
                } else {
                    // A declared gap is valid only for the stream's connection: a vessel that still has the packets sends
                    // them, and one that does not declares the gap again.
                    self.stream = Some(stream);
                    self.gaps.clear();
                    self.durable = durable;
                }
                self.handle(ShoreInput::Resume(id, durable));
            }
            Answer::Part(id, ask, bytes) => self.handle(ShoreInput::ChartPart(id, ask, bytes)),
            Answer::Kept(stream, from, to) => {
                if self.stream == Some(stream) {
                    self.gaps.insert(from, to);
                    self.acknowledge();
                }
            }
        }
    }

    /// The highest number below which everything is durable or declared missing. A gap counts only once everything
    /// before it is on disk.
    fn acknowledgeable(&mut self) -> Option<u64> {
        let mut reached = self.durable;
        while let Some(gap) = self.gaps.first_entry()
            && *gap.key() <= reached.map_or(0, |seq| seq + 1)
        {
            reached = reached.max(gap.remove().checked_sub(1));
        }
        self.durable = reached;
        reached
    }

    fn acknowledge(&mut self) {
        if let (Some(stream), Some(seq)) = (self.stream, self.acknowledgeable()) {
            self.handle(ShoreInput::Durable { stream, seq });
        }
    }

    /// Stores a declared gap; its numbers count as done once that is durable.
    fn gap(&mut self, stream: u64, gap: Gap) {
        if gap.reason == GapReason::AcknowledgedBefore {
            // Nothing is missing: the packets are here, or were before an older copy of this archive was restored.
            return self.answered(Answer::Kept(stream, gap.from, gap.to));
        }
        let (recorder, answers) = (self.recorder.clone(), self.answers.0.clone());
        let declared = store::Gap {
            system: self.vessel,
            from: gap.since,
            to: gap.until.max(gap.since),
            kind: match gap.reason {
                GapReason::NotRecorded | GapReason::Killed => GapKind::NotRecorded,
                _ => GapKind::Lost,
            },
            reason: reason(gap.reason).to_owned(),
            // After a kill the numbers do not give a count.
            packets: (gap.reason != GapReason::Killed).then(|| gap.to.saturating_sub(gap.from)),
            numbers: Some(store::Numbers { stream, from: gap.from, to: gap.to }),
            declared: self.now().utc,
        };
        tracing::warn!(vessel = %self.vessel, reason = %declared.told(), "packets are lost for good");
        tokio::spawn(async move {
            match recorder.with_store(move |store| store.declare_gap(&declared)).await {
                Some(Ok(())) => {
                    answers.send(Answer::Kept(stream, gap.from, gap.to)).await.ok();
                }
                Some(Err(error)) => tracing::error!(%error, "a gap cannot be kept"),
                None => {}
            }
        });
    }

    /// Publishes the link's state, and periodically records its latency as a series of this server.
    async fn figures(&mut self) {
        let status = self.tell_status();
        let due = self.told.is_multiple_of(RECORD_EVERY);
        self.told = self.told.wrapping_add(1);
        if due {
            for packet in self.figures.packets(&status, self.now().utc) {
                self.router.send(packet).await.ok();
            }
        }
    }

    /// Publishes the link's state.
    fn tell_status(&mut self) -> ShoreStatus {
        let now = self.now();
        let status = self.shore.status(now);
        self.status.send_replace(status);
        let vessel = self.vessel.to_string();
        metrics::gauge!("lutra_link_up", "vessel" => vessel.clone()).set(f64::from(u8::from(status.up)));
        metrics::gauge!("lutra_link_round_trip_seconds", "vessel" => vessel.clone())
            .set(status.round_trip.map_or(f64::NAN, |time| time.as_secs_f64()));
        metrics::gauge!("lutra_link_backlog_records", "vessel" => vessel).set(status.backlog.records as f64);
        status
    }

    /// Offset by which the vessel's clock is ahead of ours (µs); 0 while unknown.
    fn vessel_ahead_us(&self) -> i64 {
        self.shore.clocks(self.now()).map_or(0, |clocks| clocks.utc_ahead_us)
    }
}

async fn until(router: &Router, due: Option<units::MonoTime>) {
    match due {
        Some(due) => router.clock().sleep_until(due).await,
        None => std::future::pending().await,
    }
}

fn incoming(stream: u64, record: Record, now: UtcTime, vessel_ahead_us: i64) -> Incoming {
    let age_us = (now - record.recorded).saturating_add(vessel_ahead_us);
    let present = age_us < i64::try_from(PRESENT.as_micros()).unwrap_or(i64::MAX);
    let link = Some(LinkSeq { stream, seq: record.seq });
    Incoming { packet: record.packet, link, lane: if present { Lane::Present } else { Lane::Backlog } }
}

fn receipt(outcome: Outcome) -> Receipt {
    match outcome {
        Outcome::Received => Receipt::Received,
        Outcome::Expired => Receipt::Expired,
        Outcome::Refused(why) => Receipt::Refused(why),
        Outcome::Unanswered => Receipt::Unanswered,
    }
}

fn reason(reason: GapReason) -> &'static str {
    match reason {
        GapReason::NotRecorded => "the vessel could not record them",
        GapReason::SpoolFull => "the vessel's spool was full",
        GapReason::PowerLost => "the vessel lost power before they were on its disk (an upper bound)",
        GapReason::Damaged => "the vessel's disk did not give them back",
        GapReason::AcknowledgedBefore => "they were acknowledged before; the shore has them or was restored",
        GapReason::Killed => "the vessel's program was killed: what it had not spooled yet is lost",
        GapReason::Other(_) => "a reason that this version does not know",
    }
}

/// Time to live of a packet to the vessel. A stick value is stale a moment later; a stop is worth delivering for as long as
/// an operator waits.
fn time_to_live(packet: &[u8]) -> Duration {
    let id = PacketView::unchecked(packet).map_or(0, |view| view.id());
    match id {
        m::RemoteActions::ID => Duration::from_millis(500),
        m::Heartbeat::ID => Duration::from_secs(1),
        m::Reference::ID => Duration::from_secs(2),
        m::Abort::ID => hub::STOP_LIFE,
        _ => TIME_TO_LIVE,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use imc::{Header, Packet};

    #[test]
    fn a_stick_is_worth_nothing_late_and_a_stop_always() {
        let packet = |message: imc::Message| Packet::new(Header::default(), message).encode().unwrap();
        let stick = time_to_live(&packet(m::RemoteActions::default().into()));
        let stop = time_to_live(&packet(m::Abort.into()));
        assert!(stick <= Duration::from_millis(750) && stop > Duration::from_mins(1));
        assert_eq!(time_to_live(b"no packet"), Duration::from_secs(10));
    }

    #[test]
    fn what_is_old_by_the_vessels_clock_belongs_to_the_past() {
        let record =
            |recorded| Record { seq: 1, recorded: UtcTime::from_micros(recorded), packet: Bytes::new() };
        let now = UtcTime::from_micros(100_000_000);
        let lane = |recorded, ahead| incoming(7, record(recorded), now, ahead).lane;
        assert_eq!(lane(99_000_000, 0), Lane::Present);
        assert_eq!(lane(90_000_000, 0), Lane::Backlog);
        // The vessel's clock is an hour behind ours.
        assert_eq!(lane(100_000_000 - 3_600_000_000, -3_600_000_000), Lane::Present);
        assert_eq!(lane(90_000_000 + 3_600_000_000, 3_600_000_000), Lane::Backlog);
    }
}
