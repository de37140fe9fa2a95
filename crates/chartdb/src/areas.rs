//! No-go areas of the people who run the vessels, in a chart set as areas where entry is prohibited: so the guard, routes and
//! the vessels themselves know them by the chart that they have anyway.

use crate::error::Result;
use crate::locate::Zones;
use crate::read::{Chart, ChartDb};
use crate::stage::Stage;
use crate::supplements::{made, refuse_other_kind};
use crate::write::{Entry, NewSource};
use charts::s57::{Area, Attribute, AttributeCode, GeoPoint, Geometry, ObjectClass, Path as Ring};
use sha2::{Digest as _, Sha256};
use std::path::Path;
use units::{LatLon, UtcTime};

/// The chart that they are in a set.
pub const NO_GO_AREAS: &str = "no-go-areas";
/// Its kind.
pub(crate) const KIND: &str = "areas";
/// RESTRN: entry prohibited.
const ENTRY_PROHIBITED: &str = "7";

/// An area that no vessel may enter.
#[derive(Debug, Clone, PartialEq)]
pub struct NoGoArea {
    /// Its number, 1 and more, which no other area has.
    pub number: u32,
    /// What people call it.
    pub name: String,
    /// Its corners; the last joins the first.
    pub corners: Vec<LatLon>,
}

impl Chart {
    /// Whether these are no-go areas of people, and no chart.
    pub fn is_no_go_areas(&self) -> bool {
        self.name == NO_GO_AREAS && self.kind == KIND
    }
}

/// Digest of these areas in a set.
pub fn no_go_digest(areas: &[NoGoArea]) -> String {
    let mut hash = Sha256::new_with_prefix("no-go areas 1\n");
    for NoGoArea { number, name, corners } in areas {
        hash.update(number.to_le_bytes());
        hash.update((name.len() as u64).to_le_bytes());
        hash.update(name);
        hash.update((corners.len() as u64).to_le_bytes());
        for corner in corners {
            hash.update(corner.lat_deg().to_le_bytes());
            hash.update(corner.lon_deg().to_le_bytes());
        }
    }
    hex::encode(hash.finalize())
}

/// The digest of the areas that these charts of a set hold: without areas, the digest of an empty list.
pub fn no_go_digest_of(charts: &[Chart]) -> String {
    let held = charts.iter().find(|chart| chart.is_no_go_areas());
    held.map_or_else(|| no_go_digest(&[]), |chart| chart.sha256.clone())
}

/// Makes a set hold exactly these areas; a set that already does is not written.
///
/// # Errors
/// When there is no set, another process is changing it, or it cannot be written; then it stays as it was.
pub fn put_no_go_areas(db: &Path, areas: &[NoGoArea], now: UtcTime) -> Result<()> {
    let digest = no_go_digest(areas);
    if no_go_digest_of(&ChartDb::open(db)?.charts()?) == digest {
        return Ok(());
    }
    let mut stage = Stage::fresh(db)?;
    let before = stage.chart(NO_GO_AREAS)?;
    refuse_other_kind(before.as_ref(), KIND, Path::new(NO_GO_AREAS))?;
    let time = now.to_string();
    if areas.is_empty() {
        let text = "no areas are left";
        let entry = Entry { source: None, cell: NO_GO_AREAS, file: "", record: None, what: "removed", text };
        stage.take_out(&time, &entry)?;
    } else {
        stage.write(
            &NewSource::supplement(NO_GO_AREAS.to_owned(), KIND, digest, time.clone()),
            before.as_ref(),
            Vec::new(),
            |writer| {
                let zones = Zones::of(&[]);
                areas.iter().try_for_each(|area| writer.feature(&feature(area), &zones))
            },
        )?;
    }
    stage.finish(&time)?;
    crate::load_index(db).map(|_| ())
}

fn feature(area: &NoGoArea) -> charts::s57::Feature {
    let point = |at: &LatLon| GeoPoint { lon_deg: at.lon_deg(), lat_deg: at.lat_deg() };
    let mut points: Vec<GeoPoint> = area.corners.iter().map(point).collect();
    points.extend(points.first().copied());
    let attribute = |code, value: &str| Attribute { code, value: value.to_owned() };
    let attributes = vec![
        attribute(AttributeCode::OBJNAM, &area.name),
        attribute(AttributeCode::RESTRN, ENTRY_PROHIBITED),
    ];
    let ring = Ring { points, edges: Vec::new() };
    let geometry = Geometry::Area(Area { exteriors: vec![ring], holes: Vec::new() });
    made(area.number, ObjectClass::RESARE, attributes, geometry)
}
