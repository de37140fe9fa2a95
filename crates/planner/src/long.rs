//! Long ways over much chart: a corridor of tiles first, then the exact water of the corridor alone.
//!
//! All water between ends hundreds of kilometres apart can be more than memory holds. So the doors of tiles are looked at
//! ([`crate::doors`]), those that a way could lead through, each prepared for a moment and kept as doors; they tell the
//! corridor ([`crate::corridor`]), whose water is prepared as that of a region is, and asked the same question. Every leg is
//! held against the depth index like any other. What is not certain is that no way outside of the corridor is shorter: the
//! answer says so ([`Route::of_corridor`]).

use crate::Cancel;
use crate::corridor::{self, Foot, Found, WIDTHS};
use crate::doors::{self, Doors, Tile};
use crate::needs::Needs;
use crate::plane::{Plane, Point};
use crate::room::PlanError;
use crate::route::{End, Question, Refusal, Request, Route};
use crate::router::{Key, Router, Water, coarse_middle};
use crate::zones::Zones;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::{Arc, Mutex, PoisonError};
use units::LatLon;

/// Middles of planes lie so far apart (m): ways whose middles are near each other share tiles.
const MIDDLES_M: f64 = 160_000.0;
/// Tiles whose middle is farther off from the plane's are not looked at (m).
const FARTHEST_M: f64 = 640_000.0;
/// So many tiles are looked at for one way: more than a way of 800 km needs.
const MOST_TILES: usize = 2_000;
/// Planes whose doors are kept, for needs and zones; the one not asked for longest goes first. Each takes some megabytes.
const MOST_PLANES: usize = 4;

/// Doors of the tiles of a plane, for needs and zones.
#[derive(Debug)]
pub(crate) struct Known {
    needs: Needs,
    zones: Arc<Zones>,
    middle: LatLon,
    tiles: BTreeMap<Tile, Arc<Doors>>,
}

/// What routers that share water know of planes.
pub(crate) type AllKnown = Arc<Mutex<Vec<Known>>>;

/// Where ends may stand that are to be moved.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stands {
    /// In the nearest open water.
    Nearest,
    /// In all that is near enough.
    All,
}

/// A place for an end in open water.
#[derive(Debug, Clone, Copy)]
struct Stand {
    tile: Tile,
    at: Point,
    triangle: u32,
    moved_m: f64,
}

/// A long way that is being looked for.
pub(crate) struct Long<'a> {
    router: &'a Router,
    request: &'a Request,
    needs: &'a Needs,
    cancel: &'a Cancel<'a>,
    middle: LatLon,
    plane: Plane,
}

impl<'a> Long<'a> {
    pub(crate) fn new(
        router: &'a Router,
        request: &'a Request,
        needs: &'a Needs,
        cancel: &'a Cancel<'a>,
    ) -> Self {
        let middle = coarse_middle(request, MIDDLES_M);
        Self { router, request, needs, cancel, middle, plane: Plane::new(middle) }
    }

    /// The shortest way of the corridor; `None` where that has more chart than may be prepared.
    pub(crate) fn route(&self) -> Result<Option<Route>, Refusal> {
        // An end that is moved is moved no farther than it must be: elsewhere only where no way leads on from there.
        match self.route_from(Stands::Nearest) {
            Err(Refusal::NoWay { .. }) => self.route_from(Stands::All),
            answer => answer,
        }
    }

    fn route_from(&self, stands: Stands) -> Result<Option<Route>, Refusal> {
        let (start, goal) = (self.foot(End::Start, stands)?, self.foot(End::Goal, stands)?);
        let direct_m = self.direct_m(&start, &goal)?;
        let mut ask = |tile: Tile| self.doors(tile);
        match corridor::find([&start, &goal], direct_m, &mut ask, MOST_TILES, self.cancel)? {
            Found::Corridor(tiles) => self.within(tiles),
            Found::TooMany => Ok(None),
            Found::Nothing { nearest } => {
                let gap_m = nearest.distance_m(goal.at);
                Err(Refusal::NoWay { nearest: self.plane.place(nearest), gap_m })
            }
        }
    }

    /// The way in the water of the widest of these corridors that is not too much; in water that is kept, if that holds the
    /// narrower one.
    fn within(&self, corridors: [BTreeSet<Tile>; WIDTHS.len()]) -> Result<Option<Route>, Refusal> {
        let mut allowed = Vec::new();
        for tiles in corridors {
            if self.barriers(&tiles)? <= self.router.most_barriers {
                allowed.push(Arc::new(tiles));
            }
        }
        let [widest, ..] = &allowed[..] else { return Ok(None) };
        // As an end is dragged, the corridor changes by some tiles at its borders.
        let least = allowed.get(1).unwrap_or(widest);
        let water =
            |tiles: &Arc<BTreeSet<Tile>>| Water::Tiles { middle: self.middle, tiles: Arc::clone(tiles) };
        let holds = |kept: &Water| matches!(kept, Water::Tiles { middle, tiles } if *middle == self.middle && tiles.is_superset(least));
        let room = match self.router.kept_water(self.needs, holds) {
            Some(room) => room,
            None => self.router.room(self.key(water(widest)), self.cancel)?,
        };
        let question =
            Question { room: &room, index: self.router.index(), request: self.request, cancel: self.cancel };
        Ok(Some(Route { of_corridor: true, ..question.answer()? }))
    }

    fn key(&self, water: Water) -> Key {
        self.router.key(self.needs, water)
    }

    fn tile_key(&self, tile: Tile) -> Key {
        self.key(Water::Tiles { middle: self.middle, tiles: Arc::new(BTreeSet::from([tile])) })
    }

    /// Where an end may stand, and which doors that leads to.
    fn foot(&self, end: End, which: Stands) -> Result<Foot, Refusal> {
        let place = match end {
            End::Start => self.request.from,
            End::Goal => self.request.to,
        };
        let at = self.plane.point(place);
        let mut stands = self.stands(at)?;
        if stands.is_empty() {
            let room = self.router.room(self.tile_key(Tile::of(at)), self.cancel)?;
            let (index, request, cancel) = (self.router.index(), self.request, self.cancel);
            // The tile has no open water near enough, so that its room says what is there.
            let closed = Question { room: &room, index, request, cancel }.closed(end);
            return Err(
                closed.unwrap_or_else(|| PlanError::Geometry("an end stands nowhere".to_owned()).into())
            );
        }
        stands.sort_by(|one, other| one.moved_m.total_cmp(&other.moved_m));
        if which == Stands::Nearest {
            stands.truncate(1);
        }
        let mut foot = Foot { at, doors: Vec::new(), tiles: BTreeSet::new() };
        for stand in stands {
            self.add_doors(&stand, &mut foot)?;
        }
        Ok(foot)
    }

    /// Where an end may stand: at its very place, or else at the nearest points of open water in the tiles around.
    fn stands(&self, at: Point) -> Result<Vec<Stand>, PlanError> {
        let own = self.router.room(self.tile_key(Tile::of(at)), self.cancel)?;
        if let Some(triangle) = own.mesh.locate(at) {
            return Ok(vec![Stand { tile: Tile::of(at), at, triangle, moved_m: 0.0 }]);
        }
        let mut stands = Vec::new();
        for tile in Tile::around(at, self.request.move_up_to_m) {
            let room = self.router.room(self.tile_key(tile), self.cancel)?;
            let near = room.mesh.nearest(at, self.request.move_up_to_m).into_iter();
            stands.extend(near.map(|near| Stand {
                tile,
                at: near.at,
                triangle: near.triangle,
                moved_m: near.distance_m,
            }));
        }
        Ok(stands)
    }

    /// Adds the doors that one leads to from a stand.
    fn add_doors(&self, stand: &Stand, foot: &mut Foot) -> Result<(), PlanError> {
        let Stand { tile, at, triangle, moved_m } = *stand;
        foot.tiles.insert(tile);
        let Some(doors) = self.doors(tile)? else { return Ok(()) };
        let room = self.router.room(self.tile_key(tile), self.cancel)?;
        let from = (room.mesh.within(triangle, at), triangle);
        for (number, door) in doors.list.iter().enumerate() {
            let length_m = doors::length_m(&room, from, (door.at, door.triangle), self.cancel)?;
            if length_m.is_finite() {
                foot.doors.push(((tile, number), moved_m + length_m));
            }
        }
        Ok(())
    }

    /// How long the way between both ends is within a tile, if they stand in the same water of the same one (m).
    fn direct_m(&self, start: &Foot, goal: &Foot) -> Result<Option<f64>, PlanError> {
        for tile in start.tiles.intersection(&goal.tiles) {
            let room = self.router.room(self.tile_key(*tile), self.cancel)?;
            let [from, to] = [start.at, goal.at].map(|at| room.mesh.nearest(at, self.request.move_up_to_m));
            for (one, other) in from.iter().flat_map(|one| to.iter().map(move |other| (one, other))) {
                let [from, to] =
                    [one, other].map(|near| (room.mesh.within(near.triangle, near.at), near.triangle));
                let length_m = doors::length_m(&room, from, to, self.cancel)?;
                if length_m.is_finite() {
                    return Ok(Some(length_m));
                }
            }
        }
        Ok(None)
    }

    /// The doors of a tile, prepared now if they are not known; `None` if it is too far off.
    fn doors(&self, tile: Tile) -> Result<Option<Arc<Doors>>, PlanError> {
        let middle = tile.region().min.towards(tile.region().max, 0.5);
        if middle.x.abs().max(middle.y.abs()) > FARTHEST_M {
            return Ok(None);
        }
        let lock = || self.router.known.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(doors) = self.known(&mut lock()).tiles.get(&tile) {
            return Ok(Some(Arc::clone(doors)));
        }
        let room = Router::prepare(self.router.index(), &self.tile_key(tile), self.cancel)?;
        let doors = Arc::new(Doors::of(&room, self.cancel)?);
        self.known(&mut lock()).tiles.insert(tile, Arc::clone(&doors));
        Ok(Some(doors))
    }

    /// What is known of this plane for these needs and zones, from now on the newest.
    fn known<'k>(&self, all: &'k mut Vec<Known>) -> &'k mut Known {
        let zones = self.router.zones();
        let is_it = |known: &Known| {
            known.needs == *self.needs && known.middle == self.middle && known.zones == *zones
        };
        let known = all.iter().position(is_it).map(|at| all.remove(at));
        let fresh = || Known {
            needs: *self.needs,
            zones: Arc::clone(zones),
            middle: self.middle,
            tiles: BTreeMap::new(),
        };
        let known = known.unwrap_or_else(fresh);
        if all.len() >= MOST_PLANES {
            all.remove(0);
        }
        all.push(known);
        let newest = all.len() - 1;
        &mut all[newest]
    }

    fn barriers(&self, tiles: &BTreeSet<Tile>) -> Result<usize, PlanError> {
        let mut all = 0;
        for tile in tiles {
            all += self.doors(*tile)?.map_or(0, |doors| doors.barriers);
        }
        Ok(all)
    }
}
