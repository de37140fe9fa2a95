//! Detections counted into steps, bars, tags and flags.

use super::sighting::{Name, Sighting};
use crate::quality::MARKS;
use api::{FlagCode, SummaryBar, SummaryFlag};
use detections::Protocol;
use std::collections::BTreeMap;

const SECOND_US: i64 = 1_000_000;
const HOUR_US: i64 = 3_600 * SECOND_US;
const DAY_US: i64 = 24 * HOUR_US;
const WEEK_US: i64 = 7 * DAY_US;
/// 1970-01-05, a Monday (µs since 1970-01-01).
const MONDAY_US: i64 = 4 * DAY_US;
/// Steps of time that a plot of tags has at most.
const STEPS: i64 = 600;
/// Bars at most.
const BARS: i64 = 400;
/// How long a step or a bar can be: what people count in. Beyond, 52 weeks or a multiple.
const LENGTHS_US: [i64; 17] = [
    SECOND_US,
    5 * SECOND_US,
    15 * SECOND_US,
    60 * SECOND_US,
    300 * SECOND_US,
    900 * SECOND_US,
    1_800 * SECOND_US,
    HOUR_US,
    2 * HOUR_US,
    6 * HOUR_US,
    12 * HOUR_US,
    DAY_US,
    2 * DAY_US,
    WEEK_US,
    2 * WEEK_US,
    4 * WEEK_US,
    13 * WEEK_US,
];

/// The shortest length of which a span has at most so many, from a least one on.
fn length_us(span_us: i64, most: i64, least_us: i64) -> i64 {
    let fits = |length_us: &i64| *length_us >= least_us && span_us / length_us < most;
    LENGTHS_US.into_iter().find(fits).unwrap_or_else(|| (span_us / most / WEEK_US / 52 + 1) * WEEK_US * 52)
}

/// Begin and length of steps over a span.
#[derive(Debug, Clone, Copy)]
pub(super) struct Steps {
    pub(super) from_us: i64,
    pub(super) length_us: i64,
    pub(super) count: usize,
}

impl Steps {
    /// For plots of tags.
    pub(super) fn fine(from_us: i64, last_us: i64) -> Self {
        Self::new(from_us, last_us, STEPS, SECOND_US)
    }

    /// For bars.
    pub(super) fn bars(from_us: i64, last_us: i64) -> Self {
        Self::new(from_us, last_us, BARS, HOUR_US)
    }

    fn new(from_us: i64, last_us: i64, most: i64, least_us: i64) -> Self {
        // One of them is lost by beginning at a whole one.
        let length_us = length_us(last_us.saturating_sub(from_us), most - 1, least_us);
        // Weeks begin on Monday.
        let begin_us = if length_us % WEEK_US == 0 { MONDAY_US } else { 0 };
        let from_us = from_us.saturating_sub(begin_us).div_euclid(length_us) * length_us + begin_us;
        let count = usize::try_from(last_us.saturating_sub(from_us) / length_us + 1).unwrap_or(1);
        Self { from_us, length_us, count }
    }

    /// Which one a time lies in.
    pub(super) fn at(self, time_us: i64) -> Option<usize> {
        let at = usize::try_from(time_us.checked_sub(self.from_us)?.div_euclid(self.length_us)).ok()?;
        (at < self.count).then_some(at)
    }

    /// The end of the last one.
    pub(super) fn to_us(self) -> i64 {
        self.from_us.saturating_add(self.length_us.saturating_mul(self.count as i64))
    }
}

/// Detections, and those that nothing confirms.
pub(super) type Pair = (u64, u64);

/// One more of both.
pub(super) fn add(pair: &mut Pair, is_doubted: bool) {
    pair.0 += 1;
    pair.1 += u64::from(is_doubted);
}

/// Bars of detections and of listening.
pub(super) struct Bars {
    pub(super) steps: Steps,
    pub(super) counts: Vec<Pair>,
    /// Seconds that receivers listened; absent where none reported it.
    listened_s: Vec<Option<f64>>,
}

impl Bars {
    pub(super) fn new(steps: Steps) -> Self {
        Self { steps, counts: vec![(0, 0); steps.count], listened_s: vec![None; steps.count] }
    }

    /// A stretch in which a receiver listened, divided among the bars that it touches.
    pub(super) fn listen(&mut self, from_us: i64, to_us: i64) {
        let Steps { from_us: begin_us, length_us, .. } = self.steps;
        let (mut from_us, to_us) = (from_us.max(begin_us), to_us.min(self.steps.to_us()));
        while from_us <= to_us {
            let Some(at) = self.steps.at(from_us) else { return };
            let end_us = (begin_us + (at as i64 + 1) * length_us).min(to_us);
            *self.listened_s[at].get_or_insert(0.0) += (end_us - from_us) as f64 / 1e6;
            if end_us == to_us {
                return;
            }
            from_us = end_us;
        }
    }

    pub(super) fn told(&self) -> Vec<SummaryBar> {
        let bar =
            |(at, ((detections, unconfirmed), listened_s)): (usize, (&Pair, &Option<f64>))| SummaryBar {
                from_us: self.steps.from_us + at as i64 * self.steps.length_us,
                detections: *detections,
                unconfirmed: *unconfirmed,
                listened_s: *listened_s,
            };
        let all = self.counts.iter().zip(&self.listened_s).enumerate().map(bar);
        all.filter(|bar| bar.detections > 0 || bar.listened_s.is_some()).collect()
    }
}

/// Detections of one tag, by whichever receivers: a code that was given to several tags in turn is several of them.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tally {
    pub(super) count: Pair,
    pub(super) first_us: i64,
    pub(super) last_us: i64,
    /// The tag by a receiver of one of its detections, and what the register knows of that.
    pub(super) example: (usize, Slot),
}

impl Tally {
    fn add(&mut self, row: &Sighting, is_doubted: bool) {
        add(&mut self.count, is_doubted);
        let time_us = row.plotted_us();
        (self.first_us, self.last_us) = (self.first_us.min(time_us), self.last_us.max(time_us));
    }
}

/// The register's data of a detection: the place of its tag among those of its code, and whether an animal carried it.
pub(super) type Slot = Option<(usize, bool)>;

/// The key of a tag: protocol and number, the register's tag, and whether an animal carried it.
type Key<'s> = (&'s Protocol, u32, Option<(&'s str, bool)>);

/// All tags that were heard.
pub(super) struct Tallies<'s> {
    places: BTreeMap<Key<'s>, usize>,
    /// By tag and receiver the place that was asked for last; most detections ask for the same again.
    last: Vec<Option<(Slot, usize)>>,
    pub(super) all: Vec<Tally>,
}

impl<'s> Tallies<'s> {
    /// For so many tags by receivers.
    pub(super) fn new(series: usize) -> Self {
        Self { places: BTreeMap::new(), last: vec![None; series], all: Vec::new() }
    }

    /// Counts a detection; the place of its tag. `called` is the name of the register's tag.
    pub(super) fn add(
        &mut self,
        (series, row): (usize, &Sighting),
        name: &'s Name,
        slot: Slot,
        called: impl Fn() -> Option<&'s str>,
        is_doubted: bool,
    ) -> usize {
        let known = self.last[series].filter(|(last, _)| *last == slot).map(|(_, at)| at);
        let at = known.unwrap_or_else(|| {
            let of_register = slot.and_then(|(_, is_carried)| Some((called()?, is_carried)));
            let next = self.all.len();
            *self.places.entry((&name.protocol, name.tag_id, of_register)).or_insert(next)
        });
        self.last[series] = Some((slot, at));
        if at == self.all.len() {
            let (first_us, last_us) = (i64::MAX, i64::MIN);
            self.all.push(Tally { count: (0, 0), first_us, last_us, example: (series, slot) });
        }
        self.all[at].add(row, is_doubted);
        at
    }

    /// Their places, the one that was heard most first; of equals by protocol and number, and of a code the earlier one.
    pub(super) fn heard(&self, names: &[&Name]) -> Vec<usize> {
        let mut heard: Vec<usize> = (0..self.all.len()).collect();
        let key = |at: &usize| {
            let tally = &self.all[*at];
            let name = names[tally.example.0];
            (std::cmp::Reverse(tally.count.0), name.protocol.clone(), name.tag_id, tally.first_us)
        };
        heard.sort_by_cached_key(key);
        heard
    }
}

/// How many have which flag.
#[derive(Default)]
pub(super) struct Flags {
    unconfirmed: u64,
    own: [u64; MARKS.len()],
}

impl Flags {
    pub(super) fn add(&mut self, marks: u8, is_doubted: bool) {
        self.unconfirmed += u64::from(is_doubted);
        for (at, count) in self.own.iter_mut().enumerate() {
            *count += u64::from(marks >> at & 1);
        }
    }

    pub(super) fn told(&self) -> Vec<SummaryFlag> {
        let own = MARKS.into_iter().zip(self.own);
        let all = std::iter::once((FlagCode::Unconfirmed, self.unconfirmed)).chain(own);
        let flag = |(code, detections)| SummaryFlag { code, detections };
        all.map(flag).filter(|flag| flag.detections > 0).collect()
    }
}
