//! The whole vessel: repeatability, faults and what must hold whatever is asked of it.

use devices::torqeedo::{CanFrame, CardCommand};
use devices::{Pair, Reading, Side};
use proptest::prelude::*;
use sim::{
    BatteryConfig, CurrentConfig, EnvironmentConfig, FishConfig, GnssConfig, Output, OutputForm, Port, Timed,
    Vessel, VesselConfig, WaveConfig, WindConfig,
};
use std::time::Duration;
use units::{LatLon, LocalPoint, MonoTime, UtcTime};

const STEP: Duration = Duration::from_millis(40);

fn config(seed: u64) -> VesselConfig {
    let place = LatLon::from_deg(63.44, 10.35).unwrap();
    VesselConfig::at(place, UtcTime::from_micros(1_718_000_000_000_000), seed)
}

fn rough(seed: u64) -> VesselConfig {
    let calm = config(seed);
    VesselConfig {
        environment: EnvironmentConfig {
            current: CurrentConfig { speed_mps: 0.3, variation_mps: 0.05, ..CurrentConfig::default() },
            wind: WindConfig { speed_mps: 7.0, from_rad: 1.0, ..WindConfig::default() },
            waves: WaveConfig { significant_height_m: 0.4, ..WaveConfig::default() },
        },
        gnss: GnssConfig { outages_per_hour: 10.0, ..GnssConfig::default() },
        fish: vec![
            FishConfig::near(calm.start_place, calm.start_utc, 40, 1),
            FishConfig::near(calm.start_place, calm.start_utc, 41, 2),
        ],
        form: OutputForm::Both,
        ..calm
    }
}

/// Steps on under a command that is kept up, and collects what comes out.
fn sail(vessel: &mut Vessel, seconds: u64, port: f64, starboard: f64) -> Vec<Timed> {
    let mut outputs = Vec::new();
    for step in 0..seconds * 25 {
        if step % 10 == 0 {
            vessel.command(port, starboard).unwrap();
        }
        vessel.step(STEP);
        outputs.extend(std::iter::from_fn(|| vessel.poll_output()));
    }
    outputs
}

fn serial_text(outputs: &[Timed], wanted: Port) -> String {
    let bytes: Vec<u8> = outputs
        .iter()
        .filter_map(|timed| match &timed.output {
            Output::Serial(port, bytes) if *port == wanted => Some(bytes.clone()),
            _ => None,
        })
        .flatten()
        .collect();
    String::from_utf8(bytes).unwrap()
}

/// Whether a sentence ends in the right checksum.
fn checksum_holds(sentence: &str) -> bool {
    let Some((body, sum)) = sentence.strip_prefix('$').and_then(|s| s.split_once('*')) else { return false };
    u8::from_str_radix(sum, 16) == Ok(body.bytes().fold(0, |sum, byte| sum ^ byte))
}

#[test]
fn the_same_seed_gives_the_same_bytes_for_an_hour() {
    let run = |seed| sail(&mut Vessel::new(&rough(seed)).unwrap(), 3600, 0.5, 0.45);
    let first = run(1);
    assert!(first.len() > 60_000, "{}", first.len());
    assert_eq!(first, run(1));
    let other = run(2);
    assert_ne!(serial_text(&first, Port::Gnss), serial_text(&other, Port::Gnss));
    let text = serial_text(&first, Port::Gnss);
    assert!(text.split_terminator("\r\n").all(checksum_holds));
    assert_eq!(text.matches("$GPZDA").count(), 3600);
    assert!(text.contains(",,,,,0,"), "the outages leave their mark");
    assert!(serial_text(&first, Port::Hydrophone).contains(",S256,40,"));
    assert!(first.windows(2).all(|w| w[0].at <= w[1].at));
}

#[test]
fn the_length_of_the_calls_does_not_matter() {
    let mut whole = Vessel::new(&rough(1)).unwrap();
    let mut parts = whole.clone();
    whole.step(Duration::from_mins(1));
    for ms in [1, 7, 33, 150, 809].into_iter().cycle().take(300) {
        parts.step(Duration::from_millis(ms));
    }
    assert_eq!(parts.now(), MonoTime::from_micros(60_000_000));
    let drain = |vessel: &mut Vessel| std::iter::from_fn(|| vessel.poll_output()).collect::<Vec<_>>();
    assert_eq!(drain(&mut whole), drain(&mut parts));
    assert_eq!(whole.truth(), parts.truth());
}

#[test]
fn straight_ahead_it_reaches_the_speed_of_the_model() {
    let mut vessel = Vessel::new(&config(1)).unwrap();
    for _ in 0..120 {
        // 60 rad/s; the model's answer is 1.0287 m/s.
        vessel.command_rpm(572.958, 572.958).unwrap();
        vessel.step(Duration::from_millis(500));
    }
    let truth = vessel.truth();
    assert!((truth.speed_mps - 1.0287).abs() < 1e-3, "{truth:?}");
    assert!((vessel.motor(Side::Port).propeller_rpm - 572.958).abs() < 0.1);
}

#[test]
fn in_a_beam_wind_it_drifts_away_at_some_percent_of_the_wind() {
    let mut config = config(1);
    config.environment.wind = WindConfig { speed_mps: 7.0, from_rad: 0.0, ..WindConfig::default() };
    config.heading_rad = 1.57;
    let mut vessel = Vessel::new(&config).unwrap();
    sail(&mut vessel, 300, 0.0, 0.0);
    let drifted = vessel.truth().state.position;
    // To the south; leeway of small craft is one to a few percent of the wind.
    let share = -drifted.north_m / 300.0 / 7.0;
    assert!((0.01..0.05).contains(&share), "{share}");
}

#[test]
fn waves_make_it_oscillate_but_carry_it_nowhere() {
    let mut config = config(1);
    config.environment.waves =
        WaveConfig { significant_height_m: 0.3, from_rad: 0.8, ..WaveConfig::default() };
    let mut vessel = Vessel::new(&config).unwrap();
    let (mut fastest_mps, mut fastest_radps) = (0.0_f64, 0.0_f64);
    for _ in 0..300 * 25 {
        vessel.step(STEP);
        fastest_mps = fastest_mps.max(vessel.truth().speed_mps);
        fastest_radps = fastest_radps.max(vessel.truth().state.r_radps.abs());
    }
    let position = vessel.truth().state.position;
    println!("{fastest_mps} m/s, {fastest_radps} rad/s, {position:?}");
    // The amplitudes of the water's own movement add up to 0.45 m/s; the hull rides with it.
    assert!((0.1..0.5).contains(&fastest_mps), "{fastest_mps}");
    assert!((0.005..0.2).contains(&fastest_radps), "{fastest_radps}");
    assert!(position.north_m.hypot(position.east_m) < 3.0, "{position:?}");
}

#[test]
fn without_commands_the_card_stops_the_motors() {
    let mut vessel = Vessel::new(&config(1)).unwrap();
    let set = CardCommand::MotorSet(Pair::new(600, 600)).frame();
    vessel.receive_can(&set).unwrap();
    vessel.step(Duration::from_secs(1));
    assert!(vessel.motor(Side::Port).propeller_rpm > 590.0);
    vessel.step(Duration::from_secs(2));
    assert!(vessel.motor(Side::Port).propeller_rpm.abs() < 0.1);
    assert!(vessel.receive_can(&CanFrame::new(0x1234, &[]).unwrap()).is_err());
    vessel.faults_mut().card_deaf = true;
    vessel.receive_can(&set).unwrap();
    vessel.step(Duration::from_millis(500));
    assert!(vessel.motor(Side::Port).propeller_rpm.abs() < 0.1);
}

#[test]
fn injected_faults_reach_the_bytes() {
    let mut vessel = Vessel::new(&config(1)).unwrap();
    sail(&mut vessel, 5, 0.3, 0.3);
    vessel.faults_mut().heading_nan = true;
    assert!(serial_text(&sail(&mut vessel, 3, 0.3, 0.3), Port::Gnss).contains("$GPHDT,NaN,T*"));
    *vessel.faults_mut() = sim::Faults { gnss_silent: true, ..sim::Faults::default() };
    // Bytes that were on the line when the silence began still arrive.
    sail(&mut vessel, 1, 0.3, 0.3);
    assert_eq!(serial_text(&sail(&mut vessel, 5, 0.3, 0.3), Port::Gnss), "");
    *vessel.faults_mut() =
        sim::Faults { motor_feedback_lost: Pair::new(false, true), ..sim::Faults::default() };
    let outputs = sail(&mut vessel, 2, 0.3, 0.3);
    let drives = |motor: u8| {
        let is = |timed: &&Timed| matches!(&timed.output, Output::Can(f) if f.id() == 0x00C0_ABFF && f.data()[0] == motor);
        outputs.iter().filter(is).count()
    };
    assert_eq!((drives(0), drives(1)), (10, 0));
    *vessel.faults_mut() = sim::Faults { card_silent: true, ..sim::Faults::default() };
    let outputs = sail(&mut vessel, 2, 0.3, 0.3);
    assert!(!outputs.iter().any(|timed| matches!(timed.output, Output::Can(_))));
}

#[test]
fn a_position_jump_moves_the_fix_but_not_the_vessel() {
    let mut vessel = Vessel::new(&VesselConfig {
        form: OutputForm::Values,
        gnss: GnssConfig::default().perfect(),
        ..config(1)
    })
    .unwrap();
    vessel.faults_mut().position_jump = Some(LocalPoint { north_m: 100.0, east_m: 0.0 });
    let outputs = sail(&mut vessel, 3, 0.0, 0.0);
    let Some(Output::Reading(Reading::Gnss(reading))) =
        outputs.iter().map(|t| &t.output).find(|o| matches!(o, Output::Reading(Reading::Gnss(_))))
    else {
        panic!("no epoch came");
    };
    let fix = reading.fix.unwrap();
    let found = vessel.frame().to_local(LatLon::from_rad(fix.lat_rad, fix.lon_rad).unwrap());
    assert!((found.north_m - 100.0).abs() < 1e-6);
    assert!(vessel.truth().state.position.north_m.abs() < 1e-9);
}

#[test]
fn an_empty_battery_stops_the_vessel() {
    let mut vessel = Vessel::new(&VesselConfig { form: OutputForm::Values, ..config(1) }).unwrap();
    sail(&mut vessel, 10, 0.8, 0.8);
    vessel.drain_to(15.0);
    let outputs = sail(&mut vessel, 2, 0.8, 0.8);
    assert!(outputs.iter().any(
        |t| matches!(t.output, Output::Reading(Reading::Battery(r)) if (14.0..16.0).contains(&r.charge_percent))
    ));
    vessel.drain_to(0.0);
    sail(&mut vessel, 20, 0.8, 0.8);
    assert!(vessel.truth().speed_mps < 0.01);
    assert!(vessel.battery().is_empty());
}

#[test]
fn three_vessels_hear_the_same_fish_at_ranges_that_fit() {
    let place = LatLon::from_deg(63.44, 10.35).unwrap();
    let since = UtcTime::from_micros(1_718_000_000_000_000);
    let fish = FishConfig { radius_m: 50.0, ..FishConfig::near(place, since, 40, 9) };
    let stamps = |north_m: f64| {
        let frame = units::LocalFrame::new(place);
        let start = frame.to_place(LocalPoint { north_m, east_m: 0.0 });
        let mut config = VesselConfig { fish: vec![fish], form: OutputForm::Values, ..config(1) };
        config.start_place = start;
        config.hydrophone.miss_probability = 0.0;
        config.hydrophone.sensor_interval_s = 0.0;
        let mut vessel = Vessel::new(&config).unwrap();
        sail(&mut vessel, 600, 0.0, 0.0)
            .into_iter()
            .filter_map(|t| match t.output {
                Output::Reading(Reading::Tag(tag)) => {
                    Some(f64::from(tag.clock_s) + f64::from(tag.millis) / 1e3)
                }
                _ => None,
            })
            .collect::<Vec<f64>>()
    };
    let (south, north) = (stamps(-200.0), stamps(200.0));
    assert_eq!(south.len(), north.len());
    assert!(south.len() >= 6);
    for (s, n) in south.iter().zip(&north) {
        // Receivers 400 m apart: no difference beyond 400 m / 1485 m/s plus the jitter.
        assert!((s - n).abs() < 0.27 + 0.01, "{s} {n}");
    }
}

#[test]
fn the_hydrophone_answers_a_clock_message() {
    let mut vessel = Vessel::new(&config(1)).unwrap();
    for byte in b"(+)" {
        vessel.receive_serial(Port::Hydrophone, &[*byte]);
        vessel.step(Duration::from_millis(1));
    }
    let outputs = sail(&mut vessel, 1, 0.0, 0.0);
    assert_eq!(serial_text(&outputs, Port::Hydrophone), "ack01\r");
}

#[test]
fn outputs_that_nobody_polls_are_counted_when_lost() {
    let mut vessel = Vessel::new(&config(1)).unwrap();
    vessel.step(Duration::from_mins(100));
    assert!(vessel.outputs_lost() > 0);
    assert!(vessel.poll_output().is_some());
}

#[test]
fn refuses_settings_and_commands_that_are_no_numbers() {
    let mut vessel = Vessel::new(&config(1)).unwrap();
    assert!(vessel.command(f64::NAN, 0.0).is_err());
    assert!(vessel.command(0.0, 1.1).is_err());
    assert!(vessel.command_rpm(0.0, f64::INFINITY).is_err());
    for broken in [
        VesselConfig { heading_rad: f64::NAN, ..config(1) },
        VesselConfig { payload_kg: 46.0, ..config(1) },
        VesselConfig { water_c: 80.0, ..config(1) },
        VesselConfig { start_utc: UtcTime::from_micros(i64::MAX), ..config(1) },
        VesselConfig {
            fish: vec![FishConfig::near(config(1).start_place, UtcTime::from_micros(0), 1, 1)],
            ..config(1)
        },
        VesselConfig { battery: BatteryConfig { hotel_w: -1.0, ..BatteryConfig::default() }, ..config(1) },
    ] {
        assert!(Vessel::new(&broken).is_err());
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(48))]

    #[test]
    fn whatever_is_asked_everything_stays_finite_and_energy_only_drains(
        seed in any::<u64>(),
        payload_kg in 0.0..=45.0,
        heading_rad in -3.1..3.1,
        wind_mps in 0.0..40.0,
        wave_m in 0.0..3.0,
        current_mps in 0.0..5.0,
        commands in proptest::collection::vec((-1.0..=1.0, -1.0..=1.0, 1_u64..2_000), 1..60),
    ) {
        let mut config = rough(seed);
        config.payload_kg = payload_kg;
        config.heading_rad = heading_rad;
        config.environment.wind.speed_mps = wind_mps;
        config.environment.waves.significant_height_m = wave_m;
        config.environment.current.speed_mps = current_mps;
        let mut vessel = Vessel::new(&config).unwrap();
        let mut stored_wh = vessel.truth().stored_wh;
        for (port, starboard, ms) in commands {
            vessel.command(port, starboard).unwrap();
            vessel.step(Duration::from_millis(ms));
            let truth = vessel.truth();
            let s = truth.state;
            for value in [s.position.north_m, s.position.east_m, s.psi_rad, s.u_mps, s.v_mps, s.r_radps] {
                prop_assert!(value.is_finite());
            }
            prop_assert!(truth.stored_wh <= stored_wh);
            stored_wh = truth.stored_wh;
            while let Some(timed) = vessel.poll_output() {
                if let Output::Serial(Port::Gnss, bytes) = &timed.output {
                    let text = std::str::from_utf8(bytes).unwrap();
                    prop_assert!(text.ends_with("\r\n") && checksum_holds(text.trim_end()), "{text:?}");
                    prop_assert!(text.len() <= 100);
                }
            }
        }
    }

    #[test]
    fn frames_of_any_content_are_refused_or_obeyed_without_harm(
        id in 0_u32..1 << 29,
        aimed in any::<bool>(),
        data in proptest::collection::vec(any::<u8>(), 0..=8),
    ) {
        let mut vessel = Vessel::new(&config(1)).unwrap();
        let id = if aimed { id & 0x1FF0_0000 | 0xFEAB } else { id };
        let _ = vessel.receive_can(&CanFrame::new(id, &data).unwrap());
        vessel.step(Duration::from_millis(200));
        prop_assert!(vessel.truth().speed_mps.is_finite());
    }

    #[test]
    fn bytes_of_any_content_on_the_serial_lines_do_no_harm(
        pieces in proptest::collection::vec(proptest::collection::vec(any::<u8>(), 0..200), 0..5),
    ) {
        let mut vessel = Vessel::new(&config(1)).unwrap();
        for piece in pieces {
            vessel.receive_serial(Port::Hydrophone, &piece);
            vessel.receive_serial(Port::Gnss, &piece);
            vessel.step(STEP);
        }
    }
}
