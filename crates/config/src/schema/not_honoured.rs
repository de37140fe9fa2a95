//! Settings that are read and checked, because DUNE's files have them, but that have no effect in Lutra.
//!
//! A setting is listed with the value that Lutra acts by, where it has one. A file with another value gets
//! a note where it makes little difference, a warning where the vessel behaves otherwise than the file
//! says. A setting whose neglect would make the vessel less safe must not be listed here but be implemented.

use crate::problem::Severity;

/// A setting without effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotHonoured {
    /// The first name of its section; [`ANY_TASK`] for an option that every task has.
    pub section: &'static str,
    /// Its key; `{}` as in the schema.
    pub key: &'static str,
    /// The value as which Lutra acts, in the words of the file; none where no value says it.
    pub acts_as: Option<&'static str>,
    /// What Lutra does instead.
    pub instead: &'static str,
    /// The severity of another value.
    pub severity: Severity,
}

const fn entry(
    severity: Severity,
    section: &'static str,
    key: &'static str,
    acts_as: Option<&'static str>,
    instead: &'static str,
) -> NotHonoured {
    NotHonoured { section, key, acts_as, instead, severity }
}

use Severity::{Note, Warning};

/// Stands for every task.
pub const ANY_TASK: &str = "*";

const GENERAL: &str = "General";
const NAVIGATION: &str = "Navigation.General.GPSNavigation";
const RPM: &str = "Control.ASV.HeadingAndSpeed";
const FORCE: &str = "Control.ASV.HeadingAndSpeedForce";
const ENGINE: &str = "Plan.Engine";
const MULTIPLEXER: &str = "Maneuver.Multiplexer";
const VEHICLE: &str = "Supervisors.Vehicle";
const LOST: &str = "Supervisors.ASV.LostComms";
const ENTITIES: &str = "Monitors.Entities";
const FUEL: &str = "Monitors.FuelLevel";
const CLOCK: &str = "Monitors.Clock";
const HOST: &str = "Monitors.HostResources";
const ILOS: &str = "Control.Path.ILOS";
const PURE_PURSUIT: &str = "Control.Path.PurePursuit";
const VECTOR_FIELD: &str = "Control.Path.VectorField";
const UDP: &str = "Transports.UDP";
const ANNOUNCE: &str = "Transports.Announce";
const LOGGING: &str = "Transports.Logging";
const COMPASS: &str = "Sensors.GPS";
const HYDROPHONE: &str = "Sensors.ThelmaHydrophone";
const SIMULATED_CURRENT: &str = "Simulators.StreamVelocity";
const SIMULATED_GPS: &str = "Simulators.GPS";
const SIMULATED_HULL: &str = "Simulators.VSIM";
const SIMULATED_MOTOR: &str = "Simulators.Motor";

const TUNED: &str = "the controllers have limits of their own, tuned on the hull";
const EVERY_POSITION: &str = "path control steps with every estimate of the position";
const PRINT: &str = "packets are not printed; `imc listen` shows them";
const AT_ONCE: &str = "every part is ready at once";
const ONE_COMPASS: &str = "the simulated compass is one model, with that model's noise";
const ONE_HULL: &str = "the simulated vessel has steps, motors and current of its own";
const NO_ROLL: &str = "roll and pitch are not used";

/// All of them.
pub static NOT_HONOURED: &[NotHonoured] = &[
    entry(Note, ANY_TASK, "Execution Priority", None, "all tasks share one thread"),
    entry(Note, ANY_TASK, "Activation Time", Some("0"), AT_ONCE),
    entry(Note, ANY_TASK, "Deactivation Time", Some("0"), AT_ONCE),
    entry(Note, ANY_TASK, "Debug Level", Some("None"), "`--log-level` says what is logged, also by part"),
    entry(Note, ANY_TASK, "Loopback Internal Messages", Some("false"), "parts do not send to themselves"),
    entry(Note, ANY_TASK, "Active", Some("true"), "what is enabled is active"),
    entry(Note, ANY_TASK, "Active - Scope", Some("global"), "what is enabled is active"),
    entry(Note, ANY_TASK, "Active - Visibility", None, "what is enabled is active"),
    entry(Note, GENERAL, "Battery Packs", None, "every battery that reports is watched"),
    entry(Note, GENERAL, "CPU Usage - Moving Average Samples", Some("10"), "ten samples are averaged"),
    entry(Warning, GENERAL, "Recovery Plan", None, "any console may start any plan"),
    entry(Note, NAVIGATION, "Entity Label - IMU", None, NO_ROLL),
    entry(Note, NAVIGATION, "GPS has IMU", None, NO_ROLL),
    entry(Warning, RPM, "Maximum Thrust Differential Actuation", None, TUNED),
    entry(Warning, RPM, "Hardware RPMs Control", Some("true"), "the motors keep the propeller speed"),
    entry(Note, RPM, "RPMs at Maximum Thrust", None, TUNED),
    entry(Note, RPM, "RPMs PID Gains", None, "the motors keep the propeller speed"),
    entry(Note, RPM, "RPMs Feedforward Gain", None, "the motors keep the propeller speed"),
    entry(Note, RPM, "RPMs Integral Limit", None, "the motors keep the propeller speed"),
    entry(Warning, RPM, "Minimum RPM Limit", Some("0"), TUNED),
    entry(Warning, RPM, "Maximum RPM Limit", None, TUNED),
    entry(Note, RPM, "Maximum RPM Acceleration", None, TUNED),
    entry(Note, RPM, "Log PID Parcels", Some("false"), "the parts of the controllers are not sent"),
    entry(Warning, FORCE, "Minimum Force Limit", Some("-30"), TUNED),
    entry(Warning, FORCE, "Maximum Force Limit", Some("239.364"), TUNED),
    entry(
        Note,
        FORCE,
        "Share Saturation",
        Some("true"),
        "the turn comes first, and the common force gives way",
    ),
    entry(Note, FORCE, "Log PID Parcels", Some("false"), "the parts of the controllers are not sent"),
    entry(Note, ENGINE, "Compute Progress", Some("true"), "progress is always reported"),
    entry(Note, ENGINE, "Fuel Prediction", Some("true"), "the energy is always predicted"),
    entry(
        Warning,
        ENGINE,
        "Abort On Failed Activation",
        Some("false"),
        "payloads do not tell whether they start",
    ),
    entry(Note, ENGINE, "Vehicle Reply Timeout", None, "engine and supervisor are one; nothing waits"),
    entry(Warning, "Plan.DB", "Folder", Some(""), "plans lie in the agent's data folder"),
    entry(Note, MULTIPLEXER, "Entity Label -- {}", None, "all maneuvers are one entity"),
    entry(
        Warning,
        VEHICLE,
        "Allows External Control",
        Some("false"),
        "the motors are never commanded from outside",
    ),
    entry(
        Warning,
        LOST,
        "Require Idle",
        Some("false"),
        "the `Action ..` settings say what is done during what",
    ),
    entry(Warning, LOST, "Require Bad Outcome", Some("false"), "how the last plan ended is not asked"),
    entry(Note, ENTITIES, "Transition Time Gap", None, "every change of state is reported"),
    entry(Note, ENTITIES, "Maximum Consecutive Transitions", None, "every change of state is reported"),
    entry(Note, FUEL, "Execution Frequency", None, "the batteries are looked at twice a second"),
    entry(Warning, FUEL, "Low Confidence Level", Some("0"), "the batteries' own charge is believed"),
    entry(Note, ILOS, "Control Frequency", None, EVERY_POSITION),
    entry(Note, PURE_PURSUIT, "Control Frequency", None, EVERY_POSITION),
    entry(Note, VECTOR_FIELD, "Control Frequency", None, EVERY_POSITION),
    entry(Note, UDP, "Contact Refresh Periodicity", None, "contacts are looked through at every packet"),
    entry(Note, UDP, "Local Messages Only", Some("true"), "no others' messages are passed on by datagrams"),
    entry(Note, UDP, "Print Incoming Messages", Some("false"), PRINT),
    entry(Note, UDP, "Print Outgoing Messages", Some("false"), PRINT),
    entry(Warning, "Transports.TCP.Client", "Enabled", Some("Never"), "the agent does not connect to others"),
    entry(
        Warning,
        ANNOUNCE,
        "Ignored Interfaces",
        Some(""),
        "announcements go out as the system routes them",
    ),
    entry(Warning, ANNOUNCE, "System Type", Some("USV"), "the vessel announces itself as a USV"),
    entry(Note, LOGGING, "LSF Volume Size", Some("0"), "a new log begins with every plan only"),
    entry(Warning, LOGGING, "LSF Volume Directories", Some(""), "logs lie in the agent's data folder"),
    entry(Note, LOGGING, "Transports", Some(""), "every message is logged"),
    entry(
        Note,
        COMPASS,
        "Sentence Order",
        None,
        "what comes of one moment is one measurement, in whatever order",
    ),
    entry(
        Warning,
        COMPASS,
        "Initialization String {} - Reply",
        Some(""),
        "no answer of a compass is awaited; it fails when no sentence of use comes",
    ),
    entry(
        Warning,
        HYDROPHONE,
        "Rawlogfile folder",
        Some(""),
        "no file of raw lines is written: each line is in the Event of its detection",
    ),
    entry(Note, SIMULATED_HULL, "Execution Frequency", None, ONE_HULL),
    entry(Note, SIMULATED_HULL, "Entity Label - Stream Velocity Source", None, ONE_HULL),
    entry(Note, SIMULATED_CURRENT, "Execution Frequency", None, ONE_HULL),
    entry(Note, SIMULATED_CURRENT, "Default Speed Down", Some("0"), ONE_HULL),
    entry(Note, SIMULATED_MOTOR, "Execution Frequency", None, ONE_HULL),
    entry(Note, SIMULATED_MOTOR, "Thruster Act to RPM Factor", None, ONE_HULL),
    entry(Note, SIMULATED_GPS, "Number of Satellites", None, ONE_COMPASS),
    entry(Note, SIMULATED_GPS, "HACC", None, ONE_COMPASS),
    entry(Note, SIMULATED_GPS, "HDOP", None, ONE_COMPASS),
    entry(Note, SIMULATED_GPS, "Activation Depth", None, ONE_COMPASS),
    entry(Note, SIMULATED_GPS, "Report Ground Velocity", None, ONE_COMPASS),
    entry(Warning, SIMULATED_GPS, "Report Yaw", Some("true"), ONE_COMPASS),
    entry(Warning, SIMULATED_GPS, "Position Noise", None, ONE_COMPASS),
    entry(
        Note,
        "Sensors.ThermalZone",
        "Execution Frequency",
        None,
        "the temperature is reported every second",
    ),
    entry(Warning, CLOCK, "Minimum GPS Fixes", None, "the clock is judged by every position with a time"),
    entry(Warning, CLOCK, "Boot Synchronization Timeout", Some("0"), "nothing waits for the clock"),
    entry(Warning, CLOCK, "Hardware Clock Synchronization Command", Some(""), "no command is run"),
    entry(Note, HOST, "Execution Frequency", Some("1"), "the computer is looked at once a second"),
];

/// Whether this setting has no effect, and what is done instead.
pub fn not_honoured(section: &str, key: &str) -> Option<&'static NotHonoured> {
    let is_of = |one: &&NotHonoured| one.section == section || one.section == ANY_TASK;
    NOT_HONOURED.iter().filter(is_of).find(|one| one.key == key)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::read;
    use crate::schema::common::OF_EVERY_TASK;
    use crate::schema::find;

    #[test]
    fn each_is_a_setting_of_the_schema_once_and_acts_as_a_value_it_may_have() {
        for (n, one) in NOT_HONOURED.iter().enumerate() {
            let name = format!("{}/{}", one.section, one.key);
            let param = if one.section == ANY_TASK {
                OF_EVERY_TASK.iter().find(|param| param.name == one.key)
            } else {
                let spec = find(one.section).unwrap();
                assert_eq!(spec.name(), one.section);
                spec.params().find(|param| param.name == one.key)
            };
            let param = param.unwrap_or_else(|| panic!("{name}"));
            assert!(
                NOT_HONOURED[..n].iter().all(|other| (other.section, other.key) != (one.section, one.key))
            );
            assert!(one.acts_as.is_none_or(|text| read(param, text).faults.is_empty()), "{name}");
        }
    }
}
