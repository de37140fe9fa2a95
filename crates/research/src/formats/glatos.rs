//! The detection export of GLATOS, 1.4.
//!
//! `min_lag` is the time to the nearest other detection of the tag by the same receiver, within a day; where
//! no other was heard in that time it stays empty.

use super::cells::Cells;
use super::vue::sensor;
use super::{Format, Rows};
use crate::study::Heard;

pub(super) const FORMAT: Format = Format {
    name: "glatos",
    about: "GLATOS 1.4, with min_lag; glatos reads it",
    header: "animal_id,detection_timestamp_utc,glatos_array,station_no,transmitter_codespace,transmitter_id,sensor_value,\
             sensor_unit,deploy_lat,deploy_long,receiver_sn,tag_type,tag_model,tag_serial_number,common_name_e,\
             capture_location,length,weight,sex,release_group,release_location,release_latitude,release_longitude,\
             utc_release_date_time,glatos_project_transmitter,glatos_project_receiver,glatos_tag_recovered,\
             glatos_caught_date,station,min_lag,record_status\n",
    absent: "",
    rows: Rows::Detections(row),
    has_lag: true,
};

fn row(cells: &mut Cells<'_>, heard: &Heard<'_>) -> bool {
    let one = heard.detection;
    let (animal, tag) = (heard.animal, heard.tag);
    cells.maybe(animal.map(|animal| &*animal.name));
    cells.blank_ms(Some(heard.time_us));
    // The array is the fleet of a project, and each vessel a station of it.
    cells.maybe(heard.deployment.map(|deployment| &*deployment.project));
    cells.text(heard.vessel);
    cells.text(&heard.codespace());
    cells.whole(Some(one.tag_id.into()));
    sensor(cells, heard);
    cells.degrees(one.pose.map(|pose| pose.place.lat_deg()));
    cells.degrees(one.pose.map(|pose| pose.place.lon_deg()));
    cells.whole(Some(one.receiver.into()));
    cells.maybe(tag.map(|tag| &*tag.sensor_type));
    cells.maybe(tag.map(|tag| &*tag.model));
    cells.maybe(tag.map(|tag| &*tag.serial));
    cells.maybe(animal.map(|animal| &*animal.common_name));
    cells.maybe(animal.map(|animal| &*animal.capture_place));
    // Metres and kilograms.
    cells.number(animal.and_then(|animal| animal.length_mm).map(|length_mm| length_mm / 1_000.0));
    cells.number(animal.and_then(|animal| animal.weight_g).map(|weight_g| weight_g / 1_000.0));
    cells.maybe(animal.map(|animal| &*animal.sex));
    cells.maybe(animal.map(|animal| &*animal.release_group));
    cells.maybe(animal.map(|animal| &*animal.release_place));
    cells.degrees(animal.and_then(|animal| animal.release_lat_deg));
    cells.degrees(animal.and_then(|animal| animal.release_lon_deg));
    cells.blank_s(animal.and_then(|animal| animal.release_us));
    cells.maybe(heard.project.map(|project| &*project.name));
    cells.maybe(heard.deployment.map(|deployment| &*deployment.project));
    cells.nothings(2);
    cells.text(heard.vessel);
    cells.number(heard.lag.seconds());
    cells.nothing();
    true
}
