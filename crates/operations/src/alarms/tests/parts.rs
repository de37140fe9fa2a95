//! Parts are recognised by their messages, whatever their label.

use super::*;

/// A vessel whose people call its parts in their own language.
fn bench() -> Bench {
    let mut bench = Bench::new();
    let list = "Kompass=1;Babord=2;Styrbord=3;Grunnvakt=4;Loggen=5;Bestikk=6;Lytter=7;Batteri A=8;Ladning=9;Klokka=10;\
                Landkontakt=11;Kurs=12";
    bench.say(0, m::EntityList { op: m::EntityListOp::Report, list: list.into() });
    bench
}

/// Each message that shows what a part is, once.
fn all_speak(bench: &mut Bench) {
    let values = |data: &str| m::Event { topic: "EntityStateValues".into(), data: data.into() };
    bench.say(1, m::GpsFix::default());
    bench.say(2, m::Rpm::default());
    bench.say(3, m::Rpm::default());
    bench.say(4, values("on=1;blocks=0"));
    bench.say(6, m::EstimatedState::default());
    bench.say(7, m::Event { topic: detections::LISTENING_TOPIC.into(), data: "listening=on".into() });
    bench.say(8, m::FuelLevel { value: 80.0, ..m::FuelLevel::default() });
    bench.say(8, m::Voltage::default());
    bench.say(10, values("quality=good"));
    bench.say(11, values("lost=0"));
    bench.say(12, m::PathControlState::default());
}

/// The alarms of one part that is in error.
fn told_of(entity: u8) -> Vec<(Kind, String, Priority)> {
    let mut bench = bench();
    all_speak(&mut bench);
    for _ in 0..12 {
        bench.part(entity, EntityStateState::Error);
        bench.say(6, m::EstimatedState::default());
        bench.pass(1);
    }
    let told = bench.alarms.standing().filter(|alarm| alarm.is_told());
    told.map(|alarm| (alarm.key.kind, alarm.key.part.clone(), alarm.priority)).collect()
}

#[test]
fn parts_are_sorted_by_what_they_send_and_not_by_the_language_of_their_labels() {
    for (entity, kind, part, priority) in [
        (1, Kind::Part, "Kompass", Priority::Warning),
        (2, Kind::Motor, "", Priority::Warning),
        (4, Kind::Grounding, "", Priority::Emergency),
        (5, Kind::Part, "Loggen", Priority::Warning),
        (6, Kind::Position, "", Priority::Warning),
        (7, Kind::Hydrophone, "", Priority::Warning),
        (8, Kind::Battery, "", Priority::Alarm),
        (10, Kind::Clock, "", Priority::Warning),
        (11, Kind::NoConsole, "", Priority::Warning),
        (12, Kind::Part, "Kurs", Priority::Warning),
    ] {
        assert_eq!(told_of(entity), [(kind, part.to_owned(), priority)], "entity {entity}");
    }
}

#[test]
fn what_needs_the_position_is_within_its_loss_whatever_it_is_called() {
    let mut bench = bench();
    all_speak(&mut bench);
    for _ in 0..5 {
        for entity in [1, 5, 6, 12] {
            bench.part(entity, EntityStateState::Error);
        }
        bench.pass(1);
    }
    let kinds: Vec<Kind> = bench.told().into_iter().map(|(kind, ..)| kind).collect();
    assert_eq!(kinds, [Kind::Position, Kind::Part], "the lost position, and the log beside it");
}

#[test]
fn the_charge_is_that_of_the_monitor_and_not_of_one_battery_whatever_they_are_called() {
    let mut bench = bench();
    all_speak(&mut bench);
    bench.say(9, m::FuelLevel { value: 25.0, ..m::FuelLevel::default() });
    bench.pass(6);
    let only = bench.only();
    assert_eq!((only.key.kind, only.priority), (Kind::Battery, Priority::Warning));
    assert!(only.text.contains("25"), "{}", only.text);
}

#[test]
fn after_a_restart_labels_come_before_what_a_number_sent_earlier() {
    let mut bench = Bench::new();
    let announce = |uid: &str| m::Announce {
        sys_type: m::SystemType::Usv,
        services: format!("imc+info://0.0.0.0/uid/{uid}/").into(),
        ..m::Announce::default()
    };
    bench.say(0, announce("1"));
    bench.say(1, m::Rpm::default());
    bench.pass(1);
    // Another part has the number of the motor, and says so by its label.
    bench.say(0, announce("2"));
    let list = m::EntityList { op: m::EntityListOp::Report, list: "Hydrophone=1".into() };
    bench.say(0, list);
    for _ in 0..12 {
        bench.part(1, EntityStateState::Error);
        bench.pass(1);
    }
    assert_eq!(bench.only().key.kind, Kind::Hydrophone);
    // A part whose label says nothing keeps its kind.
    let list = m::EntityList { op: m::EntityListOp::Report, list: "Babord=1".into() };
    bench.say(0, list);
    for _ in 0..12 {
        bench.part(1, EntityStateState::Error);
        bench.pass(1);
    }
    assert!(bench.told().iter().any(|(kind, ..)| *kind == Kind::Motor), "{:?}", bench.told());
}
