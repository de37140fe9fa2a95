//! Portals of tiles that were looked at, kept for the next long way.

use crate::needs::Needs;
use crate::portals::Portals;
use crate::tile::{Grid, Tile};
use crate::zones::Zones;
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// Portals take no more memory (bytes); those that were not used for longest go first. They are found again where needed.
const MOST_BYTES: usize = 16 << 20;

/// What portals are of.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Of {
    pub(crate) needs: Needs,
    pub(crate) zones: Arc<Zones>,
    pub(crate) grid: Grid,
}

/// Portals by what they are of and by tile; clones share them.
#[derive(Debug, Clone, Default)]
pub(crate) struct Known(Arc<Mutex<All>>);

#[derive(Debug, Default)]
struct All {
    groups: Vec<Group>,
    /// Counts questions: the number of the last one that used a tile says for how long it was not used.
    questions: u64,
    bytes: usize,
}

#[derive(Debug)]
struct Group {
    of: Of,
    tiles: BTreeMap<Tile, (u64, Arc<Portals>)>,
}

impl Known {
    pub(crate) fn get(&self, of: &Of, tile: Tile) -> Option<Arc<Portals>> {
        let mut all = self.lock();
        all.questions += 1;
        let now = all.questions;
        let group = all.groups.iter_mut().find(|group| group.of == *of)?;
        let (used, portals) = group.tiles.get_mut(&tile)?;
        *used = now;
        Some(Arc::clone(portals))
    }

    pub(crate) fn put(&self, of: &Of, tile: Tile, portals: &Arc<Portals>) {
        let mut all = self.lock();
        let now = all.questions;
        let at = all.groups.iter().position(|group| group.of == *of);
        let at = at.unwrap_or_else(|| {
            all.groups.push(Group { of: of.clone(), tiles: BTreeMap::new() });
            all.groups.len() - 1
        });
        all.bytes += portals.bytes();
        if let Some((_, old)) = all.groups[at].tiles.insert(tile, (now, Arc::clone(portals))) {
            all.bytes -= old.bytes();
        }
        while all.bytes > MOST_BYTES && all.forget_one() {}
    }

    /// How much memory they take (bytes).
    pub(crate) fn bytes(&self) -> usize {
        self.lock().bytes
    }

    fn lock(&self) -> MutexGuard<'_, All> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl All {
    /// Leaves out the tile that was not used for longest; `false` without tiles.
    fn forget_one(&mut self) -> bool {
        let used =
            self.groups.iter().enumerate().flat_map(|(group, held)| {
                held.tiles.iter().map(move |(tile, (used, _))| (*used, group, *tile))
            });
        let Some((_, group, tile)) = used.min() else { return false };
        if let Some((_, portals)) = self.groups[group].tiles.remove(&tile) {
            self.bytes -= portals.bytes();
        }
        self.groups.retain(|group| !group.tiles.is_empty());
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::plane::Point;
    use units::LatLon;

    #[test]
    fn portals_that_were_not_used_for_longest_are_forgotten_first() {
        let grid = Grid { middle: LatLon::from_deg(63.0, 10.0).unwrap(), tile_m: 1_000.0 };
        let needs = Needs::depth_and_clearance(5.0, 25.0);
        let of = Of { needs, zones: Arc::default(), grid };
        let other = Of { needs: Needs::depth_and_clearance(2.0, 25.0), ..of.clone() };
        let tile = |east: u32| grid.tile(Point { x: 1_000.0 * f64::from(east) + 1.0, y: 1.0 });
        let known = Known::default();
        let quarter = Arc::new(Portals::of_bytes(MOST_BYTES / 4));
        for east in 0..4 {
            assert!(known.get(&of, tile(east)).is_none());
            known.put(&of, tile(east), &quarter);
        }
        assert!(known.get(&of, tile(0)).is_some(), "four quarters are kept");
        known.put(&other, tile(0), &quarter);
        assert_eq!(known.bytes(), MOST_BYTES);
        assert!(known.get(&of, tile(1)).is_none(), "it was not used for longest");
        for (of, east) in [(&of, 0), (&of, 2), (&of, 3), (&other, 0)] {
            assert!(known.get(of, tile(east)).is_some(), "{east}");
        }
        known.put(&of, tile(2), &Arc::new(Portals::of_bytes(0)));
        assert_eq!(known.bytes(), MOST_BYTES / 4 * 3, "what is put again takes the place of what was there");
    }
}
