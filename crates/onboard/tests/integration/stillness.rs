//! When the motors must stay still: the vessel was not started, was aborted, or a command was not for it.

use crate::common::{frame, settings};
use devices::{BatteryReading, GnssFix, GnssReading, GroundVelocity, MotorReading, Quality, Reading, Side};
use imc::messages::{
    Abort, Goto, Heartbeat, PlanControl, PlanControlOp, PlanControlType, PlanDB, PlanDBOp, PlanDBType,
    PlanManeuver, PlanSpecification, RemoteActions, SpeedUnits, Teleoperation, ZUnits,
};
use imc::{Address, Header, Message, Packet};
use mission::{BatteryConfig, LimitsConfig, LostCommsConfig, Remedy, Step};
use onboard::{Brain, Input, Keep, Output, Peer, Settings};
use std::ops::Range;
use std::time::Duration;
use units::{LocalPoint, MonoTime, Now, UtcTime};

const OTTER: u16 = 0x2810;
const CONSOLE: u16 = 0x4001;

fn at(us: u64) -> Now {
    Now { mono: MonoTime::from_micros(us), utc: UtcTime::from_micros(1_790_000_000_000_000 + us as i64) }
}

fn from_console(dst: u16, message: impl Into<Message>) -> Input {
    from_console_at(0, dst, message)
}

/// A message made at a second.
fn from_console_at(second: u64, dst: u16, message: impl Into<Message>) -> Input {
    let timestamp = at(second * 1_000_000).utc.seconds();
    let header = Header { timestamp, src: Address(CONSOLE), dst: Address(dst), ..Header::default() };
    Input::Packet(Peer::Tcp(1), Packet::new(header, message).encode().unwrap())
}

fn fix(us: u64, speed_mps: f64) -> Input {
    let north_m = speed_mps * us as f64 / 1e6;
    let place = frame().to_place(LocalPoint { north_m, east_m: 0.0 });
    Input::Reading(
        at(us).mono,
        Reading::Gnss(GnssReading {
            utc: Some(at(us).utc),
            fix: Some(GnssFix {
                lat_rad: place.lat_rad(),
                lon_rad: place.lon_rad(),
                height_m: 0.0,
                quality: Quality::Autonomous,
                hdop: 0.9,
            }),
            satellites: 9,
            velocity: Some(GroundVelocity { course_rad: 0.0, speed_mps }),
            heading_rad: Some(0.0),
            yaw_rate_rad_s: Some(0.0),
            ..GnssReading::default()
        }),
    )
}

/// Runs a brain whose vessel is carried north at a speed, with more input each second; the greatest thrust in
/// the seconds asked for.
fn greatest_thrust(
    settings: Settings,
    seconds: Range<u64>,
    speed_mps: f64,
    mut more: impl FnMut(u64) -> Vec<Input>,
) -> f64 {
    let mut brain = Brain::new(settings, at(0), mission::Kept::default()).unwrap();
    let mut greatest = 0.0_f64;
    for step in 0..seconds.end * 20 {
        let us = step * 50_000;
        let mut inputs = vec![Input::Timer];
        if step % 4 == 0 {
            inputs.push(fix(us, speed_mps));
        }
        if step % 10 == 0 {
            inputs.extend(
                Side::BOTH
                    .map(|side| Input::Reading(at(us).mono, Reading::Motor(side, MotorReading::default()))),
            );
        }
        if step % 20 == 0 {
            inputs.extend(more(step / 20));
        }
        while let Some(input) = inputs.pop() {
            brain.handle(at(us), input);
            while let Some(output) = brain.poll_output() {
                match output {
                    Output::Motors(pair) if step >= seconds.start * 20 => {
                        greatest = greatest.max(pair.port.abs()).max(pair.starboard.abs());
                    }
                    Output::Keep(Keep::Plans(effect)) => inputs.push(Input::Stored(effect.ticket(), Ok(()))),
                    _ => {}
                }
            }
        }
    }
    greatest
}

fn goto(north_m: f64) -> Goto {
    let place = frame().to_place(LocalPoint { north_m, east_m: 0.0 });
    Goto {
        lat: place.lat_rad(),
        lon: place.lon_rad(),
        speed: 1.0,
        speed_units: SpeedUnits::MetersPs,
        z_units: ZUnits::Depth,
        ..Goto::default()
    }
}

fn home() -> PlanDB {
    let maneuver =
        PlanManeuver { maneuver_id: "a".into(), data: goto(300.0).into(), ..PlanManeuver::default() };
    let plan = PlanSpecification {
        plan_id: "home".into(),
        start_man_id: "a".into(),
        maneuvers: [maneuver].into_iter().collect(),
        ..PlanSpecification::default()
    };
    PlanDB {
        r#type: PlanDBType::Request,
        op: PlanDBOp::Set,
        plan_id: "home".into(),
        arg: plan.into(),
        ..PlanDB::default()
    }
}

fn start(argument: impl Into<Message>) -> PlanControl {
    PlanControl {
        r#type: PlanControlType::Request,
        op: PlanControlOp::Start,
        plan_id: "t".into(),
        arg: argument.into().into(),
        ..PlanControl::default()
    }
}

#[test]
fn a_vessel_on_a_trailer_does_not_hold_its_station() {
    let mut settings = settings();
    settings.watch.limits = LimitsConfig {
        max_speed_mps: Some(3.1),
        speed_remedy: Some(Remedy::Hold),
        ..LimitsConfig::default()
    };
    let thrust = greatest_thrust(settings, 0..60, 6.0, |_| Vec::new());
    assert!(thrust.abs() < f64::EPSILON, "{thrust}");
}

#[test]
fn a_low_battery_at_the_quay_starts_nothing() {
    let mut settings = settings();
    let remedy = Remedy::Run { plan_id: "home".into() };
    settings.watch.battery = BatteryConfig { reserve_remedy: Some(remedy), ..BatteryConfig::default() };
    let low = || {
        let battery = BatteryReading {
            number: 0,
            voltage_v: 28.0,
            current_a: 1.0,
            charge_percent: 15.0,
            temperature_c: 20.0,
        };
        Input::Reading(at(2_000_000).mono, Reading::Battery(battery))
    };
    let thrust = greatest_thrust(settings, 0..60, 0.0, |second| match second {
        2 => vec![low(), from_console(OTTER, home())],
        _ => vec![low()],
    });
    assert!(thrust.abs() < f64::EPSILON, "{thrust}");
}

#[test]
fn after_an_abort_no_supervisor_starts_again_but_after_a_stop_it_does() {
    // Twenty seconds after the last heartbeat an idle vessel holds its station. It drifts away at 0.6 m/s, so
    // holding needs the motors.
    let lost = LostCommsConfig {
        idle: vec![Step { after: Duration::from_secs(20), remedy: Remedy::Hold }],
        plan: Vec::new(),
        teleoperation: Vec::new(),
        ..LostCommsConfig::default()
    };
    let later = |end: fn() -> Message| {
        let mut settings = settings();
        settings.watch.lost_comms = lost.clone();
        greatest_thrust(settings, 12..90, 0.6, |second| match second {
            5 => vec![from_console(OTTER, Heartbeat), from_console(OTTER, start(goto(100.0)))],
            8 => vec![from_console(OTTER, end())],
            0..8 => vec![from_console(OTTER, Heartbeat)],
            _ => Vec::new(),
        })
    };
    let aborted = later(|| Abort.into());
    assert!(aborted.abs() < f64::EPSILON, "{aborted}");
    let stopped = later(|| {
        PlanControl { op: PlanControlOp::Stop, arg: imc::Nested::none(), ..start(goto(1.0)) }.into()
    });
    assert!(stopped > 0.0, "the supervisor acts at all");
}

fn ahead() -> RemoteActions {
    RemoteActions { actions: "Port Motor=127;Starboard Motor=127".into() }
}

#[test]
fn keys_that_a_stalled_connection_held_back_move_nothing() {
    let by = || Teleoperation { custom: format!("src={CONSOLE}").into() };
    let thrust = |seconds| {
        greatest_thrust(settings(), seconds, 0.0, |second| match second {
            5 => vec![from_console_at(5, OTTER, Heartbeat), from_console_at(5, OTTER, start(by()))],
            6..9 => vec![from_console_at(second, OTTER, ahead())],
            // Nothing for five seconds, then all of it at once.
            14 => (9..13).rev().map(|second| from_console_at(second, OTTER, ahead())).collect(),
            20 => vec![from_console_at(20, OTTER, ahead())],
            _ => Vec::new(),
        })
    };
    assert!(thrust(6..9) > 0.9, "fresh keys act");
    assert!(thrust(12..20).abs() < f64::EPSILON, "late ones do not");
    assert!(thrust(20..22) > 0.9, "and fresh ones act again");
}

#[test]
fn the_session_belongs_to_the_connection_that_started_it() {
    let other = |input| match input {
        Input::Packet(_, bytes) => Input::Packet(Peer::Tcp(2), bytes),
        input => input,
    };
    for custom in [format!("src={CONSOLE}"), String::new()] {
        let thrust = greatest_thrust(settings(), 0..15, 0.0, |second| match second {
            5 => {
                let by = Teleoperation { custom: custom.as_str().into() };
                vec![from_console_at(5, OTTER, start(by))]
            }
            8..12 => vec![other(from_console_at(second, OTTER, ahead()))],
            _ => vec![from_console_at(second, OTTER, Heartbeat)],
        });
        assert!(thrust.abs() < f64::EPSILON, "{custom}: {thrust}");
    }
}

#[test]
fn sticks_that_are_not_for_this_vessel_move_nothing() {
    for (dst, moves) in [(OTTER, true), (0, false), (0xFFFF, false), (0x2811, false)] {
        let thrust = greatest_thrust(settings(), 0..15, 0.0, |second| match second {
            5 => {
                let by = Teleoperation { custom: format!("src={CONSOLE}").into() };
                vec![from_console_at(5, OTTER, Heartbeat), from_console_at(5, OTTER, start(by))]
            }
            8 => vec![from_console_at(8, dst, ahead())],
            _ => vec![from_console_at(second, OTTER, Heartbeat)],
        });
        assert_eq!(thrust > 0.0, moves, "{dst:#06x}: {thrust}");
    }
}
