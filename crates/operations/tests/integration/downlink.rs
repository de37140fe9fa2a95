//! The downlink: which way orders take, which wait, which a stop cancels.

use hub::{
    CommandId, Delivery, Dispatched, Hub, Incoming, OrderLog as _, Peer, PeerId, Role, Settings, Sources,
    Tag, Telecommand, Transport, Urgency,
};
use imc::messages::{
    Aborted, Message, PlanControl, PlanControlOp, PlanControlState, PlanControlStateState, PlanControlType,
    Voltage,
};
use imc::{Address, Header, Packet};
use operations::{Commands, Order, OrderedBy, Receipt, Stage};
use std::collections::BTreeMap;
use units::{MonoTime, Now, UtcTime};

const BOAT: Address = Address(0x2810);

fn at(millis: u64) -> Now {
    let us = millis * 1_000;
    Now { mono: MonoTime::from_micros(us), utc: UtcTime::from_micros(1_790_000_000_000_000 + us as i64) }
}

struct World {
    hub: Hub<Commands>,
}

impl World {
    fn new() -> Self {
        let settings = Settings { address: Address(0x4F00), name: "shore".into(), active: false };
        Self { hub: Hub::new(settings, Commands::new(Address(0x4F00))) }
    }

    /// The peer of the vessel's link, which is not open yet.
    fn link(&mut self) -> PeerId {
        let sources = Sources::Only(vec![BOAT]);
        let peer = Peer { transport: Transport::Link, role: Role::Vessel, name: "link".to_owned(), sources };
        self.hub.join(at(0), peer)
    }

    fn node(&mut self, transport: Transport) -> PeerId {
        let peer =
            Peer { transport, role: Role::Vessel, name: transport.name().to_owned(), sources: Sources::Any };
        self.hub.join(at(0), peer)
    }

    fn says(&mut self, millis: u64, peer: PeerId, message: impl Into<Message>) {
        let timestamp = at(millis).utc.seconds();
        let header = Header { src: BOAT, dst: Address(0xFFFF), timestamp, ..Header::default() };
        let packet = Packet::new(header, message).encode().unwrap();
        self.hub.packets(at(millis), peer, [Incoming::from(bytes::Bytes::from(packet))]);
    }

    fn heard(&mut self, millis: u64, peer: PeerId) {
        self.says(millis, peer, Voltage { value: millis as f32 });
    }

    fn order(&mut self, millis: u64, order: Order) -> (CommandId, Dispatched) {
        let by = OrderedBy { name: "anna".to_owned(), ..OrderedBy::default() };
        let id = self.hub.orders_mut().begin(at(millis), BOAT, &by, 7, order).unwrap();
        let telecommand = self.hub.orders_mut().accepted(at(millis), id, None).unwrap();
        let dispatched = self.hub.dispatch(at(millis), telecommand);
        self.hub.orders_mut().dispatched(at(millis), id, &dispatched);
        (id, dispatched)
    }

    /// Time passes, as for the shore.
    fn tick(&mut self, now: Now) {
        self.hub.tick(now);
        self.hub.orders_mut().tick(now);
    }

    /// The orders that wait for each peer, by their commands.
    fn drain(&mut self) -> BTreeMap<PeerId, Vec<Delivery>> {
        let mut out = BTreeMap::new();
        self.hub.drain_deliveries(|peer, mut packets| {
            packets.retain(|packet| packet.tag.is_some());
            if !packets.is_empty() {
                out.insert(peer, packets);
            }
        });
        out
    }

    fn ids(&mut self, peer: PeerId) -> Vec<CommandId> {
        let all = self.drain().remove(&peer).unwrap_or_default();
        let orders = all.into_iter().filter_map(|packet| packet.tag).filter(|tag| !tag.is_copy);
        orders.filter_map(|tag| tag.id).collect()
    }

    fn stage(&self, id: CommandId) -> (Stage, String) {
        let command = self.hub.orders().get(id).unwrap();
        (command.stage(), command.steps.last().unwrap().in_full().to_string())
    }
}

fn start() -> Order {
    Order::StartPlan { plan_id: "survey".to_owned() }
}

#[test]
fn an_order_takes_the_link_while_it_stands_and_else_the_best_other_way() {
    let mut world = World::new();
    let (link, tcp, udp) = (world.link(), world.node(Transport::Tcp), world.node(Transport::Udp));
    world.hub.trust_transports([Transport::Tcp, Transport::Udp]);
    world.heard(0, tcp);
    world.heard(100, udp);
    let (id, dispatched) = world.order(200, start());
    assert_eq!(dispatched, Dispatched::Sent(vec![Transport::Tcp]));
    assert_eq!(world.ids(tcp), [id]);
    world.hub.link_stands(at(300), link, true);
    let (id, dispatched) = world.order(400, start());
    assert_eq!(dispatched, Dispatched::Sent(vec![Transport::Link]));
    assert_eq!(world.ids(link), [id]);
    world.hub.link_stands(at(500), link, false);
    assert_eq!(world.order(600, start()).1, Dispatched::Sent(vec![Transport::Tcp]));
}

#[test]
fn a_stop_takes_every_way_and_its_copies_are_not_worth_more_than_any_order() {
    let mut world = World::new();
    let (link, udp) = (world.link(), world.node(Transport::Udp));
    world.hub.trust_transports([Transport::Udp]);
    world.heard(0, udp);
    world.hub.link_stands(at(0), link, true);
    let (_, dispatched) = world.order(1_000, Order::Stop);
    assert_eq!(dispatched, Dispatched::Sent(vec![Transport::Link, Transport::Udp]));
    let out = world.drain();
    let expires = |peer| out[&peer][0].tag.unwrap().expires;
    assert_eq!(
        expires(link),
        at(11_000).mono,
        "whoever starts again must not be stopped by it minutes later"
    );
    assert_eq!(expires(udp), at(11_000).mono);
    let (_, dispatched) = world.order(200_000, Order::Stop);
    assert_eq!(dispatched, Dispatched::Sent(vec![Transport::Link]), "the other way is gone");
    assert_eq!(world.drain()[&link][0].tag.unwrap().expires, at(210_000).mono);
}

#[test]
fn a_stop_waits_for_its_vessel_and_goes_out_first_when_it_is_heard() {
    let mut world = World::new();
    let link = world.link();
    let (early, dispatched) = world.order(0, start());
    assert_eq!(dispatched, Dispatched::Waits(vec![]));
    let (stop, dispatched) = world.order(1_000, Order::Stop);
    assert_eq!(dispatched, Dispatched::Waits(vec![]));
    assert_eq!(world.stage(early), (Stage::Refused, "a stop was ordered before it could be sent".to_owned()));
    let (late, _) = world.order(300_000, start());
    for second in 1..=305 {
        world.tick(at(second * 1_000));
    }
    assert_eq!(world.stage(stop).0, Stage::Waiting, "for minutes");
    world.hub.link_stands(at(306_000), link, true);
    assert_eq!(world.ids(link), [stop, late]);
    assert_eq!(world.stage(stop), (Stage::Sent, "by link".to_owned()));
    // Once and no more.
    world.hub.link_stands(at(307_000), link, false);
    world.hub.link_stands(at(308_000), link, true);
    assert_eq!(world.ids(link), []);
}

#[test]
fn a_stop_that_nobody_was_there_to_hear_expires_and_any_other_order_sooner() {
    let mut world = World::new();
    world.link();
    let (command, _) = world.order(0, start());
    let (other, dispatched) = world.order(1, Order::Stop);
    assert_eq!((dispatched, world.stage(command).0), (Dispatched::Waits(vec![]), Stage::Refused));
    let (command, _) = world.order(2, start());
    for second in 1..=12 {
        world.tick(at(second * 1_000));
    }
    assert_eq!(world.stage(command).0, Stage::Expired);
    assert_eq!(world.stage(other).0, Stage::Waiting);
    world.tick(at(601_000));
    assert_eq!(world.stage(other).0, Stage::Expired);
}

#[test]
fn a_vessel_without_a_link_gets_a_stop_when_it_is_heard_again_and_other_orders_are_refused_at_once() {
    let mut world = World::new();
    let udp = world.node(Transport::Udp);
    let (_, dispatched) = world.order(0, start());
    assert_eq!(dispatched, Dispatched::Refused("no connection to the vessel now"));
    let (stop, dispatched) = world.order(1_000, Order::Stop);
    assert_eq!(dispatched, Dispatched::Waits(vec![]));
    world.heard(2_000, udp);
    assert_eq!(world.ids(udp), [stop]);
    assert_eq!(world.stage(stop).0, Stage::Sent);
}

#[test]
fn stick_positions_wait_for_nothing() {
    let mut world = World::new();
    let link = world.link();
    let tag = |millis| Tag {
        id: None,
        is_copy: false,
        epoch: 7,
        expires: at(millis).mono,
        urgency: Urgency::Sticks,
    };
    let sticks = |tag| Telecommand { vessel: BOAT, tag, packet: voltage() };
    assert!(matches!(world.hub.dispatch(at(0), sticks(tag(500))), Dispatched::Refused(_)));
    world.hub.link_stands(at(100), link, true);
    assert!(world.drain().is_empty());
    assert_eq!(world.hub.dispatch(at(100), sticks(tag(500))), Dispatched::Sent(vec![Transport::Link]));
    assert!(matches!(world.hub.dispatch(at(600), sticks(tag(500))), Dispatched::Refused(_)), "too late");
}

fn voltage() -> bytes::Bytes {
    let header = Header { dst: BOAT, ..Header::default() };
    Packet::new(header, Voltage { value: 1.0 }).encode().unwrap().into()
}

#[test]
fn the_effect_of_a_stop_is_what_the_vessel_says() {
    let mut world = World::new();
    let udp = world.node(Transport::Udp);
    world.heard(0, udp);
    let ready = PlanControlState { state: PlanControlStateState::Ready, ..PlanControlState::default() };
    let (stop, _) = world.order(1_000, Order::Stop);
    world.says(1_100, udp, ready.clone());
    assert_eq!(world.stage(stop).0, Stage::Sent, "it rested before, and may not have heard yet");
    world.says(1_200, udp, Aborted);
    assert_eq!(world.stage(stop).0, Stage::EffectSeen);
    let (stop, _) = world.order(2_000, Order::Stop);
    world.says(4_100, udp, ready.clone());
    assert_eq!(world.stage(stop).0, Stage::EffectSeen);
    // A stop is sent however many orders wait, and its effect is reported even after its timeout.
    let (stop, _) = world.order(5_000, Order::Stop);
    for millis in 0..19 {
        world.order(6_000 + millis, start());
    }
    assert_eq!(world.order(7_000, Order::Stop).1, Dispatched::Sent(vec![Transport::Udp]));
    for second in 7..=40 {
        world.tick(at(second * 1_000));
    }
    assert_eq!(world.stage(stop).0, Stage::TimedOut);
    world.says(41_000, udp, Aborted);
    assert_eq!(world.stage(stop), (Stage::EffectSeen, "late: the vessel says that it aborted".to_owned()));
}

#[test]
fn how_far_commands_get_is_told_once_for_the_audit_log() {
    let mut world = World::new();
    let udp = world.node(Transport::Udp);
    world.heard(0, udp);
    world.order(1_000, Order::Stop);
    world.order(1_000, Order::List);
    world.says(1_200, udp, Aborted);
    let (events, forgotten) = world.hub.orders_mut().drain();
    let told: Vec<(&str, &str)> = events.iter().map(|one| (one.verb, one.step.stage.name())).collect();
    let stages = ["sent", "received", "executing", "effect seen"];
    assert_eq!((told, forgotten), (stages.map(|stage| ("vessel.abort", stage)).to_vec(), 0));
    assert!(world.hub.orders_mut().drain().0.is_empty());
    assert_eq!(events[0].by.name, "anna");
}

#[test]
fn a_start_that_is_still_being_written_down_is_not_sent_after_a_stop() {
    let mut world = World::new();
    let udp = world.node(Transport::Udp);
    world.heard(0, udp);
    let by = OrderedBy { name: "anna".to_owned(), ..OrderedBy::default() };
    let begin =
        |world: &mut World, order| world.hub.orders_mut().begin(at(100), BOAT, &by, 7, order).unwrap();
    let id = begin(&mut world, start());
    assert_eq!(world.hub.orders().stops(BOAT), 0);
    world.order(200, Order::Stop);
    assert_eq!(world.hub.orders().stops(BOAT), 1, "who prepares an order sees that a stop came in between");
    assert_eq!(world.hub.orders_mut().accepted(at(300), id, None), None);
    assert_eq!(world.stage(id), (Stage::Refused, "a stop was ordered before it could be sent".to_owned()));
    // An order after the stop is sent.
    let (later, _) = world.order(400, start());
    assert_eq!(world.stage(later).0, Stage::Sent);
}

#[test]
fn a_stop_is_given_again_to_a_vessel_that_was_out_of_reach() {
    let mut world = World::new();
    let udp = world.node(Transport::Udp);
    world.heard(0, udp);
    // In a radio shadow: the node is still known, and a datagram goes into nothing.
    let (stop, dispatched) = world.order(10_000, Order::Stop);
    assert_eq!(dispatched, Dispatched::Waits(vec![Transport::Udp]));
    assert_eq!(world.ids(udp), [stop]);
    world.heard(40_000, udp);
    assert_eq!(world.ids(udp), [stop]);
    assert_eq!(world.stage(stop).0, Stage::Sent);
    world.heard(41_000, udp);
    assert_eq!(world.ids(udp), [], "once");
}

#[test]
fn what_a_peer_did_not_take_goes_by_another_way() {
    let mut world = World::new();
    let (tcp, udp) = (world.node(Transport::Tcp), world.node(Transport::Udp));
    world.heard(0, udp);
    world.heard(100, tcp);
    let (id, dispatched) = world.order(200, start());
    assert_eq!(dispatched, Dispatched::Sent(vec![Transport::Tcp]));
    let left = world.drain().remove(&tcp).unwrap().remove(0);
    world.hub.leave(tcp);
    let again = Telecommand { vessel: BOAT, tag: left.tag.unwrap(), packet: left.packet };
    world.hub.give_again(at(300), again);
    assert_eq!(world.ids(udp), [id]);
}

#[test]
fn that_the_link_did_not_bring_a_stop_is_not_its_end_where_another_way_did() {
    let mut world = World::new();
    let (link, udp) = (world.link(), world.node(Transport::Udp));
    world.hub.trust_transports([Transport::Udp]);
    world.heard(0, udp);
    world.hub.link_stands(at(0), link, true);
    let (stop, _) = world.order(1_000, Order::Stop);
    world.hub.orders_mut().receipt(at(11_000), stop, Receipt::Expired);
    assert_eq!(world.stage(stop).0, Stage::TimedOut);
    world.says(12_000, udp, Aborted);
    assert_eq!(world.stage(stop).0, Stage::EffectSeen);
}

#[test]
fn a_stop_that_was_sent_is_given_again_until_the_vessel_shows_that_it_has_it() {
    let mut world = World::new();
    let udp = world.node(Transport::Udp);
    world.heard(0, udp);
    // Heard a second ago, so that it counts as sent; but the vessel has just gone behind an island.
    let (stop, dispatched) = world.order(1_000, Order::Stop);
    assert_eq!((dispatched, world.ids(udp)), (Dispatched::Sent(vec![Transport::Udp]), vec![stop]));
    for second in 2..=70 {
        world.tick(at(second * 1_000));
    }
    assert_eq!(world.stage(stop).0, Stage::TimedOut);
    world.heard(90_000, udp);
    assert_eq!(world.ids(udp), [stop]);
    assert_eq!(world.stage(stop), (Stage::Sent, "again by udp".to_owned()));
    world.heard(91_000, udp);
    assert_eq!(world.ids(udp), [], "while it is heard it is not flooded");
    world.says(91_500, udp, Aborted);
    assert_eq!(world.stage(stop).0, Stage::EffectSeen);
    world.heard(120_000, udp);
    assert_eq!(world.ids(udp), [], "it has it");
}

#[test]
fn a_stop_that_nobody_confirms_ends_with_its_life() {
    let mut world = World::new();
    let udp = world.node(Transport::Udp);
    world.heard(0, udp);
    let (stop, _) = world.order(1_000, Order::Stop);
    assert_eq!(world.ids(udp), [stop]);
    world.tick(at(601_500));
    world.heard(602_000, udp);
    assert_eq!(world.ids(udp), []);
}

#[test]
fn a_stop_that_a_lost_connection_took_is_given_to_the_next() {
    let mut world = World::new();
    let tcp = world.node(Transport::Tcp);
    world.heard(0, tcp);
    let (stop, _) = world.order(500, Order::Stop);
    assert_eq!(world.ids(tcp), [stop]);
    world.hub.leave(tcp);
    let again = world.node(Transport::Tcp);
    world.heard(1_700, again);
    assert_eq!(world.ids(again), [stop], "what the first took was perhaps never on the line");
    world.heard(1_800, again);
    assert_eq!(world.ids(again), []);
}

#[test]
fn a_stop_by_link_and_radio_outlives_both() {
    let mut world = World::new();
    let (link, udp) = (world.link(), world.node(Transport::Udp));
    world.hub.trust_transports([Transport::Udp]);
    world.heard(0, udp);
    world.hub.link_stands(at(0), link, true);
    let (stop, _) = world.order(1_000, Order::Stop);
    world.drain();
    world.hub.orders_mut().receipt(at(14_000), stop, Receipt::Unanswered);
    world.hub.link_stands(at(15_000), link, false);
    world.hub.link_stands(at(100_000), link, true);
    assert_eq!(world.ids(link), [stop]);
    world.hub.orders_mut().receipt(at(100_100), stop, Receipt::Received);
    world.hub.link_stands(at(110_000), link, false);
    world.hub.link_stands(at(120_000), link, true);
    assert_eq!(world.ids(link), [], "it has it");
}

#[test]
fn what_is_started_after_a_stop_is_not_ended_by_it() {
    let mut world = World::new();
    let udp = world.node(Transport::Udp);
    world.heard(0, udp);
    let (stop, _) = world.order(1_000, Order::Stop);
    let (begin, _) = world.order(2_000, start());
    assert_eq!(world.ids(udp), [stop, begin]);
    world.heard(40_000, udp);
    assert_eq!(world.ids(udp), []);
    // A start that the vessel refuses does not count.
    world.hub.orders_mut().refused(at(41_000), begin, api::Said::as_is("no such plan"));
    world.heard(80_000, udp);
    assert_eq!(world.ids(udp), [stop]);
    // By another console as well.
    let mut world = World::new();
    let (udp, console) = (world.node(Transport::Udp), world.node(Transport::Proxy));
    world.heard(0, udp);
    world.order(1_000, Order::Stop);
    world.drain();
    let control =
        PlanControl { op: PlanControlOp::Start, r#type: PlanControlType::Request, ..PlanControl::default() };
    let header =
        Header { src: Address(0x4001), dst: BOAT, timestamp: at(2_000).utc.seconds(), ..Header::default() };
    let packet = bytes::Bytes::from(Packet::new(header, control).encode().unwrap());
    world.hub.packets(at(2_000), console, [Incoming::from(packet)]);
    world.heard(40_000, udp);
    assert_eq!(world.ids(udp), []);
}

#[test]
fn parameters_and_questions_after_a_stop_do_not_end_it() {
    let mut world = World::new();
    let udp = world.node(Transport::Udp);
    world.heard(0, udp);
    let (stop, _) = world.order(1_000, Order::Stop);
    world.order(1_500, Order::List);
    world.drain();
    world.heard(40_000, udp);
    assert_eq!(world.ids(udp), [stop]);
}

#[test]
fn a_way_that_takes_nothing_is_none() {
    let mut world = World::new();
    let (tcp, udp) = (world.node(Transport::Tcp), world.node(Transport::Udp));
    world.heard(0, tcp);
    world.heard(0, udp);
    world.hub.takes(tcp, false);
    assert_eq!(world.order(100, start()).1, Dispatched::Sent(vec![Transport::Udp]));
    world.hub.takes(udp, false);
    let (stop, dispatched) = world.order(200, Order::Stop);
    assert_eq!(
        dispatched,
        Dispatched::Waits(vec![Transport::Tcp, Transport::Udp]),
        "what is full is not a way"
    );
    world.drain();
    world.hub.takes(tcp, true);
    world.heard(300, tcp);
    assert_eq!(world.ids(tcp), [stop]);
}

#[test]
fn nothing_is_started_over_the_head_of_a_stop_that_was_perhaps_not_heard() {
    let mut world = World::new();
    let udp = world.node(Transport::Udp);
    world.heard(0, udp);
    let (stop, dispatched) = world.order(5_000, Order::Stop);
    assert_eq!(dispatched, Dispatched::Waits(vec![Transport::Udp]));
    let (begin, dispatched) = world.order(6_000, start());
    assert!(matches!(dispatched, Dispatched::Refused(_)), "{dispatched:?}");
    assert_eq!(world.stage(begin).0, Stage::Refused);
    world.drain();
    world.heard(40_000, udp);
    assert_eq!(world.ids(udp), [stop]);
    let (begin, _) = world.order(40_500, start());
    assert_eq!(world.ids(udp), [begin]);
}

#[test]
fn a_vessel_that_is_heard_and_shows_nothing_is_given_the_stop_again_and_more_and_more_seldom() {
    let mut world = World::new();
    let udp = world.node(Transport::Udp);
    world.heard(0, udp);
    world.order(100, Order::Stop);
    world.drain();
    let mut given = Vec::new();
    for second in 1..=600 {
        world.tick(at(second * 1_000));
        world.heard(second * 1_000, udp);
        if !world.ids(udp).is_empty() {
            given.push(second);
        }
    }
    assert_eq!(given, [4, 11, 24, 49, 98, 195, 388]);
}

#[test]
fn a_link_that_is_down_gives_no_start_that_was_ordered_before_a_stop() {
    let mut world = World::new();
    let (link, udp) = (world.link(), world.node(Transport::Udp));
    world.hub.trust_transports([Transport::Udp]);
    world.heard(0, udp);
    world.hub.link_stands(at(0), link, true);
    world.order(500, start());
    world.hub.link_stands(at(1_000), link, false);
    world.drain();
    let (stop, dispatched) = world.order(2_000, Order::Stop);
    assert_eq!(dispatched, Dispatched::Sent(vec![Transport::Udp]));
    let out = world.drain();
    let told = out[&link][0].tag.unwrap();
    assert_eq!(
        (told.urgency, told.id, told.is_copy),
        (Urgency::Stop, Some(stop), true),
        "the link hears of it, and calls off what it holds"
    );
    assert_eq!(out[&udp][0].tag.unwrap().id, Some(stop));
}

#[test]
fn a_link_that_ended_without_a_word_is_no_way() {
    let mut world = World::new();
    let lost = world.link();
    world.hub.link_stands(at(0), lost, true);
    let again = world.link();
    let (_, dispatched) = world.order(1_000, Order::Stop);
    assert_eq!(dispatched, Dispatched::Waits(vec![]));
    world.drain();
    world.hub.link_stands(at(2_000), again, true);
    assert_eq!(world.ids(again).len(), 1);
}

#[test]
fn of_the_last_stop_it_stays_known_whether_it_arrived() {
    let mut world = World::new();
    let udp = world.node(Transport::Udp);
    world.heard(0, udp);
    let (stop, _) = world.order(500, Order::Stop);
    world.drain();
    for second in 1..=20 {
        world.tick(at(second * 1_000));
    }
    for number in 0..300 {
        let (question, _) = world.order(21_000 + number, Order::List);
        world.hub.orders_mut().refused(at(21_000 + number), question, api::Said::as_is("no"));
    }
    world.drain();
    world.heard(30_000, udp);
    assert_eq!(world.ids(udp), [stop]);
}

#[test]
fn a_start_waits_behind_a_stop_that_waits() {
    let mut world = World::new();
    let (_link, udp) = (world.link(), world.node(Transport::Udp));
    world.hub.trust_transports([Transport::Udp]);
    world.heard(0, udp);
    let (stop, _) = world.order(5_000, Order::Stop);
    let (begin, dispatched) = world.order(6_000, start());
    assert_eq!(dispatched, Dispatched::Waits(vec![]), "not into the same silence");
    world.drain();
    world.heard(9_000, udp);
    assert_eq!(world.ids(udp), [stop, begin]);
}

#[test]
fn what_a_console_says_into_the_silence_ends_no_stop() {
    let mut world = World::new();
    let (udp, console) = (world.node(Transport::Udp), world.node(Transport::Proxy));
    world.heard(0, udp);
    let (stop, _) = world.order(5_000, Order::Stop);
    world.drain();
    let control =
        PlanControl { op: PlanControlOp::Start, r#type: PlanControlType::Request, ..PlanControl::default() };
    let header =
        Header { src: Address(0x4001), dst: BOAT, timestamp: at(30_000).utc.seconds(), ..Header::default() };
    let packet = bytes::Bytes::from(Packet::new(header, control).encode().unwrap());
    world.hub.packets(at(30_000), console, [Incoming::from(packet)]);
    world.heard(40_000, udp);
    assert_eq!(world.ids(udp), [stop]);
}

#[test]
fn of_two_stops_the_newer_is_kept() {
    let mut world = World::new();
    let tcp = world.node(Transport::Tcp);
    world.heard(0, tcp);
    world.order(500, Order::Stop);
    let (newer, dispatched) = world.order(10_000, Order::Stop);
    assert_eq!(dispatched, Dispatched::Waits(vec![Transport::Tcp]));
    let left = world.drain().remove(&tcp).unwrap().pop().unwrap();
    world.hub.leave(tcp);
    let again = Telecommand { vessel: BOAT, tag: left.tag.unwrap(), packet: left.packet };
    world.hub.give_again(at(11_000), again);
    assert_eq!(world.stage(newer).0, Stage::Waiting);
    let again = world.node(Transport::Tcp);
    world.heard(560_000, again);
    assert_eq!(world.ids(again), [newer]);
}

#[test]
fn a_start_that_is_refused_ends_nothing_that_was_started_before_it() {
    let mut world = World::new();
    let udp = world.node(Transport::Udp);
    world.heard(0, udp);
    world.order(1_000, Order::Stop);
    world.order(2_000, start());
    let (refused, _) = world.order(3_000, start());
    world.hub.orders_mut().refused(at(3_500), refused, api::Said::as_is("no such plan"));
    world.drain();
    world.heard(40_000, udp);
    assert_eq!(world.ids(udp), []);
}

#[test]
fn what_nobody_was_given_has_no_effect() {
    let mut world = World::new();
    let udp = world.node(Transport::Udp);
    let (stop, dispatched) = world.order(1_000, Order::Stop);
    assert_eq!(dispatched, Dispatched::Waits(vec![]));
    world.says(2_000, udp, Aborted);
    assert_eq!(world.ids(udp), [stop], "it aborted for another reason, perhaps long ago");
    assert_eq!(world.stage(stop).0, Stage::Sent);
}
