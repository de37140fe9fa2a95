//! Alarms that returned, and effects of people's own orders.

use super::*;

/// A vessel sails, is lost and is heard again, and no one acknowledges the alarm.
fn returned() -> (Bench, AlarmId) {
    let mut bench = Bench::new();
    bench.mode(VehicleStateOpMode::Maneuver, 450);
    bench.silence(12);
    let alarm = bench.only();
    assert_eq!((alarm.key.kind, alarm.priority), (Kind::NotHeard, Priority::Warning));
    bench.pass(5);
    assert_eq!(bench.only().state, State::Returned);
    (bench, alarm.id)
}

#[test]
fn a_returned_alarm_does_not_rise_again_when_its_vessel_is_switched_off_at_rest() {
    let (mut bench, id) = returned();
    bench.mode(VehicleStateOpMode::Service, 0);
    bench.pass(5);
    let sounded = bench.only().sounded;
    bench.silence(300);
    let alarm = bench.only();
    assert_eq!((alarm.state, alarm.id, alarm.sounded), (State::Returned, id, sounded), "silent at the quay");
    // After a past alarm is acknowledged, the present one is reported.
    bench.alarms.acknowledge(bench.now(), id, "nils").unwrap();
    bench.silence(2);
    let alarm = bench.only();
    assert_eq!((alarm.priority, alarm.state), (Priority::Caution, State::Acknowledged));
    assert!(alarm.id > id && !alarm.wants_acknowledgement());
}

#[test]
fn what_comes_again_is_as_urgent_as_it_is_now() {
    let (mut bench, id) = returned();
    bench.mode(VehicleStateOpMode::Maneuver, m::Teleoperation::ID);
    bench.silence(12);
    assert_eq!((bench.only().id, bench.only().priority), (id, Priority::Alarm));
    bench.pass(5);
    bench.mode(VehicleStateOpMode::Maneuver, 450);
    bench.silence(12);
    let alarm = bench.only();
    assert_eq!((alarm.id, alarm.priority, alarm.count), (id, Priority::Warning, 3));
    bench.silence(60);
    assert_eq!(bench.only().priority, Priority::Alarm, "and still becomes an alarm by waiting");
}

#[test]
fn what_the_log_book_says_of_an_abort_that_was_ordered_is_no_trouble() {
    let entry = |text: &str| m::LogBookEntry {
        r#type: m::LogBookEntryType::Error,
        text: text.into(),
        ..m::LogBookEntry::default()
    };
    let mut bench = Bench::new();
    // An abort without an order raises an alarm.
    bench.say(5, entry("got abort request from entity Leak @ 0x09"));
    bench.pass(2);
    assert_eq!(bench.only().key.kind, Kind::LogBook);
    bench.pass(90);
    assert_eq!(bench.told(), []);
    let header = Header { timestamp: 100.0, src: Address(0x4F00), dst: BOAT, ..Header::default() };
    let abort = Packet::new(header, m::Abort).encode().unwrap();
    let now = bench.now();
    bench.fleet.update(now, &PacketView::new(&abort).unwrap(), Transport::Shore);
    bench.pass(1);
    bench.say(5, entry("got abort request from system lutra - 0x4F00 @ 0xFF"));
    bench.pass(1);
    bench.say(0, entry("plan failed: vehicle was aborted"));
    bench.pass(3);
    assert_eq!(bench.told(), []);
    // An unrelated entry is reported, and so is an abort long after the order.
    bench.say(5, entry("the leak sensor is wet"));
    bench.pass(2);
    assert_eq!(bench.only().text, "Logger: the leak sensor is wet");
    bench.pass(90);
    bench.say(5, entry("got abort request from entity Leak @ 0x09"));
    bench.pass(2);
    assert_eq!(bench.only().key.kind, Kind::LogBook);
}
