//! `lutra-agent sniff` as a process: pipes, ports, and how it ends.

use crate::common::program;
use rustix::pty::{OpenptFlags, grantpt, openpt, ptsname, unlockpt};
use rustix::termios::{LocalModes, tcgetattr};
use serde_json::Value;
use std::fs::File;
use std::io::{BufRead as _, BufReader, Write as _};
use std::process::Stdio;
use std::time::Duration;

const TAG: &[u8] = b"$1000042,1623050485,615,S64K,1285,12,24,69,11\r";

#[test]
fn a_pipe_is_read_until_its_end() {
    let mut child = program()
        .args(["sniff", "--device", "tbr", "--json", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut input = child.stdin.take().unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap());
    input.write_all(TAG).unwrap();
    // It is printed at once, while the pipe is open.
    let mut line = String::new();
    output.read_line(&mut line).unwrap();
    let found: Value = serde_json::from_str(&line).unwrap();
    assert_eq!((&found["id"], &found["data"]), (&Value::from(1285), &Value::from(12)));
    drop(input);
    line.clear();
    output.read_line(&mut line).unwrap();
    assert_eq!(line, "");
    assert!(child.wait().unwrap().success());
}

#[test]
fn a_reader_that_goes_away_is_no_error() {
    let mut child = program()
        .args(["sniff", "--device", "tbr", "-"])
        .stdin(Stdio::piped())
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    drop(child.stdout.take());
    let mut input = child.stdin.take().unwrap();
    // Until it has noticed and ended.
    while input.write_all(TAG).is_ok() {}
    let output = child.wait_with_output().unwrap();
    assert!(output.status.success());
    assert_eq!(String::from_utf8_lossy(&output.stderr), "");
}

#[test]
fn a_port_is_set_to_raw_bytes_and_its_end_says_what_to_do() {
    // Closed in the child: otherwise its own copy would keep the line open.
    let device = openpt(OpenptFlags::RDWR | OpenptFlags::NOCTTY | OpenptFlags::CLOEXEC).unwrap();
    grantpt(&device).unwrap();
    unlockpt(&device).unwrap();
    let name = ptsname(&device, Vec::new()).unwrap().into_string().unwrap();
    let mut device = File::from(device);
    let mut child = program()
        .args(["sniff", "--device", "tbr", "--json", "--baud", "38400", &name])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .unwrap();
    let mut output = BufReader::new(child.stdout.take().unwrap());
    let (told, heard) = std::sync::mpsc::channel();
    let reader = std::thread::spawn(move || {
        let mut line = String::new();
        output.read_line(&mut line).unwrap();
        told.send(line).unwrap();
        output
    });
    // Bytes from before the port is configured are discarded: the tag is sent until it is decoded.
    let line = (0..200).find_map(|_| {
        device.write_all(TAG).unwrap();
        device.write_all(b"\n").unwrap();
        heard.recv_timeout(Duration::from_millis(100)).ok()
    });
    let line = line.expect("a line within 20 s");
    assert!(line.contains("1285"), "{line}");
    let settings = tcgetattr(&device).unwrap();
    assert!(!settings.local_modes.intersects(LocalModes::ICANON | LocalModes::ECHO));
    assert_eq!(settings.output_speed(), 38_400);
    drop(device);
    // The rest is read as well, or the program would block on a full pipe.
    std::io::copy(&mut reader.join().unwrap(), &mut std::io::sink()).unwrap();
    let output = child.wait_with_output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("check the cable"), "{said}");
}

#[test]
fn a_file_that_is_not_there_is_an_error_with_a_remedy() {
    let output = program().args(["sniff", "--device", "gnss", "/no/such/port"]).output().unwrap();
    assert_eq!(output.status.code(), Some(1));
    let said = String::from_utf8(output.stderr).unwrap();
    assert!(said.contains("/no/such/port") && said.contains("check the name"), "{said}");
}
