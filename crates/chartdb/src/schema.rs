//! The tables of a chart set: an OGC GeoPackage 1.3 (OGC 12-128r17) that QGIS opens directly, and Lutra's own.
//!
//! Feature tables by kind of geometry: `skin` (the areas of group 1 that tile the sea and the land), `areas`,
//! `lines`, `points`, `soundings` (one row each) and `points_of_interest`. `objects` holds what has no geometry
//! of its own: collections, and of each group of soundings what they share. Every feature of a cell has exactly
//! one row in `skin`, `areas`, `lines`, `points` or `objects`. `cells` says where they come from, `coverage`
//! where a cell has data, `import_log` what was done, dropped or repaired, `chart_set` what the set is.
//!
//! The triggers that keep the R-trees right call functions that only the editing program has (ST_MinX and its
//! like), so Lutra drops them before it writes and makes them again last. Our own triggers record manual edits,
//! so that the depth index is rebuilt.

use crate::error::{ChartDbError, Named as _, Result};
use rusqlite::{Connection, OptionalExtension as _, params};
use std::path::Path;

/// `GPKG`.
const APPLICATION_ID: i64 = 0x4750_4B47;
/// GeoPackage 1.3.
const GEOPACKAGE_VERSION: i64 = 10_300;
/// Of Lutra's own tables.
const SCHEMA: i64 = 1;

/// Name, type, whether it has depths as third coordinate, and what it is.
pub(crate) const FEATURE_TABLES: [(&str, &str, bool, &str); 6] = [
    ("skin", "MULTIPOLYGON", false, "Depth areas, land and what else tiles the charted surface"),
    ("areas", "MULTIPOLYGON", false, "All other areas"),
    ("lines", "MULTILINESTRING", false, "Lines, and boundaries of areas that do not close"),
    ("points", "POINT", false, "Points"),
    ("soundings", "POINT", true, "Soundings, depth as third coordinate"),
    ("points_of_interest", "POINT", false, "Aids, dangers and depth areas by one point each"),
];

const ATTRIBUTE_TABLES: [(&str, &str); 5] = [
    ("objects", "Features without geometry of their own"),
    ("cells", "Where the features come from"),
    ("coverage", "Where each cell has data"),
    ("import_log", "What was imported, dropped and repaired"),
    ("chart_set", "What this chart set is"),
];

/// Tables that hold whole features.
pub(crate) const WHOLE_TABLES: [&str; 5] = ["skin", "areas", "lines", "points", "objects"];

/// Columns of [`WHOLE_TABLES`]. Those before `attributes` are copies of it for looking and filtering.
pub(crate) const FEATURE_COLUMNS: &str = "source, record, class, class_code, object, grp, version, objnam, \
     nobjnm, drval1, drval2, valsou, valdco, watlev, quasou, scamin, sordat, attributes, national, links, \
     edges, unreadable, cell, edition, update_no, scale, band, issued, zone";

const FEATURE_DEFINITIONS: &str = "source INTEGER NOT NULL, record INTEGER NOT NULL, class TEXT NOT NULL, \
     class_code INTEGER NOT NULL, object TEXT NOT NULL, grp INTEGER NOT NULL, version INTEGER NOT NULL, \
     objnam TEXT, nobjnm TEXT, drval1 REAL, drval2 REAL, valsou REAL, valdco REAL, watlev INTEGER, \
     quasou TEXT, scamin INTEGER, sordat TEXT, attributes TEXT NOT NULL, national TEXT NOT NULL, links TEXT, \
     edges BLOB, unreadable TEXT, cell TEXT NOT NULL, edition TEXT NOT NULL, update_no TEXT NOT NULL, \
     scale INTEGER NOT NULL, band INTEGER NOT NULL, issued TEXT NOT NULL, zone INTEGER";

const OWN: &str = "
CREATE TABLE cells (
  id INTEGER PRIMARY KEY AUTOINCREMENT, name TEXT NOT NULL UNIQUE, kind TEXT NOT NULL, sha256 TEXT NOT NULL,
  files TEXT NOT NULL, bytes INTEGER NOT NULL, edition TEXT NOT NULL, update_no TEXT NOT NULL,
  scale INTEGER NOT NULL, band INTEGER NOT NULL, issued TEXT NOT NULL, updated TEXT NOT NULL,
  standard TEXT NOT NULL, agency INTEGER NOT NULL, horizontal_datum INTEGER NOT NULL,
  vertical_datum INTEGER NOT NULL, sounding_datum INTEGER NOT NULL, comment TEXT NOT NULL,
  features INTEGER NOT NULL, vertices INTEGER NOT NULL, skin_deg2 REAL, coverage_deg2 REAL,
  skin_holds INTEGER, imported TEXT NOT NULL, min_x REAL, min_y REAL, max_x REAL, max_y REAL);
CREATE TABLE coverage (
  id INTEGER PRIMARY KEY, source INTEGER NOT NULL, cell TEXT NOT NULL, record INTEGER NOT NULL,
  covered INTEGER NOT NULL, area_deg2 REAL NOT NULL, min_x REAL, min_y REAL, max_x REAL, max_y REAL);
CREATE INDEX coverage_source ON coverage (source);
CREATE TABLE import_log (
  id INTEGER PRIMARY KEY AUTOINCREMENT, time TEXT NOT NULL, source INTEGER, cell TEXT NOT NULL,
  file TEXT NOT NULL, record INTEGER, what TEXT NOT NULL, text TEXT NOT NULL);
CREATE INDEX import_log_source ON import_log (source);
CREATE TABLE chart_set (key TEXT NOT NULL PRIMARY KEY, value TEXT NOT NULL);
";

const GEOPACKAGE: &str = r#"
CREATE TABLE gpkg_spatial_ref_sys (
  srs_name TEXT NOT NULL, srs_id INTEGER NOT NULL PRIMARY KEY, organization TEXT NOT NULL,
  organization_coordsys_id INTEGER NOT NULL, definition TEXT NOT NULL, description TEXT);
CREATE TABLE gpkg_contents (
  table_name TEXT NOT NULL PRIMARY KEY, data_type TEXT NOT NULL, identifier TEXT UNIQUE,
  description TEXT DEFAULT '', last_change DATETIME NOT NULL DEFAULT (strftime('%Y-%m-%dT%H:%M:%fZ','now')),
  min_x DOUBLE, min_y DOUBLE, max_x DOUBLE, max_y DOUBLE, srs_id INTEGER,
  CONSTRAINT fk_gc_r_srs_id FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys(srs_id));
CREATE TABLE gpkg_geometry_columns (
  table_name TEXT NOT NULL, column_name TEXT NOT NULL, geometry_type_name TEXT NOT NULL,
  srs_id INTEGER NOT NULL, z TINYINT NOT NULL, m TINYINT NOT NULL,
  CONSTRAINT pk_geom_cols PRIMARY KEY (table_name, column_name),
  CONSTRAINT uk_gc_table_name UNIQUE (table_name),
  CONSTRAINT fk_gc_tn FOREIGN KEY (table_name) REFERENCES gpkg_contents(table_name),
  CONSTRAINT fk_gc_srs FOREIGN KEY (srs_id) REFERENCES gpkg_spatial_ref_sys (srs_id));
CREATE TABLE gpkg_extensions (
  table_name TEXT, column_name TEXT, extension_name TEXT NOT NULL, definition TEXT NOT NULL,
  scope TEXT NOT NULL, CONSTRAINT ge_tce UNIQUE (table_name, column_name, extension_name));
INSERT INTO gpkg_spatial_ref_sys VALUES
  ('Undefined cartesian SRS', -1, 'NONE', -1, 'undefined', 'undefined cartesian coordinate reference system'),
  ('Undefined geographic SRS', 0, 'NONE', 0, 'undefined', 'undefined geographic coordinate reference system'),
  ('WGS 84 geodetic', 4326, 'EPSG', 4326,
   'GEOGCS["WGS 84",DATUM["WGS_1984",SPHEROID["WGS 84",6378137,298.257223563,AUTHORITY["EPSG","7030"]],AUTHORITY["EPSG","6326"]],PRIMEM["Greenwich",0,AUTHORITY["EPSG","8901"]],UNIT["degree",0.0174532925199433,AUTHORITY["EPSG","9122"]],AXIS["Latitude",NORTH],AXIS["Longitude",EAST],AUTHORITY["EPSG","4326"]]',
   'longitude/latitude coordinates in decimal degrees on the WGS 84 spheroid');
"#;

/// What the editing program runs; `t` is the table. From OGC 12-128r17, F.3.
const TRIGGERS: &str = "
CREATE TRIGGER rtree_t_geom_insert AFTER INSERT ON t
  WHEN (new.geom NOT NULL AND NOT ST_IsEmpty(NEW.geom))
BEGIN INSERT OR REPLACE INTO rtree_t_geom VALUES
  (NEW.fid, ST_MinX(NEW.geom), ST_MaxX(NEW.geom), ST_MinY(NEW.geom), ST_MaxY(NEW.geom)); END;
CREATE TRIGGER rtree_t_geom_update1 AFTER UPDATE OF geom ON t
  WHEN OLD.fid = NEW.fid AND (NEW.geom NOTNULL AND NOT ST_IsEmpty(NEW.geom))
BEGIN INSERT OR REPLACE INTO rtree_t_geom VALUES
  (NEW.fid, ST_MinX(NEW.geom), ST_MaxX(NEW.geom), ST_MinY(NEW.geom), ST_MaxY(NEW.geom)); END;
CREATE TRIGGER rtree_t_geom_update2 AFTER UPDATE OF geom ON t
  WHEN OLD.fid = NEW.fid AND (NEW.geom ISNULL OR ST_IsEmpty(NEW.geom))
BEGIN DELETE FROM rtree_t_geom WHERE id = OLD.fid; END;
CREATE TRIGGER rtree_t_geom_update3 AFTER UPDATE ON t
  WHEN OLD.fid != NEW.fid AND (NEW.geom NOTNULL AND NOT ST_IsEmpty(NEW.geom))
BEGIN DELETE FROM rtree_t_geom WHERE id = OLD.fid;
  INSERT OR REPLACE INTO rtree_t_geom VALUES
  (NEW.fid, ST_MinX(NEW.geom), ST_MaxX(NEW.geom), ST_MinY(NEW.geom), ST_MaxY(NEW.geom)); END;
CREATE TRIGGER rtree_t_geom_update4 AFTER UPDATE ON t
  WHEN OLD.fid != NEW.fid AND (NEW.geom ISNULL OR ST_IsEmpty(NEW.geom))
BEGIN DELETE FROM rtree_t_geom WHERE id IN (OLD.fid, NEW.fid); END;
CREATE TRIGGER rtree_t_geom_delete AFTER DELETE ON t WHEN old.geom NOT NULL
BEGIN DELETE FROM rtree_t_geom WHERE id = OLD.fid; END;
";

/// Any manual edit gives the set a new digest.
const EDIT_TRIGGERS: &str = "
CREATE TRIGGER edited_t_insert AFTER INSERT ON t
BEGIN UPDATE chart_set SET value = hex(randomblob(16)) WHERE key = 'edited'; END;
CREATE TRIGGER edited_t_update AFTER UPDATE ON t
BEGIN UPDATE chart_set SET value = hex(randomblob(16)) WHERE key = 'edited'; END;
CREATE TRIGGER edited_t_delete AFTER DELETE ON t
BEGIN UPDATE chart_set SET value = hex(randomblob(16)) WHERE key = 'edited'; END;
";

/// Makes all tables in an empty database.
pub(crate) fn create(connection: &Connection) -> rusqlite::Result<()> {
    connection.pragma_update(None, "application_id", APPLICATION_ID)?;
    connection.pragma_update(None, "user_version", GEOPACKAGE_VERSION)?;
    connection.execute_batch(GEOPACKAGE)?;
    connection.execute_batch(OWN)?;
    for (table, kind, depths, text) in FEATURE_TABLES {
        let columns = match table {
            "soundings" => {
                "source INTEGER NOT NULL, record INTEGER NOT NULL, part INTEGER NOT NULL, \
                 depth_m REAL NOT NULL, quasou TEXT, cell TEXT NOT NULL, edition TEXT NOT NULL, \
                 update_no TEXT NOT NULL, scale INTEGER NOT NULL, band INTEGER NOT NULL, \
                 issued TEXT NOT NULL, zone INTEGER"
            }
            "points_of_interest" => {
                "source INTEGER NOT NULL, record INTEGER NOT NULL, class TEXT NOT NULL, name TEXT, \
                 depth_m REAL, greatest_m REAL, watlev INTEGER, cell TEXT NOT NULL, \
                 edition TEXT NOT NULL, update_no TEXT NOT NULL, scale INTEGER NOT NULL, \
                 band INTEGER NOT NULL, issued TEXT NOT NULL, zone INTEGER"
            }
            _ => FEATURE_DEFINITIONS,
        };
        connection.execute_batch(&format!(
            "CREATE TABLE {table} (fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, geom {kind}, {columns});
             CREATE INDEX {table}_source ON {table} (source, record);
             CREATE VIRTUAL TABLE rtree_{table}_geom USING rtree(id, minx, maxx, miny, maxy);
             INSERT INTO gpkg_contents (table_name, data_type, identifier, description, srs_id)
               VALUES ('{table}', 'features', '{table}', '{text}', 4326);
             INSERT INTO gpkg_geometry_columns VALUES ('{table}', 'geom', '{kind}', 4326, {z}, 0);
             INSERT INTO gpkg_extensions VALUES ('{table}', 'geom', 'gpkg_rtree_index',
               'http://www.geopackage.org/spec120/#extension_rtree', 'write-only');",
            z = u8::from(depths)
        ))?;
    }
    connection.execute_batch(&format!(
        "CREATE TABLE objects (fid INTEGER PRIMARY KEY AUTOINCREMENT NOT NULL, {FEATURE_DEFINITIONS});
         CREATE INDEX objects_source ON objects (source, record);"
    ))?;
    for (table, text) in ATTRIBUTE_TABLES {
        connection.execute(
            "INSERT INTO gpkg_contents (table_name, data_type, identifier, description) \
             VALUES (?1, 'attributes', ?1, ?2)",
            [table, text],
        )?;
    }
    for (key, value) in [("schema", SCHEMA.to_string()), ("edited", String::new())] {
        connection.execute("INSERT INTO chart_set VALUES (?1, ?2)", [key, &value])?;
    }
    Ok(())
}

/// Tables whose rows say where and how deep it is.
fn edited_tables() -> impl Iterator<Item = &'static str> {
    WHOLE_TABLES.into_iter().chain(["soundings", "cells"])
}

/// Takes the triggers away, for writing.
pub(crate) fn drop_triggers(connection: &Connection) -> rusqlite::Result<()> {
    let mut names = connection.prepare("SELECT name FROM sqlite_master WHERE type = 'trigger'")?;
    let names = names.query_map([], |row| row.get(0))?.collect::<rusqlite::Result<Vec<String>>>()?;
    names.iter().try_for_each(|name| connection.execute_batch(&format!("DROP TRIGGER \"{name}\"")))
}

/// Makes the triggers, and what `gpkg_contents` says of each table.
pub(crate) fn finish(connection: &Connection, time: &str) -> rusqlite::Result<()> {
    for (table, ..) in FEATURE_TABLES {
        let sides = extent(connection, table)?;
        let [west, east, south, north] = [0, 1, 2, 3].map(|side| sides.map(|sides| f64::from(sides[side])));
        connection.execute(
            "UPDATE gpkg_contents SET last_change = ?1, min_x = ?3, max_x = ?4, min_y = ?5, max_y = ?6 \
             WHERE table_name = ?2",
            params![time, table, west, east, south, north],
        )?;
    }
    connection.execute("UPDATE gpkg_contents SET last_change = ?1 WHERE data_type = 'attributes'", [time])?;
    drop_triggers(connection)?;
    for (table, ..) in FEATURE_TABLES {
        let text = TRIGGERS.replace("rtree_t_", &format!("rtree_{table}_"));
        connection.execute_batch(&text.replace(" ON t", &format!(" ON {table}")))?;
    }
    for table in edited_tables() {
        let text = EDIT_TRIGGERS.replace("edited_t_", &format!("edited_{table}_"));
        connection.execute_batch(&text.replace(" ON t", &format!(" ON {table}")))?;
    }
    Ok(())
}

/// West, east, south and north of all boxes of an R-tree (degrees): those of its root, so that its size does not matter.
/// A node is its height and the number of its boxes (u16, big-endian), and for each box a number (i64) and its sides
/// (f32), as SQLite's `rtree.c` describes it.
fn extent(connection: &Connection, table: &str) -> rusqlite::Result<Option<[f32; 4]>> {
    let root = format!("SELECT data FROM rtree_{table}_geom_node WHERE nodeno = 1");
    let root: Vec<u8> = connection.query_row(&root, [], |row| row.get(0)).optional()?.unwrap_or_default();
    let count = root.get(2..4).map_or(0, |bytes| usize::from(u16::from_be_bytes([bytes[0], bytes[1]])));
    let side = |bytes: &[u8], side: usize| {
        let bytes = bytes[8 + 4 * side..].first_chunk();
        f32::from_be_bytes(*bytes.unwrap_or(&[0; 4]))
    };
    let boxes = root.get(4..).unwrap_or_default().chunks_exact(24).take(count);
    let boxes = boxes.map(|bytes| [0, 1, 2, 3].map(|at| side(bytes, at)));
    Ok(boxes.reduce(|a, b| [a[0].min(b[0]), a[1].max(b[1]), a[2].min(b[2]), a[3].max(b[3])]))
}

/// Refuses what is not a chart set of this version.
pub(crate) fn check(connection: &Connection, path: &Path) -> Result<()> {
    let id: i64 = connection.pragma_query_value(None, "application_id", |row| row.get(0)).named(path)?;
    let own = "SELECT 1 FROM sqlite_master WHERE type = 'table' AND name = 'chart_set'";
    let own: Option<i64> = connection.query_row(own, [], |row| row.get(0)).optional().named(path)?;
    if id != APPLICATION_ID || own.is_none() {
        return Err(ChartDbError::Foreign(path.to_owned()));
    }
    let schema = "SELECT value FROM chart_set WHERE key = 'schema'";
    let schema: Option<String> = connection.query_row(schema, [], |row| row.get(0)).optional().named(path)?;
    match schema.and_then(|text| text.parse::<i64>().ok()) {
        Some(SCHEMA) => Ok(()),
        Some(schema) if schema < SCHEMA => Err(ChartDbError::Older(path.to_owned())),
        Some(_) => Err(ChartDbError::Newer(path.to_owned())),
        None => Err(ChartDbError::Foreign(path.to_owned())),
    }
}
