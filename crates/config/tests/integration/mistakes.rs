//! A configuration with many different mistakes: each is reported at its own line, and nothing else is.

use std::path::Path;

use config::schema::path::ilos;
use config::{Config, InMemory, Problem, ProblemKind, Severity};

/// Each line that ends in a mark `# !kind` holds that mistake.
const MAIN: &str = "\
stray = 1                                             # !syntax
[require common.ini]                                  # !misspelt-keyword
[Require missing.ini]                                 # !file-missing
[Require base.ini]
Late = 2                                              # !stray-section
[General]
Vehicle = ntnu-otter-1                                # !identity
Battery Packs = 04                                    # !octal
Time Of Arrival Factor = soon                         # !wrong-type
Speed Conversion -- MPS = 0, 1                        # !contradiction
Absolute Maximum Depth = $(General, Depth)            # !reference
[Control.Path.ILOS]
Enabled = Always
Entity Label = Path Control
ILOS Lookahead Distance = 70                          # !out-of-range
ILOS Lookahead Distnce = 7                            # !unknown-key
Course Control = yes                                  # !wrong-type
Corridor -- Width = 3 m                               # !wrong-type
Control Frequency {scope:global, colour:red} = 10     # !attribute
Debug Level = Spew#None
[Control.ASV.HeadingAndSpeed]
Enabled = Simulaton                                   # !profile
Entity Label = Course
Yaw PID Gains = 1, 2                                  # !wrong-length
[Control.Path.VectorField]
Enabled = Simulation
Entity Label = Path Control                           # !label
[Transports.UPD]                                      # !unknown-section
[Monitors.Entities]
Enabled = Always
Entity Label = Entity Monitor
Default Monitoring = Path Control,
                     Daemon,
GPS # once = more                                     # !comment-in-name
Default Monitoring- = Navigation                      # !list-edit
[Monitors.Clock                                       # !syntax
Enabled = Never
";

const BASE: &str = "[IMC Addresses]\nntnu-otter-01 = 0x2810\n[Include base.ini]";

/// The marks of [`MAIN`], taken off the text.
fn marks() -> (String, Vec<(u32, String)>) {
    let mut text = String::new();
    let mut marks = Vec::new();
    for (number, line) in (1..).zip(MAIN.lines()) {
        let (line, mark) = line.split_once("# !").map_or((line, None), |(line, mark)| (line, Some(mark)));
        marks.extend(mark.map(|mark| (number, mark.to_owned())));
        text.push_str(line.trim_end());
        text.push('\n');
    }
    (text, marks)
}

#[test]
fn more_than_twenty_mistakes_are_all_reported_with_file_and_line() {
    let (text, mut expected) = marks();
    assert!(expected.len() > 20);
    // The cut value cannot carry a mark, since the mark would be cut off with it.
    expected.push((20, ProblemKind::ValueCut.as_str().to_owned()));
    let files = InMemory::new().with("v/main.ini", text).with("v/base.ini", BASE);
    let config = Config::load(&files, Path::new("v/main.ini"), &["Simulation"]);

    let mut found = Vec::new();
    let real = |problem: &&Problem| problem.kind != ProblemKind::NotHonoured;
    for problem in config.report().problems().iter().filter(real) {
        let place = problem.place.as_ref().expect("every mistake has a place");
        if &*place.file == "v/base.ini" {
            assert_eq!((problem.kind, place.line), (ProblemKind::IncludeCycle, 3));
            continue;
        }
        assert_eq!(&*place.file, "v/main.ini");
        assert!(!problem.what.is_empty() && !problem.remedy.is_empty(), "{problem}");
        found.push((place.line, problem.kind.as_str().to_owned()));
    }
    found.sort();
    expected.sort();
    assert_eq!(found, expected, "{}", config.report());
}

#[test]
fn suggestions_and_ranges_tell_the_remedy() {
    let (text, _) = marks();
    let files = InMemory::new().with("v/main.ini", text).with("v/base.ini", BASE);
    let config = Config::load(&files, Path::new("v/main.ini"), &["Simulation"]);
    let report = config.report().to_string();
    for remedy in [
        "`ILOS Lookahead Distance`?",
        "allowed is 1 to 50 m",
        "[Transports.UDP]?",
        "`ntnu-otter-01`?",
        "`Simulation`?",
        "give exactly 3 items",
        "write [Require path] or [Include path]",
    ] {
        assert!(report.contains(remedy), "{remedy}\n{report}");
    }
}

#[test]
fn a_refused_value_leaves_the_default_in_force_and_shows_so() {
    let (text, _) = marks();
    let files = InMemory::new().with("main.ini", text).with("base.ini", BASE);
    let config = Config::load(&files, Path::new("main.ini"), &["Simulation"]);
    let controller = config.running(&ilos::ILOS).next().unwrap();
    assert!((controller.get(&ilos::LOOKAHEAD) - 10.0).abs() < f64::EPSILON);
    assert!(controller.parameter("ILOS Lookahead Distance").unwrap().is_rejected());
    let shown = config.to_string();
    assert!(shown.contains("default, because the value of main.ini:15 is refused"), "{shown}");
}

#[test]
fn mistakes_in_what_does_not_run_are_only_warnings() {
    let text = "[General]\nVehicle = v\n[IMC Addresses]\nv = 1\n\
                [Control.Path.ILOS]\nEnabled = Never\nILOS Lookahead Distance = 70\n";
    let config = Config::load(&InMemory::new().with("m.ini", text), Path::new("m.ini"), &["Hardware"]);
    let counts = config.report().counts();
    assert_eq!((counts.errors, counts.warnings), (0, 1), "{}", config.report());
}

#[test]
fn contradictions_between_values_are_errors() {
    let head = "[General]\nVehicle = v\n[IMC Addresses]\nv = 1\n";
    for text in [
        "[Control.ASV.HeadingAndSpeed]\nEnabled = Always\nEntity Label = C\n\
         Entity Label - Port Motor = C\nEntity Label - Starboard Motor = C\n\
         Minimum RPM Limit = 900\nMaximum RPM Limit = 800",
        "[Transports.TCP.Server/a]\nEnabled = Always\nEntity Label = A\nPort = 1\n\
         [Transports.TCP.Server/b]\nEnabled = Always\nEntity Label = B\nPort = 1",
        "[UserInterfaces.LEDs]\nEnabled = Always\nEntity Label = L\nPattern - Error = 1, 200, 0",
        "[Supervisors.OperationalLimits]\nEnabled = Always\nEntity Label = O\nArea = 63, 10, 64",
        "[General]\nSpeed Conversion -- Actuation = 0, 0, 1, 2, 3, 4, 5, 6, 7, 8, 9",
    ] {
        let files = InMemory::new().with("m.ini", format!("{head}{text}\n"));
        let config = Config::load(&files, Path::new("m.ini"), &["Simulation"]);
        assert!(config.report().has_errors(), "{text}\n{}", config.report());
        let mut others = config.report().problems().iter().filter(|one| one.severity == Severity::Warning);
        assert!(others.all(|one| one.kind == ProblemKind::NotHonoured), "{text}\n{}", config.report());
    }
}

const VESSEL: &str = "[General]\nVehicle = otter\n[IMC Addresses]\notter = 0x2810\n";

#[test]
fn what_nothing_obeys_is_said_and_is_an_error_where_it_would_protect_the_vessel() {
    for (section, line, severity) in [
        ("Supervisors.ASV.LostComms", "Require Idle = true", Some(Severity::Warning)),
        ("Supervisors.ASV.LostComms", "Require Idle = false", None),
        ("Supervisors.Vehicle", "Allows External Control = true", Some(Severity::Warning)),
        ("Monitors.FuelLevel", "Low Confidence Level = 40", Some(Severity::Warning)),
        ("Monitors.FuelLevel", "Error Voltage = 24", None),
        ("Monitors.Entities", "Transition Time Gap = 4", Some(Severity::Note)),
        ("Maneuver.FollowReference.ASV", "Minimum Separation = 15", None),
        ("Maneuver.Multiplexer", "Unsupported = Rows", None),
    ] {
        let text = format!("{VESSEL}[{section}]\nEnabled = Always\nEntity Label = GPS\n{line}\n");
        let config = Config::load(&InMemory::new().with("m.ini", text), Path::new("m.ini"), &["Simulation"]);
        let problems = config.report().problems().iter();
        let found: Vec<_> = problems.filter(|one| one.kind == ProblemKind::NotHonoured).collect();
        assert_eq!(found.first().map(|one| one.severity), severity, "{line}\n{}", config.report());
        assert!(found.iter().all(|one| one.place.as_ref().unwrap().line == 8), "{line}");
    }
}

#[test]
fn a_misspelt_vital_entity_is_an_error_with_the_right_name() {
    let vital = "[Supervisors.Vehicle]\nEnabled = Always\nEntity Label = V\nVital Entities = Navigatoin\n\
                 [Navigation.General.GPSNavigation]\nEnabled = Always\nEntity Label = Navigation\n";
    let files = InMemory::new().with("m.ini", format!("{VESSEL}{vital}"));
    let config = Config::load(&files, Path::new("m.ini"), &["Simulation"]);
    let found = config.report().problems().iter().find(|one| one.what.contains("Navigatoin")).unwrap();
    assert_eq!((found.severity, found.remedy.as_str()), (Severity::Error, "`Navigation`?"));
}

#[test]
fn a_vessel_without_a_compass_is_refused() {
    let head = "[General]\nVehicle = v\n[IMC Addresses]\nv = 1\n[Navigation.General.GPSNavigation]\n\
                Enabled = Always\nEntity Label = Navigation\n";
    for (text, refused) in
        [("GPS has Yaw = true", false), ("GPS has Yaw = false", true), ("Entity Label - Yaw = AHRS", true)]
    {
        let files = InMemory::new().with("m.ini", format!("{head}{text}\n"));
        let config = Config::load(&files, Path::new("m.ini"), &["Hardware"]);
        assert_eq!(config.report().has_errors(), refused, "{text}\n{}", config.report());
        assert_eq!(config.report().to_string().contains("satellite compass"), refused, "{text}");
    }
}
