//! Tests of the navigator.

use super::*;
use devices::Quality;

fn at(seconds: f64) -> MonoTime {
    MonoTime::from_micros((seconds * 1e6) as u64)
}

fn reading(seconds: f64, north_m: f64) -> GnssReading {
    let frame = LocalFrame::new(LatLon::from_deg(63.33, 10.0833).unwrap());
    let place = frame.to_place(LocalPoint { north_m, east_m: 0.0 });
    GnssReading {
        utc: UtcTime::from_seconds(1_700_000_000.0 + seconds),
        fix: Some(GnssFix {
            lat_rad: place.lat_rad(),
            lon_rad: place.lon_rad(),
            height_m: 40.0,
            quality: Quality::Autonomous,
            hdop: 0.9,
        }),
        satellites: 9,
        velocity: Some(GroundVelocity { course_rad: 0.0, speed_mps: 2.0 }),
        heading_rad: Some(-0.3),
        yaw_rate_rad_s: Some(0.1),
        ..GnssReading::default()
    }
}

fn sailing() -> Navigation {
    let mut navigation = Navigation::new(NavigationSettings::default());
    for second in 0..10 {
        let seconds = f64::from(second);
        navigation.read(at(seconds), &reading(seconds, 2.0 * seconds)).unwrap();
    }
    navigation
}

#[test]
fn keeps_heading_and_course_apart_with_the_right_sign_of_sway() {
    let estimate = sailing().estimate(at(9.0)).unwrap();
    // Bow 0.3 rad to port of a course to the north: set to starboard, v > 0.
    assert!((estimate.motion.sway_mps() - 2.0 * 0.3_f64.sin()).abs() < 1e-9);
    assert!((estimate.motion.surge_mps() - 2.0 * 0.3_f64.cos()).abs() < 1e-9);
    assert!((estimate.offset.north_m - 18.0).abs() < 0.01, "{estimate:?}");
}

#[test]
fn reckons_over_a_gap_with_growing_uncertainty_and_then_gives_up() {
    let navigation = sailing();
    let (near, far) = (navigation.estimate(at(9.0)).unwrap(), navigation.estimate(at(11.5)).unwrap());
    assert!((far.offset.north_m - 23.0).abs() < 0.02);
    assert!((wrap_pi(far.motion.heading_rad + 0.3 - 0.15)).abs() < 1e-9, "no turn is believed for long");
    assert!(far.is_reckoned() && far.is_heading_old() && far.motion.yaw_rate_rad_s.is_none());
    // 0.4 m/s of drift, and half of the 2 m/s that nothing measures any more.
    assert!((far.sigma_m - near.sigma_m - 2.5 * 1.4).abs() < 0.01, "{} of {}", far.sigma_m, near.sigma_m);
    assert_eq!(navigation.health(at(13.9)), NavigationHealth::Reckoning);
    assert_eq!(navigation.health(at(14.1)), NavigationHealth::NoPosition);
    assert!(navigation.estimate(at(14.1)).is_none());
}

#[test]
fn refuses_what_is_no_number_or_too_poor() {
    let mut navigation = sailing();
    let before = navigation.estimate(at(10.0)).unwrap();
    let mut nan = reading(10.0, 20.0);
    nan.heading_rad = Some(f64::NAN);
    nan.yaw_rate_rad_s = Some(f64::INFINITY);
    nan.velocity = Some(GroundVelocity { course_rad: f64::NAN, speed_mps: 2.0 });
    nan.fix = nan.fix.map(|fix| GnssFix { lat_rad: f64::NAN, ..fix });
    assert_eq!(navigation.read(at(10.0), &nan), Err(Rejection::Invalid));
    assert_eq!(navigation.estimate(at(10.0)), Some(before));
    let mut poor = reading(11.0, 22.0);
    poor.fix = poor.fix.map(|fix| GnssFix { hdop: 9.0, ..fix });
    assert_eq!(navigation.read(at(11.0), &poor), Err(Rejection::Dilution));
    poor.fix = poor.fix.map(|fix| GnssFix { hdop: f64::NAN, ..fix });
    assert_eq!(navigation.read(at(12.0), &poor), Err(Rejection::Stale));
    assert_eq!(navigation.read(at(12.0), &GnssReading::default()), Err(Rejection::Invalid));
}

#[test]
fn one_outlier_is_refused_and_three_that_agree_are_believed() {
    let mut navigation = sailing();
    assert_eq!(navigation.read(at(10.0), &reading(10.0, 520.0)), Err(Rejection::Jump));
    navigation.read(at(11.0), &reading(11.0, 22.0)).unwrap();
    assert_eq!(navigation.jumps(), 0);
    for (seconds, north_m) in [(12.0, 524.0), (13.0, 526.0)] {
        assert_eq!(navigation.read(at(seconds), &reading(seconds, north_m)), Err(Rejection::Jump));
        assert!(navigation.estimate(at(seconds)).unwrap().offset.north_m < 30.0);
    }
    navigation.read(at(14.0), &reading(14.0, 528.0)).unwrap();
    assert!((navigation.estimate(at(14.0)).unwrap().offset.north_m - 528.0).abs() < 0.1);
    assert_eq!(navigation.jumps(), 1);
}

#[test]
fn takes_another_reference_far_away_without_moving_the_vessel() {
    let mut navigation = Navigation::new(NavigationSettings::default());
    for second in 0..600 {
        let seconds = f64::from(second);
        navigation.read(at(seconds), &reading(seconds, 2.0 * seconds)).unwrap();
    }
    let estimate = navigation.estimate(at(599.0)).unwrap();
    assert!(estimate.offset.north_m < 250.0);
    let frame = LocalFrame::new(LatLon::from_deg(63.33, 10.0833).unwrap());
    assert!((frame.to_local(estimate.place).north_m - 1198.0).abs() < 1.0);
}

#[test]
fn a_repeated_epoch_is_stale() {
    let mut navigation = sailing();
    assert_eq!(navigation.read(at(9.5), &reading(9.0, 18.0)), Err(Rejection::Stale));
    // Nor does a receiver that hangs keep its heading alive.
    for tenth in 0..50 {
        let now = at(10.0 + 0.1 * f64::from(tenth));
        assert_eq!(navigation.read(now, &reading(9.0, 18.0)), Err(Rejection::Stale));
    }
    assert_eq!(navigation.health(at(14.5)), NavigationHealth::NoPosition);
}

#[test]
fn with_a_heading_the_reckoned_way_turns_with_the_bow() {
    let mut navigation = sailing();
    navigation.reconfigure(NavigationSettings { reckoning_s: 20.0, ..NavigationSettings::default() });
    // Two seconds after the last position the vessel turns to the east, and the compass gives its heading only.
    let turned = |seconds: f64| GnssReading {
        fix: None,
        velocity: None,
        heading_rad: Some(-0.3 + std::f64::consts::FRAC_PI_2),
        yaw_rate_rad_s: Some(0.0),
        ..reading(seconds, 0.0)
    };
    assert_eq!(navigation.read(at(11.0), &turned(11.0)), Err(Rejection::Invalid));
    for second in 12..15 {
        let seconds = f64::from(second);
        assert_eq!(navigation.read(at(seconds), &turned(seconds)), Err(Rejection::Invalid));
    }
    let estimate = navigation.estimate(at(14.0)).unwrap();
    assert!((estimate.offset.north_m - 22.0).abs() < 0.05 && (estimate.offset.east_m - 6.0).abs() < 0.05);
    assert!(estimate.motion.east_mps > 1.9 && estimate.is_reckoned() && !estimate.is_heading_old());
}

#[test]
fn what_is_too_uncertain_is_no_estimate_before_its_time_is_over() {
    let mut navigation = sailing();
    navigation.reconfigure(NavigationSettings { reckoning_s: 60.0, ..NavigationSettings::default() });
    // 1 m, and 1.4 m for each second.
    assert_eq!(navigation.health(at(18.5)), NavigationHealth::Reckoning);
    assert_eq!(navigation.health(at(19.5)), NavigationHealth::NoPosition);
}

#[test]
fn a_position_without_a_dilution_is_used_with_the_assumed_one() {
    let mut navigation = sailing();
    let mut silent = reading(10.0, 20.0);
    silent.fix = silent.fix.map(|fix| GnssFix { hdop: f64::NAN, ..fix });
    navigation.read(at(10.0), &silent).unwrap();
    let estimate = navigation.estimate(at(10.0)).unwrap();
    assert!((estimate.sigma_m - 2.0).abs() < 1e-9, "{}", estimate.sigma_m);
    // One that is too poor by assumption is refused as any other.
    navigation.reconfigure(NavigationSettings { assumed_hdop: 9.0, ..NavigationSettings::default() });
    silent.utc = UtcTime::from_seconds(1_700_000_011.0);
    assert_eq!(navigation.read(at(11.0), &silent), Err(Rejection::Dilution));
}

#[test]
fn a_vessel_that_stands_has_no_velocity_of_before() {
    let mut navigation = sailing();
    let velocity = |course_rad, speed_mps| Some(GroundVelocity { course_rad, speed_mps });
    let stands = GnssReading { velocity: velocity(f64::NAN, 0.0), ..reading(10.0, 20.0) };
    navigation.read(at(10.0), &stands).unwrap();
    let motion = navigation.estimate(at(10.0)).unwrap().motion;
    assert_eq!((motion.north_mps, motion.east_mps), (0.0, 0.0));
    // Faster without a course it is nonsense, and changes nothing.
    let nonsense = GnssReading { velocity: velocity(f64::NAN, 2.0), ..reading(11.0, 20.0) };
    navigation.read(at(11.0), &nonsense).unwrap();
    assert!(navigation.estimate(at(11.0)).unwrap().motion.north_mps.abs() < 1e-9);
}
