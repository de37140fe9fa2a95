//! Checks across values: labels given twice, limits that exclude each other, names that refer to nothing.

use std::collections::BTreeMap;

use crate::config::Config;
use crate::problem::{Problem, ProblemKind, Severity};
use crate::read::read;
use crate::schema::{self, control, device, general, mission, path, simulate, transport, watch};
use crate::section::Section;
use crate::spec::{Kind, Param, ParamSpec, SectionSpec};

/// The label of the agent itself.
const DAEMON: &str = "Daemon";

/// Looks at the whole configuration and adds what it finds to the report.
pub(crate) fn all(config: &mut Config) {
    let mut found = Vec::new();
    identity(config, &mut found);
    labels(config, &mut found);
    label_references(config, &mut found);
    numbers_used_once(config, &mut found);
    limits(config, &mut found);
    tables(config, &mut found);
    hull_model(config, &mut found);
    compass(config, &mut found);
    for section in config.sections.iter().filter(|section| section.runs) {
        activation(section, &mut found);
        not_honoured(section, &mut found);
    }
    for problem in found {
        config.report.add(problem);
    }
}

type Found = Vec<Problem>;

/// A problem of one option, at its line, or at its section's where the files do not give it.
fn about(
    section: &Section,
    severity: Severity,
    kind: ProblemKind,
    param: &ParamSpec,
    what: String,
) -> Problem {
    let place = section.parameter(param.name).and_then(crate::section::Parameter::place);
    Problem::new(severity, kind, place.or(section.place()), what)
}

fn identity(config: &Config, found: &mut Found) {
    let general = config.general();
    let problem =
        |what| about(&general, Severity::Error, ProblemKind::Identity, &general::VEHICLE.spec, what);
    let vehicle = config.vehicle();
    if vehicle.is_empty() {
        let what = "the vessel has no name".to_owned();
        found.push(problem(what).remedy("write `Vehicle = name` in [General]"));
        return;
    }
    if config.saved_path().is_none() {
        let what = format!("`{vehicle}` cannot be part of a file's name");
        found.push(problem(what).remedy("take `/` and a leading `.` out of the name"));
    }
    let addresses = config.addresses();
    let Some(own) = addresses.get(vehicle) else {
        let what = format!("`{vehicle}` has no address");
        let remedy = match suggest::nearest(vehicle, addresses.keys().copied()) {
            Some(near) => {
                format!("`{near}`? Otherwise write `{vehicle} = 0x2810` or such in [IMC Addresses]")
            }
            None => format!("write `{vehicle} = 0x2810` or such in [IMC Addresses]"),
        };
        found.push(problem(what).remedy(remedy));
        return;
    };
    for (name, _) in addresses.iter().filter(|(name, address)| *address == own && **name != vehicle) {
        let what = format!("`{name}` has the same address as `{vehicle}`: {own:#06x}");
        found.push(problem(what).remedy("give each system an address of its own"));
    }
}

/// Entity labels must differ, since messages name entities by them.
fn labels(config: &Config, found: &mut Found) {
    let mut owners: BTreeMap<&str, &Section> = BTreeMap::new();
    for section in config.sections.iter().filter(|section| section.runs) {
        let Some(label) = section.label() else { continue };
        if let Some(first) = owners.get(label) {
            let place = config.ini.setting(section.name(), "Entity Label").and_then(crate::Setting::place);
            let what = format!("[{}] and [{}] both have the label `{label}`", first.name(), section.name());
            let problem = Problem::error(ProblemKind::Label, place.or(section.place()), what);
            found.push(problem.remedy("give each its own, or enable only one of them in this profile"));
        } else {
            owners.insert(label, section);
        }
    }
}

/// Labels that other sections refer to must exist in this profile.
fn label_references(config: &Config, found: &mut Found) {
    let known = known_labels(config);
    let single: [(&'static SectionSpec, &Param<String>); 7] = [
        (&mission::navigation::NAVIGATION, &mission::navigation::GPS),
        (&mission::navigation::NAVIGATION, &mission::navigation::IMU),
        (&mission::navigation::NAVIGATION, &mission::navigation::YAW),
        (&control::course_speed::COURSE_SPEED, &control::PORT_MOTOR),
        (&control::course_speed::COURSE_SPEED, &control::STARBOARD_MOTOR),
        (&device::sound_speed::SOUND_SPEED, &device::sound_speed::ENTITY),
        (&simulate::hull::HULL, &simulate::hull::STREAM_SOURCE),
    ];
    let mut references: Vec<(&Section, ParamSpec, Vec<String>)> = Vec::new();
    for (spec, param) in single {
        for section in config.running(spec) {
            references.push((section, param.spec, vec![section.get(param)]));
        }
    }
    for section in config.running(&watch::entities::ENTITIES) {
        let monitored = &watch::entities::MONITORED;
        references.push((section, monitored.spec, section.get(monitored)));
        let hardware = &watch::entities::MONITORED_HARDWARE;
        if config.profiles.selected().iter().any(|profile| profile == "Hardware") {
            references.push((section, hardware.spec, section.get(hardware)));
        }
    }
    for section in config.running(&watch::vehicle::VEHICLE) {
        let vital = &watch::vehicle::VITAL_ENTITIES;
        references.push((section, vital.spec, section.get(vital)));
    }
    for (section, param, labels) in references {
        // A vital entity with an unknown label would never end a plan.
        let vital = param.name == watch::vehicle::VITAL_ENTITIES.spec.name;
        let severity = if vital { Severity::Error } else { Severity::Warning };
        for label in labels.iter().filter(|label| !known.contains(label)) {
            let what = format!("`{}`: no running task has the label `{label}`", param.name);
            let remedy = match suggest::nearest(label, known.iter().map(String::as_str)) {
                Some(near) => format!("`{near}`?"),
                None => "mend the label, or enable the task that has it".to_owned(),
            };
            let problem = about(section, severity, ProblemKind::Label, &param, what);
            found.push(problem.remedy(remedy));
        }
    }
}

/// The labels of all entities that exist with the selected profiles.
fn known_labels(config: &Config) -> Vec<String> {
    use device::torqeedo::{BATTERY_LABEL, MOTOR_LABEL, RAIL_LABEL};
    let mut known = vec![DAEMON.to_owned()];
    for section in config.sections.iter().filter(|section| section.runs) {
        known.extend(section.label().map(str::to_owned));
        let own = if section.is(&device::torqeedo::TORQEEDO) {
            &[(&MOTOR_LABEL, "Motor {}"), (&RAIL_LABEL, "Rail {}"), (&BATTERY_LABEL, "Battery {}")][..]
        } else if section.is(&mission::maneuver::MULTIPLEXER) {
            &[(&mission::maneuver::LABELS, "{} Maneuver")][..]
        } else {
            &[]
        };
        for (param, usual) in own {
            let given: BTreeMap<_, _> = section.each(param).into_iter().collect();
            let labels = param.spec.each.iter().map(|part| match given.get(part) {
                Some(label) if !label.is_empty() => label.clone(),
                Some(_) | None => usual.replace("{}", part),
            });
            known.extend(labels);
        }
    }
    known
}

/// Ports and thrusters that only one task can have.
fn numbers_used_once(config: &Config, found: &mut Found) {
    let unique: [(&'static SectionSpec, &Param<i64>); 3] = [
        (&transport::tcp::SERVER, &transport::tcp::PORT),
        (&transport::udp::UDP, &transport::udp::PORT),
        (&simulate::motor::MOTOR, &simulate::motor::THRUSTER_ID),
    ];
    for (spec, param) in unique {
        let mut users: BTreeMap<i64, &Section> = BTreeMap::new();
        for section in config.running(spec) {
            let number = section.get(param);
            let Some(first) = users.insert(number, section) else { continue };
            let what = format!("`{}`: [{}] has {number} as well", param.spec.name, first.name());
            let problem = about(section, Severity::Error, ProblemKind::Contradiction, &param.spec, what);
            found.push(problem.remedy("give each its own"));
        }
    }
}

/// Pairs of limits of which the first must not exceed the second.
fn limits(config: &Config, found: &mut Found) {
    use mission::maneuver;
    let ordered: [(&'static SectionSpec, &Param<f64>, &Param<f64>); 8] = [
        (
            &control::course_speed::COURSE_SPEED,
            &control::course_speed::MINIMUM_RPM,
            &control::course_speed::MAXIMUM_RPM,
        ),
        (
            &control::course_speed_force::COURSE_SPEED_FORCE,
            &control::course_speed_force::MINIMUM_FORCE,
            &control::course_speed_force::MAXIMUM_FORCE,
        ),
        (
            &mission::navigation::NAVIGATION,
            &mission::navigation::DEAD_RECKONING,
            &mission::navigation::FIX_TIMEOUT,
        ),
        (&watch::fuel::FUEL, &watch::fuel::ERROR_LEVEL, &watch::fuel::RESERVE_LEVEL),
        (&watch::fuel::FUEL, &watch::fuel::RESERVE_LEVEL, &watch::fuel::WARNING_LEVEL),
        (&watch::host::HOST, &watch::host::DISK_ERROR, &watch::host::DISK_WARNING),
        (&maneuver::MULTIPLEXER, &maneuver::SCHEDULED_MINIMUM, &maneuver::SCHEDULED_MAXIMUM),
        (&maneuver::FOLLOW_TRAJECTORY, &maneuver::TRAJECTORY_MINIMUM, &maneuver::TRAJECTORY_MAXIMUM),
    ];
    for (spec, low, high) in ordered {
        for section in config.running(spec) {
            let (least, most) = (section.get(low), section.get(high));
            if least > most {
                let what =
                    format!("`{}` is {least}, above `{}`, which is {most}", low.spec.name, high.spec.name);
                let problem = about(section, Severity::Error, ProblemKind::Contradiction, &low.spec, what);
                found.push(problem.remedy("exchange or mend them"));
            }
        }
    }
    for section in config.running(&path::ilos::ILOS) {
        let (field, sight) = (&path::ilos::OUT_VECTOR_FIELD, &path::ilos::OUT_LINE_OF_SIGHT);
        if section.get(field) && section.get(sight) {
            let what = format!("`{}` and `{}` exclude each other", field.spec.name, sight.spec.name);
            let problem = about(section, Severity::Warning, ProblemKind::Contradiction, &sight.spec, what);
            found.push(problem.remedy("the vector field is used; set the other to false"));
        }
    }
}

/// Lists that must fit each other.
fn tables(config: &Config, found: &mut Found) {
    let general = config.general();
    let actuations = general.get(&general::CONVERSION_ACTUATION);
    let rising = actuations.windows(2).all(|pair| pair[0] < pair[1]);
    if !rising {
        let param = &general::CONVERSION_ACTUATION.spec;
        let what = format!("`{}` does not rise from item to item", param.name);
        let problem = about(&general, Severity::Error, ProblemKind::Contradiction, param, what);
        found.push(problem.remedy("sort the table"));
    }
    for param in [&general::CONVERSION_RPM, &general::CONVERSION_MPS] {
        let items = general.get(param).len();
        if items != actuations.len() {
            let (name, wanted) = (param.spec.name, actuations.len());
            let what = format!("`{name}` has {items} items and the table of actuations {wanted}");
            let problem = about(&general, Severity::Error, ProblemKind::Contradiction, &param.spec, what);
            found.push(problem.remedy("give all tables of speed conversion the same length"));
        }
    }
    for section in config.running(&device::board::LIGHTS) {
        patterns(section, found);
    }
    for section in config.running(&watch::limits::LIMITS) {
        let corners = section.get(&watch::limits::AREA).len();
        if !corners.is_multiple_of(2) || (1..6).contains(&corners) {
            let what = format!("`Area` has {corners} numbers");
            let param = &watch::limits::AREA.spec;
            let problem = about(section, Severity::Error, ProblemKind::Contradiction, param, what);
            found.push(problem.remedy("give latitude and longitude of at least three corners"));
        }
    }
}

/// Without a compass DUNE takes the course for the heading: at rest that is noise, and the vessel spins.
fn compass(config: &Config, found: &mut Found) {
    use mission::navigation::{GPS, GPS_HAS_YAW, NAVIGATION, YAW};
    for section in config.running(&NAVIGATION) {
        let (param, what) = if !section.get(&GPS_HAS_YAW) {
            (
                &GPS_HAS_YAW.spec,
                "`GPS has Yaw` is false: the heading would be the course over ground".to_owned(),
            )
        } else if section.get(&YAW) != section.get(&GPS) {
            let what = format!("`{}` is `{}`, not the compass", YAW.spec.name, section.get(&YAW));
            (&YAW.spec, what)
        } else {
            continue;
        };
        let problem = about(section, Severity::Error, ProblemKind::Contradiction, param, what);
        found.push(
            problem.remedy("Lutra steers by the heading of a satellite compass only; fit one and say so"),
        );
    }
}

/// A pattern of lights is made of groups: a state for each light and a duration.
fn patterns(section: &Section, found: &mut Found) {
    use device::board;
    let group = section.get(&board::PINS).len() + 1;
    for param in [
        &board::PATTERN_NORMAL,
        &board::PATTERN_FUEL_LOW,
        &board::PATTERN_STARTING,
        &board::PATTERN_EXECUTING,
        &board::PATTERN_ERROR,
        &board::PATTERN_FATAL,
        &board::PATTERN_SHUTDOWN,
    ] {
        let items = section.get(param).len();
        if items == 0 || !items.is_multiple_of(group) {
            let what = format!("`{}` has {items} items, no multiple of {group}", param.spec.name);
            let problem = about(section, Severity::Error, ProblemKind::Contradiction, &param.spec, what);
            found.push(problem.remedy("repeat: one state for each light, then milliseconds"));
        }
    }
}

/// The simulator needs the hull that the vessel's type names.
fn hull_model(config: &Config, found: &mut Found) {
    let general = config.general();
    let name = format!("{}{}", general::hull::MODEL.name(), general.get(&general::VEHICLE_TYPE));
    if config.running(&simulate::hull::HULL).next().is_none() || config.section(&name).is_some() {
        return;
    }
    let models = config.sections.iter().filter(|section| section.is(&general::hull::MODEL));
    let remedy = match suggest::nearest(&name, models.map(Section::name)) {
        Some(near) => format!("there is [{near}]: capital and small letters are different"),
        None => format!("add [{name}]; Lutra's own simulator does without"),
    };
    let what = format!("DUNE's simulator would look for [{name}], which is not there");
    let param = &general::VEHICLE_TYPE.spec;
    let problem = about(&general, Severity::Warning, ProblemKind::Contradiction, param, what);
    found.push(problem.remedy(remedy));
}

/// Settings in the files that have no effect.
fn not_honoured(section: &Section, found: &mut Found) {
    let Some(spec) = section.spec() else { return };
    for parameter in section.parameters() {
        let (Some(param), Some(_)) = (parameter.spec(), parameter.setting()) else { continue };
        let entry = schema::not_honoured(spec.name(), param.name).filter(|_| param.kind != Kind::Unused);
        let Some(entry) = entry else { continue };
        let same = |text: &str| read(param, text).value.as_ref() == Some(parameter.value());
        // An empty text is the default to the reader of files; here it means an empty value.
        let is_empty = parameter.value().to_string().is_empty();
        if entry.acts_as.is_some_and(|text| if text.is_empty() { is_empty } else { same(text) }) {
            continue;
        }
        let what = format!("`{}` is not honoured: {}", parameter.key(), entry.instead);
        let remedy = match entry.acts_as {
            Some("") => "leave it empty".to_owned(),
            Some(text) => format!("write `{} = {text}`, which is what Lutra does", parameter.key()),
            None => "take it out unless DUNE needs it".to_owned(),
        };
        let problem = Problem::new(entry.severity, ProblemKind::NotHonoured, parameter.place(), what);
        found.push(problem.remedy(remedy));
    }
}

/// A task with scope maneuver starts inactive whatever its option says.
fn activation(section: &Section, found: &mut Found) {
    use crate::schema::common::{ACTIVE, ACTIVE_SCOPE};
    if section.get(&ACTIVE) && section.get(&ACTIVE_SCOPE) == "maneuver" {
        let what = "`Active` is true, but a task with scope maneuver starts inactive".to_owned();
        let problem = about(section, Severity::Note, ProblemKind::Contradiction, &ACTIVE.spec, what);
        found.push(problem);
    }
}
