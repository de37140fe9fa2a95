//! `chart export-grid` and `export-vertices`: CSV, or a table of SQLite with the place in radians as its key.

use super::ask::{MOST_M, index, place, within};
use crate::cli::data::Progress;
use crate::cli::say::{counted, say};
use anyhow::{Context as _, ensure};
use chartdb::ChartDb;
use chartdb::export::{self, Adapt, Grid};
use clap::Args;
use rusqlite::{Connection, params};
use serde_json::json;
use std::fs::{self, File};
use std::io::{BufWriter, Write};
use std::path::{Path, PathBuf};
use units::LatLon;

/// Most points of a grid: some hours of work.
const MOST_POINTS: u64 = 200_000_000;
/// Smaller distances of points are finer than any chart (m).
const LEAST_SPACING_M: f64 = 0.1;

#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Examples:
  lutra-server chart export-grid --from 63.40,10.20 --to 63.48,10.50 --spacing 50 -o grid.csv
  lutra-server chart export-grid --from 63.40,10.20 --to 63.48,10.50 --spacing 2 --deep 20 --coarsest 64 -o grid.db

Land and places without data are left out. A file that ends in .db or .sqlite gets a table depth_grid with
latitude and longitude in radians as its key; any other gets CSV in degrees."
)]
pub(super) struct GridArguments {
    /// South-western corner in degrees.
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true)]
    from: LatLon,
    /// North-eastern corner in degrees.
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true)]
    to: LatLon,
    /// Distance of points (m).
    #[arg(long, value_name = "M", value_parser = spacing)]
    spacing: f64,
    /// Do not divide squares that are everywhere at least this deep (m): fine where shallow, coarse where deep.
    /// Each square then has its shallowest depth.
    #[arg(long, value_name = "M", requires = "coarsest")]
    deep: Option<f64>,
    /// Side of the largest squares (m).
    #[arg(long, value_name = "M", requires = "deep")]
    coarsest: Option<f64>,
    /// The file to write; one that is there is replaced.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

#[derive(Debug, Args)]
#[command(
    allow_negative_numbers = true,
    after_help = "Example:\n  lutra-server chart export-vertices --spacing 5 --deepest 20 -o contours.csv"
)]
pub(super) struct VerticesArguments {
    /// Points are no farther apart than this (m).
    #[arg(long, value_name = "M", default_value_t = 5.0, value_parser = spacing)]
    spacing: f64,
    /// Leave out areas whose least depth is more than this (m).
    #[arg(long, value_name = "M", default_value_t = 20.0)]
    deepest: f64,
    /// The file to write; one that is there is replaced.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
}

fn spacing(text: &str) -> Result<f64, String> {
    within(text, LEAST_SPACING_M, MOST_M)
}

/// Rows of four numbers and a text or number, into CSV or a table.
enum Sink {
    Csv(BufWriter<File>),
    Table(Connection, &'static str),
}

struct Row<'a> {
    at: LatLon,
    least_m: f64,
    greatest_m: Option<f64>,
    last: &'a dyn std::fmt::Display,
}

impl Sink {
    fn make(path: &Path, table: &'static str, last: &str) -> anyhow::Result<Self> {
        let ending = path.extension().map(|ending| ending.to_string_lossy().to_ascii_lowercase());
        if !matches!(ending.as_deref(), Some("db" | "sqlite")) {
            return Ok(Self::csv(path, last)?);
        }
        fs::remove_file(part(path)).ok();
        let connection = Connection::open(part(path))?;
        let insert = if table == "depth_grid" {
            connection.execute_batch(
                "CREATE TABLE depth_grid (Lat REAL NOT NULL, Lon REAL NOT NULL, DRVAL1 REAL NOT NULL, \
                 DRVAL2 REAL, size_m REAL NOT NULL, PRIMARY KEY (Lat, Lon)) WITHOUT ROWID;
                 CREATE INDEX depth_grid_depth ON depth_grid (DRVAL1);",
            )?;
            "INSERT OR REPLACE INTO depth_grid VALUES (?1, ?2, ?3, ?4, ?5)"
        } else {
            // Neighbours share the vertices of their border, so the position cannot be a key.
            connection.execute_batch(
                "CREATE TABLE contour_vertices (Lat REAL NOT NULL, Lon REAL NOT NULL, DRVAL1 REAL NOT NULL, \
                 DRVAL2 REAL, chart TEXT NOT NULL);
                 CREATE INDEX contour_vertices_place ON contour_vertices (Lat, Lon);",
            )?;
            "INSERT INTO contour_vertices VALUES (?1, ?2, ?3, ?4, ?5)"
        };
        connection.execute_batch("BEGIN")?;
        Ok(Self::Table(connection, insert))
    }

    fn csv(path: &Path, last: &str) -> std::io::Result<Self> {
        let mut file = BufWriter::new(File::create(part(path))?);
        writeln!(file, "lat_deg,lon_deg,least_m,greatest_m,{last}")?;
        Ok(Self::Csv(file))
    }

    fn put(&mut self, row: &Row<'_>) -> anyhow::Result<()> {
        match self {
            Self::Csv(file) => {
                let greatest = row.greatest_m.map(|depth_m| depth_m.to_string()).unwrap_or_default();
                let (lat, lon) = (row.at.lat_deg(), row.at.lon_deg());
                writeln!(file, "{lat:.9},{lon:.9},{},{greatest},{}", row.least_m, row.last)?;
            }
            Self::Table(connection, insert) => {
                let (lat, lon) = (row.at.lat_rad(), row.at.lon_rad());
                let last = row.last.to_string();
                connection.prepare_cached(insert)?.execute(params![
                    lat,
                    lon,
                    row.least_m,
                    row.greatest_m,
                    last
                ])?;
            }
        }
        Ok(())
    }

    /// Renames the file to its final name, now that it is complete.
    fn finish(self, path: &Path) -> anyhow::Result<()> {
        match self {
            Self::Csv(file) => file.into_inner()?.sync_all()?,
            Self::Table(connection, _) => {
                connection.execute_batch("COMMIT")?;
                connection.close().map_err(|(_, error)| error)?;
            }
        }
        fs::rename(part(path), path).with_context(|| path.display().to_string())
    }
}

fn part(path: &Path) -> PathBuf {
    let mut name = path.as_os_str().to_owned();
    name.push(".part");
    name.into()
}

/// Writes the rows of `each`; a file that fails is removed.
fn write(
    path: &Path,
    json: bool,
    table: &'static str,
    last: &str,
    each: impl FnOnce(&mut dyn FnMut(&Row<'_>) -> bool) -> anyhow::Result<u64>,
) -> anyhow::Result<()> {
    let mut sink = Sink::make(path, table, last).with_context(|| path.display().to_string())?;
    let mut failed = None;
    let outcome = each(&mut |row| match sink.put(row) {
        Ok(()) => true,
        Err(error) => {
            failed = Some(error);
            false
        }
    });
    let outcome = match failed {
        Some(error) => Err(error.context(path.display().to_string())),
        None => outcome.and_then(|count| sink.finish(path).map(|()| count)),
    };
    if outcome.is_err() {
        fs::remove_file(part(path)).ok();
    }
    let count = outcome?;
    if json {
        say!("{}", json!({"file": path, "rows": count}));
    } else {
        say!("{}: {}", path.display(), counted(count, "row"));
    }
    Ok(())
}

pub(super) fn grid(db: &Path, json: bool, arguments: &GridArguments) -> anyhow::Result<()> {
    let (from, to) = (arguments.from, arguments.to);
    ensure!(
        from.lat_deg() < to.lat_deg() && from.lon_deg() < to.lon_deg(),
        "--from is the south-western corner and --to the north-eastern; a box over 180° is to be cut in two"
    );
    let adapt = match (arguments.deep, arguments.coarsest) {
        (Some(deep_m), Some(coarsest_m)) => Some(Adapt { deep_m, coarsest_m }),
        _ => None,
    };
    let grid = Grid { south_west: from, north_east: to, spacing_m: arguments.spacing, adapt };
    let points = bounded(&grid)?;
    let index = index(db)?;
    let mut progress = Progress::new();
    write(&arguments.output, json, "depth_grid", "size_m", |put| {
        let looked = &mut |share: f64| progress.tell(|| format!("{:.0} % of {points} points", 100.0 * share));
        let count = export::grid(&index, &grid, looked, &mut |row| {
            put(&Row { at: row.at, least_m: row.least_m, greatest_m: row.greatest_m, last: &row.size_m })
        });
        drop(progress);
        Ok(count)
    })
}

/// The points of a grid.
///
/// # Errors
/// They are more than can be looked at.
fn bounded(grid: &Grid) -> anyhow::Result<u64> {
    let points = grid.points();
    // As many squares on the same box.
    let spacing_m = grid.spacing_m * (points as f64 / MOST_POINTS as f64).sqrt();
    ensure!(
        points <= MOST_POINTS,
        "--spacing {}: the box has {points} points, and {MOST_POINTS} are the most: take {:.1} m or more, or a smaller box",
        grid.spacing_m,
        (spacing_m * 10.0).ceil() / 10.0
    );
    Ok(points)
}

pub(super) fn vertices(db: &Path, json: bool, arguments: &VerticesArguments) -> anyhow::Result<()> {
    let charts = ChartDb::open(db)?;
    write(&arguments.output, json, "contour_vertices", "chart", |put| {
        let (spacing_m, deepest_m) = (arguments.spacing, arguments.deepest);
        Ok(export::vertices(&charts, spacing_m, deepest_m, &mut |row| {
            put(&Row { at: row.at, least_m: row.least_m, greatest_m: row.greatest_m, last: &row.chart })
        })?)
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_without_end_is_refused_with_the_spacing_that_is_possible() {
        let corner = |lat_deg, lon_deg| LatLon::from_deg(lat_deg, lon_deg).unwrap();
        let (south_west, north_east) = (corner(63.40, 10.20), corner(63.48, 10.50));
        let grid = |spacing_m, adapt| Grid { south_west, north_east, spacing_m, adapt };
        assert!((50_000..60_000).contains(&bounded(&grid(50.0, None)).unwrap()));
        // Those of the finest squares count also where deep water has coarser ones.
        let adapt = Some(Adapt { deep_m: 20.0, coarsest_m: 64.0 });
        assert!((33_000_000..36_000_000).contains(&bounded(&grid(2.0, adapt)).unwrap()));
        let refused = bounded(&grid(0.1, None)).unwrap_err().to_string();
        assert!(
            refused.contains("200000000 are the most: take 0.9 m or more, or a smaller box"),
            "{refused}"
        );
        assert!(bounded(&grid(0.9, None)).is_ok());
        assert_eq!(spacing("0.001"), Err("0.1 to 10000 m".to_owned()));
    }
}
