//! GeoPackage: detections as a layer of points in a database.
//!
//! A database is a file that is written in more than one place, which this crate does not do: `shore` writes it by the columns and values
//! of here.

use super::{Format, Rows};

pub(super) const FORMAT: Format = Format {
    name: "geopackage",
    about: "QGIS, ArcGIS, GDAL, R's sf: layers of detections, with every column, and of the vessels' tracks",
    // What the file begins with.
    header: "SQLite format 3",
    absent: "",
    rows: Rows::Database,
    has_lag: true,
};
