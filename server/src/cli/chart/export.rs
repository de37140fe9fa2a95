//! `chart export-grid` and `export-vertices`: CSV, or a table of SQLite with the place in radians as its key.

use super::ask::{index, place};
use crate::cli::say::say;
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

#[derive(Debug, Args)]
#[command(after_help = "Examples:
  lutra-server chart export-grid --from 63.40,10.20 --to 63.48,10.50 --spacing 50 -o grid.csv
  lutra-server chart export-grid --from 63.40,10.20 --to 63.48,10.50 --spacing 2 --deep 20 --coarsest 64 -o grid.db

Land and places without data are left out. A file that ends in .db or .sqlite gets a table depth_grid with
latitude and longitude in radians as its key; any other gets CSV in degrees.")]
pub(super) struct GridArguments {
    /// South-western corner in degrees.
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true)]
    from: LatLon,
    /// North-eastern corner in degrees.
    #[arg(long, value_name = "LAT,LON", value_parser = place, allow_hyphen_values = true)]
    to: LatLon,
    /// Distance of points (m).
    #[arg(long, value_name = "M")]
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
    after_help = "Example:\n  lutra-server chart export-vertices --spacing 5 --deepest 20 -o contours.csv"
)]
pub(super) struct VerticesArguments {
    /// Points are no farther apart than this (m).
    #[arg(long, value_name = "M", default_value_t = 5.0)]
    spacing: f64,
    /// Leave out areas whose least depth is more than this (m).
    #[arg(long, value_name = "M", default_value_t = 20.0)]
    deepest: f64,
    /// The file to write; one that is there is replaced.
    #[arg(short, long, value_name = "FILE")]
    output: PathBuf,
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
        say!("{}: {count} rows", path.display());
    }
    Ok(())
}

pub(super) fn grid(db: &Path, json: bool, arguments: &GridArguments) -> anyhow::Result<()> {
    let (from, to) = (arguments.from, arguments.to);
    ensure!(
        from.lat_deg() < to.lat_deg() && from.lon_deg() < to.lon_deg(),
        "--from is the south-western corner and --to the north-eastern; a box over 180° is to be cut in two"
    );
    ensure!(
        arguments.spacing > 0.0 && arguments.spacing.is_finite(),
        "--spacing is a length above 0 in metres"
    );
    let adapt = match (arguments.deep, arguments.coarsest) {
        (Some(deep_m), Some(coarsest_m)) => Some(Adapt { deep_m, coarsest_m }),
        _ => None,
    };
    let grid = Grid { south_west: from, north_east: to, spacing_m: arguments.spacing, adapt };
    let index = index(db)?;
    write(&arguments.output, json, "depth_grid", "size_m", |put| {
        Ok(export::grid(&index, &grid, &mut |row| {
            put(&Row { at: row.at, least_m: row.least_m, greatest_m: row.greatest_m, last: &row.size_m })
        }))
    })
}

pub(super) fn vertices(db: &Path, json: bool, arguments: &VerticesArguments) -> anyhow::Result<()> {
    ensure!(
        arguments.spacing > 0.0 && arguments.spacing.is_finite(),
        "--spacing is a length above 0 in metres"
    );
    let charts = ChartDb::open(db)?;
    write(&arguments.output, json, "contour_vertices", "chart", |put| {
        let (spacing_m, deepest_m) = (arguments.spacing, arguments.deepest);
        Ok(export::vertices(&charts, spacing_m, deepest_m, &mut |row| {
            put(&Row { at: row.at, least_m: row.least_m, greatest_m: row.greatest_m, last: &row.chart })
        })?)
    })
}
