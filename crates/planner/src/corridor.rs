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
use std::collections::{BTreeSet, BinaryHeap, HashMap};
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

/// A door of a tile.
type Node = (Tile, usize);

/// Where a way begins or ends: which doors it leads to, and how long it is there (m).
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Foot {
    pub(crate) at: Point,
    pub(crate) doors: Vec<(Node, f64)>,
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

/// Ways over doors.
struct Search<'a, 'b> {
    doors: Ask<'a>,
    known: HashMap<Tile, Option<Arc<Doors>>>,
    cancel: &'a Cancel<'b>,
}

/// Finds the corridor between two feet that has a way, looking at so many tiles at most. `direct_m` is how long the way is
/// that leads through no door (m), if there is one.
pub(crate) fn find(
    [from, to]: [&Foot; 2],
    direct_m: Option<f64>,
    doors: Ask<'_>,
    most_tiles: usize,
    cancel: &Cancel<'_>,
) -> Result<Found, PlanError> {
    let mut search = Search { doors, known: HashMap::new(), cancel };
    let is_enclosed = direct_m.is_none() && search.is_enclosed(to, from)?;
    let most_tiles = if is_enclosed { search.known.len() + NEAREST_TILES } else { most_tiles };
    let (lengths_m, ending) = search.forward(from, to, direct_m, most_tiles)?;
    match ending {
        Ending::Length(length_m) => Ok(Found::Corridor(search.back([from, to], &lengths_m, length_m)?)),
        Ending::Nothing { nearest } => Ok(Found::Nothing { nearest }),
        Ending::TooMany { nearest } if is_enclosed => Ok(Found::Nothing { nearest }),
        Ending::TooMany { .. } => Ok(Found::TooMany),
    }
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

/// By length, whose bits order like itself.
type Heap = BinaryHeap<Reverse<(u64, Node)>>;

impl Search<'_, '_> {
    fn doors(&mut self, tile: Tile) -> Result<Option<Arc<Doors>>, PlanError> {
        if let Some(known) = self.known.get(&tile) {
            return Ok(known.clone());
        }
        let doors = (self.doors)(tile)?;
        self.known.insert(tile, doors.clone());
        Ok(doors)
    }

    /// Where one leads on from a door: within its tile and beyond it.
    fn onward(&mut self, (tile, door): Node) -> Result<Vec<(Node, f64)>, PlanError> {
        let Some(here) = self.doors(tile)? else { return Ok(Vec::new()) };
        let mut onward: Vec<(Node, f64)> =
            here.from(door).map(|(other, length_m)| ((tile, other), length_m)).collect();
        let beyond = here.beyond(tile, door);
        if let Some(there) = self.doors(beyond)? {
            onward.extend(there.opposite(&here.list[door]).map(|(other, length_m)| ((beyond, other), length_m)));
        }
        Ok(onward)
    }

    fn at(&mut self, (tile, door): Node) -> Result<Point, PlanError> {
        Ok(self.doors(tile)?.map_or_else(Point::default, |doors| doors.list[door].at))
    }

    /// Whether the water around a foot ends before it has led to the other one, or beyond some tiles.
    fn is_enclosed(&mut self, around: &Foot, other: &Foot) -> Result<bool, PlanError> {
        let mut seen: BTreeSet<Node> = around.doors.iter().map(|(node, _)| *node).collect();
        let mut waiting: Vec<Node> = seen.iter().copied().collect();
        while let Some(node) = waiting.pop() {
            self.cancel.check()?;
            if other.doors.iter().any(|(door, _)| *door == node) || self.known.len() > LOOK_TILES {
                return Ok(false);
            }
            for (next, _) in self.onward(node)? {
                if seen.insert(next) {
                    waiting.push(next);
                }
            }
        }
        Ok(true)
    }

    /// How long the shortest way to each door is (m), for all through which a way to the goal may lead that belongs to the
    /// corridor.
    fn forward(
        &mut self,
        from: &Foot,
        to: &Foot,
        direct_m: Option<f64>,
        most_tiles: usize,
    ) -> Result<(HashMap<Node, f64>, Ending), PlanError> {
        let rest_m: HashMap<Node, f64> = to.doors.iter().copied().collect();
        let mut best_m = direct_m.unwrap_or(f64::INFINITY);
        let mut nearest = (from.at.distance_m(to.at), from.at);
        let (mut lengths_m, mut done, mut heap) = (HashMap::new(), BTreeSet::new(), Heap::new());
        for (node, length_m) in &from.doors {
            self.put(&mut heap, &mut lengths_m, *node, *length_m, to.at)?;
        }
        while let Some(Reverse((bits, node))) = heap.pop() {
            if f64::from_bits(bits) > most_m(WIDTHS[0], best_m) {
                break;
            }
            if !done.insert(node) {
                continue;
            }
            if done.len() % DOORS_BETWEEN_LOOKS == 0 {
                self.cancel.check()?;
            }
            let (length_m, at) = (lengths_m[&node], self.at(node)?);
            nearest = if at.distance_m(to.at) < nearest.0 { (at.distance_m(to.at), at) } else { nearest };
            best_m = rest_m.get(&node).map_or(best_m, |rest_m| best_m.min(length_m + rest_m));
            if self.known.len() > most_tiles {
                return Ok((lengths_m, Ending::TooMany { nearest: nearest.1 }));
            }
            for (next, step_m) in self.onward(node)? {
                self.put(&mut heap, &mut lengths_m, next, length_m + step_m, to.at)?;
            }
        }
        let nothing = Ending::Nothing { nearest: nearest.1 };
        Ok((lengths_m, if best_m.is_finite() { Ending::Length(best_m) } else { nothing }))
    }

    /// Puts a door by, if no shorter way to it is known.
    fn put(
        &mut self,
        heap: &mut Heap,
        lengths_m: &mut HashMap<Node, f64>,
        node: Node,
        length_m: f64,
        goal: Point,
    ) -> Result<(), PlanError> {
        if lengths_m.get(&node).is_none_or(|known_m| length_m < *known_m) {
            lengths_m.insert(node, length_m);
            let all_m = length_m + self.at(node)?.distance_m(goal);
            heap.push(Reverse((all_m.to_bits(), node)));
        }
        Ok(())
    }

    /// From the goal back through what the search came to: the tiles of all ways that are short enough.
    fn back(
        &mut self,
        [from, to]: [&Foot; 2],
        lengths_m: &HashMap<Node, f64>,
        best_m: f64,
    ) -> Result<[BTreeSet<Tile>; WIDTHS.len()], PlanError> {
        let mut tiles = WIDTHS.map(|_| from.tiles.union(&to.tiles).copied().collect::<BTreeSet<Tile>>());
        let (mut back_m, mut done, mut heap) = (HashMap::new(), BTreeSet::new(), Heap::new());
        let put = |heap: &mut Heap, back_m: &mut HashMap<Node, f64>, node: Node, length_m: f64| {
            let Some(there_m) = lengths_m.get(&node) else { return };
            if there_m + length_m <= most_m(WIDTHS[0], best_m)
                && back_m.get(&node).is_none_or(|known_m| length_m < *known_m) {
                back_m.insert(node, length_m);
                heap.push(Reverse((length_m.to_bits(), node)));
            }
        };
        to.doors.iter().for_each(|(node, length_m)| put(&mut heap, &mut back_m, *node, *length_m));
        while let Some(Reverse((_, node))) = heap.pop() {
            if !done.insert(node) {
                continue;
            }
            if done.len() % DOORS_BETWEEN_LOOKS == 0 {
                self.cancel.check()?;
            }
            let length_m = back_m[&node];
            for (width, tiles) in WIDTHS.into_iter().zip(&mut tiles) {
                if lengths_m[&node] + length_m <= most_m(width, best_m) {
                    tiles.insert(node.0);
                }
            }
            for (next, step_m) in self.onward(node)? {
                put(&mut heap, &mut back_m, next, length_m + step_m);
            }
        }
        Ok(tiles)
    }
}
