//! The table `detections` of a data package of the European Tracking Network (R package etn).
//!
//! Protocols stay as receivers name them where no code space is known for them (`R01M-802761`). Latitude and longitude are the
//! vessel's at each detection: the receiver moves with it. Whole seconds, as the package has them.

use super::cells::Cells;
use super::vue::sensor;
use super::{Format, Rows};
use crate::study::Heard;

pub(super) const FORMAT: Format = Format {
    name: "etn",
    about: "European Tracking Network, table detections of its data package",
    header: "detection_id,date_time,tag_serial_number,acoustic_tag_id,animal_project_code,animal_id,scientific_name,\
             acoustic_project_code,receiver_id,station_name,deploy_latitude,deploy_longitude,sensor_value,sensor_unit,\
             sensor2_value,sensor2_unit,signal_to_noise_ratio,source_file,qc_flag,deployment_id\n",
    absent: "",
    rows: Rows::Detections(row),
    has_lag: false,
};

fn row(cells: &mut Cells<'_>, heard: &Heard<'_>) -> bool {
    let one = heard.detection;
    cells.text(&format!("{:04x}-{}", one.origin.system.0, one.id()));
    cells.iso_s(Some(heard.time_us));
    cells.maybe(heard.tag.map(|tag| &*tag.serial));
    cells.text(&tag_id(heard));
    cells.maybe(heard.project.map(|project| &*project.name));
    cells.maybe(heard.animal.map(|animal| &*animal.name));
    cells.maybe(heard.animal.map(|animal| &*animal.scientific_name));
    cells.maybe(heard.deployment.map(|deployment| &*deployment.project));
    cells.text(&format!("{}-{}", heard.model(), one.receiver));
    cells.text(heard.vessel);
    cells.degrees(one.pose.map(|pose| pose.place.lat_deg()));
    cells.degrees(one.pose.map(|pose| pose.place.lon_deg()));
    sensor(cells, heard);
    cells.nothings(2);
    cells.whole(one.snr_db.map(i64::from));
    cells.nothings(2);
    cells.maybe(heard.deployment.map(|deployment| &*deployment.name));
    true
}

/// Code space and number; the protocol's own name where no code space is known.
fn tag_id(heard: &Heard<'_>) -> String {
    let one = heard.detection;
    let (code, protocol) = (heard.codespace(), one.protocol.to_string());
    let is_made = one.frequency_khz.is_some_and(|khz| code == format!("A{khz}-{protocol}"));
    format!("{}-{}", if is_made { &protocol } else { &code }, one.tag_id)
}
