//! What a receiver hears gets the vessel's pose, and is told whole: also before its clock is set, and in codings that IMC
//! has no number for.

use crate::common::*;
use ::detections::{ClockState, Detection, Origin, fused};
use devices::{MotorReading, Reading, Side, TagReading, WaterReading};
use imc::messages::*;
use onboard::Input;

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
    };
    tag.raw = Some(tag.line());
    tag
}

/// By the moment at which it was said.
fn origin(now: units::Now) -> Origin {
    Origin { system: imc::Address(7), entity: 9, reported: now.utc, received: None }
}

/// What the vessel reported whole.
fn reports(sea: &Sea) -> Vec<Detection> {
    let told = |(now, event): (units::Now, Event)| Detection::from_report(origin(now), &event).unwrap();
    sea.all().into_iter().map(told).collect()
}

#[test]
fn a_detection_before_the_clock_is_set_never_has_a_time_of_day() {
    let mut sea = Sea::new().ready();
    sea.forget();
    sea.tell(Input::Reading(Reading::Tag(tag(600, "R64K", 1))));
    sea.tell(Input::Reading(Reading::Tag(tag(612, "R64K", 2))));
    sea.tell(Input::Reading(Reading::Water(WaterReading {
        clock_s: 620,
        temperature_c: 8.5,
        counter: 3,
        ..WaterReading::default()
    })));
    assert!(sea.all::<TBRFishTag>().is_empty() && sea.all::<TBRSensor>().is_empty());
    let kept = reports(&sea);
    assert_eq!(kept.len(), 2);
    let first = &kept[0];
    assert_eq!(
        (first.clock.state, first.clock.utc(), first.clock.micros()),
        (ClockState::NotSet, None, 600_045_000)
    );
    assert_eq!((first.receiver, first.tag_id, first.data, first.snr_db), (1234, 1705, Some(8), 23));
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
    sea.tell(Input::Reading(Reading::Tag(tag(now_s, "R64K", 4))));
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
    sea.tell(Input::Reading(Reading::Water(water)));
    for (side, propeller_rpm) in [(Side::Port, -300.0), (Side::Starboard, 250.0)] {
        let motor = MotorReading { propeller_rpm, ..MotorReading::default() };
        sea.tell(Input::Reading(Reading::Motor(side, motor)));
    }
    sea.forget();
    sea.tell(Input::Reading(Reading::Tag(tag(now_s, "R64K", 4))));
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
    assert_eq!(one.raw, Some(tag(now_s, "R64K", 4).line()));
}

#[test]
fn a_coding_without_a_number_keeps_its_name() {
    let mut sea = Sea::new().ready();
    sea.forget();
    let now_s = sea.vehicle.now.utc.seconds() as u32;
    sea.tell(Input::Reading(Reading::Tag(tag(now_s, "OPi;x=1", 1))));
    assert!(sea.all::<TBRFishTag>().is_empty(), "no number stands for it");
    let kept = reports(&sea);
    assert_eq!((kept[0].protocol.name(), kept[0].protocol.number()), (Some("OPi;x=1"), None));
    assert_eq!(kept[0].clock.utc().unwrap().micros(), i64::from(now_s) * 1_000_000 + 45_000);
    assert_eq!(kept[0].effort.lines_lost, None, "it is the first line");
}
