//! The summary of many detections.

use super::count::{Bars, Flags, Pair, Slot, Steps, Tallies, add};
use super::effort::each_listened;
use super::lags::AllLags;
use super::sighting::{Name, Pieces, Sighting, Sightings};
use super::squares::{Bounds, Squares};
use crate::lag::{HORIZON_S, Lag};
use crate::narrowed::Narrowed;
use crate::study::{Study, confirming_s, is_doubted, is_of_time};
use api::{DetectionsSummary, RegisterTag, SummaryTag, SummaryVessel};
use detections::TagFilter;
use std::collections::{BTreeMap, BTreeSet};

/// Tags with a row of their own.
const TAGS: usize = 100;
/// Of so many times and more a few can be seen to be far from the others.
const ENOUGH: usize = 20;
/// One of so many is few, at each end.
const FEW: usize = 1_000;
/// They stay outside where a plot without them is so many times shorter.
const FAR: i64 = 10;

/// Which detections are counted.
#[derive(Debug, Clone)]
pub struct Question {
    /// Vessels; what others heard is not there.
    pub vessels: BTreeSet<u16>,
    /// Reported from then on (µs since 1970 UTC).
    pub from_us: i64,
    /// Reported before.
    pub to_us: i64,
    /// Tags; all where empty.
    pub tags: Vec<TagFilter>,
    /// Projects and area.
    pub narrowed: Narrowed,
    /// Whether plots reach to all of them, also to a few by wrong clocks whose times are far from all others'.
    pub whole_axis: bool,
}

/// Counts the selected detections of `pieces`; those of each vessel follow each other, the newest first. Detections of a
/// day before and after the selected time confirm the first and last ones. Where not all are loaded, `whole_from_us` says
/// since when they are (µs, by report): earlier reports are left out, and no detection counts as unconfirmed that a
/// missing one may confirm.
pub fn summary(
    pieces: &[&Sightings],
    study: &Study,
    question: &Question,
    whole_from_us: Option<i64>,
) -> DetectionsSummary {
    let pieces = Pieces::new(pieces);
    let question = &Question {
        from_us: whole_from_us.map_or(question.from_us, |whole_us| whole_us.max(question.from_us)),
        ..question.clone()
    };
    let series: Vec<Series<'_>> =
        pieces.names.iter().map(|name| Series::new(name, study, question)).collect();
    let lags = AllLags::new(&pieces, |row| question.vessels.contains(&row.vessel));
    let (wanted, bounds) = wanted(&pieces, &series, question);
    let Some(span) = Span::of(&pieces, &wanted, question) else { return nothing() };
    let Span { first_us, last_us, outside, listened_outside_s } = span;
    let confirmed_from_us = whole_from_us.map(|whole_us| whole_us.saturating_add(HORIZON_S * 1_000_000));
    let mut counts = Counts {
        names: &pieces.names,
        tallies: Tallies::new(series.len()),
        bars: Bars::new(Steps::bars(first_us, last_us)),
        squares: Squares::new(&bounds),
        flags: Flags::default(),
        vessels: question.vessels.iter().map(|vessel| (*vessel, (0, None))).collect(),
    };
    let counted: Vec<(usize, bool)> = wanted
        .iter()
        .map(|one| {
            let is_near_edge = confirmed_from_us.is_some_and(|from_us| one.row.reported_us < from_us);
            let of = &series[one.series];
            let is_doubted = !is_near_edge && of.is_doubted(one.row.time_us, lags.lag(one.at));
            (counts.add(one, of, is_doubted), is_doubted)
        })
        .collect();
    counts.listen(&pieces, question);
    let steps = Steps::fine(first_us, last_us);
    let listed = counts.listed(&series, study, steps, &wanted, &counted);
    DetectionsSummary { outside, listened_outside_s, ..counts.told(wanted.len() as u64, steps, listed) }
}

/// A row that is wanted.
#[derive(Clone, Copy)]
pub(super) struct Wanted<'s> {
    /// Its number among all rows.
    at: usize,
    /// Which tag by which receiver.
    series: usize,
    pub(super) row: &'s Sighting,
}

/// Those that are wanted, and within which bounds they are.
pub(super) fn wanted<'s>(
    pieces: &Pieces<'s>,
    all_series: &[Series<'_>],
    question: &Question,
) -> (Vec<Wanted<'s>>, Bounds) {
    let (mut all, mut bounds) = (Vec::new(), Bounds::new());
    for (at, (series, row)) in pieces.rows().enumerate() {
        let is_wanted = (question.from_us..question.to_us).contains(&row.reported_us)
            && question.vessels.contains(&row.vessel)
            && all_series[series].is_wanted(row.time_us)
            && (!question.narrowed.has_area() || question.narrowed.admits_place(row.place()));
        if !is_wanted {
            continue;
        }
        if let Some(place) = row.place() {
            bounds.add(place);
        }
        all.push(Wanted { at, series, row });
    }
    (all, bounds)
}

/// From when to when plots reach (µs).
struct Span {
    first_us: i64,
    last_us: i64,
    /// Detections whose times lie outside.
    outside: u64,
    /// How long receivers listened outside (s).
    listened_outside_s: f64,
}

impl Span {
    /// Around all detections and all listening, for plots show that nothing was heard meanwhile; `None` where there is neither.
    ///
    /// A few whose times are far from all others' stay outside, so that the others remain visible: detections by a clock
    /// known to be wrong, and listening, whose clock is unknown. Detections by a good clock are always on the axis: the
    /// first week of a season may be a few detections far from all others.
    fn of(pieces: &Pieces<'_>, wanted: &[Wanted<'_>], question: &Question) -> Option<Self> {
        let mut times: Vec<i64> = wanted.iter().map(|one| one.row.plotted_us()).collect();
        each_stretch(pieces, question, |_, from_us, to_us| times.extend([from_us, to_us]));
        let all = Reach::around(times.iter().copied())?;
        let of_all = |reach: Reach| Self {
            first_us: reach.first_us,
            last_us: reach.last_us,
            outside: 0,
            listened_outside_s: 0.0,
        };
        if question.whole_axis || times.len() < ENOUGH {
            return Some(of_all(all));
        }
        let near = near(&mut times);
        let good = wanted.iter().filter(|one| !one.row.is_clock_wrong()).map(|one| one.row.plotted_us());
        let mut reach = Reach::around(times.into_iter().filter(|time_us| near.has(*time_us)).chain(good))?;
        // A stretch that lies on the axis in part lies on it.
        let on_axis = reach;
        each_stretch(pieces, question, |_, from_us, to_us| {
            if on_axis.touches(from_us, to_us) {
                reach = reach.with(from_us).with(to_us);
            }
        });
        if reach.length_us() > all.length_us() / FAR {
            return Some(of_all(all));
        }
        let outside = wanted.iter().filter(|one| !reach.has(one.row.plotted_us())).count() as u64;
        let mut listened_outside_s = 0.0;
        each_stretch(pieces, question, |_, from_us, to_us| {
            if !reach.touches(from_us, to_us) {
                listened_outside_s += (to_us - from_us) as f64 / 1e6;
            }
        });
        Some(Self { outside, listened_outside_s, ..of_all(reach) })
    }
}

/// Where times lie that are not far from most: no further from them than these reach. There are `ENOUGH`.
fn near(times: &mut [i64]) -> Reach {
    let few = (times.len() / FEW).max(1);
    let low_us = *times.select_nth_unstable(few).1;
    let high = times.len() - 1 - few;
    let high_us = *times.select_nth_unstable(high).1;
    let beside_us = high_us.saturating_sub(low_us);
    Reach { first_us: low_us.saturating_sub(beside_us), last_us: high_us.saturating_add(beside_us) }
}

/// From a time to another (µs), both of which belong to it.
#[derive(Debug, Clone, Copy)]
struct Reach {
    first_us: i64,
    last_us: i64,
}

impl Reach {
    fn around(times: impl Iterator<Item = i64>) -> Option<Self> {
        times.fold(None, |reach: Option<Self>, us| {
            Some(reach.map_or(Self { first_us: us, last_us: us }, |reach| reach.with(us)))
        })
    }

    fn with(self, us: i64) -> Self {
        Self { first_us: self.first_us.min(us), last_us: self.last_us.max(us) }
    }

    fn has(self, us: i64) -> bool {
        self.touches(us, us)
    }

    fn touches(self, from_us: i64, to_us: i64) -> bool {
        from_us <= self.last_us && to_us >= self.first_us
    }

    fn length_us(self) -> i64 {
        self.last_us.saturating_sub(self.first_us)
    }
}

/// Stretches in which receivers listened, of the vessels and the time asked for. Listening within an area is unknown, as
/// its reports have no position.
fn each_stretch(pieces: &Pieces<'_>, question: &Question, mut give: impl FnMut(u16, i64, i64)) {
    if question.narrowed.has_area() {
        return;
    }
    each_listened(
        pieces,
        |told| question.vessels.contains(&told.vessel),
        |vessel, from_us, to_us| {
            let (from_us, to_us) = (from_us.max(question.from_us), to_us.min(question.to_us));
            if from_us <= to_us {
                give(vessel, from_us, to_us);
            }
        },
    );
}

/// A tag by a receiver, with what the register knows of it.
pub(super) struct Series<'s> {
    is_asked: bool,
    /// Whether those without a project are wanted too.
    any_project: bool,
    /// Tags of its code, one after another.
    known: Vec<Known<'s>>,
}

/// A tag of the register.
struct Known<'s> {
    tag: &'s RegisterTag,
    /// Within how many seconds something must confirm it.
    within_s: Option<f64>,
    /// From when on an animal carries it (µs): its project is that of the animal only then.
    carried_us: i64,
    /// Whether it is wanted from then on.
    is_wanted: bool,
    /// Whether it is before.
    is_wanted_before: bool,
}

impl<'s> Series<'s> {
    pub(super) fn new(name: &Name, study: &'s Study, question: &Question) -> Self {
        let narrowed = &question.narrowed;
        let known = |tag: &'s RegisterTag| {
            let carrier = study.carrier(tag);
            let wanted = |animal| narrowed.admits_project(study.project(tag, animal));
            Known {
                tag,
                within_s: confirming_s(tag),
                carried_us: carrier.and_then(|(_, from_us)| from_us).unwrap_or(i64::MIN),
                is_wanted: wanted(carrier.map(|(animal, _)| animal)),
                is_wanted_before: wanted(None),
            }
        };
        let known = study.tags_of(&name.protocol.to_string(), name.tag_id, name.khz).map(known).collect();
        Self { is_asked: name.is_admitted(&question.tags), any_project: narrowed.admits_project(None), known }
    }

    /// Which tag of the register it is at a time, and whether an animal carries it then.
    fn slot(&self, time_us: i64) -> Slot {
        let at = self.known.iter().position(|known| is_of_time(known.tag, time_us))?;
        Some((at, self.known[at].carried_us <= time_us))
    }

    /// Whether detections of a time are wanted.
    fn is_wanted(&self, time_us: i64) -> bool {
        let of_project = |(at, is_carried): (usize, bool)| {
            let known = &self.known[at];
            if is_carried { known.is_wanted } else { known.is_wanted_before }
        };
        self.is_asked && (self.any_project || self.slot(time_us).is_some_and(of_project))
    }

    fn is_doubted(&self, time_us: i64, lag: Lag) -> bool {
        let within_s = self.slot(time_us).and_then(|(at, _)| self.known[at].within_s);
        within_s.is_some_and(|within_s| is_doubted(within_s, lag))
    }
}

/// The counts.
struct Counts<'s> {
    names: &'s [&'s Name],
    tallies: Tallies<'s>,
    bars: Bars,
    squares: Squares,
    flags: Flags,
    /// Detections, and seconds that its receivers listened.
    vessels: BTreeMap<u16, (u64, Option<f64>)>,
}

impl<'s> Counts<'s> {
    /// Counts a detection; the place of its tag among those that were heard.
    fn add(&mut self, one: &Wanted<'_>, series: &Series<'s>, is_doubted: bool) -> usize {
        let row = one.row;
        self.flags.add(row.marks, is_doubted);
        if let Some(at) = self.bars.steps.at(row.plotted_us()) {
            add(&mut self.bars.counts[at], is_doubted);
        }
        if let Some(place) = row.place() {
            self.squares.add(place);
        }
        if let Some((count, _)) = self.vessels.get_mut(&row.vessel) {
            *count += 1;
        }
        let slot = series.slot(row.time_us);
        let called = || slot.map(|(at, _)| &*series.known[at].tag.name);
        self.tallies.add((one.series, row), self.names[one.series], slot, called, is_doubted)
    }

    fn listen(&mut self, pieces: &Pieces<'_>, question: &Question) {
        let (bars, vessels) = (&mut self.bars, &mut self.vessels);
        each_stretch(pieces, question, |vessel, from_us, to_us| {
            bars.listen(from_us, to_us);
            if let Some((_, listened_s)) = vessels.get_mut(&vessel) {
                *listened_s.get_or_insert(0.0) += (to_us - from_us) as f64 / 1e6;
            }
        });
    }

    /// The tags that were heard most, with when, and how many tags there are.
    fn listed(
        &self,
        series: &[Series<'_>],
        study: &Study,
        steps: Steps,
        wanted: &[Wanted<'_>],
        counted: &[(usize, bool)],
    ) -> (Vec<SummaryTag>, usize) {
        let heard = self.tallies.heard(self.names);
        let mut rows: Vec<Option<usize>> = vec![None; self.tallies.all.len()];
        heard.iter().take(TAGS).enumerate().for_each(|(row, tag)| rows[*tag] = Some(row));
        let mut marks: Vec<Vec<Pair>> = vec![vec![(0, 0); steps.count]; heard.len().min(TAGS)];
        for (one, (tag, is_doubted)) in wanted.iter().zip(counted) {
            if let (Some(line), Some(at)) = (rows[*tag], steps.at(one.row.plotted_us())) {
                add(&mut marks[line][at], *is_doubted);
            }
        }
        let tag = |(tag, marks): (&usize, &Vec<Pair>)| self.tag(*tag, marks, series, study);
        (heard.iter().zip(&marks).map(tag).collect(), heard.len())
    }

    fn tag(&self, at: usize, marks: &[Pair], series: &[Series<'_>], study: &Study) -> SummaryTag {
        let tally = self.tallies.all[at];
        let (at, slot) = tally.example;
        let (name, known) = (self.names[at], slot.map(|(tag, carried)| (series[at].known[tag].tag, carried)));
        let tag = known.map(|(tag, _)| tag);
        let animal = known.filter(|(_, is_carried)| *is_carried).and_then(|(tag, _)| study.carrier(tag));
        let animal = animal.map(|(animal, _)| animal);
        let project = tag.and_then(|tag| study.project(tag, animal));
        let small = |count: u64| u32::try_from(count).unwrap_or(u32::MAX);
        let mark = |(at, pair): (usize, &Pair)| [small(at as u64), small(pair.0), small(pair.1)];
        SummaryTag {
            tag: name.tag(),
            tag_id: name.tag_id,
            name: tag.map(|tag| tag.name.clone()).unwrap_or_default(),
            animal: animal.map(|animal| animal.name.clone()).unwrap_or_default(),
            project: project.map(|project| project.name.clone()).unwrap_or_default(),
            detections: tally.count.0,
            unconfirmed: tally.count.1,
            first_us: tally.first_us,
            last_us: tally.last_us,
            marks: marks.iter().enumerate().filter(|(_, pair)| pair.0 > 0).map(mark).collect(),
        }
    }

    fn told(
        &self,
        detections: u64,
        steps: Steps,
        (tags, tags_all): (Vec<SummaryTag>, usize),
    ) -> DetectionsSummary {
        let (squares, square_m) = self.squares.told();
        let vessels =
            self.vessels.iter().filter(|(_, (count, listened_s))| *count > 0 || listened_s.is_some());
        let vessel = |(system, (detections, listened_s)): (&u16, &(u64, Option<f64>))| SummaryVessel {
            system: *system,
            detections: *detections,
            listened_s: *listened_s,
        };
        DetectionsSummary {
            detections,
            from_us: Some(steps.from_us),
            to_us: Some(steps.to_us()),
            step_us: steps.length_us,
            tags,
            tags_all: u32::try_from(tags_all).unwrap_or(u32::MAX),
            bar_us: self.bars.steps.length_us,
            bars: self.bars.told(),
            squares,
            square_m,
            vessels: vessels.map(vessel).collect(),
            flags: self.flags.told(),
            outside: 0,
            listened_outside_s: 0.0,
            left_out_before_us: None,
            confirmed_from_us: None,
            read_from_us: None,
        }
    }
}

/// The summary without detections or listening.
fn nothing() -> DetectionsSummary {
    DetectionsSummary {
        detections: 0,
        from_us: None,
        to_us: None,
        step_us: 1,
        tags: Vec::new(),
        tags_all: 0,
        bar_us: 1,
        bars: Vec::new(),
        squares: Vec::new(),
        square_m: 0.0,
        vessels: Vec::new(),
        flags: Vec::new(),
        outside: 0,
        listened_outside_s: 0.0,
        left_out_before_us: None,
        confirmed_from_us: None,
        read_from_us: None,
    }
}
