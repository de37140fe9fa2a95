//! Supervisors and monitors.

#![expect(missing_docs, reason = "each parameter carries its documentation as a value")]

use crate::schema::common::{OF_EVERY_TASK, execution_frequency};
use crate::spec::{Param, SectionSpec, Unit, choice, flag, float, floats, int, text, texts, unused};

pub mod vehicle {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, execution_frequency, flag, float, texts};

    pub const FREQUENCY: Param<f64> = execution_frequency(2.0);
    pub const EXTERNAL_CONTROL: Param<bool> =
        flag("Allows External Control", false).doc("Whether control loops may be on without a maneuver.");
    pub const HANDLING_TIMEOUT: Param<f64> = float("Maneuver Handling Timeout", 1.0, Unit::Second)
        .within(0.1, 60.0)
        .doc("A maneuver must answer a start or stop within this time.");
    pub const VITAL_ENTITIES: Param<Vec<String>> =
        texts("Vital Entities", &[]).doc("Entities whose errors count even in a plan that ignores errors.");

    pub static VEHICLE: SectionSpec =
        SectionSpec::task(&["Supervisors.Vehicle"], "Vehicle Supervisor", "Always")
            .doc("Decides about the mode of operation: service, calibration, maneuver, error.")
            .groups(&[
                OF_EVERY_TASK,
                &[FREQUENCY.spec, EXTERNAL_CONTROL.spec, HANDLING_TIMEOUT.spec, VITAL_ENTITIES.spec],
            ]);
}

pub mod lost_comms {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, choice, flag, float, text};

    pub const PLAN: Param<String> =
        text("Plan Name", "lostcomms").doc("Plan that brings the vessel home; the boats call it lost_comms.");
    pub const TIMEOUT: Param<f64> = float("Lost Comms Timeout", 300.0, Unit::Second)
        .within(1.0, 86_400.0)
        .doc("Without a heartbeat of a console for so long communications are lost.");
    pub const REQUIRE_IDLE: Param<bool> =
        flag("Require Idle", true).doc("Whether a running plan holds this supervisor off, as in DUNE.");
    pub const REQUIRE_BAD_OUTCOME: Param<bool> =
        flag("Require Bad Outcome", true).doc("Whether it acts only when the last plan failed, as in DUNE.");
    pub const DURING_PLAN: Param<&str> =
        choice("Action During Plan", "continue", &["continue", "hold", "return"])
            .doc("Lutra: what to do when communications are lost in a plan.");
    pub const DURING_TELEOPERATION: Param<&str> =
        choice("Action During Teleoperation", "hold", &["hold", "return"])
            .doc("Lutra: what to do when they are lost under manual control, motors stopped in any case.");
    pub const WHEN_IDLE: Param<&str> =
        choice("Action When Idle", "continue", &["continue", "hold", "return"])
            .doc("Lutra: what to do when they are lost while nothing runs.");
    pub const HOLD_RADIUS: Param<f64> = float("Hold Radius", 15.0, Unit::Metre)
        .within(1.0, 1000.0)
        .doc("Lutra: radius within which the vessel holds its place.");

    pub static LOST_COMMS: SectionSpec = SectionSpec::task(
        &["Supervisors.ASV.LostComms", "Supervisors.AUV.LostComms"],
        "LostComms Supervisor",
        "Always",
    )
    .doc("Acts when no console has been heard for long.")
    .groups(&[
        OF_EVERY_TASK,
        &[
            PLAN.spec,
            TIMEOUT.spec,
            REQUIRE_IDLE.spec,
            REQUIRE_BAD_OUTCOME.spec,
            DURING_PLAN.spec,
            DURING_TELEOPERATION.spec,
            WHEN_IDLE.spec,
            HOLD_RADIUS.spec,
        ],
    ]);
}

pub mod entities {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, float, int, texts};

    pub const REPORT_TIMEOUT: Param<f64> = float("Report Timeout", 5.0, Unit::Second)
        .within(1.0, 600.0)
        .doc("An entity that says nothing for so long has failed.");
    pub const TRANSITION_GAP: Param<f64> = float("Transition Time Gap", 4.0, Unit::Second)
        .within(0.0, 600.0)
        .doc("Changes of state closer together than this are counted as flapping.");
    pub const MAXIMUM_TRANSITIONS: Param<i64> = int("Maximum Consecutive Transitions", 3, Unit::None)
        .within(1, 1000)
        .doc("From so many on the log is silent; the state still counts.");
    pub const MONITORED: Param<Vec<String>> =
        texts("Default Monitoring", &["Daemon", "GPS", "Navigation", "Path Control"])
            .doc("Entities whose errors stop missions.");
    pub const MONITORED_HARDWARE: Param<Vec<String>> = texts("Default Monitoring -- Hardware", &["Torqeedo"])
        .doc("Entities that are watched in the profile Hardware besides.");

    pub static ENTITIES: SectionSpec = SectionSpec::task(&["Monitors.Entities"], "Entity Monitor", "Always")
        .doc("Watches the entities that the vessel needs.")
        .groups(&[
            OF_EVERY_TASK,
            &[
                REPORT_TIMEOUT.spec,
                TRANSITION_GAP.spec,
                MAXIMUM_TRANSITIONS.spec,
                MONITORED.spec,
                MONITORED_HARDWARE.spec,
            ],
        ]);
}

pub mod fuel {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, choice, execution_frequency, float, text};

    pub const FREQUENCY: Param<f64> = execution_frequency(1.0);
    pub const WARNING_LEVEL: Param<f64> = float("Warning Level", 30.0, Unit::Percent)
        .within(0.0, 100.0)
        .doc("Charge below which the operator is warned.");
    pub const RESERVE_LEVEL: Param<f64> = float("Reserve Level", 20.0, Unit::Percent)
        .within(0.0, 100.0)
        .doc("Lutra: charge below which the reserve is touched, which takes the `Reserve Action`.");
    pub const ERROR_LEVEL: Param<f64> = float("Error Level", 10.0, Unit::Percent)
        .within(0.0, 100.0)
        .doc("Charge below which not even the way home is left; with a `Reserve Action` the vessel holds.");
    pub const LOW_CONFIDENCE: Param<f64> = float("Low Confidence Level", 40.0, Unit::Percent)
        .within(0.0, 100.0)
        .doc("Confidence below which the estimate is called unreliable.");
    pub const WARNING_VOLTAGE: Param<f64> = float("Warning Voltage", 0.0, Unit::Volt)
        .within(0.0, 1000.0)
        .doc("Lutra: voltage below which the operator is warned; 0 does not look at it.");
    pub const ERROR_VOLTAGE: Param<f64> = float("Error Voltage", 0.0, Unit::Volt).within(0.0, 1000.0).doc(
        "Lutra: voltage that means the reserve is used up, released 0.2 V above; 0 does not look at it.",
    );
    pub const RESERVE_ACTION: Param<&str> = choice("Reserve Action", "warn", &["warn", "hold", "return"])
        .doc("Lutra: what to do when the reserve is touched.");
    pub const RESERVE_PLAN: Param<String> =
        text("Reserve Plan", "").doc("Lutra: plan for `return`; empty for the one of lost communications.");

    pub static FUEL: SectionSpec = SectionSpec::task(&["Monitors.FuelLevel"], "Fuel Level", "Always")
        .doc("Watches the batteries.")
        .groups(&[
            OF_EVERY_TASK,
            &[
                FREQUENCY.spec,
                WARNING_LEVEL.spec,
                RESERVE_LEVEL.spec,
                ERROR_LEVEL.spec,
                LOW_CONFIDENCE.spec,
                WARNING_VOLTAGE.spec,
                ERROR_VOLTAGE.spec,
                RESERVE_ACTION.spec,
                RESERVE_PLAN.spec,
            ],
        ]);
}

pub mod limits {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, choice, float, floats};

    pub const MAXIMUM_SPEED: Param<f64> = float("Maximum Speed", 3.1, Unit::MetrePerSecond)
        .within(0.1, 20.0)
        .doc("Greatest speed over ground that is allowed.");
    pub const AREA: Param<Vec<f64>> = floats("Area", &[], Unit::Degree).within(-180.0, 180.0).doc(
        "Corners of the area that must not be left: latitude, longitude, latitude, ...; empty for none.",
    );
    pub const ACTION: Param<&str> =
        choice("Action", "hold", &["warn", "hold", "return"]).doc("What to do when a limit is passed.");

    pub static LIMITS: SectionSpec =
        SectionSpec::task(&["Supervisors.OperationalLimits"], "Operational Limits", "Always")
            .doc("Lutra: keeps the vessel within its area and speed.")
            .groups(&[OF_EVERY_TASK, &[MAXIMUM_SPEED.spec, AREA.spec, ACTION.spec]]);
}

pub mod grounding {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, choice, flag, float, text};

    pub const CHART: Param<String> = text("Chart", "").doc(
        "Depth index that plans and the water ahead are held against, as `lutra-server chart` makes it; empty \
         for none.",
    );
    pub const FROM_SHORE: Param<bool> = flag("Chart From Shore", true).doc(
        "Whether the chart of the server is fetched over the link and takes the place of the one above, also where \
         none is.",
    );
    pub const WITHOUT_CHART: Param<&str> = choice("Unreadable Chart", "refuse", &["refuse", "warn"]).doc(
        "Whether plans are refused while the chart that is configured cannot be read, or only warned of.",
    );
    pub const NAVIGABLE: Param<f64> = float("Navigable Depth", 1.0, Unit::Metre)
        .within(0.1, 100.0)
        .doc("Least depth in which anybody may drive the vessel.");
    pub const AUTONOMOUS: Param<f64> = float("Autonomous Depth", 5.0, Unit::Metre)
        .within(0.1, 100.0)
        .doc("Least depth in which it may go by itself.");
    pub const DRAUGHT: Param<f64> =
        float("Draught", 0.32, Unit::Metre).within(0.0, 10.0).doc("Draught at rest.");
    pub const SQUAT: Param<f64> =
        float("Squat", 0.05, Unit::Metre).within(0.0, 10.0).doc("How much deeper it lies under way.");
    pub const AIR_DRAUGHT: Param<f64> = float("Air Draught", 2.0, Unit::Metre)
        .within(0.0, 100.0)
        .doc("Height above the water up to the highest aerial; 0 passes under everything.");
    pub const WATER_LEVEL: Param<f64> = float("Water Level", 0.0, Unit::Metre)
        .within(-10.0, 20.0)
        .doc("Height of the water above chart datum that is relied upon.");
    pub const TRUST: Param<&str> =
        choice("Chart Trust", "as charted", &["as charted", "depth errors", "all errors"]).doc(
            "Whether the errors of the zones of confidence are taken off depths, and added to widths too.",
        );
    pub const ENTRY: Param<&str> = choice(
        "Restricted Areas",
        "refuse prohibited",
        &["refuse prohibited", "refuse all", "warn", "ignore"],
    )
    .doc(
        "What becomes of plans into areas where the chart prohibits or restricts entry; `refuse prohibited` warns of \
         those that are restricted or to be avoided.",
    );
    pub const POSITION: Param<f64> = float("Position Uncertainty", 3.0, Unit::Metre)
        .within(0.0, 1000.0)
        .doc("How far off the position may be at best; more where navigation says so.");
    pub const CROSS_TRACK: Param<f64> = float("Cross Track", 10.0, Unit::Metre)
        .within(0.0, 1000.0)
        .doc("How far plans may lead past danger: the vessel may stray so far from its track.");
    pub const DRIFT: Param<f64> = float("Drift Speed", 0.2, Unit::MetrePerSecond)
        .within(0.0, 5.0)
        .doc("How fast the vessel drifts with its motors off.");
    pub const WARNING_TIME: Param<f64> = float("Warning Time", 30.0, Unit::Second)
        .within(1.0, 600.0)
        .doc("Danger on the course within this time is warned of.");
    pub const WARNING_DISTANCE: Param<f64> = float("Warning Distance", 20.0, Unit::Metre)
        .within(0.0, 2000.0)
        .doc("Danger on the course within this distance is warned of.");
    pub const REACTION: Param<f64> = float("Reaction Time", 3.0, Unit::Second)
        .within(0.5, 60.0)
        .doc("Time at full way before braking works.");
    pub const DECELERATION: Param<f64> = float("Deceleration", 0.3, Unit::MetrePerSecondSquared)
        .within(0.01, 10.0)
        .doc("Braking that can be relied upon.");
    pub const RESERVE: Param<f64> = float("Reserve Distance", 5.0, Unit::Metre)
        .within(0.0, 1000.0)
        .doc("Distance that is kept from danger under manual control beyond stopping.");
    pub const ACTION: Param<&str> = choice("Action", "deep water", &["warn", "slow", "stop", "deep water"])
        .doc(
            "What to do in a plan within stopping distance of danger; weaker ones leave the rest to others.",
        );
    pub const ABORT_AFTER: Param<f64> = float("Abort After", 60.0, Unit::Second)
        .within(0.0, 3600.0)
        .doc("Time in danger with the motors running after which they stop for good; 0 never.");
    pub const OVERRIDE: Param<f64> = float("Override Request", 0.0, Unit::Second)
        .within(0.0, 600.0)
        .doc("An operator asks to steer unguarded for this time; 0 ends it. Only while it is set live.");
    pub const CONFIRM: Param<f64> = float("Override Confirmation", 0.0, Unit::Second)
        .within(0.0, 600.0)
        .doc("The same time again, within 30 s of the request: only then the guard is lifted.");
    pub const ROUTES: Param<bool> = flag("Route Around Land", true).doc(
        "Whether the vessel looks for a route on the chart where the straight way home or to a reference is refused.",
    );
    pub const ROUTE_CLEARANCE: Param<f64> = float("Route Clearance", 25.0, Unit::Metre)
        .within(0.0, 2000.0)
        .doc("How far such routes keep from danger where the water allows it; never less than plans must.");
    pub const LONGEST_ROUTE: Param<f64> = float("Longest Route", 20_000.0, Unit::Metre)
        .within(100.0, 200_000.0)
        .doc("Longer ones are not taken. It also bounds the memory that looking for them takes.");

    pub static GROUNDING: SectionSpec = SectionSpec::task(
        &["Supervisors.Grounding"],
        "Grounding Supervisor",
        "Always",
    )
    .doc("Lutra: keeps the vessel off the ground by the sea chart; DUNE's task of this name only warns.")
    .groups(&[
        OF_EVERY_TASK,
        &[
            CHART.spec,
            FROM_SHORE.spec,
            WITHOUT_CHART.spec,
            NAVIGABLE.spec,
            AUTONOMOUS.spec,
            DRAUGHT.spec,
            SQUAT.spec,
            AIR_DRAUGHT.spec,
            WATER_LEVEL.spec,
            TRUST.spec,
            ENTRY.spec,
            POSITION.spec,
            CROSS_TRACK.spec,
            DRIFT.spec,
            WARNING_TIME.spec,
            WARNING_DISTANCE.spec,
            REACTION.spec,
            DECELERATION.spec,
            RESERVE.spec,
            ACTION.spec,
            ABORT_AFTER.spec,
            OVERRIDE.spec,
            CONFIRM.spec,
            ROUTES.spec,
            ROUTE_CLEARANCE.spec,
            LONGEST_ROUTE.spec,
        ],
    ]);
}

pub mod clock {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, float, int, text, unused};

    pub const MINIMUM_FIXES: Param<i64> = int("Minimum GPS Fixes", 10, Unit::None)
        .within(1, 10_000)
        .doc("Positions with date and time that are awaited before the clock is judged.");
    pub const MAXIMUM_OFFSET: Param<f64> = float("Maximum Clock Offset", 4.0, Unit::Second)
        .within(0.0, 86_400.0)
        .doc("A clock farther off than this is reported.");
    pub const MAXIMUM_PULSE_OFFSET: Param<f64> = float("Maximum Pulse Offset", 0.001, Unit::Second)
        .within(0.000_001, 1.0)
        .doc("Lutra: the same where the receiver's pulse says how far it is off.");
    pub const PULSE_DEVICE: Param<String> = text("Pulse Device", "").doc(
        "Lutra: the kernel's source of the receiver's pulse per second, such as /dev/pps0; empty without the wire. Its \
         silence is reported.",
    );
    pub const CHRONY_SOCKET: Param<String> = text("Chrony Socket", "").doc(
        "Lutra: the socket of chrony's SOCK source that gets the time of the receiver's messages, such as \
         /run/chrony/lutra.sock; empty for none.",
    );
    pub const BOOT_TIMEOUT: Param<f64> = float("Boot Synchronization Timeout", 30.0, Unit::Second)
        .within(0.0, 86_400.0)
        .doc("After this time the vessel goes on with the clock as it is.");
    pub const COMMAND: Param<String> = text("Hardware Clock Synchronization Command", "")
        .doc("Command that sets the hardware clock, run after the clock was stepped.");

    pub static CLOCK: SectionSpec = SectionSpec::task(&["Monitors.Clock"], "Clock", "Hardware")
        .doc("Compares the computer's clock with the satellites'.")
        .groups(&[
            OF_EVERY_TASK,
            &[
                MINIMUM_FIXES.spec,
                MAXIMUM_OFFSET.spec,
                MAXIMUM_PULSE_OFFSET.spec,
                PULSE_DEVICE.spec,
                CHRONY_SOCKET.spec,
                BOOT_TIMEOUT.spec,
                COMMAND.spec,
                unused("Change Log", "Lutra's log goes on over a step of the clock"),
            ],
        ]);
}

pub mod host {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, execution_frequency, float};

    pub const FREQUENCY: Param<f64> = execution_frequency(1.0);
    pub const DISK_WARNING: Param<f64> = float("Storage Warning Level", 10.0, Unit::Percent)
        .within(0.0, 100.0)
        .doc("Lutra: free disk space below which the operator is warned; 10 GiB is always enough.");
    pub const DISK_ERROR: Param<f64> = float("Storage Error Level", 2.0, Unit::Percent)
        .within(0.0, 100.0)
        .doc("Lutra: free disk space below which the entity is in error; 10 GiB is always enough.");
    pub const MEMORY_WARNING: Param<f64> = float("Memory Warning Level", 10.0, Unit::Percent)
        .within(0.0, 100.0)
        .doc("Lutra: free memory below which the operator is warned.");

    pub static HOST: SectionSpec = SectionSpec::task(&["Monitors.HostResources"], "Host Resources", "Always")
        .doc("Watches processor, memory and disk.")
        .groups(&[OF_EVERY_TASK, &[FREQUENCY.spec, DISK_WARNING.spec, DISK_ERROR.spec, MEMORY_WARNING.spec]]);

    pub const THERMAL_FREQUENCY: Param<f64> = execution_frequency(0.5);

    pub static THERMAL: SectionSpec =
        SectionSpec::task(&["Sensors.ThermalZone"], "Mainboard (Core)", "Always")
            .doc("Reports the processor's temperature.")
            .groups(&[OF_EVERY_TASK, &[THERMAL_FREQUENCY.spec]]);
}
