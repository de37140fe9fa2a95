//! Which peer gets which packet, by every transport.

use crate::support::{CONSOLE, OTTER, SERVER, at, drain, hub, join, packet, pass, voltage};
use bytes::Bytes;
use hub::{Incoming, Lane, LinkSeq, Peer, PeerId, Role, Sources, Transport};
use imc::messages::{self, Heartbeat};
use imc::{Address, Header, Packet, PacketView};
use proptest::prelude::*;

#[test]
fn the_proxy_transport_passes_everything_to_all_others_and_never_back() {
    let mut hub = hub(false);
    let [a, b, c] = [(); 3].map(|()| join(&mut hub, Transport::Proxy, Role::Console));
    for dst in [Address::NULL, Address::BROADCAST, CONSOLE, SERVER, Address(0x1234)] {
        let telemetry = voltage(OTTER, dst, f64::from(dst.0));
        assert_eq!(pass(&mut hub, at(1.0), a, &telemetry), [b, c], "{dst:?}");
    }
    assert_eq!(pass(&mut hub, at(2.0), c, &voltage(CONSOLE, OTTER, 5.0)), [a, b]);
}

#[test]
fn a_command_goes_to_where_its_vessel_lives() {
    let mut hub = hub(false);
    let console = join(&mut hub, Transport::Proxy, Role::Console);
    let vessel = join(&mut hub, Transport::Link, Role::Vessel);
    let other = join(&mut hub, Transport::Link, Role::Vessel);
    assert_eq!(pass(&mut hub, at(0.0), vessel, &voltage(OTTER, Address::NULL, 1.0)), [console]);
    assert_eq!(pass(&mut hub, at(0.1), other, &voltage(Address(0x2811), Address::NULL, 1.0)), [console]);
    assert_eq!(pass(&mut hub, at(0.2), console, &packet(CONSOLE, OTTER, 2.0, messages::Abort)), [vessel]);
    assert_eq!(pass(&mut hub, at(0.3), console, &packet(CONSOLE, Address(0x2999), 3.0, messages::Abort)), []);
    assert_eq!(hub.counters().unroutable, 1);
    // Broadcasts of consoles reach the vessels; broadcasts of vessels do not fill other vessels' radios.
    assert_eq!(
        pass(&mut hub, at(0.4), console, &packet(CONSOLE, Address::NULL, 4.0, Heartbeat)),
        [vessel, other]
    );
    // An answer goes back to the console alone.
    assert_eq!(
        pass(&mut hub, at(0.5), vessel, &packet(OTTER, CONSOLE, 5.0, messages::PlanControl::default())),
        [console]
    );
    // A vessel that was silent for long lives nowhere.
    assert_eq!(pass(&mut hub, at(500.0), console, &packet(CONSOLE, OTTER, 6.0, messages::Abort)), []);
}

#[test]
fn a_vessel_heard_by_two_transports_is_relayed_once_and_never_to_itself() {
    let mut hub = hub(false);
    let proxy = join(&mut hub, Transport::Proxy, Role::Console);
    let tcp = join(&mut hub, Transport::Tcp, Role::Vessel);
    let console = join(&mut hub, Transport::Udp, Role::Console);
    let state = voltage(OTTER, Address::NULL, 1.0);
    assert_eq!(pass(&mut hub, at(0.0), proxy, &state), [console]);
    assert_eq!(pass(&mut hub, at(0.1), tcp, &state), [], "it was here before");
    assert_eq!(pass(&mut hub, at(0.2), tcp, &voltage(OTTER, Address::NULL, 2.0)), [console]);
    assert_eq!(hub.drain_records().len(), 2);
    assert_eq!(hub.counters().duplicates, 1);
    // A command takes both ways; the vessel recognises copies by request id.
    assert_eq!(pass(&mut hub, at(0.3), console, &packet(CONSOLE, OTTER, 3.0, messages::Abort)), [proxy, tcp]);
}

#[test]
fn copies_for_several_consoles_are_relayed_each_and_recorded_once() {
    let mut hub = hub(false);
    let vessel = join(&mut hub, Transport::Proxy, Role::Console);
    let one = join(&mut hub, Transport::Proxy, Role::Console);
    for console in 0x4001..0x4006 {
        assert_eq!(pass(&mut hub, at(0.0), vessel, &voltage(OTTER, Address(console), 1.0)), [one]);
    }
    assert_eq!(hub.drain_records().len(), 1);
    assert_eq!(hub.counters().duplicates, 4);
}

#[test]
fn a_token_speaks_for_its_own_vessel_only() {
    let mut hub = hub(false);
    let listener = join(&mut hub, Transport::Proxy, Role::Console);
    let sources = Sources::Only(vec![OTTER]);
    let vessel =
        hub.join(at(0.0), Peer { transport: Transport::Link, role: Role::Vessel, name: "o".into(), sources });
    assert_eq!(pass(&mut hub, at(0.0), vessel, &voltage(OTTER, Address::NULL, 1.0)), [listener]);
    assert_eq!(pass(&mut hub, at(0.0), vessel, &voltage(CONSOLE, Address::NULL, 1.0)), []);
    assert_eq!((hub.counters().refused, hub.drain_records().len()), (1, 1));
    // What it recorded from others is kept all the same, but not routed.
    let heard = packet(CONSOLE, OTTER, 2.0, messages::Abort);
    let link = Some(LinkSeq { stream: 7, seq: 1 });
    hub.packets(at(0.0), vessel, [Incoming { packet: heard, link, lane: Lane::Present }]);
    assert!(drain(&mut hub).is_empty() && hub.fleet().system(CONSOLE).is_none());
    assert_eq!((hub.counters().refused, hub.drain_records().len()), (1, 1));
}

#[test]
fn rubbish_and_tails_are_nobodys_business() {
    let mut hub = hub(false);
    let [a, b] = [(); 2].map(|()| join(&mut hub, Transport::Proxy, Role::Console));
    let good = voltage(OTTER, Address::NULL, 1.0);
    let mut bad_crc = good.to_vec();
    bad_crc[21] ^= 1;
    for rubbish in
        [Bytes::new(), Bytes::from_static(b"hello"), good.slice(..30.min(good.len() - 1)), bad_crc.into()]
    {
        assert_eq!(pass(&mut hub, at(0.0), a, &rubbish), []);
    }
    assert_eq!(hub.counters().damaged, 4);
    hub.packets(at(0.0), a, [Incoming::from(Bytes::from([good.as_ref(), b"tail"].concat()))]);
    assert_eq!(drain(&mut hub)[&b], [good]);
}

#[test]
fn lanes_of_the_link() {
    let mut hub = hub(false);
    let console = join(&mut hub, Transport::Proxy, Role::Console);
    let vessel = join(&mut hub, Transport::Link, Role::Vessel);
    let live = voltage(OTTER, Address::NULL, 100.0);
    let mut give = |packet: &Bytes, seq: Option<u64>, lane| {
        let link = seq.map(|seq| LinkSeq { stream: 7, seq });
        hub.packets(at(100.0), vessel, [Incoming { packet: packet.clone(), link, lane }]);
        let heard = drain(&mut hub).contains_key(&console);
        (heard, hub.drain_records().iter().map(|record| record.link.unwrap().seq).collect::<Vec<_>>())
    };
    // Ahead of the records, then the backlog, then the record of what was seen already.
    assert_eq!(give(&live, None, Lane::Live), (true, vec![]));
    assert_eq!(give(&voltage(OTTER, Address::NULL, 50.0), Some(1), Lane::Backlog), (false, vec![1]));
    assert_eq!(give(&live, Some(2), Lane::Present), (false, vec![2]));
    assert_eq!(give(&voltage(OTTER, Address::NULL, 101.0), Some(3), Lane::Present), (true, vec![3]));
    let (key, series) = hub.fleet().system(OTTER).unwrap().latest(251).unwrap();
    assert_eq!((key.entity, series.packet()), (3, voltage(OTTER, Address::NULL, 101.0).as_ref()));
}

#[test]
fn a_detection_of_the_past_is_told_once_and_changes_nothing_of_the_present() {
    let mut hub = hub(false);
    let console = join(&mut hub, Transport::Proxy, Role::Console);
    let vessel = join(&mut hub, Transport::Link, Role::Vessel);
    let tag = |trans_id, seconds: f64| -> Bytes {
        let header =
            Header { timestamp: seconds, src: OTTER, src_ent: 9, dst: Address::NULL, ..Header::default() };
        let tag = messages::TBRFishTag { trans_id, ..messages::TBRFishTag::default() };
        Packet::new(header, tag).encode().unwrap().into()
    };
    let mut give = |packet: &Bytes, seq: Option<u64>, lane| {
        let link = seq.map(|seq| LinkSeq { stream: 7, seq });
        hub.packets(at(100.0), vessel, [Incoming { packet: packet.clone(), link, lane }]);
        let told = drain(&mut hub).contains_key(&console);
        let changes = hub.fleet().changes(0, 100, |_, _| true);
        (told, changes.events.iter().map(|event| event.late).collect::<Vec<_>>())
    };
    let (live, old) = (tag(1, 100.0), tag(2, 50.0));
    assert_eq!(give(&live, None, Lane::Live), (true, vec![false]));
    assert_eq!(
        give(&old, Some(1), Lane::Backlog),
        (false, vec![false, true]),
        "no console takes it for the present"
    );
    assert_eq!(give(&live, Some(2), Lane::Backlog), (false, vec![false, true]), "it was told live");
    // Other late messages are in the history only.
    give(&voltage(OTTER, Address::NULL, 50.0), Some(3), Lane::Backlog);
    assert_eq!(hub.fleet().changes(0, 100, |_, _| true).events.len(), 2);
    let (_, series) = hub.fleet().system(OTTER).unwrap().latest(2_007).unwrap();
    assert_eq!(series.packet(), live.as_ref());
    assert_eq!(hub.drain_records().len(), 3);
}

#[test]
fn the_server_keeps_vessels_sending() {
    let mut hub = hub(true);
    hub.set_services("imc+udp://127.0.0.1:6001/");
    let proxy = join(&mut hub, Transport::Proxy, Role::Console);
    let link = join(&mut hub, Transport::Link, Role::Vessel);
    for peer in [proxy, link] {
        let first = &drain(&mut hub);
        if let Some(packets) = first.get(&peer) {
            let announce = Packet::decode(&packets[0]).unwrap();
            let announce = announce.get::<messages::Announce>().unwrap();
            assert_eq!(announce.sys_name.to_str_lossy(), "shore");
        }
    }
    hub.packets(at(0.0), proxy, [Incoming::from(voltage(OTTER, Address::NULL, 1.0))]);
    drain(&mut hub);
    let mut heard: Vec<(PeerId, u16)> = Vec::new();
    for second in 1..=12 {
        hub.packets(
            at(f64::from(second)),
            proxy,
            [Incoming::from(voltage(OTTER, Address::NULL, f64::from(second)))],
        );
        hub.tick(at(f64::from(second)));
        for (peer, packets) in drain(&mut hub) {
            heard.extend(packets.iter().map(|packet| (peer, PacketView::new(packet).unwrap().id())));
        }
    }
    let count = |peer, id| heard.iter().filter(|entry| **entry == (peer, id)).count();
    assert_eq!(count(proxy, 150), 12, "a heartbeat each second to where the vessel lives");
    assert_eq!(count(link, 150), 0);
    assert_eq!(count(proxy, 5), 2, "its entities are asked for until they are known");
    assert_eq!((count(proxy, 151), count(link, 151)), (2, 2), "an announcement each ten seconds");
}

proptest! {
    /// Whatever comes from wherever: never back, each delivery is the original, and the sum is what the counters say.
    #[test]
    fn nothing_comes_back(
        transports in prop::collection::vec((0_usize..4, any::<bool>()), 2..6),
        packets in prop::collection::vec((any::<prop::sample::Index>(), 0_u16..6, 0_u16..8, 0_u32..20), 1..60),
    ) {
        let mut hub = hub(false);
        let kinds = [Transport::Proxy, Transport::Link, Transport::Tcp, Transport::Udp];
        let peers: Vec<PeerId> = transports
            .iter()
            .map(|(transport, console)| {
                join(&mut hub, kinds[*transport], if *console { Role::Console } else { Role::Vessel })
            })
            .collect();
        let systems = [0x2810, 0x2811, 0x4001, 0x4002, 0x0801, 0x8001, 0xFFFF, 0xFFF0].map(Address);
        let mut delivered = 0;
        for (from, src, dst, time) in packets {
            let from = *from.get(&peers);
            let bytes = voltage(systems[usize::from(src)], systems[usize::from(dst)], f64::from(time) + 1.0);
            let heard = pass(&mut hub, at(f64::from(time)), from, &bytes);
            prop_assert!(!heard.contains(&from));
            delivered += heard.len() as u64;
        }
        prop_assert_eq!(hub.counters().delivered, delivered);
    }

    /// No bytes make it panic, and only whole packets pass.
    #[test]
    fn any_bytes(bytes in prop::collection::vec(any::<u8>(), 0..200), cut in 0_usize..40) {
        let mut hub = hub(true);
        let a = join(&mut hub, Transport::Proxy, Role::Console);
        join(&mut hub, Transport::Link, Role::Vessel);
        let mut nearly = packet(OTTER, CONSOLE, 1.0, messages::Announce::default()).to_vec();
        nearly.truncate(cut);
        nearly.extend(&bytes);
        hub.packets(at(0.0), a, [Incoming::from(Bytes::from(bytes)), Incoming::from(Bytes::from(nearly))]);
        hub.tick(at(1.0));
    }
}
