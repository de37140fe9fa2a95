//! Another peer sends with the address of a linked vessel: an alarm of its own, until a minute after the last packet.

use bytes::Bytes;
use hub::{Incoming, Peer, PeerId, Role, Settings, Sources, Transport};
use imc::messages::Voltage;
use imc::{Address, Header, Packet};
use operations::Operations;
use operations::alarms::{Kind, ShoreState, State};
use units::{MonoTime, Now, UtcTime};

const BOAT: Address = Address(0x2810);

fn at(seconds: f64) -> Now {
    let us = (seconds * 1e6) as u64;
    Now { mono: MonoTime::from_micros(us), utc: UtcTime::from_micros(1_700_000_000_000_000 + us as i64) }
}

fn voltage(timestamp: f64) -> Incoming {
    let header = Header { timestamp, src: BOAT, ..Header::default() };
    Bytes::from(Packet::new(header, Voltage { value: 12.0 }).encode().unwrap()).into()
}

fn join(shore: &mut Operations, transport: Transport, sources: Sources) -> PeerId {
    let peer = Peer { transport, role: Role::Vessel, name: "192.0.2.66:40000".into(), sources };
    shore.hub_mut().join(at(0.0), peer)
}

fn watch(shore: &mut Operations, seconds: f64) -> Vec<(Kind, String)> {
    shore.watch(at(seconds), &ShoreState::default());
    shore.watch(at(seconds + 1.0), &ShoreState::default());
    let standing = shore.alarms().standing().filter(|alarm| alarm.key.vessel == Some(BOAT));
    standing.filter(|alarm| alarm.is_told()).map(|alarm| (alarm.key.kind, alarm.text.clone())).collect()
}

#[test]
fn who_speaks_in_a_vessels_name_is_an_alarm_that_ends() {
    for transport in [Transport::Proxy, Transport::Udp, Transport::Tcp] {
        let settings = Settings { address: Address(0x4F00), name: "shore".into(), active: false };
        let mut shore = Operations::new(settings);
        let link = join(&mut shore, Transport::Link, Sources::Only(vec![BOAT]));
        let forger = join(&mut shore, transport, Sources::Any);
        shore.hub_mut().packets(at(0.0), link, [voltage(1.0)]);
        assert_eq!(watch(&mut shore, 0.0), []);
        shore.hub_mut().packets(at(1.0), forger, [voltage(2.0)]);
        let alarms = watch(&mut shore, 1.5);
        let (kind, text) = &alarms[0];
        assert_eq!((alarms.len(), *kind), (1, Kind::OtherSource));
        assert!(text.contains(transport.name()) && text.contains("192.0.2.66:40000"), "{text}");
        shore.hub_mut().packets(at(70.0), link, [voltage(70.0)]);
        shore.watch(at(70.0), &ShoreState::default());
        shore.watch(at(76.0), &ShoreState::default());
        assert!(shore.alarms().standing().all(|alarm| alarm.state == State::Returned));
    }
}

#[test]
fn who_speaks_for_a_vessel_that_is_silent_is_an_alarm_too() {
    let settings = Settings { address: Address(0x4F00), name: "shore".into(), active: false };
    let mut shore = Operations::new(settings);
    join(&mut shore, Transport::Link, Sources::Only(vec![BOAT]));
    let forger = join(&mut shore, Transport::Tcp, Sources::Any);
    shore.hub_mut().packets(at(30.0), forger, [voltage(1.0)]);
    assert_eq!(watch(&mut shore, 30.0).first().map(|(kind, _)| *kind), Some(Kind::OtherSource));
}
