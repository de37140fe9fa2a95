//! A detection in 32 bytes.

use crate::quality::{CLOCK_OFF, marks};
use detections::{Detection, Listening, Origin, Protocol, TagFilter};
use std::collections::BTreeMap;

/// Tags by receivers that have names; those beyond are not taken in.
const SERIES: usize = 100_000;
/// Latitude or longitude where nobody knows it.
pub(super) const NOWHERE: i32 = i32::MIN;

/// What a plot needs of a detection.
#[derive(Debug, Clone, Copy)]
pub(super) struct Sighting {
    /// By the receiver's clock where that is set, else as it was reported.
    pub(super) time_us: i64,
    pub(super) reported_us: i64,
    /// 1e-7 degrees, which is a centimetre.
    pub(super) lat_e7: i32,
    pub(super) lon_e7: i32,
    /// Which tag by which receiver: its place in [`Names`].
    pub(super) series: u32,
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
    pub(super) khz: u8,
    pub(super) receiver: u32,
}

/// Names of tags by receivers, for the numbers that stand for them. It only grows, up to 100,000.
#[derive(Debug, Clone, Default)]
pub struct Names {
    pub(super) all: Vec<Name>,
    places: BTreeMap<Name, u32>,
}

/// Detections, and how receivers listened, the newest report first.
#[derive(Debug, Clone, Default)]
pub struct Sightings {
    pub(super) rows: Vec<Sighting>,
    pub(super) listened: Vec<Listened>,
}

impl Names {
    /// The number of a detection's tag by its receiver; `None` where there is no room for one more.
    fn of(&mut self, one: &Detection) -> Option<u32> {
        let name = Name {
            protocol: one.protocol.clone(),
            tag_id: one.tag_id,
            khz: one.frequency_khz,
            receiver: one.receiver,
        };
        if let Some(place) = self.places.get(&name) {
            return Some(*place);
        }
        let place = u32::try_from(self.all.len()).ok().filter(|_| self.all.len() < SERIES)?;
        self.all.push(name.clone());
        self.places.insert(name, place);
        Some(place)
    }
}

impl Sightings {
    /// Takes a detection, the next older one; `false` where `names` has no room for its tag.
    pub fn push(&mut self, names: &mut Names, one: &Detection) -> bool {
        let Some(series) = names.of(one) else { return false };
        let e7 = |deg: f64| (deg * 1e7).round() as i32;
        let place = one.pose.map(|pose| (e7(pose.place.lat_deg()), e7(pose.place.lon_deg())));
        let (lat_e7, lon_e7) = place.unwrap_or((NOWHERE, NOWHERE));
        self.rows.push(Sighting {
            time_us: one.clock.utc().unwrap_or(one.origin.reported).micros(),
            reported_us: one.origin.reported.micros(),
            lat_e7,
            lon_e7,
            series,
            vessel: one.origin.system.0,
            marks: marks(one),
        });
        true
    }

    /// Takes what a receiver told of how it listens, the next older one.
    pub fn listen(&mut self, origin: Origin, told: Listening) {
        let Origin { system, entity, reported, .. } = origin;
        self.listened.push(Listened {
            reported_us: reported.micros(),
            vessel: system.0,
            entity,
            on: told.on,
        });
    }

    /// How many there are of both.
    pub fn len(&self) -> usize {
        self.rows.len() + self.listened.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
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

    /// Degrees, north and east positive.
    pub(super) fn place(&self) -> Option<(f64, f64)> {
        (self.lat_e7 != NOWHERE).then(|| (f64::from(self.lat_e7) / 1e7, f64::from(self.lon_e7) / 1e7))
    }
}
