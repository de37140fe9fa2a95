//! The accuracy of the whole chain: compass, navigation, guidance, control, motors, hull.

use crate::common::*;
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

/// Where the vessel is and where it believes to be, on the way to a corner.
struct Moment {
    corner: String,
    truth: LocalPoint,
    belief: LocalPoint,
}

fn sail(sea: &mut Sea, corners: &[(f64, f64)], limit_s: f64) -> Vec<Moment> {
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
        let belief = frame().to_local(sea.vehicle.brain.estimate().unwrap().place);
        track.push(Moment { corner: state.man_id.to_string(), truth: sea.position(), belief });
        sea.forget();
    }
    panic!("not done in {limit_s} s");
}

/// The settled part of a leg of 200 m to the north, with so much white and slow error on each axis.
fn leg(seed: u64, rate_hz: u32, (white_m, slow_m): (f64, f64)) -> Vec<Moment> {
    let mut sea = Sea::with(settings(), |vessel| {
        rough(vessel);
        vessel.seed = seed;
        vessel.gnss.rate_hz = rate_hz;
        vessel.gnss.position_white_m = white_m;
        vessel.gnss.position_slow_m = slow_m;
    })
    .ready();
    let mut track = sail(&mut sea, &[(20.0, 0.0), (220.0, 0.0)], 400.0);
    track.retain(|at| at.corner == "1" && at.truth.north_m > 60.0 && at.truth.north_m < 205.0);
    assert!(track.len() > 150, "a leg of {} moments", track.len());
    track
}

/// RMS distance from the leg (m).
fn rms_m(track: &[Moment], place: impl Fn(&Moment) -> LocalPoint) -> f64 {
    let squares = track.iter().map(|at| place(at).east_m.powi(2));
    (squares.sum::<f64>() / track.len() as f64).sqrt()
}

/// Issue 3: at most 0.5 m RMS of the true track, with positions of 1 m noise.
#[test]
fn legs_of_200_m_in_a_cross_current_with_gusts() {
    for seed in 1..=6 {
        let rms_m = rms_m(&leg(seed, 5, (1.0, 0.0)), |at| at.truth);
        println!("noise 1 m, seed {seed}: RMS {rms_m:.2} m");
        assert!(rms_m <= 0.5, "seed {seed}: {rms_m}");
    }
}

/// The slow error of the receiver is in every position: the vessel can follow no closer than that (see
/// docs/simulation.md). What the chain adds to it is what can be asked for.
#[test]
fn legs_with_a_receiver_that_drifts_are_followed_as_the_receiver_sees_them() {
    for seed in 1..=6 {
        let track = leg(seed, 5, (0.2, 0.67));
        let (true_m, believed_m) = (rms_m(&track, |at| at.truth), rms_m(&track, |at| at.belief));
        println!("drift 0.67 m, seed {seed}: RMS {true_m:.2} m, as believed {believed_m:.2} m");
        assert!(believed_m <= 0.25, "seed {seed}: {believed_m}");
        assert!(true_m <= 3.0 * 0.67, "seed {seed}: {true_m}");
    }
}

fn overshoot_m(seed: u64, (white_m, slow_m): (f64, f64)) -> f64 {
    let mut sea = Sea::with(settings(), |vessel| {
        rough(vessel);
        vessel.seed = seed;
        vessel.gnss.position_white_m = white_m;
        vessel.gnss.position_slow_m = slow_m;
    })
    .ready();
    let corners = [(1000.0, 0.0), (1000.0, 1000.0), (0.0, 1000.0), (0.0, 0.0), (1000.0, 0.0)];
    let track = sail(&mut sea, &corners, 6000.0);
    // Beyond the square, on the side that each turn swings out to.
    let outside = |at: &Moment| {
        let at = at.truth;
        [at.north_m - 1000.0, -at.north_m, at.east_m - 1000.0, -at.east_m]
            .into_iter()
            .fold(f64::MIN, f64::max)
    };
    let worst_m = track.iter().skip(60).map(outside).fold(f64::MIN, f64::max);
    println!("noise {white_m} m, drift {slow_m} m, seed {seed}: overshoot {worst_m:.2} m");
    worst_m
}

#[test]
fn a_square_of_a_kilometre_overshoots_little() {
    (1..=2).for_each(|seed| assert!(overshoot_m(seed, (1.0, 0.0)) <= 4.0));
}

#[test]
fn a_square_overshoots_little_with_a_receiver_that_drifts() {
    (1..=2).for_each(|seed| assert!(overshoot_m(seed, (0.2, 0.67)) <= 4.0));
}

/// The result of some time on a station of 10 m, with the simulator's usual compass.
#[derive(Debug)]
struct Watch {
    /// Share of the time that the vessel was truly inside.
    inside: f64,
    /// Share of the time that a motor was on.
    running: f64,
    /// Times that the motors were switched on.
    drives: usize,
    /// Farthest from the centre (m).
    farthest_m: f64,
}

fn station(seed: u64, wind_mps: f64, current_mps: f64, seconds: u32) -> Watch {
    let centre = LocalPoint { north_m: 25.0, east_m: 10.0 };
    let mut sea = Sea::with(settings(), |vessel| {
        vessel.seed = seed;
        vessel.gnss = GnssConfig { rate_hz: 5, baud: 115_200, ..GnssConfig::default() };
        vessel.environment.current.speed_mps = current_mps;
        vessel.environment.current.to_rad = std::f64::consts::FRAC_PI_2;
        vessel.environment.wind =
            WindConfig { speed_mps: wind_mps, from_rad: -1.0, ..vessel.environment.wind };
    })
    .ready();
    let station = StationKeeping {
        lat: place(centre.north_m, centre.east_m).lat_rad(),
        lon: place(centre.north_m, centre.east_m).lon_rad(),
        z_units: ZUnits::Depth,
        radius: 10.0,
        speed: 1.0,
        ..StationKeeping::default()
    };
    sea.ask(PlanControlOp::Start, "station", Some(station.into()));
    // It has arrived when it rests for the first time.
    sea.run(5.0);
    let rests = |sea: &Sea| sea.motors.last().is_some_and(|(_, m)| *m == control::MotorPair::STOPPED);
    assert!(sea.run_until(120.0, rests), "it arrives");
    let (mut inside, mut running, mut drives, mut farthest_m) = (0, 0, 0, 0.0_f64);
    let mut was_on = false;
    for _ in 0..seconds {
        sea.forget();
        sea.run(1.0);
        let range_m = sea.position().distance_m(centre);
        farthest_m = farthest_m.max(range_m);
        inside += u32::from(range_m <= 10.0);
        let on = sea.motors.iter().any(|(_, motors)| *motors != control::MotorPair::STOPPED);
        running += u32::from(on);
        drives += usize::from(on && !was_on);
        was_on = on;
    }
    let share = |count: u32| f64::from(count) / f64::from(seconds);
    Watch { inside: share(inside), running: share(running), drives, farthest_m }
}

fn holds(seed: u64, wind_mps: f64, current_mps: f64, most_running: f64) {
    let watch = station(seed, wind_mps, current_mps, 3600);
    println!(
        "wind {wind_mps} m/s, current {current_mps} m/s, seed {seed}: inside {:.2} %, motors on {:.2} %, \
         {} drives, at most {:.2} m from the centre",
        100.0 * watch.inside,
        100.0 * watch.running,
        watch.drives,
        watch.farthest_m
    );
    assert!(watch.inside >= 0.99 && watch.running <= most_running, "seed {seed}: {watch:?}");
}

// Issue 3 asks for 99 % inside with motors on at most 25 % of an hour without current. Several tests, so that
// they run beside each other.

#[test]
fn holds_a_station_of_10_m_for_an_hour_in_still_water_without_a_motor() {
    (1..=3).for_each(|seed| holds(seed, 0.0, 0.0, 0.0));
}

#[test]
fn holds_a_station_in_still_water_whatever_the_compass_says() {
    (4..=6).for_each(|seed| holds(seed, 0.0, 0.0, 0.0));
}

#[test]
fn holds_a_station_in_wind_of_3_mps_with_motors_mostly_off() {
    (1..=3).for_each(|seed| holds(seed, 3.0, 0.0, 0.04));
}

#[test]
fn holds_a_station_in_wind_whatever_the_compass_says() {
    (4..=6).for_each(|seed| holds(seed, 3.0, 0.0, 0.04));
}

#[test]
fn holds_a_station_in_rough_water_and_in_a_stream() {
    holds(1, 5.0, 0.3, 0.35);
    holds(1, 0.0, 0.1, 0.12);
}

#[test]
fn a_compass_of_one_epoch_a_second_is_enough() {
    let track = leg(7, 1, (0.2, 0.0));
    let worst_m = track.iter().map(|at| at.truth.east_m.abs()).fold(0.0, f64::max);
    println!("1 Hz: largest error {worst_m:.2} m");
    assert!(worst_m < 2.0, "{worst_m}");
}
