//! The receiver's clock: when which command is due, which acknowledgement is awaited, and how good the clock is.
//!
//! Without a pulse per second `(+)` goes at marks of ten seconds of UTC and rounds the clock to them; every n-th time, and
//! whenever the clock is not known to be near, the full time goes instead, for rounding a clock that is more than five seconds
//! off would set it wrong for good. With a pulse `UT=` goes on a whole second, seldom.
//!
//! A clock is lost when acknowledgements are missing, when its stamps cannot be, when the delay of its lines jumps, and when
//! this computer's clock is set: it goes by the old time until its next command.

use super::delays::Delays;
use core::time::Duration;
use devices::ClockState;
use devices::tbr::{Ack, SET_AFTER_S};
use devices::tbr_clock::ClockCommand;
use units::{MonoTime, Now};

const TEN_SECONDS_US: i64 = 10_000_000;
const SECOND_US: i64 = 1_000_000;
/// A command is passed on this long before its mark: the port waits for the mark, not this driver (µs).
const AHEAD_US: i64 = 200_000;
/// After a command by pulse that was not acknowledged the next one follows.
const RETRY: Duration = Duration::from_secs(10);
/// A line comes so long after its stamp at most: the longest train of pulses and what waits before it.
const SETTLING: Duration = Duration::from_secs(10);
/// Acknowledgements missing in a row that lose the clock.
const MISSES_THAT_LOSE: u32 = 3;
/// Differences between arrival and stamp that the offset is the least of.
const DIFFERENCES: usize = 8;
/// A line comes after its stamp, by the rest of its train of pulses and what waits before it (s): more or less is a clock
/// that is wrong. Trains last up to some four seconds. Rounding can leave a clock wrong by ten seconds exactly, so that the
/// range must be narrower than that.
const BELIEVED_S: core::ops::RangeInclusive<f64> = -1.0..=8.0;
/// UTC that runs away from the steady clock by more than this at once was set (µs), beyond a thousandth of the time: who slews
/// it faster moves it by as much between two marks as a step does.
const STEP_US: i64 = 100_000;
const SLEWED: i64 = 1000;

/// How the receiver's clock is kept.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Sync {
    /// Not at all.
    Off,
    /// By commands at marks of ten seconds; every so many times with the full time, 1 always.
    Marks {
        /// One in so many commands carries the full time.
        full_every: u32,
    },
    /// By a pulse per second at the receiver; the time is sent once a period.
    Pulse {
        /// From one command to the next.
        period: Duration,
    },
}

/// The outputs of the clock's keeper.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Said {
    /// Send this at that time.
    Send(ClockCommand, MonoTime),
    /// For the log.
    Note(String),
    /// For the log, and a person should look at it.
    Warning(String),
}

/// The keeping of the receiver's clock.
#[derive(Debug, Clone)]
pub(super) struct Keeper {
    sync: Sync,
    /// From the end of a command to its acknowledgement at most.
    ack_timeout: Duration,
    state: ClockState,
    /// Why it was lost, and the remedy.
    why: String,
    /// Whether it obeyed a command with the full time since: a stamp alone does not show that rounding hits the right ten
    /// seconds.
    was_set: bool,
    /// When the computer's two clocks were compared last.
    seen: Option<Now>,
    /// When the next command is to be prepared.
    next: Option<MonoTime>,
    /// Commands since the last with the full time.
    since_full: u32,
    awaited: Option<Awaited>,
    misses: u32,
    differences_s: Vec<f64>,
    delays: Delays,
    /// Until then lines may come whose stamps are older than the clock's setting.
    settling_until: Option<MonoTime>,
    /// Those stamps are of a clock that was lost.
    was_lost: bool,
}

/// An acknowledgement that is awaited.
#[derive(Debug, Clone, Copy)]
struct Awaited {
    ack: Ack,
    /// When the command leaves.
    sent: MonoTime,
    until: MonoTime,
}

/// The stamp of a line, and what sort of line it was where its delay can be compared.
#[derive(Debug, Clone, Copy)]
pub(super) struct Stamp<'a> {
    pub(super) clock_s: u32,
    pub(super) millis: u16,
    pub(super) sort: Option<&'a str>,
}

impl Keeper {
    pub(super) fn new(sync: Sync, ack_timeout: Duration) -> Self {
        Self {
            sync,
            ack_timeout,
            state: ClockState::Unknown,
            why: String::new(),
            was_set: false,
            seen: None,
            next: None,
            since_full: 0,
            awaited: None,
            misses: 0,
            differences_s: Vec::new(),
            delays: Delays::default(),
            settling_until: None,
            was_lost: false,
        }
    }

    pub(super) const fn state(&self) -> ClockState {
        self.state
    }

    /// How good the clock is by which the lines are stamped that come now, and why it was lost, if it is: those that were under
    /// way when it was set are not better for that.
    pub(super) fn of_lines(&self) -> (ClockState, &str) {
        let state = if self.was_lost { ClockState::Lost } else { self.state };
        (state, if state == ClockState::Lost { &self.why } else { "" })
    }

    /// The least of the last differences between arrival by the computer's clock and stamp (s): the offset of the receiver's
    /// clock with the shortest delay of a line on top of it.
    pub(super) fn offset_s(&self) -> Option<f64> {
        self.differences_s.iter().copied().reduce(f64::min)
    }

    /// Commands may be sent from now on. Whether the clock is as it was before is not known: the receiver may have lost its
    /// power.
    pub(super) fn start(&mut self, now: Now) {
        *self = Self { seen: Some(now), ..Self::new(self.sync, self.ack_timeout) };
        self.plan(now);
    }

    /// Compares the computer's two clocks. When UTC was set, the receiver's clock goes by the old time, and a command that
    /// is under way carries it.
    pub(super) fn watch(&mut self, now: Now, said: &mut Vec<Said>) {
        let Some(before) = self.seen.replace(now) else { return };
        // A gap of days fits 63 bits of microseconds.
        let elapsed_us = now.mono.since(before.mono).as_micros() as i64;
        let step_us = (now.utc - before.utc) - elapsed_us;
        if step_us.abs() <= STEP_US + elapsed_us / SLEWED {
            return;
        }
        self.differences_s.clear();
        self.awaited = None;
        if self.next.is_some() {
            self.plan(now);
        }
        if matches!(self.state, ClockState::Set | ClockState::Disciplined) {
            let (step_s, remedy) = (step_us as f64 / 1e6, self.remedy());
            let why = format!(
                "this computer's clock was set by {step_s:+.1} s, and the hydrophone's goes by the old time: {remedy}"
            );
            self.lose(now, why.clone());
            said.push(Said::Warning(why));
        }
    }

    /// No more commands: the port is gone, or in command mode.
    pub(super) fn stop(&mut self) {
        self.next = None;
        self.awaited = None;
    }

    pub(super) fn timeout(&self) -> Option<MonoTime> {
        let settled = self.settling_until.filter(|_| self.was_lost);
        self.awaited.map(|awaited| awaited.until).into_iter().chain(self.next).chain(settled).min()
    }

    /// The output that is due.
    pub(super) fn time(&mut self, now: Now, said: &mut Vec<Said>) {
        self.settle(now);
        if let Some(Awaited { ack, until, .. }) = self.awaited
            && until <= now.mono
        {
            self.awaited = None;
            self.missed(now, ack, said);
        }
        if self.next.is_some_and(|next| next <= now.mono) {
            self.command(now, said);
        }
    }

    /// Looks whether all lines have come that were stamped before the clock was set.
    fn settle(&mut self, now: Now) {
        if self.settling_until.is_some_and(|until| until <= now.mono) {
            self.settling_until = None;
            self.was_lost = false;
        }
    }

    /// The raster of the marks (µs).
    const fn raster_us(&self) -> Option<i64> {
        match self.sync {
            Sync::Off => None,
            Sync::Marks { .. } => Some(TEN_SECONDS_US),
            Sync::Pulse { .. } => Some(SECOND_US),
        }
    }

    /// The next mark far enough ahead to be met.
    fn mark_us(now: Now, raster_us: i64) -> i64 {
        let least_us = now.utc.micros().saturating_add(AHEAD_US / 2);
        (least_us.div_euclid(raster_us) + 1).saturating_mul(raster_us)
    }

    /// Lays down when the next command is prepared: shortly before the next mark.
    fn plan(&mut self, now: Now) {
        self.next = self.raster_us().map(|raster_us| {
            let wait_us = (Self::mark_us(now, raster_us) - now.utc.micros() - AHEAD_US).max(0);
            now.mono + Duration::from_micros(wait_us.unsigned_abs())
        });
    }

    fn command(&mut self, now: Now, said: &mut Vec<Said>) {
        let Some(raster_us) = self.raster_us() else { return };
        let mark_us = Self::mark_us(now, raster_us);
        let ahead_us = mark_us - now.utc.micros();
        if ahead_us > 2 * AHEAD_US {
            // Called late or the computer's clock was set: the mark is missed, the next one is met.
            return self.plan(now);
        }
        let at = now.mono + Duration::from_micros(ahead_us.unsigned_abs());
        let seconds = mark_us / SECOND_US;
        let (command, ack) = match self.sync {
            Sync::Pulse { .. } => (ClockCommand::SetSecond(seconds), Ack::SetByPulse),
            Sync::Marks { full_every } if !self.is_near() || self.since_full + 1 >= full_every => {
                self.since_full = 0;
                (ClockCommand::SetTens(seconds), Ack::Set)
            }
            Sync::Marks { .. } | Sync::Off => {
                self.since_full += 1;
                (ClockCommand::Round, Ack::Rounded)
            }
        };
        // A character a millisecond, twelve at most or thirteen with UT=.
        let sent = Duration::from_millis(command.text().len() as u64);
        self.awaited = Some(Awaited { ack, sent: at, until: at + sent + self.ack_timeout });
        said.push(Said::Send(command, at));
        let period = match self.sync {
            Sync::Pulse { period } => period,
            Sync::Marks { .. } | Sync::Off => Duration::from_micros(TEN_SECONDS_US.unsigned_abs()),
        };
        self.next = Some(at + period.saturating_sub(Duration::from_micros(AHEAD_US.unsigned_abs())));
    }

    /// Whether rounding would hit the right ten seconds.
    const fn is_near(&self) -> bool {
        self.was_set && matches!(self.state, ClockState::Set | ClockState::Disciplined)
    }

    fn missed(&mut self, now: Now, ack: Ack, said: &mut Vec<Said>) {
        self.misses += 1;
        let text = ack.text();
        if self.misses == MISSES_THAT_LOSE || (self.misses == 1 && matches!(self.sync, Sync::Pulse { .. })) {
            let misses = self.misses;
            let why = format!(
                "the hydrophone's clock is not kept: {text} missing {misses} times in a row; check the line to the receiver"
            );
            self.lose(now, why.clone());
            said.push(Said::Warning(why));
        } else if self.misses < MISSES_THAT_LOSE {
            said.push(Said::Note(format!("the hydrophone did not acknowledge its clock's command ({text})")));
        }
        if matches!(self.sync, Sync::Pulse { .. }) {
            self.next = Some(now.mono + RETRY);
        }
    }

    /// An acknowledgement came. One that comes before its command has left is of an earlier command.
    pub(super) fn ack(&mut self, now: Now, ack: Ack, said: &mut Vec<Said>) {
        match self.awaited {
            Some(Awaited { ack: awaited, sent, .. }) if awaited == ack && sent <= now.mono => {
                self.awaited = None;
                self.misses = 0;
                if !self.is_near() {
                    // Earlier stamps say nothing of the clock as it is set now.
                    self.differences_s.clear();
                    self.delays.clear();
                    self.settling_until = Some(now.mono + SETTLING);
                    self.was_lost = self.state == ClockState::Lost;
                }
                self.was_set |= ack != Ack::Rounded;
                self.state = match (ack, self.state) {
                    (Ack::Set, state) if state != ClockState::Disciplined => ClockState::Set,
                    _ => ClockState::Disciplined,
                };
                let delay_s = now.mono.since(sent).as_secs_f64();
                if let Some(jump_s) = self.delays.take(now.mono, ack.text(), delay_s) {
                    self.jumped(now, &format!("it acknowledges {}", ack.text()), "its mark", jump_s, said);
                }
            }
            Some(Awaited { ack: awaited, .. }) if awaited != ack => {
                let (ack, awaited) = (ack.text(), awaited.text());
                said.push(Said::Note(format!("the hydrophone answered {ack} where {awaited} was due")));
            }
            _ => said.push(Said::Note(format!("the hydrophone sent {} that was not due", ack.text()))),
        }
    }

    /// A delay is another than it was, and stays so.
    fn jumped(&mut self, now: Now, what: &str, than: &str, jump_s: f64, said: &mut Vec<Said>) {
        let (ms, word) = (jump_s.abs() * 1e3, if jump_s > 0.0 { "later" } else { "earlier" });
        let remedy = self.remedy();
        let why = format!(
            "the hydrophone's clock jumped: {what} {ms:.0} ms {word} after {than} than before; {remedy}, and if that does not help, \
             look at the computer's load and its clock"
        );
        self.lose(now, why.clone());
        said.push(Said::Warning(why));
    }

    /// A line with a stamp came, its time by the receiver's clock.
    pub(super) fn stamp(&mut self, now: Now, stamp: Stamp<'_>, said: &mut Vec<Said>) {
        let Stamp { clock_s, millis, sort } = stamp;
        self.settle(now);
        if self.settling_until.is_some() {
            return;
        }
        if clock_s < SET_AFTER_S {
            return self.unset(clock_s, said);
        }
        let stamp_us = (i64::from(clock_s) * 1000 + i64::from(millis)) * 1000;
        let difference_s = (now.utc.micros() - stamp_us) as f64 / 1e6;
        if self.differences_s.len() == DIFFERENCES {
            self.differences_s.remove(0);
        }
        self.differences_s.push(difference_s);
        if BELIEVED_S.contains(&difference_s) {
            self.believe();
            let jump_s = sort.and_then(|sort| self.delays.take(now.mono, sort, difference_s));
            if let Some(jump_s) = jump_s.filter(|_| self.state != ClockState::Lost) {
                let sort = sort.unwrap_or_default();
                self.jumped(now, &format!("lines of {sort} come"), "their stamps", jump_s, said);
            }
        } else if self.state != ClockState::Lost {
            let remedy = self.remedy();
            let why = format!(
                "a line of the hydrophone is {difference_s:.1} s old by its clock, which is wrong: {remedy}"
            );
            self.lose(now, why.clone());
            said.push(Said::Warning(why));
        }
    }

    /// A stamp counts from power-up.
    fn unset(&mut self, clock_s: u32, said: &mut Vec<Said>) {
        if matches!(self.state, ClockState::Set | ClockState::Disciplined) {
            let remedy = self.remedy();
            said.push(Said::Warning(format!(
                "the hydrophone's clock is not set any more ({clock_s} s since power-up): {remedy}"
            )));
        }
        if self.state != ClockState::Lost {
            self.state = ClockState::Unset;
        }
        self.was_set = false;
    }

    /// A stamp is plausible. A clock that we do not set counts as set again by its stamps alone.
    const fn believe(&mut self) {
        let found = matches!(self.state, ClockState::Unknown | ClockState::Unset);
        if found || (matches!(self.state, ClockState::Lost) && matches!(self.sync, Sync::Off)) {
            self.state = ClockState::Set;
        }
    }

    pub(super) const fn remedy(&self) -> &'static str {
        match self.sync {
            Sync::Off => "nothing sets it; configure how it is kept",
            Sync::Marks { .. } => "it is set at the next mark of ten seconds",
            Sync::Pulse { .. } => "it is set with the next command; check the pulse per second",
        }
    }

    /// The clock may be anything, as when the receiver restarted: `why` says it to people, with the remedy.
    pub(super) fn lose(&mut self, now: Now, why: String) {
        self.state = ClockState::Lost;
        self.why = why;
        self.was_set = false;
        self.settling_until = None;
        self.was_lost = false;
        self.delays.clear();
        if matches!(self.sync, Sync::Pulse { .. }) && self.next.is_some() && self.awaited.is_none() {
            // Its next command may be half an hour away.
            self.plan(now);
        }
    }
}
