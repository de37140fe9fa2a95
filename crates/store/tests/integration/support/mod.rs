//! Helpers for the tests of the store.

use imc::messages::{EstimatedState, Payload, Temperature};
use imc::{Address, Header};
use std::path::{Path, PathBuf};
use store::{Accepted, LinkSeq, Outcome, Store, Transport};
use units::UtcTime;

/// 2026-11-21T08:00:00Z.
pub(crate) const START_US: i64 = 1_795_248_000_000_000;
/// The Otter that says everything.
pub(crate) const OTTER: Address = Address(0x2810);

pub(crate) fn utc(us: i64) -> UtcTime {
    UtcTime::from_micros(us)
}

pub(crate) fn packet<T: Payload>(time_us: i64, entity: u8, message: &T) -> Vec<u8> {
    packet_of(OTTER, time_us, entity, message)
}

pub(crate) fn packet_of<T: Payload>(src: Address, time_us: i64, entity: u8, message: &T) -> Vec<u8> {
    let header = Header { timestamp: utc(time_us).seconds(), src, src_ent: entity, ..Header::default() };
    let mut bytes = Vec::new();
    imc::encode_into(&mut bytes, &header, message).unwrap();
    bytes
}

pub(crate) fn temperature(time_us: i64, value: f32) -> Vec<u8> {
    packet(time_us, 5, &Temperature { value })
}

pub(crate) fn state(x: f32) -> EstimatedState {
    EstimatedState {
        lat: 63.4406_f64.to_radians(),
        lon: 10.3535_f64.to_radians(),
        x,
        y: 2.0 * x,
        ..EstimatedState::default()
    }
}

pub(crate) fn accept(store: &mut Store, packet: &[u8], received_us: i64, transport: Transport) -> Outcome {
    store.accept(&Accepted { packet, received: utc(received_us), transport, link: None }).unwrap()
}

pub(crate) fn accept_link(store: &mut Store, packet: &[u8], received_us: i64, seq: u64) -> Outcome {
    let link = Some(LinkSeq { stream: 7, seq });
    store.accept(&Accepted { packet, received: utc(received_us), transport: Transport::Link, link }).unwrap()
}

/// All bytes of a system's archive, day after day.
pub(crate) fn archived(folder: &Path, system: Address) -> Vec<u8> {
    let mut days: Vec<PathBuf> = std::fs::read_dir(folder.join(format!("archive/{:#06x}", system.0)))
        .map(|entries| entries.map(|entry| entry.unwrap().path()).collect())
        .unwrap_or_default();
    days.sort();
    days.iter().flat_map(|day| std::fs::read(day.join("Data.lsf")).unwrap()).collect()
}

/// The history's contents without arrival times, as text: to compare two.
pub(crate) fn dump(folder: &Path) -> Vec<String> {
    let mut lines = Vec::new();
    let mut files: Vec<PathBuf> = std::fs::read_dir(folder.join("history"))
        .unwrap()
        .map(|entry| entry.unwrap().path())
        .filter(|path| path.extension().is_some_and(|end| end == "sqlite"))
        .collect();
    files.sort();
    for file in files {
        let name = file.file_name().unwrap().to_string_lossy().into_owned();
        let connection = rusqlite::Connection::open(&file).unwrap();
        let mut tables =
            connection.prepare("SELECT name FROM sqlite_master WHERE type='table' ORDER BY name").unwrap();
        let tables: Vec<String> =
            tables.query_map((), |row| row.get(0)).unwrap().map(Result::unwrap).collect();
        for table in tables {
            // Numbers of series and times of saving depend on the order of events; what they stand for does not.
            let sql = match table.as_str() {
                "meta" | "archived" | "month" | "stream" | "_field" | "sqlite_stat1" => continue,
                "_rollup" => "SELECT f.id,f.src,f.src_ent,f.field,r.level_s,r.cell,r.first_us,r.count,r.min,r.max,\
                              r.sum,r.first,r.last FROM _rollup r JOIN _field f USING (series) ORDER BY 1,2,3,4,5,6"
                    .to_owned(),
                "_direction" => "SELECT f.id,f.src,f.src_ent,f.field,d.level_s,d.cell,d.count,d.cos,d.sin \
                                 FROM _direction d JOIN _field f USING (series) ORDER BY 1,2,3,4,5,6"
                    .to_owned(),
                table => format!("SELECT * FROM \"{table}\" ORDER BY 1,2,3,4"),
            };
            let mut rows = connection.prepare(&sql).unwrap();
            let columns = rows.column_count();
            let mut rows = rows.query(()).unwrap();
            while let Some(row) = rows.next().unwrap() {
                let cells: Vec<String> =
                    (0..columns).map(|at| format!("{:?}", row.get_ref(at).unwrap())).collect();
                lines.push(format!("{name} {table} {}", cells.join(" ")));
            }
        }
    }
    lines
}
