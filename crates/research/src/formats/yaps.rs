//! Detections for the R package yaps, which finds positions from arrival times.
//!
//! Such times must be the receiver's own: detections of a clock that was never set, or was lost, are left out. yaps takes
//! receivers for fixed, so that only what vessels heard at anchor is fit for it.

use super::cells::Cells;
use super::{Format, Rows};
use crate::study::Heard;

pub(super) const FORMAT: Format = Format {
    name: "yaps",
    about: "yaps, its detections; only for vessels that lay still",
    header: "ts,tag,epo,frac,serial\n",
    absent: "NA",
    rows: Rows::Detections(row),
    has_lag: false,
};

fn row(cells: &mut Cells<'_>, heard: &Heard<'_>) -> bool {
    let one = heard.detection;
    cells.blank_ms(Some(heard.time_us));
    // A number alone is that of several tags, one of each protocol.
    cells.text(&one.tag());
    cells.whole(Some(heard.time_us.div_euclid(1_000_000)));
    cells.decimals(&format!("0.{:03}", heard.time_us.rem_euclid(1_000_000) / 1_000));
    cells.whole(Some(one.receiver.into()));
    heard.is_by_receiver
}
