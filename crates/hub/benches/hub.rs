//! How fast the hub relays, on one core and without sockets.

#![expect(missing_docs, reason = "criterion's macros make public functions without any")]

use bytes::Bytes;
use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use hub::{Hub, Incoming, Peer, PeerId, Role, Settings, Sources, Transport};
use imc::messages::EstimatedState;
use imc::{Address, Header, Packet};
use units::{MonoTime, Now, UtcTime};

const BATCH: u32 = 1_000;

fn now(us: u64) -> Now {
    Now { mono: MonoTime::from_micros(us), utc: UtcTime::from_micros(us as i64) }
}

fn packets(from_us: u64) -> Vec<Bytes> {
    let packet = |n: u32| {
        let timestamp = from_us as f64 / 1e6 + f64::from(n) / 1e3;
        let header = Header { timestamp, src: Address(0x2810), ..Header::default() };
        Packet::new(header, EstimatedState::default()).encode().unwrap_or_default().into()
    };
    (0..BATCH).map(packet).collect()
}

fn relay(c: &mut Criterion) {
    let mut group = c.benchmark_group("hub/relay EstimatedState");
    for receivers in [1, 20] {
        let settings = Settings { address: Address(0x4F00), name: "shore".into(), active: false };
        let mut hub = Hub::new(settings, ());
        let peer = |_| {
            let name = String::new();
            hub.join(
                now(0),
                Peer { transport: Transport::Proxy, role: Role::Console, name, sources: Sources::Any },
            )
        };
        let peers: Vec<PeerId> = (0..=receivers).map(peer).collect();
        group.throughput(Throughput::Elements(u64::from(BATCH) * receivers));
        let mut us = 0;
        group.bench_function(format!("deliveries, one to {receivers}"), |bencher| {
            bencher.iter_batched(
                || {
                    us += 1_000_000;
                    (us, packets(us))
                },
                |(us, packets)| {
                    hub.packets(now(us), peers[0], packets.into_iter().map(Incoming::from));
                    let mut out = Vec::new();
                    hub.drain_deliveries(|peer, packets| out.push((peer, packets)));
                    (out, hub.drain_records())
                },
                BatchSize::PerIteration,
            );
        });
    }
}

criterion_group!(benches, relay);
criterion_main!(benches);
