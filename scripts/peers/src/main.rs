//! The shortest way by other planners in Rust, on water that the benches of Lutra's planner wrote: `lutra-peers FILE…`.
//! `pathfinding` searches the cells of the grid; `polyanya` the exact lines, where the file has them, without clearance and with
//! none of its legs asked of a chart.

use glam::Vec2;
use polyanya::{Mesh, Triangulation};
use serde_json::Value;
use std::hint::black_box;
use std::io::Write as _;
use std::time::Instant;

/// A way is asked for so many times; the middle one counts.
const ROUNDS: usize = 9;
/// Costs are whole numbers: parts of a cell's side.
const PARTS: f64 = 10_000.0;

struct Grid {
    /// That of its file.
    name: String,
    head: Value,
    columns: usize,
    rows: usize,
    spacing_m: f64,
    open: Vec<u8>,
}

fn main() -> Result<(), String> {
    for file in std::env::args().skip(1) {
        let grid = Grid::read(&file)?;
        println!("{}:", grid.name);
        grid.by_pathfinding();
        grid.by_polyanya();
    }
    Ok(())
}

/// How long the first time and the middle one of some rounds took (ms), and what the last one gave.
fn timed<T>(ask: impl Fn() -> T) -> ([f64; 2], T) {
    let mut took_ms = Vec::new();
    let begun = Instant::now();
    let mut answer = ask();
    let first_ms = begun.elapsed().as_secs_f64() * 1e3;
    for _ in 0..ROUNDS {
        let begun = Instant::now();
        answer = black_box(ask());
        took_ms.push(begun.elapsed().as_secs_f64() * 1e3);
    }
    took_ms.sort_by(f64::total_cmp);
    ([first_ms, took_ms[ROUNDS / 2]], answer)
}

fn pair(value: &Value) -> Option<[f64; 2]> {
    Some([value[0].as_f64()?, value[1].as_f64()?])
}

impl Grid {
    /// A line of JSON, then a byte for each cell.
    fn read(file: &str) -> Result<Self, String> {
        let bytes = std::fs::read(file).map_err(|error| format!("{file}: {error}"))?;
        let end = bytes.iter().position(|byte| *byte == b'\n').ok_or(format!("{file}: it has no head"))?;
        let head: Value = serde_json::from_slice(&bytes[..end]).map_err(|error| format!("{file}: {error}"))?;
        let count = |name: &str| head[name].as_u64().unwrap_or_default() as usize;
        let (columns, rows) = (count("columns"), count("rows"));
        let open = bytes[end + 1..].to_vec();
        if open.len() != columns * rows || open.is_empty() {
            return Err(format!("{file}: {} cells in place of {columns} by {rows}", open.len()));
        }
        let name = file.rsplit('/').next().unwrap_or(file).to_owned();
        Ok(Self { name, spacing_m: head["spacing_m"].as_f64().unwrap_or(1.0), columns, rows, open, head })
    }

    /// Adds a row to the table that `LUTRA_TABLE` names, as Lutra's benches do.
    fn note(&self, planner: &str, prepared_ms: Option<f64>, [first_ms, again_ms]: [f64; 2], length_m: f64) {
        let Some(file) = std::env::var_os("LUTRA_TABLE") else { return };
        let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
        let most = status.lines().find_map(|line| line.strip_prefix("VmHWM:")).unwrap_or_default();
        let most_mib = most.trim().trim_end_matches(" kB").parse::<u64>().unwrap_or(0) >> 10;
        let prepared = prepared_ms.map_or_else(|| "-".to_owned(), |ms| format!("{ms:.2}"));
        let (water, nodes) = (&self.name, "-");
        let row = format!(
            "{water}\t{planner}\t{prepared}\t{first_ms:.2}\t{again_ms:.2}\t{length_m:.1}\t{nodes}\t{most_mib}\n"
        );
        let table = std::fs::File::options().create(true).append(true).open(&file);
        if let Err(error) = table.and_then(|mut table| table.write_all(row.as_bytes())) {
            eprintln!("{}: {error}", file.to_string_lossy());
        }
    }

    /// A* over eight neighbours; a diagonal step passes between closed cells as those of the others do.
    fn by_pathfinding(&self) {
        let end = |name: &str| pair(&self.head[name]).map(|at| (at[0] as i32, at[1] as i32));
        let (Some(from), Some(to)) = (end("from"), end("to")) else { return };
        let is_open = |(x, y): (i32, i32)| {
            let within = x >= 0 && y >= 0 && (x as usize) < self.columns && (y as usize) < self.rows;
            within && self.open[y as usize * self.columns + x as usize] == 1
        };
        let (straight, across) = (PARTS as u64, (PARTS * std::f64::consts::SQRT_2) as u64);
        let beside = |&(x, y): &(i32, i32)| {
            let steps = (-1..=1).flat_map(move |dx| (-1..=1).map(move |dy| (dx, dy)));
            steps.filter(|step| *step != (0, 0)).filter_map(move |(dx, dy)| {
                let cost = if dx != 0 && dy != 0 { across } else { straight };
                is_open((x + dx, y + dy)).then_some(((x + dx, y + dy), cost))
            })
        };
        let left = |&(x, y): &(i32, i32)| {
            let (dx, dy) = (u64::from(x.abs_diff(to.0)), u64::from(y.abs_diff(to.1)));
            across * dx.min(dy) + straight * dx.abs_diff(dy)
        };
        let ask = || pathfinding::directed::astar::astar(&from, beside, left, |at| *at == to);
        let ([first_ms, took_ms], way) = timed(ask);
        match way {
            Some((_, cost)) => {
                let length_m = cost as f64 / PARTS * self.spacing_m;
                println!("  pathfinding, A*, 8 neighbours: {length_m:.1} m, {took_ms:.1} ms");
                self.note("pathfinding, A*, 8 neighbours", None, [first_ms, took_ms], length_m);
            }
            None => println!("  pathfinding, A*: no way"),
        }
    }

    /// The exact lines as obstacles in a square.
    fn by_polyanya(&self) {
        let lines = &self.head["lines"];
        let (Some(half_m), Some(land)) = (lines["half_m"].as_f64(), lines["land"].as_array()) else { return };
        let (Some(from), Some(to)) = (pair(&lines["from"]), pair(&lines["to"])) else { return };
        let at = |[x, y]: [f64; 2]| Vec2::new(x as f32, y as f32);
        let begun = Instant::now();
        let corners = [[-1.0, -1.0], [1.0, -1.0], [1.0, 1.0], [-1.0, 1.0]];
        let corners = corners.map(|[x, y]: [f64; 2]| at([x * half_m, y * half_m]));
        let mut lines = Triangulation::from_outer_edges(&corners);
        for ring in land {
            let ring: Vec<Vec2> = ring.as_array().into_iter().flatten().filter_map(pair).map(at).collect();
            lines.add_obstacle(ring);
        }
        let mut mesh: Mesh = lines.as_navmesh();
        mesh.bake();
        let prepared_ms = begun.elapsed().as_secs_f64() * 1e3;
        let ([first_ms, took_ms], way) = timed(|| mesh.path(at(from), at(to)));
        match way {
            Some(way) => {
                println!(
                    "  polyanya, exact lines: {:.1} m, {took_ms:.3} ms, prepared in {prepared_ms:.0} ms",
                    way.length
                );
                let length_m = f64::from(way.length);
                self.note("polyanya, unchecked", Some(prepared_ms), [first_ms, took_ms], length_m);
            }
            None => println!("  polyanya: no way, prepared in {prepared_ms:.0} ms"),
        }
    }
}
