//! Detections as points of NetCDF, a record each, with all columns.
//!
//! How many records there are, and how long their texts, stands in the header; so rows wait until all are there. A point has a place:
//! detections without one are left out. A text of more than 255 bytes is cut there, which the file says.

use super::super::about::{About, Covered, iso};
use super::super::columns::{ColumnKind, LUTRA_COLUMNS, values};
use super::super::waiting::{Spool, Waiting};
use super::super::{DetectionColumn, Format, Rows};
use super::classic::{Attribute, Attributes, Classic, Kind, Over, Variable, fill};
use super::{SINCE, common, coordinates, crs, extent, seconds};
use crate::study::Heard;
use std::io::{self, Read, Write};

/// Bytes of a text at most.
const TEXT: usize = 255;

pub(in super::super) const FORMAT: Format = Format {
    name: "netcdf",
    about: "oceanographers, xarray, ncdf4: NetCDF with CF-1.10 and ACDD-1.3, a point each, every column; those with a place only",
    // What the file begins with.
    header: "CDF",
    absent: "",
    rows: Rows::Points,
    has_lag: true,
};

/// Columns that are the coordinates.
const COORDINATES: [&str; 2] = ["latitude", "longitude"];

/// Points on their way into a file.
#[derive(Debug)]
pub(in super::super) struct Points {
    waiting: Waiting,
    rows: u32,
    /// The longest text of each column, bytes.
    widths: [usize; LUTRA_COLUMNS.len()],
    covered: Covered,
}

impl Points {
    /// Without a row yet.
    ///
    /// # Errors
    /// There is no place where rows can wait.
    pub(in super::super) fn new(spool: Option<Box<dyn Spool>>) -> io::Result<Self> {
        let widths = [1; LUTRA_COLUMNS.len()];
        Ok(Self { waiting: Waiting::new(spool)?, rows: 0, widths, covered: Covered::default() })
    }

    /// Takes a detection; `false` where it has no place.
    ///
    /// # Errors
    /// Where rows wait is full, or there are more than the format can count.
    pub(in super::super) fn row(&mut self, heard: &Heard<'_>) -> io::Result<bool> {
        let Some(pose) = heard.detection.pose else { return Ok(false) };
        self.rows = self.rows.checked_add(1).ok_or_else(|| {
            io::Error::new(
                io::ErrorKind::FileTooLarge,
                "NetCDF counts up to 4294967295 detections; ask for a shorter time",
            )
        })?;
        self.covered.take(heard);
        let mut row = Vec::with_capacity(512);
        for value in [seconds(heard.time_us), pose.place.lat_deg(), pose.place.lon_deg()] {
            row.extend_from_slice(&value.to_be_bytes());
        }
        let mut columns = LUTRA_COLUMNS.iter().zip(&mut self.widths);
        values(heard, &mut |value| {
            let Some((column, width)) = columns.next() else { return };
            match column.kind {
                _ if COORDINATES.contains(&column.bare_name()) => {}
                ColumnKind::Text => {
                    let plain = value.plain();
                    let text = plain.as_ref().map_or("", |(text, _)| cut(text));
                    *width = text.len().max(*width);
                    row.push(text.len() as u8);
                    row.extend_from_slice(text.as_bytes());
                }
                ColumnKind::Time => {
                    row.extend_from_slice(&value.micros().map_or(f64::NAN, seconds).to_be_bytes());
                }
                ColumnKind::Whole | ColumnKind::Real => {
                    row.extend_from_slice(&value.number().unwrap_or(f64::NAN).to_be_bytes());
                }
            }
        });
        self.waiting.push(&row)?;
        Ok(true)
    }

    /// Writes all.
    ///
    /// # Errors
    /// As [`Self::row()`], or `out` cannot be written.
    pub(in super::super) fn end(self, out: &mut dyn Write, about: &About) -> io::Result<()> {
        let variables = self.variables();
        let kinds: Vec<Kind> =
            variables.iter().filter(|one| one.over == Over::Records).map(|one| one.kind).collect();
        // Before the first byte goes out: what finds no room here is refused, and not cut.
        let mut waiting = self.waiting.read()?;
        let header =
            Classic { records: ("obs", self.rows), attributes: described(about, &self.covered), variables };
        header.write(out)?;
        let mut record = Vec::new();
        for _ in 0..self.rows {
            record.clear();
            for kind in &kinds {
                read(&mut waiting, *kind, &mut record)?;
            }
            out.write_all(&record)?;
        }
        Ok(())
    }

    fn variables(&self) -> Vec<Variable> {
        let when = "when the receiver heard the tag, by its clock; by the vessel's where that was never set or was lost";
        let columns = LUTRA_COLUMNS.iter().zip(self.widths);
        let columns = columns.filter(|(column, _)| !COORDINATES.contains(&column.bare_name()));
        let columns = columns.map(|(column, width)| variable(column, width));
        std::iter::once(crs()).chain(coordinates(when)).chain(columns).collect()
    }
}

/// Not more than a text may have, and whole letters.
fn cut(text: &str) -> &str {
    &text[..text.floor_char_boundary(TEXT)]
}

/// Appends a value of a record.
fn read(waiting: &mut impl Read, kind: Kind, record: &mut Vec<u8>) -> io::Result<()> {
    let begins = record.len();
    let bytes = match kind {
        Kind::Text(_) => {
            let mut length = [0];
            waiting.read_exact(&mut length)?;
            usize::from(length[0])
        }
        kind => kind.bytes() as usize,
    };
    record.resize(begins + bytes, 0);
    waiting.read_exact(&mut record[begins..])?;
    record.resize(begins + kind.bytes() as usize, 0);
    fill(record);
    Ok(())
}

/// The variable of a column.
fn variable(column: &DetectionColumn, width: usize) -> Variable {
    let mut attributes: Attributes = vec![("long_name", Attribute::Text(long_name(column)))];
    let kind = match column.kind {
        ColumnKind::Text => Kind::Text(width as u32),
        ColumnKind::Time => {
            attributes.extend([("units", SINCE.into()), ("calendar", "standard".into())]);
            Kind::Double
        }
        ColumnKind::Whole | ColumnKind::Real => {
            attributes.extend(units(column).map(|unit| ("units", Attribute::from(unit))));
            Kind::Double
        }
    };
    match kind {
        Kind::Text(_) => attributes.push(("_Encoding", "utf-8".into())),
        _ => attributes.push(("_FillValue", Attribute::Double(f64::NAN))),
    }
    attributes.push(("coordinates", "time latitude longitude".into()));
    attributes.push(("grid_mapping", super::CRS.into()));
    let name = column.bare_name().replace("_utc", "_time");
    Variable { name, kind, over: Over::Records, attributes, values: Vec::new() }
}

/// What it tells, and where its unit stands if that is none of its own.
fn long_name(column: &DetectionColumn) -> String {
    if has_unit_beside(column) {
        format!("{}; in the unit that stands in sensor_unit", column.about)
    } else {
        column.about.to_owned()
    }
}

/// Whether the unit differs between tags, and is a column of its own.
fn has_unit_beside(column: &DetectionColumn) -> bool {
    column.bare_name() == "sensor_reading"
}

/// The unit as UDUNITS knows it; absent where it stands beside.
fn units(column: &DetectionColumn) -> Option<&'static str> {
    match column.unit() {
        _ if has_unit_beside(column) => None,
        None | Some("count") => Some("1"),
        // A ratio of powers: UDUNITS has no decibel without what it refers to.
        Some("dB") => Some("0.1 lg(re 1)"),
        Some("deg") => Some("degrees"),
        unit => unit,
    }
}

/// What the file says of itself.
fn described(about: &About, covered: &Covered) -> Attributes {
    let mut all = common("point");
    let creators = covered.creators(about);
    let joined = |of: fn(&api::DatasetAuthor) -> &str| {
        let texts: Vec<&str> = creators.iter().map(of).filter(|text| !text.is_empty()).collect();
        texts.join("; ")
    };
    let projects: Vec<&str> = covered.projects.iter().map(String::as_str).collect();
    let species: Vec<&str> = covered.species.iter().map(String::as_str).collect();
    let keywords = ["acoustic telemetry", "fish tracking", "uncrewed surface vehicle"];
    let keywords: Vec<&str> = keywords.into_iter().chain(species).collect();
    let coarse = covered.coarsening();
    let texts = [
        ("title", about.title().to_owned()),
        ("summary", about.summary().to_owned()),
        ("keywords", keywords.join(", ")),
        ("id", about.id.clone()),
        ("license", covered.licence(about)),
        ("creator_name", joined(|one| &one.name)),
        ("creator_institution", joined(|one| &one.affiliation)),
        ("creator_url", joined(|one| &one.orcid)),
        ("publisher_name", about.publisher.clone()),
        ("institution", about.publisher.clone()),
        ("project", projects.join("; ")),
        ("references", about.citation.clone()),
        ("source", "acoustic receivers on uncrewed surface vessels".to_owned()),
        ("platform", "uncrewed surface vehicle".to_owned()),
        ("processing_level", "detections as the receivers reported them; nothing is filtered".to_owned()),
        ("comment", comment(&coarse)),
        ("date_created", about.published_us.or(covered.came_us).map_or_else(String::new, iso)),
    ];
    let known = texts.into_iter().filter(|(_, text)| !text.is_empty());
    all.extend(known.map(|(name, text)| (name, Attribute::Text(text))));
    all.extend(extent(covered.box_deg, covered.first_us, covered.last_us));
    all
}

fn comment(coarse: &str) -> String {
    let cut = "Texts of more than 255 bytes are cut. date_created is when the newest of these data came ashore, or when they were published.";
    if coarse.is_empty() { cut.to_owned() } else { format!("The {coarse}. {cut}") }
}
