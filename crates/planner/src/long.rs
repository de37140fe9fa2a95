//! Long ways: a corridor of tiles first, then the exact water of the corridor alone.
//!
//! All water between ends hundreds of kilometres apart can be more than memory holds. So the search goes from tile to tile by
//! their portals ([`crate::portals`]); each tile is prepared only for as long as its portals are looked for. From them follows
//! the corridor ([`crate::corridor`]), whose water is prepared as that of a region is, and asked the same question. Every leg is
//! checked against the depth index like any other. Where water outside of the corridor could hold a shorter way, the answer
//! says so ([`Route::of_part`]).
//!
//! The search is bounded: in tiles, in memory, and in time where the caller gives one ([`Cancel::within`]). When a bound is
//! reached, it gives up and says how far it came ([`Refusal::GaveUp`]); portals that are known are kept, so that it comes
//! farther when it is asked again.

use crate::corridor::{self, Foot, Found, Most, Part, WIDTHS};
use crate::known::{Known, Of};
use crate::mesh::others_within_m;
use crate::needs::Needs;
use crate::plane::{Plane, Point};
use crate::portals::{self, Portals};
use crate::refusal::{End, Refusal, Spent};
use crate::region::Region;
use crate::room::SeaRoom;
use crate::rooms::{Rooms, Square, Water, coarse_middle};
use crate::route::{Question, Request, Route};
use crate::sailing::Wish;
use crate::tile::{Grid, Tile, Tiles};
use crate::{Cancel, PlanError, Progress};
use charts::depth_index::Leg;
use std::cell::RefCell;
use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;
use units::LatLon;

/// Middles of planes lie so far apart, in tiles: ways whose middles are near each other share tiles.
const MIDDLES_TILES: f64 = 8.0;
/// Tiles whose middle is farther off from the plane's are not looked at (m): lengths there are up to 0.25 % too long.
const FARTHEST_M: f64 = 640_000.0;
/// The portals of the tiles that are looked at for one way take no more memory (bytes).
const MOST_BYTES: usize = 16 << 20;
/// Half side of the region in which the nearest open water is looked for, around an end in closed water (m).
const LOOK_M: f64 = 20_000.0;
/// So much longer than the shortest way a way is at most that is called the shortest.
const AS_SHORT: f64 = 1.001;

/// How long ways are looked for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Limits {
    /// Side of a tile (m).
    pub(crate) tile_m: f64,
    /// A corridor has no more straight parts of what its ways keep clear of.
    pub(crate) most_barriers: usize,
    /// For one way no more tiles are looked at.
    pub(crate) most_tiles: usize,
    /// How far apart ends may lie where a corridor has too many (m).
    pub(crate) apart_m: f64,
}

/// A place for an end in open water.
#[derive(Debug, Clone, Copy)]
struct Stand {
    tile: Tile,
    at: Point,
    triangle: u32,
    piece: u32,
    moved_m: f64,
}

/// What the route through some water is good for; `None` for the shortest.
pub(crate) type WishIn<'a> = &'a dyn Fn(&Water) -> Result<Option<Wish>, PlanError>;

/// A long way that is being looked for.
pub(crate) struct Long<'a> {
    rooms: &'a Rooms,
    known: &'a Known,
    limits: Limits,
    request: &'a Request,
    needs: &'a Needs,
    cancel: &'a Cancel<'a>,
    plane: Plane,
    of: Of,
    /// Tiles whose portals this search asked for.
    asked: RefCell<BTreeSet<Tile>>,
    wish: WishIn<'a>,
    /// How many waters are prepared of one corridor: its own, and those that are preferred.
    waters: usize,
}

impl<'a> Long<'a> {
    pub(crate) fn new(
        (rooms, known): (&'a Rooms, &'a Known),
        limits: Limits,
        request: &'a Request,
        needs: &'a Needs,
        (wish, waters): (WishIn<'a>, usize),
        cancel: &'a Cancel<'a>,
    ) -> Self {
        let middle = coarse_middle([request.from, request.to], MIDDLES_TILES * limits.tile_m);
        let grid = Grid { middle, tile_m: limits.tile_m };
        let of = Of { needs: *needs, zones: Arc::clone(&rooms.zones), grid };
        let (plane, asked) = (Plane::new(middle), RefCell::default());
        Self { rooms, known, limits, request, needs, cancel, plane, of, asked, wish, waters }
    }

    /// The best way of the corridor.
    pub(crate) fn route(&self) -> Result<Route, Refusal> {
        self.find().map_err(|refusal| match refusal {
            // Wherever in the search the time was used up.
            Refusal::GaveUp { spent, .. } => self.gave_up(spent),
            other => other,
        })
    }

    fn gave_up(&self, spent: Spent) -> Refusal {
        let (asked, start) = (self.asked.borrow(), self.plane.point(self.request.from));
        let off_m = |tile: &Tile| self.of.grid.region(*tile).distance_m(start);
        let looked_m = asked.iter().map(off_m).fold(0.0, f64::max);
        Refusal::GaveUp { tiles: asked.len(), looked_km: looked_m / 1e3, spent }
    }

    fn find(&self) -> Result<Route, Refusal> {
        let (starts, goals) =
            (self.stands((End::Start, self.request.from))?, self.stands((End::Goal, self.request.to))?);
        let all = starts.iter().flat_map(|start| goals.iter().map(move |goal| [*start, *goal]));
        let mut pairs: Vec<[Stand; 2]> = all.collect();
        pairs.sort_by(|[a, b], [c, d]| (a.moved_m + b.moved_m).total_cmp(&(c.moved_m + d.moved_m)));
        // Ends are moved no farther than they must be: elsewhere only where no way leads on from the nearest water.
        let mut refused = None;
        // Each enclosed water is looked at once, so that no pair is left out.
        let mut enclosed: Vec<BTreeSet<Part>> = Vec::new();
        for [start, goal] in pairs {
            let [from, to] = [start, goal].map(|stand| (stand.tile, stand.piece));
            if enclosed.iter().any(|water| water.contains(&from) != water.contains(&to)) {
                continue;
            }
            match self.between(start, goal, &mut enclosed) {
                Err(refusal @ Refusal::NoWay { .. }) => refused = refused.or(Some(refusal)),
                answer => return answer,
            }
        }
        Err(refused
            .unwrap_or_else(|| PlanError::Geometry("no open water was found at an end".to_owned()).into()))
    }

    /// The shortest way between two places. Without one, adds to the enclosed waters.
    fn between(&self, start: Stand, goal: Stand, waters: &mut Vec<BTreeSet<Part>>) -> Result<Route, Refusal> {
        let direct_m = self.direct_m(&start, &goal)?;
        let feet = [self.foot(&start)?, self.foot(&goal)?];
        let mut ask = |tile: Tile| self.portals(tile);
        let sizes = (direct_m, self.limits.tile_m);
        let most = Most { tiles: self.limits.most_tiles, bytes: MOST_BYTES };
        match corridor::find([&feet[0], &feet[1]], sizes, &mut ask, most, self.cancel)? {
            Found::Corridor { tiles, portals } => self.within(tiles, &portals),
            Found::NoWay { enclosed, reached, all } => {
                waters.push(enclosed);
                let (nearest, gap_m) = self.nearest(&reached, start.at)?;
                let looked_km = (!all).then(|| self.looked_km(&reached, start.at));
                Err(Refusal::NoWay { nearest: self.plane.place(nearest), gap_m, looked_km })
            }
            Found::Unknown { reached } => {
                let (nearest, gap_m) = self.nearest(&reached, start.at)?;
                let looked_km = self.looked_km(&reached, start.at);
                Err(Refusal::Unknown { looked_km, nearest: self.plane.place(nearest), gap_m })
            }
            Found::Spent => Err(self.gave_up(Spent::Tiles)),
        }
    }

    /// How far from the start the farthest of these parts lies (km).
    fn looked_km(&self, reached: &BTreeSet<Part>, start: Point) -> f64 {
        let off_m = |(tile, _): &Part| self.of.grid.region(*tile).distance_m(start);
        reached.iter().map(off_m).fold(0.0, f64::max) / 1e3
    }

    /// The way in the water of the widest of these corridors that is not too much; in water that is kept, if that holds the
    /// narrower one.
    fn within(&self, corridors: [BTreeSet<Tile>; WIDTHS.len()], portals: &[Point]) -> Result<Route, Refusal> {
        let mut allowed = Vec::new();
        for tiles in corridors {
            if self.waters * self.barriers(&tiles)? <= self.limits.most_barriers {
                allowed.push(Arc::new(tiles));
            }
        }
        let [widest, ..] = &allowed[..] else { return Err(self.too_far(portals)) };
        // As an end is dragged, the corridor changes by some tiles at its edges.
        let least = allowed.get(1).unwrap_or(widest);
        let holds = |tiles: &Tiles| tiles.grid == self.of.grid && tiles.tiles.is_superset(least);
        let wanted = |kept: &Water| matches!(kept, Water::Tiles(tiles) if holds(tiles));
        let (water, room) = if let Some(kept) = self.rooms.kept(self.needs, wanted) {
            kept
        } else {
            let water = Water::Tiles(Tiles { grid: self.of.grid, tiles: Arc::clone(widest) });
            (water.clone(), self.rooms.room(self.needs, water, self.cancel)?)
        };
        let wish = (self.wish)(&water)?;
        match (Question { wish: wish.as_ref(), ..self.question(&room) }).answer() {
            Ok(route) => Ok(Route { of_part: !self.is_shortest(&route, least), ..route }),
            // The corridor has a way by its portals; what its water as a whole says is no proof about other water.
            Err(Refusal::NoWay { nearest, gap_m, .. }) => {
                Err(Refusal::Unknown { looked_km: self.straight_m() / 1e3, nearest, gap_m })
            }
            Err(refusal) => Err(refusal),
        }
    }

    /// Whether no way through other tiles can be shorter than a route in these.
    fn is_shortest(&self, route: &Route, tiles: &BTreeSet<Tile>) -> bool {
        let ends = [route.start, route.goal()];
        let straight_m = Leg { from: ends[0], to: ends[1] }.length_m();
        let length_m = route.shortest_m();
        let [from, to] = ends.map(|end| self.plane.point(end));
        // Through any other tile a way is at least as long as straight there and on; on the sea it is shorter than in the plane.
        let is_longer = |tile: Tile| {
            let region = self.of.grid.region(tile);
            let corners = region.ring().into_iter().chain([from, to]);
            let scale = corners.map(|corner| self.plane.scale(corner)).fold(1.0, f64::max);
            region.distance_m(from) + region.distance_m(to) >= length_m * scale
        };
        let around = Region::of(&[from, to]).wider(0.5 * length_m);
        length_m <= AS_SHORT * straight_m
            || self.of.grid.tiles_in(around).all(|tile| tiles.contains(&tile) || is_longer(tile))
    }

    fn question<'q>(&'q self, room: &'q SeaRoom) -> Question<'q> {
        Question { room, index: &self.rooms.index, request: self.request, wish: None, cancel: self.cancel }
    }

    fn straight_m(&self) -> f64 {
        Leg { from: self.request.from, to: self.request.to }.length_m()
    }

    /// Proposes portals of the way that is too long as places on the way.
    fn too_far(&self, portals: &[Point]) -> Refusal {
        let mut by = Vec::new();
        let mut before = self.plane.point(self.request.from);
        let goal = self.plane.point(self.request.to);
        for pair in portals.windows(2) {
            if before.distance_m(pair[1]) > self.limits.apart_m
                && before.distance_m(goal) > self.limits.apart_m
            {
                by.push(self.plane.place(pair[0]));
                before = pair[0];
            }
        }
        Refusal::TooFar { straight_km: self.straight_m() / 1e3, most_km: self.limits.apart_m / 1e3, by }
    }

    /// The place nearest to the goal in parts of tiles, and how far off it is (m).
    fn nearest(&self, reached: &BTreeSet<Part>, start: Point) -> Result<(Point, f64), PlanError> {
        let goal = self.plane.point(self.request.to);
        let mut pieces: BTreeMap<Tile, Vec<u32>> = BTreeMap::new();
        for (tile, piece) in reached {
            pieces.entry(*tile).or_default().push(*piece);
        }
        let off_m = |tile: &Tile| self.of.grid.region(*tile).distance_m(goal);
        let mut tiles: Vec<(f64, Tile)> = pieces.keys().map(|tile| (off_m(tile), *tile)).collect();
        tiles.sort_by(|one, other| one.0.total_cmp(&other.0));
        let mut best = (start, start.distance_m(goal));
        for (off_m, tile) in tiles {
            if off_m >= best.1 {
                break;
            }
            let room = self.tile_room(tile)?;
            for piece in &pieces[&tile] {
                let near = room.mesh.nearest_of(*piece, goal);
                best = near
                    .filter(|near| near.distance_m < best.1)
                    .map_or(best, |near| (near.at, near.distance_m));
            }
        }
        Ok(best)
    }

    fn room(&self, tiles: Arc<BTreeSet<Tile>>) -> Result<Arc<SeaRoom>, PlanError> {
        self.rooms.room(self.needs, Water::Tiles(Tiles { grid: self.of.grid, tiles }), self.cancel)
    }

    fn tile_room(&self, tile: Tile) -> Result<Arc<SeaRoom>, PlanError> {
        self.room(Arc::new(BTreeSet::from([tile])))
    }

    /// Where an end may stand: at its very place, or else at the nearest points of open water in the tiles around.
    fn stands(&self, end: (End, LatLon)) -> Result<Vec<Stand>, Refusal> {
        let at = self.plane.point(end.1);
        let tile = self.of.grid.tile(at);
        let own = self.tile_room(tile)?;
        if let Some(triangle) = own.mesh.locate(at) {
            let piece = own.mesh.piece[triangle as usize];
            return Ok(vec![Stand { tile, at, triangle, piece, moved_m: 0.0 }]);
        }
        let within_m = self.request.move_up_to_m;
        let mut stands = Vec::new();
        for tile in self.of.grid.tiles_in(Region::of(&[at]).wider(within_m)) {
            let room = self.tile_room(tile)?;
            stands.extend(room.mesh.nearest(at, within_m).into_iter().map(|near| Stand {
                tile,
                at: near.at,
                triangle: near.triangle,
                piece: room.mesh.piece[near.triangle as usize],
                moved_m: near.distance_m,
            }));
        }
        stands.sort_by(|one, other| one.moved_m.total_cmp(&other.moved_m));
        let Some(Stand { moved_m, .. }) = stands.first() else { return Err(self.closed(end)?) };
        // As in a region that holds all of them.
        let most_m = others_within_m(*moved_m);
        stands.retain(|stand| stand.moved_m <= most_m);
        Ok(stands)
    }

    /// Why a way cannot begin or end there, by the water around.
    fn closed(&self, (end, place): (End, LatLon)) -> Result<Refusal, PlanError> {
        let around = Water::Square(Square::between([place; 2], LOOK_M));
        let room = self.rooms.room(self.needs, around, self.cancel)?;
        let at_edge = "the nearest open water is as far off as an end may be moved";
        let unsure = || PlanError::Geometry(at_edge.to_owned()).into();
        Ok(self.question(&room).closed((end, place)).unwrap_or_else(unsure))
    }

    /// The portals that an end leads to.
    fn foot(&self, stand: &Stand) -> Result<Foot, PlanError> {
        let Stand { tile, at, triangle, piece, .. } = *stand;
        let mut leads = Vec::new();
        if let Some(portals) = self.portals(tile)? {
            let room = self.tile_room(tile)?;
            let from = (room.mesh.within(triangle, at), triangle);
            for (number, portal) in
                portals.list.iter().enumerate().filter(|(_, portal)| portal.piece == piece)
            {
                let length_m = portals::length_m(&room, from, (portal.at, portal.triangle), self.cancel)?;
                leads.push(((tile, number), length_m));
            }
        }
        Ok(Foot { at, portals: leads, part: (tile, piece) })
    }

    /// How long the shortest way between both ends is that leaves no tile (m); `None` where there is no such way.
    fn direct_m(&self, start: &Stand, goal: &Stand) -> Result<Option<f64>, PlanError> {
        if (start.tile, start.piece) != (goal.tile, goal.piece) {
            return Ok(None);
        }
        let room = self.tile_room(start.tile)?;
        let [from, to] =
            [start, goal].map(|stand| (room.mesh.within(stand.triangle, stand.at), stand.triangle));
        portals::length_m(&room, from, to, self.cancel).map(Some)
    }

    /// The portals of a tile, prepared now if they are not known; `None` if it is too far off.
    fn portals(&self, tile: Tile) -> Result<Option<Arc<Portals>>, PlanError> {
        let Region { min, max } = self.of.grid.region(tile);
        if min.towards(max, 0.5).distance_m(Point::default()) > FARTHEST_M {
            return Ok(None);
        }
        self.cancel.check()?;
        self.asked.borrow_mut().insert(tile);
        if let Some(portals) = self.known.get(&self.of, tile) {
            return Ok(Some(portals));
        }
        let water = Water::Tiles(Tiles { grid: self.of.grid, tiles: Arc::new(BTreeSet::from([tile])) });
        let room = self.rooms.prepare(self.needs, &water, self.cancel)?;
        let portals = Arc::new(Portals::of(&room, self.cancel)?);
        self.known.put(&self.of, tile, &portals);
        self.cancel.report(Progress { tiles: self.asked.borrow().len(), most_tiles: self.limits.most_tiles });
        Ok(Some(portals))
    }

    fn barriers(&self, tiles: &BTreeSet<Tile>) -> Result<usize, PlanError> {
        let mut all = 0;
        for tile in tiles {
            all += self.portals(*tile)?.map_or(0, |portals| portals.barriers);
        }
        Ok(all)
    }
}
