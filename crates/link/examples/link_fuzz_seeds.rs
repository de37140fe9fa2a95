//! Writes the seeds of the fuzz target into `fuzz/seeds`: `cargo run -p link --example link_fuzz_seeds`.

use bytes::Bytes;
use link::frame::{
    Ack, Bye, Command, Frame, Heartbeat, Receipt, Stamp, VERSION, Verdict, Welcome, encode, message,
};
use link::{
    ByeCode, Capabilities, Gap, GapReason, Hello, Lease, Packer, Record, WayHello, WayReport, WayState,
    WaysReport, Why, pack,
};
use std::fs;
use std::path::Path;
use units::{MonoTime, UtcTime};

fn frames() -> Vec<Frame> {
    let stamp = Stamp {
        mono: MonoTime::from_micros(5_000_000),
        utc: UtcTime::from_micros(1_790_000_000_000_000),
        echo: MonoTime::from_micros(4_000_000),
        echo_received: MonoTime::from_micros(4_900_000),
    };
    let record = |seq| Record {
        seq,
        recorded: UtcTime::from_micros(1_790_000_000_000_000 + seq as i64 * 10_000),
        packet: Bytes::from(vec![seq as u8; 60]),
    };
    let records: Vec<Record> = (0..8).map(record).collect();
    let hello = Hello {
        version: VERSION,
        oldest_version: VERSION,
        capabilities: Capabilities::ALL,
        address: 0x2810,
        incarnation: 3,
        attempt: 9,
        stream: 77,
        first: 2,
        next: 100,
        stamp,
        name: "ntnu-otter-01".to_owned(),
        software: "lutra-agent".to_owned(),
        way: Some(WayHello { index: 1, metered: true, name: "4g".to_owned() }),
    };
    let (version, capabilities) = (VERSION, Capabilities::ALL);
    vec![
        Frame::Hello(hello),
        Frame::Welcome(Welcome {
            version,
            capabilities,
            resume: 5,
            window_bytes: 1 << 20,
            stamp,
            run: Some(3),
        }),
        Frame::Records(pack(&mut Packer::new(true), &records)),
        Frame::Records(pack(&mut Packer::new(false), &records)),
        Frame::Live(pack(&mut Packer::new(true), &records)),
        Frame::Gap(Gap { from: 0, to: 9, since: stamp.utc, until: stamp.utc, reason: GapReason::SpoolFull }),
        Frame::Ack(Ack { received: 9, durable: 5, bytes: 1000 }),
        Frame::Command(Command {
            id: 1,
            sent: stamp.mono,
            ttl_ms: 500,
            lease: 7,
            order: 0,
            packet: vec![1; 22].into(),
        }),
        Frame::Command(Command {
            id: 2,
            sent: stamp.mono,
            ttl_ms: 500,
            lease: 7,
            order: 1_790_000_000_000,
            packet: vec![1; 22].into(),
        }),
        Frame::Receipt(Receipt {
            id: 1,
            verdict: Verdict::Refused,
            text: "the queue is full".to_owned(),
            order: 9,
        }),
        Frame::Heartbeat(Heartbeat { stamp, bytes: 1, next: 9, durable: 2, waiting_us: 3, kept_us: 4 }),
        Frame::Bye(Bye { code: ByeCode::Ending, text: "the program ends".to_owned() }),
        Frame::Lease(Lease { epoch: 7, ttl_ms: 30_000, holder: "nils".to_owned(), number: 4 }),
        Frame::Ways(ways()),
    ]
}

fn ways() -> WaysReport {
    let way = |name: &str, state| WayReport {
        name: name.to_owned(),
        state,
        round_trip_us: 60_000,
        today_bytes: 7_000_000,
        daily_bytes: 50_000_000,
        ..WayReport::default()
    };
    let ways = vec![way("radio", WayState::Suspect), way("4g", WayState::Up)];
    WaysReport { choice: 3, live: Some(1), live_why: Why::Failover, ways, ..WaysReport::default() }
}

fn main() -> std::io::Result<()> {
    let folder = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../fuzz/seeds/link_message"));
    fs::create_dir_all(folder)?;
    let mut all = Vec::new();
    for (at, frame) in frames().iter().enumerate() {
        fs::write(folder.join(format!("{at:02}")), message(frame))?;
        encode(frame, &mut all);
    }
    fs::write(folder.join("all"), &all)?;
    fs::write(folder.join("unknown_type"), [&[200, 3, 0, 0, 0, 1, 2, 3], &all[..]].concat())?;
    fs::write(folder.join("cut"), &all[..all.len() / 2])?;
    fs::write(folder.join("long_frame"), [3, 255, 255, 255, 255])
}
