//! The parameters of every task.

#![expect(missing_docs, reason = "each parameter carries its documentation as a value")]

use crate::spec::{Param, ParamSpec, Unit, choice, flag, float, int, text, texts};

pub const ENABLED: Param<Vec<String>> =
    texts("Enabled", &["Never"]).doc("Profiles in which the task runs: Always, Never, or names.");

pub const ENTITY_LABEL: Param<String> =
    text("Entity Label", "").doc("Name of the task's entity, unique on the vessel.");

pub const EXECUTION_PRIORITY: Param<i64> = int("Execution Priority", 10, Unit::None)
    .within(0, 99)
    .doc("Priority of the task's thread in DUNE; Lutra runs all tasks in one thread.");

pub const ACTIVATION_TIME: Param<f64> = float("Activation Time", 0.0, Unit::Second)
    .doc("Time the task needs to become active, used when plans are timed.");

pub const DEACTIVATION_TIME: Param<f64> = float("Deactivation Time", 0.0, Unit::Second)
    .doc("Time the task needs to become inactive, used when plans are timed.");

pub const DEBUG_LEVEL: Param<&str> = choice("Debug Level", "None", &["None", "Debug", "Trace", "Spew"])
    .doc("How much the task writes to the log.");

pub const LOOPBACK: Param<bool> = flag("Loopback Internal Messages", false)
    .doc("Whether the task also gets the messages that it sends itself.");

pub const ACTIVE: Param<bool> = flag("Active", false)
    .doc("Whether the task is active; with scope maneuver it starts inactive whatever stands here.");

pub const ACTIVE_SCOPE: Param<&str> =
    choice("Active - Scope", "global", &["global", "idle", "plan", "maneuver"])
        .doc("When `Active` may be changed.");

pub const ACTIVE_VISIBILITY: Param<&str> =
    choice("Active - Visibility", "developer", &["user", "developer"]).doc("Who sees `Active` on a console.");

/// The options that every task has.
pub const OF_EVERY_TASK: &[ParamSpec] = &[
    ENABLED.spec,
    ENTITY_LABEL.spec,
    EXECUTION_PRIORITY.spec,
    ACTIVATION_TIME.spec,
    DEACTIVATION_TIME.spec,
    DEBUG_LEVEL.spec,
    LOOPBACK.spec,
    ACTIVE.spec,
    ACTIVE_SCOPE.spec,
    ACTIVE_VISIBILITY.spec,
];

/// How often a periodic task runs.
pub(crate) const fn execution_frequency(default_hz: f64) -> Param<f64> {
    float("Execution Frequency", default_hz, Unit::Hertz)
        .within(0.001, 1000.0)
        .doc("How often the task runs.")
}

/// Numbers for `{}` in a key.
pub(crate) const DIGITS: &[&str] = &["0", "1", "2", "3", "4", "5", "6", "7", "8", "9"];
