use super::*;
use config::InMemory;

const FORCE: &str = "[Control.ASV.HeadingAndSpeed]\nEnabled = Never\n\
                     [Control.ASV.HeadingAndSpeedForce]\nEnabled = Always\n";

fn doubts_with(more: &str, profile: &str) -> Vec<String> {
    let files = InMemory::new().with("otter.ini", format!("{}\n{more}", crate::OTTER_INI));
    let config = Config::load(&files, "otter.ini".as_ref(), &[profile]);
    assert!(!config.report().has_errors(), "{}", config.report());
    doubts_of(&config)
}

fn doubts_of(config: &Config) -> Vec<String> {
    let (settings, _) = setup::settings(config, 1).unwrap();
    doubts(config, &settings)
}

#[test]
fn of_the_shipped_configuration_nothing_is_said() {
    for more in ["", FORCE] {
        for profile in ["Simulation", "Hardware"] {
            assert_eq!(doubts_with(more, profile), Vec::<String>::new(), "{profile}");
        }
    }
}

#[test]
fn nor_of_another_load_on_the_hull() {
    for payload_kg in [0, 45] {
        for more in ["", FORCE] {
            let more = format!("{more}[Simulators.VSIM]\nPayload = {payload_kg}\n");
            assert_eq!(doubts_with(&more, "Simulation"), Vec::<String>::new(), "{payload_kg} kg");
        }
    }
}

#[test]
fn gains_that_oscillate_are_told_with_figures_and_a_remedy() {
    let doubts = doubts_with("[Control.ASV.HeadingAndSpeed]\nYaw PID Gains = 3, 0, 0\n", "Simulation");
    assert_eq!(doubts.len(), 1, "{doubts:?}");
    println!("{}", doubts[0]);
    for said in
        ["[Control.ASV.HeadingAndSpeed]", "oscillates", "of full throttle a second", "Yaw PID Gains = 1,"]
    {
        assert!(doubts[0].contains(said), "{said}: {doubts:?}");
    }
}

#[test]
fn gains_that_are_too_weak_to_settle_are_told_as_such() {
    let doubts = doubts_with("[Control.ASV.HeadingAndSpeed]\nYaw PID Gains = 0.05, 0, 0\n", "Simulation");
    assert_eq!(doubts.len(), 1, "{doubts:?}");
    println!("{}", doubts[0]);
    assert!(doubts[0].contains("does not settle") && !doubts[0].contains("oscillates"), "{doubts:?}");
}

#[test]
fn a_speed_that_is_not_reached_is_told() {
    let gains = "MPS PID Gains = 20, 0, 0\nMPS Feedforward Gain = 1\n";
    let doubts = doubts_with(&format!("[Control.ASV.HeadingAndSpeed]\n{gains}"), "Simulation");
    assert_eq!(doubts.len(), 1, "{doubts:?}");
    println!("{}", doubts[0]);
    assert!(
        doubts[0].contains("asked for 3.0 m/s it makes") && !doubts[0].contains("oscillates"),
        "{doubts:?}"
    );
}

#[test]
fn a_speed_that_the_files_do_not_allow_is_not_asked_for() {
    let slow = "[Control.ASV.HeadingAndSpeed]\nMaximum Thrust Actuation = 0.7\n";
    assert_eq!(doubts_with(slow, "Simulation"), Vec::<String>::new());
}

#[test]
fn a_compass_that_is_too_slow_for_the_gains_is_told() {
    let doubts = doubts_with("[Simulators.GPS]\nExecution Frequency = 1\n", "Simulation");
    assert!(doubts.len() == 1 && doubts[0].contains("The compass gives 1 Hz"), "{doubts:?}");
}

#[test]
fn the_otters_own_gains_are_told() {
    let Some(folder) = testkit::shared("data/onboard/ini/user/etc") else { return };
    // The files of the boats cut what one motor cannot give from the turn.
    for (profile, section, remedy) in [
        ("Simulation", "[Control.ASV.HeadingAndSpeed]", "with `Share Saturation = true` mend it"),
        ("Hardware", "[Control.ASV.HeadingAndSpeedForce]", "`Yaw PID Gains = 225, 10, 180`"),
    ] {
        let config = Config::load(&config::Disk, &folder.join("ntnu-otter-01.ini"), &[profile]);
        assert!(!config.report().has_errors(), "{profile}: {}", config.report());
        let doubts = doubts_of(&config);
        println!("{profile}: {doubts:?}");
        assert!(doubts.len() == 1 && doubts[0].starts_with(section), "{profile}: {doubts:?}");
        assert!(doubts[0].contains(remedy), "{profile}: {doubts:?}");
    }
}
