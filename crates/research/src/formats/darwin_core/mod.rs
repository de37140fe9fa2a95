//! Occurrences for OBIS and GBIF, in terms of Darwin Core: that an animal was heard at a place and time.
//!
//! `darwin-core` is the table alone; the archives have its rows with measurements and descriptions. An occurrence has a species and a place: tags without an animal in the register, and detections without a place, are left out.

mod archive;
mod eml;
mod facts;
mod hours;
mod meta;

pub(super) use archive::{Archive, Keep};

use archive::{DESCRIPTION, FACTS, OCCURRENCES};

use super::cells::Cells;
use super::{Format, Rows};
use crate::study::Heard;
use tables::Dialect;

/// How far from the vessel the animal may have been, m: what networks of fixed receivers state for a raw detection.
const HEARD_WITHIN_M: f64 = 1_000.0;

pub(super) const FORMAT: Format = Format {
    name: "darwin-core",
    about: "OBIS and GBIF, table occurrence of a Darwin Core archive; animals with a place only",
    header: "type,license,rightsHolder,datasetID,institutionCode,collectionCode,datasetName,basisOfRecord,dataGeneralizations,\
             occurrenceID,sex,lifeStage,occurrenceStatus,organismID,organismName,eventID,parentEventID,eventDate,\
             samplingProtocol,eventRemarks,locationID,locality,decimalLatitude,decimalLongitude,geodeticDatum,\
             coordinateUncertaintyInMeters,identificationVerificationStatus,scientificNameID,scientificName,kingdom\n",
    absent: "",
    rows: Rows::Detections(row),
    has_lag: true,
};

/// The first of each hour in an archive, as OBIS and GBIF ask for.
pub(super) const HOURLY: Format = Format {
    name: "dwca",
    about: "OBIS and GBIF: a whole Darwin Core archive, of each animal, vessel and hour the first detection",
    header: "PK",
    absent: "",
    rows: Rows::Archive(Keep::FirstOfHour),
    has_lag: true,
};

/// Every detection in an archive.
pub(super) const EVERY: Format = Format {
    name: "dwca-all",
    about: "OBIS and GBIF: a whole Darwin Core archive, of every detection",
    rows: Rows::Archive(Keep::Every),
    ..HOURLY
};

fn row(cells: &mut Cells<'_>, heard: &Heard<'_>) -> bool {
    if !is_occurrence(heard) {
        return false;
    }
    before(cells, heard);
    cells.text(&generalization(None, heard.cell_m));
    after(cells, heard);
    true
}

/// Whether it has a species and a place.
fn is_occurrence(heard: &Heard<'_>) -> bool {
    heard.animal.is_some_and(|animal| !animal.scientific_name.is_empty()) && heard.detection.pose.is_some()
}

/// Names it among the detections of all vessels.
fn id(heard: &Heard<'_>) -> String {
    format!("{:04x}-{}", heard.detection.origin.system.0, heard.detection.id())
}

/// The cells before what is said of many that became one.
fn before(cells: &mut Cells<'_>, heard: &Heard<'_>) {
    cells.text("Event");
    cells.maybe(heard.project.map(|project| &*project.licence));
    cells.maybe(heard.principal_investigator.map(|person| &*person.affiliation));
    cells.nothings(2);
    cells.maybe(heard.project.map(|project| &*project.name));
    cells.maybe(heard.project.map(|project| &*project.title));
    cells.text("MachineObservation");
}

/// The cells after it.
fn after(cells: &mut Cells<'_>, heard: &Heard<'_>) {
    let (Some(animal), Some(pose)) = (heard.animal, heard.detection.pose) else { return };
    let id = id(heard);
    cells.text(&id);
    cells.text(sex(&animal.sex));
    cells.text(&animal.life_stage);
    cells.text("present");
    cells.text(&animal.name);
    cells.text(&animal.name);
    cells.text(&id);
    cells.nothing();
    cells.iso_ms(Some(heard.time_us));
    cells.text("acoustic telemetry");
    cells
        .text(&heard.doubt().map_or_else(String::new, |doubt| format!("perhaps a false detection: {doubt}")));
    cells.nothing();
    cells.maybe(heard.deployment.map(|deployment| &*deployment.name));
    cells.degrees(Some(pose.place.lat_deg()));
    cells.degrees(Some(pose.place.lon_deg()));
    cells.text("EPSG:4326");
    cells.number(Some(uncertainty_m(pose.sigma_m, heard.cell_m)));
    cells.nothing();
    cells.text(
        &animal.aphia_id.map_or_else(String::new, |id| format!("urn:lsid:marinespecies.org:taxname:{id}")),
    );
    cells.text(&animal.scientific_name);
    cells.text("Animalia");
}

/// What was done to the data: of how many detections of an hour this is the first, and how large the cells of places are.
fn generalization(of: Option<u64>, cell_m: Option<u32>) -> String {
    let of_hour = of.map(|of| format!("subsampled by hour: first of {of} record(s)"));
    let coarse = cell_m.map(|cell_m| format!("places are middles of cells of about {cell_m} m"));
    of_hour.into_iter().chain(coarse).collect::<Vec<_>>().join("; ")
}

/// Cells of a row that begins, or goes on, in an archive.
fn cells(out: &mut Vec<u8>, goes_on: bool) -> Cells<'_> {
    if goes_on { Cells::further(out, Dialect::Plain, "") } else { Cells::new(out, Dialect::Plain, "") }
}

/// How far the animal may have been from the place, whole m: within reach of the receiver, the vessel within twice the deviation of
/// its position, or anywhere in its cell.
fn uncertainty_m(sigma_m: Option<f64>, cell_m: Option<u32>) -> f64 {
    let half_diagonal_m = cell_m.map_or(0.0, |cell_m| f64::from(cell_m) / f64::sqrt(2.0));
    (HEARD_WITHIN_M + sigma_m.map_or(0.0, |sigma_m| 2.0 * sigma_m) + half_diagonal_m).ceil()
}

/// The term of Darwin Core for the register's letter.
fn sex(word: &str) -> &str {
    match word {
        "F" => "female",
        "M" => "male",
        other => other,
    }
}

#[cfg(test)]
mod tests;
