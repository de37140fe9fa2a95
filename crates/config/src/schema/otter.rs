//! The values that Lutra's own configuration of an Otter has in place of the defaults.
//!
//! Sources: the boats' public configuration files, the thesis (NTNU 2020), and the
//! minimum radii of DUNE's own otter.ini. What belongs to the gains of course and speed control is tuned with them
//! on the model of the hull (`control::CourseSpeedConfig`).

/// Section, key and value, each a key of the schema.
pub static OTTER_VALUES: &[(&str, &str, &str)] = &[
    ("Control.ASV.HeadingAndSpeed", "Share Saturation", "true"),
    ("Control.ASV.HeadingAndSpeed", "Yaw Integral Limit", "0.1"),
    ("Control.ASV.HeadingAndSpeed", "Maximum Thrust Differential Actuation", "1"),
    ("Control.ASV.HeadingAndSpeed", "RPMs at Maximum Thrust", "1100"),
    ("Control.ASV.HeadingAndSpeed", "RPMs Feedforward Gain", "0.00046"),
    ("Control.ASV.HeadingAndSpeed", "MPS Integral Limit", "300"),
    ("Control.ASV.HeadingAndSpeed", "Minimum RPM Limit", "0"),
    ("Control.ASV.HeadingAndSpeed", "Maximum RPM Limit", "1100"),
    ("Control.ASV.HeadingAndSpeed", "Maximum RPM Acceleration", "62"),
    ("Control.ASV.HeadingAndSpeedForce", "MPS Force Integral Limit", "100"),
    ("Control.ASV.HeadingAndSpeedForce", "MPS Force Feedforward Gain", "77.55"),
    ("Control.ASV.HeadingAndSpeedForce", "Minimum Force Limit", "-30"),
    ("Control.ASV.HeadingAndSpeedForce", "Minimum speed to use course", "0.4"),
    ("Control.Path.ILOS", "Along-track -- Check Period", "20"),
    ("Control.Path.ILOS", "Along-track -- Minimum Speed", "0.05"),
    ("Control.Path.ILOS", "Along-track -- Minimum Yaw", "2"),
    ("Control.Path.ILOS", "Cross-track -- Distance Limit", "25"),
    ("Control.Path.ILOS", "Cross-track -- Time Limit", "20"),
    ("Control.Path.ILOS", "Position Jump Threshold", "10"),
    ("Control.Path.ILOS", "Position Jump Time Factor", "0.5"),
    ("Control.Path.ILOS", "ETA Minimum Speed", "0.1"),
    ("Control.Path.ILOS", "Corridor -- Width", "3"),
    ("Control.Path.ILOS", "Corridor -- Out Vector Field", "true"),
    ("Control.Path.ILOS", "ILOS Integrator Gain", "0.5"),
    ("Control.ASV.RemoteOperation", "Connection Timeout", "2"),
    ("Maneuver.Multiplexer", "Loiter -- Minimum Radius", "1"),
    ("Maneuver.Multiplexer", "StationKeeping -- Minimum Radius", "2"),
    ("Maneuver.FollowReference.ASV", "Horizontal Tolerance", "30"),
    ("Supervisors.ASV.LostComms", "Plan Name", "lost_comms"),
    ("Sensors.GPS", "Serial Port - Baud Rate", "115200"),
    // A Hemisphere V104s sends only the sentences it is set to: all that the vessel needs, five times a second.
    ("Sensors.GPS", "Initialization String 0 - Command", r"$JASC,GPGGA,5\r\n"),
    ("Sensors.GPS", "Initialization String 1 - Command", r"$JASC,GPVTG,5\r\n"),
    ("Sensors.GPS", "Initialization String 2 - Command", r"$JASC,GPZDA,5\r\n"),
    ("Sensors.GPS", "Initialization String 3 - Command", r"$JATT,NMEAHE,0\r\n"),
    ("Sensors.GPS", "Initialization String 4 - Command", r"$JASC,GPROT,5\r\n"),
    ("Sensors.GPS", "Initialization String 5 - Command", r"$JASC,GPHDT,5\r\n"),
    ("Sensors.GPS", "Initialization String 6 - Command", r"$JASC,GPHDM,5\r\n"),
    ("Sensors.ThelmaHydrophone", "Serial Port - Device", "/dev/ttyAMA0"),
    ("Sensors.ThelmaHydrophone", "Serial Port - Baud Rate", "115200"),
];

/// The Otter's value of a key, where it is not the default.
pub fn otter_value(section: &str, key: &str) -> Option<&'static str> {
    let found = OTTER_VALUES.iter().find(|(of, name, _)| *of == section && *name == key);
    found.map(|(_, _, value)| *value)
}
