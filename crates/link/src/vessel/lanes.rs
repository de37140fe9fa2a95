//! Which way carries which lane, put into effect and reported to the shore.

use super::VesselOutput;
use super::machine::Vessel;
use super::up::Lanes;
use super::way::Way;
use crate::frame::{Capabilities, Frame, message};
use crate::ways::choice::{Candidate, Lane, choose};
use crate::ways::{Thinning, WayState, WaysReport};
use std::time::Duration;
use units::Now;

/// The ways are reported to the shore this often.
const REPORT_EVERY: Duration = Duration::from_secs(1);
/// And this often by a way that is metered.
const REPORT_METERED_EVERY: Duration = Duration::from_secs(10);
const REPORT_THINNED_EVERY: Duration = Duration::from_mins(1);

impl Vessel {
    /// The number that the record lane is at.
    pub(super) fn records_at(&self) -> Option<u64> {
        let place = self.report.records.map(usize::from)?;
        self.ways.get(place).and_then(|way| way.up()).map(|up| up.cursor)
    }

    /// The lanes that the connection of a way carries.
    pub(super) fn lanes(&self, place: usize) -> Lanes {
        let here = |lane: Option<u8>| lane.map(usize::from) == Some(place);
        let records_at = self.records_at();
        self.ways[place].lanes(here(self.report.live), here(self.report.records), records_at)
    }

    /// Gives each lane to its way.
    pub(super) fn assign(&mut self, now: Now) {
        let candidates: Vec<Candidate> = self.ways.iter().map(|way| way.candidate(now.mono)).collect();
        let live = self.report.live.map(usize::from);
        let records = self.report.records.map(usize::from);
        let (live_now, live_why) = choose(Lane::Live, live, &candidates);
        let (records_now, records_why) = choose(Lane::Records, records, &candidates);
        if live_why.is_none() && records_why.is_none() {
            return;
        }
        if let Some(why) = live_why {
            (self.report.live, self.report.live_why) = (live_now.map(|place| place as u8), why);
            self.take_live(now, live, live_now, live_now == records_now);
        }
        if let Some(why) = records_why {
            (self.report.records, self.report.records_why) = (records_now.map(|place| place as u8), why);
            self.take_records(now, records, records_now);
        }
        self.next_report = now.mono;
        if self.ways.len() > 1 {
            let report = self.ways_report();
            self.outputs.push_back(VesselOutput::Switched(report));
        }
    }

    fn take_live(&mut self, now: Now, before: Option<usize>, place: Option<usize>, with_records: bool) {
        let Some(place) = place else { return };
        self.report.choice += 1;
        if let Some(up) = self.ways[place].open_mut().and_then(|open| open.up.as_mut()) {
            up.take_live(now.mono, before.is_some(), with_records);
        }
        // Records sent by the previous way may never arrive.
        self.live.refresh();
        if self.ways.len() > 1 {
            self.answer_again(now, place);
        }
    }

    fn take_records(&mut self, now: Now, before: Option<usize>, place: Option<usize>) {
        if let Some(up) =
            before.and_then(|place| self.ways[place].open_mut()).and_then(|open| open.up.as_mut())
        {
            up.leave_records();
        }
        if before.is_some() {
            self.pull.unlinked(now.mono);
        }
        let Some(open) = place.and_then(|place| self.ways[place].open_mut()) else { return };
        if let Some(up) = &mut open.up {
            up.take_records();
        }
        self.pull.linked(open.capabilities.has(Capabilities::CHARTS));
        if let Some(offer) = open.offer.clone() {
            let want = self.pull.offered(offer);
            self.want(now, want);
        }
    }

    fn ways_report(&self) -> WaysReport {
        WaysReport { ways: self.ways.iter().map(Way::report).collect(), ..self.report.clone() }
    }

    /// Reports to the shore, by the way of the live values.
    pub(super) fn tell_ways(&mut self, now: Now) {
        let Some(place) = self.report.live.map(usize::from).filter(|_| self.joint) else { return };
        if self.ways.len() < 2 || !self.ways[place].stands() {
            return;
        }
        // That a way was lost or came up is reported at once.
        let states: Vec<WayState> = self.ways.iter().map(Way::state).collect();
        if now.mono < self.next_report && states == self.told_states {
            return;
        }
        self.told_states = states;
        let way = &self.ways[place];
        let every = match (way.settings.metered, way.meter.thinning()) {
            (false, _) => REPORT_EVERY,
            (true, Thinning::Nothing | Thinning::Records) => REPORT_METERED_EVERY,
            (true, Thinning::Most | Thinning::AllButLast) => REPORT_THINNED_EVERY,
        };
        self.next_report = now.mono + every;
        let frame = Frame::Ways(self.ways_report());
        self.send(now, place, message(&frame));
    }
}
