//! The shore's frames, and the vessel's answers.

use super::machine::{End, Vessel};
use super::up::Up;
use super::way::Way;
use super::{Answer, VesselOutput};
use crate::commands::First;
use crate::frame::{
    Ack, ByeCode, ChartOffer, ChartPart, Command, Frame, Heartbeat, Lease, OLDEST_VERSION, VERSION, Verdict,
    Welcome, decode, message,
};
use crate::ways::LONGEST_SILENCE;
use bytes::Bytes;
use std::time::Duration;
use units::Now;

/// Starts of the shore that are remembered.
const MOST_PAST_RUNS: usize = 8;

impl Vessel {
    pub(super) fn message(&mut self, now: Now, place: usize, bytes: Bytes) -> Result<(), End> {
        self.ways[place].meter.count(now, bytes.len());
        if let Some(open) = self.ways[place].open_mut() {
            open.heard = now.mono;
        }
        for frame in decode(bytes).map_err(End::protocol)? {
            self.frame(now, place, frame.map_err(End::protocol)?)?;
        }
        Ok(())
    }

    fn frame(&mut self, now: Now, place: usize, frame: Frame) -> Result<(), End> {
        if self.ways[place].open().is_none() {
            return Ok(());
        }
        match (frame, self.ways[place].stands()) {
            (Frame::Bye(bye), _) => {
                let refused = !matches!(bye.code, ByeCode::Ending | ByeCode::Silent);
                let reason = format!("the shore closes the link: {} ({:?})", bye.text, bye.code);
                return Err(End { code: None, reason, refused });
            }
            (Frame::Welcome(welcome), false) => return self.welcome(now, place, &welcome),
            (Frame::Ack(ack), true) => return self.ack(now, place, ack),
            (Frame::Heartbeat(beat), true) => self.heartbeat(now, place, beat),
            (Frame::Command(command), true) => self.command(now, place, command),
            (Frame::Lease(lease), true) => self.lease(lease),
            (Frame::Chart(offer), true) => self.chart(now, place, offer),
            (Frame::ChartPart(part), true) => return self.chart_part(now, place, &part),
            (
                Frame::Ack(_)
                | Frame::Heartbeat(_)
                | Frame::Command(_)
                | Frame::Lease(_)
                | Frame::Chart(_)
                | Frame::ChartPart(_),
                false,
            ) => {
                return Err(End::protocol("the shore speaks before it agreed"));
            }
            (_, _) => return Err(End::protocol("a frame that only a vessel sends, or a second welcome")),
        }
        Ok(())
    }

    fn ack(&mut self, now: Now, place: usize, ack: Ack) -> Result<(), End> {
        if let Some(took) = self.ways[place].arrived(now, ack.bytes) {
            self.arriving.add(took);
        }
        // The count received is that of all ways together.
        let most = if self.joint { self.settings.spool.next } else { 0 };
        let Some(up) = self.ways[place].open_mut().and_then(|open| open.up.as_mut()) else { return Ok(()) };
        if up.ack(now.mono, ack, most, &mut self.keeping).is_none() {
            return Err(End::protocol("the shore acknowledges what was never sent"));
        }
        self.acknowledged(ack.durable);
        Ok(())
    }

    fn acknowledged(&mut self, durable: u64) {
        if durable > self.durable {
            self.durable = durable;
            self.outputs.push_back(VesselOutput::Acknowledged(durable));
        }
    }

    fn heartbeat(&mut self, now: Now, place: usize, beat: Heartbeat) {
        // A welcome followed by a disconnect is not a success.
        self.ways[place].backoff.succeeded();
        if let Some(open) = self.ways[place].open_mut() {
            open.clocks.heard(now, beat.stamp);
        }
        if let Some(took) = self.ways[place].arrived(now, beat.bytes) {
            self.arriving.add(took);
        }
    }

    /// Who commands; ignored if another way has overtaken it.
    fn lease(&mut self, lease: Lease) {
        if lease.number == 0 || lease.number > self.newest_lease {
            self.newest_lease = self.newest_lease.max(lease.number);
            self.outputs.push_back(VesselOutput::Lease(lease));
        }
    }

    fn chart(&mut self, now: Now, place: usize, offer: ChartOffer) {
        if let Some(open) = self.ways[place].open_mut() {
            open.offer = Some(offer.clone());
        }
        if self.report.records.map(usize::from) == Some(place) {
            let want = self.pull.offered(offer);
            self.want(now, want);
        }
    }

    fn chart_part(&mut self, now: Now, place: usize, part: &ChartPart) -> Result<(), End> {
        let Some(open) = self.ways[place].open() else { return Ok(()) };
        if self.report.records.map(usize::from) != Some(place) {
            return Ok(());
        }
        let round_trip = open.clocks.shortest_round_trip();
        let came = self.pull.part(now.mono, part, round_trip).map_err(End::protocol)?;
        self.outputs.extend(came.map(|(offset, bytes)| VesselOutput::ChartPart {
            digest: part.digest,
            offset,
            bytes,
        }));
        Ok(())
    }

    fn welcome(&mut self, now: Now, place: usize, welcome: &Welcome) -> Result<(), End> {
        if welcome.version > VERSION || welcome.version < OLDEST_VERSION {
            return Err(End::protocol(format_args!(
                "the shore chose version {}, this program speaks {OLDEST_VERSION} to {VERSION}",
                welcome.version
            )));
        }
        if welcome.resume > self.settings.spool.next {
            self.outputs.push_back(VesselOutput::Renumber);
            let reason = format!("the shore has records below {}, more than were spooled", welcome.resume);
            return Err(End::ending(reason));
        }
        if welcome.run.is_some_and(|run| self.past_runs.contains(&run)) {
            return Err(End::silent("another start of the shore has followed this one"));
        }
        self.joined(now, place, welcome);
        let budget = self.settings.budget_bytes_per_s;
        let joint = self.joint;
        let Some(open) = self.ways[place].open_mut() else { return Ok(()) };
        open.clocks.heard(now, welcome.stamp);
        open.up = Some(Up::new(now.mono, welcome, budget));
        (open.capabilities, open.joint) = (welcome.capabilities, joint);
        self.connections += 1;
        self.outputs.push_back(VesselOutput::Up(self.ways[place].id()));
        self.acknowledged(welcome.resume);
        // The first open one carries all, from this moment on.
        self.assign(now);
        Ok(())
    }

    /// Whether this shore accepts parallel connections, and whether it is the same shore as the others'.
    fn joined(&mut self, now: Now, place: usize, welcome: &Welcome) {
        self.joint = self.ways.len() > 1 && welcome.run.is_some();
        let other_shore = self.run != welcome.run;
        if other_shore {
            self.past_runs.extend(self.run);
            if self.past_runs.len() > MOST_PAST_RUNS {
                self.past_runs.pop_front();
            }
            (self.run, self.newest_command, self.newest_lease) = (welcome.run, 0, 0);
        }
        if !self.joint {
            (self.turn, self.left) = (place, None);
            self.end_all(
                now,
                |other| other != place,
                || End::silent("the shore keeps one connection at a time"),
            );
        } else if other_shore {
            let is_up: Vec<bool> = self.ways.iter().map(Way::stands).collect();
            self.end_all(
                now,
                |other| other != place && is_up[other],
                || End::silent("the shore was started again"),
            );
        }
    }

    fn command(&mut self, now: Now, place: usize, command: Command) {
        let Some(open) = self.ways[place].open() else { return };
        let (id, order, joint) = (command.id, command.order, open.joint);
        let age = open.clocks.greatest_age(now.mono, command.sent);
        let first = self.seen.look(id, order, place);
        if order > 0 {
            let again = first != First::New;
            self.outputs.push_back(VesselOutput::Came { id, order, way: place, again });
        }
        match first {
            First::Unanswered => {}
            First::Answered(receipt) => self.send(now, place, message(&Frame::Receipt(receipt))),
            First::New if joint && id < self.newest_command => {
                let text = "a later command came before it, by another way".to_owned();
                self.answer(now, id, Answer::Refused(text));
            }
            First::New => {
                self.newest_command = id;
                let left = age.and_then(|age| {
                    let ttl = Duration::from_millis(u64::from(command.ttl_ms));
                    ttl.checked_sub(age).filter(|left| !left.is_zero())
                });
                match left {
                    Some(left) => {
                        let (lease, packet, expires) = (command.lease, command.packet, now.mono + left);
                        self.outputs.push_back(VesselOutput::Command { id, lease, order, packet, expires });
                    }
                    None => self.answer(now, id, Answer::Expired),
                }
            }
        }
    }

    pub(super) fn answer(&mut self, now: Now, id: u64, answer: Answer) {
        let (verdict, text) = match answer {
            Answer::Received => (Verdict::Received, String::new()),
            Answer::Expired => (Verdict::Expired, String::new()),
            Answer::Refused(text) => (Verdict::Refused, text),
        };
        let Some((receipt, came_on)) = self.seen.answer(now.mono, id, verdict, text) else { return };
        if receipt.order > 0 {
            self.outputs.push_back(VesselOutput::Answered(receipt.clone()));
        }
        // Either way may be dead though it is open; a record that comes twice does no harm ashore.
        let live = self.report.live.map(usize::from);
        let stands: Vec<usize> = (0..self.ways.len()).filter(|place| self.ways[*place].stands()).collect();
        let wanted = |place: &usize| came_on.contains(place) || live == Some(*place);
        let mut places: Vec<usize> = stands.iter().copied().filter(wanted).collect();
        if places.is_empty() {
            places.extend(stands.first());
        }
        for place in places {
            self.send(now, place, message(&Frame::Receipt(receipt.clone())));
        }
    }

    /// Says the answers again that may have gone into a way that was dead for as long as that can last.
    pub(super) fn answer_again(&mut self, now: Now, place: usize) {
        for receipt in self.seen.answered_within(now.mono, LONGEST_SILENCE) {
            self.send(now, place, message(&Frame::Receipt(receipt)));
        }
    }
}
