//! Detections in Google Earth: a KML 2.2 placemark each, with its moment, so that the time slider plays a season.
//!
//! A placemark has a place: detections without one are left out.

use super::about::escaped;
use super::columns::{LUTRA_COLUMNS, values};
use super::{Document, Format, Rows};
use crate::study::Heard;
use std::fmt::Write as _;
use tables::IsoTime;

pub(super) const FORMAT: Format = Format {
    name: "kml",
    about: "Google Earth: a place mark each, with every column; those with a place only",
    header: "<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n\
             <kml xmlns=\"http://www.opengis.net/kml/2.2\"><Document><name>Detections</name>\n",
    absent: "",
    rows: Rows::Elements(Document {
        ending: "kml",
        media: "application/vnd.google-earth.kml+xml",
        element,
        between: "\n",
        end: "\n</Document></kml>\n",
    }),
    has_lag: true,
};

fn element(out: &mut String, heard: &Heard<'_>) -> bool {
    let one = heard.detection;
    let Some(pose) = one.pose else { return false };
    let name = heard.animal.map_or_else(|| one.tag(), |animal| animal.name.clone());
    let mut time = Vec::new();
    IsoTime::new().write_ms(&mut time, heard.time_us);
    // Writing to a text cannot fail.
    let _ = write!(
        out,
        "<Placemark><name>{}</name><TimeStamp><when>{}</when></TimeStamp><ExtendedData>",
        escaped(&name),
        String::from_utf8_lossy(&time)
    );
    let mut columns = LUTRA_COLUMNS.iter();
    values(heard, &mut |value| {
        let (Some(column), Some((text, _))) = (columns.next(), value.plain()) else { return };
        let (name, text) = (escaped(column.name), escaped(&text));
        let _ = write!(out, "<Data name=\"{name}\"><value>{text}</value></Data>");
    });
    let (lat_deg, lon_deg) = (pose.place.lat_deg(), pose.place.lon_deg());
    let _ = write!(
        out,
        "</ExtendedData><Point><coordinates>{lon_deg:.8},{lat_deg:.8}</coordinates></Point></Placemark>"
    );
    true
}
