//! DUNE's echoes to its clients, and orders that people send twice.

use crate::support::{CONSOLE, Hub, OTTER, at, hub, join, packet, pass, voltage};
use bytes::Bytes;
use hub::{PeerId, Role, Transport};
use imc::Address;
use imc::messages::{Abort, Announce, Heartbeat, PlanControl, PlanControlOp, PlanControlType, RemoteActions};
use proptest::prelude::*;

/// A console at the vessel's own network, which the server does not know.
const NEAR: Address = Address(0x4002);

fn start(src: Address, time: f64) -> Bytes {
    let request =
        PlanControl { r#type: PlanControlType::Request, op: PlanControlOp::Start, ..PlanControl::default() };
    packet(src, OTTER, time, request)
}

/// A DUNE that is reached by TCP and UDP, and a console at the IMCProxy transport.
fn dune() -> (Hub, PeerId, PeerId, PeerId) {
    let mut hub = hub(false);
    let tcp = join(&mut hub, Transport::Tcp, Role::Vessel);
    let udp = join(&mut hub, Transport::Udp, Role::Vessel);
    let console = join(&mut hub, Transport::Proxy, Role::Console);
    assert_eq!(pass(&mut hub, at(0.0), tcp, &voltage(OTTER, Address::NULL, 1.0)), [console]);
    assert_eq!(pass(&mut hub, at(0.0), udp, &voltage(OTTER, Address::NULL, 1.0)), []);
    (hub, tcp, udp, console)
}

#[test]
fn what_a_vessel_echoes_never_goes_to_it_by_any_transport() {
    let (mut hub, tcp, udp, console) = dune();
    // A console that is connected to DUNE itself: DUNE forwards to all its clients, so to us by both transports.
    for (transport, time) in [(tcp, 2.0), (udp, 3.0)] {
        let said = start(NEAR, time);
        assert_eq!(pass(&mut hub, at(1.0), transport, &said), [], "a command that DUNE had already");
        let other = if transport == tcp { udp } else { tcp };
        assert_eq!(pass(&mut hub, at(1.0), other, &said), [], "and its copy");
    }
    // Nor broadcasts, which other consoles get.
    let announced = packet(NEAR, Address::ANNOUNCE, 4.0, Announce::default());
    assert_eq!(pass(&mut hub, at(1.0), tcp, &announced), [console]);
    let sticks = packet(NEAR, OTTER, 0.0, RemoteActions::default());
    assert_eq!(pass(&mut hub, at(1.0), udp, &sticks), [], "nor what carries no time");
}

#[test]
fn a_command_takes_one_way_and_an_abort_all() {
    let (mut hub, tcp, udp, console) = dune();
    assert_eq!(pass(&mut hub, at(1.0), console, &start(CONSOLE, 2.0)), [tcp]);
    assert_eq!(pass(&mut hub, at(1.0), tcp, &start(CONSOLE, 2.0)), [], "its echo");
    assert_eq!(pass(&mut hub, at(1.0), udp, &start(CONSOLE, 2.0)), [], "its other echo");
    assert_eq!(pass(&mut hub, at(1.0), console, &packet(CONSOLE, OTTER, 3.0, Abort)), [tcp, udp]);
    // By TCP nothing came for a while: the way that lives is taken.
    pass(&mut hub, at(9.0), udp, &voltage(OTTER, Address::NULL, 9.0));
    assert_eq!(pass(&mut hub, at(9.5), console, &start(CONSOLE, 9.5)), [udp]);
    assert_eq!(pass(&mut hub, at(9.5), console, &packet(CONSOLE, OTTER, 9.6, Heartbeat)), [tcp, udp]);
}

#[test]
fn a_command_from_the_proxy_transport_goes_to_a_vessel_there_and_nowhere_else() {
    let (mut hub, _, _, console) = dune();
    let relay = join(&mut hub, Transport::Proxy, Role::Console);
    pass(&mut hub, at(1.0), relay, &voltage(OTTER, CONSOLE, 1.0));
    assert_eq!(pass(&mut hub, at(1.5), console, &start(CONSOLE, 2.0)), [relay], "that protocol passes all");
    // From the relay behind which the vessel lives too it is an echo.
    assert_eq!(pass(&mut hub, at(1.5), relay, &start(NEAR, 3.0)), [console]);
}

#[test]
fn a_relay_on_another_machine_reaches_a_vessel_through_us() {
    let (mut hub, tcp, _, relay) = dune();
    // It gives back what it was given, as DUNEs and proxies do: that does not make it the vessel's home.
    for second in 1..20 {
        let time = f64::from(second);
        let telemetry = voltage(OTTER, Address::NULL, 10.0 + time);
        pass(&mut hub, at(time), tcp, &telemetry);
        pass(&mut hub, at(time), relay, &telemetry);
        assert_eq!(pass(&mut hub, at(time), relay, &start(CONSOLE, 100.0 + time)), [tcp]);
    }
}

#[test]
fn the_same_bytes_said_again_are_a_command_again() {
    let (mut hub, tcp, udp, console) = dune();
    let (abort, start) = (packet(CONSOLE, OTTER, 2.0, Abort), start(CONSOLE, 2.0));
    for time in [1.0, 1.0, 1.5, 8.0, 400.0] {
        pass(&mut hub, at(time), tcp, &voltage(OTTER, Address::NULL, 10.0 + time));
        let before = hub
            .fleet()
            .system(CONSOLE)
            .map_or(0, |system| system.all_series().map(|(_, series)| series.count()).sum());
        hub.drain_records();
        assert!(pass(&mut hub, at(time), console, &abort).contains(&tcp), "at {time} s");
        assert_eq!(pass(&mut hub, at(time), console, &start), [tcp], "at {time} s");
        assert_eq!(pass(&mut hub, at(time), udp, &start), [], "an echo stays one");
        let system = hub.fleet().system(CONSOLE).unwrap();
        assert_eq!(system.all_series().map(|(_, series)| series.count()).sum::<u64>(), before + 2);
        assert_eq!(hub.drain_records().len(), 2, "and is recorded each time");
    }
    // Telemetry is not.
    let telemetry = voltage(CONSOLE, OTTER, 5.0);
    assert_eq!(pass(&mut hub, at(400.0), console, &telemetry).len(), 1);
    assert_eq!(pass(&mut hub, at(401.0), console, &telemetry), []);
}

#[test]
fn a_console_that_comes_by_two_ways_commands_once() {
    let (mut hub, tcp, _, console) = dune();
    let other = join(&mut hub, Transport::Udp, Role::Console);
    assert_eq!(pass(&mut hub, at(1.0), console, &start(CONSOLE, 2.0)), [tcp]);
    assert_eq!(pass(&mut hub, at(1.1), other, &start(CONSOLE, 2.0)), []);
    // It lost the first way, connects again and says it again.
    hub.leave(console);
    assert_eq!(pass(&mut hub, at(1.2), other, &start(CONSOLE, 2.0)), [tcp]);
}

/// Two relays that pass everything to each other, both connected here: a command must not go round for ever.
#[test]
fn relays_in_a_circle_do_not_repeat_a_command_for_ever() {
    let (mut hub, tcp, _, one) = dune();
    let two = join(&mut hub, Transport::Proxy, Role::Console);
    let begun = start(CONSOLE, 2.0);
    let (mut told, mut waiting) = (0, vec![(0.0, one)]);
    while let Some((time, from)) = waiting.pop().filter(|(time, _)| *time < 60.0) {
        pass(&mut hub, at(time), tcp, &voltage(OTTER, Address::NULL, 10.0 + time));
        let heard = pass(&mut hub, at(time), from, &begun);
        told += heard.iter().filter(|peer| **peer == tcp).count();
        // What one of them hears the other one says to us a moment later.
        waiting.extend(heard.iter().filter(|peer| **peer == two).map(|_| (time + 0.05, one)));
    }
    assert!(told <= 20, "{told} times");
    let next = pass(&mut hub, at(60.0), one, &start(CONSOLE, 60.0));
    assert!(next.contains(&tcp), "another command passes: {next:?}");
}

proptest! {
    /// Several transports lead to one DUNE, and consoles order by any of them. DUNE gets each order once, and none that came
    /// from it.
    #[test]
    fn an_order_arrives_once(
        transports in prop::collection::vec(0_usize..3, 1..4),
        orders in prop::collection::vec((any::<prop::sample::Index>(), any::<bool>()), 1..20),
    ) {
        let mut hub = hub(false);
        let kinds = [Transport::Proxy, Transport::Tcp, Transport::Udp];
        let ways: Vec<PeerId> = transports.iter().map(|transport| join(&mut hub, kinds[*transport], Role::Vessel)).collect();
        let console = join(&mut hub, Transport::Proxy, Role::Console);
        for (order, (way, near)) in orders.into_iter().enumerate() {
            let time = 1.0 + order as f64;
            for (number, way) in ways.iter().enumerate() {
                pass(&mut hub, at(time), *way, &voltage(OTTER, Address(0x4100 + number as u16), time));
            }
            let (said, mut got) = (start(if near { NEAR } else { CONSOLE }, time), 0);
            if !near {
                let heard = pass(&mut hub, at(time), console, &said);
                got += heard.iter().filter(|peer| ways.contains(peer)).count();
                prop_assert_eq!(got, 1);
            }
            // DUNE echoes it to all its clients, this one first.
            let first = *way.get(&ways);
            for from in std::iter::once(first).chain(ways.iter().copied().filter(|one| *one != first)) {
                let heard = pass(&mut hub, at(time), from, &said);
                prop_assert!(heard.iter().all(|peer| !ways.contains(peer)), "{:?}", heard);
            }
        }
    }
}
