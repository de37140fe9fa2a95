//! Both ends of the link, joined directly: greetings, gaps, commands and refusals.

use bytes::Bytes;
use link::frame::{self, Frame};
use link::{
    Answer, ByeCode, Commander, ConnectionId, Entry, Failure, Gap, GapReason, Outcome, Record, Shore,
    ShoreInput, ShoreOutput, ShoreSettings, SpoolState, Vessel, VesselInput, VesselOutput, VesselSettings,
};
use std::time::Duration;
use units::{MonoTime, Now, UtcTime};

fn at(ms: u64) -> Now {
    Now {
        mono: MonoTime::from_micros(1_000_000 + ms * 1000),
        utc: UtcTime::from_micros(1_790_000_000_000_000 + ms as i64 * 1000),
    }
}

fn vessel(first: u64, next: u64) -> Vessel {
    let settings = VesselSettings {
        address: 0x2810,
        name: "ntnu-otter-01".to_owned(),
        software: "test".to_owned(),
        incarnation: 1,
        seed: 9,
        budget_bytes_per_s: None,
        spool: SpoolState { stream: 7, first, next },
        ways: Vec::new(),
    };
    Vessel::new(at(0), settings)
}

fn wanted(vessel: &mut Vessel) -> Vec<VesselOutput> {
    std::iter::from_fn(|| vessel.poll_output()).collect()
}

fn given(shore: &mut Shore) -> Vec<ShoreOutput> {
    std::iter::from_fn(|| shore.poll_output()).collect()
}

/// Connects, and carries messages both ways until neither end has output. Answers its other requests.
struct Pair {
    vessel: Vessel,
    shore: Shore,
    durable: Option<u64>,
    aboard: Vec<VesselOutput>,
    ashore: Vec<ShoreOutput>,
    open: Option<ConnectionId>,
}

impl Pair {
    fn new(vessel: Vessel, durable: Option<u64>) -> Self {
        let shore = Shore::new(ShoreSettings::default());
        Self { vessel, shore, durable, aboard: Vec::new(), ashore: Vec::new(), open: None }
    }

    fn carry(&mut self, now: Now) {
        self.vessel.handle(now, VesselInput::Timer);
        self.shore.handle(now, ShoreInput::Timer);
        loop {
            let (up, down) = (wanted(&mut self.vessel), given(&mut self.shore));
            if up.is_empty() && down.is_empty() {
                return;
            }
            for output in up {
                match output {
                    VesselOutput::Open(id, 0, _) => {
                        self.open = Some(id);
                        self.shore.handle(now, ShoreInput::Opened(id));
                        self.vessel.handle(now, VesselInput::Opened(id));
                    }
                    VesselOutput::Send(id, bytes) => self.shore.handle(now, ShoreInput::Message(id, bytes)),
                    other => self.aboard.push(other),
                }
            }
            for output in down {
                match output {
                    ShoreOutput::Hello(id, _) => {
                        self.shore.handle(now, ShoreInput::Resume(id, self.durable));
                    }
                    ShoreOutput::Send(id, bytes) => self.vessel.handle(now, VesselInput::Message(id, bytes)),
                    other => self.ashore.push(other),
                }
            }
        }
    }
}

fn record(seq: u64) -> Record {
    Record { seq, recorded: at(seq).utc, packet: vec![seq as u8; 30].into() }
}

#[test]
fn gaps_are_declared_in_their_place_and_acknowledged() {
    let mut pair = Pair::new(vessel(0, 10), None);
    pair.carry(at(0));
    pair.carry(at(60));
    let [VesselOutput::Up(_), VesselOutput::Need(0, _)] = pair.aboard[..] else {
        panic!("{:?}", pair.aboard)
    };
    let lost =
        Gap { from: 0, to: 4, since: UtcTime::default(), until: at(4).utc, reason: GapReason::SpoolFull };
    // Number 6 is missing without a declaration.
    let entries = vec![
        Entry::Gap(lost),
        Entry::Record(record(4)),
        Entry::Record(record(5)),
        Entry::Record(record(7)),
        Entry::Gap(Gap { from: 8, to: 10, reason: GapReason::NotRecorded, ..lost }),
    ];
    pair.vessel.handle(at(60), VesselInput::Entries(0, entries));
    pair.carry(at(60));
    let told: Vec<(u64, u64, Option<GapReason>)> = pair
        .ashore
        .iter()
        .filter_map(|output| match output {
            ShoreOutput::Records { stream: 7, records } => {
                Some((records[0].seq, records.last().unwrap().seq + 1, None))
            }
            ShoreOutput::Gap { stream: 7, gap } => Some((gap.from, gap.to, Some(gap.reason))),
            _ => None,
        })
        .collect();
    let expected = [
        (0, 4, Some(GapReason::SpoolFull)),
        (4, 6, None),
        (6, 7, Some(GapReason::Damaged)),
        (7, 8, None),
        (8, 10, Some(GapReason::NotRecorded)),
    ];
    assert_eq!(told, expected);
    pair.shore.handle(at(70), ShoreInput::Durable { stream: 7, seq: 9 });
    pair.carry(at(70));
    assert_eq!(pair.aboard.last(), Some(&VesselOutput::Acknowledged(10)));
    assert_eq!(pair.vessel.status(at(70)).backlog, 0);
}

#[test]
fn a_shore_that_knows_more_than_the_spool_makes_it_begin_another_stream() {
    let mut pair = Pair::new(vessel(0, 10), Some(10));
    pair.carry(at(0));
    assert_eq!(pair.aboard[0], VesselOutput::Renumber);
    assert!(matches!(&pair.aboard[1], VesselOutput::Close(..)));
    pair.vessel.handle(at(1), VesselInput::Spool(SpoolState { stream: 8, first: 0, next: 10 }));
    pair.durable = None;
    pair.carry(at(2000));
    assert!(pair.aboard.iter().any(|one| matches!(one, VesselOutput::Up(_))));
}

#[test]
fn a_spool_that_cannot_be_read_is_asked_again_after_a_second() {
    let mut pair = Pair::new(vessel(0, 10), None);
    for ms in [0, 60] {
        pair.carry(at(ms));
    }
    pair.vessel.handle(at(60), VesselInput::Entries(0, Vec::new()));
    pair.carry(at(900));
    let asked = |pair: &Pair| pair.aboard.iter().filter(|one| matches!(one, VesselOutput::Need(..))).count();
    assert_eq!(asked(&pair), 1);
    pair.carry(at(1100));
    assert_eq!(asked(&pair), 2);
}

fn command(id: u64, ttl_ms: u64) -> ShoreInput {
    ShoreInput::Command {
        id,
        ttl: Duration::from_millis(ttl_ms),
        lease: 7,
        order: 77,
        overtakes: false,
        packet: Bytes::from_static(b"packet"),
    }
}

#[test]
fn a_command_is_delivered_answered_and_reported() {
    let mut pair = Pair::new(vessel(0, 0), None);
    pair.carry(at(0));
    pair.shore.handle(at(100), command(5, 1000));
    pair.carry(at(100));
    let Some(VesselOutput::Command { id: 5, lease: 7, order: 77, packet, expires }) = pair.aboard.pop()
    else {
        panic!()
    };
    assert_eq!(&packet[..], b"packet");
    assert!(expires <= at(1100).mono && expires > at(1090).mono, "{expires:?}");
    pair.vessel.handle(at(101), VesselInput::Answer(5, Answer::Refused("the queue is full".to_owned())));
    pair.carry(at(101));
    assert_eq!(
        pair.ashore.pop(),
        Some(ShoreOutput::Outcome(5, Outcome::Refused("the queue is full".to_owned())))
    );
}

#[test]
fn an_order_keeps_its_number_down_and_back_and_when_it_is_given_again() {
    let mut pair = Pair::new(vessel(0, 0), None);
    pair.carry(at(0));
    for (id, ms) in [(5, 100), (6, 3_000)] {
        pair.shore.handle(at(ms), command(id, 1000));
        pair.carry(at(ms));
        let came = VesselOutput::Came { id, order: 77, way: 0, again: false };
        assert!(pair.aboard.contains(&came), "{:?}", pair.aboard);
        let over = pair.open.unwrap();
        let sent = ShoreOutput::Sent { id, order: 77, over, times: 1 };
        assert!(pair.ashore.contains(&sent), "{:?}", pair.ashore);
        pair.vessel.handle(at(ms), VesselInput::Answer(id, Answer::Received));
        pair.carry(at(ms));
        assert_eq!(pair.ashore.last(), Some(&ShoreOutput::Outcome(id, Outcome::Received)));
    }
    let answered = pair.aboard.iter().filter_map(|one| match one {
        VesselOutput::Answered(receipt) => Some((receipt.id, receipt.order)),
        _ => None,
    });
    assert_eq!(answered.collect::<Vec<_>>(), [(5, 77), (6, 77)]);
    // A shore that was started again meanwhile knows neither identity, but the order.
    let receipt = frame::Receipt { id: 4, verdict: frame::Verdict::Received, text: String::new(), order: 76 };
    let message = frame::message(&Frame::Receipt(receipt.clone()));
    pair.shore.handle(at(3_001), ShoreInput::Message(pair.open.unwrap(), message));
    assert!(given(&mut pair.shore).contains(&ShoreOutput::Stray(receipt)));
}

#[test]
fn a_vessel_of_before_gets_the_command_that_it_knows() {
    let sent_to = |capabilities: u32| {
        let mut shore = Shore::new(ShoreSettings::default());
        let id = ConnectionId(1);
        shore.handle(at(0), ShoreInput::Opened(id));
        let Some(Ok(Frame::Hello(hello))) = frame::decode(hello(1, frame::VERSION)).unwrap().next() else {
            panic!()
        };
        let hello = frame::Hello { capabilities: link::Capabilities(capabilities), ..hello };
        shore.handle(at(0), ShoreInput::Message(id, frame::message(&Frame::Hello(hello))));
        shore.handle(at(0), ShoreInput::Resume(id, None));
        shore.handle(at(0), command(5, 1000));
        let mut messages = given(&mut shore).into_iter().filter_map(|output| match output {
            ShoreOutput::Send(_, bytes) => Some(bytes),
            _ => None,
        });
        let kinds = [7, 17];
        let command = messages.rfind(|bytes| kinds.contains(&bytes[0])).unwrap();
        let Some(Ok(Frame::Command(told))) = frame::decode(command.clone()).unwrap().next() else { panic!() };
        assert_eq!(&told.packet[..], b"packet");
        (command[0], told.order)
    };
    assert_eq!(sent_to(15), (7, 0), "as version 0.1.0 reads it");
    assert_eq!(sent_to(47), (17, 77));
}

#[test]
fn who_commands_is_told_before_commands_again_and_again_and_on_every_connection() {
    let mut pair = Pair::new(vessel(0, 0), None);
    let lease = |ttl_ms, holder: &str| link::Lease { epoch: 7, ttl_ms, holder: holder.to_owned(), number: 0 };
    let told = |pair: &mut Pair| -> Vec<link::Lease> {
        let told = pair.aboard.drain(..).filter_map(|one| match one {
            VesselOutput::Lease(lease) => Some(lease),
            _ => None,
        });
        told.collect()
    };
    // Known before there is a connection, and a command waits as well.
    pair.shore.handle(at(0), ShoreInput::Lease(Commander { epoch: 7, holder: Some("nils".to_owned()) }));
    pair.shore.handle(at(0), command(5, 60_000));
    pair.carry(at(0));
    let order = |one: &VesselOutput| matches!(one, VesselOutput::Lease(_) | VesselOutput::Command { .. });
    let first: Vec<_> = pair.aboard.iter().filter(|one| order(one)).collect();
    assert!(matches!(first[..], [VesselOutput::Lease(_), VesselOutput::Command { .. }]), "{first:?}");
    assert_eq!(told(&mut pair), [lease(30_000, "nils")]);
    for ms in (500..=20_500).step_by(500) {
        pair.carry(at(ms));
    }
    assert_eq!(told(&mut pair).len(), 2, "every ten seconds");
    let old = pair.open.unwrap();
    pair.vessel.handle(at(21_000), VesselInput::Closed(old));
    pair.shore.handle(at(21_000), ShoreInput::Closed(old));
    pair.carry(at(23_000));
    assert_eq!(told(&mut pair), [lease(30_000, "nils")]);
    pair.shore.handle(at(23_500), ShoreInput::Lease(Commander { epoch: 7, holder: None }));
    for ms in (23_500..40_000).step_by(500) {
        pair.carry(at(ms));
    }
    assert_eq!(told(&mut pair), [lease(0, "")], "its end is told once");
}

#[test]
fn a_command_on_its_way_for_too_long_is_not_delivered() {
    let mut pair = Pair::new(vessel(0, 0), None);
    pair.carry(at(0));
    pair.shore.handle(at(100), command(5, 1000));
    let down = given(&mut pair.shore);
    for output in down {
        if let ShoreOutput::Send(id, bytes) = output {
            pair.vessel.handle(at(1101), VesselInput::Message(id, bytes));
        }
    }
    assert!(!wanted(&mut pair.vessel).iter().any(|one| match one {
        VesselOutput::Command { .. } => true,
        VesselOutput::Send(id, bytes) => {
            pair.shore.handle(at(1102), ShoreInput::Message(*id, bytes.clone()));
            false
        }
        _ => false,
    }));
    assert!(given(&mut pair.shore).contains(&ShoreOutput::Outcome(5, Outcome::Expired)));
}

#[test]
fn a_command_whose_answer_was_lost_is_not_delivered_twice() {
    let mut pair = Pair::new(vessel(0, 0), None);
    pair.carry(at(0));
    pair.shore.handle(at(100), command(5, 60_000));
    pair.carry(at(100));
    // The answer is given while the connection is gone.
    let old = pair.open.unwrap();
    pair.vessel.handle(at(200), VesselInput::Closed(old));
    pair.shore.handle(at(200), ShoreInput::Closed(old));
    pair.vessel.handle(at(200), VesselInput::Answer(5, Answer::Received));
    pair.carry(at(2000));
    let delivered = pair.aboard.iter().filter(|one| matches!(one, VesselOutput::Command { .. }));
    assert_eq!(delivered.count(), 1);
    assert!(pair.ashore.contains(&ShoreOutput::Outcome(5, Outcome::Received)));
}

#[test]
fn without_a_vessel_commands_expire_and_too_many_are_refused() {
    let mut shore = Shore::new(ShoreSettings::default());
    for id in 0..257 {
        shore.handle(at(0), command(id, 1000));
    }
    let outputs = given(&mut shore);
    assert!(matches!(&outputs[..], [ShoreOutput::Outcome(256, Outcome::Refused(_))]));
    assert_eq!(shore.poll_timeout(at(0)), Some(at(1000).mono));
    shore.handle(at(1000), ShoreInput::Timer);
    assert_eq!(given(&mut shore).len(), 256);
    assert_eq!(shore.poll_timeout(at(1000)), None);
}

fn hello(attempt: u64, version: u16) -> Bytes {
    let mut vessel = vessel(0, 0);
    vessel.handle(at(0), VesselInput::Timer);
    vessel.handle(at(0), VesselInput::Opened(ConnectionId(1)));
    let sent = wanted(&mut vessel).into_iter().find_map(|output| match output {
        VesselOutput::Send(_, bytes) => frame::decode(bytes).unwrap().next(),
        _ => None,
    });
    let Some(Ok(Frame::Hello(hello))) = sent else { panic!("{sent:?}") };
    frame::message(&Frame::Hello(frame::Hello { attempt, version, oldest_version: version, ..hello }))
}

fn closed(outputs: &[ShoreOutput]) -> Vec<(u64, ByeCode)> {
    let closed = outputs.iter().filter_map(|output| match output {
        ShoreOutput::Close(id, code, _) => Some((id.0, *code)),
        _ => None,
    });
    closed.collect()
}

#[test]
fn the_latest_connection_counts_whatever_order_they_come_in() {
    let mut shore = Shore::new(ShoreSettings::default());
    for (id, attempt) in [(10, 4), (11, 6), (12, 5)] {
        let id = ConnectionId(id);
        shore.handle(at(id.0), ShoreInput::Opened(id));
        shore.handle(at(id.0), ShoreInput::Message(id, hello(attempt, frame::VERSION)));
        shore.handle(at(id.0), ShoreInput::Resume(id, None));
    }
    assert_eq!(closed(&given(&mut shore)), [(10, ByeCode::Replaced), (12, ByeCode::Replaced)]);
    assert!(shore.status(at(20)).up);
}

#[test]
fn strangers_are_shown_out() {
    let refused = |bytes: Bytes| {
        let mut shore = Shore::new(ShoreSettings::default());
        shore.handle(at(0), ShoreInput::Opened(ConnectionId(1)));
        shore.handle(at(0), ShoreInput::Message(ConnectionId(1), bytes));
        closed(&given(&mut shore))
    };
    assert_eq!(refused(hello(1, frame::VERSION + 1)), [(1, ByeCode::Version)]);
    assert_eq!(refused(hello(1, 1)), [(1, ByeCode::Version)], "what knows no leases is not commanded");
    assert_eq!(refused(Bytes::from_static(b"GET / HTTP/1.1\r\n")), [(1, ByeCode::Protocol)]);
    assert_eq!(refused(vec![0; (1 << 20) + 1].into()), [(1, ByeCode::Protocol)]);
    let early = frame::message(&Frame::Ack(frame::Ack { received: 0, durable: 0, bytes: 0 }));
    assert_eq!(refused(early), [(1, ByeCode::Protocol)]);
    // Silence too.
    let mut shore = Shore::new(ShoreSettings::default());
    shore.handle(at(0), ShoreInput::Opened(ConnectionId(1)));
    shore.handle(at(4999), ShoreInput::Timer);
    assert_eq!(given(&mut shore), []);
    shore.handle(at(5000), ShoreInput::Timer);
    assert_eq!(closed(&given(&mut shore)), [(1, ByeCode::Silent)]);
}

#[test]
fn a_vessel_that_is_refused_comes_back_later_than_one_that_nobody_answered() {
    let pause = |refuse: bool| {
        let mut vessel = vessel(0, 0);
        let mut ms = 0;
        for _ in 0..10 {
            vessel.handle(at(ms), VesselInput::Timer);
            let id = match &wanted(&mut vessel)[..] {
                [VesselOutput::Open(id, 0, _)] => *id,
                other => panic!("{other:?}"),
            };
            let failure = if refuse { Failure::Refused } else { Failure::Unanswered };
            vessel.handle(at(ms), VesselInput::Failed(id, failure));
            let before = ms;
            ms = (vessel.poll_timeout(at(ms)).unwrap().micros() - 1_000_000).div_ceil(1000);
            assert!(ms > before);
        }
        ms
    };
    assert!(pause(false) < 10_000);
    assert!(pause(true) > 40_000 && pause(true) < 150_000);
}

#[test]
fn a_silent_shore_is_left_after_three_seconds() {
    let mut pair = Pair::new(vessel(0, 0), None);
    pair.carry(at(0));
    assert!(pair.vessel.status(at(0)).up);
    pair.vessel.handle(at(2999), VesselInput::Timer);
    assert!(!wanted(&mut pair.vessel).iter().any(|one| matches!(one, VesselOutput::Close(..))));
    pair.vessel.handle(at(3000), VesselInput::Timer);
    assert!(wanted(&mut pair.vessel).iter().any(|one| matches!(one, VesselOutput::Close(..))));
}

#[test]
fn what_was_ordered_before_a_stop_is_not_sent_after_it() {
    let mut pair = Pair::new(vessel(0, 0), None);
    let stop = |id| match command(id, 60_000) {
        ShoreInput::Command { id, ttl, lease, order, packet, .. } => {
            ShoreInput::Command { id, ttl, lease, order, overtakes: true, packet }
        }
        other => other,
    };
    pair.shore.handle(at(0), command(1, 60_000));
    pair.shore.handle(at(0), stop(2));
    pair.shore.handle(at(0), command(3, 60_000));
    let mut told = Vec::new();
    while let Some(output) = pair.shore.poll_output() {
        told.push(output);
    }
    let off = |output: &ShoreOutput| matches!(output, ShoreOutput::Outcome(1, Outcome::Refused(why)) if why.contains("a stop"));
    assert!(told.iter().any(off), "{told:?}");
}
