//! A closed reader, or a full disk behind a redirected log, does not stop a vessel.

use std::fs::OpenOptions;
use std::io::{BufRead as _, BufReader};
use std::process::{Command, Stdio};

const AGENT: &str = env!("CARGO_BIN_EXE_lutra-agent");

#[test]
fn a_closed_pipe_ends_no_simulation() {
    let mut child = Command::new(AGENT)
        .args(["simulate", "--until", "60", "--every", "1"])
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    assert!(child.wait().unwrap().success());
}

#[test]
fn the_vessel_goes_on_when_its_words_cannot_be_written() {
    let data = tempfile::tempdir().unwrap();
    let full = OpenOptions::new().write(true).open("/dev/full").unwrap();
    let config = testkit::repository().join("vehicle-agent/etc/otter.ini");
    let mut child = Command::new(AGENT)
        .arg("run")
        .arg(config)
        .args(["--bind", "127.0.0.1", "--udp-port", "0", "--tcp-port", "0", "--announce-port", "0", "--data"])
        .arg(data.path())
        .stdout(Stdio::piped())
        .stderr(full)
        .spawn()
        .unwrap();
    let mut lines = BufReader::new(child.stdout.take().unwrap()).lines();
    assert!(lines.next().unwrap().unwrap().starts_with("listening"));
    assert!(Command::new("kill").args(["-TERM", &child.id().to_string()]).status().unwrap().success());
    assert!(lines.next().unwrap().unwrap().starts_with("motors stopped"));
    assert!(child.wait().unwrap().success());
}
