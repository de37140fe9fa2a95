//! The hardware on board.

#![expect(missing_docs, reason = "each parameter carries its documentation as a value")]

use crate::schema::common::{DIGITS, OF_EVERY_TASK, execution_frequency};
use crate::spec::{
    Param, ParamSpec, SectionSpec, Unit, bytes, choice, flag, float, int, ints, text, texts, unused,
};

pub const SERIAL_DEVICE: Param<String> =
    text("Serial Port - Device", "/dev/ttyUSB0").doc("Serial port, or tcp://host:port.");
pub const BAUD_RATE: Param<i64> = int("Serial Port - Baud Rate", 19_200, Unit::Baud)
    .within(300, 4_000_000)
    .doc("Speed of the serial port.");
pub const INIT_COMMAND: Param<Vec<u8>> = bytes("Initialization String {} - Command", "")
    .each(DIGITS)
    .doc("Sent at the start, in order; escapes such as \\r\\n are replaced.");
pub const INIT_REPLY: Param<Vec<u8>> = bytes("Initialization String {} - Reply", "")
    .each(DIGITS)
    .doc("Awaited after the command of the same number; empty for no reply.");

const OF_EVERY_SERIAL: &[ParamSpec] =
    &[SERIAL_DEVICE.spec, BAUD_RATE.spec, INIT_COMMAND.spec, INIT_REPLY.spec];

pub mod compass {
    use super::{OF_EVERY_SERIAL, OF_EVERY_TASK, Param, SectionSpec, Unit, flag, float, int, text, texts};

    pub const SENTENCES: Param<Vec<String>> =
        texts("Sentence Order", &["GPROT", "GPHDM", "GPGGA", "GPVTG", "GPZDA"])
            .doc("NMEA sentences that make up one measurement, in the order of the receiver.");
    pub const INPUT_TIMEOUT: Param<f64> = float("Input Timeout", 4.0, Unit::Second)
        .within(0.5, 600.0)
        .doc("Without a complete measurement for so long the entity is in error.");
    pub const GPSD_HOST: Param<String> =
        text("GPSD - Address", "localhost").doc("Lutra: host of gpsd, for Sensors.GPSDraw.");
    pub const GPSD_PORT: Param<i64> = int("GPSD - Port", 2947, Unit::None)
        .within(1, 65_535)
        .doc("Lutra: port of gpsd, for Sensors.GPSDraw.");

    pub const HEADING_OFFSET: Param<f64> = float("Heading Offset", 0.0, Unit::Degree)
        .within(-180.0, 180.0)
        .doc("Lutra: added to the compass' heading, for antennas that do not point forward; to starboard positive.");

    pub const MAGNETIC: Param<bool> = flag("Magnetic Heading", false)
        .doc("Lutra: whether a magnetic heading (HDM) stands in while the compass gives no true one.");
    pub const VARIATION: Param<f64> = float("Magnetic Variation", 0.0, Unit::Degree)
        .within(-180.0, 180.0)
        .doc("Lutra: added to such a heading; east is positive. The chart tells it.");

    pub static COMPASS: SectionSpec =
        SectionSpec::task(&["Sensors.GPS", "Sensors.GPSOtter", "Sensors.GPSDraw"], "GPS", "Hardware")
            .doc("Satellite compass on a serial port, or through gpsd under the name Sensors.GPSDraw.")
            .groups(&[
                OF_EVERY_TASK,
                OF_EVERY_SERIAL,
                &[
                    SENTENCES.spec,
                    INPUT_TIMEOUT.spec,
                    GPSD_HOST.spec,
                    GPSD_PORT.spec,
                    HEADING_OFFSET.spec,
                    MAGNETIC.spec,
                    VARIATION.spec,
                ],
            ]);
}

pub mod hydrophone {
    use super::{OF_EVERY_SERIAL, OF_EVERY_TASK, Param, SectionSpec, Unit, flag, float, int, text, unused};

    pub const USE_PPS: Param<bool> = flag("Use PPS", true)
        .doc("Whether the receiver's clock is kept by pulses; otherwise by timed characters.");
    pub const SYNC_PERIOD: Param<f64> = float("Sync Period", 1800.0, Unit::Second)
        .within(1.0, 86_400.0)
        .doc("How often the time is sent when pulses are used.");
    pub const SYNC_ACK_TIMEOUT: Param<f64> = float("Sync Period Ack Timeout", 5.0, Unit::Second)
        .within(0.1, 600.0)
        .doc("The receiver must confirm the time within this.");
    pub const FULL_STAMP_DIVIDER: Param<i64> = int("Write full timestamp divider", 6, Unit::None)
        .within(1, 10_000)
        .doc("Without pulses, every so many 10 s periods the whole time is sent.");
    pub const TRANSMISSION_TIME: Param<f64> = float("Transmission Time", 3.0, Unit::Second)
        .within(0.0, 60.0)
        .doc("Duration of a tag's transmission, taken off the time of its detection to find where the vessel was.");
    pub const RAW_FOLDER: Param<String> = text("Rawlogfile folder", "")
        .doc("Where all lines received are written; empty for the agent's log folder.");
    pub const POWER_CHANNEL: Param<String> =
        text("Power Channel - Name", "").doc("Power channel that is switched on first; empty for none.");

    pub const ARM_FORWARD: Param<f64> = float("Lever Arm - Forward", 0.0, Unit::Metre)
        .within(-20.0, 20.0)
        .doc("Lutra: how far the hydrophone is before the compass' antenna, along the vessel.");
    pub const ARM_STARBOARD: Param<f64> = float("Lever Arm - Starboard", 0.0, Unit::Metre)
        .within(-20.0, 20.0)
        .doc("Lutra: how far it is to starboard of the antenna.");
    pub const ARM_DOWN: Param<f64> = float("Lever Arm - Down", 0.0, Unit::Metre)
        .within(-20.0, 100.0)
        .doc("Lutra: how far it is below the antenna.");

    pub static HYDROPHONE: SectionSpec =
        SectionSpec::task(&["Sensors.ThelmaHydrophone", "Sensors.TBR700RT"], "TBLive", "Hardware")
            .doc("Acoustic receiver for fish tags.")
            .groups(&[
                OF_EVERY_TASK,
                OF_EVERY_SERIAL,
                &[
                    USE_PPS.spec,
                    SYNC_PERIOD.spec,
                    SYNC_ACK_TIMEOUT.spec,
                    FULL_STAMP_DIVIDER.spec,
                    TRANSMISSION_TIME.spec,
                    RAW_FOLDER.spec,
                    POWER_CHANNEL.spec,
                    ARM_FORWARD.spec,
                    ARM_STARBOARD.spec,
                    ARM_DOWN.spec,
                    unused("Entity Label - GPS", "positions come from navigation"),
                ],
            ]);
}

/// Receivers of fish tags that are not Thelma's.
pub mod line_receiver {
    use super::hydrophone::{ARM_DOWN, ARM_FORWARD, ARM_STARBOARD, TRANSMISSION_TIME};
    use super::{OF_EVERY_SERIAL, OF_EVERY_TASK, Param, SectionSpec, Unit, choice, float, text};

    pub const RECEIVER: Param<&str> = choice("Receiver", "VR2C", &["VR2C", "Rx-LIVE", "Pattern"])
        .doc("Lutra: whose lines they are; Pattern for any that `Line Pattern` declares.");
    pub const PATTERN: Param<String> = text("Line Pattern", "").doc(
        "Lutra: a line with its fields in braces, such as {serial},{utc},{protocol},{id}; `lutra-agent sniff --help` \
         lists the fields.",
    );
    pub const LONGEST_SILENCE: Param<f64> = float("Longest Silence", 0.0, Unit::Second)
        .within(0.0, 86_400.0)
        .doc("Lutra: without a line for so long the entity is in error; 0 where the receiver may be silent.");

    pub static LINE_RECEIVER: SectionSpec =
        SectionSpec::task(&["Sensors.LineReceiver"], "Receiver", "Never")
            .doc("Acoustic receiver for fish tags that only writes lines: Innovasea VR2C, Rx-LIVE, or any by a pattern.")
            .groups(&[
                OF_EVERY_TASK,
                OF_EVERY_SERIAL,
                &[
                    RECEIVER.spec,
                    PATTERN.spec,
                    LONGEST_SILENCE.spec,
                    TRANSMISSION_TIME.spec,
                    ARM_FORWARD.spec,
                    ARM_STARBOARD.spec,
                    ARM_DOWN.spec,
                ],
            ]);
}

pub mod sound_speed {
    use super::{OF_EVERY_TASK, Param, SectionSpec, Unit, execution_frequency, flag, float, text};

    pub const FREQUENCY: Param<f64> = execution_frequency(0.1);
    pub const INITIAL: Param<f64> = float("Initial Speed Of Sound", 1485.0, Unit::MetrePerSecond)
        .within(1300.0, 1700.0)
        .doc("Used until it is worked out.");
    pub const USE_TEMPERATURE: Param<bool> = flag("Use Temperature For Speed Of Sound", true)
        .doc("Whether it is worked out from the measured temperature.");
    pub const TEMPERATURE: Param<f64> = float("Initial Temperature", 10.0, Unit::Celsius)
        .within(-4.0, 45.0)
        .doc("Temperature of the water until one is measured.");
    pub const SALINITY: Param<f64> =
        float("Initial Salinity", 25.0, Unit::PerMille).within(0.0, 45.0).doc("Salinity of the water.");
    pub const DEPTH: Param<f64> =
        float("Initial Depth", 1.0, Unit::Metre).within(0.0, 1000.0).doc("Depth of the receiver.");
    pub const ENTITY: Param<String> =
        text("Temperature - Entity", "TBLive").doc("Entity that measures the temperature.");

    pub static SOUND_SPEED: SectionSpec =
        SectionSpec::task(&["Monitors.SpeedOfSoundInWater"], "SoundSpeedCalculator", "Hardware")
            .doc("Works the speed of sound out.")
            .groups(&[
                OF_EVERY_TASK,
                &[
                    FREQUENCY.spec,
                    INITIAL.spec,
                    USE_TEMPERATURE.spec,
                    TEMPERATURE.spec,
                    SALINITY.spec,
                    DEPTH.spec,
                    ENTITY.spec,
                ],
            ]);
}

pub mod torqeedo {
    use super::{
        DIGITS, OF_EVERY_TASK, Param, SectionSpec, Unit, execution_frequency, flag, float, int, text,
    };

    pub const CHANNELS: &[&str] = &[
        "H_MOT0", "H_MOT1", "H_AUX0", "H_AUX1", "H_12V0", "H_12V1", "H_12V2", "H_12V3", "H_VR0", "H_VR1",
        "H_5V",
    ];

    pub const FREQUENCY: Param<f64> = execution_frequency(40.0);
    pub const DEVICE: Param<String> = text("CAN Port - Device", "can0")
        .doc("CAN interface of the card, or Lutra: slcan:/dev/... for an adapter on a serial port.");
    pub const BAUD_RATE: Param<i64> = int("CAN Port - Baud Rate", 115_200, Unit::Baud)
        .within(300, 4_000_000)
        .doc("Lutra: speed of the serial port of an slcan adapter; those on USB take any.");
    pub const BIT_RATE: Param<i64> = int("CAN Port - Bit Rate", 500_000, Unit::Baud)
        .within(10_000, 1_000_000)
        .doc("Lutra: speed of the bus, which is sent to an slcan adapter: 10, 20, 50, 100, 125, 250, 500, 800 or 1000 kbit/s.");
    pub const PORT_MOTOR: Param<i64> = int("Port Motor - Number", 0, Unit::None)
        .within(0, 1)
        .doc("Lutra: which motor of the card is to port; `lutra-agent motors test` finds out.");
    pub const PORT_REVERSED: Param<bool> = flag("Port Motor - Reversed", false)
        .doc("Lutra: whether the port motor turns astern where ahead is ordered.");
    pub const STARBOARD_REVERSED: Param<bool> = flag("Starboard Motor - Reversed", false)
        .doc("Lutra: whether the starboard motor turns astern where ahead is ordered.");
    pub const RAILS: Param<i64> = int("Card Rails", 5, Unit::None)
        .within(4, 5)
        .doc("Lutra: 4 for cards of the earlier document, whose 5 V output is on the fourth rail.");
    pub const WRITE_DIVIDER: Param<i64> = int("Motor write divider", 10, Unit::None)
        .within(1, 40)
        .doc("Every so many steps the motors are commanded; the card stops them after 1 s without.");
    pub const COMMAND_TIMEOUT: Param<f64> = float("Command Timeout", 0.5, Unit::Second)
        .within(0.1, 1.0)
        .doc("Lutra: without a new actuation for so long the motors are stopped.");
    pub const CHANNEL_NAME: Param<String> = text("Power Channel {} - Name", "")
        .each(CHANNELS)
        .doc("Name of a power channel; only named ones are switched.");
    pub const CHANNEL_STATE: Param<i64> = int("Power Channel {} - State", 0, Unit::None)
        .each(CHANNELS)
        .within(0, 1)
        .doc("Whether the channel is on at the start.");
    pub const MOTOR_LABEL: Param<String> = text("Motor {} - Label", "")
        .each(&["0", "1"])
        .doc("Entity label of a motor; `Motor 0` and `Motor 1` when not given.");
    pub const RAIL_LABEL: Param<String> = text("Rail {} - Label", "")
        .each(DIGITS)
        .doc("Entity label of a power rail; `Rail 0` and so on when not given.");
    pub const BATTERY_LABEL: Param<String> = text("Battery {} - Label", "")
        .each(DIGITS)
        .doc("Entity label of a battery; `Battery 0` and so on when not given.");

    pub static TORQEEDO: SectionSpec = SectionSpec::task(&["Actuators.Torqeedo"], "Torqeedo", "Hardware")
        .doc("Motors, batteries and power channels through the interface card.")
        .groups(&[
            OF_EVERY_TASK,
            &[
                FREQUENCY.spec,
                DEVICE.spec,
                BAUD_RATE.spec,
                BIT_RATE.spec,
                PORT_MOTOR.spec,
                PORT_REVERSED.spec,
                STARBOARD_REVERSED.spec,
                RAILS.spec,
                WRITE_DIVIDER.spec,
                COMMAND_TIMEOUT.spec,
                CHANNEL_NAME.spec,
                CHANNEL_STATE.spec,
                MOTOR_LABEL.spec,
                RAIL_LABEL.spec,
                BATTERY_LABEL.spec,
            ],
        ]);
}

pub mod board {
    use super::{
        OF_EVERY_TASK, Param, SectionSpec, Unit, choice, execution_frequency, float, ints, text, texts,
    };

    pub const FREQUENCY: Param<f64> = execution_frequency(0.5);
    pub const PULSE: Param<f64> = float("TimeToggled", 0.25, Unit::Second)
        .within(0.01, 1.0)
        .doc("How long each heartbeat pulse lasts.");

    pub const CHIP: Param<String> =
        text("GPIO Chip", "/dev/gpiochip0").doc("Lutra: the character device of the computer's pins.");

    pub static WATCHDOG: SectionSpec =
        SectionSpec::task(&["Safety.StratoPIWatchdog"], "Watchdog", "Hardware")
            .doc("Keeps the board from cutting the computer's power.")
            .groups(&[OF_EVERY_TASK, &[FREQUENCY.spec, PULSE.spec, CHIP.spec]]);

    pub const INTERFACE: Param<&str> =
        choice("Interface", "GPIO", &["GPIO"]).doc("How the lights are switched.");
    pub const PINS: Param<Vec<i64>> =
        ints("Identifiers", &[26], Unit::None).within(0, 53).doc("GPIO numbers (BCM) of the lights.");
    pub const CRITICAL: Param<Vec<String>> = texts("Critical Entities", &["Logger"])
        .doc("Entities whose failure shows the fatal pattern until the next start.");

    pub const PATTERN_NORMAL: Param<Vec<i64>> = ints("Pattern - Normal", &[1, 2000, 0, 2000], Unit::None)
        .doc("A pattern is repeated groups of one state for each light and a duration in ms.");
    pub const PATTERN_FUEL_LOW: Param<Vec<i64>> =
        ints("Pattern - Fuel Low", &[1, 200, 0, 200, 1, 200, 0, 2000], Unit::None)
            .doc("Shown when the batteries are low; DUNE never shows it.");
    pub const PATTERN_STARTING: Param<Vec<i64>> =
        ints("Pattern - Plan Starting", &[1, 200, 0, 2000], Unit::None).doc("Shown while a plan starts.");
    pub const PATTERN_EXECUTING: Param<Vec<i64>> =
        ints("Pattern - Plan Executing", &[1, 500, 0, 500], Unit::None).doc("Shown while a plan runs.");
    pub const PATTERN_ERROR: Param<Vec<i64>> =
        ints("Pattern - Error", &[1, 200, 0, 2000], Unit::None).doc("Shown in error.");
    pub const PATTERN_FATAL: Param<Vec<i64>> = ints("Pattern - Fatal Error", &[1, 200, 0, 2000], Unit::None)
        .doc("Shown after a critical entity has failed.");
    pub const PATTERN_SHUTDOWN: Param<Vec<i64>> =
        ints("Pattern - Shutdown", &[1, 200, 0, 2000], Unit::None).doc("Shown while the power goes off.");

    pub static LIGHTS: SectionSpec =
        SectionSpec::task(&["UserInterfaces.LEDs", "UserInterfaces.LEDsotter"], "Signal Light", "Hardware")
            .doc("The signal light.")
            .groups(&[
                OF_EVERY_TASK,
                &[
                    INTERFACE.spec,
                    CHIP.spec,
                    PINS.spec,
                    CRITICAL.spec,
                    PATTERN_NORMAL.spec,
                    PATTERN_FUEL_LOW.spec,
                    PATTERN_STARTING.spec,
                    PATTERN_EXECUTING.spec,
                    PATTERN_ERROR.spec,
                    PATTERN_FATAL.spec,
                    PATTERN_SHUTDOWN.spec,
                ],
            ]);
}
