use super::*;
use imc::messages::{self, EntityList, EntityListOp, LogBookEntry, Message, SetThrusterActuation};
use imc::{Header, Packet};
use proptest::prelude::*;
use std::time::Duration;
use units::MonoTime;

const OTTER: Address = Address(0x2810);

fn at(seconds: f64) -> Now {
    let us = (seconds * 1e6) as u64;
    Now { mono: MonoTime::from_micros(us), utc: UtcTime::from_micros(us as i64) }
}

fn give(fleet: &mut Fleet, now: Now, entity: u8, timestamp: f64, message: impl Into<Message>) -> bool {
    let header = Header { timestamp, src: OTTER, src_ent: entity, ..Header::default() };
    let bytes = Packet::new(header, message).encode().unwrap();
    fleet.update(now, &PacketView::new(&bytes).unwrap(), Transport::Link)
}

fn volts(fleet: &Fleet, entity: u8) -> f32 {
    let key = SeriesKey { id: 251, entity, instance: None };
    let series = fleet.system(OTTER).unwrap().series(key).unwrap();
    let packet = Packet::decode(series.packet()).unwrap();
    packet.get::<messages::Voltage>().unwrap().value
}

#[test]
fn port_and_starboard_of_one_entity_are_two_series() {
    let mut fleet = Fleet::default();
    for id in [0, 1] {
        assert!(give(&mut fleet, at(0.0), 1, 1.0, SetThrusterActuation { id, value: 0.5 }));
    }
    let keys: Vec<_> = fleet.system(OTTER).unwrap().all_series().map(|(key, _)| key.instance).collect();
    assert_eq!(keys, [Some(0), Some(1)]);
}

#[test]
fn an_older_packet_does_not_replace_a_newer_one_but_a_clock_set_back_does() {
    let mut fleet = Fleet::default();
    assert!(give(&mut fleet, at(0.0), 0, 100.0, messages::Voltage { value: 1.0 }));
    assert!(!give(&mut fleet, at(0.1), 0, 99.5, messages::Voltage { value: 2.0 }));
    assert!((volts(&fleet, 0) - 1.0).abs() < 1e-6);
    assert!(
        give(&mut fleet, at(0.2), 0, 100.0, messages::Voltage { value: 3.0 }),
        "same time: the later counts"
    );
    assert!(!give(&mut fleet, at(5.0), 0, 50.0, messages::Voltage { value: 4.0 }));
    assert!(
        give(&mut fleet, at(11.0), 0, 50.5, messages::Voltage { value: 5.0 }),
        "it lives in the past now"
    );
    assert!(give(&mut fleet, at(11.1), 0, f64::NAN, messages::Voltage { value: 6.0 }));
    assert!(give(&mut fleet, at(11.2), 0, 51.0, messages::Voltage { value: 7.0 }));
    assert!((volts(&fleet, 0) - 7.0).abs() < 1e-6);
}

/// A log book entry of the past.
fn late(fleet: &mut Fleet, text: &str) {
    let header = Header { timestamp: 1.0, src: OTTER, ..Header::default() };
    let entry = LogBookEntry { text: text.into(), ..LogBookEntry::default() };
    let bytes = Packet::new(header, entry).encode().unwrap();
    fleet.late(at(2.0), &PacketView::new(&bytes).unwrap());
}

#[test]
fn what_comes_late_takes_no_place_of_the_present() {
    let mut fleet = Fleet::default();
    let entry = |text: &str| LogBookEntry { text: text.into(), ..LogBookEntry::default() };
    give(&mut fleet, at(1.0), 1, 1.0, entry("now"));
    let seen = fleet.changes(0, usize::MAX, |_, _| true).revision;
    for number in 0..2 * LATE_KEPT {
        late(&mut fleet, &number.to_string());
    }
    give(&mut fleet, at(3.0), 1, 3.0, entry("then"));

    let all = fleet.changes(0, usize::MAX, |_, _| true);
    assert_eq!(all.events.iter().filter(|event| !event.late).count(), 2, "none of the present is forgotten");
    assert_eq!(all.events.len(), LATE_KEPT + 2);
    assert!(all.events.is_sorted_by_key(|event| event.revision), "in the order in which they came");
    let since = fleet.changes(seen, usize::MAX, |_, _| true);
    assert_eq!((since.events.len(), since.events_missed), (LATE_KEPT + 1, LATE_KEPT as u64));
}

#[test]
fn periods_and_freshness_follow_the_sender() {
    let mut fleet = Fleet::default();
    for n in 0..100 {
        give(&mut fleet, at(f64::from(n)), 0, f64::from(n) * 4.0, messages::Voltage { value: 1.0 });
    }
    let (_, series) = fleet.system(OTTER).unwrap().latest(251).unwrap();
    assert!((series.period_s().unwrap() - 4.0).abs() < 1e-3);
    assert_eq!(series.fresh_for(), Duration::from_secs(12));
    assert_eq!(series.count(), 100);
    assert_eq!(series.age(at(101.0).mono), Duration::from_secs(2));
}

#[test]
fn liveness_goes_down_the_ladder() {
    let mut fleet = Fleet::default();
    give(&mut fleet, at(0.0), 0, 1.0, messages::Heartbeat);
    let system = fleet.system(OTTER).unwrap();
    for (silence, word) in
        [(0.0, "live"), (2.0, "live"), (2.1, "late"), (5.1, "stale"), (10.1, "lost"), (1e5, "lost")]
    {
        assert_eq!(system.liveness(at(silence).mono).name(), word);
    }
}

#[test]
fn names_come_from_announcements_and_entity_lists_and_go_with_a_restart() {
    let mut fleet = Fleet::default();
    let announce = |uid: u32| messages::Announce {
        sys_name: "otter-1".into(),
        services: format!("dune://0.0.0.0/uid/{uid};imc+udp://10.0.0.2:6002/").as_str().into(),
        ..messages::Announce::default()
    };
    give(&mut fleet, at(0.0), 0, 1.0, announce(1));
    give(&mut fleet, at(0.0), 0, 1.0, EntityList { op: EntityListOp::Report, list: "GPS=46;AHRS=47".into() });
    give(&mut fleet, at(0.0), 0, 1.0, EntityList { op: EntityListOp::Query, list: "".into() });
    assert_eq!(fleet.named("otter-1").unwrap().entity(46), Some("GPS"));
    give(&mut fleet, at(1.0), 0, 2.0, announce(1));
    assert_eq!(fleet.named("otter-1").unwrap().entity(47), Some("AHRS"));
    give(&mut fleet, at(2.0), 0, 3.0, announce(2));
    assert_eq!(fleet.named("otter-1").unwrap().entity(46), None);
    give(
        &mut fleet,
        at(2.0),
        0,
        3.0,
        messages::EntityInfo { id: 9, label: "Leak".into(), ..Default::default() },
    );
    assert_eq!(fleet.named("otter-1").unwrap().entity(9), Some("Leak"));
}

#[test]
fn systems_of_one_name_are_told_apart() {
    let mut fleet = Fleet::default();
    let announces = |fleet: &mut Fleet, src: u16| {
        let header = Header { timestamp: 1.0, src: Address(src), ..Header::default() };
        let announce = messages::Announce { sys_name: "otter-1".into(), ..messages::Announce::default() };
        let bytes = Packet::new(header, announce).encode().unwrap();
        fleet.update(at(0.0), &PacketView::new(&bytes).unwrap(), Transport::Udp);
    };
    announces(&mut fleet, 0x2810);
    assert_eq!(fleet.title(Address(0x2810)), "otter-1");
    announces(&mut fleet, 0x0999);
    assert_eq!(fleet.title(Address(0x2810)), "otter-1 (0x2810)");
    assert_eq!(fleet.title(Address(0x0999)), "otter-1 (0x0999)");
    assert_eq!(fleet.title(Address(0x0998)), Address(0x0998).to_string());
}

#[test]
fn each_event_is_given_once_and_the_missed_are_counted() {
    let mut fleet = Fleet::default();
    let entry = |n: u32| LogBookEntry { text: n.to_string().as_str().into(), ..LogBookEntry::default() };
    // Later ones first: an event counts even when it is older than the last of its kind.
    for n in 0..10 {
        give(&mut fleet, at(0.0), 0, f64::from(100 - n), entry(n));
    }
    let changes = fleet.changes(0, 100, |_, _| true);
    assert_eq!((changes.events.len(), changes.events_missed, changes.series.len()), (10, 0, 1));
    let revision = changes.revision;
    assert!(fleet.changes(revision, 100, |_, _| true).events.is_empty());
    for n in 0..EVENTS_KEPT as u32 + 5 {
        give(&mut fleet, at(1.0), 0, 200.0 + f64::from(n), entry(n));
    }
    let changes = fleet.changes(revision, 100, |_, _| true);
    assert_eq!((changes.events.len(), changes.events_missed), (EVENTS_KEPT, 5));
    let others = fleet.changes(revision, 100, |_, key| key.id == 251);
    assert_eq!((others.events.len(), others.series.len()), (0, 0));
}

#[test]
fn what_is_kept_is_bounded() {
    let mut fleet = Fleet::default();
    for address in 0..SYSTEMS_KEPT as u16 + 50 {
        let header = Header { timestamp: 1.0, src: Address(address), ..Header::default() };
        let bytes = Packet::new(header, messages::Heartbeat).encode().unwrap();
        fleet.update(at(f64::from(address)), &PacketView::new(&bytes).unwrap(), Transport::Udp);
    }
    assert_eq!(fleet.systems().count(), SYSTEMS_KEPT);
    assert_eq!(fleet.changed.len(), SYSTEMS_KEPT);
    assert!(fleet.system(Address(0)).is_none(), "the longest silent one went");
}

/// Packets of the greatest length, from any number of invented systems and entities.
#[test]
fn the_memory_of_all_systems_is_bounded_and_the_silent_ones_pay() {
    let mut fleet = Fleet::default();
    let text = "x".repeat(60_000);
    let mut clock = 0.0;
    for source in 0..200_u16 {
        for entity in 0..15 {
            clock += 1e-3;
            let header =
                Header { timestamp: clock, src: Address(source), src_ent: entity, ..Header::default() };
            let entry = messages::DevDataText { value: text.as_str().into() };
            let bytes = Packet::new(header, entry).encode().unwrap();
            fleet.update(at(clock), &PacketView::new(&bytes).unwrap(), Transport::Udp);
            // The operator's boat continues to send.
            give(&mut fleet, at(clock), 1, clock, messages::Voltage { value: 12.0 });
            assert!(fleet.bytes <= BYTES_KEPT);
        }
    }
    assert_eq!(fleet.bytes, fleet.systems().map(System::size).sum::<usize>());
    assert!(fleet.system(Address(0)).is_none() && fleet.system(Address(199)).is_some());
    assert!(fleet.system(OTTER).is_some(), "who speaks stays");
}

proptest! {
    /// A reader that comes back at any times, with any limit, ends with the same values as the fleet.
    #[test]
    fn readers_catch_up(steps in prop::collection::vec((0_u8..5, 0_u16..50, any::<bool>()), 1..80), most in 1_usize..6) {
        let mut fleet = Fleet::default();
        let mut seen: BTreeMap<SeriesKey, Vec<u8>> = BTreeMap::new();
        let mut revision = 0;
        let mut read = |fleet: &Fleet, seen: &mut BTreeMap<SeriesKey, Vec<u8>>| {
            let changes = fleet.changes(revision, most, |_, _| true);
            revision = changes.revision;
            seen.extend(changes.series.iter().map(|(_, key, series)| (*key, series.packet().to_vec())));
        };
        for (n, (entity, value, look)) in steps.into_iter().enumerate() {
            let value = f32::from(value);
            give(&mut fleet, at(n as f64), entity, n as f64, messages::Voltage { value });
            if look {
                read(&fleet, &mut seen);
            }
        }
        for _ in 0..20 {
            read(&fleet, &mut seen);
        }
        let all = fleet.system(OTTER).unwrap().all_series();
        let now: BTreeMap<SeriesKey, Vec<u8>> =
            all.map(|(key, series)| (key, series.packet().to_vec())).collect();
        prop_assert_eq!(seen, now);
    }
}
