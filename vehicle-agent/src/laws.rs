//! Control laws from the configuration files: path following, manual steering and maneuvers.
//!
//! These are the choices between laws and the parameters of each; parameters that consoles may change at run time are in
//! `onboard::parameters`. A set of values that a controller refuses changes nothing and is reported.

use config::schema::control::remote;
use config::schema::mission::maneuver;
use config::schema::path::{self, ilos, vector_field};
use config::{Config, Section};
use control::{
    AlongTrackConfig, CrossTrackConfig, Drive, ExtendedField, JumpConfig, Law, Mixing, NearRule,
    OutsideCorridor, PathConfig, RemoteConfig, ThrustMap,
};
use mission::{FollowSystemConfig, ManeuverKind, ScheduledGotoConfig, TrajectoryConfig};
use onboard::Settings;
use std::time::Duration;
use units::Speed;

/// Time in which a held button changes the throttle by one step (s): the original controllers step once for each message,
/// of which consoles send ten a second.
const STEP_S: f64 = 0.1;

/// Takes over the values of the files.
pub(crate) fn adopt(config: &Config, settings: &mut Settings, doubts: &mut Vec<String>) {
    for spec in [&ilos::ILOS, &path::PURE_PURSUIT, &vector_field::VECTOR_FIELD] {
        for section in config.running(spec) {
            settings.path_report = Duration::from_secs_f64(1.0 / section.get(&path::STATE_REPORT_FREQUENCY));
            let wanted = tracking(section, settings.path);
            match wanted.validate() {
                Ok(()) => settings.path = wanted,
                Err(error) => doubts.push(format!("[{}] {error}; the usual values are used", section.name())),
            }
        }
    }
    for section in config.running(&ilos::ILOS) {
        settings.path.loiter_capture_m = Some(section.get(&ilos::CORRIDOR_LOITER));
    }
    leg_law(config, settings);
    maneuvers(config, settings, doubts);
    for section in config.running(&remote::REMOTE) {
        let wanted = RemoteConfig {
            mixing: mixing(section, settings, doubts),
            output_period_s: 1.0 / section.get(&remote::FREQUENCY),
            throttle_per_s: section.get(&remote::SPEED_STEP) / STEP_S,
            heading_step_rad: section.get(&remote::YAW_STEP).to_radians(),
            ..settings.remote
        };
        match wanted.validate() {
            Ok(()) => settings.remote = wanted,
            Err(error) => doubts.push(format!("[{}] {error}; the usual values are used", section.name())),
        }
    }
}

/// Settings of all laws: when a path is done, and its monitoring.
fn tracking(section: &Section, usual: PathConfig) -> PathConfig {
    let radius_m = section.get(&path::RADIUS_TO_ENDPOINT);
    let uncertainty = section.get(&path::CROSS_UNCERTAINTY);
    PathConfig {
        near: if radius_m < 0.0 { NearRule::TimeToArrival } else { NearRule::Radius(radius_m) },
        course_control: section.get(&path::COURSE_CONTROL),
        max_length_m: section.get(&path::MAXIMUM_TRACK_LENGTH),
        along_track: section.get(&path::ALONG_MONITOR).then(|| AlongTrackConfig {
            period_s: section.get(&path::ALONG_PERIOD),
            min_speed_mps: section.get(&path::ALONG_SPEED),
            min_yaw_rate_rad_s: section.get(&path::ALONG_YAW).to_radians(),
        }),
        cross_track: section.get(&path::CROSS_MONITOR).then(|| CrossTrackConfig {
            limit_m: section.get(&path::CROSS_DISTANCE),
            uncertainty_factor: Some(uncertainty).filter(|factor| *factor > 0.0),
            time_limit_s: section.get(&path::CROSS_TIME),
        }),
        jump: JumpConfig { recovery_mps: section.get(&path::JUMP_TIME_FACTOR), ..usual.jump },
        ..usual
    }
}

fn leg_law(config: &Config, settings: &mut Settings) {
    match &mut settings.guidance.leg {
        Law::Ilos(law) => {
            for section in config.running(&ilos::ILOS) {
                law.integrator_start = section.get(&ilos::INTEGRATOR_INITIAL);
                let field = section.get(&ilos::OUT_VECTOR_FIELD);
                law.outside = match (field, section.get(&ilos::OUT_LINE_OF_SIGHT)) {
                    (true, _) => OutsideCorridor::VectorField,
                    (false, true) => OutsideCorridor::LineOfSight,
                    (false, false) => OutsideCorridor::Ilos,
                };
            }
        }
        Law::VectorField(law) => {
            for section in config.running(&vector_field::VECTOR_FIELD) {
                law.extended = section.get(&vector_field::EXTENDED).then(|| ExtendedField {
                    exponent: section.get(&vector_field::EXTENDED_GAIN),
                    turn_rate_gain: section.get(&vector_field::EXTENDED_TURN_GAIN),
                });
            }
        }
        Law::PurePursuit => {}
    }
}

fn maneuvers(config: &Config, settings: &mut Settings, doubts: &mut Vec<String>) {
    let behaviour = &mut settings.mission.engine.maneuver;
    for section in config.running(&maneuver::MULTIPLEXER) {
        behaviour.scheduled = ScheduledGotoConfig {
            min_mps: section.get(&maneuver::SCHEDULED_MINIMUM),
            max_mps: section.get(&maneuver::SCHEDULED_MAXIMUM),
        };
        for name in section.get(&maneuver::UNSUPPORTED) {
            match kind(&name) {
                Some(kind) => {
                    settings.mission.limits.refused.insert(kind);
                }
                None => doubts.push(format!("[{}] Unsupported: no maneuver '{name}'", section.name())),
            }
        }
    }
    for section in config.running(&maneuver::FOLLOW_REFERENCE) {
        behaviour.reference.default_radius_m = section.get(&maneuver::FOLLOW_RADIUS);
        let speed = section.get(&maneuver::FOLLOW_SPEED);
        behaviour.reference.default_speed = match section.get(&maneuver::FOLLOW_SPEED_UNITS) {
            "rpm" => Speed::Rpm(speed),
            "m/s" => Speed::MetresPerSecond(speed),
            _ => Speed::Percent(speed),
        };
        behaviour.reference.separation_m = section.get(&maneuver::SEPARATION);
    }
    for section in config.running(&maneuver::FOLLOW_TRAJECTORY) {
        behaviour.trajectory = TrajectoryConfig {
            tolerance_s: section.get(&maneuver::TRAJECTORY_DELAY),
            corrected_min_mps: section.get(&maneuver::TRAJECTORY_MINIMUM),
            corrected_max_mps: section.get(&maneuver::TRAJECTORY_MAXIMUM),
        };
        settings.mission.limits.max_timed_mps = section.get(&maneuver::TRAJECTORY_MAXIMUM);
    }
    for section in config.running(&maneuver::FOLLOW_SYSTEM) {
        behaviour.system = FollowSystemConfig {
            min_displace_m: section.get(&maneuver::FOLLOW_DISPLACEMENT),
            safety_m: section.get(&maneuver::FOLLOW_STOP),
            slack_m: section.get(&maneuver::FOLLOW_TOLERANCE),
            silence: Duration::from_secs_f64(section.get(&maneuver::FOLLOW_TIMEOUT)),
        };
    }
}

/// A maneuver by its name in the files, which is IMC's.
fn kind(name: &str) -> Option<ManeuverKind> {
    use ManeuverKind::{
        FollowPath, FollowReference, FollowSystem, FollowTrajectory, Goto, Idle, Launch, Loiter, Rows,
        RowsCoverage, ScheduledGoto, StationKeeping, Teleoperation,
    };
    let all = [
        ("IdleManeuver", Idle),
        ("Goto", Goto),
        ("Launch", Launch),
        ("Loiter", Loiter),
        ("StationKeeping", StationKeeping),
        ("Rows", Rows),
        ("RowsCoverage", RowsCoverage),
        ("FollowPath", FollowPath),
        ("FollowTrajectory", FollowTrajectory),
        ("ScheduledGoto", ScheduledGoto),
        ("FollowReference", FollowReference),
        ("FollowSystem", FollowSystem),
        ("Teleoperation", Teleoperation),
    ];
    all.into_iter().find_map(|(known, kind)| (known == name).then_some(kind))
}

fn mixing(section: &Section, settings: &Settings, doubts: &mut Vec<String>) -> Mixing {
    let normal = match section.get(&remote::MIXING) {
        "proportional" => Mixing::Scaled,
        _ => Mixing::Additive,
    };
    match section.get(&remote::RC_MODE) {
        0 => normal,
        1 => Mixing::ForceLinear(match settings.control.drive {
            Drive::Force { map, .. } => map,
            Drive::Rpm { .. } => ThrustMap::FOSSEN_OTTER,
        }),
        2 => Mixing::Skewed { outer_share: section.get(&remote::SKEW) },
        3 => Mixing::Autopilot {
            max_speed_mps: section.get(&remote::AUTOPILOT_SPEED),
            max_turn_rad: section.get(&remote::AUTOPILOT_YAW).to_radians(),
        },
        mode => {
            doubts.push(format!(
                "[{}] RC mode: there is no mode {mode}; 0 is used, as in the original",
                section.name()
            ));
            normal
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use config::InMemory;
    use control::GuidanceConfig;

    fn adopted(text: &str) -> (Settings, Vec<String>) {
        let head = "[General]\nVehicle = v\n[IMC Addresses]\nv = 1\n";
        let files = InMemory::new().with("v.ini", format!("{head}{text}\n"));
        let config = Config::load(&files, "v.ini".as_ref(), &["Simulation"]);
        crate::setup::settings(&config, 1).unwrap_or_else(|error| panic!("{error}: {}", config.report()))
    }

    fn pair(section: &str, label: &str, values: &str) -> (Settings, Vec<String>) {
        adopted(&format!("[{section}]\nEnabled = Always\nEntity Label = {label}\n{values}"))
    }

    #[test]
    fn the_law_and_its_parameters_are_those_of_the_section_that_runs() {
        let (ilos, doubts) = pair(
            "Control.Path.ILOS",
            "Path Control",
            "Corridor -- Out LOS = true\nILOS Integrator Initial Value = 2\nCorridor -- Loiter = 3",
        );
        assert_eq!(doubts, Vec::<String>::new());
        let Law::Ilos(law) = ilos.guidance.leg else { panic!("{:?}", ilos.guidance) };
        assert_eq!((law.outside, law.integrator_start), (OutsideCorridor::LineOfSight, 2.0));
        assert_eq!(ilos.path.loiter_capture_m, Some(3.0));
        let (field, _) = pair(
            "Control.Path.VectorField",
            "Path Control",
            "Extended Control -- Enabled = true\nExtended Control -- Controller Gain = 2\n\
             Extended Control -- Turn Rate Gain = 3",
        );
        let Law::VectorField(law) = field.guidance.leg else { panic!("{:?}", field.guidance) };
        assert_eq!(law.extended, Some(ExtendedField { exponent: 2.0, turn_rate_gain: 3.0 }));
        let (pursuit, _) = pair("Control.Path.PurePursuit", "Path Control", "");
        let expected = GuidanceConfig { leg: Law::PurePursuit, ..GuidanceConfig::default() };
        assert_eq!(pursuit.guidance, expected);
    }

    #[test]
    fn every_law_is_watched_as_its_section_says() {
        for task in ["ILOS", "PurePursuit", "VectorField"] {
            let (settings, doubts) = pair(
                &format!("Control.Path.{task}"),
                "Path Control",
                "Along-track -- Monitor = false\nCross-track -- Distance Limit = 40\n\
                 Cross-track -- Nav. Unc. Factor = 2\nCross-track -- Time Limit = 7\n\
                 Radius To Endpoint = 5\nMaximum Track Length = 900\nCourse Control = false\n\
                 Position Jump Time Factor = 0.7\nState Report Frequency = 4",
            );
            assert_eq!(doubts, Vec::<String>::new(), "{task}");
            let path = settings.path;
            assert_eq!((path.along_track, path.near), (None, NearRule::Radius(5.0)), "{task}");
            assert_eq!((path.max_length_m, path.course_control, path.jump.recovery_mps), (900.0, false, 0.7));
            let cross = CrossTrackConfig { limit_m: 40.0, uncertainty_factor: Some(2.0), time_limit_s: 7.0 };
            assert_eq!(path.cross_track, Some(cross), "{task}");
            assert_eq!(settings.path_report, Duration::from_millis(250), "{task}");
        }
    }

    #[test]
    fn values_that_path_control_refuses_are_told() {
        let (settings, doubts) = pair("Control.Path.PurePursuit", "Path Control", "Radius To Endpoint = 0.1");
        assert_eq!(settings.path.near, NearRule::TimeToArrival);
        assert!(doubts.len() == 1 && doubts[0].contains("near_radius"), "{doubts:?}");
    }

    #[test]
    fn sticks_steer_by_the_mode_of_the_files() {
        let mode = |values: &str| pair("Control.ASV.RemoteOperation", "Remote Control", values);
        for (values, mixing) in [
            ("", Mixing::Additive),
            ("Mixing = proportional", Mixing::Scaled),
            ("RC mode = 1", Mixing::ForceLinear(ThrustMap::FOSSEN_OTTER)),
            ("RC mode = 2\nSkewed Motor Force Factor = 0.4", Mixing::Skewed { outer_share: 0.4 }),
            ("RC mode = 3", Mixing::Autopilot { max_speed_mps: 2.3, max_turn_rad: std::f64::consts::PI }),
            (
                "RC mode = 3\nAutopilot Max Speed = 1.5\nAutopuilot Max Yaw = 90",
                Mixing::Autopilot { max_speed_mps: 1.5, max_turn_rad: std::f64::consts::FRAC_PI_2 },
            ),
        ] {
            let (settings, doubts) = mode(values);
            assert_eq!(settings.remote.mixing, mixing);
            assert_eq!(doubts, Vec::<String>::new());
        }
        let (settings, _) = mode("Speed step = 0.02\nYaw step = 45");
        assert!((settings.remote.throttle_per_s - 0.2).abs() < 1e-12);
        assert!((settings.remote.heading_step_rad - std::f64::consts::FRAC_PI_4).abs() < 1e-12);
        let (settings, doubts) = mode("RC mode = 4\nExecution Frequency = 20");
        assert_eq!(settings.remote.mixing, Mixing::Additive);
        assert!((settings.remote.output_period_s - 0.05).abs() < 1e-12);
        assert!(doubts.len() == 1 && doubts[0].contains("no mode 4"), "{doubts:?}");
    }

    #[test]
    fn maneuvers_behave_as_the_files_say() {
        let (settings, doubts) = adopted(
            "[Maneuver.Multiplexer]\nEnabled = Always\nEntity Label = Multiplexer Maneuver\n\
             Unsupported = Launch, Dance\nScheduledGoto -- Maximum Speed = 2\n\
             [Maneuver.FollowReference.ASV]\nEnabled = Always\nEntity Label = Follow Reference Maneuver\n\
             Default Speed = 1.2\nDefault Speed Units = m/s\nMinimum Separation = 20\n\
             [Maneuver.FollowSystem]\nEnabled = Always\nEntity Label = Follow System Maneuver\n\
             Stop Distance = 25\nAnnounce Timeout = 90\n\
             [Maneuver.FollowTrajectory]\nEnabled = Always\nEntity Label = Follow Trajectory Maneuver\n\
             Maximum Speed = 1.5",
        );
        let behaviour = settings.mission.engine.maneuver;
        assert_eq!(behaviour.scheduled, ScheduledGotoConfig { min_mps: 0.7, max_mps: 2.0 });
        assert_eq!(behaviour.reference.default_speed, Speed::MetresPerSecond(1.2));
        assert!((behaviour.reference.separation_m - 20.0).abs() < 1e-9);
        let system = FollowSystemConfig {
            safety_m: 25.0,
            silence: Duration::from_secs(90),
            ..FollowSystemConfig::default()
        };
        assert_eq!(behaviour.system, system);
        assert!((settings.mission.limits.max_timed_mps - 1.5).abs() < 1e-9);
        assert_eq!(settings.mission.limits.refused, [ManeuverKind::Launch].into());
        assert!(doubts.len() == 1 && doubts[0].contains("no maneuver 'Dance'"), "{doubts:?}");
    }
}
