//! Invariants ashore after any faults of vessel and shore: every number once, every packet once.

use super::program::logged;
use super::{OTTER, archive_of, archived_packets};
use bytes::Bytes;
use imc::messages::{LoggingControl, Payload as _};
use imc::{Address, PacketView};
use std::collections::BTreeMap;
use std::path::Path;
use std::time::{SystemTime, UNIX_EPOCH};

/// A packet's time may precede its recording by so much (s).
pub(crate) const SAID_BEFORE_S: f64 = 0.5;

pub(crate) fn now_s() -> f64 {
    SystemTime::now().duration_since(UNIX_EPOCH).unwrap().as_secs_f64()
}

/// Time of a packet (s since 1970).
pub(crate) fn time_s(packet: &[u8]) -> f64 {
    PacketView::new(packet).unwrap().timestamp()
}

/// Bytes of the vessel in the archive: cheap to check repeatedly.
pub(crate) fn archived_bytes(data: &Path) -> u64 {
    bytes_of(data, OTTER)
}

/// Bytes of a vessel in the archive.
pub(crate) fn bytes_of(data: &Path, vessel: Address) -> u64 {
    archive_of(data, vessel).iter().filter_map(|log| Some(std::fs::metadata(log).ok()?.len())).sum()
}

/// Time of the newest packet ashore (s since 1970).
pub(crate) fn newest_s(data: &Path) -> f64 {
    newest_of(data, OTTER)
}

/// Time of a vessel's newest packet ashore (s since 1970).
pub(crate) fn newest_of(data: &Path, vessel: Address) -> f64 {
    archived_packets(data, vessel).iter().map(|one| time_s(one)).fold(0.0, f64::max)
}

/// The records of all packets of the link, from `Arrivals.idx`.
fn link_records(data: &Path) -> Vec<[u8; 32]> {
    let mut found = Vec::new();
    for system in std::fs::read_dir(data.join("archive")).unwrap().map(|entry| entry.unwrap().path()) {
        let Ok(days) = std::fs::read_dir(system) else { continue };
        for day in days {
            let Ok(records) = std::fs::read(day.unwrap().path().join("Arrivals.idx")) else { continue };
            for record in records.chunks_exact(32) {
                let (has_link, is_jump) = (record[6] & 1 << 5 != 0, record[6] & 1 << 7 != 0);
                if has_link && !is_jump {
                    found.push(record.try_into().unwrap());
                }
            }
        }
    }
    found
}

/// When each packet came, by the shore's clock (s since 1970).
pub(crate) fn arrivals_s(data: &Path) -> Vec<f64> {
    let arrival = |record: &[u8; 32]| {
        let mut bytes = [0; 8];
        bytes[..7].copy_from_slice(&record[7..14]);
        u64::from_le_bytes(bytes) as f64 / 1e6
    };
    link_records(data).iter().map(arrival).collect()
}

/// The numbers in the record lanes.
pub(crate) fn link_numbers(data: &Path) -> BTreeMap<u64, Vec<u64>> {
    let mut streams: BTreeMap<u64, Vec<u64>> = BTreeMap::new();
    for record in link_records(data) {
        let word = |at: usize| u64::from_le_bytes(record[at..at + 8].try_into().unwrap());
        streams.entry(word(22)).or_default().push(word(14));
    }
    streams
}

/// Every number came once and none is missing but `declared` ones.
pub(crate) fn every_number_came_once(data: &Path, declared: u64) {
    let mut missing = 0;
    for (stream, mut numbers) in link_numbers(data) {
        let came = numbers.len() as u64;
        numbers.sort_unstable();
        numbers.dedup();
        assert_eq!(came, numbers.len() as u64, "numbers of {stream:#x} came twice");
        missing += numbers[numbers.len() - 1] - numbers[0] + 1 - came;
    }
    assert_eq!(missing, declared, "numbers are missing that nobody declared");
}

/// Checks that every packet of the vessel's logs is ashore as often, except in times that are `exempt`. Returns the number
/// of compared packets.
pub(crate) fn all_that_was_logged_is_ashore(
    data: &Path,
    aboard: &Path,
    exempt: impl Fn(f64) -> bool,
) -> usize {
    logged_is_ashore(data, aboard, OTTER, exempt)
}

/// The same for any vessel.
pub(crate) fn logged_is_ashore(
    data: &Path,
    aboard: &Path,
    vessel: Address,
    exempt: impl Fn(f64) -> bool,
) -> usize {
    let ashore = counted(archived_packets(data, vessel));
    let of_its_own = |packet: &Bytes| {
        let view = PacketView::new(packet).unwrap();
        // Each log begins and ends with its own mark.
        view.src() == vessel && view.id() != LoggingControl::ID
    };
    let said = counted(logged(aboard).into_iter().filter(of_its_own).collect());
    let mut compared = 0;
    for (packet, times) in said.iter().filter(|(packet, _)| !exempt(time_s(packet))) {
        compared += times;
        assert_eq!(ashore.get(packet), Some(times), "{:?}", imc::Packet::decode(packet));
    }
    compared
}

/// How often each packet is there.
pub(crate) fn counted(packets: Vec<Bytes>) -> BTreeMap<Bytes, usize> {
    let mut counts = BTreeMap::new();
    for packet in packets {
        *counts.entry(packet).or_default() += 1;
    }
    counts
}
