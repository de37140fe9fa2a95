//! Plain data: the vessel, addresses, profiles and the hull models of the simulator.

#![expect(missing_docs, reason = "each parameter carries its documentation as a value")]

use crate::schema::common::DIGITS;
use crate::spec::{Form, Kind, Param, ParamSpec, SectionSpec, Unit, flag, float, floats, int, text, unused};

pub const VEHICLE: Param<String> =
    text("Vehicle", "").doc("The vessel's name; its address stands under it in [IMC Addresses].");

pub const VEHICLE_TYPE: Param<String> = text("Vehicle Type", "ASV")
    .doc("Picks the section VSIM/Model/<type>, capital and small letters being different.");

pub const CONVERSION_ACTUATION: Param<Vec<f64>> = floats(
    "Speed Conversion -- Actuation",
    &[0.0, 0.1, 0.2, 0.3, 0.4, 0.5, 0.6, 0.7, 0.8, 0.9, 1.0],
    Unit::Actuation,
)
.within(0.0, 1.0)
.doc("Actuations for which the next two tables hold.");

pub const CONVERSION_RPM: Param<Vec<f64>> = floats(
    "Speed Conversion -- RPM",
    &[0.0, 120.0, 240.0, 360.0, 480.0, 610.0, 726.0, 845.0, 960.0, 980.0, 980.0],
    Unit::Rpm,
)
.within(0.0, 10_000.0)
.doc("Propeller speed at each actuation, as measured on the Otters.");

pub const CONVERSION_MPS: Param<Vec<f64>> = floats(
    "Speed Conversion -- MPS",
    &[0.0, 0.34, 0.66, 1.0, 1.36, 1.57, 1.75, 2.05, 2.4, 2.4, 2.4],
    Unit::MetrePerSecond,
)
.within(0.0, 20.0)
.doc("Speed through water at each actuation, as measured on the Otters.");

pub const MAXIMUM_DEPTH: Param<f64> = float("Absolute Maximum Depth", 0.0, Unit::Metre)
    .within(0.0, 11_000.0)
    .doc("Plans that go deeper are refused; 0 for a vessel on the surface.");

pub const TIME_OF_ARRIVAL_FACTOR: Param<f64> = float("Time Of Arrival Factor", 6.0, Unit::Second)
    .within(0.0, 60.0)
    .doc("A waypoint counts as reached this long before the vessel would be there.");

pub const BATTERY_PACKS: Param<i64> =
    int("Battery Packs", 4, Unit::None).within(1, 16).doc("Batteries on board.");

pub const BATTERY_CAPACITY: Param<f64> = float("Battery Capacity", 3660.0, Unit::WattHour)
    .within(1.0, 1e6)
    .doc("Energy of all batteries when full: 4 of 915 Wh on the Otters.");

pub const CPU_MAXIMUM: Param<f64> = float("CPU Usage - Maximum", 65.0, Unit::Percent)
    .within(1.0, 100.0)
    .doc("Average processor use above which the daemon reports an error, which stops missions.");

pub const CPU_SAMPLES: Param<i64> = int("CPU Usage - Moving Average Samples", 10, Unit::None)
    .within(1, 3600)
    .doc("Samples, one a second, over which processor use is averaged.");

pub const RECOVERY_PLAN: Param<String> =
    text("Recovery Plan", "dislodge").doc("Plan that only the vessel itself may start.");

pub static GENERAL: SectionSpec =
    SectionSpec::data(&["General"], Form::Data).doc("What concerns the whole vessel.").groups(&[&[
        VEHICLE.spec,
        VEHICLE_TYPE.spec,
        CONVERSION_ACTUATION.spec,
        CONVERSION_RPM.spec,
        CONVERSION_MPS.spec,
        MAXIMUM_DEPTH.spec,
        TIME_OF_ARRIVAL_FACTOR.spec,
        BATTERY_PACKS.spec,
        BATTERY_CAPACITY.spec,
        CPU_MAXIMUM.spec,
        CPU_SAMPLES.spec,
        RECOVERY_PLAN.spec,
        unused("Underwater Depth Threshold", "a surface vessel does not dive"),
    ]]);

const ANY_ADDRESS: ParamSpec =
    int("address", 0xffff, Unit::None).within(0, 0xffff).doc("IMC address of the system of this name.").spec;

pub static IMC_ADDRESSES: SectionSpec =
    SectionSpec::data(&["IMC Addresses"], Form::OpenData(ANY_ADDRESS)).doc("IMC addresses by system name.");

const ANY_PROFILE: ParamSpec = text("description", "").doc("What the profile is for.").spec;

pub static PROFILES: SectionSpec = SectionSpec::data(&["Profiles"], Form::OpenData(ANY_PROFILE))
    .doc("Profiles besides Hardware, Simulation and Hardware/Simulation.");

/// The hull of DUNE's own simulator. Lutra's simulator has Fossen's Otter model instead and takes from here
/// only what that model lacks; the values are checked so that the files stay good for DUNE.
pub mod hull {
    use super::{
        DIGITS, Form, Kind, Param, ParamSpec, SectionSpec, Unit, flag, float, floats, int, text, unused,
    };

    pub const TYPE: Param<String> = text("Type", "ASV").doc("Sort of vehicle.");
    pub const MASS: Param<f64> = float("Mass", 80.0, Unit::Kilogram)
        .within(0.1, 1e6)
        .doc("Mass with payload: the Otter's hull has 55 kg.");
    pub const BUOYANCY: Param<Vec<f64>> = floats("Buoyancy", &[0.0, 0.0, -0.017], Unit::Metre)
        .of_length(3)
        .doc("Centre of buoyancy, forward, starboard, down.");
    pub const VOLUME: Param<Vec<f64>> = floats("Volume", &[2.0, 1.08, 0.5], Unit::Metre)
        .of_length(3)
        .within(0.0, 1000.0)
        .doc("Length, width and height of the hull.");
    pub const INERTIA: Param<Vec<f64>> =
        floats("Inertial Matrix", &[60.0, 400.0, 1000.0, 1.0, 1.0, 1.0], Unit::None)
            .of_length(6)
            .within(0.0, f64::MAX)
            .doc("Inertia in surge, sway, heave (kg), roll, pitch, yaw (kg m^2).");
    pub const LINEAR_DRAG: Param<Vec<f64>> = floats(
        "Linear Drag Coefficients",
        &[-77.55, 0.0, 0.0, 0.0, 0.0, -40.04, 0.0, 0.0, 0.0, 0.0],
        Unit::None,
    )
    .of_length(10)
    .doc("Must be negative to brake: (1,1) to (6,6), then (2,6), (3,5), (5,3), (6,2).");
    pub const QUADRATIC_DRAG: Param<Vec<f64>> = floats(
        "Quadratic Drag Coefficients",
        &[-0.0165, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 0.0],
        Unit::None,
    )
    .of_length(10)
    .doc("As the linear ones, for the square of the speed.");
    pub const FIN_COUNT: Param<i64> = int("Fin Count", 0, Unit::None).within(0, 10).doc("Fins.");
    pub const ENGINE_COUNT: Param<i64> = int("Engine Count", 2, Unit::None).within(0, 10).doc("Thrusters.");
    pub const ENGINE_PARAMETERS: Param<Vec<f64>> = floats("Engine Parameters {}", &[], Unit::None)
        .each(DIGITS)
        .of_length(3)
        .doc("Thruster coefficients (a, b, c): force (a n - b U)|n| at n = actuation c/60.");
    pub const ENGINE_POSITION: Param<Vec<f64>> = floats("Engine Position {}", &[], Unit::Metre)
        .each(DIGITS)
        .of_length(3)
        .doc("Where the thruster is: forward, starboard, down.");
    pub const ENGINE_ORIENTATION: Param<Vec<f64>> = floats("Engine Orientation {}", &[], Unit::None)
        .each(DIGITS)
        .of_length(2)
        .doc("Where it pushes to, in the horizontal and in the vertical plane (rad).");
    pub const ENGINE_MAX_FORCE: Param<f64> = float("Engine Max Force", 119.7, Unit::Newton)
        .within(0.0, 1e6)
        .doc("Greatest thrust of one thruster.");
    pub const INTEGRATION: Param<bool> = flag("Integration Method", true)
        .doc("False leaves the dynamics out: speed is force through inertia.");
    pub const GRAVITY: Param<Vec<f64>> =
        floats("Gravity", &[0.0, 0.0, 9.82], Unit::MetrePerSecondSquared).of_length(3).doc("Gravity.");

    const fn each_fin(name: &'static str) -> ParamSpec {
        ParamSpec { name, each: DIGITS, kind: Kind::Unused, unit: Unit::None, doc: "the Otter has no fins" }
    }

    pub static MODEL: SectionSpec = SectionSpec::data(&["VSIM/Model/"], Form::DataFor { example: "ASV" })
        .doc("A hull for DUNE's simulator; General/Vehicle Type picks the one.")
        .groups(&[&[
            TYPE.spec,
            MASS.spec,
            BUOYANCY.spec,
            VOLUME.spec,
            INERTIA.spec,
            LINEAR_DRAG.spec,
            QUADRATIC_DRAG.spec,
            FIN_COUNT.spec,
            ENGINE_COUNT.spec,
            ENGINE_PARAMETERS.spec,
            ENGINE_POSITION.spec,
            ENGINE_ORIENTATION.spec,
            ENGINE_MAX_FORCE.spec,
            INTEGRATION.spec,
            GRAVITY.spec,
            unused("Added Mass Coefficients", "the model of this simulator has none for a surface vessel"),
            unused("Body Lift Coefficients", "the Otter has no lifting body"),
            each_fin("Fin Force {}"),
            each_fin("Fin Position {}"),
        ]]);
}
