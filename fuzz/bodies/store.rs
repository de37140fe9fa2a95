//! What must hold whatever stands in the archive's sidecar `Arrivals.idx`. The fuzz target calls this with bytes of
//! its own making, and `make test` with the committed seeds and everything that was ever found.

use imc::messages::Temperature;
use imc::{Address, Header};
use std::fs;
use std::path::Path;
use store::{Reader, Store};

pub(crate) const SYSTEM: Address = Address(0x2810);
/// 2026-11-21T08:00:00Z.
pub(crate) const START_S: f64 = 1_795_248_000.0;
pub(crate) const PACKETS: u64 = 6;
const RECORD_BYTES: usize = 32;

/// The packets that lie beside the sidecar.
pub(crate) fn packet(number: u64) -> Vec<u8> {
    let header = Header { timestamp: START_S + number as f64, src: SYSTEM, src_ent: 5, ..Header::default() };
    let mut bytes = Vec::new();
    imc::encode_into(&mut bytes, &header, &Temperature { value: number as f32 }).expect("short");
    bytes
}

/// The first byte says whether each record's sum is made right, so that what it says is believed; the rest is the
/// sidecar. The store opens, keeps every packet and gives each of them once; opened again it is as it was.
pub(crate) fn arrivals(data: &[u8]) {
    let Some((mend, sidecar)) = data.split_first() else { return };
    let mut sidecar = sidecar.to_vec();
    if mend % 2 == 1 {
        for record in sidecar.chunks_exact_mut(RECORD_BYTES) {
            let sum = !imc::crc16(&record[..RECORD_BYTES - 2]);
            record[RECORD_BYTES - 2..].copy_from_slice(&sum.to_le_bytes());
        }
    }
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
    let folder = folder.expect("a scratch folder");
    let day = folder.path().join("archive/0x2810/20261121");
    let log: Vec<u8> = (0..PACKETS).flat_map(packet).collect();
    fs::create_dir_all(&day).expect("room");
    fs::write(day.join("Data.lsf"), &log).expect("room");
    fs::write(day.join("Arrivals.idx"), &sidecar).expect("room");

    let streams: Vec<u64> = sidecar
        .chunks_exact(RECORD_BYTES)
        .map(|record| u64::from_le_bytes(record[22..30].try_into().expect("eight")))
        .collect();
    let durable = |store: &Store| streams.iter().map(|stream| store.durable(*stream)).collect::<Vec<_>>();
    let store = Store::open(folder.path()).expect("damage is mended");
    let before = durable(&store);
    store.close().expect("a good end");
    assert_eq!(fs::read(day.join("Data.lsf")).expect("it is there"), log, "packets were changed");
    let mut reader = Reader::open(folder.path()).expect("it is there");
    let samples: u64 = reader.series(None).expect("readable").iter().map(|series| series.extent.count).sum();
    assert_eq!(samples, PACKETS, "each packet is in the history once");

    let store = Store::open(folder.path()).expect("it was mended");
    assert_eq!(store.repairs().notes, Vec::<String>::new(), "nothing is left to mend");
    assert_eq!(durable(&store), before, "nothing that was acknowledged is forgotten");
}
