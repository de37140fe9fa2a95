//! The package for Python against a running server: rows with their types, downloads that are cut and go on, and a link with a password.

use crate::support::program::{Server, add_admin, run};
use imc::messages::{EstimatedState, TBRFishTag};
use imc::{Address, Header, Message, Packet};
use serde_json::{Value, json};
use std::io::{Read as _, Write as _};
use std::net::{SocketAddr, TcpStream};
use std::path::Path;
use std::process::Command;
use store::{Accepted, Store, Transport};
use units::UtcTime;

/// 2024-11-21 08:00 UTC: in the past, as a dataset ends at the present.
const START_US: i64 = 1_732_176_000_000_000;
const BOAT: u16 = 0x0814;
/// Enough for files that can be cut in their middle.
const DETECTIONS: u32 = 600;
const PASSWORD: &str = "nine grey otters";

fn fill(data: &Path) {
    let mut store = Store::open(data).unwrap();
    let mut put = |time_us: i64, message: Message| {
        let received = UtcTime::from_micros(time_us);
        let header =
            Header { timestamp: received.seconds(), src: Address(BOAT), src_ent: 2, ..Header::default() };
        let packet = Packet::new(header, message).encode().unwrap();
        store.accept(&Accepted { packet: &packet, received, transport: Transport::Tcp, link: None }).unwrap();
    };
    for at in 0..DETECTIONS {
        let tag = TBRFishTag {
            serial_no: 1_024,
            unix_timestamp: 1_732_176_000 + at,
            millis: 7,
            trans_protocol: 6_u8.into(),
            trans_id: 101 + at % 2,
            snr: 20,
            trans_freq: 69,
            lat: Some(1.107),
            lon: Some(0.181),
            ..TBRFishTag::default()
        };
        put(START_US + i64::from(at) * 1_000_000, tag.into());
    }
    for at in 0..3 {
        let state = EstimatedState {
            lat: 63.44_f64.to_radians(),
            lon: 10.4_f64.to_radians(),
            ..EstimatedState::default()
        };
        put(START_US + at * 1_000_000, state.into());
    }
    store.close().unwrap();
}

fn post(server: SocketAddr, path: &str, token: &str, body: &Value) -> Value {
    let (mut stream, body) = (TcpStream::connect(server).unwrap(), body.to_string());
    write!(
        stream,
        "POST /api/v1{path} HTTP/1.0\r\nhost: {server}\r\nauthorization: Bearer {token}\r\n\
         content-type: application/json\r\ncontent-length: {}\r\n\r\n{body}",
        body.len()
    )
    .unwrap();
    let mut answer = String::new();
    stream.read_to_string(&mut answer).unwrap();
    let (head, body) = answer.split_once("\r\n\r\n").unwrap();
    assert!(head.contains(" 200 "), "{path}: {head}\n{body}");
    serde_json::from_str(body).unwrap()
}

/// It takes some seconds, as a server starts as a program, and Python some times.
#[test]
fn the_package_for_python_reads_everything_and_goes_on_with_what_was_cut() {
    if Command::new("python3").arg("--version").output().is_err() {
        testkit::absent(testkit::Need::Python, "apt-get install python3");
        return;
    }
    let data = tempfile::tempdir().unwrap();
    fill(data.path());
    add_admin(data.path(), "kari", PASSWORD);
    let token = run(data.path(), &["token", "create", "--person", "kari", "--role", "researcher"]);
    let token = token.trim();
    let server = Server::start(data.path());
    let say = |path: &str, body: Value| post(server.web, path, token, &body);
    say("/register", json!({"kind": "person", "name": "Nordmann, Kari", "affiliation": "NTNU"}));
    let draft = json!({
        "title": "Salmon in the fjord", "description": "Heard by one boat.", "publisher": "NTNU",
        "authors": ["Nordmann, Kari"], "query": {"vessels": [BOAT]},
    });
    let made = say("/datasets", draft);
    let dataset = made["id"].to_string();
    say(&format!("/datasets/{dataset}/publish"), json!({"revision": made["revision"]}));
    let link = json!({"label": "Ola", "days": 30, "password": PASSWORD});
    let link = say(&format!("/datasets/{dataset}/shares"), link);
    let url = format!("http://{}", server.web);
    let output = Command::new("python3")
        .arg(testkit::repository().join("clients/python/tests/against_server.py"))
        .args([&*url, &*format!("{url}{}", link["path"].as_str().unwrap()), PASSWORD, &*dataset])
        .arg(DETECTIONS.to_string())
        .env("LUTRA_TOKEN", token)
        .env("PYTHONDONTWRITEBYTECODE", "1")
        .output()
        .unwrap();
    let said = String::from_utf8_lossy(&output.stdout);
    assert!(output.status.success(), "{said}\n{}", String::from_utf8_lossy(&output.stderr));
    assert_eq!(said.trim(), "all as it should be");
}
