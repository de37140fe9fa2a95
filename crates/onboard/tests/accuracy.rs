//! How well the whole chain sails: compass, navigation, guidance, control, motors, hull (issue 3's figures).

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

mod common;

use common::*;
use imc::messages::*;
use sim::{GnssConfig, VesselConfig, WindConfig};
use units::LocalPoint;

/// A compass with a metre of noise, a cross current of 0.3 m/s, gusts.
fn rough(vessel: &mut VesselConfig) {
    vessel.gnss = GnssConfig { rate_hz: 5, baud: 115_200, ..GnssConfig::default() };
    vessel.environment.current.speed_mps = 0.3;
    vessel.environment.current.to_rad = std::f64::consts::FRAC_PI_2;
    vessel.environment.wind = WindConfig { speed_mps: 5.0, from_rad: -1.0, ..vessel.environment.wind };
}

fn sail(sea: &mut Sea, corners: &[(f64, f64)], limit_s: f64) -> Vec<(String, LocalPoint)> {
    let goto = |(n, (north_m, east_m)): (usize, &(f64, f64))| {
        (format!("{n}"), Message::from(goto(*north_m, *east_m, 1.5)))
    };
    let plan = plan("course", corners.iter().enumerate().map(goto).collect());
    sea.ask(PlanControlOp::Start, "course", Some(plan.into()));
    let mut track = Vec::new();
    for _ in 0..(limit_s * 2.0) as u64 {
        sea.run(0.5);
        let state = sea.plan_state();
        if state.state != PlanControlStateState::Executing {
            assert_eq!(state.last_outcome, PlanControlStateLastOutcome::Success);
            return track;
        }
        track.push((state.man_id.to_string(), sea.position()));
        sea.forget();
        sea.said.clear();
    }
    panic!("not done in {limit_s} s");
}

#[test]
fn legs_of_200_m_in_a_cross_current_with_gusts() {
    // The vessel can follow no closer than its compass tells: the slow error of the receiver (0.67 m on each
    // axis) stands apart from what the chain adds.
    for (white_m, slow_m, most_m) in [(1.0, 0.0, 0.5), (0.2, 0.67, 1.0)] {
        let mut sea = Sea::with(settings(), |vessel| {
            rough(vessel);
            vessel.gnss.position_white_m = white_m;
            vessel.gnss.position_slow_m = slow_m;
        })
        .ready();
        let track = sail(&mut sea, &[(20.0, 0.0), (220.0, 0.0), (220.0, 0.0)], 400.0);
        let leg = track.iter().filter(|(id, at)| id == "1" && at.north_m > 60.0 && at.north_m < 205.0);
        let cross: Vec<f64> = leg.map(|(_, at)| at.east_m).collect();
        let rms_m = (cross.iter().map(|m| m * m).sum::<f64>() / cross.len() as f64).sqrt();
        println!("white {white_m} m, slow {slow_m} m: RMS {rms_m:.2} m of {} places", cross.len());
        assert!(rms_m <= most_m, "{rms_m}");
    }
}

#[test]
fn a_square_of_a_kilometre_overshoots_little() {
    let mut sea = Sea::with(settings(), rough).ready();
    let corners = [(1000.0, 0.0), (1000.0, 1000.0), (0.0, 1000.0), (0.0, 0.0), (1000.0, 0.0)];
    let track = sail(&mut sea, &corners, 6000.0);
    // Beyond the square, on the side that each turn swings out to.
    let outside = |at: &LocalPoint| {
        [at.north_m - 1000.0, -at.north_m, at.east_m - 1000.0, -at.east_m]
            .into_iter()
            .fold(f64::MIN, f64::max)
    };
    let worst_m = track.iter().skip(60).map(|(_, at)| outside(at)).fold(f64::MIN, f64::max);
    println!("overshoot {worst_m:.2} m");
    assert!(worst_m <= 4.0, "{worst_m}");
}

#[test]
fn holds_a_station_of_10_m_for_an_hour_with_motors_mostly_off() {
    let mut sea = Sea::with(settings(), |vessel| {
        vessel.gnss = GnssConfig { rate_hz: 5, baud: 115_200, ..GnssConfig::default() };
    })
    .ready();
    let station = StationKeeping {
        lat: place(0.0, 0.0).lat_rad(),
        lon: place(0.0, 0.0).lon_rad(),
        z_units: ZUnits::Depth,
        radius: 10.0,
        speed: 1.0,
        ..StationKeeping::default()
    };
    sea.ask(PlanControlOp::Start, "station", Some(station.into()));
    let (mut inside, mut running) = (0, 0);
    for _ in 0..3600 {
        sea.forget();
        sea.run(1.0);
        inside += u32::from(sea.position().distance_m(LocalPoint::default()) <= 10.0);
        running += u32::from(sea.motors.iter().any(|(_, motors)| *motors != control::MotorPair::STOPPED));
    }
    println!("inside {:.1} %, motors on {:.1} %", f64::from(inside) / 36.0, f64::from(running) / 36.0);
    assert!(inside >= 3564 && running <= 900, "{inside}, {running}");
}

#[test]
fn a_compass_of_one_epoch_a_second_is_enough() {
    let mut sea = Sea::with(settings(), |vessel| {
        rough(vessel);
        vessel.gnss.rate_hz = 1;
        vessel.gnss.position_slow_m = 0.0;
    })
    .ready();
    let track = sail(&mut sea, &[(20.0, 0.0), (220.0, 0.0)], 400.0);
    let worst_m = track
        .iter()
        .filter(|(id, at)| id == "1" && at.north_m > 60.0 && at.north_m < 205.0)
        .map(|(_, at)| at.east_m.abs())
        .fold(0.0, f64::max);
    println!("1 Hz: largest error {worst_m:.2} m");
    assert!(worst_m < 2.0, "{worst_m}");
}
