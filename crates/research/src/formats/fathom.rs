//! The CSV of Fathom (Innovasea's VDAT), version 2.0.0, of which we have the records `DET`.
//!
//! It has a place for each detection, which suits receivers that move. The time of the device is what its clock counted; the
//! correction is what is added to it where that clock was not set and the vessel's time stands in.

use super::cells::Cells;
use super::{Format, Rows};
use crate::study::Heard;

pub(super) const FORMAT: Format = Format {
    name: "fathom",
    about: "Fathom of Innovasea, VDAT 2.0.0 (records DET); a place for each detection",
    header: "VEMCO DATA LOG,2.0.0,Lutra\n\
             DET_DESC,Device Time (UTC),Time,Time Offset (h),Time Correction (s),Model,Serial Number,Channel,Detection Type,\
             Full ID,ID,Raw Data,Transmitter Serial,Signal Strength (dB),Noise (dB),Gain (dB),Quality Score,Station Name,\
             Latitude,Longitude,GPS HDOP\n",
    absent: "",
    rows: Rows::Detections(row),
    has_lag: false,
};

fn row(cells: &mut Cells<'_>, heard: &Heard<'_>) -> bool {
    let one = heard.detection;
    let device_us = one.clock.micros();
    cells.text("DET");
    cells.blank_ms(Some(device_us));
    cells.blank_ms(Some(heard.time_us));
    cells.decimals("0.00");
    cells.decimals(&format!("{:.3}", (heard.time_us - device_us) as f64 / 1e6));
    cells.text(heard.model());
    cells.whole(Some(one.receiver.into()));
    cells.nothing();
    cells.text("PPM");
    cells.text(&format!("{}-{}", heard.codespace(), one.tag_id));
    cells.whole(Some(one.tag_id.into()));
    cells.whole(one.data.map(i64::from));
    cells.maybe(heard.tag.map(|tag| &*tag.serial));
    // Receivers of Thelma tell a ratio of signal to noise, and neither by itself.
    cells.nothings(4);
    cells.text(heard.vessel);
    cells.degrees(one.pose.map(|pose| pose.place.lat_deg()));
    cells.degrees(one.pose.map(|pose| pose.place.lon_deg()));
    cells.nothing();
    true
}
