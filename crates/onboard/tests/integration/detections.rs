//! Detections get the vessel's pose and are reported whole: also before the receiver's clock is set, and in codings that
//! have no number in IMC.

use crate::common::*;
use ::detections::{ClockState, Detection, Listening, Origin, fused};
use devices::{MotorReading, Reading, ReceiverReading, Side, TagReading, WaterReading};
use imc::messages::*;
use onboard::{Entity, HydrophoneSettings, Input, LeverArm, Settings};
use std::time::Duration;
use units::{LatLon, MonoTime, UtcTime};

fn tag(clock_s: u32, protocol: &str, counter: u16) -> TagReading {
    let mut tag = TagReading {
        serial: 1234,
        clock_s,
        millis: 45,
        protocol: protocol.to_owned(),
        tag_id: 1705,
        data: Some(8),
        snr_db: 23,
        frequency_khz: 69,
        counter,
        raw: None,
        lines_lost: None,
    };
    tag.raw = Some(tag.line());
    tag
}

/// By the moment at which it was sent.
fn origin(now: units::Now) -> Origin {
    Origin { system: imc::Address(7), entity: 9, reported: now.utc, received: None }
}

/// The detections that the vessel reported whole.
fn reports(sea: &Sea) -> Vec<Detection> {
    let told = |(now, event): (units::Now, Event)| Detection::from_report(origin(now), &event);
    sea.all().into_iter().filter_map(told).collect()
}

/// Its reports of how the receiver listens.
fn listening(sea: &Sea) -> Vec<Listening> {
    sea.all::<Event>().iter().filter_map(|(_, event)| Listening::from_report(event)).collect()
}

/// The vessel's clock in whole seconds and the rest of the receiver's stamp.
fn stamp_of(utc: UtcTime) -> (u32, u16) {
    let (seconds, micros) = (utc.micros().div_euclid(1_000_000), utc.micros().rem_euclid(1_000_000));
    (u32::try_from(seconds).unwrap(), (micros / 1000) as u16)
}

/// A boat that goes north at some two metres a second, pushed by the water.
fn adrift(settings: Settings, change: impl FnOnce(&mut sim::VesselConfig)) -> Sea {
    let mut sea = Sea::with(settings, |vessel| {
        (vessel.environment.current.speed_mps, vessel.environment.current.to_rad) = (2.0, 0.0);
        change(vessel);
    })
    .ready();
    sea.run(20.0);
    sea
}

/// The hydrophone's state as last reported.
fn state_of(sea: &Sea) -> Option<EntityState> {
    let number = Entity::Hydrophone.number();
    let mut own = sea.said.iter().rev().filter(|(_, packet)| packet.header.src_ent == number);
    own.find_map(|(_, packet)| packet.get::<EntityState>().cloned())
}

/// Where the vessel is north of its start (m).
fn north_m(place: LatLon) -> f64 {
    frame().to_local(place).north_m
}

fn receiver(clock: devices::ClockState, clock_fault: &str) -> ReceiverReading {
    ReceiverReading {
        listening: true,
        frequency_khz: Some(69),
        protocols: Some(8),
        clock,
        clock_offset_s: Some(3.6),
        clock_fault: clock_fault.to_owned(),
    }
}

#[test]
fn a_detection_before_the_clock_is_set_never_has_a_time_of_day() {
    let mut sea = Sea::new().ready();
    sea.run(5.0);
    sea.forget();
    sea.read(Reading::Tag(tag(600, "R64K", 1)));
    sea.read(Reading::Tag(tag(612, "R64K", 2)));
    sea.read(Reading::Water(WaterReading {
        clock_s: 620,
        temperature_c: 8.5,
        counter: 3,
        ..WaterReading::default()
    }));
    assert!(sea.all::<TBRFishTag>().is_empty() && sea.all::<TBRSensor>().is_empty());
    let kept = reports(&sea);
    assert_eq!(kept.len(), 2);
    let first = &kept[0];
    assert_eq!(
        (first.clock.state, first.clock.utc(), first.clock.micros()),
        (ClockState::NotSet, None, 600_045_000)
    );
    assert_eq!((first.receiver, first.tag_id, first.data, first.snr_db), (1234, 1705, Some(8), Some(23)));
    assert_eq!(first.raw.as_deref(), Some("$001234,0000000600,045,R64K,1705,8,23,69,1"));
    let pose = first.pose.unwrap();
    assert!((pose.place.lat_deg() - 63.33).abs() < 0.001, "where it was when the line came: {pose:?}");
    let (_, water) = sea.all::<DevDataText>().remove(0);
    let water = water.value.to_string();
    assert_eq!(imc::tuples::get(&water, "clock"), Some("not set"));
    assert_eq!(imc::tuples::get(&water, "temperature_c"), Some("8.5"));
    let told = sea.all::<LogBookEntry>();
    assert_eq!(
        told.iter().filter(|(_, entry)| entry.text.to_str_lossy().contains("clock is not set")).count(),
        1
    );
    // Once it is set they are detections like all others.
    let now_s = sea.vehicle.now.utc.seconds() as u32;
    sea.read(Reading::Tag(tag(now_s, "R64K", 4)));
    assert_eq!(sea.all::<TBRFishTag>().len(), 1);
    assert_eq!(reports(&sea).pop().unwrap().clock.state, ClockState::Set);
}

#[test]
fn both_messages_of_a_detection_are_one_with_pose_effort_and_line() {
    let mut sea = Sea::new().ready();
    // The place of a detection is that of 3 s before its stamp.
    sea.run(10.0);
    let now_s = sea.vehicle.now.utc.seconds() as u32;
    let water = WaterReading {
        clock_s: now_s,
        temperature_c: 8.5,
        noise_average: 12,
        noise_peak: 20,
        counter: 1,
        ..WaterReading::default()
    };
    sea.read(Reading::Water(water));
    for (side, propeller_rpm) in [(Side::Port, -300.0), (Side::Starboard, 250.0)] {
        let motor = MotorReading { propeller_rpm, ..MotorReading::default() };
        sea.read(Reading::Motor(side, motor));
    }
    sea.forget();
    sea.read(Reading::Tag(TagReading { lines_lost: Some(2), ..tag(now_s, "R64K", 9) }));
    let (now, brief) = sea.all::<TBRFishTag>().remove(0);
    let brief = Detection::from_fish_tag(origin(now), &brief);
    let whole = reports(&sea).remove(0);
    assert!(brief.is_same(&whole));
    let one = fused(vec![brief, whole]).remove(0);
    assert_eq!(one.origin.reported, sea.vehicle.now.utc);
    let pose = one.pose.unwrap();
    // The receiver stamps the end of 3 s of transmission; the compass gives a position every few tenths of a second.
    assert!(pose.age_s.unwrap() < 1.0 && pose.sigma_m.unwrap() < 10.0, "{pose:?}");
    let noise = one.effort.noise.unwrap();
    assert_eq!((one.effort.lines_lost, noise.average, noise.peak), (Some(2), 12, 20));
    assert_eq!(one.effort.propeller_rpm, Some(300.0));
    // Whatever the numbers: its driver knows them, and what it wrote before.
    assert_eq!(one.raw, Some(tag(now_s, "R64K", 9).line()));
    let told = sea.all::<LogBookEntry>();
    assert_eq!(told.iter().filter(|(_, entry)| entry.text == "2 lines of the receiver lost").count(), 1);
}

#[test]
fn a_coding_without_a_number_keeps_its_name() {
    let mut sea = Sea::new().ready();
    sea.forget();
    let now_s = sea.vehicle.now.utc.seconds() as u32;
    sea.read(Reading::Tag(tag(now_s, "OPi;x=1", 1)));
    assert!(sea.all::<TBRFishTag>().is_empty(), "no number stands for it");
    let kept = reports(&sea);
    assert_eq!((kept[0].protocol.name(), kept[0].protocol.number()), (Some("OPi;x=1"), None));
    assert_eq!(kept[0].clock.utc().unwrap().micros(), i64::from(now_s) * 1_000_000 + 45_000);
    assert_eq!(kept[0].effort.lines_lost, None, "it is the first line");
}

#[test]
fn a_lost_clock_dates_nothing_and_the_vessel_says_what_to_do() {
    let mut sea = Sea::new().ready();
    sea.run(5.0);
    let hear = |sea: &mut Sea, clock, fault: &str| {
        sea.forget();
        sea.read(Reading::Receiver(receiver(clock, fault)));
        let (clock_s, _) = stamp_of(sea.vehicle.now.utc);
        sea.read(Reading::Tag(tag(clock_s, "R64K", 1)));
        let report = reports(sea).pop().unwrap();
        (report, sea.all::<TBRFishTag>().len(), state_of(sea))
    };
    let (report, brief, _) = hear(&mut sea, devices::ClockState::Disciplined, "");
    assert_eq!((report.clock.state, brief), (ClockState::Disciplined, 1));
    let (report, brief, state) = hear(&mut sea, devices::ClockState::Lost, "ack01 missing; check the line");
    assert_eq!((report.clock.state, report.clock.utc(), brief), (ClockState::Lost, None, 0));
    assert!(report.pose.is_some(), "the place of its arrival");
    let state = state.unwrap();
    assert_eq!(state.state, EntityStateState::Fault);
    let text = state.description.to_str_lossy().into_owned();
    assert!(text.starts_with("ack01 missing; check the line; until then"), "{text}");
    let logged = |sea: &Sea, words: &str| {
        sea.all::<LogBookEntry>()
            .iter()
            .filter(|(_, entry)| entry.text.to_str_lossy().contains(words))
            .count()
    };
    assert_eq!(logged(&sea, "ack01 missing"), 1);
    // Its water is not a TBRSensor either.
    let (clock_s, _) = stamp_of(sea.vehicle.now.utc);
    sea.read(Reading::Water(WaterReading { clock_s, temperature_c: 8.0, ..WaterReading::default() }));
    assert!(sea.all::<TBRSensor>().is_empty());
    let kept = sea.last::<DevDataText>().unwrap().value.to_string();
    assert_eq!(imc::tuples::get(&kept, "clock"), Some("lost"));
    let (report, brief, state) = hear(&mut sea, devices::ClockState::Set, "");
    assert_eq!((report.clock.state, brief, logged(&sea, "good again")), (ClockState::Set, 1, 1));
    assert_eq!(state.unwrap().state, EntityStateState::Normal);
}

#[test]
fn how_the_receiver_listens_is_told_while_it_hears_nothing() {
    let mut sea = Sea::new().ready();
    sea.run(40.0);
    assert!(listening(&sea).is_empty(), "the vessel has no receiver");
    sea.read(Reading::Receiver(receiver(devices::ClockState::Disciplined, "")));
    sea.forget();
    sea.run(60.0);
    let told = listening(&sea);
    // Once, and again each half minute.
    assert!((2..=3).contains(&told.len()), "{told:?}");
    let first = told[0];
    assert!(first.on && first.frequency_khz == Some(69) && first.protocols == Some(8));
    assert_eq!(
        (first.thrust, first.clock, first.clock_offset_s),
        (Some(0.0), Some(ClockState::Disciplined), Some(3.6))
    );
    // The vessel sails: its own thrust is reported within a second.
    sea.forget();
    let north = plan("north", vec![("a".to_owned(), Message::from(goto(300.0, 0.0, 1.5)))]);
    sea.ask(PlanControlOp::Start, "north", Some(north.into()));
    sea.run(20.0);
    let told = listening(&sea);
    assert!(
        told.iter().any(|one| one.thrust.unwrap() > 0.2 && one.propeller_rpm.unwrap() > 50.0),
        "{told:?}"
    );
    assert!(told.len() <= 20, "{}", told.len());
    // The cable is pulled.
    sea.forget();
    sea.read(Reading::Receiver(ReceiverReading {
        listening: false,
        ..receiver(devices::ClockState::Unknown, "")
    }));
    sea.run(1.5);
    assert!(listening(&sea).iter().any(|one| !one.on));
}

#[test]
fn a_detection_gets_the_place_of_its_own_moment_however_late_its_line_and_the_compass_are() {
    // Calculation in the compass and its line: 115200 and 19200 baud.
    for (late_s, rate_hz) in [(0.08, 5), (0.4, 1)] {
        let mut sea = adrift(settings(), |vessel| {
            vessel.gnss.rate_hz = rate_hz;
            vessel.gnss.latency_s = late_s;
        });
        let truth = sea.vehicle.hull.vessel.truth();
        let (then, mono) = (sea.vehicle.now.utc, sea.vehicle.now.mono);
        assert!(truth.speed_mps > 1.5, "{truth:?}");
        // The hull's steps are coarser than the clock.
        let truth_m = north_m(truth.place) + truth.speed_mps * (then - truth.utc) as f64 / 1e6;
        // The train that began then is stamped with its end, 3 s later; its line is in the port another 2 s, as in a stall.
        sea.run(3.0);
        let (clock_s, millis) = stamp_of(sea.vehicle.now.utc);
        sea.run(2.0);
        sea.forget();
        sea.read(Reading::Tag(TagReading { millis, ..tag(clock_s, "R64K", 1) }));
        let pose = reports(&sea).pop().unwrap().pose.unwrap();
        let error_m = north_m(pose.place) - truth_m;
        // The place of the arrival of a slow epoch is 0.8 m away.
        assert!(error_m.abs() < 0.1, "{late_s} s: {error_m} m");
        // A receiver without a clock: the line's own moment counts, not that of the loop, less the train.
        sea.forget();
        let at = MonoTime::from_micros(mono.micros() + 3_000_000);
        sea.tell(Input::Reading(at, Reading::Tag(tag(600, "R64K", 2))));
        let report = reports(&sea).pop().unwrap();
        let error_m = north_m(report.pose.unwrap().place) - truth_m;
        assert!(report.clock.utc().is_none() && error_m.abs() < 0.1, "{late_s} s: {error_m} m");
    }
}

#[test]
fn the_length_of_a_transmission_and_the_arm_are_those_of_the_settings() {
    let arm = LeverArm { forward_m: -1.0, starboard_m: 0.5, down_m: 0.7 };
    let place = |hydrophone: HydrophoneSettings| {
        let mut settings = settings();
        settings.hydrophone = hydrophone;
        let mut sea = adrift(settings, |_| {});
        sea.forget();
        let (clock_s, millis) = stamp_of(sea.vehicle.now.utc);
        sea.read(Reading::Tag(TagReading { millis, ..tag(clock_s, "R64K", 1) }));
        sea.read(Reading::Tag(tag(600, "R64K", 2)));
        sea.run(1.5);
        let found = reports(&sea);
        let places = [0, 1].map(|n: usize| frame().to_local(found[n].pose.unwrap().place));
        (places, sea.vehicle.hull.vessel.truth().heading_rad, listening(&sea).pop().unwrap())
    };
    let (usual, _, told) = place(HydrophoneSettings::default());
    assert_eq!(told.below_antenna_m, None);
    let short = HydrophoneSettings { transmission: Duration::from_secs(1), ..HydrophoneSettings::default() };
    let (later, _, _) = place(short);
    for (usual, later) in usual.iter().zip(&later) {
        // Two seconds of some two metres a second.
        assert!((3.0..5.0).contains(&(later.north_m - usual.north_m)), "{usual:?} {later:?}");
    }
    let (moved, heading_rad, told) = place(HydrophoneSettings { arm, ..HydrophoneSettings::default() });
    let (sin, cos) = heading_rad.sin_cos();
    let (north_m, east_m) = (-cos - 0.5 * sin, -sin + 0.5 * cos);
    for (usual, moved) in usual.iter().zip(&moved) {
        let error_m = (moved.north_m - usual.north_m - north_m).hypot(moved.east_m - usual.east_m - east_m);
        // The heading turns a little in 3 s.
        assert!(error_m < 0.1, "{error_m} m");
    }
    assert_eq!(told.below_antenna_m, Some(0.7));
}
