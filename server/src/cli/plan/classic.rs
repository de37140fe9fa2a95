//! `plan route --classic`: the grid search of a 2020 master's thesis beside the exact route, to compare and to teach.

use crate::cli::say::say;
use anyhow::{bail, ensure};
use charts::depth_index::{Demand, DepthIndex, Leg};
use clap::Args;
use planner::classic::{ClassicGrid, ClassicRoute, Neighbours, VaryingGrid};
use planner::{Cancel, Needs, Route};
use serde_json::{Value, json};
use std::time::Instant;
use units::LatLon;

/// Sizes of cells (m) of which the finest is taken that gives no more than so many cells, if none is asked for.
const SIZES_M: [f64; 9] = [2.0, 5.0, 10.0, 20.0, 50.0, 100.0, 200.0, 500.0, 1_000.0];
const CELLS: usize = 1_000_000;
/// The grid reaches so far beyond the exact route: a share of the distance from start to goal, and at least this (m).
const BEYOND: f64 = 0.1;
const LEAST_BEYOND_M: f64 = 500.0;

#[derive(Debug, Args)]
pub(super) struct ClassicArguments {
    /// Compare with the thesis' A* on a grid, in cells of one size and of varying size: length, cells opened and closed, time.
    #[arg(long, conflicts_with_all = ["pairs", "via", "alternatives", "avoid", "within", "objective"])]
    classic: bool,
    /// Side of the finest cells (m) [default: the finest of 2, 5, 10 ... 1000 m that gives a million cells or fewer].
    #[arg(long, value_name = "M", requires = "classic", allow_negative_numbers = true)]
    resolution: Option<f64>,
    /// Neighbours of a cell: 8, or 16 for more directions.
    #[arg(long, value_name = "8|16", requires = "classic", default_value = "8", value_parser = neighbours)]
    neighbours: Neighbours,
    /// How much the distance to the goal counts: 1 for the shortest way on the grid, more to be faster, 0 for Dijkstra's search.
    #[arg(
        long,
        value_name = "W",
        requires = "classic",
        default_value_t = 1.0,
        allow_negative_numbers = true
    )]
    weight: f64,
}

fn neighbours(text: &str) -> Result<Neighbours, String> {
    match text {
        "8" => Ok(Neighbours::Eight),
        "16" => Ok(Neighbours::Sixteen),
        _ => Err("give 8 or 16".to_owned()),
    }
}

/// One search, with what it took.
struct Row {
    name: String,
    cells: Option<usize>,
    length_m: f64,
    effort: Option<[usize; 2]>,
    /// Legs that the check against the chart refuses at the depth alone, of so many.
    refused: [usize; 2],
    prepared_ms: f64,
    took_ms: f64,
}

/// The exact route and those on the grids.
pub(super) struct Comparison {
    rows: Vec<Row>,
    keeps_m: f64,
}

impl ClassicArguments {
    pub(super) fn is_asked(&self) -> bool {
        self.classic
    }

    /// Refuses what no grid is searched by.
    pub(super) fn validate(&self) -> anyhow::Result<()> {
        ensure!((0.0..=100.0).contains(&self.weight), "--weight: give a weight of 0 to 100");
        let resolution_m = self.resolution.unwrap_or(1.0);
        ensure!(resolution_m > 0.0 && resolution_m.is_finite(), "--resolution: give a size above 0 m");
        Ok(())
    }

    /// Searches the grids from where a route begins to where it ends.
    pub(super) fn compared(
        &self,
        index: &DepthIndex,
        (route, took_ms): (&Route, f64),
        needs: &Needs,
        cancel: &Cancel<'_>,
    ) -> anyhow::Result<Comparison> {
        let route = route.shortest.as_deref().unwrap_or(route);
        let places: Vec<LatLon> = route.places().collect();
        let [from, to] = [route.start, route.goal()];
        let beyond_m = (BEYOND * Leg { from, to }.length_m()).max(LEAST_BEYOND_M);
        let fitting_m = || ClassicGrid::fitting((from, &places), beyond_m, &SIZES_M, CELLS);
        let Some(spacing_m) = self.resolution.or_else(fitting_m) else { bail!("--resolution: give a size") };
        let exact = Row {
            name: "exact route".to_owned(),
            cells: None,
            length_m: route.length_m,
            effort: None,
            refused: refused(index, &needs.demand, &places),
            prepared_ms: 0.0,
            took_ms,
        };
        let begun = Instant::now();
        let grid =
            ClassicGrid::covering(index, &needs.demand, (from, &places), (beyond_m, spacing_m), cancel)?;
        let laid_ms = ms(begun);
        for (end, place) in [("start", from), ("goal", to)] {
            ensure!(
                grid.cell_of(place).is_some(),
                "the middle of the {end}'s cell is not deep enough in cells of {spacing_m} m: give a finer --resolution"
            );
        }
        ensure!(
            grid.cell_of(from) != grid.cell_of(to),
            "start and goal lie in one cell of {spacing_m} m: give a finer --resolution"
        );
        let how = (self.neighbours, self.weight);
        let begun = Instant::now();
        let fixed = grid.route(from, to, how, cancel)?;
        let fixed_ms = ms(begun);
        let begun = Instant::now();
        let varying = VaryingGrid::new(&grid);
        let joined_ms = ms(begun);
        let begun = Instant::now();
        let coarse = varying.route(from, to, how, cancel)?;
        let coarse_ms = ms(begun);
        let (Some(fixed), Some(coarse)) = (fixed, coarse) else {
            bail!(
                "no way on cells of {spacing_m} m: the water between is narrower, or leads round beyond the grid; give a finer \
                 --resolution"
            );
        };
        let row = |name, cells, way: &ClassicRoute, [prepared_ms, took_ms]: [f64; 2]| Row {
            name,
            cells: Some(cells),
            length_m: way.places.windows(2).map(|ends| Leg { from: ends[0], to: ends[1] }.length_m()).sum(),
            effort: Some([way.opened, way.closed]),
            refused: refused(index, &needs.demand, &way.places),
            prepared_ms,
            took_ms,
        };
        let [_, coarsest_m] = varying.sides_m();
        let rows = vec![
            exact,
            row(format!("grid of {spacing_m} m"), grid.open_cells(), &fixed, [laid_ms, fixed_ms]),
            row(
                format!("grid of {spacing_m} to {coarsest_m} m"),
                varying.open_cells(),
                &coarse,
                [laid_ms + joined_ms, coarse_ms],
            ),
        ];
        Ok(Comparison { rows, keeps_m: needs.clearance_m })
    }
}

impl Comparison {
    pub(super) fn print(&self) {
        say!(
            "\n{:<24} {:>11} {:>10} {:>10} {:>10} {:>14} {:>12} {:>11}",
            "search",
            "length m",
            "cells",
            "opened",
            "closed",
            "legs refused",
            "prepared ms",
            "search ms"
        );
        for row in &self.rows {
            let [cells, opened, closed] =
                [row.cells, row.effort.map(|[opened, _]| opened), row.effort.map(|[_, closed]| closed)]
                    .map(|count| count.map_or_else(|| "-".to_owned(), |count| count.to_string()));
            let refused = format!("{} of {}", row.refused[0], row.refused[1]);
            say!(
                "{:<24} {:>11.1} {cells:>10} {opened:>10} {closed:>10} {refused:>14} {:>12.1} {:>11.2}",
                row.name,
                row.length_m,
                row.prepared_ms,
                row.took_ms
            );
        }
        say!(
            "legs refused: those that touch shallower water or a danger, of all; a grid looks at the middles of cells alone"
        );
        if self.keeps_m > 0.0 {
            say!(
                "the exact route keeps {:.0} m clear, which ways on a grid do not: --clearance 0 compares like with like; its time \
                 includes preparing the water",
                self.keeps_m
            );
        } else {
            say!("the time of the exact route includes preparing the water");
        }
    }

    pub(super) fn json(&self) -> Value {
        let row = |row: &Row| {
            json!({"search": row.name, "length_m": row.length_m, "cells": row.cells,
                   "opened": row.effort.map(|[opened, _]| opened), "closed": row.effort.map(|[_, closed]| closed),
                   "legs": row.refused[1], "legs_refused": row.refused[0],
                   "prepared_us": (row.prepared_ms * 1e3).round(), "time_us": (row.took_ms * 1e3).round()})
        };
        self.rows.iter().map(row).collect()
    }
}

/// Legs that touch what is not so deep, and all legs.
fn refused(index: &DepthIndex, demand: &Demand, places: &[LatLon]) -> [usize; 2] {
    let is_refused =
        |ends: &&[LatLon]| !index.shallowest_along(Leg { from: ends[0], to: ends[1] }, 0.0, demand).navigable;
    [places.windows(2).filter(is_refused).count(), places.len().saturating_sub(1)]
}

fn ms(begun: Instant) -> f64 {
    begun.elapsed().as_secs_f64() * 1e3
}
