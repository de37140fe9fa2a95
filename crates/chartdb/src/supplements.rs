//! Importing soundings and land masks.

use crate::error::{ChartDbError, Named as _, Result};
use crate::locate::Zones;
use crate::read::Chart;
use crate::report::{ImportOptions, Imported, outcome, unchanged};
use crate::stage::Stage;
use crate::write::NewSource;
use charts::s57::{
    Area, Attribute, Feature, GeoPoint, Geometry, ObjectClass, ObjectId, Path as Ring, Sounding,
};
use charts::utm::{Datum, Utm};
use charts::xyz::{self, Vertical, XyzError};
use geofile::{Polygon, geojson};
use sha2::{Digest as _, Sha256};
use std::fs::File;
use std::io::{BufRead as _, BufReader, Read as _};
use std::path::Path;

/// Lines of soundings that are held at a time.
const LINES: usize = 50_000;
/// A line longer than this is not a sounding.
const LINE_BYTES: u64 = 4096;
/// Land masks larger than this must be split by their maker: they are in memory whole while they are read.
const LAND_BYTES: u64 = 512 << 20;

/// The chart's name: the file's without its ending.
pub(crate) fn name(path: &Path) -> String {
    path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default()
}

pub(crate) fn source(
    path: &Path,
    kind: &'static str,
    sha256: String,
    bytes: u64,
    options: &ImportOptions,
) -> NewSource {
    NewSource {
        files: vec![path.display().to_string()],
        bytes,
        ..NewSource::supplement(name(path), kind, sha256, options.now.to_string())
    }
}

/// The outcome of a chart that is not a cell.
pub(crate) fn imported(
    source: NewSource,
    before: Option<&Chart>,
    features: u64,
    notices: Vec<String>,
) -> Imported {
    Imported {
        name: source.name,
        kind: source.kind,
        outcome: outcome(before),
        edition: String::new(),
        update: String::new(),
        features,
        skin: None,
        notices,
    }
}

/// A chart of that name that is not a cell must not take a cell's place.
pub(crate) fn refuse_other_kind(before: Option<&Chart>, kind: &str, path: &Path) -> Result<()> {
    match before {
        Some(chart) if chart.kind != kind => {
            let problem = format!(
                "the chart set holds {} ({}) under this name; rename the file, or remove that chart first",
                chart.name, chart.kind
            );
            Err(ChartDbError::file(path.display().to_string(), problem))
        }
        _ => Ok(()),
    }
}

/// SHA-256 of a file and of how it is read.
pub(crate) fn hash(path: &Path, how: &str) -> Result<(String, u64)> {
    let mut file = File::open(path).named(path)?;
    let (mut hash, mut bytes) = (Sha256::new_with_prefix(how.as_bytes()), 0);
    let mut buffer = vec![0; 1 << 16];
    loop {
        let count = file.read(&mut buffer).named(path)?;
        if count == 0 {
            return Ok((hex::encode(hash.finalize()), bytes));
        }
        bytes += count as u64;
        hash.update(&buffer[..count]);
    }
}

/// A feature that Lutra makes from data other than cells.
pub(crate) fn made(
    record: u32,
    class: ObjectClass,
    attributes: Vec<Attribute>,
    geometry: Geometry,
) -> Feature {
    Feature {
        record,
        object: ObjectId::default(),
        class,
        group: if class == ObjectClass::SOUNDG { 2 } else { 1 },
        version: 1,
        attributes,
        national: Vec::new(),
        links: Vec::new(),
        geometry,
    }
}

/// The notice for positions in a datum other than WGS 84.
pub(crate) fn datum_notice(datum: Datum) -> Option<String> {
    (datum != Datum::Wgs84).then(|| {
        format!(
            "positions are ETRS89: up to {} m from WGS 84, to be allowed for by the position uncertainty",
            datum.offset_m()
        )
    })
}

/// Imports an .xyz file, some thousand lines at a time.
pub(crate) fn soundings(stage: &mut Stage, path: &Path, options: &ImportOptions) -> Result<Imported> {
    let file = path.display().to_string();
    let Some(epsg) = options.epsg else {
        let problem = "the file does not say its coordinate system; give it by --epsg, like --epsg 25833 for \
                       EUREF89 UTM 33";
        return Err(ChartDbError::file(file, problem));
    };
    let utm = Utm::from_epsg(epsg).map_err(|error| ChartDbError::file(&file, error.to_string()))?;
    let (sha256, bytes) = hash(path, &format!("xyz {epsg} {:?}\n", options.vertical))?;
    let before = stage.chart(&name(path))?;
    refuse_other_kind(before.as_ref(), "soundings", path)?;
    if let Some(chart) = before.as_ref().filter(|chart| chart.sha256 == sha256) {
        return Ok(unchanged(chart, "soundings"));
    }
    let source = source(path, "soundings", sha256, bytes, options);
    let notices: Vec<String> = datum_notice(utm.datum()).into_iter().collect();
    let noted: Vec<_> = notices.iter().map(|text| (file.clone(), None, text.clone())).collect();
    let mut blocks = Blocks::open(path, utm, options.vertical)?;
    let features = stage.write(&source, before.as_ref(), noted, |writer| {
        let feature = made(1, ObjectClass::SOUNDG, Vec::new(), Geometry::Soundings(Vec::new()));
        writer.feature(&feature, &Zones::of(&[]))?;
        let mut count = 0;
        loop {
            let block = blocks.next_block()?;
            if block.is_empty() {
                return Ok(());
            }
            writer.soundings(&feature, &block, count)?;
            count += block.len();
        }
    })?;
    Ok(imported(source, before.as_ref(), features, notices))
}

/// Soundings of a file in blocks of whole lines.
struct Blocks<'a> {
    file: BufReader<File>,
    path: &'a Path,
    utm: Utm,
    vertical: Vertical,
    lines: usize,
    offset: usize,
}

impl<'a> Blocks<'a> {
    fn open(path: &'a Path, utm: Utm, vertical: Vertical) -> Result<Self> {
        let file = BufReader::new(File::open(path).named(path)?);
        Ok(Self { file, path, utm, vertical, lines: 0, offset: 0 })
    }

    /// The next soundings; empty at the end of the file.
    fn next_block(&mut self) -> Result<Vec<Sounding>> {
        let fail = |error: &XyzError| ChartDbError::file(self.path.display().to_string(), error.to_string());
        let mut text = Vec::new();
        loop {
            text.clear();
            let mut lines = 0;
            while lines < LINES {
                let count =
                    (&mut self.file).take(LINE_BYTES).read_until(b'\n', &mut text).named(self.path)?;
                if count == 0 {
                    break;
                }
                if count as u64 == LINE_BYTES && text.last() != Some(&b'\n') {
                    let problem =
                        format!("line {}: it is not a sounding, but very long", self.lines + lines + 1);
                    return Err(ChartDbError::file(self.path.display().to_string(), problem));
                }
                lines += 1;
            }
            let soundings = xyz::read(&text, self.utm, self.vertical).map_err(|mut error| {
                error.line += self.lines;
                error.offset += self.offset;
                fail(&error)
            })?;
            self.lines += lines;
            self.offset += text.len();
            if !soundings.is_empty() || text.is_empty() {
                return Ok(soundings);
            }
        }
    }
}

/// Imports a GeoJSON land mask.
pub(crate) fn land(stage: &mut Stage, path: &Path, options: &ImportOptions) -> Result<Imported> {
    let file = path.display().to_string();
    let (sha256, bytes) = hash(path, "land\n")?;
    let before = stage.chart(&name(path))?;
    refuse_other_kind(before.as_ref(), "land", path)?;
    if let Some(chart) = before.as_ref().filter(|chart| chart.sha256 == sha256) {
        return Ok(unchanged(chart, "land"));
    }
    if bytes > LAND_BYTES {
        let problem =
            format!("it has {bytes} bytes, more than {LAND_BYTES}; cut it to the area of operation");
        return Err(ChartDbError::file(file, problem));
    }
    let text = std::fs::read(path).named(path)?;
    let areas =
        geojson::read_polygons(&text).map_err(|error| ChartDbError::file(&file, error.to_string()))?;
    drop(text);
    let source = source(path, "land", sha256, bytes, options);
    let features = stage.write(&source, before.as_ref(), Vec::new(), |writer| {
        let zones = Zones::of(&[]);
        for (at, polygon) in areas.into_iter().enumerate() {
            let feature = made(at as u32 + 1, ObjectClass::LNDARE, Vec::new(), Geometry::Area(area(polygon)));
            writer.feature(&feature, &zones)?;
        }
        Ok(())
    })?;
    Ok(imported(source, before.as_ref(), features, Vec::new()))
}

fn area(polygon: Polygon) -> Area {
    let point = |at: geofile::Position| GeoPoint { lon_deg: at.lon_deg, lat_deg: at.lat_deg };
    let ring = |ring: Vec<geofile::Position>| Ring {
        points: ring.into_iter().map(point).collect(),
        edges: Vec::new(),
    };
    let mut rings = polygon.into_iter().map(ring);
    Area { exteriors: rings.next().into_iter().collect(), holes: rings.collect() }
}
