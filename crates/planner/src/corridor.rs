//! Which tiles a long way may lead through: from door to door, the nearest to the goal first.
//!
//! A* (P. E. Hart, N. J. Nilsson and B. Raphael 1968) over doors, which asks for the doors of a tile when it comes there, and
//! so prepares no water that the way cannot lead to. Then all tiles are taken through which a way leads that is hardly
//! longer than the shortest one found: doors are entered at their middles, so that figures are a little too long, by some
//! tenths of a percent in open water.

use crate::doors::{Doors, Tile};
use crate::plane::Point;
use crate::{Cancel, PlanError};
use std::cmp::Reverse;
use std::collections::{BTreeMap, BTreeSet, BinaryHeap};
use std::sync::Arc;

/// Tiles belong to the corridor if a way through them is longer than the shortest by no more than this share and this length
/// (m).
pub(crate) const WIDTHS: [(f64, f64); 3] = [(0.004, 2_500.0), (0.002, 1_000.0), (0.0, 1.0)];
/// Tiles that are looked at around the goal, to see whether it lies in water that ends there.
const LOOK_TILES: usize = 24;
/// Where it does, so many more are looked at to say how near to it a way leads.
const NEAREST_TILES: usize = 64;
/// Doors between two looks at whether the answer is still wanted.
const DOORS_BETWEEN_LOOKS: usize = 256;

/// Where a way begins or ends: which doors it leads to, and how long it is there (m).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Foot {
    pub(crate) at: Point,
    pub(crate) doors: Vec<((Tile, usize), f64)>,
    /// The tiles in which it may stand.
    pub(crate) tiles: BTreeSet<Tile>,
}

/// What was found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Found {
    /// Tiles for each of [`WIDTHS`], the widest first.
    Corridor([BTreeSet<Tile>; WIDTHS.len()]),
    /// No way; the place nearest to the goal that one leads to.
    Nothing { nearest: Point },
    /// More tiles than may be looked at.
    TooMany,
}

/// Gives the doors of a tile; none of one that is too far off.
pub(crate) type Ask<'a> = &'a mut dyn FnMut(Tile) -> Result<Option<Arc<Doors>>, PlanError>;

/// Finds the corridor between two feet that has a way, looking at so many tiles at most. `direct_m` is how long the way is
/// that leads through no door (m), if there is one.
pub(crate) fn find(
    [from, to]: [&Foot; 2],
    direct_m: Option<f64>,
    doors: Ask<'_>,
    most_tiles: usize,
    cancel: &Cancel<'_>,
) -> Result<Found, PlanError> {
    let mut search =
        Search { doors, numbers: BTreeMap::new(), tiles: Vec::new(), onward: Vec::new(), cancel };
    let [start, goal] = [search.end(from)?, search.end(to)?];
    let is_enclosed = direct_m.is_none() && search.is_enclosed(&goal, &start)?;
    let most_tiles = if is_enclosed { search.tiles.len() + NEAREST_TILES } else { most_tiles };
    let (there_m, ending) = search.forward(&start, &goal, direct_m, most_tiles)?;
    match ending {
        Ending::Length(length_m) => {
            let ends = from.tiles.union(&to.tiles).copied().collect();
            Ok(Found::Corridor(search.back(&goal, &there_m, length_m, &ends)?))
        }
        Ending::Nothing { nearest } => Ok(Found::Nothing { nearest }),
        Ending::TooMany { nearest } if is_enclosed => Ok(Found::Nothing { nearest }),
        Ending::TooMany { .. } => Ok(Found::TooMany),
    }
}

/// A door: the number of its tile in the search, and its own in the tile.
type Node = (u32, u32);

/// A foot whose doors are numbered.
struct End {
    at: Point,
    doors: Vec<(Node, f64)>,
}

/// Ways over doors.
struct Search<'a, 'b> {
    doors: Ask<'a>,
    numbers: BTreeMap<Tile, u32>,
    tiles: Vec<(Tile, Option<Arc<Doors>>)>,
    /// Where one leads on from the door that was asked for last.
    onward: Vec<(Node, f64)>,
    cancel: &'a Cancel<'b>,
}

/// How long ways in a corridor of a width are at most (m).
fn most_m((share, more_m): (f64, f64), best_m: f64) -> f64 {
    (1.0 + share) * best_m + more_m
}

/// How a search ended.
enum Ending {
    Length(f64),
    Nothing { nearest: Point },
    TooMany { nearest: Point },
}

/// Doors that wait, by length, whose bits order like itself; and how long the shortest known way to each is (m).
#[derive(Default)]
struct Ways {
    heap: BinaryHeap<Reverse<(u64, Node)>>,
    lengths_m: Vec<Vec<f64>>,
}

impl Ways {
    /// How long the shortest known way to a door is (m); infinite where no way is known.
    fn length_m(&self, (tile, door): Node) -> f64 {
        let doors = self.lengths_m.get(tile as usize);
        doors.and_then(|doors| doors.get(door as usize)).copied().unwrap_or(f64::INFINITY)
    }

    /// Puts a door by, if no shorter way to it is known; in the order of its length and what is left at least (m).
    fn put(&mut self, node: Node, length_m: f64, left_m: f64) {
        if length_m >= self.length_m(node) {
            return;
        }
        let (tile, door) = (node.0 as usize, node.1 as usize);
        self.lengths_m.resize(self.lengths_m.len().max(tile + 1), Vec::new());
        let doors = &mut self.lengths_m[tile];
        doors.resize(doors.len().max(door + 1), f64::INFINITY);
        doors[door] = length_m;
        self.heap.push(Reverse(((length_m + left_m).to_bits(), node)));
    }
}

impl Search<'_, '_> {
    fn number(&mut self, tile: Tile) -> Result<u32, PlanError> {
        if let Some(number) = self.numbers.get(&tile) {
            return Ok(*number);
        }
        let doors = (self.doors)(tile)?;
        let number = self.tiles.len() as u32;
        self.tiles.push((tile, doors));
        self.numbers.insert(tile, number);
        Ok(number)
    }

    fn end(&mut self, foot: &Foot) -> Result<End, PlanError> {
        let mut doors = Vec::with_capacity(foot.doors.len());
        for ((tile, door), length_m) in &foot.doors {
            doors.push(((self.number(*tile)?, *door as u32), *length_m));
        }
        Ok(End { at: foot.at, doors })
    }

    /// Looks where one leads on from a door: within its tile and beyond it.
    fn look_onward(&mut self, (number, door): Node) -> Result<(), PlanError> {
        self.onward.clear();
        let (tile, doors) = &self.tiles[number as usize];
        let Some(here) = doors.clone() else { return Ok(()) };
        let beyond = here.beyond(*tile, door as usize);
        self.onward
            .extend(here.from(door as usize).map(|(other, length_m)| ((number, other as u32), length_m)));
        let number = self.number(beyond)?;
        if let Some(there) = &self.tiles[number as usize].1 {
            let leads = there.opposite(&here.list[door as usize]);
            self.onward.extend(leads.map(|(other, length_m)| ((number, other as u32), length_m)));
        }
        Ok(())
    }

    fn at(&self, (tile, door): Node) -> Point {
        let doors = self.tiles[tile as usize].1.as_ref();
        doors.map_or_else(Point::default, |doors| doors.list[door as usize].at)
    }

    /// Whether the water around an end ends before it has led to the other one, or beyond some tiles.
    fn is_enclosed(&mut self, around: &End, other: &End) -> Result<bool, PlanError> {
        let mut seen: BTreeSet<Node> = around.doors.iter().map(|(node, _)| *node).collect();
        let mut waiting: Vec<Node> = seen.iter().copied().collect();
        while let Some(node) = waiting.pop() {
            self.cancel.check()?;
            if other.doors.iter().any(|(door, _)| *door == node) || self.tiles.len() > LOOK_TILES {
                return Ok(false);
            }
            self.look_onward(node)?;
            waiting.extend(self.onward.iter().map(|(next, _)| *next).filter(|next| seen.insert(*next)));
        }
        Ok(true)
    }

    /// The ways to all doors through which a way to the goal may lead that belongs to the corridor.
    fn forward(
        &mut self,
        from: &End,
        to: &End,
        direct_m: Option<f64>,
        most_tiles: usize,
    ) -> Result<(Ways, Ending), PlanError> {
        let rest_m: BTreeMap<Node, f64> = to.doors.iter().copied().collect();
        let mut best_m = direct_m.unwrap_or(f64::INFINITY);
        let mut nearest = (from.at.distance_m(to.at), from.at);
        let (mut ways, mut looked) = (Ways::default(), 0_usize);
        for (node, length_m) in &from.doors {
            ways.put(*node, *length_m, self.at(*node).distance_m(to.at));
        }
        while let Some(Reverse((bits, node))) = ways.heap.pop() {
            if f64::from_bits(bits) > most_m(WIDTHS[0], best_m) {
                break;
            }
            let (length_m, at) = (ways.length_m(node), self.at(node));
            let left_m = at.distance_m(to.at);
            if (length_m + left_m).to_bits() < bits {
                // A shorter way there was looked at before.
                continue;
            }
            looked += 1;
            if looked.is_multiple_of(DOORS_BETWEEN_LOOKS) {
                self.cancel.check()?;
            }
            nearest = if left_m < nearest.0 { (left_m, at) } else { nearest };
            best_m = rest_m.get(&node).map_or(best_m, |rest_m| best_m.min(length_m + rest_m));
            if self.tiles.len() > most_tiles {
                return Ok((ways, Ending::TooMany { nearest: nearest.1 }));
            }
            self.look_onward(node)?;
            for (next, step_m) in &self.onward {
                ways.put(*next, length_m + step_m, self.at(*next).distance_m(to.at));
            }
        }
        let nothing = Ending::Nothing { nearest: nearest.1 };
        Ok((ways, if best_m.is_finite() { Ending::Length(best_m) } else { nothing }))
    }

    /// From the goal back through what the search came to: the tiles of all ways that are short enough, and these.
    fn back(
        &mut self,
        to: &End,
        there: &Ways,
        best_m: f64,
        ends: &BTreeSet<Tile>,
    ) -> Result<[BTreeSet<Tile>; WIDTHS.len()], PlanError> {
        let mut tiles = WIDTHS.map(|_| ends.clone());
        let (mut ways, mut looked) = (Ways::default(), 0_usize);
        to.doors.iter().for_each(|(node, length_m)| ways.put(*node, *length_m, 0.0));
        while let Some(Reverse((bits, node))) = ways.heap.pop() {
            let length_m = ways.length_m(node);
            let all_m = there.length_m(node) + length_m;
            if length_m.to_bits() < bits || all_m > most_m(WIDTHS[0], best_m) {
                continue;
            }
            looked += 1;
            if looked.is_multiple_of(DOORS_BETWEEN_LOOKS) {
                self.cancel.check()?;
            }
            for (width, tiles) in WIDTHS.into_iter().zip(&mut tiles) {
                if all_m <= most_m(width, best_m) {
                    tiles.insert(self.tiles[node.0 as usize].0);
                }
            }
            self.look_onward(node)?;
            for (next, step_m) in &self.onward {
                ways.put(*next, length_m + step_m, 0.0);
            }
        }
        Ok(tiles)
    }
}
