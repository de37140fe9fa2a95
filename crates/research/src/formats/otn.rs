//! The detection extract of the Ocean Tracking Network, as it is since 2025.
//!
//! `detectedBy` is the project of the receiver's deployment. The day of the last change of a row is that on which it came
//! ashore. Both times are given: the collected one is the vessel's where the receiver's clock was never set, and the
//! uncorrected one always what the receiver counted.

use super::cells::Cells;
use super::{Format, Rows};
use crate::study::Heard;

pub(super) const FORMAT: Format = Format {
    name: "otn",
    about: "Ocean Tracking Network, detection extract since 2025; glatos and resonATe read it",
    header: "collectionCode,catalogNumber,organismID,scientificName,commonName,dateLastModified,detectedBy,station,receiver,\
             bottomDepth,receiverDepth,tagName,codeSpace,sensorName,sensorRaw,sensorType,sensorValue,sensorUnit,\
             dateCollectedUTC,uncorrectedDateCollectedUTC,decimalLongitude,decimalLatitude,geodeticDatum,geometry,localArea,\
             citation,unqDetecID,contactPOC,contactPI\n",
    absent: "",
    rows: Rows::Detections(row),
    has_lag: false,
};

fn row(cells: &mut Cells<'_>, heard: &Heard<'_>) -> bool {
    let one = heard.detection;
    let code = heard.codespace();
    cells.maybe(heard.project.map(|project| &*project.name));
    cells.maybe(heard.animal.map(|animal| &*animal.name).or(heard.tag.map(|tag| &*tag.name)));
    cells.maybe(heard.animal.map(|animal| &*animal.name));
    cells.maybe(heard.animal.map(|animal| &*animal.scientific_name));
    cells.maybe(heard.animal.map(|animal| &*animal.common_name));
    cells.iso_s(one.origin.received.map(units::UtcTime::micros));
    cells.maybe(heard.deployment.map(|deployment| &*deployment.project));
    cells.text(heard.vessel);
    cells.whole(Some(one.receiver.into()));
    cells.nothing();
    cells.number(heard.deployment.and_then(|deployment| deployment.depth_m));
    cells.text(&format!("{code}-{}", one.tag_id));
    cells.text(&code);
    let sensor = heard.sensor();
    cells.maybe(sensor.map(|sensor| sensor.kind));
    cells.whole(one.data.map(i64::from));
    cells.maybe(sensor.map(|sensor| sensor.kind));
    cells.number(sensor.map(|sensor| sensor.value));
    cells.maybe(sensor.map(|sensor| sensor.unit));
    cells.iso_ms(Some(heard.time_us));
    cells.iso_ms(Some(one.clock.micros()));
    place(cells, heard);
    cells.nothing();
    cells.maybe(heard.project.map(|project| &*project.citation));
    cells.text(&unique_id(heard));
    cells.maybe(heard.contact.map(|person| &*person.name));
    cells.maybe(heard.principal_investigator.map(|person| &*person.name));
    true
}

fn place(cells: &mut Cells<'_>, heard: &Heard<'_>) {
    let place = heard.detection.pose.map(|pose| (pose.place.lon_deg(), pose.place.lat_deg()));
    cells.degrees(place.map(|(lon, _)| lon));
    cells.degrees(place.map(|(_, lat)| lat));
    cells.maybe(place.map(|_| "EPSG:4326"));
    match place {
        Some((lon, lat)) => cells.text(&format!("POINT ({lon:.8} {lat:.8})")),
        None => cells.nothing(),
    }
}

/// Unique among all detections, as the detection's id is among those of a vessel, and the same whatever the register says.
fn unique_id(heard: &Heard<'_>) -> String {
    format!("LUTRA-{:04x}-{}", heard.detection.origin.system.0, heard.detection.id())
}
