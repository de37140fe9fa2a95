//! The schema as a file: complete, documented, and equal to the defaults when read back.

use std::path::Path;

use config::schema::{self, general};
use config::{Config, Counts, Form, InMemory, Kind, Section, Vessel, documented_ini};

fn own() -> (String, Config, Config) {
    let text = documented_ini(&Vessel::default()).expect("the name can be written");
    let files = InMemory::new().with("otter.ini", text.clone());
    let load = |profile| Config::load(&files, Path::new("otter.ini"), &[profile]);
    (text.clone(), load("Simulation"), load("Hardware"))
}

#[test]
fn the_documented_configuration_is_free_of_problems() {
    let (_, simulation, hardware) = own();
    assert_eq!(simulation.report().counts(), Counts::default(), "{}", simulation.report());
    assert_eq!(hardware.report().counts(), Counts::default(), "{}", hardware.report());
    assert_eq!((simulation.vehicle(), simulation.address()), ("ntnu-otter-01", Some(0x2810)));
}

#[test]
fn the_documented_configuration_reads_back_to_the_defaults_and_the_otters_values() {
    let (_, config, _) = own();
    for spec in schema::SECTIONS {
        if matches!(spec.form, Form::OpenData(_)) || is_absent(spec) {
            continue;
        }
        let section = config.sections().iter().find(|section| section.spec() == Some(spec)).unwrap();
        let defaults = Section::defaults(spec);
        for parameter in defaults.parameters() {
            let obeyed = schema::not_honoured(spec.name(), parameter.key()).is_none();
            if !obeyed || ["Vehicle", "Enabled", "Entity Label"].contains(&parameter.key()) {
                continue;
            }
            let read = section.parameter(parameter.key()).unwrap();
            let wanted = match schema::otter_value(spec.name(), parameter.key()) {
                Some(otter) => otter.to_owned(),
                None => parameter.value().to_string(),
            };
            assert_eq!(read.value().to_string(), wanted, "[{}] {}", spec.name(), parameter.key());
            assert!(read.place().is_some(), "[{}] {}", spec.name(), parameter.key());
        }
    }
}

/// Whether Lutra does not have this task at all.
fn is_absent(spec: &config::SectionSpec) -> bool {
    schema::not_honoured(spec.name(), "Enabled").is_some()
}

#[test]
fn every_line_is_short_and_every_parameter_documented() {
    let (text, ..) = own();
    assert!(text.lines().all(|line| line.len() <= 120));
    let all = schema::SECTIONS
        .iter()
        .filter(|spec| !is_absent(spec))
        .flat_map(|spec| spec.params().map(move |param| (spec, param)));
    for (_, param) in all.filter(|(spec, param)| schema::not_honoured(spec.name(), param.name).is_none()) {
        let first = param.doc.split(' ').take(3).collect::<Vec<_>>().join(" ");
        assert!(param.kind == Kind::Unused || text.contains(&first), "{}", param.name);
    }
}

#[test]
fn another_vessel_gets_its_name_and_address() {
    let text = documented_ini(&Vessel { name: "otter-7".to_owned(), address: 0x2817 }).unwrap();
    let config = Config::load(&InMemory::new().with("o.ini", text), Path::new("o.ini"), &["Simulation"]);
    assert_eq!(config.general().get(&general::VEHICLE), "otter-7");
    assert_eq!(config.address(), Some(0x2817));
    assert!(documented_ini(&Vessel { name: "a#b".to_owned(), address: 1 }).is_err());
}
