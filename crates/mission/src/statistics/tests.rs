//! Tests of statistics and progress.

use super::*;
use crate::maneuver::{Left, Loiter, Teleoperation};
use crate::testing::{SPEED, at, goto, idle, place, plan};

fn statistics(maneuvers: Vec<Maneuver<crate::RawPlace>>) -> PlanStatistics {
    PlanStatistics::of(&plan(maneuvers), Some(place(0.0, 0.0)), at(0.0), &VehicleModel::default())
}

#[track_caller]
fn assert_close(value: Option<f64>, expected: f64) {
    let value = value.unwrap();
    assert!((value - expected).abs() < 1e-3 * expected.abs().max(1.0), "{value} is not {expected}");
}

#[test]
fn adds_up_length_duration_and_energy() {
    let statistics = statistics(vec![goto(150.0, 0.0), idle(60), goto(150.0, 300.0)]);
    assert_eq!(statistics.maneuvers.len(), 3);
    assert_close(statistics.maneuvers[0].1.duration_s, 100.0);
    assert_close(statistics.maneuvers[1].1.length_m, 0.0);
    assert_close(statistics.total.length_m, 450.0);
    assert_close(statistics.total.duration_s, 360.0);
    let moving_w = VehicleModel::default().power_w(1.5);
    assert_close(statistics.total.energy_j, 300.0 * moving_w + 60.0 * 30.0);
}

#[test]
fn a_loiter_takes_the_way_to_its_circle_and_its_time() {
    let loiter = Maneuver::Loiter(Loiter {
        centre: place(100.0, 0.0).into(),
        radius_m: 10.0,
        speed: SPEED,
        duration: Some(Duration::from_mins(1)),
        shape: LoiterShape::Circle(units::Turn::Clockwise),
    });
    let statistics = statistics(vec![loiter]);
    assert_close(statistics.total.duration_s, 120.0);
    assert_close(statistics.total.length_m, 180.0);
}

#[test]
fn what_cannot_be_known_is_absent() {
    let steered = Maneuver::Teleoperation(Teleoperation { operator: crate::Operator::Anyone });
    for unknown in [steered, idle(0)] {
        let statistics = statistics(vec![goto(150.0, 0.0), unknown]);
        assert_close(statistics.maneuvers[0].1.duration_s, 100.0);
        assert_eq!(statistics.maneuvers[1].1, Cost::default());
        assert_eq!(statistics.total, Cost::default());
    }
    let nowhere = PlanStatistics::of(&plan(vec![goto(1.0, 0.0)]), None, at(0.0), &VehicleModel::default());
    assert_eq!(nowhere.total, Cost::default());
}

#[test]
fn a_model_reads_between_its_rows_and_stops_at_the_last() {
    let model = VehicleModel::default();
    let cases = [
        (Speed::Percent(15.0), 1.15),
        (Speed::Rpm(60.0), 0.5),
        (Speed::Percent(100.0), 3.09),
        (Speed::Rpm(0.0), 0.0),
        (Speed::MetresPerSecond(1.7), 1.7),
    ];
    for (speed, mps) in cases {
        assert!((model.mps(speed) - mps).abs() < 1e-9, "{speed}: {}", model.mps(speed));
    }
    assert!((model.power_w(99.0) - model.power_w(3.09)).abs() < 1e-9);
    assert_eq!(VehicleModel::new(Vec::new()), Err(ModelError::TooFewRows));
    let row = |mps| ModelPoint { percent: mps, rpm: mps, mps, power_w: mps };
    assert_eq!(VehicleModel::new(vec![row(0.0), row(2.0), row(1.0)]), Err(ModelError::Row(2)));
    assert_eq!(VehicleModel::new(vec![row(0.0), row(f64::NAN)]), Err(ModelError::Row(1)));
}

#[test]
fn progress_follows_reality() {
    let plan = plan(vec![goto(150.0, 0.0), goto(300.0, 0.0)]);
    let mut progress = Progress::new(&plan, Some(place(0.0, 0.0)), at(0.0), &VehicleModel::default());
    progress.begin(0);
    let left = |way_m| Some(Left { way_m, wait_s: 0.0 });
    let start = progress.standing(at(0.0), left(150.0));
    assert_close(start.progress, 0.0);
    assert_close(start.plan_eta_s, 200.0);
    // Half the first leg takes three times as long as planned: what is left does, nearly.
    let half = progress.standing(at(150.0), left(75.0));
    assert_close(half.progress, 0.25);
    assert_close(half.plan_eta_s, 150.0 * 180.0 / 80.0);
    assert_close(half.maneuver_eta_s, 50.0 * 180.0 / 80.0);
    let back = progress.standing(at(160.0), left(90.0));
    assert_close(back.progress, 0.25);
    progress.begin(1);
    assert_close(progress.standing(at(300.0), left(0.0)).progress, 1.0);
}
