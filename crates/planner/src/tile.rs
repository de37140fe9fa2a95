//! The plane of a long way as squares.

use crate::plane::Point;
use crate::region::Region;
use std::collections::BTreeSet;
use std::sync::Arc;
use units::LatLon;

/// A square of a plane, by the numbers of its column and row.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub(crate) struct Tile {
    column: i32,
    row: i32,
}

/// A border of a tile.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub(crate) enum Border {
    West,
    East,
    South,
    North,
}

pub(crate) const BORDERS: [Border; 4] = [Border::West, Border::East, Border::South, Border::North];

impl Border {
    pub(crate) fn opposite(self) -> Self {
        match self {
            Self::West => Self::East,
            Self::East => Self::West,
            Self::South => Self::North,
            Self::North => Self::South,
        }
    }

    /// Where a point of the border lies along it (m).
    pub(crate) fn along_m(self, at: Point) -> f64 {
        match self {
            Self::West | Self::East => at.y,
            Self::South | Self::North => at.x,
        }
    }

    /// How far a point of a region lies inside of this border of it (m).
    pub(crate) fn inside_m(self, region: &Region, at: Point) -> f64 {
        match self {
            Self::West => at.x - region.min.x,
            Self::East => region.max.x - at.x,
            Self::South => at.y - region.min.y,
            Self::North => region.max.y - at.y,
        }
    }

    /// The point of this border of a region that lies so far along it (m).
    pub(crate) fn point(self, region: &Region, along_m: f64) -> Point {
        match self {
            Self::West => Point { x: region.min.x, y: along_m },
            Self::East => Point { x: region.max.x, y: along_m },
            Self::South => Point { x: along_m, y: region.min.y },
            Self::North => Point { x: along_m, y: region.max.y },
        }
    }
}

impl Tile {
    pub(crate) fn beside(self, border: Border) -> Self {
        let Self { column, row } = self;
        match border {
            Border::West => Self { column: column - 1, row },
            Border::East => Self { column: column + 1, row },
            Border::South => Self { column, row: row - 1 },
            Border::North => Self { column, row: row + 1 },
        }
    }
}

/// Squares around the middle of a plane.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Grid {
    /// The middle of the plane: a corner of four tiles.
    pub(crate) middle: LatLon,
    /// Side of a tile (m).
    pub(crate) tile_m: f64,
}

impl Grid {
    /// The tile that holds a point.
    pub(crate) fn tile(&self, at: Point) -> Tile {
        // Saturates far beyond any plane.
        let number = |value: f64| (value / self.tile_m).floor() as i32;
        Tile { column: number(at.x), row: number(at.y) }
    }

    /// Tiles that come into a region.
    pub(crate) fn tiles_in(&self, region: Region) -> impl Iterator<Item = Tile> {
        let (least, most) = (self.tile(region.min), self.tile(region.max));
        let rows = move |column: i32| (least.row..=most.row).map(move |row| Tile { column, row });
        (least.column..=most.column).flat_map(rows)
    }

    pub(crate) fn region(&self, tile: Tile) -> Region {
        let corner = |column: i32, row: i32| Point {
            x: f64::from(column) * self.tile_m,
            y: f64::from(row) * self.tile_m,
        };
        Region { min: corner(tile.column, tile.row), max: corner(tile.column + 1, tile.row + 1) }
    }
}

/// Some tiles of a grid.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Tiles {
    pub(crate) grid: Grid,
    pub(crate) tiles: Arc<BTreeSet<Tile>>,
}
