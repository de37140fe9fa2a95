use super::*;
use hub::Transport;
use imc::messages::{self as m, EntityState, EntityStateState, Message, Payload as _, VehicleStateOpMode};
use imc::{Header, Packet, PacketView};
use proptest::prelude::*;
use units::MonoTime;

mod certificate;
mod parts;
mod returned;

const BOAT: Address = Address(0x2810);

/// A fleet and its alarms, by a clock of their own.
struct Bench {
    fleet: Fleet,
    alarms: Alarms,
    shore: ShoreState,
    s: u64,
}

impl Bench {
    fn new() -> Self {
        let mut bench =
            Self { fleet: Fleet::default(), alarms: Alarms::default(), shore: ShoreState::default(), s: 0 };
        bench.say(0, m::Announce { sys_type: m::SystemType::Usv, ..m::Announce::default() });
        let list = m::EntityList {
            op: m::EntityListOp::Report,
            list: "GPS=1;Motor Port=2;Motor Starboard=3;Grounding Supervisor=4;Logger=5;Navigation=6".into(),
        };
        bench.say(0, list);
        bench
    }

    fn now(&self) -> Now {
        let us = self.s * 1_000_000;
        Now { mono: MonoTime::from_micros(us), utc: UtcTime::from_micros(us as i64) }
    }

    fn say(&mut self, entity: u8, message: impl Into<Message>) {
        let now = self.now();
        let header =
            Header { timestamp: 1.0 + self.s as f64, src: BOAT, src_ent: entity, ..Header::default() };
        let bytes = Packet::new(header, message).encode().unwrap();
        self.fleet.update(now, &PacketView::new(&bytes).unwrap(), Transport::Link);
    }

    fn mode(&mut self, op_mode: VehicleStateOpMode, maneuver_type: u16) {
        self.say(0, m::VehicleState { op_mode, maneuver_type, ..m::VehicleState::default() });
    }

    fn part(&mut self, entity: u8, state: EntityStateState) {
        self.say(entity, EntityState { state, description: "words".into(), ..EntityState::default() });
    }

    /// Seconds pass in which the vessel is silent.
    fn silence(&mut self, seconds: u64) {
        for _ in 0..seconds {
            self.s += 1;
            let now = self.now();
            self.alarms.watch(now, &self.fleet, &self.shore);
        }
    }

    /// Seconds pass in which the vessel says that it lives.
    fn pass(&mut self, seconds: u64) {
        for _ in 0..seconds {
            self.s += 1;
            self.say(0, m::Heartbeat);
            let now = self.now();
            self.alarms.watch(now, &self.fleet, &self.shore);
        }
    }

    /// The reported alarms: kind, state and priority.
    fn told(&self) -> Vec<(Kind, State, Priority)> {
        let told = self.alarms.standing().filter(|alarm| alarm.is_told());
        told.map(|alarm| (alarm.key.kind, alarm.state, alarm.priority)).collect()
    }

    fn only(&self) -> Alarm {
        let told: Vec<&Alarm> = self.alarms.standing().filter(|alarm| alarm.is_told()).collect();
        assert_eq!(told.len(), 1, "{told:?}");
        told[0].clone()
    }
}

#[test]
fn silence_is_one_alarm_whatever_else_stops_with_it() {
    let mut bench = Bench::new();
    bench.mode(VehicleStateOpMode::Maneuver, 450);
    bench.say(0, m::EstimatedState::default());
    bench.part(2, EntityStateState::Error);
    bench.pass(5);
    assert_eq!(bench.told(), [(Kind::Motor, State::Unacknowledged, Priority::Warning)]);
    bench.silence(10);
    bench.silence(1);
    assert_eq!(bench.told(), [(Kind::NotHeard, State::Unacknowledged, Priority::Warning)]);
    let id = bench.only().id;
    bench.alarms.acknowledge(bench.now(), id, "nils").unwrap();
    bench.silence(300);
    assert_eq!(bench.told(), [(Kind::NotHeard, State::Acknowledged, Priority::Warning)]);
    assert_eq!(bench.only().acknowledged.unwrap().by, "nils");
    // Heard again: the silence is over, and the motor is reported again.
    bench.part(2, EntityStateState::Error);
    bench.say(0, m::EstimatedState::default());
    bench.pass(4);
    assert_eq!(bench.told().first().map(|(kind, ..)| *kind), Some(Kind::Motor));
    assert!(bench.told().iter().all(|(kind, ..)| *kind != Kind::NotHeard));
}

#[test]
fn how_urgent_silence_is_follows_from_what_the_vessel_did() {
    for (mode, maneuver, priority) in [
        (VehicleStateOpMode::Service, 0, Priority::Caution),
        (VehicleStateOpMode::Maneuver, 450, Priority::Warning),
        (VehicleStateOpMode::Maneuver, m::Teleoperation::ID, Priority::Alarm),
    ] {
        let mut bench = Bench::new();
        bench.mode(mode, maneuver);
        bench.silence(12);
        assert_eq!(bench.only().priority, priority);
        assert_eq!(bench.only().wants_acknowledgement(), priority > Priority::Caution);
    }
}

#[test]
fn a_warning_nobody_acknowledges_becomes_an_alarm_and_sounds_again() {
    let mut bench = Bench::new();
    bench.part(2, EntityStateState::Error);
    for _ in 0..4 {
        bench.part(2, EntityStateState::Error);
        bench.pass(1);
    }
    assert_eq!((bench.only().priority, bench.only().sounded), (Priority::Warning, 1));
    let mut seen = Vec::new();
    for _ in 0..130 {
        bench.part(2, EntityStateState::Error);
        bench.pass(1);
        let alarm = bench.only();
        seen.push((alarm.priority, alarm.escalated, alarm.sounded));
    }
    assert_eq!(seen.last(), Some(&(Priority::Alarm, true, 4)), "at 60 s, 90 s and 120 s");
    let id = bench.only().id;
    bench.alarms.acknowledge(bench.now(), id, "nils").unwrap();
    for _ in 0..100 {
        bench.part(2, EntityStateState::Error);
        bench.pass(1);
    }
    assert_eq!((bench.only().sounded, bench.only().priority), (4, Priority::Warning), "known: silent again");
    assert_eq!(bench.alarms.acknowledge(bench.now(), id, "nils"), Err(AlarmRefused::Known));
}

#[test]
fn what_returned_unseen_stays_until_somebody_knows_and_comes_again_as_the_same() {
    let mut bench = Bench::new();
    bench.part(2, EntityStateState::Error);
    bench.pass(4);
    let id = bench.only().id;
    bench.part(2, EntityStateState::Normal);
    let ended = UtcTime::from_micros(bench.now().utc.micros() + 1_000_000);
    bench.pass(7);
    assert_eq!((bench.only().state, bench.only().id), (State::Returned, id));
    assert_eq!(bench.only().over, Some(ended), "when it ended, not when that was believed");
    bench.part(2, EntityStateState::Error);
    bench.pass(4);
    assert_eq!(bench.only().over, None);
    assert_eq!((bench.only().state, bench.only().id, bench.only().count), (State::Unacknowledged, id, 2));
    bench.part(2, EntityStateState::Normal);
    bench.pass(7);
    bench.alarms.acknowledge(bench.now(), id, "nils").unwrap();
    assert!(bench.told().is_empty());
    assert_eq!(bench.alarms.acknowledge(bench.now(), id, "nils"), Err(AlarmRefused::Gone));
    // After it was normal it is another.
    bench.pass(60);
    bench.part(2, EntityStateState::Error);
    bench.pass(4);
    assert!(bench.only().id > id);
    let what: Vec<&str> = bench.alarms.notes().map(|note| note.what).collect();
    assert_eq!(what, ["raised", "returned", "again", "returned", "acknowledged", "raised"]);
}

#[test]
fn what_flaps_is_held_and_short_trouble_is_none() {
    let mut bench = Bench::new();
    for _ in 0..20 {
        bench.part(2, EntityStateState::Error);
        bench.pass(1);
        bench.part(2, EntityStateState::Normal);
        bench.pass(1);
    }
    assert!(bench.told().is_empty(), "never longer than its delay");
    let mut states = Vec::new();
    for _ in 0..8 {
        bench.part(2, EntityStateState::Error);
        bench.pass(4);
        bench.part(2, EntityStateState::Normal);
        bench.pass(7);
        states.push(bench.only().state);
    }
    assert_eq!(states[..2], [State::Returned; 2]);
    assert!(states[2..].iter().all(|state| *state == State::Unacknowledged), "{states:?}");
    assert!(bench.only().chatters);
    assert_eq!(bench.only().count, 3, "held: it does not come again");
    bench.pass(61);
    assert_eq!((bench.only().state, bench.only().chatters), (State::Returned, false));
}

#[test]
fn areas_that_are_not_in_force_are_an_alarm_once_the_chart_had_time_to_take_them() {
    let mut bench = Bench::new();
    bench.shore.no_go = Some("the sea chart is about to take them".to_owned());
    bench.pass(9);
    assert!(bench.told().is_empty(), "a chart takes some seconds");
    bench.pass(2);
    let told = bench.only();
    assert_eq!((told.key.kind, told.priority), (Kind::NoGoAreas, Priority::Alarm));
    assert_eq!(told.text, "the no-go areas are not in force: the sea chart is about to take them");
    bench.shore.no_go = None;
    bench.pass(10);
    assert_eq!(bench.only().state, State::Returned);
}

#[test]
fn shelving_hides_for_a_time_and_never_an_emergency() {
    let mut bench = Bench::new();
    bench.shore.recording = Some("the disk is full".to_owned());
    bench.pass(2);
    let id = bench.only().id;
    let minutes = Duration::from_mins;
    for (span, reason, refused) in [
        (minutes(0), "why", AlarmRefused::Time),
        (minutes(10_000), "why", AlarmRefused::Time),
        (minutes(5), " ", AlarmRefused::Reason),
    ] {
        assert_eq!(bench.alarms.shelve(bench.now(), id, "nils", span, reason), Err(refused));
    }
    bench.alarms.shelve(bench.now(), id, "nils", minutes(5), "a new disk comes").unwrap();
    bench.pass(299);
    assert!(bench.told().is_empty());
    assert_eq!(bench.alarms.standing().count(), 1, "it is listed all the same");
    bench.pass(2);
    assert_eq!(bench.only().state, State::Unacknowledged);

    let mut bench = Bench::new();
    bench.part(4, EntityStateState::Error);
    bench.pass(1);
    let grounding = bench.only();
    assert_eq!((grounding.key.kind, grounding.priority), (Kind::Grounding, Priority::Emergency));
    let refused = bench.alarms.shelve(bench.now(), grounding.id, "nils", minutes(5), "why");
    assert_eq!(refused, Err(AlarmRefused::Emergency));
}

#[test]
fn more_urgent_trouble_needs_a_new_acknowledgement_and_charge_has_hysteresis() {
    let mut bench = Bench::new();
    let charge = |bench: &mut Bench, value: f32, seconds| {
        bench.say(9, m::FuelLevel { value, ..m::FuelLevel::default() });
        bench.pass(seconds);
    };
    charge(&mut bench, 31.0, 20);
    assert!(bench.told().is_empty());
    charge(&mut bench, 29.0, 6);
    assert_eq!(bench.told(), [(Kind::Battery, State::Unacknowledged, Priority::Warning)]);
    let id = bench.only().id;
    bench.alarms.acknowledge(bench.now(), id, "nils").unwrap();
    charge(&mut bench, 31.0, 60);
    assert_eq!(bench.only().state, State::Acknowledged, "31 % is not above 30 % and its hysteresis");
    charge(&mut bench, 19.0, 2);
    assert_eq!(bench.told(), [(Kind::Battery, State::Unacknowledged, Priority::Alarm)]);
    assert_eq!(bench.only().id, id);
    bench.alarms.acknowledge(bench.now(), id, "nils").unwrap();
    charge(&mut bench, 80.0, 40);
    assert!(bench.told().is_empty());
}

#[test]
fn a_position_that_stops_while_the_vessel_speaks_is_told_once() {
    let mut bench = Bench::new();
    bench.say(0, m::EstimatedState::default());
    bench.pass(9);
    assert!(bench.told().is_empty());
    bench.part(1, EntityStateState::Error);
    bench.pass(6);
    assert_eq!(bench.told(), [(Kind::Position, State::Unacknowledged, Priority::Warning)]);
    assert!(bench.alarms.standing().any(|alarm| alarm.collapsed == Some(Kind::Position)));
}

#[test]
fn clocks_errors_in_log_books_and_a_full_disk_are_told() {
    let mut bench = Bench::new();
    bench.shore.clocks = vec![LinkClock { vessel: BOAT, ahead_s: 0.3, uncertainty_s: 0.25 }];
    bench.pass(30);
    assert!(bench.told().is_empty(), "the measurement's doubt explains it");
    bench.shore.clocks[0].uncertainty_s = 0.05;
    bench.shore.disk = Some((500 << 20, 100 << 30));
    let entry =
        m::LogBookEntry { r#type: m::LogBookEntryType::Error, text: "broken".into(), ..Default::default() };
    bench.say(5, entry);
    bench.pass(15);
    let kinds: Vec<Kind> = bench.told().into_iter().map(|(kind, ..)| kind).collect();
    assert_eq!(kinds, [Kind::Disk, Kind::Clock, Kind::LogBook]);
    bench.shore = ShoreState::default();
    bench.pass(90);
    let left = bench.told();
    assert_eq!(left.len(), 2, "the caution went by itself: {left:?}");
    assert!(left.iter().all(|(_, state, _)| *state == State::Returned));
}

#[test]
fn a_vessel_that_sails_by_another_chart_is_a_caution_after_a_minute() {
    let mut bench = Bench::new();
    let difference = api::ChartDifference::Fetching { percent: 43 };
    bench.shore.charts = vec![OtherChart { vessel: BOAT, held: true, difference }];
    bench.pass(90);
    assert!(bench.told().is_empty(), "at rest nobody needs to know");
    bench.mode(VehicleStateOpMode::Maneuver, 450);
    bench.pass(58);
    assert!(bench.told().is_empty(), "most are aboard by then");
    bench.pass(4);
    assert!(matches!(bench.told()[..], [(Kind::Chart, _, Priority::Caution)]), "{:?}", bench.told());
    assert!(bench.only().text.contains("43 %"), "{}", bench.only().text);
    bench.shore.charts.clear();
    bench.pass(10);
    assert!(bench.told().is_empty(), "it goes by itself");
}

#[test]
fn an_acknowledged_alarm_survives_a_restart_and_goes_when_its_vessel_is_well() {
    let mut bench = Bench::new();
    bench.mode(VehicleStateOpMode::Maneuver, 450);
    bench.silence(12);
    let id = bench.only().id;
    bench.alarms.acknowledge(bench.now(), id, "nils").unwrap();
    let saved: Vec<Saved> = bench.alarms.standing().map(Saved::from).collect();
    let mut after = Bench { fleet: Fleet::default(), alarms: Alarms::default(), ..bench };
    for one in saved {
        after.alarms.restore(after.now(), one);
    }
    after.silence(100);
    assert_eq!((after.only().state, after.only().id), (State::Acknowledged, id));
    after.say(0, m::Announce { sys_type: m::SystemType::Usv, ..m::Announce::default() });
    after.pass(5);
    assert!(after.told().is_empty());
    after.mode(VehicleStateOpMode::Maneuver, 450);
    after.silence(12);
    assert!(after.only().id > id, "numbers go on");
}

#[test]
fn a_silence_that_was_over_before_a_restart_does_not_hide_the_next() {
    let mut bench = Bench::new();
    bench.mode(VehicleStateOpMode::Maneuver, 450);
    bench.silence(12);
    bench.say(0, m::Heartbeat);
    bench.pass(10);
    let saved: Vec<Saved> = bench.alarms.standing().map(Saved::from).collect();
    assert_eq!(
        saved.iter().map(|one| (one.key.kind, one.state)).collect::<Vec<_>>(),
        [(Kind::NotHeard, State::Returned)]
    );
    let mut after = Bench { fleet: Fleet::default(), alarms: Alarms::default(), ..bench };
    for one in saved {
        after.alarms.restore(after.now(), one);
    }
    after.shore.expected = vec![BOAT];
    after.silence(100);
    let kinds: Vec<Kind> = after.alarms.standing().map(|one| one.key.kind).collect();
    assert!(kinds.contains(&Kind::NeverHeard), "{kinds:?}");
}

#[test]
fn when_all_places_are_taken_the_urgent_get_one_and_the_rest_is_counted() {
    let mut alarms = Alarms::default();
    let at = |s: u64| Now {
        mono: MonoTime::from_micros(s * 1_000_000),
        utc: UtcTime::from_micros(s as i64 * 1_000_000),
    };
    let trouble = |n: usize, priority| Trouble {
        key: Key { vessel: Some(BOAT), kind: Kind::Part, part: n.to_string() },
        priority,
        says: Vec::new(),
    };
    let mut all: Vec<Trouble> = (0..ALARMS_KEPT + 10).map(|n| trouble(n, Priority::Warning)).collect();
    all.push(trouble(99_999, Priority::Alarm));
    for s in 0..10 {
        alarms.update(at(s), all.clone(), |_| false);
    }
    assert_eq!(alarms.standing().count(), ALARMS_KEPT);
    assert!(alarms.standing().any(|alarm| alarm.priority == Priority::Alarm));
    assert_eq!(alarms.untold, 11);
    alarms.watch(at(10), &Fleet::default(), &ShoreState::default());
    assert!(alarms.standing().any(|alarm| alarm.key.kind == Kind::TooMany));
}

proptest! {
    /// Under any sequence of troubles: a reader that follows the changes knows the present alarms, numbers never repeat, an
    /// alarm sounds only until it is acknowledged, and after a quiet time and all acknowledgements none is left.
    #[test]
    fn readers_follow_and_all_comes_to_rest(
        steps in prop::collection::vec((0_usize..4, 0_usize..4, 1_u64..40, 0_u8..6), 1..60),
    ) {
        let mut bench = Bench::new();
        let (mut known, mut revision) = (BTreeMap::new(), 0);
        let mut sounded: BTreeMap<AlarmId, u32> = BTreeMap::new();
        for (part, priority, seconds, act) in steps {
            let key = Key { vessel: Some(BOAT), kind: Kind::ALL[part], part: String::new() };
            let trouble = Trouble { key, priority: Priority::ALL[priority], says: vec![AlarmSaying::Charge { percent: act.into() }] };
            for _ in 0..seconds {
                bench.s += 1;
                let holds = if act % 2 == 0 { vec![trouble.clone()] } else { Vec::new() };
                let now = bench.now();
                bench.alarms.update(now, holds, |_| false);
                for alarm in bench.alarms.changed(revision) {
                    known.insert(alarm.key.clone(), alarm.clone());
                    let before = sounded.insert(alarm.id, alarm.sounded).unwrap_or(0);
                    if alarm.sounded > before {
                        prop_assert!(alarm.state == State::Unacknowledged);
                    }
                }
                revision = bench.alarms.revision();
                known.retain(|_, alarm| alarm.state != State::Normal || alarm.shelved.is_some());
                let stand: Vec<AlarmId> = bench.alarms.standing().map(|alarm| alarm.id).collect();
                prop_assert_eq!(known.values().map(|alarm| alarm.id).collect::<Vec<_>>(), stand);
            }
            if act == 3 {
                let ids: Vec<AlarmId> = bench.alarms.standing().map(|alarm| alarm.id).collect();
                for id in ids {
                    bench.alarms.acknowledge(bench.now(), id, "nils").ok();
                }
            }
        }
        for _ in 0..200 {
            bench.s += 1;
            let now = bench.now();
            bench.alarms.update(now, Vec::new(), |_| false);
        }
        let ids: Vec<AlarmId> = bench.alarms.standing().map(|alarm| alarm.id).collect();
        for id in ids {
            prop_assert!(bench.alarms.acknowledge(bench.now(), id, "nils").is_ok());
        }
        let raised: Vec<u64> = bench.alarms.notes().filter(|note| note.what == "raised").map(|note| note.id.0).collect();
        prop_assert!(raised.windows(2).all(|two| two[0] < two[1]), "{raised:?}");
        prop_assert_eq!(bench.alarms.standing().count(), 0);
    }
}

#[test]
fn a_vessel_that_is_expected_and_never_came_in_is_told_until_it_comes_or_is_not_expected() {
    let mut bench = Bench::new();
    let absent = Address(0x2811);
    bench.shore.expected = vec![BOAT, absent];
    bench.pass(60);
    assert_eq!(bench.told(), [], "it may be on its way");
    bench.pass(1);
    let told = bench.only();
    assert_eq!(
        (told.key.vessel, told.key.kind, told.priority),
        (Some(absent), Kind::NeverHeard, Priority::Caution)
    );
    assert_eq!(told.text, "not heard since the server started at 1970-01-01 00:00:01Z");
    assert!(!told.wants_acknowledgement());
    // A log of it that is imported is not the vessel.
    let header = Header { timestamp: 1.0, src: absent, ..Header::default() };
    let bytes = Packet::new(header, m::Heartbeat).encode().unwrap();
    let now = bench.now();
    bench.fleet.update(now, &PacketView::new(&bytes).unwrap(), Transport::Import);
    bench.pass(10);
    assert_eq!(bench.only().key.kind, Kind::NeverHeard);
    let now = bench.now();
    bench.fleet.update(now, &PacketView::new(&bytes).unwrap(), Transport::Link);
    bench.pass(6);
    assert_eq!(bench.told(), []);

    let retired = Address(0x2812);
    bench.shore.expected = vec![retired];
    bench.pass(61);
    assert_eq!(bench.only().key.vessel, Some(retired));
    bench.shore.expected.clear();
    bench.pass(6);
    assert_eq!(bench.told(), [], "whose token is revoked is laid up");
}

#[test]
fn a_silence_that_stood_before_the_start_is_not_told_twice() {
    let mut bench = Bench::new();
    bench.mode(VehicleStateOpMode::Maneuver, 450);
    bench.silence(11);
    assert_eq!(bench.only().key.kind, Kind::NotHeard);
    // The server starts again.
    bench.fleet = Fleet::default();
    bench.shore.expected = vec![BOAT];
    bench.silence(61);
    assert_eq!(bench.only().key.kind, Kind::NotHeard);
}
