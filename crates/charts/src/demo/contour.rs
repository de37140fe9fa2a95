//! Contours of a sampled sea floor by marching triangles.
//!
//! Each square of the grid is cut into two triangles, over which depth is linear: a contour crosses a triangle
//! in one straight piece and no case is ambiguous (W. Lorensen and H. Cline, SIGGRAPH 1987, in two dimensions).
//! Contours of different depths never touch, because no sample lies at a contour's depth.

/// Samples keep so far from every contour's depth (m).
const KEEP_OFF_M: f64 = 0.04;
/// No crossing leads on.
const NONE: usize = usize::MAX;

/// Depths at the points of a grid, row by row from the south-west.
pub(super) struct Grid {
    pub(super) origin: [f64; 2],
    pub(super) step_m: f64,
    /// Points along x and y.
    pub(super) size: [usize; 2],
    pub(super) depths_m: Vec<f64>,
}

/// A contour; shallower water is on its left.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Contour {
    /// Which of the levels.
    pub(super) level: usize,
    /// Its points; of a closed one the first is not repeated.
    pub(super) points: Vec<[f64; 2]>,
    /// Whether it closes; otherwise it runs from border to border.
    pub(super) closed: bool,
}

impl Grid {
    /// Samples a depth; levels are the depths of the contours, ascending.
    pub(super) fn sample(
        origin: [f64; 2],
        step_m: f64,
        size: [usize; 2],
        levels: &[f64],
        depth_m: impl Fn([f64; 2]) -> f64,
    ) -> Self {
        let mut grid = Self { origin, step_m, size, depths_m: Vec::with_capacity(size[0] * size[1]) };
        for j in 0..size[1] {
            for i in 0..size[0] {
                let depth = depth_m(grid.point(i, j));
                let close = levels.iter().find(|level| (depth - **level).abs() < KEEP_OFF_M);
                // Towards the surface: a chart errs to the shallow side.
                grid.depths_m.push(close.map_or(depth, |level| level - KEEP_OFF_M));
            }
        }
        grid
    }

    /// Where a point of the grid is.
    pub(super) fn point(&self, i: usize, j: usize) -> [f64; 2] {
        [self.origin[0] + self.step_m * i as f64, self.origin[1] + self.step_m * j as f64]
    }

    /// The depth at a point of the grid.
    pub(super) fn depth_m(&self, i: usize, j: usize) -> f64 {
        self.depths_m[j * self.size[0] + i]
    }

    /// All contours, by level.
    pub(super) fn contours(&self, levels: &[f64]) -> Vec<Contour> {
        (0..levels.len()).flat_map(|level| self.contours_of(level, levels[level])).collect()
    }

    fn contours_of(&self, level: usize, depth_m: f64) -> Vec<Contour> {
        // Sides of triangles are numbered by their lower left point: 0 east, 1 north, 2 north-east of it.
        let side = |point: usize, which: usize| point * 3 + which;
        let mut next = vec![NONE; self.depths_m.len() * 3];
        let mut reached = vec![false; next.len()];
        let row = self.size[0];
        for j in 0..self.size[1] - 1 {
            for i in 0..row - 1 {
                let a = j * row + i;
                let (b, c, d) = (a + 1, a + row + 1, a + row);
                let triangles = [
                    [(a, b, side(a, 0)), (b, c, side(b, 1)), (c, a, side(a, 2))],
                    [(a, c, side(a, 2)), (c, d, side(d, 0)), (d, a, side(a, 1))],
                ];
                for sides in triangles {
                    // Anticlockwise round the triangle, a contour enters where it becomes deep and leaves
                    // where it becomes shallow: so the shallow is on its left.
                    let (mut from, mut to) = (NONE, NONE);
                    for (start, end, side) in sides {
                        match (self.depths_m[start] < depth_m, self.depths_m[end] < depth_m) {
                            (true, false) => from = side,
                            (false, true) => to = side,
                            _ => {}
                        }
                    }
                    if from != NONE {
                        next[from] = to;
                        reached[to] = true;
                    }
                }
            }
        }
        let mut contours = Vec::new();
        // Those from the border first; what is left closes.
        for closed in [false, true] {
            for start in 0..next.len() {
                if next[start] == NONE || (!closed && reached[start]) {
                    continue;
                }
                let mut points = vec![self.crossing(start, depth_m)];
                let mut at = start;
                loop {
                    let to = std::mem::replace(&mut next[at], NONE);
                    if to == NONE || to == start {
                        break;
                    }
                    points.push(self.crossing(to, depth_m));
                    at = to;
                }
                contours.push(Contour { level, points, closed });
            }
        }
        contours
    }

    /// Where a depth is on a side of a triangle.
    fn crossing(&self, side: usize, depth_m: f64) -> [f64; 2] {
        let (point, which) = (side / 3, side % 3);
        let (i, j) = (point % self.size[0], point / self.size[0]);
        let (di, dj) = [(1, 0), (0, 1), (1, 1)][which];
        let (a, b) = (self.depth_m(i, j), self.depth_m(i + di, j + dj));
        let t = (depth_m - a) / (b - a);
        let ([ax, ay], [bx, by]) = (self.point(i, j), self.point(i + di, j + dj));
        [ax + (bx - ax) * t, ay + (by - ay) * t]
    }
}
