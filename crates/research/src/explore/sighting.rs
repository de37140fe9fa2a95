//! A detection in 32 bytes.
//!
//! Detections are gathered in pieces that know the names of their own tags: a piece that is forgotten takes its names with it.

use crate::quality::{CLOCK_OFF, CLOCK_WRONG, marks};
use detections::{Detection, Listening, Maker, Origin, Protocol, TagFilter};
use std::collections::BTreeMap;

/// As much memory as a name takes, in detections.
const NAME_WEIGHT: usize = 4;
/// Latitude or longitude where it is unknown.
pub(super) const NOWHERE: i32 = i32::MIN;

/// A detection, reduced for plots.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sighting {
    /// By the receiver's clock where that is set, else as it was reported.
    pub(super) time_us: i64,
    pub(super) reported_us: i64,
    /// 1e-7 degrees, which is a centimetre.
    pub(super) lat_e7: i32,
    pub(super) lon_e7: i32,
    /// Which tag by which receiver: its place among the names of its piece.
    pub(super) name: u32,
    pub(super) vessel: u16,
    /// Bits of [`crate::quality::MARKS`].
    pub(super) marks: u8,
}

/// How a receiver listened from a moment on.
#[derive(Debug, Clone, Copy)]
pub(super) struct Listened {
    pub(super) reported_us: i64,
    pub(super) vessel: u16,
    pub(super) entity: u8,
    pub(super) on: bool,
}

/// A tag by a receiver.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Name {
    pub(super) protocol: Protocol,
    pub(super) tag_id: u32,
    pub(super) khz: Option<u8>,
    pub(super) receiver: (u32, Option<Maker>),
}

/// A piece of the detections of a time, and how receivers listened, the newest report first. It does not change.
#[derive(Debug, Clone, Default)]
pub struct Sightings {
    pub(super) names: Vec<Name>,
    pub(super) rows: Vec<Sighting>,
    pub(super) listened: Vec<Listened>,
}

/// Gathers [`Sightings`].
#[derive(Debug, Default)]
pub struct SightingsBuilder {
    places: BTreeMap<Name, u32>,
    kept: Sightings,
}

impl SightingsBuilder {
    /// Takes a detection, the next older one.
    pub fn push(&mut self, one: &Detection) {
        let name = self.name(one);
        let e7 = |deg: f64| (deg * 1e7).round() as i32;
        let place = one.pose.map(|pose| (e7(pose.place.lat_deg()), e7(pose.place.lon_deg())));
        let (lat_e7, lon_e7) = place.unwrap_or((NOWHERE, NOWHERE));
        self.kept.rows.push(Sighting {
            time_us: one.clock.utc().unwrap_or(one.origin.reported).micros(),
            reported_us: one.origin.reported.micros(),
            lat_e7,
            lon_e7,
            name,
            vessel: one.origin.system.0,
            marks: marks(one),
        });
    }

    /// Takes a receiver's report of how it listens, newest first.
    pub fn listen(&mut self, origin: Origin, told: Listening) {
        let Origin { system, entity, reported, .. } = origin;
        self.kept.listened.push(Listened {
            reported_us: reported.micros(),
            vessel: system.0,
            entity,
            on: told.on,
        });
    }

    /// The gathered detections, in no more memory than they need.
    pub fn finish(mut self) -> Sightings {
        self.kept.names.shrink_to_fit();
        self.kept.rows.shrink_to_fit();
        self.kept.listened.shrink_to_fit();
        self.kept
    }

    /// The number of a detection's tag by its receiver.
    fn name(&mut self, one: &Detection) -> u32 {
        let name = Name {
            protocol: one.protocol.clone(),
            tag_id: one.tag_id,
            khz: one.frequency_khz,
            receiver: (one.receiver, one.maker),
        };
        let names = &mut self.kept.names;
        *self.places.entry(name).or_insert_with_key(|name| {
            names.push(name.clone());
            (names.len() - 1) as u32
        })
    }
}

impl Sightings {
    /// How much memory they take, in detections of 32 bytes: names count as four.
    pub fn weight(&self) -> usize {
        self.rows.len() + self.listened.len() + NAME_WEIGHT * self.names.len()
    }
}

/// Pieces read together: the same tag by the same receiver has one number in all of them.
pub(super) struct Pieces<'s> {
    pub(super) names: Vec<&'s Name>,
    pieces: Vec<(&'s Sightings, Vec<usize>)>,
}

impl<'s> Pieces<'s> {
    pub(super) fn new(all: &[&'s Sightings]) -> Self {
        let (mut names, mut places) = (Vec::new(), BTreeMap::new());
        let mut number = |name: &'s Name| {
            *places.entry(name).or_insert_with(|| {
                names.push(name);
                names.len() - 1
            })
        };
        let pieces =
            all.iter().map(|piece| (*piece, piece.names.iter().map(&mut number).collect())).collect();
        Self { names, pieces }
    }

    /// Every detection with the number of its tag by its receiver, piece by piece.
    pub(super) fn rows(&self) -> impl Iterator<Item = (usize, &'s Sighting)> {
        self.pieces.iter().flat_map(|(piece, series)| {
            // A row's name is one of its piece.
            piece.rows.iter().filter_map(|row| Some((*series.get(row.name as usize)?, row)))
        })
    }

    /// How receivers listened; the reports of each, the newest first.
    pub(super) fn listened(&self) -> impl Iterator<Item = &'s Listened> {
        self.pieces.iter().flat_map(|(piece, _)| &piece.listened)
    }
}

impl Name {
    /// The tag as people write it.
    pub(super) fn tag(&self) -> String {
        format!("{}-{}", self.protocol, self.tag_id)
    }

    pub(super) fn is_admitted(&self, tags: &[TagFilter]) -> bool {
        tags.is_empty() || tags.iter().any(|tag| tag.admits_code(&self.protocol, self.tag_id))
    }
}

impl Sighting {
    /// When, for plots: not by a clock that is off.
    pub(super) fn plotted_us(&self) -> i64 {
        if self.marks & CLOCK_OFF == 0 { self.time_us } else { self.reported_us }
    }

    /// Whether the receiver's clock was not set, lost, or far from the vessel's: either may be wrong.
    pub(super) fn is_clock_wrong(&self) -> bool {
        self.marks & CLOCK_WRONG != 0
    }

    /// Degrees, north and east positive.
    pub(super) fn place(&self) -> Option<(f64, f64)> {
        (self.lat_e7 != NOWHERE).then(|| (f64::from(self.lat_e7) / 1e7, f64::from(self.lon_e7) / 1e7))
    }
}
