//! Simulated boats that send IMC, and their history.

use bytes::Bytes;
use hub::{Incoming, Peer, Role, Sources, Transport};
use imc::messages::{
    Announce, EntityList, EntityListOp, EstimatedState, LogBookEntry, Message, SystemType, Voltage,
};
use imc::{Address, Header, Packet};
use shore::router::{Connection, Router};
use std::path::Path;
use std::sync::Arc;
use store::{Accepted, Store};
use units::UtcTime;

/// The address of boat 0; the others follow.
pub(crate) const FIRST: u16 = 0x0814;
const NOBODY: u8 = 255;

/// Sends packets of boats.
#[derive(Clone)]
pub(crate) struct Boats(Arc<Connection>);

impl Boats {
    /// Connects to the hub.
    pub(crate) async fn join(relay: &Router) -> Self {
        let peer = Peer {
            transport: Transport::Link,
            role: Role::Vessel,
            name: "boats".to_owned(),
            sources: Sources::Any,
        };
        Self(Arc::new(relay.join(peer, 1 << 20).await.unwrap()))
    }

    pub(crate) async fn say(&self, packets: Vec<Bytes>) {
        self.0.give(packets.into_iter().map(Incoming::from).collect()).await.unwrap();
    }

    /// Sends packets over a lane of the link.
    pub(crate) async fn give(&self, packets: Vec<Incoming>) {
        self.0.give(packets).await.unwrap();
    }

    /// Begins to read again after the queue was full.
    pub(crate) async fn reopen(&self) {
        assert!(self.0.outbox.take().await.is_err());
        self.0.outbox.reopen();
    }

    /// The next packet with this id for the boats.
    pub(crate) async fn heard(&self, id: u16) -> Bytes {
        loop {
            let packets = self.0.outbox.take_packets().await.unwrap();
            let wanted = |packet: &Bytes| imc::PacketView::new(packet).is_ok_and(|view| view.id() == id);
            if let Some(packet) = packets.into_iter().find(wanted) {
                return packet;
            }
        }
    }

    /// The next batch of packets for the boats.
    pub(crate) async fn heard_all(&self) -> Vec<Bytes> {
        self.0.outbox.take_packets().await.unwrap().into_iter().collect()
    }

    /// All packets with this id for the boats in the next batch.
    pub(crate) async fn heard_together(&self, id: u16) -> Vec<Bytes> {
        loop {
            let mut packets = self.0.outbox.take_packets().await.unwrap();
            packets.retain(|packet| imc::PacketView::new(packet).is_ok_and(|view| view.id() == id));
            if !packets.is_empty() {
                return packets.into_iter().collect();
            }
        }
    }

    /// Lets two boats and a system without a name send ten times a second, for the duration of the test. A third boat sends
    /// once.
    pub(crate) fn sail(&self) {
        let boats = self.clone();
        tokio::spawn(async move {
            boats.say(boat(2, shore::clock::now())).await;
            let mut interval = tokio::time::interval(std::time::Duration::from_millis(100));
            loop {
                interval.tick().await;
                let now = shore::clock::now();
                boats.say(boat(0, now)).await;
                boats.say(boat(1, now)).await;
                boats.say(vec![packet(3, NOBODY, now, Voltage { value: 12.0 })]).await;
            }
        });
    }
}

/// All packets of a boat at this time: it sails a circle of 300 m around a place given by its number. Among them are two
/// series of Voltage, and one event, the last.
pub(crate) fn boat(number: u16, now: UtcTime) -> Vec<Bytes> {
    let (lat_deg, lon_deg, course_rad) = place(number, now);
    let announce = Announce {
        sys_name: format!("otter-{number}").into(),
        sys_type: SystemType::Usv,
        owner: 0xFFFF,
        ..Announce::default()
    };
    let entities =
        EntityList { op: EntityListOp::Report, list: "Navigation=1;<b>Battery</b>=2;Spare=3".into() };
    let state = EstimatedState {
        lat: lat_deg.to_radians(),
        lon: lon_deg.to_radians(),
        psi: course_rad as f32,
        u: 1.5,
        vx: 1.5 * course_rad.cos() as f32,
        vy: 1.5 * course_rad.sin() as f32,
        ..EstimatedState::default()
    };
    let entry = LogBookEntry { text: "<img src=x onerror=alert(1)>".into(), ..LogBookEntry::default() };
    vec![
        packet(number, NOBODY, now, announce),
        packet(number, NOBODY, now, entities),
        packet(number, 1, now, state),
        voltage(number, now),
        packet(number, 3, now, Voltage { value: f32::NAN }),
        event(number, now, entry),
    ]
}

/// The battery's voltage at this time.
pub(crate) fn voltage(number: u16, now: UtcTime) -> Bytes {
    packet(number, 2, now, Voltage { value: 24.0 + (now.micros() % 1_000_000) as f32 / 1e6 })
}

/// An event at this time.
pub(crate) fn event(number: u16, now: UtcTime, entry: LogBookEntry) -> Bytes {
    packet(number, NOBODY, now, entry)
}

/// A message of a boat's entity.
pub(crate) fn packet(number: u16, src_ent: u8, now: UtcTime, message: impl Into<Message>) -> Bytes {
    let src = Address(FIRST + number);
    let header = Header { timestamp: now.seconds(), src, src_ent, dst: Address(0xFFFF), dst_ent: NOBODY };
    Packet::new(header, message).encode().unwrap().into()
}

/// Latitude and longitude in degrees and the course of a boat.
fn place(number: u16, now: UtcTime) -> (f64, f64, f64) {
    let seconds = (now.micros() % 600_000_000) as f64 / 1e6;
    let along = seconds / 600.0 * std::f64::consts::TAU + f64::from(number);
    let (lat, lon) = (63.44 + 0.004 * f64::from(number), 10.40 + 0.006 * f64::from(number));
    (lat + 0.0027 * along.cos(), lon + 0.006 * along.sin(), along + std::f64::consts::FRAC_PI_2)
}

/// Fills a data folder with the last hour of the first three boats, a position every nine seconds, as an earlier server
/// would have.
pub(crate) fn an_hour(data: &Path, now: UtcTime) {
    let mut store = Store::open(data).unwrap();
    for step in (0..400).rev() {
        let then = UtcTime::from_micros(now.micros() - step * 9_000_000);
        for packet in (0..3).flat_map(|number| boat(number, then)) {
            store
                .accept(&Accepted {
                    packet: &packet,
                    received: then,
                    transport: store::Transport::Tcp,
                    link: None,
                })
                .unwrap();
        }
    }
    store.close().unwrap();
}
