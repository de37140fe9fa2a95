//! The Otters' own files load as they are, and the report of what Lutra does not know is pinned.

use std::path::PathBuf;

use config::schema::{control, device, general, mission, path, simulate, transport, watch};
use config::{Config, Disk, Problem, ProblemKind, Severity, Value};

fn load(vessel: &str, profile: &str) -> Option<Config> {
    let folder: PathBuf = testkit::shared("data/onboard/ini/user/etc")?;
    Some(Config::load(&Disk, &folder.join(format!("{vessel}.ini")), &[profile]))
}

#[test]
fn every_vessel_loads_in_both_profiles_with_a_known_report() {
    // The first vessel has the servers that the others connect to, which is one more warning for each of them.
    for (vessel, address, clients) in
        [("ntnu-otter-01", 0x2810, 0), ("ntnu-otter-02", 0x2811, 1), ("ntnu-otter-03", 0x2812, 1)]
    {
        for (profile, errors, warnings, notes) in [("Simulation", 0, 10, 73), ("Hardware", 0, 7, 62)] {
            let Some(config) = load(vessel, profile) else { return };
            let counts = config.report().counts();
            let found = (counts.errors, counts.warnings, counts.notes);
            assert_eq!(found, (errors, warnings + clients, notes), "{vessel} {profile}\n{}", config.report());
            assert_eq!((config.vehicle(), config.address()), (vessel, Some(address)));
        }
    }
}

#[test]
fn the_warnings_are_real_slips_in_the_files() {
    let Some(config) = load("ntnu-otter-01", "Simulation") else { return };
    let warnings = config.report().problems().iter().filter(|problem| problem.severity == Severity::Warning);
    let warnings = warnings.filter(|problem| problem.kind != ProblemKind::NotHonoured);
    let found: Vec<(ProblemKind, u32)> =
        warnings.map(|problem: &Problem| (problem.kind, problem.place.as_ref().unwrap().line)).collect();
    let expected = [
        (ProblemKind::Repeated, 186), // `ETA Minimum Speed` twice in VectorField
        (ProblemKind::ValueCut, 238), // `Spew#None`
        (ProblemKind::Label, 104),    // motors that no simulator is called like
        (ProblemKind::Label, 105),
    ];
    assert_eq!(found, expected);
}

#[test]
fn values_are_those_of_the_files() {
    let Some(config) = load("ntnu-otter-02", "Simulation") else { return };
    let controller = config.running(&control::course_speed::COURSE_SPEED).next().unwrap();
    assert_eq!(controller.get(&control::course_speed::SPEED_GAINS), [450.0, 25.0, 0.0]);
    assert!(!controller.get(&control::SHARE_SATURATION));
    let ilos = config.running(&path::ilos::ILOS).next().unwrap();
    assert_eq!(ilos.task(), "Control.Path.ILOSOtter");
    assert!((ilos.get(&path::ilos::INTEGRATOR_GAIN) - 0.5).abs() < f64::EPSILON);
    assert!((ilos.get(&path::MAXIMUM_TRACK_LENGTH) - 25_000.0).abs() < f64::EPSILON, "a default");
    let udp = config.running(&transport::udp::UDP).next().unwrap();
    assert_eq!(udp.get(&transport::udp::PORT), 6004, "the vessel's own file overrides");
    assert_eq!(udp.get(&transport::udp::MESSAGES).len(), 60);
    assert_eq!(udp.get(&transport::FILTERS), [("CpuUsage".to_owned(), "Daemon".to_owned())]);
    assert_eq!(udp.get(&transport::RATES).len(), 13);
    let gps = config.running(&simulate::gps::GPS).next().unwrap();
    assert_eq!(gps.get(&simulate::gps::INITIAL_POSITION), [61.908_558_2, 5.320_201_8]);
    let monitor = config.running(&watch::entities::ENTITIES).next().unwrap();
    assert_eq!(monitor.get(&watch::entities::MONITORED), ["Daemon", "GPS", "Navigation", "Path Control"]);
    assert!((config.general().get(&general::TIME_OF_ARRIVAL_FACTOR) - 6.0).abs() < f64::EPSILON);
}

#[test]
fn profiles_pick_the_instances() {
    let (Some(simulation), Some(hardware)) =
        (load("ntnu-otter-03", "Simulation"), load("ntnu-otter-03", "Hardware"))
    else {
        return;
    };
    let instances = |config: &Config, spec| -> Vec<String> {
        config.running(spec).map(|section| section.name().to_owned()).collect()
    };
    let motors = ["Simulators.Motor/Port", "Simulators.Motor/Starboard"];
    assert_eq!(instances(&simulation, &simulate::motor::MOTOR), motors);
    assert!(instances(&hardware, &simulate::motor::MOTOR).is_empty());
    assert_eq!(instances(&simulation, &transport::tcp::CLIENT), ["Transports.TCP.Client/sw"]);
    assert_eq!(instances(&hardware, &transport::tcp::CLIENT), ["Transports.TCP.Client/hw"]);
    let follow = &mission::maneuver::FOLLOW_REFERENCE;
    assert_eq!(instances(&simulation, follow), ["Maneuver.FollowReference.ASV/sim"]);
    assert_eq!(instances(&hardware, &device::compass::COMPASS), ["Sensors.GPSDraw"]);
    let server = simulation.by_label("Entity Monitor").unwrap();
    assert_eq!((server.name(), server.instance()), ("Monitors.Entities", None));
}

#[test]
fn repeated_parameters_are_found_by_their_part() {
    let Some(config) = load("ntnu-otter-01", "Hardware") else { return };
    let hydrophone = config.running(&device::hydrophone::HYDROPHONE).next().unwrap();
    let replies = hydrophone.each(&device::INIT_REPLY);
    assert_eq!(replies[3], ("3", b"FV=v1.0.6\r".to_vec()));
    let card = config.running(&device::torqeedo::TORQEEDO).next().unwrap();
    assert_eq!(card.each(&device::torqeedo::MOTOR_LABEL).len(), 2);
    assert_eq!(card.each(&device::torqeedo::CHANNEL_STATE).len(), 8);
}

#[test]
fn the_effective_configuration_names_the_line_of_every_value() {
    let Some(config) = load("ntnu-otter-02", "Simulation") else { return };
    let shown = config.to_string();
    let line = |start: &str| shown.lines().find(|line| line.trim_start().starts_with(start)).unwrap();
    let port = line("Local Port = 6004");
    assert!(port.contains("ntnu-otter-02.ini:42, overrides "), "{port}");
    assert!(port.contains("basic.ini:"), "{port}");
    assert!(line("Maximum Track Length = 25000 m").ends_with("# default"));
    assert!(line("Corridor -- Entry Angle = 15 deg").contains("basic.ini:"));
    assert!(line("[Transports.FTP]").contains("not used"));
    assert!(shown.ends_with("0 errors, 11 warnings, 73 notes\n"));
}

#[test]
fn the_json_form_says_the_same() {
    let Some(config) = load("ntnu-otter-02", "Simulation") else { return };
    let json = config.to_json();
    assert_eq!(json["vehicle"], "ntnu-otter-02");
    assert_eq!(json["address"], 0x2811);
    let sections = json["sections"].as_array().unwrap();
    let udp = sections.iter().find(|section| section["name"] == "Transports.UDP").unwrap();
    assert_eq!(udp["enabled"]["osim"], true);
    let port = udp["parameters"].as_array().unwrap().iter().find(|p| p["key"] == "Local Port").unwrap();
    assert_eq!((&port["value"], &port["text"]), (&6004.into(), &"6004".into()));
    assert_eq!(port["source"]["line"], 42);
    assert_eq!(port["history"].as_array().unwrap().len(), 3);
    let watched = sections.iter().find(|section| section["name"] == "Monitors.Entities").unwrap();
    let list = watched["parameters"].as_array().unwrap().iter().find(|p| p["key"] == "Default Monitoring");
    assert_eq!(list.unwrap()["list"].as_array().unwrap().len(), 4);
    assert_eq!(json["report"]["warnings"], 11);
}

#[test]
fn a_changed_value_is_checked_and_an_impossible_one_refused() {
    let Some(mut config) = load("ntnu-otter-01", "Simulation") else { return };
    let section = config.section_mut("Control.Path.ILOSOtter").unwrap();
    assert_eq!(section.change("ILOS Lookahead Distance", "12"), Ok(Value::Float(12.0)));
    let refused = section.change("ILOS Lookahead Distance", "120").unwrap_err();
    assert_eq!(refused.kind, ProblemKind::OutOfRange);
    assert!((section.get(&path::ilos::LOOKAHEAD) - 12.0).abs() < f64::EPSILON);
    for key in ["Lookahead", "Entity Label", "Bottom Track -- Enabled"] {
        assert_eq!(section.change(key, "1").unwrap_err().kind, ProblemKind::UnknownKey, "{key}");
    }
}
