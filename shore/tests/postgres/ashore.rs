//! A shore without HTTP that a test records by, and the way from it to the database.

use crate::{OTTER, START_S};
use imc::messages::Temperature;
use imc::{Address, Header, Message, Packet};
use shore::clock::Clock;
use shore::sinks::SinkState;
use shore::{Opened, Running};
use std::fs;
use std::net::SocketAddr;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use store::{Accepted, CsvOptions, Selection, Store, Transport};
use tempfile::TempDir;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener, TcpStream};
use units::UtcTime;

/// Longer than anything here takes on a loaded machine.
const PATIENCE: Duration = Duration::from_mins(2);

/// A shore without HTTP whose sink is the database at a URL.
pub(crate) struct Shore {
    pub(crate) running: Running,
    pub(crate) data: PathBuf,
    pub(crate) said: u32,
}

impl Shore {
    pub(crate) async fn start(data: &Path, url: &str, password: &Path) -> Self {
        let postgres = shore::sinks::Postgres {
            url: url.to_owned(),
            user: "lutra".to_owned(),
            password_file: password.to_owned(),
            ..shore::sinks::Postgres::default()
        };
        let settings = shore::Settings {
            data: data.to_owned(),
            hub: hub::Settings { address: Address(0x4F00), name: "shore".into(), active: false },
            trusted: Vec::new(),
            people: shore::identity::Settings::default(),
            charts: shore::charts::Settings::default(),
            sinks: shore::sinks::Settings { postgres, ..shore::sinks::Settings::default() },
            notices: shore::notices::Settings::default(),
            compress_after_days: 0,
            compress_months_after_days: 0,
            most_unpacked_bytes: 1 << 20,
        };
        let running = Opened::open(settings, Clock::real()).unwrap().start().await.unwrap();
        Self { running, data: data.to_owned(), said: 0 }
    }

    /// Another one on the same data, which goes on counting.
    pub(crate) async fn again(self, url: &str, password: &Path) -> Self {
        let (data, said) = (self.data.clone(), self.said);
        self.end().await;
        Self { said, ..Self::start(&data, url, password).await }
    }

    pub(crate) async fn end(self) {
        self.running.shore.stop.cancel();
        self.running.end().await;
    }

    /// Records packets, and has them on the disk.
    pub(crate) async fn record(&self, packets: Vec<Vec<u8>>) {
        let record = move |store: &mut Store| {
            for (at, packet) in packets.iter().enumerate() {
                let received = UtcTime::from_micros((START_S as i64 + 10_000) * 1_000_000 + at as i64);
                let accepted = Accepted { packet, received, transport: Transport::Tcp, link: None };
                store.accept(&accepted).unwrap();
            }
            store.sync().unwrap();
        };
        self.running.shore.recorder.with_store(record).await.unwrap();
    }

    /// Records temperatures that count on.
    pub(crate) async fn say(&mut self, count: u32) {
        let numbers = self.said..self.said + count;
        self.said += count;
        let value = |number| Temperature { value: number as f32 };
        let packets = numbers.map(|number| packet(START_S + f64::from(number), value(number)));
        self.record(packets.collect()).await;
    }

    pub(crate) fn state(&self) -> SinkState {
        self.running.shore.sinks[0].borrow().clone()
    }

    /// Waits until the sink says a trouble.
    pub(crate) async fn troubled(&self, words: &str) {
        until(words, || self.state().trouble.is_some_and(|trouble| trouble.contains(words))).await;
    }

    /// Waits until all that is recorded is carried.
    pub(crate) async fn caught_up(&self) {
        let marks = self.running.shore.recorder.with_store(|store| store.marks()).await.unwrap();
        until("caught up", || {
            let tail = store::Tail::open(&self.data, "postgres", &self.state().target);
            tail.is_ok_and(|tail| tail.behind(&marks) == 0) && self.state().behind_bytes == Some(0)
        })
        .await;
    }
}

/// A packet of the Otter's.
pub(crate) fn packet(timestamp: f64, message: impl Into<Message>) -> Vec<u8> {
    let header = Header { timestamp, src: OTTER, src_ent: 9, ..Header::default() };
    Packet::new(header, message).encode().unwrap()
}

/// Waits until something holds; panics with `what` when it does not in time.
pub(crate) async fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !holds() {
        assert!(begun.elapsed() < PATIENCE, "not in time: {what}");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

/// A way to the database that carries so many bytes a second; its address.
pub(crate) async fn slow_line(database: SocketAddr, bytes_per_s: Arc<AtomicU64>) -> SocketAddr {
    let listener = TcpListener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    tokio::spawn(async move {
        while let Ok((from, _)) = listener.accept().await {
            tokio::spawn(carry(from, database, Arc::clone(&bytes_per_s)));
        }
    });
    address
}

pub(crate) async fn carry(mut from: TcpStream, database: SocketAddr, bytes_per_s: Arc<AtomicU64>) {
    let Ok(mut to) = TcpStream::connect(database).await else { return };
    let (mut up, mut down) = ([0; 4_096], [0; 4_096]);
    loop {
        tokio::select! {
            length = from.read(&mut up) => {
                let Ok(length @ 1..) = length else { return };
                let us = length as u64 * 1_000_000 / bytes_per_s.load(Ordering::Relaxed);
                tokio::time::sleep(Duration::from_micros(us)).await;
                if to.write_all(&up[..length]).await.is_err() { return }
            }
            length = to.read(&mut down) => {
                let Ok(length @ 1..) = length else { return };
                if from.write_all(&down[..length]).await.is_err() { return }
            }
        }
    }
}

/// A folder of data, and a file with the right password.
pub(crate) fn scratch() -> (TempDir, PathBuf, PathBuf) {
    let scratch = TempDir::new().unwrap();
    let (data, password) = (scratch.path().join("data"), scratch.path().join("password"));
    fs::create_dir(&data).unwrap();
    fs::write(&password, "right\n").unwrap();
    (scratch, data, password)
}

/// All rows of a message as CSV.
pub(crate) fn exported(data: &Path, message: &str) -> String {
    let selection = Selection { messages: vec![message.to_owned()], ..Selection::default() };
    let mut csv = Vec::new();
    store::export_csv(data, &selection, &CsvOptions::default(), &mut csv).unwrap();
    String::from_utf8(csv).unwrap()
}
