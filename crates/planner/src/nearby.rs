//! Which of many short pieces lie near one, while they are added one after another: each in the square of its middle.

use crate::plane::Point;
use crate::region::Region;

/// So many squares at most.
const MOST_SQUARES: f64 = 4e6;
const NONE: u32 = u32::MAX;

/// Pieces by squares.
pub(crate) struct Nearby {
    origin: Point,
    size_m: f64,
    columns: usize,
    rows: usize,
    /// Of each square its newest piece.
    newest: Vec<u32>,
    settled: Vec<bool>,
    /// Of each piece the one of its square that was added before it, and the marks of both and of all before.
    before: Vec<(u32, u8)>,
}

impl Nearby {
    /// For pieces in a region; squares are larger than asked where there were too many. What lies outside of it counts as in
    /// its outermost squares.
    pub(crate) fn new(region: Region, size_m: f64) -> Self {
        let size_m = size_m.max((region.area() / MOST_SQUARES).sqrt());
        let (wide_m, high_m) = (region.max.x - region.min.x, region.max.y - region.min.y);
        // Within the greatest number of squares but for one row and one column.
        let [columns, rows] = [wide_m, high_m].map(|length_m| (length_m / size_m) as usize + 1);
        let (newest, settled) = (vec![NONE; columns * rows], vec![false; columns * rows]);
        Self { origin: region.min, size_m, columns, rows, newest, settled, before: Vec::new() }
    }

    pub(crate) fn size_m(&self) -> f64 {
        self.size_m
    }

    /// Adds the next piece to a square, with marks of its own.
    pub(crate) fn add(&mut self, square: usize, mark: u8) {
        let before = self.newest[square];
        let marks = self.before.get(before as usize).map_or(mark, |(_, marks)| marks | mark);
        self.before.push((before, marks));
        self.newest[square] = self.before.len() as u32 - 1;
    }

    /// The marks of a piece and of all that were added to its square before it.
    pub(crate) fn mark(&self, piece: u32) -> u8 {
        self.before[piece as usize].1
    }

    /// The newest piece in a square.
    pub(crate) fn newest(&self, square: usize) -> Option<u32> {
        Some(self.newest[square]).filter(|piece| *piece != NONE)
    }

    /// Notes whether more pieces in a square may tell something new.
    pub(crate) fn settle(&mut self, square: usize, settled: bool) {
        self.settled[square] = settled;
    }

    pub(crate) fn is_settled(&self, square: usize) -> bool {
        self.settled[square]
    }

    /// The squares that come within a distance of a point.
    pub(crate) fn around(&self, at: Point, within_m: f64) -> impl Iterator<Item = usize> + '_ {
        let columns = self.column(at.x - within_m)..=self.column(at.x + within_m);
        let rows = self.row(at.y - within_m)..=self.row(at.y + within_m);
        rows.flat_map(move |row| columns.clone().map(move |column| self.square(column, row)))
    }

    /// The square of a point.
    pub(crate) fn square_of(&self, at: Point) -> usize {
        self.square(self.column(at.x), self.row(at.y))
    }

    /// The piece of the same square that was added before this one.
    pub(crate) fn earlier(&self, piece: u32) -> Option<u32> {
        Some(self.before[piece as usize].0).filter(|before| *before != NONE)
    }

    // Saturate at 0.
    fn column(&self, x: f64) -> usize {
        (((x - self.origin.x) / self.size_m) as usize).min(self.columns - 1)
    }

    fn row(&self, y: f64) -> usize {
        (((y - self.origin.y) / self.size_m) as usize).min(self.rows - 1)
    }

    fn square(&self, column: usize, row: usize) -> usize {
        row * self.columns + column
    }
}
