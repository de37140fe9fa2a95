//! The same way on the cells of a grid, and the cells for other planners.

use crate::table::Row;
use planner::Cancel;
use planner::classic::{ClassicGrid, ClassicRoute, Neighbours, VaryingGrid};
use std::path::Path;
use std::time::Instant;
use units::LatLon;

/// A* between two places, with either kind of neighbours, on a grid that took so long to lay out (ms) and with its open water joined
/// to coarse cells.
pub(crate) fn by_a_star(water: &str, (grid, laid_ms): (&ClassicGrid, f64), [from, to]: [LatLon; 2]) {
    let begun = Instant::now();
    let varying = VaryingGrid::new(grid);
    let joined_ms = ms(begun);
    for (name, neighbours) in [("8", Neighbours::Eight), ("16", Neighbours::Sixteen)] {
        let how = (neighbours, 1.0);
        let begun = Instant::now();
        let route = grid.route(from, to, how, &Cancel::never()).unwrap();
        told((water, &format!("classic A*, {name} neighbours")), route.as_ref(), [laid_ms, ms(begun)]);
        let begun = Instant::now();
        let route = varying.route(from, to, how, &Cancel::never()).unwrap();
        let planner = format!("classic A*, {name} neighbours, varying cells");
        told((water, &planner), route.as_ref(), [laid_ms + joined_ms, ms(begun)]);
    }
}

fn ms(begun: Instant) -> f64 {
    begun.elapsed().as_secs_f64() * 1e3
}

fn told((water, planner): (&str, &str), route: Option<&ClassicRoute>, [prepared_ms, took_ms]: [f64; 2]) {
    let Some(ClassicRoute { length_m, opened, closed, .. }) = route else {
        println!("  {planner}: no way");
        return;
    };
    println!("  {planner}: {length_m:.1} m, {took_ms:.0} ms, {opened} opened, {closed} closed");
    let row = Row { water, planner, prepared_ms: Some(prepared_ms), first_ms: took_ms, ..Row::default() };
    Row { length_m: *length_m, nodes: *closed, ..row }.note();
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
