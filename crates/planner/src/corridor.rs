//! Which tiles a long way may lead through.
//!
//! A* (P. E. Hart, N. J. Nilsson and B. Raphael 1968) over portals of tiles. It asks for the portals of a tile when it comes there,
//! so that no water is prepared that the way cannot lead to. Then all tiles are taken through which a way leads that is hardly
//! longer than the shortest one found. Portals are entered at their middles, so that lengths are too long by up to 0.2 %
//! in open water: the corridor is wider than that.

use crate::plane::Point;
use crate::portals::Portals;
use crate::tile::Tile;
use crate::{Cancel, PlanError};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use std::sync::Arc;

/// A tile belongs to the corridor of a width if a way through it is longer than the shortest by no more than this share of
/// that and this share of a tile's side.
pub(crate) const WIDTHS: [(f64, f64); 3] = [(0.004, 0.125), (0.002, 0.05), (0.0, 5e-5)];
/// So many tiles are looked at around the goal first, to see whether it lies in water that is enclosed.
const LOOK_TILES: usize = 24;
/// Where it is, so many more are looked at to say how near to it a way leads; the answer says how far that was.
const NEAREST_TILES: usize = 64;
/// Portals between two looks at whether the answer is still wanted.
const DOORS_BETWEEN_LOOKS: usize = 256;

/// A piece of a tile's water.
pub(crate) type Part = (Tile, u32);

/// An end of a way: the part of a tile that it stands in, and how long the ways from it to its portals are (m).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Foot {
    pub(crate) at: Point,
    pub(crate) portals: Vec<((Tile, usize), f64)>,
    pub(crate) part: Part,
}

/// What was found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Found {
    /// Tiles for each of [`WIDTHS`], the widest first, and the portals of the shortest way.
    Corridor { tiles: [BTreeSet<Tile>; WIDTHS.len()], portals: Vec<Point> },
    /// There is no way: the water around one of the ends was looked at wholly, and these are its parts. The start leads to
    /// these others, and to more unless they are `all`.
    NoWay { enclosed: BTreeSet<Part>, reached: BTreeSet<Part>, all: bool },
    /// Not known: water leads on to tiles that are too far off. The start leads to these parts.
    Unknown { reached: BTreeSet<Part> },
    /// Not known: there is more water than may be looked at.
    Spent,
}

/// How much may be looked at for one way.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Most {
    pub(crate) tiles: usize,
    /// Of portals.
    pub(crate) bytes: usize,
}

/// Gives the portals of a tile; `None` of one that is too far off to be looked at.
pub(crate) type Ask<'a> = &'a mut dyn FnMut(Tile) -> Result<Option<Arc<Portals>>, PlanError>;

/// Finds the corridor between two ends, in tiles of this size. `direct_m` is how long the way through no portal is (m), if there
/// is one.
pub(crate) fn find(
    [from, to]: [&Foot; 2],
    (direct_m, tile_m): (Option<f64>, f64),
    portals: Ask<'_>,
    most: Most,
    cancel: &Cancel<'_>,
) -> Result<Found, PlanError> {
    let mut search = Search {
        portals,
        numbers: BTreeMap::new(),
        tiles: Vec::new(),
        onward: Vec::new(),
        bytes: 0,
        is_cut_short: false,
        is_spent: false,
        tile_m,
        cancel,
    };
    let [start, goal] = [search.end(from)?, search.end(to)?];
    let enclosed = if direct_m.is_none() { search.enclosed(&goal, &start)? } else { None };
    // The goal's water may lead on to where nothing is looked at; what counts from here on is the start's.
    search.is_cut_short = false;
    let most =
        if enclosed.is_some() { Most { tiles: search.tiles.len() + NEAREST_TILES, ..most } } else { most };
    let (there, shortest_m) = search.forward((&start, &goal), direct_m, most)?;
    if shortest_m.is_finite() {
        let ends = BTreeSet::from([from.part.0, to.part.0]);
        let portals = search.way(&goal, &there);
        return Ok(Found::Corridor { tiles: search.back(&goal, &there, shortest_m, &ends)?, portals });
    }
    let mut reached = search.reached(&there);
    reached.insert(from.part);
    Ok(match enclosed {
        _ if !search.is_cut_short => Found::NoWay { enclosed: reached.clone(), reached, all: true },
        Some(mut enclosed) => {
            enclosed.insert(to.part);
            Found::NoWay { enclosed, reached, all: false }
        }
        None if search.is_spent => Found::Spent,
        None => Found::Unknown { reached },
    })
}

/// A portal: the number of its tile in the search, and its own in the tile.
type Node = (u32, u32);

/// An end whose portals are numbered.
struct End {
    at: Point,
    portals: Vec<(Node, f64)>,
}

/// Ways over portals.
struct Search<'a, 'b> {
    portals: Ask<'a>,
    numbers: BTreeMap<Tile, u32>,
    tiles: Vec<(Tile, Option<Arc<Portals>>)>,
    /// Where the portal that was asked for last leads on to.
    onward: Vec<(Node, f64)>,
    /// Of the portals of all these tiles.
    bytes: usize,
    /// Water leads on to where it was not looked at.
    is_cut_short: bool,
    /// No more water may be looked at.
    is_spent: bool,
    tile_m: f64,
    cancel: &'a Cancel<'b>,
}

/// Portals that wait, by length, whose bits order like itself; and how long the shortest known way to each is (m).
#[derive(Default)]
struct Ways {
    heap: BinaryHeap<Reverse<(u64, Node)>>,
    /// By tile and portal: the length, and the portal before it, or itself where the way begins.
    known: Vec<Vec<(f64, Node)>>,
}

impl Ways {
    /// How long the shortest known way to a portal is (m); infinite where no way is known.
    fn length_m(&self, node: Node) -> f64 {
        self.known(node).0
    }

    fn known(&self, node: Node) -> (f64, Node) {
        let portals = self.known.get(node.0 as usize);
        portals.and_then(|portals| portals.get(node.1 as usize)).copied().unwrap_or((f64::INFINITY, node))
    }

    /// Adds a portal that waits, if no shorter way to it is known; in the order of its length and what is left at least (m).
    fn put(&mut self, node: Node, (length_m, before): (f64, Node), left_m: f64) {
        if length_m >= self.length_m(node) {
            return;
        }
        let (tile, portal) = (node.0 as usize, node.1 as usize);
        self.known.resize(self.known.len().max(tile + 1), Vec::new());
        let portals = &mut self.known[tile];
        portals.resize(portals.len().max(portal + 1), (f64::INFINITY, node));
        portals[portal] = (length_m, before);
        self.heap.push(Reverse(((length_m + left_m).to_bits(), node)));
    }
}

impl Search<'_, '_> {
    fn number(&mut self, tile: Tile) -> Result<u32, PlanError> {
        if let Some(number) = self.numbers.get(&tile) {
            return Ok(*number);
        }
        let portals = (self.portals)(tile)?;
        self.bytes += portals.as_ref().map_or(0, |portals| portals.bytes());
        let number = self.tiles.len() as u32;
        self.tiles.push((tile, portals));
        self.numbers.insert(tile, number);
        Ok(number)
    }

    fn end(&mut self, foot: &Foot) -> Result<End, PlanError> {
        let mut portals = Vec::with_capacity(foot.portals.len());
        for ((tile, portal), length_m) in &foot.portals {
            portals.push(((self.number(*tile)?, *portal as u32), *length_m));
        }
        Ok(End { at: foot.at, portals })
    }

    /// Looks where a portal leads on to: within its tile, and beyond it.
    fn look_onward(&mut self, (number, portal): Node) -> Result<(), PlanError> {
        self.onward.clear();
        let (tile, portals) = &self.tiles[number as usize];
        let Some(here) = portals.clone() else { return Ok(()) };
        let beyond = here.beyond(*tile, portal as usize);
        let within = here.onward(portal as usize);
        self.onward.extend(within.map(|(other, length_m)| ((number, other as u32), length_m)));
        let number = self.number(beyond)?;
        match &self.tiles[number as usize].1 {
            Some(there) => {
                let leads = there.opposite(&here.list[portal as usize]);
                self.onward.extend(leads.map(|(other, length_m)| ((number, other as u32), length_m)));
            }
            None => self.is_cut_short = true,
        }
        Ok(())
    }

    fn at(&self, (tile, portal): Node) -> Point {
        let portals = self.tiles[tile as usize].1.as_ref();
        portals.map_or_else(Point::default, |portals| portals.list[portal as usize].at)
    }

    /// How long ways in a corridor of a width are at most (m).
    fn most_m(&self, (share, of_tile): (f64, f64), shortest_m: f64) -> f64 {
        (1.0 + share) * shortest_m + of_tile * self.tile_m
    }

    /// The parts of the water around an end if it is enclosed: all of it was looked at, in few tiles, and the other end was not
    /// in it.
    fn enclosed(&mut self, around: &End, other: &End) -> Result<Option<BTreeSet<Part>>, PlanError> {
        let goals: BTreeSet<Node> = other.portals.iter().map(|(node, _)| *node).collect();
        let mut seen: BTreeSet<Node> = around.portals.iter().map(|(node, _)| *node).collect();
        let mut waiting: Vec<Node> = seen.iter().copied().collect();
        while let Some(node) = waiting.pop() {
            self.cancel.check()?;
            if goals.contains(&node) || self.tiles.len() > LOOK_TILES {
                return Ok(None);
            }
            self.look_onward(node)?;
            if self.is_cut_short {
                return Ok(None);
            }
            waiting.extend(self.onward.iter().map(|(next, _)| *next).filter(|next| seen.insert(*next)));
        }
        let part = |node: Node| {
            let (tile, portals) = &self.tiles[node.0 as usize];
            portals.as_ref().map(|portals| (*tile, portals.list[node.1 as usize].piece))
        };
        Ok(Some(seen.into_iter().filter_map(part).collect()))
    }

    /// The ways to all portals through which a way to the goal may lead that belongs to the corridor, and how long the
    /// shortest one is (m); infinite where no way was found.
    fn forward(
        &mut self,
        (from, to): (&End, &End),
        direct_m: Option<f64>,
        most: Most,
    ) -> Result<(Ways, f64), PlanError> {
        let rest_m: BTreeMap<Node, f64> = to.portals.iter().copied().collect();
        let mut shortest_m = direct_m.unwrap_or(f64::INFINITY);
        let (mut ways, mut looked) = (Ways::default(), 0_usize);
        for (node, length_m) in &from.portals {
            ways.put(*node, (*length_m, *node), self.at(*node).distance_m(to.at));
        }
        while let Some(Reverse((bits, node))) = ways.heap.pop() {
            if f64::from_bits(bits) > self.most_m(WIDTHS[0], shortest_m) {
                break;
            }
            let length_m = ways.length_m(node);
            if (length_m + self.at(node).distance_m(to.at)).to_bits() < bits {
                // A shorter way there was looked at before.
                continue;
            }
            looked += 1;
            if looked.is_multiple_of(DOORS_BETWEEN_LOOKS) {
                self.cancel.check()?;
            }
            shortest_m = rest_m.get(&node).map_or(shortest_m, |rest_m| shortest_m.min(length_m + rest_m));
            if self.tiles.len() > most.tiles || self.bytes > most.bytes {
                (self.is_cut_short, self.is_spent) = (true, true);
                break;
            }
            self.look_onward(node)?;
            for (next, step_m) in &self.onward {
                ways.put(*next, (length_m + step_m, node), self.at(*next).distance_m(to.at));
            }
        }
        Ok((ways, shortest_m))
    }

    /// The parts of tiles that ways lead to.
    fn reached(&self, ways: &Ways) -> BTreeSet<Part> {
        let mut parts = BTreeSet::new();
        for ((tile, portals), known) in self.tiles.iter().zip(&ways.known) {
            let list = portals.iter().flat_map(|portals| &portals.list).zip(known);
            let leads = list.filter(|(_, (length_m, _))| length_m.is_finite());
            parts.extend(leads.map(|(portal, _)| (*tile, portal.piece)));
        }
        parts
    }

    /// The portals of the shortest way, in order.
    fn way(&self, to: &End, there: &Ways) -> Vec<Point> {
        let length_m = |(node, rest_m): &(Node, f64)| there.length_m(*node) + rest_m;
        let last = to.portals.iter().min_by(|one, other| length_m(one).total_cmp(&length_m(other)));
        let mut way = Vec::new();
        let mut next = last.map(|(node, _)| *node).filter(|node| there.length_m(*node).is_finite());
        while let Some(node) = next {
            way.push(self.at(node));
            next = Some(there.known(node).1).filter(|before| *before != node);
        }
        way.reverse();
        way
    }

    /// From the goal back through what the search came to: the tiles of all ways that are short enough, and those of the ends.
    fn back(
        &mut self,
        to: &End,
        there: &Ways,
        shortest_m: f64,
        ends: &BTreeSet<Tile>,
    ) -> Result<[BTreeSet<Tile>; WIDTHS.len()], PlanError> {
        let mut tiles = WIDTHS.map(|_| ends.clone());
        let (mut ways, mut looked) = (Ways::default(), 0_usize);
        to.portals.iter().for_each(|(node, length_m)| ways.put(*node, (*length_m, *node), 0.0));
        while let Some(Reverse((bits, node))) = ways.heap.pop() {
            let length_m = ways.length_m(node);
            let all_m = there.length_m(node) + length_m;
            if length_m.to_bits() < bits || all_m > self.most_m(WIDTHS[0], shortest_m) {
                continue;
            }
            looked += 1;
            if looked.is_multiple_of(DOORS_BETWEEN_LOOKS) {
                self.cancel.check()?;
            }
            for (width, tiles) in WIDTHS.into_iter().zip(&mut tiles) {
                if all_m <= self.most_m(width, shortest_m) {
                    tiles.insert(self.tiles[node.0 as usize].0);
                }
            }
            self.look_onward(node)?;
            for (next, step_m) in &self.onward {
                ways.put(*next, (length_m + step_m, node), 0.0);
            }
        }
        Ok(tiles)
    }
}
