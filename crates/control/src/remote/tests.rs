use super::*;
use proptest::prelude::*;

fn at(ms: u64) -> MonoTime {
    MonoTime::from_micros(ms * 1000)
}

fn remote(mixing: Mixing) -> Remote {
    let mut remote = Remote::new(RemoteConfig { mixing, ..RemoteConfig::default() }).unwrap();
    remote.activate(at(0));
    assert_eq!(remote.poll(at(0)), Some(STOP), "activation stops the motors");
    assert_eq!(remote.poll(at(0)), None);
    remote
}

const SKEWED: Mixing = Mixing::Skewed { outer_share: 0.25 };
const STOP: RemoteCommand = RemoteCommand::Motors(MotorPair::STOPPED);

fn keys(text: &str) -> RemoteActions {
    let (actions, ignored) = RemoteActions::parse(text);
    assert!(ignored.is_empty());
    actions
}

fn motors(command: Option<RemoteCommand>) -> MotorPair {
    match command {
        Some(RemoteCommand::Motors(motors)) => motors,
        other => panic!("{other:?}"),
    }
}

#[test]
fn mixes_as_each_mode_says() {
    let map = ThrustMap::FOSSEN_OTTER;
    let force = |force_n: f64| map.actuation_for(force_n);
    let turn_n = 133.417 / 127.0 * 25.0;
    for (mixing, text, port, starboard) in [
        (Mixing::Additive, "Throttle=64;Heading=32", 96.0 / 127.0, 32.0 / 127.0),
        (Mixing::Additive, "Heading=127", 1.0, -1.0),
        (Mixing::Additive, "Throttle=127;Heading=-32", 63.0 / 127.0, 1.0),
        (
            Mixing::Scaled,
            "Throttle=64;Heading=32",
            64.0 / 127.0 * (1.0 + 64.0 / 127.0),
            64.0 / 127.0 * (63.0 / 127.0),
        ),
        (Mixing::Scaled, "Heading=127", 0.0, 0.0),
        (SKEWED, "Throttle=127", 1.0, 1.0),
        (
            SKEWED,
            "Throttle=64;Heading=32",
            64.0 / 127.0 * (1.0 + 16.0 / 127.0),
            64.0 / 127.0 * (63.0 / 127.0),
        ),
        (
            SKEWED,
            "Throttle=64;Heading=-32",
            64.0 / 127.0 * (63.0 / 127.0),
            64.0 / 127.0 * (1.0 + 16.0 / 127.0),
        ),
        (SKEWED, "Throttle=-64;Heading=127", -64.0 / 127.0 * 1.5, 64.0 / 127.0),
        (Mixing::Skewed { outer_share: 10.0 }, "Throttle=127;Heading=127", 1.0, -1.0),
        (Mixing::ForceLinear(map), "Throttle=127", 1.0, 1.0),
        (Mixing::ForceLinear(map), "Throttle=-127", -1.0, -1.0),
        (Mixing::ForceLinear(map), "Heading=25", force(turn_n), force(-turn_n)),
        (Mixing::Scaled, "Port Motor=127;Starboard Motor=-64", 1.0, -64.0 / 127.0),
        (
            Mixing::Autopilot { max_speed_mps: 2.3, max_turn_rad: std::f64::consts::PI },
            "Starboard Motor=127",
            0.0,
            1.0,
        ),
        (Mixing::Additive, "Throttle=127;Stop=1", 0.0, 0.0),
    ] {
        let mut remote = remote(mixing);
        assert_eq!(remote.handle(at(10), &keys(text), 0.0, true), RemoteReply::Taken);
        let got = motors(remote.poll(at(10)));
        assert!(
            (got.port - port).abs() < 1e-9 && (got.starboard - starboard).abs() < 1e-9,
            "{mixing:?} {text}: {got:?}"
        );
    }
}

#[test]
fn autopilot_holds_the_heading_it_began_with_and_steps_once_per_press() {
    let mut remote = remote(Mixing::Autopilot { max_speed_mps: 2.3, max_turn_rad: std::f64::consts::PI });
    let step = 30_f64.to_radians();
    for (ms, text, heading_rad, speed_mps) in [
        (100, "Throttle=127", 1.0, 2.3),
        (200, "Throttle=127;Right=1", 1.0 + step, 2.3),
        (300, "Throttle=-127;Right=1", 1.0 + step, 0.0),
        (400, "", 1.0 + step, 0.0),
        (500, "Right=1;Throttle=0", 1.0 + 2.0 * step, 0.0),
        (600, "Left=1", 1.0 + step, 0.0),
        (700, "Heading=127", wrap_pi(1.0 + step + std::f64::consts::PI), 0.0),
    ] {
        remote.handle(at(ms), &keys(text), 1.0 + f64::from(u32::try_from(ms).unwrap() - 100), true);
        let Some(RemoteCommand::Autopilot(Setpoint {
            yaw: Some(YawTarget::Heading(got_rad)),
            speed: Some(Speed::MetresPerSecond(got_mps)),
        })) = remote.poll(at(ms))
        else {
            panic!("{text}");
        };
        assert!(
            (got_rad - heading_rad).abs() < 1e-9 && (got_mps - speed_mps).abs() < 1e-9,
            "{ms} {got_rad} {got_mps}"
        );
    }
}

#[test]
fn accelerating_depends_on_time_and_not_on_the_rate_of_messages() {
    for period_ms in [20, 50, 100, 200] {
        let mut remote = remote(Mixing::Additive);
        let mut throttle = 0.0;
        for ms in (1000..=2000).step_by(period_ms) {
            remote.handle(at(ms as u64), &keys("Accelerate=1"), 0.0, true);
            throttle = remote.session.unwrap().throttle;
        }
        assert!((throttle - 0.55).abs() < 1e-9, "{period_ms} ms: {throttle}");
    }
    // 12 messages at 10 Hz: 0.60, as observed on DUNE.
    let mut remote = remote(Mixing::Additive);
    for n in 0..12 {
        remote.handle(at(100 * n), &keys("Accelerate=1"), 0.0, true);
    }
    assert!((remote.session.unwrap().throttle - 0.6).abs() < 1e-9);
    remote.handle(at(1200), &keys("Decelerate=1"), 0.0, true);
    assert!((remote.session.unwrap().throttle - 0.55).abs() < 1e-9);
    remote.handle(at(1300), &keys("Port Motor=5"), 0.0, true);
    assert!(remote.session.unwrap().throttle.abs() < 1e-12, "direct thrust clears the held throttle");
}

#[test]
fn silence_stops_once_and_the_next_message_begins_from_zero() {
    let mut remote = remote(Mixing::Additive);
    remote.handle(at(100), &keys("Throttle=100"), 0.0, true);
    assert_eq!(remote.poll_timeout(), Some(at(100)));
    for ms in (100..2100).step_by(100) {
        assert!(motors(remote.poll(at(ms))).port > 0.7, "{ms} ms");
        assert_eq!(remote.poll(at(ms)), None);
    }
    assert_eq!(remote.poll_timeout(), Some(at(2100)));
    assert_eq!(remote.poll(at(2100)), Some(STOP));
    assert_eq!((remote.poll(at(2100)), remote.poll(at(9000)), remote.poll_timeout()), (None, None, None));
    assert!(!remote.is_connected() && remote.is_active());
    remote.handle(at(9000), &keys("Accelerate=1"), 0.0, true);
    assert!((motors(remote.poll(at(9000))).port - 0.05).abs() < 1e-9);
}

#[test]
fn a_late_poll_never_lets_old_thrust_through() {
    let mut remote = remote(Mixing::Additive);
    remote.handle(at(100), &keys("Throttle=100"), 0.0, true);
    assert_eq!(remote.poll(at(5000)), Some(STOP));
    // Nor does a message after unnoticed silence continue with the old throttle.
    remote.handle(at(6000), &keys("Throttle=100"), 0.0, true);
    remote.handle(at(9000), &keys("Heading=0"), 0.0, true);
    assert_eq!(remote.poll(at(9000)), Some(STOP));
}

#[test]
fn only_the_source_in_control_steers_and_quiets_the_watchdog() {
    let mut remote = remote(Mixing::Additive);
    assert_eq!(remote.handle(at(100), &keys("Throttle=90"), 0.0, false), RemoteReply::NotInControl);
    assert_eq!(remote.poll(at(100)), None);
    remote.handle(at(200), &keys("Throttle=50"), 0.0, true);
    for ms in (300..2200).step_by(100) {
        remote.handle(at(ms), &keys("Throttle=90;Exit=1"), 0.0, false);
        assert!((motors(remote.poll(at(ms))).port - 50.0 / 127.0).abs() < 1e-9);
    }
    assert_eq!(remote.poll(at(2200)), Some(STOP), "2 s after the last message in control");
}

#[test]
fn leaving_stops_the_motors() {
    let mut remote = remote(Mixing::Additive);
    remote.handle(at(100), &keys("Throttle=90"), 0.0, true);
    assert_eq!(remote.handle(at(150), &keys("Throttle=90;Exit=1"), 0.0, true), RemoteReply::Exit);
    assert_eq!(remote.poll_timeout(), Some(at(150)));
    assert_eq!((remote.poll(at(150)), remote.poll(at(150))), (Some(STOP), None));
    assert_eq!(remote.handle(at(200), &keys("Throttle=90"), 0.0, true), RemoteReply::Inactive);
    remote.deactivate(at(300));
    assert_eq!(remote.poll(at(300)), None, "it had stopped already");
}

#[test]
fn a_stop_does_not_wait_for_the_next_output() {
    let mut remote = remote(Mixing::Additive);
    remote.handle(at(100), &keys("Throttle=90"), 0.0, true);
    remote.poll(at(100));
    remote.handle(at(110), &keys("Throttle=90;Stop=1"), 0.0, true);
    assert_eq!(remote.poll(at(110)), Some(STOP));
}

#[test]
fn refuses_values_out_of_range() {
    let config = RemoteConfig {
        mixing: Mixing::Autopilot { max_speed_mps: f64::NAN, max_turn_rad: std::f64::consts::PI },
        connection_timeout_s: 60.0,
        ..RemoteConfig::default()
    };
    assert_eq!(Remote::new(config).unwrap_err().problems.len(), 2);
}

proptest! {
    #[test]
    fn thrust_stays_within_the_scale_and_mirrors(
        mode in 0..4_usize, thrust_scale in 0.1..1.0_f64,
        messages in proptest::collection::vec((any::<[f64; 4]>(), any::<[bool; 3]>(), 0..3000_u64), 1..30),
    ) {
        let mixing = [Mixing::Additive, Mixing::Scaled, Mixing::ForceLinear(ThrustMap::NTNU_OTTER), SKEWED][mode];
        let config = RemoteConfig { mixing, thrust_scale, ..RemoteConfig::default() };
        let (mut one, mut other) = (Remote::new(config).unwrap(), Remote::new(config).unwrap());
        one.activate(at(0));
        other.activate(at(0));
        let mut ms = 0;
        for ([port_motor, starboard_motor, heading, throttle], [accelerate, stop, direct], pause_ms) in messages {
            ms += pause_ms;
            let (port_motor, starboard_motor) = if direct { (port_motor, starboard_motor) } else { (0.0, 0.0) };
            let throttle = (!accelerate).then_some(throttle);
            let actions = RemoteActions {
                stop, accelerate, port_motor, starboard_motor, heading, throttle, ..RemoteActions::default()
            };
            let mirrored = RemoteActions {
                port_motor: starboard_motor, starboard_motor: port_motor, heading: -heading, ..actions
            };
            one.handle(at(ms), &actions, 0.0, true);
            other.handle(at(ms), &mirrored, 0.0, true);
            loop {
                let (a, b) = (one.poll(at(ms)), other.poll(at(ms)));
                prop_assert_eq!(a.is_some(), b.is_some());
                if a.is_none() {
                    break;
                }
                let (a, b) = (motors(a), motors(b));
                prop_assert!(a.port.abs() <= thrust_scale && a.starboard.abs() <= thrust_scale);
                prop_assert!((a.port - b.starboard).abs() < 1e-9 && (a.starboard - b.port).abs() < 1e-9);
            }
        }
    }
}

#[test]
fn sticks_whose_life_ran_out_pass_neutral_before_they_move_anything() {
    let mut remote = remote(Mixing::Additive);
    let ahead = keys("Port Motor=64;Starboard Motor=64;Life=300");
    let neutral = keys("Port Motor=0;Starboard Motor=0;Life=300");
    assert_eq!(remote.handle(at(0), &ahead, 0.0, true), RemoteReply::Taken);
    assert!(motors(remote.poll(at(0))).port > 0.4);
    // The next comes just in time, the one after it too late, whether the clock was looked at or not.
    remote.handle(at(299), &ahead, 0.0, true);
    assert!(!remote.is_locked());
    for polled in [true, false] {
        let late = if polled { 700 } else { 2_700 };
        assert!(!polled || remote.poll(at(650)) == Some(STOP));
        for more in [0, 50, 100] {
            remote.handle(at(late + more), &ahead, 0.0, true);
            assert!(remote.is_locked());
            assert_eq!(motors(remote.poll(at(late + more))), MotorPair::STOPPED);
        }
        remote.handle(at(late + 150), &neutral, 0.0, true);
        remote.handle(at(late + 200), &ahead, 0.0, true);
        while let Some(command) = remote.poll(at(late + 300)) {
            assert!(motors(Some(command)).port > 0.4);
        }
    }
    // A life that ends at rest is not an interruption, and consoles that send no life continue as usual.
    remote.handle(at(3_100), &neutral, 0.0, true);
    assert_eq!(remote.poll(at(3_500)), Some(STOP));
    remote.handle(at(3_600), &ahead, 0.0, true);
    assert!(motors(remote.poll(at(3_600))).port > 0.4);
    assert_eq!(remote.poll(at(4_000)), Some(STOP));
    remote.handle(at(4_100), &keys("Port Motor=64;Starboard Motor=64"), 0.0, true);
    assert!(motors(remote.poll(at(4_100))).port > 0.4);
}
