//! Which of many sides lie near one, while they are added one after another: a plain grid of squares.

use crate::obstacles::Region;
use crate::plane::Point;

/// So many squares at most.
const MOST_SQUARES: f64 = 2e6;
/// No square is smaller (m).
const LEAST_M: f64 = 10.0;
const NONE: u32 = u32::MAX;

/// Sides by the squares that their boxes meet.
pub(crate) struct Nearby {
    origin: Point,
    size_m: f64,
    columns: usize,
    rows: usize,
    /// Of each square its newest entry.
    newest: Vec<u32>,
    /// A side, and the entry of its square before it.
    entries: Vec<(u32, u32)>,
    /// Of each side at which visit it was given.
    given: Vec<u32>,
    visits: u32,
    added: u32,
}

impl Nearby {
    /// For so many sides in a region; what lies outside of it counts as in its outermost squares.
    pub(crate) fn new(region: Region, size_m: f64, count: usize) -> Self {
        let (wide_m, high_m) = (region.max.x - region.min.x, region.max.y - region.min.y);
        let size_m = size_m.max(LEAST_M).max((wide_m * high_m / MOST_SQUARES).sqrt());
        // Within the greatest number of squares but for one row and one column.
        let [columns, rows] = [wide_m, high_m].map(|length_m| (length_m / size_m) as usize + 1);
        Self {
            origin: region.min,
            size_m,
            columns,
            rows,
            newest: vec![NONE; columns * rows],
            entries: Vec::with_capacity(2 * count),
            given: vec![0; count],
            visits: 0,
            added: 0,
        }
    }

    /// Adds the next side.
    pub(crate) fn add(&mut self, ends: [Point; 2]) {
        for square in self.squares(ends, 0.0) {
            self.entries.push((self.added, self.newest[square]));
            self.newest[square] = self.entries.len() as u32 - 1;
        }
        self.added += 1;
    }

    /// Gives each side that was added and may come within a distance of these ends' box, once.
    pub(crate) fn visit(&mut self, ends: [Point; 2], within_m: f64, mut give: impl FnMut(usize)) {
        self.visits += 1;
        for square in self.squares(ends, within_m) {
            let mut entry = self.newest[square];
            while let Some((side, before)) = self.entries.get(entry as usize).copied() {
                let given = &mut self.given[side as usize];
                if *given != self.visits {
                    *given = self.visits;
                    give(side as usize);
                }
                entry = before;
            }
        }
    }

    /// The squares that a box meets, with so much around it.
    fn squares(&self, [a, b]: [Point; 2], more_m: f64) -> impl Iterator<Item = usize> + use<> {
        let index = |value: f64, origin: f64, count: usize| {
            // Saturates at 0.
            (((value - origin) / self.size_m) as usize).min(count - 1)
        };
        let column = |x: f64| index(x, self.origin.x, self.columns);
        let row = |y: f64| index(y, self.origin.y, self.rows);
        let (west, east) = (column(a.x.min(b.x) - more_m), column(a.x.max(b.x) + more_m));
        let (south, north) = (row(a.y.min(b.y) - more_m), row(a.y.max(b.y) + more_m));
        let columns = self.columns;
        (south..=north).flat_map(move |row| (west..=east).map(move |column| row * columns + column))
    }
}
