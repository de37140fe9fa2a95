//! Settings that are read and checked, because DUNE's files have them, and that nothing in Lutra obeys.
//!
//! A setting stands here with the value as which Lutra acts, where it has one. A file that says otherwise is
//! told so: a note where it makes no difference to safety, a warning where the vessel behaves otherwise than
//! the file says, an error where the vessel would be less safe than the file says.

use crate::problem::Severity;

/// A setting that nothing obeys.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct NotHonoured {
    /// The first name of its section.
    pub section: &'static str,
    /// Its key; `{}` as in the schema.
    pub key: &'static str,
    /// The value as which Lutra acts, in the words of the file; none where no value says it.
    pub acts_as: Option<&'static str>,
    /// What Lutra does instead.
    pub instead: &'static str,
    /// What another value is worth.
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

const TUNED: &str = "the controllers have limits of their own, tuned on the hull";
const NO_ROLL: &str = "roll and pitch are not used";

/// All of them.
pub static NOT_HONOURED: &[NotHonoured] = &[
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
        "nobody outside ever commands the motors",
    ),
    entry(
        Warning,
        LOST,
        "Require Idle",
        Some("false"),
        "the `Action ..` settings say what is done during what",
    ),
    entry(Warning, LOST, "Require Bad Outcome", Some("false"), "how the last plan ended is not asked"),
    entry(Note, ENTITIES, "Transition Time Gap", None, "every change of state is told"),
    entry(Note, ENTITIES, "Maximum Consecutive Transitions", None, "every change of state is told"),
    entry(Note, FUEL, "Execution Frequency", None, "the batteries are looked at twice a second"),
    entry(Warning, FUEL, "Low Confidence Level", Some("0"), "the batteries' own charge is believed"),
    entry(Warning, CLOCK, "Minimum GPS Fixes", None, "the clock is judged by every position with a time"),
    entry(Warning, CLOCK, "Boot Synchronization Timeout", Some("0"), "nothing waits for the clock"),
    entry(Warning, CLOCK, "Hardware Clock Synchronization Command", Some(""), "no command is run"),
    entry(Note, HOST, "Execution Frequency", Some("1"), "the computer is looked at once a second"),
    entry(
        Warning,
        HOST,
        "Memory Warning Level",
        Some("0"),
        "the agent's own memory is watched, not the free one",
    ),
];

/// Whether nothing obeys this setting, and what is done instead.
pub fn not_honoured(section: &str, key: &str) -> Option<&'static NotHonoured> {
    NOT_HONOURED.iter().find(|one| one.section == section && one.key == key)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::read::read;
    use crate::schema::find;

    #[test]
    fn each_is_a_setting_of_the_schema_once_and_acts_as_a_value_it_may_have() {
        for (n, one) in NOT_HONOURED.iter().enumerate() {
            let (spec, name) = (find(one.section).unwrap(), format!("{}/{}", one.section, one.key));
            assert_eq!(spec.name(), one.section);
            let param = spec.params().find(|param| param.name == one.key);
            let param = param.unwrap_or_else(|| panic!("{name}"));
            assert!(
                NOT_HONOURED[..n].iter().all(|other| (other.section, other.key) != (one.section, one.key))
            );
            assert!(one.acts_as.is_none_or(|text| read(param, text).faults.is_empty()), "{name}");
        }
    }
}
