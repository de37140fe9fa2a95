//! What must hold for any bytes that claim to be GPX, GeoJSON, or a grid of currents in CSV or NetCDF. The fuzz target calls this with bytes of its own
//! making, and `make test` with the committed seeds and everything that was ever found.

use geofile::{Geometry, Shapes, currents, geojson, gpx};

/// A file is read or refused in words; what is read can be written and read again.
pub(crate) fn file(data: &[u8]) {
    match gpx::read(data) {
        Ok(shapes) => again(&shapes),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    match geojson::read(data) {
        Ok(shapes) => again(&shapes),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    match geojson::read_polygons(data) {
        Ok(polygons) => assert!(polygons.iter().flatten().all(|ring| ring.len() >= 4)),
        Err(error) => assert!(!error.to_string().is_empty()),
    }
    match currents::read(data) {
        Ok(field) => {
            let crossings = field.times_s.len() * field.lats_deg.len() * field.lons_deg.len();
            assert_eq!((field.east_mps.len(), field.north_mps.len()), (crossings, crossings));
            assert!(crossings <= currents::MOST_CROSSINGS);
        }
        Err(error) => assert!(!error.to_string().is_empty()),
    }
}

fn again(shapes: &Shapes) {
    let read = geojson::read(geojson::write(shapes).as_bytes()).expect("we wrote it");
    assert_eq!(read.shapes, shapes.shapes);
    let points = |shapes: &Shapes| -> usize {
        let count = |geometry: &Geometry| match geometry {
            Geometry::Point(_) => 1,
            Geometry::Line(points) => points.len(),
        };
        shapes.shapes.iter().map(|shape| count(&shape.geometry)).sum()
    };
    let read = gpx::read(gpx::write(shapes).as_bytes()).expect("we wrote it");
    assert_eq!(points(&read), points(shapes));
}
