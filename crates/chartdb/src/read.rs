//! Reading a chart set: what it holds, and its features as they were imported.

use crate::blob::{self, Shape};
use crate::error::{ChartDbError, Named as _, Result};
use crate::row;
use crate::schema::{self, WHOLE_TABLES};
use charts::coverage::{ChartCoverage, Source};
use charts::s57::{Area, Feature, Geometry, ObjectClass, Path, Sounding};
use rusqlite::{Connection, OpenFlags, Row};
use sha2::{Digest as _, Sha256};
use std::collections::BTreeMap;
use std::path::{Path as FilePath, PathBuf};
use std::time::Duration;

/// How long to wait for other programs that read or write.
pub(crate) const PATIENCE: Duration = Duration::from_secs(5);

/// A chart set, for reading.
#[derive(Debug)]
pub struct ChartDb {
    path: PathBuf,
    connection: Connection,
}

/// What a chart set records of one of its charts.
#[derive(Debug, Clone, PartialEq, serde::Serialize)]
pub struct Chart {
    /// Its number in the database.
    #[serde(skip)]
    pub id: i64,
    /// Name of the cell, or of the file without its ending.
    pub name: String,
    /// `cell`, `soundings`, `land`, `lakes` or `areas`.
    pub kind: String,
    /// SHA-256 of its files and of how they were read.
    pub sha256: String,
    /// Bytes of its files.
    pub bytes: u64,
    /// Edition.
    pub edition: String,
    /// Number of the last update.
    pub update: String,
    /// Compilation scale, 1 : this; 0 if unknown.
    pub scale: u32,
    /// Usage band, 1 overview to 6 berthing; 0 for what is not a cell.
    pub band: u8,
    /// Date of issue (YYYYMMDD).
    pub issued: String,
    /// Datum of depths (S-57 code VERDAT); 0 if unknown.
    pub sounding_datum: u8,
    /// Datum of heights (S-57 code VERDAT); 0 if unknown.
    pub vertical_datum: u8,
    /// Number of features.
    pub features: u64,
    /// Number of vertices and soundings.
    pub vertices: u64,
    /// Whether its depth areas and land tile what it says it covers; `None` for what is not a cell.
    pub skin_holds: Option<bool>,
    /// When it was imported, UTC.
    pub imported: String,
    /// West, south, east and north (degrees); `None` if it holds no position.
    pub bounds_deg: Option<[f64; 4]>,
    /// Its producer's comment.
    pub comment: String,
}

const SELECT_CHART: &str = "SELECT id, name, kind, sha256, bytes, edition, update_no, scale, band, issued, \
     sounding_datum, vertical_datum, features, vertices, skin_holds, imported, min_x, min_y, max_x, max_y, comment \
     FROM cells";

/// Another number when the same charts get another meaning in an index: indexes made before, ashore and
/// aboard, are of another set then, and are rebuilt.
pub(crate) const MEANING: &[u8] = b"lutra charts 2\n";

/// The chart of a name.
pub(crate) fn find_chart(connection: &Connection, name: &str) -> rusqlite::Result<Option<Chart>> {
    let mut select = connection.prepare_cached(&format!("{SELECT_CHART} WHERE name = ?1"))?;
    select.query_map([name], chart)?.next().transpose()
}

/// One line of the import log.
#[derive(Debug, Clone, PartialEq, Eq, serde::Serialize)]
pub struct LogEntry {
    /// When, UTC.
    pub time: String,
    /// The chart.
    pub chart: String,
    /// The file.
    pub file: String,
    /// The feature's record number, where it concerns one.
    pub record: Option<u32>,
    /// What kind of entry: `imported`, `replaced`, `removed`, `notice`, `skin`.
    pub what: String,
    /// What it is.
    pub text: String,
}

/// Copies one consistent state of a set. An import that starts meanwhile waits, and gets an error if it waits too long.
///
/// # Errors
/// When there is no set, it cannot be read, or the copy, which must not be there yet, cannot be written.
pub fn copy(from: &FilePath, to: &FilePath) -> Result<()> {
    let set = ChartDb::open(from)?;
    set.connection.execute("VACUUM INTO ?1", [to.to_string_lossy()]).named(from)?;
    Ok(())
}

impl ChartDb {
    /// Opens a chart set for reading.
    ///
    /// # Errors
    /// When the file does not exist, or is not a chart set.
    pub fn open(path: &FilePath) -> Result<Self> {
        if !path.exists() {
            return Err(ChartDbError::Absent(path.to_owned()));
        }
        if path.is_dir() {
            return Err(ChartDbError::Foreign(path.to_owned()));
        }
        let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
        let open = || {
            let connection = Connection::open_with_flags(path, flags).named(path)?;
            connection.busy_timeout(PATIENCE).named(path)?;
            Self::of(connection, path)
        };
        match open() {
            Err(ChartDbError::Sqlite { source, .. }) if is_half_changed(&source) => {
                undo(path).named(path)?;
                open()
            }
            other => other,
        }
    }

    pub(crate) fn of(connection: Connection, path: &FilePath) -> Result<Self> {
        schema::check(&connection, path)?;
        Ok(Self { path: path.to_owned(), connection })
    }

    pub(crate) fn into_connection(self) -> Connection {
        self.connection
    }

    pub(crate) fn connection(&self) -> &Connection {
        &self.connection
    }

    /// The file.
    pub fn path(&self) -> &FilePath {
        &self.path
    }

    /// The charts by name.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn charts(&self) -> Result<Vec<Chart>> {
        let read = || -> rusqlite::Result<Vec<Chart>> {
            let mut select = self.connection.prepare(&format!("{SELECT_CHART} ORDER BY name"))?;
            select.query_map([], chart)?.collect()
        };
        read().named(&self.path)
    }

    /// The charts by name. Where the set was edited by hand, each is read for its box and the number of its features.
    pub(crate) fn charts_in_full(&self) -> Result<Vec<Chart>> {
        let mut charts = self.charts()?;
        if !self.edited()?.is_empty() {
            for chart in &mut charts {
                // One that cannot be read keeps what is noted of it.
                if let Ok(features) = self.features(chart) {
                    let points = features.iter().flat_map(|feature| feature.geometry.points());
                    let envelope = blob::Envelope::of(points);
                    chart.bounds_deg = envelope.map(|blob::Envelope([w, e, s, n])| [w, s, e, n]);
                    chart.features = features.len() as u64;
                }
            }
        }
        Ok(charts)
    }

    /// The charts of those names, all where none is given.
    ///
    /// # Errors
    /// When no chart has one of the names, or the database cannot be read.
    pub fn charts_named(&self, names: &[String]) -> Result<Vec<Chart>> {
        let all = self.charts()?;
        if names.is_empty() {
            return Ok(all);
        }
        let find = |name: &String| {
            let found = all.iter().find(|chart| chart.name.eq_ignore_ascii_case(name)).cloned();
            found.ok_or_else(|| unknown(name, &all))
        };
        names.iter().map(find).collect()
    }

    /// Number of features by class.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn counts(&self, chart: &Chart) -> Result<BTreeMap<String, u64>> {
        let mut counts = BTreeMap::new();
        for table in WHOLE_TABLES {
            let mut read = || -> rusqlite::Result<()> {
                let statement =
                    format!("SELECT class, count(*) FROM {table} WHERE source = ?1 GROUP BY class");
                let mut select = self.connection.prepare(&statement)?;
                let mut rows = select.query([chart.id])?;
                while let Some(row) = rows.next()? {
                    *counts.entry(row.get(0)?).or_default() += unsigned(row, 1)?;
                }
                Ok(())
            };
            read().named(&self.path)?;
        }
        Ok(counts)
    }

    /// The log of a chart: what was done, dropped or repaired, oldest first.
    ///
    /// # Errors
    /// When the database cannot be read.
    pub fn log(&self, chart: &Chart) -> Result<Vec<LogEntry>> {
        let read = || -> rusqlite::Result<Vec<LogEntry>> {
            let mut select = self.connection.prepare(
                "SELECT time, cell, file, record, what, text FROM import_log WHERE cell = ?1 ORDER BY id",
            )?;
            let entry = |row: &Row<'_>| {
                Ok(LogEntry {
                    time: row.get(0)?,
                    chart: row.get(1)?,
                    file: row.get(2)?,
                    record: row.get(3)?,
                    what: row.get(4)?,
                    text: row.get(5)?,
                })
            };
            select.query_map([&chart.name], entry)?.collect()
        };
        read().named(&self.path)
    }

    /// The features of a chart as they were imported, by record number.
    ///
    /// # Errors
    /// When the database cannot be read, or a row in it is not a valid feature.
    pub fn features(&self, chart: &Chart) -> Result<Vec<Feature>> {
        let mut soundings = self.soundings(chart).named(&self.path)?;
        let mut features = Vec::new();
        for table in WHOLE_TABLES {
            features.extend(self.rows_of(chart, table, "", &mut soundings)?);
        }
        features.sort_by_key(|feature| feature.record);
        Ok(features)
    }

    /// The features of a chart in one table, as far as a condition says; groups of soundings take theirs.
    fn rows_of(
        &self,
        chart: &Chart,
        table: &str,
        condition: &str,
        soundings: &mut BTreeMap<u32, Vec<Sounding>>,
    ) -> Result<Vec<Feature>> {
        let geom = if table == "objects" { "NULL" } else { "geom" };
        let statement = format!(
            "SELECT record, class_code, object, grp, version, attributes, national, links, edges, \
             unreadable, {geom} FROM {table} WHERE source = ?1 {condition} ORDER BY record, fid"
        );
        let mut select = self.connection.prepare_cached(&statement).named(&self.path)?;
        let mut rows = select.query([chart.id]).named(&self.path)?;
        let mut features = Vec::new();
        while let Some(row) = rows.next().named(&self.path)? {
            let record: u32 = row.get(0).named(&self.path)?;
            let fail = || ChartDbError::Damaged {
                path: self.path.clone(),
                chart: chart.name.clone(),
                problem: format!("table {table}, record {record} is not a feature of Lutra's"),
            };
            let mut feature = feature(row).named(&self.path)?.ok_or_else(fail)?;
            if table == "objects"
                && let Some(list) = soundings.remove(&record)
            {
                feature.geometry = Geometry::Soundings(list);
            }
            features.push(feature);
        }
        Ok(features)
    }

    /// The areas of ordered traffic of a chart: of separation schemes and deep-water routes.
    ///
    /// # Errors
    /// When the database cannot be read, or a row in it is not a valid feature.
    pub fn traffic(&self, chart: &Chart) -> Result<Vec<Feature>> {
        let classes = "AND class IN ('TSSLPT', 'TSEZNE', 'TSSCRS', 'TSSRON', 'DWRTPT')";
        self.rows_of(chart, "areas", classes, &mut BTreeMap::new())
    }

    /// What a chart covers, whatever others do: as [`ChartCoverage::of`] has it of all its features, but read alone.
    ///
    /// # Errors
    /// When the database cannot be read, or a row in it is not a valid feature.
    pub fn coverage(&self, chart: &Chart) -> Result<ChartCoverage> {
        let told = self.rows_of(chart, "areas", "AND class = 'M_COVR'", &mut BTreeMap::new())?;
        let told = ChartCoverage::of(chart.source(), &told);
        if !told.areas.is_empty() || told.source.supplement {
            return Ok(told);
        }
        let mut skin = self.rows_of(chart, "skin", "", &mut BTreeMap::new())?;
        skin.sort_by_key(|feature| feature.record);
        Ok(ChartCoverage::of(chart.source(), &skin))
    }

    /// The soundings by record of their feature.
    fn soundings(&self, chart: &Chart) -> rusqlite::Result<BTreeMap<u32, Vec<Sounding>>> {
        let mut select = self.connection.prepare(
            "SELECT record, geom, depth_m FROM soundings WHERE source = ?1 ORDER BY record, part, fid",
        )?;
        let mut rows = select.query([chart.id])?;
        let mut all: BTreeMap<u32, Vec<Sounding>> = BTreeMap::new();
        while let Some(row) = rows.next()? {
            if let Some(Shape::Point(at)) = blob::read(row.get_ref(1)?.as_blob()?) {
                all.entry(row.get(0)?).or_default().push(Sounding { at, depth_m: row.get(2)? });
            }
        }
        Ok(all)
    }

    /// The mark that manual editing left in the set; empty where it was not edited.
    pub(crate) fn edited(&self) -> Result<String> {
        let select = "SELECT value FROM chart_set WHERE key = 'edited'";
        self.connection.query_row(select, [], |row| row.get(0)).named(&self.path)
    }
}

impl Chart {
    /// Digest of its contents.
    pub fn contents(&self) -> String {
        let Self { name, kind, sha256, edition, update, .. } = self;
        [name, kind, sha256, edition, update].map(String::as_str).join("\u{1F}")
    }

    /// The same for an index, in a set that was edited so.
    pub(crate) fn mark(&self, edited: &str) -> [u8; 32] {
        let hash = Sha256::new_with_prefix(MEANING).chain_update(self.contents());
        hash.chain_update("\n").chain_update(edited).finalize().into()
    }

    /// As the depth index names it.
    pub fn source(&self) -> Source {
        Source {
            name: self.name.clone(),
            edition: self.edition.clone(),
            update: self.update.clone(),
            issue_date: self.issued.clone(),
            band: self.band,
            scale: self.scale,
            sounding_datum: self.sounding_datum,
            supplement: matches!(self.kind.as_str(), "soundings" | "land" | "areas"),
        }
    }
}

/// Whether a change of the set was interrupted, as by a power cut, and is not rolled back yet: a reader cannot do that.
fn is_half_changed(error: &rusqlite::Error) -> bool {
    let code = error.sqlite_error().map(|error| error.extended_code);
    code == Some(rusqlite::ffi::SQLITE_READONLY_ROLLBACK)
}

/// Lets SQLite roll back an interrupted transaction; for a writer it does so automatically.
fn undo(path: &FilePath) -> rusqlite::Result<()> {
    let connection = Connection::open_with_flags(path, OpenFlags::SQLITE_OPEN_READ_WRITE)?;
    connection.busy_timeout(PATIENCE)?;
    connection.query_row("SELECT count(*) FROM sqlite_master", [], |_| Ok(()))
}

pub(crate) fn unknown(name: &str, all: &[Chart]) -> ChartDbError {
    let held: Vec<&str> = all.iter().take(20).map(|chart| chart.name.as_str()).collect();
    let held = match all.len() {
        0 => "nothing".to_owned(),
        count if count > held.len() => format!("{} and {} more", held.join(", "), count - held.len()),
        _ => held.join(", "),
    };
    ChartDbError::Unknown { name: name.to_owned(), held }
}

/// SQLite has no unsigned numbers; a negative count is not valid.
fn unsigned(row: &Row<'_>, at: usize) -> rusqlite::Result<u64> {
    Ok(u64::try_from(row.get::<_, i64>(at)?).unwrap_or(0))
}

fn chart(row: &Row<'_>) -> rusqlite::Result<Chart> {
    let sides: [Option<f64>; 4] = [row.get(16)?, row.get(17)?, row.get(18)?, row.get(19)?];
    Ok(Chart {
        id: row.get(0)?,
        name: row.get(1)?,
        kind: row.get(2)?,
        sha256: row.get(3)?,
        bytes: unsigned(row, 4)?,
        edition: row.get(5)?,
        update: row.get(6)?,
        scale: row.get(7)?,
        band: row.get(8)?,
        issued: row.get(9)?,
        sounding_datum: row.get(10)?,
        vertical_datum: row.get(11)?,
        features: unsigned(row, 12)?,
        vertices: unsigned(row, 13)?,
        skin_holds: row.get(14)?,
        imported: row.get(15)?,
        bounds_deg: if let [Some(w), Some(s), Some(e), Some(n)] = sides { Some([w, s, e, n]) } else { None },
        comment: row.get(20)?,
    })
}

/// `None` where the row is not valid.
fn feature(row: &Row<'_>) -> rusqlite::Result<Option<Feature>> {
    let geometry =
        geometry(row.get_ref(8)?.as_blob_or_null()?, row.get(9)?, row.get_ref(10)?.as_blob_or_null()?);
    let attributes = row::read_attributes(row.get_ref(5)?.as_str()?);
    let national = row::read_attributes(row.get_ref(6)?.as_str()?);
    let object = row::read_object(row.get_ref(2)?.as_str()?);
    let links = row::read_links(row.get_ref(7)?.as_str_or_null()?);
    let (Some(geometry), Some(attributes), Some(national), Some(object), Some(links)) =
        (geometry, attributes, national, object, links)
    else {
        return Ok(None);
    };
    Ok(Some(Feature {
        record: row.get(0)?,
        object,
        class: ObjectClass(row.get(1)?),
        group: row.get(3)?,
        version: row.get(4)?,
        attributes,
        national,
        links,
        geometry,
    }))
}

fn geometry(edges: Option<&[u8]>, unreadable: Option<String>, geom: Option<&[u8]>) -> Option<Geometry> {
    let path = |points| Path { points, edges: Vec::new() };
    let lines = |list: Vec<Vec<_>>| -> Option<Vec<Path>> {
        let mut paths: Vec<Path> = list.into_iter().map(path).collect();
        row::read_edges(edges, paths.iter_mut()).then_some(paths)
    };
    let shape = match geom {
        Some(blob) => Some(blob::read(blob)?),
        None => None,
    };
    Some(match (shape, unreadable) {
        (None, None) => Geometry::None,
        (None, Some(reason)) => Geometry::Unreadable { paths: Vec::new(), reason },
        (Some(Shape::Lines(list)), Some(reason)) => Geometry::Unreadable { paths: lines(list)?, reason },
        (Some(Shape::Lines(list)), None) => Geometry::Lines(lines(list)?),
        (Some(Shape::Point(at)), _) => Geometry::Point(at),
        (Some(Shape::Polygons(list)), _) => {
            let mut area = Area::default();
            for rings in list {
                let mut rings = rings.into_iter().map(path);
                area.exteriors.extend(rings.next());
                area.holes.extend(rings);
            }
            let rings = area.exteriors.iter_mut().chain(&mut area.holes);
            if !row::read_edges(edges, rings) {
                return None;
            }
            Geometry::Area(area)
        }
    })
}
