//! What must hold for any bytes that claim to be GPX or GeoJSON. The fuzz target calls this with bytes of its own
//! making, and `make test` with the committed seeds and everything that was ever found.

use geofile::{Geometry, Shapes, geojson, gpx};

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
