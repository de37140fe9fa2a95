//! Detections counted into steps, bars, tags and flags.

use super::sighting::{Name, Sighting};
use crate::quality::MARKS;
use api::{FlagCode, SummaryBar, SummaryFlag};
use std::collections::BTreeMap;

const SECOND_US: i64 = 1_000_000;
const HOUR_US: i64 = 3_600 * SECOND_US;
const DAY_US: i64 = 24 * HOUR_US;
/// Steps of time that a plot of tags has at most.
const STEPS: i64 = 600;
/// Bars at most.
const BARS: i64 = 400;
/// How long a step or a bar can be: what people count in. Beyond, whole years.
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
    7 * DAY_US,
    14 * DAY_US,
    28 * DAY_US,
    91 * DAY_US,
];

/// The shortest length of which a span has at most so many, from a least one on.
fn length_us(span_us: i64, most: i64, least_us: i64) -> i64 {
    let fits = |length_us: &i64| *length_us >= least_us && span_us / length_us < most;
    LENGTHS_US.into_iter().find(fits).unwrap_or_else(|| (span_us / most / DAY_US / 364 + 1) * DAY_US * 364)
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
        let from_us = from_us.div_euclid(length_us) * length_us;
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
    /// Seconds that receivers listened; absent where nobody told.
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

/// A tag of a protocol and number, by whichever receivers and carriers.
#[derive(Debug, Clone, Copy)]
pub(super) struct Tally {
    pub(super) count: Pair,
    pub(super) first_us: i64,
    pub(super) last_us: i64,
    /// The receiver that heard it last.
    pub(super) last_series: u32,
}

impl Tally {
    const NONE: Self = Self { count: (0, 0), first_us: i64::MAX, last_us: i64::MIN, last_series: 0 };

    fn add(&mut self, row: &Sighting, is_doubted: bool) {
        add(&mut self.count, is_doubted);
        let time_us = row.plotted_us();
        self.first_us = self.first_us.min(time_us);
        if time_us >= self.last_us {
            (self.last_us, self.last_series) = (time_us, row.series);
        }
    }
}

/// All tags that were heard.
pub(super) struct Tallies {
    /// By series the place of its tag.
    pub(super) tags: Vec<usize>,
    pub(super) all: Vec<Tally>,
}

impl Tallies {
    pub(super) fn new(names: &[Name]) -> Self {
        let mut places = BTreeMap::new();
        let mut tag = |name: &Name| {
            let next = places.len();
            *places.entry((name.protocol.clone(), name.tag_id)).or_insert(next)
        };
        let tags: Vec<usize> = names.iter().map(&mut tag).collect();
        Self { tags, all: vec![Tally::NONE; places.len()] }
    }

    pub(super) fn add(&mut self, row: &Sighting, is_doubted: bool) {
        if let Some(tally) = self.tags.get(row.series as usize).and_then(|tag| self.all.get_mut(*tag)) {
            tally.add(row, is_doubted);
        }
    }

    /// Those that were heard, by place, the one that was heard most first; of equals the one of the lower number.
    pub(super) fn heard(&self, names: &[Name]) -> Vec<usize> {
        let mut heard: Vec<usize> = (0..self.all.len()).filter(|at| self.all[*at].count.0 > 0).collect();
        let key = |at: &usize| {
            let tally = &self.all[*at];
            (std::cmp::Reverse(tally.count.0), names[tally.last_series as usize].clone())
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
