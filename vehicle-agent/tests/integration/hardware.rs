//! The whole program with real protocols: `simulate-devices` is the devices, `run --profile Hardware` steers the vessel.
//!
//! These tests take as long as the devices' own deadlines, as both programs use the computer's clock. Nothing sleeps: every
//! wait is for a packet, a line or the true state from the simulation, with a deadline.

use crate::common::devices::{Devices, configuration};
use crate::common::{Agent, Console, DEADLINE, far_plan, ini, program};
use imc::messages::*;
use onboard::Entity;
use std::time::Instant;
use tempfile::TempDir;

/// Waits until an entity reports this state, with a text that contains `words`.
fn wait_state(console: &mut Console, entity: Entity, state: EntityStateState, words: &str) {
    console.wait(&format!("{entity:?} {state:?} {words}"), |packet| {
        let said = packet.get::<EntityState>().filter(|_| packet.header.src_ent == entity.number())?;
        (said.state == state && said.description.to_str_lossy().contains(words)).then_some(())
    });
}

pub(crate) fn sail(console: &mut Console) {
    console.ready();
    console.database(PlanDBOp::Set, "far", Some(far_plan().into()));
    console.start("far", None);
    console.wait_for::<EstimatedState>("way on", |state| state.u > 0.8);
}

#[test]
fn a_plan_is_sailed_over_real_protocols_and_a_silent_motor_card_stops_the_boat_and_says_why() {
    let mut devices = Devices::start(&[]);
    let agent = devices.agent(&[]);
    let mut console = Console::connect(&agent);
    sail(&mut console);
    let (utc_s, state) = console.wait("estimate", |packet| {
        packet.get::<EstimatedState>().map(|state| (packet.header.timestamp, state.clone()))
    });
    let frame = units::LocalFrame::new(units::LatLon::from_rad(state.lat, state.lon).unwrap());
    let place = frame.to_place(units::LocalPoint { north_m: state.x.into(), east_m: state.y.into() });
    devices.wait("the truth of that time", |truth| truth.utc_s > utc_s);
    let off_m = devices.off_m(utc_s, place.lat_rad(), place.lon_rad());
    assert!(off_m < 1.5, "{off_m} m");

    // A detection is where the vessel was when the tag began to send, three seconds before its stamp.
    let tag = console.wait_for::<TBRFishTag>("a detection", |_| true);
    let sent_s = f64::from(tag.unix_timestamp) + f64::from(tag.millis) / 1e3 - 3.0;
    let off_m = devices.off_m(sent_s, tag.lat.unwrap(), tag.lon.unwrap());
    assert!(off_m < 1.5, "{off_m} m");
    wait_state(&mut console, Entity::Hydrophone, EntityStateState::Normal, "detections");

    // The receiver measures the instants at which its clock is set. Two marks of ten seconds have passed by then.
    let mark_s = (devices.last().utc_s / 10.0).ceil() * 10.0;
    devices.wait("two marks", |truth| truth.utc_s > mark_s + 10.5);
    let instants = devices.order("report hydrophone");
    print!("{instants}");
    let number = |name: &str| -> f64 {
        let (_, rest) = instants.split_once(name).unwrap();
        rest.split_whitespace().next().unwrap().parse().unwrap()
    };
    assert!(number("commands=") >= 2.0, "{instants}");
    // The computer may be busy: a real error would be larger than that, or all characters would come at once.
    assert!(number("worst_ms=").abs() < 250.0 && number(" to ") > 0.8, "{instants}");

    devices.order("babble hydrophone");
    wait_state(&mut console, Entity::Hydrophone, EntityStateState::Error, "baud");
    devices.order("mend hydrophone");
    wait_state(&mut console, Entity::Hydrophone, EntityStateState::Normal, "detections");

    devices.order("silence motors");
    wait_state(&mut console, Entity::MotorPort, EntityStateState::Error, "nothing from the motor card");
    console.wait_for::<VehicleState>("error", |state| state.op_mode == VehicleStateOpMode::Error);
    devices.wait("both propellers stand", |truth| truth.shaft_radps < 0.1);
    devices.order("mend motors");
    wait_state(&mut console, Entity::MotorPort, EntityStateState::Normal, "");
    console.ready();
    console.start("far", None);
    devices.wait("way on again", |truth| truth.speed_mps > 0.5);

    // The last command to the motors is a stop; the card would stop them only after a second.
    let ended = Instant::now();
    let last = agent.terminate();
    assert!(last.starts_with("motors stopped, log closed"), "{last}");
    devices.wait("stopped at the end", |truth| truth.shaft_radps < 20.0);
    assert!(ended.elapsed() < DEADLINE);
    devices.terminate();
}

#[test]
fn a_compass_that_is_unplugged_in_a_plan_stops_the_boat_until_it_is_back_and_the_plan_goes_on() {
    let mut devices = Devices::start(&[]);
    let recording = devices.folder.path().join("run.rec");
    let agent = devices.agent(&["--record", recording.to_str().unwrap()]);
    let mut console = Console::connect(&agent);
    sail(&mut console);
    devices.order("unplug gnss");
    wait_state(&mut console, Entity::Gps, EntityStateState::Error, "gnss");
    devices.wait("both propellers stand", |truth| truth.shaft_radps < 0.1);
    devices.order("plug gnss");
    wait_state(&mut console, Entity::Gps, EntityStateState::Normal, "");
    devices.wait("the plan goes on", |truth| truth.speed_mps > 0.5);
    let state = console.wait_for::<PlanControlState>("the plan's state", |_| true);
    assert_eq!(state.state, PlanControlStateState::Executing);
    // Noise is neither a position nor the end.
    devices.order("babble gnss");
    wait_state(&mut console, Entity::Gps, EntityStateState::Error, "baud");
    devices.order("mend gnss");
    wait_state(&mut console, Entity::Gps, EntityStateState::Normal, "");
    agent.terminate();
    // The devices' data are in the recording: another brain gives the same outputs.
    let replay = program().arg("replay").arg(recording).output().unwrap();
    assert!(replay.status.success(), "{}", String::from_utf8_lossy(&replay.stderr));
}

#[test]
fn a_killed_program_leaves_standing_motors_and_one_with_a_wrong_speed_of_the_line_says_so_and_mends_it() {
    let devices = Devices::start(&["--gnss-baud", "19200"]);
    let config = devices.folder.path().join("otter.ini");
    let wrong = std::fs::read_to_string(&config).unwrap();
    std::fs::write(&config, wrong.replacen("115200", "19200", 1)).unwrap();
    let mut agent = devices.agent(&[]);
    let mut console = Console::connect(&agent);
    sail(&mut console);
    // Suspended for a while, and then killed: the card stops the motors on its own.
    agent.signal("STOP");
    devices.wait("both propellers stand", |truth| truth.shaft_radps < 0.1);
    agent.signal("CONT");
    devices.wait("way on again", |truth| truth.shaft_radps > 20.0);
    agent.child.kill().unwrap();
    agent.child.wait().unwrap();
    devices.wait("both propellers stand", |truth| truth.shaft_radps < 0.1);
    // The port is free for the next agent at once, which receives the compass as noise at its present speed.
    std::fs::write(&config, wrong).unwrap();
    let agent = devices.agent(&[]);
    let mut console = Console::connect(&agent);
    wait_state(&mut console, Entity::Gps, EntityStateState::Error, "bytes come but no valid NMEA");
    wait_state(&mut console, Entity::MotorPort, EntityStateState::Normal, "");
    // The agent orders it, at its present speed, to change to the line's speed.
    wait_state(&mut console, Entity::Gps, EntityStateState::Normal, "");
    assert!(devices.received("gnss").contains("$JBAUD,115200"), "{}", devices.received("gnss"));
    console.wait_for::<GpsFix>("a position", |fix| fix.validity.contains(GpsFixValidity::VALID_POS));
}

#[test]
fn a_vessel_whose_devices_are_all_absent_starts_and_says_of_each_what_to_do() {
    let folder = TempDir::new().unwrap();
    let config = folder.path().join("otter.ini");
    std::fs::copy(ini(), folder.path().join("base.ini")).unwrap();
    std::fs::write(&config, configuration(&folder.path().join("dev"))).unwrap();
    let mut command = program();
    command.arg("run").arg(&config).args(["--log-level", "off", "--profile", "Hardware"]);
    let agent = Agent::spawn(&mut command, folder.path(), &[]);
    let mut console = Console::connect(&agent);
    for entity in [Entity::Gps, Entity::MotorPort, Entity::MotorStarboard, Entity::Hydrophone] {
        wait_state(&mut console, entity, EntityStateState::Error, "there is no");
    }
    assert!(agent.terminate().starts_with("motors stopped, log closed"));
}

/// Waits until the log book has a warning that contains `words`.
fn wait_warning(console: &mut Console, words: &str) {
    console.wait_for::<LogBookEntry>(words, |entry| {
        entry.r#type == LogBookEntryType::Warning && entry.text.to_str_lossy().contains(words)
    });
}

#[test]
fn an_adapter_that_restarts_without_being_unplugged_is_told_again_and_the_plan_goes_on() {
    let mut devices = Devices::start(&[]);
    let agent = devices.agent(&[]);
    let mut console = Console::connect(&agent);
    sail(&mut console);
    devices.order("restart motors");
    let again = devices
        .wait("the adapter is told again", |_| devices.received("motors").matches("\rO\r").count() >= 2);
    // The card drops a command after a second.
    devices.wait("commanded after that", |truth| truth.utc_s > again.utc_s + 2.0 && truth.shaft_radps > 20.0);
    let state = console.wait_for::<PlanControlState>("the plan's state", |_| true);
    assert_eq!(state.state, PlanControlStateState::Executing);
    agent.terminate();
}

#[test]
fn a_power_channel_that_the_card_refuses_is_in_the_log_book_with_what_to_do() {
    let mut devices = Devices::start(&[]);
    let config = devices.folder.path().join("otter.ini");
    let text = std::fs::read_to_string(&config).unwrap();
    let named =
        "[Actuators.Torqeedo]\nPower Channel H_AUX1 - Name = Lamp\nPower Channel H_AUX1 - State = 0\n";
    std::fs::write(&config, text + named).unwrap();
    devices.order("refuse motors");
    let agent = devices.agent(&[]);
    let mut console = Console::connect(&agent);
    wait_warning(
        &mut console,
        "power channel `Lamp` (rail 2, channel 1) stays on: refused after 3 times; look at the rail's fuse",
    );
    // The motors' own channels are as they were, and the vessel sails.
    sail(&mut console);
    agent.terminate();
}

#[test]
fn devices_that_say_what_cannot_be_are_not_believed_and_the_boat_stops_until_they_make_sense() {
    let mut devices = Devices::start(&[]);
    let agent = devices.agent(&[]);
    let mut console = Console::connect(&agent);
    sail(&mut console);
    devices.order("nonsense hydrophone");
    wait_warning(&mut console, "damaged line");
    devices.order("mend hydrophone");
    devices.order("nonsense gnss");
    wait_state(&mut console, Entity::Gps, EntityStateState::Error, "");
    devices.wait("both propellers stand", |truth| truth.shaft_radps < 0.1);
    devices.order("mend gnss");
    devices.wait("the plan goes on", |truth| truth.speed_mps > 0.5);
    devices.order("nonsense motors");
    wait_warning(&mut console, "values that cannot be");
    wait_state(&mut console, Entity::MotorPort, EntityStateState::Error, "no feedback");
    devices.wait("both propellers stand", |truth| truth.shaft_radps < 0.1);
    devices.order("mend motors");
    wait_state(&mut console, Entity::MotorPort, EntityStateState::Normal, "");
    console.ready();
    // Noise at the full speed of the line, including an adapter's refusals.
    console.start("far", None);
    devices.wait("way on", |truth| truth.speed_mps > 0.5);
    devices.order("babble motors");
    wait_state(&mut console, Entity::MotorPort, EntityStateState::Error, "motor card");
    devices.wait("both propellers stand", |truth| truth.shaft_radps < 0.1);
    devices.order("mend motors");
    wait_state(&mut console, Entity::MotorPort, EntityStateState::Normal, "");
    agent.terminate();
}

#[test]
fn a_compass_without_its_orders_says_nothing_and_one_that_lost_its_power_gets_them_again() {
    let mut devices = Devices::start(&[]);
    let agent = devices.agent(&[]);
    let mut console = Console::connect(&agent);
    console.wait_for::<GpsFix>("a position", |_| true);
    devices.order("restart gnss");
    wait_state(&mut console, Entity::Gps, EntityStateState::Error, "nothing came for 4 s");
    wait_state(&mut console, Entity::Gps, EntityStateState::Normal, "");
    assert!(devices.received("gnss").matches("$JASC,GPGGA,5\r\n").count() >= 2);
    assert!(agent.terminate().starts_with("motors stopped, log closed"));
    // Another agent, whose commands the compass does not know: it answers none of them, and sends nothing.
    let config = devices.folder.path().join("otter.ini");
    let command = |n| format!("Initialization String {n} - Command = $JASC,GPGGX,5\\r\\n\n");
    let wrong = (0..7).map(command).collect::<Vec<_>>().concat();
    let text = std::fs::read_to_string(&config).unwrap().replacen(
        "[Sensors.GPS]\n",
        &format!("[Sensors.GPS]\n{wrong}"),
        1,
    );
    std::fs::write(&config, text).unwrap();
    devices.order("restart gnss");
    let agent = devices.agent(&[]);
    wait_state(&mut Console::connect(&agent), Entity::Gps, EntityStateState::Error, "nothing came for 4 s");
}
