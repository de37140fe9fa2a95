//! The transfer of the shore's chart aboard: what is requested when, and what is reported to the shore.
//!
//! One part is under way at a time, and none while the previous one is being stored. A part is so small that the link
//! carries it in [`CARRIED_WITHIN`], and for three times as long as it took no part is requested: commands and
//! acknowledgements wait for one part at most and find three quarters of the link free.

use crate::frame::{
    ChartDigest, ChartOffer, ChartPart, ChartReport, ChartRequest, ChartStage, Frame, MAX_PART_BYTES,
};
use crate::wire::DecodeError;
use bytes::Bytes;
use std::time::Duration;
use units::MonoTime;

/// The link should carry a part within this; parts grow and shrink for it.
const CARRIED_WITHIN: Duration = Duration::from_millis(60);
const LEAST_PART_BYTES: u32 = 2 << 10;
const FIRST_PART_BYTES: u32 = 4 << 10;
const GREATEST_PART_BYTES: u32 = MAX_PART_BYTES as u32;
/// The pause between parts, as a multiple of the time that a part took, within these bounds.
const PAUSE_TIMES: u32 = 3;
const LEAST_PAUSE: Duration = Duration::from_millis(5);
const GREATEST_PAUSE: Duration = Duration::from_secs(2);
/// A part that does not come in this time is asked for again.
const ANSWER_WITHIN: Duration = Duration::from_secs(15);
/// A chart that could not be taken is tried again after this, then after twice as long, up to the greatest.
const FIRST_RETRY: Duration = Duration::from_secs(5);
const GREATEST_RETRY: Duration = Duration::from_mins(10);
/// The progress is reported this often.
const REPORT_EVERY: Duration = Duration::from_secs(1);

/// The chart aboard.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct ChartAboard {
    /// Digest of the file in force; zeros for none.
    pub held: ChartDigest,
    /// Its contents, for people.
    pub edition: String,
    /// Whether the vessel takes the shore's.
    pub takes: bool,
    /// Why one that is whole is not in force yet; empty where nothing waits.
    pub waits: String,
}

/// An output about the chart.
#[derive(Debug)]
pub(crate) enum Want {
    /// Send this.
    Send(Frame),
    /// Prepare to take this chart.
    Begin(ChartOffer),
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// No chart is wanted.
    Still,
    /// The driver prepares, or keeps a part.
    Driver,
    /// The next part is asked for then.
    Due(MonoTime),
    /// A part is under way.
    Asked { at: MonoTime, offset: u64, length: u32 },
    /// It failed, and is tried again then.
    Pausing(MonoTime),
    /// It is aboard as a whole.
    Kept,
}

/// The vessel's side. It lives through connections; what was fetched is the driver's, on its disk.
#[derive(Debug)]
pub(crate) struct Pull {
    aboard: ChartAboard,
    /// Whether a link is open over which the shore offers charts.
    linked: bool,
    /// The shore's offer over this connection.
    offer: Option<ChartOffer>,
    /// The wanted part.
    goal: Option<ChartOffer>,
    stage: Stage,
    have: u64,
    part_bytes: u32,
    not_before: MonoTime,
    failures: u32,
    trouble: String,
    told: Option<ChartReport>,
    next_report: MonoTime,
}

impl Pull {
    pub(crate) fn new(now: MonoTime) -> Self {
        Self {
            aboard: ChartAboard::default(),
            linked: false,
            offer: None,
            goal: None,
            stage: Stage::Still,
            have: 0,
            part_bytes: FIRST_PART_BYTES,
            not_before: now,
            failures: 0,
            trouble: String::new(),
            told: None,
            next_report: now,
        }
    }

    /// The link is open; `speaks`: whether the shore knows the chart's frames.
    pub(crate) fn linked(&mut self, speaks: bool) {
        self.linked = speaks;
    }

    /// The link is gone: so is a part that was under way.
    pub(crate) fn unlinked(&mut self, now: MonoTime) {
        (self.linked, self.offer, self.told) = (false, None, None);
        if matches!(self.stage, Stage::Asked { .. }) {
            self.stage = Stage::Due(now);
        }
        self.part_bytes = FIRST_PART_BYTES;
    }

    /// The chart aboard changed, or whether the shore's is wanted.
    pub(crate) fn aboard(&mut self, aboard: ChartAboard) -> Option<Want> {
        self.aboard = aboard;
        self.choose()
    }

    /// The shore has this.
    pub(crate) fn offered(&mut self, offer: ChartOffer) -> Option<Want> {
        self.offer = Some(offer);
        self.choose()
    }

    fn choose(&mut self) -> Option<Want> {
        let offer = self.offer.as_ref()?;
        let wanted = self.aboard.takes && offer.bytes > 0 && offer.digest != self.aboard.held;
        if !wanted {
            (self.goal, self.stage) = (None, Stage::Still);
            self.trouble.clear();
            return None;
        }
        if self.goal.as_ref().is_some_and(|goal| goal.digest == offer.digest) {
            return None;
        }
        self.goal = Some(offer.clone());
        (self.have, self.failures) = (0, 0);
        self.trouble.clear();
        self.begin()
    }

    fn begin(&mut self) -> Option<Want> {
        self.stage = Stage::Driver;
        self.goal.clone().map(Want::Begin)
    }

    fn is_goal(&self, digest: &ChartDigest) -> bool {
        self.goal.as_ref().is_some_and(|goal| goal.digest == *digest)
    }

    /// The driver has so much of a chart and wants the next part.
    pub(crate) fn go_on(&mut self, now: MonoTime, digest: &ChartDigest, have: u64) {
        if self.is_goal(digest) && self.stage == Stage::Driver {
            self.have = have;
            self.stage = Stage::Due(self.not_before.max(now));
        }
    }

    /// The driver has all of a chart, as it should be.
    pub(crate) fn kept(&mut self, digest: &ChartDigest) {
        if self.is_goal(digest) {
            self.have = self.goal.as_ref().map_or(0, |goal| goal.bytes);
            (self.stage, self.failures) = (Stage::Kept, 0);
            self.trouble.clear();
        }
    }

    /// The driver cannot take a chart.
    pub(crate) fn failed(&mut self, now: MonoTime, digest: &ChartDigest, text: String) {
        if self.is_goal(digest) {
            let pause = FIRST_RETRY * 2_u32.pow(self.failures.min(10));
            self.failures += 1;
            self.trouble = text;
            self.stage = Stage::Pausing(now + pause.min(GREATEST_RETRY));
        }
    }

    /// A part came; answers its place and bytes, or nothing where it was not waited for. `round_trip` is the
    /// shortest of late.
    ///
    /// # Errors
    /// When it is not what was asked for.
    pub(crate) fn part(
        &mut self,
        now: MonoTime,
        part: &ChartPart,
        round_trip: Option<Duration>,
    ) -> Result<Option<(u64, Bytes)>, DecodeError> {
        let Stage::Asked { at, offset, length } = self.stage else { return Ok(None) };
        if !self.is_goal(&part.digest) || part.offset != offset {
            return Ok(None);
        }
        let raw = part.unpack()?;
        let (have, most) = (raw.len() as u64, u64::from(length));
        if have > most {
            return Err(DecodeError::TooLong { what: "a part of a chart that was asked for", have, most });
        }
        if raw.is_empty() {
            self.failed(now, &part.digest, "the shore does not have the chart any more".to_owned());
            return Ok(None);
        }
        let took = now.since(at).saturating_sub(round_trip.unwrap_or_default());
        if took > CARRIED_WITHIN {
            self.part_bytes = (self.part_bytes / 2).max(LEAST_PART_BYTES);
        } else if took < CARRIED_WITHIN / 3 {
            self.part_bytes = (self.part_bytes * 2).min(GREATEST_PART_BYTES);
        }
        self.not_before = now + (took * PAUSE_TIMES).clamp(LEAST_PAUSE, GREATEST_PAUSE);
        self.stage = Stage::Driver;
        Ok(Some((offset, raw)))
    }

    /// The outputs that are due.
    pub(crate) fn step(&mut self, now: MonoTime) -> Vec<Want> {
        let mut wants = Vec::new();
        if !self.linked {
            return wants;
        }
        match self.stage {
            Stage::Asked { at, .. } if now.since(at) >= ANSWER_WITHIN => {
                self.part_bytes = LEAST_PART_BYTES;
                self.stage = Stage::Due(now);
            }
            Stage::Pausing(until) if now >= until && self.offer.is_some() => wants.extend(self.begin()),
            _ => {}
        }
        if let (Stage::Due(at), Some(goal), true) = (self.stage, &self.goal, self.offer.is_some())
            && now >= at
        {
            let left = goal.bytes.saturating_sub(self.have).min(u64::from(self.part_bytes));
            let (digest, offset, length) = (goal.digest, self.have, left as u32);
            self.stage = Stage::Asked { at: now, offset, length };
            wants.push(Want::Send(Frame::ChartRequest(ChartRequest { digest, offset, length })));
        }
        wants.extend(self.report(now).map(|report| Want::Send(Frame::ChartReport(report))));
        wants
    }

    /// The report that is due: at once when there is news, from time to time for the progress.
    fn report(&mut self, now: MonoTime) -> Option<ChartReport> {
        let report = self.as_told();
        let news =
            self.told.as_ref().is_none_or(|told| ChartReport { have: report.have, ..told.clone() } != report);
        let further = self.told.as_ref() != Some(&report);
        if !(news || further && now >= self.next_report) {
            return None;
        }
        self.next_report = now + REPORT_EVERY;
        self.told = Some(report.clone());
        Some(report)
    }

    fn as_told(&self) -> ChartReport {
        let (stage, text) = match self.stage {
            _ if !self.aboard.takes => (ChartStage::Declined, String::new()),
            Stage::Still => (ChartStage::Settled, String::new()),
            Stage::Kept => (ChartStage::Waiting, self.aboard.waits.clone()),
            Stage::Pausing(_) => (ChartStage::Failed, self.trouble.clone()),
            Stage::Driver | Stage::Due(_) | Stage::Asked { .. } => (ChartStage::Fetching, String::new()),
        };
        let goal = self.goal.as_ref();
        ChartReport {
            held: self.aboard.held,
            edition: self.aboard.edition.clone(),
            stage,
            have: goal.map_or(0, |_| self.have),
            of: goal.map_or(0, |goal| goal.bytes),
            text,
        }
    }

    /// When to look again, while the link is open.
    pub(crate) fn poll_timeout(&self) -> Option<MonoTime> {
        if !self.linked {
            return None;
        }
        let due = match self.stage {
            Stage::Due(at) | Stage::Pausing(at) => self.offer.as_ref().map(|_| at),
            Stage::Asked { at, .. } => Some(at + ANSWER_WITHIN),
            Stage::Still | Stage::Driver | Stage::Kept => None,
        };
        let report = (self.told.as_ref() != Some(&self.as_told())).then_some(self.next_report);
        due.into_iter().chain(report).min()
    }
}
