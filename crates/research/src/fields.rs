//! The fields of each kind of entry, in the order in which files have them.

use crate::column::{Column, Rule, Slot};
use api::{
    RegisterAnimal, RegisterDeployment, RegisterKind, RegisterPerson, RegisterProject, RegisterReceiver,
    RegisterRecord, RegisterTag, Wording, say,
};
use detections::Maker;

/// All kinds; those that others refer to come first.
pub const KINDS: [RegisterKind; 6] = [
    RegisterKind::Person,
    RegisterKind::Project,
    RegisterKind::Animal,
    RegisterKind::Tag,
    RegisterKind::Receiver,
    RegisterKind::Deployment,
];

/// The maker of a receiver of the register, by its manufacturer, else by its model.
pub(crate) fn maker_of(receiver: &RegisterReceiver) -> Option<Maker> {
    Maker::of(&receiver.manufacturer).or_else(|| Maker::of(&receiver.model))
}

/// The word for a kind in addresses and texts.
pub const fn kind_word(kind: RegisterKind) -> &'static str {
    match kind {
        RegisterKind::Project => "project",
        RegisterKind::Person => "person",
        RegisterKind::Animal => "animal",
        RegisterKind::Tag => "tag",
        RegisterKind::Receiver => "receiver",
        RegisterKind::Deployment => "deployment",
    }
}

/// The same, in words of any language.
pub fn kind_said(kind: RegisterKind) -> Wording {
    say(kind_word(kind))
}

/// The kind of an entry.
pub const fn kind_of(record: &RegisterRecord) -> RegisterKind {
    match record {
        RegisterRecord::Project(_) => RegisterKind::Project,
        RegisterRecord::Person(_) => RegisterKind::Person,
        RegisterRecord::Animal(_) => RegisterKind::Animal,
        RegisterRecord::Tag(_) => RegisterKind::Tag,
        RegisterRecord::Receiver(_) => RegisterKind::Receiver,
        RegisterRecord::Deployment(_) => RegisterKind::Deployment,
    }
}

/// An entry that says nothing.
pub fn blank(kind: RegisterKind) -> RegisterRecord {
    match kind {
        RegisterKind::Project => RegisterRecord::Project(RegisterProject::default()),
        RegisterKind::Person => RegisterRecord::Person(RegisterPerson::default()),
        RegisterKind::Animal => RegisterRecord::Animal(RegisterAnimal::default()),
        RegisterKind::Tag => RegisterRecord::Tag(RegisterTag::default()),
        RegisterKind::Receiver => RegisterRecord::Receiver(RegisterReceiver::default()),
        RegisterKind::Deployment => RegisterRecord::Deployment(RegisterDeployment::default()),
    }
}

/// The name of an entry.
pub fn name_of(record: &RegisterRecord) -> &str {
    match record {
        RegisterRecord::Project(one) => &one.name,
        RegisterRecord::Person(one) => &one.name,
        RegisterRecord::Animal(one) => &one.name,
        RegisterRecord::Tag(one) => &one.name,
        RegisterRecord::Receiver(one) => &one.name,
        RegisterRecord::Deployment(one) => &one.name,
    }
}

const NAME: Column =
    needed("name", "name, by which others refer to it; unique among its kind", Rule::Line(80));
const PROJECT_OF: Column = may("project", "name of its project", Rule::Name(RegisterKind::Project));
const NOTES: Column = may("notes", "what else is to be known", Rule::Text(2_000));
const LAT: Rule = Rule::Real(-90.0, 90.0);
const LON: Rule = Rule::Real(-180.0, 180.0);

const fn needed(name: &'static str, about: &'static str, rule: Rule) -> Column {
    Column { name, about, rule, needed: true }
}

const fn may(name: &'static str, about: &'static str, rule: Rule) -> Column {
    Column { name, about, rule, needed: false }
}

const PROJECT: [Column; 7] = [
    NAME,
    may("title", "title", Rule::Line(200)),
    may("principal_investigator", "name of the person who leads it", Rule::Name(RegisterKind::Person)),
    may("contact", "name of the person who answers questions", Rule::Name(RegisterKind::Person)),
    may("citation", "how to cite it", Rule::Line(1_000)),
    may("licence", "licence of its data by SPDX, such as CC-BY-4.0", Rule::Line(80)),
    NOTES,
];

const PERSON: [Column; 4] = [
    NAME,
    may("affiliation", "where they work", Rule::Line(200)),
    may("orcid", "ORCID, such as 0000-0002-1825-0097", Rule::Orcid),
    NOTES,
];

const ANIMAL: [Column; 20] = [
    NAME,
    PROJECT_OF,
    may("scientific_name", "scientific name of the species", Rule::Line(120)),
    may("aphia_id", "the species' number in WoRMS (AphiaID)", Rule::Whole(1, 9_999_999)),
    may("common_name", "common name of the species", Rule::Line(120)),
    may("length_mm", "length, mm", Rule::Real(1.0, 40_000.0)),
    may("length_type", "which length: total, fork, standard …", Rule::Line(40)),
    may("weight_g", "weight, g", Rule::Real(0.01, 2e8)),
    may("sex", "F, M or U for unknown", Rule::OneOf(&["F", "M", "U"])),
    may("life_stage", "stage of life, such as smolt", Rule::Line(40)),
    may("capture_time", "when it was caught, ISO 8601", Rule::Time),
    may("capture_place", "where it was caught, in words", Rule::Line(120)),
    may("capture_lat_deg", "WGS 84 latitude of the catch, degrees", LAT),
    may("capture_lon_deg", "WGS 84 longitude of the catch, degrees", LON),
    may("release_time", "when it was released, ISO 8601", Rule::Time),
    may("release_place", "where it was released, in words", Rule::Line(120)),
    may("release_lat_deg", "WGS 84 latitude of the release, degrees", LAT),
    may("release_lon_deg", "WGS 84 longitude of the release, degrees", LON),
    may("release_group", "the group with which it was released", Rule::Line(80)),
    NOTES,
];

const TAG: [Column; 19] = [
    may("name", "what people call it; protocol and number when empty", Rule::Line(80)),
    PROJECT_OF,
    needed("protocol", "protocol as receivers name it, such as R64K or OPs", Rule::Line(40)),
    needed("tag_id", "its number", Rule::Whole(0, u32::MAX as i64)),
    may("frequency_khz", "carrier, kHz; any when empty", Rule::Whole(30, 500)),
    may("codespace", "frequency and code space as portals write them, such as A69-1303", Rule::Line(40)),
    may("serial", "serial number of the maker", Rule::Line(40)),
    may("manufacturer", "who made it", Rule::Line(80)),
    may("model", "its model", Rule::Line(80)),
    may("sensor_type", "what it measures, such as depth", Rule::Line(40)),
    may("sensor_slope", "value = slope · count + intercept", Rule::Real(-1e6, 1e6)),
    may("sensor_intercept", "see sensor_slope", Rule::Real(-1e6, 1e6)),
    may("sensor_unit", "unit of the value, such as m", Rule::Line(20)),
    may("interval_min_s", "least time from ping to ping, s", Rule::Real(0.001, 1e6)),
    may("interval_max_s", "greatest time from ping to ping, s", Rule::Real(0.001, 1e6)),
    may(
        "animal",
        "name of the animal that carries it; empty for a reference tag",
        Rule::Name(RegisterKind::Animal),
    ),
    may(
        "from_time",
        "from when on, ISO 8601; when empty, from the animal's release or capture on",
        Rule::Time,
    ),
    may("to_time", "until when, ISO 8601; to the end when empty", Rule::Time),
    NOTES,
];

const RECEIVER: [Column; 5] = [
    may("name", "what people call it; model and serial number when empty", Rule::Line(80)),
    needed("serial", "serial number, as it stands in its lines", Rule::Whole(0, u32::MAX as i64)),
    may("model", "model as portals write it, such as TBR700", Rule::Line(40)),
    may("manufacturer", "who made it", Rule::Line(80)),
    NOTES,
];

const DEPLOYMENT: [Column; 10] = [
    may("name", "what people call it; receiver and begin when empty", Rule::Line(80)),
    needed("receiver", "name of the receiver", Rule::Name(RegisterKind::Receiver)),
    needed("vessel", "name or IMC address of the vessel, or of the fixed station", Rule::Vessel),
    PROJECT_OF,
    needed("from_time", "from when on, ISO 8601", Rule::Time),
    may("to_time", "until when, ISO 8601; empty while it goes on", Rule::Time),
    may("depth_m", "depth of the hydrophone below the surface, m", Rule::Real(0.0, 2_000.0)),
    may("lat_deg", "WGS 84 latitude of a fixed station, degrees; empty on a vessel that moves", LAT),
    may("lon_deg", "WGS 84 longitude of a fixed station, degrees", LON),
    NOTES,
];

/// The fields of a kind.
pub const fn columns(kind: RegisterKind) -> &'static [Column] {
    match kind {
        RegisterKind::Project => &PROJECT,
        RegisterKind::Person => &PERSON,
        RegisterKind::Animal => &ANIMAL,
        RegisterKind::Tag => &TAG,
        RegisterKind::Receiver => &RECEIVER,
        RegisterKind::Deployment => &DEPLOYMENT,
    }
}

/// The places of an entry's values, in the order of [`columns`].
pub fn slots(record: &mut RegisterRecord) -> Vec<Slot<'_>> {
    match record {
        RegisterRecord::Project(one) => project(one),
        RegisterRecord::Person(one) => person(one),
        RegisterRecord::Animal(one) => animal(one),
        RegisterRecord::Tag(one) => tag(one),
        RegisterRecord::Receiver(one) => receiver(one),
        RegisterRecord::Deployment(one) => deployment(one),
    }
}

fn project(one: &mut RegisterProject) -> Vec<Slot<'_>> {
    let RegisterProject { name, title, principal_investigator, contact, citation, licence, notes } = one;
    [name, title, principal_investigator, contact, citation, licence, notes].map(Slot::Text).into()
}

fn person(one: &mut RegisterPerson) -> Vec<Slot<'_>> {
    let RegisterPerson { name, affiliation, orcid, notes } = one;
    [name, affiliation, orcid, notes].map(Slot::Text).into()
}

fn animal(one: &mut RegisterAnimal) -> Vec<Slot<'_>> {
    vec![
        Slot::Text(&mut one.name),
        Slot::Text(&mut one.project),
        Slot::Text(&mut one.scientific_name),
        Slot::Whole(&mut one.aphia_id),
        Slot::Text(&mut one.common_name),
        Slot::Real(&mut one.length_mm),
        Slot::Text(&mut one.length_type),
        Slot::Real(&mut one.weight_g),
        Slot::Text(&mut one.sex),
        Slot::Text(&mut one.life_stage),
        Slot::Time(&mut one.capture_us),
        Slot::Text(&mut one.capture_place),
        Slot::Real(&mut one.capture_lat_deg),
        Slot::Real(&mut one.capture_lon_deg),
        Slot::Time(&mut one.release_us),
        Slot::Text(&mut one.release_place),
        Slot::Real(&mut one.release_lat_deg),
        Slot::Real(&mut one.release_lon_deg),
        Slot::Text(&mut one.release_group),
        Slot::Text(&mut one.notes),
    ]
}

fn tag(one: &mut RegisterTag) -> Vec<Slot<'_>> {
    vec![
        Slot::Text(&mut one.name),
        Slot::Text(&mut one.project),
        Slot::Text(&mut one.protocol),
        Slot::Whole(&mut one.tag_id),
        Slot::Whole(&mut one.frequency_khz),
        Slot::Text(&mut one.codespace),
        Slot::Text(&mut one.serial),
        Slot::Text(&mut one.manufacturer),
        Slot::Text(&mut one.model),
        Slot::Text(&mut one.sensor_type),
        Slot::Real(&mut one.sensor_slope),
        Slot::Real(&mut one.sensor_intercept),
        Slot::Text(&mut one.sensor_unit),
        Slot::Real(&mut one.interval_min_s),
        Slot::Real(&mut one.interval_max_s),
        Slot::Text(&mut one.animal),
        Slot::Time(&mut one.from_us),
        Slot::Time(&mut one.to_us),
        Slot::Text(&mut one.notes),
    ]
}

fn receiver(one: &mut RegisterReceiver) -> Vec<Slot<'_>> {
    vec![
        Slot::Text(&mut one.name),
        Slot::Whole(&mut one.serial),
        Slot::Text(&mut one.model),
        Slot::Text(&mut one.manufacturer),
        Slot::Text(&mut one.notes),
    ]
}

fn deployment(one: &mut RegisterDeployment) -> Vec<Slot<'_>> {
    vec![
        Slot::Text(&mut one.name),
        Slot::Text(&mut one.receiver),
        Slot::Vessel(&mut one.vessel),
        Slot::Text(&mut one.project),
        Slot::Time(&mut one.from_us),
        Slot::Time(&mut one.to_us),
        Slot::Real(&mut one.depth_m),
        Slot::Real(&mut one.lat_deg),
        Slot::Real(&mut one.lon_deg),
        Slot::Text(&mut one.notes),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_field_of_the_api_is_a_column_with_its_slot() {
        for kind in KINDS {
            let mut record = blank(kind);
            let json = serde_json::to_value(&record).unwrap();
            // `kind` itself is not a field; times are called `_us` in the API, and `_time` in files.
            let fields: Vec<String> =
                json.as_object().unwrap().keys().filter(|key| *key != "kind").cloned().collect();
            let mut of_files: Vec<String> =
                columns(kind).iter().map(|column| column.name.replace("_time", "_us")).collect();
            assert_eq!(slots(&mut record).len(), of_files.len(), "{kind:?}");
            of_files.sort();
            let mut fields = fields;
            fields.sort();
            assert_eq!(fields, of_files, "{kind:?}");
        }
    }

    #[test]
    fn each_slot_is_that_of_its_column() {
        for kind in KINDS {
            for (at, column) in columns(kind).iter().enumerate() {
                let mut record = blank(kind);
                match &mut slots(&mut record)[at] {
                    Slot::Text(text) => "x".clone_into(text),
                    Slot::Real(value) => **value = Some(1.0),
                    Slot::Whole(value) | Slot::Time(value) => **value = Some(1),
                    Slot::Vessel(value) => **value = Some(1),
                }
                let json = serde_json::to_value(&record).unwrap();
                let field = &json[column.name.replace("_time", "_us")];
                assert!(*field == "x" || *field == 1 || *field == 1.0, "{kind:?} {}: {field}", column.name);
            }
        }
    }
}
