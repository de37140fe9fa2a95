//! Events for Movebank: where an animal was heard, which is where the vessel was.
//!
//! An event has a place: detections without one are left out.

use super::cells::Cells;
use super::{Format, Rows};
use crate::study::Heard;

pub(super) const FORMAT: Format = Format {
    name: "movebank",
    about: "Movebank, events; those with a place only",
    header: "timestamp,location-long,location-lat,individual-local-identifier,tag-local-identifier,sensor-type,\
             individual-taxon-canonical-name\n",
    absent: "",
    rows: Rows::Detections(row),
    has_lag: false,
};

fn row(cells: &mut Cells<'_>, heard: &Heard<'_>) -> bool {
    let one = heard.detection;
    cells.blank_ms(Some(heard.time_us));
    cells.degrees(one.pose.map(|pose| pose.place.lon_deg()));
    cells.degrees(one.pose.map(|pose| pose.place.lat_deg()));
    cells.maybe(heard.animal.map(|animal| &*animal.name));
    cells.text(&heard.tag.map_or_else(|| one.tag(), |tag| tag.name.clone()));
    cells.text("acoustic-telemetry");
    cells.maybe(heard.animal.map(|animal| &*animal.scientific_name));
    one.pose.is_some()
}
