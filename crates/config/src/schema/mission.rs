//! Navigation, plans and maneuvers.

#![expect(missing_docs, reason = "each parameter carries its documentation as a value")]

use crate::schema::common::OF_EVERY_TASK;
use crate::spec::{Kind, Param, ParamSpec, SectionSpec, Unit, choice, flag, float, int, text, texts, unused};

pub mod navigation {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, flag, float, text};

    pub const GPS: Param<String> = text("Entity Label - GPS", "GPS").doc("Entity whose positions are used.");
    pub const IMU: Param<String> =
        text("Entity Label - IMU", "GPS").doc("Entity whose roll, pitch and rates are used.");
    pub const YAW: Param<String> = text("Entity Label - Yaw", "GPS").doc("Entity whose heading is used.");
    pub const GPS_HAS_IMU: Param<bool> =
        flag("GPS has IMU", true).doc("Whether the GPS entity gives roll and pitch.");
    pub const GPS_HAS_YAW: Param<bool> = flag("GPS has Yaw", true)
        .doc("Whether the GPS entity is a compass; if not, its heading would be the course over ground.");
    pub const MAXIMUM_HDOP: Param<f64> = float("Maximum HDOP", 5.0, Unit::None)
        .within(0.5, 100.0)
        .doc("Positions of worse quality are rejected.");
    pub const ASSUMED_HDOP: Param<f64> = float("Assumed HDOP", 2.0, Unit::None)
        .within(0.5, 100.0)
        .doc("Lutra: taken for positions whose quality the receiver does not tell.");
    pub const FIX_TIMEOUT: Param<f64> = float("GPS Timeout", 5.0, Unit::Second)
        .within(0.5, 600.0)
        .doc("Without a good position for so long navigation is in error.");
    pub const ORIGIN_DISTANCE: Param<f64> = float("Distance To Reset Origin", 1000.0, Unit::Metre)
        .within(500.0, 100_000.0)
        .doc("Farther than this from the origin of the local frame a new origin is taken.");
    pub const JUMP_SPEED: Param<f64> = float("Position Jump Speed", 10.0, Unit::MetrePerSecond)
        .within(1.0, 100.0)
        .doc("Lutra: two positions that would need a higher speed are a jump.");
    pub const DEAD_RECKONING: Param<f64> = float("Dead Reckoning Time", 5.0, Unit::Second)
        .within(1.0, 60.0)
        .doc(
            "Lutra: gaps in positions and heading up to this long are bridged; then the motors stop and a plan waits.",
        );
    pub const RECKONING_UNCERTAINTY: Param<f64> =
        float("Dead Reckoning Uncertainty", 15.0, Unit::Metre).within(1.0, 1000.0).doc(
            "Lutra: a gap ends earlier when the position is more uncertain than this, as standard deviation.",
        );
    pub const RECKONING_SPEED: Param<f64> = float("Dead Reckoning Speed", 0.8, Unit::MetrePerSecond)
        .within(0.1, 20.0)
        .doc("Lutra: greatest speed on a path while positions are missing.");
    pub const RECKONING_DRIFT: Param<f64> = float("Dead Reckoning Drift", 0.4, Unit::MetrePerSecond)
        .within(0.05, 5.0)
        .doc("Lutra: so fast the position becomes uncertain without positions, by wind and current.");
    pub const RECKONING_ERROR: Param<f64> = float("Dead Reckoning Speed Error", 50.0, Unit::Percent)
        .within(0.0, 100.0)
        .doc("Lutra: and by this share of the speed, which nothing measures then.");
    pub const RECOVERY_TIME: Param<f64> = float("Position Recovery Time", 3.0, Unit::Second)
        .within(0.0, 60.0)
        .doc("Lutra: positions must have been good for so long before a plan that waited goes on.");

    pub static NAVIGATION: SectionSpec = SectionSpec::task(
        &["Navigation.General.GPSNavigation", "Navigation.General.GPSNavigationOtter"],
        "Navigation",
        "Always",
    )
    .doc("From satellite positions and compass to the vessel's state.")
    .groups(&[
        OF_EVERY_TASK,
        &[
            GPS.spec,
            IMU.spec,
            YAW.spec,
            GPS_HAS_IMU.spec,
            GPS_HAS_YAW.spec,
            MAXIMUM_HDOP.spec,
            ASSUMED_HDOP.spec,
            FIX_TIMEOUT.spec,
            ORIGIN_DISTANCE.spec,
            JUMP_SPEED.spec,
            DEAD_RECKONING.spec,
            RECKONING_UNCERTAINTY.spec,
            RECKONING_SPEED.spec,
            RECKONING_DRIFT.spec,
            RECKONING_ERROR.spec,
            RECOVERY_TIME.spec,
        ],
    ]);
}

pub mod plan {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, choice, flag, float, int, text, unused};

    pub const COMPUTE_PROGRESS: Param<bool> =
        flag("Compute Progress", false).doc("Whether the share of the plan that is done is reported.");
    pub const FUEL_PREDICTION: Param<bool> =
        flag("Fuel Prediction", false).doc("Whether the energy a plan needs is worked out.");
    pub const REPORT_FREQUENCY: Param<f64> = float("State Report Frequency", 3.0, Unit::Hertz)
        .within(0.1, 10.0)
        .doc("How often the engine's state is reported.");
    pub const MINIMUM_CALIBRATION: Param<i64> = int("Minimum Calibration Time", 10, Unit::Second)
        .within(0, 600)
        .doc("Least duration of a calibration before a plan.");
    pub const CALIBRATE: Param<bool> = flag("Perform Calibration", false)
        .doc("Whether a plan started with the calibrate flag is calibrated for.");
    pub const ABORT_ON_FAILED_ACTIVATION: Param<bool> = flag("Abort On Failed Activation", false)
        .doc("Whether a plan fails when a payload that it switches on does not start.");
    pub const VEHICLE_TIMEOUT: Param<f64> = float("Vehicle Reply Timeout", 2.5, Unit::Second)
        .within(0.5, 60.0)
        .doc("Lutra: the vehicle supervisor must answer within this time; fixed in DUNE.");

    pub const POSITION_GAP: Param<f64> = float("Position Gap Limit", 120.0, Unit::Second)
        .within(0.0, 3600.0)
        .doc("Lutra: a plan without a position waits for so long, motors stopped, before it fails; 0 fails at once.");
    pub const TRACK_RECOVERY: Param<f64> = float("Track Recovery Time", 120.0, Unit::Second)
        .within(0.0, 3600.0)
        .doc("Lutra: a vessel too far from its track steers back for so long before the plan fails; 0 fails at once.");
    pub const AFTER_FAILURE: Param<&str> = choice("Action After Failure", "hold", &["hold", "drift"])
        .doc("Lutra: what to do after a plan that failed under way.");
    pub const AFTER_RESTART: Param<&str> =
        choice("Action After Restart", "hold", &["hold", "resume", "return", "drift"]).doc(
            "Lutra: what to do when the program restarts after it ended under way; resume holds until the count-down.",
        );
    pub const COUNTDOWN: Param<f64> = float("Resume Countdown", 30.0, Unit::Second)
        .within(0.0, 600.0)
        .doc("Lutra: the plan resumes so long after the hold began, unless an operator stops it or starts another.");
    pub const RESTART_MEMORY: Param<f64> =
        float("Restart Memory", 600.0, Unit::Second).within(0.0, 86_400.0).doc(
            "Lutra: what was under way longer ago is reported, and nothing is done: the vessel may lie on land.",
        );

    pub static ENGINE: SectionSpec =
        SectionSpec::task(&["Plan.Engine"], "Plan Engine", "Always").doc("Runs plans.").groups(&[
            OF_EVERY_TASK,
            &[
                COMPUTE_PROGRESS.spec,
                FUEL_PREDICTION.spec,
                REPORT_FREQUENCY.spec,
                MINIMUM_CALIBRATION.spec,
                CALIBRATE.spec,
                ABORT_ON_FAILED_ACTIVATION.spec,
                VEHICLE_TIMEOUT.spec,
                POSITION_GAP.spec,
                TRACK_RECOVERY.spec,
                AFTER_FAILURE.spec,
                AFTER_RESTART.spec,
                COUNTDOWN.spec,
                RESTART_MEMORY.spec,
                unused("StationKeeping While Calibrating", "the Otter has nothing to calibrate under way"),
                unused("StationKeeping Speed in RPM", "the Otter has nothing to calibrate under way"),
                unused("StationKeeping Radius", "the Otter has nothing to calibrate under way"),
                unused("IMU Entity Label", "the Otter has no inertial unit to align"),
                unused("Plan Generator Entity Label", "Lutra has no plan generator on board"),
            ],
        ]);

    pub const FOLDER: Param<String> =
        text("Folder", "").doc("Lutra: where the database is kept; empty for the agent's data folder.");

    pub static DATABASE: SectionSpec = SectionSpec::task(&["Plan.DB"], "Plan Database", "Always")
        .doc("Keeps plans and their digests.")
        .groups(&[OF_EVERY_TASK, &[FOLDER.spec]]);
}

pub mod maneuver {
    use super::{
        Kind, OF_EVERY_TASK, Param, ParamSpec, SectionSpec, Unit, choice, float, text, texts, unused,
    };

    pub const SUPPORTED: &[&str] = &[
        "IdleManeuver",
        "Goto",
        "Launch",
        "Loiter",
        "StationKeeping",
        "Rows",
        "FollowPath",
        "ScheduledGoto",
    ];
    const LEFT_OUT: &[&str] = &[
        "YoYo",
        "Elevator",
        "PopUp",
        "Dislodge",
        "Takeoff",
        "Land",
        "Drop",
        "Sample",
        "StationKeepingExtended",
    ];

    pub const LABELS: Param<String> = text("Entity Label -- {}", "")
        .each(SUPPORTED)
        .doc("Entity label of one maneuver; empty for `<name> Maneuver`.");
    pub const UNSUPPORTED: Param<Vec<String>> =
        texts("Unsupported", &[]).doc("Maneuvers that are refused although they exist.");
    pub const LOITER_RADIUS: Param<f64> = float("Loiter -- Minimum Radius", 10.0, Unit::Metre)
        .within(0.5, 1000.0)
        .doc("Smaller circles are widened to this; an Otter can do 1 m.");
    pub const STATION_RADIUS: Param<f64> = float("StationKeeping -- Minimum Radius", 10.0, Unit::Metre)
        .within(0.5, 1000.0)
        .doc("Smaller radii are widened to this; an Otter can do 2 m.");
    pub const SCHEDULED_MINIMUM: Param<f64> =
        float("ScheduledGoto -- Minimum Speed", 0.7, Unit::MetrePerSecond)
            .within(0.0, 10.0)
            .doc("A scheduled goto waits while less than this is needed.");
    pub const SCHEDULED_MAXIMUM: Param<f64> =
        float("ScheduledGoto -- Maximum Speed", 1.6, Unit::MetrePerSecond)
            .within(0.1, 10.0)
            .doc("Greatest speed of a scheduled goto.");

    const DIVING: &str = "for vehicles that dive, fly or sample";

    const fn left_out(name: &'static str, each: &'static [&'static str]) -> ParamSpec {
        ParamSpec { name, each, kind: Kind::Unused, unit: Unit::None, doc: DIVING }
    }

    pub static MULTIPLEXER: SectionSpec =
        SectionSpec::task(&["Maneuver.Multiplexer"], "Multiplexer Maneuver", "Always")
            .doc("The basic maneuvers: idle, goto, launch, loiter, station keeping, rows, paths.")
            .groups(&[
                OF_EVERY_TASK,
                &[
                    LABELS.spec,
                    UNSUPPORTED.spec,
                    LOITER_RADIUS.spec,
                    STATION_RADIUS.spec,
                    SCHEDULED_MINIMUM.spec,
                    SCHEDULED_MAXIMUM.spec,
                    left_out("Entity Label -- {}", LEFT_OUT),
                    unused("YoYo -- Maximum Pitch Variation", DIVING),
                    unused("Elevator -- Minimum Radius", DIVING),
                    unused("StationKeepingExtended -- Minimum Radius", DIVING),
                ],
            ]);

    pub const HORIZONTAL_TOLERANCE: Param<f64> = float("Horizontal Tolerance", 15.0, Unit::Metre)
        .within(0.5, 1000.0)
        .doc("So far beyond the radius the vessel may drift before it returns; the boats use 30 m.");
    pub const FOLLOW_RADIUS: Param<f64> = float("Loitering Radius", 7.5, Unit::Metre)
        .within(0.0, 1000.0)
        .doc("Radius used when a reference gives none.");
    pub const FOLLOW_SPEED: Param<f64> = float("Default Speed", 50.0, Unit::None)
        .within(0.0, 10_000.0)
        .doc("Speed used when a reference gives none, in the units named below.");
    pub const FOLLOW_SPEED_UNITS: Param<&str> =
        choice("Default Speed Units", "percent", &["percent", "rpm", "m/s"])
            .doc("Units of the default speed.");
    pub const SEPARATION: Param<f64> = float("Minimum Separation", 0.0, Unit::Metre)
        .within(0.0, 1000.0)
        .doc("Lutra: stop when another vessel is announced closer than this; 0 never stops.");

    pub static FOLLOW_REFERENCE: SectionSpec = SectionSpec::task(
        &["Maneuver.FollowReference.ASV", "Maneuver.FollowReference.AUV"],
        "Follow Reference Maneuver",
        "Always",
    )
    .doc("Goes where another system's references say.")
    .groups(&[
        OF_EVERY_TASK,
        &[
            HORIZONTAL_TOLERANCE.spec,
            FOLLOW_RADIUS.spec,
            FOLLOW_SPEED.spec,
            FOLLOW_SPEED_UNITS.spec,
            SEPARATION.spec,
            unused("Vertical Tolerance", "a surface vessel has no depth to keep"),
            unused("Default Z", "a surface vessel has no depth to keep"),
            unused("Default Z Units", "a surface vessel has no depth to keep"),
        ],
    ]);

    pub const FOLLOW_DISPLACEMENT: Param<f64> = float("Minimum Displacement", 2.0, Unit::Metre)
        .within(0.1, 1000.0)
        .doc("The leader's course is taken from positions this far apart.");
    pub const FOLLOW_STOP: Param<f64> = float("Stop Distance", 15.0, Unit::Metre)
        .within(1.0, 1000.0)
        .doc("Closer than this to the leader the vessel stops.");
    pub const FOLLOW_TOLERANCE: Param<f64> = float("Slot Tolerance", 10.0, Unit::Metre)
        .within(1.0, 1000.0)
        .doc("The vessel moves only when farther than this from its place.");
    pub const FOLLOW_TIMEOUT: Param<f64> = float("Announce Timeout", 60.0, Unit::Second)
        .within(1.0, 3600.0)
        .doc("Without news of the leader for so long the maneuver fails.");

    pub static FOLLOW_SYSTEM: SectionSpec = SectionSpec::task(
        &["Maneuver.FollowSystem", "Maneuver.FollowSystemOtter"],
        "Follow System Maneuver",
        "Always",
    )
    .doc("Keeps a place beside another system.")
    .groups(&[
        OF_EVERY_TASK,
        &[FOLLOW_DISPLACEMENT.spec, FOLLOW_STOP.spec, FOLLOW_TOLERANCE.spec, FOLLOW_TIMEOUT.spec],
    ]);

    pub const TRAJECTORY_MINIMUM: Param<f64> = float("Minimum Speed", 1.0, Unit::MetrePerSecond)
        .within(0.0, 10.0)
        .doc("Least speed while catching up or waiting for the plan's times.");
    pub const TRAJECTORY_MAXIMUM: Param<f64> = float("Maximum Speed", 2.0, Unit::MetrePerSecond)
        .within(0.1, 10.0)
        .doc("Greatest speed; a leg that needs more is an error.");
    pub const TRAJECTORY_DELAY: Param<f64> = float("Time Tolerance", 2.0, Unit::Second)
        .within(0.1, 600.0)
        .doc("The speed is corrected when the vessel is earlier or later than this.");

    pub static FOLLOW_TRAJECTORY: SectionSpec =
        SectionSpec::task(&["Maneuver.FollowTrajectory"], "Follow Trajectory Maneuver", "Always")
            .doc("Passes points at given times.")
            .groups(&[
                OF_EVERY_TASK,
                &[TRAJECTORY_MINIMUM.spec, TRAJECTORY_MAXIMUM.spec, TRAJECTORY_DELAY.spec],
            ]);

    pub static ROWS_COVERAGE: SectionSpec =
        SectionSpec::task(&["Maneuver.RowsCoverage"], "Rows Coverage Maneuver", "Always")
            .doc("Covers an area in rows as wide as the sensor sees.")
            .groups(&[OF_EVERY_TASK]);

    pub static TELEOPERATION: SectionSpec =
        SectionSpec::task(&["Maneuver.Teleoperation"], "Teleoperation Maneuver", "Always")
            .doc("Hands the vessel to manual control.")
            .groups(&[OF_EVERY_TASK]);
}
