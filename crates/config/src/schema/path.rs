//! Path controllers: what they share and what each has of its own.

#![expect(missing_docs, reason = "each parameter carries its documentation as a value")]

use crate::schema::common::OF_EVERY_TASK;
use crate::spec::{Param, ParamSpec, SectionSpec, Unit, flag, float, unused};

pub const CONTROL_FREQUENCY: Param<f64> = float("Control Frequency", 10.0, Unit::Hertz)
    .within(0.1, 100.0)
    .doc("Steps per second at most; never more than navigation gives.");
pub const COURSE_CONTROL: Param<bool> = flag("Course Control", true)
    .doc("Whether the course over ground follows the path rather than the heading.");
pub const MAXIMUM_TRACK_LENGTH: Param<f64> =
    float("Maximum Track Length", 25_000.0, Unit::Metre).within(1.0, 1e6).doc("A longer leg is an error.");
pub const STATE_REPORT_FREQUENCY: Param<f64> = float("State Report Frequency", 1.0, Unit::Hertz)
    .within(0.1, 10.0)
    .doc("How often the state on the path is reported.");
pub const ALONG_MONITOR: Param<bool> =
    flag("Along-track -- Monitor", true).doc("Whether too little progress along the track is an error.");
pub const ALONG_PERIOD: Param<f64> = float("Along-track -- Check Period", 15.0, Unit::Second)
    .within(1.0, 600.0)
    .doc("Progress is checked this often; two failures in a row are an error.");
pub const ALONG_SPEED: Param<f64> = float("Along-track -- Minimum Speed", 0.25, Unit::MetrePerSecond)
    .within(0.0, 10.0)
    .doc("The least progress along the track that is enough.");
pub const ALONG_YAW: Param<f64> = float("Along-track -- Minimum Yaw", 10.0, Unit::DegreePerSecond)
    .within(0.0, 180.0)
    .doc("The least decrease of the course error that is enough while the vessel turns.");
pub const CROSS_MONITOR: Param<bool> =
    flag("Cross-track -- Monitor", true).doc("Whether too large a distance from the track is an error.");
pub const CROSS_UNCERTAINTY: Param<f64> = float("Cross-track -- Nav. Unc. Factor", -1.0, Unit::None)
    .within(-1.0, 100.0)
    .doc("Widens the limit by so many standard deviations of the position; -1 does not.");
pub const CROSS_DISTANCE: Param<f64> = float("Cross-track -- Distance Limit", 15.0, Unit::Metre)
    .within(0.1, 10_000.0)
    .doc("Distance from the track beyond which the time limit runs.");
pub const CROSS_TIME: Param<f64> = float("Cross-track -- Time Limit", 10.0, Unit::Second)
    .within(0.1, 600.0)
    .doc("So long beyond the distance limit is an error.");
pub const JUMP_THRESHOLD: Param<f64> = float("Position Jump Threshold", 7.0, Unit::Metre)
    .within(0.5, 1000.0)
    .doc("Two positions farther apart than this are a jump, which holds the monitors off.");
pub const JUMP_TIME_FACTOR: Param<f64> = float("Position Jump Time Factor", 0.3, Unit::MetrePerSecond)
    .within(0.01, 100.0)
    .doc("The monitors are off for the jump's length divided by this, at most 100 s.");
pub const ETA_MINIMUM_SPEED: Param<f64> = float("ETA Minimum Speed", 1.0, Unit::MetrePerSecond)
    .within(0.05, 5.0)
    .doc("The least speed assumed when the time to arrival is worked out.");
pub const NEW_REFERENCE_TIMEOUT: Param<f64> = float("New Reference Timeout", 5.0, Unit::Second)
    .within(3.0, 10.0)
    .doc("At the end of a path without a new one for so long is an error.");
pub const RADIUS_TO_ENDPOINT: Param<f64> = float("Radius To Endpoint", -1.0, Unit::Metre)
    .within(-1.0, 1000.0)
    .doc("The end is reached within this distance; -1 decides by the time to arrival.");

const OF_EVERY_PATH: &[ParamSpec] = &[
    CONTROL_FREQUENCY.spec,
    COURSE_CONTROL.spec,
    MAXIMUM_TRACK_LENGTH.spec,
    STATE_REPORT_FREQUENCY.spec,
    ALONG_MONITOR.spec,
    ALONG_PERIOD.spec,
    ALONG_SPEED.spec,
    ALONG_YAW.spec,
    CROSS_MONITOR.spec,
    CROSS_UNCERTAINTY.spec,
    CROSS_DISTANCE.spec,
    CROSS_TIME.spec,
    JUMP_THRESHOLD.spec,
    JUMP_TIME_FACTOR.spec,
    ETA_MINIMUM_SPEED.spec,
    NEW_REFERENCE_TIMEOUT.spec,
    RADIUS_TO_ENDPOINT.spec,
    unused("Bottom Track -- Enabled", "a surface vessel does not follow the bottom"),
];

pub const CORRIDOR_WIDTH: Param<f64> = float("Corridor -- Width", 5.0, Unit::Metre)
    .within(1.0, 50.0)
    .doc("Half width of the corridor around the track.");
pub const ENTRY_ANGLE: Param<f64> = float("Corridor -- Entry Angle", 15.0, Unit::Degree)
    .within(2.0, 45.0)
    .doc("Angle to the track at the corridor's border.");

pub mod ilos {
    use super::{
        CORRIDOR_WIDTH, ENTRY_ANGLE, OF_EVERY_PATH, OF_EVERY_TASK, Param, SectionSpec, Unit, flag, float,
    };

    pub const LOOKAHEAD: Param<f64> = float("ILOS Lookahead Distance", 10.0, Unit::Metre)
        .within(1.0, 50.0)
        .doc("Distance ahead along the track that is aimed at.");
    pub const INTEGRATOR_GAIN: Param<f64> = float("ILOS Integrator Gain", 0.0, Unit::None)
        .within(0.0, 4.0)
        .doc("Gain of the integral that takes a steady cross-track error away; the Otters use 0.5.");
    pub const INTEGRATOR_INITIAL: Param<f64> = float("ILOS Integrator Initial Value", 0.0, Unit::Metre)
        .within(0.0, 10.0)
        .doc("The integral at the start.");
    pub const OUT_VECTOR_FIELD: Param<bool> = flag("Corridor -- Out Vector Field", false)
        .doc("Whether a vector field leads back into the corridor; the Otters use it.");
    pub const OUT_LINE_OF_SIGHT: Param<bool> =
        flag("Corridor -- Out LOS", false).doc("Whether plain line of sight leads back into the corridor.");
    pub const CORRIDOR_LOITER: Param<f64> = float("Corridor -- Loiter", 5.0, Unit::Metre)
        .within(0.1, 100.0)
        .doc("A circle is reached within this distance of it.");

    pub static ILOS: SectionSpec =
        SectionSpec::task(&["Control.Path.ILOS", "Control.Path.ILOSOtter"], "Path Control", "Always")
            .doc("Follows paths by integral line of sight.")
            .groups(&[
                OF_EVERY_TASK,
                OF_EVERY_PATH,
                &[
                    CORRIDOR_WIDTH.spec,
                    ENTRY_ANGLE.spec,
                    OUT_VECTOR_FIELD.spec,
                    OUT_LINE_OF_SIGHT.spec,
                    CORRIDOR_LOITER.spec,
                    LOOKAHEAD.spec,
                    INTEGRATOR_GAIN.spec,
                    INTEGRATOR_INITIAL.spec,
                ],
            ]);
}

pub static PURE_PURSUIT: SectionSpec =
    SectionSpec::task(&["Control.Path.PurePursuit"], "Path Control", "Never")
        .doc("Steers straight at the end of the path.")
        .groups(&[OF_EVERY_TASK, OF_EVERY_PATH]);

pub mod vector_field {
    use super::{
        CORRIDOR_WIDTH, ENTRY_ANGLE, OF_EVERY_PATH, OF_EVERY_TASK, Param, SectionSpec, Unit, flag, float,
    };

    pub const EXTENDED: Param<bool> =
        flag("Extended Control -- Enabled", false).doc("Whether the law is refined inside the corridor.");
    pub const EXTENDED_GAIN: Param<f64> = float("Extended Control -- Controller Gain", 1.0, Unit::None)
        .within(1.0, 10.0)
        .doc("Exponent of the refined law.");
    pub const EXTENDED_TURN_GAIN: Param<f64> = float("Extended Control -- Turn Rate Gain", 1.0, Unit::None)
        .within(0.1, 10.0)
        .doc("Turn-rate gain of the refined law.");

    pub static VECTOR_FIELD: SectionSpec =
        SectionSpec::task(&["Control.Path.VectorField"], "Path Control", "Never")
            .doc("Follows paths by a vector field.")
            .groups(&[
                OF_EVERY_TASK,
                OF_EVERY_PATH,
                &[
                    CORRIDOR_WIDTH.spec,
                    ENTRY_ANGLE.spec,
                    EXTENDED.spec,
                    EXTENDED_GAIN.spec,
                    EXTENDED_TURN_GAIN.spec,
                ],
            ]);
}
