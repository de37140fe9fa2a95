//! GeoPackage 1.3 (OGC 12-128r17): detections as a layer of points, and the tracks of the vessels as a layer of lines.
//!
//! It is a database of SQLite in a file without a name in the data folder, at most 1 GiB, which is sent once it is whole. Times that stand in
//! it are those of the data, so that the same rows give the same bytes. A detection without a place is a row without a geometry.

use super::file::HeardFile;
use super::spool::{full, named, room};
use crate::history;
use api::TrackPoint;
use imc::Address;
use research::{About, ColumnKind, DetectionColumn, Heard, LUTRA_COLUMNS, Value, values};
use rusqlite::types::Value as Cell;
use rusqlite::{Connection, ErrorCode, params, params_from_iter};
use std::fs::File;
use std::io::{self, Seek as _, SeekFrom, Write};
use std::path::{Path, PathBuf};
use store::{DetectionsWanted, Reader, StoreError, TimeRange};
use tables::IsoTime;

/// Bytes of a page.
const PAGE: u64 = 4_096;
/// Positions of a vessel's track at most.
const POSITIONS: usize = 20_000;
/// Rows that are written before the disk is looked at again.
const LOOK_EVERY: u64 = 100_000;

/// What every GeoPackage has, and its layers but for their own columns.
const TABLES: &str = "
CREATE TABLE gpkg_spatial_ref_sys (srs_name TEXT NOT NULL, srs_id INTEGER NOT NULL PRIMARY KEY, organization TEXT NOT NULL,
  organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT);
CREATE TABLE gpkg_contents (table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT UNIQUE,
  description TEXT DEFAULT '', last_change DATETIME NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')), min_x DOUBLE,
  min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER,
  CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id));
CREATE TABLE gpkg_geometry_columns (table_name TEXT NOT NULL, column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL,
  srs_id INTEGER NOT NULL, z TINYINT NOT NULL, m TINYINT NOT NULL,
  CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name), CONSTRAINT uk_gc_table_name UNIQUE (table_name),
  CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) REFERENCES gpkg_contents(table_name),
  CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys (srs_id));
INSERT INTO gpkg_spatial_ref_sys VALUES
  ('Undefined Cartesian SRS', -1, 'NONE', -1, 'undefined', 'undefined Cartesian coordinate reference system'),
  ('Undefined geographic SRS', 0, 'NONE', 0, 'undefined', 'undefined geographic coordinate reference system'),
  ('WGS 84 geodetic', 4326, 'EPSG', 4326, 'GEOGCS[\"WGS 84\",DATUM[\"WGS_1984\",SPHEROID[\"WGS 84\",6378137,298.257223563,AUTHORITY[\"EPSG\",\"7030\"]],AUTHORITY[\"EPSG\",\"6326\"]],PRIMEM[\"Greenwich\",0,AUTHORITY[\"EPSG\",\"8901\"]],UNIT[\"degree\",0.0174532925199433,AUTHORITY[\"EPSG\",\"9122\"]],AUTHORITY[\"EPSG\",\"4326\"]]',
   'longitude and latitude in degrees');
";

const TRACKS: &str = "CREATE TABLE tracks (fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, geom LINESTRING, vessel TEXT, from_utc DATETIME, \
                      to_utc DATETIME, positions INTEGER)";

/// A database on its way.
pub(super) struct GeoPackage {
    database: Connection,
    /// The same file, to be read at the end.
    file: File,
    room: Room,
    insert: String,
    rows: u64,
    of_detections: Layer,
    of_tracks: Layer,
    has_tracks: bool,
    /// When the newest of it came, µs.
    came_us: i64,
}

/// What a layer reaches over: west, south, east, north, degrees.
#[derive(Debug, Clone, Copy, Default)]
struct Layer(Option<[f64; 4]>);

impl Layer {
    fn reach(&mut self, lat_deg: f64, lon_deg: f64) {
        let [west, south, east, north] = self.0.unwrap_or([lon_deg, lat_deg, lon_deg, lat_deg]);
        self.0 = Some([west.min(lon_deg), south.min(lat_deg), east.max(lon_deg), north.max(lat_deg)]);
    }
}

/// Where the database grows, and how far.
struct Room {
    folder: PathBuf,
    most_bytes: u64,
}

impl Room {
    /// What went wrong. A full disk and a full database look alike to SQLite.
    fn failed(&self, error: rusqlite::Error) -> io::Error {
        match error.sqlite_error_code() {
            Some(ErrorCode::DiskFull) => room(&self.folder).err().unwrap_or_else(|| full(self.most_bytes)),
            _ => io::Error::other(error),
        }
    }
}

/// A database with layers that have no rows yet.
fn begun(path: &Path, most_bytes: u64, has_tracks: bool) -> rusqlite::Result<Connection> {
    let database = Connection::open(path)?;
    // Nobody else reads it, and what a crash leaves of it has no name.
    database.execute_batch(&format!(
        "PRAGMA page_size={PAGE}; PRAGMA journal_mode=OFF; PRAGMA synchronous=OFF; PRAGMA locking_mode=EXCLUSIVE; \
         PRAGMA max_page_count={}; PRAGMA application_id=0x47504B47; PRAGMA user_version=10300; BEGIN;",
        most_bytes / PAGE
    ))?;
    database.execute_batch(TABLES)?;
    let columns: Vec<String> = LUTRA_COLUMNS.iter().map(column).collect();
    let create = format!(
        "CREATE TABLE detections (fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, geom POINT, {})",
        columns.join(", ")
    );
    database.execute_batch(&create)?;
    if has_tracks {
        database.execute_batch(TRACKS)?;
    }
    Ok(database)
}

impl GeoPackage {
    /// Without a row yet.
    ///
    /// # Errors
    /// The data folder takes no file, or its disk is full.
    pub(super) fn new(data: &Path, file: &HeardFile) -> io::Result<Self> {
        room(data)?;
        let room = Room { folder: data.to_owned(), most_bytes: file.most_waiting_bytes };
        let has_tracks = file.has_tracks();
        let named_file = tempfile::NamedTempFile::new_in(data).map_err(|error| named(data, &error))?;
        let database =
            begun(named_file.path(), room.most_bytes, has_tracks).map_err(|error| room.failed(error))?;
        let names: Vec<String> = LUTRA_COLUMNS.iter().map(name_of).collect();
        let marks = vec!["?"; LUTRA_COLUMNS.len() + 1].join(",");
        let insert = format!("INSERT INTO detections (geom,{}) VALUES ({marks})", names.join(","));
        let (of_detections, of_tracks) = (Layer::default(), Layer::default());
        let file = named_file.into_file();
        Ok(Self { database, file, room, insert, rows: 0, of_detections, of_tracks, has_tracks, came_us: 0 })
    }

    /// Takes a detection.
    ///
    /// # Errors
    /// The database is as large as it may be, or the disk is full.
    pub(super) fn row(&mut self, heard: &Heard<'_>) -> io::Result<()> {
        self.rows += 1;
        if self.rows.is_multiple_of(LOOK_EVERY) {
            room(&self.room.folder)?;
        }
        let origin = heard.detection.origin;
        self.came_us = self.came_us.max(origin.received.unwrap_or(origin.reported).micros());
        let place = heard.detection.pose.map(|pose| (pose.place.lat_deg(), pose.place.lon_deg()));
        let mut cells = Vec::with_capacity(LUTRA_COLUMNS.len() + 1);
        cells.push(place.map_or(Cell::Null, |(lat_deg, lon_deg)| {
            self.of_detections.reach(lat_deg, lon_deg);
            Cell::Blob(point(lat_deg, lon_deg))
        }));
        values(heard, &mut |value| cells.push(cell(value)));
        let mut insert =
            self.database.prepare_cached(&self.insert).map_err(|error| self.room.failed(error))?;
        insert.execute(params_from_iter(cells)).map_err(|error| self.room.failed(error))?;
        Ok(())
    }

    /// Takes the tracks of the vessels within a time, a row for each part between breaks. `goes_on` is asked before each month of a vessel.
    ///
    /// # Errors
    /// That of `goes_on`, the history cannot be read, or as [`Self::row()`].
    pub(super) fn tracks(
        &mut self,
        data: &Path,
        wanted: &DetectionsWanted,
        range: TimeRange,
        called: &dyn Fn(u16) -> Option<String>,
        goes_on: &mut dyn FnMut() -> store::Result<()>,
    ) -> store::Result<()> {
        let mut reader = Reader::open(data)?;
        let recorded = reader.systems()?;
        let is_wanted =
            |system: &Address| wanted.systems.as_ref().is_none_or(|systems| systems.contains(system));
        for system in recorded.iter().filter(|system| is_wanted(&system.address)) {
            let (points, step_us) =
                history::track_while(&mut reader, system.address, (range, POSITIONS), goes_on)?;
            let name = called(system.address.0).unwrap_or_else(|| system.name.clone());
            for part in history::unbroken(&points, step_us).filter(|part| part.len() > 1) {
                self.track(&name, part).map_err(unwritable)?;
            }
        }
        Ok(())
    }

    fn track(&mut self, vessel: &str, part: &[TrackPoint]) -> io::Result<()> {
        for point in part {
            self.of_tracks.reach(point.lat_deg, point.lon_deg);
        }
        let (Some(first), Some(last)) = (part.first(), part.last()) else { return Ok(()) };
        self.came_us = self.came_us.max(last.time_us);
        let sql = "INSERT INTO tracks (geom,vessel,from_utc,to_utc,positions) VALUES (?,?,?,?,?)";
        let row = params![line(part), vessel, moment(first.time_us), moment(last.time_us), part.len() as i64];
        self.database
            .prepare_cached(sql)
            .map_err(|error| self.room.failed(error))?
            .execute(row)
            .map_err(|error| self.room.failed(error))?;
        Ok(())
    }

    /// Lists the layers, and writes the file.
    ///
    /// # Errors
    /// As [`Self::row()`], or `out` cannot be written.
    pub(super) fn end(mut self, out: &mut dyn Write, about: &About) -> io::Result<()> {
        let changed = moment(about.published_us.unwrap_or(self.came_us));
        let title = if about.title.is_empty() { "Detections of acoustic tags" } else { &about.title };
        self.list("detections", "POINT", title, self.of_detections, &changed)?;
        if self.has_tracks {
            self.list("tracks", "LINESTRING", "Tracks of the vessels", self.of_tracks, &changed)?;
        }
        self.database.execute_batch("COMMIT").map_err(|error| self.room.failed(error))?;
        self.database.close().map_err(|(_, error)| self.room.failed(error))?;
        self.file.seek(SeekFrom::Start(0))?;
        io::copy(&mut self.file, out)?;
        Ok(())
    }

    fn list(&self, table: &str, kind: &str, title: &str, layer: Layer, changed: &str) -> io::Result<()> {
        let [west, south, east, north] = layer.0.map_or([None; 4], |corners| corners.map(Some));
        let sql = "INSERT INTO gpkg_contents (table_name,data_type,identifier,description,last_change,min_x,min_y,max_x,max_y,srs_id) \
                   VALUES (?,'features',?,?,?,?,?,?,?,4326)";
        self.database
            .execute(sql, params![table, table, title, changed, west, south, east, north])
            .map_err(|error| self.room.failed(error))?;
        let sql = "INSERT INTO gpkg_geometry_columns VALUES (?,'geom',?,4326,0,0)";
        self.database.execute(sql, params![table, kind]).map(drop).map_err(|error| self.room.failed(error))
    }
}

/// A name for a column, with its unit: `position_age_s`.
fn name_of(column: &DetectionColumn) -> String {
    let unit = column.unit().filter(|unit| *unit != "count").map(|unit| format!("_{}", unit.to_lowercase()));
    format!("{}{}", column.bare_name(), unit.unwrap_or_default())
}

fn column(column: &DetectionColumn) -> String {
    let kind = match column.kind {
        ColumnKind::Text => "TEXT",
        ColumnKind::Whole => "INTEGER",
        ColumnKind::Real => "DOUBLE",
        ColumnKind::Time => "DATETIME",
    };
    format!("{} {kind}", name_of(column))
}

fn cell(value: Value<'_>) -> Cell {
    match value {
        Value::Whole(value) => value.map_or(Cell::Null, Cell::Integer),
        Value::Text("") => Cell::Null,
        Value::Text(text) => Cell::Text(text.to_owned()),
        Value::Millis(_) | Value::Micros(_) => {
            value.micros().map_or(Cell::Null, |time_us| Cell::Text(moment(time_us)))
        }
        other => other.number().map_or(Cell::Null, Cell::Real),
    }
}

/// `2026-11-21T08:00:00.007Z`: the standard has milliseconds.
fn moment(time_us: i64) -> String {
    let mut out = Vec::new();
    IsoTime::new().write_ms(&mut out, time_us);
    String::from_utf8_lossy(&out).into_owned()
}

/// The begin of a geometry: little-endian, without an envelope or with west, east, south and north, in WGS 84.
fn geometry(envelope: Option<[f64; 4]>, kind: u32) -> Vec<u8> {
    let mut out = b"GP\0".to_vec();
    out.push(if envelope.is_some() { 0b11 } else { 0b01 });
    out.extend_from_slice(&4_326_i32.to_le_bytes());
    envelope.into_iter().flatten().for_each(|bound| out.extend_from_slice(&bound.to_le_bytes()));
    out.push(1);
    out.extend_from_slice(&kind.to_le_bytes());
    out
}

fn point(lat_deg: f64, lon_deg: f64) -> Vec<u8> {
    let mut out = geometry(None, 1);
    out.extend_from_slice(&lon_deg.to_le_bytes());
    out.extend_from_slice(&lat_deg.to_le_bytes());
    out
}

fn line(points: &[TrackPoint]) -> Vec<u8> {
    let mut around = Layer::default();
    for point in points {
        around.reach(point.lat_deg, point.lon_deg);
    }
    let mut out = geometry(around.0.map(|[west, south, east, north]| [west, east, south, north]), 2);
    out.extend_from_slice(&u32::try_from(points.len()).unwrap_or(u32::MAX).to_le_bytes());
    for point in points {
        out.extend_from_slice(&point.lon_deg.to_le_bytes());
        out.extend_from_slice(&point.lat_deg.to_le_bytes());
    }
    out
}

fn unwritable(source: io::Error) -> StoreError {
    StoreError::Io { path: "the export".into(), source }
}
