//! A real InfluxDB beside the history: it gets all recorded traffic, also from times when it was unavailable.

use crate::support::program::{Process, run, until};
use std::fs;
use std::io::{Read as _, Write as _};
use std::net::{TcpListener, TcpStream};
use std::path::Path;
use std::process::{Command, Stdio};

/// A port that is free now.
fn free_port() -> u16 {
    TcpListener::bind("127.0.0.1:0").unwrap().local_addr().unwrap().port()
}

/// Starts InfluxDB on a folder; `None` if it is not installed.
fn influxd(folder: &Path, port: u16) -> Option<Process> {
    let rpc = free_port();
    let at = |name: &str| folder.join(name).display().to_string();
    let config = format!(
        "reporting-disabled = true\nbind-address = \"127.0.0.1:{rpc}\"\n[meta]\ndir = \"{}\"\n[data]\ndir = \"{}\"\n\
         wal-dir = \"{}\"\nindex-version = \"tsi1\"\n[http]\nbind-address = \"127.0.0.1:{port}\"\nlog-enabled = false\n\
         [monitor]\nstore-enabled = false\n",
        at("meta"),
        at("data"),
        at("wal"),
    );
    fs::write(folder.join("influx.conf"), config).unwrap();
    let mut command = Command::new("influxd");
    command.arg("-config").arg(folder.join("influx.conf")).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().ok().map(Process)
}

/// An answer of InfluxDB with its raw body; `None` while it is not listening.
fn ask(port: u16, method: &str, path: &str) -> Option<String> {
    let mut stream = TcpStream::connect(("127.0.0.1", port)).ok()?;
    write!(stream, "{method} {path} HTTP/1.0\r\nHost: x\r\nContent-Length: 0\r\n\r\n").ok()?;
    let mut answer = String::new();
    stream.read_to_string(&mut answer).ok()?;
    Some(answer)
}

/// How many values a field has.
fn count(port: u16, field: &str, measurement: &str) -> u64 {
    let query = format!("/query?db=lutra&q=SELECT%20count({field})%20FROM%20{measurement}");
    let answer = ask(port, "GET", &query).unwrap_or_default();
    let Some((_, values)) = answer.split_once("\"values\":[[") else { return 0 };
    values.split([',', ']']).nth(1).and_then(|number| number.parse().ok()).unwrap_or_default()
}

#[tokio::test(flavor = "multi_thread", worker_threads = 2)]
async fn everything_goes_there_also_what_came_while_it_was_away() {
    let Some(log) = testkit::shared("data/imc/dune_log_a/Data.lsf.gz") else { return };
    let (data, store, port) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap(), free_port());
    // The log is in the archive before there is an InfluxDB.
    run(data.path(), &["import", "--new", log.to_str().unwrap()]);
    let url = format!("sinks.influx.url=http://127.0.0.1:{port}");
    let serve = || {
        Command::new(crate::support::program::SERVER)
            .args(["serve", "--listen", "127.0.0.1:0", "--set", "imc.active=false", "--set", &url, "--data"])
            .arg(data.path())
            .stdout(Stdio::null())
            .stderr(Stdio::null())
            .spawn()
            .map(Process)
            .unwrap()
    };
    let mut server = serve();
    let Some(_influx) = influxd(store.path(), port) else {
        testkit::absent(testkit::Need::Influxd, "apt-get install influxdb");
        return;
    };
    until("up", || ask(port, "GET", "/ping")).await;
    // Without the database nothing is accepted, and nothing is dropped.
    let create = "/query?q=CREATE%20DATABASE%20lutra";
    until("made", || ask(port, "POST", create).filter(|answer| answer.contains(" 200 "))).await;
    let rows = |message: &str| run(data.path(), &["export", "--message", message]).lines().count() as u64 - 1;
    let fields = [("SetThrusterActuation", "value"), ("EstimatedState", "latdeg"), ("Heartbeat", "present")];
    for (message, field) in fields {
        let expected = rows(message);
        assert!(expected > 10, "{message}: {expected}");
        until(message, || (count(port, field, message) == expected).then_some(())).await;
    }
    // Sending everything again, by a server without its cursor, changes nothing.
    let cursor = data.path().join("sinks/influx.json");
    until("written down", || cursor.exists().then_some(())).await;
    server.terminate();
    let carried = fs::read_to_string(&cursor).unwrap();
    fs::remove_file(&cursor).unwrap();
    let _server = serve();
    until("carried again", || fs::read_to_string(&cursor).ok().filter(|text| *text == carried)).await;
    for (message, field) in fields {
        assert_eq!(count(port, field, message), rows(message), "{message}");
    }
}
