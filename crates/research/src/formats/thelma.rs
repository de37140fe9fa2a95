//! The CSV that Thelma Biotel's ComPort writes, of before and of now. Data and ratios that are absent are `-` in both, and a
//! protocol of unknown carrier has its name alone.

use super::cells::Cells;
use super::{Format, Rows};
use crate::study::Heard;

pub(super) const OLD: Format = Format {
    name: "thelma-old",
    about: "ComPort of Thelma Biotel, earlier versions; actel reads it",
    header: "Date and Time UTC,TBR Serial Number,Unix Timestamp UTC,Millisecond,CodeType,Id,Data,Signal to Noise Ratio\n",
    absent: "-",
    rows: Rows::Detections(old),
    has_lag: false,
};

pub(super) const NEW: Format = Format {
    name: "thelma",
    about: "ComPort of Thelma Biotel; actel reads it",
    header: "Date and Time (UTC),Unix Timestamp (UTC),ID,Data,Protocol,SNR,Receiver\n",
    absent: "-",
    rows: Rows::Detections(new),
    has_lag: false,
};

fn old(cells: &mut Cells<'_>, heard: &Heard<'_>) -> bool {
    let one = heard.detection;
    cells.blank_s(Some(heard.time_us));
    cells.whole(Some(one.receiver.into()));
    cells.whole(Some(heard.time_us.div_euclid(1_000_000)));
    cells.whole(Some(heard.time_us.rem_euclid(1_000_000) / 1_000));
    cells.text(&one.protocol.to_string());
    cells.whole(Some(one.tag_id.into()));
    cells.whole(one.data.map(i64::from));
    cells.whole(one.snr_db.map(i64::from));
    true
}

fn new(cells: &mut Cells<'_>, heard: &Heard<'_>) -> bool {
    let one = heard.detection;
    cells.blank_ms(Some(heard.time_us));
    let (seconds, millis) =
        (heard.time_us.div_euclid(1_000_000), heard.time_us.rem_euclid(1_000_000) / 1_000);
    cells.decimals(&format!("{seconds}.{millis:03}"));
    cells.whole(Some(one.tag_id.into()));
    cells.whole(one.data.map(i64::from));
    let carrier = one.frequency_khz.map_or_else(String::new, |khz| format!("-{khz}kHz"));
    cells.text(&format!("{}{carrier}", one.protocol));
    cells.whole(one.snr_db.map(i64::from));
    cells.whole(Some(one.receiver.into()));
    true
}
