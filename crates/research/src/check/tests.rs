use super::*;
use crate::fields::{KINDS, blank};
use api::{RegisterPerson, RegisterProject};

fn tag(name: &str, id: i64, from_us: Option<i64>, to_us: Option<i64>) -> RegisterRecord {
    RegisterRecord::Tag(RegisterTag {
        name: name.to_owned(),
        protocol: "R64K".to_owned(),
        tag_id: Some(id),
        from_us,
        to_us,
        ..RegisterTag::default()
    })
}

fn told(record: &RegisterRecord) -> Vec<String> {
    check(&mut record.clone()).into_iter().map(|(column, text)| format!("{column}: {text}")).collect()
}

#[test]
fn a_blank_entry_lacks_what_it_needs() {
    let lacks = |kind| {
        let all = told(&blank(kind));
        all.iter().map(|text| text.split(':').next().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(
        KINDS.map(lacks),
        [
            vec!["name".to_owned()],
            vec!["name".to_owned()],
            vec!["name".to_owned()],
            vec!["protocol".to_owned(), "tag_id".to_owned()],
            vec!["serial".to_owned()],
            vec!["receiver".to_owned(), "vessel".to_owned(), "from_time".to_owned()],
        ]
    );
}

#[test]
fn what_has_no_name_is_called_by_what_it_is() {
    let mut one = tag("  ", 7, None, None);
    assert!(check(&mut one).is_empty() && name_of(&one) == "R64K-7");
    let mut receiver = RegisterRecord::Receiver(RegisterReceiver {
        serial: Some(1_024),
        model: "TBR700".to_owned(),
        ..RegisterReceiver::default()
    });
    assert!(check(&mut receiver).is_empty() && name_of(&receiver) == "TBR700-1024");
    let mut deployment = RegisterRecord::Deployment(RegisterDeployment {
        receiver: "TBR700-1024".to_owned(),
        vessel: Some(7),
        from_us: Some(1_795_248_000_000_000),
        ..RegisterDeployment::default()
    });
    assert!(check(&mut deployment).is_empty() && name_of(&deployment) == "TBR700-1024 2026-11-21T08:00Z");
}

#[test]
fn what_cannot_be_is_told_at_its_field() {
    let animal = |change: fn(&mut RegisterAnimal)| {
        let mut one = RegisterAnimal { name: "a".to_owned(), ..RegisterAnimal::default() };
        change(&mut one);
        told(&RegisterRecord::Animal(one)).join("; ")
    };
    assert_eq!(animal(|_| ()), "");
    assert!(animal(|one| one.sex = "female".to_owned()).starts_with("sex: `female` is not one of F, M, U"));
    assert!(animal(|one| one.length_mm = Some(0.0)).starts_with("length_mm: 0 is not within 1 to 40000"));
    assert!(animal(|one| one.length_mm = Some(f64::NAN)).starts_with("length_mm: NaN"));
    assert!(animal(|one| one.aphia_id = Some(0)).starts_with("aphia_id: 0"));
    assert!(animal(|one| one.capture_lat_deg = Some(63.0)).starts_with("capture_lat_deg: a place"));
    assert!(animal(|one| one.name = "a\nb".to_owned()).starts_with("name: has several lines"));
    assert!(animal(|one| one.name = "x".repeat(81)).starts_with("name: has 81 characters"));
    assert!(animal(|one| one.notes = "\u{7}".to_owned()).starts_with("notes: has control"));
    assert!(
        animal(|one| (one.capture_us, one.release_us) = (Some(2), Some(1)))
            .starts_with("release_time: is before")
    );
    assert!(animal(|one| one.release_us = Some(-1)).starts_with("release_time: -1 is not a time"));
    let person = RegisterPerson {
        name: "Kari".to_owned(),
        orcid: "0000-0002-1825-0098".to_owned(),
        ..RegisterPerson::default()
    };
    assert!(
        told(&RegisterRecord::Person(person))[0].starts_with("orcid: `0000-0002-1825-0098` is not an ORCID")
    );
    assert!(told(&tag("t", 7, Some(5), Some(5)))[0].starts_with("to_time: is not after"));
    let interval = RegisterTag {
        protocol: "S256".to_owned(),
        tag_id: Some(1),
        interval_min_s: Some(90.0),
        interval_max_s: Some(30.0),
        sensor_intercept: Some(1.0),
        ..RegisterTag::default()
    };
    let told = told(&RegisterRecord::Tag(interval)).join("; ");
    assert!(told.contains("interval_max_s: is less") && told.contains("sensor_slope: empty"), "{told}");
}

#[test]
fn a_code_is_one_tag_at_a_time() {
    let wrong = |all: &[RegisterRecord]| {
        check_all(all).into_iter().map(|one| (one.entry, one.column)).collect::<Vec<_>>()
    };
    assert_eq!(wrong(&[tag("a", 7, None, Some(5)), tag("b", 7, Some(5), None), tag("c", 8, None, None)]), []);
    assert_eq!(wrong(&[tag("a", 7, None, Some(6)), tag("b", 7, Some(5), None)]), [(1, "from_time")]);
    assert_eq!(wrong(&[tag("a", 7, None, None), tag("A ", 9, None, None)]), [(1, "name")]);
    let khz = |name: &str, khz| match tag(name, 7, None, None) {
        RegisterRecord::Tag(tag) => RegisterRecord::Tag(RegisterTag { frequency_khz: khz, ..tag }),
        other => other,
    };
    assert_eq!(wrong(&[khz("a", Some(69)), khz("b", Some(71))]), []);
    assert_eq!(wrong(&[khz("a", Some(69)), khz("b", None)]), [(1, "from_time")]);
}

#[test]
fn a_serial_number_is_a_makers_own() {
    let receiver = |name: &str, manufacturer: &str, model: &str| {
        RegisterRecord::Receiver(RegisterReceiver {
            name: name.to_owned(),
            serial: Some(700),
            manufacturer: manufacturer.to_owned(),
            model: model.to_owned(),
            ..RegisterReceiver::default()
        })
    };
    let wrong = |all: &[RegisterRecord]| check_all(all).into_iter().map(|one| one.column).collect::<Vec<_>>();
    assert_eq!(wrong(&[receiver("a", "VEMCO", ""), receiver("b", "", "TBR 700")]), Vec::<&str>::new());
    assert_eq!(wrong(&[receiver("a", "VEMCO", ""), receiver("b", "Innovasea", "VR2Tx")]), ["serial"]);
    assert_eq!(wrong(&[receiver("a", "VEMCO", ""), receiver("b", "", "")]), ["serial"], "it may be the same");
}

#[test]
fn a_reference_is_to_something_that_is_there() {
    let project = RegisterRecord::Project(RegisterProject {
        name: "FJORD".to_owned(),
        contact: "Kari Nordman".to_owned(),
        ..RegisterProject::default()
    });
    let person = RegisterRecord::Person(RegisterPerson {
        name: "Kari Nordmann".to_owned(),
        ..RegisterPerson::default()
    });
    let faults = check_all(&[project.clone(), person]);
    assert_eq!(faults.len(), 1);
    assert!(
        faults[0]
            .text
            .to_string()
            .contains("no person is called `Kari Nordman`; did you mean `Kari Nordmann`?"),
        "{faults:?}"
    );
    assert!(check_all(&[project])[0].text.to_string().contains("register the person first"));
}

#[test]
fn a_receiver_is_on_one_vessel_at_a_time_and_has_a_serial_number_of_its_own() {
    let receiver = |name: &str, serial| {
        RegisterRecord::Receiver(RegisterReceiver {
            name: name.to_owned(),
            serial: Some(serial),
            ..Default::default()
        })
    };
    let deployed = |name: &str, vessel, from_us, to_us| {
        RegisterRecord::Deployment(RegisterDeployment {
            name: name.to_owned(),
            receiver: "r".to_owned(),
            vessel: Some(vessel),
            from_us: Some(from_us),
            to_us,
            ..Default::default()
        })
    };
    assert_eq!(check_all(&[receiver("r", 1), deployed("a", 5, 0, Some(9)), deployed("b", 6, 9, None)]), []);
    let wrong = check_all(&[
        receiver("r", 1),
        deployed("a", 5, 0, None),
        deployed("b", 6, 9, None),
        receiver("s", 1),
    ]);
    assert_eq!(
        wrong.iter().map(|one| (one.entry, one.column)).collect::<Vec<_>>(),
        [(2, "from_time"), (3, "serial")]
    );
}

#[test]
fn similar_names_are_looked_for_as_long_as_that_helps() {
    let mut records: Vec<RegisterRecord> = (0..30).map(|id| tag(&format!("T{id}"), id, None, None)).collect();
    for record in &mut records {
        let RegisterRecord::Tag(tag) = record else { panic!("a tag") };
        tag.animal = "Samlon".to_owned();
    }
    let salmon = RegisterAnimal { name: "Salmon".to_owned(), ..RegisterAnimal::default() };
    records.push(RegisterRecord::Animal(salmon));
    let faults = check_all(&records);
    let meant =
        faults.iter().filter(|fault| fault.text.to_string().contains("did you mean `Salmon`")).count();
    assert_eq!((faults.len(), meant), (30, SUGGESTIONS));
}
