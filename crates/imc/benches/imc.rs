//! How fast packets are read and written on one core. `make bench` runs this.

#![expect(missing_docs, reason = "criterion's macros make public functions without any")]

use criterion::{BatchSize, Criterion, Throughput, criterion_group, criterion_main};
use imc::messages::{EstimatedState, Goto, PlanManeuver, PlanSpecification, PlanTransition};
use imc::{Address, Frame, Frames, Header, Packet, PacketView, ShortPayload};
use std::hint::black_box;

fn header() -> Header {
    Header { timestamp: 1_590_400_001.5, src: Address(0x2810), src_ent: 42, ..Header::default() }
}

fn estimated_state() -> EstimatedState {
    EstimatedState { lat: 1.107_245, lon: 0.180_973, height: 43.25, x: 12.5, psi: 1.57, ..Default::default() }
}

/// A plan of 120 waypoints, each with its transition.
fn plan() -> PlanSpecification {
    let waypoint = |at: usize| PlanManeuver {
        maneuver_id: format!("wp{at}").as_str().into(),
        data: Goto { lat: 1.107, lon: 0.18, speed: 1.2, ..Goto::default() }.into(),
        ..PlanManeuver::default()
    };
    let transition = |at: usize| PlanTransition {
        source_man: format!("wp{at}").as_str().into(),
        dest_man: format!("wp{}", at + 1).as_str().into(),
        conditions: "ManeuverIsDone".into(),
        ..PlanTransition::default()
    };
    PlanSpecification {
        plan_id: "survey".into(),
        start_man_id: "wp0".into(),
        maneuvers: (0..120).map(waypoint).collect(),
        transitions: (0..119).map(transition).collect(),
        ..PlanSpecification::default()
    }
}

/// A log of 32 MiB: the recorded vehicle's if it is there, else one of our own with the same mixture.
fn log() -> Vec<u8> {
    let recorded = testkit::shared("data/imc/dune_log_a/Data.lsf.gz").map(|path| {
        let mut bytes = Vec::new();
        let file = std::fs::File::open(path).expect("the recording can be opened");
        std::io::Read::read_to_end(&mut flate2::read::MultiGzDecoder::new(file), &mut bytes)
            .expect("the recording is gzip");
        bytes
    });
    let unit = recorded.unwrap_or_else(|| {
        let mut bytes = Vec::new();
        for at in 0..1_000_u32 {
            let state = imc::messages::EntityState { description: "active".into(), ..Default::default() };
            let rpm = imc::messages::Rpm { value: at as i16 };
            imc::encode_into(&mut bytes, &header(), &estimated_state()).expect("fits");
            imc::encode_into(&mut bytes, &header(), &state).expect("fits");
            imc::encode_into(&mut bytes, &header(), &rpm).expect("fits");
        }
        bytes
    });
    unit.repeat((32 << 20) / unit.len() + 1)
}

fn packets(c: &mut Criterion) {
    let mut bytes = Vec::new();
    imc::encode_into(&mut bytes, &header(), &estimated_state()).expect("fits");
    let mut group = c.benchmark_group("packet");
    group.throughput(Throughput::Elements(1));
    group.bench_function("EstimatedState decode, CRC checked", |b| {
        b.iter(|| {
            let view = PacketView::new(black_box(&bytes)).expect("whole");
            imc::decode::<EstimatedState>(&view).expect("whole")
        });
    });
    group.bench_function("EstimatedState decode to Packet, CRC checked", |b| {
        b.iter(|| Packet::decode(black_box(&bytes)).expect("whole"));
    });
    let (state, mut out) = (estimated_state(), Vec::with_capacity(256));
    group.bench_function("EstimatedState encode", |b| {
        b.iter(|| {
            out.clear();
            imc::encode_into(&mut out, black_box(&header()), black_box(&state)).expect("fits");
            out.len()
        });
    });
    group.bench_function("header view of EstimatedState, CRC checked", |b| {
        b.iter(|| {
            let view = PacketView::new(black_box(&bytes)).expect("whole");
            (view.id(), view.src(), view.dst())
        });
    });
    let mut plan_bytes = Vec::new();
    imc::encode_into(&mut plan_bytes, &header(), &plan()).expect("fits");
    group.bench_function("plan of 120 waypoints decode, CRC checked", |b| {
        b.iter_batched(
            || PacketView::new(black_box(&plan_bytes)).expect("whole"),
            |view| imc::decode::<PlanSpecification>(&view).expect("whole"),
            BatchSize::SmallInput,
        );
    });
    group.bench_function("plan of 120 waypoints decode, every element looked at", |b| {
        b.iter_batched(
            || PacketView::new(black_box(&plan_bytes)).expect("whole"),
            |view| {
                let plan = imc::decode::<PlanSpecification>(&view).expect("whole").expect("a plan");
                let lats = plan.maneuvers.of::<PlanManeuver>().filter_map(|node| node.data.of::<Goto>());
                let ends = plan.transitions.of::<PlanTransition>().filter(|next| !next.dest_man.is_empty());
                (lats.map(|goto| goto.lat).sum::<f64>(), ends.count())
            },
            BatchSize::SmallInput,
        );
    });
    group.finish();
}

fn streams(c: &mut Criterion) {
    let log = log();
    let mut group = c.benchmark_group("stream");
    group.throughput(Throughput::Bytes(1 << 16)).bench_function("CRC of 64 KiB", |b| {
        b.iter(|| imc::crc16(black_box(&log[..1 << 16])));
    });
    group.throughput(Throughput::Bytes(log.len() as u64)).sample_size(20);
    group.bench_function("log, header of each packet, CRC checked", |b| {
        b.iter(|| {
            Frames::new(black_box(&log))
                .map(|frame| match frame {
                    Frame::Packet { view, .. } => u64::from(view.id()),
                    Frame::Damage(_) => 0,
                })
                .sum::<u64>()
        });
    });
    group.bench_function("log, full decode, CRC checked", |b| {
        b.iter(|| {
            let packets = Frames::new(black_box(&log)).filter(|frame| match frame {
                Frame::Packet { view, .. } => Packet::from_view(view, ShortPayload::default()).is_ok(),
                Frame::Damage(_) => false,
            });
            packets.count()
        });
    });
    group.finish();
}

criterion_group!(benches, packets, streams);
criterion_main!(benches);
