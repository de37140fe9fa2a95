//! The same way on the cells of a grid, and the cells for other planners.

use planner::classic::{ClassicGrid, Neighbours};
use std::path::Path;
use std::time::Instant;
use units::LatLon;

/// A* between two places, with either kind of neighbours.
pub(crate) fn by_a_star(grid: &ClassicGrid, [from, to]: [LatLon; 2]) {
    for (name, neighbours) in [("8", Neighbours::Eight), ("16", Neighbours::Sixteen)] {
        let begun = Instant::now();
        let Some(route) = grid.route(from, to, neighbours, 1.0) else {
            println!("  no way on the grid");
            continue;
        };
        println!(
            "  A* with {name} neighbours: {:.1} m, {:.0} ms, {} opened, {} closed",
            route.length_m,
            begun.elapsed().as_secs_f64() * 1e3,
            route.opened,
            route.closed
        );
    }
}

/// Writes a line of JSON, then a byte for each cell: 1 where it is open. Planners that take lines find them in the head.
pub(crate) fn write(
    file: &Path,
    grid: &ClassicGrid,
    spacing_m: f64,
    ends: [LatLon; 2],
    lines: &serde_json::Value,
) {
    let ([columns, rows], open) = grid.cells();
    let [from, to] = ends.map(|end| grid.cell_of(end).unwrap());
    let head = serde_json::json!({ "columns": columns, "rows": rows, "spacing_m": spacing_m, "from": from, "to": to, "lines": lines });
    let mut bytes = format!("{head}\n").into_bytes();
    bytes.extend(open.iter().map(|open| u8::from(*open)));
    std::fs::write(file, bytes).unwrap();
}
