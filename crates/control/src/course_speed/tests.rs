use super::*;
use crate::speed_table::SpeedTable;
use crate::thrust::{Sharing, ThrustMap};
use proptest::prelude::*;
use std::f64::consts::PI;

fn at(seconds: f64) -> MonoTime {
    MonoTime::from_micros((seconds * 1e6).round() as u64)
}

fn still(heading_rad: f64) -> Motion {
    Motion { heading_rad, yaw_rate_rad_s: Some(0.0), north_mps: 0.0, east_mps: 0.0 }
}

fn heading(rad: f64, speed: Speed) -> Setpoint {
    Setpoint { yaw: Some(YawTarget::Heading(rad)), speed: Some(speed) }
}

/// Without fade, so that single steps show what the loops do.
fn crisp(mut config: CourseSpeedConfig) -> CourseSpeed {
    config.output.fade_s = 0.0;
    let mut control = CourseSpeed::new(config).unwrap();
    control.enable(MotorPair::STOPPED);
    control
}

fn all_sets() -> [CourseSpeedConfig; 6] {
    [
        CourseSpeedConfig::fossen_force(),
        CourseSpeedConfig::fossen_rpm(),
        CourseSpeedConfig::thesis(),
        CourseSpeedConfig::ntnu_rpm(),
        CourseSpeedConfig::dune_rpm(),
        CourseSpeedConfig::ntnu_force(),
    ]
}

fn run(control: &mut CourseSpeed, steps: usize, motion: &Motion, setpoint: &Setpoint) -> ControlOutput {
    let mut last = None;
    for step in 0..steps {
        last = Some(control.update(at(step as f64 * 0.1), motion, setpoint, None).unwrap());
    }
    last.unwrap()
}

#[test]
fn turns_to_starboard_by_pushing_on_the_port_side() {
    for config in all_sets() {
        let got = run(&mut crisp(config), 3, &still(0.0), &heading(1.0, Speed::MetresPerSecond(1.0)));
        assert!(got.motors.port > 0.0 && got.motors.starboard < 0.0, "{got:?}");
        assert!(!got.ahead, "57 degrees off: first turn, then go");
    }
}

#[test]
fn forward_gate_has_hysteresis() {
    let mut control = crisp(CourseSpeedConfig::thesis());
    let mut t = 0.0;
    for (error_deg, ahead) in
        [(33.0, false), (29.0, true), (35.0, true), (37.0, false), (31.0, false), (-29.0, true)]
    {
        t += 0.1;
        let setpoint = heading(f64::to_radians(error_deg), Speed::MetresPerSecond(1.0));
        let got = control.update(at(t), &still(0.0), &setpoint, None).unwrap();
        assert_eq!(got.ahead, ahead, "{error_deg} degrees");
    }
}

#[test]
fn differential_limit_holds_only_while_going_ahead() {
    let mut control = crisp(CourseSpeedConfig::thesis());
    let slow = control.update(at(0.0), &still(0.0), &heading(0.5, Speed::Percent(0.0)), None).unwrap();
    assert!((slow.motors.port - 0.4).abs() < 1e-12, "1.5 x 0.5 rad, cut at 0.4: {slow:?}");
    let mut control = crisp(CourseSpeedConfig::thesis());
    let spin = control.update(at(0.0), &still(0.0), &heading(0.66, Speed::Percent(0.0)), None).unwrap();
    assert!((spin.motors.port - 0.99).abs() < 1e-12, "{spin:?}");
}

#[test]
fn desired_speed_below_a_tenth_stops() {
    for config in all_sets() {
        let got = run(&mut crisp(config), 20, &still(0.0), &heading(0.0, Speed::MetresPerSecond(0.09)));
        assert!(got.motors.common().abs() < 1e-12, "{got:?}");
    }
}

#[test]
fn demand_is_limited_in_rate_and_range() {
    // Thesis: from rest at most 62 rpm per second, at least 62 rpm; 1100 rpm is full.
    let mut control = crisp(CourseSpeedConfig::thesis());
    let setpoint = heading(0.0, Speed::MetresPerSecond(2.0));
    for step in 0..50 {
        let got = control.update(at(f64::from(step) * 0.1), &still(0.0), &setpoint, None).unwrap();
        let rpm = got.motors.port * 1100.0;
        assert!(
            rpm >= 62.0 - 1e-9 && rpm <= (62.0 + 6.2 * f64::from(step)).max(62.0) + 1e-9,
            "{step}: {rpm}"
        );
    }
}

#[test]
fn thesis_gains_reach_at_most_the_published_rpm() {
    // 100·v + 200 rpm, plus kp·error: at 2 m/s desired and none made, 402 rpm.
    let got = run(
        &mut crisp(CourseSpeedConfig::thesis()),
        1000,
        &still(0.0),
        &heading(0.0, Speed::MetresPerSecond(2.0)),
    );
    assert!((got.motors.port * 1100.0 - 402.0).abs() < 1e-6, "{got:?}");
}

#[test]
fn units_of_speed_are_kept_apart() {
    let full = SpeedTable::FOSSEN_OTTER.rpm_for_percent(100.0);
    for config in [CourseSpeedConfig::fossen_force(), CourseSpeedConfig::fossen_rpm()] {
        for (speed, actuation) in [
            (Speed::Percent(40.0), 0.4),
            (Speed::Rpm(0.4 * full), 0.4),
            (Speed::Percent(-30.0), -0.3),
            (Speed::Rpm(1e9), 1.0),
        ] {
            let got = run(&mut crisp(config), 100, &still(0.0), &heading(0.0, speed));
            assert!((got.motors.port - actuation).abs() < 1e-6, "{speed:?}: {got:?}");
        }
    }
}

#[test]
fn software_governor_follows_measured_rpm_and_does_without() {
    let mut config = CourseSpeedConfig::thesis();
    config.drive = Drive::Rpm { rpm_at_max_thrust: 1100.0, governor: CourseSpeedConfig::thesis_governor() };
    config.speed.max_demand_rate_per_s = 1e5;
    let mut control = crisp(config);
    let setpoint = heading(0.0, Speed::Rpm(500.0));
    control.update(at(0.0), &still(0.0), &setpoint, None).unwrap();
    let blind = control.update(at(0.1), &still(0.0), &setpoint, None).unwrap();
    assert!((blind.motors.port - 0.46e-3 * 500.0).abs() < 1e-9, "feed-forward only: {blind:?}");
    let slow = control.update(at(0.2), &still(0.0), &setpoint, Some(300.0)).unwrap();
    assert!((slow.motors.port - (0.46e-3 * 500.0 + 0.2e-3 * 200.0)).abs() < 1e-9, "{slow:?}");
    let later = control.update(at(0.3), &still(0.0), &setpoint, Some(300.0)).unwrap();
    assert!(later.motors.port > slow.motors.port, "the integral grows");
}

#[test]
fn saturated_force_still_turns_the_right_way() {
    // The published code writes the two forces back swapped when starboard exceeds its limit.
    let mut config = CourseSpeedConfig::ntnu_force();
    config.yaw.max_error_to_thrust_rad = 3.0;
    let got = run(&mut crisp(config), 100, &still(0.0), &heading(-0.5, Speed::MetresPerSecond(9.0)));
    assert!(got.motors.starboard > got.motors.port, "a turn to port: {got:?}");
    let map = ThrustMap::NTNU_OTTER;
    let differential_n = (map.force_at(got.motors.port) - map.force_at(got.motors.starboard)) / 2.0;
    assert!((differential_n + 30.0).abs() < 1e-6, "60 N/rad x 0.5 rad survive: {differential_n}");
}

#[test]
fn enabling_starts_from_what_the_motors_do() {
    for config in all_sets() {
        let mut control = CourseSpeed::new(config).unwrap();
        let before = MotorPair { port: 0.35, starboard: 0.3 };
        control.enable(before);
        let setpoint = heading(0.2, Speed::MetresPerSecond(1.5));
        let moving = Motion::from_course(0.0, Some(0.0), 0.0, 0.8);
        let first = control.update(at(5.0), &moving, &setpoint, None).unwrap();
        assert!((first.motors.port - before.port).abs() < 1e-12, "{first:?}");
        assert!((first.motors.starboard - before.starboard).abs() < 1e-12, "{first:?}");
        let second = control.update(at(5.1), &moving, &setpoint, None).unwrap();
        assert!((second.motors.port - before.port).abs() < 0.2, "{second:?}");
    }
}

#[test]
fn ramp_limits_growth_by_time_and_never_a_stop() {
    let mut config = CourseSpeedConfig::fossen_rpm();
    config.output.ramp_per_s = Some(0.5);
    config.speed.max_demand_rate_per_s = 1e5;
    let mut control = crisp(config);
    let setpoint = heading(0.0, Speed::Percent(80.0));
    for (t, actuation) in [(0.0, 0.0), (0.2, 0.1), (0.4, 0.2), (1.4, 0.7), (1.6, 0.8), (1.8, 0.8)] {
        let got = control.update(at(t), &still(0.0), &setpoint, None).unwrap();
        assert!((got.motors.port - actuation).abs() < 1e-9, "{t} s: {got:?}");
    }
    let stop = control.update(at(2.0), &still(0.0), &heading(0.0, Speed::Percent(0.0)), None).unwrap();
    assert!(stop.motors.port.abs() < 1e-12);
}

#[test]
fn a_long_pause_starts_anew_from_stopped_motors() {
    let mut control = CourseSpeed::new(CourseSpeedConfig::default()).unwrap();
    control.enable(MotorPair::STOPPED);
    let setpoint = heading(0.1, Speed::MetresPerSecond(1.5));
    run(&mut control, 50, &still(0.0), &setpoint);
    let got = control.update(at(60.0), &still(0.0), &setpoint, None).unwrap();
    assert!(got.restarted);
    assert!(got.motors.port.abs() < 1e-12 && got.motors.starboard.abs() < 1e-12);
}

#[test]
fn integral_does_not_grow_while_the_boat_cannot_go_faster() {
    // 9 m/s cannot be reached: the demand stands at its limit and the integral must not have grown there.
    for config in [CourseSpeedConfig::fossen_force(), CourseSpeedConfig::fossen_rpm()] {
        let mut control = crisp(config);
        let fast = Motion::from_course(0.0, Some(0.0), 0.0, 3.0);
        let got = run(&mut control, 3000, &fast, &heading(0.0, Speed::MetresPerSecond(9.0)));
        assert!(got.speed.integral.abs() < 1e-6, "{got:?}");
    }
}

#[test]
fn answers_nothing_when_disabled_or_given_no_numbers() {
    let mut control = CourseSpeed::new(CourseSpeedConfig::default()).unwrap();
    let setpoint = heading(0.0, Speed::Percent(10.0));
    assert_eq!(control.update(at(0.0), &still(0.0), &setpoint, None), Err(ControlFault::Disabled));
    control.enable(MotorPair { port: f64::NAN, starboard: 7.0 });
    assert_eq!(control.update(at(0.0), &still(f64::NAN), &setpoint, None), Err(ControlFault::NotFinite));
    let bad = heading(0.0, Speed::Percent(f64::INFINITY));
    assert_eq!(control.update(at(0.0), &still(0.0), &bad, None), Err(ControlFault::NotFinite));
    let got = control.update(at(0.0), &still(0.0), &setpoint, Some(f64::NAN)).unwrap();
    assert!(got.motors.port.abs() < 1e-12 && (got.motors.starboard - 1.0).abs() < 1e-12);
    control.disable();
    assert!(!control.is_enabled());
}

#[test]
fn new_parameters_keep_the_integral_and_bad_ones_are_refused() {
    let mut control = crisp(CourseSpeedConfig::fossen_force());
    let setpoint = heading(0.0, Speed::MetresPerSecond(0.5));
    let before = run(&mut control, 30, &still(0.0), &setpoint);
    let mut config = *control.config();
    config.speed.pid.ki *= 2.0;
    control.reconfigure(config).unwrap();
    let after = control.update(at(2.9), &still(0.0), &setpoint, None).unwrap();
    assert!((after.speed.integral - before.speed.integral).abs() < 1e-9);
    config.speed.pid.ki = -1.0;
    assert!(control.reconfigure(config).is_err());
    assert!(control.is_enabled());
    control.reconfigure(CourseSpeedConfig::fossen_rpm()).unwrap();
    assert!(!control.is_enabled(), "another drive starts from rest");
}

#[test]
fn without_a_target_there_is_no_effort() {
    let mut control = crisp(CourseSpeedConfig::default());
    let got = run(&mut control, 5, &still(1.0), &Setpoint::default());
    assert!(got.motors.port.abs() < 1e-12 && got.motors.starboard.abs() < 1e-12);
}

fn any_motion() -> impl Strategy<Value = Motion> {
    (-3.1..3.1_f64, proptest::option::of(-0.5..0.5_f64), -3.0..3.0_f64, -3.0..3.0_f64).prop_map(
        |(heading_rad, yaw_rate_rad_s, north_mps, east_mps)| Motion {
            heading_rad,
            yaw_rate_rad_s,
            north_mps,
            east_mps,
        },
    )
}

fn any_speed() -> impl Strategy<Value = Speed> {
    prop_oneof![
        (-1.0..4.0_f64).prop_map(Speed::MetresPerSecond),
        (-2000.0..2000.0_f64).prop_map(Speed::Rpm),
        (-150.0..150.0_f64).prop_map(Speed::Percent),
    ]
}

fn mirrored(motion: &Motion) -> Motion {
    Motion {
        heading_rad: -motion.heading_rad,
        yaw_rate_rad_s: motion.yaw_rate_rad_s.map(|rate| -rate),
        north_mps: motion.north_mps,
        east_mps: -motion.east_mps,
    }
}

proptest! {
    #[test]
    fn any_finite_input_gives_actuation_within_limits(
        set in 0..6_usize, max_actuation in 0.1..1.0_f64, sharing in any::<bool>(),
        steps in proptest::collection::vec(
            (any::<[f64; 4]>(), any::<f64>(), any::<f64>(), 0..4_000_000_u64), 1..30),
    ) {
        let mut config = all_sets()[set];
        config.output.max_actuation = max_actuation;
        config.output.sharing = if sharing { Sharing::TurnFirst } else { Sharing::Independent };
        let mut control = CourseSpeed::new(config).unwrap();
        control.enable(MotorPair::STOPPED);
        let mut now = MonoTime::from_micros(0);
        for ([heading_rad, rate, north_mps, east_mps], yaw, speed, us) in steps {
            now = now + std::time::Duration::from_micros(us);
            let motion = Motion { heading_rad, yaw_rate_rad_s: Some(rate), north_mps, east_mps };
            let setpoint = heading(yaw, Speed::MetresPerSecond(speed));
            if let Ok(got) = control.update(now, &motion, &setpoint, Some(speed)) {
                prop_assert!(got.motors.port.abs() <= max_actuation, "{:?}", got);
                prop_assert!(got.motors.starboard.abs() <= max_actuation, "{:?}", got);
            }
        }
    }

    #[test]
    fn a_mirrored_world_swaps_the_motors(
        set in 0..6_usize,
        steps in proptest::collection::vec((any_motion(), -3.1..3.1_f64, any_speed(), any::<bool>()), 1..40),
    ) {
        let mut one = crisp(all_sets()[set]);
        let mut other = crisp(all_sets()[set]);
        let mut t = 0.0;
        for (motion, yaw_rad, speed, as_course) in steps {
            // At half a turn the side is a matter of rounding.
            prop_assume!((units::wrap_pi(yaw_rad - motion.heading_rad).abs() - PI).abs() > 0.2);
            t += 0.1;
            let target = |sign: f64| if as_course {
                YawTarget::Course { course_rad: sign * yaw_rad, turn_rate_rad_s: sign * 0.05 }
            } else {
                YawTarget::Heading(sign * yaw_rad)
            };
            let setpoint = |sign| Setpoint { yaw: Some(target(sign)), speed: Some(speed) };
            let a = one.update(at(t), &motion, &setpoint(1.0), None).unwrap();
            prop_assume!((a.heading_error_rad.abs() - PI).abs() > 1e-6);
            let b = other.update(at(t), &mirrored(&motion), &setpoint(-1.0), None).unwrap();
            prop_assert!((a.motors.port - b.motors.starboard).abs() < 1e-6, "{:?} {:?}", a, b);
            prop_assert!((a.motors.starboard - b.motors.port).abs() < 1e-6, "{:?} {:?}", a, b);
        }
    }
}
