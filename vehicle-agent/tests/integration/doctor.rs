//! `doctor` and `motors test` with simulated devices: their findings and remedies.
//!
//! A device that does not answer takes the seconds that its driver gives it.

use crate::common::devices::Devices;
use crate::common::{Console, far_plan, program};
use serde_json::Value;
use std::io::Write as _;
use std::process::{Output, Stdio};

fn doctor(devices: &Devices) -> (Option<i32>, Value) {
    let folder = devices.folder.path();
    let out = program()
        .args(["doctor", "--json"])
        .arg(folder.join("otter.ini"))
        .arg("--data")
        .arg(folder)
        .output()
        .unwrap();
    (out.status.code(), serde_json::from_slice(&out.stdout).unwrap())
}

fn finding<'a>(found: &'a Value, part: &str) -> (&'a str, String) {
    let all = found["checks"].as_array().unwrap();
    let one = all.iter().find(|one| one["code"] == part).unwrap_or_else(|| panic!("{part}: {found}"));
    let text = format!("{} -> {}", one["text"].as_str().unwrap(), one["remedy"].as_str().unwrap());
    (one["status"].as_str().unwrap(), text)
}

#[test]
fn devices_that_answer_are_good_and_a_silent_and_an_absent_one_bad_with_what_to_do() {
    let mut devices = Devices::start(&["--set-up"]);
    let (code, found) = doctor(&devices);
    assert_eq!(code, Some(1), "{found:#}");
    for part in ["configuration", "compass", "motors", "hydrophone", "clock", "data_folder"] {
        assert_eq!(finding(&found, part).0, "ok", "{found:#}");
    }
    assert_eq!(finding(&found, "shore").0, "warn", "the link is off in this configuration");

    devices.order("unplug gnss");
    devices.order("silence motors");
    let (code, found) = doctor(&devices);
    assert_eq!((code, found["status"].as_str()), (Some(2), Some("fail")));
    let (compass, text) = finding(&found, "compass");
    assert!(compass == "fail" && text.contains("there is no"), "{text}");
    let (motors, text) = finding(&found, "motors");
    assert!(motors == "fail" && text.contains("nothing from the motor card"), "{text}");
    assert_eq!(finding(&found, "hydrophone").0, "ok");
}

#[test]
fn while_an_agent_sails_the_doctor_opens_no_port_and_no_motor_is_tried() {
    let devices = Devices::start(&["--set-up"]);
    let agent = devices.agent(&[]);
    let mut console = Console::connect(&agent);
    console.ready();
    console.start("far", Some(far_plan().into()));
    devices.wait("way on", |truth| truth.shaft_radps > 20.0);
    let (code, found) = doctor(&devices);
    assert_eq!(code, Some(1), "{found:#}");
    assert_eq!(finding(&found, "data_folder").0, "warn");
    let (verdict, text) = finding(&found, "devices");
    assert!(verdict == "warn" && text.contains("not looked at") && text.contains("vessel's page"), "{text}");
    let looked_at = ["compass", "motors", "hydrophone"];
    let none = found["checks"]
        .as_array()
        .unwrap()
        .iter()
        .all(|one| !looked_at.contains(&one["code"].as_str().unwrap()));
    assert!(none, "{found:#}");
    let tried = try_motors(&devices, "clear\nport\nyes\nclear\nstarboard\nyes\n");
    assert_eq!(tried.status.code(), Some(3));
    assert!(String::from_utf8_lossy(&tried.stderr).contains(&format!("process {}", agent.child.id())));
    assert!(agent.terminate().starts_with("motors stopped"));
}

#[test]
fn the_doctor_sets_nothing_and_switches_nothing() {
    let devices = Devices::start(&["--set-up"]);
    let (code, found) = doctor(&devices);
    assert_eq!(code, Some(1), "{found:#}");
    // The simulation records what the computer sent to each device.
    assert_eq!(devices.received("gnss"), "");
    assert_eq!(devices.received("hydrophone"), "LIVECMFV?EX!");
    assert_eq!(devices.received("motors"), "\r\r\rC\rS6\rO\r");
}

#[test]
fn a_broken_configuration_is_all_that_is_looked_at() {
    let folder = tempfile::tempdir().unwrap();
    let config = folder.path().join("otter.ini");
    std::fs::write(&config, "[Require nowhere.ini]\n").unwrap();
    let out = program().arg("doctor").arg(&config).output().unwrap();
    let text = String::from_utf8_lossy(&out.stdout);
    assert_eq!(out.status.code(), Some(1));
    assert!(text.contains("nowhere.ini") && text.contains("1 bad, 0 in doubt, 0 good"), "{text}");
}

/// Answers the questions of `motors test`.
fn try_motors(devices: &Devices, answers: &str) -> Output {
    let config = devices.folder.path().join("otter.ini");
    let mut child = program()
        .args(["motors", "test"])
        .arg(config)
        .arg("--data")
        .arg(devices.folder.path())
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    child.stdin.take().unwrap().write_all(answers.as_bytes()).unwrap();
    child.wait_with_output().unwrap()
}

#[test]
fn each_motor_turns_once_it_may_and_what_was_seen_becomes_the_configuration() {
    let devices = Devices::start(&["--set-up"]);
    let out = try_motors(&devices, "clear\nstarboard\nyes\nclear\nport\nno\n");
    let text = String::from_utf8_lossy(&out.stdout).into_owned();
    assert!(out.status.success(), "{text}");
    for line in [
        "Port Motor - Number = 1",
        "Port Motor - Reversed = true",
        "Starboard Motor - Reversed = false",
        "rpm of the propeller",
    ] {
        assert!(text.contains(line), "{text}");
    }
    let fastest = devices.truth().iter().map(|truth| truth.shaft_radps).fold(0.0, f64::max);
    // 0.15 of full speed, which is 104 rad/s.
    assert!((10.0..20.0).contains(&fastest), "{fastest} rad/s");
    devices.wait("both stand at the end", |truth| truth.shaft_radps < 0.1);

    let unsaid = try_motors(&devices, "");
    assert!(!unsaid.status.success());
    assert!(String::from_utf8_lossy(&unsaid.stderr).contains("nothing was turned without `clear`"));
    devices.wait("still", |truth| truth.shaft_radps < 0.1);
}
