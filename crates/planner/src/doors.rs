//! The sea as squares of one plane, and the doors between them: where a long way can lead.
//!
//! A long way is not looked for in all water at once. The plane is divided into [`Tile`]s; of each only its [`Doors`] are
//! kept, the open stretches of its border and how long the ways between them are within. That takes a few kilobytes, where
//! the triangles of a tile take megabytes, so that the doors of a whole coast fit into memory.

use crate::mesh::NONE;
use crate::obstacles::Region;
use crate::plane::Point;
use crate::room::SeaRoom;
use crate::{Cancel, PlanError, search};
use std::collections::BTreeMap;

/// Side of a tile (m).
pub(crate) const TILE_M: f64 = 20_000.0;
/// A door is within one stretch of a side, between two of these (m): short ones near the corners, so that a way around a
/// corner of a tile is not told to be much longer than it is.
const STRETCHES_M: [f64; 9] = [0.0, 400.0, 1_500.0, 5_000.0, 10_000.0, 15_000.0, 18_500.0, 19_600.0, TILE_M];
/// Narrower openings are no doors (m): tiles are cut out one by one, on a grid of centimetres.
const NARROWEST_M: f64 = 0.1;
/// What lies so near a border lies on it, and openings so near each other are one (m).
const SAME_M: f64 = 0.02;

/// A square of the plane, by the numbers of its column and row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Tile {
    column: i32,
    row: i32,
}

/// A side of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
enum Side {
    West,
    East,
    South,
    North,
}

const SIDES: [Side; 4] = [Side::West, Side::East, Side::South, Side::North];

impl Side {
    fn opposite(self) -> Self {
        match self {
            Self::West => Self::East,
            Self::East => Self::West,
            Self::South => Self::North,
            Self::North => Self::South,
        }
    }
}

impl Tile {
    /// The one that holds a point.
    pub(crate) fn of(at: Point) -> Self {
        // Saturates far beyond any plane.
        let number = |value: f64| (value / TILE_M).floor() as i32;
        Self { column: number(at.x), row: number(at.y) }
    }

    /// Those that come within a distance of a point.
    pub(crate) fn around(at: Point, within_m: f64) -> Vec<Self> {
        let corner = |by_m: f64| Self::of(Point { x: at.x + by_m, y: at.y + by_m });
        let (least, most) = (corner(-within_m), corner(within_m));
        let rows = |column: i32| (least.row..=most.row).map(move |row| Self { column, row });
        (least.column..=most.column).flat_map(rows).collect()
    }

    pub(crate) fn region(self) -> Region {
        let corner =
            |column: i32, row: i32| Point { x: f64::from(column) * TILE_M, y: f64::from(row) * TILE_M };
        Region { min: corner(self.column, self.row), max: corner(self.column + 1, self.row + 1) }
    }

    fn beside(self, side: Side) -> Self {
        let Self { column, row } = self;
        match side {
            Side::West => Self { column: column - 1, row },
            Side::East => Self { column: column + 1, row },
            Side::South => Self { column, row: row - 1 },
            Side::North => Self { column, row: row + 1 },
        }
    }
}

/// An opening in the border of a tile.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Door {
    side: Side,
    /// Which stretch of the side.
    stretch: usize,
    /// Which piece of the tile's water.
    piece: u32,
    /// Where it is open, along the side (m).
    open: Vec<[f64; 2]>,
    /// The middle of its widest opening, and the triangle there.
    pub(crate) at: Point,
    pub(crate) triangle: u32,
}

/// What a coarse search knows of a tile.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Doors {
    pub(crate) list: Vec<Door>,
    /// How long the way from each to each is within the tile (m); infinite where there is none.
    lengths_m: Vec<f32>,
    /// Straight parts of what ways keep clear of: by these the memory of its water goes.
    pub(crate) barriers: usize,
}

impl Doors {
    /// Of the water of a tile.
    pub(crate) fn of(room: &SeaRoom, cancel: &Cancel<'_>) -> Result<Self, PlanError> {
        let list = doors(room);
        let count = list.len();
        let mut lengths_m = vec![f32::INFINITY; count * count];
        for (one, from) in list.iter().enumerate() {
            for (other, to) in list.iter().enumerate().skip(one + 1).filter(|(_, to)| to.piece == from.piece)
            {
                let length_m = length_m(room, (from.at, from.triangle), (to.at, to.triangle), cancel)?;
                // To the metre at 20 km.
                (lengths_m[one * count + other], lengths_m[other * count + one]) =
                    (length_m as f32, length_m as f32);
            }
        }
        Ok(Self { list, lengths_m, barriers: room.barriers() })
    }

    /// The doors that a way from one leads to within the tile, and how long it is (m).
    pub(crate) fn from(&self, door: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let count = self.list.len();
        let row = self.lengths_m[door * count..(door + 1) * count].iter();
        row.enumerate()
            .map(|(other, length_m)| (other, f64::from(*length_m)))
            .filter(|(_, length_m)| length_m.is_finite())
    }

    /// The tile beyond a door.
    pub(crate) fn beyond(&self, tile: Tile, door: usize) -> Tile {
        tile.beside(self.list[door].side)
    }

    /// Which doors of the tile beyond a door of another it leads to, and how far off they are (m).
    pub(crate) fn opposite<'a>(&'a self, door: &'a Door) -> impl Iterator<Item = (usize, f64)> + 'a {
        let meets =
            |one: &[f64; 2], other: &[f64; 2]| one[1].min(other[1]) - one[0].max(other[0]) > NARROWEST_M;
        let leads = move |other: &&Door| {
            other.side == door.side.opposite()
                && other.stretch == door.stretch
                && other.open.iter().any(|one| door.open.iter().any(|other| meets(one, other)))
        };
        let numbered = self.list.iter().enumerate().filter(move |(_, other)| leads(other));
        numbered.map(|(number, other)| (number, other.at.distance_m(door.at)))
    }
}

/// Length of the shortest way between two points of a room, each in a triangle (m); infinite where there is none.
pub(crate) fn length_m(
    room: &SeaRoom,
    from: (Point, u32),
    to: (Point, u32),
    cancel: &Cancel<'_>,
) -> Result<f64, PlanError> {
    let found = search::shortest(&room.mesh, from, to, cancel)?;
    let length_m = |way: &[Point]| way.windows(2).map(|leg| leg[0].distance_m(leg[1])).sum();
    Ok(found.map_or(f64::INFINITY, |(way, _)| length_m(&way)))
}

/// Openings of a piece of water in a stretch of a side, and the triangles there.
type Openings = BTreeMap<(Side, usize, u32), Vec<([f64; 2], u32)>>;

fn doors(room: &SeaRoom) -> Vec<Door> {
    let mut openings = Openings::new();
    for (triangle, beyond) in (0_u32..).zip(&room.mesh.beyond) {
        let corners = room.mesh.triangle(triangle);
        for side in (0..3).filter(|side| beyond[*side] == NONE) {
            add_opening(&mut openings, room, triangle, [corners[side], corners[(side + 1) % 3]]);
        }
    }
    openings.into_iter().filter_map(|(key, parts)| door(room, key, parts)).collect()
}

/// Adds a side of a triangle where it lies on the border of the room's region, in stretches.
fn add_opening(openings: &mut Openings, room: &SeaRoom, triangle: u32, ends: [Point; 2]) {
    let Region { min, max } = room.region;
    let on = |side: Side| {
        let off_m = |at: Point| match side {
            Side::West => at.x - min.x,
            Side::East => max.x - at.x,
            Side::South => at.y - min.y,
            Side::North => max.y - at.y,
        };
        ends.iter().all(|end| off_m(*end) < SAME_M)
    };
    for side in SIDES.into_iter().filter(|side| on(*side)) {
        let [a, b] = ends.map(|end| along(side, end));
        let (least, most) = (a.min(b), a.max(b));
        let begin = along(side, min);
        for (stretch, ends_m) in STRETCHES_M.windows(2).enumerate() {
            let (from, to) = (least.max(begin + ends_m[0]), most.min(begin + ends_m[1]));
            if from >= to {
                continue;
            }
            let key = (side, stretch, room.mesh.piece[triangle as usize]);
            openings.entry(key).or_default().push(([from, to], triangle));
        }
    }
}

fn along(side: Side, at: Point) -> f64 {
    match side {
        Side::West | Side::East => at.y,
        Side::South | Side::North => at.x,
    }
}

/// A door of openings that lie beside each other; `None` if each of them is too narrow.
fn door(
    room: &SeaRoom,
    (side, stretch, piece): (Side, usize, u32),
    mut parts: Vec<([f64; 2], u32)>,
) -> Option<Door> {
    parts.sort_by(|one, other| one.0[0].total_cmp(&other.0[0]));
    let mut open: Vec<[f64; 2]> = Vec::new();
    for ([from, to], _) in &parts {
        match open.last_mut() {
            Some(last) if from - last[1] < SAME_M => last[1] = last[1].max(*to),
            _ => open.push([*from, *to]),
        }
    }
    open.retain(|[from, to]| to - from > NARROWEST_M);
    let widest =
        open.iter().copied().max_by(|one, other| (one[1] - one[0]).total_cmp(&(other[1] - other[0])))?;
    let middle = f64::midpoint(widest[0], widest[1]);
    let (_, triangle) =
        parts.iter().find(|([from, to], _)| (from - SAME_M..=to + SAME_M).contains(&middle))?;
    let Region { min, max } = room.region;
    let at = match side {
        Side::West => Point { x: min.x, y: middle },
        Side::East => Point { x: max.x, y: middle },
        Side::South => Point { x: middle, y: min.y },
        Side::North => Point { x: middle, y: max.y },
    };
    let at = room.mesh.within(*triangle, at);
    Some(Door { side, stretch, piece, open, at, triangle: *triangle })
}
