//! Importing lakes with depths: polygons of an ESRI shapefile or a GeoPackage, one column of which is a depth.
//!
//! Each polygon becomes a depth area whose least depth (DRVAL1) is that column. Polygons are bands of depth that
//! lie beside each other; where they lie on top of each other the shallower counts. A polygon without a depth
//! is water of unknown depth, which nothing may enter.

use crate::blob::{self, Polygon, Shape};
use crate::error::{ChartDbError, Result};
use crate::locate::Zones;
use crate::report::{ImportOptions, Imported, unchanged};
use crate::stage::Stage;
use crate::supplements::{datum_notice, hash, imported, made, name, refuse_other_kind, source};
use charts::s57::{Area, Attribute, AttributeCode, GeoPoint, Geometry, ObjectClass, Path as Ring};
use charts::utm::{Datum, Utm, UtmPoint};
use rusqlite::types::ValueRef;
use rusqlite::{Connection, OpenFlags};
use shapefile::dbase::{FieldValue, Record};
use shapefile::{PolygonRing, Shape as EsriShape};
use std::path::Path;

/// The frame of some coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Frame {
    Degrees(Datum),
    Utm(Utm),
}

impl Frame {
    fn from_epsg(code: u32) -> Result<Self, String> {
        match code {
            4326 => Ok(Self::Degrees(Datum::Wgs84)),
            4258 => Ok(Self::Degrees(Datum::Etrs89)),
            _ => Utm::from_epsg(code).map(Self::Utm).map_err(|error| error.to_string()),
        }
    }

    fn datum(self) -> Datum {
        match self {
            Self::Degrees(datum) => datum,
            Self::Utm(utm) => utm.datum(),
        }
    }

    /// A position whose x and y are in place of degrees.
    fn place(self, at: GeoPoint) -> Result<GeoPoint, String> {
        match self {
            Self::Degrees(_) => match at.place() {
                Some(_) => Ok(at),
                None => {
                    Err(format!("{}, {} are not degrees; give the system by --epsg", at.lon_deg, at.lat_deg))
                }
            },
            Self::Utm(utm) => {
                let point = UtmPoint { easting_m: at.lon_deg, northing_m: at.lat_deg };
                let place = utm.to_place(point).map_err(|error| error.to_string())?;
                Ok(GeoPoint { lon_deg: place.lon_deg(), lat_deg: place.lat_deg() })
            }
        }
    }
}

/// One polygon with its depths, or why it is not valid.
struct Lake {
    polygons: Result<Vec<Polygon>, &'static str>,
    least_m: Option<f64>,
    greatest_m: Option<f64>,
}

/// Imports lakes.
pub(crate) fn import(stage: &mut Stage, path: &Path, options: &ImportOptions) -> Result<Imported> {
    let how = format!(
        "lakes {:?} {:?} {:?} {:?}\n",
        options.epsg, options.depth_column, options.deepest_column, options.layer
    );
    let (sha256, bytes) = hash_all(path, &how)?;
    let before = stage.chart(&name(path))?;
    refuse_other_kind(before.as_ref(), "lakes", path)?;
    if let Some(chart) = before.as_ref().filter(|chart| chart.sha256 == sha256) {
        return Ok(unchanged(chart, "lakes"));
    }
    let new = source(path, "lakes", sha256, bytes, options);
    let file = path.display().to_string();
    let mut notices = Vec::new();
    let features = stage.write_noting(&new, before.as_ref(), &mut notices, |writer, notices| {
        let zones = Zones::of(&[]);
        let mut record = 0;
        let datum = each(path, options, &mut |frame, lake| {
            record += 1;
            let mut note = |text: String| notices.push((file.clone(), Some(record), text));
            match area(frame, lake.polygons) {
                Ok(area) => {
                    if lake.least_m.is_none() {
                        note("it has no depth, and counts as water of unknown depth".to_owned());
                    }
                    let depth = |code, depth_m: Option<f64>| {
                        depth_m.map(|depth_m| Attribute { code, value: depth_m.to_string() })
                    };
                    let least = depth(AttributeCode::DRVAL1, lake.least_m);
                    let greatest = depth(AttributeCode::DRVAL2, lake.greatest_m);
                    let attributes = least.into_iter().chain(greatest).collect();
                    let geometry = Geometry::Area(area);
                    writer.feature(&made(record, ObjectClass::DEPARE, attributes, geometry), &zones)?;
                }
                Err(why) => note(format!("dropped: {why}")),
            }
            Ok(())
        })?;
        notices.extend(datum_notice(datum).map(|text| (file.clone(), None, text)));
        Ok(())
    })?;
    let told = notices.into_iter().map(|(file, record, text)| match record {
        Some(record) => format!("{file}, polygon {record}: {text}"),
        None => format!("{file}: {text}"),
    });
    Ok(imported(new, before.as_ref(), features, told.collect()))
}

/// The depths of a shapefile are in another file.
fn hash_all(path: &Path, how: &str) -> Result<(String, u64)> {
    let table = path.with_extension("dbf");
    if is_shapefile(path) && table.exists() {
        let (first, some) = hash(&table, how)?;
        let (whole, more) = hash(path, &format!("{first}\n"))?;
        return Ok((whole, some + more));
    }
    hash(path, how)
}

fn is_shapefile(path: &Path) -> bool {
    path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("shp"))
}

fn each(
    path: &Path,
    options: &ImportOptions,
    give: &mut dyn FnMut(Frame, Lake) -> Result<()>,
) -> Result<Datum> {
    if is_shapefile(path) { shapefile(path, options, give) } else { geopackage(path, options, give) }
}

/// Rings in degrees, each closed.
fn area(frame: Frame, polygons: Result<Vec<Polygon>, &'static str>) -> Result<Area, String> {
    let mut area = Area::default();
    for polygon in polygons? {
        for (at, ring) in polygon.into_iter().enumerate() {
            if ring.len() < 4 || ring.first() != ring.last() {
                return Err("a ring of it is not closed".to_owned());
            }
            let points = ring.into_iter().map(|at| frame.place(at)).collect::<Result<_, _>>()?;
            let ring = Ring { points, edges: Vec::new() };
            if at == 0 { area.exteriors.push(ring) } else { area.holes.push(ring) }
        }
    }
    if area.exteriors.is_empty() { Err("it is empty".to_owned()) } else { Ok(area) }
}

/// The column of the least depth, or what to give.
fn depth_column<'a>(file: &str, options: &'a ImportOptions, columns: &[String]) -> Result<&'a str> {
    let known = |name: &String| columns.iter().any(|column| column == name);
    let list = columns.join(", ");
    let Some(column) = &options.depth_column else {
        let problem =
            format!("say which column is the least depth in metres by --depth-column; there are: {list}");
        return Err(ChartDbError::file(file, problem));
    };
    for name in [Some(column), options.deepest_column.as_ref()].into_iter().flatten() {
        if !known(name) {
            return Err(ChartDbError::file(file, format!("there is no column {name}; there are: {list}")));
        }
    }
    Ok(column)
}

fn shapefile(
    path: &Path,
    options: &ImportOptions,
    give: &mut dyn FnMut(Frame, Lake) -> Result<()>,
) -> Result<Datum> {
    let file = path.display().to_string();
    let fail = |error: shapefile::Error| {
        let problem =
            format!("{error}; give the .shp with its .dbf and .shx beside it, as it was downloaded");
        ChartDbError::file(&file, problem)
    };
    let frame = match options.epsg {
        Some(code) => Frame::from_epsg(code),
        None => match std::fs::read_to_string(path.with_extension("prj")) {
            Ok(text) if text.trim_start().starts_with("GEOGCS[\"GCS_WGS_1984\"") => Frame::from_epsg(4326),
            Ok(text) => {
                let name = text.split('"').nth(1).unwrap_or_default().to_owned();
                Err(format!("its coordinate system is {name:?}; give its EPSG code by --epsg"))
            }
            Err(_) => Err("it does not say its coordinate system; give it by --epsg".to_owned()),
        },
    };
    let frame = frame.map_err(|problem| ChartDbError::file(&file, problem))?;
    let table = path.with_extension("dbf");
    let columns = shapefile::dbase::Reader::from_path(&table).map_err(|error| {
        ChartDbError::file(table.display().to_string(), format!("{error}; it holds the depths"))
    })?;
    let columns: Vec<String> = columns.fields().iter().map(|field| field.name().to_owned()).collect();
    let column = depth_column(&file, options, &columns)?;
    let mut reader = shapefile::Reader::from_path(path).map_err(fail)?;
    for item in reader.iter_shapes_and_records() {
        let (shape, record) = item.map_err(fail)?;
        let depth = |column: &str| number(&record, column);
        let lake = Lake {
            polygons: polygons(shape),
            least_m: depth(column),
            greatest_m: options.deepest_column.as_deref().and_then(depth),
        };
        give(frame, lake)?;
    }
    Ok(frame.datum())
}

fn number(record: &Record, column: &str) -> Option<f64> {
    let value = match record.get(column)? {
        FieldValue::Numeric(value) => *value,
        FieldValue::Float(value) => value.map(f64::from),
        FieldValue::Integer(value) => Some(f64::from(*value)),
        FieldValue::Double(value) | FieldValue::Currency(value) => Some(*value),
        FieldValue::Character(text) => text.as_ref().and_then(|text| text.trim().parse().ok()),
        _ => None,
    };
    value.filter(|value| value.is_finite())
}

fn polygons(shape: EsriShape) -> Result<Vec<Polygon>, &'static str> {
    fn of<P>(rings: Vec<PolygonRing<P>>, xy: impl Fn(&P) -> (f64, f64)) -> Vec<Polygon> {
        let mut list: Vec<Polygon> = Vec::new();
        for ring in rings {
            let outer = matches!(ring, PolygonRing::Outer(_));
            let point = |one: &P| {
                let (lon_deg, lat_deg) = xy(one);
                GeoPoint { lon_deg, lat_deg }
            };
            let points = ring.points().iter().map(point).collect();
            match list.last_mut().filter(|_| !outer) {
                Some(polygon) => polygon.push(points),
                None => list.push(vec![points]),
            }
        }
        list
    }
    match shape {
        EsriShape::Polygon(polygon) => Ok(of(polygon.into_inner(), |at| (at.x, at.y))),
        EsriShape::PolygonM(polygon) => Ok(of(polygon.into_inner(), |at| (at.x, at.y))),
        EsriShape::PolygonZ(polygon) => Ok(of(polygon.into_inner(), |at| (at.x, at.y))),
        EsriShape::NullShape => Err("it has no geometry"),
        _ => Err("it is not a polygon"),
    }
}

fn quoted(name: &str) -> String {
    format!("\"{}\"", name.replace('"', "\"\""))
}

fn geopackage(
    path: &Path,
    options: &ImportOptions,
    give: &mut dyn FnMut(Frame, Lake) -> Result<()>,
) -> Result<Datum> {
    let file = path.display().to_string();
    let fail = |problem: String| ChartDbError::file(&file, problem);
    let unfit = |error: rusqlite::Error| fail(format!("{error}; give a GeoPackage with polygons"));
    let flags = OpenFlags::SQLITE_OPEN_READ_ONLY | OpenFlags::SQLITE_OPEN_NO_MUTEX;
    let connection = Connection::open_with_flags(path, flags).map_err(unfit)?;
    let layers = |connection: &Connection| -> rusqlite::Result<Vec<(String, String, u32)>> {
        let mut select = connection.prepare(
            "SELECT table_name, column_name, organization_coordsys_id FROM gpkg_geometry_columns \
             JOIN gpkg_spatial_ref_sys USING (srs_id) WHERE geometry_type_name LIKE '%POLYGON' ORDER BY 1",
        )?;
        select.query_map([], |row| Ok((row.get(0)?, row.get(1)?, row.get(2).unwrap_or(0))))?.collect()
    };
    let layers = layers(&connection).map_err(unfit)?;
    let names: Vec<&str> = layers.iter().map(|(name, ..)| name.as_str()).collect();
    let wanted = |name: &str| options.layer.as_ref().is_none_or(|layer| layer == name);
    let mut fitting = layers.iter().filter(|(name, ..)| wanted(name));
    let (Some((layer, geom, epsg)), None) = (fitting.next(), fitting.next()) else {
        return Err(fail(format!(
            "say which table by --layer; with polygons there are: {}",
            names.join(", ")
        )));
    };
    let frame = Frame::from_epsg(options.epsg.unwrap_or(*epsg)).map_err(fail)?;
    let columns = |connection: &Connection| -> rusqlite::Result<Vec<String>> {
        let mut select = connection.prepare("SELECT name FROM pragma_table_info(?1)")?;
        select.query_map([layer], |row| row.get(0))?.collect()
    };
    let column = depth_column(&file, options, &columns(&connection).map_err(unfit)?)?;
    let deepest = options.deepest_column.as_deref().map_or_else(|| "NULL".to_owned(), quoted);
    let statement = format!("SELECT {}, {}, {deepest} FROM {}", quoted(geom), quoted(column), quoted(layer));
    let mut select = connection.prepare(&statement).map_err(unfit)?;
    let mut rows = select.query([]).map_err(unfit)?;
    while let Some(row) = rows.next().map_err(unfit)? {
        let value = |at: usize| match row.get_ref(at).ok()? {
            ValueRef::Real(value) => Some(value).filter(|value| value.is_finite()),
            ValueRef::Integer(value) => Some(value as f64),
            ValueRef::Text(text) => std::str::from_utf8(text).ok()?.trim().parse().ok(),
            _ => None,
        };
        let polygons = match row.get_ref(0).map_err(unfit)? {
            ValueRef::Blob(bytes) => match blob::read(bytes) {
                Some(Shape::Polygons(list)) => Ok(list),
                Some(_) => Err("it is not a polygon"),
                None => Err("its geometry cannot be read"),
            },
            _ => Err("it has no geometry"),
        };
        give(frame, Lake { polygons, least_m: value(1), greatest_m: value(2) })?;
    }
    Ok(frame.datum())
}
