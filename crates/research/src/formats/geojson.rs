//! Detections on a map: a GeoJSON feature (RFC 7946) each, with all columns as its properties.
//!
//! A detection without a place is a feature without a geometry, as the standard has it: tables show it, maps do not.

use super::columns::{LUTRA_COLUMNS, values};
use super::{Document, Format, Rows};
use crate::study::Heard;
use std::fmt::Write as _;

pub(super) const FORMAT: Format = Format {
    name: "geojson",
    about: "QGIS and other programs with maps: a point each, with every column",
    header: "{\"type\":\"FeatureCollection\",\"features\":[\n",
    absent: "null",
    rows: Rows::Elements(Document {
        ending: "geojson",
        media: "application/geo+json",
        element,
        between: ",\n",
        end: "\n]}\n",
    }),
    has_lag: true,
};

fn element(out: &mut String, heard: &Heard<'_>) -> bool {
    let one = heard.detection;
    // A program takes the id for a key: it names the detection among those of all vessels.
    let id = quoted(&format!("{:04x}-{}", one.origin.system.0, one.id()));
    let geometry = one.pose.map_or_else(
        || "null".to_owned(),
        |pose| {
            let (lat_deg, lon_deg) = (pose.place.lat_deg(), pose.place.lon_deg());
            format!("{{\"type\":\"Point\",\"coordinates\":[{lon_deg:.8},{lat_deg:.8}]}}")
        },
    );
    // Writing to a text cannot fail.
    let _ = write!(out, "{{\"type\":\"Feature\",\"id\":{id},\"geometry\":{geometry},\"properties\":{{");
    let mut columns = LUTRA_COLUMNS.iter().enumerate();
    values(heard, &mut |value| {
        let Some((at, column)) = columns.next() else { return };
        let comma = if at > 0 { "," } else { "" };
        let _ = match value.plain() {
            None => write!(out, "{comma}{}:null", quoted(column.name)),
            Some((number, true)) => write!(out, "{comma}{}:{number}", quoted(column.name)),
            Some((text, false)) => write!(out, "{comma}{}:{}", quoted(column.name), quoted(&text)),
        };
    });
    out.push_str("}}");
    true
}

fn quoted(text: &str) -> String {
    serde_json::Value::from(text).to_string()
}
