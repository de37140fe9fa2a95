//! `<vehicle>-saved.ini` beside the main file overrides all others.

use std::path::Path;

use config::schema::{path::ilos, watch};
use config::{Config, Disk, InMemory, Ini, ProblemKind, Saved, write_atomically};

const MAIN: &str = "[General]\nVehicle = otter\n[IMC Addresses]\notter = 0x2810\n\
                    [Control.Path.ILOS]\nEnabled = Always\nEntity Label = P\nILOS Integrator Gain = 0.5\n";

fn lookahead_and_gain(config: &Config) -> (f64, f64) {
    let section = config.running(&ilos::ILOS).next().expect("it is enabled");
    (section.get(&ilos::LOOKAHEAD), section.get(&ilos::INTEGRATOR_GAIN))
}

#[test]
fn saved_values_override_and_the_report_says_so() {
    let saved = "[Control.Path.ILOS]\nILOS Integrator Gain = 0.25\n";
    let files = InMemory::new().with("etc/main.ini", MAIN).with("etc/otter-saved.ini", saved);
    let config = Config::load(&files, Path::new("etc/main.ini"), &["Simulation"]);
    assert_eq!(lookahead_and_gain(&config), (10.0, 0.25));
    assert_eq!(config.report().problems().len(), 1, "{}", config.report());
    assert_eq!(config.report().problems()[0].kind, ProblemKind::Saved);
    let setting = config.ini().setting("Control.Path.ILOS", "ILOS Integrator Gain").unwrap();
    assert_eq!(setting.place().unwrap().to_string(), "etc/otter-saved.ini:2");
    assert_eq!(setting.history().len(), 2);
}

#[test]
fn a_value_saved_while_running_is_there_after_a_restart() {
    let folder = tempfile::tempdir().unwrap();
    let main = folder.path().join("main.ini");
    std::fs::write(&main, MAIN).unwrap();
    let config = Config::load(&Disk, &main, &["Simulation"]);
    assert_eq!(config.report().problems().len(), 0, "{}", config.report());
    let path = config.saved_path().unwrap();

    let mut saved = Saved::default();
    saved.set("Control.Path.ILOS", "ILOS Lookahead Distance", "8");
    write_atomically(&path, &saved.to_text().unwrap()).unwrap();
    let mut saved = Saved::from_ini(&Ini::read(&Disk, &path).0);
    saved.set("Control.Path.ILOS", "ILOS Integrator Gain", "0.1");
    write_atomically(&path, &saved.to_text().unwrap()).unwrap();

    assert_eq!(lookahead_and_gain(&Config::load(&Disk, &main, &["Simulation"])), (8.0, 0.1));
}

#[test]
fn what_is_saved_in_the_folder_of_data_counts_and_else_what_lies_beside_the_configuration() {
    let saved = |gain: &str| format!("[Control.Path.ILOS]\nILOS Integrator Gain = {gain}\n");
    let load = |files: &InMemory| {
        Config::load_aboard(files, Path::new("etc/main.ini"), &["Simulation"], Path::new("state"))
    };
    let gain = |files: &InMemory| lookahead_and_gain(&load(files)).1.to_string();
    let files = InMemory::new().with("etc/main.ini", MAIN);
    assert_eq!(load(&files).saved_path(), Some("state/otter-saved.ini".into()));
    let files = files.with("etc/otter-saved.ini", saved("0.25"));
    assert_eq!(gain(&files), "0.25", "what an earlier version saved");
    let config = load(&files);
    assert_eq!(config.saved_path(), Some("state/otter-saved.ini".into()), "it is saved there from now on");
    assert_eq!(config.saved_beside(), Some("etc/otter-saved.ini".into()));
    let files = files.with("state/otter-saved.ini", saved("0.75"));
    assert_eq!(gain(&files), "0.75");
}

#[test]
fn a_vessel_whose_name_is_a_path_saves_nothing() {
    for name in ["../otter", ".", "a/b"] {
        let text = MAIN.replace("otter\n", &format!("{name}\n"));
        let files = InMemory::new().with("main.ini", text);
        let config = Config::load(&files, Path::new("main.ini"), &["Simulation"]);
        assert_eq!(config.saved_path(), None);
        assert!(config.report().problems().iter().any(|problem| problem.kind == ProblemKind::Identity));
    }
}

#[test]
fn a_parameter_marked_as_not_editable_stays() {
    let text = MAIN.replace("ILOS Integrator Gain", "ILOS Integrator Gain {editable:false}");
    let files = InMemory::new().with("main.ini", text);
    let mut config = Config::load(&files, Path::new("main.ini"), &["Simulation"]);
    let section = config.section_mut("Control.Path.ILOS").unwrap();
    assert_eq!(section.change("ILOS Integrator Gain", "0.1").unwrap_err().kind, ProblemKind::Attribute);
    assert!(section.change("ILOS Lookahead Distance", "5").is_ok());
    assert_eq!(lookahead_and_gain(&config), (5.0, 0.5));
}

const LIMITS: &str = "[Supervisors.OperationalLimits]\nEnabled = Always\nEntity Label = L\nMaximum Speed = 2\n\
                      [Monitors.FuelLevel]\nEnabled = Always\nEntity Label = F\nReserve Level = 25\n";

#[test]
fn a_bad_saved_value_is_dropped_with_a_warning_and_the_configured_one_stays() {
    let saved = "[Supervisors.OperationalLimits]\nMaximum Speed = -1\n\
                 [Monitors.FuelLevel]\nWarning Level = 15\nReserve Level = 22\n\
                 [Nobody]\nx = 1\n[Control.Path.ILOS]\nILOS Integrator Gain = 0.25\n";
    let files = InMemory::new().with("main.ini", format!("{MAIN}{LIMITS}")).with("otter-saved.ini", saved);
    let config = Config::load(&files, Path::new("main.ini"), &["Simulation"]);
    assert!(!config.report().has_errors(), "{}", config.report());
    assert_eq!(lookahead_and_gain(&config), (10.0, 0.25), "what is good of it is used");
    let limits = config.running(&watch::limits::LIMITS).next().unwrap();
    assert!((limits.get(&watch::limits::MAXIMUM_SPEED) - 2.0).abs() < f64::EPSILON);
    let fuel = config.running(&watch::fuel::FUEL).next().unwrap();
    assert!((fuel.get(&watch::fuel::RESERVE_LEVEL) - 22.0).abs() < f64::EPSILON);
    assert!((fuel.get(&watch::fuel::WARNING_LEVEL) - 30.0).abs() < f64::EPSILON, "15 contradicts 22");
    let dropped: Vec<_> = config
        .report()
        .problems()
        .iter()
        .filter(|problem| problem.what.contains("DROPPED"))
        .map(|problem| problem.place.as_ref().unwrap().line)
        .collect();
    assert_eq!(dropped, [7, 4, 2], "{}", config.report());
}

#[test]
fn a_damaged_saved_file_stops_nothing() {
    for damage in ["text before a section\n", "[Unclosed\n", "[Require nowhere.ini]\n", "\u{0}\u{1}[\n=\n"] {
        let files = InMemory::new().with("main.ini", MAIN).with("otter-saved.ini", damage);
        let config = Config::load(&files, Path::new("main.ini"), &["Simulation"]);
        assert!(!config.report().has_errors(), "{damage:?}: {}", config.report());
        assert_eq!(lookahead_and_gain(&config), (10.0, 0.5));
    }
}
