//! A real PostgreSQL that everything recorded goes to: equal to the history, each row once, whole in the end although it is slow, killed,
//! emptied and set back; and what is wrong there is said with what to do.

#![expect(clippy::unwrap_used, reason = "a test fails where it unwraps nothing")]

use detections::{ClockState, Detection, Effort, Origin, Pose, Protocol, ReceiverClock};
use imc::messages::{Announce, CpuUsage, EstimatedState, LogBookEntry, TBRFishTag, Temperature, Voltage};
use imc::{Address, Header, Message, Packet};
use serde_json::Value;
use shore::clock::Clock;
use shore::sinks::SinkState;
use shore::{Opened, Running};
use std::fs;
use std::net::{SocketAddr, TcpListener};
use std::os::unix::fs::MetadataExt as _;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};
use store::{Accepted, CsvOptions, Selection, Store, Transport};
use tempfile::TempDir;
use tokio::io::{AsyncReadExt as _, AsyncWriteExt as _};
use tokio::net::{TcpListener as Listener, TcpStream};
use units::{LatLon, UtcTime};

const OTTER: Address = Address(0x2810);
/// Longer than anything here takes on a loaded machine.
const PATIENCE: Duration = Duration::from_mins(2);

const START_S: f64 = 1_795_248_000.0;

/// A server with a role `lutra`, whose database is `boats`, and a superuser `postgres`; both let in by passwords over TCP.
struct Postgres {
    bin: PathBuf,
    folder: TempDir,
    port: u16,
    options: &'static str,
}

impl Postgres {
    /// Makes and starts one; `None`, and says so, where there is none.
    fn start() -> Option<Self> {
        Self::start_with("-c fsync=off")
    }

    fn start_with(options: &'static str) -> Option<Self> {
        let Some(bin) = newest_bin() else {
            testkit::absent(testkit::Need::Postgres, "apt-get install postgresql");
            return None;
        };
        let folder = TempDir::new().unwrap();
        if let Some((user, group)) = other_user() {
            std::os::unix::fs::chown(folder.path(), Some(user), Some(group)).unwrap();
        }
        fs::write(folder.path().join("password"), "admin").unwrap();
        let port = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port();
        let postgres = Self { bin, folder, port, options };
        let at = |name: &str| postgres.folder.path().join(name).display().to_string();
        let initdb = [
            "-D",
            &at("data"),
            "-U",
            "postgres",
            "-A",
            "scram-sha-256",
            "--pwfile",
            &at("password"),
            "-E",
            "UTF8",
        ];
        postgres.tool("initdb", &initdb);
        postgres.up();
        postgres.admin("CREATE ROLE lutra LOGIN PASSWORD 'right'");
        postgres.admin("CREATE DATABASE boats OWNER lutra");
        Some(postgres)
    }

    /// A program of PostgreSQL's, which refuses to run as root.
    fn tool(&self, program: &str, arguments: &[&str]) {
        let mut command = match other_user() {
            None => Command::new(self.bin.join(program)),
            Some((user, group)) => {
                let mut command = Command::new("setpriv");
                command.arg(format!("--reuid={user}")).arg(format!("--regid={group}")).arg("--clear-groups");
                command.arg(self.bin.join(program));
                command
            }
        };
        let output = command.args(arguments).current_dir(self.folder.path()).output().unwrap();
        assert!(output.status.success(), "{program}: {}", String::from_utf8_lossy(&output.stderr));
    }

    fn up(&self) {
        let folder = self.folder.path().display();
        let options = format!(
            "-p {} -c listen_addresses=127.0.0.1 -c unix_socket_directories={folder} {}",
            self.port, self.options
        );
        self.tool(
            "pg_ctl",
            &["-D", &format!("{folder}/data"), "-o", &options, "-l", &format!("{folder}/log"), "-w", "start"],
        );
    }

    /// As if its power failed, or in good order.
    fn down(&self, mode: &str) {
        let data = self.folder.path().join("data").display().to_string();
        self.tool("pg_ctl", &["-D", &data, "-m", mode, "-w", "stop"]);
    }

    fn address(&self) -> SocketAddr {
        SocketAddr::from(([127, 0, 0, 1], self.port))
    }

    fn url(&self) -> String {
        format!("postgres://{}/boats", self.address())
    }

    /// What a statement answers, in CSV without a heading; or what is wrong with it.
    fn ask(&self, user: &str, password: &str, sql: &str) -> Result<String, String> {
        // What belongs to the whole server is made before there is a database of ours.
        let is_for_all = sql.starts_with("CREATE DATABASE") || sql.starts_with("CREATE ROLE");
        let database = if is_for_all { "postgres" } else { "boats" };
        let mut command = Command::new(self.bin.join("psql"));
        command.args(["-h", "127.0.0.1", "-p", &self.port.to_string(), "-U", user, "-d", database]);
        command.args(["-v", "ON_ERROR_STOP=1", "-q", "--csv", "-t", "-c", "SET timezone = 'UTC'", "-c", sql]);
        let output = command.env("PGPASSWORD", password).output().unwrap();
        let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).trim_end().to_owned();
        if output.status.success() { Ok(text(&output.stdout)) } else { Err(text(&output.stderr)) }
    }

    fn admin(&self, sql: &str) -> String {
        self.ask("postgres", "admin", sql).unwrap()
    }

    fn say(&self, sql: &str) -> String {
        self.ask("lutra", "right", sql).unwrap()
    }

    /// How many rows a table has; 0 where there is none.
    fn count(&self, table: &str) -> usize {
        let answer = self.ask("lutra", "right", &format!("SELECT count(*) FROM lutra.{table}"));
        answer.ok().and_then(|count| count.parse().ok()).unwrap_or_default()
    }
}

impl Drop for Postgres {
    fn drop(&mut self) {
        let data = self.folder.path().join("data").display().to_string();
        if self.folder.path().join("data/postmaster.pid").exists() {
            self.tool("pg_ctl", &["-D", &data, "-m", "immediate", "-w", "stop"]);
        }
    }
}

/// Where Debian has the programs of the newest version that is installed.
fn newest_bin() -> Option<PathBuf> {
    let versions = fs::read_dir("/usr/lib/postgresql").ok()?;
    let bins = versions.flatten().map(|version| version.path().join("bin"));
    bins.filter(|bin| bin.join("initdb").exists() && bin.join("psql").exists()).max()
}

/// Whom to run it as where the tests run as root.
fn other_user() -> Option<(u32, u32)> {
    if fs::metadata("/proc/self").unwrap().uid() != 0 {
        return None;
    }
    let users = fs::read_to_string("/etc/passwd").unwrap();
    let line = users.lines().find(|line| line.starts_with("postgres:") || line.starts_with("nobody:"))?;
    let mut parts = line.split(':').skip(2).map(|number| number.parse().unwrap());
    Some((parts.next()?, parts.next()?))
}

/// A shore without HTTP whose sink is the database at a URL.
struct Shore {
    running: Running,
    data: PathBuf,
    said: u32,
}

impl Shore {
    async fn start(data: &Path, url: &str, password: &Path) -> Self {
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
            most_unpacked_bytes: 1 << 20,
        };
        let running = Opened::open(settings, Clock::real()).unwrap().start().await.unwrap();
        Self { running, data: data.to_owned(), said: 0 }
    }

    /// Another one on the same data, which goes on counting.
    async fn again(self, url: &str, password: &Path) -> Self {
        let (data, said) = (self.data.clone(), self.said);
        self.end().await;
        Self { said, ..Self::start(&data, url, password).await }
    }

    async fn end(self) {
        self.running.shore.stop.cancel();
        self.running.end().await;
    }

    /// Records packets, and has them on the disk.
    async fn record(&self, packets: Vec<Vec<u8>>) {
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
    async fn say(&mut self, count: u32) {
        let numbers = self.said..self.said + count;
        self.said += count;
        let value = |number| Temperature { value: number as f32 };
        let packets = numbers.map(|number| packet(START_S + f64::from(number), value(number)));
        self.record(packets.collect()).await;
    }

    fn state(&self) -> SinkState {
        self.running.shore.sinks[0].borrow().clone()
    }

    /// Waits until the sink says a trouble.
    async fn troubled(&self, words: &str) {
        until(words, || self.state().trouble.is_some_and(|trouble| trouble.contains(words))).await;
    }

    /// Waits until all that is recorded is carried.
    async fn caught_up(&self) {
        let marks = self.running.shore.recorder.with_store(|store| store.marks()).await.unwrap();
        until("caught up", || {
            let tail = store::Tail::open(&self.data, "postgres", &self.state().target);
            tail.is_ok_and(|tail| tail.behind(&marks) == 0) && self.state().behind_bytes == Some(0)
        })
        .await;
    }
}

/// A packet of the Otter's.
fn packet(timestamp: f64, message: impl Into<Message>) -> Vec<u8> {
    let header = Header { timestamp, src: OTTER, src_ent: 9, ..Header::default() };
    Packet::new(header, message).encode().unwrap()
}

/// Waits until something holds; panics with `what` when it does not in time.
async fn until(what: &str, mut holds: impl FnMut() -> bool) {
    let begun = Instant::now();
    while !holds() {
        assert!(begun.elapsed() < PATIENCE, "not in time: {what}");
        tokio::time::sleep(Duration::from_millis(50)).await;
    }
}

/// A way to the database that carries so many bytes a second; its address.
async fn slow_line(database: SocketAddr, bytes_per_s: Arc<AtomicU64>) -> SocketAddr {
    let listener = Listener::bind("127.0.0.1:0").await.unwrap();
    let address = listener.local_addr().unwrap();
    tokio::spawn(async move {
        while let Ok((from, _)) = listener.accept().await {
            tokio::spawn(carry(from, database, Arc::clone(&bytes_per_s)));
        }
    });
    address
}

async fn carry(mut from: TcpStream, database: SocketAddr, bytes_per_s: Arc<AtomicU64>) {
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
fn scratch() -> (TempDir, PathBuf, PathBuf) {
    let scratch = TempDir::new().unwrap();
    let (data, password) = (scratch.path().join("data"), scratch.path().join("password"));
    fs::create_dir(&data).unwrap();
    fs::write(&password, "right\n").unwrap();
    (scratch, data, password)
}

/// All rows of a message as CSV.
fn exported(data: &Path, message: &str) -> String {
    let selection = Selection { messages: vec![message.to_owned()], ..Selection::default() };
    let mut csv = Vec::new();
    store::export_csv(data, &selection, &CsvOptions::default(), &mut csv).unwrap();
    String::from_utf8(csv).unwrap()
}

/// A line of CSV whose cells hold no line ends.
fn cells(line: &str) -> Vec<String> {
    let (mut cells, mut cell, mut is_quoted) = (Vec::new(), String::new(), false);
    for sign in line.chars() {
        match sign {
            '"' => is_quoted = !is_quoted,
            ',' if !is_quoted => cells.push(std::mem::take(&mut cell)),
            sign => cell.push(sign),
        }
    }
    cells.push(cell);
    cells
}

/// A value as both write it: numbers by their bits.
fn value(text: &str) -> String {
    match text.parse::<f64>() {
        Ok(number) if number.is_nan() => "NaN".to_owned(),
        Ok(number) => format!("{:?}", number + 0.0),
        Err(_) => text.strip_prefix("\\x").unwrap_or(text).to_owned(),
    }
}

/// All rows of a message as the history has them and as PostgreSQL has them, by the columns that both have.
fn both(data: &Path, postgres: &Postgres, message: &str) -> [Vec<Vec<String>>; 2] {
    let csv = exported(data, message);
    let mut lines = csv.lines();
    let heading = cells(lines.next().unwrap());
    let names: Vec<String> =
        heading.iter().map(|name| name.split(" [").next().unwrap().to_lowercase()).collect();
    let table = format!("lutra.{message}");
    let columns = postgres.say(&format!(
        "SELECT attname FROM pg_attribute WHERE attrelid = '{table}'::regclass AND attnum > 7 AND attgenerated = ''"
    ));
    let columns: Vec<&str> =
        columns.lines().filter(|column| names.iter().any(|name| name == column)).collect();
    let mut selected = "extract(epoch FROM time)::numeric(30,6), src_ent, dst".to_owned();
    for column in &columns {
        selected += &format!(", \"{column}\"");
    }
    let at = |name: &str| names.iter().position(|one| one == name).unwrap();
    let mut mine: Vec<Vec<String>> = lines
        .map(|line| {
            let cells = cells(line);
            let dst = u16::from_str_radix(cells[at("dst")].trim_start_matches("0x"), 16).unwrap().to_string();
            let first = [cells[at("unix_s")].clone(), cells[at("entity_id")].clone(), dst];
            let own = columns.iter().map(|column| cells[at(column)].clone());
            first.into_iter().chain(own).map(|cell| value(&cell)).collect()
        })
        .collect();
    let answer = postgres.say(&format!("SELECT {selected} FROM {table}"));
    let mut theirs: Vec<Vec<String>> =
        answer.lines().map(|line| cells(line).iter().map(|cell| value(cell)).collect()).collect();
    mine.sort();
    theirs.sort();
    [mine, theirs]
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_recorded_log_is_there_value_for_value() {
    let Some(log) = testkit::shared("data/imc/dune_log_a/Data.lsf.gz") else { return };
    let Some(postgres) = Postgres::start() else { return };
    let (_scratch, data, password) = scratch();
    let shore = Shore::start(&data, &postgres.url(), &password).await;
    let now = UtcTime::from_micros(START_S as i64 * 1_000_000);
    let import = move |store: &mut Store| drop(store.import(&[log], now, &mut |_| true).unwrap());
    shore.running.shore.recorder.with_store(import).await.unwrap();
    shore.record(vec![packet(START_S, Voltage { value: 12.5 })]).await;
    shore.caught_up().await;
    shore.end().await;
    let tables = postgres.say(
        "SELECT c.relname FROM pg_class c JOIN pg_namespace n ON n.oid = c.relnamespace WHERE n.nspname = 'lutra' \
         AND c.relkind = 'r' AND c.relname NOT IN ('_lutra', 'vessels', 'detection_reports', '_raw')",
    );
    assert!(tables.lines().count() > 20, "{tables}");
    let mut compared = 0;
    for table in tables.lines() {
        let message = imc::catalogue::MESSAGES
            .iter()
            .find(|desc| desc.abbrev.eq_ignore_ascii_case(table))
            .unwrap()
            .abbrev;
        // Quoted cells may hold line ends and commas; what they hold is another test's.
        if exported(&data, message).contains('"') {
            continue;
        }
        let [mine, theirs] = both(&data, &postgres, message);
        assert_eq!(mine.len(), theirs.len(), "{message}");
        if let Some(at) = (0..mine.len()).find(|at| mine[*at] != theirs[*at]) {
            panic!("{message}: {:?} in the history, {:?} in PostgreSQL", mine[at], theirs[at]);
        }
        compared += mine.iter().map(Vec::len).sum::<usize>();
    }
    println!("{compared} values compared");
    assert!(compared > 200_000, "{compared}");
    let comment = "SELECT col_description('lutra.eulerangles'::regclass, attnum) FROM pg_attribute \
                   WHERE attrelid = 'lutra.eulerangles'::regclass AND attname = 'psi'";
    assert!(postgres.say(comment).contains("unit rad"));
    reads_for_grafana(&postgres);
    for (title, sql) in dashboard() {
        let rows = postgres.ask("grafana", "reads", &sql).unwrap_or_else(|error| panic!("{title}: {error}"));
        // This vessel had no hydrophone.
        assert!(!rows.is_empty() || title.contains("Detections"), "{title} shows nothing: {sql}");
    }
}

/// A role that may read what is there and what will be, as docs/postgresql.md has it.
fn reads_for_grafana(postgres: &Postgres) {
    postgres.admin("CREATE ROLE grafana LOGIN PASSWORD 'reads'");
    postgres.say(
        "GRANT USAGE ON SCHEMA lutra TO grafana; GRANT SELECT ON ALL TABLES IN SCHEMA lutra TO grafana; \
         ALTER DEFAULT PRIVILEGES IN SCHEMA lutra GRANT SELECT ON TABLES TO grafana",
    );
}

/// The statements of Grafana's dashboard, its macros written out: title and SQL.
fn dashboard() -> Vec<(String, String)> {
    let file = testkit::repository().join("docker/grafana/dashboards/postgres.json");
    let dashboard: Value = serde_json::from_str(&fs::read_to_string(file).unwrap()).unwrap();
    let vessels = &dashboard["templating"]["list"][0];
    let panels = dashboard["panels"].as_array().unwrap().iter();
    let panels = panels.map(|panel| (panel["title"].clone(), panel["targets"][0]["rawSql"].clone()));
    let all = panels.chain([(vessels["label"].clone(), vessels["query"].clone())]);
    let written_out = |(title, sql): (Value, Value)| {
        let mut sql = sql.as_str().unwrap().to_owned();
        for (macro_, meaning) in [
            ("$__timeFilter(time)", "time BETWEEN '2000-01-01' AND '2100-01-01'"),
            ("$__timeGroup(time, '1h')", "to_timestamp(floor(extract(epoch FROM time) / 3600) * 3600)"),
            ("$__timeGroup(time, '10s')", "to_timestamp(floor(extract(epoch FROM time) / 10) * 10)"),
            ("$__timeGroup(time, $__interval)", "to_timestamp(floor(extract(epoch FROM time) / 60) * 60)"),
            ("IN ($vessel)", "IN (SELECT src FROM lutra.vessels)"),
        ] {
            sql = sql.replace(macro_, meaning);
        }
        assert!(!sql.contains('$'), "a macro that is not known here: {sql}");
        (title.as_str().unwrap().to_owned(), sql)
    };
    let all: Vec<_> = all.map(written_out).collect();
    assert!(all.len() > 5);
    all
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn each_row_is_there_once_although_it_is_slow_killed_emptied_and_set_back() {
    let Some(postgres) = Postgres::start() else { return };
    let (_scratch, data, password) = scratch();
    let rate = Arc::new(AtomicU64::new(1 << 30));
    let line = slow_line(postgres.address(), Arc::clone(&rate)).await;
    let url = format!("postgres://{line}/boats");
    let mut shore = Shore::start(&data, &url, &password).await;
    shore.say(10).await;
    shore.caught_up().await;
    assert_eq!(postgres.count("temperature"), 10);
    let cursor = data.join("sinks/postgres.json");
    let early = fs::read_to_string(&cursor).unwrap();

    // One that is slow holds up nothing: all is recorded long before it is there.
    rate.store(20_000, Ordering::Relaxed);
    shore.say(1_490).await;
    assert!(postgres.count("temperature") < 1_500, "it was not slow");
    // Killed in the middle of a batch.
    postgres.down("immediate");
    shore.say(100).await;
    until("noticed", || shore.state().trouble.is_some()).await;
    rate.store(1 << 30, Ordering::Relaxed);
    postgres.up();
    shore.caught_up().await;
    assert_eq!(postgres.count("temperature"), 1_600);

    // As if the shore was killed after commits and before it noted them: the rows come again, and are there once.
    shore.end().await;
    fs::write(&cursor, &early).unwrap();
    let mut shore = Shore { said: 1_600, ..Shore::start(&data, &url, &password).await };
    shore.caught_up().await;
    assert_eq!(postgres.count("temperature"), 1_600);

    // Emptied while the shore runs, then while it does not.
    postgres.say("DROP SCHEMA lutra CASCADE");
    shore.say(10).await;
    until("filled again", || postgres.count("temperature") == 1_610).await;
    shore.caught_up().await;
    shore.end().await;
    postgres.say("DROP SCHEMA lutra CASCADE");
    let shore = Shore::start(&data, &url, &password).await;
    until("filled once more", || postgres.count("temperature") == 1_610).await;
    shore.caught_up().await;

    // Set back, as by a backup of yesterday.
    shore.end().await;
    postgres.say("DELETE FROM lutra.temperature WHERE value > 500; UPDATE lutra._lutra SET batch = 0");
    let shore = Shore::start(&data, &url, &password).await;
    until("whole after the backup", || postgres.count("temperature") == 1_610).await;
    shore.caught_up().await;
    assert_eq!(postgres.say("SELECT address FROM lutra.vessels WHERE src = 10256"), "0x2810");
    shore.end().await;
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn what_is_wrong_there_is_said_and_once_mended_everything_comes() {
    let Some(postgres) = Postgres::start() else { return };
    let (scratch, data, password) = scratch();
    let wrong = scratch.path().join("wrong");
    fs::write(&wrong, "secret of nobody").unwrap();
    postgres.admin(
        "CREATE DATABASE latin ENCODING 'LATIN1' TEMPLATE template0 LC_COLLATE 'C' LC_CTYPE 'C' OWNER lutra",
    );
    postgres.admin("CREATE DATABASE foreigns");
    let address = postgres.address();
    let at = |database: &str| format!("postgres://{address}/{database}");
    let closed = TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap();
    let troubles = [
        (at("boats"), &wrong, "does not let the server in"),
        (at("nowhere"), &password, "the database is not there"),
        (at("latin"), &password, "holds LATIN1 and not UTF8"),
        (at("foreigns"), &password, "CREATE SCHEMA lutra AUTHORIZATION lutra"),
        (format!("postgres://{closed}/boats"), &password, "it is not reached"),
    ];
    for (url, password, trouble) in troubles {
        let shore = Shore::start(&data, &url, password).await;
        shore.troubled(trouble).await;
        assert!(!format!("{:?}", shore.state()).contains("secret of nobody"));
        shore.end().await;
    }

    let mut shore = Shore::start(&data, &at("boats"), &password).await;
    shore.say(20).await;
    shore.caught_up().await;
    // A column of another type, by hand: nothing is passed over.
    postgres.say("ALTER TABLE lutra.temperature ALTER COLUMN value TYPE text");
    let mut shore = shore.again(&at("boats"), &password).await;
    shore.say(10).await;
    shore.troubled("table temperature holds text in value, not real").await;
    // A column that is missing is made again.
    postgres.say("ALTER TABLE lutra.temperature DROP COLUMN value");
    shore.caught_up().await;
    assert_eq!(postgres.say("SELECT count(*), count(value) FROM lutra.temperature"), "30,10");
    // A column that every row must have.
    postgres.say(
        "ALTER TABLE lutra.temperature ADD COLUMN who text NOT NULL DEFAULT ''; \
         ALTER TABLE lutra.temperature ALTER COLUMN who DROP DEFAULT",
    );
    let mut shore = shore.again(&at("boats"), &password).await;
    shore.say(1).await;
    shore.troubled("wants a value for who in each row").await;
    postgres.say("ALTER TABLE lutra.temperature DROP COLUMN who");
    shore.caught_up().await;

    // A rule by hand that refuses one row of many: the others are there.
    postgres.say("ALTER TABLE lutra.temperature ADD CHECK (value <> 77)");
    shore.say(100).await;
    shore.caught_up().await;
    assert_eq!(postgres.count("temperature"), 130);
    assert_eq!((shore.state().refused, shore.state().kept), (1, 100));
    shore.end().await;

    // Who only reads may read, and no more.
    reads_for_grafana(&postgres);
    assert_eq!(postgres.ask("grafana", "reads", "SELECT count(*) FROM lutra.temperature").unwrap(), "130");
    let denied = postgres.ask("grafana", "reads", "DELETE FROM lutra.temperature").unwrap_err();
    assert!(denied.contains("permission denied"), "{denied}");
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn whatever_a_packet_holds_is_there_and_can_be_turned_back() {
    let Some(postgres) = Postgres::start() else { return };
    let (_scratch, data, password) = scratch();
    let shore = Shore::start(&data, &postgres.url(), &password).await;
    let texts: [&[u8]; 4] = [b"a\0b", b"\xff\xfe", br"\x00 typed", "bl\u{e5}b\u{e6}r 'x\"".as_bytes()];
    let mut packets = Vec::new();
    for (at, text) in texts.iter().enumerate() {
        let htime = [f64::NAN, f64::INFINITY, f64::NEG_INFINITY, -0.0][at];
        let entry = LogBookEntry { text: imc::Text::from_bytes(*text), htime, ..LogBookEntry::default() };
        packets.push(packet(START_S + at as f64, entry));
    }
    for (at, stamp) in [f64::NAN, 0.0, -1e17, 1e12].into_iter().enumerate() {
        packets.push(packet(stamp, CpuUsage { value: 250 + at as u8 }));
    }
    packets.push(packet(
        START_S,
        EstimatedState { lat: 1.1, lon: 0.2, x: 1_000.0, ..EstimatedState::default() },
    ));
    let header = Header { timestamp: START_S, src: OTTER, ..Header::default() };
    let mut unknown = Packet::new(header, CpuUsage { value: 1 });
    // By its size the second is another message than the Otters' TBRFishTag, and the Event is cut off.
    for (id, payload) in [(60_001, vec![1, 2, 3]), (2_007, vec![7; 5]), (660, vec![9])] {
        unknown.body = imc::Body::Unknown { id, payload };
        packets.push(unknown.encode().unwrap());
    }
    shore.record(packets).await;
    shore.caught_up().await;
    shore.end().await;
    let told = postgres
        .say("SELECT text || '|' || htime FROM lutra.LogBookEntry WHERE htime IS NOT NULL ORDER BY time");
    let told: Vec<String> = told.lines().map(|line| line.trim_matches('"').replace("\"\"", "\"")).collect();
    let (values, escaped) = (["NaN", "Infinity", "-Infinity", "-0"], texts.map(imc::text::escape));
    for at in 0..texts.len() {
        assert_eq!(told[at], format!("{}|{}", escaped[at], values[at]));
        assert_eq!(imc::text::unescape(&escaped[at]).as_ref(), texts[at]);
    }
    assert_eq!(
        postgres.say("SELECT time FROM lutra.CpuUsage ORDER BY value").lines().collect::<Vec<_>>(),
        ["-infinity", "1970-01-01 00:00:00+00", "-infinity", "33658-09-27 01:46:40+00"]
    );
    let place = postgres.say("SELECT true_lat_deg > lat_deg, abs(lat_deg - degrees(1.1)) < 1e-12 FROM lutra.EstimatedState WHERE lat = 1.1");
    assert_eq!(place, "t,t");
    assert_eq!(
        postgres.say("SELECT id, encode(payload, 'hex') FROM lutra._raw ORDER BY id"),
        "660,09\n2007,0707070707\n60001,010203"
    );
    assert!(postgres.say("SELECT problem FROM lutra._raw WHERE id = 2007").contains("is no TBRFishTag"));
}

/// What a vessel says of one detection: all of it as an Event, then what IMC's own message holds.
fn detection(tag: u32) -> Detection {
    Detection {
        origin: Origin {
            system: OTTER,
            entity: 9,
            reported: UtcTime::from_micros(START_S as i64 * 1_000_000 + i64::from(tag)),
            received: None,
        },
        receiver: 1_024,
        clock: ReceiverClock { seconds: START_S as u32 - 2, millis: 250, state: ClockState::Disciplined },
        protocol: Protocol::named("S256"),
        tag_id: tag,
        data: Some(77),
        snr_db: 30,
        frequency_khz: 69,
        line: 5,
        pose: Some(Pose {
            place: LatLon::from_deg(63.4, 10.4).unwrap(),
            age_s: Some(0.2),
            sigma_m: Some(0.5),
        }),
        effort: Effort { lines_lost: Some(0), noise: None, propeller_rpm: Some(600.0) },
        raw: Some("$001024,1795247998,250,S256,101,77,30,69,5".to_owned()),
    }
}

/// PostGIS makes the view wider when it comes later: it takes more than 2 s to install itself in a database.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn a_detection_is_there_once_and_has_a_place_with_postgis() {
    let Some(postgres) = Postgres::start() else { return };
    let (_scratch, data, password) = scratch();
    let shore = Shore::start(&data, &postgres.url(), &password).await;
    let announce = Announce { sys_name: "otter-nils".into(), ..Announce::default() };
    let mut packets = vec![packet(START_S, announce)];
    for tag in [101, 102] {
        let one = detection(tag);
        let said_s = one.origin.reported.micros() as f64 / 1e6;
        packets.push(packet(said_s, one.report()));
        packets.push(packet(said_s, one.fish_tag().unwrap()));
    }
    // Another receiver does not know its place or its time.
    let lost = TBRFishTag { serial_no: 7, unix_timestamp: 600, trans_id: 103, ..TBRFishTag::default() };
    packets.push(packet(START_S, lost));
    shore.record(packets).await;
    shore.caught_up().await;
    shore.end().await;
    assert_eq!(postgres.count("detection_reports"), 5);
    let seen = "SELECT tag, heard, clock, vessel, round(lat_deg::numeric, 6), pose_age_s, data, propeller_rpm, raw IS NULL \
                FROM lutra.detections ORDER BY tag";
    let heard = "2026-11-21 07:59:58.25+00,disciplined,otter-nils,63.400000,0.2,77,600,f";
    assert_eq!(postgres.say(seen), format!("101,{heard}\n102,{heard}\n103,,not set,otter-nils,,,0,,t"));
    assert!(postgres.ask("lutra", "right", "SELECT place FROM lutra.detections").is_err());
    if postgres.ask("postgres", "admin", "CREATE EXTENSION postgis").is_err() {
        testkit::absent(testkit::Need::Postgis, "apt-get install postgresql-15-postgis-3");
        return;
    }
    let shore = Shore::start(&data, &postgres.url(), &password).await;
    let place = "SELECT tag, ST_AsText(place, 6), ST_SRID(place) FROM lutra.detections ORDER BY tag";
    until("placed", || postgres.ask("lutra", "right", place).is_ok()).await;
    shore.end().await;
    assert_eq!(postgres.say(place), "101,POINT(10.4 63.4),4326\n102,POINT(10.4 63.4),4326\n103,,");
    assert_eq!(
        postgres.say("SELECT type, srid FROM geometry_columns WHERE f_table_name = 'detections'"),
        "POINT,4326"
    );
}

/// TimescaleDB is not in Debian: a stand-in with the signature of its function notes what it is asked for.
#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn tables_become_hypertables_where_timescaledb_is_installed() {
    let Some(postgres) = Postgres::start() else { return };
    postgres.admin(
        "CREATE TABLE public.asked (name text, column_name text, chunk interval);
         CREATE FUNCTION public.create_hypertable(relation regclass, time_column_name name, partitioning_column name = NULL, \
           number_partitions integer = NULL, associated_schema_name name = NULL, associated_table_prefix name = NULL, \
           chunk_time_interval anyelement = NULL::bigint, create_default_indexes boolean = true, if_not_exists boolean = false) \
           RETURNS void LANGUAGE sql SECURITY DEFINER AS \
           'INSERT INTO public.asked VALUES (relation::text, time_column_name, chunk_time_interval::text::interval)';
         SET allow_system_table_mods = on;
         INSERT INTO pg_extension (oid, extname, extowner, extnamespace, extrelocatable, extversion) \
           VALUES (70000, 'timescaledb', 10, 'public'::regnamespace, false, '2.15')",
    );
    let (_scratch, data, password) = scratch();
    let mut shore = Shore::start(&data, &postgres.url(), &password).await;
    shore.say(3).await;
    shore.caught_up().await;
    assert_eq!(postgres.count("temperature"), 3);
    shore.end().await;
    assert_eq!(
        postgres.admin("SELECT * FROM public.asked ORDER BY name"),
        "lutra.detection_reports,time,7 days\nlutra.temperature,time,7 days"
    );
}

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
