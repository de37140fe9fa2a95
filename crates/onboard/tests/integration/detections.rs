//! What a receiver hears before its clock is set, and in codings that nobody has a number for, is kept and marked.

use crate::common::*;
use devices::{Reading, TagReading, WaterReading};
use imc::messages::*;
use onboard::Input;
use std::collections::BTreeMap;

fn tag(clock_s: u32, protocol: &str, counter: u16) -> TagReading {
    TagReading {
        serial: 1234,
        clock_s,
        millis: 45,
        protocol: protocol.to_owned(),
        tag_id: 1705,
        data: Some(8),
        snr_db: 23,
        frequency_khz: 69,
        counter,
    }
}

/// What came as text, as its tuples.
fn texts(sea: &Sea) -> Vec<BTreeMap<String, String>> {
    let tuples = |(_, text): (_, DevDataText)| {
        let text = text.value.to_string();
        imc::tuples::parse(&text).map(|(name, value)| (name.to_owned(), value.to_owned())).collect()
    };
    sea.all::<DevDataText>().into_iter().map(tuples).collect()
}

#[test]
fn a_detection_before_the_clock_is_set_is_kept_and_never_has_an_absolute_time() {
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
    let kept = texts(&sea);
    assert_eq!(kept.len(), 3);
    let first = &kept[0];
    for (name, value) in [
        ("clock", "not set"),
        ("since_power_up_s", "600.045"),
        ("serial", "1234"),
        ("protocol", "R64K"),
        ("tag", "1705"),
        ("data", "8"),
        ("snr_db", "23"),
    ] {
        assert_eq!(first.get(name).map(String::as_str), Some(value), "{first:?}");
    }
    let lat_deg: f64 = first["lat_deg"].parse().unwrap();
    assert!((lat_deg - 63.33).abs() < 0.001 && first.contains_key("arrived_by_vessel_clock"));
    assert_eq!(kept[2]["temperature_c"], "8.5");
    let told = sea.all::<LogBookEntry>();
    assert_eq!(
        told.iter().filter(|(_, entry)| entry.text.to_str_lossy().contains("clock is not set")).count(),
        1
    );
    // Once it is set they are detections like all others.
    let now_s = sea.vehicle.now.utc.seconds() as u32;
    sea.tell(Input::Reading(Reading::Tag(tag(now_s, "R64K", 4))));
    assert_eq!(sea.all::<TBRFishTag>().len(), 1);
    assert_eq!(texts(&sea).len(), 3);
}

#[test]
fn an_unknown_coding_keeps_its_name() {
    let mut sea = Sea::new().ready();
    sea.forget();
    let now_s = sea.vehicle.now.utc.seconds() as u32;
    sea.tell(Input::Reading(Reading::Tag(tag(now_s, "OPi;x=1", 1))));
    assert!(sea.all::<TBRFishTag>().is_empty(), "no number stands for it");
    let kept = texts(&sea);
    assert_eq!((kept[0]["protocol"].as_str(), kept[0].contains_key("clock")), ("OPi_x_1", false));
    assert_eq!(kept[0]["unix_s"], format!("{now_s}.045"));
}
