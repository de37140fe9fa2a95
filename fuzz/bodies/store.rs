//! What must hold whatever stands in the archive's sidecar `Arrivals.idx`, in the files of a compressed day, and in a chunk of a compressed
//! month. The fuzz target calls this with bytes of
//! its own making, and `make test` with the committed seeds and everything that was ever found.

use imc::messages::{LogBookEntry, Temperature};
use imc::{Address, Header};
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;
use store::{
    Accepted, LinkSeq, PackedMonth, Packing, Page, Reader, Source, Store, TimeRange, Transport, plan_months,
    plan_packing,
};
use units::UtcTime;

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

fn scratch() -> tempfile::TempDir {
    let memory = Path::new("/dev/shm");
    let folder = if memory.is_dir() { tempfile::tempdir_in(memory) } else { tempfile::tempdir() };
    folder.expect("a scratch folder")
}

fn day(folder: &Path) -> PathBuf {
    folder.join("archive/0x2810/20261121")
}

/// The files of a compressed day, packets and records, as a store makes them.
pub(crate) static PACKED: LazyLock<[Vec<u8>; 2]> = LazyLock::new(|| {
    let folder = scratch();
    let mut store = Store::open(folder.path()).expect("a new folder");
    for number in 0..=PACKETS {
        // The last packet is of the day after: the newest day is not compressed.
        let after_s = if number == PACKETS { 86_400.0 } else { 0.0 };
        let received = UtcTime::from_seconds(START_S + number as f64 + after_s).expect("a time");
        let link = Some(LinkSeq { stream: 7, seq: number });
        let packet = packet(number);
        store
            .accept(&Accepted { packet: &packet, received, transport: Transport::Link, link })
            .expect("a packet");
    }
    store.commit().expect("room");
    let now = UtcTime::from_seconds(START_S + 86_400.0 * 9.0).expect("a time");
    let plan = plan_packing(folder.path(), 3, now).expect("readable");
    let mut packing = Packing::begin(folder.path(), &plan[0]).expect("room");
    while packing.work(u64::MAX).expect("room") {}
    store.adopt(&mut packing).expect("room").expect("nothing came for it");
    ["Data.lsf.zst", "Arrivals.zst"].map(|name| fs::read(day(folder.path()).join(name)).expect("it is there"))
});

/// The first byte says which file is damaged, whether what follows takes the place of all of it or of a part, and whether the
/// sum of its head is made right; two bytes say where the part begins. The store opens, reads what it can, and changes
/// neither file.
pub(crate) fn packed(data: &[u8]) {
    let Some((how, rest)) = data.split_first() else { return };
    let mut files = PACKED.clone();
    let file = &mut files[usize::from(how & 1)];
    if how & 2 == 0 {
        *file = rest.to_vec();
    } else if let Some(([low, high], bytes)) = rest.split_first_chunk() {
        let at = usize::from(u16::from_le_bytes([*low, *high])) % file.len();
        let end = file.len().max(at + bytes.len());
        file.resize(end, 0);
        file[at..at + bytes.len()].copy_from_slice(bytes);
    }
    if how & 4 != 0 && file.len() >= 62 {
        let sum = imc::crc16(&file[..60]);
        file[60..62].copy_from_slice(&sum.to_le_bytes());
    }
    let folder = scratch();
    let day = day(folder.path());
    fs::create_dir_all(&day).expect("room");
    let paths = ["Data.lsf.zst", "Arrivals.zst"].map(|name| day.join(name));
    for (path, bytes) in paths.iter().zip(&files) {
        fs::write(path, bytes).expect("room");
    }
    let read = || {
        let mut store = Store::open(folder.path()).expect("damage stops nothing");
        store.index().ok();
        let durable = store.durable(7);
        store.close().ok();
        let now = UtcTime::from_seconds(START_S).expect("a time");
        store::doctor(folder.path(), now, true, &mut |_| true).expect("damage is a check");
        store::covered(folder.path()).ok();
        durable
    };
    let durable = read();
    assert_eq!(read(), durable, "opened again it is as it was");
    for (path, bytes) in paths.iter().zip(&files) {
        assert!(fs::read(path).expect("it is there") == *bytes, "a compressed file was changed");
    }
    assert!(
        !day.join("Data.lsf").exists() && !day.join("Arrivals.idx").exists(),
        "a compressed day was written to"
    );
}

/// Entries of the log book in a compressed month.
const ENTRIES: u64 = 40;
const MONTH: &str = "history/2026-11.sqlite";

/// A compressed month, and the body of its one chunk, as a store makes them.
pub(crate) static CHUNK: LazyLock<[Vec<u8>; 2]> = LazyLock::new(|| {
    let folder = scratch();
    let mut store = Store::open(folder.path()).expect("a new folder");
    for number in 0..ENTRIES {
        let received = UtcTime::from_seconds(START_S + number as f64).expect("a time");
        let header = Header { timestamp: received.seconds(), src: SYSTEM, src_ent: 5, ..Header::default() };
        let entry = LogBookEntry {
            text: format!("entry {}", number * number).into(),
            htime: 0.1 * number as f64,
            ..LogBookEntry::default()
        };
        let mut packet = Vec::new();
        imc::encode_into(&mut packet, &header, &entry).expect("short");
        store
            .accept(&Accepted { packet: &packet, received, transport: Transport::Tcp, link: None })
            .expect("a packet");
    }
    store.commit().expect("room");
    let now = UtcTime::from_seconds(START_S + 86_400.0 * 90.0).expect("a time");
    let month = plan_months(folder.path(), 1, now).expect("readable")[0];
    assert!(store.ready_month(month.key).expect("room"), "the history lacks nothing");
    let packed = PackedMonth::make(folder.path(), &month, &mut |_| true).expect("room");
    store.adopt_month(packed).expect("room").done().expect("nothing else has it open");
    store.close().expect("a good end");
    let file = folder.path().join(MONTH);
    let connection = rusqlite::Connection::open(&file).expect("a database");
    let body = connection.query_row("SELECT body FROM _chunk", (), |row| row.get(0)).expect("one chunk");
    drop(connection);
    [fs::read(&file).expect("it is there"), body]
});

/// The first byte says whether what follows takes the place of all of a chunk or of a part, and whether its sum is made right; two bytes
/// say where the part begins. Reading it gives as many rows as it had, or says that it is damaged.
pub(crate) fn chunk(data: &[u8]) {
    let Some((how, rest)) = data.split_first() else { return };
    let [file, whole] = &*CHUNK;
    let mut body = whole.clone();
    if how & 1 == 0 {
        body = rest.to_vec();
    } else if let Some(([low, high], bytes)) = rest.split_first_chunk() {
        let at = usize::from(u16::from_le_bytes([*low, *high])) % body.len();
        let end = body.len().max(at + bytes.len());
        body.resize(end, 0);
        body[at..at + bytes.len()].copy_from_slice(bytes);
    }
    if how & 2 != 0 && body.len() >= 4 {
        let said = body.len() - 4;
        let mut sum = flate2::Crc::new();
        sum.update(&body[..said]);
        body[said..].copy_from_slice(&sum.sum().to_le_bytes());
    }
    let folder = scratch();
    let month = folder.path().join(MONTH);
    fs::create_dir(folder.path().join("history")).expect("room");
    fs::write(&month, file).expect("room");
    let connection = rusqlite::Connection::open(&month).expect("a database");
    connection.execute("UPDATE _chunk SET body=?1", [&body]).expect("room");
    drop(connection);
    let mut reader = Reader::open(folder.path()).expect("it is there");
    let source = Source { system: SYSTEM, entity: 5, message: "LogBookEntry".to_owned() };
    let fields = ["type", "htime", "context", "text"];
    match reader.rows(&source, &fields, TimeRange::ALL, Page::first(usize::MAX)) {
        Ok(rows) => assert_eq!(rows.items.len() as u64, ENTRIES, "rows were lost or made up"),
        Err(error) => assert!(error.to_string().contains("LogBookEntry of 0x2810"), "{error}"),
    }
    if body != *whole && how & 2 == 0 {
        let told = reader.samples(&source, &["htime"], TimeRange::ALL, 100);
        assert!(told.is_err(), "its sum is wrong, and nothing is said");
    }
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
    let folder = scratch();
    let day = day(folder.path());
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
