//! Detections of vessels by stretches of some days, kept in memory as long as there is room.
//!
//! Each vessel's stretch is kept separately, so that a user's query is not limited by vessels that they may not see. The
//! least recently requested stretches are evicted first. Within one query newer stretches take precedence, and all its
//! vessels reach back equally far. Names of tags are part of a stretch and evicted with it.
//!
//! It does no reading itself and has no clock: a reader [`Shelf::begin`]s a stretch and passes it page by page to
//! [`Shelf::take`].

use research::Sightings;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use std::time::{Duration, Instant};
use store::TimeRange;
use units::UtcTime;

/// A vessel's stretch: when the stretch begins (µs), and the vessel.
type Key = (i64, u16);

/// Longest stretch (µs); a stretch also ends with its month. So some days can be served of a month that does not fit as a
/// whole. The last stretch of data without a plausible time, decades before and after all months, reaches to its end.
const STRETCH_US: i64 = 4 * 86_400_000_000;
/// Most stretches of a month. They share one version: one more message has all of them read again.
const STRETCHES: u32 = 8;

/// The scope of a query.
#[derive(Debug, Clone)]
pub(super) struct Wanted {
    /// Stretches, the newest first, with the version of the history.
    pub(super) stretches: Vec<(TimeRange, u64)>,
    /// By address.
    pub(super) vessels: BTreeSet<u16>,
}

/// Vessels of a stretch that are to be read.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Unread {
    pub(super) stretch: TimeRange,
    version: u64,
    vessels: BTreeSet<u16>,
    /// All vessels of the query.
    asked_for: BTreeSet<u16>,
}

/// What the shelf has of the stretches of a query.
#[derive(Debug)]
pub(super) struct Found {
    /// Of each vessel the newest first.
    pub(super) pieces: Vec<Arc<Sightings>>,
    /// Complete from then on so far; the rest is being read.
    pub(super) read_from_us: Option<i64>,
    /// Complete from then on; there is no room for the rest.
    pub(super) left_out_before_us: Option<i64>,
}

/// The outcome of adding a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kept {
    /// It is kept.
    All,
    /// There is no room for it: the stretch is cut before it.
    NoRoom,
    /// There is no room for it beside other vessels of the query: read the stretch again from its end, with all of them, so
    /// that they reach back equally far.
    Again,
}

/// A vessel's stretch, as far as it is read.
#[derive(Debug, Clone)]
struct Stretch {
    /// Version of the history that was read.
    version: u64,
    /// The newest first.
    pieces: Vec<Arc<Sightings>>,
    reach: Reach,
    /// The last query that covered it.
    asked: u64,
    /// The query for which it was read.
    read_for: u64,
    /// When it was read, and how long that took.
    read: Option<(Instant, Duration)>,
}

/// How far a stretch is read.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Reach {
    /// All of it.
    Whole,
    /// From this time on (µs); a reader is working on it.
    From(i64),
    /// From this time on (µs); there was no room for more.
    Cut(i64),
}

/// A stretch that is being read.
#[derive(Debug)]
pub(super) struct Reading {
    of: Unread,
    asked: u64,
    begun: Instant,
    fresh: BTreeMap<u16, Stretch>,
}

/// Vessels' stretches.
#[derive(Debug)]
pub(super) struct Shelf {
    /// How much it holds (`Sightings::weight`).
    most: usize,
    /// A stretch is read again at the earliest after the reading time of its whole month multiplied by this, as its
    /// stretches share one version.
    rest: u32,
    stretches: BTreeMap<Key, Stretch>,
    /// Counts queries.
    asked: u64,
}

impl Stretch {
    fn weight(&self) -> usize {
        self.pieces.iter().map(|piece| piece.weight()).sum()
    }
}

impl Reading {
    pub(super) fn stretch(&self) -> TimeRange {
        self.of.stretch
    }

    pub(super) fn vessels(&self) -> impl Iterator<Item = u16> {
        self.of.vessels.iter().copied()
    }
}

impl Shelf {
    pub(super) fn new(most: usize, rest: u32) -> Self {
        Self { most, rest, stretches: BTreeMap::new(), asked: 0 }
    }

    /// Registers a query for stretches; returns its number.
    pub(super) fn ask(&mut self, wanted: &Wanted) -> u64 {
        self.asked += 1;
        for key in wanted.keys() {
            if let Some(stretch) = self.stretches.get_mut(&key) {
                stretch.asked = self.asked;
            }
        }
        self.asked
    }

    /// The stretches of a query that are to be read, the newest first.
    pub(super) fn unread(&self, wanted: &Wanted, asked: u64, now: Instant) -> Vec<Unread> {
        let own: BTreeSet<Key> = wanted.keys().collect();
        let others: Vec<&Stretch> =
            self.stretches.iter().filter(|(key, _)| !own.contains(key)).map(|(_, stretch)| stretch).collect();
        let mut all = Vec::new();
        for (stretch, version) in &wanted.stretches {
            let is_read = |vessel: &u16| {
                let Some(known) = self.stretches.get(&(stretch.from_us, *vessel)) else { return false };
                let is_new = known.version == *version;
                match known.reach {
                    Reach::From(_) => false,
                    Reach::Cut(_) => {
                        known.read_for == asked
                            || !self.may_grow((stretch.from_us, known), is_new, &others, now)
                    }
                    Reach::Whole => is_new || !self.is_rested(stretch.from_us, known, now),
                }
            };
            let mut vessels: BTreeSet<u16> =
                wanted.vessels.iter().copied().filter(|vessel| !is_read(vessel)).collect();
            let is_cut = self.is_cut(*stretch, &wanted.vessels);
            if vessels.is_empty() && is_cut {
                break;
            }
            if is_cut {
                vessels.clone_from(&wanted.vessels);
            }
            if !vessels.is_empty() {
                let asked_for = wanted.vessels.clone();
                all.push(Unread { stretch: *stretch, version: *version, vessels, asked_for });
            }
        }
        all
    }

    /// Whether a cut stretch may become longer when it is read again: there is room in stretches that no query covered
    /// since. Those that other queries covered since are kept, or two queries that do not fit together would evict each
    /// other endlessly.
    fn may_grow(
        &self,
        (from_us, known): (i64, &Stretch),
        is_new: bool,
        others: &[&Stretch],
        now: Instant,
    ) -> bool {
        let is_idle = |other: &&Stretch| other.asked <= known.read_for;
        others.iter().any(is_idle) || (self.is_rested(from_us, known, now) && (!is_new || !others.is_empty()))
    }

    fn is_rested(&self, from_us: i64, known: &Stretch, now: Instant) -> bool {
        let Some((at, _)) = known.read else { return true };
        now.saturating_duration_since(at) >= self.month_took(from_us).saturating_mul(self.rest)
    }

    /// How long all stretches of this month took to read.
    fn month_took(&self, from_us: i64) -> Duration {
        let month = |us: i64| {
            let civil = UtcTime::from_micros(us).civil();
            (civil.year, civil.month)
        };
        let far_us = i64::from(STRETCHES) * STRETCH_US;
        let near = (from_us.saturating_sub(far_us), 0)..=(from_us.saturating_add(far_us), u16::MAX);
        let mut took = BTreeMap::<i64, Duration>::new();
        for ((begin_us, _), one) in self.stretches.range(near) {
            if let Some((_, of_one)) = one.read.filter(|_| month(*begin_us) == month(from_us)) {
                // Its vessels are read together.
                let known = took.entry(*begin_us).or_default();
                *known = of_one.max(*known);
            }
        }
        took.into_values().fold(Duration::ZERO, Duration::saturating_add)
    }

    fn is_cut(&self, stretch: TimeRange, vessels: &BTreeSet<u16>) -> bool {
        let known = |vessel: &u16| self.stretches.get(&(stretch.from_us, *vessel));
        vessels.iter().filter_map(known).any(|known| matches!(known.reach, Reach::Cut(_)))
    }

    /// What the shelf has for a query.
    pub(super) fn found(&self, wanted: &Wanted) -> Found {
        let mut found = Found { pieces: Vec::new(), read_from_us: None, left_out_before_us: None };
        for (stretch, _) in &wanted.stretches {
            let (mut read_from_us, mut left_out_before_us) = (None, None);
            for vessel in &wanted.vessels {
                let known = self.stretches.get(&(stretch.from_us, *vessel));
                found.pieces.extend(known.into_iter().flat_map(|known| known.pieces.iter().cloned()));
                match known.map_or(Reach::From(stretch.to_us), |known| known.reach) {
                    Reach::Whole => {}
                    Reach::From(from_us) => read_from_us = read_from_us.max(Some(from_us)),
                    Reach::Cut(from_us) => left_out_before_us = left_out_before_us.max(Some(from_us)),
                }
            }
            if read_from_us.is_some() || left_out_before_us.is_some() {
                (found.read_from_us, found.left_out_before_us) = (read_from_us, left_out_before_us);
                break;
            }
        }
        found
    }

    /// Begins to read vessels of a stretch. An old stretch is kept until then if it is complete, and dropped otherwise.
    pub(super) fn begin(&mut self, of: Unread, asked: u64, now: Instant) -> Reading {
        let stretch = of.stretch;
        self.stretches.retain(|(from_us, vessel), known| {
            *from_us != stretch.from_us || !of.vessels.contains(vessel) || known.reach == Reach::Whole
        });
        let fresh = |vessel: &u16| {
            let (pieces, reach) = (Vec::new(), Reach::From(stretch.to_us));
            (*vessel, Stretch { version: of.version, pieces, reach, asked, read_for: asked, read: None })
        };
        let fresh = of.vessels.iter().map(fresh).collect();
        Reading { of, asked, begun: now, fresh }
    }

    /// Takes the next older page of a stretch, by vessel; with it the stretch is complete from `whole_from_us` on, or
    /// entirely if that is `None`.
    pub(super) fn take(
        &mut self,
        reading: &mut Reading,
        pieces: BTreeMap<u16, Arc<Sightings>>,
        whole_from_us: Option<i64>,
        now: Instant,
    ) -> Kept {
        let weight = pieces.values().map(|piece| piece.weight()).sum();
        if !self.has_room_beside(reading, weight) {
            if reading.of.vessels != reading.of.asked_for {
                self.begin_again(reading, now);
                return Kept::Again;
            }
            for stretch in reading.fresh.values_mut() {
                if let Reach::From(from_us) = stretch.reach {
                    stretch.reach = Reach::Cut(from_us);
                }
            }
            self.keep(reading, now);
            return Kept::NoRoom;
        }
        for (vessel, piece) in pieces {
            if let Some(stretch) = reading.fresh.get_mut(&vessel) {
                stretch.pieces.push(piece);
            }
        }
        for stretch in reading.fresh.values_mut() {
            stretch.reach = whole_from_us.map_or(Reach::Whole, Reach::From);
        }
        self.keep(reading, now);
        Kept::All
    }

    /// Starts over, with all vessels of the query.
    fn begin_again(&mut self, reading: &mut Reading, now: Instant) {
        let of = Unread { vessels: reading.of.asked_for.clone(), ..reading.of.clone() };
        self.stretches
            .retain(|(from_us, vessel), _| *from_us != of.stretch.from_us || !of.vessels.contains(vessel));
        *reading = self.begin(of, reading.asked, now);
    }

    /// Keeps what was read of a stretch. It replaces an old one, unless the old one is complete and this one is not yet.
    fn keep(&mut self, reading: &mut Reading, now: Instant) {
        for (vessel, fresh) in &mut reading.fresh {
            let key = (reading.of.stretch.from_us, *vessel);
            let before = self.stretches.get(&key);
            let is_done = !matches!(fresh.reach, Reach::From(_));
            if is_done {
                fresh.read = Some((now, now.saturating_duration_since(reading.begun)));
            }
            if is_done || before.is_none_or(|before| before.reach != Reach::Whole) {
                let asked = before.map_or(fresh.asked, |before| before.asked.max(fresh.asked));
                self.stretches.insert(key, Stretch { asked, ..fresh.clone() });
            }
        }
    }

    /// Whether there is room for `weight` more of a stretch, beside its old version or in place of that.
    fn has_room_beside(&mut self, reading: &Reading, weight: usize) -> bool {
        let stretch_us = reading.of.stretch.from_us;
        let is_stale = |shelf: &Self, vessel: &u16| {
            shelf.stretches.get(&(stretch_us, *vessel)).is_some_and(|known| known.reach == Reach::Whole)
        };
        let stale: Vec<u16> = reading.vessels().filter(|vessel| is_stale(self, vessel)).collect();
        // The replacement is not on the shelf yet.
        let beside: usize = stale.iter().map(|vessel| reading.fresh[vessel].weight()).sum();
        if self.has_room(beside + weight, reading) {
            return true;
        }
        for vessel in stale {
            self.stretches.remove(&(stretch_us, vessel));
        }
        self.has_room(beside + weight, reading)
    }

    /// Makes room by evicting stretches that this query does not cover, then its older ones; returns whether there is room.
    fn has_room(&mut self, weight: usize, reading: &Reading) -> bool {
        let mut there: usize = self.stretches.values().map(Stretch::weight).sum();
        let from_us = reading.of.stretch.from_us;
        // A repeated query gives all its stretches a newer number.
        let own = reading.vessels().filter_map(|vessel| self.stretches.get(&(from_us, vessel)));
        let newest = own.map(|stretch| stretch.asked).fold(reading.asked, u64::max);
        while there + weight > self.most {
            let is_less = |(key, stretch): &(&Key, &Stretch)| {
                stretch.asked < reading.asked
                    || ([reading.asked, newest].contains(&stretch.asked) && key.0 < from_us)
            };
            let others = self.stretches.iter().filter(is_less);
            let Some(key) = others.min_by_key(|(key, stretch)| (stretch.asked, key.0)).map(|(key, _)| *key)
            else {
                return false;
            };
            there -= self.stretches.remove(&key).map_or(0, |stretch| stretch.weight());
        }
        true
    }
}

impl Wanted {
    /// The parts of these months within a range, the oldest first; each with the time of its first data, and its version.
    pub(super) fn new(
        months: impl DoubleEndedIterator<Item = (TimeRange, TimeRange, u64)>,
        range: TimeRange,
        vessels: BTreeSet<u16>,
    ) -> Self {
        let of = |(month, heard, version): (TimeRange, TimeRange, u64)| {
            let is_wanted = move |one: &TimeRange| !one.within(range).within(heard).is_empty();
            stretches(month).filter(is_wanted).map(move |one| (one, version))
        };
        Self { stretches: months.rev().flat_map(of).collect(), vessels }
    }

    /// All its vessels' stretches.
    fn keys(&self) -> impl Iterator<Item = Key> {
        let of = |(stretch, _): &(TimeRange, u64)| {
            let from_us = stretch.from_us;
            self.vessels.iter().map(move |vessel| (from_us, *vessel))
        };
        self.stretches.iter().flat_map(of)
    }
}

/// A month in stretches, the newest first. Their bounds do not depend on the query, so that queries share them.
fn stretches(month: TimeRange) -> impl Iterator<Item = TimeRange> {
    let begins = (0..i64::from(STRETCHES)).map(move |at| month.from_us.saturating_add(at * STRETCH_US));
    let ends = begins.clone().skip(1).chain([month.to_us]);
    let stretch = move |(from_us, to_us): (i64, i64)| TimeRange { from_us, to_us }.within(month);
    let all: Vec<TimeRange> = begins.zip(ends).map(stretch).filter(|one| !one.is_empty()).collect();
    all.into_iter().rev()
}

#[cfg(test)]
#[path = "shelf_tests.rs"]
mod tests;
