//! Where a long way can go from tile to tile.
//!
//! The water of a long way is too much to be prepared as a whole. Of each tile only its [`Portals`] are kept (the word of
//! navigation meshes for openings between parts): the open stretches of its borders, and how long the ways between them are
//! within the tile. That takes kilobytes, where the triangles of a tile take megabytes.

use crate::mesh::NONE;
use crate::plane::Point;
use crate::room::SeaRoom;
use crate::tile::{BORDERS, Border, Tile};
use crate::{Cancel, PlanError};
use std::collections::BTreeMap;

/// A portal lies within one stretch of a border, between two of these shares of it. Stretches near corners are short: a way around
/// a corner of a tile would otherwise be measured much too long.
const STRETCHES: [f64; 12] = [0.0, 0.02, 0.08, 0.2, 0.32, 0.44, 0.56, 0.68, 0.8, 0.92, 0.98, 1.0];
/// Narrower openings are no portals (m): tiles are cut out one by one, on a grid of centimetres.
const NARROWEST_M: f64 = 0.1;
/// Openings of a stretch are one portal where the way between them is no longer than so many times straight and this share of a tile's
/// side.
const JOINED: f64 = 1.1;
const JOINED_SHARE: f64 = 0.002;
/// What lies so near a border lies on it, and openings so near each other are one (m).
const SAME_M: f64 = 0.02;

/// An opening in the border of a tile.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Portal {
    border: Border,
    /// Which stretch of the border.
    stretch: usize,
    /// Which piece of the tile's water.
    pub(crate) piece: u32,
    /// Where it is open, along the border (m).
    open: Vec<[f64; 2]>,
    /// The middle of its widest opening, and the triangle there.
    pub(crate) at: Point,
    pub(crate) triangle: u32,
}

impl Portal {
    /// Takes another opening in; the place of the portal is in its widest one.
    fn take(&mut self, other: Self) {
        let widest_m = |portal: &Self| portal.open.iter().map(|[from, to]| to - from).fold(0.0, f64::max);
        if widest_m(&other) > widest_m(self) {
            (self.at, self.triangle) = (other.at, other.triangle);
        }
        self.open.extend(other.open);
    }
}

/// What a coarse search knows of a tile.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Portals {
    pub(crate) list: Vec<Portal>,
    /// How long the way from each to each is within the tile (m); infinite without one.
    lengths_m: Vec<f32>,
    /// Straight parts of what ways keep clear of: the memory that the tile's water takes grows with their number.
    pub(crate) barriers: usize,
}

impl Portals {
    /// Of the water of a tile.
    pub(crate) fn of(room: &SeaRoom, cancel: &Cancel<'_>) -> Result<Self, PlanError> {
        let list = portals(room, cancel)?;
        let count = list.len();
        let mut lengths_m = vec![f32::INFINITY; count * count];
        for (one, from) in list.iter().enumerate() {
            cancel.check()?;
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

    /// Without portals, and of a size.
    #[cfg(test)]
    pub(crate) fn of_bytes(bytes: usize) -> Self {
        Self { lengths_m: vec![0.0; bytes / size_of::<f32>()], ..Self::default() }
    }

    /// How much memory they take (bytes).
    pub(crate) fn bytes(&self) -> usize {
        let openings: usize = self.list.iter().map(|portal| portal.open.len()).sum();
        self.list.len() * size_of::<Portal>()
            + openings * size_of::<[f64; 2]>()
            + self.lengths_m.len() * size_of::<f32>()
    }

    /// The portals that a way from one leads to within the tile, and how long it is (m).
    pub(crate) fn onward(&self, portal: usize) -> impl Iterator<Item = (usize, f64)> + '_ {
        let count = self.list.len();
        let row = self.lengths_m[portal * count..(portal + 1) * count].iter();
        row.enumerate()
            .map(|(other, length_m)| (other, f64::from(*length_m)))
            .filter(|(_, length_m)| length_m.is_finite())
    }

    /// The tile beyond a portal.
    pub(crate) fn beyond(&self, tile: Tile, portal: usize) -> Tile {
        tile.beside(self.list[portal].border)
    }

    /// Which portals of the tile beyond a portal of another it leads to, and how far off they are (m).
    pub(crate) fn opposite<'a>(&'a self, portal: &'a Portal) -> impl Iterator<Item = (usize, f64)> + 'a {
        let meets = |one: &[f64; 2], other: &[f64; 2]| one[1].min(other[1]) - one[0].max(other[0]) > SAME_M;
        let leads = move |other: &&Portal| {
            other.border == portal.border.opposite()
                && other.open.iter().any(|one| portal.open.iter().any(|other| meets(one, other)))
        };
        let numbered = self.list.iter().enumerate().filter(move |(_, other)| leads(other));
        numbered.map(|(number, other)| (number, other.at.distance_m(portal.at)))
    }
}

/// Length of the shortest way between two points of a room, each in a triangle (m); infinite without one.
pub(crate) fn length_m(
    room: &SeaRoom,
    from: (Point, u32),
    to: (Point, u32),
    cancel: &Cancel<'_>,
) -> Result<f64, PlanError> {
    let found = room.shortest([from, to], None, cancel)?;
    let length_m = |way: &[Point]| way.windows(2).map(|leg| leg[0].distance_m(leg[1])).sum();
    Ok(found.map_or(f64::INFINITY, |(way, _)| length_m(&way)))
}

/// Sides of triangles of a piece of water on a border, along it (m), and the triangles.
type Sides = BTreeMap<(Border, u32), Vec<([f64; 2], u32)>>;

fn portals(room: &SeaRoom, cancel: &Cancel<'_>) -> Result<Vec<Portal>, PlanError> {
    let mut all = Sides::new();
    for (triangle, beyond) in (0_u32..).zip(&room.mesh.beyond) {
        let corners = room.mesh.triangle(triangle);
        for side in (0..3).filter(|side| beyond[*side] == NONE) {
            add_side(&mut all, room, triangle, [corners[side], corners[(side + 1) % 3]]);
        }
    }
    let mut portals: Vec<Portal> = Vec::new();
    for ((border, piece), mut sides) in all {
        cancel.check()?;
        sides.sort_by(|one, other| one.0[0].total_cmp(&other.0[0]));
        let first = portals.len();
        for open in openings(&sides).into_iter().flat_map(|open| stretches(room, border, open)) {
            let middle_m = f64::midpoint(open[0], open[1]);
            let holds =
                |([from, to], _): &&([f64; 2], u32)| (from - SAME_M..=to + SAME_M).contains(&middle_m);
            let Some((_, triangle)) = sides.iter().find(holds).copied() else { continue };
            let at = room.mesh.within(triangle, border.point(&room.region, middle_m));
            let portal = Portal {
                border,
                stretch: stretch(room, border, middle_m),
                piece,
                open: vec![open],
                at,
                triangle,
            };
            match portals[first..].last_mut() {
                Some(last) if last.stretch == portal.stretch && is_beside(room, last, &portal, cancel)? => {
                    last.take(portal);
                }
                _ => portals.push(portal),
            }
        }
    }
    Ok(portals)
}

/// Adds a side of a triangle where it lies on the border of the room's region.
fn add_side(all: &mut Sides, room: &SeaRoom, triangle: u32, ends: [Point; 2]) {
    let on = |border: &Border| ends.iter().all(|end| border.inside_m(&room.region, *end) < SAME_M);
    for border in BORDERS.into_iter().filter(on) {
        let [a, b] = ends.map(|end| border.along_m(end));
        let key = (border, room.mesh.piece[triangle as usize]);
        all.entry(key).or_default().push(([a.min(b), a.max(b)], triangle));
    }
}

/// Where sides that lie beside each other leave a border open, without what is too narrow (m); sides in order.
fn openings(sides: &[([f64; 2], u32)]) -> Vec<[f64; 2]> {
    let mut open: Vec<[f64; 2]> = Vec::new();
    for ([from, to], _) in sides {
        match open.last_mut() {
            Some(last) if from - last[1] < SAME_M => last[1] = last[1].max(*to),
            _ => open.push([*from, *to]),
        }
    }
    // As a whole: where a stretch ends is no matter of the water.
    open.retain(|[from, to]| to - from > NARROWEST_M);
    open
}

/// Where the stretches of a border begin and end (m).
fn bounds_m(room: &SeaRoom, border: Border) -> [f64; STRETCHES.len()] {
    let (begin, end) = (border.along_m(room.region.min), border.along_m(room.region.max));
    STRETCHES.map(|share| begin + (end - begin) * share)
}

fn stretch(room: &SeaRoom, border: Border, at_m: f64) -> usize {
    bounds_m(room, border).iter().skip(1).take_while(|bound_m| **bound_m < at_m).count()
}

/// An opening in stretches; a shred at the end of a stretch stays with the rest.
fn stretches(room: &SeaRoom, border: Border, [from, to]: [f64; 2]) -> Vec<[f64; 2]> {
    let mut parts = Vec::new();
    let mut begin = from;
    for bound_m in bounds_m(room, border) {
        if bound_m - begin > NARROWEST_M && to - bound_m > NARROWEST_M {
            parts.push([begin, bound_m]);
            begin = bound_m;
        }
    }
    parts.push([begin, to]);
    parts
}

/// Whether an opening is joined with a portal before it by water near the border, so that one length does for both.
fn is_beside(room: &SeaRoom, portal: &Portal, next: &Portal, cancel: &Cancel<'_>) -> Result<bool, PlanError> {
    let side_m = room.region.max.x - room.region.min.x;
    let most_m = JOINED * portal.at.distance_m(next.at) + JOINED_SHARE * side_m;
    Ok(length_m(room, (portal.at, portal.triangle), (next.at, next.triangle), cancel)? <= most_m)
}
