//! What must hold for any bytes that claim to be a chart. The fuzz targets call these with bytes of their own
//! making, and `make test` with the committed seeds and everything that was ever found.

#![allow(dead_code, reason = "each fuzz target calls one of these")]

use charts::depth_index::{Demand, DepthIndex, IndexBuilder, Leg};
use charts::iso8211::{LexicalLevel, Reader};
use charts::s57::{Catalogue, Cell, GeoPoint, Geometry, NamedBytes};
use charts::utm::{Datum, Utm};
use charts::xyz;
use charts::xyz::Vertical;
use units::LatLon;

/// A container reads to its end or to an error that names place and remedy.
pub(crate) fn iso8211(data: &[u8]) {
    let mut reader = match Reader::new(data) {
        Ok(reader) => reader,
        Err(error) => return assert!(error.to_string().contains("; ")),
    };
    let mut row = Vec::new();
    let mut end = 0;
    while let Ok(Some(record)) = reader.next_record() {
        assert!(record.offset > end);
        end = record.offset;
        for field in &record.fields {
            let level = if field.bytes.len() % 2 == 0 { LexicalLevel::Ucs2 } else { LexicalLevel::Latin1 };
            let Ok(mut rows) = reader.rows(&record, *field, level) else { continue };
            while let Ok(true) = rows.next_into(&mut row) {}
        }
    }
    let _ = Catalogue::read("CATALOG.031", data);
}

/// A cell, and an update where the first two bytes say that one follows, give features or an error; what is
/// read can be asked for depths, and no data is never navigable.
pub(crate) fn s57(data: &[u8]) {
    let [low, high, data @ ..] = data else { return };
    let split = usize::from(u16::from_le_bytes([*low, *high])).min(data.len());
    let (base, update) = data.split_at(split);
    let update = NamedBytes { name: "NO5X0001.001", bytes: update };
    let updates = if update.bytes.is_empty() { &[][..] } else { std::slice::from_ref(&update) };
    let cell = match Cell::read(NamedBytes { name: "NO5X0001.000", bytes: base }, updates) {
        Ok(cell) => cell,
        Err(error) => return assert!(error.to_string().contains("NO5X0001.00")),
    };
    let vertices: usize = cell.features.iter().map(|feature| feature.geometry.points().count()).sum();
    assert!(vertices <= data.len() * 4 + 100_000);
    cell.skin_check();
    let mut builder = IndexBuilder::new();
    builder.add_cell(&cell).expect("positions were checked");
    let index = builder.build().expect("small");
    let around = cell.features.iter().find(|feature| !matches!(feature.geometry, Geometry::None));
    let place = around.and_then(|feature| feature.geometry.points().next()).and_then(GeoPoint::place);
    let place = place.unwrap_or_else(|| LatLon::from_deg(63.01, 10.02).expect("in range"));
    ask(&index, place);
    assert_eq!(DepthIndex::from_bytes(&index.to_bytes()).as_ref(), Ok(&index));
}

fn ask(index: &DepthIndex, from: LatLon) {
    let to = LatLon::from_rad((from.lat_rad() + 1e-5).min(1.57), from.lon_rad()).expect("in range");
    let demand = Demand::least_depth(1.0);
    let answer = index.shallowest_along(Leg { from, to }, 20.0, &demand);
    let danger = index.first_danger_along(Leg { from, to }, 20.0, &demand);
    assert_eq!(answer.navigable, danger.is_none(), "{answer:?} {danger:?}");
    // A point of a corridor is never worse than the corridor.
    let point = index.depth_at(from, &demand);
    assert!(point.navigable || !answer.navigable);
    index.points_of_interest(from, 3, 1_000.0, |_| true);
    index.distance_to_shallower(from, 1.0, 1_000.0);
}

/// Soundings.
pub(crate) fn text(data: &[u8]) {
    let utm = Utm::new(33, false, Datum::Etrs89).expect("a zone");
    if let Ok(soundings) = xyz::read(data, utm, Vertical::DepthDown) {
        assert!(soundings.iter().all(|one| one.at.place().is_some()));
    }
}

/// An index of any bytes answers or is refused.
pub(crate) fn index(data: &[u8]) {
    if let Ok(index) = DepthIndex::from_bytes(data) {
        ask(&index, LatLon::from_deg(63.01, 10.02).expect("in range"));
    }
}
