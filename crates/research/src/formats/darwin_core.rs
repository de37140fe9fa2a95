//! Occurrences for OBIS and GBIF, in terms of Darwin Core: that an animal was heard at a place and time.
//!
//! An occurrence has a species and a place: tags without an animal in the register, and detections without a place, are left out.

use super::cells::Cells;
use super::{Format, Rows};
use crate::study::Heard;

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

fn row(cells: &mut Cells<'_>, heard: &Heard<'_>) -> bool {
    let one = heard.detection;
    let (Some(animal), Some(pose)) = (heard.animal, one.pose) else { return false };
    if animal.scientific_name.is_empty() {
        return false;
    }
    let id = format!("{:04x}-{}", one.origin.system.0, one.id());
    cells.text("Event");
    cells.maybe(heard.project.map(|project| &*project.licence));
    cells.maybe(heard.principal_investigator.map(|person| &*person.affiliation));
    cells.nothings(2);
    cells.maybe(heard.project.map(|project| &*project.name));
    cells.maybe(heard.project.map(|project| &*project.title));
    cells.text("MachineObservation");
    cells.text(&heard.cell_m.map_or_else(String::new, generalization));
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
    true
}

fn generalization(cell_m: u32) -> String {
    format!("places are middles of cells of about {cell_m} m")
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
