//! Writing a chart's features into the tables, and taking them out again.

use crate::blob::{self, Envelope};
use crate::error::{Named as _, Result};
use crate::locate::{Zones, representative};
use crate::row;
use crate::schema::{FEATURE_COLUMNS, FEATURE_TABLES};
use charts::s57::{
    Area, AttributeCode, Feature, GeoPoint, Geometry, ObjectClass, Path, SKIN_CLASSES, SkinCheck, Sounding,
};
use rusqlite::types::Value;
use rusqlite::{Connection, params, params_from_iter};
use std::path::Path as FilePath;

/// The thesis' table A.1, the beacons that it leaves out, and the other aids of the same kind.
const INTEREST: [ObjectClass; 20] = [
    ObjectClass::BCNCAR,
    ObjectClass::BCNISD,
    ObjectClass::BCNLAT,
    ObjectClass::BCNSAW,
    ObjectClass::BCNSPP,
    ObjectClass::BOYCAR,
    ObjectClass::BOYINB,
    ObjectClass::BOYISD,
    ObjectClass::BOYLAT,
    ObjectClass::BOYSAW,
    ObjectClass::BOYSPP,
    ObjectClass::COALNE,
    ObjectClass::DAYMAR,
    ObjectClass::DEPARE,
    ObjectClass::LIGHTS,
    ObjectClass::MORFAC,
    ObjectClass::OBSTRN,
    ObjectClass::PILPNT,
    ObjectClass::UWTROC,
    ObjectClass::WRECKS,
];

/// A chart's row in `cells`.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct NewSource {
    pub(crate) name: String,
    pub(crate) kind: &'static str,
    pub(crate) sha256: String,
    pub(crate) files: Vec<String>,
    pub(crate) bytes: u64,
    pub(crate) edition: String,
    pub(crate) update: String,
    pub(crate) scale: u32,
    pub(crate) band: u8,
    pub(crate) issued: String,
    pub(crate) updated: String,
    pub(crate) standard: String,
    pub(crate) agency: u16,
    pub(crate) datums: [u8; 3],
    pub(crate) comment: String,
    pub(crate) skin: Option<SkinCheck>,
    pub(crate) time: String,
}

impl NewSource {
    /// Of a supplement: it has no edition, scale or datum of its own.
    pub(crate) fn supplement(name: String, kind: &'static str, sha256: String, time: String) -> Self {
        Self {
            name,
            kind,
            sha256,
            files: Vec::new(),
            bytes: 0,
            edition: String::new(),
            update: String::new(),
            scale: 0,
            band: 0,
            issued: String::new(),
            updated: String::new(),
            standard: String::new(),
            agency: 0,
            datums: [0; 3],
            comment: String::new(),
            skin: None,
            time,
        }
    }
}

/// Writes features of one chart, one after another.
pub(crate) struct Writer<'a> {
    connection: &'a Connection,
    path: &'a FilePath,
    source: &'a NewSource,
    id: i64,
    features: u64,
    vertices: u64,
    bounds: Option<Envelope>,
}

impl<'a> Writer<'a> {
    pub(crate) fn new(
        connection: &'a Connection,
        path: &'a FilePath,
        source: &'a NewSource,
    ) -> rusqlite::Result<Self> {
        let [horizontal, vertical, sounding] = source.datums;
        let files = serde_json::to_string(&source.files).unwrap_or_default();
        connection.prepare_cached(
            "INSERT INTO cells (name, kind, sha256, files, bytes, edition, update_no, scale, band, issued, \
             updated, standard, agency, horizontal_datum, vertical_datum, sounding_datum, comment, features, \
             vertices, skin_deg2, coverage_deg2, skin_holds, imported) VALUES \
             (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15, ?16, ?17, 0, 0, ?18, ?19, ?20, ?21)",
        )?
        .execute(params![
            source.name,
            source.kind,
            source.sha256,
            files,
            source.bytes as i64,
            source.edition,
            source.update,
            source.scale,
            source.band,
            source.issued,
            source.updated,
            source.standard,
            source.agency,
            horizontal,
            vertical,
            sounding,
            source.comment,
            source.skin.map(|check| check.skin_deg2),
            source.skin.map(|check| check.coverage_deg2),
            source.skin.map(|check| check.holds()),
            source.time,
        ])?;
        let id = connection.last_insert_rowid();
        Ok(Self { connection, path, source, id, features: 0, vertices: 0, bounds: None })
    }

    /// Its number in `cells`.
    pub(crate) fn id(&self) -> i64 {
        self.id
    }

    /// Writes a feature with all its rows.
    pub(crate) fn feature(&mut self, feature: &Feature, zones: &Zones) -> Result<()> {
        self.put(feature, zones).named(self.path)
    }

    fn put(&mut self, feature: &Feature, zones: &Zones) -> rusqlite::Result<()> {
        let zone = match feature.code(AttributeCode::CATZOC) {
            Some(zone) => Some(zone),
            None => representative(&feature.geometry).and_then(|at| zones.at(at)),
        };
        let envelope = Envelope::of(feature.geometry.points());
        self.features += 1;
        self.vertices += feature.geometry.points().count() as u64;
        if let Some(Envelope(new)) = envelope {
            let Envelope(old) = self.bounds.unwrap_or(Envelope(new));
            let grown = [old[0].min(new[0]), old[1].max(new[1]), old[2].min(new[2]), old[3].max(new[3])];
            self.bounds = Some(Envelope(grown));
        }
        let (table, geom) = geometry(feature, envelope);
        self.row(feature, table, geom, zone)?;
        if let (Some(envelope), true) = (envelope, table != "objects") {
            self.rtree(table, envelope)?;
        }
        if let Geometry::Soundings(list) = &feature.geometry {
            self.put_soundings(feature, list, zones, 0)?;
        }
        if feature.class == ObjectClass::M_COVR {
            self.coverage(feature, envelope)?;
        }
        self.interest(feature, zone)
    }

    fn row(
        &self,
        feature: &Feature,
        table: &str,
        geom: Option<Vec<u8>>,
        zone: Option<u32>,
    ) -> rusqlite::Result<()> {
        let text = |code| Value::from(feature.text(code).map(str::to_owned));
        let number = |code| Value::from(feature.number(code));
        let whole = |code| Value::from(feature.code(code).map(i64::from));
        let acronym = |name| AttributeCode::from_acronym(name).unwrap_or(AttributeCode(0));
        let source = self.source;
        let unreadable = match &feature.geometry {
            Geometry::Unreadable { reason, .. } => Some(reason.clone()),
            _ => None,
        };
        let mut values = vec![
            Value::from(self.id),
            i64::from(feature.record).into(),
            feature.class.to_string().into(),
            i64::from(feature.class.0).into(),
            row::object(feature.object).into(),
            i64::from(feature.group).into(),
            i64::from(feature.version).into(),
            text(AttributeCode::OBJNAM),
            text(AttributeCode::NOBJNM),
            number(AttributeCode::DRVAL1),
            number(AttributeCode::DRVAL2),
            number(AttributeCode::VALSOU),
            number(AttributeCode::VALDCO),
            whole(AttributeCode::WATLEV),
            text(AttributeCode::QUASOU),
            whole(acronym("SCAMIN")),
            text(acronym("SORDAT")),
            row::attributes(&feature.attributes).into(),
            row::attributes(&feature.national).into(),
            row::links(&feature.links).into(),
            edges(&feature.geometry).into(),
            unreadable.into(),
            source.name.clone().into(),
            source.edition.clone().into(),
            source.update.clone().into(),
            i64::from(source.scale).into(),
            i64::from(source.band).into(),
            source.issued.clone().into(),
            zone.map(i64::from).into(),
        ];
        let mut columns = FEATURE_COLUMNS.to_owned();
        if table != "objects" {
            columns += ", geom";
            values.push(geom.into());
        }
        let places = vec!["?"; values.len()].join(", ");
        let statement = format!("INSERT INTO {table} ({columns}) VALUES ({places})");
        self.connection.prepare_cached(&statement)?.execute(params_from_iter(values)).map(drop)
    }

    /// Files the row written last under its box.
    fn rtree(&self, table: &str, Envelope([w, e, s, n]): Envelope) -> rusqlite::Result<()> {
        let statement = format!("INSERT INTO rtree_{table}_geom VALUES (?1, ?2, ?3, ?4, ?5)");
        let fid = self.connection.last_insert_rowid();
        self.connection.prepare_cached(&statement)?.execute(params![fid, w, e, s, n]).map(drop)
    }

    /// Adds soundings to a feature whose row is written, numbered from `first` on.
    pub(crate) fn soundings(&mut self, feature: &Feature, list: &[Sounding], first: usize) -> Result<()> {
        self.vertices += list.len() as u64;
        let ends = self.bounds.into_iter().flat_map(|Envelope([w, e, s, n])| {
            [GeoPoint { lon_deg: w, lat_deg: s }, GeoPoint { lon_deg: e, lat_deg: n }]
        });
        self.bounds = Envelope::of(ends.chain(list.iter().map(|one| one.at)));
        self.put_soundings(feature, list, &Zones::of(&[]), first).named(self.path)
    }

    fn put_soundings(
        &self,
        feature: &Feature,
        list: &[Sounding],
        zones: &Zones,
        first: usize,
    ) -> rusqlite::Result<()> {
        let source = self.source;
        let quality = feature.text(AttributeCode::QUASOU);
        let mut insert = self.connection.prepare_cached(
            "INSERT INTO soundings (geom, source, record, part, depth_m, quasou, cell, edition, update_no, \
             scale, band, issued, zone) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13)",
        )?;
        for (part, sounding) in list.iter().enumerate() {
            let at = sounding.at;
            insert.execute(params![
                blob::point(at, Some(sounding.depth_m)),
                self.id,
                feature.record,
                (first + part) as i64,
                sounding.depth_m,
                quality,
                source.name,
                source.edition,
                source.update,
                source.scale,
                source.band,
                source.issued,
                zones.at(at),
            ])?;
            self.rtree("soundings", Envelope([at.lon_deg, at.lon_deg, at.lat_deg, at.lat_deg]))?;
        }
        Ok(())
    }

    fn coverage(&self, feature: &Feature, envelope: Option<Envelope>) -> rusqlite::Result<()> {
        let area = if let Geometry::Area(area) = &feature.geometry { area.area_deg2() } else { 0.0 };
        let side = |at: usize| envelope.map(|Envelope(sides)| sides[at]);
        let covered = feature.code(AttributeCode::CATCOV) == Some(1);
        self.connection
            .prepare_cached(
                "INSERT INTO coverage (source, cell, record, covered, area_deg2, min_x, max_x, min_y, max_y) \
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9)",
            )?
            .execute(params![
                self.id,
                self.source.name,
                feature.record,
                covered,
                area,
                side(0),
                side(1),
                side(2),
                side(3)
            ])
            .map(drop)
    }

    fn interest(&self, feature: &Feature, zone: Option<u32>) -> rusqlite::Result<()> {
        let Some(at) = representative(&feature.geometry).filter(|_| INTEREST.contains(&feature.class)) else {
            return Ok(());
        };
        let depth = feature.number(AttributeCode::VALSOU).or_else(|| feature.number(AttributeCode::DRVAL1));
        let source = self.source;
        self.connection.prepare_cached(
            "INSERT INTO points_of_interest (geom, source, record, class, name, depth_m, greatest_m, watlev, \
             cell, edition, update_no, scale, band, issued, zone) \
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12, ?13, ?14, ?15)",
        )?
        .execute(params![
            blob::point(at, None),
            self.id,
            feature.record,
            feature.class.to_string(),
            feature.text(AttributeCode::OBJNAM),
            depth,
            feature.number(AttributeCode::DRVAL2),
            feature.code(AttributeCode::WATLEV),
            source.name,
            source.edition,
            source.update,
            source.scale,
            source.band,
            source.issued,
            zone,
        ])?;
        self.rtree("points_of_interest", Envelope([at.lon_deg, at.lon_deg, at.lat_deg, at.lat_deg]))
    }

    /// Notes how much it was.
    pub(crate) fn finish(self) -> rusqlite::Result<u64> {
        let side = |at: usize| self.bounds.map(|Envelope(sides)| sides[at]);
        self.connection.execute(
            "UPDATE cells SET features = ?2, vertices = ?3, min_x = ?4, max_x = ?5, min_y = ?6, max_y = ?7 \
             WHERE id = ?1",
            params![self.id, self.features as i64, self.vertices as i64, side(0), side(1), side(2), side(3)],
        )?;
        Ok(self.features)
    }
}

/// The table of a feature and its geometry there.
fn geometry(feature: &Feature, envelope: Option<Envelope>) -> (&'static str, Option<Vec<u8>>) {
    let lines = |paths: &[Path]| {
        let list: Vec<&[GeoPoint]> = paths.iter().map(|path| path.points.as_slice()).collect();
        envelope.map(|envelope| blob::lines(envelope, &list))
    };
    match &feature.geometry {
        Geometry::None | Geometry::Soundings(_) => ("objects", None),
        Geometry::Point(at) => ("points", Some(blob::point(*at, None))),
        Geometry::Lines(paths) | Geometry::Unreadable { paths, .. } => ("lines", lines(paths)),
        Geometry::Area(area) => {
            let table = if SKIN_CLASSES.contains(&feature.class) { "skin" } else { "areas" };
            (table, envelope.map(|envelope| blob::polygons(envelope, &polygons(area))))
        }
    }
}

/// Each exterior with its holes. An area of an ENC has one exterior; where there are more, a hole goes with the
/// one whose box holds it.
fn polygons(area: &Area) -> Vec<Vec<&[GeoPoint]>> {
    let mut list: Vec<Vec<&[GeoPoint]>> = area.exteriors.iter().map(|ring| vec![&ring.points[..]]).collect();
    for hole in &area.holes {
        let holds = |rings: &Vec<&[GeoPoint]>| {
            let (Some(Envelope([w, e, s, n])), Some(at)) =
                (Envelope::of(rings[0].iter().copied()), hole.points.first())
            else {
                return false;
            };
            (w..=e).contains(&at.lon_deg) && (s..=n).contains(&at.lat_deg)
        };
        let of = list.iter().position(holds).unwrap_or(0);
        match list.get_mut(of) {
            Some(rings) => rings.push(&hole.points),
            None => list.push(vec![&hole.points]),
        }
    }
    list
}

fn edges(geometry: &Geometry) -> Option<Vec<u8>> {
    match geometry {
        Geometry::Lines(paths) | Geometry::Unreadable { paths, .. } => row::edges(paths.iter()),
        Geometry::Area(area) => row::edges(area.exteriors.iter().chain(&area.holes)),
        Geometry::None | Geometry::Point(_) | Geometry::Soundings(_) => None,
    }
}

/// Removes a chart and all its rows; false if no chart has that name.
pub(crate) fn remove(connection: &Connection, name: &str) -> rusqlite::Result<bool> {
    let mut find = connection.prepare_cached("SELECT id FROM cells WHERE name = ?1")?;
    let Some(id) = find.query_map([name], |row| row.get::<_, i64>(0))?.next().transpose()? else {
        return Ok(false);
    };
    for (table, ..) in FEATURE_TABLES {
        connection.execute(
            &format!(
                "DELETE FROM rtree_{table}_geom WHERE id IN (SELECT fid FROM {table} WHERE source = ?1)"
            ),
            [id],
        )?;
    }
    let tables = FEATURE_TABLES.iter().map(|(table, ..)| *table).chain(["objects", "coverage", "import_log"]);
    for table in tables {
        connection.execute(&format!("DELETE FROM {table} WHERE source = ?1"), [id])?;
    }
    connection.execute("DELETE FROM cells WHERE id = ?1", [id])?;
    Ok(true)
}

/// One line of the import log.
pub(crate) struct Entry<'a> {
    pub(crate) source: Option<i64>,
    pub(crate) cell: &'a str,
    pub(crate) file: &'a str,
    pub(crate) record: Option<u32>,
    pub(crate) what: &'a str,
    pub(crate) text: &'a str,
}

pub(crate) fn log(connection: &Connection, time: &str, entry: &Entry<'_>) -> rusqlite::Result<()> {
    connection
        .prepare_cached(
            "INSERT INTO import_log (time, source, cell, file, record, what, text) \
             VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)",
        )?
        .execute(params![time, entry.source, entry.cell, entry.file, entry.record, entry.what, entry.text])
        .map(drop)
}
