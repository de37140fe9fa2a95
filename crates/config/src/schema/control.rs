//! Course and speed, and manual control.

#![expect(missing_docs, reason = "each parameter carries its documentation as a value")]

use crate::schema::common::{OF_EVERY_TASK, execution_frequency};
use crate::spec::{Param, ParamSpec, SectionSpec, Unit, choice, flag, float, floats, int, text};

pub const MAXIMUM_ACTUATION: Param<f64> = float("Maximum Thrust Actuation", 1.0, Unit::Actuation)
    .within(0.01, 1.0)
    .doc("Greatest actuation of each motor.");
pub const RAMP_LIMIT: Param<f64> = float("Ramp Actuation Limit", 0.0, Unit::ActuationPerSecond)
    .within(0.0, 100.0)
    .doc("How fast the actuation of a motor may rise; 0 does not limit it.");
pub const MAXIMUM_HEADING_ERROR: Param<f64> = float("Maximum Heading Error to Thrust", 30.0, Unit::Degree)
    .within(5.0, 180.0)
    .doc("With a larger error the vessel turns on the spot before it goes ahead.");
pub const SHARE_SATURATION: Param<bool> = flag("Share Saturation", false)
    .doc("Whether what one motor cannot give is taken from the other, so that turning keeps its strength.");
pub const LOG_PID: Param<bool> =
    flag("Log PID Parcels", false).doc("Whether the parts of each controller's output are sent.");
pub const PORT_MOTOR: Param<String> =
    text("Entity Label - Port Motor", "Motor 0").doc("Entity that reports the speed of the port motor.");
pub const STARBOARD_MOTOR: Param<String> = text("Entity Label - Starboard Motor", "Motor 1")
    .doc("Entity that reports the speed of the starboard motor.");

const OF_EVERY_SPEED: &[ParamSpec] = &[
    MAXIMUM_ACTUATION.spec,
    RAMP_LIMIT.spec,
    MAXIMUM_HEADING_ERROR.spec,
    SHARE_SATURATION.spec,
    LOG_PID.spec,
    PORT_MOTOR.spec,
    STARBOARD_MOTOR.spec,
];

pub mod course_speed {
    use super::{OF_EVERY_SPEED, OF_EVERY_TASK, Param, SectionSpec, Unit, flag, float, floats};

    pub const MAXIMUM_DIFFERENTIAL: Param<f64> =
        float("Maximum Thrust Differential Actuation", 0.2, Unit::Actuation)
            .within(0.0, 2.0)
            .doc("Greatest difference put on the motors for turning while going ahead.");
    pub const HARDWARE_RPM: Param<bool> = flag("Hardware RPMs Control", true)
        .doc("Whether the motors keep the propeller speed themselves; otherwise a PID here does.");
    pub const RPM_AT_MAXIMUM: Param<f64> = float("RPMs at Maximum Thrust", 2500.0, Unit::Rpm)
        .within(1.0, 10_000.0)
        .doc("Propeller speed at full actuation; the Otters use 1100.");
    pub const RPM_GAINS: Param<Vec<f64>> =
        floats("RPMs PID Gains", &[0.2e-3, 0.21e-3, 29.0e-6], Unit::ActuationPerRpm).of_length(3).doc(
            "Gains P, I, D from propeller speed to actuation. DUNE has no default; these are the thesis'.",
        );
    pub const RPM_FEEDFORWARD: Param<f64> = float("RPMs Feedforward Gain", 0.5, Unit::ActuationPerRpm)
        .within(0.0, 10.0)
        .doc("Actuation for each wanted rpm, added to that PID; the thesis uses 0.46e-3.");
    pub const SPEED_GAINS: Param<Vec<f64>> =
        floats("MPS PID Gains", &[180.0, 100.0, 0.0], Unit::RpmPerMetrePerSecond)
            .of_length(3)
            .within(0.0, 1e5)
            .doc("Gains P, I, D from speed to propeller speed. DUNE has no default; these are tuned on the hull's model.");
    pub const SPEED_INTEGRAL_LIMIT: Param<f64> = float("MPS Integral Limit", -1.0, Unit::Rpm)
        .within(-1.0, 10_000.0)
        .doc("Greatest integral part of the speed PID; -1 does not limit it.");
    pub const SPEED_FEEDFORWARD: Param<f64> = float("MPS Feedforward Gain", 0.0, Unit::RpmPerMetrePerSecond)
        .within(0.0, 10_000.0)
        .doc("Propeller speed for each wanted m/s, added to the speed PID.");
    pub const MINIMUM_RPM: Param<f64> = float("Minimum RPM Limit", 200.0, Unit::Rpm)
        .within(0.0, 10_000.0)
        .doc("Least propeller speed while under way.");
    pub const MAXIMUM_RPM: Param<f64> =
        float("Maximum RPM Limit", 2000.0, Unit::Rpm).within(0.0, 10_000.0).doc("Greatest propeller speed.");
    pub const MAXIMUM_RPM_ACCELERATION: Param<f64> =
        float("Maximum RPM Acceleration", 70.0, Unit::RpmPerSecond)
            .within(0.0, 100_000.0)
            .doc("How fast the propeller speed may change.");
    pub const YAW_GAINS: Param<Vec<f64>> = floats(
        "Yaw PID Gains",
        &[1.0, 0.04, 0.7],
        Unit::ActuationPerRadian,
    )
    .of_length(3)
    .within(0.0, 1e5)
    .doc(
        "Gains P, I, D from heading error to actuation. DUNE has no default; these are tuned on the hull's \
                 model. `lutra-agent check` tells of ones that oscillate there.",
    );
    pub const YAW_INTEGRAL_LIMIT: Param<f64> = float("Yaw Integral Limit", -1.0, Unit::Actuation)
        .within(-1.0, 2.0)
        .doc("Greatest integral part of the yaw PID; -1 does not limit it.");
    pub const RPM_INTEGRAL_LIMIT: Param<f64> = float("RPMs Integral Limit", -1.0, Unit::Actuation)
        .within(-1.0, 1.0)
        .doc("Greatest integral part of the propeller speed PID; -1 does not limit it.");

    pub static COURSE_SPEED: SectionSpec = SectionSpec::task(
        &["Control.ASV.HeadingAndSpeed", "Control.ASV.Differential.HeadingAndSpeed"],
        "Course & Speed Controller",
        "Always",
    )
    .doc("Keeps course and speed with two motors, by propeller speed.")
    .groups(&[
        OF_EVERY_TASK,
        OF_EVERY_SPEED,
        &[
            MAXIMUM_DIFFERENTIAL.spec,
            HARDWARE_RPM.spec,
            RPM_AT_MAXIMUM.spec,
            RPM_GAINS.spec,
            RPM_FEEDFORWARD.spec,
            RPM_INTEGRAL_LIMIT.spec,
            SPEED_GAINS.spec,
            SPEED_INTEGRAL_LIMIT.spec,
            SPEED_FEEDFORWARD.spec,
            MINIMUM_RPM.spec,
            MAXIMUM_RPM.spec,
            MAXIMUM_RPM_ACCELERATION.spec,
            YAW_GAINS.spec,
            YAW_INTEGRAL_LIMIT.spec,
        ],
    ]);
}

pub mod course_speed_force {
    use super::{OF_EVERY_SPEED, OF_EVERY_TASK, Param, SectionSpec, Unit, float, floats};

    pub const SPEED_GAINS: Param<Vec<f64>> =
        floats("MPS Force PID Gains", &[80.0, 40.0, 0.0], Unit::NewtonPerMetrePerSecond)
            .of_length(3)
            .within(0.0, 1e5)
            .doc("Gains P, I, D from speed to the common force of both motors, tuned on the hull's model.");
    pub const SPEED_INTEGRAL_LIMIT: Param<f64> = float("MPS Force Integral Limit", 240.0, Unit::Newton)
        .within(-1.0, 10_000.0)
        .doc("Greatest integral part of the speed PID; -1 does not limit it.");
    pub const SPEED_FEEDFORWARD: Param<f64> =
        float("MPS Force Feedforward Gain", 0.0, Unit::NewtonPerMetrePerSecond)
            .within(0.0, 10_000.0)
            .doc("Force for each wanted m/s, added to the speed PID.");
    pub const YAW_GAINS: Param<Vec<f64>> = floats(
        "Yaw PID Gains",
        &[225.0, 10.0, 180.0],
        Unit::NewtonPerRadian,
    )
    .of_length(3)
    .within(0.0, 1e5)
    .doc(
        "Gains P, I, D from heading error to the force difference, tuned on the hull's model. `lutra-agent \
                 check` tells of ones that oscillate there.",
    );
    pub const MINIMUM_FORCE: Param<f64> = float("Minimum Force Limit", -135.0, Unit::Newton)
        .within(-1000.0, 0.0)
        .doc("Least force of a motor, astern being negative; the Otters use -30.");
    pub const MAXIMUM_FORCE: Param<f64> = float("Maximum Force Limit", 239.364, Unit::Newton)
        .within(0.0, 1000.0)
        .doc("Greatest force of a motor.");
    pub const MINIMUM_COURSE_SPEED: Param<f64> =
        float("Minimum speed to use course", -1.0, Unit::MetrePerSecond).within(-1.0, 5.0).doc(
            "Above this speed the course is kept rather than the heading; below 0.05 always the heading.",
        );

    pub static COURSE_SPEED_FORCE: SectionSpec =
        SectionSpec::task(&["Control.ASV.HeadingAndSpeedForce"], "Direction & Speed Controller", "Never")
            .doc("Keeps course and speed with two motors, by force.")
            .groups(&[
                OF_EVERY_TASK,
                OF_EVERY_SPEED,
                &[
                    SPEED_GAINS.spec,
                    SPEED_INTEGRAL_LIMIT.spec,
                    SPEED_FEEDFORWARD.spec,
                    YAW_GAINS.spec,
                    MINIMUM_FORCE.spec,
                    MAXIMUM_FORCE.spec,
                    MINIMUM_COURSE_SPEED.spec,
                ],
            ]);
}

pub mod remote {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, choice, execution_frequency, float, int};

    pub const FREQUENCY: Param<f64> = execution_frequency(10.0);
    pub const CONNECTION_TIMEOUT: Param<f64> = float("Connection Timeout", 1.0, Unit::Second)
        .within(0.2, 10.0)
        .doc("Without a stick value for so long the motors stop; the Otters use 2 s.");
    pub const LONGEST_AGE: Param<f64> = float("Maximum Command Age", 1.0, Unit::Second)
        .within(0.2, 5.0)
        .doc("Lutra: keys that took so much longer than the fastest packet of their sender have no effect.");
    pub const THRUST_SCALE: Param<f64> =
        float("Thrust Scale", 1.0, Unit::Actuation).within(0.01, 1.0).doc("Actuation at full stick.");
    pub const RC_MODE: Param<i64> = int("RC mode", 0, Unit::None)
        .within(0, 4)
        .doc("How sticks become thrust: 0 normal, 1 force made linear, 2 skewed, 3 autopilot, 4 reserved.");
    pub const SKEW: Param<f64> = float("Skewed Motor Force Factor", 1.0, Unit::None)
        .within(0.0, 10.0)
        .doc("Mode 2: the outer motor gains this share of what the inner one loses in a turn.");
    pub const AUTOPILOT_SPEED: Param<f64> = float("Autopilot Max Speed", 2.3, Unit::MetrePerSecond)
        .within(0.1, 10.0)
        .doc("Mode 3: speed at full throttle.");
    pub const AUTOPILOT_YAW: Param<f64> = float("Autopuilot Max Yaw", 180.0, Unit::Degree)
        .within(1.0, 180.0)
        .doc("Mode 3: turn at full deflection. The name is spelled as NTNU's task has it.");
    pub const SPEED_STEP: Param<f64> = float("Speed step", 0.05, Unit::Actuation).within(0.005, 0.5).doc(
        "What Accelerate and Decelerate change in a tenth of a second, however many messages come in it.",
    );
    pub const YAW_STEP: Param<f64> = float("Yaw step", 30.0, Unit::Degree)
        .within(1.0, 180.0)
        .doc("What each press of Left and Right changes.");
    pub const MIXING: Param<&str> = choice("Mixing", "additive", &["additive", "proportional"])
        .doc("Lutra: additive turns on the spot (speed +- heading); proportional is speed (1 +- 2 heading).");

    pub static REMOTE: SectionSpec = SectionSpec::task(
        &["Control.ASV.RemoteOperation", "Control.ASV.RemoteOperationOtter"],
        "Remote Control",
        "Always",
    )
    .doc("Manual control from a console.")
    .groups(&[
        OF_EVERY_TASK,
        &[
            FREQUENCY.spec,
            CONNECTION_TIMEOUT.spec,
            LONGEST_AGE.spec,
            THRUST_SCALE.spec,
            RC_MODE.spec,
            SKEW.spec,
            AUTOPILOT_SPEED.spec,
            AUTOPILOT_YAW.spec,
            SPEED_STEP.spec,
            YAW_STEP.spec,
            MIXING.spec,
        ],
    ]);
}
