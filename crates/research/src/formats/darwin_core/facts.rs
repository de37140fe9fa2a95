//! Measurements of occurrences: OBIS' extension of measurements and facts.
//!
//! Each occurrence has its signal to noise ratio where that is known, and the value of the tag's sensor where the register says
//! what it means. Length and weight of an animal stand once, with its first occurrence. Identifiers are those of the NERC
//! vocabulary server; a quantity that the register names in own words has none.

use super::{cells, id};
use crate::study::Heard;
use api::RegisterAnimal;

/// The columns.
pub(super) const HEADER: &str = "occurrenceID,measurementType,measurementTypeID,measurementValue,measurementValueID,measurementUnit,measurementUnitID\n";

const LENGTH: &str = "http://vocab.nerc.ac.uk/collection/P01/current/OBSINDLX/";
const WEIGHT: &str = "http://vocab.nerc.ac.uk/collection/P01/current/SPWGXX01/";
const MILLIMETRES: &str = "http://vocab.nerc.ac.uk/collection/P06/current/UXMM/";
const GRAMS: &str = "http://vocab.nerc.ac.uk/collection/P06/current/UGRM/";

/// A measurement.
struct Fact<'f> {
    about: &'f str,
    about_id: &'f str,
    value: f64,
    unit: &'f str,
    unit_id: &'f str,
}

/// Appends the lines of an occurrence; those of its animal too where `of_animal`.
pub(super) fn write(out: &mut Vec<u8>, heard: &Heard<'_>, of_animal: bool) {
    let id = id(heard);
    if let Some(snr_db) = heard.detection.snr_db {
        let (about, value) = ("signal to noise ratio", f64::from(snr_db));
        line(out, &id, &Fact { about, about_id: "", value, unit: "dB", unit_id: "" });
    }
    if let Some(sensor) = heard.sensor().filter(|sensor| sensor.value.is_finite()) {
        let about = if sensor.kind.is_empty() { "sensor of the tag" } else { sensor.kind };
        line(out, &id, &Fact { about, about_id: "", value: sensor.value, unit: sensor.unit, unit_id: "" });
    }
    if let Some(animal) = heard.animal.filter(|_| of_animal) {
        animal_lines(out, &id, animal);
    }
}

fn animal_lines(out: &mut Vec<u8>, id: &str, animal: &RegisterAnimal) {
    if let Some(value) = animal.length_mm {
        let kind = animal.length_type.trim();
        let about = if kind.is_empty() { "length".to_owned() } else { format!("length ({kind})") };
        let (about, about_id) = (&*about, LENGTH);
        line(out, id, &Fact { about, about_id, value, unit: "mm", unit_id: MILLIMETRES });
    }
    if let Some(value) = animal.weight_g {
        line(out, id, &Fact { about: "weight", about_id: WEIGHT, value, unit: "g", unit_id: GRAMS });
    }
}

fn line(out: &mut Vec<u8>, id: &str, fact: &Fact<'_>) {
    let mut cells = cells(out, false);
    cells.text(id);
    cells.text(fact.about);
    cells.text(fact.about_id);
    cells.number(Some(fact.value));
    cells.nothing();
    cells.text(fact.unit);
    cells.text(fact.unit_id);
    out.push(b'\n');
}
