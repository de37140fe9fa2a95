//! One way to the shore aboard: its connection, pauses, quality and cost.

use super::up::{Lanes, Up};
use crate::HEARTBEAT;
use crate::backoff::Backoff;
use crate::clocks::Clocks;
use crate::frame::{Capabilities, ChartOffer};
use crate::pace::Pace;
use crate::ways::choice::{Candidate, hold};
use crate::ways::meter::Meter;
use crate::ways::quality::Quality;
use crate::ways::{SLOW_HEARTBEAT, Thinning, WayReport, WaySettings, WayState, dead_after};
use crate::{ConnectionId, DEAD_AFTER};
use std::time::Duration;
use units::{MonoTime, Now};

/// A way that has answered for so long has its earlier breaks forgiven.
const FORGIVEN_AFTER: Duration = Duration::from_mins(10);
/// After a stall of the program, messages that came meanwhile have this long to be read, and unsent ones to be answered.
const EXCUSED_FOR: Duration = Duration::from_millis(600);
/// After a break an unmetered way is tried again beside a metered one so many times as late as a lane would go back to it:
/// where a shore keeps one connection at a time, trying closes the open one.
const RETURN_HOLDS: u32 = 4;

#[derive(Debug)]
pub(crate) struct Way {
    pub(crate) settings: WaySettings,
    pub(crate) phase: Phase,
    /// The number of its last connection.
    pub(crate) attempt: u64,
    pub(crate) backoff: Backoff,
    pub(crate) quality: Quality,
    pub(crate) meter: Meter,
    /// How often it stopped answering or broke since its last long good period.
    breaks: u32,
    pub(crate) failures: u32,
    /// With a shore that keeps one connection at a time: not in place of an open one until then.
    pub(crate) return_at: MonoTime,
}

#[derive(Debug)]
pub(crate) enum Phase {
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
pub(crate) struct Open {
    pub(crate) heard: MonoTime,
    /// Given up when the shore has not agreed by then.
    pub(crate) greeting_until: MonoTime,
    pub(crate) clocks: Clocks,
    pub(crate) pace: Pace,
    /// After the shore agreed.
    pub(crate) up: Option<Up>,
    /// The chart that the shore has, as it last said here.
    pub(crate) offer: Option<ChartOffer>,
    pub(crate) capabilities: Capabilities,
    /// Both ends know of ways.
    pub(crate) joint: bool,
    /// A sent message was not answered in time.
    pub(crate) suspect: bool,
    /// Since when it answers without a break.
    answers_since: MonoTime,
    /// The program itself was stalled: until then silence is not a fault of the way.
    excused_until: MonoTime,
}

impl Open {
    pub(crate) fn new(now: MonoTime, greeting_within: Duration, clocks: Clocks, pace: Pace) -> Self {
        Self {
            heard: now,
            greeting_until: now + greeting_within,
            clocks,
            pace,
            up: None,
            offer: None,
            capabilities: Capabilities::default(),
            joint: false,
            suspect: false,
            answers_since: now,
            excused_until: now,
        }
    }
}

impl Way {
    pub(crate) fn new(now: MonoTime, seed: u64, settings: WaySettings) -> Self {
        Self {
            phase: Phase::Pausing(now),
            attempt: 0,
            backoff: Backoff::new(seed),
            quality: Quality::default(),
            meter: Meter::new(now, settings.used, settings.daily_bytes),
            breaks: 0,
            failures: 0,
            return_at: now,
            settings,
        }
    }

    pub(crate) fn id(&self) -> ConnectionId {
        ConnectionId(self.attempt)
    }

    pub(crate) fn is_active(&self) -> bool {
        matches!(self.phase, Phase::Opening | Phase::Open(_))
    }

    pub(crate) fn open(&self) -> Option<&Open> {
        if let Phase::Open(open) = &self.phase { Some(open) } else { None }
    }

    pub(crate) fn open_mut(&mut self) -> Option<&mut Open> {
        if let Phase::Open(open) = &mut self.phase { Some(open) } else { None }
    }

    pub(crate) fn up(&self) -> Option<&Up> {
        self.open().and_then(|open| open.up.as_ref())
    }

    pub(crate) fn stands(&self) -> bool {
        self.up().is_some()
    }

    /// When its connection is given up for silence.
    pub(crate) fn dead_at(&self, open: &Open) -> MonoTime {
        let silent = if open.joint { dead_after(self.settings.metered) } else { DEAD_AFTER };
        (open.heard + silent).max(open.excused_until)
    }

    /// A sent message has no answer yet.
    pub(crate) fn waits_for_answer(&self) -> bool {
        self.open().is_some_and(|open| open.pace.oldest().is_some())
    }

    /// The program did not look for a while: what came meanwhile waits to be read, and what was to go may not have gone. A
    /// way that was silent ever since the last such pause is not excused again: a program that is always late still finds it.
    pub(crate) fn excuse(&mut self, now: MonoTime) {
        let Phase::Open(open) = &mut self.phase else { return };
        if !open.suspect && open.heard + EXCUSED_FOR > open.excused_until {
            open.excused_until = now + EXCUSED_FOR;
            open.greeting_until = open.greeting_until.max(open.excused_until);
        }
    }

    /// When what is under way makes the way suspect; `None` while nothing does.
    pub(crate) fn suspect_at(&self) -> Option<MonoTime> {
        let open = self.open().filter(|open| open.up.is_some())?;
        let allowed = self.quality.allowance(open.pace.under_way());
        // An older shore answers small messages with its own beat.
        let allowed = if open.joint { allowed } else { allowed + HEARTBEAT };
        open.pace.oldest().map(|oldest| (oldest + allowed).max(open.excused_until))
    }

    /// Looks whether it answers; true where it has just become suspect.
    pub(crate) fn look(&mut self, now: MonoTime) -> bool {
        let suspect = self.suspect_at().is_some_and(|at| now >= at);
        let Phase::Open(open) = &mut self.phase else { return false };
        let begins = suspect && !open.suspect;
        if suspect {
            open.answers_since = now;
        } else if self.breaks > 0 && open.up.is_some() && now.since(open.answers_since) >= FORGIVEN_AFTER {
            self.breaks = 0;
        }
        open.suspect = suspect;
        if begins {
            self.broke();
        }
        begins
    }

    /// It is left for another one: that its connection ends is not its fault.
    pub(crate) fn leave(&mut self, now: MonoTime) {
        if let Phase::Open(open) = &mut self.phase {
            open.excused_until = open.excused_until.max(now + EXCUSED_FOR);
        }
    }

    /// Another one was left for it, and the shore did not answer: it is tried later, and later after each further time.
    pub(crate) fn gone_back_to_in_vain(&mut self) {
        self.breaks = self.breaks.saturating_add(1);
    }

    /// Its connection is gone.
    pub(crate) fn lost(&mut self, now: MonoTime) {
        // A way that was suspect has been counted; the shore gives one up, too, where the program was away for long.
        let is_its_fault = |open: &Open| open.up.is_some() && !open.suspect && now >= open.excused_until;
        if self.open().is_some_and(is_its_fault) {
            self.broke();
        }
        self.return_at = now + hold(self.breaks) * RETURN_HOLDS;
    }

    fn broke(&mut self) {
        self.breaks = self.breaks.saturating_add(1);
        self.failures = self.failures.saturating_add(1);
    }

    /// When it has answered for long enough to be gone back to.
    pub(crate) fn proven_at(&self) -> Option<MonoTime> {
        let open = self.open().filter(|open| open.up.is_some() && !open.suspect)?;
        Some(open.answers_since + hold(self.breaks))
    }

    pub(crate) fn candidate(&self, now: MonoTime) -> Candidate {
        let open = self.open().filter(|open| open.up.is_some());
        Candidate {
            stands: open.is_some(),
            answers: open.is_some_and(|open| !open.suspect),
            is_proven: self.proven_at().is_some_and(|at| now >= at),
            metered: self.settings.metered,
            thinning: self.meter.thinning(),
            is_good: self.quality.is_good(),
            cost_ms: self.quality.cost_ms(),
        }
    }

    /// The lanes that its connection carries.
    pub(crate) fn lanes(&self, live: bool, records: bool, records_at: Option<u64>) -> Lanes {
        let thinning = self.meter.thinning();
        let joint = self.open().is_some_and(|open| open.joint);
        let slow = joint && self.settings.metered && (!(live || records) || thinning >= Thinning::Most);
        Lanes { live, records, records_at, thinning, beat: if slow { SLOW_HEARTBEAT } else { HEARTBEAT } }
    }

    /// So many bytes have arrived ashore in all; answers how long the last of them took.
    pub(crate) fn arrived(&mut self, now: Now, bytes: u64) -> Option<Duration> {
        let Phase::Open(open) = &mut self.phase else { return None };
        let before = open.pace.arrived_bytes();
        let took = open.pace.arrived(now.mono, bytes)?;
        // A pause of the program says nothing of the way.
        if now.mono >= open.excused_until {
            self.quality.arrived(open.pace.arrived_bytes() - before, took);
        }
        Some(took)
    }

    pub(crate) fn state(&self) -> WayState {
        match self.open().filter(|open| open.up.is_some()) {
            None => WayState::Down,
            Some(open) if open.suspect => WayState::Suspect,
            Some(_) => WayState::Up,
        }
    }

    pub(crate) fn report(&self) -> WayReport {
        let round_trip = self.quality.usual().unwrap_or_default().as_micros();
        WayReport {
            name: self.settings.name.clone(),
            metered: self.settings.metered,
            state: self.state(),
            round_trip_us: u32::try_from(round_trip).unwrap_or(u32::MAX),
            late_per_mille: self.quality.late_per_mille(),
            rate_bytes_per_s: self.quality.rate_bytes_per_s(),
            today_bytes: self.meter.used().bytes,
            daily_bytes: self.meter.daily_bytes().unwrap_or(0),
            thinning: self.meter.thinning(),
            failures: self.failures,
        }
    }
}
