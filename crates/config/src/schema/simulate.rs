//! Simulated sensors and motors.

#![expect(missing_docs, reason = "each parameter carries its documentation as a value")]

use crate::schema::common::{OF_EVERY_TASK, execution_frequency};
use crate::spec::{Param, SectionSpec, Unit, choice, flag, float, floats, int, text};

pub mod hull {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, execution_frequency, float, text};

    pub const FREQUENCY: Param<f64> = execution_frequency(25.0);
    pub const STREAM_SOURCE: Param<String> =
        text("Entity Label - Stream Velocity Source", "Stream Velocity Simulator")
            .doc("Entity whose current acts on the vessel.");
    pub const PAYLOAD: Param<f64> =
        float("Payload", 25.0, Unit::Kilogram).within(0.0, 45.0).doc("Lutra: load on the hull of 55 kg.");

    pub static HULL: SectionSpec = SectionSpec::task(&["Simulators.VSIM"], "Simulation Engine", "Simulation")
        .doc("Moves the simulated vessel.")
        .groups(&[OF_EVERY_TASK, &[FREQUENCY.spec, STREAM_SOURCE.spec, PAYLOAD.spec]]);
}

pub mod current {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, choice, execution_frequency, float};

    pub const FREQUENCY: Param<f64> = execution_frequency(1.0);
    pub const NORTH: Param<f64> = float("Default Speed North", 0.0, Unit::MetrePerSecond)
        .within(-5.0, 5.0)
        .doc("Speed of the water towards north.");
    pub const EAST: Param<f64> = float("Default Speed East", 0.0, Unit::MetrePerSecond)
        .within(-5.0, 5.0)
        .doc("Speed of the water towards east.");
    pub const DOWN: Param<f64> = float("Default Speed Down", 0.0, Unit::MetrePerSecond)
        .within(-5.0, 5.0)
        .doc("Speed of the water downwards; without effect on a surface vessel.");
    pub const SOURCE: Param<&str> =
        choice("Stream Velocity Source", "Constant", &["Constant"]).doc("Where the current comes from.");

    pub static CURRENT: SectionSpec =
        SectionSpec::task(&["Simulators.StreamVelocity"], "Stream Velocity Simulator", "Simulation")
            .doc("A steady current.")
            .groups(&[OF_EVERY_TASK, &[FREQUENCY.spec, NORTH.spec, EAST.spec, DOWN.spec, SOURCE.spec]]);
}

pub mod gps {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, execution_frequency, flag, float, floats, int};

    pub const FREQUENCY: Param<f64> = execution_frequency(5.0);
    pub const SATELLITES: Param<i64> =
        int("Number of Satellites", 8, Unit::None).within(0, 50).doc("Satellites reported.");
    pub const HACC: Param<f64> =
        float("HACC", 2.0, Unit::Metre).within(0.0, 1000.0).doc("Horizontal accuracy reported.");
    pub const HDOP: Param<f64> = float("HDOP", 0.9, Unit::None).within(0.0, 100.0).doc("Quality reported.");
    pub const ACTIVATION_DEPTH: Param<f64> = float("Activation Depth", 0.2, Unit::Metre)
        .within(0.0, 100.0)
        .doc("Deeper than this there is no position.");
    pub const REPORT_GROUND_VELOCITY: Param<bool> =
        flag("Report Ground Velocity", false).doc("Whether the speed over ground is reported besides.");
    pub const REPORT_YAW: Param<bool> =
        flag("Report Yaw", true).doc("Whether it is a compass too. DUNE's default is false.");
    pub const INITIAL_POSITION: Param<Vec<f64>> =
        floats("Initial Position", &[63.33, 10.083_333], Unit::Degree)
            .of_length(2)
            .within(-180.0, 180.0)
            .doc("Where the vessel starts: latitude, longitude.");
    pub const POSITION_NOISE: Param<f64> = float("Position Noise", 0.0, Unit::Metre)
        .within(0.0, 100.0)
        .doc("Lutra: standard deviation of each coordinate.");

    pub static GPS: SectionSpec = SectionSpec::task(&["Simulators.GPS"], "GPS", "Simulation")
        .doc("A simulated satellite compass.")
        .groups(&[
            OF_EVERY_TASK,
            &[
                FREQUENCY.spec,
                SATELLITES.spec,
                HACC.spec,
                HDOP.spec,
                ACTIVATION_DEPTH.spec,
                REPORT_GROUND_VELOCITY.spec,
                REPORT_YAW.spec,
                INITIAL_POSITION.spec,
                POSITION_NOISE.spec,
            ],
        ]);
}

pub mod motor {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, execution_frequency, floats, int};

    pub const FREQUENCY: Param<f64> = execution_frequency(20.0);
    pub const THRUSTER_ID: Param<i64> =
        int("Thruster Id", 0, Unit::None).within(0, 1).doc("0 is port, 1 is starboard.");
    pub const ACT_TO_RPM: Param<Vec<f64>> = floats("Thruster Act to RPM Factor", &[50.0, 1100.0], Unit::Rpm)
        .of_length(2)
        .within(0.0, 10_000.0)
        .doc("Propeller speed a sign(actuation) + b actuation.");

    pub static MOTOR: SectionSpec = SectionSpec::task(&["Simulators.Motor"], "Motor 0", "Simulation")
        .doc("A simulated motor; one instance for each side.")
        .groups(&[OF_EVERY_TASK, &[FREQUENCY.spec, THRUSTER_ID.spec, ACT_TO_RPM.spec]]);
}

pub mod fish {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, float, floats, int};

    pub const TAG: Param<i64> = int("Tag Number", 1, Unit::None)
        .within(0, 0xFFFF_FFFF)
        .doc("Lutra: what its tag says; fish with different numbers swim differently.");
    pub const BEGINNING: Param<i64> = int("Beginning", 0, Unit::Second).within(0, 4_102_444_800).doc(
        "Lutra: since when it swims, counted from 1970, at most a year before the vessel starts; 0 for the \
             vessel's own start. Vessels whose files say the same of a fish hear the same fish.",
    );
    pub const CENTRE: Param<Vec<f64>> = floats("Area -- Centre", &[63.33, 10.083_333], Unit::Degree)
        .of_length(2)
        .within(-180.0, 180.0)
        .doc("Lutra: around where it swims: latitude, longitude.");
    pub const RADIUS: Param<f64> = float("Area -- Radius", 300.0, Unit::Metre)
        .within(1.0, 100_000.0)
        .doc("Lutra: how far from there it turns back.");
    pub const SPEED: Param<f64> =
        float("Mean Speed", 0.4, Unit::MetrePerSecond).within(0.0, 5.0).doc("Lutra: how fast it swims.");
    pub const DEPTH: Param<f64> =
        float("Mean Depth", 10.0, Unit::Metre).within(0.0, 1000.0).doc("Lutra: how deep it swims.");
    pub const INTERVAL: Param<Vec<f64>> = floats("Tag Interval", &[30.0, 90.0], Unit::Second)
        .of_length(2)
        .within(1.0, 86_400.0)
        .doc("Lutra: shortest and longest time between transmissions, in whole seconds.");

    pub static FISH: SectionSpec = SectionSpec::task(&["Simulators.Fish"], "Tagged Fish", "Never")
        .doc(
            "Lutra: a simulated fish with an acoustic tag that the simulated hydrophone hears; further fish in \
             sections Simulators.Fish/NAME.",
        )
        .groups(&[
            OF_EVERY_TASK,
            &[
                TAG.spec,
                BEGINNING.spec,
                CENTRE.spec,
                RADIUS.spec,
                SPEED.spec,
                DEPTH.spec,
                INTERVAL.spec,
            ],
        ]);
}
