//! Files of the R package actel: its standard detections, and its biometrics.
//!
//! The receiver is its serial number alone, as actel asks. `NA` is what is not known.

use super::cells::Cells;
use super::vue::sensor;
use super::{Format, Rows};
use crate::study::{Heard, codespace};
use api::{RegisterAnimal, RegisterTag};

pub(super) const DETECTIONS: Format = Format {
    name: "actel",
    about: "actel, its standard detections",
    header: "Timestamp,Receiver,CodeSpace,Signal,Sensor.Value,Sensor.Unit\n",
    absent: "NA",
    rows: Rows::Detections(detection),
    has_lag: false,
};

pub(super) const BIOMETRICS: Format = Format {
    name: "actel-biometrics",
    about: "actel, its biometrics: tagged animals of the register, whatever was heard",
    header: "Release.date,Release.site,Serial.nr,Signal,Group,Total.Length.mm,Mass.g\n",
    absent: "NA",
    rows: Rows::Animals(animal),
    has_lag: false,
};

fn detection(cells: &mut Cells<'_>, heard: &Heard<'_>) -> bool {
    let one = heard.detection;
    cells.blank_ms(Some(heard.time_us));
    cells.whole(Some(one.receiver.into()));
    cells.text(&codespace(heard.tag, &one.protocol.to_string(), one.frequency_khz));
    cells.whole(Some(one.tag_id.into()));
    sensor(cells, heard);
    true
}

fn animal(cells: &mut Cells<'_>, tag: &RegisterTag, animal: &RegisterAnimal) {
    cells.blank_s(animal.release_us);
    cells.text(&animal.release_place);
    cells.text(&tag.serial);
    cells.whole(tag.tag_id);
    cells.text(&animal.release_group);
    cells.number(animal.length_mm);
    cells.number(animal.weight_g);
}
