//! Who is trusted when several peers send with one vessel's address.

use crate::support::{CONSOLE, Hub, OTTER, at, drain, hub, join, packet, pass, voltage};
use hub::{Contradiction, Incoming, Lane, LinkSeq, Peer, PeerId, Role, Sources, Transport};
use imc::Address;
use imc::messages::{Abort, Announce, EstimatedState, SystemType};

fn link(hub: &mut Hub) -> PeerId {
    let sources = Sources::Only(vec![OTTER]);
    hub.join(at(0.0), Peer { transport: Transport::Link, role: Role::Vessel, name: "link".into(), sources })
}

fn other(hub: &mut Hub, transport: Transport, role: Role) -> PeerId {
    hub.join(at(0.0), Peer { transport, role, name: "192.0.2.66:40000".into(), sources: Sources::Any })
}

#[test]
fn a_vessel_that_has_a_link_is_believed_there_only_and_who_contradicts_is_told() {
    for transport in [Transport::Proxy, Transport::Udp, Transport::Tcp] {
        let mut hub = hub(false);
        let link = link(&mut hub);
        let console = join(&mut hub, Transport::Proxy, Role::Console);
        let forger = other(&mut hub, transport, Role::Vessel);
        let said = packet(
            OTTER,
            Address::ANNOUNCE,
            1.0,
            Announce { sys_type: SystemType::Usv, ..Announce::default() },
        );
        assert_eq!(pass(&mut hub, at(0.0), link, &said), [console]);
        assert_eq!(hub.contradictions(at(0.0).mono), []);
        hub.drain_records();
        let forged =
            packet(OTTER, Address::NULL, 2.0, EstimatedState { lat: 1.0, ..EstimatedState::default() });
        assert_eq!(pass(&mut hub, at(1.0), forger, &forged), [], "{transport}");
        assert!(hub.fleet().system(OTTER).unwrap().latest(350).is_none() && hub.drain_records().is_empty());
        assert_eq!(hub.counters().refused, 1);
        // Nor does it get what is for the vessel.
        assert_eq!(
            pass(&mut hub, at(1.1), console, &packet(CONSOLE, OTTER, 3.0, Abort))
                .into_iter()
                .filter(|peer| *peer == forger)
                .count(),
            usize::from(transport == Transport::Proxy)
        );
        let peer = "192.0.2.66:40000".to_owned();
        assert_eq!(hub.contradictions(at(1.5).mono), [Contradiction { vessel: OTTER, transport, peer }]);
        // The vessel's own packet, sent back by another peer, contradicts nothing.
        pass(&mut hub, at(70.0), link, &voltage(OTTER, Address::NULL, 70.0));
        pass(&mut hub, at(70.0), forger, &voltage(OTTER, Address::NULL, 70.0));
        assert_eq!(hub.contradictions(at(70.0).mono), []);
    }
}

#[test]
fn who_contradicts_a_vessel_that_is_silent_is_told_too() {
    let mut hub = hub(false);
    link(&mut hub);
    let forger = other(&mut hub, Transport::Tcp, Role::Vessel);
    pass(&mut hub, at(30.0), forger, &voltage(OTTER, Address::NULL, 1.0));
    assert_eq!(hub.contradictions(at(30.0).mono).len(), 1);
}

#[test]
fn a_transport_that_is_trusted_is_believed_beside_the_link() {
    let mut hub = hub(false);
    hub.trust_transports([Transport::Tcp]);
    link(&mut hub);
    let console = join(&mut hub, Transport::Proxy, Role::Console);
    let tcp = other(&mut hub, Transport::Tcp, Role::Vessel);
    assert_eq!(pass(&mut hub, at(0.0), tcp, &voltage(OTTER, Address::NULL, 1.0)), [console]);
    assert_eq!(hub.contradictions(at(1.0).mono), []);
}

#[test]
fn who_has_a_link_is_known_before_it_comes_in_and_others_are_believed_anywhere() {
    let mut hub = hub(false);
    let console = join(&mut hub, Transport::Proxy, Role::Console);
    let tcp = other(&mut hub, Transport::Tcp, Role::Vessel);
    assert_eq!(pass(&mut hub, at(0.0), tcp, &voltage(OTTER, Address::NULL, 1.0)), [console]);
    hub.set_linked([OTTER].into());
    assert_eq!(pass(&mut hub, at(1.0), tcp, &voltage(OTTER, Address::NULL, 2.0)), []);
    assert_eq!(
        pass(&mut hub, at(1.0), console, &packet(CONSOLE, OTTER, 3.0, Abort)),
        [],
        "it lives there no more"
    );
    assert_eq!(pass(&mut hub, at(1.0), tcp, &voltage(Address(0x2811), Address::NULL, 2.0)), [console]);
    // Its token is revoked.
    hub.set_linked([].into());
    assert_eq!(pass(&mut hub, at(2.0), tcp, &voltage(OTTER, Address::NULL, 4.0)), [console]);
    // What a vessel recorded before it lost its link is a record still.
    let link = link(&mut hub);
    let record = Incoming {
        packet: voltage(OTTER, Address::NULL, 0.5),
        link: Some(LinkSeq { stream: 7, seq: 1 }),
        lane: Lane::Backlog,
    };
    hub.drain_records();
    hub.packets(at(3.0), link, [record]);
    assert_eq!((drain(&mut hub).len(), hub.drain_records().len()), (0, 1));
}
