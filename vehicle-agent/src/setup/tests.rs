use super::*;
use config::{InMemory, Ini, Saved};
use onboard::ChartTrust;
use onboard::parameters::Access;

const OTTER: &str = "etc/otter.ini";

fn load(text: &str, saved: &str) -> Config {
    let files = InMemory::new().with(OTTER, text).with("etc/ntnu-otter-01-saved.ini", saved);
    let config = Config::load(&files, Path::new(OTTER), &["Simulation"]);
    assert!(!config.report().has_errors(), "{}", config.report());
    config
}

fn values(settings: &Settings) -> Vec<(&'static str, Option<String>)> {
    parameters::all().iter().map(|parameter| (parameter.name, parameter.get(settings))).collect()
}

/// The same vessel with the rpm controller, and with the force controller.
fn setups() -> [String; 2] {
    let rpm = crate::OTTER_INI.to_owned();
    let (before, after) = rpm.split_once("[Control.ASV.HeadingAndSpeed]").unwrap();
    let after = after.replacen("Enabled = Always", "Enabled = Hardware", 1);
    let force = after.replacen("Enabled = Never", "Enabled = Simulation", 1);
    let force = format!("{before}[Control.ASV.HeadingAndSpeed]{force}");
    [rpm, force]
}

#[test]
fn what_check_prints_is_what_is_in_force() {
    for text in setups() {
        let config = load(&text, "");
        let (settings, doubts) = settings(&config, 1).unwrap();
        assert_eq!(doubts, Vec::<String>::new());
        let mut seen = 0;
        for parameter in parameters::all() {
            let Some((section, printed)) = home(&config, &parameter) else { continue };
            let Some(in_force) = parameter.get(&settings) else { continue };
            assert_eq!(in_force, printed, "[{section}] {}", parameter.name);
            seen += 1;
        }
        assert!(seen > 25, "{seen}");
    }
}

#[test]
fn every_parameter_set_and_saved_is_the_same_after_a_restart() {
    for text in setups() {
        let config = load(&text, "");
        let (before, _) = settings(&config, 1).unwrap();
        for parameter in parameters::all().iter().filter(|parameter| parameter.access == Access::Live) {
            let Some(old) = parameter.get(&before) else { continue };
            if home(&config, parameter).is_none() {
                continue; // its task does not run, so that no console is told of it to any effect
            }
            let mut changed = before.clone();
            let other = ["1", "0.5", "2", "7", "20", "600", "0.1, 0.2, 0.3"];
            let new = other.iter().find(|new| **new != old && parameter.set(&mut changed, new).is_ok());
            let new = new.unwrap_or_else(|| panic!("{}", parameter.name));
            let mut saved = Saved::default();
            let label = before.labels.of(parameter.entity);
            let wanted = values(&changed);
            let own = [(parameter.name.to_owned(), parameter.get(&changed).unwrap())];
            save(&config, &mut saved, label, &own).unwrap();
            let again = load(&text, &saved.to_text().unwrap());
            let (after, doubts) = settings(&again, 1).unwrap();
            assert_eq!(values(&after), wanted, "{} = {new}", parameter.name);
            assert_eq!(doubts, Vec::<String>::new());
        }
    }
}

#[test]
fn the_levels_of_the_battery_mean_the_same_on_the_wire_and_in_the_file() {
    let levels = "Warning Level = 50\nReserve Level = 40\nError Level = 15\nReserve Action = hold\n";
    let text = format!("{}\n[Monitors.FuelLevel]\n{levels}", crate::OTTER_INI);
    let (settings, _) = settings(&load(&text, ""), 1).unwrap();
    let battery = settings.watch.battery;
    assert!((battery.low - 0.5).abs() < 1e-12 && (battery.reserve - 0.4).abs() < 1e-12);
    assert!((battery.critical - 0.15).abs() < 1e-12);
    assert_eq!((battery.reserve_remedy, battery.critical_remedy), (Some(Remedy::Hold), Some(Remedy::Hold)));
}

#[test]
fn a_saved_value_of_an_older_version_does_not_keep_the_vessel_ashore() {
    let saved = "[Supervisors.OperationalLimits]\nMaximum Speed = -1\n[Control.ASV.HeadingAndSpeed]\n\
                 Ramp Actuation Limit = 0.001\nYaw PID Gains = 2, 0, 0\n";
    let config = load(crate::OTTER_INI, saved);
    let (settings, doubts) = settings(&config, 1).unwrap();
    assert_eq!(settings.watch.limits.max_speed_mps, Some(3.1));
    assert!((settings.control.yaw.pid.kp - 2.0).abs() < f64::EPSILON);
    assert_eq!(settings.control.output.ramp_per_s, None);
    assert_eq!(doubts.len(), 1, "{doubts:?}");
    let now = units::Now { mono: units::MonoTime::default(), utc: UtcTime::default() };
    onboard::Brain::new(settings, now, mission::Kept::default()).unwrap();
}

#[test]
fn what_has_no_section_that_runs_is_not_said_to_be_saved() {
    let config = load(&crate::OTTER_INI.replace("[Maneuver.FollowReference.ASV]", "[Ignored]"), "");
    let value = [("Horizontal Tolerance".to_owned(), "20".to_owned())];
    let mut saved = Saved::from_ini(&Ini::default());
    let label = settings(&config, 1).unwrap().0.labels.of(Entity::Maneuver).to_owned();
    assert!(save(&config, &mut saved, &label, &value).is_err());
    assert_eq!(saved, Saved::default());
}

#[test]
fn batteries_and_power_rails_have_the_labels_of_the_card_s_section() {
    let more = "[Actuators.Torqeedo]\nEnabled = Always\nRail 4 - Label = 5 V\nRail 9 - Label = none such\n\
                Battery 1 - Label = Battery Starboard\nBattery 2 - Label =\n";
    let (settings, _) = settings(&load(&format!("{}\n{more}", crate::OTTER_INI), ""), 1).unwrap();
    let labels =
        [Entity::Rail4, Entity::Rail3, Entity::Battery1, Entity::Battery2].map(|e| settings.labels.of(e));
    assert_eq!(labels, ["5 V", "Rail 3", "Battery Starboard", "Battery 2"]);
}

#[test]
fn compass_hydrophone_and_motors_have_the_labels_of_their_sections() {
    let labels = |more: &str| {
        let (settings, doubts) = settings(&load(&format!("{}\n{more}", crate::OTTER_INI), ""), 1).unwrap();
        assert_eq!(doubts, Vec::<String>::new());
        let all = [Entity::Gps, Entity::Hydrophone, Entity::MotorPort, Entity::MotorStarboard];
        all.map(|entity| settings.labels.of(entity).to_owned())
    };
    let usual = ["GPS", "Hydrophone", "Motor Port", "Motor Starboard"];
    assert_eq!(labels(""), usual, "what does not run gives no name");
    let devices = "[Simulators.GPS]\nEnabled = Never\n[Sensors.GPS]\nEnabled = Simulation\nEntity Label = Kompass\n\
                   [Navigation.General.GPSNavigation]\nEntity Label - GPS = Kompass\nEntity Label - IMU = Kompass\n\
                   Entity Label - Yaw = Kompass\n[Monitors.Entities]\nDefault Monitoring = Kompass\n\
                   [Supervisors.Vehicle]\nVital Entities = Kompass\n\
                   [Sensors.ThelmaHydrophone]\nEnabled = Simulation\nEntity Label = Lytter\n\
                   [Actuators.Torqeedo]\nEnabled = Simulation\nPort Motor - Number = 1\nMotor 0 - Label = Styrbord\n\
                   Motor 1 - Label = Babord\n";
    assert_eq!(labels(devices), ["Kompass", "Lytter", "Babord", "Styrbord"]);
    let line = "[Sensors.LineReceiver]\nEnabled = Simulation\nEntity Label = VR2C\n";
    assert_eq!(labels(line)[1], "VR2C");
}

#[test]
fn voltages_and_silences_of_the_files_are_obeyed() {
    let more = "[Monitors.FuelLevel]\nWarning Voltage = 26\nError Voltage = 24.5\n\
                [Supervisors.Vehicle]\nManeuver Handling Timeout = 3\nVital Entities = GPS\n\
                [Monitors.Entities]\nReport Timeout = 1.5\nDefault Monitoring = Navigation, UDP\n\
                [Supervisors.OperationalLimits]\nAction = warn\nArea = 63, 10, 64, 10, 64, 11\n";
    let config = load(&format!("{}\n{more}", crate::OTTER_INI), "");
    let (settings, doubts) = settings(&config, 1).unwrap();
    assert_eq!(doubts, Vec::<String>::new());
    let watch = &settings.watch;
    assert_eq!((watch.battery.low_v, watch.battery.reserve_v), (Some(26.0), Some(24.5)));
    assert_eq!(settings.mission.engine.maneuver.path_silence, Duration::from_secs(3));
    let least = Duration::from_millis(1500);
    assert_eq!((watch.gnss_timeout, watch.motor_timeout), (least, least));
    assert_eq!(watch.vital, [Entity::Gps]);
    assert!(watch.monitored.contains(&Entity::Udp) && watch.monitored.contains(&Entity::MotorPort));
    assert!(watch.limits.area.is_some() && watch.limits.max_speed_mps.is_some(), "watched");
    assert_eq!((&watch.limits.area_remedy, &watch.limits.speed_remedy), (&None, &None), "and told");
    assert!(settings.mission.limits.area.is_some(), "plans must stay inside all the same");
}

#[test]
fn a_part_that_lutra_does_not_watch_is_told() {
    let more = "[Monitors.Entities]\nDefault Monitoring = Navigation, Simulation Engine\n";
    let config = load(&format!("{}\n{more}", crate::OTTER_INI), "");
    let (_, doubts) = settings(&config, 1).unwrap();
    assert_eq!(doubts, ["[Monitors.Entities] `Simulation Engine` is not a part that Lutra watches"]);
}

const START: UtcTime = UtcTime::from_micros(1_790_000_100_000_000);

/// The simulated vessel of the shipped configuration with lines after it.
fn vessel_with(more: &str) -> anyhow::Result<sim::VesselConfig> {
    let files = config::InMemory::new().with("otter.ini", format!("{}\n{more}", crate::OTTER_INI));
    let config = Config::load(&files, "otter.ini".as_ref(), &["Simulation"]);
    assert!(!config.report().has_errors(), "{}", config.report());
    vessel(&config, START, 1)
}

#[test]
fn fish_swim_where_the_configuration_has_them() {
    assert!(vessel_with("").unwrap().fish.is_empty());
    let fish = |number: u32, beginning_s: i64| {
        format!(
            "[Simulators.Fish/{number}]\nEnabled = Simulation\nEntity Label = Fish {number}\nTag Number = \
             {number}\nBeginning = {beginning_s}\nArea -- Centre = 63.44, 10.35\n"
        )
    };
    let found = vessel_with(&(fish(7, 1_790_000_000) + &fish(8, 0))).unwrap();
    assert_eq!(found.fish.iter().map(|fish| fish.tag_id).collect::<Vec<_>>(), [7, 8]);
    assert_eq!(found.fish[0].since.micros(), 1_790_000_000_000_000);
    assert_eq!(found.fish[1].since, START);
    sim::Vessel::new(&found).unwrap();
    // Another vessel hears the same fish with a receiver of another number.
    let other = "[General]\nVehicle = other\n[IMC Addresses]\nother = 0x28D1\n";
    let other = vessel_with(&(fish(7, 1_790_000_000) + other)).unwrap();
    assert_eq!(other.fish[0], found.fish[0]);
    assert_ne!(other.hydrophone.serial, found.hydrophone.serial);
}

#[test]
fn a_fish_that_cannot_be_names_its_section() {
    let wrong = "[Simulators.Fish/odd]\nEnabled = Simulation\nEntity Label = Odd\nTag Interval = 90, 30\n";
    let told = format!("{:#}", vessel_with(wrong).unwrap_err());
    assert!(told.contains("[Simulators.Fish/odd]") && told.contains("longest tag interval"), "{told}");
}

#[test]
fn the_shipped_configuration_is_as_the_schema_writes_it() {
    // Rebuild it: cargo run -p config --example otter_ini > vehicle-agent/etc/otter.ini
    assert!(crate::OTTER_INI == config::documented_ini(&config::Vessel::default()).unwrap());
}

#[test]
fn the_chart_and_the_words_of_the_grounding_supervisor_are_obeyed() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path();
    let path = folder.join("chart.lutra-index");
    let chart = testkit::sea::Sea::new(LatLon::from_deg(63.33, 10.08).unwrap(), 500.0, 20.0).index();
    std::fs::write(&path, chart.to_bytes()).unwrap();
    let with = |chart: &Path| {
        let more = format!(
            "[Supervisors.Grounding]\nChart = {}\nUnreadable Chart = warn\nChart Trust = all errors\n\
             Action = stop\nAutonomous Depth = 4\n",
            chart.display()
        );
        settings(&load(&format!("{}\n{more}", crate::OTTER_INI), ""), 1).unwrap()
    };
    let (good, doubts) = with(&path);
    assert_eq!(doubts, Vec::<String>::new());
    assert_eq!(good.grounding.chart, Chart::of(&path.display().to_string(), chart));
    assert_eq!((good.grounding.action, good.grounding.refuses_without), (GroundingAction::Stop, false));
    assert_eq!(good.grounding.limits.trust, ChartTrust::AllErrors(ChartTrust::STANDARD));
    assert!((good.grounding.limits.autonomous_m - 4.0).abs() < 1e-9);
    std::fs::write(&path, b"no chart").unwrap();
    assert!(matches!(with(&path).0.grounding.chart, Chart::Unreadable { .. }));
    assert!(matches!(with(&folder.join("absent")).0.grounding.chart, Chart::Unreadable { .. }));
    assert_eq!(settings(&load(crate::OTTER_INI, ""), 1).unwrap().0.grounding.chart, Chart::Off);
}

#[test]
fn the_hydrophone_is_where_the_files_say_and_a_transmission_as_long() {
    let more = "\n[Sensors.ThelmaHydrophone]\nEnabled = Simulation\nTransmission Time = 4.5\nLever Arm - Forward = -0.8\n\
                Lever Arm - Starboard = 0.25\nLever Arm - Down = 1.1\n";
    let (settings, _) = settings(&load(&format!("{}{more}", crate::OTTER_INI), ""), 1).unwrap();
    let arm = LeverArm { forward_m: -0.8, starboard_m: 0.25, down_m: 1.1 };
    let expected = HydrophoneSettings { transmission: Duration::from_millis(4500), arm };
    assert_eq!(settings.hydrophone, expected);
}
