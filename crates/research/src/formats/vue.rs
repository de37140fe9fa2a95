//! The CSV of detections that VUE exports (Innovasea, formerly Vemco).
//!
//! The station is the vessel, whose place is that of each detection. A count that the register gives no meaning to has the
//! unit `ADC`, as VUE calls it.

use super::cells::Cells;
use super::{Format, Rows};
use crate::study::Heard;

pub(super) const FORMAT: Format = Format {
    name: "vue",
    about: "VUE of Innovasea (Vemco); glatos, actel and yaps read it",
    header: "Date and Time (UTC),Receiver,Transmitter,Transmitter Name,Transmitter Serial,Sensor Value,Sensor Unit,\
             Station Name,Latitude,Longitude\n",
    absent: "",
    rows: Rows::Detections(row),
    has_lag: false,
};

/// The unit of a count without a meaning.
const COUNT: &str = "ADC";

fn row(cells: &mut Cells<'_>, heard: &Heard<'_>) -> bool {
    let one = heard.detection;
    cells.blank_ms(Some(heard.time_us));
    cells.text(&format!("{}-{}", heard.model(), one.receiver));
    cells.text(&format!("{}-{}", heard.codespace(), one.tag_id));
    cells.maybe(heard.tag.map(|tag| &*tag.name));
    cells.maybe(heard.tag.map(|tag| &*tag.serial));
    sensor(cells, heard);
    cells.text(heard.vessel);
    cells.degrees(one.pose.map(|pose| pose.place.lat_deg()));
    cells.degrees(one.pose.map(|pose| pose.place.lon_deg()));
    true
}

/// Value and unit of a tag's measurement; its count where nothing else is known.
pub(super) fn sensor(cells: &mut Cells<'_>, heard: &Heard<'_>) {
    if let Some(sensor) = heard.sensor() {
        cells.number(Some(sensor.value));
        cells.text(sensor.unit);
    } else {
        cells.whole(heard.detection.data.map(i64::from));
        cells.maybe(heard.detection.data.map(|_| COUNT));
    }
}
