//! Grids that are drawn by hand or at random, and one of a chart.

use super::*;
use proptest::prelude::*;
use std::cell::Cell;

const SPACING_M: f64 = 10.0;

/// A grid drawn from north to south: `#` is closed.
fn drawn(rows: &[&str]) -> ClassicGrid {
    let open: Vec<bool> = rows.iter().rev().flat_map(|row| row.bytes().map(|cell| cell != b'#')).collect();
    of_cells(rows[0].len(), rows.len(), open)
}

fn of_cells(columns: usize, rows: usize, open: Vec<bool>) -> ClassicGrid {
    let plane = Plane::new(LatLon::from_deg(63.44, 10.4).unwrap());
    let halves_m = [columns, rows].map(|count| 0.5 * SPACING_M * count as f64);
    let grid = ClassicGrid::lay(plane, halves_m, SPACING_M).unwrap();
    assert_eq!((grid.columns, grid.rows), (columns as i64, rows as i64));
    ClassicGrid { open, ..grid }
}

impl ClassicGrid {
    fn place_of(&self, [column, row]: [i64; 2]) -> LatLon {
        self.plane.place(self.middle_of(column, row))
    }

    fn between(&self, ends: [[i64; 2]; 2], how: (Neighbours, f64)) -> Option<ClassicRoute> {
        let [from, to] = ends.map(|cell| self.place_of(cell));
        self.route(from, to, how, &Cancel::never()).unwrap()
    }

    fn varying_between(&self, ends: [[i64; 2]; 2], how: (Neighbours, f64)) -> Option<ClassicRoute> {
        let [from, to] = ends.map(|cell| self.place_of(cell));
        VaryingGrid::new(self).route(from, to, how, &Cancel::never()).unwrap()
    }
}

fn is_near(one_m: f64, other_m: f64) -> bool {
    (one_m - other_m).abs() <= 1e-5 * one_m.max(other_m)
}

#[test]
fn sixteen_neighbours_give_more_directions_and_pass_no_closed_cell() {
    let open = drawn(&["....."; 3]);
    let ends = [[0, 0], [4, 2]];
    let length_m = |grid: &ClassicGrid, neighbours| grid.between(ends, (neighbours, 1.0)).unwrap().length_m;
    let (eight_m, knights_m) = (20.0 + 20.0 * 2_f64.sqrt(), 2.0 * SPACING_M * 5_f64.sqrt());
    assert!(is_near(length_m(&open, Neighbours::Eight), eight_m));
    assert!(is_near(length_m(&open, Neighbours::Sixteen), knights_m));
    assert_eq!(open.between(ends, (Neighbours::Sixteen, 1.0)).unwrap().places.len(), 3);
    // A wall one cell thick: a knight's move would lead over it.
    let walled = drawn(&["..#..", "..#..", "..#.."]);
    assert_eq!(walled.between(ends, (Neighbours::Sixteen, 1.0)), None);
    // Corners that touch let a diagonal through, as in the thesis.
    let corners = drawn(&["..#", ".#.", "#.."]);
    assert!(corners.between([[0, 2], [2, 0]], (Neighbours::Eight, 1.0)).is_some());
}

#[test]
fn cells_opened_and_closed_are_counted() {
    // A straight channel: all three cells are opened once and closed.
    let channel = drawn(&["..."]);
    let route = channel.between([[0, 0], [2, 0]], (Neighbours::Eight, 1.0)).unwrap();
    assert_eq!((route.opened, route.closed, route.places.len()), (3, 3, 3));
    // Dijkstra's search closes all that is nearer than the goal; the heuristic only what lies towards it.
    let open = drawn(&["....................."; 21]);
    let ends = [[10, 10], [20, 10]];
    let closed = |weight| open.between(ends, (Neighbours::Eight, weight)).unwrap().closed;
    assert_eq!(closed(1.0), 11, "those of the way");
    assert!(closed(0.0) > 250, "{}", closed(0.0));
}

#[test]
fn a_greater_weight_closes_fewer_cells_and_is_longer_by_that_factor_at_most() {
    // A pocket in the straight way, from which the heuristic has to come out again.
    let mut rows = vec![".".repeat(41); 41];
    for row in &mut rows[8..33] {
        row.replace_range(30..31, "#");
    }
    for row in [8, 32] {
        rows[row].replace_range(8..31, &"#".repeat(23));
    }
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    let grid = drawn(&rows);
    let found = |weight| grid.between([[12, 22], [40, 20]], (Neighbours::Eight, weight)).unwrap();
    let (exact, hasty) = (found(1.0), found(2.5));
    assert!(hasty.closed < exact.closed, "{} {}", hasty.closed, exact.closed);
    assert!(hasty.length_m >= exact.length_m && hasty.length_m <= 2.5 * exact.length_m);
}

#[test]
fn open_water_is_joined_to_coarse_cells_and_the_shore_stays_fine() {
    let mut rows = vec![".".repeat(128); 128];
    rows[70].replace_range(70..71, "#");
    let rows: Vec<&str> = rows.iter().map(String::as_str).collect();
    let grid = drawn(&rows);
    let varying = VaryingGrid::new(&grid);
    let [finest_m, coarsest_m] = varying.sides_m();
    assert!((finest_m - SPACING_M).abs() < 1e-9 && (coarsest_m - 64.0 * SPACING_M).abs() < 1e-9);
    // Three quarters in one cell each, and of the fourth three of each size down to the finest.
    assert_eq!(varying.open_cells(), 3 + 3 * 6);
    let covered: i64 = varying.leaves.iter().map(|leaf| leaf.side * leaf.side).sum();
    assert_eq!(covered, 128 * 128 - 1);
    let ends = [[3, 5], [120, 90]];
    let fixed = grid.between(ends, (Neighbours::Eight, 1.0)).unwrap();
    let coarse = grid.varying_between(ends, (Neighbours::Eight, 1.0)).unwrap();
    assert!(coarse.closed * 10 < fixed.closed, "{} {}", coarse.closed, fixed.closed);
    assert_eq!((coarse.places[0], coarse.places.last()), (fixed.places[0], fixed.places.last()));
    // Within one coarse cell the way is straight.
    let near = grid.varying_between([[3, 5], [40, 20]], (Neighbours::Eight, 1.0)).unwrap();
    assert_eq!(near.places.len(), 2);
}

#[test]
fn too_many_cells_are_refused_with_a_size_that_will_do() {
    let [from, to] = [(63.0, 9.0), (64.0, 11.0)].map(|(lat, lon)| LatLon::from_deg(lat, lon).unwrap());
    let (plane, halves_m) = around(from, &[to], 1_000.0);
    let lay = |spacing_m| ClassicGrid::lay(plane, halves_m, spacing_m);
    let Err(ClassicError::TooMany { cells, enough_m, .. }) = lay(2.0) else { panic!("not refused") };
    assert!(cells > MOST_CELLS as f64, "{cells}");
    assert!(lay(enough_m).is_ok(), "{enough_m}");
    assert!(lay(2.0).unwrap_err().to_string().contains(&format!("a resolution of {enough_m} m or more")));
    for spacing_m in [0.0, -5.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(lay(spacing_m), Err(ClassicError::Resolution(_))), "{spacing_m}");
    }
    let sizes_m = [2.0, 50.0, 500.0];
    assert_eq!(ClassicGrid::fitting((from, &[to]), 1_000.0, &sizes_m, 10_000_000), Some(50.0));
    assert_eq!(ClassicGrid::fitting((from, &[to]), 1_000.0, &sizes_m, 10), Some(500.0));
}

#[test]
fn an_answer_that_is_no_longer_wanted_is_not_looked_for() {
    let grid = drawn(&[".".repeat(200).as_str(); 200]);
    let looks = Cell::new(0);
    let wanted = || {
        looks.set(looks.get() + 1);
        looks.get() < 3
    };
    let [from, to] = [[0, 0], [199, 150]].map(|cell| grid.place_of(cell));
    let how = (Neighbours::Eight, 0.0);
    assert_eq!(grid.route(from, to, how, &Cancel::unless(&wanted)), Err(PlanError::Cancelled));
    assert_eq!(looks.get(), 3);
}

proptest! {
    /// Weight 1 finds no longer way than Dijkstra's search, more directions no longer one, and the varying grid
    /// connects the same.
    #[test]
    fn ways_on_random_grids(
        columns in 1_usize..40,
        rows in 1_usize..40,
        seed in prop::collection::vec(0_u8..100, 1600),
        closed in 0_u8..60,
        ends in prop::array::uniform4(0.0..1.0_f64),
    ) {
        // Blocks of three by three, so that there is open water to join.
        let open = |cell: usize| seed[(cell / columns / 3) * 40 + cell % columns / 3] >= closed;
        let mut grid = of_cells(columns, rows, (0..columns * rows).map(open).collect());
        let at = |share: f64, count: usize| (share * count as f64) as i64;
        let ends = [[at(ends[0], columns), at(ends[1], rows)], [at(ends[2], columns), at(ends[3], rows)]];
        for [column, row] in ends {
            grid.open[(row * columns as i64 + column) as usize] = true;
        }
        let lengths_m = [Neighbours::Eight, Neighbours::Sixteen].map(|neighbours| {
            let found = [0.0, 1.0].map(|weight| grid.between(ends, (neighbours, weight)));
            let varying = grid.varying_between(ends, (neighbours, 1.0));
            assert_eq!(found[0].is_some(), varying.is_some());
            let [dijkstra, a_star] = found.map(|route| route.map(|route| route.length_m));
            assert_eq!(dijkstra.is_some(), a_star.is_some());
            let (Some(dijkstra_m), Some(a_star_m)) = (dijkstra, a_star) else { return None };
            assert!(is_near(dijkstra_m, a_star_m), "{dijkstra_m} {a_star_m}");
            Some(a_star_m)
        });
        prop_assert_eq!(lengths_m[0].is_some(), lengths_m[1].is_some());
        if let [Some(eight_m), Some(sixteen_m)] = lengths_m {
            prop_assert!(sixteen_m <= eight_m * (1.0 + 1e-5));
        }
    }
}
