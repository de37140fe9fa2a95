//! Water that is prepared and kept: for which needs and zones, of which part of the chart.

use crate::needs::Needs;
use crate::plane::Plane;
use crate::room::{FAR_M, SeaRoom};
use crate::tile::Tiles;
use crate::zones::Zones;
use crate::{Cancel, PlanError};
use charts::depth_index::DepthIndex;
use std::sync::{Arc, Mutex, PoisonError};
use units::LatLon;

/// So many rooms are kept unless fewer are asked for; the room that was not used for longest goes first.
const MOST_ROOMS: usize = 8;
/// All rooms together take no more memory, except for the room that was asked for last (bytes). With the portals of tiles
/// ([`crate::known`]) that is 96 MiB.
const MOST_BYTES: usize = 80 << 20;

/// A part of the chart.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Water {
    /// All of it.
    Whole,
    /// A square region.
    Square(Square),
    /// Tiles of the plane of a long way.
    Tiles(Tiles),
}

/// A square region around a middle on a coarse grid, so that requests near each other share it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Square {
    pub(crate) middle: LatLon,
    pub(crate) half_m: f64,
}

impl Square {
    /// The square of this size for two ends.
    pub(crate) fn between(ends: [LatLon; 2], half_m: f64) -> Self {
        Self { middle: coarse_middle(ends, half_m / 8.0), half_m }
    }
}

/// The place of a grid of so many metres that is nearest to the middle between two places.
pub(crate) fn coarse_middle([from, to]: [LatLon; 2], step_m: f64) -> LatLon {
    // The same both ways: the plane of one end gives another middle than that of the other.
    let order = |place: &LatLon| (place.lat_rad().to_bits(), place.lon_rad().to_bits());
    let [from, to] = if order(&to) < order(&from) { [to, from] } else { [from, to] };
    let plane = Plane::new(from);
    let middle = plane.place(plane.point(from).towards(plane.point(to), 0.5));
    let step_deg = step_m / 111_000.0;
    let lat_deg = ((middle.lat_deg() / step_deg).round() * step_deg).clamp(-90.0, 90.0);
    // Of the grid's latitude: by the middle's own latitude each request would have a grid of its own.
    let lon_step_deg = step_deg / lat_deg.to_radians().cos().max(0.05);
    let lon_deg = ((middle.lon_deg() / lon_step_deg).round() * lon_step_deg).clamp(-180.0, 180.0);
    LatLon::from_deg(lat_deg, lon_deg).unwrap_or(middle)
}

/// Water that was prepared on one chart, to be prepared on the next one too ([`crate::Router::prepared`]).
#[derive(Debug, Clone, PartialEq)]
pub struct Prepared {
    needs: Needs,
    zones: Arc<Zones>,
    water: Water,
}

impl Prepared {
    pub(crate) fn needs(&self) -> &Needs {
        &self.needs
    }

    pub(crate) fn is_whole(&self) -> bool {
        self.water == Water::Whole
    }

    pub(crate) fn square(&self) -> Option<&Square> {
        match &self.water {
            Water::Square(square) => Some(square),
            Water::Whole | Water::Tiles(_) => None,
        }
    }
}

/// Rooms on one chart; clones share what is kept.
#[derive(Debug, Clone)]
pub(crate) struct Rooms {
    pub(crate) index: Arc<DepthIndex>,
    pub(crate) zones: Arc<Zones>,
    most: usize,
    kept: Arc<Mutex<Vec<Kept>>>,
}

#[derive(Debug, Clone)]
struct Kept {
    needs: Needs,
    zones: Arc<Zones>,
    water: Water,
    room: Arc<SeaRoom>,
}

impl Rooms {
    pub(crate) fn new(index: Arc<DepthIndex>) -> Self {
        Self { index, zones: Arc::default(), most: MOST_ROOMS, kept: Arc::default() }
    }

    /// With so many rooms kept at most, and never less than one.
    pub(crate) fn keeping(self, most: usize) -> Self {
        Self { most: most.max(1), ..self }
    }

    pub(crate) fn in_zones(&self, zones: Zones) -> Self {
        Self { zones: Arc::new(zones), ..self.clone() }
    }

    /// How many rooms are kept, and about how much memory they take (bytes).
    pub(crate) fn held(&self) -> (usize, usize) {
        let kept = self.lock();
        (kept.len(), bytes(&kept))
    }

    /// The water for these needs, prepared now if it is not kept.
    pub(crate) fn room(
        &self,
        needs: &Needs,
        water: Water,
        cancel: &Cancel<'_>,
    ) -> Result<Arc<SeaRoom>, PlanError> {
        if let Some((_, room)) = self.kept(needs, |kept| *kept == water) {
            return Ok(room);
        }
        let room = Arc::new(self.prepare(needs, &water, cancel)?);
        let mut kept = self.lock();
        // Only now: a preparation that is called off pushes no other room out.
        let one_more = |kept: &[Kept]| {
            kept.len() >= self.most || !kept.is_empty() && bytes(kept) + room.bytes() > MOST_BYTES
        };
        drop_while(&mut kept, one_more);
        kept.push(Kept { needs: *needs, zones: Arc::clone(&self.zones), water, room: Arc::clone(&room) });
        Ok(room)
    }

    /// Water that is kept for these needs, if some is what is wanted.
    pub(crate) fn kept(
        &self,
        needs: &Needs,
        wanted: impl Fn(&Water) -> bool,
    ) -> Option<(Water, Arc<SeaRoom>)> {
        let mut kept = self.lock();
        let at = kept
            .iter()
            .position(|one| one.needs == *needs && one.zones == self.zones && wanted(&one.water))?;
        let used = kept.remove(at);
        kept.push(used.clone());
        Some((used.water, used.room))
    }

    /// What is kept, the water that was asked for last first; without that of long ways, which takes much longer.
    pub(crate) fn prepared(&self) -> Vec<Prepared> {
        let of = |Kept { needs, zones, water, .. }: &Kept| match water {
            Water::Whole | Water::Square(_) => {
                Some(Prepared { needs: *needs, zones: Arc::clone(zones), water: water.clone() })
            }
            Water::Tiles(_) => None,
        };
        self.lock().iter().rev().filter_map(of).collect()
    }

    /// Prepares water before it is asked for, in room that is left: it pushes nothing out, and goes first itself. Whether it was
    /// prepared.
    pub(crate) fn prepare_early(&self, wanted: &Prepared, cancel: &Cancel<'_>) -> Result<bool, PlanError> {
        let Prepared { needs, zones, water } = wanted;
        let has = |kept: &[Kept]| {
            kept.iter().any(|one| one.needs == *needs && one.zones == *zones && one.water == *water)
        };
        let is_full = |kept: &[Kept]| kept.len() >= self.most || bytes(kept) >= MOST_BYTES;
        {
            let kept = self.lock();
            if has(&kept) || is_full(&kept) {
                return Ok(false);
            }
        }
        let its = Self { zones: Arc::clone(zones), ..self.clone() };
        let room = Arc::new(its.prepare(needs, water, cancel)?);
        let mut kept = self.lock();
        if has(&kept) || is_full(&kept) || bytes(&kept) + room.bytes() > MOST_BYTES {
            return Ok(false);
        }
        kept.insert(0, Kept { needs: *needs, zones: Arc::clone(zones), water: water.clone(), room });
        Ok(true)
    }

    /// Drops rooms after one has learned, and so grown.
    pub(crate) fn keep_within_bounds(&self) {
        drop_while(&mut self.lock(), |kept| kept.len() > 1 && bytes(kept) > MOST_BYTES);
    }

    /// Water that is kept, in which a search was long and nothing was learned yet.
    pub(crate) fn to_learn(&self) -> Option<Arc<SeaRoom>> {
        let kept = self.lock();
        kept.iter().rev().find(|one| one.room.learned.is_wanted()).map(|one| Arc::clone(&one.room))
    }

    /// The water for these needs; it is not kept.
    pub(crate) fn prepare(
        &self,
        needs: &Needs,
        water: &Water,
        cancel: &Cancel<'_>,
    ) -> Result<SeaRoom, PlanError> {
        let both = (needs, &self.zones);
        match water {
            Water::Whole => SeaRoom::of_chart(&self.index, needs, &self.zones, cancel),
            Water::Square(Square { middle, half_m }) => {
                SeaRoom::around(&self.index, both, *middle, (*half_m, *half_m), cancel)
            }
            Water::Tiles(tiles) => SeaRoom::of_tiles(&self.index, both, (tiles, FAR_M), cancel),
        }
    }

    fn lock(&self) -> std::sync::MutexGuard<'_, Vec<Kept>> {
        self.kept.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Drops the rooms that were not used for longest, as long as there are too many.
fn drop_while(kept: &mut Vec<Kept>, is_too_much: impl Fn(&[Kept]) -> bool) {
    while is_too_much(kept) {
        // What a question works with stays: it may have up to three.
        let unused = kept.iter().position(|one| Arc::strong_count(&one.room) == 1);
        let Some(unused) = unused else { break };
        kept.remove(unused);
    }
}

fn bytes(kept: &[Kept]) -> usize {
    kept.iter().map(|one| one.room.bytes()).sum()
}
