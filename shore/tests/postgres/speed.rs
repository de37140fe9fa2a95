//! How fast an archive goes to PostgreSQL.

use crate::START_S;
use crate::ashore::{Shore, scratch, until};
use crate::database::Postgres;
use imc::Packet;
use std::fs;
use std::path::Path;
use std::time::{Duration, Instant};
use store::{Accepted, Store, Transport};
use units::UtcTime;

/// How fast an archive goes there: the recording of a DUNE vehicle, repeated, with fsync. Prints a row of BENCHMARKS.md.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
#[ignore = "a benchmark, see make bench"]
async fn speed() {
    let Some(log) = testkit::shared("data/imc/dune_log_a/Data.lsf.gz") else { return };
    let Some(postgres) = Postgres::start_with("") else { return };
    let (_scratch, data, password) = scratch();
    let repeats: u32 = std::env::var("LUTRA_REPEATS").map_or(17, |text| text.parse().unwrap());
    let count = fill(&data, &log, repeats);
    let shore = Shore::start(&data, &postgres.url(), &password).await;
    let begun = Instant::now();
    until("begun", || shore.state().behind_bytes.is_some()).await;
    while shore.state().behind_bytes != Some(0) {
        tokio::time::sleep(Duration::from_millis(20)).await;
    }
    let took_s = begun.elapsed().as_secs_f64();
    let bytes: u64 = postgres.admin("SELECT pg_database_size('boats')").parse().unwrap();
    let load = fs::read_to_string("/proc/loadavg").unwrap();
    println!(
        "{count} messages in {took_s:.1} s: {:.0}/s, committed with fsync; {} MB there; load {}",
        count as f64 / took_s,
        bytes / 1_000_000,
        load.trim()
    );
    assert_eq!(shore.state().refused, 0);
    shore.end().await;
}

/// Makes an archive of a log, repeated, each later by its length; how many packets.
fn fill(data: &Path, log: &Path, repeats: u32) -> u64 {
    let mut packets = Vec::new();
    let mut reader = imc::lsf::LogReader::open(log).unwrap();
    while let Some(item) = reader.next_item().unwrap() {
        if let imc::lsf::LogItem::Packet { view, .. } = item {
            packets.push(Packet::decode(view.bytes()).unwrap());
        }
    }
    let stamps = packets.iter().map(|packet| packet.header.timestamp);
    let length_s = stamps.clone().fold(0.0, f64::max) - stamps.fold(f64::MAX, f64::min) + 1.0;
    let mut store = Store::open(data).unwrap();
    let mut received_us = START_S as i64 * 1_000_000;
    for repeat in 0..repeats {
        for packet in &packets {
            let mut packet = packet.clone();
            packet.header.timestamp += f64::from(repeat) * length_s;
            let packet = packet.encode().unwrap();
            received_us += 1;
            let received = UtcTime::from_micros(received_us);
            let accepted = Accepted { packet: &packet, received, transport: Transport::Tcp, link: None };
            store.accept(&accepted).unwrap();
        }
        store.sync().unwrap();
    }
    store.close().unwrap();
    packets.len() as u64 * u64::from(repeats)
}
