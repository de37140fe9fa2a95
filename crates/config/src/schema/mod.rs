//! The sections and parameters that Lutra knows, under DUNE's names.
//!
//! Defaults are DUNE's where it has one; where an Otter needs another value the documentation names it.
//! Sources: the `param(..)` lines of the DUNE tasks of the same names.
//! Keys that DUNE does not have are marked "Lutra:" in their documentation.

pub mod common;
pub mod control;
pub mod device;
pub mod general;
pub mod mission;
mod not_honoured;
mod otter;
pub mod path;
pub mod simulate;
pub mod transport;
pub mod watch;

pub use not_honoured::{ANY_TASK, NOT_HONOURED, NotHonoured, not_honoured};
pub use otter::{OTTER_VALUES, otter_value};

use crate::spec::{Form, SectionSpec};

/// Every section that Lutra knows, in the order in which its own configuration is written.
pub static SECTIONS: &[&SectionSpec] = &[
    &general::GENERAL,
    &general::IMC_ADDRESSES,
    &general::PROFILES,
    &mission::navigation::NAVIGATION,
    &control::course_speed::COURSE_SPEED,
    &control::course_speed_force::COURSE_SPEED_FORCE,
    &path::ilos::ILOS,
    &path::PURE_PURSUIT,
    &path::vector_field::VECTOR_FIELD,
    &control::remote::REMOTE,
    &mission::plan::ENGINE,
    &mission::plan::DATABASE,
    &mission::maneuver::MULTIPLEXER,
    &mission::maneuver::FOLLOW_REFERENCE,
    &mission::maneuver::FOLLOW_SYSTEM,
    &mission::maneuver::FOLLOW_TRAJECTORY,
    &mission::maneuver::ROWS_COVERAGE,
    &mission::maneuver::TELEOPERATION,
    &watch::vehicle::VEHICLE,
    &watch::lost_comms::LOST_COMMS,
    &watch::entities::ENTITIES,
    &watch::fuel::FUEL,
    &watch::limits::LIMITS,
    &watch::grounding::GROUNDING,
    &watch::clock::CLOCK,
    &watch::host::HOST,
    &watch::host::THERMAL,
    &transport::announce::ANNOUNCE,
    &transport::udp::UDP,
    &transport::tcp::SERVER,
    &transport::tcp::CLIENT,
    &transport::logging::LOGGING,
    &transport::log_book::LOG_BOOK,
    &transport::lutra::LUTRA,
    &transport::lutra::WAY,
    &device::compass::COMPASS,
    &device::hydrophone::HYDROPHONE,
    &device::line_receiver::LINE_RECEIVER,
    &device::sound_speed::SOUND_SPEED,
    &device::torqeedo::TORQEEDO,
    &device::board::WATCHDOG,
    &device::board::LIGHTS,
    &simulate::hull::HULL,
    &simulate::current::CURRENT,
    &simulate::gps::GPS,
    &simulate::motor::MOTOR,
    &simulate::fish::FISH,
    &general::hull::MODEL,
];

/// DUNE tasks that Lutra knows of and does without, each with the reason.
pub static LEFT_OUT: &[(&str, &str)] = &[
    ("Transports.Discovery", "Lutra's Transports.Announce listens as well"),
    ("Transports.HTTP", "the Lutra server has the web page"),
    ("Transports.FTP", "logs reach the shore over Lutra's link"),
    ("Transports.Cache", "Lutra's spool keeps what must not be lost"),
    ("Transports.Fragments", "Lutra's link carries packets of any size"),
    ("Transports.RemoteState", "for acoustic modems"),
    ("Plan.Generator", "plans are made ashore"),
    ("Autonomy.TextActions", "for text messages over radio"),
];

/// The description of the section called `name` in a file, if Lutra knows it.
pub fn find(name: &str) -> Option<&'static SectionSpec> {
    let task = task_of(name);
    SECTIONS.iter().copied().find(|spec| match spec.form {
        Form::Task { .. } => spec.names.contains(&task),
        Form::Data | Form::OpenData(_) => spec.names.contains(&name),
        Form::DataFor { .. } => {
            spec.names.iter().any(|prefix| name.len() > prefix.len() && name.starts_with(prefix))
        }
    })
}

/// Why Lutra does without the DUNE task of this section, if it is one it knows of.
pub fn reason_left_out(name: &str) -> Option<&'static str> {
    let task = task_of(name);
    LEFT_OUT.iter().find(|(known, _)| *known == task).map(|(_, reason)| *reason)
}

/// The part of a section's name that names the task: the text before the first `/`.
pub(crate) fn task_of(name: &str) -> &str {
    name.split_once('/').map_or(name, |(task, _)| task)
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeSet;

    use super::*;
    use crate::read::{default, read};
    use crate::spec::{Kind, ParamSpec};

    #[test]
    fn every_name_and_key_is_known_once() {
        let mut names = BTreeSet::new();
        for spec in SECTIONS {
            assert!(spec.names.iter().all(|name| names.insert(*name)), "{}", spec.name());
            let mut keys = BTreeSet::new();
            for key in spec.params().flat_map(ParamSpec::keys) {
                assert!(keys.insert(key.clone()), "{}/{key}", spec.name());
                assert!(spec.params().any(|param| param.matches(&key)), "{}/{key}", spec.name());
            }
        }
    }

    #[test]
    fn everything_is_documented_in_one_line() {
        for spec in SECTIONS {
            assert!(!spec.doc.is_empty(), "{}", spec.name());
            for param in spec.params() {
                let one_line = !param.doc.is_empty() && !param.doc.contains('\n');
                assert!(one_line, "{}/{}", spec.name(), param.name);
                assert_eq!(param.name.contains("{}"), param.is_repeated(), "{}/{}", spec.name(), param.name);
            }
        }
    }

    #[test]
    fn every_default_is_allowed() {
        for spec in SECTIONS {
            for param in spec.params().filter(|param| !matches!(param.kind, Kind::Unused)) {
                let value = default(&param.kind).unwrap();
                let text = value.to_string();
                let outcome = read(param, &text);
                assert_eq!(outcome.faults, [], "{}/{}", spec.name(), param.name);
                if !text.is_empty() {
                    assert_eq!(outcome.value, Some(value), "{}/{}", spec.name(), param.name);
                }
            }
        }
    }

    #[test]
    fn every_value_of_the_otter_is_allowed_and_differs_from_the_default() {
        for (section, key, text) in OTTER_VALUES {
            let spec = find(section).unwrap();
            let param = spec.params().find(|param| param.matches(key)).unwrap();
            let value = read(param, text).value;
            assert!(value.is_some() && value != default(&param.kind), "{section}/{key}");
            assert_eq!(spec.name(), *section);
        }
    }

    #[test]
    fn instances_and_other_names_find_their_section() {
        for (name, found) in [
            ("Simulators.Motor/Port", Some("Simulators.Motor")),
            ("Control.Path.ILOSOtter", Some("Control.Path.ILOS")),
            ("VSIM/Model/asv", Some("VSIM/Model/")),
            ("VSIM/Model/", None),
            ("General/x", None),
            ("general", None),
        ] {
            assert_eq!(find(name).map(SectionSpec::name), found, "{name}");
        }
        assert!(reason_left_out("Transports.FTP").is_some());
    }
}
